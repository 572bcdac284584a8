"""What stands behind a change: the programmed speed at stops, in its own units, and the programmed end."""

from __future__ import annotations

import pytest

import chipbreak

LATHE = ("G21 G7 G18 G90 G95 G64", "M3 S2000", "G0 X30 Z2")
CUT = ("(VIB N1.5 F62.5)", "G1 Z-5 F0.1", "(VIB OFF)")


def filtered(*lines: str, profile: str = "linuxcnc-lathe") -> list[str]:
    settings = chipbreak.load(profile, ['planner.model="ideal"', 'output.segments="stroke"'])
    data = "\n".join([*lines, ""]).encode()
    return chipbreak.rewrite(data, settings).data.decode().splitlines()


def before(lines: list[str], line: str) -> list[str]:
    """The blocks of the last bracket before a line."""
    at = lines.index(line)
    assert lines[at - 1].startswith("(CHIPBREAK END"), lines[at - 1]
    begin = max(i for i in range(at) if lines[i].startswith("(CHIPBREAK BEGIN"))
    return lines[begin + 1 : at - 1]


@pytest.mark.parametrize("stop", ["M0", "M1", "M60", "T2 M6"])
def test_the_programmed_speed_is_back_at_a_stop(stop: str) -> None:
    assert before(filtered(*LATHE, *CUT, stop, "M2"), stop) == ["S2000"]
    surface = filtered(LATHE[0], LATHE[1], "G96 D2500 S100", LATHE[2], *CUT, stop, "M2")
    assert before(surface, stop) == ["G96 D2500 S100"]


def test_a_surface_speed_is_given_back_in_the_units_it_was_set_in() -> None:
    lines = (LATHE[0], LATHE[1], "G96 D2500 S100", LATHE[2], *CUT, "G20", "M0", "M2")
    assert before(filtered(*lines), "M0") == ["G21", "G20 G96 D2500 S100"]


@pytest.mark.parametrize("behind", ["G1 X40", "S90", "M3"])
def test_a_surface_speed_that_is_not_known_is_refused(behind: str) -> None:
    branch = ("o100 if [1 gt 0]", "S90", "o100 endif", "G0 X30 Z2")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        filtered(LATHE[0], LATHE[1], "G96 D2500 S100", *branch, *CUT, behind, "M2")
    assert [one.code for one in caught.value.diagnostics if one.severity.value == "error"] == ["VIB057"]


def test_a_cut_ends_in_all_digits_of_the_program() -> None:
    lines = filtered(*LATHE[:2], "G20", "G0 X1 Z.1", "F0.004", "(VIB N1.5)", "G1 X.9129682 Z-.127454", "M2")
    end = next(line for line in reversed(lines) if line.startswith("X"))
    assert end.startswith("X0.9129682 Z-0.127454")


def test_a_feed_is_given_back_in_the_units_in_force() -> None:
    lines = filtered(
        "G20 G7 G18 G90 G94", "F4", "M3 S1000", "G0 X1 Z.1", "G21", "G0 Z2", "(VIB N0.5)", "G1 Z-5", "M2"
    )
    at = lines.index("G94 G20")
    assert lines[at + 1] == "G21 F4", "with the number that the program wrote: what reads it finds that"


MILL = ("G17 G21 G90 G94", "M3 S2000", "G0 X0 Y0 Z2")
MILLED = ("(VIB N0.5)", "G1 Z1 F4", "(VIB OFF)")


@pytest.mark.parametrize(
    ("said", "given_back"),
    [
        (("G64 P0.254", "G20"), ["G61", "G21 G64 P0.254", "G20"]),
        (("G20", "G64P.01 q.002", "G21"), ["G61", "G20 G64 P.01 q.002", "G21"]),
        (("G64", "G20"), ["G61", "G64"]),
        (("G20", "G64 P0.01", "G61", "G21"), []),
        (("G20", "G64 P0.01"), ["G61", "G64 P0.01"]),
        (("G64 P0.254", "G20", "G81 X0.1 Z0.4 R0.5 F4", "G80"), ["G61", "G21 G64 P0.254", "G20"]),
        (("G64 P0.254", "G20", "M70", "G61", "G21", "M72"), ["G61", "G21 G64 P0.254", "G20"]),
    ],
)
def test_a_path_mode_is_given_back_in_its_own_units(*, said: tuple[str, ...], given_back: list[str]) -> None:
    lines = filtered(*MILL, *said, "G0 Z.5", *MILLED, "M2", profile="linuxcnc-mill")
    inside = lines[lines.index("(VIB N0.5)") : lines.index("(VIB OFF)")]
    assert [line for line in inside if line.startswith(("G6", "G2"))] == given_back


@pytest.mark.parametrize(("units", "given_back"), [("G20", "G64 P0.01"), ("G21", "G64 P0.254")])
def test_the_lengths_of_the_profile_are_millimetres(units: str, given_back: str) -> None:
    sets = ['planner.model="ideal"', 'output.segments="stroke"', 'planner.usual_path_mode="G64 P0.254"']
    data = "\n".join([*MILL, units, "G0 Z.5", *MILLED, "M2", ""]).encode()
    lines = chipbreak.rewrite(data, chipbreak.load("linuxcnc-mill", sets)).data.decode().splitlines()
    assert [line for line in lines if "G64" in line] == [given_back]


def test_a_tolerance_of_other_units_decides_which_strokes_are_merged_away() -> None:
    sets = ["planner.path_mode=", "axes.Z.max_acceleration_mm_s2=20000"]
    settings = chipbreak.load("linuxcnc-mill", sets)
    small, large = (
        "\n".join([*MILL, *path, "G0 Z.5", "(VIB N0.5)", "G1 Z.1 F4", "M2", ""]).encode()
        for path in (("G64 P0.002", "G20"), ("G20", "G64 P0.002"))
    )
    assert chipbreak.rewrite(small, settings).cuts
    with pytest.raises(chipbreak.ProgramRejectedError, match=r"0\.0508 mm"):
        chipbreak.rewrite(large, settings)


@pytest.mark.parametrize("word", ["P#1", "P[#1+1]"])
def test_a_path_mode_by_a_variable_cannot_be_given_back(word: str) -> None:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        filtered(*MILL, "#1=0.01", f"G64 {word}", "#1=5", *MILLED, "M2", profile="linuxcnc-mill")
    assert [one.code for one in caught.value.diagnostics if one.severity.value == "error"] == ["VIB050"]


def test_a_feed_that_m72_rounds_is_refused_by_that_name() -> None:
    lines = ("G17 G21 G90 G95", "M3 S1000", "G0 X0 Y0 Z2", "F0.15", "M70", "G91", "M72")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        filtered(*lines, "(VIB N0.5)", "G1 Z-5", "(VIB OFF)", "M2", profile="linuxcnc-mill")
    (refused,) = [one for one in caught.value.diagnostics if one.severity.value == "error"]
    assert refused.code == "VIB050"
    assert refused.message.startswith("the feed is not known: F0.15 (line 4) is rounded to a tenth by M72")
    assert filtered(*lines, "(VIB N0.5)", "G1 Z-5 F0.15", "(VIB OFF)", "M2", profile="linuxcnc-mill")


@pytest.mark.parametrize(
    ("block", "back"),
    [
        ("G64 P0.02 Q0.01 G3 X32 Z1 R5 F0.1", "G64 P0.02 Q0.01"),
        ("G64 G3 X32 Z1 R5 F0.1", "G64"),
        ("G64 P0.02 Q0.01", "G64 P0.02 Q0.01"),
    ],
)
def test_the_radius_of_an_arc_is_no_word_of_the_path_mode(block: str, back: str) -> None:
    """LinuxCNC takes no R with G64 alone."""
    lines = filtered(*LATHE, block, "G0 X30 Z2", *CUT, "M2")
    modes = [line for line in lines if line.startswith(("G61", "G64"))]
    assert modes[-2:] == ["G61", back]


@pytest.mark.parametrize("comment", ["(MSG, LOOK)", "(log,#5420)", "( print, x)", "(LOGCLOSE)", ";py,x=1"])
def test_what_a_comment_does_is_done(comment: str) -> None:
    """LinuxCNC shows or writes what stands in it, before the block moves."""
    lines = filtered(*LATHE, "(VIB N1.5)", f"G1 Z-5 F0.1 {comment}", "M2")
    begin = lines.index("(VIB N1.5)") + 1
    assert lines[begin + 2] == comment, "behind the two lines with which the bracket begins"


def test_of_several_comments_the_control_chooses_the_last_one_still() -> None:
    """LinuxCNC acts on the last one alone: here it shows nothing, and it must not begin to."""
    lines = filtered(*LATHE, "(VIB N1.5)", "G1 Z-5 F0.1 (MSG, LOOK) (TO THE SHOULDER)", "M2")
    assert "(MSG, LOOK) (TO THE SHOULDER)" in lines
    assert "(MSG, LOOK)" not in lines


@pytest.mark.parametrize("behind", ["G1 Z-5 F0.1\nX34 (MSG, CORNER)", "G1 Z-5 F0.1\n(LOG,#5420)\nX34"])
def test_a_chain_ends_before_a_comment_that_does_something(behind: str) -> None:
    """It is done when the tool is there, not before both blocks."""
    lines = filtered(*LATHE, "(VIB N1.5)", *behind.split("\n"), "M2")
    acts = next(i for i, line in enumerate(lines) if line.startswith(("(MSG", "(LOG")))
    assert any(line.startswith("Z-5") for line in lines[:acts])
    assert any(line.startswith("X34") for line in lines[acts:])


def test_another_comment_stays_in_the_bracket_alone() -> None:
    lines = filtered(*LATHE, "(VIB N1.5)", "G1 Z-5 F0.1 (TO THE SHOULDER)", "M2")
    assert "(TO THE SHOULDER)" not in lines
