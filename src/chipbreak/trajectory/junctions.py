"""The straight moves of a cut as the control sees them: where it turns back, where it rests at a corner."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats

Places = NDArray[np.intp]
CORNER_LIMIT = 0.1  # radians that count as straight on
_DIGITS = 9  # of a length in mm: what lies behind them is noise that would make every stretch another one


@dataclass(frozen=True, eq=False)
class Blocks:
    """Straight moves as the control sees them.

    ``lengths_mm`` (n,) are signed along the path, ``moved_mm`` (n, 3) are the moves themselves.
    ``corners`` (n,): how far the direction turns behind each block, the most of any axis's share in it;
    where the tool turns back it does not matter.  ``acceleration_mm_s2`` (n,) is what the axes allow in the
    direction of each block.  ``feed_steps_mm_s`` (n,) are the steps of the feeds that can be typed, None
    where any can.
    """

    lengths_mm: Floats
    moved_mm: Floats
    corners: Floats
    acceleration_mm_s2: Floats
    feed_steps_mm_s: Floats | None = None

    def part(self, run: slice | list[int]) -> Blocks:
        """Some of them; between those that are not in a row there is no corner that counts."""
        steps = None if self.feed_steps_mm_s is None else self.feed_steps_mm_s[run]
        moves = self.lengths_mm[run], self.moved_mm[run]
        return Blocks(*moves, self.corners[run], self.acceleration_mm_s2[run], steps)


def lengths_of(moved_mm: Floats, ahead_mm: Floats) -> tuple[Floats, Floats]:
    """The lengths of moves, (n, 3) -> (n,), and the same rounded and signed along the path."""
    lengths_mm = np.sqrt(np.einsum("ij,ij->i", moved_mm, moved_mm))
    return lengths_mm, np.copysign(np.round(lengths_mm, _DIGITS), ahead_mm)


def blocks_of(moved_mm: Floats, ahead_mm: Floats, accelerations_mm_s2: Sequence[float]) -> Blocks:
    """Blocks from their moves, (n, 3), how far each one leads along the path, (n,), and that of each axis."""
    lengths_mm, signed_mm = lengths_of(moved_mm, ahead_mm)
    ways = moved_mm / lengths_mm[:, np.newaxis]
    turns = np.abs(np.diff(ways, axis=0))
    corners = np.append(np.maximum(np.maximum(turns[:, 0], turns[:, 1]), turns[:, 2]), 0.0)
    allowed = np.full(len(ways), np.inf)
    with np.errstate(divide="ignore"):
        for row, acceleration in enumerate(accelerations_mm_s2):
            if acceleration < np.inf:
                np.minimum(allowed, acceleration / np.abs(ways[:, row]), out=allowed)
    return Blocks(signed_mm, moved_mm, corners, allowed)


def exact_blocks(moved_mm: Floats, ahead_mm: Floats) -> Blocks:
    """:func:`blocks_of` for a control to which corners and acceleration are nothing."""
    _, signed_mm = lengths_of(moved_mm, ahead_mm)
    count = len(signed_mm)
    return Blocks(signed_mm, moved_mm, np.zeros(count), np.full(count, np.inf))


@dataclass(frozen=True, eq=False)
class Parts:
    """Stretches from rest to rest: the strokes, cut where the control rests on the way; (p,) each.

    ``starts`` and ``stops`` are first and behind-last block, and ``strokes`` counts the strokes from 0.
    """

    starts: Places
    stops: Places
    strokes: Places


def parts_of(lengths_mm: Floats, corner_shares: Floats, last: int) -> Parts:
    """The parts of all strokes that end before block ``last``.

    ``corner_shares`` (n,) say what of its limit each corner takes: at 1 or more the control rests there.
    """
    turns = np.flatnonzero(np.diff(np.sign(lengths_mm))) + 1
    bounds = np.concatenate(([0], turns, [len(lengths_mm)]))
    bounds = bounds[bounds <= last]
    end = int(bounds[-1])
    rests = np.flatnonzero(corner_shares[: max(end - 1, 0)] >= 1.0) + 1
    begins = np.zeros(len(lengths_mm) + 1, np.bool_)
    begins[bounds[:-1]] = True
    begins[rests] = True
    starts = np.flatnonzero(begins)
    stops = np.append(starts[1:], [end] * min(len(starts), 1))
    strokes = np.searchsorted(bounds, starts, "right") - 1
    return Parts(starts, stops, strokes)


def least_of_parts(parts: Parts, acceleration_mm_s2: Floats) -> Floats:
    """The least of some accelerations of blocks, (n,), in each part, (p,)."""
    least: Floats = np.minimum.reduceat(acceleration_mm_s2[: parts.stops[-1]], parts.starts)
    return least


def four_digits(values: Floats) -> Floats:
    """Rounded: what lies behind four digits would make every stretch another one."""
    exponent = np.floor(np.log10(values)) - 3.0
    unit = 10.0 ** np.abs(exponent)
    rounded: Floats = np.where(exponent < 0.0, np.rint(values * unit) / unit, np.rint(values / unit) * unit)
    return rounded
