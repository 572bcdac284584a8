"""The straight moves of a cut as the control sees them: where it turns back, where it rests at a bend."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.vibration.control import ControlModel

Floats = NDArray[np.float64]
_DIGITS = 9  # of a length in mm: what lies behind them is noise that would make every stretch another one
_SOFT_BEND = 0.1  # LinuxCNC's tangent kink ratio; for other controls, radians that count as straight on


@dataclass(frozen=True, eq=False)
class Blocks:
    """Straight moves as the control sees them; (n,) each.

    ``lengths_mm`` are signed along the path.  ``bends``: how far the direction turns behind each block, the
    most of any axis's share in it; where the tool turns back it does not matter.  ``acceleration_mm_s2`` is
    what the axes allow in each block's direction.
    """

    lengths_mm: Floats
    bends: Floats
    acceleration_mm_s2: Floats

    def model(self, start: int, stop: int, model: ControlModel, strengths: Floats) -> ControlModel:
        """The control in some of the blocks.

        LinuxCNC keeps the acceleration that a bend may take from the blocks beside it.
        """
        if model.acceleration_mm_s2 == math.inf:
            return model
        has = float(self.acceleration_mm_s2[start:stop].min())
        if model.law == "linuxcnc":
            has *= 1.0 - _SOFT_BEND * float(strengths[start : stop - 1].max(initial=0.0))
        return replace(model, acceleration_mm_s2=float(f"{has:.4g}"))


def blocks_of(moved_mm: Floats, ahead_mm: Floats, settings: Settings) -> Blocks:
    """Blocks from their moves, (n, 3), and how far each one leads along the path, (n,)."""
    lengths_mm = np.sqrt(np.einsum("ij,ij->i", moved_mm, moved_mm))
    ways = moved_mm / lengths_mm[:, np.newaxis]
    bends = np.append(np.abs(np.diff(ways, axis=0)).max(axis=1, initial=0.0), 0.0)
    allowed = np.full(len(ways), np.inf)
    with np.errstate(divide="ignore"):
        for name, axis in settings.axes.items():
            if axis.max_acceleration_mm_s2 is not None:
                share = np.abs(ways[:, AXES.index(name)])
                np.minimum(allowed, axis.max_acceleration_mm_s2 / share, out=allowed)
    return Blocks(np.copysign(np.round(lengths_mm, _DIGITS), ahead_mm), bends, allowed)


def bend_strengths(blocks: Blocks, feeds_mm_s: Floats, model: ControlModel) -> Floats:
    """Each bend as a share of what the control still runs through without a rest, (n,); 1 or more is a stop.

    LinuxCNC (``tpSetupTangent``): the change of velocity within one servo period, and the acceleration, may
    take a tenth of the axis's acceleration; with feed per revolution the velocity is the highest possible.
    In exact stop every end of a block is a rest.
    """
    if model.every_block_stops:
        return np.ones(len(blocks.bends))
    if model.law != "linuxcnc":
        return blocks.bends / _SOFT_BEND
    top = np.minimum(np.abs(blocks.lengths_mm) / model.servo_period_s, model.velocity_mm_s)
    speeds = top if model.per_revolution else np.minimum(top, feeds_mm_s)
    slower = np.append(np.minimum(speeds[:-1], speeds[1:]), 0.0)
    jolt = slower / model.servo_period_s + blocks.acceleration_mm_s2
    strengths: Floats = jolt * blocks.bends / model.acceleration_mm_s2 / _SOFT_BEND
    return strengths


def strokes(lengths_mm: Floats) -> list[tuple[int, int]]:
    """First and behind-last block of each stretch between two reversals."""
    turns = np.flatnonzero(np.diff(np.sign(lengths_mm))) + 1
    bounds = [0, *turns.tolist(), len(lengths_mm)]
    return list(pairwise(bounds))


def parts(first: int, last: int, strengths: Floats) -> list[tuple[int, int]]:
    """A stroke cut where the control rests on the way."""
    rests = [first + 1 + int(i) for i in np.flatnonzero(strengths[first : last - 1] >= 1.0)]
    return list(pairwise([first, *rests, last]))
