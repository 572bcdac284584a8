"""What stands in the way of the passes of a cycle: the height of the stock along the direction of cutting.

Passes at levels leave steps, so the height is constant between breaks.  A move that would take the tool
through the stock in rapid, or deeper than the cycle says, is a fault of ours.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from itertools import pairwise

from chipbreak.cycles.contour import Point
from chipbreak.text.diagnostics import SelfCheckError

_SAME_MM = 1e-6


class Stock:
    """Stock from ``first_mm`` to ``last_mm`` along t, all of one height [mm] at first; nothing elsewhere."""

    def __init__(self, first_mm: float, last_mm: float, height_mm: float) -> None:
        self.breaks = [first_mm, last_mm]
        self.heights = [height_mm]

    def _split(self, t_mm: float) -> int:
        """Make a break; the number of the stretch that begins there."""
        at = bisect_left(self.breaks, t_mm - _SAME_MM)
        if at < len(self.breaks) and abs(self.breaks[at] - t_mm) <= _SAME_MM:
            return at
        if at in (0, len(self.breaks)):
            return min(at, len(self.breaks) - 1)
        self.breaks.insert(at, t_mm)
        self.heights.insert(at, self.heights[at - 1])
        return at

    def cut(self, first_mm: float, last_mm: float, level_mm: float, depth_mm: float = math.inf) -> None:
        """Take all above a level away.  Raises SelfCheckError where more than ``depth_mm`` is taken."""
        begin, end = self._split(first_mm), self._split(last_mm)
        for index in range(begin, end):
            taken = self.heights[index] - level_mm
            if taken > depth_mm + _SAME_MM:
                raise SelfCheckError(f"a pass takes {taken:z.4f} mm, {depth_mm:g} are allowed")
            self.heights[index] = min(self.heights[index], level_mm)

    def highest(self, first_mm: float, last_mm: float) -> float:
        """The greatest height between two places; minus infinity where there is no stock."""
        low, high = min(first_mm, last_mm) + _SAME_MM, max(first_mm, last_mm) - _SAME_MM
        begin = max(bisect_right(self.breaks, low) - 1, 0)
        end = min(bisect_left(self.breaks, high), len(self.heights))
        return max(self.heights[begin:end], default=-math.inf)

    def check_rapid(self, start: Point, end: Point) -> None:
        """Raises SelfCheckError when a straight rapid would go through the stock."""
        if abs(start.t - end.t) <= _SAME_MM:
            if self._beside(start.t) > min(start.h, end.h) + _SAME_MM:
                raise SelfCheckError(f"a rapid from {start} to {end} would go through standing stock")
            return
        inside = [t for t in self.breaks if min(start.t, end.t) < t < max(start.t, end.t)]
        places = sorted([start.t, *inside, end.t])
        for first, last in pairwise(places):
            lowest = min(_height(start, end, first), _height(start, end, last))
            if self.highest(first, last) > lowest + _SAME_MM:
                raise SelfCheckError(f"a rapid from {start} to {end} would go through standing stock")

    def _beside(self, t_mm: float) -> float:
        """The height at a place; at a wall the lower side, where the tool is."""
        left = bisect_left(self.breaks, t_mm - _SAME_MM) - 1
        right = bisect_right(self.breaks, t_mm + _SAME_MM) - 1
        return min(self.heights[at] if 0 <= at < len(self.heights) else -math.inf for at in (left, right))


def _height(start: Point, end: Point, t_mm: float) -> float:
    return start.h + (t_mm - start.t) / (end.t - start.t) * (end.h - start.h)
