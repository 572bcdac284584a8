"""Shapes at a distance against closed forms, each also turned and moved, so that no axis is a special one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import nullcontext
from itertools import pairwise

import pytest

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.offset import (
    _circles_meet,
    _is_on,
    _line_meets_circle,
    at_distance,
    check_distance,
    heading,
    pieces_at_distance,
    round_corner,
    sharp_corner,
)
from chipbreak.text.diagnostics import RefusalError

Place = tuple[float, float]
TOO_FAR = "something in the contour is smaller than the distance at which the cycle leaves it"
ROOT = math.sqrt(0.5)
TURNED = [(0.0, (0.0, 0.0)), (0.7, (3.0, -2.0)), (math.pi / 2.0, (-5.0, 11.0)), (3.9, (40.0, 7.0))]


def line(*places: Place) -> list[Segment]:
    return [Segment(Point(*a), Point(*b)) for a, b in pairwise(places)]


def arc(start: Place, end: Place, centre: Place, turn: int) -> Segment:
    return Segment(Point(*start), Point(*end), Point(*centre), turn)


def turned(shape: Sequence[Segment], angle: float, shift: Place, times: float = 1.0) -> list[Segment]:
    """The same shape elsewhere, and of another size."""

    def there(place: Point) -> Point:
        t_mm, h_mm = times * place.t, times * place.h
        t = t_mm * math.cos(angle) - h_mm * math.sin(angle)
        return Point(t + shift[0], t_mm * math.sin(angle) + h_mm * math.cos(angle) + shift[1])

    return [
        Segment(there(one.start), there(one.end), one.centre and there(one.centre), one.turn) for one in shape
    ]


def same(found: Sequence[Segment], wanted: Sequence[Segment]) -> None:
    assert len(found) == len(wanted), found
    for one, other in zip(found, wanted, strict=True):
        assert one.start == pytest.approx(other.start, abs=1e-9)
        assert one.end == pytest.approx(other.end, abs=1e-9)
        assert (one.centre is None) == (other.centre is None)
        assert one.centre == (None if other.centre is None else pytest.approx(other.centre, abs=1e-9))
        assert one.turn == other.turn


# The contour and what lies 1 mm on its left.
SHAPES = {
    "inner corner": (line((0, 0), (10, 0), (10, 5)), line((0, 1), (9, 1), (9, 5))),
    "outer corner": (
        line((0, 5), (10, 5), (10, 0)),
        [*line((0, 6), (10, 6)), arc((10, 6), (11, 5), (10, 5), -1), *line((11, 5), (11, 0))],
    ),
    "straight on": (line((0, 0), (4, 0), (10, 0)), line((0, 1), (4, 1), (10, 1))),
    "fillet": (
        [*line((0, 0), (4, 0)), arc((4, 0), (7, 3), (4, 3), 1), *line((7, 3), (7, 9))],
        [*line((0, 1), (4, 1)), arc((4, 1), (6, 3), (4, 3), 1), *line((6, 3), (6, 9))],
    ),
    "round corner": (
        [*line((0, 3), (4, 3)), arc((4, 3), (7, 0), (4, 0), -1), *line((7, 0), (7, -4))],
        [*line((0, 4), (4, 4)), arc((4, 4), (8, 0), (4, 0), -1), *line((8, 0), (8, -4))],
    ),
    # A wall met by an arc about (4, 0) of radius 3 at its top, left at 45 degrees.
    "arc into a wall": (
        [arc((1, 0), (4, 3), (4, 0), -1), *line((4, 3), (4, 9))],
        [arc((0, 0), (3, math.sqrt(15.0)), (4, 0), -1), *line((3, math.sqrt(15.0)), (3, 9))],
    ),
    "wall into an arc": (
        [*line((0, -9), (0, 0)), arc((0, 0), (-3, 3), (-3, 0), 1)],
        [*line((-1, -9), (-1, 0)), arc((-1, 0), (-3, 2), (-3, 0), 1)],
    ),
    # Two hills of radius 5 that meet in a valley: at 6 they meet straight above it.
    "arc into an arc": (
        [arc((-5, 0), (4, 3), (0, 0), -1), arc((4, 3), (13, 0), (8, 0), -1)],
        [arc((-6, 0), (4, math.sqrt(20.0)), (0, 0), -1), arc((4, math.sqrt(20.0)), (14, 0), (8, 0), -1)],
    ),
    "line into an arc": (
        [*line((-9, 3), (4, 3)), arc((4, 3), (13, 0), (8, 0), -1)],
        [*line((-9, 4), (8 - math.sqrt(20.0), 4)), arc((8 - math.sqrt(20.0), 4), (14, 0), (8, 0), -1)],
    ),
    "outer corner, then inner": (
        line((0, 5), (10, 5), (10, 0), (20, 0)),
        [
            *line((0, 6), (10, 6)),
            arc((10, 6), (11, 5), (10, 5), -1),
            *line((11, 5), (11, 1), (20, 1)),
        ],
    ),
    # What a corner leaves nothing of.
    "a step of just the distance": (
        line((0, 0), (10, 0), (10, 1), (20, 1)),
        [*line((0, 1), (9, 1)), arc((9, 1), (10, 2), (10, 1), -1), *line((10, 2), (20, 2))],
    ),
    "a slope out of just the distance": (
        line((0, 0), (10, 0), (10, 1), (13, 5)),
        [
            *line((0, 1), (9, 1)),
            arc((9, 1), (9.2, 1.6), (10, 1), -1),
            *line((9.2, 1.6), (12.2, 5.6)),
        ],
    ),
    "a groove of just the distance": (
        line((0, 5), (0, 0), (2, 0), (2, 5)),
        line((1, 5), (1, 1), (1, 5)),
    ),
    "two outer corners": (
        line((0, 5), (10, 5), (10, 0), (0, 0)),
        [
            *line((0, 6), (10, 6)),
            arc((10, 6), (11, 5), (10, 5), -1),
            *line((11, 5), (11, 0)),
            arc((11, 0), (10, -1), (10, 0), -1),
            *line((10, -1), (0, -1)),
        ],
    ),
    "there and back": (
        line((0, 0), (5, 0), (2, 0)),
        [*line((0, 1), (5, 1)), arc((5, 1), (5, -1), (5, 0), -1), *line((5, -1), (2, -1))],
    ),
}


@pytest.mark.parametrize(("angle", "shift"), TURNED)
@pytest.mark.parametrize("name", SHAPES)
def test_a_shape_at_a_distance(name: str, angle: float, shift: Place) -> None:
    for times in (1.0, 0.4):
        contour, wanted = (turned(one, angle, shift, times) for one in SHAPES[name])
        made = pieces_at_distance(contour, times, round_corner)
        assert len(made) == len(contour)
        same([one for pieces in made for one in pieces], wanted)
        if name != "there and back":
            same(at_distance(contour, times), wanted)


def test_ends_that_differ_by_rounding_are_joined() -> None:
    """An arc whose end has the digits of a program, and a line that goes on from it straight."""
    end = (7, 3.00005)
    made = pieces_at_distance([arc((4, 0), end, (4, 3), 1), *line(end, (7, 9))], 1.0, round_corner)
    assert made[0][0].end == made[1][0].start
    back = pieces_at_distance([*line((7, 9), end), arc(end, (4, 0), (4, 3), -1)], 1.0, round_corner)
    assert back[1][0].start != back[0][0].end and back[1][0].start == pytest.approx(back[0][0].end, abs=1e-4)


def test_no_distance_leaves_the_shape() -> None:
    contour = SHAPES["outer corner"][0]
    assert at_distance(contour, 0.0) == tuple(contour)
    assert at_distance(contour, 1e-7) == tuple(contour)
    assert at_distance(contour, 2e-7) != tuple(contour)


@pytest.mark.parametrize(("angle", "shift"), TURNED)
def test_a_sharp_corner_behind_a_step_of_just_the_distance(angle: float, shift: Place) -> None:
    """Nothing is left of the wall but the way out to where the corner ends."""
    step = turned(line((0, 0), (10, 0), (10, 1), (20, 1)), angle, shift)
    made = pieces_at_distance(step, 1.0, sharp_corner)
    wanted = [line((0, 1), (9, 1)), line((9, 1), (9, 2)), line((9, 2), (20, 2))]
    for found, pieces in zip(made, wanted, strict=True):
        same(found, turned(pieces, angle, shift))


def corner_of(turn_deg: float) -> list[Segment]:
    """Along t, then off to the right by an angle."""
    angle = math.radians(turn_deg)
    return line((-9, 0), (0, 0), (9 * math.cos(angle), -9 * math.sin(angle)))


@pytest.mark.parametrize(("angle", "shift"), TURNED)
@pytest.mark.parametrize("turn_deg", [10.0, 45.0, 89.0, 90.0])
def test_a_sharp_corner_goes_straight_on_until_both_meet(turn_deg: float, angle: float, shift: Place) -> None:
    """R tan(half the angle) beyond the corner."""
    on = 0.8 * math.tan(math.radians(turn_deg) / 2.0)
    turn = math.radians(turn_deg)
    end = (9 * math.cos(turn) + 0.8 * math.sin(turn), -9 * math.sin(turn) + 0.8 * math.cos(turn))
    made = pieces_at_distance(turned(corner_of(turn_deg), angle, shift), 0.8, sharp_corner)
    assert [len(pieces) for pieces in made] == [1, 1]
    same([one for pieces in made for one in pieces], turned(line((-9, 0.8), (on, 0.8), end), angle, shift))


@pytest.mark.parametrize(("angle", "shift"), TURNED)
@pytest.mark.parametrize("turn_deg", [91.0, 120.0, 170.0])
def test_beyond_a_right_angle_a_third_line_cuts_the_corner_short(
    turn_deg: float, angle: float, shift: Place
) -> None:
    """It begins and ends a radius beyond the corner."""
    turn = math.radians(turn_deg)
    out = (math.cos(turn), -math.sin(turn))
    side = (0.8 * math.sin(turn), 0.8 * math.cos(turn))
    end = (9 * out[0] + side[0], 9 * out[1] + side[1])
    ahead = (side[0] - 0.8 * out[0], side[1] - 0.8 * out[1])
    made = pieces_at_distance(turned(corner_of(turn_deg), angle, shift), 0.8, sharp_corner)
    assert [len(pieces) for pieces in made] == [1, 2]
    wanted = line((-9, 0.8), (0.8, 0.8), ahead, end)
    same([one for pieces in made for one in pieces], turned(wanted, angle, shift))


@pytest.mark.parametrize(("angle", "shift"), TURNED)
def test_a_sharp_corner_beside_arcs_keeps_them_whole(angle: float, shift: Place) -> None:
    """A quarter about (4, 0) that ends square to the wall behind it, and one that begins so."""
    hill = [arc((1, 0), (4, 3), (4, 0), -1), *line((4, 3), (4, -5))]
    wanted = [arc((0, 0), (4, 4), (4, 0), -1), *line((4, 4), (5, 4), (5, -5))]
    made = pieces_at_distance(turned(hill, angle, shift), 1.0, sharp_corner)
    same([one for pieces in made for one in pieces], turned(wanted, angle, shift))
    fall = [*line((-5, 3), (4, 3)), arc((4, 3), (7, 0), (7, 3), 1)]
    wanted = [*line((-5, 4), (5, 4), (5, 3)), arc((5, 3), (7, 1), (7, 3), 1)]
    made = pieces_at_distance(turned(fall, angle, shift), 1.0, sharp_corner)
    same([one for pieces in made for one in pieces], turned(wanted, angle, shift))


@pytest.mark.parametrize(
    "contour",
    [
        line((0, 0), (10, 0), (10, 0.5), (20, 0.5)),
        line((0, 0), (0.5, 0), (0.5, 6)),
        [*line((0, 0), (4, 0)), arc((4, 0), (4.9, 0.9), (4, 0.9), 1), *line((4.9, 0.9), (4.9, 9))],
        [*line((0, 0), (4, 0)), arc((4, 0), (5, 1), (4, 1), 1), *line((5, 1), (5, 9))],
        # A groove that is wider inside.
        line((0, 5), (4, 5), (2, 0), (9, 0), (5, 5), (12, 5)),
    ],
    ids=["step", "short floor", "fillet", "fillet of just the distance", "groove"],
)
def test_what_is_smaller_than_the_distance_is_refused(contour: list[Segment]) -> None:
    with pytest.raises(RefusalError) as caught:
        at_distance(contour, 1.0)
    if contour[-1].end != Point(12, 5):  # of the groove the lines meet, inside of the material
        with pytest.raises(RefusalError):
            pieces_at_distance(contour, 1.0, round_corner)
    assert (caught.value.code, caught.value.message) == ("CYC002", TOO_FAR)
    assert caught.value.help == "give a smaller D, or leave what is so small out"


@pytest.mark.parametrize(("off_mm", "is_refused"), [(0.9887, True), (0.9893, False)])
@pytest.mark.parametrize(("angle", "shift"), TURNED)
def test_how_near_is_too_near(off_mm: float, is_refused: bool, angle: float, shift: Place) -> None:
    """A hundredth of the distance and a micrometre are rounding."""
    contour = turned(line((0, 0), (10, 0)), angle, shift)
    made = turned(line((4, 9), (4, off_mm)), angle, shift)
    with pytest.raises(RefusalError) if is_refused else nullcontext():
        check_distance(contour, made, 1.0)
    half = turned(line((4, 9), (4, (off_mm + 0.001) / 2.0 - 0.001)), angle, shift)
    with pytest.raises(RefusalError) if is_refused else nullcontext():
        check_distance(contour, half, 0.5)
    check_distance([], made, 1.0)
    check_distance(contour, [], 1.0)


@pytest.mark.parametrize(
    ("degrees", "is_on"),
    [(100.0, True), (179.9, True), (180.1, True), (190.0, False), (80.0, False), (89.9, True)],
)
def test_a_place_is_on_an_arc_between_its_ends(degrees: float, is_on: bool) -> None:
    """Or as near to one as the digits are."""
    angle = math.radians(degrees)
    place = Point(4 + 0.03 * math.cos(angle), 0.03 * math.sin(angle))
    assert _is_on(arc((4, 0.03), (3.97, 0), (4, 0), 1), place) is is_on


@pytest.mark.parametrize(
    ("way_mm", "is_on"), [(-2e-4, False), (-9e-5, True), (3.0, True), (5.00009, True), (5.0002, False)]
)
def test_a_place_is_on_a_line_as_near_as_the_digits_are(way_mm: float, is_on: bool) -> None:
    assert _is_on(line((1, 2), (4, 6))[0], Point(1 + 0.6 * way_mm, 2 + 0.8 * way_mm)) is is_on


@pytest.mark.parametrize(("apart_mm", "is_met"), [(2.0, True), (2.00002, True), (2.00003, False)])
def test_a_line_that_touches_an_arc_meets_it(apart_mm: float, is_met: bool) -> None:
    """By 4e-5 mm2 of the square of half the chord, which is rounding: both meetings are the foot."""
    circle = arc((3, 4), (1, 2), (1, 4), 1)
    found = list(_line_meets_circle(line((-5, 4 + apart_mm), (9, 4 + apart_mm))[0], circle))
    assert found == ([pytest.approx((1.0, 4 + apart_mm))] * 2 if is_met else [])


@pytest.mark.parametrize(
    ("apart_mm", "is_met"), [(5.0, True), (5.00001, True), (5.0001, False), (0.5, False), (0.0, False)]
)
def test_circles_that_touch_meet(apart_mm: float, is_met: bool) -> None:
    one = arc((3, 4), (1, 2), (1, 4), 1)
    other = arc((4 + apart_mm, 4), (1 + apart_mm, 1), (1 + apart_mm, 4), 1)
    found = list(_circles_meet(one, other))
    assert found == ([pytest.approx((3.0, 4.0), abs=1e-4)] * 2 if is_met else [])


def test_circles_that_nearly_touch_meet_twice() -> None:
    """Radii 2 and 3, 4.9 apart: half the chord by Heron is 0.61 mm."""
    one = arc((3, 4), (1, 2), (1, 4), 1)
    other = arc((8.9, 4), (5.9, 1), (5.9, 4), 1)
    along = (4.9**2 + 4.0 - 9.0) / 9.8
    half = math.sqrt(4.0 - along**2)
    assert list(_circles_meet(one, other)) == [
        pytest.approx((1 + along, 4 - half)),
        pytest.approx((1 + along, 4 + half)),
    ]


def test_an_arc_is_a_wall_everywhere() -> None:
    wall = [arc((-5, 0), (5, 0), (0, 0), -1)]
    for degrees in range(5, 180, 10):
        angle = math.radians(degrees)
        place = (4.5 * math.cos(angle), 4.5 * math.sin(angle))
        with pytest.raises(RefusalError):
            check_distance(wall, line((0, 0), place), 1.0)
    check_distance(wall, line((0, 0), (3.9, 0)), 1.0)


@pytest.mark.parametrize(("at_end", "way"), [(False, (0.0, 1.0)), (True, (1.0, 0.0))])
def test_where_an_arc_heads(at_end: bool, way: Place) -> None:
    assert heading(arc((1, 0), (4, 3), (4, 0), -1), at_end=at_end) == pytest.approx(way)
    back = arc((4, 3), (1, 0), (4, 0), 1)
    assert heading(back, at_end=not at_end) == pytest.approx((-way[0], -way[1]))
    assert heading(line((1, 2), (4, 6))[0], at_end=at_end) == pytest.approx((0.6, 0.8))
