"""LinuxCNC's trajectory planner on blocks that go the same way, from rest to rest.

Blocks are given as lengths [mm] and speeds [mm/s], all above zero; acceleration in mm/s², times in s.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import inf, sqrt

from chipbreak.trajectory.planner import Numbers, joint_speeds

NOTHING = 1e-12  # mm and s that count as none
STANDING = 1e-8  # mm/s
LEAST_PERIODS = 1.02  # a block that LinuxCNC runs into takes at least this many periods


@lru_cache(maxsize=4096)
def linuxcnc(
    lengths: Numbers,
    speeds: Numbers,
    acceleration: float,
    period: float,
    ramp: float,
    *,
    before: float | None = None,
) -> tuple[Numbers, Numbers]:
    """Time of each block as LinuxCNC 2.9 runs it, and the distance covered after each servo period.

    ``ramp`` [s]: a block run through in less is one even change of speed (1 / ARC_BLEND_RAMP_FREQ).
    ``before``: with feed per revolution, the speed of the block before these, 0 where there was none.
    """
    if before is None:
        stretch = _Stretch(lengths, speeds, acceleration, period, ramp)
    else:
        stretch = _PerRevolution(lengths, speeds, acceleration, period, ramp, feed_before=before)
    while not stretch.finished:
        stretch.advance()
    return tuple(stretch.times), tuple(stretch.places)


class _Stretch:
    """The state of LinuxCNC's planner on one stretch, advanced by one servo period at a time.

    A block ends within a period only where the next one is run into; the rest of that period is the next
    block's first, shorter step.
    """

    def __init__(
        self, lengths: Numbers, speeds: Numbers, acceleration: float, period: float, ramp: float
    ) -> None:
        self.lengths = lengths
        self.acceleration = acceleration
        self.period = period
        self.ramp = ramp
        self.caps = [lengths[0] / period, *(way / (LEAST_PERIODS * period) for way in lengths[1:])]
        self.speeds = [min(pair) for pair in zip(speeds, self.caps, strict=True)]
        self.ends = self._end_speeds()
        self.times = [0.0] * len(lengths)
        self.places = list[float]()
        self.block = 0
        self.done = self.speed = self.before = 0.0
        self.leaving: tuple[float, float] | None = None  # time to the end of the block, and the speed there
        self.finished = False
        self._enter()

    def _end_speeds(self) -> list[float]:
        """The speed at the end of each block."""
        joints = [min(pair) for pair in pairwise(self.speeds)]
        return joint_speeds(self.lengths, joints, self.acceleration)

    def advance(self) -> None:
        """One servo period, or as many as pass at an even speed far from the end of the block."""
        if self.leaving is None:
            self._cruise()
            self._step(self.period, even=self.even)
            self.leaving = self._end_in_sight()
        else:
            rest, self.speed = self.leaving
            self.times[self.block] += rest
            self.before += self.lengths[self.block]
            self.block = self.block + 1
            self.done = 0.0
            self._begin(self.period - rest)
        self.places.append(self.before + self.done)
        self.finished = self.leaving is not None and self.block == len(self.lengths) - 1

    def _begin(self, time: float) -> None:
        """What is left of a period when a block ends in it belongs to the next one."""
        self._step(time, even=False)
        self._enter()
        self.leaving = self._end_in_sight()

    def _enter(self) -> None:
        """A block whose speed changes evenly in less than ``ramp`` is run so."""
        left = self.lengths[self.block] - self.done
        both = self.speed + self.ends[self.block]
        self.even = self.block < len(self.lengths) - 1 and 2.0 * left < self.ramp * both

    def _cruise(self) -> None:
        speed = self.speed
        left = self.lengths[self.block] - self.done
        if self.even or speed != self.speeds[self.block]:
            return
        step = speed * self.period
        count = int((left - speed * speed / self.acceleration) / step) - 2
        if count > 0:
            self.places += [self.before + self.done + step * i for i in range(1, count + 1)]
            self.times[self.block] += count * self.period
            self.done += count * step

    def _step(self, time: float, *, even: bool) -> None:
        """Move on by ``time``: towards the end speed, or as fast as feed and braking allow."""
        speed = self.speed
        most = self.acceleration
        left = self.lengths[self.block] - self.done
        end = self.ends[self.block]
        if even and end > STANDING:
            change = (end - speed) * (speed + end) / (2.0 * max(left, NOTHING))
        else:
            half = most * time / 2.0
            # Braking from the next speed w has to fit behind the way that this period takes.
            room = end * end + most * (2.0 * left - speed * time)
            braked = sqrt(room + half * half) - half if room > 0.0 else -half
            change = (min(braked, self.speeds[self.block]) - speed) / max(time, NOTHING)
        after = speed + max(-most, min(most, change)) * time
        if after < 0.0:  # the last, incomplete period goes to the end
            after = 0.0
            self.done = self.done + (left if left < speed * time else 0.0)
        else:
            self.done += min(left, (speed + after) / 2.0 * time)
        self.speed = after
        self.times[self.block] += time

    def _end_in_sight(self) -> tuple[float, float] | None:
        """The time to the end of the block and the speed there, if it is reached within the next period."""
        left = self.lengths[self.block] - self.done
        if left <= NOTHING:
            return 0.0, self.speed
        end = self.ends[self.block]
        mean = (self.speed + self.ends[self.block]) / 2.0
        if self.block == len(self.lengths) - 1 or mean <= STANDING:
            return None
        time = left / mean
        change = (end - self.speed) / time
        if abs(change) > self.acceleration:
            change = self.acceleration if change > 0.0 else -self.acceleration
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

    def __init__(
        self,
        lengths: Numbers,
        speeds: Numbers,
        acceleration: float,
        period: float,
        ramp: float,
        *,
        feed_before: float,
    ) -> None:
        self.feeds = speeds
        self.feed_before = feed_before
        super().__init__(lengths, speeds, acceleration, period, ramp)

    def _end_speeds(self) -> list[float]:
        joints = [min(pair) for pair in pairwise(self.caps)]
        self.reachable = joint_speeds(self.lengths, joints, self.acceleration)
        own = zip(self.reachable, self.speeds, [*self.caps[1:], inf], strict=True)
        return [min(speeds) for speeds in own]

    def _begin(self, time: float) -> None:
        block = self.block
        own_speed = self.speeds[block]
        own_end = self.ends[block]
        self.feed_before = self.feeds[block - 1]
        # For the rest of this period nothing is known of the block after this one.
        self.speeds[block] = min(self.feed_before, self.caps[block])
        self.ends[block] = 0.0
        self._step(time, even=False)
        self.leaving = self._end_in_sight()
        self.speeds[block] = own_speed
        self.ends[block] = own_end
        self._enter()

    def _enter(self) -> None:
        left = self.lengths[self.block] - self.done
        both = self.speed + min(self.reachable[self.block], self.feed_before, self.caps[self.block])
        self.even = self.block < len(self.lengths) - 1 and 2.0 * left < self.ramp * both
