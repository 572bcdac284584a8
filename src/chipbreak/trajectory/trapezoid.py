"""A control that nobody has measured: it rests at every reversal, and its acceleration is declared.

It speeds up and brakes at that acceleration, and runs through the joints of blocks that go the same way.  A
block from rest to rest takes d/v + v/a, or 2·sqrt(d/a) when it is too short to reach v, and the time that the
control stops there until it takes the axis to be in position.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junctions import Blocks, Parts
from chipbreak.trajectory.planner import speed_for_time
from chipbreak.trajectory.resting import Kind, RestingLaw

_NONE = np.empty(0)
_SAME_SHARE = 1e-9  # of a time is rounding


@dataclass(frozen=True)
class Trapezoid(RestingLaw):
    """Even acceleration from rest to rest; ``reversal_stop_s`` is how long the control stops at each rest."""

    name: ClassVar[str] = "trapezoid"

    reversal_stop_s: float = 0.0

    @property
    def befores_mm_s(self) -> tuple[float, ...]:
        """See :attr:`RestingLaw.befores_mm_s`: the block before a rest does not count."""
        return (0.0,)

    def counted(self, before_mm_s: float, length_mm: float) -> float:
        """See :meth:`RestingLaw.counted`."""
        return 0.0

    def run(self, ways_mm: Floats, speeds_mm_s: Floats, before_mm_s: float) -> Floats:
        """See :meth:`RestingLaw.run`."""
        acceleration = np.array([self.acceleration_mm_s2])
        times_s: Floats = trapezoids(ways_mm[np.newaxis], speeds_mm_s[np.newaxis], acceleration)[0]
        times_s[-1] += self.reversal_stop_s
        return times_s

    def run_kinds(self, kinds: Sequence[Kind]) -> list[Floats]:
        """See :meth:`RestingLaw.run_kinds`: those of as many blocks at once."""
        if self.every_block_stops:
            return super().run_kinds(kinds)
        counts = np.array([len(kind.lengths_mm) for kind in kinds], dtype=np.intp)
        runs = [_NONE] * len(kinds)
        for count in np.unique(counts):
            places = np.flatnonzero(counts == count).tolist()
            lengths, feeds, has, _ = zip(*(kinds[place] for place in places), strict=True)
            times_s = self.times_alike(np.array(lengths), np.array(feeds), np.array(has), 0.0)
            for place, row in zip(places, times_s, strict=True):
                runs[place] = row
        return runs

    def times_alike(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: float
    ) -> Floats:
        """See :meth:`RestingLaw.times_alike`."""
        if self.every_block_stops:
            return super().times_alike(lengths_mm, feeds_mm_s, acceleration_mm_s2, before_mm_s)
        speeds = np.minimum(feeds_mm_s, self.velocity_mm_s)
        times_s = trapezoids(np.abs(lengths_mm), speeds, acceleration_mm_s2)
        times_s[:, -1] += self.reversal_stop_s
        return np.maximum(times_s, self.read_s)

    def shortest_time(self, length_mm: float) -> float:
        """See :meth:`ControlLaw.shortest_time`."""
        way_mm = abs(length_mm)
        top = min(self.velocity_mm_s, sqrt(way_mm * self.acceleration_mm_s2))
        return max(way_mm / top + top / self.acceleration_mm_s2 + self.reversal_stop_s, self.read_s)

    def slack_s(self, wanted_s: float) -> float:
        """See :meth:`RestingLaw.slack_s`."""
        return 0.002 * wanted_s

    def knots(self, distance_mm: Floats, parts: Parts, times_s: Floats) -> tuple[Floats, Floats]:
        """The ends of the blocks, and of the stops at the rests among them."""
        time_s = np.append(0.0, np.cumsum(times_s))
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
        # What rounding leaves of a stroke that is as long as the stop is no time to move.
        return 4.0 * length_mm / moving_s**2 if moving_s > _SAME_SHARE * time_s else inf


def trapezoids(lengths_mm: Floats, speeds_mm_s: Floats, acceleration_mm_s2: Floats) -> Floats:
    """Times of the blocks of stretches of n blocks each, (k, n), with an acceleration each, (k,).

    The axis runs through the joints as fast as speeds and braking allow.  One block alone takes d/v + v/a, or
    2·sqrt(d/a) when it is too short to reach v.
    """
    most = acceleration_mm_s2
    ends = np.zeros(lengths_mm.shape)
    np.minimum(speeds_mm_s[:, :-1], speeds_mm_s[:, 1:], out=ends[:, :-1])
    for block in range(lengths_mm.shape[1] - 1, 0, -1):
        braking = np.sqrt(ends[:, block] ** 2 + 2.0 * most * lengths_mm[:, block])
        np.minimum(ends[:, block - 1], braking, out=ends[:, block - 1])
    times_s = np.empty(lengths_mm.shape)
    start = np.zeros(len(lengths_mm))
    for block, length in enumerate(lengths_mm.T):
        end = np.minimum(ends[:, block], np.sqrt(start**2 + 2.0 * most * length))
        top = np.minimum(speeds_mm_s[:, block], np.sqrt(most * length + (start**2 + end**2) / 2.0))
        way = (2.0 * top**2 - start**2 - end**2) / (2.0 * most)
        times_s[:, block] = (2.0 * top - start - end) / most + np.maximum(length - way, 0.0) / top
        start = end
    return times_s


def _with_stops(
    time_s: Floats, distance_mm: Floats, rests: NDArray[np.intp], stop_s: float
) -> tuple[Floats, Floats]:
    """The knots, and those at which a stop that belongs to a block begins."""
    knots_s = np.insert(time_s, rests, time_s[rests] - stop_s)
    return knots_s, np.insert(distance_mm, rests, distance_mm[rests])
