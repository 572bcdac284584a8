"""The self-check of roughing: each way of the tool against the stock, on both sides of every bound."""

from __future__ import annotations

import re
from contextlib import nullcontext
from itertools import pairwise

import numpy as np
import pytest

from chipbreak.cycles.contour import Point, Segment
from chipbreak.cycles.promise import _heights_at, _Left, _lowest_near
from chipbreak.cycles.roughing import Roughing, roughing_passes
from chipbreak.text.diagnostics import SelfCheckError

Place = tuple[float, float]
STEP = 0.001  # so 3 um are rounding


def line(*places: Place) -> tuple[Segment, ...]:
    return tuple(Segment(Point(*a), Point(*b)) for a, b in pairwise(places))


# A step 4 mm high at 10, from 2 mm before it; 7 mm of stock.
STEPS = Roughing(Point(-2.0, 7.0), line((0, 0), (10, 0), (10, 4), (15, 4)), 2.0, 0.5)


def left(cycle: Roughing = STEPS, *ways: tuple[Place, ...]) -> _Left:
    """The stock behind some cuts."""
    found = _Left(cycle, STEP)
    for way in ways:
        found.run(np.array(way), is_cut=True)
    return found


def said(message: str, is_wrong: bool) -> object:
    return pytest.raises(SelfCheckError, match=f"^{re.escape(message)}$") if is_wrong else nullcontext()


def test_the_grid_is_as_fine_as_the_digits_and_begins_at_the_departure() -> None:
    found = left(STEPS._replace(t_allowance_mm=0.5, h_allowance_mm=0.25))
    assert (found.t[0], found.t[-1], len(found.t)) == (-2.5, 14.5, 17001)
    assert found.tolerance_mm == pytest.approx(0.003)
    assert set(found.height) == {7.0}
    at = int(np.argmin(abs(found.t - 9.5)))
    assert (found.lowest[at], found.highest[at]) == (0.25, 4.25)
    assert (found.lowest[at - 1], found.highest[at - 1]) == (0.25, 0.25)
    assert (found.lowest[at + 1], found.highest[at + 1]) == (4.25, 4.25)
    assert (found.lowest[0], found.highest[-1]) == (0.25, 4.25)


def test_a_long_cycle_has_a_coarser_grid() -> None:
    long = STEPS._replace(contour=line((0, 0), (1000, 0), (1000, 4)))
    assert len(left(long).t) == 200_001


@pytest.mark.parametrize(
    ("level", "said_mm"), [(5.0, ""), (4.9975, ""), (4.9965, "2.003"), (4.0, "3.000"), (7.5, "")]
)
def test_how_much_a_cut_may_take(level: float, said_mm: str) -> None:
    with said(f"a pass takes {said_mm} mm, 2 are commanded", bool(said_mm)):
        left(STEPS, ((-2.0, level), (9.0, level)))


@pytest.mark.parametrize("way", [((9.0, 5.0), (-2.0, 5.0)), ((-2.0, 5.0), (9.0, 5.0))])
def test_a_cut_takes_what_stands_above_its_way(way: tuple[Place, ...]) -> None:
    found = left(STEPS, way)
    assert set(found.height[found.t < 8.999]) == {5.0}
    assert set(found.height[found.t > 9.001]) == {7.0}


def test_a_cut_up_a_slope() -> None:
    found = left(STEPS, ((0.0, 5.0), (4.0, 7.0)))
    inside = (found.t > 0.001) & (found.t < 3.999)
    assert found.height[inside] == pytest.approx(5.0 + found.t[inside] / 2.0)
    assert found.height[found.t < -0.001].min() == 7.0


@pytest.mark.parametrize(("level", "said_mm"), [(7.0, ""), (6.9975, ""), (6.9965, "0.003"), (5.5, "1.500")])
def test_a_rapid_takes_nothing(level: float, said_mm: str) -> None:
    found = left()
    with said(f"a rapid of an unrolled cycle goes through {said_mm} mm of stock", bool(said_mm)):
        found.run(np.array([(-2.0, level), (9.0, level)]), is_cut=False)
    assert set(found.height) == {7.0}


@pytest.mark.parametrize(("wide_mm", "is_wrong"), [(0.007, False), (0.012, True)])
def test_what_the_digits_blur_is_not_judged(wide_mm: float, is_wrong: bool) -> None:
    """A rapid through a ridge of a few steps; a pass that takes more than its depth of one."""
    low = ((-2.0, 5.0), (4.0, 5.0)), ((4.0 + wide_mm, 5.0), (15.0, 5.0))
    with said("a rapid of an unrolled cycle goes through 1.000 mm of stock", is_wrong):
        left(STEPS, *low).run(np.array([(-2.0, 6.0), (9.0, 6.0)]), is_cut=False)
    with said("a pass takes 3.500 mm, 2 are commanded", is_wrong):
        left(STEPS, *low).run(np.array([(-2.0, 3.5), (9.0, 3.5)]), is_cut=True)


@pytest.mark.parametrize(("back_mm", "is_wrong"), [(0.0025, False), (0.0035, True)])
def test_a_way_does_not_turn_back(back_mm: float, is_wrong: bool) -> None:
    way = [(0.0, 6.0), (4.0, 6.0), (4.0 - back_mm, 6.0), (9.0, 6.0)]
    with said("a move of an unrolled cycle turns back along its passes", is_wrong):
        left(STEPS, tuple(way))
    with said("a move of an unrolled cycle turns back along its passes", is_wrong):
        left(STEPS, tuple(reversed(way)))


@pytest.mark.parametrize(
    ("at", "to", "is_wrong"),
    [
        (2.0, 6.5, True),
        (2.0, 6.9965, True),
        (2.0, 6.9975, False),
        (-2.0, 1.0, False),  # in front of the stock
        (4.0, 5.5, False),  # beside the wall of the last pass
        (4.0, 4.5, True),
        (14.9, 5.5, True),
        (3.0, 5.0, False),
        (3.0, 4.9, True),
    ],
)
def test_a_rapid_straight_down_has_free_room_beside_it(at: float, to: float, is_wrong: bool) -> None:
    found = left(STEPS, ((2.5, 5.0), (4.0, 5.0)))
    with said("a rapid of an unrolled cycle goes down into stock", is_wrong):
        found.run(np.array([(at, 9.0), (at, to)]), is_cut=False)
    found.run(np.array([(at, to), (at, 9.0)]), is_cut=False)
    found.run(np.array([(at, 9.0), (at, to)]), is_cut=True)


def whole(cycle: Roughing) -> _Left:
    """The stock behind all passes of a cycle; arcs it has none."""
    found = _Left(cycle, STEP)
    at = cycle.start
    for move in (move for one in roughing_passes(cycle) for move in one.moves):
        found.run(np.array([at, move.end]), is_cut=move.cuts)
        at = move.end
    return found


TOO_MUCH = "an unrolled cycle leaves {} mm too much, {} mm too little over its contour"


@pytest.mark.parametrize(
    ("off_mm", "wrong"),
    [(0.0, ""), (0.0025, ""), (0.0036, ("0.004", "0.000")), (-0.0025, ""), (-0.0036, ("0.000", "0.004"))],
)
def test_what_is_left_is_the_contour(off_mm: float, wrong: tuple[str, str] | str) -> None:
    """Passes with another allowance towards the stock; behind the step it stands as it is."""
    found = whole(STEPS._replace(h_allowance_mm=0.2 + off_mm))
    found.cycle = STEPS._replace(h_allowance_mm=0.2)
    wanted = _Left(found.cycle, STEP)
    found.highest, found.lowest = wanted.highest, wanted.lowest
    with said(TOO_MUCH.format(*wrong or ("", "")), bool(wrong)):
        found.compare()


@pytest.mark.parametrize(("depth", "is_wrong"), [(2.0, False), (0.7, True)])
def test_without_a_pass_along_the_contour_steps_may_stay(depth: float, is_wrong: bool) -> None:
    """A slope of 4 mm in levels of 2 mm leaves steps of nearly that."""
    cycle = Roughing(Point(-2.0, 4.0), line((0, 0), (10, 0), (14, 4)), 2.0, 0.5, finishes=False)
    found = whole(cycle)
    found.cycle = cycle._replace(depth_mm=depth)
    with pytest.raises(SelfCheckError, match="mm too much") if is_wrong else nullcontext():
        found.compare()


def test_of_pockets_alone_the_rest_is_gone() -> None:
    contour = line((0, 3), (4, 3), (4, 1), (8, 1), (8, 3), (11, 3), (14, 6))
    cycle = Roughing(Point(-1.0, 6.0), contour, 1.0, 0.25, only_pockets=True)
    found = left(cycle)
    assert set(found.height[found.t < 10.9]) == {3.0}
    assert found.height[-1] == 6.0
    whole(cycle).compare()
    with pytest.raises(SelfCheckError, match=r"2.000 mm too much"):
        found.compare()


def test_stock_is_as_high_as_the_start_at_most() -> None:
    """A contour that ends above it leaves the stock there."""
    high = Roughing(Point(-2.0, 3.0), line((0, 0), (10, 0), (10, 6), (15, 6)), 1.0, 0.5)
    whole(high).compare()


@pytest.mark.parametrize(("first", "beside"), [((0.0, 0.0), 0), ((0.3, 0.2005), 501), ((0.0004, 0.0), 1)])
def test_how_far_beside_a_steep_line_counts(first: Place, beside: int) -> None:
    cycle = STEPS._replace(t_first_mm=first[0], h_first_mm=first[1])
    assert left(cycle).beside == beside


def test_the_last_pass_takes_what_stands_beside_a_wall_as_thick_as_it_is() -> None:
    """0.3 mm are left before the wall at 10; in height it is 4 mm, more than the depth."""
    cycle = STEPS._replace(t_first_mm=0.3, h_first_mm=0.0)
    levels = (((-2.3, 5.0), (15.0, 5.0)), ((-2.3, 3.0), (9.7, 3.0)), ((-2.3, 1.0), (9.7, 1.0)))
    found = left(cycle, *levels)
    found.run(np.array([(-2.3, 0.0), (10.0, 0.0)]), is_cut=True)
    thick = left(cycle._replace(t_first_mm=0.1), *levels)
    with pytest.raises(SelfCheckError, match=r"^a pass takes 5.000 mm, 2 are commanded$"):
        thick.run(np.array([(-2.1, 0.0), (10.0, 0.0)]), is_cut=True)


def test_heights_along_a_way() -> None:
    places = np.array([1.0, 2.0, 3.0])
    assert _heights_at(places, np.array([0.0, 4.0]), np.array([5.0, 9.0])).tolist() == [6.0, 7.0, 8.0]
    bent = _heights_at(places, np.array([0.0, 2.0, 4.0]), np.array([5.0, 9.0, 9.0]))
    assert bent.tolist() == [7.0, 9.0, 9.0]
    wall = _heights_at(np.array([2.0]), np.array([2.0, 2.0]), np.array([5.0, 9.0]))
    assert wall.tolist() in ([5.0], [9.0])


def test_the_lowest_of_neighbours() -> None:
    heights = np.array([5.0, 3.0, 4.0, 9.0, 8.0, 7.0])
    assert _lowest_near(heights, 1).tolist() == [3.0, 3.0, 4.0, 7.0]
    assert _lowest_near(heights, 2).tolist() == [3.0, 3.0]
    assert _lowest_near(heights[:5], 2).tolist() == [3.0]
    assert _lowest_near(heights[:4], 2).tolist() == []
    assert len(_lowest_near(np.zeros(10))) == 2
