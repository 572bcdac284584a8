"""LinuxCNC's planner on single blocks from rest to rest: how many servo periods, which feed, which places.

Such a block speeds up by a·T in each period, keeps its feed while it can still brake behind the period, runs
one period onto the braking curve v² = 2·a·(way to go), and brakes by a·T in each period; the last, incomplete
one counts as a whole.  So all of it is known without going through the periods.
``linuxcnc_planner.linuxcnc`` goes through them; a test holds the two equal.

All arrays are (m,), a block each: lengths in mm, feeds in mm/s, accelerations in mm/s².
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple

Counts = NDArray[np.intp]
_HALVINGS = 14


class Profile(NamedTuple):
    """The periods of blocks, (m,): ``rising`` at the full acceleration, a ``partial`` one, ``even`` ones.

    Then one period runs onto the braking curve and ends at ``onto`` [mm/s], and ``falling`` ones follow.
    """

    rising: Counts
    partial: Counts
    even: Counts
    onto: Floats
    falling: Counts

    @property
    def periods(self) -> Counts:
        """How many periods each block takes, (m,)."""
        return self.rising + self.partial + self.even + 1 + self.falling


def profile_of(lengths: Floats, feeds: Floats, acceleration: Floats, period: float) -> Profile:
    """How the blocks run."""
    step = acceleration * period
    feed = np.minimum(feeds, lengths / period)
    rising = np.floor(np.minimum(feed / step, np.sqrt(lengths / acceleration) / period) + 1e-9)
    speed = rising * step
    left = lengths - speed * rising * period / 2.0
    partial = (feed > speed * (1.0 + 1e-12)) & (_braked(speed, left, step, period) >= feed)
    left = left - np.where(partial, (speed + feed) / 2.0 * period, 0.0)
    speed = np.where(partial, feed, speed)
    # Only who has reached the feed keeps it; the others are on their way onto the braking curve.
    is_even = speed >= feed * (1.0 - 1e-9)
    spare = left - speed * speed / (2.0 * acceleration)
    with np.errstate(divide="ignore", invalid="ignore"):
        even = np.where(is_even, np.floor(np.maximum(spare / (speed * period), 0.0) + 1e-9), 0.0)
    left = left - even * speed * period
    onto = np.maximum(_braked(speed, left, step, period), 0.0)
    falling = np.ceil(onto / step - 1e-9)
    counts = [np.asarray(part, dtype=np.intp) for part in (rising, partial, even, falling)]
    return Profile(counts[0], counts[1], counts[2], onto, counts[3])


def _braked(speed: Floats, left: Floats, step: Floats, period: float) -> Floats:
    """The speed behind one period more from which braking fits into the way that is then left."""
    half = step / 2.0
    room = step / period * (2.0 * left - speed * period)
    braked: Floats = np.where(room > 0.0, np.sqrt(np.maximum(room, 0.0) + half * half), 0.0) - half
    return braked


def middle_feeds(lengths: Floats, times: Floats, acceleration: Floats, period: float) -> Floats:
    """The feed in the middle, by time, of all feeds with which each block takes its time.

    Whether the control can do it has been asked before.
    """
    periods = np.rint(times / period)
    least = 2.0 * np.sqrt(lengths / acceleration) / period

    def slowest(most: Floats) -> Floats:
        """The longest trapezoid times, in periods, that LinuxCNC still runs in ``most`` of its periods."""
        low = np.maximum(most - 2.0, least)
        high = most
        for _ in range(_HALVINGS):
            middle = (low + high) / 2.0
            feeds = speeds_for_times(lengths, middle * period, acceleration)
            fits = profile_of(lengths, feeds, acceleration, period).periods <= most
            low = np.where(fits, middle, low)
            high = np.where(fits, high, middle)
        return low

    early = np.where(least < periods - 1.0, np.maximum(least, slowest(periods - 1.0)), least)
    return speeds_for_times(lengths, (slowest(periods) + early) / 2.0 * period, acceleration)


def speeds_for_times(lengths: Floats, times: Floats, acceleration: Floats) -> Floats:
    """:func:`planner.speed_for_time` for many."""
    rate = acceleration * times
    speeds: Floats = (rate - np.sqrt(np.maximum(rate * rate - 4.0 * acceleration * lengths, 0.0))) / 2.0
    return speeds


def places_of(lengths: Floats, feeds: Floats, acceleration: Floats, period: float) -> tuple[Counts, Floats]:
    """The periods of each block, (m,), and the way after each period, block behind block in one line."""
    profile = profile_of(lengths, feeds, acceleration, period)
    counts = profile.periods
    feed = np.minimum(feeds, lengths / period)
    block = np.repeat(np.arange(len(counts)), counts)
    starts = np.cumsum(counts) - counts
    number = np.arange(len(block)) - starts[block] + 1
    step = (acceleration * period)[block]
    risen = (profile.rising + profile.partial + profile.even)[block]
    rising = np.minimum(number * step, feed[block])
    onto = profile.onto[block]
    speeds = np.where(number <= profile.rising[block], number * step, rising)
    speeds = np.where(number > risen, np.maximum(onto - (number - risen - 1) * step, 0.0), speeds)
    before = np.append(0.0, speeds[:-1])
    before[starts] = 0.0
    ways = np.cumsum((before + speeds) / 2.0 * period)
    ways -= (np.append(0.0, ways)[starts])[block]
    ways[starts + counts - 1] = lengths
    return counts, np.minimum(ways, lengths[block])
