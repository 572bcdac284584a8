"""LinuxCNC's planner for many stretches at once: ``linuxcnc_planner.linuxcnc`` with a row for each of them.

Every row goes through the same steps as there, one servo period at a time; a test holds the two equal.
Lengths in mm, speeds in mm/s, acceleration in mm/s², times in s.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.linuxcnc_planner import LEAST_PERIODS, NOTHING, STANDING

Bools = NDArray[np.bool_]
Places = NDArray[np.intp]


def middle_feeds(lengths: Floats, times: Floats, acceleration: Floats, period: float, ramp: float) -> Floats:
    """The feed of :meth:`ControlLaw.feed_for_time` for single blocks from rest to rest, (m,) each.

    Whether the control can do it has been asked before.
    """
    periods = np.rint(times / period)
    least = 2.0 * np.sqrt(lengths / acceleration) / period

    def slowest(most: Floats) -> Floats:
        """The longest trapezoid times, in periods, that LinuxCNC still runs in ``most`` of its periods."""
        low = np.maximum(most - 2.0, least)
        high = most
        for _ in range(14):
            middle = (low + high) / 2.0
            feeds = _speeds_for_times(lengths, middle * period, acceleration)
            took, _ = linuxcnc_many(lengths[:, np.newaxis], feeds[:, np.newaxis], acceleration, period, ramp)
            fits = np.rint(took[:, 0] / period) <= most
            low = np.where(fits, middle, low)
            high = np.where(fits, high, middle)
        return low

    early = np.where(least < periods - 1.0, np.maximum(least, slowest(periods - 1.0)), least)
    return _speeds_for_times(lengths, (slowest(periods) + early) / 2.0 * period, acceleration)


def _speeds_for_times(lengths: Floats, times: Floats, acceleration: Floats) -> Floats:
    """:func:`planner.speed_for_time` for many."""
    rate = acceleration * times
    speeds: Floats = (rate - np.sqrt(np.maximum(rate * rate - 4.0 * acceleration * lengths, 0.0))) / 2.0
    return speeds


def linuxcnc_many(
    lengths: Floats,
    speeds: Floats,
    acceleration: Floats,
    period: float,
    ramp: float,
    *,
    before: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Time of each block, (m, n), and the distance covered after each servo period, (m, periods).

    ``lengths`` and ``speeds`` are (m, n), ``acceleration`` (m,); ``before`` (m,) is given with feed per
    revolution.  Behind the end of a stretch its distances are NaN.
    """
    blocks = _Blocks(lengths, speeds, acceleration, (period, ramp), per_revolution=before is not None)
    times = np.zeros(lengths.size)
    rows = _start(blocks, before)
    seen: list[tuple[Places, Floats]] = []
    with np.errstate(divide="ignore", invalid="ignore"):
        while len(rows.row):
            blocks.advance(rows, times)
            seen.append((rows.row, rows.way + rows.done))
            finished = rows.leaves & (rows.block == blocks.count - 1)
            if finished.any():
                rows = rows.kept(~finished)
    places = np.full((len(lengths), len(seen)), np.nan)
    for at, (row, place) in enumerate(seen):
        places[row, at] = place
    return times.reshape(lengths.shape), places


@dataclass
class _Rows:
    """Where the stretches stand that have not ended; (k,) each, as in ``linuxcnc_planner._Stretch``.

    ``leaves``: the block ends within the next period, after ``rest`` and at ``end_speed``.
    """

    row: Places
    block: Places
    done: Floats
    way: Floats
    speed: Floats
    feed_before: Floats
    even: Bools
    leaves: Bools
    rest: Floats
    end_speed: Floats

    def kept(self, mask: Bools) -> _Rows:
        """Only some of them."""
        return _Rows(*(getattr(self, field.name)[mask] for field in fields(self)))


class _Blocks:
    """What is fixed of each block, row after row in one line: (m * n,)."""

    def __init__(
        self,
        lengths: Floats,
        speeds: Floats,
        acceleration: Floats,
        times: tuple[float, float],
        *,
        per_revolution: bool,
    ) -> None:
        self.count = lengths.shape[1]
        self.acceleration = acceleration
        self.per_revolution = per_revolution
        self.period, self.ramp = times
        period = self.period
        caps = lengths / (LEAST_PERIODS * period)
        caps[:, 0] = lengths[:, 0] / period
        tops = np.minimum(speeds, caps)
        limits = caps if self.per_revolution else tops
        reachable = ends = _joint_speeds(lengths, limits, acceleration)
        if self.per_revolution:
            ends = np.minimum(reachable, tops)
            ends[:, :-1] = np.minimum(ends[:, :-1], caps[:, 1:])
        self.lengths = lengths.ravel()
        self.feeds = speeds.ravel()
        self.caps = caps.ravel()
        self.tops = tops.ravel()
        self.ends = ends.ravel()
        self.reachable = reachable.ravel()

    def is_even(self, rows: _Rows, at: Places) -> Bools:
        """Whose block is run as one even change of speed."""
        aim = self.ends[at]
        if self.per_revolution:
            aim = np.minimum(np.minimum(self.reachable[at], rows.feed_before), self.caps[at])
        left = self.lengths[at] - rows.done
        even: Bools = (rows.block < self.count - 1) & (2.0 * left < self.ramp * (rows.speed + aim))
        return even

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
        end = self.ends[at]
        if self.per_revolution:
            rows.feed_before = np.where(new, self.feeds[at - 1], rows.feed_before)
            top = np.where(new, np.minimum(rows.feed_before, self.caps[at]), top)
            end = np.where(new, 0.0, end)
        time = np.where(new, self.period - rows.rest, self.period)
        self._step(rows, at, time, top, end)
        times[at] += time
        rows.even = np.where(new, self.is_even(rows, at), rows.even)
        self._look_ahead(rows, at, end)

    def _step(self, rows: _Rows, at: Places, time: Floats, top: Floats, end: Floats) -> None:
        speed = rows.speed
        most = self.acceleration[rows.row]
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
        most = self.acceleration[rows.row]
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


def _start(blocks: _Blocks, before: Floats | None) -> _Rows:
    count = len(blocks.lengths) // blocks.count
    none = np.zeros(count)
    off = np.zeros(count, np.bool_)
    feed_before = none if before is None else before
    row = np.arange(count)
    rows = _Rows(row, np.zeros(count, np.intp), none, none, none, feed_before, off, off, none, none)
    rows.even = blocks.is_even(rows, row * blocks.count)
    return rows


def _joint_speeds(lengths: Floats, limits: Floats, acceleration: Floats) -> Floats:
    """The highest speed at the end of each block from which all later ones can still brake to rest."""
    ends = np.minimum(limits, np.roll(limits, -1, axis=1))
    ends[:, -1] = 0.0
    for index in range(lengths.shape[1] - 1, 0, -1):
        reached = np.sqrt(ends[:, index] ** 2 + 2.0 * acceleration * lengths[:, index])
        ends[:, index - 1] = np.minimum(ends[:, index - 1], reached)
    return ends
