"""How many moves, and how many slow vibrations, one cut may have at most."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.vibration import cuts, plan

HEAD = "G21 G18 G99 G97 S600 M3\nG0 X20. Z2.\n"
LINE = "G1 Z-20. F0.05\n"
ARC = "G2 X40. Z-8. R10. F0.05\n"
CORNER = "G1 Z-2. F0.05\nX28.\n"
LATHE = [f"axes.{axis}.max_acceleration_mm_s2=90000" for axis in "XZ"]
FOLLOWED = [
    "planner.model=after-interpolation",
    *(f"axes.{axis}.{number}" for axis in "XZ" for number in ("acc_dec_ms=8", "position_gain_1_s=90")),
]
RESTING = ["planner.model=trapezoid"]
TWICE_PLANNED = ["planner.model=junction", "output.feed_mode=minute"]
DWELL = "N0.2 WAVE DWELL"
CASES = {
    # wish, cut, settings, which of the bounds, in whose words
    "dwells": (DWELL, LINE, FOLLOWED, "MOST_DWELLS", "with a dwell each"),
    "an arc": ("N1.5", ARC, FOLLOWED, "MOST_STROKES_ROUND_BENDS", "behind its own filter"),
    "a corner": ("N1.5", CORNER, FOLLOWED, "MOST_STROKES_ROUND_BENDS", "behind its own filter"),
    "no two alike": (
        "N0.5 WAVE SINE Q1.8",
        ARC,
        RESTING,
        "MOST_UNLIKE_MOVES",
        "(trapezoid) runs no two strokes alike",
    ),
    "planned": ("N1.5", LINE, TWICE_PLANNED, "MOST_PLANNED_MOVES", "(junction) plans again"),
    "a line": ("N1.5", LINE, FOLLOWED, "MOST_MOVES", "blocks"),
    "no filters": ("N1.5", ARC, RESTING, "MOST_MOVES", "blocks"),
}
BOUNDS = ("MOST_DWELLS", "MOST_STROKES_ROUND_BENDS", "MOST_UNLIKE_MOVES", "MOST_PLANNED_MOVES", "MOST_MOVES")


def said(case: str) -> list[chipbreak.Diagnostic]:
    wish, cut, sets, *_ = CASES[case]
    program = f"{HEAD}(VIB {wish})\n{cut}G0 X300.\nM30\n"
    found = chipbreak.check(program.encode(), chipbreak.load("fanuc-lathe", [*LATHE, *sets]))
    return [one for one in found if one.severity.value == "error"]


@pytest.mark.parametrize("case", CASES)
def test_a_cut_is_bounded_by_what_it_takes_to_follow_it(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert said(case) == []
    *_, own, words = CASES[case]
    for bound in BOUNDS[: BOUNDS.index(own)]:
        monkeypatch.setattr(plan, bound, 1)
    assert said(case) == []  # those are about other cuts
    monkeypatch.setattr(plan, own, 60)
    monkeypatch.setattr(plan, "sample", None)  # refused before anything is made of it
    (refused,) = said(case)
    assert refused.code == "VIB021"
    assert words in refused.message
    assert refused.message.endswith("; 60 of them are the most")


def test_several_cuts_with_a_rapid_between_are_looked_at_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "MOST_DWELLS", 100)
    (refused,) = said("dwells")
    assert "several cuts with a rapid between" in refused.help
    halves = "G1 Z-9. F0.05\nG0 X21.\nX20.\n" + LINE
    monkeypatch.setitem(CASES, "halves", (DWELL, halves, FOLLOWED, "", ""))
    assert said("halves") == []


def test_the_cuts_of_a_program_have_so_many_blocks_in_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thousand cuts with a feed in another unit would take all memory; then no further cut is planned."""
    monkeypatch.setattr(cuts, "MOST_MOVES_IN_ALL", 100)
    three = "G0 X21. Z2.\n" + LINE
    monkeypatch.setitem(CASES, "three", ("N1.5", LINE + three + three, RESTING, "", ""))
    refused = said("three")
    assert [(one.code, one.place and one.place.line) for one in refused] == [("VIB021", 6), ("VIB021", 8)]
    assert "; 100 in all are the most" in refused[0].message
    assert "several programs" in refused[0].help


def test_the_longest_cut_that_was_ever_asked_for_is_none_too_many() -> None:
    """201,480 strokes, 403,000 blocks, in LinuxCNC's law."""
    assert plan.MOST_PLANNED_MOVES < 403_000 < plan.MOST_MOVES
