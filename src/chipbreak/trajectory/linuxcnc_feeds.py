"""The feeds with which the strokes of a cut really take their time on LinuxCNC.

A stroke of one block has its feed from a formula.  One of several is run through its joints: all its feeds
get one factor, found by trying, from the middle of all factors that do, so that rounding F does not tip it
over.  Strokes that hardly differ share what was found; that each of them takes its time is then looked after.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.linuxcnc_joints import Bools
from chipbreak.trajectory.linuxcnc_many import Stretches
from chipbreak.trajectory.linuxcnc_planner import Clock
from chipbreak.trajectory.linuxcnc_runs import Counts, times_by_clock

_TRIED = np.geomspace(0.5, 20.0, 75)
_TRIED_BETWEEN = 40
_BESIDE = np.geomspace(0.976, 1.024, 40)
_COARSE = 5
_MANY_BLOCKS = 25  # the times of fewer jump by whole periods, up and down, as factors grow
_HUGE_BLOCKS = 150
_LONG_SHARE = 1e-4  # of a time of many seconds, which it may be off
_HUGE_SHARE = 1e-3  # the same with so many blocks: the digits of their feeds make the time jump about as far
_LIKELY = (0.97, 1.6)
_HALVINGS = 16
_EDGE_HALVINGS = 2
_ROWS_AT_ONCE = 1 << 13
_FAR_PERIODS = 3.5
_FAR = 8.0  # times what a stretch may be off
_SAME_S = 1e-9
_SHAPED_AT_MOST = 256
_SHAPED_BLOCKS = 24
_MUCH_SLOWER = 0.7
_SHAPED = np.geomspace(0.75, 1.33, 24)
_SHAPING = 4
_DAMPING = 0.7


class Wanted(NamedTuple):
    """Stretches of as many blocks each, and what is wanted of them.

    ``spans`` (m, n) is how long each block should take, ``fitted`` how many of the first blocks get their
    feeds here (the rest keep theirs), ``time`` (m,) how long these should take in all.  ``steps`` (m, n) are
    those of the speeds that can be typed, None where any can.
    """

    stretches: Stretches
    spans: Floats
    fitted: int
    time: Floats
    steps: Floats | None = None

    def rows(self, which: Counts | Bools) -> Wanted:
        """Some of them."""
        steps = None if self.steps is None else self.steps[which]
        return Wanted(self.stretches.rows(which), self.spans[which], self.fitted, self.time[which], steps)

    def typed(self) -> Wanted:
        """The same at the speeds that can be typed."""
        return self._replace(
            stretches=self.stretches._replace(speeds=self.typed_speeds(self.stretches.speeds))
        )

    def typed_speeds(self, speeds: Floats) -> Floats:
        """The speeds that are typed for some, (m, n): whole steps, at least one."""
        if self.steps is None:
            return speeds
        return np.asarray(np.maximum(np.rint(speeds / self.steps), 1.0) * self.steps)


class Found(NamedTuple):
    """Factors on the speeds, (m, n), and by how much the fitted blocks then miss their time [s], (m,).

    ``never``: at any feed they take longer.
    """

    factors: Floats
    late: Floats
    never: Bools


def factors_for(wanted: Wanted, clocks: Sequence[Clock]) -> Found:
    """Factors on the speeds of every stretch, the same for all its blocks where their shape is kept.

    With several clocks nobody knows which one it will be: the worst of them counts.
    """
    factors, late, never = _one_factor(wanted, clocks)
    whole = np.ones(wanted.spans.shape)
    whole[:, : wanted.fitted] = factors[:, np.newaxis]
    found = Found(whole, late, never)
    _shape(wanted, clocks, found)
    return found


def _one_factor(wanted: Wanted, clocks: Sequence[Clock]) -> tuple[Floats, Floats, Bools]:
    """One factor for each stretch, by how much it misses its time, and whether any factor does."""
    if wanted.fitted < _MANY_BLOCKS:
        return _factor_of_all(wanted, clocks)
    factors, missed = _halved(wanted, clocks)
    never = np.zeros(len(factors), np.bool_)
    rows = np.flatnonzero(np.isnan(missed))
    if len(rows):
        factors[rows], missed[rows], never[rows] = _factor_of_all(wanted.rows(rows), clocks)
    slack = clocks[0].period_s / 2.0
    # Where none of these does, one beside them may; with thousands of blocks, that takes too long.
    rows = np.flatnonzero((np.abs(missed) > slack) & ~never & (wanted.fitted < _HUGE_BLOCKS))
    if len(rows):
        tried = factors[rows, np.newaxis] * _BESIDE
        factors[rows], missed[rows] = _narrowed(wanted, rows, tried, clocks)
        missed[rows] = np.where(np.abs(missed[rows]) <= slack, 0.0, missed[rows])
    return factors, missed, never


def _halved(wanted: Wanted, clocks: Sequence[Clock]) -> tuple[Floats, Floats]:
    """:func:`_one_factor` of stretches of many blocks, for which a larger factor takes less time.

    A round wave that never turns back has thousands of blocks, and every try runs through all of them.  NaN
    where no factor is slow enough, or fast enough.
    """
    half = clocks[0].period_s / 2.0
    time = wanted.time
    share = _HUGE_SHARE if wanted.fitted >= _HUGE_BLOCKS else _LONG_SHARE
    slack = np.maximum(half, share * time)
    # Most factors are a little above 1, so the ends of all are tried only where these do not do.
    places = np.repeat(np.log(_LIKELY), len(time)).reshape(
        2, -1
    )  # of what is too slow, and of what is too fast
    took = np.array([_late(wanted, np.arange(len(time)), np.exp(end), clocks) + time for end in places])
    for end, is_open in ((0, took[0] <= time + slack), (1, took[1] >= time - slack)):
        rows = np.flatnonzero(is_open)
        if len(rows):
            places[end, rows] = np.log(_TRIED[-end])
            took[end, rows] = _late(wanted, rows, np.exp(places[end, rows]), clocks) + time[rows]
    within = (took[0] > time + slack) & (took[1] < time - slack)
    factors, missed = np.ones(len(time)), np.where(within, np.inf, np.nan)
    rows = np.flatnonzero(within)
    for _ in range(_HALVINGS):
        if not len(rows):
            break
        # Time is about one over the factor, so both are taken as logarithms; never too near to an end.
        share = np.log(took[0, rows] / time[rows]) / np.log(took[0, rows] / took[1, rows])
        tried = places[0, rows] + np.clip(share, 0.1, 0.9) * (places[1, rows] - places[0, rows])
        every = _late_by_clock(wanted, rows, np.exp(tried), clocks)
        late = _worst(every)
        better = np.abs(late) < np.abs(missed[rows])
        factors[rows[better]], missed[rows[better]] = np.exp(tried[better]), late[better]
        side = (late < 0.0).astype(np.intp)
        hit = np.abs(late) <= slack[rows]
        places[side[~hit], rows[~hit]] = tried[~hit]
        took[side[~hit], rows[~hit]] = (late + time[rows])[~hit]
        # What is far too slow by one clock and far too fast by another is so with any factor.
        apart = (every.max(axis=0) > _FAR * slack[rows]) & (every.min(axis=0) < -_FAR * slack[rows])
        rows = rows[~hit & ~apart]
    hits = np.flatnonzero((np.abs(missed) <= half) & (slack <= half))
    if len(hits):
        middle = _middle_of_hits(
            wanted, hits, (places[0, hits], np.log(factors[hits]), places[1, hits]), clocks
        )
        is_one = np.abs(_late(wanted, hits, np.exp(middle), clocks)) <= half
        factors[hits[is_one]] = np.exp(middle[is_one])
        missed[hits] = 0.0
    return factors, missed


def _middle_of_hits(
    wanted: Wanted, rows: Counts, around: tuple[Floats, Floats, Floats], clocks: Sequence[Clock]
) -> Floats:
    """The middle of the factors that do: ``around`` are one that is too slow, one that does, one too fast."""
    slow, found, fast = around
    slack = clocks[0].period_s / 2.0
    inside = np.concatenate([found, found])
    outside = np.concatenate([slow, fast])
    both = np.concatenate([rows, rows])
    for _ in range(_EDGE_HALVINGS):
        middle = (inside + outside) / 2.0
        hit = np.abs(_late(wanted, both, np.exp(middle), clocks)) <= slack
        inside, outside = np.where(hit, middle, inside), np.where(hit, outside, middle)
    ends = inside.reshape(2, -1)
    return np.asarray(ends.mean(axis=0))


def _factor_of_all(wanted: Wanted, clocks: Sequence[Clock]) -> tuple[Floats, Floats, Bools]:
    """:func:`_one_factor` from the times with every factor."""
    late = _late_of_all(wanted, clocks)
    slack = clocks[0].period_s / 2.0
    ends = np.array([_between(misses, slack) for misses in late]).reshape(-1, 2)
    factors = np.sqrt(ends.prod(axis=1))
    # A larger factor hardly ever takes longer: so what lies between two that do may not do.
    missed = _late(wanted, np.arange(len(late)), factors, clocks)
    rows = np.flatnonzero((np.abs(missed) > slack) | (np.abs(late).min(axis=1) > slack))
    if len(rows):
        tried = np.geomspace(ends[rows, 0], ends[rows, 1], _TRIED_BETWEEN, axis=1)
        factors[rows], missed[rows] = _narrowed(wanted, rows, tried, clocks)
    return factors, np.where(np.abs(missed) <= slack, 0.0, missed), late.min(axis=1) > slack


def _between(misses: Floats, slack: float) -> tuple[float, float]:
    """The ends of the longest run of factors that do.

    Where none of those tried does: two neighbours, the first of which is too slow and the second too fast.
    """
    hits = np.flatnonzero(np.abs(misses) <= slack)
    if len(hits):
        widest = _longest_run(hits)
        return float(_TRIED[widest[0]]), float(_TRIED[widest[-1]])
    crossing = np.flatnonzero((misses[:-1] > 0.0) & (misses[1:] <= 0.0))
    at = int(crossing[0]) if len(crossing) else int(np.abs(misses).argmin())
    return float(_TRIED[at]), float(_TRIED[min(at + 1, len(_TRIED) - 1)])


def _longest_run(places: Counts) -> Counts:
    """The longest run of whole numbers that follow each other, (k,) of (n,) that rise."""
    return max(np.split(places, np.flatnonzero(np.diff(places) > 1) + 1), key=len)


def _narrowed(wanted: Wanted, rows: Counts, tried: Floats, clocks: Sequence[Clock]) -> tuple[Floats, Floats]:
    """The best of the factors in between: the middle of the longest run of those that miss it as little.

    Every third is tried, and those beside one that misses it by hardly more than the best.
    """
    count = tried.shape[1]
    late = np.full(tried.shape, np.nan)

    def look(at: Counts, columns: Counts) -> None:
        late[at, columns] = _late(wanted, rows[at], tried[at, columns], clocks)

    every_third = np.arange(1, count, 3)
    look(np.repeat(np.arange(len(rows)), len(every_third)), np.tile(every_third, len(rows)))
    misses = np.abs(late)
    least = np.nanmin(misses, axis=1, keepdims=True)
    near = misses <= least + clocks[0].period_s + _SAME_S
    beside = np.zeros(tried.shape, np.bool_)
    beside[:, 1:] |= near[:, :-1]
    beside[:, :-1] |= near[:, 1:]
    look(*np.nonzero(beside))
    runs = map(_best_run, late)
    middles = [run[np.abs(run - (run[0] + run[-1]) / 2.0).argmin()] for run in runs]
    own = np.arange(len(rows)), np.array(middles)
    return tried[own], late[own]


def _best_run(late: Floats) -> Counts:
    """The longest run of columns that miss their time as little, of those that are known, (n,)."""
    known = np.flatnonzero(~np.isnan(late))
    misses = np.abs(late[known])
    best = np.flatnonzero(misses <= misses.min() + _SAME_S)
    runs = np.split(best, np.flatnonzero(np.diff(best) > 1) + 1)
    longest = max(runs, key=lambda run: known[run[-1]] - known[run[0]])
    return np.asarray(known[longest])


def _late_of_all(wanted: Wanted, clocks: Sequence[Clock]) -> Floats:
    """How much too long each stretch takes with each factor [s], (m, 75).

    A larger factor hardly ever takes longer.  So the times between two coarse factors are worked out only
    where these do not both miss by far on the same side; elsewhere that of the first of them stands for all.
    """
    coarse = np.append(np.arange(0, len(_TRIED) - 1, _COARSE), len(_TRIED) - 1)
    rows = np.arange(len(wanted.time))
    many = np.repeat(rows, len(coarse))
    late = _late(wanted, many, np.tile(_TRIED[coarse], len(rows)), clocks).reshape(len(rows), -1)
    side = np.sign(late) * (np.abs(late) > _FAR_PERIODS * clocks[0].period_s)
    near = side[:, :-1] * side[:, 1:] <= 0.0
    cells = np.searchsorted(coarse, np.arange(len(_TRIED)), "right") - 1
    every: Floats = late[:, cells]
    # All but the coarse ones of the cells that are near, in one go.
    inner = near[:, np.minimum(cells, len(coarse) - 2)] & ~np.isin(np.arange(len(_TRIED)), coarse)
    some, columns = np.nonzero(inner)
    if len(some):
        every[some, columns] = _late(wanted, some, _TRIED[columns], clocks)
    return every


def _late(wanted: Wanted, rows: Counts, factors: Floats, clocks: Sequence[Clock]) -> Floats:
    """How much too long some stretches take with a factor each [s], (k,); of several clocks the worst."""
    return _worst(_late_by_clock(wanted, rows, factors, clocks))


def _late_by_clock(wanted: Wanted, rows: Counts, factors: Floats, clocks: Sequence[Clock]) -> Floats:
    """:func:`_late` by each clock, (c, k)."""
    late = np.empty((len(clocks), len(factors)))
    for first in range(0, len(factors), _ROWS_AT_ONCE):
        some = slice(first, first + _ROWS_AT_ONCE)
        chosen = wanted.rows(rows[some])
        speeds = chosen.stretches.speeds
        speeds[:, : wanted.fitted] *= factors[some, np.newaxis]
        late[:, some] = [times.sum(axis=1) - chosen.time for times in _times(chosen, speeds, clocks)]
    return late


def _worst(late: Floats) -> Floats:
    """What is furthest from zero of each column, (k,) of (c, k)."""
    worst: Floats = np.take_along_axis(late, np.abs(late).argmax(axis=0)[np.newaxis], axis=0)[0]
    return worst


def _times(wanted: Wanted, speeds: Floats, clocks: Sequence[Clock]) -> list[Floats]:
    """Times of the fitted blocks by each clock, (m, fitted)."""
    typed = wanted.typed_speeds(speeds)
    return times_by_clock(wanted.stretches._replace(speeds=typed), clocks, wanted.fitted)


def _shape(wanted: Wanted, clocks: Sequence[Clock], found: Found) -> None:
    """Give blocks within a stretch their own times too, where a swing lies in it; changes ``found``.

    A stroke so small that the tool does not turn back is a slow block between fast ones: with one factor on
    all of them the control would smooth it away, and the vibration with it.
    """
    if wanted.fitted > _SHAPED_BLOCKS:
        return  # so many are points of a round wave, which slows down by itself
    rows = np.flatnonzero(_swings(wanted))[:_SHAPED_AT_MOST]
    if len(rows):
        uneven = _unevenness(wanted.rows(rows), (wanted.stretches.speeds * found.factors)[rows], clocks)
        rows = rows[uneven > clocks[0].period_s]
    if not len(rows):
        return
    some = wanted.rows(rows)
    shape = found.factors[rows].copy()
    best = _unevenness(some, some.stretches.speeds * found.factors[rows], clocks)
    allowed = np.maximum(np.abs(found.late[rows]), clocks[0].period_s / 2.0) + _SAME_S
    factors = found.factors[rows]
    every = np.arange(len(rows))
    for _ in range(_SHAPING):
        speeds = some.stretches.speeds * factors
        ratio = _times(some, speeds, clocks[:1])[0] / some.spans[:, : some.fitted]
        shape[:, : some.fitted] *= np.clip(ratio, 0.25, 4.0) ** _DAMPING
        shaped = some._replace(stretches=some.stretches._replace(speeds=some.stretches.speeds * shape))
        one, late = _narrowed(shaped, every, np.tile(_SHAPED, (len(every), 1)), clocks)
        factors = shape.copy()
        factors[:, : some.fitted] *= one[:, np.newaxis]
        now = _unevenness(some, some.stretches.speeds * factors, clocks)
        better = (now < best) & (np.abs(late) <= allowed)
        if not better.any():
            break
        best = np.where(better, now, best)
        found.factors[rows[better]] = factors[better]
        found.late[rows[better]] = late[better]


def _swings(wanted: Wanted) -> Bools:
    """Which stretches get much slower and faster again, (m,)."""
    speeds = wanted.stretches.speeds
    before = np.maximum.accumulate(speeds, axis=1)
    behind = np.maximum.accumulate(speeds[:, ::-1], axis=1)[:, ::-1]
    return np.asarray((speeds < _MUCH_SLOWER * np.minimum(before, behind)).any(axis=1))


def _unevenness(wanted: Wanted, speeds: Floats, clocks: Sequence[Clock]) -> Floats:
    """By how much the end of any fitted block misses its time [s], (m,)."""
    ends = np.cumsum(wanted.spans[:, : wanted.fitted], axis=1)
    misses = [np.cumsum(times, axis=1) - ends for times in _times(wanted, speeds, clocks)]
    worst: Floats = np.abs(np.array(misses)).max(axis=(0, 2))
    return worst
