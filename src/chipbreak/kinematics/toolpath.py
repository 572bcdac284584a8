"""A chain of cutting moves as one path, measured by its arc length.

Pure geometry: points are rows (x, y, z) in mm with X as radius; s runs from 0 to ``length_mm``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

Point = tuple[float, float, float]

# First and second axis of a plane: turning from the first to the second is counter-clockwise (G3).
PLANE_AXES = {"XY": (0, 1), "ZX": (2, 0), "YZ": (1, 2)}
# How far start and end may differ in their distance from an arc's centre: two roundings of 0.001 mm, as
# posts write them, with room for inch programs.
RADIUS_TOLERANCE_MM = 0.02
_NO_LENGTH_MM = 1e-9
BAD_ARC = "VIB022"


class Leg(NamedTuple):
    """One programmed move.

    ``turn`` is 0 for a line, -1 for clockwise, +1 for counter-clockwise.  ``centre_offset`` runs from the
    start to the centre, NaN where the block gives none; ``radius_mm`` is R, negative for the longer arc.
    """

    start: Point
    end: Point
    turn: int = 0
    plane: str = "XY"
    centre_offset: Point = (math.nan, math.nan, math.nan)
    radius_mm: float = math.nan


@dataclass(frozen=True)
class _Arc:
    """An arc or helix: angles in radians, ``rise_mm`` along the axis of the plane."""

    centre: Point
    radius_mm: float
    first_rad: float
    sweep_rad: float
    axes: tuple[int, int]
    rise_mm: float


@dataclass(frozen=True, eq=False)
class Path:
    """Lines and arcs, end to end.  ``ends_mm`` holds s at the joints, from 0 to the length."""

    legs: tuple[Leg, ...]
    arcs: tuple[_Arc | None, ...]
    ends_mm: Floats

    @property
    def length_mm(self) -> float:
        """The whole arc length."""
        return float(self.ends_mm[-1])

    def beginning(self, length_mm: float) -> Path:
        """The path as far as an arc length within it."""
        last = int(np.searchsorted(self.ends_mm[1:-1], length_mm, "left"))
        x, y, z = self.points(np.array([length_mm]))[0].tolist()
        share = (length_mm - self.ends_mm[last]) / (self.ends_mm[last + 1] - self.ends_mm[last])
        arc = self.arcs[last]
        if arc is not None:
            arc = replace(arc, sweep_rad=share * arc.sweep_rad, rise_mm=share * arc.rise_mm)
        return Path(
            (*self.legs[:last], self.legs[last]._replace(end=(x, y, z))),
            (*self.arcs[:last], arc),
            np.append(self.ends_mm[: last + 1], length_mm),
        )

    def points(self, s_mm: Floats) -> Floats:
        """Points at arc lengths: (n,) -> (n, 3).  The ends of the path are exact."""
        points = self._by_leg(self._on_leg, s_mm)
        points[s_mm <= 0.0] = self.legs[0].start
        points[s_mm >= self.length_mm] = self.legs[-1].end
        return points

    def tangents(self, s_mm: Floats) -> Floats:
        """Unit directions of travel: (n,) -> (n, 3)."""
        return self._by_leg(self._along_leg, s_mm)

    def _by_leg(self, function: Callable[[int, Floats], Floats], s_mm: Floats) -> Floats:
        """Evaluate on the leg that each s lies on."""
        if len(self.legs) == 1:
            return function(0, s_mm)
        rows = np.empty((len(s_mm), 3))
        which = np.clip(np.searchsorted(self.ends_mm, s_mm, "right") - 1, 0, len(self.legs) - 1)
        for index in np.unique(which):
            mask = which == index
            rows[mask] = function(int(index), s_mm[mask])
        return rows

    def corners_mm(self, bend: float = 0.001) -> Floats:
        """Where the direction changes by more than ``bend`` radians from one leg to the next."""
        joints = range(1, len(self.legs))
        ends = [self._along_leg(i - 1, self.ends_mm[i : i + 1])[0] for i in joints]
        starts = [self._along_leg(i, self.ends_mm[i : i + 1])[0] for i in joints]
        sharp = [math.dist(one, other) > bend for one, other in zip(ends, starts, strict=True)]
        corners: Floats = self.ends_mm[1:-1][np.array(sharp, dtype=bool)]
        return corners

    def pieces(self, start_mm: Floats, end_mm: Floats, chord_mm: float) -> NDArray[np.intp]:
        """Into how many straight moves to cut each move so that they stay close to the arcs; (n,) -> (n,).

        A chord over an arc of radius r and length l leaves it by l^2 / (8 r).
        """
        low = np.minimum(start_mm, end_mm)
        high = np.maximum(start_mm, end_mm)
        pieces = np.ones(len(low), dtype=np.intp)
        for index, arc in enumerate(self.arcs):
            if arc is not None:
                touches = (high > self.ends_mm[index]) & (low < self.ends_mm[index + 1])
                needed = np.ceil((high - low) / math.sqrt(8.0 * chord_mm * arc.radius_mm) - 1e-9)
                pieces = np.where(touches, np.maximum(pieces, needed.astype(np.intp)), pieces)
        return pieces

    def breakpoints(self, chord_mm: float) -> Floats:
        """Where a straight move must end: the joints, and points so dense on arcs that chords stay close.

        A chord over an arc of radius r and length l leaves it by l^2 / (8 r).
        """
        cuts = [self.ends_mm[1:-1]]
        for index, arc in enumerate(self.arcs):
            if arc is not None:
                length = self.ends_mm[index + 1] - self.ends_mm[index]
                pieces = max(1, math.ceil(length / math.sqrt(8.0 * chord_mm * arc.radius_mm)))
                cuts.append(self.ends_mm[index] + length * np.arange(1, pieces) / pieces)
        return np.unique(np.concatenate(cuts))

    def _on_leg(self, index: int, s_mm: Floats) -> Floats:
        leg = self.legs[index]
        arc = self.arcs[index]
        start_s = self.ends_mm[index]
        end_s = self.ends_mm[index + 1]
        share = (s_mm - start_s) / (end_s - start_s)
        if arc is None:
            line: Floats = np.asarray(leg.start) + share[:, None] * np.subtract(leg.end, leg.start)
            return line
        angle = arc.first_rad + arc.sweep_rad * share
        points = np.tile(np.asarray(leg.start), (len(s_mm), 1))
        points[:, arc.axes[0]] = arc.centre[arc.axes[0]] + arc.radius_mm * np.cos(angle)
        points[:, arc.axes[1]] = arc.centre[arc.axes[1]] + arc.radius_mm * np.sin(angle)
        points[:, 3 - sum(arc.axes)] += arc.rise_mm * share
        return points

    def _along_leg(self, index: int, s_mm: Floats) -> Floats:
        leg = self.legs[index]
        arc = self.arcs[index]
        start_s = self.ends_mm[index]
        end_s = self.ends_mm[index + 1]
        length = end_s - start_s
        if arc is None:
            return np.tile(np.subtract(leg.end, leg.start) / length, (len(s_mm), 1))
        angle = arc.first_rad + arc.sweep_rad * (s_mm - start_s) / length
        turn = arc.sweep_rad * arc.radius_mm / length
        tangents = np.zeros((len(s_mm), 3))
        tangents[:, arc.axes[0]] = -turn * np.sin(angle)
        tangents[:, arc.axes[1]] = turn * np.cos(angle)
        tangents[:, 3 - sum(arc.axes)] = arc.rise_mm / length
        return tangents


def path_of(legs: Sequence[Leg]) -> Path:
    """The path of some moves in a row; legs without length are left out.

    Errors: VIB022 for an arc that cannot be, VIB023 when there is no length at all.
    """
    arcs = []
    lengths = []
    kept = []
    for leg in legs:
        arc = _arc_of(leg) if leg.turn else None
        length = math.dist(leg.start, leg.end)
        if arc is not None:
            length = math.hypot(arc.radius_mm * arc.sweep_rad, arc.rise_mm)
        if length > _NO_LENGTH_MM:
            kept.append(leg)
            arcs.append(arc)
            lengths.append(length)
    if not kept:
        raise RefusalError("VIB023", "the cut has no length", "a vibrated cut needs a distance to travel")
    return Path(tuple(kept), tuple(arcs), np.concatenate(([0.0], np.cumsum(lengths))))


def _arc_of(leg: Leg) -> _Arc:
    axes = PLANE_AXES[leg.plane]
    start = np.array([leg.start[a] for a in axes])
    end = np.array([leg.end[a] for a in axes])
    offset = np.array([leg.centre_offset[a] for a in axes])
    # R goes before I, J and K where a block gives both; LinuxCNC stops at such a block.
    if np.isfinite(offset).any() and math.isnan(leg.radius_mm):
        centre = start + np.nan_to_num(offset)
    else:
        centre = _centre_from_radius(start, end, leg)
    radius = math.dist(start, centre)
    end_radius = math.dist(end, centre)
    if radius == 0.0 or abs(radius - end_radius) > RADIUS_TOLERANCE_MM:
        message = f"the arc starts {radius:z.4f} mm and ends {end_radius:z.4f} mm from its centre"
        raise RefusalError(BAD_ARC, message, "check I, J, K or R of the block")
    first = math.atan2(start[1] - centre[1], start[0] - centre[0])
    sweep = math.atan2(end[1] - centre[1], end[0] - centre[0]) - first
    full = 2.0 * math.pi
    sweep = sweep % full if leg.turn > 0 else sweep % full - full
    if sweep in (0.0, -full) or math.dist(start, end) < 1e-9:
        sweep = full * leg.turn
    middle = [0.0, 0.0, 0.0]
    middle[axes[0]] = float(centre[0])
    middle[axes[1]] = float(centre[1])
    axial = 3 - sum(axes)
    rise = leg.end[axial] - leg.start[axial]
    return _Arc((middle[0], middle[1], middle[2]), radius, first, sweep, axes, rise)


def _centre_from_radius(start: Floats, end: Floats, leg: Leg) -> Floats:
    chord = end - start
    length = float(np.hypot(*chord))
    radius = abs(leg.radius_mm)
    if math.isnan(radius):
        message = "the arc has neither centre nor radius"
        raise RefusalError(BAD_ARC, message, "give I, J, K or R on the block")
    if length == 0.0 or radius < length / 2.0 - RADIUS_TOLERANCE_MM:
        message = f"no arc of radius {leg.radius_mm:g} mm joins points {length:z.4f} mm apart"
        raise RefusalError(BAD_ARC, message, "give I, J, K or a fitting R on the block")
    height = math.sqrt(max(0.0, radius * radius - length * length / 4.0))
    side = leg.turn * math.copysign(1.0, leg.radius_mm)
    normal = np.array([-chord[1], chord[0]]) / length
    centre: Floats = (start + end) / 2.0 + side * height * normal
    return centre


def split_at(time_s: Floats, distance_mm: Floats, breakpoints_mm: Floats) -> tuple[Floats, Floats]:
    """Add a knot wherever the motion crosses a breakpoint, forward or back, at the time it does.

    The motion between the knots is linear; shapes (n,) -> (m,) with m >= n.
    """
    if not len(breakpoints_mm):
        return time_s, distance_mm
    low = np.minimum(distance_mm[:-1], distance_mm[1:])
    high = np.maximum(distance_mm[:-1], distance_mm[1:])
    first = np.searchsorted(breakpoints_mm, low, "right")
    count = np.maximum(np.searchsorted(breakpoints_mm, high, "left") - first, 0)
    interval = np.repeat(np.arange(len(low)), count)
    rank = np.arange(len(interval)) - np.repeat(np.cumsum(count) - count, count)
    at = breakpoints_mm[first[interval] + rank]
    share = (at - distance_mm[interval]) / (distance_mm[interval + 1] - distance_mm[interval])
    times = np.concatenate((time_s, time_s[interval] + share * (time_s[interval + 1] - time_s[interval])))
    order = np.argsort(times, kind="stable")
    return times[order], np.concatenate((distance_mm, at))[order]
