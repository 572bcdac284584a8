"""How LinuxCNC runs all the blocks of a cut: stretch by stretch from rest to rest, those alike only once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.linuxcnc_joints import Bools
from chipbreak.trajectory.linuxcnc_many import Stretches, linuxcnc_many, passing_speeds, times_of_many
from chipbreak.trajectory.linuxcnc_planner import NOTHING, Clock, Stretch, block_times, linuxcnc, runs_alike
from chipbreak.trajectory.linuxcnc_strokes import places_of, profile_of
from chipbreak.trajectory.planner import Numbers

Counts = NDArray[np.intp]
# Fewer stretches are faster one by one, and so is a long even feed: it then takes no time.
_MANY = 60
_LONG_PERIODS = 200.0
_MOST_KEPT_BLOCKS = 128
_AT_ONCE = 1 << 15
_FACTOR = 0x9E3779B97F4A7C15  # odd, and without a pattern: its powers mix all digits of a row


class Parts(NamedTuple):
    """Stretches from rest to rest in a row: their first and behind-last blocks, (p,)."""

    starts: Counts
    stops: Counts

    @property
    def sizes(self) -> Counts:
        """How many blocks each has, (p,)."""
        return self.stops - self.starts

    def of_size(self, size: int) -> Counts:
        """Which of them have so many blocks."""
        return np.flatnonzero(self.sizes == size)

    def blocks_of(self, which: Counts, size: int) -> Counts:
        """The blocks of some of them that have ``size`` each, (m, size)."""
        return self.starts[which][:, np.newaxis] + np.arange(size)


def parts_of(runs_on: Bools) -> Parts:
    """The stretches between joints, (n - 1,), that are not run through."""
    rests = np.flatnonzero(~runs_on) + 1
    return Parts(np.append(0, rests), np.append(rests, len(runs_on) + 1))


class Columns(NamedTuple):
    """Blocks in a row, (n,): lengths, speeds, what the axes allow, what accelerations they have."""

    lengths: Floats
    speeds: Floats
    tops: Floats
    accelerations: Floats

    def stretches(self, blocks: Counts, clock: Clock, first_before: float = 0.0) -> Stretches:
        """Some parts, by their blocks (m, size); of the block before, what counts for them."""
        starts = blocks[:, 0]
        before = np.where(starts > 0, self.speeds[starts - 1], first_before)
        lengths = self.lengths[blocks]
        return Stretches(
            lengths,
            self.speeds[blocks],
            self.tops[blocks],
            self.accelerations[blocks],
            counted(before, lengths[:, 0], clock),
        )


def counted(before: Floats, lengths: Floats, clock: Clock) -> Floats:
    """The speed of the block before a stretch, as far as it counts for its first one.

    It is asked whether there was one, and with feed per revolution whether the first block is one even change
    of speed; so one of three speeds stands for all.
    """
    is_even = 2.0 * lengths < clock.ramp_s * before if clock.override == inf else before > 0.0
    return np.where(is_even, inf, np.where(before > 0.0, NOTHING, 0.0))


class Runs(NamedTuple):
    """Time of each block [s], (n,), and the way of each part after each of its periods.

    ``counts`` are the periods of each part, (p,), and ``firsts`` where its way begins in ``ways``, which has
    each kind of way once: a cut of an hour has millions of periods, and a few kinds of strokes.
    """

    times: Floats
    counts: Counts
    firsts: Counts
    ways: Floats

    def places(self, first: int, last: int) -> Floats:
        """The ways of parts ``first`` to ``last`` (exclusive), in one line."""
        each = self.counts[first:last]
        before = np.cumsum(each) - each
        source = np.repeat(self.firsts[first:last] - before, each) + np.arange(int(each.sum()))
        places: Floats = self.ways[source]
        return places

    def pieces(self, periods: int) -> list[tuple[int, int]]:
        """All parts in a row of pieces of about so many periods, as first and behind-last part."""
        done = np.cumsum(self.counts)
        cuts = np.searchsorted(done, np.arange(periods, int(done[-1]), periods)) + 1
        ends = np.unique(np.concatenate([[0], cuts, [len(done)]])).tolist()
        return list(pairwise(ends))


class _Table:
    """The ways of stretches that are alike, kept once, and which of them each part is."""

    def __init__(self, parts: int) -> None:
        self.kind = np.zeros(parts, np.intp)
        self.counts: list[Counts] = []
        self.places: list[Floats] = []
        self.size = 0

    def add(self, which: Counts, kind: Counts, counts: Counts, places: Floats) -> None:
        self.kind[which] = kind + self.size
        self.counts.append(counts)
        self.places.append(places)
        self.size += len(counts)

    def runs(self, times: Floats) -> Runs:
        counts = np.concatenate(self.counts)
        starts = np.cumsum(counts) - counts
        return Runs(times, counts[self.kind], starts[self.kind], np.concatenate(self.places))


def starts_alike(columns: Columns, parts: Parts, clock: Clock) -> bool:
    """True where the first part runs the same behind a stand as behind a rapid."""
    blocks = parts.blocks_of(np.array([0]), int(parts.sizes[0]))
    return runs_alike(_stretch(columns.stretches(blocks, clock), 0), clock)


def run_all(columns: Columns, parts: Parts, clock: Clock, before: float = 0.0) -> Runs:
    """Run every part; ``before`` is the speed of the block before the first one."""
    times = np.empty(len(columns.lengths))
    table = _Table(len(parts.starts))
    for size, which in _of_sizes(parts):
        blocks = parts.blocks_of(which, size)
        if size == 1:
            kind, counts, places = _run_single(columns, blocks[:, 0], clock)
            times[blocks[:, 0]] = counts[kind] * clock.period_s
        else:
            stretches = columns.stretches(blocks, clock, before)
            kinds, kind = kinds_of(np.column_stack(stretches))
            some, counts, places = run_stretches(stretches.rows(kinds), clock)
            times[blocks] = some[kind]
        table.add(which, kind, counts, places)
    return table.runs(times)


def single_times(columns: Columns, clock: Clock) -> Floats:
    """The time of each block, (n,), where every one runs from rest to rest."""
    speeds = np.minimum(columns.speeds, columns.tops)
    periods = profile_of(columns.lengths, speeds, columns.accelerations, clock.period_s).periods
    return np.asarray(periods * clock.period_s)


def _of_sizes(parts: Parts) -> Iterator[tuple[int, Counts]]:
    """The parts of each size, so many at a time: a long cut has millions, of few kinds."""
    for size in np.flatnonzero(np.bincount(parts.sizes)).tolist():
        every = parts.of_size(size)
        for first in range(0, len(every), _AT_ONCE):
            yield size, every[first : first + _AT_ONCE]


def _run_single(columns: Columns, blocks: Counts, clock: Clock) -> tuple[Counts, Counts, Floats]:
    """Of which kind each of some blocks is, periods of each kind, and the ways of all kinds in one line."""
    speeds = np.minimum(columns.speeds[blocks], columns.tops[blocks])
    rows = np.column_stack([columns.lengths[blocks], speeds, columns.accelerations[blocks]])
    kinds, kind = kinds_of(rows)
    counts, places = places_of(rows[kinds, 0], rows[kinds, 1], rows[kinds, 2], clock.period_s)
    return kind, counts, places


def run_stretches(stretches: Stretches, clock: Clock) -> tuple[Floats, Counts, Floats]:
    """Times of the blocks, (m, n), periods of each stretch, (m,), and its ways, in one line."""
    periods = (stretches.lengths / np.minimum(stretches.speeds, stretches.tops)).sum(axis=1) / clock.period_s
    alone = periods > _LONG_PERIODS
    if np.count_nonzero(~alone) < _MANY:
        alone[:] = True
    times = np.empty(stretches.lengths.shape)
    ways: dict[int, Floats] = {}
    for row in np.flatnonzero(alone).tolist():
        took, places = linuxcnc(_stretch(stretches, row), clock)
        times[row] = took
        ways[row] = np.array(places)
    others = np.flatnonzero(~alone)
    if len(others):
        times[others], table = linuxcnc_many(stretches.rows(others), clock)
        for row, places in zip(others.tolist(), table, strict=True):
            ways[row] = places[~np.isnan(places)]
    ordered = [ways[row] for row in range(len(times))]
    return times, np.array([len(places) for places in ordered], dtype=np.intp), np.concatenate(ordered)


def times_by_clock(stretches: Stretches, clocks: Sequence[Clock], until: int) -> list[Floats]:
    """Times of the first ``until`` blocks of stretches by each clock, (m, until).

    Where the speeds that matter are those of the first clock, its times are.
    """
    stretches = stretches.at_least(clocks[0].least_mm_s)
    first = _block_times(stretches, clocks[0], until)
    found = [first]
    passed = passing_speeds(stretches, clocks[0]) if len(clocks) > 1 else None
    for clock in clocks[1:]:
        other = np.flatnonzero((passing_speeds(stretches, clock) != passed).any(axis=1))
        times = first.copy()
        if len(other):
            times[other] = _block_times(stretches.rows(other), clock, until)
        found.append(times)
    return found


def _block_times(stretches: Stretches, clock: Clock, until: int) -> Floats:
    """Times of the first ``until`` blocks of stretches, (m, until)."""
    count = len(stretches.lengths)
    if count >= _MANY:
        return times_of_many(stretches, clock, until)
    times = block_times if stretches.lengths.shape[1] > _MOST_KEPT_BLOCKS else _kept_block_times
    return np.array([times(_stretch(stretches, row), clock)[:until] for row in range(count)])


@lru_cache(maxsize=1024)
def _kept_block_times(stretch: Stretch, clock: Clock) -> Numbers:
    """:func:`block_times`; a search looks at the same stretch again, behind others."""
    return block_times(stretch, clock)


def _stretch(stretches: Stretches, row: int) -> Stretch:
    """One of them."""
    lengths, speeds, tops, accelerations = (tuple(column[row].tolist()) for column in stretches[:4])
    return Stretch(lengths, speeds, tops, accelerations, float(stretches.before[row]))


def kinds_of(rows: Floats) -> tuple[Counts, Counts]:
    """The first of each kind of row of (m, k), and the kind of each row, (m,).

    Rows are told apart by one number made of all their digits, which is faster than by each of them.
    """
    digits = np.ascontiguousarray(rows).view(np.uint64)
    numbers = digits @ _powers(digits.shape[1])
    _, first, kind = np.unique(numbers, return_index=True, return_inverse=True)
    if not np.array_equal(digits[first][kind], digits):  # two kinds with the same number
        return _sorted_kinds(digits)
    order, place = _sorted_kinds(digits[first])
    return first[order], place[kind]


@lru_cache(maxsize=64)
def _powers(count: int) -> NDArray[np.uint64]:
    """The first powers of the factor, (count,)."""
    return np.array([pow(_FACTOR, at + 1, 1 << 64) for at in range(count)], np.uint64)


def _sorted_kinds(digits: NDArray[np.uint64]) -> tuple[Counts, Counts]:
    """:func:`kinds_of` rows of digits; the kinds rise."""
    kinds = digits.view(np.dtype((np.void, digits.dtype.itemsize * digits.shape[1])))
    _, first, kind = np.unique(kinds.ravel(), return_index=True, return_inverse=True)
    return first, kind
