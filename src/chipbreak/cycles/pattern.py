"""Passes along the contour (G73): all of one shape, the first the farthest off, the last at the allowances.

Each begins at the start point, moved as the pass is, and rushes back there from its end.  A pattern may have
any shape; the ways of the rapids must not cross it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.reading import BEYOND_START
from chipbreak.cycles.roughing import Motion, Pass
from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_PIECES_OF_ARC = 200
_NOTHING_MM = 1e-6


class Pattern(NamedTuple):
    """What a pattern is told; t runs along Z and h along the radius, lengths in mm.

    ``start``     where the tool stands before the cycle
    ``first``     the first point of the contour;  ``contour``  its moves from there on
    ``offsets``   how far each pass is off the contour, in order
    ``feeds_in``  the tool is fed, and does not rush, to the first point
    """

    start: Point
    first: Point
    contour: tuple[Segment, ...]
    offsets: tuple[Point, ...]
    feeds_in: bool


def offsets_of(times: int, first: Point, allowance: Point) -> tuple[Point, ...]:
    """How far each of the passes is off: the last by the allowance, the first farther by ``first``."""
    shares = [(times - 1 - number) / (times - 1) for number in range(times - 1)] + [0.0]
    return tuple(
        Point(allowance.t + share * first.t + 0.0, allowance.h + share * first.h + 0.0) for share in shares
    )


def pattern_passes(pattern: Pattern) -> list[Pass]:
    """The passes, in order.  Errors: CYC006 where a rapid would cross the shape that its pass has cut."""
    passes = []
    at = pattern.start
    for number, offset in enumerate(pattern.offsets, 1):
        begin = _moved(pattern.start, offset)
        first = _moved(pattern.first, offset)
        shape = [one.shifted(offset.t, offset.h) for one in pattern.contour]
        moves = [Motion(False, begin)] if _differ(at, begin) else []
        if _differ(begin, first):
            moves.append(Motion(pattern.feeds_in, first))
            _refuse_crossing([begin, first], shape)
        moves += [Motion(True, one.end, one.centre, one.turn) for one in shape]
        is_last = number == len(pattern.offsets)
        at = pattern.start if is_last else _moved(pattern.start, pattern.offsets[number])
        back = _way_back(shape[-1].end, at, outwards=pattern.start.h - pattern.first.h)
        _refuse_crossing([shape[-1].end, *back], shape)
        moves += [Motion(False, place) for place in back]
        title = f"{offset.h:.4g} and {offset.t:.4g} mm off the contour"
        passes.append(Pass(number, title, tuple(moves)))
    return passes


def _moved(point: Point, offset: Point) -> Point:
    return Point(point.t + offset.t, point.h + offset.h)


def _differ(one: Point, other: Point) -> bool:
    return max(abs(one.t - other.t), abs(one.h - other.h)) > _NOTHING_MM


def _way_back(end: Point, to: Point, outwards: float) -> list[Point]:
    """Away from the part first, then along it; from a place farther out, along it first."""
    over = Point(end.t, to.h) if (to.h - end.h) * outwards > 0.0 else Point(to.t, end.h)
    places = [over] if _differ(end, over) and _differ(over, to) else []
    return [*places, to] if _differ(end, to) else []


def _refuse_crossing(way: Sequence[Point], shape: Sequence[Segment]) -> None:
    """A rapid, or the way to the first point, stays on one side of the shape.  Errors: CYC006."""
    line = _outline(shape)
    for begin, end in pairwise(way):
        if _crosses(np.array(begin), np.array(end), line):
            message = "a rapid of this cycle would cross its contour"
            raise RefusalError(BEYOND_START, message, "start the cycle outside the stock, before the contour")


def _outline(shape: Sequence[Segment]) -> Floats:
    """Places on the shape, (n, 2)."""
    rows = [shape[0].start]
    for one in shape:
        count = 2 if one.centre is None else _PIECES_OF_ARC
        rows += [one.point(share) for share in np.linspace(0.0, 1.0, count).tolist()[1:]]
    return np.array(rows)


def _crosses(begin: Floats, end: Floats, line: Floats) -> bool:
    """True where a straight way and a line, (n, 2), cross; touching is no crossing."""
    way = end - begin
    off_way = _cross(way, line - begin)
    pieces = line[1:] - line[:-1]
    near = _NOTHING_MM * max(float(np.hypot(*way)), _NOTHING_MM)
    changes = (np.minimum(off_way[:-1], off_way[1:]) < -near) & (np.maximum(off_way[:-1], off_way[1:]) > near)
    lengths = np.maximum(np.hypot(pieces[:, 0], pieces[:, 1]), _NOTHING_MM)
    begin_off = _cross(pieces, begin - line[:-1]) / lengths
    end_off = _cross(pieces, end - line[:-1]) / lengths
    passes = (np.minimum(begin_off, end_off) < -_NOTHING_MM) & (np.maximum(begin_off, end_off) > _NOTHING_MM)
    return bool((changes & passes).any())


def _cross(one: Floats, other: Floats) -> Floats:
    product: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product
