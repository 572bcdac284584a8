"""The factor on the feeds of blocks in a row with which they take the wanted time.

A control runs through the joints of such blocks, so how long they take is found by trying: many factors, and
many stretches, at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.linuxcnc_stretches import can_run_many, middle_feeds, run_many
from chipbreak.trajectory.model import ControlModel
from chipbreak.trajectory.planner import feed_for_time, predict, refuse_too_fast
from chipbreak.units import MS_PER_S

Floats = NDArray[np.float64]
_TRIED = np.geomspace(0.5, 20.0, 75)
_TRIED_BETWEEN, _COARSE = 40, 5
_ROWS_AT_ONCE = 1 << 13
_SAME_S = 1e-9
_MOST_KNOWN = 1 << 16


class Stretch(NamedTuple):
    """Blocks from rest to rest: lengths, nominal feeds, the time they should take, what the axes allow."""

    lengths_mm: tuple[float, ...]
    feeds_mm_s: tuple[float, ...]
    wanted_s: float
    acceleration_mm_s2: float


def feed_factors(
    stretches: Sequence[Stretch], before_mm_s: float, model: ControlModel
) -> list[float | RefusalError]:
    """One factor for all feeds of a stretch, or why none does (VIB030).

    The factor stands in the middle of those that do, so that rounding F does not tip it over.
    ``before_mm_s`` is the feed of the block before.  Errors: VIB030 to VIB032 for what even one block over
    the whole stretch could not do.
    """
    known = _known(model)
    new = [stretch for stretch in dict.fromkeys(stretches) if (stretch, before_mm_s) not in known]
    for stretch, factor in zip(new, _new_factors(new, before_mm_s, model), strict=True):
        known[stretch, before_mm_s] = factor
    return [known[stretch, before_mm_s] for stretch in stretches]


@lru_cache(maxsize=4)
def _known(model: ControlModel) -> dict[Any, Any]:
    """What was found for this control: the cuts of a program ask for the same again and again."""
    return {}


def forget(model: ControlModel) -> None:
    """Keep no more of what was found than memory should hold."""
    if len(_known(model)) > _MOST_KNOWN:
        _known(model).clear()


def _new_factors(
    stretches: Sequence[Stretch], before_mm_s: float, model: ControlModel
) -> list[float | RefusalError]:
    for stretch in stretches:
        own = replace(model, acceleration_mm_s2=stretch.acceleration_mm_s2)
        refuse_too_fast(sum(stretch.lengths_mm), stretch.wanted_s, own)
    found: list[float | RefusalError | Floats] = []
    for stretch, late in zip(stretches, _late_of_all(stretches, before_mm_s, model), strict=True):
        hits = np.flatnonzero(np.abs(late) <= _slack_s(stretch, model))
        crossing = np.flatnonzero((late[:-1] > 0.0) & (late[1:] <= 0.0))
        if len(hits):
            widest = max(np.split(hits, np.flatnonzero(np.diff(hits) > 1) + 1), key=len)
            found.append(math.sqrt(float(_TRIED[widest[0]] * _TRIED[widest[-1]])))
        elif len(crossing):
            low, high = _TRIED[crossing[0]], _TRIED[crossing[0] + 1]
            found.append(np.geomspace(low, high, _TRIED_BETWEEN))
        else:
            found.append(_no_factor(stretch, float(late.min())))
    between = [at for at, factor in enumerate(found) if isinstance(factor, np.ndarray)]
    tried = np.array([found[at] for at in between]).reshape(len(between), _TRIED_BETWEEN)
    late_s = _late([stretches[at] for at in between], tried, before_mm_s, model)
    for at, factors, late in zip(between, tried, late_s, strict=True):
        best = np.flatnonzero(np.abs(late) <= np.abs(late).min() + _SAME_S)
        found[at] = float(factors[best[len(best) // 2]])
    return [factor for factor in found if not isinstance(factor, np.ndarray)]


def _slack_s(stretch: Stretch, model: ControlModel) -> float:
    return model.servo_period_s / 2.0 if model.law == "linuxcnc" else 0.002 * stretch.wanted_s


def _late_of_all(stretches: Sequence[Stretch], before_mm_s: float, model: ControlModel) -> Floats:
    """How much too long each stretch takes with each factor [s], (k, 75).

    A larger factor hardly ever takes longer.  So the times between two coarse factors are worked out only
    where these do not both miss by far on the same side; elsewhere that of the first of them stands for all.
    """
    coarse = np.append(np.arange(0, len(_TRIED) - 1, _COARSE), len(_TRIED) - 1)
    late_s = _late(stretches, np.tile(_TRIED[coarse], (len(stretches), 1)), before_mm_s, model)
    far_s = np.array([_slack_s(stretch, model) + 3.0 * model.servo_period_s for stretch in stretches])
    side = np.sign(late_s) * (np.abs(late_s) > far_s[:, np.newaxis])
    near = side[:, :-1] * side[:, 1:] <= 0.0
    cells = np.searchsorted(coarse, np.arange(len(_TRIED)), "right") - 1
    all_s = late_s[:, cells]
    for cell in range(len(coarse) - 1):
        rows = np.flatnonzero(near[:, cell])
        inner = np.arange(coarse[cell] + 1, coarse[cell + 1])
        some = [stretches[row] for row in rows.tolist()]
        all_s[np.ix_(rows, inner)] = _late(some, np.tile(_TRIED[inner], (len(rows), 1)), before_mm_s, model)
    return all_s


def feeds_of_single_blocks(
    lengths_mm: Floats, wanted_s: Floats, acceleration_mm_s2: Floats, model: ControlModel
) -> Floats:
    """The feed [mm/s] with which each block, from rest to rest, takes the wanted time; (k,) each.

    Errors: VIB030 to VIB032.
    """
    known = _known(model)
    keys = list(zip(lengths_mm.tolist(), wanted_s.tolist(), acceleration_mm_s2.tolist(), strict=True))
    kinds = [kind for kind in dict.fromkeys(keys) if kind not in known]
    owns = [replace(model, acceleration_mm_s2=has) for _, _, has in kinds]
    if kinds and can_run_many(model):
        for (length, wanted, _), own in zip(kinds, owns, strict=True):
            refuse_too_fast(length, wanted, own)
        columns = np.array(kinds).T
        feeds = middle_feeds(columns[0], columns[1], columns[2], model).tolist()
    else:
        feeds = [feed_for_time(kind[0], kind[1], own) for kind, own in zip(kinds, owns, strict=True)]
    known.update(zip(kinds, feeds, strict=True))
    return np.array([known[key] for key in keys])


def _no_factor(stretch: Stretch, least_late_s: float) -> RefusalError:
    message = (
        f"a stroke of {sum(stretch.lengths_mm):.4g} mm in {len(stretch.lengths_mm)} blocks takes"
        f" {(least_late_s + stretch.wanted_s) * MS_PER_S:.4g} ms"
        f" at any feed, {stretch.wanted_s * MS_PER_S:.4g} ms are wanted"
    )
    help_text = "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
    return RefusalError("VIB030", message, help_text)


def _late(stretches: Sequence[Stretch], factors: Floats, before_mm_s: float, model: ControlModel) -> Floats:
    """How much too long each stretch takes with each of its factors [s]: (k, f) -> (k, f)."""
    late_s = np.empty(factors.shape)
    if not can_run_many(model):
        for at, stretch in enumerate(stretches):
            own = replace(model, acceleration_mm_s2=stretch.acceleration_mm_s2)
            feeds = np.array(stretch.feeds_mm_s)
            took = [predict(stretch.lengths_mm, feeds * f, own, before_mm_s=before_mm_s) for f in factors[at]]
            late_s[at] = np.sum(took, axis=1) - stretch.wanted_s
        return late_s
    counts = np.array([len(stretch.lengths_mm) for stretch in stretches])
    at_once = max(1, _ROWS_AT_ONCE // factors.shape[1])
    for count in np.unique(counts):
        alike = np.flatnonzero(counts == count)
        for first in range(0, len(alike), at_once):
            some = alike[first : first + at_once]
            late_s[some] = _late_alike([stretches[at] for at in some], factors[some], before_mm_s, model)
    return late_s


def _late_alike(
    stretches: Sequence[Stretch], factors: Floats, before_mm_s: float, model: ControlModel
) -> Floats:
    """:func:`_late` where all have as many blocks."""
    tries = factors.shape[1]
    lengths = np.repeat([stretch.lengths_mm for stretch in stretches], tries, axis=0)
    feeds = np.repeat([stretch.feeds_mm_s for stretch in stretches], tries, axis=0) * factors.reshape(-1, 1)
    allowed = np.repeat([stretch.acceleration_mm_s2 for stretch in stretches], tries)
    times_s, _ = run_many(lengths, feeds, allowed, np.full(len(lengths), before_mm_s), model)
    wanted_s = np.array([[stretch.wanted_s] for stretch in stretches])
    late_s: Floats = times_s.sum(axis=1).reshape(-1, tries) - wanted_s
    return late_s
