"""N, f and S that break chips with the least load, near a spindle speed: what a machine can choose from.

A triangle that breaks with margin m has the stroke P = m f_r / (z D), see the waves.  Its strokes from rest
to rest need 4 d / t^2, so every choice of a command period, of a forward share and of a speed has a known
demand, and thousands of them are compared at once.  Load falls with N, but so does the number of chips: below
one vibration per revolution chips grow longer than a revolution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.speed_solver import WHOLE_WITHIN, Period, SolverRules
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

MOST_PER_REV = 4.5  # more vibrations ask for more than any axis has, and for a spindle that never droops
LEAST_PER_REV = 0.2  # a chip of five revolutions is hardly one that breaks
_SPEED_WEIGHT = 5.0  # a speed a fifth off weighs as much as chips longer by a revolution
_SAME_SHARE = 0.03  # N and f this near are one choice
_MOST = 400  # choices, the best of them


_Places = NDArray[np.intp] | NDArray[np.bool_]


class Wanted(NamedTuple):
    """The cut for which conditions are chosen: feed, programmed speed, edges, margin of the stroke.

    ``tolerance`` is how far S may go from the programmed one, as a share.  ``alpha`` is the forward share
    where it is given, else it follows N.  ``stroke_mm`` is the stroke where that is given.
    """

    feed_mm_rev: float
    speed_rpm: float
    edges: int
    margin: float
    tolerance: float
    alpha: float | None = None
    stroke_mm: float | None = None


class Limits(NamedTuple):
    """What the axes may use: acceleration [mm/s^2], speed [mm/s], and the rest at each reversal [s]."""

    acceleration_mm_s2: float
    velocity_mm_s: float
    stop_s: float = 0.0


class Conditions(NamedTuple):
    """One choice: S [rpm], N, the command period, the forward share, the stroke, and what it needs.

    ``chip_rev`` is the length of a chip of one edge, before what the air takes of it.
    """

    speed_rpm: float
    per_rev: float
    period: Period
    alpha: float
    stroke_mm: float
    acceleration_mm_s2: float
    chip_rev: float


_LEAST_RPM = 1e-9


@dataclass(frozen=True, eq=False)
class _Table:
    """Choices as columns, (n,) each; ``at`` is the place of the period."""

    at: Floats
    ticks: Floats
    forward: Floats
    period_s: Floats
    speed_rpm: Floats

    @property
    def per_rev(self) -> Floats:
        """N; of a speed that prints as zero, more than any that is allowed."""
        return S_PER_MIN / (self.period_s * np.maximum(self.speed_rpm, _LEAST_RPM))

    @property
    def alpha(self) -> Floats:
        """The forward share."""
        return self.forward / self.ticks

    def only(self, keep: _Places) -> _Table:
        """The rows for which ``keep`` holds, or those at its places."""
        columns = (self.at, self.ticks, self.forward, self.period_s, self.speed_rpm)
        return _Table(*(column[keep] for column in columns))


@dataclass(frozen=True, eq=False)
class _Demands:
    """Choices that break, with the stroke [mm] and what it needs: acceleration [mm/s^2], speed [mm/s]."""

    wanted: Wanted
    periods: Sequence[Period]
    table: _Table
    stroke_mm: Floats
    need_mm_s2: Floats
    need_mm_s: Floats

    def at(self, place: int) -> Conditions:
        """One of them."""
        per_rev = float(self.table.per_rev[place])
        return Conditions(
            speed_rpm=round(float(self.table.speed_rpm[place]), 9),
            per_rev=per_rev,
            period=self.periods[int(self.table.at[place])],
            alpha=float(self.table.alpha[place]),
            stroke_mm=float(self.stroke_mm[place]),
            acceleration_mm_s2=float(self.need_mm_s2[place]),
            chip_rev=self.wanted.edges / per_rev,
        )


def best_first(
    wanted: Wanted, periods: Sequence[Period], rules: SolverRules, limits: Limits
) -> list[Conditions]:
    """Choices that break chips within the limits, the best first; of those near each other only the best.

    The best has chips no longer than a revolution, or as short as the limits allow, the least acceleration,
    the nearest speed, and a stroke no larger than N at its best phase needs.  Empty where nothing stays
    within the limits: see :func:`least_demand`.
    """
    found = _all(wanted, periods, rules, limits)
    fits = found.need_mm_s2 <= limits.acceleration_mm_s2
    places = np.flatnonzero(fits & (found.need_mm_s <= limits.velocity_mm_s))
    ranked = places[np.argsort(_cost(found, limits)[places], kind="stable")]
    kinds = np.log(np.stack([found.table.per_rev[ranked], found.table.period_s[ranked]])) / _SAME_SHARE
    _, first = np.unique(np.rint(kinds), axis=1, return_index=True)
    return [found.at(place) for place in ranked[np.sort(first)[:_MOST]].tolist()]


def least_demand(
    wanted: Wanted, periods: Sequence[Period], rules: SolverRules, limits: Limits
) -> Conditions | None:
    """The choice that needs the least acceleration, whatever the limits; None where there is none at all."""
    found = _all(wanted, periods, rules, limits)
    return found.at(int(found.need_mm_s2.argmin())) if len(found.need_mm_s2) else None


def _cost(found: _Demands, limits: Limits) -> Floats:
    """What speaks against each choice: revolutions of a chip beyond one, and shares of what there is."""
    wanted = found.wanted
    chip_rev = np.maximum(1.0, wanted.edges / found.table.per_rev)
    off = np.abs(found.table.speed_rpm / wanted.speed_rpm - 1.0)
    larger = wanted.edges * found.stroke_mm / (wanted.margin * wanted.feed_mm_rev) - 1.0
    share = found.need_mm_s2 / limits.acceleration_mm_s2
    cost: Floats = chip_rev + share + _SPEED_WEIGHT * off + larger
    return cost


def _all(wanted: Wanted, periods: Sequence[Period], rules: SolverRules, limits: Limits) -> _Demands:
    """All choices with a stroke that breaks, whatever they need."""
    table = _choices(wanted, periods, rules)
    drop = _largest_drop(table.per_rev / wanted.edges, table.alpha)
    feed_mm = wanted.feed_mm_rev / wanted.edges
    with np.errstate(divide="ignore"):
        least_mm = wanted.margin * feed_mm / drop
    stroke_mm = least_mm if wanted.stroke_mm is None else np.full(len(drop), wanted.stroke_mm)
    advance_mm = wanted.feed_mm_rev / table.per_rev
    forward_mm = stroke_mm + table.alpha * advance_mm
    back_mm = stroke_mm - (1.0 - table.alpha) * advance_mm
    forward_s = table.alpha * table.period_s - limits.stop_s
    back_s = (1.0 - table.alpha) * table.period_s - limits.stop_s
    breaks = (stroke_mm * drop >= feed_mm) & (back_mm > 0.0)
    keep = np.flatnonzero(breaks & (forward_s > 0.0) & (back_s > 0.0))
    ways = ((forward_mm[keep], forward_s[keep]), (back_mm[keep], back_s[keep]))
    need = np.maximum(*(4.0 * way / time**2 for way, time in ways))
    speed = np.maximum(*(way / time for way, time in ways))
    return _Demands(wanted, periods, table.only(keep), stroke_mm[keep], need, speed)


def _choices(wanted: Wanted, periods: Sequence[Period], rules: SolverRules) -> _Table:
    """Every period with forward shares and speeds that may suit it, within the rules."""
    ticks = np.array([float(period.ticks) for period in periods])
    period_s = np.array([period.period_s for period in periods])
    at = np.arange(float(len(periods)))
    tables = []
    for forward, speed_rpm in _suits(wanted, ticks, period_s):
        speeds = np.floor(speed_rpm / rules.resolution_rpm + 0.5) * rules.resolution_rpm
        tables.append((at, ticks, np.clip(forward, 1.0, ticks - 1.0), period_s, speeds))
    table = _Table(*map(np.concatenate, zip(*tables, strict=True)))
    return table.only(_allowed(table, wanted, rules))


def _suits(wanted: Wanted, ticks: Floats, period_s: Floats) -> list[tuple[Floats, Floats]]:
    """Forward ticks and speeds [rpm] for each period: the programmed speed, and those with a favoured N."""
    programmed = np.full(len(ticks), wanted.speed_rpm)
    share = S_PER_MIN / (period_s * programmed) / wanted.edges
    matched = np.rint((1.0 - (share - np.floor(share))) * ticks)
    given = None if wanted.alpha is None else np.floor(wanted.alpha * ticks + 0.5)
    forwards = [np.ceil(ticks / 2.0), matched] if given is None else [given]
    found = [(forward, programmed) for forward in forwards]
    for whole in range(int(MOST_PER_REV)):
        # An even triangle, or the given one; below one vibration per revolution, return in a whole tick count
        # that is the revolution itself.
        forward = forwards[0]
        phase = 1.0 - np.clip(forward, 1.0, ticks - 1.0) / ticks
        found.append((forward, S_PER_MIN / (period_s * wanted.edges * (whole + phase))))
    if given is None:
        forward = ticks - np.clip(np.rint(S_PER_MIN / wanted.speed_rpm / (period_s / ticks)), 1.0, None)
        phase = 1.0 - np.clip(forward, 1.0, ticks - 1.0) / ticks
        found.append((forward, S_PER_MIN / (period_s * wanted.edges * phase)))
    return found


def _allowed(table: _Table, wanted: Wanted, rules: SolverRules) -> NDArray[np.bool_]:
    """Which choices the spindle and the tolerance allow, and of which N is not whole."""
    share = table.per_rev / wanted.edges
    most_rpm = wanted.speed_rpm * (1.0 + wanted.tolerance)
    if rules.max_rpm is not None:
        most_rpm = min(most_rpm, rules.max_rpm)
    least_rpm = max(wanted.speed_rpm * (1.0 - wanted.tolerance), rules.min_rpm, rules.resolution_rpm)
    keep: NDArray[np.bool_] = (
        (table.speed_rpm >= least_rpm)
        & (table.speed_rpm <= most_rpm)
        & (share >= LEAST_PER_REV)
        & (share <= MOST_PER_REV)
        & (np.abs(share - np.rint(share)) > WHOLE_WITHIN)
    )
    return keep


def _largest_drop(share: Floats, alpha: Floats) -> Floats:
    """:meth:`Triangle.largest_drop` of many."""
    delta = share - np.floor(share)
    return np.minimum(delta / (1.0 - alpha), (1.0 - delta) / alpha)
