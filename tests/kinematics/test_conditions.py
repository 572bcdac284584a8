"""Conditions that are chosen: which N and S are tried, by closed forms, and in which order they come."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from chipbreak.kinematics.conditions import Conditions, Limits, Wanted, best_first, least_demand
from chipbreak.kinematics.speed_solver import Period, SolverRules

TICK_S = 0.004
FREE = Limits(1e9, 1e9)
FINE = SolverRules(resolution_rpm=0.001)


def of_ticks(*ticks: int) -> list[Period]:
    return [Period(1.0 / (TICK_S * n), TICK_S * n, n) for n in ticks]


def wanted(speed_rpm: float, *, edges: int = 1, alpha: float | None = None) -> Wanted:
    return Wanted(0.1, speed_rpm, edges, 1.2, 0.2, alpha)


def found(ask: Wanted, *ticks: int, limits: Limits = FREE, rules: SolverRules = FINE) -> list[Conditions]:
    return best_first(ask, of_ticks(*ticks), rules, limits)


def has(choices: list[Conditions], speed_rpm: float, alpha: float) -> Conditions:
    """The one choice of this speed and forward share."""
    (one,) = [
        one for one in choices if abs(one.speed_rpm - speed_rpm) < 1e-3 and abs(one.alpha - alpha) < 1e-9
    ]
    return one


@pytest.mark.parametrize("edges", [1, 2])
@pytest.mark.parametrize("whole", [0, 1, 2, 3])
def test_an_even_triangle_is_tried_with_half_a_vibration_beyond_each_whole_number(
    whole: int, edges: int
) -> None:
    """N/z = whole + 1/2 lies ahead by the whole stroke, so the stroke is margin times feed per edge."""
    n = edges * (whole + 0.5)
    best_rpm = 60.0 / (10 * TICK_S * n)
    one = has(found(wanted(0.9 * best_rpm, edges=edges), 10), best_rpm, 0.5)
    assert one.per_rev == pytest.approx(n, rel=1e-5)
    assert one.stroke_mm == pytest.approx(1.2 * 0.1 / edges, rel=1e-4)
    assert one.chip_rev == pytest.approx(edges / n, rel=1e-5)


@pytest.mark.parametrize(
    ("whole", "share", "ticks"), [(0, 0.7, 10), (1, 0.7, 10), (2, 0.3, 10), (0, 0.25, 4), (0, 0.75, 4)]
)
def test_a_given_share_is_tried_with_its_own_best_count(whole: int, share: float, ticks: int) -> None:
    """Forward for 7 of 10 ticks: a pass that is 3 of 10 late lies ahead by the whole stroke."""
    best_rpm = 60.0 / (ticks * TICK_S * (whole + 1.0 - share))
    one = has(found(wanted(1.1 * best_rpm, alpha=share), ticks), best_rpm, share)
    assert one.stroke_mm == pytest.approx(0.12, rel=1e-4)


@pytest.mark.parametrize(("ticks", "back"), [(12, 5), (9, 4), (20, 5), (14, 3)])
def test_below_one_vibration_a_revolution_the_return_takes_a_revolution(ticks: int, back: int) -> None:
    """N = 1 - forward share: what the tool goes back takes as long as the spindle goes round once."""
    best_rpm = 60.0 / (back * TICK_S)
    one = has(found(wanted(0.96 * best_rpm), ticks), best_rpm, 1.0 - back / ticks)
    assert one.per_rev == pytest.approx(back / ticks, rel=1e-5)
    assert one.stroke_mm == pytest.approx(0.12, rel=1e-4)


@pytest.mark.parametrize(("ticks", "forward"), [(12, 7), (9, 5), (20, 15)])
def test_the_programmed_speed_is_tried_with_the_share_that_suits_its_count(ticks: int, forward: int) -> None:
    """N = 1 + 1 - share: as late as the return is long, a vibration later."""
    speed_rpm = 60.0 / (TICK_S * (2 * ticks - forward))
    one = has(found(wanted(speed_rpm), ticks), speed_rpm, forward / ticks)
    assert one.stroke_mm == pytest.approx(0.12, rel=1e-4)


def cost(one: Conditions, ask: Wanted, limits: Limits) -> float:
    """What speaks against one: chips beyond a revolution, the share of what the axis has, speed, stroke."""
    return (
        max(1.0, one.chip_rev)
        + one.acceleration_mm_s2 / limits.acceleration_mm_s2
        + 5.0 * abs(one.speed_rpm / ask.speed_rpm - 1.0)
        + one.stroke_mm * ask.edges / (ask.margin * ask.feed_mm_rev)
    )


@pytest.mark.parametrize("edges", [1, 2])
@pytest.mark.parametrize("stroke_mm", [None, 0.17])
def test_the_best_comes_first(edges: int, stroke_mm: float | None) -> None:
    ask = wanted(1370.0, edges=edges)._replace(stroke_mm=stroke_mm)
    limits = Limits(4000.0, 80.0)
    choices = found(ask, *range(4, 40), limits=limits)
    costs = [cost(one, ask, limits) for one in choices]
    assert len(costs) > 20
    assert all(a <= b + 1e-9 for a, b in pairwise(costs))
    assert max(one.acceleration_mm_s2 for one in choices) <= 4000.0
    squares = {
        (round(math.log(one.per_rev) / 0.03), round(math.log(one.period.period_s) / 0.03)) for one in choices
    }
    assert len(squares) == len(choices), "of N and f within 3 % only the best is said"


def test_the_strokes_fit_in_the_time_that_the_rests_leave() -> None:
    """Both ways from rest to rest: 4 d / t^2, of which the greater counts; d with the feed and against it."""
    limits = Limits(1e9, 1e9, stop_s=0.006)
    one = has(found(wanted(2000.0, alpha=0.6), 20, limits=limits), 1875.0, 0.6)
    assert one.per_rev == pytest.approx(0.4)
    advance_mm = 0.1 / one.per_rev
    ways = ((0.12 + 0.6 * advance_mm, 0.048), (0.12 - 0.4 * advance_mm, 0.032))
    need = max(4.0 * way / (time - 0.006) ** 2 for way, time in ways)
    assert one.acceleration_mm_s2 == pytest.approx(need, rel=1e-4)
    speed = max(way / (time - 0.006) for way, time in ways)
    assert has(found(wanted(2000.0, alpha=0.6), 20, limits=Limits(1e9, speed * 1.001, 0.006)), 1875.0, 0.6)
    slow = found(wanted(2000.0, alpha=0.6), 20, limits=Limits(1e9, speed * 0.999, 0.006))
    assert not [choice for choice in slow if choice.speed_rpm == 1875.0]


def test_what_needs_least_is_said_whatever_the_limits() -> None:
    ask = wanted(1370.0)
    every = found(ask, *range(4, 40))
    least = least_demand(ask, of_ticks(*range(4, 40)), FINE, Limits(1.0, 1.0))
    assert least is not None
    assert least.acceleration_mm_s2 <= min(one.acceleration_mm_s2 for one in every)
    assert not found(ask, *range(4, 40), limits=Limits(0.99 * least.acceleration_mm_s2, 1e9))
    assert found(ask, *range(4, 40), limits=Limits(1.01 * least.acceleration_mm_s2, 1e9))
    assert least_demand(ask, [], FINE, FREE) is None
