"""The edge of a tool as it was and as it is, and whether it is chipped.

Pure numpy; lengths in mm.  As patent JP7625807B2 has it, an edge is chipped where the distance along the
normal is W *or more*.

An edge is a curve of radius over height, measured at any heights.  Between two points it is the flatter of
the two circles through three neighbours: exact for a wall, a cone and a ball, straight beside a corner, and
little impressed by noise.  A point's distance inward is that to the nearest place of this curve, so it is
measured along the curve's normal, and the limit line at W need not be drawn to be judged.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats

# Lengths that differ by less are equal: sums of decimal fractions are off by some 1e-15.
SAME_MM: Final = 1e-9
# A new trace whose points are closer than this has no hole, however close the stored ones are.
WIDEST_GAP_MM: Final = 0.5
# As many pairs of a point and a piece of the curve are looked at together.
_PAIRS: Final = 1_000_000


@dataclass(frozen=True)
class EdgeVerdict:
    """One tooth: the point of the new trace that lies furthest inward of the stored shape.

    ``inward_mm``  its distance along the normal; below 0 where the whole trace lies outside
    ``height_mm``  its height
    """

    inward_mm: float
    height_mm: float
    radius_mm: float
    limit_mm: float

    @property
    def is_chipped(self) -> bool:
        """True when it lies on the limit line or inside."""
        return self.inward_mm >= self.limit_mm - SAME_MM


def judge_edge(stored: Floats, traced: Floats, limit_mm: float) -> EdgeVerdict:
    """Compare a trace with the stored shape of the same tooth.

    ``stored`` and ``traced`` are points (height, radius) of shape (n, 2) by rising height.  Raises ValueError
    as :func:`inward_mm` does.
    """
    inward = inward_mm(stored, traced)
    at = int(np.argmax(inward))
    return EdgeVerdict(float(inward[at]), float(traced[at, 0]), float(traced[at, 1]), limit_mm)


def inward_mm(stored: Floats, traced: Floats) -> Floats:
    """Distance of every traced point inward of the stored shape, along its normal; negative outside.

    A point above or below the stored heights has nothing to be compared with: -inf.  Raises ValueError when
    the stored shape has less than two points, when a trace does not rise, and when a stretch of the stored
    shape was not traced again, where a chip could hide.
    """
    curve = _Curve(stored)
    _check_rise(traced, 1)
    _check_cover(stored[:, 0], traced[:, 0])
    block = max(1, _PAIRS // len(curve.half))
    parts = [curve.inward(traced[i : i + block]) for i in range(0, len(traced), block)]
    return np.concatenate(parts)


def limit_line(stored: Floats, limit_mm: float, pieces: int = 8) -> Floats:
    """The stored shape moved inward along its normal: points (height, radius) of shape (n, 2), for a figure.

    ``pieces`` points are drawn between two stored ones.  Where the line would cross itself, in a corner, the
    loop is left out.
    """
    curve = _Curve(stored)
    points, normals = curve.drawn(pieces)
    moved = points - limit_mm * normals
    distance = np.concatenate([curve.nearest(moved[i : i + 4096]) for i in range(0, len(moved), 4096)])
    # The tip of a cone: what lies beyond the axis belongs to the other side.
    kept: Floats = moved[(distance >= limit_mm - 1e-6) & (moved[:, 1] >= 0.0)]
    return kept


def _check_rise(points: Floats, least: int) -> None:
    if len(points) < least:
        raise ValueError(f"an edge has at least {least} points")
    if not np.isfinite(points).all():
        raise ValueError("heights and radii are numbers")
    if not (np.diff(points[:, 0]) > SAME_MM).all():
        raise ValueError("the heights of an edge rise, each is there once")


def _check_cover(stored: Floats, traced: Floats) -> None:
    """A chip between two traced points is not seen, so they are about as close as the stored ones."""
    twice = 2.0 * float(np.diff(stored).max()) + SAME_MM
    inside = traced[(traced > stored[0]) & (traced < stored[-1])]
    seen = np.concatenate((stored[:1], inside, stored[-1:]))
    gaps = np.diff(seen)
    # A trace that goes on beyond an end, or ends there, has seen it.
    gaps[0] = 0.0 if traced[0] <= stored[0] and len(inside) else gaps[0]
    gaps[-1] = 0.0 if traced[-1] >= stored[-1] and len(inside) else gaps[-1]
    # The tip and the top are where edges break first: no more than usual may be missing there.
    widest = np.full(len(gaps), max(WIDEST_GAP_MM, twice))
    widest[[0, -1]] = twice
    if (gaps > widest).any():
        at = int(np.argmax(gaps - widest))
        raise ValueError(
            f"the new trace has no point from height {seen[at]:g} to {seen[at + 1]:g} mm, where the stored"
            " shape has some"
        )


class _Curve:
    """The stored shape as arcs.

    Every piece has its own frame in the middle of its chord: ``along`` (unit vector of rising height) and
    ``outward``.  ``half`` is half the chord, ``bend`` the curvature [1/mm], positive where it bulges outward.
    """

    def __init__(self, points: Floats) -> None:
        _check_rise(points, 2)
        self.points = points
        chord = np.diff(points, axis=0)
        length = np.hypot(chord[:, 0], chord[:, 1])
        self.middle = (points[1:] + points[:-1]) / 2.0
        self.along = chord / length[:, None]
        self.outward = np.column_stack((-self.along[:, 1], self.along[:, 0]))
        self.half = length / 2.0
        self.bend = _flatter(_curvature(points), len(chord))
        self.cosine = np.sqrt(np.maximum(0.0, 1.0 - (self.bend * self.half) ** 2))
        # The first and the last piece go on a little: a normal near an end may meet the shape beyond it.
        self.low = -self.half.copy()
        self.high = self.half.copy()
        self.low[0] *= 3.0
        self.high[-1] *= 3.0

    def inward(self, points: Floats) -> Floats:
        """Signed distance of points (n, 2), -inf beyond the heights of the shape."""
        distance = np.where(self._is_inside(points), 1.0, -1.0) * self.nearest(points)
        first = self.points[0, 0] - SAME_MM
        last = self.points[-1, 0] + SAME_MM
        beyond = (points[:, 0] < first) | (points[:, 0] > last)
        result: Floats = np.where(beyond, -np.inf, distance)
        return result

    def nearest(self, points: Floats) -> Floats:
        """Distance of points (n, 2) to the nearest place of the shape, never negative."""
        t, s = self._local(points[:, None, :])
        to_arc, foot, is_facing = self._to_circle(t, s)
        on_arc = is_facing & (foot >= self.low) & (foot <= self.high)
        to_arc = np.where(on_arc, np.abs(to_arc), np.inf)
        difference = points[:, None, :] - self.points[None, :, :]
        to_corner = np.hypot(difference[..., 0], difference[..., 1]).min(axis=1)
        nearest: Floats = np.minimum(to_arc.min(axis=1), to_corner)
        return nearest

    def _local(self, points: Floats) -> tuple[Floats, Floats]:
        """Coordinates (n, pieces) along and outward of every chord."""
        difference = points - self.middle
        t = (difference * self.along).sum(axis=-1)
        s = (difference * self.outward).sum(axis=-1)
        return t, s

    def _to_circle(self, t: Floats, s: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Distance outward of the circle of each piece, its foot along the chord, and whether the point
        is on the arc's side of the centre.

        Written without the radius, so that a straight piece (curvature 0) is no special case: with g the
        cosine of half the arc, distance = (k (t² + s² - a²) + 2 s g) / (1 + sqrt(k² t² + (k s + g)²)).
        """
        k = self.bend
        a = self.half
        g = self.cosine
        height = k * s + g
        reach = np.hypot(k * t, height)
        distance = (k * (t * t + s * s - a * a) + 2.0 * s * g) / (1.0 + reach)
        foot = t / np.maximum(reach, 1e-300)
        return distance, foot, height > 0.0

    def _is_inside(self, points: Floats) -> NDArray[np.bool_]:
        """True below the curve at the point's own height."""
        piece = np.searchsorted(self.points[:, 0], points[:, 0], "right") - 1
        piece = np.clip(piece, 0, len(self.half) - 1)
        difference = points - self.middle[piece]
        t = (difference * self.along[piece]).sum(axis=1)
        s = (difference * self.outward[piece]).sum(axis=1)
        k = self.bend[piece]
        a = self.half[piece]
        g = self.cosine[piece]
        from_arc = k * (t * t + s * s - a * a) + 2.0 * s * g
        # Far inside, the point may be beyond the circle on its other side; the chord knows better there.
        inside: NDArray[np.bool_] = np.where(
            k >= 0.0, (s < 0.0) | (from_arc < 0.0), (s < 0.0) & (from_arc < 0.0)
        )
        return inside

    def drawn(self, pieces: int) -> tuple[Floats, Floats]:
        """Points (n, 2) along the arcs, and their outward normals."""
        share = np.linspace(-1.0, 1.0, pieces + 1)
        t = self.half[:, None] * share
        k = self.bend[:, None]
        g = self.cosine[:, None]
        root = np.sqrt(np.maximum(0.0, 1.0 - (k * t) ** 2))
        # Height of the arc over its chord, (root - g) / k without the division.
        s = k * (self.half[:, None] ** 2 - t * t) / (root + g)
        along = self.along[:, None, :]
        outward = self.outward[:, None, :]
        points = self.middle[:, None, :] + t[..., None] * along + s[..., None] * outward
        normals = (k * t)[..., None] * along + root[..., None] * outward
        return points.reshape(-1, 2), normals.reshape(-1, 2)


def _curvature(points: Floats) -> Floats:
    """Curvature [1/mm] of the circle through each point and its neighbours, shape (n - 2,)."""
    one = points[1:-1] - points[:-2]
    two = points[2:] - points[1:-1]
    across = points[2:] - points[:-2]
    lengths = np.hypot(one[:, 0], one[:, 1]) * np.hypot(two[:, 0], two[:, 1])
    turn = one[:, 1] * two[:, 0] - one[:, 0] * two[:, 1]
    result: Floats = 2.0 * turn / (lengths * np.hypot(across[:, 0], across[:, 1]))
    return result


def _flatter(bends: Floats, pieces: int) -> Floats:
    """Of the circles on both ends of each piece the flatter; straight where they bulge to different sides.

    At the first and the last piece the next circle takes the place of the one that is not there.
    """
    if not len(bends):
        return np.zeros(pieces)
    padded = np.concatenate(([bends[min(1, len(bends) - 1)]], bends, [bends[max(-2, -len(bends))]]))
    one = padded[:-1]
    two = padded[1:]
    flatter: Floats = np.where(one * two > 0.0, np.sign(one) * np.minimum(np.abs(one), np.abs(two)), 0.0)
    return flatter
