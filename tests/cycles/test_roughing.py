"""Passes at levels: what they remove is the stock over the contour with its allowances, for any contour."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.cycles.contour import Frame, Point, Segment, drop_mm, turns_back_along_t
from chipbreak.cycles.roughing import Motion, Pass, Roughing, roughing_passes
from chipbreak.cycles.stock import Stock
from chipbreak.text.diagnostics import SelfCheckError

FINE = 20_001


def arc(start: Point, end: Point, bulge: float) -> Segment:
    """An arc; ``bulge`` is its sagitta over half its chord, with the sign of its turn."""
    half = math.dist(start, end) / 2.0
    sagitta = abs(bulge) * half
    radius = (half * half + sagitta * sagitta) / (2.0 * sagitta)
    away = (radius - sagitta) / (2.0 * half) * math.copysign(1.0, bulge)
    middle = Point((start.t + end.t) / 2.0, (start.h + end.h) / 2.0)
    centre = Point(middle.t - away * (end.h - start.h), middle.h + away * (end.t - start.t))
    return Segment(start, end, centre, 1 if bulge > 0.0 else -1)


@st.composite
def contours(draw: st.DrawFn, *, pockets: bool) -> tuple[Segment, ...]:
    """Lines and arcs that never turn back along t, and along h only where ``pockets``."""
    steps = draw(
        st.lists(
            st.tuples(st.integers(0, 12000), st.integers(-6000 if pockets else 0, 6000), st.integers(-3, 3)),
            min_size=1,
            max_size=7,
        )
    )
    points = [Point(0.0, 0.0)]
    bulges = []
    for t, h, bulge in steps:
        if t == 0 and h == 0:
            continue
        points.append(Point(points[-1].t + t / 1000.0, points[-1].h + h / 1000.0))
        bulges.append(bulge / 10.0)
    made = [
        arc(a, b, bulge) if bulge else Segment(a, b)
        for (a, b), bulge in zip(pairwise(points), bulges, strict=True)
    ]
    straight = [Segment(one.start, one.end) for one in made]
    fits = not turns_back_along_t(made) and (pockets or drop_mm(made) <= 1e-6)
    return tuple(made if fits else straight)


@st.composite
def cycles(draw: st.DrawFn, *, pockets: bool = False) -> Roughing:
    contour = draw(contours(pockets=pockets).filter(lambda c: bool(c) and c[-1].end.t > 0.5))
    highest = max(max(one.start.h, one.end.h) for one in contour)
    before = draw(st.integers(0, 3)) if contour[0].start.h < highest else 0
    return Roughing(
        start=Point(-float(before), highest + draw(st.integers(1, 4000)) / 1000.0 + 2.0),
        contour=contour,
        depth_mm=draw(st.integers(300, 4000)) / 1000.0,
        retract_mm=draw(st.integers(1, 10)) / 20.0,
        t_allowance_mm=draw(st.integers(0, 300)) / 1000.0,
        h_allowance_mm=draw(st.integers(0, 500)) / 1000.0,
        feeds_in=draw(st.booleans()),
    )


def points_of(start: Point, move: Motion) -> np.ndarray:
    """Places on a move, (n, 2), close enough that chords lie within a tenth of a micrometre."""
    segment = Segment(start, move.end, move.centre, move.turn)
    count = 2 if move.centre is None else 4000
    return np.array([segment.point(share) for share in np.linspace(0.0, 1.0, count)])


def left_behind(cycle: Roughing, passes: list[Pass]) -> tuple[np.ndarray, np.ndarray]:
    """Where stock stands behind the passes: places along t and heights; a rapid through stock is no pass."""
    last = max(one.end.t for one in cycle.rough_contour)
    t = np.linspace(cycle.departure.t, last, FINE)
    height = np.full(FINE, cycle.start.h)
    at = cycle.start
    for move in (move for one in passes for move in one.moves):
        way = points_of(at, move)
        at = move.end
        if abs(way[-1, 0] - way[0, 0]) < 1e-9:
            continue
        way = way if way[-1, 0] > way[0, 0] else way[::-1]
        inside = (t > way[0, 0] + 1e-9) & (t < way[-1, 0] - 1e-9)
        there = np.interp(t[inside], way[:, 0], way[:, 1])
        if move.cuts:
            assert (height[inside] - there).max(initial=0.0) <= cycle.depth_mm + 2e-3
            height[inside] = np.minimum(height[inside], there)
        else:
            assert (height[inside] - there).max(initial=0.0) <= 2e-3, "a rapid goes through stock"
    assert at == cycle.start
    return t, height


def wanted(cycle: Roughing, t: np.ndarray) -> np.ndarray:
    """The contour with its allowances, as high as the stock at most."""
    places = [np.array([cycle.rough_contour[0].start])]
    at = cycle.rough_contour[0].start
    for one in cycle.rough_contour:
        places.append(points_of(at, Motion(True, one.end, one.centre, one.turn)))
        at = one.end
    way = np.concatenate(places)
    return np.minimum(np.interp(t, way[:, 0], way[:, 1]), cycle.start.h)


def check(cycle: Roughing, passes: list[Pass]) -> None:
    t, height = left_behind(cycle, passes)
    aimed = wanted(cycle, t)
    step = (t[-1] - t[0]) / FINE
    lost = float(np.abs(height - aimed).sum() * step)
    walls = sum(abs(one.end.h - one.start.h) for one in cycle.contour) + cycle.start.h
    assert lost <= 2.0 * step * walls + 1e-3 * (t[-1] - t[0])


@pytest.mark.few(30)
@given(cycles())
def test_what_type_one_removes_is_the_stock_over_the_contour(cycle: Roughing) -> None:
    check(cycle, roughing_passes(cycle))


@pytest.mark.few(15)
@given(cycles(pockets=True))
def test_what_pockets_remove_is_the_stock_over_the_contour(cycle: Roughing) -> None:
    check(cycle, roughing_passes(cycle))


@pytest.mark.parametrize("wrong_mm", [0.05, -0.05])
def test_passes_of_another_allowance_are_found(wrong_mm: float) -> None:
    """The check above can fail."""
    contour = (Segment(Point(0.0, 0.0), Point(20.0, 0.0)), Segment(Point(20.0, 0.0), Point(30.0, 8.0)))
    cycle = Roughing(Point(-2.0, 10.0), contour, 2.0, 0.5, h_allowance_mm=0.2)
    check(cycle, roughing_passes(cycle))
    with pytest.raises(AssertionError):
        check(cycle, roughing_passes(cycle._replace(h_allowance_mm=0.2 + wrong_mm)))


def test_passes_of_a_greater_depth_are_found() -> None:
    contour = (Segment(Point(0.0, 0.0), Point(20.0, 0.0)),)
    cycle = Roughing(Point(-2.0, 10.0), contour, 2.0, 0.5)
    with pytest.raises(AssertionError):
        check(cycle, roughing_passes(cycle._replace(depth_mm=2.5)))


def test_a_rapid_through_stock_is_a_fault() -> None:
    stock = Stock(0.0, 10.0, 5.0)
    stock.cut(0.0, 4.0, 2.0)
    stock.check_rapid(Point(0.0, 2.5), Point(4.0, 2.5))
    with pytest.raises(SelfCheckError, match="standing stock"):
        stock.check_rapid(Point(0.0, 2.5), Point(6.0, 2.5))


def test_a_pass_deeper_than_commanded_is_a_fault() -> None:
    with pytest.raises(SelfCheckError, match="are allowed"):
        Stock(0.0, 10.0, 5.0).cut(0.0, 4.0, 2.0, depth_mm=2.0)


@pytest.mark.parametrize("along", ["Z", "X"])
@pytest.mark.parametrize("t_sign", [1, -1])
@pytest.mark.parametrize("h_sign", [1, -1])
def test_the_axes_of_passes_lead_back_to_the_lathe(along: str, t_sign: int, h_sign: int) -> None:
    frame = Frame(along, t_sign, h_sign)
    assert frame.outside(frame.inside(3.0, 7.0)) == (3.0, 7.0)
    # The turn from +Z to +X, seen in the axes of the passes.
    origin = frame.inside(0.0, 0.0)
    z = frame.inside(1.0, 0.0)
    x = frame.inside(0.0, 1.0)
    cross = (z.t - origin.t) * (x.h - origin.h) - (z.h - origin.h) * (x.t - origin.t)
    assert frame.mirrors == (cross < 0.0)
