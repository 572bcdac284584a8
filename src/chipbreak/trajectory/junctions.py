"""The straight moves of a cut as the control sees them: where it turns back, where it rests at a bend."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.trajectory.model import ControlModel

Floats = NDArray[np.float64]
Places = NDArray[np.intp]
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


def blocks_of(moved_mm: Floats, ahead_mm: Floats, settings: Settings) -> Blocks:
    """Blocks from their moves, (n, 3), and how far each one leads along the path, (n,)."""
    lengths_mm = np.sqrt(np.einsum("ij,ij->i", moved_mm, moved_mm))
    signed_mm = np.copysign(np.round(lengths_mm, _DIGITS), ahead_mm)
    if settings.planner.model == "ideal":  # its law asks for neither bends nor acceleration
        return Blocks(signed_mm, np.zeros(len(signed_mm)), np.full(len(signed_mm), np.inf))
    ways = moved_mm / lengths_mm[:, np.newaxis]
    turns = np.abs(np.diff(ways, axis=0))
    bends = np.append(np.maximum(np.maximum(turns[:, 0], turns[:, 1]), turns[:, 2]), 0.0)
    allowed = np.full(len(ways), np.inf)
    with np.errstate(divide="ignore"):
        for name, axis in settings.axes.items():
            if axis.max_acceleration_mm_s2 is not None:
                share = np.abs(ways[:, AXES.index(name)])
                np.minimum(allowed, axis.max_acceleration_mm_s2 / share, out=allowed)
    return Blocks(signed_mm, bends, allowed)


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


@dataclass(frozen=True, eq=False)
class Parts:
    """Stretches from rest to rest: the strokes, cut where the control rests on the way; (p,) each.

    ``starts`` and ``stops`` are first and behind-last block, ``strokes`` counts the strokes from 0, and
    ``acceleration_mm_s2`` is what the control has there.
    """

    starts: Places
    stops: Places
    strokes: Places
    acceleration_mm_s2: Floats


def parts_of(blocks: Blocks, strengths: Floats, model: ControlModel, last: int) -> Parts:
    """The parts of all strokes that end before block ``last``."""
    turns = np.flatnonzero(np.diff(np.sign(blocks.lengths_mm))) + 1
    bounds = np.concatenate(([0], turns, [len(blocks.lengths_mm)]))
    bounds = bounds[bounds <= last]
    end = int(bounds[-1])
    rests = np.flatnonzero(strengths[: max(end - 1, 0)] >= 1.0) + 1
    starts = np.union1d(bounds[:-1], rests)
    stops = np.append(starts[1:], [end] * min(len(starts), 1))
    strokes = np.searchsorted(bounds, starts, "right") - 1
    return Parts(starts, stops, strokes, _accelerations(blocks, strengths, model, starts, stops))


def _accelerations(
    blocks: Blocks, strengths: Floats, model: ControlModel, starts: Places, stops: Places
) -> Floats:
    """What the control has in each part; LinuxCNC keeps what a bend may take from the blocks beside it."""
    if model.acceleration_mm_s2 == np.inf or not len(starts):
        return np.full(len(starts), model.acceleration_mm_s2)
    has = np.minimum.reduceat(blocks.acceleration_mm_s2[: stops[-1]], starts)
    if model.law == "linuxcnc":
        inside = strengths[: stops[-1]].copy()
        inside[stops - 1] = 0.0
        has = has * (1.0 - _SOFT_BEND * np.maximum.reduceat(inside, starts))
    # Four digits: what lies behind them would make every stretch another one.
    exponent = np.floor(np.log10(has)) - 3.0
    unit = 10.0 ** np.abs(exponent)
    rounded: Floats = np.where(exponent < 0.0, np.rint(has * unit) / unit, np.rint(has / unit) * unit)
    return rounded
