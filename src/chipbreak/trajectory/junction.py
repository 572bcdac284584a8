"""Controls that plan with junction deviation: Grbl, grblHAL, and Klipper with its own rule of corners.

They need not rest where the tool turns back: rounding to steps bends the way, and a joint that is no exact
reversal is passed at the speed that its angle allows.  So the whole motion is planned at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.junction_plan import (
    Moves,
    Speeds,
    corner_speed_limits,
    deviation_limits,
    late_in_first_segments,
    planned,
    planned_smoothly,
    seen_ahead,
)
from chipbreak.trajectory.junctions import CORNER_LIMIT, Blocks, Places
from chipbreak.trajectory.law import AxisLimits, ControlLaw, turns_of
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.planner import speed_for_time
from chipbreak.trajectory.ramps import ramp_knots
from chipbreak.units import MS_PER_S

_HALVINGS = 30
_ROUNDS = 4  # the speed at a joint is the lower one of its two strokes
_SAME_SHARE = 1e-4  # of the time of a stroke, by which it may be late at the highest feed
_EDGE_S = 5e-6  # nearer to the end of a segment, digits that are lost decide whether a block ends in it
_ENOUGH = 2.0  # times the speed that a stroke can reach from rest: a higher feed changes nothing


@dataclass(frozen=True)
class Junction(ControlLaw):
    """Even acceleration, limits per axis and along the path, speeds at joints by their angle.

    ``junction_deviation_mm`` sets the speed at a corner, or ``corner_velocity_mm_s``, the speed round a right
    angle, where that is given.  ``min_cruise_ratio`` is the share of a short move that runs evenly.
    ``path_velocity_mm_s`` and ``path_acceleration_mm_s2`` are limits along the path, whatever its direction.
    ``look_ahead_blocks``: how many blocks the control knows at once, None for enough.  However slow a feed,
    it makes ``least_steps_per_s`` (of the axis that has most to make), and ``least_feed_mm_s``.
    ``segment_s``: the time for which it works out steps at once.
    """

    name: ClassVar[str] = "junction"
    is_single_precision: ClassVar[bool] = True
    plans_whole: ClassVar[bool] = True

    junction_deviation_mm: float = 0.01
    corner_velocity_mm_s: float | None = None
    min_cruise_ratio: float = 0.0
    path_velocity_mm_s: float = inf
    path_acceleration_mm_s2: float = inf
    look_ahead_blocks: int | None = None
    least_steps_per_s: float = 0.0
    least_feed_mm_s: float = 0.0
    segment_s: float = 0.0

    def along(self, direction: Sequence[float], axes: Sequence[AxisLimits]) -> Self:
        """See :meth:`ControlLaw.along`; the limits along the path count beside those of the axes."""
        law = super().along(direction, axes)
        is_path = self.path_acceleration_mm_s2 < law.acceleration_mm_s2
        return replace(
            law,
            velocity_mm_s=min(law.velocity_mm_s, self.path_velocity_mm_s),
            acceleration_mm_s2=min(law.acceleration_mm_s2, self.path_acceleration_mm_s2),
            axis="the path" if is_path else law.axis,
        )

    def block_times(
        self, lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, *, before_mm_s: float = 0.0
    ) -> Floats:
        """See :meth:`ControlLaw.block_times`."""
        lengths, feeds = self.checked(lengths_mm, feeds_mm_s)
        ways = np.sign(lengths)[:, np.newaxis] * np.array([1.0, 0.0, 0.0])
        moves = Moves(np.abs(lengths), np.full(len(lengths), self.acceleration_mm_s2), ways)
        speeds = self._speeds(moves, self._limits(moves), np.minimum(feeds, self.velocity_mm_s))
        return np.maximum(speeds.times_s(moves), self.read_s)

    def feeds_for_spans(self, blocks: Blocks, spans_s: Floats, plain_from: int) -> Floats:
        """See :meth:`ControlLaw.feeds_for_spans`.

        One factor a stroke, found for all strokes at once by halving: how fast one is left or reached depends
        a little on its neighbours.
        """
        self.refuse_lost_strokes(blocks.lengths_mm)
        feeds_mm_s: Floats = np.abs(blocks.lengths_mm) / spans_s
        strokes = _strokes_before(blocks, spans_s, plain_from)
        if strokes is None:
            return feeds_mm_s
        plan = self._plan_of(blocks)
        strokes = strokes.off_segments(self.segment_s).at_most(plan.longest_s)
        shares = strokes.sums(spans_s) / strokes.wanted_s
        own_mm_s = feeds_mm_s[: strokes.stop] * strokes.spread(shares)

        def late_s(factors: Floats) -> Floats:
            """How much longer than wanted each stroke takes."""
            feeds_mm_s[: strokes.stop] = own_mm_s * strokes.spread(factors)
            return strokes.sums(plan.spans_s(feeds_mm_s)) - strokes.wanted_s

        slow = np.ones(len(strokes.wanted_s))
        reach_mm_s = strokes.spread(
            np.sqrt(strokes.sums(plan.moves.lengths_mm * plan.moves.accelerations_mm_s2))
        )
        most_mm_s = np.minimum(plan.tops_mm_s[: strokes.stop], _ENOUGH * reach_mm_s)
        fast = np.maximum(strokes.most(most_mm_s / own_mm_s), 1.0)
        self._refuse_late(strokes, late_s(fast), plan)
        fastest = fast
        for _ in range(_ROUNDS):
            fast = _least_in_time(slow, fast, late_s)
            is_late = late_s(fast) > _SAME_SHARE * strokes.wanted_s
            if not is_late.any():
                break
            # Their neighbours have become slower since: these search on beside those as they are now.
            slow = fast
            fast = np.where(is_late, fastest, fast)
        return feeds_mm_s

    def motion_between_dwells(self, distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats) -> Motion:
        """See :meth:`ControlLaw.commanded_motion`."""
        self.refuse_lost_strokes(blocks.lengths_mm)
        plan = self._plan_of(blocks)
        speeds = plan.speeds(feeds_mm_s)
        spans_s = plan.real_s(speeds)
        return Motion(spans_s, *ramp_knots(distance_mm, plan.moves, speeds, spans_s))

    def peak_speed_mm_s(self, blocks: Blocks, feeds_mm_s: Floats) -> float | None:
        """See :meth:`ControlLaw.peak_speed_mm_s`; between two knots it is not told."""
        return float(np.sqrt(self._plan_of(blocks).speeds(feeds_mm_s).peaks.max()))

    def _plan_of(self, blocks: Blocks) -> _Plan:
        """The moves of blocks, and what limits them."""
        lengths_mm = np.abs(blocks.lengths_mm)
        ways = blocks.moved_mm / lengths_mm[:, np.newaxis]
        has_mm_s2 = np.minimum(blocks.acceleration_mm_s2, self.path_acceleration_mm_s2)
        tops_mm_s = np.full(len(ways), self.path_velocity_mm_s)
        with np.errstate(divide="ignore"):
            for row, axis in enumerate(self.axes):
                np.minimum(tops_mm_s, axis.velocity_mm_s / np.abs(ways[:, row]), out=tops_mm_s)
        return _Plan(self, Moves(lengths_mm, has_mm_s2, ways), tops_mm_s)

    def _limits(self, moves: Moves) -> Floats:
        """What the joints of moves allow, (n + 1,) squared."""
        if self.every_block_stops:
            return np.zeros(len(moves) + 1)
        if self.corner_velocity_mm_s is not None:
            limits = corner_speed_limits(moves, self.corner_velocity_mm_s, self._square_mm_s2)
        else:
            own = [axis.acceleration_mm_s2 for axis in self.axes] or [self.acceleration_mm_s2]
            axes_mm_s2 = np.minimum(own, self.path_acceleration_mm_s2)
            limits = deviation_limits(moves, self.junction_deviation_mm, axes_mm_s2)
        if self.look_ahead_blocks is None:
            return limits
        return seen_ahead(limits, moves.gains, self.look_ahead_blocks)

    @property
    def _square_mm_s2(self) -> float:
        """The acceleration that ``corner_velocity_mm_s`` is meant with."""
        own = self.path_acceleration_mm_s2
        return own if own < inf else self.acceleration_mm_s2

    def _speeds(self, moves: Moves, limits: Floats, nominal_mm_s: Floats) -> Speeds:
        if self.min_cruise_ratio <= 0.0:
            return planned(moves, limits, nominal_mm_s)
        smooth_mm_s2 = self._square_mm_s2 * (1.0 - self.min_cruise_ratio)
        return planned_smoothly(moves, limits, nominal_mm_s, smooth_mm_s2)

    def _refuse_late(self, strokes: _Strokes, late_s: Floats, plan: _Plan) -> None:
        """Errors: VIB030 to VIB032 where no feed takes the time of a straight stroke."""
        late = np.where(strokes.bends, -inf, late_s / strokes.wanted_s)
        worst = int(late.argmax())
        if late[worst] <= _SAME_SHARE:
            return
        run = strokes.run(worst)
        length_mm = float(plan.moves.lengths_mm[run].sum())
        wanted_s = float(strokes.wanted_s[worst])
        count = run.stop - run.start
        slowest = run.start + int(plan.moves.accelerations_mm_s2[run].argmin())
        law = self.along(plan.moves.ways[slowest].tolist(), self.axes) if self.axes else self
        law.refuse_too_short(length_mm, wanted_s)
        law.feed_for_time(length_mm, wanted_s)
        message = (
            f"a stroke of {length_mm:.4g} mm in {count} blocks takes"
            f" {(late_s[worst] + wanted_s) * MS_PER_S:.4g} ms at any feed,"
            f" {wanted_s * MS_PER_S:.4g} ms are wanted"
        )
        raise RefusalError(
            "VIB030", message, "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
        )

    def _feed_for(self, length_mm: float, time_s: float) -> float:
        return speed_for_time(length_mm, time_s, self.acceleration_mm_s2)

    def _acceleration_for(self, length_mm: float, time_s: float) -> float:
        return 4.0 * length_mm / time_s**2


def _least_in_time(slow: Floats, fast: Floats, late_s: Callable[[Floats], Floats]) -> Floats:
    """The least factors between two, (s,) each, with which no stroke is late, by halving."""
    for _ in range(_HALVINGS):
        middle = np.sqrt(slow * fast)
        is_late = late_s(middle) > 0.0
        slow = np.where(is_late, middle, slow)
        fast = np.where(is_late, fast, middle)
    return fast


@dataclass(frozen=True, eq=False)
class _Plan:
    """Moves under a law, and the fastest that each can be, (n,)."""

    law: Junction
    moves: Moves
    tops_mm_s: Floats

    @cached_property
    def _limits(self) -> Floats:
        return self.law._limits(self.moves)

    def speeds(self, feeds_mm_s: Floats) -> Speeds:
        """How the control plans them with these feeds, (n,)."""
        feeds_mm_s = np.maximum(feeds_mm_s, self.law.least_feed_mm_s)
        return self.law._speeds(self.moves, self._limits, np.minimum(feeds_mm_s, self.tops_mm_s))

    def spans_s(self, feeds_mm_s: Floats) -> Floats:
        """How long each then takes, (n,)."""
        return self.real_s(self.speeds(feeds_mm_s))

    def real_s(self, speeds: Speeds) -> Floats:
        """How long each takes, (n,), with the speeds of its plan: not before it is read, no slow steps."""
        times_s = speeds.times_s(self.moves)
        if self.law.segment_s > 0.0 and self._steps is not None:
            times_s += late_in_first_segments(self.moves, speeds, self._steps, self.law.segment_s)
        return np.maximum(np.minimum(times_s, self.longest_s), self.law.read_s)

    @cached_property
    def _steps(self) -> Floats | None:
        """The most steps that an axis has to make in each, (n,); None where no axis has any."""
        axes = [(row, axis.step_mm) for row, axis in enumerate(self.law.axes) if axis.step_mm > 0.0]
        if not axes:
            return None
        ways_mm = np.abs(self.moves.ways) * self.moves.lengths_mm[:, np.newaxis]
        steps: Floats = np.max([ways_mm[:, row] / step_mm for row, step_mm in axes], axis=0)
        return steps

    @cached_property
    def longest_s(self) -> Floats:
        """How long each takes at most, for its steps and the least feed, (n,)."""
        with np.errstate(divide="ignore"):
            longest_s: Floats = self.moves.lengths_mm / np.float64(self.law.least_feed_mm_s)
        if self.law.least_steps_per_s <= 0.0 or self._steps is None:
            return longest_s
        longest: Floats = np.where(self._steps > 0.0, self._steps / self.law.least_steps_per_s, inf)
        return np.minimum(longest, longest_s)


@dataclass(frozen=True, eq=False)
class _Strokes:
    """Blocks that go the same way along the path: where they begin, and the end of the last one.

    ``wanted_s`` is how long each should take, ``bends`` where it has a corner inside; (s,) each.
    """

    starts: Places
    stop: int
    wanted_s: Floats
    bends: NDArray[np.bool_]

    def at_most(self, longest_s: Floats) -> _Strokes:
        """The same where no block takes longer than this, (n,): what one cannot take, the next one gets."""
        if np.isinf(longest_s).all():
            return self
        most_s = np.minimum(self.sums(longest_s), self.wanted_s.sum())
        over_s = np.cumsum(self.wanted_s - most_s)
        left_s = over_s - np.minimum(np.minimum.accumulate(over_s), 0.0)
        return replace(self, wanted_s=self.wanted_s - np.diff(left_s, prepend=0.0))

    def off_segments(self, segment_s: float) -> _Strokes:
        """The same where no block ends with a segment of time, but a little later, for sure in the next one.

        In single precision a little of its way may be left there, at next to no speed, which takes up to a
        twentieth of a segment more.
        """
        if segment_s <= 0.0:
            return self
        off_s = self.wanted_s - np.rint(self.wanted_s / segment_s) * segment_s
        is_alone = np.diff(self.starts, append=self.stop) == 1
        is_edge = is_alone & (np.abs(off_s) < _EDGE_S)
        return replace(self, wanted_s=np.where(is_edge, self.wanted_s - off_s + _EDGE_S, self.wanted_s))

    def sums(self, values: Floats) -> Floats:
        """Sums of values of blocks, (n,) -> (s,)."""
        found: Floats = np.add.reduceat(values[: self.stop], self.starts)
        return found

    def most(self, values: Floats) -> Floats:
        """The largest of values of blocks, (n,) -> (s,)."""
        found: Floats = np.maximum.reduceat(values[: self.stop], self.starts)
        return found

    def spread(self, values: Floats) -> Floats:
        """Values of strokes for each of their blocks, (s,) -> (n,)."""
        return np.repeat(values, np.diff(self.starts, append=self.stop))

    def run(self, stroke: int) -> slice:
        """The blocks of one stroke."""
        ends = np.append(self.starts[1:], self.stop)
        return slice(int(self.starts[stroke]), int(ends[stroke]))


def _strokes_before(blocks: Blocks, spans_s: Floats, last: int) -> _Strokes | None:
    """The strokes that end before block ``last``; None where there are none."""
    bounds = np.concatenate(([0], turns_of(blocks.lengths_mm), [len(spans_s)]))
    bounds = bounds[bounds <= last]
    if len(bounds) < 2:
        return None
    starts, stop = bounds[:-1], int(bounds[-1])
    inside = blocks.corners[:stop] > CORNER_LIMIT
    inside[np.append(starts[1:], stop) - 1] = False
    wanted_s = np.add.reduceat(spans_s[:stop], starts)
    return _Strokes(starts, stop, wanted_s, np.logical_or.reduceat(inside, starts))
