"""The factor on the feeds of blocks in a row with which they take the wanted time.

A control runs through the joints of such blocks, so how long they take is found by trying: many factors, and
many stretches, at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Protocol, Self

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MS_PER_S

_TRIED = np.geomspace(0.5, 20.0, 75)
_TRIED_BETWEEN = 40
_COARSE = 5
_ROWS_AT_ONCE = 1 << 13
_SAME_S = 1e-9
_MOST_KNOWN = 1 << 16


class Stretch(NamedTuple):
    """Blocks from rest to rest: lengths, nominal feeds, the time they should take, what the axes allow."""

    lengths_mm: tuple[float, ...]
    feeds_mm_s: tuple[float, ...]
    wanted_s: float
    acceleration_mm_s2: float


class Tried(Protocol):
    """What the search asks of a law of control."""

    def __hash__(self) -> int: ...

    @property
    def servo_period_s(self) -> float:
        """How often the control decides."""

    def with_acceleration(self, acceleration_mm_s2: float) -> Self:
        """The same control where it has another acceleration."""

    def refuse_too_fast(self, length_mm: float, time_s: float) -> None:
        """Errors: VIB030 to VIB032 for what even one block could not do."""

    def slack_s(self, wanted_s: float) -> float:
        """By how much a stretch may miss its time."""

    def times_alike(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: float
    ) -> Floats:
        """Times of the blocks of stretches of n blocks each, (k, n), with an acceleration each, (k,)."""

    def single_feeds(self, lengths_mm: Floats, times_s: Floats, acceleration_mm_s2: Floats) -> list[float]:
        """The feeds with which blocks, each from rest to rest, take their times; (k,)."""


class _Between(NamedTuple):
    """Two neighbouring factors, the first of which is too slow and the second too fast."""

    slow: float
    fast: float


def feed_factors(stretches: Sequence[Stretch], before_mm_s: float, law: Tried) -> list[float | RefusalError]:
    """One factor for all feeds of a stretch, or why none does (VIB030).

    The factor stands in the middle of those that do, so that rounding F does not tip it over.
    ``before_mm_s`` is the feed of the block before.  Errors: VIB030 to VIB032 for what even one block over
    the whole stretch could not do.
    """
    known = _known(law)
    found = {stretch: known.get((stretch, before_mm_s)) for stretch in stretches}
    new = [stretch for stretch, factor in found.items() if factor is None]
    for stretch, factor in zip(new, _new_factors(new, before_mm_s, law), strict=True):
        found[stretch] = known[stretch, before_mm_s] = factor
    return [factor for factor in map(found.__getitem__, stretches) if factor is not None]


@lru_cache(maxsize=4)
def _known(law: Tried) -> dict[Any, Any]:
    """What was found for this control: the cuts of a program ask for the same again and again.

    Another thread may forget it at any time, so that whoever asks keeps what was answered.
    """
    return {}


def forget(law: Tried) -> None:
    """Keep no more of what was found than memory should hold."""
    if len(_known(law)) > _MOST_KNOWN:
        _known(law).clear()


def _new_factors(stretches: Sequence[Stretch], before_mm_s: float, law: Tried) -> list[float | RefusalError]:
    own = {has: law.with_acceleration(has) for has in {stretch.acceleration_mm_s2 for stretch in stretches}}
    for stretch in stretches:
        own[stretch.acceleration_mm_s2].refuse_too_fast(sum(stretch.lengths_mm), stretch.wanted_s)
    rows = zip(stretches, _late_of_all(stretches, before_mm_s, law), strict=True)
    found = [_among_tried(stretch, late_s, law) for stretch, late_s in rows]
    open_ones = [(s, f) for s, f in zip(stretches, found, strict=True) if isinstance(f, _Between)]
    narrowed = iter(_narrowed(open_ones, before_mm_s, law))
    return [next(narrowed) if isinstance(factor, _Between) else factor for factor in found]


def _among_tried(stretch: Stretch, late_s: Floats, law: Tried) -> float | _Between | RefusalError:
    """The middle of the longest run of tried factors that do, else where the times cross the wanted one."""
    hits = np.flatnonzero(np.abs(late_s) <= law.slack_s(stretch.wanted_s))
    if len(hits):
        widest = max(np.split(hits, np.flatnonzero(np.diff(hits) > 1) + 1), key=len)
        return math.sqrt(float(_TRIED[widest[0]] * _TRIED[widest[-1]]))
    crossing = np.flatnonzero((late_s[:-1] > 0.0) & (late_s[1:] <= 0.0))
    if len(crossing):
        return _Between(_TRIED[crossing[0]], _TRIED[crossing[0] + 1])
    return _no_factor(stretch, float(late_s.min()))


def _narrowed(open_ones: Sequence[tuple[Stretch, _Between]], before_mm_s: float, law: Tried) -> list[float]:
    """The best of the factors in between: the middle of those that miss the time by as little."""
    tried = np.array([np.geomspace(*between, _TRIED_BETWEEN) for _, between in open_ones])
    tried = tried.reshape(len(open_ones), _TRIED_BETWEEN)
    late_s = _late([stretch for stretch, _ in open_ones], tried, before_mm_s, law)
    found = []
    for factors, late in zip(tried, late_s, strict=True):
        best = np.flatnonzero(np.abs(late) <= np.abs(late).min() + _SAME_S)
        found.append(float(factors[best[len(best) // 2]]))
    return found


def _late_of_all(stretches: Sequence[Stretch], before_mm_s: float, law: Tried) -> Floats:
    """How much too long each stretch takes with each factor [s], (k, 75).

    A larger factor hardly ever takes longer.  So the times between two coarse factors are worked out only
    where these do not both miss by far on the same side; elsewhere that of the first of them stands for all.
    """
    coarse = np.append(np.arange(0, len(_TRIED) - 1, _COARSE), len(_TRIED) - 1)
    late_s = _late(stretches, np.tile(_TRIED[coarse], (len(stretches), 1)), before_mm_s, law)
    far_s = np.array([law.slack_s(stretch.wanted_s) + 3.0 * law.servo_period_s for stretch in stretches])
    side = np.sign(late_s) * (np.abs(late_s) > far_s[:, np.newaxis])
    near = side[:, :-1] * side[:, 1:] <= 0.0
    cells = np.searchsorted(coarse, np.arange(len(_TRIED)), "right") - 1
    all_s = late_s[:, cells]
    for cell in range(len(coarse) - 1):
        rows = np.flatnonzero(near[:, cell])
        inner = np.arange(coarse[cell] + 1, coarse[cell + 1])
        some = [stretches[row] for row in rows.tolist()]
        all_s[np.ix_(rows, inner)] = _late(some, np.tile(_TRIED[inner], (len(rows), 1)), before_mm_s, law)
    return all_s


def feeds_of_single_blocks(
    lengths_mm: Floats, wanted_s: Floats, acceleration_mm_s2: Floats, law: Tried
) -> Floats:
    """The feed [mm/s] with which each block, from rest to rest, takes the wanted time; (k,) each.

    Errors: VIB030 to VIB032.
    """
    known = _known(law)
    keys = list(zip(lengths_mm.tolist(), wanted_s.tolist(), acceleration_mm_s2.tolist(), strict=True))
    found = {key: known.get(key) for key in keys}
    kinds = [kind for kind, feed in found.items() if feed is None]
    if kinds:
        new = dict(zip(kinds, law.single_feeds(*np.array(kinds).T), strict=True))
        known.update(new)
        found.update(new)
    return np.array([found[key] for key in keys])


def _no_factor(stretch: Stretch, least_late_s: float) -> RefusalError:
    message = (
        f"a stroke of {sum(stretch.lengths_mm):.4g} mm in {len(stretch.lengths_mm)} blocks takes"
        f" {(least_late_s + stretch.wanted_s) * MS_PER_S:.4g} ms"
        f" at any feed, {stretch.wanted_s * MS_PER_S:.4g} ms are wanted"
    )
    help_text = "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
    return RefusalError("VIB030", message, help_text)


def _late(stretches: Sequence[Stretch], factors: Floats, before_mm_s: float, law: Tried) -> Floats:
    """How much too long each stretch takes with each of its factors [s]: (k, f) -> (k, f)."""
    late_s = np.empty(factors.shape)
    counts = np.array([len(stretch.lengths_mm) for stretch in stretches])
    at_once = max(1, _ROWS_AT_ONCE // factors.shape[1])
    for count in np.unique(counts):
        alike = np.flatnonzero(counts == count)
        for first in range(0, len(alike), at_once):
            some = alike[first : first + at_once]
            late_s[some] = _late_alike([stretches[at] for at in some], factors[some], before_mm_s, law)
    return late_s


def _late_alike(stretches: Sequence[Stretch], factors: Floats, before_mm_s: float, law: Tried) -> Floats:
    """:func:`_late` where all have as many blocks."""
    tries = factors.shape[1]
    lengths = np.repeat([stretch.lengths_mm for stretch in stretches], tries, axis=0)
    feeds = np.repeat([stretch.feeds_mm_s for stretch in stretches], tries, axis=0) * factors.reshape(-1, 1)
    allowed = np.repeat([stretch.acceleration_mm_s2 for stretch in stretches], tries)
    times_s = law.times_alike(lengths, feeds, allowed, before_mm_s)
    wanted_s = np.array([[stretch.wanted_s] for stretch in stretches])
    late_s: Floats = times_s.sum(axis=1).reshape(-1, tries) - wanted_s
    return late_s
