"""Which joints of blocks LinuxCNC runs through, and what a bend costs (``tpSetupTangent`` of its planner).

A joint where the tool turns back to within 2 degrees is a stop and costs nothing.  At any other one the
change of velocity within one servo period, and the acceleration of the block behind it, are set against what
the axes can do.  What takes less than a tenth of an axis is run through, and both blocks lose that share of
their acceleration; anything else is a stop, and both lose the whole tenth although the tool rests there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junctions import Blocks

Bools = NDArray[np.bool_]
KINK_SHARE = 0.1  # arcBlendTangentKinkRatio, of an axis's acceleration
_TURNS_BACK_RAD = pi * 2.0 / 180.0


@dataclass(frozen=True, eq=False)
class Joints:
    """The joints between n blocks, ``runs_on`` (n - 1,), and what these have left to speed up with, (n,)."""

    runs_on: Bools
    acceleration_mm_s2: Floats


@dataclass(frozen=True, eq=False)
class Bends:
    """What of the joints of n blocks does not depend on their feeds.

    ``lengths_mm`` are not signed, ``velocity_mm_s`` and ``acceleration_mm_s2`` are what the axes allow in the
    direction of each block, (n,).  ``turns_back`` (n - 1,): to within 2 degrees.  ``bend_s2_mm`` (n - 1,):
    how far the direction turns, in each axis as a part of its acceleration, the most of any axis.
    """

    lengths_mm: Floats
    velocity_mm_s: Floats
    acceleration_mm_s2: Floats
    turns_back: Bools
    bend_s2_mm: Floats

    def joints(
        self, feeds_mm_s: Floats, period_s: float, override: float, *, every_block_stops: bool
    ) -> Joints:
        """The joints at these feeds, (n,), and a highest feed override; inf with feed per revolution.

        In exact stop no joint is looked at, so none costs anything.
        """
        if every_block_stops:
            return Joints(np.zeros(len(self.turns_back), np.bool_), self.acceleration_mm_s2)
        top = np.minimum(self.velocity_mm_s, self.lengths_mm / period_s)
        if override < np.inf:
            top = np.minimum(top, override * np.minimum(feeds_mm_s, self.velocity_mm_s))
        slower = np.minimum(top[:-1], top[1:])
        share = (slower / period_s + self.acceleration_mm_s2[1:]) * self.bend_s2_mm
        runs_on = ~self.turns_back & (share < KINK_SHARE)
        lost = np.where(self.turns_back, 0.0, np.minimum(share, KINK_SHARE))
        lost = np.concatenate([[0.0], lost, [0.0]])
        left = 1.0 - np.maximum(lost[:-1], lost[1:])
        return Joints(runs_on, self.acceleration_mm_s2 * left)

    def part(self, run: slice | NDArray[Any]) -> Bends:
        """Some blocks in a row, with the joints between them."""
        inner = slice(run.start, run.stop - 1) if isinstance(run, slice) else run[:-1]
        return Bends(
            self.lengths_mm[run],
            self.velocity_mm_s[run],
            self.acceleration_mm_s2[run],
            self.turns_back[inner],
            self.bend_s2_mm[inner],
        )


def bends_of(
    blocks: Blocks, velocities_mm_s: Floats, accelerations_mm_s2: Floats, path: tuple[float, float]
) -> Bends:
    """The bends of blocks on axes with these limits, (3,) each.

    ``path`` is the velocity and the acceleration of a path whose axes have none of their own.
    """
    lengths_mm = np.abs(blocks.lengths_mm)
    # Axis by axis, each in one line: a cut has hundreds of thousands of blocks, and axes that never move.
    moving = [axis for axis in range(3) if blocks.moved_mm[:, axis].any()]
    exact_mm = np.sqrt(np.einsum("ij,ij->i", blocks.moved_mm, blocks.moved_mm))
    ways = [blocks.moved_mm[:, axis] / exact_mm for axis in moving]
    turn_back = np.zeros(max(len(lengths_mm) - 1, 0))
    bend = np.zeros(len(turn_back))
    for axis, way in zip(moving, ways, strict=True):
        turn_back += (way[1:] + way[:-1]) ** 2
        np.maximum(bend, np.abs(way[1:] - way[:-1]) / accelerations_mm_s2[axis], out=bend)
    return Bends(
        lengths_mm,
        _along(ways, velocities_mm_s[moving], path[0]),
        _along(ways, accelerations_mm_s2[moving], path[1]),
        turn_back < _TURNS_BACK_RAD**2,
        bend,
    )


def _along(ways: Sequence[Floats], limits: Floats, otherwise: float) -> Floats:
    """The limit of the axis that reaches its own first, in each direction, (n,)."""
    most = np.zeros(len(ways[0]))
    for way, limit in zip(ways, limits.tolist(), strict=True):
        np.maximum(most, np.abs(way) / limit, out=most)
    along: Floats = np.divide(1.0, most, out=np.full(len(most), otherwise), where=most > 0.0)
    return along
