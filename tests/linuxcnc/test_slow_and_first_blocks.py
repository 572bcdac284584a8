"""What LinuxCNC makes of very slow blocks in inverse time, and of the first block behind a stand."""

from __future__ import annotations

import re
from math import inf

import numpy as np
import pytest

import chipbreak
from chipbreak.trajectory.linuxcnc import interpolated
from chipbreak.trajectory.linuxcnc_planner import Clock, Stretch, linuxcnc

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


# Blocks in a row: of a sine that begins, and of an even feed.
RISING = ((0.0152, 0.0155, 0.0163, 0.017, 0.0178), (3.75, 3.824, 4.022, 4.194, 4.392))
EVEN = ((0.05, 0.05, 0.05, 0.05, 0.05), (20.0, 20.0, 20.0, 20.0, 20.0))


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    ("acceleration", "row", "firsts"),
    [
        (2000.0, RISING, ((inf, 0.0152), (inf, 0.0162), (1.0, 0.0152))),
        (20000.0, EVEN, ((1.0, 0.035), (1.0, 0.045), (inf, 0.09), (inf, 0.13))),
    ],
)
def test_a_first_block_runs_alone_until_the_next_one_is_handed_over(
    acceleration: float,
    row: tuple[tuple[float, ...], tuple[float, ...]],
    firsts: tuple[tuple[float, float], ...],
) -> None:
    """One command a servo period, two with feed per revolution; a quarter of its way is too far by then."""
    programs, predicted = [], []
    for override, first in firsts:
        ways, feeds = (first, *row[0][1:]), row[1]
        words = [f"F{feed if override == inf else 60.0 * feed:.3f}" for feed in feeds]
        ends = np.cumsum(ways)
        blocks = "".join(f"G1 Z{-end:.4f} {word}\n" for end, word in zip(ends, words, strict=True))
        mode = "G95" if override == inf else "G94"
        programs.append(f"G21 G90 G97 S60 M3\n{mode} G61\nG4 P0.05\n{blocks}M2\n".encode())
        stretch = Stretch(ways, feeds, (100.0,) * len(ways), (acceleration,) * len(ways))
        _, places = linuxcnc(stretch, Clock(0.001, 0.01, override))
        predicted.append(interpolated(np.concatenate([[0.0, 0.0], places, places[-1:]])))
    off = np.inf
    for speed_up in SPEEDS:  # where the reader of the program came late, again and slower
        runs = machine.run(programs, lathe=True, speed_up=speed_up, acceleration_mm_s2=acceleration)
        seen = [-one.moving()[1 : len(path) + 1, 3] for one, path in zip(runs, predicted, strict=True)]
        off = max(np.abs(one - path[: len(one)]).max() for one, path in zip(seen, predicted, strict=True))
        if off < NEAR_MM:
            break
    assert off < NEAR_MM
