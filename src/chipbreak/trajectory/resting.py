"""Laws by which the axis rests where the tool turns back, and at corners that it cannot follow at speed.

Such a law knows one stretch, the blocks from rest to rest; a vibrated cut is many thousands of them, of few
kinds.  Each kind is worked out once.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.feed_search import Stretch, feed_factors, feeds_of_single_blocks, forget
from chipbreak.trajectory.junctions import (
    CORNER_LIMIT,
    Blocks,
    Parts,
    four_digits,
    least_of_parts,
    parts_of,
)
from chipbreak.trajectory.law import ControlLaw, turns_of
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.planner import speed_for_time

_ROUNDS = 4
_PARTS_AT_ONCE = 1 << 16  # so that what is worked out for them stays in the processor's cache


class Kind(NamedTuple):
    """A stretch with its feeds; ``before_mm_s`` is the feed of the block before it, as far as it counts."""

    lengths_mm: tuple[float, ...]
    feeds_mm_s: tuple[float, ...]
    acceleration_mm_s2: float
    before_mm_s: float


class RestingLaw(ControlLaw):
    """A law that is known when one stretch is: how it runs, and how far its times may be off."""

    unlike_stroke_costs: ClassVar[int] = 15

    @abstractmethod
    def run(self, ways_mm: Floats, speeds_mm_s: Floats, before_mm_s: float) -> Floats:
        """The times of the blocks of one stretch, all above zero, (n,).

        ``before_mm_s`` is the feed of the block before the stretch.
        """

    @abstractmethod
    def knots(self, distance_mm: Floats, parts: Parts, times_s: Floats) -> tuple[Floats, Floats]:
        """Time [s] and place [mm] of each knot of the motion, (m,), from the times of its blocks, (n,)."""

    @abstractmethod
    def slack_s(self, wanted_s: float) -> float:
        """By how much a stretch may miss its time where its feeds have been found."""

    def time_step_s(self, wanted_s: float) -> float:
        """The steps in which a stroke of about this time is shared out among its parts."""
        return wanted_s * 1e-9

    def corner_shares(self, blocks: Blocks, feeds_mm_s: Floats) -> Floats:
        """Each corner as a share of what the control still runs through, (n,); 1 or more is a rest.

        In exact stop every end of a block is a rest.
        """
        if self.every_block_stops:
            return np.ones(len(blocks.corners))
        return blocks.corners / CORNER_LIMIT

    @property
    def befores_mm_s(self) -> tuple[float, ...]:
        """All that :meth:`counted` says, where these are few, and all kinds can be worked out at once."""
        return ()

    def counted(self, before_mm_s: float, length_mm: float) -> float:
        """The feed of the block before a stretch of several, as far as it counts for its first one."""
        return before_mm_s if self.per_revolution else 0.0

    def run_kinds(self, kinds: Sequence[Kind]) -> list[Floats]:
        """Each kind as :meth:`run` has it, within the limits."""
        runs = []
        for lengths_mm, feeds_mm_s, has_mm_s2, before_mm_s in kinds:
            law = self.with_acceleration(has_mm_s2)
            lengths, feeds = law.checked(lengths_mm, feeds_mm_s)
            runs.append(law._run_within_limits(lengths, feeds, before_mm_s))
        return runs

    def times_alike(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: float
    ) -> Floats:
        """Times of the blocks of stretches of n blocks each, (k, n), with an acceleration each, (k,)."""
        laws = self._laws_of(acceleration_mm_s2)
        rows = zip(acceleration_mm_s2.tolist(), lengths_mm, feeds_mm_s, strict=True)
        return np.array(
            [laws[has].block_times(ways, feeds, before_mm_s=before_mm_s) for has, ways, feeds in rows]
        )

    def single_feeds(self, lengths_mm: Floats, times_s: Floats, acceleration_mm_s2: Floats) -> list[float]:
        """:meth:`feed_for_time` of blocks with an acceleration each, (k,)."""
        laws = self._laws_of(acceleration_mm_s2)
        rows = zip(lengths_mm.tolist(), times_s.tolist(), acceleration_mm_s2.tolist(), strict=True)
        return [laws[has].feed_for_time(length, time) for length, time, has in rows]

    def _laws_of(self, acceleration_mm_s2: Floats) -> dict[float, Self]:
        """The same law with each of some accelerations, of which there are few: they have four digits."""
        return {has: self.with_acceleration(has) for has in set(acceleration_mm_s2.tolist())}

    def refuse_too_fast(self, length_mm: float, time_s: float) -> None:
        """The errors of :meth:`feed_for_time`, without a feed."""
        wanted = self.rounded(time_s)
        self.refuse_too_short(length_mm, wanted)
        # Less by two periods: no feed in the middle is that fast, so only beyond it there is need to look.
        fastest = speed_for_time(length_mm, wanted - 2.0 * self.servo_period_s, self.acceleration_mm_s2)
        if fastest > self.velocity_mm_s:
            self.feed_for_time(length_mm, time_s)

    def block_times(
        self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, *, before_mm_s: float = 0.0
    ) -> Floats:
        """See :meth:`ControlLaw.block_times`."""
        lengths, feeds = self.checked(lengths_mm, feeds_mm_s)
        times = np.empty(len(lengths))
        for first, last in self._stretches(lengths):
            before = float(feeds[first - 1]) if first else before_mm_s
            times[first:last] = self._run_within_limits(lengths[first:last], feeds[first:last], before)
        return times

    def _stretches(self, lengths_mm: Floats) -> Iterator[tuple[int, int]]:
        """First and behind-last block of each stretch from rest to rest."""
        if self.every_block_stops:
            return pairwise(range(len(lengths_mm) + 1))
        return pairwise([0, *turns_of(lengths_mm).tolist(), len(lengths_mm)])

    def _run_within_limits(self, lengths_mm: Floats, feeds_mm_s: Floats, before_mm_s: float) -> Floats:
        speeds = np.minimum(feeds_mm_s, self.velocity_mm_s)
        return np.maximum(self.run(np.abs(lengths_mm), speeds, before_mm_s), self.read_s)

    def feeds_for_spans(self, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
        """See :meth:`ControlLaw.feeds_for_spans`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        forget(self)
        # Where the control rests at a corner depends on the feeds, and the feeds on where it rests.
        shares = self.corner_shares(blocks, np.abs(blocks.lengths_mm) / spans_s)
        for _ in range(_ROUNDS):
            found = self._feeds(blocks, spans_s, shares, plain_from)
            before = shares
            shares = self.corner_shares(blocks, found)
            if np.array_equal(before >= 1.0, shares >= 1.0):
                break
            shares = np.maximum(before, shares)
        return found

    def _feeds(self, blocks: Blocks, spans_s: Floats, corner_shares: Floats, plain_from: int) -> Floats:
        """:meth:`feeds_for_spans` where it is known what corners take."""
        ways_mm = np.abs(blocks.lengths_mm)
        feeds = ways_mm / spans_s
        parts = parts_of(blocks.lengths_mm, corner_shares, plain_from)
        has_mm_s2 = self._accelerations(blocks, corner_shares, parts)
        times_s = self._times_of_parts(parts, ways_mm, spans_s, has_mm_s2)
        alone = parts.stops - parts.starts == 1
        firsts = parts.starts[alone]
        feeds[firsts] = feeds_of_single_blocks(ways_mm[firsts], times_s[alone], has_mm_s2[alone], self)
        self._fit_several(_several(parts, ways_mm, feeds, times_s, has_mm_s2), feeds)
        return feeds

    def _accelerations(self, blocks: Blocks, corner_shares: Floats, parts: Parts) -> Floats:
        """What the control has in each part, (p,)."""
        if self.acceleration_mm_s2 == np.inf or not len(parts.starts):
            return np.full(len(parts.starts), self.acceleration_mm_s2)
        least = least_of_parts(parts, blocks.acceleration_mm_s2)
        return four_digits(least)

    def _times_of_parts(self, parts: Parts, ways_mm: Floats, spans_s: Floats, has_mm_s2: Floats) -> Floats:
        """How long each part should take, (p,)."""
        times_s: list[float] = []
        done_s = late_s = 0.0
        laws = self._laws_of(has_mm_s2)
        period_s = self.servo_period_s
        for first, last, end_s in _strokes(parts, spans_s):
            # What rounding to servo periods takes from one stroke, the next one gets.
            wanted_s = self.rounded(end_s + late_s - done_s)
            if last - first == 1:
                times_s.append(wanted_s)
                done_s += wanted_s
            else:
                ways = np.add.reduceat(ways_mm[: parts.stops[last - 1]], parts.starts[first:last]).tolist()
                own = [laws[has] for has in has_mm_s2[first:last].tolist()]
                shares = self._shared_out(wanted_s, ways, own)
                times_s += shares
                for share in shares:
                    done_s += share
            later_s = done_s - end_s - late_s - period_s
            late_s += later_s if later_s > 0.0 else 0.0  # max() takes twice as long, for every stroke
        return np.array(times_s)

    def _shared_out(
        self, wanted_s: float, ways_mm: Sequence[float], laws: Sequence[ControlLaw]
    ) -> list[float]:
        """The time of each part of a stroke that rests between them: the least each needs, and by length."""
        least_s = [law.shortest_time(way) for way, law in zip(ways_mm, laws, strict=True)]
        step_s = self.time_step_s(wanted_s)
        spare = max(0, round((wanted_s - sum(least_s)) / step_s))
        given = [int(spare * way / sum(ways_mm)) for way in ways_mm]
        given[ways_mm.index(max(ways_mm))] += spare - sum(given)
        return [least + more * step_s for least, more in zip(least_s, given, strict=True)]

    def _fit_several(self, several: Sequence[tuple[slice, Stretch]], feeds: Floats) -> None:
        """Change the feeds of the parts that are several blocks, so that these take their times."""
        found: dict[tuple[Stretch, float], float | RefusalError] = {}
        kinds = list(dict.fromkeys(stretch for _, stretch in several))
        for before in self.befores_mm_s:
            factors = feed_factors(kinds, before, self)
            found |= {(kind, before): factor for kind, factor in zip(kinds, factors, strict=True)}
        for run, stretch in several:
            seen = float(feeds[run.start - 1]) if run.start else 0.0
            before = self.counted(seen, stretch.lengths_mm[0])
            if (stretch, before) not in found:
                [found[stretch, before]] = feed_factors([stretch], before, self)
            factor = found[stretch, before]
            if isinstance(factor, RefusalError):
                raise factor
            feeds[run] *= factor

    def motion_between_dwells(self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        """See :meth:`ControlLaw.commanded_motion`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        shares = self.corner_shares(blocks, feeds_mm_s)
        parts = parts_of(blocks.lengths_mm, shares, len(blocks.lengths_mm))
        has_mm_s2 = self._accelerations(blocks, shares, parts)
        times_s = self._times_in_parts(parts, np.abs(blocks.lengths_mm), feeds_mm_s, has_mm_s2)
        return Motion(times_s, *self.knots(distance_mm, parts, times_s))

    def _times_in_parts(self, parts: Parts, ways_mm: Floats, feeds_mm_s: Floats, has_mm_s2: Floats) -> Floats:
        """How long each block takes, (n,)."""
        is_alone = parts.stops - parts.starts == 1
        is_alone &= not self.every_block_stops
        times_s = np.empty(len(ways_mm))
        firsts = parts.starts[is_alone]
        times_s[firsts] = self._times_alone(ways_mm[firsts], feeds_mm_s[firsts], has_mm_s2[is_alone])
        several = Parts(parts.starts[~is_alone], parts.stops[~is_alone], parts.strokes[~is_alone])
        runs = self._runs_of_parts(several, ways_mm, feeds_mm_s, has_mm_s2[~is_alone])
        for start, stop, run in zip(several.starts.tolist(), several.stops.tolist(), runs, strict=True):
            times_s[start:stop] = run
        return times_s

    def _times_alone(self, ways_mm: Floats, feeds_mm_s: Floats, has_mm_s2: Floats) -> Floats:
        """Times of blocks from rest to rest, (n,)."""
        times_s = np.empty(len(ways_mm))
        for first in range(0, len(ways_mm), _PARTS_AT_ONCE):
            some = slice(first, first + _PARTS_AT_ONCE)
            columns = ways_mm[some, np.newaxis], feeds_mm_s[some, np.newaxis], has_mm_s2[some]
            times_s[some] = self.times_alike(*columns, 0.0)[:, 0]
        return times_s

    def _runs_of_parts(
        self, parts: Parts, ways_mm: Floats, feeds_mm_s: Floats, has_mm_s2: Floats
    ) -> list[Floats]:
        """The times of the blocks of each part; those of one kind share them."""
        ways = ways_mm.tolist()
        feeds = feeds_mm_s.tolist()
        keys: list[tuple[tuple[float, ...], tuple[float, ...], float, float]] = []
        for start, stop, has in zip(
            parts.starts.tolist(), parts.stops.tolist(), has_mm_s2.tolist(), strict=True
        ):
            if stop - start == 1:
                keys.append(((ways[start],), (feeds[start],), has, 0.0))
            else:
                before = self.counted(feeds[start - 1] if start else 0.0, ways[start])
                keys.append((tuple(ways[start:stop]), tuple(feeds[start:stop]), has, before))
        kinds = list(dict.fromkeys(keys))
        found = dict(zip(kinds, self.run_kinds([Kind(*kind) for kind in kinds]), strict=True))
        return [found[key] for key in keys]


def _several(
    parts: Parts, ways_mm: Floats, feeds_mm_s: Floats, times_s: Floats, has_mm_s2: Floats
) -> list[tuple[slice, Stretch]]:
    """The parts of several blocks: which blocks they are, and what is wanted of them."""
    several = parts.stops - parts.starts > 1
    if not several.any():
        return []
    columns = (parts.starts, parts.stops, times_s, has_mm_s2)
    ways = ways_mm.tolist()
    feeds = feeds_mm_s.tolist()
    return [
        (slice(start, stop), Stretch(tuple(ways[start:stop]), tuple(feeds[start:stop]), wanted, has))
        for start, stop, wanted, has in zip(*(column[several].tolist() for column in columns), strict=True)
    ]


def _strokes(parts: Parts, spans_s: Floats) -> Iterator[tuple[int, int, float]]:
    """First and behind-last part of each stroke, and when it should end [s]."""
    firsts = np.flatnonzero(np.diff(parts.strokes, prepend=-1)).tolist()
    if not firsts:
        return iter(())
    lasts = [*firsts[1:], len(parts.starts)]
    ends_s = np.cumsum(spans_s)[parts.stops[np.array(lasts, np.intp) - 1] - 1].tolist()
    return zip(firsts, lasts, ends_s, strict=True)
