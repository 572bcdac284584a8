"""The region that blocks remove, drawn apart from the product: a reader of plain blocks, a scan of columns.

All is in two axes: t grows in the direction of cutting, h towards the stock.  A point tool is moved; what it
cuts is gone above its way.  Heights are piecewise smooth between places where anything begins or ends, so
areas are integrated between these places and walls cost no accuracy.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_WORD = re.compile(r"([GXZIK])(-?[\d.]+)")
_ARC_POINTS = 1501
_SAME = 1e-9
_INSIDE = 9


@dataclass(frozen=True)
class Way:
    """A straight or round way as places (n, 2); ``cuts`` where it is fed."""

    cuts: bool
    places: Floats


def arc_places(start: Floats, end: Floats, centre: Floats, *, ccw: bool) -> Floats:
    """Places on an arc from its start to its end."""
    first = math.atan2(start[1] - centre[1], start[0] - centre[0])
    last = math.atan2(end[1] - centre[1], end[0] - centre[0])
    sweep = (last - first) % (2.0 * math.pi) if ccw else -((first - last) % (2.0 * math.pi))
    angles = first + sweep * np.linspace(0.0, 1.0, _ARC_POINTS)
    radii = np.linspace(math.dist(start, centre), math.dist(end, centre), _ARC_POINTS)
    return np.column_stack((centre[0] + radii * np.cos(angles), centre[1] + radii * np.sin(angles)))


def centre_by_radius(start: Floats, end: Floats, radius: float, *, ccw: bool) -> Floats:
    """The centre of the shorter arc of a radius."""
    chord = end - start
    half = math.hypot(*chord) / 2.0
    away = math.sqrt(max(radius * radius - half * half, 0.0)) / (2.0 * half)
    side = 1.0 if ccw else -1.0
    return (start + end) / 2.0 + side * away * np.array([-chord[1], chord[0]])


def ways_of(
    blocks: Sequence[str], start: tuple[float, float], turned: Callable[[Floats], Floats]
) -> list[Way]:
    """Plain G0 to G3 blocks with X as a diameter; ``start`` is Z and the radius.

    ``turned`` takes places (n, 2) of Z and radius into t and h.
    """
    at = np.array(start)
    found = []
    for block in blocks:
        words = {letter: float(number) for letter, number in _WORD.findall(block.split("(")[0])}
        if words.get("G", 40.0) > 3.0:  # no move: a comment, or G42 behind the passes
            continue
        end = np.array([words.get("Z", at[0]), words["X"] / 2.0 if "X" in words else at[1]])
        places = np.array([at, end])
        if words["G"] >= 2.0:
            centre = at + np.array([words["K"], words["I"]])
            places = arc_places(at, end, centre, ccw=words["G"] == 3.0)
        found.append(Way(words["G"] > 0.0, turned(places)))
        at = end
    return found


class Columns:
    """Heights of stock over t, in columns between all places where something begins or ends."""

    def __init__(self, ways: Sequence[Way], outline: Floats, first: float, top: float) -> None:
        last = float(outline[:, 0].max())
        ends = [way.places[[0, -1], 0] for way in ways]
        joints = np.concatenate([*ends, outline[:, 0], [first, last]])
        joints = np.unique(joints[(joints >= first - _SAME) & (joints <= last + _SAME)])
        self.edges = joints[np.append(True, np.diff(joints) > _SAME)]
        shares = (np.arange(_INSIDE) + 0.5) / _INSIDE
        self.t = (self.edges[:-1, None] + np.diff(self.edges)[:, None] * shares).ravel()
        self.width = np.repeat(np.diff(self.edges) / _INSIDE, _INSIDE)
        self.height = np.full(len(self.t), top)
        self.aimed = np.minimum(over(outline, self.t), top)

    def run(self, way: Way, depth: float) -> tuple[float, float]:
        """Move the tool: how wide it cuts deeper than the depth, and how wide it rushes through stock."""
        places = way.places if way.places[-1, 0] >= way.places[0, 0] else way.places[::-1]
        if places[-1, 0] - places[0, 0] <= _SAME:
            return 0.0, 0.0
        inside = (self.t > places[0, 0]) & (self.t < places[-1, 0])
        there = over(places, self.t[inside])
        taken = self.height[inside] - there
        width = self.width[inside]
        if not way.cuts:
            return 0.0, float(width[taken > 2e-3].sum())
        self.height[inside] = np.minimum(self.height[inside], there)
        return float(width[taken > depth + 2e-3].sum()), 0.0

    def lost(self) -> float:
        """The area by which what is left differs from what is wanted [mm2]."""
        return float((np.abs(self.height - self.aimed) * self.width).sum())


def over(line: Floats, t: Floats) -> Floats:
    """The height of a line at places; between the two ends of a wall it does not matter."""
    return np.interp(t, np.maximum.accumulate(line[:, 0]), line[:, 1])
