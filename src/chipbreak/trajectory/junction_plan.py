"""What a planner with junction deviation makes of straight moves: the speeds at their ends and in between.

All speeds are squared [mm²/s²]: along a move the square changes by no more than twice the acceleration times
the length.  Arrays of a motion of n moves have a row a move, and n + 1 joints, its two ends included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

_TURNS_BACK = 0.999999  # the cosine of a joint beyond which the control takes it for a reversal
_SINGLE_TURNS_BACK = float(np.float32(_TURNS_BACK))
_FROM_LAST = (2, 1, 0)  # the order in which they go through the axes
_NO_LIMIT = 1e12  # mm²/s²; what is said of a joint that goes straight on
_NOTHING = 1e-12
_LOST_SHARE = 1e-14  # of all that the squared speed could gain: what running sums lose in digits
_FIRST_STEPS = np.float32(1.25)  # that the first segment of a move has at least


@dataclass(frozen=True, eq=False)
class Moves:
    """Straight moves: lengths [mm] and accelerations [mm/s²], (n,), their directions, (n, 3)."""

    lengths_mm: Floats
    accelerations_mm_s2: Floats
    ways: Floats

    def __len__(self) -> int:
        return len(self.lengths_mm)

    @property
    def gains(self) -> Floats:
        """By how much the squared speed can change along each move, (n,)."""
        return 2.0 * self.accelerations_mm_s2 * self.lengths_mm


class Speeds(NamedTuple):
    """Squared speeds where moves begin, at their fastest, and where they end, (n,) each."""

    starts: Floats
    peaks: Floats
    ends: Floats

    def times_s(self, moves: Moves) -> Floats:
        """How long each move takes, (n,): a ramp, an even part, a ramp."""
        start, peak, end = map(np.sqrt, self)
        has = moves.accelerations_mm_s2
        ramps_mm = (2.0 * self.peaks - self.starts - self.ends) / (2.0 * has)
        even_mm = np.maximum(moves.lengths_mm - ramps_mm, 0.0)
        times_s: Floats = (2.0 * peak - start - end) / has + even_mm / np.maximum(peak, _NOTHING)
        return times_s


def late_in_first_segments(moves: Moves, speeds: Speeds, steps: Floats, segment_s: float) -> Floats:
    """How much longer than planned moves take, (n,), of which so many ``steps`` must be made, (n,).

    Steps are worked out in segments of time, each with a step at least.  Where a move speeds up so slowly
    that its first segment has to be longer for that, and the ramp ends in what is added, the control counts
    what it has behind it of the ramp twice.
    """
    start, peak, _ = map(np.sqrt, speeds)
    has = moves.accelerations_mm_s2
    ramp_s = (peak - start) / has
    late_s = np.zeros(len(moves))
    at = np.flatnonzero(ramp_s > segment_s)
    if not len(at):
        return late_s
    ramps = _FirstSegments.of(moves.lengths_mm[at], steps[at], has[at], start[at], segment_s)
    time_s = segment_s
    while len(at):
        is_short = ramps.next_segment()
        at = at[is_short]
        ends = ramp_s[at] <= time_s + segment_s
        gone_mm = start[at] * time_s + has[at] * time_s**2 / 2.0
        late_s[at[ends]] = (2.0 * gone_mm / (start[at] + has[at] * time_s + peak[at]))[ends]
        at = at[~ends]
        ramps.keep(is_short, ~ends)
        time_s += segment_s
    return late_s


@dataclass(eq=False)
class _FirstSegments:
    """First segments of moves, worked out in minutes and single precision as the control does.

    What lies on the edge of a step goes by the digits that are lost.  Rows of ``state``: what is left of each
    move [mm], where its segment may end, what its speed gains in a segment, its speed [mm/min].
    """

    segment_min: np.float32
    state: NDArray[np.float32]

    @classmethod
    def of(
        cls, lengths_mm: Floats, steps: Floats, has_mm_s2: Floats, start_mm_s: Floats, segment_s: float
    ) -> _FirstSegments:
        """Those of moves, (n,) each."""
        segment_min = np.float32(segment_s / S_PER_MIN)
        left = lengths_mm.astype(np.float32)
        with np.errstate(divide="ignore"):
            least = np.maximum(left - _FIRST_STEPS / (steps.astype(np.float32) / left), np.float32(0.0))
        gains = (has_mm_s2 * S_PER_MIN**2).astype(np.float32) * segment_min
        speed = (start_mm_s * S_PER_MIN).astype(np.float32)
        return cls(segment_min, np.stack([left, least, gains, speed]))

    def next_segment(self) -> NDArray[np.bool_]:
        """Lengthen each by a segment; True where it still has no step."""
        left, least, gains, speed = self.state
        left -= self.segment_min * (speed + np.float32(0.5) * gains)
        speed += gains
        is_short: NDArray[np.bool_] = left > least
        return is_short

    def keep(self, *masks: NDArray[np.bool_]) -> None:
        """Only those of the first mask, of these only those of the next one."""
        for mask in masks:
            self.state = self.state[:, mask]


def cosines(ways: Floats) -> Floats:
    """Of the joints inside, (n - 1,): 1 where a move goes back along the one before, -1 straight on."""
    found: Floats = -np.einsum("ij,ij->i", ways[:-1], ways[1:])
    return found


def single_cosines(moves: Moves) -> Floats:
    """:func:`cosines` as these controls work them out, in single precision.

    Strokes that go back nearly as they came lie at the very edge of what counts as a reversal, and there the
    digits that are lost decide.
    """
    moved = (moves.ways * moves.lengths_mm[:, np.newaxis]).astype(np.float32)
    size = np.zeros(len(moves), np.float32)
    for axis in _FROM_LAST:
        size += moved[:, axis] * moved[:, axis]
    ways = moved * (np.float32(1.0) / np.sqrt(size))[:, np.newaxis]
    found = np.zeros(max(len(moves) - 1, 0), np.float32)
    for axis in _FROM_LAST:
        found -= ways[:-1, axis] * ways[1:, axis]
    return found.astype(np.float64)


def deviation_limits(moves: Moves, deviation_mm: float, axes_mm_s2: Floats) -> Floats:
    """What joints allow, (n + 1,), where a circle that leaves them by ``deviation_mm`` sets it.

    The acceleration round the circle is what the axes allow along the change of direction.  The motion begins
    and ends at rest.
    """
    cosine = single_cosines(moves)
    limits = np.zeros(len(moves) + 1)
    limits[1:-1] = np.where(cosine < -_SINGLE_TURNS_BACK, _NO_LIMIT, 0.0)
    bends = np.flatnonzero(np.abs(cosine) <= _SINGLE_TURNS_BACK)
    turns = moves.ways[bends + 1] - moves.ways[bends]
    turns /= np.sqrt(np.einsum("ij,ij->i", turns, turns))[:, np.newaxis]
    with np.errstate(divide="ignore"):
        has = np.min(axes_mm_s2 / np.abs(turns), axis=1, initial=np.inf)
    sine = np.sqrt((1.0 - cosine[bends]) / 2.0)
    limits[bends + 1] = np.minimum(has * deviation_mm * sine / (1.0 - sine), _NO_LIMIT)
    return limits


def corner_speed_limits(moves: Moves, corner_mm_s: float, acceleration_mm_s2: float) -> Floats:
    """What joints allow, (n + 1,), where the speed round a right angle is given instead.

    Both moves count with their own acceleration, and the circle touches each of them within its half.
    """
    cosine = cosines(moves.ways)
    deviation_mm = corner_mm_s**2 * (np.sqrt(2.0) - 1.0) / acceleration_mm_s2
    limits = np.zeros(len(moves) + 1)
    limits[1:-1] = np.where(cosine < -_TURNS_BACK, _NO_LIMIT, 0.0)
    bends = np.flatnonzero(np.abs(cosine) <= _TURNS_BACK)
    sine = np.sqrt((1.0 - cosine[bends]) / 2.0)
    tangent = sine / np.sqrt((1.0 + cosine[bends]) / 2.0)
    has = moves.accelerations_mm_s2
    round_it = np.minimum(has[bends], has[bends + 1]) * deviation_mm * sine / (1.0 - sine)
    halves = (moves.lengths_mm * has)[np.stack([bends, bends + 1])].min(axis=0) / 2.0 * tangent
    limits[bends + 1] = np.minimum(round_it, halves)
    return limits


def reachable(limits: Floats, gains: Floats) -> Floats:
    """The highest speeds at joints, (n + 1,), that change by no more than ``gains``, (n,), in each move.

    The one pass backward and the one forward of such planners, each as one running minimum.
    """
    gone = np.append(0.0, np.cumsum(gains))
    back = np.minimum.accumulate((limits + gone)[::-1])[::-1] - gone
    both = np.minimum.accumulate(back - gone) + gone
    speeds: Floats = np.clip(both, 0.0, limits)
    return speeds


def seen_ahead(limits: Floats, gains: Floats, blocks: int) -> Floats:
    """The limits, (n + 1,), of a control that knows so many blocks at once: it can always still stop."""
    gone = np.append(0.0, np.cumsum(gains))
    known = np.minimum(np.arange(len(limits)) + blocks - 1, len(gains))
    least: Floats = np.minimum(limits, gone[known] - gone)
    return least


def planned(moves: Moves, limits: Floats, nominal_mm_s: Floats) -> Speeds:
    """The plan of Grbl and its kin: as fast as the feeds, ``nominal_mm_s`` (n,), and the joints allow."""
    tops = nominal_mm_s**2
    gains = moves.gains
    joints = reachable(_within(limits, tops), gains)
    starts, ends = joints[:-1], joints[1:]
    return Speeds(starts, np.minimum(tops, (starts + ends + gains) / 2.0), ends)


def planned_smoothly(moves: Moves, limits: Floats, nominal_mm_s: Floats, smooth_mm_s2: float) -> Speeds:
    """The plan of Klipper: besides, no move goes faster than with the acceleration ``smooth_mm_s2``.

    That second plan has lower peaks; moves on the way up to one of them, and down from there, go no faster.
    """
    tops = nominal_mm_s**2
    gains = moves.gains
    slow_gains = np.minimum(2.0 * smooth_mm_s2 * moves.lengths_mm, gains)
    limits = _within(limits, tops)
    joints = reachable(limits, gains)
    slow = reachable(joints, slow_gains)
    starts, ends = joints[:-1], joints[1:]
    lost = _LOST_SHARE * float(gains.sum())
    climbs = slow[:-1] < slow[1:] + slow_gains - lost
    falls = slow[1:] < slow[:-1] + slow_gains - lost
    peaks = _peaks_behind(climbs, falls, np.minimum((slow[:-1] + slow[1:] + slow_gains) / 2.0, tops))
    fastest = np.minimum(np.minimum((starts + ends + gains) / 2.0, tops), peaks)
    fastest = _carried_down(fastest, climbs, starts)
    return Speeds(np.minimum(starts, fastest), fastest, np.minimum(ends, fastest))


def _within(limits: Floats, tops: Floats) -> Floats:
    """No joint is faster than the feeds on both sides of it."""
    inside = np.minimum(limits[1:-1], np.minimum(tops[:-1], tops[1:]))
    return np.concatenate([limits[:1], inside, limits[-1:]])


def _peaks_behind(climbs: NDArray[np.bool_], falls: NDArray[np.bool_], peaks: Floats) -> Floats:
    """The peak of the slow plan that each move is on the way to, (n,); ``peaks`` are those of all moves."""
    last_climb = np.append(~climbs[1:], False)
    is_peak = climbs & (falls | last_climb)
    places = np.where(is_peak, np.arange(len(climbs)), len(climbs))
    nearest = np.minimum.accumulate(places[::-1])[::-1]
    found: Floats = np.append(peaks, 0.0)[nearest]
    return found


def _carried_down(fastest: Floats, climbs: NDArray[np.bool_], starts: Floats) -> Floats:
    """Moves that only brake in the slow plan begin no faster than the one before them was."""
    found = fastest.copy()
    at = np.flatnonzero(climbs[:-1] & ~climbs[1:]) + 1
    while len(at):
        found[at] = np.minimum(found[at - 1], starts[at])
        at = at[at + 1 < len(climbs)] + 1
        at = at[~climbs[at]]
    return found
