"""What an unrolled cycle promises, looked after in the blocks that were written.

Behind it the control is in the state that it was in before it, but for F and S, and the tool is back where
the cycle began.  The blocks of a roughing cycle leave the contour with its allowances and nothing else, take
no more than the depth in one pass, and rush through no stock.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from chipbreak.cycles.contour import Frame, Point, Segment, filled
from chipbreak.cycles.reading import Contour, leg_of, segment_of
from chipbreak.cycles.roughing import Motion, Roughing
from chipbreak.editing.promise import Promise, Written
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.toolpath import path_of
from chipbreak.model.block_effect import Move
from chipbreak.model.modal import Position, State
from chipbreak.model.state_difference import difference, moved
from chipbreak.model.words import settles_motion
from chipbreak.text.diagnostics import SelfCheckError

_MOST_PLACES = 200_001
_BESIDE = 4
_POINTS_OF_ARC = 2001


class UnrolledCycle(Promise, kw_only=True):
    """The tool comes back to where it was, and nothing but F and S may be another.

    Where ``leaves_motion``, the next move says its own motion code, and where ``leaves_compensation`` its own
    G40, G41 or G42.  ``end`` is where the tool stays on a control that does not take it back.
    """

    leaves_speed: bool = True
    leaves_compensation: bool = False
    end: Position | None = None

    def check(self, written: Written) -> None:
        """Compare the states before and behind the blocks.  Raises SelfCheckError."""
        before = written.result.before(written.region.first)
        wrong = self._moved(written, before)
        was = written.original.before(written.edit.first)
        if settles_motion(
            written.original.program.block(written.edit.first), written.original.settings.dialect
        ):
            was = was.with_motion(before.modes.motion)  # a cycle right before it may have left another
        pairs = ((was, before), (written.was_behind, written.now_behind))
        wrong = wrong or next((said for was, now in pairs if (said := self._difference(was, now))), "")
        if wrong:
            raise SelfCheckError(f"{wrong} differs at the cycle in line {written.edit.first + 1}")

    def _moved(self, written: Written, before: State) -> str:
        """Which axis is not where it must be behind the blocks."""
        there = before
        if self.end is not None:  # Y stays where the blocks before have left it
            there = before._replace(position=before.position._replace(x=self.end.x, z=self.end.z))
        step_mm = written.original.settings.output.step_mm(is_inch=before.is_inch)
        return moved(there, written.now_behind, 0.0 if self.end is None else step_mm)

    def _difference(self, was: State, now: State) -> str:
        """What differs, but for F, which the original is not known to set in a cycle."""
        if now.ended:
            return ""  # a contour behind the end of the program
        was = was._replace(feed=now.feed)
        if self.leaves_compensation:
            was = was._replace(modes=was.modes._replace(compensation=now.modes.compensation))
        return difference(was.with_motion(now.modes.motion) if self.leaves_motion else was, now)


class RemovedContour(UnrolledCycle, kw_only=True):
    """A contour that nothing calls any more: no blocks stand for it."""


class CopiedContour(UnrolledCycle, kw_only=True):
    """The finishing cut: the moves of the contour, and the way back to the start."""

    ends: tuple[Position, ...]

    def check(self, written: Written) -> None:
        """Compare the ends of its moves with those of the contour.  Raises SelfCheckError."""
        super().check(written)
        ends = [move.end for move in _moves(written)][: len(self.ends)]
        near_mm = 1.01 * written.original.settings.output.step_mm(is_inch=written.now_behind.is_inch)
        pairs = zip(self.ends, ends, strict=False)
        misses = any(abs(a.x - b.x) > near_mm or abs(a.z - b.z) > near_mm for a, b in pairs)
        if misses or len(ends) != len(self.ends):
            raise SelfCheckError(f"the finishing cut at line {written.edit.first + 1} misses its contour")


class SinglePasses(UnrolledCycle, kw_only=True):
    """Passes of four moves each: to the level, along it, out, and back to the start."""

    moves: tuple[tuple[bool, float, float], ...]
    leaves_motion: bool = True

    def check(self, written: Written) -> None:
        """Compare the moves: whether each cuts, Z and radius of its end.  Raises SelfCheckError."""
        super().check(written)
        near_mm = 1.01 * written.original.settings.output.step_mm(is_inch=written.now_behind.is_inch)
        found = [(move.is_cut, move.end.z, move.end.x) for move in _moves(written)]
        pairs = zip(self.moves, found, strict=False)
        wrong = len(self.moves) != len(found) or any(
            a[0] != b[0] or abs(a[1] - b[1]) > near_mm or abs(a[2] - b[2]) > near_mm for a, b in pairs
        )
        if wrong:
            raise SelfCheckError(f"the passes at line {written.edit.first + 1} are not those of the cycle")


class PlannedMoves(UnrolledCycle, kw_only=True):
    """Each move as it was planned, in the axes of ``frame``; one that the digits swallow may be missing."""

    frame: Frame
    motions: tuple[Motion, ...]

    def check(self, written: Written) -> None:
        """Compare the moves one by one.  Raises SelfCheckError."""
        super().check(written)
        near_mm = 3.0 * written.original.settings.output.step_mm(is_inch=written.now_behind.is_inch)
        found = _moves(written)
        move = next(found, None)
        place = written.result.before(written.region.first).position
        at = self.frame.inside(place.z, place.x)
        for motion in self.motions:
            if move is not None and self._is_same(at, motion, move, near_mm):
                move = next(found, None)
            elif math.dist(at, motion.end) > near_mm:
                break
            at = motion.end
        else:
            if move is None:
                return
        raise SelfCheckError(f"the passes at line {written.edit.first + 1} are not those of the cycle")

    def _is_same(self, at: Point, motion: Motion, move: Move, near_mm: float) -> bool:
        made = segment_of(move, self.frame)
        if (
            motion.cuts != move.is_cut
            or motion.turn != made.turn
            or math.dist(motion.end, made.end) > near_mm
        ):
            return False
        if motion.centre is None or made.centre is None:
            return motion.centre is made.centre
        # Digits may put the end of a short arc behind its start, and it would become a whole circle.
        sweep = Segment(at, motion.end, motion.centre, motion.turn).sweep
        is_as_long = abs(abs(sweep) - abs(made.sweep)) < math.pi
        return is_as_long and math.dist(motion.centre, made.centre) <= near_mm


class OffsetMoves(PlannedMoves, kw_only=True):
    """Moves that nose compensation would have offset; behind them the tool is where it was to lead out."""

    def _moved(self, written: Written, before: State) -> str:
        """Which axis is not where the original leads out to."""
        step_mm = written.original.settings.output.step_mm(is_inch=before.is_inch)
        return moved(written.was_behind, written.now_behind, step_mm)


class UnrolledRoughing(UnrolledCycle, kw_only=True):
    """The passes of a roughing cycle remove the stock over its contour."""

    cycle: Roughing
    contour: Contour

    def check(self, written: Written) -> None:
        """Run the blocks against the stock.  Raises SelfCheckError."""
        super().check(written)
        settings = written.original.settings
        step_mm = settings.output.step_mm(is_inch=written.now_behind.is_inch)
        _check_stock(self.cycle, self.contour.frame, step_mm, tuple(_moves(written)))


# Programs rough the same contour from the same start for one part after the other.
@lru_cache(maxsize=4)
def _check_stock(cycle: Roughing, frame: Frame, step_mm: float, moves: tuple[Move, ...]) -> None:
    """Run moves against the stock of a cycle.  Raises SelfCheckError."""
    left = _Left(cycle, step_mm)
    for move in moves:
        # A control that goes to the start from a place that is not known does so by itself, too.
        if not math.isnan(move.start.x + move.start.z):
            left.run(_way(move, frame), is_cut=move.is_cut)
    left.compare()


def _way(move: Move, frame: Frame) -> Floats:
    """Places on a move in the axes of the passes, (n, 2)."""
    if move.kind in ("rapid", "line"):
        return np.array([frame.inside(end.z, end.x) for end in (move.start, move.end)])
    path = path_of([leg_of(move)])
    points = path.points(np.linspace(0.0, path.length_mm, _POINTS_OF_ARC))
    return np.array([frame.inside(z, x) for x, _, z in points.tolist()])


class _Left:
    """The stock that is left, as heights on a fine grid along the passes.

    What is narrower than a few steps of the output is not judged: the digits decide there.
    """

    def __init__(self, cycle: Roughing, step_mm: float) -> None:
        self.cycle = cycle
        self.tolerance_mm = 3.0 * step_mm
        contour = _outline(cycle.rough_contour)
        first_mm = cycle.departure.t
        last_mm = float(contour[:, 0].max())
        count = min(math.ceil((last_mm - first_mm) / step_mm) + 1, _MOST_PLACES)
        self.t = np.linspace(first_mm, last_mm, max(count, 2))
        heights = np.interp(self.t, contour[:, 0], contour[:, 1])
        # A ridge or a groove between two places of the grid is part of the contour, too.
        step = self.t[1] - self.t[0]
        nearest = np.clip(np.rint((contour[:, 0] - first_mm) / step), 0, len(self.t) - 1).astype(np.intp)
        self.highest, self.lowest = heights.copy(), heights
        np.maximum.at(self.highest, nearest, contour[:, 1])
        np.minimum.at(self.lowest, nearest, contour[:, 1])
        self.height = np.full(len(self.t), cycle.start.h)
        if cycle.only_pockets:
            rest = _outline(filled(cycle.rough_contour).contour)
            self.height = np.minimum(self.height, np.interp(self.t, rest[:, 0], rest[:, 1]))
        # What stands before a steep line is as thick as it stands along t, not as it stands in height.
        self.beside = math.ceil((cycle.t_first_mm + cycle.h_first_mm) / (self.t[1] - self.t[0]))

    def run(self, way: Floats, *, is_cut: bool) -> None:
        """One move of the tool."""
        sinks = bool(way[-1, 1] < way[0, 1])
        way = way if way[-1, 0] >= way[0, 0] else way[::-1]
        onward = np.maximum.accumulate(way[:, 0])
        if float((onward - way[:, 0]).max()) > self.tolerance_mm:
            raise SelfCheckError("a move of an unrolled cycle turns back along its passes")
        low, high = np.searchsorted(self.t, (onward[0], onward[-1])).tolist()
        if sinks and not is_cut and high - low < _BESIDE:
            self._check_sinking(float(way[:, 1].min()), low)
        there = _heights_at(self.t[low:high], onward, way[:, 1])
        taken_mm = self._taken_mm(low, there, is_cut=is_cut)
        if not is_cut and taken_mm > self.tolerance_mm:
            raise SelfCheckError(f"a rapid of an unrolled cycle goes through {taken_mm:z.3f} mm of stock")
        if taken_mm > self.cycle.depth_mm + self.tolerance_mm:
            raise SelfCheckError(f"a pass takes {taken_mm:z.3f} mm, {self.cycle.depth_mm:g} are commanded")
        if is_cut:
            self.height[low:high] = np.minimum(self.height[low:high], there)

    def _taken_mm(self, low: int, there: Floats, *, is_cut: bool) -> float:
        """How much a move takes at most; strips that the digits blur do not count."""
        high = low + len(there)
        allowed_mm = self.tolerance_mm + (self.cycle.depth_mm if is_cut else 0.0)
        taken = self.height[low:high] - there
        most_mm = float(taken.max(initial=0.0))
        if most_mm <= allowed_mm:
            return most_mm
        if is_cut and self.beside:
            first = max(low - self.beside, 0)
            padded = np.pad(self.height[first : high + self.beside], self.beside, mode="edge")
            begin = low - first
            taken = _lowest_near(padded, self.beside)[begin : begin + len(there)] - there
        return float(_lowest_near(taken, _BESIDE).max(initial=0.0))

    def _check_sinking(self, lowest_mm: float, at: int) -> None:
        """A rapid straight down must find free room on one of its sides at least."""
        beside = self.height[max(at - _BESIDE, 0) : at + _BESIDE]
        if _BESIDE < at < len(self.t) and float(beside.min()) > lowest_mm + self.tolerance_mm:
            raise SelfCheckError("a rapid of an unrolled cycle goes down into stock")

    def compare(self) -> None:
        """What is left is the contour with its allowances, as far as the stock reached."""
        highest = np.minimum(self.highest, self.cycle.start.h)
        lowest = np.minimum(self.lowest, self.cycle.start.h)
        within = slice(_BESIDE, -_BESIDE)
        # Without a pass along the contour steps are left, none of them as high as a pass is deep.
        steps_mm = 0.0 if self.cycle.ends_along_contour else self.cycle.depth_mm
        above_mm = float((self.height[within] + _lowest_near(-highest)).max(initial=0.0)) - steps_mm
        below_mm = float((_lowest_near(lowest) - self.height[within]).max(initial=0.0))
        if max(above_mm, below_mm) > self.tolerance_mm:
            wrong = f"{above_mm:z.3f} mm too much, {below_mm:z.3f} mm too little"
            raise SelfCheckError(f"an unrolled cycle leaves {wrong} over its contour")


def _heights_at(places: Floats, t_mm: Floats, h_mm: Floats) -> Floats:
    """The heights of a way at places along it; most ways are straight."""
    if len(t_mm) > 2 or t_mm[-1] <= t_mm[0]:
        return np.interp(places, t_mm, h_mm)
    slope = (h_mm[-1] - h_mm[0]) / (t_mm[-1] - t_mm[0])
    heights: Floats = h_mm[0] + (places - t_mm[0]) * slope
    return heights


def _lowest_near(heights: Floats, beside: int = _BESIDE) -> Floats:
    """The lowest of each height and its ``beside`` neighbours on either side; fewer heights come out."""
    window = 2 * beside + 1
    if len(heights) < window:
        return heights[:0]
    lowest, width = heights, 1
    while width < window:  # of two windows side by side the lower one
        step = min(width, window - width)
        lowest = np.minimum(lowest[:-step], lowest[step:])
        width += step
    return lowest


def _outline(contour: Sequence[Segment]) -> Floats:
    """Places on a contour, (n, 2)."""
    rows = [contour[0].start]
    for one in contour:
        count = 2 if one.centre is None else _POINTS_OF_ARC
        rows += [one.point(share) for share in np.linspace(0.0, 1.0, count).tolist()[1:]]
    return np.array(rows)


def _moves(written: Written) -> Iterator[Move]:
    """The moves of the blocks that stand for the cycle."""
    for effect in written.result.effects_of(written.region.body, written.region.last):
        if effect.move is not None:
            yield effect.move
