"""Passes of a pattern move by move, and when a way crosses a shape by more than rounding."""

from __future__ import annotations

import math
from contextlib import nullcontext
from itertools import pairwise

import numpy as np
import pytest

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.pattern import Pattern, _crosses, _way_back, offsets_of, pattern_passes
from chipbreak.cycles.roughing import Motion
from chipbreak.text.diagnostics import RefusalError


def test_offsets_go_down_in_even_steps() -> None:
    allowance, first = Point(0.1, 0.2), Point(3.0, -6.0)
    assert offsets_of(1, first, allowance) == (allowance,)
    assert offsets_of(2, first, allowance) == (Point(3.1, -5.8), allowance)
    assert offsets_of(4, first, allowance) == tuple(
        pytest.approx(place) for place in (Point(3.1, -5.8), Point(2.1, -3.8), Point(1.1, -1.8), allowance)
    )


START = Point(2.0, 10.0)
FIRST = Point(1.0, 4.0)
ROUND = Segment(Point(-5.0, 4.0), Point(-7.0, 6.0), Point(-7.0, 4.0), 1)
SHAPE = (Segment(FIRST, ROUND.start), ROUND, Segment(ROUND.end, Point(-7.0, 9.0)))


def cut(t: float, h: float) -> Motion:
    return Motion(True, Point(t, h))


def rapid(t: float, h: float) -> Motion:
    return Motion(False, Point(t, h))


@pytest.mark.parametrize("feeds_in", [False, True])
def test_each_pass_begins_at_the_moved_start_and_goes_back_away_from_the_part_first(feeds_in: bool) -> None:
    passes = pattern_passes(Pattern(START, FIRST, SHAPE, (Point(1.0, 2.0), Point(0.0, 0.5)), feeds_in))
    assert [(one.number, one.title) for one in passes] == [
        (1, "2 and 1 mm off the contour"),
        (2, "0.5 and 0 mm off the contour"),
    ]
    assert passes[0].moves == (
        rapid(3.0, 12.0),
        Motion(feeds_in, Point(2.0, 6.0)),
        cut(-4.0, 6.0),
        Motion(True, Point(-6.0, 8.0), Point(-6.0, 6.0), 1),
        cut(-6.0, 11.0),
        # To the start of the next pass, which is lower: along it first, for it stands farther out.
        rapid(2.0, 11.0),
        rapid(2.0, 10.5),
    )
    assert passes[1].moves == (
        Motion(feeds_in, Point(1.0, 4.5)),
        cut(-5.0, 4.5),
        Motion(True, Point(-7.0, 6.5), Point(-7.0, 4.5), 1),
        cut(-7.0, 9.5),
        rapid(-7.0, 10.0),
        rapid(2.0, 10.0),
    )


def test_a_pass_that_begins_where_the_tool_stands_makes_no_move_there() -> None:
    shape = (Segment(START, Point(-5.0, 10.0)), Segment(Point(-5.0, 10.0), Point(-5.0, 12.0)))
    (only,) = pattern_passes(Pattern(START, START, shape, (Point(0.0, 0.0),), False))
    assert only.moves[:2] == (cut(-5.0, 10.0), cut(-5.0, 12.0))


@pytest.mark.parametrize(
    ("start", "first", "is_refused"),
    [
        (Point(2.0, 10.0), Point(1.0, 4.0), False),
        (Point(-9.0, 10.0), Point(1.0, 4.0), True),  # over the wall
        (Point(2.0, 5.0), Point(1.0, 4.0), True),  # the way back begins at h 9
    ],
)
def test_a_rapid_across_the_contour_is_refused(start: Point, first: Point, is_refused: bool) -> None:
    wall = (Segment(first, Point(-5.0, 4.0)), Segment(Point(-5.0, 4.0), Point(-7.0, 9.0)))
    shape = (*wall, Segment(Point(-7.0, 9.0), Point(-8.0, 2.0))) if start.h == 5.0 else wall
    with pytest.raises(RefusalError) if is_refused else nullcontext() as caught:
        pattern_passes(Pattern(start, first, shape, (Point(0.0, 0.0),), False))
    if is_refused:
        said = caught.value
        assert (said.code, said.message) == ("CYC006", "a rapid of this cycle would cross its contour")
        assert said.help == "start the cycle outside the stock, before the contour"


@pytest.mark.parametrize(("beyond_mm", "crosses"), [(0.5e-6, False), (-0.5e-6, False), (3e-6, True)])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, 4.0])
@pytest.mark.parametrize("is_line", [False, True])
@pytest.mark.parametrize("at_end", [False, True])
def test_what_rounding_takes_across_is_no_crossing(
    beyond_mm: float, crosses: bool, angle: float, is_line: bool, at_end: bool
) -> None:
    """A way that ends beyond a line, and a line that ends beyond a way, both of any length."""
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    through = np.array([[0.0, 40.0], [0.0, -beyond_mm]]) @ turn + (3.0, 8.0)
    through = through[::-1] if at_end else through
    across = np.array([[-0.25, 0.0], [7.0, 0.0]]) @ turn + (3.0, 8.0)
    one, other = (across, through) if is_line else (through, across)
    assert _crosses(one[0], one[1], other) is crosses
    assert _crosses(one[1], one[0], other[::-1]) is crosses


def test_a_line_of_several_pieces_is_crossed_in_one_of_them() -> None:
    line = np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (9.0, 3.0)])
    for begin, end, crosses in (
        ((1.0, 1.0), (2.0, -1.0), True),
        ((3.0, 1.0), (5.0, 1.0), True),
        ((6.0, 4.0), (6.0, 2.0), True),
        ((1.0, 1.0), (3.0, 4.0), False),
        ((10.0, 1.0), (10.0, 9.0), False),
        ((-1.0, -2.0), (12.0, -2.0), False),
        ((4.0, 0.0), (4.0, 3.0), False),
    ):
        assert _crosses(np.array(begin), np.array(end), line) is crosses


def test_a_rapid_across_the_first_line_of_a_contour_is_refused() -> None:
    """The end lies behind it, and the start is lower, so the way back begins along t."""
    places = [Point(1.0, 4.0), Point(1.0, 12.0), Point(6.0, 12.0), Point(6.0, 11.0)]
    shape = tuple(Segment(a, b) for a, b in pairwise(places))
    with pytest.raises(RefusalError, match="would cross"):
        pattern_passes(Pattern(Point(-3.0, 10.0), places[0], shape, (Point(0.0, 0.0),), False))


def test_away_from_the_part_is_towards_the_axis_in_a_bore() -> None:
    """Start and end are both nearer to the axis than the contour; the start more than the end."""
    shape = (Segment(Point(1.0, 4.0), Point(-5.0, 4.0)), Segment(Point(-5.0, 4.0), Point(-5.0, 2.0)))
    (only,) = pattern_passes(Pattern(Point(2.0, 1.0), Point(1.0, 4.0), shape, (Point(0.0, 0.0),), False))
    assert only.moves[-2:] == (rapid(-5.0, 1.0), rapid(2.0, 1.0))


def test_a_rapid_is_held_against_every_place_of_an_arc() -> None:
    """A way below the top of a hill of radius 5, and one above it."""
    hill = (Segment(Point(5.0, 0.0), Point(-5.0, 0.0), Point(0.0, 0.0), 1),)
    for height, is_refused in ((4.99, True), (5.01, False)):
        pattern = Pattern(Point(6.0, height), Point(5.0, 0.0), hill, (Point(0.0, 0.0),), False)
        with pytest.raises(RefusalError) if is_refused else nullcontext():
            pattern_passes(pattern)


@pytest.mark.parametrize(
    ("end", "to", "outwards", "way"),
    [
        ((-7.0, 9.0), (2.0, 10.0), 6.0, [(-7.0, 10.0), (2.0, 10.0)]),
        ((-7.0, 12.0), (2.0, 10.0), 6.0, [(2.0, 12.0), (2.0, 10.0)]),
        ((-7.0, -9.0), (2.0, -10.0), -6.0, [(-7.0, -10.0), (2.0, -10.0)]),
        ((-7.0, 10.0), (2.0, 10.0), 6.0, [(2.0, 10.0)]),
        ((2.0, 9.0), (2.0, 10.0), 6.0, [(2.0, 10.0)]),
        ((2.0, 10.0), (2.0, 10.0), 6.0, []),
        ((-7.0, 9.5), (2.0, 10.0), 0.5, [(-7.0, 10.0), (2.0, 10.0)]),
        ((2.0, 10.0000005), (2.0000005, 10.0), 6.0, []),
        ((2.0, 10.000002), (2.0, 10.0), 6.0, [(2.0, 10.0)]),
    ],
)
def test_the_way_back(
    end: tuple[float, float], to: tuple[float, float], outwards: float, way: list[tuple[float, float]]
) -> None:
    assert _way_back(Point(*end), Point(*to), outwards) == way
