"""A control that nobody has measured: it rests at every reversal, and its acceleration is declared.

It speeds up and brakes at that acceleration, and runs through the joints of blocks that go the same way.  A
block from rest to rest takes d/v + v/a, or 2·sqrt(d/a) when it is too short to reach v, and the time that the
control stops there until it takes the axis to be in position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junctions import Blocks, Parts
from chipbreak.trajectory.planner import Numbers, joint_speeds, speed_for_time
from chipbreak.trajectory.resting import RestingLaw, Run


@dataclass(frozen=True)
class Trapezoid(RestingLaw):
    """Even acceleration from rest to rest; ``reversal_stop_s`` is how long the control stops at each rest."""

    name: ClassVar[str] = "trapezoid"

    reversal_stop_s: float = 0.0

    def run(self, ways_mm: Floats, speeds_mm_s: Floats, before_mm_s: float) -> Run:
        """See :meth:`RestingLaw.run`."""
        times_s = np.array(trapezoid(ways_mm.tolist(), speeds_mm_s.tolist(), self.acceleration_mm_s2))
        times_s[-1] += self.reversal_stop_s
        return times_s, np.empty(0)

    def slack_s(self, wanted_s: float) -> float:
        """See :meth:`RestingLaw.slack_s`."""
        return 0.002 * wanted_s

    def knots(
        self, distance_mm: Floats, lengths_mm: Floats, parts: Parts, runs: Sequence[Run]
    ) -> tuple[Floats, Floats]:
        """The ends of the blocks, and of the stops at the rests among them."""
        time_s = np.append(0.0, np.cumsum(np.concatenate([run[0] for run in runs])))
        if self.reversal_stop_s <= 0.0:
            return time_s, distance_mm
        return _with_stops(time_s, distance_mm, parts.stops, self.reversal_stop_s)

    def peak_speed_mm_s(self, blocks: Blocks, feeds_mm_s: Floats) -> float | None:
        """What an axis reaches that speeds up and brakes within a block, of which only the ends are known."""
        reachable = np.sqrt(self.acceleration_mm_s2 * np.abs(blocks.lengths_mm))
        return float(np.minimum(np.minimum(feeds_mm_s, self.velocity_mm_s), reachable).max())

    def _feed_for(self, length_mm: float, time_s: float) -> float:
        return speed_for_time(length_mm, time_s - self.reversal_stop_s, self.acceleration_mm_s2)

    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        moving_s = time_s - self.reversal_stop_s
        return 4.0 * length_mm / moving_s**2 if moving_s > 0.0 else inf


def trapezoid(
    lengths_mm: Sequence[float], speeds_mm_s: Sequence[float], acceleration_mm_s2: float
) -> Numbers:
    """Time of each block when the axis runs through the joints as fast as speeds and braking allow.

    One block alone takes d/v + v/a, or 2·sqrt(d/a) when it is too short to reach v.
    """
    most = acceleration_mm_s2
    ends = joint_speeds(lengths_mm, [min(pair) for pair in pairwise(speeds_mm_s)], most)
    times_s: list[float] = []
    start = 0.0
    for length, speed, end in zip(lengths_mm, speeds_mm_s, ends, strict=True):
        end_speed = min(end, sqrt(start * start + 2.0 * most * length))
        top = min(speed, sqrt(most * length + (start * start + end_speed * end_speed) / 2.0))
        ramps = (2.0 * top - start - end_speed) / most
        way = (2.0 * top * top - start * start - end_speed * end_speed) / (2.0 * most)
        times_s.append(ramps + max(length - way, 0.0) / top)
        start = end_speed
    return tuple(times_s)


def _with_stops(
    time_s: Floats, distance_mm: Floats, rests: NDArray[np.intp], stop_s: float
) -> tuple[Floats, Floats]:
    """The knots, and those at which a stop that belongs to a block begins."""
    knots_s = np.insert(time_s, rests, time_s[rests] - stop_s)
    return knots_s, np.insert(distance_mm, rests, distance_mm[rests])
