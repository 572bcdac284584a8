"""The laser barrier: a beam along X, sharp about its focus, and whether a tool breaks it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chipbreak.lasersim.tool import SimulatedTool


@dataclass(frozen=True)
class Beam:
    """A beam along X through (``y_mm``, ``z_mm``) in machine coordinates, focused at ``x_mm``.

    Only what stands within ``focus_half_mm`` of the focus darkens it.  ``is_blocked``: something else does.
    """

    x_mm: float
    y_mm: float
    z_mm: float
    focus_half_mm: float = 3.0
    is_blocked: bool = False


@dataclass(frozen=True)
class Spindle:
    """A turning spindle, or one that stands at ``angle_deg`` (counted the way M3 turns)."""

    is_turning: bool = False
    angle_deg: float = 0.0


def is_broken(
    beam: Beam, tool: SimulatedTool, spindle: Spindle, x_mm: ArrayLike, y_mm: ArrayLike, z_mm: ArrayLike
) -> NDArray[np.bool_]:
    """True where the tool breaks the beam, for positions of the spindle nose in machine coordinates [mm].

    The three positions broadcast; the answer has their common shape.  A turning tool counts with all it
    sweeps.
    """
    x, y, z = np.broadcast_arrays(*(np.asarray(v, np.float64) for v in (x_mm, y_mm, z_mm)))
    if beam.is_blocked or tool.is_missing:
        return np.full(x.shape, beam.is_blocked)
    height = beam.z_mm - (z - tool.gauge_mm)
    off = beam.y_mm - y
    if spindle.is_turning:
        reach = tool.envelope(height)
    else:
        front = tool.reach(height, spindle.angle_deg, 90.0)
        back = tool.reach(height, spindle.angle_deg, -90.0)
        reach = np.where(off >= 0.0, front, back)
    aside = np.abs(beam.x_mm - x)
    nearest = np.hypot(off, np.maximum(aside - beam.focus_half_mm, 0.0))
    farthest = np.hypot(off, aside + beam.focus_half_mm)
    # A tolerance far below any measurement: the beam at a whole micrometre is met at that micrometre.
    found: NDArray[np.bool_] = (nearest <= reach + 1e-9) & (farthest >= tool.hollow(height) - 1e-9)
    return found
