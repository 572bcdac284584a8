"""Programs that come over a line: what is refused because its blocks come in too slowly."""

from __future__ import annotations

import re

import pytest

import chipbreak

PROGRAM = b"G21 G90 G94\nS2500 M3\nG0 X10. Z2.\nG1 Z-20. F125. N1.5\nG0 X30.\nM30\n"
AXES = ("axes.X.max_acceleration_mm_s2=20000", "axes.Z.max_acceleration_mm_s2=20000")


def cuts_at(baud: int, program: bytes = PROGRAM) -> tuple[chipbreak.CutReport, ...]:
    """Ten bits a byte."""
    profile = chipbreak.load("grbl", [*AXES, f"planner.max_bytes_per_s={baud / 10}"])
    return chipbreak.rewrite(program, profile).cuts


def test_a_fast_line_is_enough() -> None:
    assert len(cuts_at(115_200)) == 1


def test_a_slow_line_is_refused_with_what_works() -> None:
    """62.5 Hz are 125 blocks a second; at 9,600 baud N 1.5 would fall to 0.5."""
    with pytest.raises(chipbreak.ProgramRejectedError, match="the control gets 960") as caught:
        cuts_at(9600)
    (error,) = caught.value.diagnostics
    assert error.code == "VIB032"
    works = re.search(r"works at f ([0-9.]+) Hz", error.help)
    assert works
    (cut,) = cuts_at(9600, PROGRAM.replace(b"N1.5", b"N1.5 f" + works[1].encode()))
    assert cut.verdict.breaks
    assert cut.plan.solution.per_rev == pytest.approx(1.5, abs=0.001)
