"""Strokes as long as the control stops at each of their ends: refused, whatever the way out that is tried."""

from __future__ import annotations

import numpy as np
import pytest

import chipbreak
from chipbreak.editing.render import can_be_written
from chipbreak.vibration import blocks

SETS = (
    "vibration.waveform=sine",
    "vibration.ramp_vibrations=2",
    "vibration.ramp_exponent=1",
    "vibration.end_revolutions=0",
    "output.form=loop",
    "planner.max_bytes_per_s=11520",
    "planner.model=trapezoid",
    "axes.X.max_acceleration_mm_s2=10000",
    "axes.Z.max_acceleration_mm_s2=10000",
)


@pytest.mark.parametrize(
    ("stop_ms", "why"),
    [
        (4, "leaves no time to move: the control stops as long"),
        (3.99999999, "needs 4e+16 m/s2"),
        (3.9, "needs 400 m/s2"),
    ],
)
def test_a_stroke_that_is_hardly_longer_than_the_stop(stop_ms: float, why: str) -> None:
    settings = chipbreak.load("mitsubishi-lathe", (*SETS, f"planner.reversal_stop_ms={stop_ms}"))
    cuts = "(VIB EDGES 2 N1.5)\nG1 Z-10. F0.2\nG3 X80. Z-20. R10.\nG1 Z-21.\n(VIB OFF)\n"
    program = f"G97 S2000 M3\nG99\nG0 X60. Z0.\n{cuts}G0 X90.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), settings)
    (said,) = caught.value.diagnostics
    assert (said.code, said.place and said.place.line) == ("VIB030", 5)
    assert why in said.message


def test_numbers_that_a_program_can_say() -> None:
    assert can_be_written(np.array([9e15]), 0)
    assert not can_be_written(np.array([9.1e15]), 0)
    assert can_be_written(np.array([-9e12, 0.0]), 3)
    assert not can_be_written(np.array([0.0, -9.1e12]), 3)
    assert not can_be_written(np.array([np.inf]), 3)
    assert not can_be_written(np.array([np.nan]), 3)
    assert can_be_written(np.empty(0), 3)


def test_a_feed_that_no_program_can_say_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ways out are tried with more acceleration than any machine has."""
    monkeypatch.setattr(
        blocks, "_feeds_for_spans", lambda law, moved, spans_s, plain_from: np.full(len(spans_s), 1e15)
    )
    program = b"G97 S1200 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program, chipbreak.load("generic-lathe"))
    (said,) = caught.value.diagnostics
    assert said.code == "VIB031"
    assert said.message == "a block would need F4.8e+13, which no program can say"
