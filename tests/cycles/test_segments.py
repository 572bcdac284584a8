"""Lines and arcs of a contour against closed forms: places, parts that do not turn back, pockets."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from chipbreak.cycles.contour import (
    Frame,
    Pocket,
    Point,
    Segment,
    direction,
    drop_mm,
    filled,
    parts_of,
    turns_back_along_t,
)

LINE = Segment(Point(3.0, 7.0), Point(7.0, 10.0))
CENTRE = Point(10.0, 5.0)


def on_circle(degrees: float, radius_mm: float = 2.0) -> Point:
    angle = math.radians(degrees)
    return Point(CENTRE.t + radius_mm * math.cos(angle), CENTRE.h + radius_mm * math.sin(angle))


def arc(first_deg: float, last_deg: float, turn: int) -> Segment:
    return Segment(on_circle(first_deg), on_circle(last_deg), CENTRE, turn)


def near(point: Point, wanted: tuple[float, float]) -> bool:
    return math.dist(point, wanted) < 1e-9


def test_a_line() -> None:
    assert (LINE.radius_mm, LINE.sweep, LINE.length_mm) == (math.inf, 0.0, 5.0)
    assert [LINE.point(share) for share in (0.0, 0.25, 1.0)] == [(3.0, 7.0), (4.0, 7.75), (7.0, 10.0)]
    assert LINE.split() == [LINE]
    assert direction(LINE) == (0.8, 0.6)
    assert LINE.shifted(2.0, -1.0) == Segment(Point(5.0, 6.0), Point(9.0, 9.0))
    assert (LINE.t_at(7.0), LINE.t_at(8.5), LINE.t_at(10.0)) == (3.0, 5.0, 7.0)


@pytest.mark.parametrize(
    ("first", "last", "turn", "sweep_deg"),
    [
        (200.0, 80.0, 1, 240.0),
        (80.0, 200.0, -1, -240.0),
        (30.0, 60.0, 1, 30.0),
        (30.0, 60.0, -1, -330.0),
        (-170.0, 170.0, -1, -20.0),
        (40.0, 40.0, 1, 360.0),
        (40.0, 40.0, -1, -360.0),
    ],
)
def test_an_arc(first: float, last: float, turn: int, sweep_deg: float) -> None:
    one = arc(first, last, turn)
    assert one.radius_mm == pytest.approx(2.0)
    assert math.degrees(one.sweep) == pytest.approx(sweep_deg)
    assert one.length_mm == pytest.approx(2.0 * math.radians(abs(sweep_deg)))
    for share in (0.0, 0.3, 1.0):
        assert near(one.point(share), on_circle(first + share * sweep_deg))
    moved = one.shifted(3.0, -4.0)
    assert moved.centre == Point(13.0, 1.0) and moved.turn == turn
    assert near(moved.start, (one.start.t + 3.0, one.start.h - 4.0))
    assert near(moved.end, (one.end.t + 3.0, one.end.h - 4.0))


@pytest.mark.parametrize(
    ("first", "last", "turn", "between_deg"),
    [
        (200.0, 80.0, 1, [270.0, 0.0]),
        (80.0, 200.0, -1, [0.0, 270.0]),
        (0.0, 180.0, 1, [90.0]),
        (90.0, -90.0, -1, [0.0]),
        (10.0, 80.0, 1, []),
        (-179.0, -178.0, -1, [180.0, 90.0, 0.0, 270.0]),
        (179.0, 178.0, 1, [180.0, 270.0, 0.0, 90.0]),
    ],
)
def test_an_arc_parts_where_it_turns_back(
    first: float, last: float, turn: int, between_deg: list[float]
) -> None:
    one = arc(first, last, turn)
    parts = one.split()
    ends = [on_circle(degrees) for degrees in between_deg]
    assert len(parts) == len(ends) + 1
    assert parts[0].start == one.start and parts[-1].end == one.end
    assert all(near(part.end, end) for part, end in zip(parts, ends, strict=False))
    assert all(a.end == b.start for a, b in pairwise(parts))
    assert {(part.centre, part.turn) for part in parts} == {(CENTRE, turn)}


@pytest.mark.parametrize("degrees", [20.0, 70.0, 110.0, 160.0, 200.0, 250.0, 290.0, 340.0])
def test_where_a_part_has_a_height(degrees: float) -> None:
    """Left of the centre or right of it, as the part is; a height beyond the arc is its highest place."""
    place = on_circle(degrees)
    part = arc(degrees - 15.0, degrees + 15.0, 1)
    assert part.t_at(place.h) == pytest.approx(place.t)
    top = arc(60.0, 90.0, 1)
    assert top.t_at(7.0 + 1e-9) == 10.0


def test_what_has_no_length_is_no_part() -> None:
    dot = Segment(Point(1.0, 1.0), Point(1.0, 1.0 + 5e-10))
    short = Segment(Point(1.0, 1.0), Point(1.0, 1.0 + 2e-9))
    assert parts_of([dot, LINE, short]) == [LINE, short]


@pytest.mark.parametrize(("back_mm", "turns"), [(0.0, False), (0.9e-6, False), (1.1e-6, True), (3.0, True)])
def test_a_contour_turns_back_where_t_gets_less(back_mm: float, turns: bool) -> None:
    back = Segment(LINE.end, Point(LINE.end.t - back_mm, 12.0))
    assert turns_back_along_t([LINE, back]) is turns
    assert turns_back_along_t([LINE, back, LINE]) is turns


@pytest.mark.parametrize(("first", "last", "turns"), [(180.0, 0.0, False), (180.0, -20.0, True)])
def test_an_arc_turns_back_behind_a_quarter(first: float, last: float, turns: bool) -> None:
    assert turns_back_along_t([arc(first, last, -1)]) is turns


def polyline(*places: tuple[float, float]) -> list[Segment]:
    return [Segment(Point(*a), Point(*b)) for a, b in pairwise(places)]


@pytest.mark.parametrize(
    ("places", "drop"),
    [
        ([(0.0, 1.0), (4.0, 3.0), (5.0, 3.0)], 0.0),
        ([(0.0, 1.0), (4.0, 3.0), (5.0, 2.5), (6.0, 4.0), (7.0, 2.0), (8.0, 5.0)], 2.0),
        ([(0.0, 4.0), (4.0, 3.0), (5.0, 3.5), (6.0, 1.0)], 3.0),
        ([(0.0, -6.0), (4.0, -5.0), (5.0, -7.5)], 2.5),
    ],
)
def test_how_far_a_contour_goes_down_again(places: list[tuple[float, float]], drop: float) -> None:
    assert drop_mm(polyline(*places)) == pytest.approx(drop)


def test_each_pocket_is_filled_up_to_its_rim() -> None:
    """The second one ends in the middle of a slope, the third one has no wall behind it."""
    contour = polyline(
        (0.0, 1.0),
        (2.0, 3.0),
        (3.0, 2.0),
        (4.0, 2.0),
        (5.0, 3.0),
        (6.0, 5.0),
        (7.0, 4.0),
        (9.0, 8.0),
        (10.0, 6.0),
        (12.0, 7.0),
    )
    made = filled(contour)
    assert made.pockets == (Pocket(2.0, 5.0, 3.0), Pocket(6.0, 7.5, 5.0), Pocket(9.0, 12.0, 8.0))
    wanted = [(0.0, 1.0), (2.0, 3.0), (5.0, 3.0), (6.0, 5.0), (7.5, 5.0), (9.0, 8.0), (12.0, 8.0)]
    assert list(made.contour) == polyline(*wanted)


def test_a_contour_without_pockets_stays_as_it_is() -> None:
    contour = polyline((0.0, 1.0), (0.0, 3.0), (4.0, 3.0), (5.0, 6.0))
    assert filled(contour) == (tuple(contour), ())


def test_a_pocket_at_the_first_place() -> None:
    contour = polyline((0.0, 5.0), (2.0, 3.0), (4.0, 3.0), (6.0, 7.0))
    assert filled(contour).pockets == (Pocket(0.0, 5.0, 5.0),)
    assert list(filled(contour).contour) == polyline((0.0, 5.0), (5.0, 5.0), (6.0, 7.0))


def test_a_pocket_without_width_leaves_no_line() -> None:
    contour = polyline((0.0, 3.0), (4.0, 3.0), (4.0, 1.0), (4.0, 5.0))
    made = filled(contour)
    assert list(made.contour) == polyline((0.0, 3.0), (4.0, 3.0), (4.0, 5.0))
    assert made.pockets == (Pocket(4.0, 4.0, 3.0),)


def test_a_round_pocket_has_its_edge_on_the_arc() -> None:
    """A fillet of radius 2 from the floor up to a wall; the rim is 1 mm over the floor."""
    rise = Segment(Point(6.0, 0.0), Point(8.0, 2.0), Point(6.0, 2.0), 1)
    contour = [*polyline((0.0, 0.0), (0.0, 1.0), (3.0, 1.0), (3.0, 0.0), (6.0, 0.0)), rise]
    edge = 6.0 + math.sqrt(3.0)
    made = filled(contour)
    assert made.pockets == (Pocket(3.0, pytest.approx(edge), 1.0),)
    last = made.contour[-1]
    assert near(last.start, (edge, 1.0)) and last.end == rise.end and last.centre == rise.centre


@pytest.mark.parametrize(
    ("frame", "place", "mirrors"),
    [
        (Frame("Z", 1, 1), (3.0, 7.0), False),
        (Frame("Z", -1, 1), (-3.0, 7.0), True),
        (Frame("Z", 1, -1), (3.0, -7.0), True),
        (Frame("Z", -1, -1), (-3.0, -7.0), False),
        (Frame("X", 1, 1), (7.0, 3.0), True),
        (Frame("X", -1, 1), (-7.0, 3.0), False),
        (Frame("X", 1, -1), (7.0, -3.0), False),
        (Frame("X", -1, -1), (-7.0, -3.0), True),
    ],
)
def test_the_axes_of_passes(frame: Frame, place: tuple[float, float], mirrors: bool) -> None:
    assert frame.inside(3.0, 7.0) == place
    assert frame.outside(Point(*place)) == (3.0, 7.0)
    assert frame.mirrors is mirrors
