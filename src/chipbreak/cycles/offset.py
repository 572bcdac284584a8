"""A contour at a distance: every point as far off, on the side of the stock, round outer corners in arcs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.corners import BAD_CONTOUR
from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError

_NOTHING_MM = 1e-7
_NEAR_MM = 1e-4
_PIECES_OF_ARC = 64


def at_distance(contour: Sequence[Segment], distance_mm: float) -> tuple[Segment, ...]:
    """The contour moved off towards its left by a distance of 0 or more.

    Errors: CYC002 where something of the contour is smaller than that.
    """
    if distance_mm <= _NOTHING_MM:
        return tuple(contour)
    made: list[Segment] = []
    for index, one in enumerate(contour):
        moved = _moved(one, distance_mm)
        if made:
            made += _joined(made, moved, contour[index - 1].end, distance_mm)
        else:
            made.append(moved)
    whole = tuple(one for one in made if one.length_mm > _NOTHING_MM)
    _check(contour, whole, distance_mm)
    return whole


def _too_far() -> RefusalError:
    message = "something in the contour is smaller than the distance at which the cycle leaves it"
    return RefusalError(BAD_CONTOUR, message, "give a smaller D, or leave what is so small out")


def _moved(one: Segment, distance_mm: float) -> Segment:
    if one.centre is None:
        t_mm = -(one.end.h - one.start.h) / one.length_mm * distance_mm
        h_mm = (one.end.t - one.start.t) / one.length_mm * distance_mm
        return one.shifted(t_mm, h_mm)
    radius_mm = one.radius_mm - one.turn * distance_mm
    if radius_mm <= _NOTHING_MM:
        raise _too_far()
    share = radius_mm / one.radius_mm
    start, end = (
        Point(one.centre.t + share * (p.t - one.centre.t), one.centre.h + share * (p.h - one.centre.h))
        for p in (one.start, one.end)
    )
    return one._replace(start=start, end=end)


def _joined(made: list[Segment], after: Segment, corner: Point, distance_mm: float) -> list[Segment]:
    """What follows the last one of ``made``, which is shortened where both meet before their corner."""
    before = made[-1]
    out_t, out_h = _heading(before, at_end=True)
    in_t, in_h = _heading(after, at_end=False)
    turns = out_t * in_h - out_h * in_t
    if math.dist(before.end, after.start) <= _NEAR_MM:
        return [after._replace(start=before.end) if after.centre is None else after]
    if turns < 0.0 or (turns == 0.0 and out_t * in_t + out_h * in_h < 0.0):
        return [Segment(before.end, after.start, corner, -1), after]
    meeting = [p for p in _meetings(before, after) if _is_on(before, p) and _is_on(after, p)]
    if not meeting:
        raise _too_far()
    at = min(meeting, key=lambda p: math.dist(p, corner))
    made[-1] = before._replace(end=at)
    return [after._replace(start=at)]


def _heading(one: Segment, *, at_end: bool) -> tuple[float, float]:
    """The direction of travel at an end, of length 1."""
    if one.centre is None:
        return (one.end.t - one.start.t) / one.length_mm, (one.end.h - one.start.h) / one.length_mm
    at = one.end if at_end else one.start
    return (
        -one.turn * (at.h - one.centre.h) / one.radius_mm,
        one.turn * (at.t - one.centre.t) / one.radius_mm,
    )


def _is_on(one: Segment, point: Point) -> bool:
    """True for a point between the ends of a segment, of one that lies on its line or circle."""
    if one.centre is None:
        t_mm, h_mm = one.end.t - one.start.t, one.end.h - one.start.h
        along = (point.t - one.start.t) * t_mm + (point.h - one.start.h) * h_mm
        return -_NEAR_MM <= along / one.length_mm <= one.length_mm + _NEAR_MM
    part = one._replace(end=point)
    near = min(math.dist(point, one.start), math.dist(point, one.end)) <= _NEAR_MM
    return near or abs(part.sweep) <= abs(one.sweep)


def _meetings(one: Segment, other: Segment) -> Iterator[Point]:
    """Where the lines or circles of two segments meet."""
    if one.centre is None and other.centre is None:
        yield from _lines_meet(one, other)
    elif one.centre is None:
        yield from _line_meets_circle(one, other)
    elif other.centre is None:
        yield from _line_meets_circle(other, one)
    else:
        yield from _circles_meet(one, other)


def _lines_meet(one: Segment, other: Segment) -> Iterator[Point]:
    a_t, a_h = _heading(one, at_end=True)
    b_t, b_h = _heading(other, at_end=True)
    cross = a_t * b_h - a_h * b_t
    if abs(cross) > _NOTHING_MM:
        along = ((other.start.t - one.start.t) * b_h - (other.start.h - one.start.h) * b_t) / cross
        yield Point(one.start.t + along * a_t, one.start.h + along * a_h)


def _line_meets_circle(line: Segment, arc: Segment) -> Iterator[Point]:
    assert arc.centre is not None
    t, h = _heading(line, at_end=True)
    along = (arc.centre.t - line.start.t) * t + (arc.centre.h - line.start.h) * h
    foot = Point(line.start.t + along * t, line.start.h + along * h)
    half = arc.radius_mm**2 - math.dist(foot, arc.centre) ** 2
    if half > -_NEAR_MM:
        for sign in (-1.0, 1.0):
            step = sign * math.sqrt(max(half, 0.0))
            yield Point(foot.t + step * t, foot.h + step * h)


def _circles_meet(one: Segment, other: Segment) -> Iterator[Point]:
    assert one.centre is not None
    assert other.centre is not None
    apart = math.dist(one.centre, other.centre)
    if apart <= _NOTHING_MM:
        return
    t, h = (other.centre.t - one.centre.t) / apart, (other.centre.h - one.centre.h) / apart
    along = (apart**2 + one.radius_mm**2 - other.radius_mm**2) / (2.0 * apart)
    half = one.radius_mm**2 - along**2
    if half > -_NEAR_MM:
        for sign in (-1.0, 1.0):
            step = sign * math.sqrt(max(half, 0.0))
            yield Point(one.centre.t + along * t - step * h, one.centre.h + along * h + step * t)


def _check(contour: Sequence[Segment], made: Sequence[Segment], distance_mm: float) -> None:
    """No point may be nearer to the contour than the distance.  Errors: CYC002."""
    lines = _places(contour)
    places = _places(made)
    first, last = lines[:-1], lines[1:]
    way = last - first
    length = np.maximum((way**2).sum(axis=1), _NOTHING_MM**2)
    for place in places:
        share = np.clip(((place - first) * way).sum(axis=1) / length, 0.0, 1.0)
        nearest = first + share[:, np.newaxis] * way
        if float(np.hypot(*(nearest - place).T).min()) < distance_mm - 0.01 * distance_mm - 1e-3:
            raise _too_far()


def _places(contour: Sequence[Segment]) -> Floats:
    """Places on a contour, (n, 2)."""
    rows = [contour[0].start]
    for one in contour:
        count = 5 if one.centre is None else _PIECES_OF_ARC
        rows += [one.point(share) for share in np.linspace(0.0, 1.0, count).tolist()[1:]]
    return np.array(rows)
