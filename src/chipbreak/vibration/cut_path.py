"""The path that has just been cut: a feed move back over it cuts air."""

from __future__ import annotations

import math

from chipbreak.model.block_effect import Move
from chipbreak.model.modal import Position

_SAME_MM = 1e-6
_ROUNDING_MM = 1e-10  # of sums of lengths; a spring pass a few micrometres deeper is no way back


class CutPath:
    """Follows the moves of a program and tells a way back from a cut.

    Only straight cuts since the last move of another kind count: their corners, the newest last.
    """

    def __init__(self) -> None:
        self.corners: list[Position] = []

    def forget(self) -> None:
        """What was cut is no longer known."""
        self.corners = []

    def is_way_back(self, move: Move | None) -> bool:
        """Follow a move; True for one that leads nowhere but back over what has just been cut."""
        if move is None:
            return False
        if move.kind != "line":
            self.corners = [move.end]
            return False
        if not self.corners or not _is_same(self.corners[-1], move.start):
            self.corners = [move.start]
        behind = _retraced(self.corners, move.end)
        if behind is None:
            self.corners.append(move.end)
            return False
        self.corners = behind
        return True


def _retraced(corners: list[Position], end: Position) -> list[Position] | None:
    """The corners that are left behind a way back to ``end``; None where the move is no way back."""
    if _is_same(corners[-1], end):
        return None  # no length
    at = len(corners) - 1
    while at > 0:
        here = corners[at]
        before = corners[at - 1]
        if _lies_between(end, here, before):
            return [*corners[:at], end]
        if not _lies_between(before, here, end):
            return None
        at -= 1
    return None


def _lies_between(point: Position, one: Position, other: Position) -> bool:
    """True for a point on the straight line from one to the other."""
    direct_mm = math.dist(_numbers(one), _numbers(other))
    round_mm = math.dist(_numbers(one), _numbers(point)) + math.dist(_numbers(point), _numbers(other))
    return round_mm - direct_mm <= _ROUNDING_MM


def _is_same(one: Position, other: Position) -> bool:
    return math.dist(_numbers(one), _numbers(other)) <= _SAME_MM


def _numbers(place: Position) -> list[float]:
    """An axis whose place is not known has not moved."""
    return [0.0 if math.isnan(value) else value for value in place]
