"""The laser barrier: a beam along X, sharp about its focus, and whether a tool breaks it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from laser_simulator.tool import SimulatedTool


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


def is_broken(
    beam: Beam, tool: SimulatedTool, angle_deg: float | None, points: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """True where the tool breaks the beam, for positions of the spindle nose; (n, 3) -> (n,).

    ``points`` are machine coordinates [mm].  ``angle_deg`` is where the spindle stands, counted the way M3
    turns it; None: it turns, and the tool counts with all it sweeps.
    """
    x, y, z = points.T
    if beam.is_blocked or tool.is_missing:
        return np.full(x.shape, beam.is_blocked)
    height = beam.z_mm - (z - tool.gauge_mm)
    if len(z) and np.all(z == z[0]):
        height = height[:1]  # most moves are level, and one look at the tool is enough for them
    off = beam.y_mm - y
    if angle_deg is None:
        reach = tool.envelope(height)
    else:
        front = tool.reach(height, angle_deg, 90.0)
        back = tool.reach(height, angle_deg, -90.0)
        reach = np.where(off >= 0.0, front, back)
    aside = np.abs(beam.x_mm - x)
    nearest = np.hypot(off, np.maximum(aside - beam.focus_half_mm, 0.0))
    farthest = np.hypot(off, aside + beam.focus_half_mm)
    # A tolerance far below any measurement: the beam at a whole micrometre is met at that micrometre.
    found: NDArray[np.bool_] = (nearest <= reach + 1e-9) & (farthest >= tool.hollow(height) - 1e-9)
    return found


@dataclass
class Station:
    """A barrier and the tools of the magazine by number; what is not in the magazine is an empty holder."""

    beam: Beam
    tools: dict[int, SimulatedTool]

    def broken(self, tool: int, angle_deg: float | None, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """True where this tool breaks the beam; arguments as of :func:`is_broken`."""
        found = self.tools.get(tool, SimulatedTool(is_missing=True))
        return is_broken(self.beam, found, angle_deg, points)
