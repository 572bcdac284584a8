"""A cutting tool as a laser sees it: edges as points on a profile of revolution, and a core that is thinner.

Angles are degrees, counted counter-clockwise as seen from the spindle; heights are measured up from the tip.
The edge of a right-hand tool turns counter-clockwise as it goes up.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
# Below this height above the tip there are only the edges of the end, and nothing between them.
GASH_MM = 0.3
# The core between two edges, as a share of the radius: thinner than the core of any usual tool, so that a
# reading between two edges is as low as it can be.
CORE_SHARE = 0.4
NO_TOOL = -np.inf


class Kind(enum.IntEnum):
    """Tool types, with the numbers that the macros take, and the round bar that calibrates."""

    FLAT = 1
    BALL = 2
    DRILL = 3
    REAMER = 4
    BAR = 5


@dataclass(frozen=True)
class Chip:
    """A piece broken out of one edge: ``depth_mm`` inward along the normal, ``extent_mm`` long in height."""

    tooth: int
    height_mm: float
    depth_mm: float
    extent_mm: float = 1.0


class _Edges(NamedTuple):
    """Edges at n heights: farthest reach (teeth, n), its angle from a direction, what is solid (n,)."""

    reach_mm: Floats
    off_deg: Floats
    solid_mm: Floats


@dataclass(frozen=True)
class SimulatedTool:
    """A tool in the spindle.

    ``length_mm`` is from the holder to the tip, ``holder_mm`` from the spindle nose to the holder's end.
    ``runout_mm`` is how far the tool's axis stands off the spindle's, toward ``runout_deg``.  ``dish_mm`` is
    how much higher than its edges the middle of an end mill is.  ``phase_deg`` is where the first edge stands
    at the tip when the spindle is at 0.  With ``is_missing`` the holder is empty.
    """

    kind: Kind = Kind.FLAT
    diameter_mm: float = 10.0
    length_mm: float = 50.0
    teeth: int = 4
    corner_mm: float = 0.0
    helix_deg: float = 0.0
    point_deg: float = 118.0
    holder_mm: float = 80.0
    runout_mm: float = 0.0
    runout_deg: float = 0.0
    phase_deg: float = 0.0
    dish_mm: float = 0.0
    chips: tuple[Chip, ...] = ()
    is_missing: bool = False

    @property
    def radius_mm(self) -> float:
        """Half the diameter."""
        return self.diameter_mm / 2.0

    @property
    def gauge_mm(self) -> float:
        """From the spindle nose to the tip."""
        return self.holder_mm + self.length_mm

    @property
    def farthest_mm(self) -> float:
        """No place of the tool is farther from the spindle's axis."""
        return self.radius_mm + self.runout_mm

    def profile(self, height_mm: ArrayLike) -> Floats:
        """Radius [mm] at heights above the tip, without chips; minus infinity below the tip."""
        height = np.asarray(height_mm, np.float64)
        radius = self.radius_mm
        if self.kind is Kind.DRILL:
            shape = np.minimum(radius, height * np.tan(np.radians(self.point_deg / 2.0)))
        else:
            corner = radius if self.kind is Kind.BALL else self.corner_mm
            below = np.clip(corner - height, 0.0, corner)
            shape = radius - corner + np.sqrt(np.maximum(corner**2 - below**2, 0.0))
        return np.where(height >= 0.0, shape, NO_TOOL)

    def tooth_radius(self, tooth: int, height_mm: ArrayLike) -> Floats:
        """Radius [mm] of one edge about the tool's own axis, chips taken out; shape of ``height_mm``."""
        height = np.asarray(height_mm, np.float64)
        return self._chipped(tooth, height, self.profile(height))

    def _chipped(self, tooth: int, height: Floats, radius: Floats) -> Floats:
        """The radius of one edge, from the profile at the same heights."""
        for chip in self.chips:
            if chip.tooth == tooth:
                hit = np.abs(height - chip.height_mm) <= chip.extent_mm / 2.0 + 1e-9
                radius = np.where(hit, radius - chip.depth_mm / self._normal_share(height), radius)
        return radius

    def tooth_angle(self, tooth: int, height_mm: ArrayLike) -> Floats:
        """Angle [deg] of one edge at heights, with the spindle at 0; shape of ``height_mm``."""
        lead = np.degrees(np.tan(np.radians(self.helix_deg)) / self.radius_mm)
        twist: Floats = np.asarray(height_mm, np.float64) * lead
        return self.phase_deg + 360.0 * tooth / self.teeth + twist

    def reach(self, height_mm: ArrayLike, spindle_deg: float, toward_deg: float) -> Floats:
        """How far [mm] the standing tool reaches from the spindle's axis toward an angle, at heights.

        The spindle's angle counts clockwise from above, the way M3 turns it.
        """
        height = np.asarray(height_mm, np.float64)
        aim = toward_deg + spindle_deg
        whole = np.where(height >= 0.0, self.profile(height), 0.0)
        best = self._core * whole
        for tooth in range(self.teeth):
            off = np.radians(self.tooth_angle(tooth, height) - aim)
            best = np.maximum(best, self._chipped(tooth, height, whole) * np.cos(off))
        shift = self.runout_mm * np.cos(np.radians(self.runout_deg - aim))
        return np.where(height >= 0.0, best + shift, NO_TOOL)

    def reach_between(
        self, height_mm: ArrayLike, begin_deg: ArrayLike, end_deg: ArrayLike, toward_deg: float
    ) -> Floats:
        """The farthest [mm] that the tool reaches toward an angle while the spindle turns between two angles.

        Each edge is where it is at that moment: one that passes the direction reaches as far as it is long,
        one that does not as far as the nearer end of its way brings it.  Shapes are broadcast.
        """
        height = np.asarray(height_mm, np.float64)
        begin = np.asarray(begin_deg, np.float64)
        turn = np.asarray(end_deg, np.float64) - begin
        edges = (
            self._edges(height, toward_deg) if height.size > 1 else _level(self, height.item(), toward_deg)
        )
        best = (edges.reach_mm * _most(edges.off_deg - begin, turn)).max(axis=0)
        solid = edges.solid_mm
        if self.runout_mm:
            solid = solid + self.runout_mm * _most(self.runout_deg - toward_deg - begin, turn)
        return np.where(height >= 0.0, np.maximum(best, solid), NO_TOOL)

    def _edges(self, height: Floats, toward_deg: float) -> _Edges:
        """Where the edges stand at heights (n,) with the spindle at 0."""
        whole = np.where(height >= 0.0, self.profile(height), 0.0)
        radius = np.array([self._chipped(tooth, height, whole) for tooth in range(self.teeth)])
        angle = np.array([self.tooth_angle(tooth, height) for tooth in range(self.teeth)])
        about = np.radians(angle - toward_deg)
        runout = np.radians(self.runout_deg - toward_deg)
        x = radius * np.cos(about) + self.runout_mm * np.cos(runout)
        y = radius * np.sin(about) + self.runout_mm * np.sin(runout)
        return _Edges(np.hypot(x, y), np.degrees(np.arctan2(y, x)), self._core_at(height) * whole)

    def envelope(self, height_mm: ArrayLike) -> Floats:
        """Radius [mm] that the turning tool sweeps at heights."""
        height = np.asarray(height_mm, np.float64)
        whole = np.where(height >= 0.0, self.profile(height), 0.0)
        swept = [self._core * whole]
        for tooth in range(self.teeth):
            off = np.radians(self.tooth_angle(tooth, height) - self.runout_deg)
            radius = self._chipped(tooth, height, whole)
            swept.append(np.sqrt(radius**2 + self.runout_mm**2 + 2 * radius * self.runout_mm * np.cos(off)))
        return np.where(height >= 0.0, np.max(swept, axis=0), NO_TOOL)

    def hollow(self, height_mm: ArrayLike) -> Floats:
        """Radius [mm] of the hollow under the tool at heights; 0 where there is none."""
        height = np.asarray(height_mm, np.float64)
        if self.dish_mm <= 0.0:
            return np.zeros(height.shape)
        return np.where(height >= 0.0, self.radius_mm * np.clip(1.0 - height / self.dish_mm, 0.0, 1.0), 0.0)

    def _core_at(self, height: Floats) -> Floats:
        """The share of the radius that is solid all round."""
        if self.kind is Kind.BAR:
            return np.ones_like(height)
        return np.where(height < GASH_MM, 0.0, self._core)

    @property
    def _core(self) -> float:
        return 1.0 if self.kind is Kind.BAR else CORE_SHARE

    def _normal_share(self, height: Floats) -> Floats:
        """The radial part of the profile's outward normal, 1 on a cylinder."""
        step = 1e-4
        low = np.maximum(height - step, 0.0)
        rise = self.profile(height + step) - self.profile(low)
        slope = np.where(height >= 0.0, rise / np.maximum(height + step - low, step), 0.0)
        share: Floats = 1.0 / np.hypot(1.0, slope)
        return share


@lru_cache(maxsize=4096)
def _level(tool: SimulatedTool, height_mm: float, toward_deg: float) -> _Edges:
    """The edges at one height: a move that is level asks for the same ones again and again."""
    return tool._edges(np.array([height_mm]), toward_deg)


def _most(off_deg: ArrayLike, turn_deg: Floats) -> Floats:
    """The largest cosine of an angle that goes down from ``off_deg`` by ``turn_deg`` (>= 0)."""
    if np.all(turn_deg >= 360.0):
        return np.ones_like(off_deg, np.float64)
    first = np.mod(off_deg, 360.0)
    ends = np.maximum(np.cos(np.radians(first)), np.cos(np.radians(first - turn_deg)))
    most: Floats = np.where(turn_deg >= first, 1.0, ends)
    return most


def table(tool: SimulatedTool, heights_mm: Iterable[float]) -> list[tuple[float, ...]]:
    """The tool as rows of numbers for a simulation in another language.

    One row a height: radius of the hollow, then radius [mm] and angle [rad] of every edge.
    """
    heights = np.fromiter(heights_mm, np.float64)
    columns = [tool.hollow(heights)]
    for tooth in range(tool.teeth):
        columns += [tool.tooth_radius(tooth, heights), np.radians(tool.tooth_angle(tooth, heights))]
    return [tuple(map(float, row)) for row in np.column_stack(columns)]
