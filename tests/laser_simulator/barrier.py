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
    if beam.is_blocked or tool.is_missing:
        return np.full(len(points), beam.is_blocked)
    x, y, z = points.T
    height = beam.z_mm - (z - tool.gauge_mm)
    off = beam.y_mm - y
    aside = np.abs(beam.x_mm - x)
    nearest = np.hypot(off, np.maximum(aside - beam.focus_half_mm, 0.0))
    found = np.zeros(len(points), np.bool_)
    # Most of a long way is farther off than any tool reaches, and needs no look at the edges.
    near = np.flatnonzero((height >= 0.0) & (nearest <= tool.farthest_mm + _EXACT_MM))
    if len(near):
        angles = (_at(begin_deg, near), _at(begin_deg if end_deg is None else end_deg, near))
        reach = _reach(tool, height[near], off[near] >= 0.0, *angles)
        found[near] = nearest[near] <= reach + _EXACT_MM
        if tool.dish_mm > 0.0:
            farthest = np.hypot(off[near], aside[near] + beam.focus_half_mm)
            found[near] &= farthest >= tool.hollow(height[near]) - _EXACT_MM
    return found


def _at(angle_deg: ArrayLike, places: NDArray[np.intp]) -> NDArray[np.float64]:
    """The angles at some of the points; one angle holds for all."""
    angle = np.asarray(angle_deg, np.float64)
    return angle[places] if angle.ndim and len(angle) > 1 else angle


def _reach(
    tool: SimulatedTool,
    height: NDArray[np.float64],
    is_front: NDArray[np.bool_],
    begin_deg: NDArray[np.float64],
    end_deg: NDArray[np.float64],
) -> NDArray[np.float64]:
    """How far the tool reaches toward the beam, from the side on which it is."""
    if np.all(height == height[0]):
        height = height[:1]  # most moves are level, and one look at the tool is enough for them
    sides = [toward for toward, seen in ((90.0, is_front), (-90.0, ~is_front)) if seen.any()]
    reached = [tool.reach_between(height, begin_deg, end_deg, toward) for toward in sides]
    return np.where(is_front, reached[0], reached[-1])


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
