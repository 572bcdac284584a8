"""LinuxCNC's trajectory planner on blocks that go the same way, from rest to rest.

Blocks are given as lengths [mm], speeds [mm/s] and accelerations [mm/s²], all above zero; times in s.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from functools import lru_cache
from math import inf, sqrt

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.planner import Numbers

NOTHING = 1e-12  # mm and s that count as none
STANDING = 1e-8  # mm/s
# A block that has come further than this before the next one is known ends at rest.
STILL_BLENDS = 0.25
LONG_CHANGE = 200  # periods of one even change of speed: more are not gone through one by one
LEAST_PERIODS = 1.02  # a block that LinuxCNC runs into takes at least this many periods


class Clock(NamedTuple):
    """What of a LinuxCNC is the same for all blocks.

    ``period_s`` is its servo period.  A block run through in less than ``ramp_s`` is one even change of speed
    (1 / ARC_BLEND_RAMP_FREQ).  ``override`` is [DISPLAY] MAX_FEED_OVERRIDE: where feeds are per minute, the
    speeds at joints are planned as if it were turned up all the way; inf with feed per revolution, where they
    are planned for the highest speed possible.  No feed is below ``least_mm_s``.
    """

    period_s: float
    ramp_s: float = 0.01
    override: float = 1.0
    least_mm_s: float = 0.0

    @property
    def periods_alone(self) -> int:
        """For how many periods the first block behind a stand runs before the next one is known.

        One command is handed over in each, and feed per revolution is a command of its own.
        """
        return 2 if self.override == inf else 1


class Stretch(NamedTuple):
    """Blocks from rest to rest: ``tops`` are the speeds that the axes allow.

    ``before`` is the speed of the block before these, 0 where there was none: the tool stood with nothing to
    do, and the first block runs alone for a while.  With other feeds than those per revolution it counts only
    whether there was one.
    """

    lengths: Numbers
    speeds: Numbers
    tops: Numbers
    accelerations: Numbers
    before: float = 0.0


@lru_cache(maxsize=4096)
def linuxcnc(stretch: Stretch, clock: Clock) -> tuple[Numbers, Floats]:
    """Time of each block as LinuxCNC 2.9 runs it, and the distance covered after each servo period."""
    run = _run(stretch, clock, is_traced=True)
    return tuple(run.times), np.array(run.places)


def block_times(stretch: Stretch, clock: Clock) -> Numbers:
    """Time of each block as LinuxCNC 2.9 runs it."""
    return tuple(_run(stretch, clock, is_traced=False).times)


def _run(stretch: Stretch, clock: Clock, *, is_traced: bool) -> _Stretch:
    kind = _Stretch if clock.override < inf else _PerRevolution
    run = kind(stretch, clock, is_traced=is_traced)
    while not run.finished:
        run.advance()
    return run


def runs_alike(stretch: Stretch, clock: Clock) -> bool:
    """True where these blocks run the same behind a stand as behind a rapid, in which all of them wait."""
    waiting = NOTHING if clock.override == inf else inf
    _, alone = linuxcnc(stretch._replace(before=0.0), clock)
    _, known = linuxcnc(stretch._replace(before=waiting), clock)
    return len(alone) == len(known) and bool(np.abs(alone - known).max() <= NOTHING)


class _Stretch:
    """The state of LinuxCNC's planner on one stretch, advanced by one servo period at a time.

    A block ends within a period only where the next one is run into; the rest of that period is the next
    block's first, shorter step.
    """

    def __init__(self, stretch: Stretch, clock: Clock, *, is_traced: bool) -> None:
        self.is_traced = is_traced  # whether all places are asked for, and not the times alone
        lengths, speeds, tops, self.accelerations, self.feed_before = stretch
        self.lengths = lengths
        self.period, self.ramp, self.override, _ = clock
        least = LEAST_PERIODS * self.period
        self.caps = _lower([lengths[0] / self.period, *(way / least for way in lengths[1:])], tops)
        self.feeds = _lower(speeds, tops)
        self.speeds = _lower(self.feeds, self.caps)
        self.reachable = self._reachable()
        self.ends = self._end_speeds()
        self.asked = self._asked()
        self.next_speeds = _lower(self.reachable, self.asked)
        self.first_ends = self._first_ends()
        self.times = [0.0] * len(lengths)
        self.places = array("d")
        self.block = 0
        self.alone = clock.periods_alone if self.feed_before <= 0.0 and len(lengths) > 1 else 0
        self.own_end = self.ends[0]
        if self.alone:
            self.ends[0] = 0.0
        self.done = self.speed = self.before = 0.0
        self.leaving: tuple[float, float] | None = None  # time to the end of the block, and the speed there
        self.finished = False
        self._enter()

    def _limits(self) -> list[float]:
        """The highest speed of each joint."""
        planned = _lower([self.override * feed for feed in self.feeds], self.caps)
        return _lower(planned[:-1], planned[1:])

    def _reachable(self) -> list[float]:
        """The highest speed at the end of each block from which all later ones can still brake to rest."""
        ends = [*self._limits(), 0.0]
        end = 0.0
        for index in range(len(ends) - 1, 0, -1):
            braked = sqrt(end * end + 2.0 * self.accelerations[index] * self.lengths[index])
            end = ends[index - 1]
            if braked < end:
                ends[index - 1] = end = braked
        return ends

    def _end_speeds(self) -> list[float]:
        """The speed at the end of each block."""
        return _lower(self.reachable, _lower(self.speeds, [*self.speeds[1:], inf]))

    def _asked(self) -> list[float]:
        """The speed that is asked for where each block is begun."""
        return self.speeds

    def _first_ends(self) -> list[float]:
        """The speed at the end of each block, as it is known where it is begun."""
        return self.ends

    def advance(self) -> None:
        """One servo period, or as many as a block takes until its end is in sight, or many even blocks."""
        if self.leaving is not None:
            self._leave()
        elif self.alone:
            self._step(self.period)
            self._meet_next()
            self.leaving = self._end_in_sight(self.ends[self.block])
            self.places.append(self.before + self.done)
        else:
            self._run_on()
        self.finished = self.leaving is not None and self.block == len(self.lengths) - 1

    def _leave(self) -> None:
        """Into the next block, and through all behind it that are even changes of speed.

        What is left of a period when a block ends in it belongs to the next one.  Nearly all blocks of round
        waves pass here, by the million: one loop, and few calls.
        """
        assert self.leaving is not None
        rest, speed = self.leaving
        period, ramp, last = self.period, self.ramp, len(self.lengths) - 1
        block, before, even, is_over = self.block, self.before, False, False
        while not is_over:
            self.times[block] += rest
            before += self.lengths[block]
            block += 1
            left, most, end = self.lengths[block], self.accelerations[block], self.first_ends[block]
            took, asked = period - rest, self.asked[block]
            done, speed = _free_step(speed, left, end, top=asked, most=most, time=took)
            self.places.append(before + done)
            left -= done
            # A block whose speed changes evenly in less than ``ramp`` is run so.
            even = block < last and 2.0 * left < ramp * (speed + self.next_speeds[block])
            is_near = left <= period * speed or left <= period * end
            is_over = is_near or not even or self.ends[block] <= STANDING
            if not is_over:
                end = self.ends[block]
                time = 2.0 * left / (speed + end)
                change, count = (end - speed) / time, int(time / period)
                # A period is begun before its end is looked for.
                is_over = abs(change) > most or not 0 < count <= LONG_CHANGE
            if not is_over:
                if self.is_traced:
                    self._trace(before + done, speed, change, count)
                took += count * period
                rest, speed = time - count * period, end
            self.times[block] += took
        self.block, self.before, self.even, self.done, self.speed = block, before, even, done, speed
        self.leaving = self._end_in_sight(self.first_ends[block])

    def _trace(self, place: float, speed: float, change: float, count: int) -> None:
        """The places after some periods of an even change of speed."""
        for ran in range(1, count + 1):
            after = ran * self.period
            self.places.append(place + (speed + change / 2.0 * after) * after)

    def _run_on(self) -> None:
        """Periods in the middle of a block, until its end is in sight."""
        if self.even:
            self._glide()
        may_cruise = not self.even
        while self.leaving is None:
            if may_cruise and self.speed == self.speeds[self.block]:
                self._cruise()
                may_cruise = False
            self._periods(stop_at_speed=may_cruise)
            self.leaving = self._end_in_sight(self.ends[self.block])

    def _periods(self, *, stop_at_speed: bool) -> None:
        """Whole periods as :meth:`_step` has them, until the end may be in sight, or the speed is reached.

        Nearly all periods of straight strokes pass here, by the million.
        """
        if self.even and self.ends[self.block] > STANDING:
            self._ramp()
            return
        block, period = self.block, self.period
        length, most = self.lengths[block], self.accelerations[block]
        end, top = self.ends[block], self.speeds[block]
        stop = top if stop_at_speed else -1.0
        # The last block is run to its end; of another the end is in sight where twice the rest is near.
        ahead = 0.0 if block == len(self.lengths) - 1 else period
        speed, done, took = self.speed, self.done, self.times[block]
        while True:
            way, speed = _free_step(speed, length - done, end, top=top, most=most, time=period)
            done += way
            took += period
            self.places.append(self.before + done)
            left = length - done
            if left <= NOTHING or (speed + end) * ahead > left or speed == stop:
                break
        self.speed, self.done, self.times[block] = speed, done, took

    def _ramp(self) -> None:
        """The same in one even change of speed."""
        block, period = self.block, self.period
        length, most, end = (column[block] for column in (self.lengths, self.accelerations, self.ends))
        speed, done, took = self.speed, self.done, self.times[block]
        while True:
            left = length - done
            change = (end - speed) * (speed + end) / (2.0 * max(left, NOTHING))
            after = speed + max(-most, min(most, change)) * period
            if after < 0.0:
                after = 0.0
                done += left * (left < speed * period)
            else:
                done += min(left, (speed + after) / 2.0 * period)
            speed = after
            took += period
            self.places.append(self.before + done)
            left = length - done
            if left <= NOTHING or (speed + end) * period > left:
                break
        self.speed, self.done, self.times[block] = speed, done, took

    def _meet_next(self) -> None:
        """The block behind the first one is handed over; the first runs into it if it is not too far on."""
        if self.alone and self.block == 0:
            self.alone -= 1
            if not self.alone and self.done < STILL_BLENDS * self.lengths[0]:
                self.ends[0] = self.own_end

    def _enter(self) -> None:
        """The first block is an even change of speed where another one is known, so not after a stand."""
        knows_next = len(self.lengths) > 1 and self.feed_before > 0.0
        self.even = knows_next and 2.0 * self.lengths[0] < self.ramp * self.next_speeds[0]

    def _cruise(self) -> None:
        speed = self.speed
        left = self.lengths[self.block] - self.done
        if self.alone or speed != self.speeds[self.block]:
            return
        step = speed * self.period
        count = int((left - speed * speed / self.accelerations[self.block]) / step) - 2
        if count > 0:
            if self.is_traced:
                self.places.frombytes((self.before + self.done + step * np.arange(1, count + 1)).tobytes())
            self.times[self.block] += count * self.period
            self.done += count * step

    def _glide(self) -> None:
        """An even change of speed, which may take a slow block thousands of periods."""
        end = self.ends[self.block]
        left = self.lengths[self.block] - self.done
        both = self.speed + end
        change = (end - self.speed) * both / (2.0 * max(left, NOTHING))
        if end <= STANDING or abs(change) > self.accelerations[self.block]:
            return
        count = int(2.0 * left / both / self.period) - 2
        if count > LONG_CHANGE:
            time = self.period * np.arange(1, count + 1)
            ways = (self.speed + change / 2.0 * time) * time
            self.places.frombytes((self.before + self.done + ways).tobytes())
            self.times[self.block] += float(time[-1])
            self.done += float(ways[-1])
            self.speed += change * float(time[-1])

    def _step(self, time: float) -> None:
        """Move on by ``time``: towards the end speed, or as fast as feed and braking allow."""
        block, speed = self.block, self.speed
        left, most, end = self.lengths[block] - self.done, self.accelerations[block], self.ends[block]
        if self.even and end > STANDING:
            change = (end - speed) * (speed + end) / (2.0 * max(left, NOTHING))
            way, self.speed = _moved(speed, left, change, most, time)
        else:
            way, self.speed = _free_step(speed, left, end, top=self.speeds[block], most=most, time=time)
        self.done += way
        self.times[block] += time

    def _end_in_sight(self, end: float) -> tuple[float, float] | None:
        """The time to the end of the block and the speed there, if it is reached within the next period."""
        left = self.lengths[self.block] - self.done
        if left <= NOTHING:
            return 0.0, self.speed
        mean = (self.speed + end) / 2.0
        if self.block == len(self.lengths) - 1 or mean <= STANDING:
            return None
        time = left / mean
        change = (end - self.speed) / time
        most = self.accelerations[self.block]
        if abs(change) > most:
            change = most if change > 0.0 else -most
            root = self.speed * self.speed + 2.0 * change * left
            if root < 0.0:
                return None
            end = sqrt(root)
            time = (end - self.speed) / change
        return (time, end) if time < self.period else None


class _PerRevolution(_Stretch):
    """Feed per revolution: until a block is begun, LinuxCNC takes its feed to be that of the one before.

    So a block runs out at its own feed, whatever the next one's is, and that of the block before decides
    whether it is run as one even change of speed.
    """

    def _limits(self) -> list[float]:
        return _lower(self.caps[:-1], self.caps[1:])

    def _end_speeds(self) -> list[float]:
        return _lower(self.reachable, _lower(self.speeds, [*self.caps[1:], inf]))

    def _asked(self) -> list[float]:
        return _lower([self.feed_before, *self.feeds[:-1]], self.caps)

    def _first_ends(self) -> list[float]:
        # For the rest of the period in which a block begins nothing is known of the one after it.
        return [0.0] * len(self.caps)


def _lower(some: Sequence[float], others: Sequence[float]) -> list[float]:
    """The lower one of each pair."""
    # A comparison takes a quarter of the time of min(), and nearly all blocks that are tried pass here.
    return [a if a < b else b for a, b in zip(some, others, strict=True)]


def _free_step(
    speed: float, left: float, end: float, *, top: float, most: float, time: float
) -> tuple[float, float]:
    """The way in some time, and the speed behind it: as fast as feed and braking allow."""
    half = most * time / 2.0
    # Braking from the next speed w has to fit behind the way that this period takes.
    room = end * end + most * (2.0 * left - speed * time)
    braked = sqrt(room + half * half) - half if room > 0.0 else -half
    after = braked if braked < top else top
    return _moved(speed, left, (after - speed) / (time if time > NOTHING else NOTHING), most, time)


def _moved(speed: float, left: float, change: float, most: float, time: float) -> tuple[float, float]:
    """The way in some time with a change of speed, at most ``most``, and the speed behind it."""
    after = speed + (-most if change < -most else most if change > most else change) * time
    if after < 0.0:  # the last, incomplete period goes to the end
        return (left if left < speed * time else 0.0), 0.0
    way = (speed + after) / 2.0 * time
    return (way if way < left else left), after
