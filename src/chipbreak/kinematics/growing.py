"""A row of numbers that comes in pieces, and is never there twice."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from chipbreak.kinematics.floats import Floats

_LEAST = 1 << 10
_GROWTH = 1.25  # what is not yet filled is memory too


class Growing:
    """The pieces so far; where they are joined at the end, a long row is in memory twice."""

    def __init__(self) -> None:
        self._row: Floats = np.empty(_LEAST)
        self._size = 0

    def add(self, piece: Floats) -> None:
        """A piece more, (k,)."""
        end = self._size + len(piece)
        if end > len(self._row):
            self._row.resize(max(end, int(_GROWTH * len(self._row))), refcheck=False)
        self._row[self._size : end] = piece
        self._size = end

    def whole(self) -> Floats:
        """All pieces in one row, (n,); nothing may be added afterwards."""
        self._row.resize(self._size, refcheck=False)
        return self._row


def joined(pieces: Iterable[Floats]) -> Floats:
    """Pieces that are made one by one in one row, (n,).

    >>> joined(np.arange(size) + 0.0 for size in (2, 3))
    array([0., 1., 0., 1., 2.])
    """
    row = Growing()
    for piece in pieces:
        row.add(piece)
    return row.whole()
