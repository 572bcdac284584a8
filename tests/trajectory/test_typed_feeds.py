"""Feeds of LinuxCNC as they can be typed: rounding must not take a period from every stroke alike."""

from __future__ import annotations

import numpy as np
import pytest

import chipbreak
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.linuxcnc_feeds import Wanted
from chipbreak.trajectory.linuxcnc_many import Stretches

LIMITS = [f"axes.{axis}.max_acceleration_mm_s2=2000" for axis in "XZ"]


@pytest.mark.parametrize("wish", ["E2", "N0.6", "N0.7", "N1.5 f16", "f11"])
@pytest.mark.parametrize("mode", ["rev", "minute"])
def test_a_sine_has_its_n(wish: str, mode: str) -> None:
    """In five digits a feed of 0.0032 is off by up to 0.15 %, and LinuxCNC counts whole periods."""
    sets = [*LIMITS, "planner.max_feed_override=1", "vibration.waveform=sine", f"output.feed_mode={mode}"]
    program = f"G21 G18 G90 G8 G97 G95 S1200 M3\nG0 X10 Z1\nG1 Z-3 F0.1 {wish}\nG0 X12\nM2\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-lathe", sets))
    (cut,) = result.cuts
    assert cut.verdict.per_rev == pytest.approx(cut.plan.solution.per_rev, rel=1e-3)
    assert cut.duration_s == pytest.approx(cut.wave.duration_s, abs=0.0025)


def test_typed_speeds() -> None:
    """Whole steps, each block its own, and at least one of them."""
    speeds = np.array([[1.24, 1.26, 0.004], [0.5, 2.0, 3.0]])
    steps = np.array([[0.1, 0.1, 0.01], [0.2, 0.5, 2.0]])
    stretches = Stretches(speeds, speeds, speeds, speeds, np.zeros(2))
    wanted = Wanted(stretches, speeds, 3, np.ones(2), steps)
    typed = [[1.2, 1.3, 0.01], [0.4, 2.0, 4.0]]
    assert wanted.typed().stretches.speeds == pytest.approx(np.array(typed))
    assert wanted.rows(np.array([1])).typed().stretches.speeds == pytest.approx(np.array(typed[1:]))
    assert wanted._replace(steps=None).typed().stretches.speeds is speeds


def test_a_part_of_blocks_keeps_its_steps() -> None:
    """The steps of the same blocks; none where any feed can be typed."""
    some = np.arange(4.0)
    blocks = Blocks(some, np.zeros((4, 3)), some, some, some * 0.1)
    part = blocks.part(slice(1, 3))
    assert part.feed_steps_mm_s is not None
    assert part.feed_steps_mm_s.tolist() == [0.1, 0.2]
    assert Blocks(some, np.zeros((4, 3)), some, some).part(slice(1, 3)).feed_steps_mm_s is None
