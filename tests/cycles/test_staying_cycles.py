"""A cycle that stays where the profile does not know its end leaves the start of the next one open."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.settings import load

BAD = "X29. ,R9.\n"
CYCLE = (
    "G71 U1. R0.5\nG71 P{p} Q{q} U0.4 W0.1 F0.25\n"
    "N{p} G0 X24.\nG1 Z-5. F0.25\n{corner}Z-10.\nN{q} X30.\n{finish}"
)
HEAD = "G21\nG97 S900 M3\nG95\nG0 X30. Z2.\n"
TAIL = "G0 X80.\nM30\n"


def _cycle(number: int, corner: str = "", *, finish: bool = True) -> str:
    call = f"G70 P{number} Q{number + 5}\n" if finish else ""
    return CYCLE.format(p=number, q=number + 5, corner=corner, finish=call)


def _unrolled(profile: str, *cycles: str) -> tuple[list[str], list[str]]:
    """What is written out, and what is said of those that stay."""
    settings = load(profile, ["cycles.unroll=always"])
    result = chipbreak.rewrite((HEAD + "".join(cycles) + TAIL).encode(), settings)
    lines = result.data.decode().splitlines()
    said = [one.message for one in result.diagnostics if one.code.startswith("CYC")]
    return [line.split("UNROLLED ")[1].rstrip(")") for line in lines if "UNROLLED G7" in line], said


@pytest.mark.parametrize("finish", [True, False])
def test_on_a_control_that_is_known_the_next_one_is_written_out(finish: bool) -> None:
    written, said = _unrolled("fanuc-lathe", _cycle(10, BAD), _cycle(20, finish=finish))
    assert written == ["G71 P20 Q25", "G70 P20 Q25"][: 1 + finish]
    assert "larger than the moves beside it" in said[0]


@pytest.mark.parametrize("finish", [True, False])
def test_on_one_that_is_not_the_next_ones_stay_too(finish: bool) -> None:
    cycles = [_cycle(10, BAD), _cycle(20, finish=finish), _cycle(30, finish=finish)]
    written, said = _unrolled("generic-lathe", *cycles)
    assert written == []
    assert [text for text in said if "where this cycle starts is not known" in text]


def test_where_the_place_is_said_again_it_is_known() -> None:
    written, _ = _unrolled("generic-lathe", _cycle(10, BAD), "G0 X30. Z2.\n", _cycle(20))
    assert written == ["G71 P20 Q25", "G70 P20 Q25"]


def test_behind_one_that_is_written_out_it_is_known() -> None:
    written, said = _unrolled("generic-lathe", _cycle(10), _cycle(20))
    assert written == ["G71 P10 Q15", "G70 P10 Q15", "G71 P20 Q25", "G70 P20 Q25"]
    assert not [text for text in said if "not known" in text]


ARC_BETWEEN = (
    "G97 S1200 M3\nG95\nG0 X30. Z5.\n"
    "G70 P10 Q20\n"
    "G3 X30.4 Z4.8 R0.2 F0.2\n"
    "G71 U2. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2\n"
    "N10 G0 X28.4\nG1 Z-0.2 F0.2\nZ-5.2\nN20 X30.4\n"
    "G0 X80.\nM30\n"
)


def test_a_contour_behind_an_arc_leaves_what_its_roughing_leaves() -> None:
    """G70 stands before the arc and shares the contour; the blocks of G71 give no G3 back behind it."""
    settings = load("mitsubishi-lathe", ["cycles.unroll=always"])
    result = chipbreak.rewrite(ARC_BETWEEN.encode(), settings)
    assert result.data.count(b"UNROLLED G7") == 2
    assert chipbreak.restore(result.data) == ARC_BETWEEN.encode()


BETWEEN_CYCLES = (
    "G97 S600 M3\nG94\nG0 X20. Z1.\n(VIB OFF)\n"
    + _cycle(10).replace("X30.", "X20.").replace("X24.", "X17.").replace("F0.25", "F120.")
    + "(VIB N1.5)\n"
    + _cycle(10, finish=False).replace("X30.", "X20.").replace("X24.", "X1.").replace("F0.25", "F120.")
    + TAIL
)


def test_a_program_of_which_no_cycle_stays_written_out_is_verified() -> None:
    """Its passes are too short to vibrate at 120 mm a revolution: a warning, where that is allowed."""
    model = ("axes.X.max_acceleration_mm_s2=2000", "axes.Z.max_acceleration_mm_s2=2000")
    settings = load("mitsubishi-lathe", ["planner.model=trapezoid", "vibration.air=vibrate", *model])
    result = chipbreak.rewrite(BETWEEN_CYCLES.encode(), settings, allow_unbroken=True)
    assert result.data == BETWEEN_CYCLES.encode()
    assert chipbreak.verify(result.data, settings).data == BETWEEN_CYCLES.encode()


@pytest.mark.parametrize("profile", ["fanuc-lathe", "haas-lathe", "mitsubishi-lathe"])
@pytest.mark.parametrize("place", ["Q15 ", "R0.5", "X24.", "Z-10.", "G70 P10 Q15"])
@pytest.mark.parametrize("mark", ["$1", " !2L1"])
def test_a_mark_in_a_cycle_or_its_contour_lets_it_stay(profile: str, place: str, mark: str) -> None:
    """Another path is meant from there on, or this one waits for it: written anew, that would be lost."""
    program = HEAD + _cycle(10).replace(place, f"{place.strip()}{mark} ", 1) + TAIL
    settings = load(profile, ["cycles.unroll=always"])
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    runs = [line for line in result.data.decode().splitlines() if "CHIPBREAK WAS" not in line]
    assert any(mark.strip() in line for line in runs)
    assert chipbreak.restore(result.data) == program.encode()
    assert [one for one in result.diagnostics if one.code in ("CYC002", "CYC007")]


def test_a_cycle_that_stays_and_one_whose_start_is_not_known_are_planned_to_an_end() -> None:
    """A place that is not known equals nothing, itself neither: the rounds end by what stays."""
    mark = "G71 U1. !2L1 R0.5\nG71 P30 Q35 U0.4 F0.25\nN30 G0 X24.\nG1 Z-5. F0.25\nN35 X30.\n"
    for profile in ("generic-lathe", "fanuc-lathe"):
        written, _ = _unrolled(profile, _cycle(10, BAD), mark, _cycle(40))
        assert written == ([] if profile == "generic-lathe" else ["G71 P40 Q45", "G70 P40 Q45"])


@pytest.mark.parametrize("between", [0, 1, 2])
def test_a_contour_in_which_another_program_begins_lets_the_cycle_stay(between: int) -> None:
    lines = ["N10 G0 X20.", "G1 Z-5.", "X25. Z-60.", "N20 X30."]
    lines.insert(between + 1, "O2")
    contour = "\n".join(lines)
    program = f"{HEAD}G71 U1. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2\n{contour}\nG70 P10 Q20\n{TAIL}".encode()
    for profile in ("fanuc-lathe", "generic-lathe"):
        result = chipbreak.rewrite(program, load(profile, ["cycles.unroll=always"]))
        assert result.data == program
        said = [one.message for one in result.diagnostics if one.code.startswith("CYC")]
        why = "another program begins between this cycle" if between == 1 else "a point of the contour"
        assert any(text.startswith(why) for text in said)


def test_a_finishing_cycle_stays_where_no_block_leads_back_to_its_start() -> None:
    """X60. is 2.362205 inches, and X2.3622 would be another place."""
    program = (
        b"G97 S300 M3\nG99\nG0 X60. Z1.\nG71 U1. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.1\n"
        b"N10 G0 X48.\nG1 Z-6. F0.1\nX49.\nN20 X60.\nG20\nG70 P10 Q20\nG0 X4.\nM30\n"
    )
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["cycles.unroll=always"]))
    said = [one.message for one in result.diagnostics if one.code == "CYC007"]
    assert [text.partition(",")[0] for text in said] == ["X2.362205"]
    assert b"\nG20\nG70 P10 Q20\n" in result.data
    assert chipbreak.restore(result.data) == program
