"""What LinuxCNC makes of very slow blocks in inverse time, and of the first block behind a stand."""

from __future__ import annotations

import re

import numpy as np
import pytest

import chipbreak

from . import machine, rs274
from .settled import SPEEDS

INCH_MM = 25.4
START = 0.0197
SLOW = b"G20 G18 G90 G8 G97 G95 S200 M3\nG0 X0.315 Z0.0197\nG1 Z-0.0183 F0.0009 N1.5 Q1.71\nM2\n"
TICKS = b"G21 G18 G90 G8 G97 G94 S6000 M3\nG0 X14.664 Z-0.4\nG1 X9.966 F840 E2\nG0 X10.966 Z0.2\nM2\n"
FAST = {"acceleration_mm_s2": 20000.0, "velocity_mm_s": (50.0, 100.0), "max_feed_override": 1.2}
NEAR_MM = 2e-6


@pytest.mark.linuxcnc
def test_blocks_of_inverse_time_get_the_feed_that_they_say() -> None:
    """An interpreter before 2.9.0 makes 0.1 inch per minute of anything slower: no block asks for that."""
    settings = chipbreak.load("linuxcnc-lathe", ["output.feed_mode=inverse"])
    result = chipbreak.rewrite(SLOW, settings)
    judgement = rs274.judge(result.data, lathe=True)
    assert (judgement.accepted, judgement.message) == (True, "")
    feeds = [one.feed / INCH_MM for one in judgement.motion if one.kind == "feed"]
    blocks = re.findall(r"^(?:G1 )?Z(\S+) F(\S+)$", result.data.decode(), re.MULTILINE)
    ends, rates = np.array(blocks, float).T
    asked = np.abs(np.diff(ends, prepend=START)) * rates
    assert len(asked) > 100
    assert feeds == pytest.approx(asked.tolist(), rel=0.001)
    assert asked.min() < 0.11


def _from_the_cut_on(x_mm: np.ndarray) -> np.ndarray:
    """X from the last moment at its highest, where the cut starts, on."""
    return np.asarray(x_mm[np.flatnonzero(x_mm > x_mm.max() - NEAR_MM)[-1] :])


@pytest.mark.linuxcnc("machine")
def test_a_first_short_block_runs_as_predicted_only_from_a_stand() -> None:
    """Behind a rapid the blocks wait, and know each other when they begin: the first is an even ramp."""
    sets = [f"axes.X.max_acceleration_mm_s2={FAST['acceleration_mm_s2']}", "planner.max_feed_override=1.2"]
    settings = chipbreak.load("linuxcnc-lathe", [*sets, "output.feed_mode=minute", "output.segments=tick"])
    result = chipbreak.rewrite(TICKS, settings)
    ((motion,), standing) = chipbreak.motions(result, settings), b"\nG4 P0\n"
    assert result.data.count(standing) == 1
    programs = [result.data, result.data.replace(standing, b"\n")]
    moments_s = 0.001 * np.arange(300)
    predicted = 14.664 - np.interp(moments_s, motion.time_s, motion.distance_mm)
    for speed_up in SPEEDS:  # where the reader of the program came late, again and slower
        runs = machine.run(programs, lathe=True, speed_up=speed_up, **FAST)
        seen = [_from_the_cut_on(one.samples[:, 1])[: len(moments_s)] for one in runs]
        off = [np.abs(one - predicted) for one in seen]
        if off[0].max() < NEAR_MM:
            break
    assert off[0].max() < NEAR_MM
    assert off[1].max() > 0.05
