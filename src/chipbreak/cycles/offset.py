"""A contour at a distance: every point as far off, on the side of the stock, round outer corners in arcs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from chipbreak.cycles.contour import Point, Segment, direction
from chipbreak.cycles.corners import BAD_CONTOUR
from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_NOTHING_MM = 1e-7
_NEAR_MM = 1e-4
_PIECES_OF_ARC = 64


class Turned(NamedTuple):
    """Two segments that part at an outer corner, and what stands between them."""

    before: Segment
    between: Sequence[Segment]
    after: Segment


Corner = Callable[[float, Segment, Segment, Point], Turned]
"""How an outer corner is taken: from the distance [mm], the segments beside it, and the corner itself."""


def at_distance(contour: Sequence[Segment], distance_mm: float) -> tuple[Segment, ...]:
    """The contour moved off towards its left by a distance of 0 or more, round outer corners in arcs.

    Errors: CYC002 where something of the contour is smaller than that.
    """
    if distance_mm <= _NOTHING_MM:
        return tuple(contour)
    made = [one for pieces in pieces_at_distance(contour, distance_mm, round_corner) for one in pieces]
    check_distance(contour, made, distance_mm)
    return tuple(made)


def pieces_at_distance(contour: Sequence[Segment], distance_mm: float, corner: Corner) -> list[list[Segment]]:
    """What stands for each segment at a distance above 0: the outer corner before it, and itself.

    Errors: CYC002 where something of the contour is smaller than that.
    """
    moved = [_moved(one, distance_mm) for one in contour]
    made = [moved[:1]]
    turn = partial(corner, distance_mm)
    for before, after, at in zip(moved, moved[1:], contour, strict=False):
        made.append(_joined(made[-1], before, after, at.end, turn))
    return [[one for one in pieces if one.length_mm > _NOTHING_MM] for pieces in made]


def round_corner(_distance_mm: float, before: Segment, after: Segment, corner: Point) -> Turned:
    """An arc about the corner."""
    return Turned(before, [Segment(before.end, after.start, corner, -1)], after)


def sharp_corner(distance_mm: float, before: Segment, after: Segment, _corner: Point) -> Turned:
    """On along the last direction and into the next one; beyond a right angle a third line cuts it short."""
    out_t, out_h = heading(before, at_end=True)
    in_t, in_h = heading(after, at_end=False)
    turn = abs(math.atan2(out_t * in_h - out_h * in_t, out_t * in_t + out_h * in_h))
    on_mm = distance_mm * (math.tan(turn / 2.0) if turn <= math.pi / 2.0 + _NOTHING_MM else 1.0)
    beyond = Point(before.end.t + on_mm * out_t, before.end.h + on_mm * out_h)
    ahead = Point(after.start.t - on_mm * in_t, after.start.h - on_mm * in_h)
    is_short = math.dist(beyond, ahead) > _NEAR_MM
    between = [Segment(beyond, ahead)] if is_short else []
    ahead = ahead if is_short else beyond
    if before.centre is None:
        before = before._replace(end=beyond)
    else:
        between = [Segment(before.end, beyond), *between]
    if after.centre is None:
        return Turned(before, between, after._replace(start=ahead))
    return Turned(before, [*between, Segment(ahead, after.start)], after)


def _too_far() -> RefusalError:
    message = "something in the contour is smaller than the distance at which the cycle leaves it"
    return RefusalError(BAD_CONTOUR, message, "give a smaller D, or leave what is so small out")


def _moved(one: Segment, distance_mm: float) -> Segment:
    if one.centre is None:
        t, h = direction(one)
        return one.shifted(-h * distance_mm, t * distance_mm)
    radius_mm = one.radius_mm - one.turn * distance_mm
    if radius_mm <= _NOTHING_MM:
        raise _too_far()
    share = radius_mm / one.radius_mm
    start, end = (
        Point(one.centre.t + share * (p.t - one.centre.t), one.centre.h + share * (p.h - one.centre.h))
        for p in (one.start, one.end)
    )
    return one._replace(start=start, end=end)


def _joined(
    made: list[Segment],
    before: Segment,
    after: Segment,
    at_corner: Point,
    turn: Callable[[Segment, Segment, Point], Turned],
) -> list[Segment]:
    """What follows the last one of ``made``, which is shortened where both meet before their corner.

    That one is ``before`` as far as the corner at its other end has left of it, which may be nothing.
    """
    out_t, out_h = heading(before, at_end=True)
    in_t, in_h = heading(after, at_end=False)
    turns = out_t * in_h - out_h * in_t
    if math.dist(before.end, after.start) <= _NEAR_MM:
        return [after._replace(start=before.end) if after.centre is None else after]
    is_straight_back = turns <= _NOTHING_MM and out_t * in_t + out_h * in_h < 0.0
    if turns < 0.0 or is_straight_back:
        turned = turn(before, after, at_corner)
        made[-1] = made[-1]._replace(end=turned.before.end)
        return [*turned.between, turned.after]
    meeting = [p for p in _meetings(before, after) if _is_on(made[-1], p) and _is_on(after, p)]
    if not meeting:
        raise _too_far()
    at = min(meeting, key=lambda p: math.dist(p, at_corner))
    made[-1] = made[-1]._replace(end=at)
    return [after._replace(start=at)]


def heading(one: Segment, *, at_end: bool) -> tuple[float, float]:
    """The direction of travel at an end, of length 1."""
    if one.centre is None:
        return direction(one)
    at = one.end if at_end else one.start
    return (
        -one.turn * (at.h - one.centre.h) / one.radius_mm,
        one.turn * (at.t - one.centre.t) / one.radius_mm,
    )


def _is_on(one: Segment, point: Point) -> bool:
    """True for a point between the ends of a segment, of one that lies on its line or circle."""
    if min(math.dist(point, one.start), math.dist(point, one.end)) <= _NEAR_MM:
        return True
    if one.centre is None:
        t_mm, h_mm = one.end.t - one.start.t, one.end.h - one.start.h
        along = (point.t - one.start.t) * t_mm + (point.h - one.start.h) * h_mm
        return 0.0 < along < one.length_mm**2
    return abs(one._replace(end=point).sweep) < abs(one.sweep)


def _meetings(one: Segment, other: Segment) -> Iterator[Point]:
    """Where the lines or circles of two segments meet; nowhere for lines along each other."""
    if one.centre is None and other.centre is None:
        yield from _lines_meet(one, other)
    elif one.centre is None:
        yield from _line_meets_circle(one, other)
    elif other.centre is None:
        yield from _line_meets_circle(other, one)
    else:
        yield from _circles_meet(one, other)


def _lines_meet(one: Segment, other: Segment) -> Iterator[Point]:
    a_t, a_h = direction(one)
    b_t, b_h = direction(other)
    cross = a_t * b_h - a_h * b_t
    if cross == 0.0:
        return
    way_t, way_h = other.start.t - one.start.t, other.start.h - one.start.h
    along = (way_t * b_h - way_h * b_t) / cross
    yield Point(one.start.t + along * a_t, one.start.h + along * a_h)


def _line_meets_circle(line: Segment, arc: Segment) -> Iterator[Point]:
    assert arc.centre is not None
    t, h = direction(line)
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


def check_distance(contour: Sequence[Segment], made: Sequence[Segment], distance_mm: float) -> None:
    """No point of ``made`` may be nearer to the contour, which may have gaps.  Errors: CYC002."""
    lines = [_places(one) for one in contour]
    if not lines or not made:
        return
    first = np.concatenate([line[:-1] for line in lines])
    way = np.concatenate([line[1:] for line in lines]) - first
    length = np.maximum((way**2).sum(axis=1), _NOTHING_MM**2)
    for place in np.concatenate([_places(one) for one in made]):
        share = np.clip(((place - first) * way).sum(axis=1) / length, 0.0, 1.0)
        nearest = first + share[:, np.newaxis] * way
        if float(np.hypot(*(nearest - place).T).min()) < distance_mm - 0.01 * distance_mm - 1e-3:
            raise _too_far()


def _places(one: Segment) -> Floats:
    """Places on a segment with its ends, (n, 2)."""
    count = 5 if one.centre is None else _PIECES_OF_ARC
    return np.array([one.start, *(one.point(share) for share in np.linspace(0.0, 1.0, count).tolist()[1:])])
