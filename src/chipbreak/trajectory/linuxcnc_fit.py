"""From the times that the blocks of a cut should take to their feeds on LinuxCNC."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import floor
from typing import Protocol

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.linuxcnc_feeds import Found, Wanted, factors_for
from chipbreak.trajectory.linuxcnc_joints import Bends, Joints
from chipbreak.trajectory.linuxcnc_many import Stretches
from chipbreak.trajectory.linuxcnc_planner import Clock
from chipbreak.trajectory.linuxcnc_runs import (
    Columns,
    Counts,
    Parts,
    kinds_of,
    parts_of,
    run_all,
    times_by_clock,
)
from chipbreak.trajectory.linuxcnc_strokes import middle_feeds, profile_of
from chipbreak.units import MS_PER_S

_ROUNDS = 4
_LOOKS = 2
_MOST_KNOWN = 1 << 14
_AT_ONCE = 1 << 13  # stretches: a long cut has many, of few kinds, and each kind is worked out once
_SAME_S = 1e-9


class Asked(NamedTuple):
    """Blocks and the times that they should take, (n,); those from ``plain_from`` on keep their feeds.

    ``turns`` are the blocks that go the other way than the one before.  ``stops``: exact stop.  ``steps``
    (n,) are those of the feeds that can be typed [mm/s], None where any can.
    """

    bends: Bends
    spans: Floats
    turns: Counts
    plain_from: int
    stops: bool
    steps: Floats | None = None


class Refuse(Protocol):
    """What says no to a block from rest to rest: length [mm], time [s], what it has or would need."""

    def too_short(self, length_mm: float, time_s: float, has_mm_s2: float) -> None:
        """Errors: VIB030 and VIB032 where no feed takes the time."""

    def too_fast(self, length_mm: float, time_s: float, feed_mm_s: float) -> None:
        """Errors: VIB031, always."""


def fitted_feeds(asked: Asked, clocks: Sequence[Clock], refuse: Refuse) -> Floats:
    """The feed of each block, (n,).  Errors: VIB030 to VIB032.

    With several clocks nobody knows which one it will be: the worst of them counts.
    """
    joints = _joints(asked, _even_feeds(asked, clocks), clocks)
    for _ in range(_ROUNDS):
        fit = _Fit.of(asked, joints, clocks, refuse)
        found = np.maximum(fit.feeds(), clocks[0].least_mm_s)
        # What a corner costs depends on the feeds, and the feeds on what it costs.
        now = _joints(asked, found, clocks)
        if np.array_equal(now.runs_on, joints.runs_on) and fit.keeps_times(found, now):
            break
        joints = Joints(joints.runs_on & now.runs_on, now.acceleration_mm_s2)
    return found


def _even_feeds(asked: Asked, clocks: Sequence[Clock]) -> Floats:
    """Those with which the blocks would take their times if nothing had to speed up, (n,)."""
    return np.maximum(asked.bends.lengths_mm / asked.spans, clocks[0].least_mm_s)


def _joints(asked: Asked, feeds: Floats, clocks: Sequence[Clock]) -> Joints:
    """The joints by the clock that rests most often."""
    found = [
        asked.bends.joints(feeds, clock.period_s, clock.override, every_block_stops=asked.stops)
        for clock in clocks
    ]
    runs_on = np.all([one.runs_on for one in found], axis=0)
    return Joints(runs_on, np.min([one.acceleration_mm_s2 for one in found], axis=0))


@dataclass(frozen=True, eq=False)
class _Fit:
    """The parts of a cut, where the joints are known; ``columns`` have the feeds of lengths and times."""

    asked: Asked
    columns: Columns
    parts: Parts
    clocks: Sequence[Clock]
    refuse: Refuse

    @classmethod
    def of(cls, asked: Asked, joints: Joints, clocks: Sequence[Clock], refuse: Refuse) -> _Fit:
        """The parts that begin before the blocks that keep their feeds."""
        bends = asked.bends
        nominal = _even_feeds(asked, clocks)
        columns = Columns(bends.lengths_mm, nominal, bends.velocity_mm_s, joints.acceleration_mm_s2)
        parts = parts_of(joints.runs_on)
        count = int(np.searchsorted(parts.starts, asked.plain_from))
        return cls(asked, columns, Parts(parts.starts[:count], parts.stops[:count]), clocks, refuse)

    @property
    def period_s(self) -> float:
        """The servo period."""
        return self.clocks[0].period_s

    def feeds(self) -> Floats:
        """The feed of each block, (n,)."""
        feeds = self.columns.speeds.copy()
        if not len(self.parts.starts):
            return feeds
        times = self._in_time(_times_of_parts(self.asked, self.columns, self.parts, self.period_s))
        single = self.parts.of_size(1)
        blocks = self.parts.starts[single]
        feeds[blocks] = self._single_feeds(blocks, times[single])
        self._refuse_several(times)
        for size in np.flatnonzero(np.bincount(self.parts.sizes)).tolist():
            which = self.parts.of_size(size) if size > 1 else single[:0]
            inner = which[self.parts.stops[which] <= self.asked.plain_from]
            for first in range(0, len(inner), _AT_ONCE):
                self._fit_alike(inner[first : first + _AT_ONCE], size, times, feeds)
            if len(inner) < len(which):
                self._fit_last(which[len(inner) :], size, times, feeds)
        return feeds

    def _in_time(self, times: Floats) -> Floats:
        """The times of the parts, (p,), none longer than at the lowest feed: the next one gets the rest."""
        least = self.clocks[0].least_mm_s
        if least <= 0.0:
            return times
        ways, has = _parts_as_blocks(self.columns, self.parts)
        longest = profile_of(ways, np.full(len(ways), least), has, self.period_s).periods * self.period_s
        for first in np.flatnonzero(times > longest + _SAME_S).tolist():
            at = first
            while at + 1 < len(times) and times[at] > longest[at]:
                times[at + 1] += times[at] - longest[at]
                times[at] = longest[at]
                at += 1
        return times

    def keeps_times(self, feeds: Floats, joints: Joints) -> bool:
        """True where other joints change no time that the parts were given."""
        columns = self.columns._replace(speeds=feeds)
        if np.array_equal(columns.accelerations, joints.acceleration_mm_s2):
            return True
        before = run_all(columns, self.parts, self.clocks[0]).times
        now = columns._replace(accelerations=joints.acceleration_mm_s2)
        after = run_all(now, self.parts, self.clocks[0]).times
        fitted = slice(0, self.asked.plain_from)
        return bool(np.abs(np.cumsum(after - before)[fitted]).max(initial=0.0) < self.period_s / 2.0)

    def _single_feeds(self, blocks: Counts, times: Floats) -> Floats:
        """The feeds of blocks from rest to rest; those of one kind are found once."""
        columns = self.columns
        tops = columns.tops[blocks]
        rows = np.column_stack([columns.lengths[blocks], times, columns.accelerations[blocks], tops])
        first, kind = kinds_of(rows)
        # The first of all is refused first.
        ways, some, accelerations, tops = rows[np.sort(first)].T
        self._refuse_too_short(ways, some, accelerations)
        ways, some, accelerations, tops = rows[first].T
        feeds = middle_feeds(ways, some, accelerations, self.period_s)
        for at in np.flatnonzero((feeds > tops)[kind]).tolist()[:1]:
            self.refuse.too_fast(*(float(column[kind[at]]) for column in (ways, some, feeds)))
        return np.asarray(feeds[kind])

    def _refuse_too_short(self, ways: Floats, times: Floats, accelerations: Floats) -> None:
        """Errors: VIB030 and VIB032 for the first that no feed does, and for the shortest time."""
        if not len(times):
            return
        least = _least_periods(ways, accelerations, self.period_s) * self.period_s
        late = np.flatnonzero(times < least - _SAME_S)[:1]
        for at in [*late.tolist(), int(times.argmin())]:
            self.refuse.too_short(float(ways[at]), float(times[at]), float(accelerations[at]))

    def _refuse_several(self, times: Floats) -> None:
        """Errors: VIB030 and VIB032 for parts of several blocks that not even one block could run."""
        several = np.flatnonzero((self.parts.sizes > 1) & (self.parts.stops <= self.asked.plain_from))
        if not len(several):
            return
        ways, has = _parts_as_blocks(self.columns, self.parts)
        self._refuse_too_short(ways[several], times[several], has[several])

    def _wanted(self, which: Counts, size: int, times: Floats, feeds: Floats) -> Wanted:
        blocks = self.parts.blocks_of(which, size)
        stretches = self.columns._replace(speeds=feeds).stretches(blocks, self.clocks[0])
        steps = None if self.asked.steps is None else self.asked.steps[blocks]
        return Wanted(stretches, self.asked.spans[blocks], size, times[which], steps)

    def _fit_last(self, which: Counts, size: int, times: Floats, feeds: Floats) -> None:
        """The stretch that runs into the blocks that keep their feeds."""
        blocks = self.parts.blocks_of(which, size)[0]
        fitted = self.asked.plain_from - int(blocks[0])
        wanted = self._wanted(which, size, times, feeds)._replace(fitted=fitted)
        feeds[blocks] *= _found(wanted, self.clocks).factors[0]

    def _fit_alike(self, which: Counts, size: int, times: Floats, feeds: Floats) -> None:
        """Change the feeds of parts of several blocks each, so that they take their times."""
        wanted = self._wanted(which, size, times, feeds)
        blocks = self.parts.blocks_of(which, size)
        nominal = feeds[blocks]
        found = _found_for_kinds(wanted, self.clocks)
        feeds[blocks] = nominal * found.factors
        slack = self.period_s / 2.0 + _SAME_S
        for _ in range(_LOOKS):
            # With feed per revolution the block before counts, and its feed is known only now; so are the
            # feeds that can be typed, and all strokes alike may lose a period by them.
            seen = self._wanted(which, size, times, feeds).typed()
            off = np.flatnonzero((_missed(seen, self.clocks) > slack) & (np.abs(found.late) <= slack))
            if not len(off):
                break
            some = seen.rows(off)
            some = some._replace(stretches=some.stretches._replace(speeds=nominal[off]))
            exact = _found(some, self.clocks)
            feeds[blocks[off]] = nominal[off] * exact.factors
            found.late[off] = exact.late
        for row in np.flatnonzero(found.never).tolist()[:1]:
            raise _no_factor(wanted.stretches.lengths[row], float(wanted.time[row]), float(found.late[row]))


def _times_of_parts(asked: Asked, columns: Columns, parts: Parts, period: float) -> Floats:
    """How long each part should take, (p,): whole periods for each stroke.

    What rounding takes from one stroke, the next one gets.
    """
    bounds = np.append(0, asked.turns)
    bounds = bounds[bounds < asked.plain_from]
    ends = np.append(bounds[1:], min(asked.plain_from, len(asked.spans)))
    whole = np.rint(np.cumsum(asked.spans)[ends - 1] / period)
    wanted = np.diff(whole, prepend=0.0)
    stroke = np.searchsorted(bounds, parts.starts, "right") - 1
    times = wanted[stroke]
    firsts = np.searchsorted(stroke, np.arange(len(bounds)))
    counts = np.diff(np.append(firsts, len(stroke)))
    shared = np.flatnonzero((counts > 1) | (np.append(0, counts[:-1]) > 1)).tolist()
    if not shared:
        return np.asarray(times * period)
    ways, has = _parts_as_blocks(columns, parts)
    # Numbers and no arrays from here on: there may be hundreds of thousands of such strokes, of few parts.
    ways_of = ways.tolist()
    least = _least_periods(ways, has, period).tolist()
    owed = 0.0
    for at in shared:
        run = slice(int(firsts[at]), int(firsts[at] + counts[at]))
        times[run], owed = _shared_out(float(wanted[at]) - owed, ways_of[run], least[run])
    return np.asarray(times * period)


def _parts_as_blocks(columns: Columns, parts: Parts) -> tuple[Floats, Floats]:
    """How long each part is, (p,), and the acceleration that all its blocks have."""
    stop = int(parts.stops[-1])
    ways = np.add.reduceat(columns.lengths[:stop], parts.starts)
    return ways, np.minimum.reduceat(columns.accelerations[:stop], parts.starts)


def _shared_out(wanted: float, ways: list[float], least: list[float]) -> tuple[list[float], float]:
    """The periods of the parts of one stroke, and what the next one must make up for.

    ``ways`` are their lengths, ``least`` the fewest periods of each.  A stroke that rests on the way gives
    each part the least it needs, and what is spare by length.  If that is too long, one period of it is made
    up for by the next stroke; with more, all that follows is late.
    """
    if len(ways) == 1:
        return [wanted], 0.0
    needed = sum(least)
    whole = sum(ways)
    spare = max(0.0, wanted - needed)
    given = [float(floor(spare * way / whole)) for way in ways]
    given[ways.index(max(ways))] += spare - sum(given)
    periods = [fewest + more for fewest, more in zip(least, given, strict=True)]
    return periods, min(1.0, max(0.0, needed - wanted))


def _least_periods(ways: Floats, accelerations: Floats, period: float) -> Floats:
    """The fewest periods of blocks from rest to rest, (m,)."""
    top = np.sqrt(ways * accelerations)
    return profile_of(ways, top, accelerations, period).periods.astype(np.float64)


def _missed(wanted: Wanted, clocks: Sequence[Clock]) -> Floats:
    """By how much each stretch misses its time as it is [s], (m,); of several clocks the worst."""
    first, kind = kinds_of(np.column_stack(wanted.stretches))
    some = wanted.stretches.rows(first)
    count = some.lengths.shape[1]
    took = [times.sum(axis=1)[kind] for times in times_by_clock(some, clocks, count)]
    return np.asarray(np.abs(np.array(took) - wanted.time).max(axis=0))


def _found_for_kinds(wanted: Wanted, clocks: Sequence[Clock]) -> Found:
    """The factors of all stretches from those of kinds of them: three digits make a kind."""
    lengths, speeds, tops, accelerations, before = wanted.stretches
    digits = [three_digits(column) for column in (lengths, speeds, tops, accelerations)]
    first, kind = kinds_of(np.column_stack([*digits, before, np.rint(wanted.time / clocks[0].period_s)]))
    rounded = Stretches(digits[0][first], digits[1][first], digits[2][first], digits[3][first], before[first])
    found = _found(wanted.rows(first)._replace(stretches=rounded, steps=None), clocks)
    return Found(found.factors[kind], found.late[kind], found.never[kind])


def _found(wanted: Wanted, clocks: Sequence[Clock]) -> Found:
    """The factors of stretches; the cuts of a program ask for the same again and again."""
    known = _known(tuple(clocks), wanted.fitted)
    if len(known) > _MOST_KNOWN:
        known.clear()
    steps = () if wanted.steps is None else (wanted.steps,)
    keys = [row.tobytes() for row in np.column_stack([*wanted.stretches, wanted.spans, wanted.time, *steps])]
    # Another thread may forget them at any time: what was answered is kept.
    mine = {key: row for key, row in ((key, known.get(key)) for key in keys) if row is not None}
    new = {key: at for at, key in enumerate(keys) if key not in mine}
    if new:
        found = factors_for(wanted.rows(np.array([*new.values()], dtype=np.intp)), clocks)
        rows = zip(found.factors, found.late.tolist(), found.never.tolist(), strict=True)
        fresh = dict(zip(new, rows, strict=True))
        known.update(fresh)
        mine |= fresh
    factors, late, never = zip(*map(mine.__getitem__, keys), strict=True)
    return Found(np.array(factors), np.array(late), np.array(never))


@lru_cache(maxsize=64)
def _known(clocks: tuple[Clock, ...], fitted: int) -> dict[bytes, tuple[Floats, float, bool]]:
    """What was found, by the numbers of the stretch."""
    return {}


def _no_factor(lengths_mm: Floats, wanted_s: float, late_s: float) -> RefusalError:
    message = (
        f"a stroke of {lengths_mm.sum():.4g} mm in {len(lengths_mm)} blocks takes"
        f" {(late_s + wanted_s) * MS_PER_S:.4g} ms"
        f" at any feed, {wanted_s * MS_PER_S:.4g} ms are wanted"
    )
    help_text = "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
    return RefusalError("VIB030", message, help_text)


def three_digits(values: Floats) -> Floats:
    """Rounded, so that what hardly differs is one kind; all above zero."""
    known = np.where(np.isfinite(values), values, 1.0)  # an axis whose speed nobody said has any
    unit = 10.0 ** (np.floor(np.log10(known)) - 2.0)
    rounded: Floats = np.where(np.isfinite(values), np.rint(known / unit) * unit, values)
    return rounded
