"""The laser barrier: a beam along X, sharp about its focus, and whether a tool breaks it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from laser_simulator.tool import SimulatedTool

# A tolerance far below any measurement: the beam at a whole micrometre is met at that micrometre.
_EXACT_MM = 1e-7


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
    beam: Beam,
    tool: SimulatedTool,
    points: NDArray[np.float64],
    begin_deg: ArrayLike,
    end_deg: ArrayLike | None = None,
) -> NDArray[np.bool_]:
    """True where the tool breaks the beam at some moment, for positions of the spindle nose; (n, 3) -> (n,).

    ``points`` are machine coordinates [mm].  The spindle turns from ``begin_deg`` to ``end_deg`` (one or n
    of them, the second not smaller; left out: it stands), counted the way M3 turns it.
    """
    x, y, z = points.T
    if beam.is_blocked or tool.is_missing:
        return np.full(x.shape, beam.is_blocked)
    height = beam.z_mm - (z - tool.gauge_mm)
    if len(z) == 0 or np.all(height < 0.0):
        return np.zeros(x.shape, np.bool_)
    if np.all(z == z[0]):
        height = height[:1]  # most moves are level, and one look at the tool is enough for them
    off = beam.y_mm - y
    last_deg = begin_deg if end_deg is None else end_deg
    front = tool.reach_between(height, begin_deg, last_deg, 90.0)
    back = tool.reach_between(height, begin_deg, last_deg, -90.0)
    reach = np.where(off >= 0.0, front, back)
    aside = np.abs(beam.x_mm - x)
    nearest = np.hypot(off, np.maximum(aside - beam.focus_half_mm, 0.0))
    farthest = np.hypot(off, aside + beam.focus_half_mm)
    found: NDArray[np.bool_] = (nearest <= reach + _EXACT_MM) & (farthest >= tool.hollow(height) - _EXACT_MM)
    return found


@dataclass
class Station:
    """A barrier and the tools of the magazine by number; what is not in the magazine is an empty holder."""

    beam: Beam
    tools: dict[int, SimulatedTool]

    def broken(
        self,
        tool: int,
        points: NDArray[np.float64],
        begin_deg: ArrayLike,
        end_deg: ArrayLike | None = None,
    ) -> NDArray[np.bool_]:
        """True where this tool breaks the beam; arguments as of :func:`is_broken`."""
        found = self.tools.get(tool, SimulatedTool(is_missing=True))
        return is_broken(self.beam, found, points, begin_deg, end_deg)

    def teeth(self, tool: int) -> int:
        """How often a revolution of this tool may break the beam."""
        return self.tools[tool].teeth if tool in self.tools else 1
