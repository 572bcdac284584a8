"""The feeds with which the strokes of a cut really take their time on LinuxCNC.

A stroke of one block has its feed from a formula.  One of several is run through its joints: all its feeds
get one factor, found by trying, from the middle of all factors that do, so that rounding F does not tip it
over.  Strokes that hardly differ share what was found; that each of them takes its time is then looked after.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.linuxcnc_joints import Bools
from chipbreak.trajectory.linuxcnc_many import Stretches, linuxcnc_many
from chipbreak.trajectory.linuxcnc_planner import Clock
from chipbreak.trajectory.linuxcnc_runs import Counts

_TRIED = np.geomspace(0.5, 20.0, 75)
_TRIED_BETWEEN = 40
_COARSE = 5
_ROWS_AT_ONCE = 1 << 13
_SAME_S = 1e-9
_UNEVEN_PERIODS = 1.5
_SHAPED_AT_MOST = 256
_SHAPING = 4
_DAMPING = 0.7


class Wanted(NamedTuple):
    """Stretches of as many blocks each, and what is wanted of them.

    ``spans`` (m, n) is how long each block should take, ``fitted`` how many of the first blocks get their
    feeds here (the rest keep theirs), ``time`` (m,) how long these should take in all.
    """

    stretches: Stretches
    spans: Floats
    fitted: int
    time: Floats

    def rows(self, which: Counts | Bools) -> Wanted:
        """Some of them."""
        return Wanted(self.stretches.rows(which), self.spans[which], self.fitted, self.time[which])


class Found(NamedTuple):
    """Factors on the speeds, (m, n), and by how much the fitted blocks then miss their time [s], (m,)."""

    factors: Floats
    late: Floats


def factors_for(wanted: Wanted, clocks: Sequence[Clock]) -> Found:
    """Factors on the speeds of every stretch, the same for all its blocks where their shape is kept.

    With several clocks nobody knows which one it will be: the worst of them counts.
    """
    factors, late = _one_factor(wanted, clocks)
    whole = np.ones(wanted.spans.shape)
    whole[:, : wanted.fitted] = factors[:, np.newaxis]
    found = Found(whole, late)
    _shape(wanted, clocks, found)
    return found


def _one_factor(wanted: Wanted, clocks: Sequence[Clock]) -> tuple[Floats, Floats]:
    """One factor for each stretch, and by how much it misses its time."""
    late = _late_of_all(wanted, clocks)
    slack = clocks[0].period_s / 2.0
    factors = np.empty(len(late))
    between: list[tuple[int, float, float]] = []
    for row, misses in enumerate(late):
        hits = np.flatnonzero(np.abs(misses) <= slack)
        if len(hits):
            widest = max(np.split(hits, np.flatnonzero(np.diff(hits) > 1) + 1), key=len)
            factors[row] = np.sqrt(_TRIED[widest[0]] * _TRIED[widest[-1]])
            continue
        crossing = np.flatnonzero((misses[:-1] > 0.0) & (misses[1:] <= 0.0))
        at = int(crossing[0]) if len(crossing) else int(np.abs(misses).argmin())
        between.append((row, float(_TRIED[at]), float(_TRIED[min(at + 1, len(_TRIED) - 1)])))
    missed = np.zeros(len(late))
    if between:
        rows = np.array([row for row, _, _ in between])
        tried = np.array([np.geomspace(slow, fast, _TRIED_BETWEEN) for _, slow, fast in between])
        misses = _late(wanted.rows(rows), tried, clocks)
        best = np.abs(misses) <= np.abs(misses).min(axis=1, keepdims=True) + _SAME_S
        for row, factor, miss, is_best in zip(rows.tolist(), tried, misses, best, strict=True):
            near = np.flatnonzero(is_best)
            middle = near[len(near) // 2]
            factors[row] = factor[middle]
            missed[row] = miss[middle]
    return factors, missed


def _late_of_all(wanted: Wanted, clocks: Sequence[Clock]) -> Floats:
    """How much too long each stretch takes with each factor [s], (m, 75).

    A larger factor hardly ever takes longer.  So the times between two coarse factors are worked out only
    where these do not both miss by far on the same side; elsewhere that of the first of them stands for all.
    """
    coarse = np.append(np.arange(0, len(_TRIED) - 1, _COARSE), len(_TRIED) - 1)
    count = len(wanted.time)
    late = _late(wanted, np.tile(_TRIED[coarse], (count, 1)), clocks)
    side = np.sign(late) * (np.abs(late) > 3.5 * clocks[0].period_s)
    near = side[:, :-1] * side[:, 1:] <= 0.0
    cells = np.searchsorted(coarse, np.arange(len(_TRIED)), "right") - 1
    every: Floats = late[:, cells]
    for cell in range(len(coarse) - 1):
        rows = np.flatnonzero(near[:, cell])
        if len(rows):
            inner = np.arange(coarse[cell] + 1, coarse[cell + 1])
            every[np.ix_(rows, inner)] = _late(
                wanted.rows(rows), np.tile(_TRIED[inner], (len(rows), 1)), clocks
            )
    return every


def _late(wanted: Wanted, factors: Floats, clocks: Sequence[Clock]) -> Floats:
    """How much too long each stretch takes with each of its factors [s]: (m, f) -> (m, f)."""
    tries = factors.shape[1]
    at_once = max(1, _ROWS_AT_ONCE // tries)
    late = np.empty(factors.shape)
    for first in range(0, len(factors), at_once):
        some = np.arange(first, min(first + at_once, len(factors)))
        rows = wanted.rows(np.repeat(some, tries))
        speeds = rows.stretches.speeds.copy()
        speeds[:, : wanted.fitted] *= factors[some].reshape(-1, 1)
        late[some] = _worst_late(rows, speeds, clocks).reshape(-1, tries)
    return late


def _worst_late(wanted: Wanted, speeds: Floats, clocks: Sequence[Clock]) -> Floats:
    """How much too long each stretch takes at these speeds, (m,); of several clocks the worst."""
    late = [_block_times(wanted, speeds, clock).sum(axis=1) - wanted.time for clock in clocks]
    if len(late) == 1:
        return late[0]
    stacked = np.array(late)
    worst: Floats = np.take_along_axis(stacked, np.abs(stacked).argmax(axis=0)[np.newaxis], axis=0)[0]
    return worst


def _block_times(wanted: Wanted, speeds: Floats, clock: Clock) -> Floats:
    """Times of the fitted blocks, (m, fitted)."""
    until = None if wanted.fitted == wanted.spans.shape[1] else wanted.fitted
    times, _ = linuxcnc_many(wanted.stretches._replace(speeds=speeds), clock, until)
    return times[:, : wanted.fitted]


def _shape(wanted: Wanted, clocks: Sequence[Clock], found: Found) -> None:
    """Give blocks within a stretch their own times too, where they miss them by far; changes ``found``.

    A stroke so small that the tool does not turn back is a slow block between fast ones: with one factor on
    all of them the control would smooth it away, and the vibration with it.
    """
    uneven = _unevenness(wanted, wanted.stretches.speeds * found.factors, clocks)
    limit = _UNEVEN_PERIODS * clocks[0].period_s
    rows = np.flatnonzero((uneven > limit) & (np.abs(found.late) <= limit))[:_SHAPED_AT_MOST]
    if not len(rows) or wanted.fitted < 2:
        return
    some = wanted.rows(rows)
    shape = np.ones(some.spans.shape)
    best = uneven[rows]
    allowed = np.maximum(np.abs(found.late[rows]), clocks[0].period_s / 2.0) + _SAME_S
    factors = found.factors[rows]
    for _ in range(_SHAPING):
        speeds = some.stretches.speeds * factors
        ratio = _block_times(some, speeds, clocks[0]) / some.spans[:, : some.fitted]
        shape[:, : some.fitted] *= np.clip(ratio, 0.25, 4.0) ** _DAMPING
        shaped = some._replace(stretches=some.stretches._replace(speeds=some.stretches.speeds * shape))
        one, late = _one_factor(shaped, clocks)
        factors = shape.copy()
        factors[:, : some.fitted] *= one[:, np.newaxis]
        now = _unevenness(some, some.stretches.speeds * factors, clocks)
        better = (now < best) & (np.abs(late) <= allowed)
        best = np.where(better, now, best)
        found.factors[rows[better]] = factors[better]
        found.late[rows[better]] = late[better]


def _unevenness(wanted: Wanted, speeds: Floats, clocks: Sequence[Clock]) -> Floats:
    """By how much the end of any fitted block misses its time [s], (m,)."""
    ends = np.cumsum(wanted.spans[:, : wanted.fitted], axis=1)
    misses = [np.cumsum(_block_times(wanted, speeds, clock), axis=1) - ends for clock in clocks]
    worst: Floats = np.abs(np.array(misses)).max(axis=(0, 2))
    return worst
