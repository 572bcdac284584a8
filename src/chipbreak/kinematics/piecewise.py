"""Motions straight between knots: where they stand, how often they turn, the height below several."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats

Indices = NDArray[np.intp]
Gaps = Iterator[tuple[Floats, Floats]]  # pairs of rising times and g_1 at those times, a piece at a time
# Many passes at many corners would fill the memory, so they are worked out some corners at a time.
_MANY_PASSES = 24
_FEW_PASSES = 8
_PLACES = 400
_HEIGHTS_AT_ONCE = 1 << 20
_SAME_SHARE = 1e-13
# So are the knots of a cut of an hour, of which there are millions.
KNOTS_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class Motion:
    """The knots of s(t), the time between two passes, and the gap that counts as a touch."""

    time_s: Floats
    distance_mm: Floats
    pass_s: float
    touch_mm: float

    def at(self, time_s: Floats) -> Floats:
        """Where the tool is [mm] at times, (n,)."""
        return np.interp(time_s, self.time_s, self.distance_mm)

    def corner_gaps(self) -> tuple[Gaps, Gaps]:
        """g_1 where it can turn: at the knots, and one pass after them."""
        return self._gaps_at_knots(), self._gaps_after_knots()

    def _gaps_at_knots(self) -> Gaps:
        for some in self.pieces():
            time_s = self.time_s[some]
            yield time_s, self.distance_mm[some] - self.at(time_s - self.pass_s)

    def _gaps_after_knots(self) -> Gaps:
        for some in self.pieces():
            later_s = self.time_s[some] + self.pass_s
            later_s = later_s[: np.searchsorted(later_s, self.time_s[-1], side="right")]
            yield later_s, self.at(later_s) - self.distance_mm[some][: later_s.size]

    def pieces(self, first: int = 0, last: int | None = None) -> Iterator[slice]:
        """The knots from ``first`` to ``last`` (exclusive; all of them without it), so many at a time."""
        end = self.time_s.size if last is None else last
        for start in range(first, end, KNOTS_AT_ONCE):
            yield slice(start, min(start + KNOTS_AT_ONCE, end))

    def corner_before(self, time_s: float) -> float:
        """The last place before a time where g_1 can turn: a knot, or one pass after a knot."""
        knot = int(np.searchsorted(self.time_s, time_s)) - 1
        near = int(np.searchsorted(self.time_s, time_s - self.pass_s))
        later_s = self.time_s[max(near - 1, 0) : near + 1] + self.pass_s
        before_s: list[float] = later_s[later_s < time_s].tolist()
        return max([float(self.time_s[knot]), *before_s])

    def peak_speed_mm_s(self) -> float:
        """The highest speed between two knots."""
        size = self.time_s.size
        steps = (slice(some.start, min(some.stop + 1, size)) for some in self.pieces(0, size - 1))
        speeds = (np.abs(np.diff(self.distance_mm[some]) / np.diff(self.time_s[some])) for some in steps)
        return max(float(some.max()) for some in speeds)

    def reversals(self) -> tuple[Indices, Indices]:
        """The knots at which the tool turns back, and those at which it goes on; a stop is no turn."""
        crests, troughs = [np.empty(0, np.intp)], [np.empty(0, np.intp)]
        last, was_forward = np.empty(0, np.intp), np.empty(0, np.bool_)  # the last move of the piece before
        for some in self.pieces(0, self.time_s.size - 1):
            steps = np.diff(self.distance_mm[some.start : some.stop + 1])
            moving = np.flatnonzero(np.abs(steps) > self.touch_mm)
            forward = np.concatenate([was_forward, steps[moving] > 0.0])
            moving = np.concatenate([last, moving + some.start])
            crests.append(moving[:-1][forward[:-1] & ~forward[1:]] + 1)
            troughs.append(moving[:-1][~forward[:-1] & forward[1:]] + 1)
            last, was_forward = moving[-1:], forward[-1:]
        return np.concatenate(crests), np.concatenate(troughs)

    def thickness(self, part: tuple[float, float], passes: int) -> tuple[Floats, float, Floats, Floats]:
        """Where the thickness over so many passes can turn in a part [s], and what :func:`lowest_of` says."""
        corners, gaps = self._gaps_below(part, passes)
        return corners, *lowest_of(gaps, corners, passes, self.touch_mm)

    def peak_thickness(self, part: tuple[float, float], passes: int, known: float) -> float:
        """The greatest thickness over so many passes in a part [s], not less than one that is ``known``."""
        corners, gaps = self._gaps_below(part, passes)
        if passes >= _MANY_PASSES:
            return _peak_of_many(corners, gaps, passes, known)
        for some in _at_once(len(corners) - 1, passes):
            at = gaps(corners[some.start : some.stop + 1])
            known = highest_minimum(at[:, :-1], at[:, 1:], known)
        return known

    def _gaps_below(self, part: tuple[float, float], passes: int) -> tuple[Floats, Callable[..., Floats]]:
        """Where the thickness can turn in a part [s], (n,); the gaps, (passes, k), to each pass at k.

        With a number behind them, to one in so many passes.
        """
        low, high = np.searchsorted(self.time_s, [part[0] - passes * self.pass_s, part[1]])
        shifts = self.pass_s * np.arange(passes + 1)[:, np.newaxis]
        corners = (self.time_s[low:high] + shifts).ravel()
        corners = np.unique(np.concatenate([part, corners[(corners > part[0]) & (corners < part[1])]]))

        def gaps(time_s: Floats, every: int = 1) -> Floats:
            return self.at(time_s) - self.at(time_s - shifts[1::every])

        return corners, gaps


def _peak_of_many(corners: Floats, gaps: Callable[..., Floats], passes: int, known: float) -> float:
    """:meth:`Motion.peak_thickness` over many passes, most of which lie behind others.

    What a few of them leave is no less than what all leave: only where that is more than the thickness known
    from some places are the others asked for.
    """
    places = corners[:: max(1, len(corners) // _PLACES)]
    known = max(known, float(gaps(places).min(axis=0).max()))
    every = max(1, passes // _FEW_PASSES)
    for some in _at_once(len(corners) - 1, _FEW_PASSES):
        at = gaps(corners[some.start : some.stop + 1], every)
        most = np.maximum(at[:, :-1], at[:, 1:]).min(axis=0)
        thick = np.flatnonzero(most > known) + some.start
        for few in _at_once(len(thick), 2 * passes):
            known = highest_minimum(gaps(corners[thick[few]]), gaps(corners[thick[few] + 1]), known)
    return known


@dataclass(frozen=True, eq=False)
class Rests:
    """The knots at which the tool comes to rest between two moves, and for how long [s]; (n,) each."""

    begin: Indices
    dwell_s: Floats

    def shortest_s(self, among: Indices) -> float:
        """The shortest dwell that begins at one of the knots ``among``; 0 when there is none."""
        dwell_s = self.dwell_s[np.isin(self.begin, among)]
        return float(dwell_s.min()) if dwell_s.size else 0.0


def rests_of(time_s: Floats, distance_mm: Floats, still_mm: float) -> Rests:
    """The rests of knots (n,), between which less than ``still_mm`` is no move."""
    moving = np.flatnonzero(np.abs(np.diff(distance_mm)) > still_mm)
    gaps = np.flatnonzero(np.diff(moving) > 1)
    begin = moving[gaps] + 1
    end = moving[gaps + 1]
    return Rests(begin, time_s[end] - time_s[begin])


def mean_step_s(crest_s: Floats, vibrations: float | None = None) -> float:
    """The time from crest to crest on average, (n,) with n > 1.

    Rounded points move single crests by some base periods, and a control that counts whole servo periods
    makes vibrations of one more and one less: the commonest step is not the mean.  A step of two vibrations,
    one of them swallowed by the control, counts as two, and a wrinkle of rounding as none.

    ``vibrations`` is how many of them were meant from the first crest to the last.  Without it a step is told
    by its time, and one vibration that takes as long as two, at a corner of the path, is taken for two.
    """
    steps_s = np.diff(crest_s)
    count = 0.0 if vibrations is None else float(np.rint(vibrations))
    return float(steps_s.sum() / (count or np.rint(steps_s / np.median(steps_s)).sum()))


def lowest_of(
    heights: Callable[[Floats], Floats], corners: Floats, count: int, floor: float
) -> tuple[float, Floats, Floats]:
    """The least of ``count`` heights, (count, k) at k places, which are straight between n + 1 corners.

    Its greatest value, and for each segment from which to which share of it, (n,) each, all heights lie above
    ``floor``: nowhere unless the second is the larger one.
    """
    peak = -np.inf
    enter = np.empty(len(corners) - 1)
    leave = np.empty(len(corners) - 1)
    for part in _at_once(len(enter), count):
        at = heights(corners[part.start : part.stop + 1])
        peak = highest_minimum(at[:, :-1], at[:, 1:], peak)
        # Each height is straight, so each is above the floor before or after one place, or throughout.
        left = at[:, :-1] - floor
        right = at[:, 1:] - floor
        with np.errstate(divide="ignore", invalid="ignore"):
            place = left / (left - right)
        enter[part] = np.where(left > 0.0, 0.0, np.where(right > 0.0, place, 1.0)).max(axis=0)
        leave[part] = np.where(right > 0.0, 1.0, np.where(left > 0.0, place, 0.0)).min(axis=0)
    return peak, enter, leave


def _at_once(segments: int, heights: int) -> Iterator[slice]:
    """Segments, so many at a time as memory holds the heights of."""
    step = max(1, _HEIGHTS_AT_ONCE // heights)
    return (slice(first, first + step) for first in range(0, segments, step))


def highest_minimum(left: Floats, right: Floats, known: float) -> float:
    """Greatest value of the least of straight lines, each given at both ends of n segments: shapes (m, n).

    Not less than a value that is ``known`` already.
    """
    best = max(known, float(left.min(axis=0).max()), float(right.min(axis=0).max()))
    # Above the corners it can only stand where a line that rises crosses one that falls.
    promising = np.flatnonzero(np.maximum(left, right).min(axis=0) > best)
    left, rise = left[:, promising], (right - left)[:, promising]
    rising, falling = left.argmin(axis=0), (left + rise).argmin(axis=0)
    while left.shape[1]:
        column = np.arange(left.shape[1])
        begin, slope = left[rising, column], rise[rising, column]
        with np.errstate(divide="ignore", invalid="ignore"):
            place = (left[falling, column] - begin) / (slope - rise[falling, column])
        bound = np.where((place > 0.0) & (place < 1.0), begin + place * slope, -np.inf)
        heights = left + np.where(bound > best, place, 0.0) * rise
        least = heights.argmin(axis=0)
        lowest = heights[least, column]
        best = max(best, float(lowest.max()))
        # Where a third line lies below the crossing, it takes the place of one of the two.
        rises = rise[least, column] > 0.0
        rising, falling = np.where(rises, least, rising), np.where(rises, falling, least)
        go_on = (bound > best) & (bound - lowest > _SAME_SHARE * np.abs(bound))
        left, rise, rising, falling = left[:, go_on], rise[:, go_on], rising[go_on], falling[go_on]
    return best
