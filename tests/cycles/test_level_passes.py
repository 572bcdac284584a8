"""Passes at levels, move by move: worked out by hand from the contour, the depth and the retract."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.roughing import Pass, Roughing, roughing_passes

Place = tuple[float, float]


def line(*places: Place) -> tuple[Segment, ...]:
    return tuple(Segment(Point(*a), Point(*b)) for a, b in pairwise(places))


def shown(passes: list[Pass]) -> list[tuple[str, str]]:
    """The title of each pass, and its moves: ``>`` a rapid, ``-`` a cut, t and h."""
    assert [one.number for one in passes] == list(range(1, len(passes) + 1))
    return [
        (one.title, " ".join(f"{'-' if m.cuts else '>'}{m.end.t:.4g},{m.end.h:.4g}" for m in one.moves))
        for one in passes
    ]


# Two steps, from 2 mm before them; 0.1 and 0.2 mm stay.
STEPS = Roughing(Point(-2.0, 7.0), line((0, 0), (10, 0), (10, 4), (15, 4)), 2.0, 0.5, 0.1, 0.2)
FIRST = ("level 2 mm below the start", ">-2.1,7 >-2.1,5 -14.9,5 >14.4,5.5 >-2.1,5.5")
SECOND = ("level 4 mm below the start", ">-2.1,3 -9.9,3 >9.4,3.5 >-2.1,3.5")
THIRD = ("level 6 mm below the start", ">-2.1,1 -9.9,1 >9.4,1.5 >-2.1,1.5")
ALONG = ">-2.1,7 >-2.1,0.2 --0.1,0.2 -9.9,0.2 -9.9,4.2 -14.9,4.2"


def test_levels_and_the_pass_along_the_contour() -> None:
    last = ("along the contour", f"{ALONG} >14.9,7 >-2,7")
    assert shown(roughing_passes(STEPS)) == [FIRST, SECOND, THIRD, last]


def test_the_tool_may_be_fed_from_level_to_level() -> None:
    fed = [
        ("level 2 mm below the start", ">-2.1,7 --2.1,5 -14.9,5 >14.4,5.5 >-2.1,5.5"),
        ("level 4 mm below the start", "--2.1,3 -9.9,3 >9.4,3.5 >-2.1,3.5"),
        ("level 6 mm below the start", "--2.1,1 -9.9,1 >9.4,1.5 >-2.1,1.5"),
        ("along the contour", f"{ALONG.replace('>-2.1,0.2', '--2.1,0.2')} >14.9,7 >-2,7"),
    ]
    assert shown(roughing_passes(STEPS._replace(feeds_in=True))) == fed


def test_a_control_that_leaves_the_tool_over_the_end_of_the_contour() -> None:
    stays = STEPS._replace(stays_at_h_mm=6.5)
    assert shown(roughing_passes(stays))[3] == ("along the contour", f"{ALONG} -14.9,6.5")
    lower = STEPS._replace(stays_at_h_mm=3.0)
    assert shown(roughing_passes(lower))[3] == ("along the contour", ALONG)


@pytest.mark.parametrize(
    ("first", "along"),
    [
        ((0.3, 0.4), ">-2.4,7 >-2.4,0.6 --0.4,0.6 -9.6,0.6 -9.6,4.6 -14.6,4.6"),
        ((0.3, 0.0), ">-2.4,7 >-2.4,0.2 --0.4,0.2 -9.6,0.2 -9.6,4.2 -14.6,4.2"),
        ((0.0, 0.4), ">-2.1,7 >-2.1,0.6 --0.1,0.6 -9.9,0.6 -9.9,4.6 -14.9,4.6"),
    ],
)
def test_a_pass_of_its_own_leaves_what_the_last_one_takes(first: Place, along: str) -> None:
    for finishes in (True, False):
        cycle = STEPS._replace(t_first_mm=first[0], h_first_mm=first[1], finishes=finishes)
        assert cycle.ends_along_contour
        begin = -2.1 - first[0]
        passes = shown(roughing_passes(cycle))
        assert passes[0][1].startswith(f">{begin:.4g},7 >{begin:.4g},5 -{14.9 - first[0]:.4g},5 ")
        assert passes[3] == ("along the contour", along)
        over = f">{14.9 - first[0]:.4g},7 >{begin:.4g},7 >{begin:.4g},0.2"
        assert passes[4] == ("along the contour", f"{over} {ALONG[ALONG.index('--0.1') :]} >14.9,7 >-2,7")


def test_without_a_pass_along_the_contour_the_last_level_is_its_floor() -> None:
    cycle = STEPS._replace(finishes=False)
    assert not cycle.ends_along_contour
    last = ("level 6.8 mm below the start", ">-2.1,0.2 -9.9,0.2 >9.4,0.7 >-2.1,0.7 >-2.1,7 >-2,7")
    assert shown(roughing_passes(cycle)) == [FIRST, SECOND, THIRD, last]


@pytest.mark.parametrize(
    ("depth", "levels"), [(6.8, 0), (6.8 - 2e-6, 1), (6.8 + 2e-6, 0), (3.4, 1), (3.3, 2)]
)
def test_a_level_on_the_floor_is_left_to_the_pass_along_the_contour(depth: float, levels: int) -> None:
    passes = roughing_passes(STEPS._replace(depth_mm=depth))
    assert [one.title == "along the contour" for one in passes] == [False] * levels + [True]
    without = roughing_passes(STEPS._replace(depth_mm=depth, finishes=False))
    assert len(without) == levels + 1


# Two pockets: the second one is deeper, and its first wall a slope.
POCKETS = Roughing(
    Point(-1.0, 6.0),
    line((0, 3), (4, 3), (4, 1), (8, 1), (10, 3), (11, 3), (12, 0.5), (14, 6)),
    1.0,
    0.25,
)
DOWN = [
    # Slopes: t 12 + 2 (h - 0.5) / 5.5 behind, and 11 + (3 - h) / 2.5 before.
    ("level 1 mm below the start", ">-1,5 -13.64,5 >13.39,5.25 >-1,5.25"),
    ("level 2 mm below the start", ">-1,4 -13.27,4 >13.02,4.25 >-1,4.25"),
    ("level 3 mm below the start", ">-1,3 -12.91,3 >12.66,3.25 >-1,3.25"),
]
IN = [
    ("level 4 mm below the start", ">4,3.25 -4,2 -9,2 >8.75,2.25 >4,2.25"),
    ("level 4 mm below the start", ">4,6 >11.4,6 >11.4,3.25 -11.4,2 -12.55,2 >12.3,2.25 >11.4,2.25"),
    ("level 5 mm below the start", ">11.8,2.25 -11.8,1 -12.18,1 >11.93,1.25 >11.8,1.25"),
]
SHAPE = "-0,3 -4,3 -4,1 -8,1 -10,3 -11,3 -12,0.5 -14,6 >-1,6"
END = [("along the contour", f">11.8,6 >-1,6 >-1,3 {SHAPE}")]


def test_pockets_are_cleared_one_after_the_other() -> None:
    assert shown(roughing_passes(POCKETS)) == DOWN + IN + END


def test_pockets_alone() -> None:
    """From over all stock down to a retract over the rim."""
    first = ("level 4 mm below the start", ">4,6 >4,3.25 -4,2 -9,2 >8.75,2.25 >4,2.25")
    assert shown(roughing_passes(POCKETS._replace(only_pockets=True))) == [first, *IN[1:], *END]


def test_what_is_narrow_is_left_to_the_pass_along_the_contour() -> None:
    """The level in the second pocket is 0.382 mm long, the one over it 1.145 mm."""
    for narrow_mm, left_out in ((0.38, 0), (0.383, 1), (1.14, 1), (1.15, 2)):
        titles = [title for title, _ in shown(roughing_passes(POCKETS._replace(narrow_mm=narrow_mm)))]
        wanted = [title for title, _ in DOWN + IN[: 3 - left_out] + END]
        assert titles == wanted


def test_a_pass_as_short_as_narrow_is_not_made() -> None:
    slot = Roughing(Point(0.0, 4.0), line((0, 4), (2, 4), (2, 1), (2.5, 1), (2.5, 4), (5, 4)), 2.0, 0.25)
    assert slot.narrow_mm == 1e-6
    assert [title for title, _ in shown(roughing_passes(slot))] == [FIRST[0], "along the contour"]
    assert len(roughing_passes(slot._replace(narrow_mm=0.5))) == 1
    assert len(roughing_passes(slot._replace(narrow_mm=0.499))) == 2


# From below up a wall, and behind it a pocket.
HILL = Roughing(Point(-1.0, 6.0), line((0, 0), (3, 0), (3, 3), (5, 3), (5, 1), (8, 1), (8, 5)), 2.0, 0.5)


def test_a_level_before_a_hill_and_in_the_pocket_behind_it() -> None:
    assert shown(roughing_passes(HILL)) == [
        ("level 2 mm below the start", ">-1,4 -8,4 >7.5,4.5 >-1,4.5"),
        ("level 4 mm below the start", ">-1,2 -3,2 >2.5,2.5 >-1,2.5"),
        ("level 4 mm below the start", ">-1,6 >5,6 >5,4.5 -5,2 -8,2 >7.5,2.5 >5,2.5"),
        ("along the contour", ">5,6 >-1,6 >-1,0 -0,0 -3,0 -3,3 -5,3 -5,1 -8,1 -8,5 >8,6 >-1,6"),
    ]
    pocket = shown(roughing_passes(HILL._replace(only_pockets=True)))
    assert pocket[0] == ("level 4 mm below the start", ">5,6 >5,3.5 -5,2 -8,2 >7.5,2.5 >5,2.5")
    assert len(pocket) == 2


def test_a_pocket_whose_rim_is_above_the_start() -> None:
    """The first level is a depth below the start all the same."""
    cycle = Roughing(Point(-1.0, 2.0), line((0, 3), (2, 0.5), (4, 0.5), (4, 4)), 1.0, 0.25, only_pockets=True)
    # At 1 mm the slope is at 2 (3 - 1) / 2.5.
    assert shown(roughing_passes(cycle))[0] == (
        "level 1 mm below the start",
        ">1.6,2 -1.6,1 -4,1 >3.75,1.25 >1.6,1.25",
    )


def test_where_no_level_lies_above_the_contour_there_may_be_no_pass_at_all() -> None:
    cycle = Roughing(Point(-1.0, 2.0), line((0, 2), (5, 2), (5, 4)), 1.0, 0.5, finishes=False)
    assert roughing_passes(cycle) == ()
    assert len(roughing_passes(cycle._replace(finishes=True))) == 1


def test_a_pass_shorter_than_the_retract_goes_back_no_farther_than_it_came() -> None:
    short = POCKETS._replace(retract_mm=0.5)
    assert shown(roughing_passes(short))[5][1] == ">11.8,2.5 -11.8,1 -12.18,1 >11.8,1.5"


def test_a_contour_that_begins_with_a_pocket_has_its_passes_behind_its_first_wall() -> None:
    cycle = Roughing(Point(-1.0, 6.0), line((0, 5), (2, 2), (6, 2), (6, 5.5)), 1.5, 0.25)
    assert shown(roughing_passes(cycle))[:2] == [
        # Down the slope from 5 to 2 at 2 mm: 0.333 mm along to 4.5, 1.333 to 3.
        ("level 1.5 mm below the start", ">0.3333,6 -0.3333,4.5 -6,4.5 >5.75,4.75 >0.3333,4.75"),
        ("level 3 mm below the start", ">1.333,4.75 -1.333,3 -6,3 >5.75,3.25 >1.333,3.25"),
    ]


def test_a_level_along_a_wall_that_ends_on_it() -> None:
    """A level at the very height of a step goes over the step as well."""
    cycle = Roughing(Point(-1.0, 6.0), line((0, 0), (5, 0), (5, 4), (9, 4), (9, 6)), 2.0, 0.5)
    assert shown(roughing_passes(cycle)) == [
        ("level 2 mm below the start", ">-1,4 -9,4 >8.5,4.5 >-1,4.5"),
        ("level 4 mm below the start", ">-1,2 -5,2 >4.5,2.5 >-1,2.5"),
        ("along the contour", ">-1,6 >-1,0 -0,0 -5,0 -5,4 -9,4 -9,6 >-1,6"),
    ]


def test_a_contour_right_at_the_start_is_followed_without_a_way_to_it() -> None:
    cycle = Roughing(Point(0.0, 3.0), line((0, 0), (5, 0), (5, 3)), 2.0, 0.5)
    assert shown(roughing_passes(cycle)) == [
        ("level 2 mm below the start", ">0,1 -5,1 >4.5,1.5 >0,1.5"),
        ("along the contour", ">0,3 >0,0 -5,0 -5,3 >0,3"),
    ]


def test_an_arc_ends_its_levels_and_is_followed_as_an_arc() -> None:
    """A fillet of radius 3 about (4, 3): at h 1 it is sqrt(5) behind its centre."""
    arc = Segment(Point(4.0, 0.0), Point(7.0, 3.0), Point(4.0, 3.0), 1)
    cycle = Roughing(Point(-1.0, 3.0), (*line((0, 0), (4, 0)), arc), 1.0, 0.5)
    passes = roughing_passes(cycle)
    assert [one.moves[1].end.t for one in passes[:2]] == pytest.approx(
        [4.0 + math.sqrt(8.0), 4.0 + math.sqrt(5.0)]
    )
    (followed,) = [move for move in passes[-1].moves if move.centre is not None]
    assert (followed.end, followed.centre, followed.turn) == (arc.end, arc.centre, 1)
