"""What an unrolled cycle promises, looked after in the blocks that were written.

Behind it the control is in the state that it was in before it, but for F and S, and the tool is back where
the cycle began.  The blocks of a roughing cycle leave the contour with its allowances and nothing else, take
no more than the depth in one pass, and rush through no stock.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chipbreak.cycles.reading import Contour, leg_of
from chipbreak.cycles.roughing import Roughing
from chipbreak.editing.promise import Promise, Written
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.toolpath import path_of
from chipbreak.model.block_effect import Move
from chipbreak.model.modal import Position, State
from chipbreak.model.state_difference import difference, moved
from chipbreak.text.diagnostics import SelfCheckError

_PLACES = 4001
_SAME_MM = 1e-6
_POINTS_OF_ARC = 2001


class UnrolledCycle(Promise, kw_only=True):
    """The tool comes back to where it was, and nothing but F and S may be another.

    Where ``leaves_motion``, the next move says its own motion code.
    """

    leaves_speed: bool = True

    def check(self, written: Written) -> None:
        """Compare the states before and behind the blocks.  Raises SelfCheckError."""
        before = written.result.before(written.region.first)
        wrong = moved(before, written.now_behind)
        pairs = (
            (written.original.before(written.edit.first), before),
            (written.was_behind, written.now_behind),
        )
        wrong = wrong or next((said for was, now in pairs if (said := self._difference(was, now))), "")
        if wrong:
            raise SelfCheckError(f"{wrong} differs at the cycle in line {written.edit.first + 1}")

    def _difference(self, was: State, now: State) -> str:
        """What differs, but for F, which the original is not known to set in a cycle."""
        if now.ended:
            return ""  # a contour behind the end of the program
        was = was._replace(feed=now.feed)
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
        pairs = zip(self.ends, ends, strict=True)
        if any(abs(a.x - b.x) > _SAME_MM or abs(a.z - b.z) > _SAME_MM for a, b in pairs):
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


class UnrolledRoughing(UnrolledCycle, kw_only=True):
    """The passes of a roughing cycle remove the stock over its contour."""

    cycle: Roughing
    contour: Contour

    def check(self, written: Written) -> None:
        """Run the blocks against the stock.  Raises SelfCheckError."""
        super().check(written)
        settings = written.original.settings
        step_mm = settings.output.step_mm(is_inch=written.now_behind.is_inch)
        left = _Left(self.cycle, step_mm)
        for move in _moves(written):
            left.run(self._way(move), is_cut=move.is_cut)
        if self.cycle.follows:
            left.compare()

    def _way(self, move: Move) -> Floats:
        """Places on a move in the axes of the passes, (n, 2)."""
        if move.kind in ("rapid", "line"):
            ends = (move.start, move.end)
            return np.array([self.contour.frame.inside(end.z, end.x) for end in ends])
        path = path_of([leg_of(move)])
        points = path.points(np.linspace(0.0, path.length_mm, _POINTS_OF_ARC))
        return np.array([self.contour.frame.inside(z, x) for x, _, z in points.tolist()])


class _Left:
    """The stock that is left, as heights at places along the passes."""

    def __init__(self, cycle: Roughing, step_mm: float) -> None:
        self.cycle = cycle
        self.tolerance_mm = 3.0 * step_mm
        self.contour = _outline(cycle)
        first_mm, last_mm = cycle.departure.t, float(self.contour[:, 0].max())
        joints = np.unique(np.append(self.contour[:, 0], [first_mm, last_mm]))
        middles = (joints[1:] + joints[:-1]) / 2.0
        places = np.unique(np.append(np.linspace(first_mm, last_mm, _PLACES), middles))
        # Beside a joint the digits of the output decide on which side of it a place is.
        at = np.clip(np.searchsorted(joints, places), 1, len(joints) - 1)
        beside_mm = np.minimum(places - joints[at - 1], joints[at] - places)
        self.t = places[beside_mm > self.tolerance_mm]
        self.height = np.full(len(self.t), cycle.start.h)

    def run(self, way: Floats, *, is_cut: bool) -> None:
        """One move of the tool."""
        if abs(way[-1, 0] - way[0, 0]) <= self.tolerance_mm:
            self._straight_down(way, is_cut=is_cut)
            return
        way = way if way[-1, 0] > way[0, 0] else way[::-1]
        onward = np.maximum.accumulate(way[:, 0])
        if float((onward - way[:, 0]).max()) > self.tolerance_mm:
            raise SelfCheckError("a move of an unrolled cycle turns back along its passes")
        way = np.column_stack((onward, way[:, 1]))
        inside = (self.t > way[0, 0] + self.tolerance_mm) & (self.t < way[-1, 0] - self.tolerance_mm)
        there = self._near(self.t[inside], way).max(axis=0)
        taken_mm = float((self.height[inside] - there).max(initial=0.0))
        if not is_cut and taken_mm > self.tolerance_mm:
            raise SelfCheckError(f"a rapid of an unrolled cycle goes through {taken_mm:z.3f} mm of stock")
        if taken_mm > self.cycle.depth_mm + self.tolerance_mm:
            raise SelfCheckError(f"a pass takes {taken_mm:z.3f} mm, {self.cycle.depth_mm:g} are commanded")
        if is_cut:
            on_way = (self.t >= way[0, 0]) & (self.t <= way[-1, 0])
            there = np.interp(self.t[on_way], way[:, 0], way[:, 1])
            self.height[on_way] = np.minimum(self.height[on_way], there)

    def _straight_down(self, way: Floats, *, is_cut: bool) -> None:
        """A rapid at one place must find free room on one of its sides at least."""
        lowest_mm = float(way[:, 1].min())
        before = self.height[self.t < way[0, 0] - self.tolerance_mm][-1:]
        behind = self.height[self.t > way[0, 0] + self.tolerance_mm][:1]
        if is_cut or not len(before) or not len(behind):
            return
        if min(before[0], behind[0]) > lowest_mm + self.tolerance_mm:
            raise SelfCheckError("a rapid of an unrolled cycle goes down into stock")

    def _near(self, places: Floats, way: Floats) -> Floats:
        """The heights of a way at places and a little before and behind them, (3, n)."""
        shifts = np.array([-1.0, 0.0, 1.0])[:, np.newaxis] * self.tolerance_mm
        heights: Floats = np.interp(places + shifts, way[:, 0], way[:, 1])
        return heights

    def compare(self) -> None:
        """What is left is the contour with its allowances, as far as the stock reached."""
        near = self._near(self.t, self.contour)
        near = np.minimum(near, self.cycle.start.h)
        above_mm = float((self.height - near.max(axis=0)).max(initial=0.0))
        below_mm = float((near.min(axis=0) - self.height).max(initial=0.0))
        if max(above_mm, below_mm) > self.tolerance_mm:
            wrong = f"{above_mm:z.3f} mm too much, {below_mm:z.3f} mm too little"
            raise SelfCheckError(f"an unrolled cycle leaves {wrong} over its contour")


def _outline(cycle: Roughing) -> Floats:
    """Places on the contour with its allowances, (n, 2)."""
    contour = cycle.rough_contour
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
