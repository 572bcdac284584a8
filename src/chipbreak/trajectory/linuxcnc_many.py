"""LinuxCNC's planner for many stretches at once: ``linuxcnc_planner.linuxcnc`` with a row for each of them.

Every row goes through the same steps as there, one servo period at a time; a test holds the two equal.
Lengths in mm, speeds in mm/s, accelerations in mm/s², times in s.
"""

from __future__ import annotations

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
_STEPS_PER_CRUISE = 4
_LENGTH, _ACCELERATION, _END, _RUNS_ON = 0, 1, 2, 5
_ENDLESS_MM = 1e100


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
    walk = _Walk(stretches, clock, stretches.lengths.shape[1])
    seen: list[Floats] = []
    with np.errstate(divide="ignore", invalid="ignore"):
        while not walk.is_over():
            walk.step()
            seen.append(walk.places())
    return walk.times_s(), np.array(seen).T


def times_of_many(stretches: Stretches, clock: Clock, until: int) -> Floats:
    """Time of each of the first ``until`` blocks, (m, until); an even feed takes no time without places."""
    walk = _Walk(stretches, clock, until)
    with np.errstate(divide="ignore", invalid="ignore"):
        while not walk.is_over():
            walk.drop_those_over()
            walk.cruise()
            for _ in range(_STEPS_PER_CRUISE):
                walk.step()
    return walk.times_s()


def passing_speeds(stretches: Stretches, clock: Clock) -> Floats:
    """How fast each block may be at its end, (m, n): what highest overrides differ in."""
    blocks = _Blocks(stretches, clock)
    return np.minimum(blocks.reachable, blocks.tops)


class _Blocks:
    """What is fixed of each block, (m, n)."""

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
        self.lengths = lengths
        self.accelerations = accelerations
        self.tops = asked
        self.ends = ends
        self.reachable = reachable
        # With feed per revolution a block is begun as if its feed were that of the one before.
        before = np.column_stack([stretches.before, feeds[:, :-1]])
        self.first_tops = np.minimum(before, caps) if self.per_revolution else asked


class _Walk:
    """Where many stretches stand, (k,) each, as in ``linuxcnc_planner._Stretch``.

    ``leaves``: the block ends within the next period, after ``rest``, and ``speed`` is the one there; the
    ``rest`` of the others is 0.  A row that has come to its end stays in a block behind it, without an end.
    """

    def __init__(self, stretches: Stretches, clock: Clock, until: int) -> None:
        blocks = _Blocks(stretches, clock)
        rows, self.width = len(stretches.before), until + 1
        self.period, self.ramp = blocks.period, blocks.ramp
        self.per_revolution = blocks.per_revolution
        self.table = _table_of(blocks, until)
        self.times = np.zeros(rows * self.width)
        self.at = np.arange(rows) * self.width
        self.over = self.at + until
        self.done = np.zeros(rows)
        self.speed = np.zeros(rows)
        self.rest = np.zeros(rows)
        self.leaves = np.zeros(rows, np.bool_)
        length, _, _, _, aim, runs_on, _ = self.table[:, self.at]
        self.even = (stretches.before > 0.0) & (runs_on > 0.0) & (2.0 * length < self.ramp * aim)
        self.alone = blocks.periods_alone
        self.standing = np.flatnonzero(stretches.before <= 0.0) if self.alone else self.at[:0]
        self.own_ends = self.table[_END, self.at[self.standing]]
        self.table[_END, self.at[self.standing]] = 0.0

    def is_over(self) -> bool:
        """True where all rows have ended."""
        return bool((self.at == self.over).all())

    def times_s(self) -> Floats:
        """Time of each block, (m, n)."""
        return self.times.reshape(-1, self.width)[:, :-1]

    def places(self) -> Floats:
        """The distance covered by each row, (k,), NaN where it has ended."""
        ways = np.cumsum(self.table[_LENGTH].reshape(-1, self.width)[:, :-1], axis=1)
        before = np.column_stack([np.zeros(len(ways)), ways]).ravel()
        return np.where(self.at == self.over, np.nan, before[self.at] + self.done)

    def drop_those_over(self) -> None:
        """Go on with the others, where many have ended."""
        goes_on = self.at != self.over
        if self.alone or 2 * np.count_nonzero(goes_on) > len(goes_on):
            return
        for name in ("at", "over", "done", "speed", "rest", "leaves", "even"):
            setattr(self, name, getattr(self, name)[goes_on])

    def cruise(self) -> None:
        """As many periods as pass far from the end of a block: at one speed, or in one even change of it."""
        length, most, end, top, *_ = self.table[:, self.at]
        speed = self.speed
        inside = ~self.leaves & (self.at != self.over)
        left = length - self.done
        both = speed + end
        change = (end - speed) * both / (2.0 * np.maximum(left, NOTHING))
        glides = inside & self.even & (end > STANDING) & (np.abs(change) <= most)
        cruises = inside & ~self.even & (speed == top)
        if self.alone or not (glides | cruises).any():
            return
        change = np.where(glides, change, 0.0)
        step = speed * self.period
        even = (left - speed * speed / most) / step
        count = np.floor(np.where(glides, 2.0 * left / both / self.period, even)) - 2.0
        count = np.where(count > np.where(glides, LONG_CHANGE, 0.0), count, 0.0)
        count = np.where(glides | cruises, count, 0.0)
        time = count * self.period
        self.done = self.done + np.where(glides, (speed + change / 2.0 * time) * time, count * step)
        self.speed = speed + change * time
        self.times[self.at] += time

    def step(self) -> None:
        """One servo period, or what is left of it in the next block where one ends."""
        new = self.leaves
        self.times[self.at] += self.rest
        self.at = self.at + new
        length, most, end, top, aim, runs_on, first_top = self.table[:, self.at]
        if self.per_revolution:
            # For the rest of the period in which a block begins nothing is known of the one after it.
            end, top = np.where(new, 0.0, end), np.where(new, first_top, top)
        done, speed = np.where(new, 0.0, self.done), self.speed
        time, left = self.period - self.rest, length - done
        change = _free_change(speed, left, end, (top, most, time))
        steady = self.even & ~new & (end > STANDING)
        if steady.any():
            ramp = (end - speed) * (speed + end) / (2.0 * np.maximum(left, NOTHING))
            change = np.where(steady, ramp, change)
        after = speed + np.minimum(np.maximum(change, -most), most) * time
        way = (speed + after) / 2.0 * time
        ended = after < 0.0  # the last, incomplete period goes to the end
        if ended.any():
            way = np.where(ended, np.where(left < speed * time, left, 0.0), way)
            after = np.where(ended, 0.0, after)
        self.done, self.speed = done + np.minimum(left, way), after
        self.times[self.at] += time
        left = length - self.done
        is_even = (runs_on > 0.0) & (2.0 * left < self.ramp * (after + aim))
        self.even = np.where(new, is_even, self.even)
        if self.alone:
            self._meet_next()
            end = np.where(new, end, self.table[_END, self.at])
        self._look_ahead(left, end, most, runs_on)

    def _meet_next(self) -> None:
        """The second block is handed over; the first runs into it if it is not too far on."""
        self.alone -= 1
        if self.alone:
            return
        rows = self.standing
        first = rows * self.width
        near = self.done[rows] < STILL_BLENDS * self.table[_LENGTH, first]
        self.table[_END, first[near]] = self.own_ends[near]

    def _look_ahead(self, left: Floats, end: Floats, most: Floats, runs_on: Floats) -> None:
        """Whose block ends within the next period, when, and at which speed."""
        speed = self.speed
        mean = (speed + end) / 2.0
        time = left / mean
        change = (end - speed) / time
        near = (runs_on > 0.0) & (mean > STANDING)
        hard = np.abs(change) > most
        if hard.any():
            change = np.where(change > 0.0, most, -most)
            root = speed * speed + 2.0 * change * left
            near &= ~(hard & (root < 0.0))
            end = np.where(hard, np.sqrt(np.maximum(root, 0.0)), end)
            time = np.where(hard, (end - speed) / change, time)
        there = left <= NOTHING
        near &= (time < self.period) & ~there
        self.leaves = there | near
        self.rest = np.where(near, time, 0.0)
        self.speed = np.where(near, end, speed)


def _free_change(speed: Floats, left: Floats, end: Floats, limits: tuple[Floats, Floats, Floats]) -> Floats:
    """The change of speed that takes a row as fast as its top, its acceleration and braking in time allow."""
    top, most, time = limits
    half = most * time / 2.0
    # Braking from the next speed has to fit behind the way that this period takes.
    room = end * end + most * (2.0 * left - speed * time)
    braked = np.where(room > 0.0, np.sqrt(np.maximum(room, 0.0) + half * half), 0.0) - half
    change: Floats = (np.minimum(braked, top) - speed) / np.maximum(time, NOTHING)
    return change


def _table_of(blocks: _Blocks, until: int) -> Floats:
    """Length, acceleration, end speed, top speed, aim, whether another follows, and the top at first.

    (7, m * (until + 1)): behind the last block of each row stands one without an end.
    """
    rows, count = blocks.lengths.shape
    table = np.zeros((7, rows, until + 1))
    columns = (
        *(blocks.lengths, blocks.accelerations, blocks.ends, blocks.tops),
        *(np.minimum(blocks.reachable, blocks.first_tops), np.ones((rows, count)), blocks.first_tops),
    )
    for row, column in zip(table, columns, strict=True):
        row[:, :until] = column[:, :until]
    table[_RUNS_ON, :, count - 1 :] = 0.0
    table[_LENGTH, :, until] = _ENDLESS_MM
    table[_ACCELERATION, :, until] = 1.0
    return table.reshape(7, -1)


def _joint_speeds(lengths: Floats, limits: Floats, accelerations: Floats) -> Floats:
    """The highest speed at the end of each block from which all later ones can still brake to rest."""
    ends = np.minimum(limits, np.roll(limits, -1, axis=1))
    ends[:, -1] = 0.0
    room = 2.0 * accelerations * lengths
    for index in range(lengths.shape[1] - 1, 0, -1):
        reached = np.sqrt(ends[:, index] ** 2 + room[:, index])
        ends[:, index - 1] = np.minimum(ends[:, index - 1], reached)
    return ends
