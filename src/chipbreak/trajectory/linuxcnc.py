"""The trajectory planner of LinuxCNC 2.9 (its ``src/emc/tp/tp.c``, and measured on its simulated machine).

It decides once per servo period T (``docs/linuxcnc-timing.md``), and in a block that ends at rest

1. it speeds up by at most a·T per period, until the feed is reached;
2. it keeps the feed until it could not brake any more on v² = 2·a·(way to go);
3. it brakes by a·T per period, and the last, incomplete period counts as a whole one.

So such a block takes a whole number of periods, the trapezoid's time rounded up and sometimes one more; the
fewest are the least k with a·T²·(k² − k mod 2)/4 ≥ d.  The full acceleration is used: half of it only where
two blocks are blended round a corner, which an oscillation never has.  G61, G61.1 and G64 are the same for
one block per stroke.  Several blocks per stroke run through their joints in G61 and G64 (one that would take
less than 1/100 s at an even change of speed is run as such a ramp), and each of them stops in G61.1.  Feed
per minute and inverse time give the same times, and so does feed per revolution for one block per stroke;
several are joined in another way (``per_revolution``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junctions import CORNER_LIMIT, Blocks, Parts, sharpest_of_parts
from chipbreak.trajectory.linuxcnc_many import linuxcnc_many, middle_feeds
from chipbreak.trajectory.linuxcnc_planner import linuxcnc
from chipbreak.trajectory.planner import speed_for_time
from chipbreak.trajectory.resting import Kind, RestingLaw, Run

_EITHER = (0.0, inf)
_PERIODS_LATE = 2.0  # its joint interpolator
# Fewer stretches are faster one by one: a long even feed, such as a plain end, then takes no time.
_MANY = 8
_STILL_EVEN_MM = 1e-9


@dataclass(frozen=True)
class LinuxCnc(RestingLaw):
    """LinuxCNC's planner and joint interpolator; ``ramp_s`` is 1/ARC_BLEND_RAMP_FREQ."""

    name: ClassVar[str] = "linuxcnc"
    runs_whole_periods: ClassVar[bool] = True
    is_slow_to_try: ClassVar[bool] = True

    ramp_s: float = 0.01

    @property
    def late_s(self) -> float:
        """See :attr:`ControlLaw.late_s`."""
        return _PERIODS_LATE * self.servo_period_s

    def rounded(self, time_s: float) -> float:
        """A whole number of servo periods."""
        return round(time_s / self.servo_period_s) * self.servo_period_s

    def checked(self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike) -> tuple[Floats, Floats]:
        """See :meth:`ControlLaw.checked`."""
        if self.acceleration_mm_s2 == inf:
            raise ValueError("LinuxCNC's law needs an acceleration: give it, or the axes with along()")
        return super().checked(lengths_mm, feeds_mm_s)

    def slack_s(self, wanted_s: float) -> float:
        """See :meth:`RestingLaw.slack_s`."""
        return self.servo_period_s / 2.0

    def time_step_s(self, wanted_s: float) -> float:
        """See :meth:`RestingLaw.time_step_s`."""
        return self.servo_period_s

    def run(self, ways_mm: Floats, speeds_mm_s: Floats, before_mm_s: float) -> Run:
        """See :meth:`RestingLaw.run`; where points on a line are joined, blocks of one feed are one."""
        is_new = (np.diff(speeds_mm_s) != 0.0) | (self.merge_mm <= 0.0)
        starts = np.flatnonzero(np.r_[True, is_new])
        joined = np.add.reduceat(ways_mm, starts)
        times, places = linuxcnc(
            tuple(joined.tolist()),
            tuple(speeds_mm_s[starts].tolist()),
            self.acceleration_mm_s2,
            self.servo_period_s,
            self.ramp_s,
            before=before_mm_s if self.per_revolution and len(joined) > 1 else None,
        )
        shares = np.repeat(np.array(times) / joined, np.diff(np.r_[starts, len(ways_mm)]))
        return shares * ways_mm, np.array(places)

    @property
    def _runs_many(self) -> bool:
        """True where many stretches can be run at once: no blocks joined, no stop inside a stretch."""
        return self.merge_mm == 0.0 and not self.every_block_stops

    def _many(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: Floats
    ) -> Run:
        """:meth:`run` for stretches of as many blocks each, two or more: (m, n) and (m,)."""
        times_s, places_mm = linuxcnc_many(
            lengths_mm,
            np.minimum(feeds_mm_s, self.velocity_mm_s),
            acceleration_mm_s2,
            self.servo_period_s,
            self.ramp_s,
            before=before_mm_s if self.per_revolution else None,
        )
        return np.maximum(times_s, self.read_s), places_mm

    def run_kinds(self, kinds: Sequence[Kind]) -> list[Run]:
        """See :meth:`RestingLaw.run_kinds`; as many at once as there are of one count of blocks."""
        found: dict[Kind, Run] = {}
        for count in {len(kind.lengths_mm) for kind in kinds} - {1} if self._runs_many else ():
            alike = [kind for kind in kinds if len(kind.lengths_mm) == count]
            if len(alike) >= _MANY:
                times, places = self._many(*map(np.array, zip(*alike, strict=True)))
                ways = [row[~np.isnan(row)] for row in places]
                found |= dict(zip(alike, zip(times, ways, strict=True), strict=True))
        others = [kind for kind in kinds if kind not in found]
        found |= dict(zip(others, super().run_kinds(others), strict=True))
        return [found[kind] for kind in kinds]

    def times_alike(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: float
    ) -> Floats:
        """See :meth:`RestingLaw.times_alike`."""
        if not self._runs_many:
            return super().times_alike(lengths_mm, feeds_mm_s, acceleration_mm_s2, before_mm_s)
        befores = np.full(len(lengths_mm), before_mm_s)
        return self._many(lengths_mm, feeds_mm_s, acceleration_mm_s2, befores)[0]

    def single_feeds(self, lengths_mm: Floats, times_s: Floats, acceleration_mm_s2: Floats) -> list[float]:
        """See :meth:`RestingLaw.single_feeds`."""
        if not self._runs_many:
            return super().single_feeds(lengths_mm, times_s, acceleration_mm_s2)
        for length, time, has in zip(
            lengths_mm.tolist(), times_s.tolist(), acceleration_mm_s2.tolist(), strict=True
        ):
            self.with_acceleration(has).refuse_too_fast(length, time)
        found: list[float] = middle_feeds(
            lengths_mm, times_s, acceleration_mm_s2, self.servo_period_s, self.ramp_s
        ).tolist()
        return found

    @property
    def befores_mm_s(self) -> tuple[float, ...]:
        """See :attr:`RestingLaw.befores_mm_s`."""
        if not self._runs_many:
            return ()
        return _EITHER if self.per_revolution else _EITHER[:1]

    def counted(self, before_mm_s: float, length_mm: float) -> float:
        """See :meth:`RestingLaw.counted`.

        With feed per revolution it is asked whether the first block is one even change of speed, and nothing
        else; so one of two feeds stands for all.
        """
        before_mm_s = super().counted(before_mm_s, length_mm)
        if self._runs_many:
            return _EITHER[int(2.0 * length_mm < self.ramp_s * before_mm_s)]
        return before_mm_s

    def corner_shares(self, blocks: Blocks, feeds_mm_s: Floats) -> Floats:
        """See :meth:`RestingLaw.corner_shares`; ``tpSetupTangent`` of LinuxCNC.

        The change of velocity within one servo period, and the acceleration, may take a tenth of the axis's
        acceleration; with feed per revolution the velocity is the highest possible.
        """
        if self.every_block_stops:
            return super().corner_shares(blocks, feeds_mm_s)
        top = np.minimum(np.abs(blocks.lengths_mm) / self.servo_period_s, self.velocity_mm_s)
        speeds = top if self.per_revolution else np.minimum(top, feeds_mm_s)
        slower = np.append(np.minimum(speeds[:-1], speeds[1:]), 0.0)
        jolt = slower / self.servo_period_s + blocks.acceleration_mm_s2
        shares: Floats = jolt * blocks.corners / self.acceleration_mm_s2 / CORNER_LIMIT
        return shares

    def in_corners(self, acceleration_mm_s2: Floats, parts: Parts, corner_shares: Floats) -> Floats:
        """See :meth:`RestingLaw.in_corners`; what a corner may take is kept from the blocks beside it."""
        left: Floats = acceleration_mm_s2 * (1.0 - CORNER_LIMIT * sharpest_of_parts(parts, corner_shares))
        return left

    def knots(
        self, distance_mm: Floats, lengths_mm: Floats, parts: Parts, runs: Sequence[Run]
    ) -> tuple[Floats, Floats]:
        """Every servo period behind the joint interpolator, where the motion is not even.

        The (1, 4, 1)/6 average of the interpolator blunts every reversal by a third of the planner's last
        step; its lag of two periods is left out.
        """
        counts = [len(places) for _, places in runs]
        # One array, changed in place: there is a place for every millisecond of the cut.
        planned = np.concatenate([np.zeros(2), *(places for _, places in runs), distance_mm[-1:]])
        along_mm = planned[2:-1]
        along_mm *= np.repeat(np.sign(lengths_mm[parts.starts]), counts)
        along_mm += np.repeat(distance_mm[parts.starts], counts)
        knots_mm = np.concatenate([np.zeros(1), interpolated(planned), distance_mm[-1:]])
        bent = np.abs(np.diff(knots_mm, 2)) > _STILL_EVEN_MM
        kept = np.flatnonzero(np.concatenate([[True], bent, [True]]))
        return kept.astype(np.float64) * self.servo_period_s, knots_mm[kept]

    def _feed_for(self, length_mm: float, time_s: float) -> float:
        """The middle of the feeds that give the time, so that rounding F does not tip it over."""
        return self._middle_feed(length_mm, round(time_s / self.servo_period_s))

    def _middle_feed(self, length_mm: float, periods: int) -> float:
        """The feed in the middle, by time, of all feeds that take this many periods."""
        period = self.servo_period_s
        acceleration = self.acceleration_mm_s2

        def slowest(most: int) -> float:
            """The longest trapezoid time, in periods, that LinuxCNC still runs in ``most`` of its periods."""
            low = max(most - 2.0, 2.0 * sqrt(length_mm / acceleration) / period)
            high = float(most)
            for _ in range(14):
                time = (low + high) / 2.0
                feed = speed_for_time(length_mm, time * period, acceleration)
                took = linuxcnc((length_mm,), (feed,), acceleration, period, self.ramp_s)[0][0]
                low, high = (time, high) if round(took / period) <= most else (low, time)
            return low

        late = slowest(periods)
        early = 2.0 * sqrt(length_mm / acceleration) / period
        if early < periods - 1.0:
            early = max(early, slowest(periods - 1))
        return speed_for_time(length_mm, (late + early) / 2.0 * period, acceleration)

    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        periods = max(round(time_s / self.servo_period_s), 2)
        return 4.0 * length_mm / (periods**2 - periods % 2) / self.servo_period_s**2


def interpolated(places_mm: Floats) -> Floats:
    """What LinuxCNC's joint interpolator makes of places in servo periods: (n,) -> (n - 2,)."""
    return (places_mm[:-2] + 4.0 * places_mm[1:-1] + places_mm[2:]) / 6.0
