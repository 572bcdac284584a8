"""LinuxCNC's planner for many stretches at once: ``linuxcnc_planner.linuxcnc`` with a row for each of them.

Every row goes through the same steps as there, one servo period at a time; a test holds the two equal.
Lengths in mm, speeds in mm/s, accelerations in mm/s², times in s.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import inf

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.linuxcnc_planner import (
    LEAST_PERIODS,
    LONG_CHANGE,
    NOTHING,
    STANDING,
    STILL_BLENDS,
    Clock,
)

Bools = NDArray[np.bool_]
Places = NDArray[np.intp]


class Stretches(NamedTuple):
    """Stretches from rest to rest of as many blocks each: (m, n), and (m,) the speed of the block before.

    ``tops`` are the speeds that the axes allow.
    """

    lengths: Floats
    speeds: Floats
    tops: Floats
    accelerations: Floats
    before: Floats

    def rows(self, which: Places | Bools) -> Stretches:
        """Some of them."""
        return Stretches(*(column[which] for column in self))

    def at_least(self, speed: float) -> Stretches:
        """The same with no block slower than that."""
        return self if speed <= 0.0 else self._replace(speeds=np.maximum(self.speeds, speed))


def linuxcnc_many(stretches: Stretches, clock: Clock) -> tuple[Floats, Floats]:
    """Time of each block, (m, n), and the distance covered after each servo period, (m, periods).

    Behind the end of a stretch its distances are NaN.
    """
    shape = stretches.lengths.shape
    blocks = _Blocks(stretches, clock)
    times = np.zeros(stretches.lengths.size)
    rows = _start(blocks, stretches.before)
    seen: list[tuple[Places, Floats]] = []
    with np.errstate(divide="ignore", invalid="ignore"):
        while len(rows.row):
            blocks.advance(rows, times)
            seen.append((rows.row, rows.way + rows.done))
            rows = rows.without(rows.leaves & (rows.block == shape[1] - 1))
    places = np.full((shape[0], len(seen)), np.nan)
    for at, (row, place) in enumerate(seen):
        places[row, at] = place
    return times.reshape(shape), places


def times_of_many(stretches: Stretches, clock: Clock, until: int) -> Floats:
    """Time of each of the first ``until`` blocks, (m, until); an even feed takes no time without places."""
    blocks = _Blocks(stretches, clock)
    times = np.zeros(stretches.lengths.size)
    rows = _start(blocks, stretches.before)
    with np.errstate(divide="ignore", invalid="ignore"):
        while len(rows.row):
            blocks.cruise(rows, times)
            blocks.advance(rows, times)
            ended = rows.leaves & (rows.block == blocks.count - 1)
            rows = rows.without(ended | (rows.block >= until))
    return times.reshape(stretches.lengths.shape)[:, :until]


def passing_speeds(stretches: Stretches, clock: Clock) -> Floats:
    """How fast each block may be at its end, (m, n): what highest overrides differ in."""
    blocks = _Blocks(stretches, clock)
    return np.minimum(blocks.reachable, blocks.tops).reshape(stretches.lengths.shape)


@dataclass
class _Rows:
    """Where the stretches stand that have not ended; (k,) each, as in ``linuxcnc_planner._Stretch``.

    ``leaves``: the block ends within the next period, after ``rest`` and at ``end_speed``.  ``alone``: how
    many periods more the first block runs without the next one; ``stops``: it ends at rest.
    """

    row: Places
    block: Places
    done: Floats
    way: Floats
    speed: Floats
    feed_before: Floats
    even: Bools
    leaves: Bools
    stops: Bools
    alone: Places
    rest: Floats
    end_speed: Floats

    def without(self, ended: Bools) -> _Rows:
        """Only the others."""
        if not ended.any():
            return self
        return _Rows(*(getattr(self, field.name)[~ended] for field in fields(self)))


class _Blocks:
    """What is fixed of each block, row after row in one line: (m * n,)."""

    def __init__(self, stretches: Stretches, clock: Clock) -> None:
        lengths, speeds, tops, accelerations, _ = stretches
        self.count = lengths.shape[1]
        self.period, self.ramp, override, _ = clock
        self.periods_alone = clock.periods_alone if self.count > 1 else 0
        self.per_revolution = override == inf
        caps = lengths / (LEAST_PERIODS * self.period)
        caps[:, 0] = lengths[:, 0] / self.period
        caps = np.minimum(caps, tops)
        feeds = np.minimum(speeds, tops)
        asked = np.minimum(feeds, caps)
        limits = caps if self.per_revolution else np.minimum(override * feeds, caps)
        reachable = _joint_speeds(lengths, limits, accelerations)
        ends = np.minimum(reachable, asked)
        behind = caps if self.per_revolution else asked
        ends[:, :-1] = np.minimum(ends[:, :-1], behind[:, 1:])
        self.lengths = lengths.ravel()
        self.acceleration = accelerations.ravel()
        self.feeds = feeds.ravel()
        self.caps = caps.ravel()
        self.tops = asked.ravel()
        self.ends = ends.ravel()
        self.reachable = reachable.ravel()

    def is_even(self, rows: _Rows, at: Places) -> Bools:
        """Whose block is run as one even change of speed."""
        asked = np.minimum(rows.feed_before, self.caps[at]) if self.per_revolution else self.tops[at]
        aim = np.minimum(self.reachable[at], asked)
        left = self.lengths[at] - rows.done
        knows_next = (rows.block < self.count - 1) & ((rows.block > 0) | (rows.feed_before > 0.0))
        even: Bools = knows_next & (2.0 * left < self.ramp * (rows.speed + aim))
        return even

    def cruise(self, rows: _Rows, times: Floats) -> None:
        """As many periods as pass far from the end of a block: at one speed, or in one even change of it."""
        at = rows.row * self.count + rows.block
        inside = ~rows.leaves & (rows.alone == 0)
        end = np.where(rows.stops, 0.0, self.ends[at])
        left = self.lengths[at] - rows.done
        speed = rows.speed
        both = speed + end
        change = (end - speed) * both / (2.0 * np.maximum(left, NOTHING))
        glides = inside & rows.even & (end > STANDING) & (np.abs(change) <= self.acceleration[at])
        cruises = inside & ~rows.even & (speed == self.tops[at])
        if not (glides | cruises).any():
            return
        change = np.where(glides, change, 0.0)
        step = speed * self.period
        even = (left - speed * speed / self.acceleration[at]) / step
        count = np.floor(np.where(glides, 2.0 * left / both / self.period, even)) - 2.0
        count = np.where(count > np.where(glides, LONG_CHANGE, 0.0), count, 0.0)
        count = np.where(glides | cruises, count, 0.0)
        time = count * self.period
        rows.done = rows.done + np.where(glides, (speed + change / 2.0 * time) * time, count * step)
        rows.speed = speed + change * time
        times[at] += time

    def advance(self, rows: _Rows, times: Floats) -> None:
        """One servo period, or what is left of it in the next block where one ends."""
        new = rows.leaves
        at = rows.row * self.count + rows.block
        times[at[new]] += rows.rest[new]
        rows.way = rows.way + np.where(new, self.lengths[at], 0.0)
        rows.done = np.where(new, 0.0, rows.done)
        rows.speed = np.where(new, rows.end_speed, rows.speed)
        rows.block = rows.block + new
        at = at + new
        top = self.tops[at]
        rows.stops = rows.stops & ~new
        end = np.where(rows.stops, 0.0, self.ends[at])
        if self.per_revolution:
            rows.feed_before = np.where(new, self.feeds[at - 1], rows.feed_before)
            top = np.where(new, np.minimum(rows.feed_before, self.caps[at]), top)
            end = np.where(new, 0.0, end)
        time = np.where(new, self.period - rows.rest, self.period)
        self._step(rows, at, time, top, end)
        times[at] += time
        rows.even = np.where(new, self.is_even(rows, at), rows.even)
        if rows.alone.any():
            end = self._meet_next(rows, at, end)
        self._look_ahead(rows, at, end)

    def _meet_next(self, rows: _Rows, at: Places, end: Floats) -> Floats:
        """The block behind the first one is handed over; the end speeds now."""
        meets = (rows.alone == 1) & rows.stops
        rows.alone = np.maximum(rows.alone - 1, 0)
        runs_on = meets & (rows.done < STILL_BLENDS * self.lengths[at])
        rows.stops = rows.stops & ~runs_on
        return np.where(runs_on, self.ends[at], end)

    def _step(self, rows: _Rows, at: Places, time: Floats, top: Floats, end: Floats) -> None:
        speed = rows.speed
        most = self.acceleration[at]
        left = self.lengths[at] - rows.done
        ramp = (end - speed) * (speed + end) / (2.0 * np.maximum(left, NOTHING))
        half = most * time / 2.0
        room = end * end + most * (2.0 * left - speed * time)
        braked = np.where(room > 0.0, np.sqrt(room + half * half) - half, -half)
        free = (np.minimum(braked, top) - speed) / np.maximum(time, NOTHING)
        change = np.where(rows.even & ~rows.leaves & (end > STANDING), ramp, free)
        after = speed + np.clip(change, -most, most) * time
        ended = after < 0.0
        ahead = np.where(ended, np.where(left < speed * time, left, 0.0), (speed + after) / 2.0 * time)
        rows.done = rows.done + np.minimum(left, ahead)
        rows.speed = np.where(ended, 0.0, after)

    def _look_ahead(self, rows: _Rows, at: Places, end: Floats) -> None:
        """Whose block ends within the next period, when, and at which speed."""
        speed = rows.speed
        most = self.acceleration[at]
        left = self.lengths[at] - rows.done
        mean = (speed + end) / 2.0
        time = left / mean
        change = (end - speed) / time
        hard = np.abs(change) > most
        change = np.where(change > 0.0, most, -most)
        root = speed * speed + 2.0 * change * left
        end = np.where(hard, np.sqrt(np.maximum(root, 0.0)), end)
        time = np.where(hard, (end - speed) / change, time)
        there = left <= NOTHING
        near = (
            (rows.block < self.count - 1) & (mean > STANDING) & ~(hard & (root < 0.0)) & (time < self.period)
        )
        rows.leaves = there | near
        rows.rest = np.where(there, 0.0, time)
        rows.end_speed = np.where(there, speed, end)


def _start(blocks: _Blocks, before: Floats) -> _Rows:
    count = len(before)
    none = np.zeros(count)
    off = np.zeros(count, np.bool_)
    row = np.arange(count)
    stands = before <= 0.0 if blocks.periods_alone else off
    alone = np.where(stands, blocks.periods_alone, 0)
    rows = _Rows(row, np.zeros(count, np.intp), none, none, none, before, off, off, stands, alone, none, none)
    rows.even = blocks.is_even(rows, row * blocks.count)
    return rows


def _joint_speeds(lengths: Floats, limits: Floats, accelerations: Floats) -> Floats:
    """The highest speed at the end of each block from which all later ones can still brake to rest."""
    ends = np.minimum(limits, np.roll(limits, -1, axis=1))
    ends[:, -1] = 0.0
    room = 2.0 * accelerations * lengths
    for index in range(lengths.shape[1] - 1, 0, -1):
        reached = np.sqrt(ends[:, index] ** 2 + room[:, index])
        ends[:, index - 1] = np.minimum(ends[:, index - 1], reached)
    return ends
