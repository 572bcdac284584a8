"""What the test asks of a machine: groups of strokes, each of which ends where it began."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import floor

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MS_PER_S, S_PER_MIN

USUAL_FEED_MM_MIN = 3000.0
LEAST_TRAVEL_MM = 5.0
LEAST_FEED_MM_MIN = 300.0
_BLOCK_MM = 0.02  # of what is read block by block
_BLOCKS_A_WAY = 100
_BLOCKS_PER_S = (100.0, 250.0, 500.0, 1000.0)
# Shares of the travel and of the highest feed, and how often: long ways first, each slowly first.
_LONG = ((1.0, 0.2, 2), (1.0, 0.5, 4), (1.0, 1.0, 6), (0.2, 0.3, 8), (0.2, 1.0, 12))
# Short strokes as they break chips: mm and ms.  No control reads much shorter ones block by block.
_SHORT = ((1.0, 20.0), (0.3, 60.0), (0.2, 36.0), (0.1, 24.0), (0.5, 16.0), (0.2, 16.0), (0.1, 16.0))
_SHORT_STROKES = 24
_DIGITS = 3


class Group(NamedTuple):
    """Strokes of an axis there and back, each of ``stroke_mm`` and written as ``blocks`` blocks."""

    name: str
    axis: str
    stroke_mm: float
    feed_mm_min: float
    strokes: int
    blocks: int = 1

    @property
    def moves_mm(self) -> Floats:
        """The blocks, (n, 3), in X, Y and Z; together they lead back to the start."""
        return _moves_of(self)

    @property
    def along_mm(self) -> Floats:
        """The same blocks as signed lengths along the axis, (n,)."""
        lengths: Floats = self.moves_mm.sum(axis=1)
        return lengths

    @property
    def feed_mm_s(self) -> float:
        """Its F in mm/s."""
        return self.feed_mm_min / S_PER_MIN

    @property
    def ideal_s(self) -> float:
        """How long it takes where every block takes its time."""
        return self.strokes * self.stroke_mm / self.feed_mm_s

    @property
    def told(self) -> str:
        """What it is, for people."""
        way = f"{self.stroke_mm:g} mm at F{self.feed_mm_min:g}"
        pieces = f", {self.blocks} blocks each" if self.blocks > 1 else ""
        return f"{self.strokes} strokes of {way}{pieces}"


@lru_cache(maxsize=256)
def _moves_of(group: Group) -> Floats:
    moves = np.zeros((group.strokes, 3))
    moves[::2, AXES.index(group.axis)] = group.stroke_mm / group.blocks
    moves[1::2, AXES.index(group.axis)] = -group.stroke_mm / group.blocks
    moves = np.repeat(moves, group.blocks, axis=0)
    moves.flags.writeable = False
    return moves


def usual_axes(settings: Settings) -> str:
    """The axes that are tested where nobody says which."""
    return "XZ" if settings.dialect.is_lathe else "XYZ"


def usual_feed_mm_min(settings: Settings, axes: Sequence[str]) -> float:
    """The highest feed of the test: what every axis can do, and no more than is good for strokes."""
    said = [settings.axes[axis].max_velocity_mm_min for axis in axes]
    return min([USUAL_FEED_MM_MIN, *(one for one in said if one is not None)])


def groups_for(axes: str, travel_mm: float, feed_mm_min: float, repeats: int = 1) -> tuple[Group, ...]:
    """The groups of a test on these axes, within ``travel_mm`` of the start in plus direction.

    ``repeats`` is how often each is done in a row, for a clock that is read by a person.
    """
    found = [group for axis in axes for group in _of_axis(axis, travel_mm, feed_mm_min)]
    found += _of_blocks(axes[-1], feed_mm_min)
    return tuple(one._replace(strokes=one.strokes * repeats) for one in found)


def _of_axis(axis: str, travel_mm: float, feed_mm_min: float) -> Iterator[Group]:
    number = 0
    for share, speed, strokes in _LONG:
        number += 1
        way_mm = round(share * travel_mm, _DIGITS)
        yield Group(f"{axis}{number}", axis, way_mm, floor(speed * feed_mm_min), strokes)
    for way_mm, time_ms in _SHORT:
        number += 1
        feed = floor(min(way_mm / time_ms * MS_PER_S * S_PER_MIN, feed_mm_min))
        yield Group(f"{axis}{number}", axis, way_mm, feed, _SHORT_STROKES)


def _of_blocks(axis: str, feed_mm_min: float) -> Iterator[Group]:
    for number, rate in enumerate(_BLOCKS_PER_S, 1):
        feed = min(rate * _BLOCK_MM * S_PER_MIN, feed_mm_min)
        yield Group(f"B{number}", axis, _BLOCK_MM * _BLOCKS_A_WAY, feed, 2, _BLOCKS_A_WAY)


def longest_mm(groups: Sequence[Group], axis: str) -> float:
    """How far an axis goes from the start at most."""
    row = AXES.index(axis)
    ways = [float(np.cumsum(group.moves_mm[:, row]).max(initial=0.0)) for group in groups]
    return max(ways, default=0.0)


def ideal_s(groups: Sequence[Group], rest_s: float) -> float:
    """How long all of them take, with a rest before each, where every block takes its time."""
    return sum(group.ideal_s + rest_s for group in groups)


def is_a_group(one: Group) -> bool:
    """True where its numbers are such as this module makes."""
    sizes = 0.0 < one.stroke_mm < 1e4 and 0.0 < one.feed_mm_min < 1e6
    counts = one.strokes % 2 == 0 and one.blocks >= 1
    return one.axis in tuple(AXES) and sizes and counts and 0 < one.strokes * one.blocks <= 100_000
