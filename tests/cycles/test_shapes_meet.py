"""Where lines and arcs meet and cross, against exact arithmetic and against the places on them."""

from __future__ import annotations

import math
from contextlib import nullcontext
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.offset import _circles_meet, _is_on, _line_meets_circle, check_distance, heading
from chipbreak.cycles.pattern import _crosses, _way_back
from chipbreak.text.diagnostics import RefusalError

places = st.builds(Point, *[st.integers(-20, 20).map(float)] * 2)


def side(a: Point, b: Point, c: Point) -> int:
    """On which side of the way from a to b the place c is, without rounding."""
    t, h = (Fraction(x) - Fraction(y) for x, y in zip(b, a, strict=True))
    off = t * (Fraction(c.h) - Fraction(a.h)) - h * (Fraction(c.t) - Fraction(a.t))
    return (off > 0) - (off < 0)


@given(places, places, st.lists(places, min_size=2, max_size=5))
def test_a_way_crosses_a_line_where_each_parts_the_ends_of_the_other(
    begin: Point, end: Point, line: list[Point]
) -> None:
    wanted = any(
        side(begin, end, a) * side(begin, end, b) < 0 and side(a, b, begin) * side(a, b, end) < 0
        for a, b in pairwise(line)
    )
    assert _crosses(np.array(begin), np.array(end), np.array(line)) == wanted


angles = st.floats(0.0, 2.0 * math.pi)
radii = st.floats(0.5, 20.0)


@st.composite
def arcs(draw: st.DrawFn) -> Segment:
    centre = draw(places)
    radius = draw(radii)
    start, end = (
        Point(centre.t + radius * math.cos(angle), centre.h + radius * math.sin(angle))
        for angle in (draw(angles), draw(angles))
    )
    assume(math.dist(start, end) > 1e-3)
    return Segment(start, end, centre, draw(st.sampled_from([1, -1])))


@given(arcs(), st.booleans())
def test_an_arc_heads_where_its_next_place_is(arc: Segment, at_end: bool) -> None:
    near = 1e-6
    one, other = (1.0 - near, 1.0) if at_end else (0.0, near)
    a, b = arc.point(one), arc.point(other)
    way = math.dist(a, b)
    assert heading(arc, at_end=at_end) == pytest.approx(((b.t - a.t) / way, (b.h - a.h) / way), abs=1e-3)


@given(arcs(), arcs())
def test_two_circles_meet_on_both(one: Segment, other: Segment) -> None:
    assert one.centre is not None and other.centre is not None
    apart = math.dist(one.centre, other.centre)
    found = list(_circles_meet(one, other))
    for place in found:
        assert math.dist(place, one.centre) == pytest.approx(one.radius_mm, rel=1e-3)
        assert math.dist(place, other.centre) == pytest.approx(other.radius_mm, rel=1e-3)
    if abs(one.radius_mm - other.radius_mm) + 0.01 < apart < one.radius_mm + other.radius_mm - 0.01:
        assert len(found) == 2 and math.dist(*found) > 1e-3


@given(places, places, arcs())
def test_a_line_meets_a_circle_on_both(start: Point, end: Point, arc: Segment) -> None:
    assume(start != end)
    assert arc.centre is not None
    line = Segment(start, end)
    found = list(_line_meets_circle(line, arc))
    for place in found:
        assert math.dist(place, arc.centre) == pytest.approx(arc.radius_mm, rel=1e-3)
        off = (end.t - start.t) * (place.h - start.h) - (end.h - start.h) * (place.t - start.t)
        assert abs(off) / math.dist(start, end) < 1e-6
    off_centre = abs(
        (end.t - start.t) * (arc.centre.h - start.h) - (end.h - start.h) * (arc.centre.t - start.t)
    ) / math.dist(start, end)
    assert bool(found) == (off_centre < arc.radius_mm) or abs(off_centre - arc.radius_mm) < 0.01
    if off_centre < arc.radius_mm - 0.01:
        assert len(found) == 2 and math.dist(*found) > 1e-3


@given(places, places, st.floats(-1.0, 2.0))
def test_a_place_is_on_a_line_between_its_ends(start: Point, end: Point, share: float) -> None:
    assume(math.dist(start, end) > 0.1 and min(abs(share), abs(share - 1.0)) > 0.01)
    line = Segment(start, end)
    assert _is_on(line, line.point(share)) == (0.0 <= share <= 1.0)


@given(places, places, st.sampled_from([-1.0, 1.0]))
def test_the_way_back_goes_along_the_axes_and_never_nowhere(end: Point, to: Point, outwards: float) -> None:
    way = [end, *_way_back(end, to, outwards)]
    assert way[-1] == to
    legs = list(pairwise(way))
    assert all((a.t == b.t) != (a.h == b.h) for a, b in legs), "one axis moves, and it moves"
    if len(legs) == 2:
        is_out = (to.h - end.h) * outwards > 0.0
        assert (legs[0][0].t == legs[0][1].t) == is_out, "away from the part first"


@pytest.mark.parametrize(("off_mm", "is_too_near"), [(0.5, True), (0.9, True), (1.0, False), (2.0, False)])
@pytest.mark.parametrize("at_mm", [3.0, 50.0, 97.0])
def test_no_place_may_be_nearer_to_any_place_of_a_contour(
    off_mm: float, is_too_near: bool, at_mm: float
) -> None:
    contour = [Segment(Point(0.0, 0.0), Point(100.0, 0.0)), Segment(Point(100.0, 0.0), Point(100.0, -30.0))]
    made = [Segment(Point(at_mm, 40.0), Point(at_mm, off_mm))]
    with pytest.raises(RefusalError) if is_too_near else nullcontext():
        check_distance(contour, made, 1.0)
