"""What an axis makes of its commanded motion: the acc/dec filter of the control, and the position loop.

Both take no time from blocks and some of each stroke, and the axis comes later.  Linear acc/dec is a moving
average of the position, bell-shaped acc/dec two of them in a row, exponential acc/dec and a position loop are
lags of first order.  What they make of a motion that is even between its knots is worked out exactly at any
time: an average from the integrals of the motion, a lag from its own exponential.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.cells import cells_of
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.growing import joined
from chipbreak.text.named_tuple import NamedTuple

STILL_MM = 0.0005  # half a step of most controls: nearer to its end an axis counts as resting there
_SETTLED = 18.0  # lag times after which a lag has made up all but 1e-8 of what it was behind
_NEARLY_SETTLED = 7.0  # lag times after which it has made up all but a thousandth
_SHARP = 0.25
_PIECES = 8  # of what an average makes of a bend
_LADDER = 16  # of what a lag makes of one
_FEWEST = 4  # of both, where there is no room for more
_KNOTS_AT_ONCE = 1 << 13
_TIMES_AT_ONCE = 1 << 17  # what is worked out for so many is small beside what is kept
_SAME_S = 1e-9
_UNSEEN_S = 1e-6  # a filter as short as this: 0.1 um at 6 m/min, less than an axis resolves
_GONE = 1e-18  # a share of a motion that no longer counts


class AxisFilter(NamedTuple):
    """Moving averages over these times, at most two, and lags of first order with these times [s]."""

    averages_s: tuple[float, ...] = ()
    lags_s: tuple[float, ...] = ()

    @property
    def delay_s(self) -> float:
        """How much later the axis is where it moves evenly."""
        return sum(self.averages_s) / 2.0 + sum(self.lags_s)

    def slower(self, share: float) -> AxisFilter:
        """Every time longer by a share of it."""
        times = (tuple(time_s * (1.0 + share) for time_s in row) for row in self)
        return AxisFilter(*times)

    @property
    def settling_s(self) -> float:
        """How long a change of the command is still seen, but for a thousandth."""
        return sum(self.averages_s) + _NEARLY_SETTLED * sum(self.lags_s)

    @property
    def rest_s(self) -> float:
        """How long after the command the axis rests too."""
        return sum(self.averages_s) + _SETTLED * sum(self.lags_s)

    def late_s(self, speed_mm_s: float) -> float:
        """How long after the end of a move at this speed the axis rests at its end: within half a step."""
        late_s = sum(self.averages_s)
        behind_mm = speed_mm_s * sum(self.lags_s) * len(self.lags_s)
        if behind_mm > STILL_MM:
            late_s += sum(self.lags_s) * math.log(behind_mm / STILL_MM)
        return late_s

    @property
    def shifts_s(self) -> tuple[float, ...]:
        """How much later than a knot of the command its averages bend."""
        shifts: tuple[float, ...] = (0.0,)
        for average_s in self.averages_s:
            shifts += tuple(shift + average_s for shift in shifts)
        return shifts


NO_FILTER = AxisFilter()


def axis_filter(
    acc_dec: str,
    acc_dec_s: float | None,
    bell_s: float | None,
    position_gain_1_s: float | None,
    feed_forward: float,
) -> AxisFilter:
    """The filter of an axis: acc/dec of a kind and its times, then the position loop, T = (1 - FF) / Kp.

    >>> axis_filter("linear", 0.016, None, 50.0, 0.0)
    AxisFilter(averages_s=(0.016,), lags_s=(0.02,))
    """
    is_lag = acc_dec == "exponential"
    averages = [] if is_lag else [acc_dec_s or 0.0]
    averages.append(bell_s or 0.0)
    lags = [acc_dec_s or 0.0] if is_lag else []
    if position_gain_1_s is not None:
        lags.append((1.0 - feed_forward) / position_gain_1_s)
    return AxisFilter(
        tuple(a for a in averages if a > _UNSEEN_S), tuple(lag for lag in lags if lag > _UNSEEN_S)
    )


def times_to_look_at(
    time_s: Floats, place_mm: Floats, filters: Sequence[AxisFilter], step_s: float, most: float = math.inf
) -> Floats:
    """Times, (m,), between which what filters leave of a motion with knots (n,) is nearly straight.

    The knots, the bends that averages make of them, and more, at most ``step_s`` apart, until the axes rest.
    Where the motion bends sharply and a filter is shorter than these steps, they lie as dense as it asks, but
    for what is more than ``most`` in all.
    """
    rest_s = max(one.rest_s for one in filters)
    sharp_s = _sharp_bends(time_s, place_mm)
    rows = [_Later(time_s, shift) for shift in sorted({shift for one in filters for shift in one.shifts_s})]
    soon = sum(len(one.shifts_s) * len(_soon_after(one, step_s, 1.0)) for one in filters) * len(sharp_s)
    share = most / max(soon, 1)
    for one in filters:
        for shift in one.shifts_s:
            rows += [_Later(sharp_s, shift, after_s) for after_s in _soon_after(one, step_s, share)]
    end_s = float(time_s[-1]) + rest_s
    pieces = (_in_pieces(some, step_s) for some in _until(_merged(rows, time_s), end_s))
    return joined(chain(pieces, [np.array([end_s])]))


class _Later:
    """Rising times, (n,), all so much later; they are taken from the first on."""

    def __init__(self, time_s: Floats, shift_s: float, after_s: float = 0.0) -> None:
        self.time_s = time_s
        self.shift_s = shift_s
        self.after_s = after_s
        self.taken = 0

    def before(self, end_s: float) -> Floats:
        """The next ones, those that lie before a time."""
        stop = int(np.searchsorted(self.time_s, end_s - self.shift_s - self.after_s)) + 1
        found: Floats = self.time_s[self.taken : stop + 1] + self.shift_s + self.after_s
        found = found[: int(np.searchsorted(found, end_s))]
        self.taken += len(found)
        return found


def _merged(rows: Sequence[_Later], time_s: Floats) -> Iterator[Floats]:
    """All times of some rows in rising pieces, about as long as what lies between some of other times."""
    for end_s in [*time_s[_KNOTS_AT_ONCE::_KNOTS_AT_ONCE].tolist(), math.inf]:
        piece = np.concatenate([row.before(end_s) for row in rows])
        piece.sort(kind="stable")  # rows that rise, one behind the other, are merged
        yield piece


def _until(pieces: Iterable[Floats], end_s: float) -> Iterator[Floats]:
    """Rising times that come in pieces until an end, each piece with the last time of the one before.

    The end comes in the place of times next to it and behind it.
    """
    last = np.empty(0)
    for piece in pieces:
        some = np.concatenate([last, piece])
        count = int(np.searchsorted(some, end_s - _SAME_S))
        if count < len(some):
            break
        yield some
        last = some[-1:]
    else:
        some, count = last, len(last)
    yield np.append(some[:count], end_s)


def _in_pieces(bends: Floats, step_s: float) -> Floats:
    """Times, (m,), from the first of some others, (n,), to before the last, at most a step apart.

    Of times that are the same the last one counts.
    """
    between_s = np.diff(bends)
    pieces = np.maximum(np.ceil(between_s / step_s - 1e-6).astype(np.intp), 1)
    pieces[between_s <= _SAME_S] = 0
    starts = np.cumsum(pieces) - pieces
    rank = np.arange(int(pieces.sum())) - np.repeat(starts, pieces)
    between_s /= np.maximum(pieces, 1)
    return np.asarray(np.repeat(bends[:-1], pieces) + np.repeat(between_s, pieces) * rank)


def _sharp_bends(time_s: Floats, place_mm: Floats) -> Floats:
    """The knots where the speed changes by much of what it changes anywhere, the first and the last too."""
    speed = np.concatenate([[0.0], np.diff(place_mm) / np.diff(time_s), [0.0]])
    change = np.abs(np.diff(speed))
    sharp: Floats = time_s[change >= _SHARP * change.max()]
    return sharp


def _soon_after(axis: AxisFilter, step_s: float, share: float) -> list[float]:
    """How long after a sharp bend more times are needed, for filters that are over in a few steps.

    ``share``: of so many as one likes to have.
    """
    ladder = max(int(_LADDER * min(share, 1.0)), _FEWEST)
    pieces = max(int(_PIECES * min(share, 1.0)), _FEWEST)
    found = []
    for lag_s in axis.lags_s:
        if lag_s < _PIECES * step_s:
            found += [-2.0 * lag_s * math.log(1.0 - piece / ladder) for piece in range(1, ladder)]
    for average_s in axis.averages_s:
        if average_s < _PIECES * step_s:
            found += [average_s * piece / pieces for piece in range(1, pieces)]
    return found


def filtered(time_s: Floats, place_mm: Floats, axis: AxisFilter, at_s: Floats) -> Floats:
    """Where an axis really is at rising times ``at_s``, (m,), for a motion with knots (n,).

    It rests before the first knot and behind the last one.  ``at_s`` begins with the first knot; a lag takes
    its input as straight between two of these times.
    """
    x_mm = np.empty(len(at_s))
    for part, (piece_mm,) in filtered_together(time_s, [place_mm], axis, at_s):
        x_mm[part] = piece_mm
    return x_mm


def filtered_together(
    time_s: Floats, places_mm: Sequence[Floats], axis: AxisFilter, at_s: Floats
) -> Iterator[tuple[slice, list[Floats]]]:
    """:func:`filtered` of several motions with the same knots in time, some times at once.

    Each piece comes with what part of ``at_s`` it is; its first time is the last one of the piece before.
    """
    averaged = _Averaged(time_s, places_mm, axis.averages_s, float(at_s[-1]))
    lags = [[_Lag(lag_s) for lag_s in axis.lags_s] for _ in places_mm]
    for first in range(0, max(len(at_s) - 1, 1), _TIMES_AT_ONCE):
        part = slice(first, first + _TIMES_AT_ONCE + 1)
        some_s = at_s[part]
        pieces_mm = averaged.at(some_s)
        for row, own in enumerate(lags):
            for lag in own:
                pieces_mm[row] = lag.behind(some_s, pieces_mm[row], is_last=part.stop >= len(at_s))
        yield part, pieces_mm


class _Lag:
    """A lag behind a motion that comes in pieces: what it is behind is carried over."""

    def __init__(self, lag_s: float) -> None:
        self.lag_s = lag_s
        self.behind_mm = 0.0

    def behind(self, at_s: Floats, x_mm: Floats, *, is_last: bool) -> Floats:
        """What it makes of the next piece, (m,), which begins where the one before ended."""
        y_mm = _lagging(at_s, x_mm, self.lag_s, self.behind_mm)
        self.behind_mm = float(y_mm[-1]) - float(x_mm[-1])
        if not is_last:
            y_mm[-1] = x_mm[-1] + self.behind_mm  # to the last digit where the next piece begins
        return y_mm


class _Averaged:
    """Motions with the same knots in time, (n,), behind moving averages: from a first or second integral."""

    def __init__(
        self, time_s: Floats, places_mm: Sequence[Floats], averages_s: Sequence[float], last_s: float
    ) -> None:
        self.time_s = time_s
        self.places_mm = places_mm
        self.averages_s = averages_s
        if not averages_s:
            return
        # What is integrated is small: the way from a motion at an even speed.
        span_s = float(time_s[-1] - time_s[0])
        self.speeds_mm_s = [float(place_mm[-1] - place_mm[0]) / span_s for place_mm in places_mm]
        reach_s = sum(averages_s)
        last_s = max(last_s, float(time_s[-1])) + reach_s
        knots_s = np.concatenate([[time_s[0] - 2.0 * reach_s], time_s, [last_s]])
        self.integrals = []
        for place_mm, speed_mm_s in zip(places_mm, self.speeds_mm_s, strict=True):
            knots_mm = np.concatenate([place_mm[:1], place_mm, place_mm[-1:]]) - place_mm[0]
            knots_mm -= speed_mm_s * (knots_s - time_s[0])
            self.integrals.append(_Integral(knots_s, knots_mm, is_twofold=len(averages_s) > 1))

    def at(self, at_s: Floats) -> list[Floats]:
        """Where each is at times, (m,)."""
        if not self.averages_s:
            return [np.interp(at_s, self.time_s, place_mm) for place_mm in self.places_mm]
        since_s = at_s - self.time_s[0] - sum(self.averages_s) / 2.0
        means = _means(self.integrals, at_s, self.averages_s)
        return [
            mean + (place_mm[0] + speed_mm_s * since_s)
            for mean, place_mm, speed_mm_s in zip(means, self.places_mm, self.speeds_mm_s, strict=True)
        ]


class _Cells(NamedTuple):
    """Between which knots some times lie, and how long after the first of these [s]; (m,) each."""

    cell: NDArray[np.intp]
    since_s: Floats

    @classmethod
    def of(cls, knots_s: Floats, at_s: Floats) -> _Cells:
        """Those of times that lie near each other."""
        cell = cells_of(knots_s, at_s)
        return cls(cell, at_s - knots_s[cell])


class _Integral:
    """The first integral of a motion that is straight between knots, (n,), and where asked the second."""

    def __init__(self, time_s: Floats, place_mm: Floats, *, is_twofold: bool) -> None:
        self.time_s = time_s
        self.place_mm = place_mm
        step_s = np.diff(time_s)
        self.slope = np.diff(place_mm) / step_s
        once = step_s * (place_mm[:-1] + place_mm[1:]) / 2.0
        self.first = np.append(0.0, np.cumsum(once))
        if is_twofold:
            twice = self.first[:-1] * step_s + step_s**2 * (2.0 * place_mm[:-1] + place_mm[1:]) / 6.0
            self.second = np.append(0.0, np.cumsum(twice))

    def once(self, at: _Cells) -> Floats:
        """The integral up to times, (m,)."""
        cell, since_s = at
        once: Floats = self.first[cell] + (self.place_mm[cell] + self.slope[cell] * since_s / 2.0) * since_s
        return once

    def twice(self, at: _Cells) -> Floats:
        """The integral of the integral up to times, (m,)."""
        cell, since_s = at
        bend = self.place_mm[cell] / 2.0 + self.slope[cell] * since_s / 6.0
        twice: Floats = self.second[cell] + (self.first[cell] + bend * since_s) * since_s
        return twice


def _means(integrals: Sequence[_Integral], at_s: Floats, averages_s: Sequence[float]) -> list[Floats]:
    """What one or two moving averages leave of motions with the same knots at times, (m,) each."""
    knots_s = integrals[0].time_s
    now = _Cells.of(knots_s, at_s)
    one_s = averages_s[0]
    before = _Cells.of(knots_s, at_s - one_s)
    if len(averages_s) == 1:
        return [(integral.once(now) - integral.once(before)) / one_s for integral in integrals]
    other_s = averages_s[1]
    other = _Cells.of(knots_s, at_s - other_s)
    both = _Cells.of(knots_s, at_s - one_s - other_s)
    return [
        ((one.twice(now) - one.twice(before)) - (one.twice(other) - one.twice(both))) / (one_s * other_s)
        for one in integrals
    ]


def _lagging(at_s: Floats, x_mm: Floats, lag_s: float, behind_mm: float = 0.0) -> Floats:
    """What a lag of first order makes of a motion with knots (m,); ``behind_mm`` is y - x at the first.

    How far it is behind, y - x, goes down by exp(-h / T) in a step of h and grows by what x moves; all steps
    are added up at once, each round over twice as many.
    """
    step_s = np.diff(at_s)
    left = np.exp(-step_s / lag_s)
    behind = np.diff(x_mm) / step_s * (lag_s * np.expm1(-step_s / lag_s))
    behind[:1] += behind_mm * left[:1]
    width = 1
    while width < len(left) and left.max() > _GONE:
        behind[width:] += left[width:] * behind[:-width]
        left[width:] *= left[:-width]
        left[:width] = 0.0
        width *= 2
    return np.append(x_mm[0] + behind_mm, x_mm[1:] + behind)
