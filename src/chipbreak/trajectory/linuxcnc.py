"""The trajectory planner of LinuxCNC 2.9 (its ``src/emc/tp/tp.c``, and measured on its simulated machine).

It decides once per servo period T (``docs/linuxcnc-timing.md``), and in a block that ends at rest

1. it speeds up by at most a·T per period, until the feed is reached;
2. it keeps the feed until it could not brake any more on v² = 2·a·(way to go);
3. it brakes by a·T per period, and the last, incomplete period counts as a whole one.

So such a block takes a whole number of periods, the trapezoid's time rounded up and sometimes one more; the
fewest are the least k with a·T²·(k² − k mod 2)/4 ≥ d.  G61, G61.1 and G64 are the same for one block per
stroke.  Several blocks per stroke run through their joints in G61 and G64 (one that would take less than
1/100 s at an even change of speed is run as such a ramp), and each of them stops in G61.1.  Each block has
the acceleration of its own direction, and less where the path bends at one of its ends.  Feed per minute and
inverse time give the same times, which depend on the highest feed override that the INI file allows; feed per
revolution joins blocks in another way, and does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import inf
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.growing import Growing
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import ControlLaw, turns_of
from chipbreak.trajectory.linuxcnc_fit import Asked, fitted_feeds
from chipbreak.trajectory.linuxcnc_joints import Bends, bends_of
from chipbreak.trajectory.linuxcnc_planner import STILL_BLENDS, Clock
from chipbreak.trajectory.linuxcnc_runs import (
    Columns,
    Parts,
    Runs,
    parts_of,
    run_all,
    single_times,
    starts_alike,
)
from chipbreak.trajectory.linuxcnc_strokes import middle_feeds
from chipbreak.trajectory.motion import Motion

# [DISPLAY] MAX_FEED_OVERRIDE of INI files; where nobody says which, a promise is kept at each of them.
USUAL_OVERRIDES = (1.0, 1.2, 1.5, 2.0)
_PERIODS_LATE = 2.0  # its joint interpolator
_PERIODS_OF_REST = 3.0
_STILL_EVEN_MM = 1e-9
_FIRST_BLOCKS = 16  # show whether the first of all runs otherwise
# There is a place for every period of a cut: worked out in pieces that stay in the processor's cache.
_PERIODS_AT_ONCE = 1 << 16
_ALONE_AT_ONCE = 1 << 12


@dataclass(frozen=True)
class LinuxCnc(ControlLaw):
    """LinuxCNC's planner and joint interpolator; ``ramp_s`` is 1/ARC_BLEND_RAMP_FREQ.

    ``max_feed_override`` is [DISPLAY] MAX_FEED_OVERRIDE, None where it is not known.  No feed is below
    ``least_feed_mm_s``: its interpreter sees to that in inverse time.
    """

    name: ClassVar[str] = "linuxcnc"
    runs_whole_periods: ClassVar[bool] = True
    unlike_stroke_costs: ClassVar[int] = 50

    ramp_s: float = 0.01
    max_feed_override: float | None = None
    least_feed_mm_s: float = 0.0

    @property
    def late_s(self) -> float:
        """See :attr:`ControlLaw.late_s`."""
        return _PERIODS_LATE * self.servo_period_s

    @property
    def dwell_delay_s(self) -> float:
        """See :attr:`ControlLaw.dwell_delay_s`: the planner finds its queue empty in the next period."""
        return self.servo_period_s

    @property
    def rest_at_crest_s(self) -> float | None:
        """See :attr:`ControlLaw.rest_at_crest_s`; with feed per revolution a block runs out at its feed.

        Points that are joined would take such a rest with them.
        """
        if self.merge_mm > 0.0:
            return None
        return _PERIODS_OF_REST * self.servo_period_s if self.per_revolution else 0.0

    def variants(self) -> tuple[LinuxCnc, ...]:
        """See :meth:`ControlLaw.variants`: one for each usual override where the profile does not say it."""
        if self.per_revolution or self.max_feed_override is not None:
            return (self,)
        return tuple(replace(self, max_feed_override=override) for override in USUAL_OVERRIDES)

    @property
    def _clock(self) -> Clock:
        override = 1.0 if self.max_feed_override is None else self.max_feed_override
        highest = inf if self.per_revolution else override
        return Clock(self.servo_period_s, self.ramp_s, highest, self.least_feed_mm_s)

    def rounded(self, time_s: float) -> float:
        """A whole number of servo periods."""
        return round(time_s / self.servo_period_s) * self.servo_period_s

    def checked(self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike) -> tuple[Floats, Floats]:
        """See :meth:`ControlLaw.checked`."""
        if self.acceleration_mm_s2 == inf:
            raise ValueError("LinuxCNC's law needs an acceleration: give it, or the axes with along()")
        return super().checked(lengths_mm, feeds_mm_s)

    def block_times(
        self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, *, before_mm_s: float = 0.0
    ) -> Floats:
        """See :meth:`ControlLaw.block_times`."""
        lengths, feeds = self.checked(lengths_mm, feeds_mm_s)
        feeds = np.maximum(feeds, self.least_feed_mm_s)
        size = len(lengths)
        even = np.full(size, self.velocity_mm_s), np.full(size, self.acceleration_mm_s2)
        turns = turns_of(lengths)
        stops = np.full(size - 1, self.every_block_stops)
        stops[turns - 1] = True
        columns = Columns(np.abs(lengths), feeds, *even)
        parts = parts_of(~stops)
        if len(parts.starts) == size and self.merge_mm == 0.0:
            # From rest to rest each: how long they take is known without the places of every period.
            times_s = single_times(columns, self._clock)
        else:
            times_s = self._runs(columns, parts, before_mm_s).times
        return np.maximum(times_s, self.read_s)

    def feeds_for_spans(self, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
        """See :meth:`ControlLaw.feeds_for_spans`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        turns = turns_of(blocks.lengths_mm)
        asked = Asked(
            self._bends(blocks), spans_s, turns, plain_from, self.every_block_stops, blocks.feed_steps_mm_s
        )
        # The others lie between the least and the highest override; the verdict looks at all of them.
        laws = dict.fromkeys([self.variants()[0], self.variants()[-1]])
        return fitted_feeds(asked, [law._clock for law in laws], _Refusals(self))

    def motion_between_dwells(self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        """See :meth:`ControlLaw.motion`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        columns, parts = self._columns(blocks, feeds_mm_s)
        runs = self._runs(columns, parts)
        time_s, knots_mm = self._knots(distance_mm, blocks.lengths_mm, parts, runs)
        return Motion(runs.times, time_s, knots_mm)

    def motions_from_rest(self, blocks: Blocks, feeds_mm_s: Floats, runs: Sequence[slice]) -> list[Motion]:
        """See :meth:`ControlLaw.motions_from_rest`; on an arc there are thousands, no two alike."""
        alone = [run.start for run in runs if run.stop - run.start == 1]
        found = dict[int, Motion]()
        for first in range(0, len(alone), _ALONE_AT_ONCE):
            some = alone[first : first + _ALONE_AT_ONCE]
            found.update(zip(some, self._motions_alone(blocks.part(some), feeds_mm_s[some]), strict=True))
        return [
            found.get(run.start) or self._motion_from_rest(blocks.part(run), feeds_mm_s[run]) for run in runs
        ]

    def _motions_alone(self, blocks: Blocks, feeds_mm_s: Floats) -> Iterator[Motion]:
        """The motion of each of some blocks by itself."""
        columns, parts = replace(self, every_block_stops=True)._columns(blocks, feeds_mm_s)
        runs = run_all(columns, parts, self._clock)
        # Each begins with rests at zero, and goes on with its ways and its end, see _knots and _bent_knots.
        sizes = runs.counts + 3
        firsts = np.cumsum(sizes) - sizes
        lasts = firsts + sizes - 1
        planned = np.zeros(int(sizes.sum()))
        is_way = np.ones(len(planned), np.bool_)
        is_way[firsts] = is_way[firsts + 1] = is_way[lasts] = False
        planned[is_way] = runs.places(0, len(sizes)) * np.repeat(np.sign(blocks.lengths_mm), runs.counts)
        planned[lasts] = blocks.lengths_mm
        places_mm = np.concatenate([[0.0], interpolated(planned), [0.0]])
        places_mm[firsts] = 0.0
        places_mm[lasts] = blocks.lengths_mm
        steps = np.diff(places_mm)
        is_knot = np.concatenate([[True], np.abs(np.diff(steps)) > _STILL_EVEN_MM, [True]])
        is_knot[firsts] = is_knot[lasts] = True
        knots = np.flatnonzero(is_knot)
        time_s = (knots - np.repeat(firsts, sizes)[knots]).astype(np.float64) * self.servo_period_s
        ends = np.searchsorted(knots, lasts, "right").tolist()
        for row, (begin, end) in enumerate(pairwise([0, *ends])):
            yield Motion(runs.times[row : row + 1], time_s[begin:end], places_mm[knots[begin:end]])

    @property
    def least_first_s(self) -> float:
        """See :attr:`ControlLaw.least_first_s`: it has not come too far when the next one is known."""
        return self._clock.periods_alone * self.servo_period_s / STILL_BLENDS

    def must_stand_before(self, blocks: Blocks, feeds_mm_s: Floats) -> bool:
        """See :meth:`ControlLaw.must_stand_before`: it hands over one block a period, and begins the first.

        Behind another move all of them wait, and know each other.
        """
        first = blocks.part(slice(0, _FIRST_BLOCKS))
        feeds = feeds_mm_s[:_FIRST_BLOCKS]
        return not all(starts_alike(*law._columns(first, feeds), law._clock) for law in self.variants())

    def _columns(self, blocks: Blocks, feeds_mm_s: Floats) -> tuple[Columns, Parts]:
        """What runs, and from where to where without a rest."""
        bends = self._bends(blocks)
        clock = self._clock
        feeds_mm_s = np.maximum(feeds_mm_s, self.least_feed_mm_s)
        joints = bends.joints(
            feeds_mm_s, clock.period_s, clock.override, every_block_stops=self.every_block_stops
        )
        columns = Columns(bends.lengths_mm, feeds_mm_s, bends.velocity_mm_s, joints.acceleration_mm_s2)
        return columns, parts_of(joints.runs_on)

    def _bends(self, blocks: Blocks) -> Bends:
        limits = [(axis.velocity_mm_s, axis.acceleration_mm_s2) for axis in self.axes] or [(inf, inf)] * 3
        velocities, accelerations = np.array(limits).T
        return bends_of(blocks, velocities, accelerations, (self.velocity_mm_s, self.acceleration_mm_s2))

    def _runs(self, columns: Columns, parts: Parts, before_mm_s: float = 0.0) -> Runs:
        """How the blocks run; where points on a line are joined, those of one feed are one."""
        if self.merge_mm > 0.0:
            return self._joined_runs(columns, parts)
        return run_all(columns, parts, self._clock, before_mm_s)

    def _joined_runs(self, columns: Columns, parts: Parts) -> Runs:
        starts = np.union1d(parts.starts, np.flatnonzero(np.diff(columns.speeds) != 0.0) + 1)
        joined = np.add.reduceat(columns.lengths, starts)
        tops, accelerations = columns.tops[starts], np.minimum.reduceat(columns.accelerations, starts)
        firsts = np.searchsorted(starts, parts.starts)
        whole = Parts(firsts, np.append(firsts[1:], len(starts)))
        own = Columns(joined, columns.speeds[starts], tops, accelerations)
        runs = run_all(own, whole, self._clock)
        shares = np.repeat(runs.times / joined, np.diff(np.append(starts, len(columns.lengths))))
        return runs._replace(times=shares * columns.lengths)

    def _knots(
        self, distance_mm: Floats, lengths_mm: Floats, parts: Parts, runs: Runs
    ) -> tuple[Floats, Floats]:
        """Every servo period behind the joint interpolator, where the motion is not even.

        The (1, 4, 1)/6 average of the interpolator blunts every reversal by a third of the planner's last
        step; its lag of two periods is left out.
        """
        turns, froms = np.sign(lengths_mm[parts.starts]), distance_mm[parts.starts]

        def planned() -> Iterator[Floats]:
            for first, last in runs.pieces(_PERIODS_AT_ONCE):
                counts = runs.counts[first:last]
                along_mm = runs.places(first, last)
                along_mm *= np.repeat(turns[first:last], counts)
                along_mm += np.repeat(froms[first:last], counts)
                yield along_mm
            yield distance_mm[-1:]

        pieces = _behind_interpolator(planned())
        return _bent_knots(pieces, float(distance_mm[-1]), self.servo_period_s)

    def _feed_for(self, length_mm: float, time_s: float) -> float:
        """The middle of the feeds that give the time, so that rounding F does not tip it over."""
        ways, times, has = (np.array([one]) for one in (length_mm, time_s, self.acceleration_mm_s2))
        return float(middle_feeds(ways, times, has, self.servo_period_s)[0])

    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        periods = max(round(time_s / self.servo_period_s), 2)
        return 4.0 * length_mm / (periods**2 - periods % 2) / self.servo_period_s**2


@dataclass(frozen=True)
class _Refusals:
    """The refusals of a law, for blocks that have an acceleration of their own."""

    law: LinuxCnc

    def too_short(self, length_mm: float, time_s: float, has_mm_s2: float) -> None:
        """See :class:`linuxcnc_fit.Refuse`."""
        self.law.with_acceleration(has_mm_s2).refuse_too_short(length_mm, time_s)

    def too_fast(self, length_mm: float, time_s: float, feed_mm_s: float) -> None:
        """See :class:`linuxcnc_fit.Refuse`."""
        raise self.law.too_fast(length_mm, time_s, feed_mm_s)


def _behind_interpolator(planned: Iterable[Floats]) -> Iterator[Floats]:
    """What the joint interpolator makes of places that come in pieces, from rest at zero."""
    last_two = np.zeros(2)
    for piece in planned:
        places_mm = np.concatenate([last_two, piece])
        last_two = places_mm[-2:]
        yield interpolated(places_mm)


def _bent_knots(pieces: Iterable[Floats], end_mm: float, period_s: float) -> tuple[Floats, Floats]:
    """Of places in servo periods, those where the motion is not even: their times and the places.

    The places begin with zero, go on with the pieces, and end with ``end_mm``; first and last are kept.
    """
    times_s, kept_mm = Growing(), Growing()
    times_s.add(np.zeros(1))
    kept_mm.add(np.zeros(1))
    at, places_mm = 0, np.zeros(1)
    for piece in chain(pieces, [np.array([end_mm])]):
        places_mm = np.concatenate([places_mm, piece])
        steps = places_mm[1:] - places_mm[:-1]
        bent = np.flatnonzero(np.abs(steps[1:] - steps[:-1]) > _STILL_EVEN_MM) + 1
        times_s.add((bent + at).astype(np.float64) * period_s)
        kept_mm.add(places_mm[bent])
        at, places_mm = at + len(places_mm) - 2, places_mm[-2:]
    times_s.add(np.array([(at + 1) * period_s]))
    kept_mm.add(places_mm[-1:])
    return times_s.whole(), kept_mm.whole()


def interpolated(places_mm: Floats) -> Floats:
    """What LinuxCNC's joint interpolator makes of places in servo periods: (n,) -> (n - 2,)."""
    return (places_mm[:-2] + 4.0 * places_mm[1:-1] + places_mm[2:]) / 6.0
