"""Which numbers of a machine explain what was seen of one axis: every kind of control is tried.

What is unknown beside the numbers is taken out as one goes: when the control began with a group (in a trace),
and what reading the clock adds to every time (typed times).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import log, sqrt

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.machine_test.groups import Group
from chipbreak.machine_test.least_squares import Solution, least_squares
from chipbreak.machine_test.model import (
    EXACT,
    FILTER_KINDS,
    KINDS,
    NOTHING_BEHIND,
    RESTS,
    FilterKind,
    Kind,
    Limits,
    Numbers,
    commanded,
    law_of,
    places_of,
    time_s,
)
from chipbreak.machine_test.trace import Piece
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.law import ControlLaw
from chipbreak.trajectory.motion import Motion

_LOOKED_AT_S = 0.6  # of a group in a trace
_NOISE_FLOOR_MM = 0.0004  # no trace and no model is better
_COARSE_PIECES = 5
_COARSE_ROUNDS = 20
_FINE_ROUNDS = 10
_FINALISTS = 2
_TRIED = 2  # starts that are followed
_ROUGH_ROUNDS = 25
_AROUND = (0.7, 1.0, 1.4)  # times what the periods say
_CLOCK_OF_TRACE_S = 0.002  # how well a trace shows how long a group lasts
_EXPLAINED = 2.5  # squares a value below which nothing more is looked for
_FAR = 1.5  # times the least squares: no kind that is further comes closer with another filter
_ALIGNMENTS = 4
_SLOPE_S = 0.0005
_BAND = 0.15
_GENERIC = FILTER_KINDS[3]
_SORTS = tuple(one for one in FILTER_KINDS if one.averages + one.lags == 2 and one.lags)
_SHORTEST_S = 0.0008  # of a filter that is seen
_FILTER_STARTS = {
    "average_s": (0.008, 0.04),
    "bell_s": (0.01,),
    "lag_s": (0.006, 0.03),
    "second_lag_s": (0.012,),
}
_SCAN = np.exp(np.linspace(-0.16, 0.16, 65))
_FINE_SCAN = np.exp(np.linspace(-0.006, 0.006, 25))
_AS_GOOD = 2.0  # logarithms of the count by which the squares may be worse
_APART = 2.0  # standard deviations that two numbers which may both be right are apart
_LIKELY = 4.0  # by so much may a score be worse within the uncertainty


@dataclass(frozen=True, eq=False)
class AxisData:
    """What was seen of one axis: pieces of a trace, and times with how well they are known."""

    axis: str
    pieces: Sequence[Piece]
    times: Sequence[tuple[Group, float]]
    error_s: float
    are_periods: bool = False

    @property
    def coarse(self) -> AxisData:
        """A part that shows most."""
        share = max(len(self.pieces) // _COARSE_PIECES, 1)
        return AxisData(self.axis, self.pieces[::share], self.times, self.error_s)

    @property
    def as_times(self) -> AxisData:
        """How long the groups take there and back, which is all that this then holds."""
        found = [(piece.group, _period_s(piece.time_s, piece.place_mm)) for piece in self.pieces]
        periods = [(group, period_s) for group, period_s in found if period_s is not None]
        return AxisData(self.axis, (), periods, _CLOCK_OF_TRACE_S, are_periods=True)

    @property
    def count(self) -> int:
        """How many values there are."""
        return sum(int(np.count_nonzero(_is_looked_at(one))) for one in self.pieces) + len(self.times)


class Fit(NamedTuple):
    """A kind and what stands behind it, with its numbers, how uncertain each is (as a share), and a score.

    The least score is best.  ``misfit_mm`` is what is left of the traces, ``misfit_s`` of the times.
    ``rivals`` are other filters that explain the data as well.
    """

    kind: Kind
    behind: FilterKind
    numbers: dict[str, float]
    shares: dict[str, float]
    squares: float
    misfit_mm: float
    misfit_s: float
    rivals: tuple[FilterKind, ...] = ()


@dataclass(frozen=True, eq=False)
class _Model:
    """Residuals of a kind and a filter on the data of an axis, in the order of ``names``."""

    kind: Kind
    behind: FilterKind
    data: AxisData
    known: Limits
    fixed: Mapping[str, float] = field(default_factory=dict)
    offsets: dict[int, float] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        own = [number.name for number in self.kind.numbers] + list(self.behind.names)
        return [name for name in own if name not in self.fixed]

    def has(self, numbers: Floats) -> dict[str, float]:
        """All numbers by name."""
        return {**self.fixed, **dict(zip(self.names, numbers.tolist(), strict=True))}

    def residuals(self, numbers: Floats) -> Floats:
        """What is left, in standard deviations: (n,)."""
        return np.concatenate([np.zeros(0), *self.parts_of_trace(numbers), self.of_times(numbers)])

    def parts_of_trace(self, numbers: Floats) -> Iterator[Floats]:
        """What is left of each piece."""
        has = self.has(numbers)
        law = law_of(self.kind, has, self.data.axis, self.known)
        behind = self.behind.filter(has)
        for number, piece in enumerate(self.data.pieces):
            motion = _begin_of(commanded(self.kind, law, has, piece.group))
            at_s, place_mm = places_of(motion, behind)
            yield self._left(number, piece, at_s, place_mm)

    def _left(self, number: int, piece: Piece, at_s: Floats, place_mm: Floats) -> Floats:
        """What is left of a piece at the best time of its begin."""
        looked_at = _is_looked_at(piece)
        seen_s = piece.time_s[looked_at] - piece.time_s[0]
        seen_mm = piece.place_mm[looked_at]
        noise_mm = max(piece.noise_mm, _NOISE_FLOOR_MM)
        if number not in self.offsets:
            self.offsets[number] = _first_guess(seen_s, seen_mm, at_s, place_mm)
        offset_s = self.offsets[number]
        for _ in range(_ALIGNMENTS):
            left = np.interp(seen_s - offset_s, at_s, place_mm) - seen_mm
            ahead = np.interp(seen_s - offset_s + _SLOPE_S, at_s, place_mm)
            speed = (ahead - np.interp(seen_s - offset_s - _SLOPE_S, at_s, place_mm)) / (2.0 * _SLOPE_S)
            change_s = float(speed @ left) / max(float(speed @ speed), 1e-9)
            offset_s += min(max(change_s, -0.02), 0.02)
            if abs(change_s) < 1e-7:
                break
        self.offsets[number] = offset_s
        left = np.interp(seen_s - offset_s, at_s, place_mm) - seen_mm
        scaled: Floats = left / noise_mm
        return scaled

    def of_times(self, numbers: Floats) -> Floats:
        """What is left of the times, but for what the clock adds to all of them."""
        if not self.data.times:
            return np.zeros(0)
        has = self.has(numbers)
        law = law_of(self.kind, has, self.data.axis, self.known)
        if self.data.are_periods:
            return self._of_periods(law, has)
        own = np.array([time_s(self.kind, law, has, group) for group, _ in self.data.times])
        left = own - np.array([time for _, time in self.data.times])
        scaled: Floats = (left - left.mean()) / self.data.error_s
        return scaled

    def _of_periods(self, law: ControlLaw, has: Numbers) -> Floats:
        left = []
        for group, period_s in self.data.times:
            motion = commanded(self.kind, law, has, group)
            at_s = np.arange(0.0, motion.time_s[-1], _SLOPE_S)
            own_s = _period_s(at_s, np.interp(at_s, motion.time_s, motion.distance_mm)) or 0.0
            left.append((own_s - period_s) * group.strokes / 2.0)
        return np.array(left) / self.data.error_s

    def solved(self, start: Sequence[float], rounds: int) -> Solution:
        """The best numbers near a start."""
        if not self.names:
            left = self.residuals(np.zeros(0))
            return Solution(np.zeros(0), float(left @ left), np.zeros((len(left), 0)))
        return least_squares(self.residuals, start, rounds)


def _period_s(time_s: Floats, place_mm: Floats) -> float | None:
    """How long an axis takes there and back, from where it comes by on its way out; None below two of these.

    What stands behind the command makes that later and not longer.
    """
    inner = place_mm[time_s > (3.0 * time_s[0] + time_s[-1]) / 4.0]
    low, high = np.percentile(inner, (5.0, 95.0))
    band = _BAND * (high - low)
    state = np.where(
        place_mm > (low + high) / 2.0 + band, 1, np.where(place_mm < (low + high) / 2.0 - band, -1, 0)
    )
    known = np.flatnonzero(state)
    outward = known[1:][(state[known[1:]] > 0) & (state[known[:-1]] < 0)]
    if len(outward) < 2:
        return None
    level = (low + high) / 2.0 + band
    before, behind = place_mm[outward - 1], place_mm[outward]
    shares = np.clip((level - before) / np.maximum(behind - before, 1e-9), 0.0, 1.0)
    times = time_s[outward - 1] + shares * (time_s[outward] - time_s[outward - 1])
    return float((times[-1] - times[0]) / (len(times) - 1))


def _is_looked_at(piece: Piece) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    looked_at: np.ndarray[tuple[int], np.dtype[np.bool_]] = piece.time_s - piece.time_s[0] < _LOOKED_AT_S
    return looked_at


def _begin_of(motion: Motion) -> Motion:
    """The motion as far as it is looked at."""
    last = int(np.searchsorted(motion.time_s, _LOOKED_AT_S, "right")) + 1
    return motion._replace(time_s=motion.time_s[:last], distance_mm=motion.distance_mm[:last])


def _first_guess(seen_s: Floats, seen_mm: Floats, at_s: Floats, place_mm: Floats) -> float:
    """When the motion began, from where both have gone a tenth of the first stroke."""
    level = 0.1 * min(float(seen_mm.max()), float(place_mm.max()))
    return _passes_s(seen_s, seen_mm, level) - _passes_s(at_s, place_mm, level)


def _passes_s(time_s: Floats, place_mm: Floats, level_mm: float) -> float:
    """When an axis first comes by a level, between two places that may be far apart."""
    behind = max(int((place_mm > level_mm).argmax()), 1)
    before_mm, behind_mm = float(place_mm[behind - 1]), float(place_mm[behind])
    share = min(max((level_mm - before_mm) / max(behind_mm - before_mm, 1e-9), 0.0), 1.0)
    return float(time_s[behind - 1] + share * (time_s[behind] - time_s[behind - 1]))


def fits_of(data: AxisData, known: Limits, usual_model: str, only: Kind | None = None) -> list[Fit]:
    """What explains the data, the best one first; kinds that are far from it are left out.

    ``usual_model`` is what the profile says of the control: of two kinds that are as good it is taken.
    ``only`` is a kind that is known already.  First every kind is tried with a filter of every sort in
    little, on a part of the data; then the good ones with each filter; the best of these on all data.
    """
    part = data.coarse
    kinds = KINDS if only is None else (only,)
    rough = _rough_fits(part, data.as_times, known, usual_model, kinds)
    found = [fit for begin in rough for fit in _with_filters(begin, part, known)]
    found = _best_of_each(found, lambda one: (one.kind.name, one.behind.name))
    # A filter that is over before the next place is seen stands for what the model rounds.
    plain = [one for one in found if all(one.numbers[name] > _SHORTEST_S for name in one.behind.names)]
    best = _ranked(plain or found, part, usual_model)[:_FINALISTS]
    if part.count != data.count:
        fine = [_solve(one, one.behind, data, known, _FINE_ROUNDS) for one in best]
        best = _ranked(fine, data, usual_model)
    return [_doubted(best[0], best[1:], data.count), *best[1:]]


def _doubted(fit: Fit, others: Sequence[Fit], count: int) -> Fit:
    """The fit, its numbers as uncertain as what another filter says of them that explains the data as well.

    A short second acc/dec time is hardly seen beside a long first one, which then stands for both.
    """
    scale = max(1.0, fit.squares / max(count, 1))
    most = fit.squares + scale * _AS_GOOD * log(max(count, 2))
    rivals = [other for other in others if other.kind is fit.kind and other.squares <= most]
    shares = dict(fit.shares)
    for other in rivals:
        for name in shares.keys() & other.shares.keys():
            apart = abs(log(other.numbers[name] / fit.numbers[name]))
            shares[name] = max(shares[name], apart / _APART)
    return fit._replace(shares=shares, rivals=tuple(other.behind for other in rivals))


def _best_of_each(found: Sequence[Fit], sort: Callable[[Fit], Hashable]) -> list[Fit]:
    """Of each sort the one that leaves least, in the order in which the sorts were found."""
    best: dict[Hashable, Fit] = {}
    for one in found:
        other = best.get(sort(one), one)
        best[sort(one)] = min(other, one, key=lambda fit: fit.squares)
    return list(best.values())


def _ranked(found: Sequence[Fit], data: AxisData, usual_model: str) -> list[Fit]:
    scale = max(1.0, min(one.squares for one in found) / max(data.count, 1))
    return sorted(found, key=lambda one: _score(one, scale, data.count, usual_model))


def _score(fit: Fit, scale: float, count: int, usual_model: str) -> float:
    """The sum of squares, more for every number, less where it is what the profile says."""
    numbers = len(fit.numbers)
    usual = 2.0 if usual_model in fit.kind.models else 0.0
    return fit.squares / scale + (2.0 * numbers - usual) * log(max(count, 2))


def _rough_fits(
    data: AxisData, times: AxisData, known: Limits, usual_model: str, kinds: Sequence[Kind]
) -> list[Fit]:
    """The kinds that may be it, each with a filter of every sort in little.

    What the profile says is tried first.  Behind a kind that explains everything nothing more is looked for.
    """
    found: list[Fit] = []
    for kind in sorted(kinds, key=lambda kind: usual_model not in kind.models or kind is EXACT):
        found += _rough_fits_of(kind, data, times, known)
        if min(one.squares for one in found) <= _EXPLAINED * data.count and data.pieces:
            break
    best = _ranked(found, data, usual_model)
    least = min(one.squares for one in found)
    near = [one for one in best if one.squares <= _FAR * least + data.count]
    names = list(dict.fromkeys(one.kind.name for one in near))[:_FINALISTS]
    return _best_of_each(
        [one for one in near if one.kind.name in names],
        lambda one: (one.kind.name, one.kind is not EXACT and one.behind.name),
    )


def _rough_fits_of(kind: Kind, data: AxisData, times: AxisData, known: Limits) -> Iterator[Fit]:
    behind = _GENERIC if data.pieces else NOTHING_BEHIND
    begin = _rough(RESTS if kind.steps else kind, behind, data, times, known)
    if kind is EXACT and data.pieces:
        yield from _with_filters(begin, data, known)
        return
    yield _scanned(kind, behind, begin.numbers, data, known) if kind.steps else begin
    if data.pieces and not kind.steps:
        yield _held(kind, data, times, known)


def _rough(kind: Kind, behind: FilterKind, data: AxisData, times: AxisData, known: Limits) -> Fit:
    """The kind from the best of its starts.

    Where there is a trace, the numbers of the kind come from how long the groups last, which no filter
    changes much: in the trace itself a wrong number is out of step, and nothing leads from there to the right
    one.
    """
    starts = {number.name: number.starts for number in kind.numbers}
    if data.pieces and starts:
        begin = _rough(kind, NOTHING_BEHIND, times, times, known)
        starts = {
            name: tuple(share * begin.numbers[name] for share in _AROUND) + starts[name] for name in starts
        }
    starts |= {name: _FILTER_STARTS[name] for name in behind.names}
    model = _Model(kind, behind, data, known)

    def squares(start: tuple[float, ...]) -> float:
        left = _Model(kind, behind, data, known).residuals(np.array(start))
        return float(left @ left)

    likely = sorted(product(*starts.values()), key=squares)[:_TRIED]
    return min((_fit(model, start, _ROUGH_ROUNDS) for start in likely), key=lambda one: one.squares)


def _held(kind: Kind, data: AxisData, times: AxisData, known: Limits) -> Fit:
    """The kind with those numbers of its own that the periods say, and what is then best behind it.

    Where all numbers are searched for together they go astray together, behind a filter of the wrong sort.
    """
    own = _rough(kind, NOTHING_BEHIND, times, times, known).numbers
    models = [_Model(kind, behind, data, known, own) for behind in _SORTS]
    starts = [[_FILTER_STARTS[name][0] for name in model.names] for model in models]
    found = (_fit(model, start, _ROUGH_ROUNDS) for model, start in zip(models, starts, strict=True))
    return min(found, key=lambda one: one.squares)


def _with_filters(begin: Fit, data: AxisData, known: Limits) -> Iterator[Fit]:
    """A kind with every filter."""
    if not data.pieces:
        yield begin
        return
    for behind in FILTER_KINDS:
        if begin.kind is not EXACT or behind is not NOTHING_BEHIND:
            yield _solve(begin, behind, data, known, _COARSE_ROUNDS)


def _solve(begin: Fit, behind: FilterKind, data: AxisData, known: Limits, rounds: int) -> Fit:
    """The kind of a fit with another filter, or on other data."""
    if begin.kind.steps:
        return _scanned(begin.kind, behind, begin.numbers, data, known)
    model = _Model(begin.kind, behind, data, known)
    start = [begin.numbers.get(name, _FILTER_STARTS.get(name, (0.01,))[0]) for name in model.names]
    return _fit(model, start, rounds)


def _scanned(kind: Kind, behind: FilterKind, begin: Numbers, data: AxisData, known: Limits) -> Fit:
    """A kind whose times jump: its acceleration is looked for step by step, what is behind it in between."""
    middle = begin["acceleration"]
    filters = {name: begin.get(name, _FILTER_STARTS[name][0]) for name in behind.names}
    squares = np.zeros(0)
    for scan in (_SCAN, _FINE_SCAN):
        squares = np.array(
            [_squares(kind, behind, data, known, filters | {"acceleration": middle * one}) for one in scan]
        )
        near = scan[squares <= squares.min() + _LIKELY * max(1.0, squares.min() / max(data.count, 1))]
        middle *= float(np.sqrt(near[0] * near[-1]))
        model = _Model(kind, behind, data, known, {"acceleration": middle})
        fit = _fit(model, [filters[name] for name in model.names], 20)
        filters = {name: fit.numbers[name] for name in behind.names}
    share = max(float(np.log(near[-1] / near[0])) / 2.0, 0.0003)
    return fit._replace(shares=fit.shares | {"acceleration": share})


def _squares(kind: Kind, behind: FilterKind, data: AxisData, known: Limits, has: Numbers) -> float:
    left = _Model(kind, behind, data, known, has).residuals(np.zeros(0))
    return float(left @ left)


def _fit(model: _Model, start: Sequence[float], rounds: int) -> Fit:
    solution = model.solved(start, rounds)
    has = model.has(solution.numbers)
    pieces = list(model.parts_of_trace(solution.numbers))
    noises = [max(piece.noise_mm, _NOISE_FLOOR_MM) for piece in model.data.pieces]
    left_mm = np.concatenate([np.zeros(0), *(p * n for p, n in zip(pieces, noises, strict=True))])
    left_s = model.of_times(solution.numbers) * model.data.error_s
    return Fit(
        model.kind,
        model.behind,
        has,
        dict(zip(model.names, _shares(solution), strict=True)),
        solution.squares,
        _rms(left_mm),
        _rms(left_s),
    )


def _shares(solution: Solution) -> list[float]:
    """The standard deviation of each number as a share of it, from how sharp the least squares are."""
    count, numbers = solution.slopes.shape
    scale = max(1.0, solution.squares / max(count - numbers, 1))
    inverse = np.linalg.pinv(solution.slopes.T @ solution.slopes) * scale
    return [sqrt(max(one, 0.0)) for one in np.diag(inverse).tolist()]


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
