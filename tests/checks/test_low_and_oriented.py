"""No check where the tool is as low as its last cut, nor where M19 holds the spindle at an angle."""

from __future__ import annotations

import pytest

from .filtered import Filtered, check, filtered

HEAD = "G90 G21 G94 G17 G40 G49 G80\nT1 M6\nS1000 M3\nG0 X0 Y0\nG43 H1 Z15.\n(ROUGH)\nG1 Z-5. F200.\nX40.\n"
FINISH = "(FINISH)\n{}G1 Z-5. F200.\nX40.\n"
END = "G0 Z15.\nM5\nG91 G28 Z0.\nG90\nM30\n"


def run(between: str, then: str = "") -> Filtered:
    result = filtered(f"{HEAD}{between}{FINISH.format(then)}{END}".encode())
    check(result)
    return result


def line_before(result: Filtered) -> str:
    """The line behind which the check between the two operations stands, "" where there is none."""
    first = [edit for edit in result.edits if edit.title.startswith("CHIP")][:-1]
    return result.interpreted.program.source.text(first[0].first - 1) if first else ""


@pytest.mark.parametrize(
    ("between", "then", "place"),
    [
        ("G0 Z15.\n", "", "G0 Z15."),
        ("G0 X-20.\nZ15.\n", "", "Z15."),  # out of a T slot first
        ("G1 Z15. F2000.\n", "G0 X0 Y0\n", "G0 X0 Y0"),
        ("G1 Y9.\nG0 Y5.\n", "G0 X0 Y9.\nZ3.\n", "Z3."),
        ("G0 Y5.\n", "G91 G28 Z0.\nG90\nG0 X0 Y9.\nG43 H1 Z3.\n", "G91 G28 Z0."),
        ("G91\nG0 Z20.\nG90\n", "G0 X0 Y9.\n", "G90"),
        ("G81 X50. Y5. Z-9. R2. F90.\nG80\n", "G0 X0 Y9.\nZ3.\n", "Z3."),
        ("G0 Y5.\n", "G0 X0 Y9.\n", ""),
        ("G0 Y5.\nZ-6.\n", "G0 X0 Y9.\n", ""),
        ("G0 Y5.\n", "G91 G28 X0 Y0\nG90\nG0 X0 Y9.\n", ""),
        ("G1 X50. Z-4.\nG0 X60.\n", "G0 X0 Y9.\n", ""),
    ],
    ids=[
        "up",
        "aside, then up",
        "up in feed",
        "up behind a way at depth",
        "home",
        "by a distance",
        "a cycle",
        "at depth",
        "deeper",
        "home in X and Y alone",
        "a ramp is a cut",
    ],
)
def test_a_check_stands_where_the_program_itself_has_raised_the_tool(
    between: str, then: str, place: str
) -> None:
    result = run(between, then)
    assert line_before(result) == place
    if not place:
        (left_out,) = (d for d in result.diagnostics if d.code == "CHK002")
        assert "has not been raised since its last cut" in left_out.message
        assert "G0 Z15." in left_out.help
        assert line_before(run(f"{between}G0 Z15.\n", f"{then}Z3.\n"))


@pytest.mark.parametrize(
    ("between", "then", "place"),
    [
        ("G0 Z15.\nM19\n", "", "G0 Z15."),
        ("M19\nG0 Z15.\n", "G0 X0 Y0\n", ""),
        ("M19\nG0 Z15.\n", "S900 M3\nG0 X0 Y0\n", "G0 Z15."),
        ("M19\nG0 Z15.\n", "M5\nG0 X0 Y0\nS900 M3\n", "G0 Z15."),
    ],
    ids=["before it", "held in the cut", "started again", "stopped again"],
)
def test_an_orientation_that_the_next_blocks_count_on_is_not_lost(
    between: str, then: str, place: str
) -> None:
    result = run(between, then)
    assert line_before(result) == place
    if not place:
        assert any("oriented (M19)" in d.message for d in result.diagnostics)
