"""The time of a whole program, held against sums that anybody can work out by hand."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.report.model import CycleTime

FAST = ("times.rapid_mm_min=6000", "times.tool_change_s=3")  # 100 mm/s
LATHE = "G21 G40 G99\nT0101\nG97 S1000 M3\nG0 X50. Z2.\n"


def time_of(program: str, profile: str = "fanuc-lathe", *sets: str) -> CycleTime:
    settings = chipbreak.load(profile, (*FAST, *sets))
    report = chipbreak.explain(chipbreak.rewrite(program.encode(), settings), settings)
    assert report.time is not None
    return report.time


def parts_of(time: CycleTime) -> dict[str, float]:
    return {part.name: part.before_s for part in time.parts}


def words_of(time: CycleTime) -> list[str]:
    return [one.what for one in time.assumed]


@pytest.mark.parametrize(
    ("blocks", "seconds"),
    [
        pytest.param("G1 Z-48. F0.1", 50 / 0.1 / 1000 * 60, id="feed per revolution"),
        pytest.param("G98 G1 Z-48. F100.", 50 / 100 * 60, id="feed per minute"),
        pytest.param("G1 X70. Z-8. F0.2", math.hypot(10, 10) / 0.2 / 1000 * 60, id="diameter"),
        pytest.param("G1 Z0. F0.1\nG3 X70. Z-10. R10.", (2 + 5 * math.pi) / 100 * 60, id="R"),
        pytest.param("G1 Z0. F0.1\nG2 X70. Z-10. I10. K0.", (2 + 5 * math.pi) / 100 * 60, id="I and K"),
        pytest.param("G1 Z0. F0.1\nG3 X70. Z-10. I10. K0.", (2 + 15 * math.pi) * 0.6, id="the longer arc"),
        pytest.param("G1 W-10. F0.1\nU20.", 20 / 0.1 / 1000 * 60, id="distances"),
        pytest.param("G32 Z-18. F2.", 20 / 2 / 1000 * 60, id="a thread"),
        # Facing from 50 to 0 at 157.08 m/min: the mean diameter of the way above 10 mm (5000 rpm) is 30.
        pytest.param(
            "G50 S5000\nG96 S157.07963\nG1 X0. F0.1",
            (20 / 0.1 * 30 / 50 + 5 / 0.1 * 10 / 50) / 1000 * 60,
            id="surface speed with a limit",
        ),
        pytest.param("G92 X48. Z-18. F2.\nX47.5\nX47.2", 3 * 20 / 2 / 1000 * 60, id="a pass a block"),
        # Depths 0.25 sqrt(n): 14 reach 0.92 - 0.02, and one finishing pass.
        pytest.param(
            "G76 P010060 Q50 R0.02\nG76 X48.16 Z-18. P920 Q250 F2.", 13 * 20 / 2 / 1000 * 60, id="G76"
        ),
        pytest.param("G90 X46. Z-48. F0.1\nX42.", (2 * 50 + 2 + 4) / 0.1 / 1000 * 60, id="G90"),
    ],
)
def test_what_cutting_takes(blocks: str, seconds: float) -> None:
    time = time_of(f"{LATHE}{blocks}\nG0 X50. Z2.\nM30\n")
    assert not time.untimed
    assert parts_of(time)["cutting"] == pytest.approx(seconds, rel=1e-6)


@pytest.mark.parametrize(
    ("blocks", "seconds"),
    [
        pytest.param("G4 X1.5", 1.5, id="X"),
        pytest.param("G4 U2.", 2.0, id="U"),
        pytest.param("G4 P500", 0.5, id="P in milliseconds"),
        pytest.param("G4 X500", 0.5, id="X without its point"),
    ],
)
def test_dwells(blocks: str, seconds: float) -> None:
    time = time_of(f"{LATHE}G1 Z0. F0.1\n{blocks}\nM30\n", "fanuc-lathe", "control.decimal_point=increment")
    assert parts_of(time)["dwells"] == pytest.approx(seconds)


def test_rapids_run_axis_by_axis_and_with_the_acceleration_of_the_profile() -> None:
    program = f"{LATHE}G1 Z0. F0.1\nG0 Z100. X70.\nX50.\nM30\n"
    plain = parts_of(time_of(program))["rapids"]
    # From a place that nobody knows, 100 mm along Z, 10 mm along X.
    assert plain == pytest.approx(1.0 + 1.0 + 0.1)
    slow = parts_of(time_of(program, "fanuc-lathe", *(f"axes.{a}.max_acceleration_mm_s2=1000" for a in "XZ")))
    # 100 mm reach 100 mm/s (0.1 s more); 10 mm are just the way to it and back.
    assert slow["rapids"] == pytest.approx(1.0 + 1.1 + 0.2)


def test_what_nobody_says_is_called_assumed() -> None:
    settings = chipbreak.load("fanuc-lathe")
    program = f"{LATHE}G1 Z-10. F0.1 N1.5\nG0 Z2.\nM30\n".encode()
    report = chipbreak.explain(chipbreak.rewrite(program, settings), settings)
    assert report.time is not None
    assert words_of(report.time) == [
        "rapids 10 m/min",
        "1 s a rapid where a place is unknown",
        "tool change 2 s",
    ]
    assert "rapids 10 m/min: times.rapid_mm_min in the profile says yours" in str(report)
    assert (
        "(assumed: rapids 10 m/min, 1 s a rapid where a place is unknown, tool change 2 s)"
        in report.summary()
    )
    said = time_of(program.decode(), "fanuc-lathe")
    assert words_of(said) == ["1 s a rapid where a place is unknown"]


def test_the_fastest_that_an_axis_moves_is_its_rapid() -> None:
    settings = chipbreak.load(
        "fanuc-lathe", ("axes.X.max_velocity_mm_min=6000", "axes.Z.max_velocity_mm_min=12000")
    )
    program = f"{LATHE}G1 Z0. F0.1\nG0 Z200.\nX70.\nM30\n".encode()
    time = chipbreak.explain(chipbreak.rewrite(program, settings), settings).time
    assert time is not None
    assert parts_of(time)["rapids"] == pytest.approx(1.0 + 1.0 + 0.1)
    assert not any(one.startswith("rapids ") for one in words_of(time))


def test_the_time_after_is_that_before_with_longer_cuts_dwells_and_checks() -> None:
    program = f"{LATHE}G97 S1100\nG1 Z-30. F0.1 N1.5\nX60.\nG0 Z2.\nM30\n"
    settings = chipbreak.load("fanuc-lathe", (*FAST, "spindle.settle_s=0.5"))
    report = chipbreak.explain(chipbreak.rewrite(program.encode(), settings), settings)
    cut, time = report.cuts[0], report.time
    assert time is not None
    assert cut.programmed_s is not None
    assert cut.speed_rpm != 1100.0  # so that the spindle is changed, and back again
    longer = cut.duration_s - cut.programmed_s
    assert time.after_s - time.before_s == pytest.approx(longer + 2 * 0.5)
    assert f"cycle 0:{time.before_s:04.1f} -> 0:{time.after_s:04.1f}" in report.summary()


def test_a_subprogram_counts_as_often_as_it_is_called() -> None:
    body = "O2000\nG1 W-10. F0.1\nG0 W10.\nM99\n"
    once = time_of(f"{LATHE}M98 P2000\nM30\n{body}")
    thrice = time_of(f"{LATHE}M98 P2000 L3\nM30\n{body}")
    packed = time_of(f"{LATHE}M98 P32000\nM30\n{body}")
    assert parts_of(once)["cutting"] == pytest.approx(10 / 0.1 / 1000 * 60)
    assert parts_of(thrice)["cutting"] == pytest.approx(3 * parts_of(once)["cutting"])
    assert parts_of(packed) == pytest.approx(parts_of(thrice))


def test_what_cannot_be_timed_is_said() -> None:
    time = time_of(f"{LATHE}G1 Z-10. F0.1\nG1 X#1\nM98 P7000\nG65 P9000 A1.\nM30\n")
    assert [(one.line, one.why) for one in time.untimed] == [
        (6, "where it begins or ends is not known"),
        (7, "what it calls is not followed"),
        (8, "what it calls is not followed"),
    ]


MILL = "G21 G90 G94 G17\nT1 M6\nG0 X0 Y0 Z50. S1000 M3\n"


@pytest.mark.parametrize(
    ("blocks", "cutting", "rapids"),
    [
        pytest.param("G99 G81 X100. Z-8. R2. F100.", 10 / 100 * 60, 1 + 1.0 + 0.48 + 0.1, id="G81"),
        pytest.param("G98 G81 X100. Z-8. R2. F100.", 10 / 100 * 60, 1 + 1.0 + 0.48 + 0.58, id="G98"),
        pytest.param("G99 G83 X100. Z-8. R2. Q4. F100.", 10 / 100 * 60, 2.82, id="pecks"),
        pytest.param("G99 G85 X100. Z-8. R2. F100.", 20 / 100 * 60, 1 + 1.0 + 0.48, id="feeds back"),
        pytest.param("G99 G81 Z-8. R2. F100.\nX100.\nX200.", 30 / 100 * 60, 1 + 2.0 + 0.48 + 0.3, id="three"),
    ],
)
def test_drilling(blocks: str, cutting: float, rapids: float) -> None:
    program = f"{MILL}{blocks}\nG80\nM30\n"
    found = parts_of(
        time_of(program, "fanuc-mill", "checks.enabled=false", "control.decimal_point=calculator")
    )
    assert found["cutting"] == pytest.approx(cutting)
    assert found["rapids"] == pytest.approx(rapids, abs=0.5)


@pytest.mark.parametrize("lines", [7, 16, 50, 1 << 14])
def test_a_long_run_takes_what_its_blocks_take_one_by_one(
    lines: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("chipbreak.cycle_time.program._PIECE_LINES", lines)
    moves = []
    for number in range(200):
        moves.append(f"N{number + 10} G{number % 4 and 1} X{number % 7}.5 Y{number % 5}.25")
        moves.append(f"Z-{number % 3}. F{100 + number}." if number % 2 else f"Y{number % 4}.")
        if number % 9 == 0:
            moves.append(f"G{2 + number % 2} X{number % 7}.5 Y{number % 4}. I1.5 J0.5\nG1")
    run = "\n".join(moves)
    plain = parts_of(time_of(f"{MILL}{run}\nM30\n", "fanuc-mill", "checks.enabled=false"))
    spoiled = run.replace("\n", "\n(STEP)\n")
    stepped = parts_of(time_of(f"{MILL}{spoiled}\nM30\n", "fanuc-mill", "checks.enabled=false"))
    assert plain == pytest.approx(stepped, rel=1e-9)


def test_a_program_that_asks_nothing_is_told_how_to_ask() -> None:
    settings = chipbreak.load("fanuc-lathe")
    report = chipbreak.explain(chipbreak.rewrite(f"{LATHE}G1 Z-10. F0.1\nM30\n".encode(), settings), settings)
    assert report.summary() == "no cut vibrates: nothing asks for it"
    assert "nothing asks: N1.5 in a cut" in str(report)


def test_cuts_that_nothing_asks_are_named() -> None:
    settings = chipbreak.load("fanuc-lathe")
    program = f"{LATHE}(ROUGH)\nG1 Z-10. F0.1 N1.5\nX60.\nZ-12.\nG0 Z2.\nM30\n".encode()
    report = chipbreak.explain(chipbreak.rewrite(program, settings), settings)
    (one,) = report.unasked
    assert (one.first_line, one.last_line, one.blocks) == (7, 8, 2)
    assert one.reason == "neither the block, nor a comment, nor the profile asks"


def test_a_hole_on_the_axis_at_surface_speed_has_no_known_time() -> None:
    """Without a limit the spindle would turn ever faster."""
    program = LATHE + "G96 S150\nG0 X0. Z2.\nG83 Z-18. R2. Q5. F0.1\nG80\nG1 Z1. F0.1\nG0 X50.\nM30\n"
    settings = chipbreak.load("fanuc-lathe", FAST)
    assert chipbreak.explain(chipbreak.rewrite(program.encode(), settings), settings).time is None
    limited = time_of(program.replace("G96", "G50 S3000\nG96"))
    assert parts_of(limited)["cutting"] == pytest.approx(20 / 0.1 / 3000 * 60)
