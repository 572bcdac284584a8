"""What every control has in common, and the questions that a law of control answers.

A law says what a kind of control makes of blocks: how long each takes, where the tool is commanded to be
when, and which feed takes a wanted time.  What the axes make of that is the same for every law: ``filters``
and ``real_motion``.  Lengths [mm] are signed along the path, feeds [mm/s] are positive, times [s].
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from math import inf, sqrt
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.filters import NO_FILTER, AxisFilter
from chipbreak.trajectory.junctions import Blocks, blocks_of
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.real_motion import followed
from chipbreak.units import S_PER_MIN

_NOTHING_MM = 1e-12  # of a length that counts as none
_SOON_S = 1e-9
_DIGITS = 9  # of a way in mm that count


class AxisLimits(NamedTuple):
    """What one axis can do: speed [mm/s], acceleration [mm/s²], how it follows its command, its step [mm]."""

    axis: str
    velocity_mm_s: float
    acceleration_mm_s2: float
    filter: AxisFilter = NO_FILTER
    step_mm: float = 0.0

    def slower(self, share: float) -> AxisLimits:
        """The same axis later by a share, and with so much less acceleration."""
        acceleration = self.acceleration_mm_s2 / (1.0 + share)
        return self._replace(acceleration_mm_s2=acceleration, filter=self.filter.slower(share))


@dataclass(frozen=True)
class ControlLaw(ABC):
    """A control along one path: the numbers of its profile, and what it makes of blocks.

    ``axes`` stand in the order of the coordinates of a point.  ``every_block_stops``: exact stop (G61.1, G9).
    ``merge_mm``: the control joins blocks of one feed whose points lie within this distance of one line
    (LinuxCNC G64 with Q, or with P alone).  ``blocks_per_s``: the most the control reads, None for no limit.
    ``axis`` names the axis that limits, for messages.  A dwell takes whole ``dwell_step_s``.

    A new kind of control is a subclass in its own module, a line in ``laws.LAWS`` and one in ``law_names``.
    It says what it is (the class variables) and answers the abstract methods; what the others answer is right
    for most.
    """

    name: ClassVar[str]
    is_assumed: ClassVar[bool] = False
    """It says what a control ought to do, and none is known to do it: what follows from it is unproven."""
    needs_acceleration: ClassVar[bool] = True
    needs_filters: ClassVar[bool] = False
    """What the axes make of their command must be known too."""
    needs_feed_per_minute: ClassVar[bool] = False
    """Where feed is per revolution the control goes by another law."""
    keeps_time: ClassVar[bool] = False
    """Blocks take the time that they say: a crest moved by rounding is then no other frequency."""
    is_single_precision: ClassVar[bool] = False
    """It keeps seven digits of a number."""
    runs_whole_periods: ClassVar[bool] = False
    """Times are whole servo periods."""
    plans_whole: ClassVar[bool] = False
    """How one stroke is run depends on its neighbours: a cut is planned as a whole, again and again."""
    unlike_stroke_costs: ClassVar[int] = 1
    """What a block costs to plan where hardly two strokes are alike, in blocks of a straight stroke."""

    velocity_mm_s: float = inf
    acceleration_mm_s2: float = inf
    every_block_stops: bool = False
    merge_mm: float = 0.0
    servo_period_s: float = 0.001
    blocks_per_s: float | None = None
    axis: str = ""
    per_revolution: bool = False
    dwell_step_s: float = 0.001
    axes: tuple[AxisLimits, ...] = ()

    def __post_init__(self) -> None:
        if not all(n > 0 for n in (self.velocity_mm_s, self.acceleration_mm_s2, self.servo_period_s)):
            raise ValueError(f"a control needs limits and a period above zero: {self}")

    def along(self, direction: Sequence[float], axes: Sequence[AxisLimits]) -> Self:
        """The same control with the limits of ``axes`` on a path of this direction (any length).

        The axis that reaches its limit first sets the limit; ``axis`` names it for the messages.
        """
        size = sqrt(sum(part * part for part in direction))
        shares = [(abs(part) / size, axis) for part, axis in zip(direction, axes, strict=True) if part]
        velocity = min(axis.velocity_mm_s / share for share, axis in shares)
        acceleration, name = min((one.acceleration_mm_s2 / share, one.axis) for share, one in shares)
        return replace(
            self, velocity_mm_s=velocity, acceleration_mm_s2=acceleration, axis=name, axes=tuple(axes)
        )

    def variants(self) -> Sequence[Self]:
        """The laws that may hold where the profile leaves something open; a promise is that of the worst."""
        return (self,)

    def with_acceleration(self, acceleration_mm_s2: float) -> Self:
        """The same control where it has another acceleration."""
        return replace(self, acceleration_mm_s2=acceleration_mm_s2)

    def slower(self, share: float) -> Self:
        """The same control with numbers that are off by a share, all to the slower side; below 0 faster."""
        axes = tuple(axis.slower(share) for axis in self.axes)
        return replace(self, acceleration_mm_s2=self.acceleration_mm_s2 / (1.0 + share), axes=axes)

    @property
    def read_s(self) -> float:
        """The least time of a block, for the control to read it."""
        return 1.0 / self.blocks_per_s if self.blocks_per_s else 0.0

    @property
    def late_s(self) -> float:
        """How much longer than its block the control goes on before a dwell."""
        return 0.0

    @property
    def dwell_delay_s(self) -> float:
        """How long the control takes to notice that a move has ended before it dwells."""
        return 0.0

    @property
    def rest_at_crest_s(self) -> float | None:
        """How long the tool must rest at a crest behind which it goes on forward, so that it goes on slower.

        0 where it slows down by itself, and only a return stroke of no length would be lost; None where the
        blocks are followed as they are.
        """
        return None

    def must_stand_before(self, blocks: Blocks, feeds_mm_s: Floats) -> bool:
        """True where these blocks run as they should only from a stand with nothing read ahead.

        They are those of a cut, behind whatever move comes before it.
        """
        return False

    @property
    def least_first_s(self) -> float:
        """The least time of the first block of a cut that is to run into the next one."""
        return 0.0

    def late_behind_s(self, feed_mm_s: float) -> float:
        """How much longer than its block, at this feed, the tool goes on before a dwell."""
        return self.late_s + self.axes_late_s(feed_mm_s)

    def axes_late_s(self, feed_mm_s: float) -> float:
        """How much longer than the command the axes go on."""
        return max((axis.filter.late_s(feed_mm_s) for axis in self.axes), default=0.0)

    def rounded(self, time_s: float) -> float:
        """The nearest time that a block can take."""
        return time_s

    def blocks(self, moved_mm: Floats, ahead_mm: Floats) -> Blocks:
        """Blocks from their moves, (n, 3), and how far each one leads along the path, (n,)."""
        return blocks_of(moved_mm, ahead_mm, [axis.acceleration_mm_s2 for axis in self.axes])

    @abstractmethod
    def block_times(
        self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, *, before_mm_s: float = 0.0
    ) -> Floats:
        """Time [s] of each block, (n,), from rest before the first to rest after the last.

        ``lengths_mm`` (n,) are signed along the path, none of them zero; ``feeds_mm_s`` (n,) or one for all.
        Give the feeds as the F words print them: at the edge of a period, rounding decides.  ``before_mm_s``
        is the feed of the block before, which counts for feed per revolution.  Errors: VIB033 when the
        control could merge strokes away.
        """

    @abstractmethod
    def feeds_for_spans(self, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
        """Feed [mm/s] of each block, (n,), so that every stroke takes its time on this control.

        Blocks from ``plain_from`` on run at their own feed.  A stroke round a corner, where the control
        rests, may be too short for its time: then it runs as fast as it can, and those behind it are so much
        later.  Errors: VIB030 acceleration, VIB031 speed, VIB032 blocks per second, VIB033 strokes that would
        be lost.
        """

    @abstractmethod
    def motion_between_dwells(self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        """:meth:`commanded_motion` of blocks behind none of which the tool dwells."""

    @abstractmethod
    def _feed_for(self, length_mm: float, time_s: float) -> float:
        """The feed for a time that the control can make, see :meth:`feed_for_time`."""

    @abstractmethod
    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        """The acceleration [mm/s²] below which no feed takes the time."""

    def motion(
        self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, dwell_s: Floats | None = None
    ) -> Motion:
        """What the machine really does: the commanded motion behind the filters of the axes that move."""
        commanded = self.commanded_motion(distance_mm, blocks, feeds_mm_s, dwell_s)
        return followed(commanded, distance_mm, blocks, [axis.filter for axis in self.axes])

    def commanded_motion(
        self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, dwell_s: Floats | None = None
    ) -> Motion:
        """The motion that the control makes of blocks between the places ``distance_mm``, (n + 1,).

        The tool dwells ``dwell_s`` behind each block, (n,); this is no part of the spans.
        """
        if dwell_s is None or not dwell_s.any():
            return self.motion_between_dwells(distance_mm, blocks, feeds_mm_s)
        return _motion_with_dwells(self, distance_mm, blocks, feeds_mm_s, dwell_s)

    def motions_from_rest(self, blocks: Blocks, feeds_mm_s: Floats, runs: Sequence[slice]) -> list[Motion]:
        """The motion of some runs of blocks by themselves, each from rest to rest, its way from zero."""
        return [self._motion_from_rest(blocks.part(run), feeds_mm_s[run]) for run in runs]

    def _motion_from_rest(self, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        ways_mm = np.append(0.0, np.cumsum(blocks.lengths_mm))
        return self.motion_between_dwells(ways_mm, blocks, feeds_mm_s)

    def peak_speed_mm_s(self, blocks: Blocks, feeds_mm_s: Floats) -> float | None:
        """The highest speed of the axis where the knots of the motion do not show it, else None."""
        return None

    def shortest_time(self, length_mm: float) -> float:
        """The least time [s] from rest to rest over ``length_mm``, whatever the feed.

        t = 2·sqrt(d/a) while the speed allows it.
        """
        length = abs(length_mm)
        top = min(self.velocity_mm_s, sqrt(length * self.acceleration_mm_s2))
        return max(float(replace(self, merge_mm=0.0).block_times([length], [top])[0]), self.read_s)

    def feed_for_time(self, length_mm: float, time_s: float) -> float:
        """The feed [mm/s] to command so that a block from rest to rest really takes ``time_s``.

        A time that the control cannot make is rounded to one that it can.  Errors: VIB030 acceleration,
        VIB031 speed, VIB032 blocks per second.
        """
        if not (abs(length_mm) > _NOTHING_MM and 0 < time_s < inf):
            raise ValueError(f"no feed for {length_mm} mm in {time_s} s")
        return _feed(abs(float(length_mm)), float(time_s), self._of_one_block)

    def refuse_too_short(self, length_mm: float, time_s: float) -> None:
        """Errors: VIB030 and VIB032 where no feed takes the time, see :meth:`feed_for_time`."""
        stroke = f"a stroke of {length_mm:.4g} mm in {time_s * 1000:.4g} ms"
        if self.blocks_per_s and time_s * self.blocks_per_s < 1.0 - 1e-9:
            rate = f"{1 / time_s:.4g} blocks per second, the control reads {self.blocks_per_s:.4g}"
            way_out = "ask for a lower frequency, or one block per stroke"
            raise RefusalError("VIB032", f"{stroke} needs {rate}", way_out)
        least = self._at_any_speed.shortest_time(length_mm)
        if time_s >= least * (1.0 - 1e-9):
            return
        needed = self._acceleration_for(length_mm, time_s)
        has = f"{self.limiting} {self.acceleration_mm_s2 / 1000:.3g} m/s2"
        way = (
            f"this stroke takes at least {least * 1000:.4g} ms; ask for a lower frequency or a smaller stroke"
        )
        if needed == inf:
            raise RefusalError("VIB030", f"{stroke} leaves no time to move: the control stops as long", way)
        raise RefusalError("VIB030", f"{stroke} needs {needed / 1000:.3g} m/s2, {has}", way)

    @cached_property
    def _at_any_speed(self) -> Self:
        """The same control where only its acceleration counts; asked for every stroke, and made once."""
        return replace(self, velocity_mm_s=inf, blocks_per_s=None)

    @cached_property
    def _of_one_block(self) -> Self:
        """The same control where there is nothing to join."""
        return replace(self, merge_mm=0.0)

    @property
    def limiting(self) -> str:
        """The axis that limits, and "has", for messages."""
        return f"{self.axis} has" if self.axis else "the axis has"

    def feed_within_limits(self, length_mm: float, time_s: float) -> float:
        """:meth:`feed_for_time` without what it keeps in mind."""
        wanted = self.rounded(time_s)
        self.refuse_too_short(length_mm, wanted)
        feed = self._feed_for(length_mm, wanted)
        if feed > self.velocity_mm_s:
            raise self.too_fast(length_mm, wanted, feed)
        return feed

    def too_fast(self, length_mm: float, time_s: float, feed_mm_s: float) -> RefusalError:
        """VIB031: a block needs this feed [mm/s] for its time, and no axis has it."""
        told = f"{feed_mm_s:.4g} mm/s for {length_mm:.4g} mm in {time_s * 1000:.4g} ms"
        has = f"{self.limiting} {self.velocity_mm_s:.4g} mm/s"
        return RefusalError("VIB031", f"needs {told}, {has}", "ask for a lower frequency or a smaller stroke")

    def refuse_lost_strokes(self, lengths_mm: Floats) -> None:
        """Errors: VIB033 when a stroke is so small that the control's path mode drops it."""
        if self.merge_mm <= 0.0:
            return
        strokes = np.abs(np.add.reduceat(lengths_mm, np.r_[0, turns_of(lengths_mm)]))
        if len(strokes) > 1 and np.min(strokes) <= self.merge_mm:
            told = f"the control joins points within {self.merge_mm:.4g} mm of a line and would drop strokes"
            small = f"the smallest stroke is {np.min(strokes):.4g} mm; "
            raise RefusalError("VIB033", told, small + "switch to G61, or G64 with a smaller P or Q")

    def refuse_overload(self, feeds_mm_s: Floats, spans_s: Floats) -> None:
        """Errors: VIB031 speed, VIB032 blocks per second, of blocks that take their spans exactly."""
        top = float(feeds_mm_s.max())
        if top > self.velocity_mm_s:
            has = f"{self.axis or 'the axis'} has {self.velocity_mm_s * S_PER_MIN:z.0f}"
            help_text = "ask for a lower frequency, a smaller stroke or less feed"
            message = f"the strokes need {top * S_PER_MIN:z.0f} mm/min, {has}"
            raise RefusalError("VIB031", message, help_text)
        least_s = float(spans_s.min())
        if self.blocks_per_s is not None and least_s * self.blocks_per_s < 1.0 - 1e-9:
            message = f"needs {1.0 / least_s:z.0f} blocks per second, the control reads {self.blocks_per_s:g}"
            help_text = 'ask for a lower frequency, or take output.segments = "stroke"'
            raise RefusalError("VIB032", message, help_text)

    def checked(self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike) -> tuple[Floats, Floats]:
        """Lengths and feeds as arrays, (n,) each.  Errors: ValueError for what are none, VIB033."""
        lengths = np.atleast_1d(np.asarray(lengths_mm, dtype=np.float64))
        feeds = np.broadcast_to(np.asarray(feeds_mm_s, dtype=np.float64), lengths.shape)
        are_moves = np.all(np.isfinite(lengths)) and np.all(np.abs(lengths) > _NOTHING_MM)
        if not (are_moves and np.all(feeds > 0)):
            raise ValueError("every block needs a length and a feed or time above zero")
        self.refuse_lost_strokes(lengths)
        return lengths, feeds


@lru_cache(maxsize=4096)
def _feed(length_mm: float, time_s: float, law: ControlLaw) -> float:
    return law.feed_within_limits(length_mm, time_s)


def turns_of(lengths_mm: Floats) -> NDArray[np.intp]:
    """The blocks that go the other way than the one before."""
    return np.flatnonzero(np.diff(np.sign(lengths_mm))) + 1


def _motion_with_dwells(
    law: ControlLaw, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, dwell_s: Floats
) -> Motion:
    """The motion from dwell to dwell, each part worked out once: a cut has many alike."""
    ends = np.flatnonzero(dwell_s > 0.0) + 1
    if ends[-1] != len(dwell_s):
        ends = np.append(ends, len(dwell_s))
    # Of as long ways in another direction the axes make something else.
    moved_mm = np.round(blocks.moved_mm, _DIGITS) + 0.0
    runs = [slice(first, last) for first, last in pairwise([0, *ends.tolist()])]
    keys = [(moved_mm[run].tobytes(), feeds_mm_s[run].tobytes()) for run in runs]
    firsts = dict(zip(reversed(keys), reversed(runs), strict=True))
    number = {key: at for at, key in enumerate(firsts)}
    kind = np.array([number[key] for key in keys])
    motions = law.motions_from_rest(blocks, feeds_mm_s, [*firsts.values()])

    spans_s, _ = _in_a_row([one.spans_s for one in motions], kind)
    dwells_s = dwell_s[ends - 1]
    stands_s = np.where(dwells_s > 0.0, law.dwell_delay_s, 0.0)
    spans_s[ends - 1] += stands_s
    own_s = np.array([one.spans_s.sum() for one in motions])[kind] + stands_s + dwells_s
    # A motion may end a little later than its blocks.
    moves_s = np.array([one.time_s[-1] for one in motions])[kind]
    ended_s = np.cumsum(np.maximum(own_s, moves_s + _SOON_S))
    time_s, counts = _in_a_row([one.time_s for one in motions], kind)
    time_s += np.repeat(np.append(0.0, ended_s[:-1]), counts)
    place_mm, _ = _in_a_row([one.distance_mm for one in motions], kind)
    place_mm += np.repeat(distance_mm[np.append(0, ends[:-1])], counts)
    place_mm[np.cumsum(counts) - 1] = distance_mm[ends]
    if dwell_s[-1] > 0.0:
        time_s, place_mm = np.append(time_s, ended_s[-1]), np.append(place_mm, distance_mm[-1])
    return Motion(spans_s, time_s, place_mm)


def _in_a_row(pieces: Sequence[Floats], kind: NDArray[np.intp]) -> tuple[Floats, NDArray[np.intp]]:
    """Arrays one behind the other, each as often as its number comes in ``kind``, (m,); how long each is."""
    sizes = np.array([len(piece) for piece in pieces])
    counts = sizes[kind]
    shift = (np.cumsum(sizes) - sizes)[kind] - (np.cumsum(counts) - counts)
    row: Floats = np.concatenate(pieces)[np.arange(int(counts.sum())) + np.repeat(shift, counts)]
    return row, counts
