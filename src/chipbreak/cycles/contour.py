"""The contour of a cycle as plain geometry, in the axes of its passes.

A pass cuts along ``t`` [mm], which grows in the direction of cutting, at a height ``h`` [mm], which grows
from the finished part towards the stock.  So outer and inner turning, facing, and all four quadrants are one
case: ``Frame`` turns the axes of the lathe into these and back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from chipbreak.text.named_tuple import NamedTuple

_NOTHING_MM = 1e-9


class Point(NamedTuple):
    """A place in the axes of the passes [mm]."""

    t: float
    h: float


class Segment(NamedTuple):
    """A line (``turn`` 0), or an arc about ``centre``: ``turn`` 1 runs from +t towards +h, -1 back."""

    start: Point
    end: Point
    centre: Point | None = None
    turn: int = 0

    @property
    def radius_mm(self) -> float:
        """The radius of an arc; infinite for a line."""
        return math.inf if self.centre is None else math.dist(self.start, self.centre)

    @property
    def sweep(self) -> float:
        """The angle of an arc [rad], with its sign; 0 for a line."""
        if self.centre is None:
            return 0.0
        first, last = _angle(self.centre, self.start), _angle(self.centre, self.end)
        full = (last - first) * self.turn % (2.0 * math.pi)
        return self.turn * (full or 2.0 * math.pi)

    @property
    def length_mm(self) -> float:
        """How long it is."""
        if self.centre is None:
            return math.dist(self.start, self.end)
        return abs(self.sweep) * self.radius_mm

    def point(self, share: float) -> Point:
        """The point at a share of its length, 0 to 1."""
        if self.centre is None:
            t = self.start.t + share * (self.end.t - self.start.t)
            return Point(t, self.start.h + share * (self.end.h - self.start.h))
        angle = _angle(self.centre, self.start) + share * self.sweep
        radius = self.radius_mm
        return Point(self.centre.t + radius * math.cos(angle), self.centre.h + radius * math.sin(angle))

    def shifted(self, t_mm: float, h_mm: float) -> Segment:
        """The same elsewhere."""
        centre = None if self.centre is None else Point(self.centre.t + t_mm, self.centre.h + h_mm)
        start, end = (Point(p.t + t_mm, p.h + h_mm) for p in (self.start, self.end))
        return Segment(start, end, centre, self.turn)

    def split(self) -> list[Segment]:
        """The same in parts in which neither t nor h turns back."""
        if self.centre is None:
            return [self]
        first = _angle(self.centre, self.start)
        between = map(self.point, sorted(self._turning_shares(first)))
        points = [self.start, *between, self.end]
        return [Segment(a, b, self.centre, self.turn) for a, b in pairwise(points)]

    def _turning_shares(self, first: float) -> Iterator[float]:
        """Where an arc passes a quarter of its circle; it begins between -pi and pi and turns once."""
        quarter = math.pi / 2.0
        for number in range(-5, 6):
            share = (number * quarter - first) / self.sweep
            if _NOTHING_MM < share < 1.0 - _NOTHING_MM:
                yield share

    def t_at(self, level_mm: float) -> float:
        """Where a part that does not turn back has this height; its height must reach it."""
        if self.centre is None:
            share = (level_mm - self.start.h) / (self.end.h - self.start.h)
            return self.start.t + share * (self.end.t - self.start.t)
        run = math.sqrt(max(self.radius_mm**2 - (level_mm - self.centre.h) ** 2, 0.0))
        return self.centre.t + math.copysign(run, self.point(0.5).t - self.centre.t)


def _angle(centre: Point, point: Point) -> float:
    return math.atan2(point.h - centre.h, point.t - centre.t)


def direction(line: Segment) -> tuple[float, float]:
    """The direction of a line, of length 1."""
    way_mm = line.length_mm
    return (line.end.t - line.start.t) / way_mm, (line.end.h - line.start.h) / way_mm


def parts_of(contour: Sequence[Segment]) -> list[Segment]:
    """A contour in parts in which neither t nor h turns back; those without length are left out."""
    return [part for one in contour for part in one.split() if part.length_mm > _NOTHING_MM]


def turns_back_along_t(contour: Sequence[Segment]) -> bool:
    """True where a segment goes against the direction of cutting: an undercut."""
    return any(part.end.t < part.start.t - 1e-6 for one in contour for part in one.split())


def drop_mm(contour: Sequence[Segment]) -> float:
    """How far a contour goes down again behind its highest place so far: the depth of its deepest pocket."""
    highest_mm = -math.inf
    deepest_mm = 0.0
    for part in parts_of(contour):
        highest_mm = max(highest_mm, part.start.h)
        deepest_mm = max(deepest_mm, highest_mm - part.end.h)
    return deepest_mm


class Pocket(NamedTuple):
    """A stretch along t in which a contour lies below what stands before it; ``rim_mm`` is that height."""

    first_mm: float
    last_mm: float
    rim_mm: float


class Filled(NamedTuple):
    """A contour that never goes down, and the pockets that were filled for that."""

    contour: tuple[Segment, ...]
    pockets: tuple[Pocket, ...]


def filled(contour: Sequence[Segment]) -> Filled:
    """The contour with each pocket filled up to the height that stands before it."""
    made: list[Segment] = []
    pockets: list[Pocket] = []
    rim_mm = contour[0].start.h
    begin: Point | None = None
    for part in parts_of(contour):
        if part.end.h <= rim_mm + _NOTHING_MM and (begin or part.end.h < part.start.h - _NOTHING_MM):
            begin = begin or part.start
            continue
        rest = part
        if begin is not None:
            if part.start.h < rim_mm:
                rest = part._replace(start=Point(part.t_at(rim_mm), rim_mm))
            pockets.append(Pocket(begin.t, rest.start.t, rim_mm))
            made.append(Segment(begin, rest.start))
        made.append(rest)
        begin = None
        rim_mm = part.end.h
    if begin is not None:
        end = Point(contour[-1].end.t, rim_mm)
        pockets.append(Pocket(begin.t, end.t, rim_mm))
        made.append(Segment(begin, end))
    return Filled(tuple(one for one in made if one.length_mm > _NOTHING_MM), tuple(pockets))


class Frame(NamedTuple):
    """How the axes of passes lie in those of the lathe: ``along`` is "Z" or "X", and two signs.

    ``t_sign`` is 1 where cutting goes towards larger numbers of the axis along which it goes, ``h_sign`` 1
    where the stock lies at larger numbers of the other axis.
    """

    along: str
    t_sign: int
    h_sign: int

    def inside(self, z_mm: float, radius_mm: float) -> Point:
        """A place of the lathe in the axes of the passes."""
        t, h = (z_mm, radius_mm) if self.along == "Z" else (radius_mm, z_mm)
        return Point(self.t_sign * t, self.h_sign * h)

    def outside(self, point: Point) -> tuple[float, float]:
        """Z and radius [mm] of a point."""
        t, h = self.t_sign * point.t, self.h_sign * point.h
        return (t, h) if self.along == "Z" else (h, t)

    @property
    def mirrors(self) -> bool:
        """True when a turn towards +h is the other way round in the plane Z, radius."""
        return self.t_sign * self.h_sign != (1 if self.along == "Z" else -1)
