"""The path that has just been cut: a feed move back over it cuts air."""

from __future__ import annotations

import math

from chipbreak.model.block_effect import Move
from chipbreak.model.modal import Position

_Corner = tuple[float, ...]
_SAME_MM = 1e-6
_ROUNDING_MM = 1e-10  # of sums of lengths; a spring pass a few micrometres deeper is no way back


class CutPath:
    """Follows the moves of a program and tells a way back from a cut.

    Only straight cuts since the last move of another kind count: their corners, the newest last.
    """

    def __init__(self) -> None:
        self.corners: list[_Corner] = []

    def forget(self) -> None:
        """What was cut is no longer known."""
        self.corners = []

    def is_way_back(self, move: Move | None) -> bool:
        """Follow a move; True for one that leads nowhere but back over what has just been cut."""
        if move is None:
            return False
        end = _corner(move.end)
        if move.kind != "line":
            self.corners = [end]
            return False
        start = _corner(move.start)
        if not self.corners or not _is_same(self.corners[-1], start):
            self.corners = [start]
        return self._goes_back(end)

    def _goes_back(self, end: _Corner) -> bool:
        corners = self.corners
        if _is_same(corners[-1], end):
            corners[-1] = end
            return False  # no length
        at = len(corners) - 1
        while at > 0:
            if _lies_between(end, corners[at], corners[at - 1]):
                del corners[at:]
                if not _is_same(corners[-1], end):
                    corners.append(end)
                return True
            if not _lies_between(corners[at - 1], corners[at], end):
                break
            at -= 1
        # Those on the way lie on one line with its ends, and need not be looked at again.
        del corners[at + 1 : -1]
        corners.append(end)
        return False


def _lies_between(point: _Corner, one: _Corner, other: _Corner) -> bool:
    """True for a point on the straight line from one to the other."""
    round_mm = math.dist(one, point) + math.dist(point, other)
    return round_mm - math.dist(one, other) <= _ROUNDING_MM


def _is_same(one: _Corner, other: _Corner) -> bool:
    return math.dist(one, other) <= _SAME_MM


def _corner(place: Position) -> _Corner:
    """An axis whose place is not known has not moved."""
    return tuple([0.0 if math.isnan(value) else value for value in place])
