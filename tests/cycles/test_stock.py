"""The stock in the way of passes, cut by cut, by its heights."""

from __future__ import annotations

import math
import re
from contextlib import nullcontext

import pytest

from chipbreak.cycles.contour import Point
from chipbreak.cycles.stock import Stock
from chipbreak.text.diagnostics import SelfCheckError


def stepped() -> Stock:
    """5 mm high from 1 to 4, 3 mm to 6, 7 mm to 11."""
    stock = Stock(1.0, 11.0, 7.0)
    stock.cut(1.0, 6.0, 5.0)
    stock.cut(4.0, 6.0, 3.0)
    return stock


def test_cuts_leave_steps() -> None:
    stock = stepped()
    assert (stock.breaks, stock.heights) == ([1.0, 4.0, 6.0, 11.0], [5.0, 3.0, 7.0])
    stock.cut(-3.0, 2.0, 6.0)  # above what stands there
    assert (stock.breaks, stock.heights) == ([1.0, 2.0, 4.0, 6.0, 11.0], [5.0, 5.0, 3.0, 7.0])
    stock.cut(9.0, 20.0, 1.0)
    assert (stock.breaks, stock.heights) == ([1.0, 2.0, 4.0, 6.0, 9.0, 11.0], [5.0, 5.0, 3.0, 7.0, 1.0])


@pytest.mark.parametrize(("near_mm", "count"), [(0.0, 3), (0.9e-6, 3), (-0.9e-6, 3), (2e-6, 4), (-2e-6, 4)])
def test_a_cut_that_ends_where_one_has_ended_makes_no_break_of_its_own(near_mm: float, count: int) -> None:
    stock = Stock(1.0, 11.0, 7.0)
    stock.cut(1.0, 4.0, 6.0)
    stock.cut(1.0, 4.0 + near_mm, 5.0)
    assert len(stock.breaks) == count
    assert stock.heights[0] == 5.0 and stock.heights[-1] == 7.0


@pytest.mark.parametrize(
    ("level_mm", "is_refused"), [(5.0, False), (4.9999995, False), (4.999, True), (6.0, False)]
)
def test_how_deep_a_pass_may_be(level_mm: float, is_refused: bool) -> None:
    stock = Stock(1.0, 11.0, 7.0)
    with pytest.raises(SelfCheckError) if is_refused else nullcontext() as caught:
        stock.cut(2.0, 4.0, level_mm, depth_mm=2.0)
    if is_refused:
        assert str(caught.value) == "a pass takes 2.0010 mm, 2 are allowed"
        with pytest.raises(SelfCheckError, match=r"^a pass takes 4.5000 mm, 0.75 are allowed$"):
            stock.cut(6.0, 7.0, 2.5, depth_mm=0.75)


@pytest.mark.parametrize(
    ("first_mm", "last_mm", "height_mm"),
    [
        (1.5, 3.0, 5.0),
        (3.0, 1.5, 5.0),
        (2.0, 4.0, 5.0),
        (2.0, 4.1, 5.0),
        (4.0, 6.0, 3.0),
        (4.1, 5.9, 3.0),
        (3.9, 4.1, 5.0),
        (5.0, 6.1, 7.0),
        (0.0, 20.0, 7.0),
        (-2.0, 1.0, -math.inf),
        (-2.0, 1.1, 5.0),
        (11.0, 12.0, -math.inf),
        (10.9, 12.0, 7.0),
        (12.0, 13.0, -math.inf),
    ],
)
def test_what_stands_highest_between_two_places(first_mm: float, last_mm: float, height_mm: float) -> None:
    """What a way only touches is not between them."""
    assert stepped().highest(first_mm, last_mm) == height_mm


# From and to (t, h); whether it goes through stock.
RAPIDS = [
    ((0.0, 5.0), (4.0, 5.0), False),
    ((0.0, 4.99), (4.0, 4.99), True),
    ((0.0, 4.9999995), (4.0, 4.9999995), False),
    ((0.0, 5.0), (6.0, 5.0), False),
    ((0.0, 5.0), (6.01, 5.0), True),
    ((20.0, 7.0), (0.0, 7.0), False),
    ((20.0, 6.9), (0.0, 6.9), True),
    ((5.0, 9.0), (5.0, 3.0), False),
    ((5.0, 9.0), (5.0, 2.99), True),
    ((5.0, 2.99), (5.0, 9.0), True),
    ((3.0, 9.0), (3.0, 4.0), True),
    ((4.0, 9.0), (4.0, 3.0), False),  # beside the wall, where the tool is
    ((4.0, 9.0), (4.0, 2.9), True),
    ((6.0, 9.0), (6.0, 3.0), False),
    ((11.0, 9.0), (11.0, -3.0), False),
    ((1.0, 9.0), (1.0, -3.0), False),
    ((0.5, 9.0), (0.5, -3.0), False),
    ((0.0, 9.0), (8.0, 5.0), True),  # at 6 it is 6 high, and 7 stand behind
    ((0.0, 9.0), (6.0, 3.0), False),  # at 4 it is 5 high, at 6 no lower than what stands before
    ((0.0, 8.9), (6.0, 2.9), True),
    ((0.0, 10.0), (12.0, 4.0), True),
    ((0.0, 11.0), (12.0, 7.0), False),
    ((12.0, 7.0), (0.0, 11.0), False),
    ((12.0, 5.0), (6.0, 11.0), True),
]


@pytest.mark.parametrize(("start", "end", "is_refused"), RAPIDS)
def test_a_rapid_goes_through_no_stock(
    start: tuple[float, float], end: tuple[float, float], is_refused: bool
) -> None:
    wrong = f"a rapid from {Point(*start)} to {Point(*end)} would go through standing stock"
    with pytest.raises(SelfCheckError, match=f"^{re.escape(wrong)}$") if is_refused else nullcontext():
        stepped().check_rapid(Point(*start), Point(*end))
