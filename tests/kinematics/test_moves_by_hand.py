"""Lengths and times of moves, legs of a path, demands of conditions, heights between knots: by hand."""

from __future__ import annotations

import math
from itertools import pairwise, product
from math import inf, nan, pi, sqrt
from typing import Any

import numpy as np
import pytest

from chipbreak.kinematics import piecewise
from chipbreak.kinematics.cells import cells_of
from chipbreak.kinematics.chip_model import judge
from chipbreak.kinematics.conditions import (
    Limits,
    Wanted,
    _all,
    _allowed,
    _choices,
    _Table,
    best_first,
    least_demand,
)
from chipbreak.kinematics.growing import Growing, joined
from chipbreak.kinematics.machine_demand import flank_clearance_deg, least_acceleration_mm_s2
from chipbreak.kinematics.move_times import (
    Arcs,
    arc_lengths_mm,
    line_lengths_mm,
    rapid_times_s,
    surface_turn_s,
)
from chipbreak.kinematics.piecewise import Motion, highest_minimum, lowest_of, mean_step_s, rests_of
from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.kinematics.speed_solver import Period, SolverRules
from chipbreak.kinematics.toolpath import Leg, path_of, split_at
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.text.diagnostics import RefusalError

# --- lengths and times ------------------------------------------------------------------------------------


def arc(
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    turn: int,
    plane: str = "XY",
    **more: Any,
) -> float:
    offset = np.array([more.get("offset", (nan, nan, nan))])
    radius = np.array([more.get("radius", nan)])
    turns = more.get("turns", 0.0)
    every = Arcs(
        np.array([start]), np.array([end]), np.array([float(turn)]), plane, offset, radius, np.array([turns])
    )
    return float(arc_lengths_mm(every)[0])


def test_lengths_of_lines() -> None:
    start, end = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]), np.array([[3.0, 5.0, 9.0], [0.0, -2.0, 0.0]])
    assert line_lengths_mm(start, end).tolist() == [7.0, 2.0]


@pytest.mark.parametrize(
    ("turn", "end", "sweep"),
    [
        (1, (0.0, 2.0, 0.0), pi / 2),
        (-1, (0.0, 2.0, 0.0), 1.5 * pi),
        (1, (-2.0, 0.0, 0.0), pi),
        (1, (2.0, 0.0, 0.0), 2 * pi),
        (-1, (2.0, 0.0, 0.0), 2 * pi),
    ],
)
@pytest.mark.parametrize("plane", ["XY", "ZX", "YZ"])
def test_lengths_of_arcs_about_a_centre(
    turn: int, end: tuple[float, float, float], sweep: float, plane: str
) -> None:
    """About a point two to one side; the first axis of the plane turns to the second counter-clockwise."""
    one, two = {"XY": (0, 1), "ZX": (2, 0), "YZ": (1, 2)}[plane]

    def placed(first: float, second: float, along: float) -> tuple[float, float, float]:
        point = [along] * 3
        point[one] = first
        point[two] = second
        return point[0], point[1], point[2]

    start, offset = placed(2.0, 0.0, 5.0), placed(-2.0, 0.0, nan)
    there = placed(end[0], end[1], 5.0)
    assert arc(start, there, turn, plane, offset=offset) == pytest.approx(2.0 * sweep)
    assert arc(start, there, turn, plane, offset=offset, turns=2.0) == pytest.approx(2.0 * (sweep + 4.0 * pi))
    helix = placed(end[0], end[1], 8.0)
    assert arc(start, helix, turn, plane, offset=offset) == pytest.approx(math.hypot(2.0 * sweep, 3.0))


def test_lengths_of_arcs_by_radius() -> None:
    start, end = (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)
    half = math.asin(1.0 / 1.6)
    assert arc(start, end, 1, radius=1.6) == pytest.approx(1.6 * 2.0 * half)
    assert arc(start, end, -1, radius=-1.6) == pytest.approx(1.6 * 2.0 * (pi - half))
    assert arc(start, end, 1, radius=1.0) == pytest.approx(pi)
    assert arc(start, end, 1, radius=0.999) == pytest.approx(0.999 * pi)
    assert arc(start, end, 1, radius=1.6, turns=1.0) == pytest.approx(1.6 * (2.0 * half + 2.0 * pi))
    # A centre goes before a radius, where a block has both; one coordinate of it is enough.
    assert arc(start, end, 1, radius=1.6, offset=(1.0, 0.0, nan)) == pytest.approx(pi)
    assert arc(start, end, 1, radius=1.6, offset=(1.0, nan, nan)) == pytest.approx(pi)


@pytest.mark.parametrize(
    ("way", "took"),
    [
        ((0.0, 0.0, 0.0), 0.0),
        ((40.0, 0.0, 0.0), 40.0 / 20.0 + 20.0 / 10.0),
        ((10.0, 0.0, 0.0), 2.0 * sqrt(10.0 / 10.0)),
        ((0.0, -30.0, 0.0), 30.0 / 10.0),
        ((10.0, 30.0, 0.0), 3.0),
        ((10.0, 30.0, 80.0), 80.0 / 40.0 + 40.0 / 20.0),
        ((0.0, 0.0, -80.0), 4.0),
        ((0.0, 0.0, -79.0), 2.0 * sqrt(79.0 / 20.0)),
    ],
)
def test_a_rapid_takes_as_long_as_its_slowest_axis(way: tuple[float, float, float], took: float) -> None:
    speed, acceleration = np.array([20.0, 10.0, 40.0]), np.array([10.0, inf, 20.0])
    assert rapid_times_s(np.array([way]), speed, acceleration).tolist() == pytest.approx([took])


@pytest.mark.parametrize(
    ("start", "end"),
    [
        (30.0, 10.0),
        (10.0, 30.0),
        (20.0, 20.0),
        (4.0, 3.0),
        (2.0, 30.0),
        (-5.0, 30.0),
        (7.0, 7.9577),
        (9.0, 9.8),
    ],
)
def test_the_mean_turn_under_constant_surface_speed(start: float, end: float) -> None:
    """The mean of 2 pi r / v over the radii, of the limit where r is smaller: by very many radii."""
    speed_m_min, limit_rpm = 100.0, 2000.0
    low, high = sorted((abs(start), abs(end)))
    radii = np.linspace(low, high, 200_001)
    turns_s = np.maximum(2.0 * pi * radii / (1000.0 * speed_m_min) * 60.0, 60.0 / limit_rpm)
    found = surface_turn_s(np.array([start]), np.array([end]), speed_m_min, limit_rpm)
    assert found.tolist() == pytest.approx([float(turns_s.mean())], rel=1e-6)


# --- paths ------------------------------------------------------------------------------------------------


def told(*legs: Leg) -> tuple[str, str, str]:
    with pytest.raises(RefusalError) as caught:
        path_of(legs)
    return caught.value.code, caught.value.message, caught.value.help


def test_what_is_said_of_arcs_that_cannot_be() -> None:
    assert told(Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, "XY", (1.03, 0.0, nan))) == (
        "VIB022",
        "the arc starts 1.0300 mm and ends 0.9700 mm from its centre",
        "check I, J, K or R of the block",
    )
    assert told(Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, "XY", (0.0, 0.0, nan)))[1].startswith(
        "the arc starts 0.0000 mm"
    )
    assert told(Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1)) == (
        "VIB022",
        "the arc has neither centre nor radius",
        "give I, J, K or R on the block",
    )
    assert told(Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, radius_mm=-0.979)) == (
        "VIB022",
        "no arc of radius -0.979 mm joins points 2.0000 mm apart",
        "give I, J, K or a fitting R on the block",
    )
    assert told(Leg((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1, radius_mm=1.0))[1].endswith(
        "joins points 0.0000 mm apart"
    )
    assert told(Leg((1.0, 0.0, 0.0), (1.0, 0.0, 0.0)), Leg((1.0, 0.0, 0.0), (1.0 + 1e-10, 0.0, 0.0))) == (
        "VIB023",
        "the cut has no length",
        "a vibrated cut needs a distance to travel",
    )
    # Two roundings are room enough.
    assert path_of([Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, "XY", (1.009, 0.0, nan))]).length_mm > 3.0
    assert path_of([Leg((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), 1, radius_mm=0.981)]).length_mm > 3.0


def quarter() -> Any:
    """3 mm along X, a quarter of a circle of 2 mm to the left, 4 mm along Y and up."""
    return path_of(
        [
            Leg((0.0, 0.0, 0.0), (3.0, 0.0, 0.0)),
            Leg((3.0, 0.0, 0.0), (5.0, 2.0, 0.0), 1, "XY", (0.0, 2.0, nan)),
            Leg((5.0, 2.0, 0.0), (5.0, 6.0, 3.0)),
        ]
    )


def test_places_and_directions_on_a_path() -> None:
    path = quarter()
    assert path.ends_mm.tolist() == pytest.approx([0.0, 3.0, 3.0 + pi, 8.0 + pi])
    where = np.array([1.5, 3.0 + pi / 2.0, 3.0 + pi + 2.5])
    root = 2.0 * sqrt(0.5)
    assert path.points(where).tolist() == [
        pytest.approx([1.5, 0.0, 0.0]),
        pytest.approx([3.0 + root, 2.0 - root, 0.0]),
        pytest.approx([5.0, 4.0, 1.5]),
    ]
    assert path.tangents(where).tolist() == [
        pytest.approx([1.0, 0.0, 0.0]),
        pytest.approx([root / 2.0, root / 2.0, 0.0]),
        pytest.approx([0.0, 0.8, 0.6]),
    ]
    # Only the last joint is a corner: by the root of 0.2² + 0.6².
    assert path.corners_mm().tolist() == pytest.approx([3.0 + pi])
    assert path.corners_mm(0.64).tolist() == [] and len(path.corners_mm(0.63)) == 1


def test_a_helix_has_its_rise_in_its_direction() -> None:
    path = path_of([Leg((2.0, 0.0, 0.0), (0.0, 2.0, 3.0), 1, "XY", (-2.0, 0.0, nan))])
    assert path.length_mm == pytest.approx(math.hypot(pi, 3.0))
    (middle,) = path.points(np.array([path.length_mm / 2.0])).tolist()
    assert middle == pytest.approx([sqrt(2.0), sqrt(2.0), 1.5])
    (way,) = path.tangents(np.array([path.length_mm / 2.0])).tolist()
    size = math.hypot(pi, 3.0)
    assert way == pytest.approx([-pi / size * sqrt(0.5), pi / size * sqrt(0.5), 3.0 / size])


@pytest.mark.parametrize("length", [1.0, 3.0, 4.0, 3.0 + pi, 9.0, 8.0 + pi])
def test_the_beginning_of_a_path_has_its_points_and_ends_at_its_length(length: float) -> None:
    path = quarter()
    begun = path.beginning(length)
    assert begun.length_mm == length
    assert len(begun.legs) == (1 if length <= 3.0 else 2 if length <= 3.0 + pi else 3)
    some = np.linspace(0.0, length, 7)
    assert begun.points(some) == pytest.approx(path.points(some), abs=1e-12)
    assert begun.tangents(some[1:-1]) == pytest.approx(path.tangents(some[1:-1]), abs=1e-12)


def test_how_many_chords_an_arc_needs() -> None:
    """l² / (8 r) = 0.01 on a radius of 2: 0.4 mm; the arc is from 3 to 3 + pi."""
    path = quarter()
    starts = np.array([0.0, 2.9, 3.0, 3.5, 3.0 + pi, 3.4, 4.0, 2.0])
    ends = np.array([3.0, 3.05, 3.4, 2.7, 7.0, 3.81, 4.0, 8.0])
    assert path.pieces(starts, ends, 0.01).tolist() == [1, 1, 1, 2, 1, 2, 1, 15]
    cuts = path.breakpoints(0.01)
    assert cuts.tolist() == pytest.approx([3.0 + pi * k / 8 for k in range(9)])
    assert path.breakpoints(1e9).tolist() == pytest.approx([3.0, 3.0 + pi])


def test_a_motion_is_split_where_it_crosses() -> None:
    time_s, place = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 4.0, 1.0, 1.0])
    times, places = split_at(time_s, place, np.array([1.0, 2.0, 4.0]))
    assert places.tolist() == [0.0, 1.0, 2.0, 4.0, 2.0, 1.0, 1.0]
    assert times.tolist() == pytest.approx([0.0, 0.25, 0.5, 1.0, 1.0 + 2.0 / 3.0, 2.0, 3.0])
    assert split_at(time_s, place, np.empty(0))[0] is time_s


# --- conditions -------------------------------------------------------------------------------------------

PERIODS = [Period(250.0 / n, n * 0.004, n) for n in range(4, 24)]


@pytest.mark.parametrize("edges", [1, 2])
@pytest.mark.parametrize(
    ("stroke_mm", "alpha", "stop_s"),
    [(None, None, 0.0), (0.15, None, 0.003), (0.11, 0.7, 0.0), (None, 0.3, 0.006)],
)
def test_what_choices_need_is_what_each_one_needs(
    edges: int, stroke_mm: float | None, alpha: float | None, stop_s: float
) -> None:
    ask = Wanted(0.1, 700.0, edges, 1.2, 0.3, alpha, stroke_mm)
    rules = SolverRules(resolution_rpm=1.0)
    table = _choices(ask, PERIODS, rules)
    found = _all(ask, PERIODS, rules, Limits(1.0, 1.0, stop_s))
    wanted = []
    for at, ticks, forward, period_s, speed in zip(
        *(
            column.tolist()
            for column in (table.at, table.ticks, table.forward, table.period_s, table.speed_rpm)
        ),
        strict=True,
    ):
        one = needs_of(ask, forward / ticks, period_s, speed, stop_s)
        if one is not None:
            wanted.append((at, forward, speed, *one))
    columns = (
        found.table.at,
        found.table.forward,
        found.table.speed_rpm,
        found.stroke_mm,
        found.need_mm_s2,
        found.need_mm_s,
    )
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    assert len(rows) == len(wanted) > 5
    for row, one in zip(rows, wanted, strict=True):
        assert row == pytest.approx(one)


def needs_of(
    ask: Wanted, share: float, period_s: float, speed_rpm: float, stop_s: float
) -> tuple[float, float, float] | None:
    """Stroke, acceleration and speed of one choice; None where it breaks nothing, or cannot be run."""
    n = 60.0 / (period_s * speed_rpm)
    delta = (n / ask.edges) % 1.0
    drop = min(delta / (1.0 - share), (1.0 - delta) / share)
    least = ask.margin * ask.feed_mm_rev / ask.edges / drop
    stroke = least if ask.stroke_mm is None else ask.stroke_mm
    ways = stroke + share * ask.feed_mm_rev / n, stroke - (1.0 - share) * ask.feed_mm_rev / n
    times = share * period_s - stop_s, (1.0 - share) * period_s - stop_s
    if stroke * drop < ask.feed_mm_rev / ask.edges or ways[1] <= 0.0 or min(times) <= 0.0:
        return None
    both = list(zip(ways, times, strict=True))
    return stroke, max(4.0 * way / time**2 for way, time in both), max(way / time for way, time in both)


def table_of(speeds: list[float], per_rev: float) -> _Table:
    """Rows with these speeds, all of them with this N."""
    rpm = np.array(speeds)
    return _Table(
        np.zeros(len(rpm)), np.full(len(rpm), 4.0), np.full(len(rpm), 2.0), 60.0 / (per_rev * rpm), rpm
    )


@pytest.mark.parametrize(
    ("rules", "speeds", "allowed"),
    [
        ({}, [799.0, 800.0, 1000.0, 1200.0, 1201.0], [False, True, True, True, False]),
        ({"max_rpm": 1100.0}, [1100.0, 1101.0], [True, False]),
        ({"max_rpm": 1300.0}, [1200.0, 1201.0], [True, False]),
        ({"min_rpm": 900.0}, [899.0, 900.0], [False, True]),
        ({"min_rpm": 700.0}, [799.0, 800.0], [False, True]),
        ({"resolution_rpm": 850.0}, [849.0, 850.0], [False, True]),
    ],
)
def test_which_speeds_are_allowed(rules: dict[str, Any], speeds: list[float], allowed: list[bool]) -> None:
    ask = Wanted(0.1, 1000.0, 1, 1.2, 0.2)
    assert _allowed(table_of(speeds, 1.5), ask, SolverRules(**rules)).tolist() == allowed


@pytest.mark.parametrize(
    ("per_rev", "allowed"),
    [
        (0.199, False),
        (0.201, True),
        (4.499, True),
        (4.501, False),
        (2.0, False),
        (2.0009, False),
        (2.0011, True),
        (1.9989, True),
    ],
)
@pytest.mark.parametrize("edges", [1, 2])
def test_which_counts_are_allowed(per_rev: float, allowed: bool, edges: int) -> None:
    ask = Wanted(0.1, 1000.0, edges, 1.2, 0.2)
    assert _allowed(table_of([1000.0], per_rev * edges), ask, SolverRules()).tolist() == [allowed]


def test_choices_within_the_limits_and_the_one_that_needs_least() -> None:
    ask = Wanted(0.1, 700.0, 1, 1.2, 0.3)
    least = least_demand(ask, PERIODS, SolverRules(), Limits(1.0, 1.0))
    assert least is not None
    assert best_first(ask, PERIODS, SolverRules(), Limits(least.acceleration_mm_s2, 1e9)) == [least]
    assert best_first(ask, PERIODS, SolverRules(), Limits(least.acceleration_mm_s2 * (1.0 - 1e-9), 1e9)) == []
    assert Limits(1.0, 2.0).stop_s == 0.0
    assert (Wanted(0.1, 1.0, 1, 1.2, 0.1).alpha, Wanted(0.1, 1.0, 1, 1.2, 0.1).stroke_mm) == (None, None)


# --- what else --------------------------------------------------------------------------------------------


def test_demands_of_the_machine_and_of_the_tool() -> None:
    cut = WaveformParameters(1.0, 0.05, 3000.0, 0.016, 4, 2, 0.06)
    assert least_acceleration_mm_s2(cut, 1.25) == pytest.approx(4.0 * (0.06 + 0.025 / 1.25) / 0.008**2)
    assert flank_clearance_deg(10.0, 20.0, 3000.0) == pytest.approx(
        math.degrees(math.atan(10.0 / (pi * 20.0 * 50.0)))
    )
    assert (str(SourcedValue(2586.2149, "S")), shown(1.0 / 3.0), shown(2500.0)) == (
        "2586.21 (S)",
        "0.333333",
        "2500",
    )


@pytest.mark.parametrize("sizes", [(3, 4), (1000, 24, 1, 300), (1024, 1), (0, 2000, 0, 5), (1025, 255, 1)])
def test_pieces_that_are_joined_are_all_there(sizes: tuple[int, ...]) -> None:
    pieces = [np.arange(size) + 10_000.0 * number for number, size in enumerate(sizes)]
    assert joined(pieces).tolist() == np.concatenate(pieces).tolist()
    row = Growing()
    for piece in pieces:
        row.add(piece)
    assert len(row.whole()) == sum(sizes)


def test_between_which_knots_numbers_lie() -> None:
    knots = np.array([0.0, 1.0, 1.0, 2.0, 5.0])
    values = np.array([-3.0, 0.0, 0.5, 1.0, 1.5, 2.0, 4.9, 5.0, 7.0])
    assert cells_of(knots, values).tolist() == [0, 0, 0, 2, 2, 3, 3, 3, 3]
    for at, value in enumerate(values):
        assert cells_of(knots, values[at : at + 1]).tolist() == [
            max(min(int((knots <= value).sum()) - 1, 3), 0)
        ]


def test_rests_and_steps_of_a_motion() -> None:
    time_s = np.array([0.0, 1.0, 3.0, 4.0, 4.5, 6.0, 7.0])
    place = np.array([0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 3.0])
    rests = rests_of(time_s, place, 0.1)
    assert (rests.begin.tolist(), rests.dwell_s.tolist()) == ([1, 3], [2.0, 2.0])
    assert rests_of(time_s, place * 0.1, 0.1).begin.tolist() == []
    uneven = rests_of(time_s + np.array([0, 0, 0, 0, 0, 1.0, 1.0]), place, 0.1)
    assert uneven.dwell_s.tolist() == [2.0, 3.0]
    assert (
        uneven.shortest_s(np.array([3, 5])),
        uneven.shortest_s(np.array([1, 3])),
        uneven.shortest_s(np.array([2])),
    ) == (3.0, 2.0, 0.0)
    # Steps of 1, 1, 2 and 0.2: four vibrations in 4.2 s, or as many as were meant.
    crests = np.cumsum([0.0, 1.0, 1.0, 2.0, 0.2])
    assert mean_step_s(crests) == pytest.approx(4.2 / 4.0)
    assert mean_step_s(crests, 3.0001) == pytest.approx(1.4)
    assert mean_step_s(crests, 0.2) == pytest.approx(4.2 / 4.0)


@pytest.mark.parametrize("at_once", [2, 3, 1 << 16])
def test_where_a_motion_turns_and_how_fast_it_is(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """It turns back at knots 2 and 6, on at 4; a stop on the way is no turn, nor is less than a touch."""
    monkeypatch.setattr(piecewise, "KNOTS_AT_ONCE", at_once)
    place = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 1.5, 3.0, 2.9999, 1.0, 1.0])
    motion = Motion(np.arange(10.0) * 0.5, place, 0.75, 0.001)
    crests, troughs = motion.reversals()
    assert (crests.tolist(), troughs.tolist()) == ([2, 6], [4])
    assert motion.peak_speed_mm_s() == pytest.approx(1.9999 / 0.5)
    gaps = [
        [pair for some in every for pair in zip(*(column.tolist() for column in some), strict=True)]
        for every in motion.corner_gaps()
    ]

    def gap(time_s: float) -> float:
        return float(np.interp(time_s, motion.time_s, place) - np.interp(time_s - 0.75, motion.time_s, place))

    assert [time for time, _ in gaps[0]] == motion.time_s.tolist()
    assert [time for time, _ in gaps[1]] == [
        time + 0.75 for time in motion.time_s.tolist() if time + 0.75 <= 4.5
    ]
    for time_s, found in (*gaps[0], *gaps[1]):
        assert found == pytest.approx(gap(time_s), abs=1e-12)


def test_the_last_place_before_a_time_where_a_gap_can_turn() -> None:
    motion = Motion(np.array([0.0, 1.0, 2.0, 3.0]), np.zeros(4), 0.75, 0.001)
    places = sorted([0.0, 1.0, 2.0, 3.0, 0.75, 1.75, 2.75])
    for time_s in (0.5, 0.75, 0.8, 1.0, 1.75, 1.76, 2.0, 2.5, 2.75, 3.0):
        assert motion.corner_before(time_s) == max(one for one in places if one < time_s)


@pytest.mark.parametrize("at_once", [4, 1 << 20])
def test_the_least_of_several_heights(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """Against so many places in every segment that hardly anything lies between them."""
    monkeypatch.setattr(piecewise, "_HEIGHTS_AT_ONCE", at_once)
    draw = np.random.default_rng(11)
    corners = np.cumsum(draw.uniform(0.5, 1.5, 9))
    table = draw.uniform(-1.0, 3.0, (4, 9))

    def heights(at: Any) -> Any:
        return np.array([np.interp(at, corners, row) for row in table])

    peak, enter, leave = lowest_of(heights, corners, 4, 0.25)
    shares = np.linspace(0.0, 1.0, 4001)
    best = -inf
    for at, (first, last) in enumerate(pairwise(corners)):
        least = heights(first + shares * (last - first)).min(axis=0)
        best = max(best, float(least.max()))
        above = shares[least > 0.25]
        if len(above):
            assert (enter[at], leave[at]) == pytest.approx((above[0], above[-1]), abs=3e-4)
        else:
            assert leave[at] <= enter[at] + 3e-4
    assert peak == pytest.approx(best, abs=2e-3)
    assert peak >= best - 1e-12


@pytest.mark.parametrize("at_once", [4, 1 << 20])
def test_the_greatest_thickness_alone(monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    """It is that which stands beside the chips, and what is known already is not undercut."""
    monkeypatch.setattr(piecewise, "_HEIGHTS_AT_ONCE", at_once)
    draw = np.random.default_rng(5)
    time_s = np.cumsum(draw.uniform(0.1, 0.4, 60))
    motion = Motion(time_s, np.cumsum(draw.uniform(-0.5, 1.0, 60)), 0.9, 1e-9)
    part = (float(time_s[12]), float(time_s[50]))
    _, peak_mm, *_ = motion.thickness(part, 4)
    assert motion.peak_thickness(part, 4, -inf) == peak_mm
    assert motion.peak_thickness(part, 4, peak_mm + 1.0) == peak_mm + 1.0


def test_the_highest_least_of_lines_by_hand() -> None:
    """Two that cross at 0.25 in a height of 1; a third that lies below there; a known one above it."""
    left, right = np.array([[0.0], [1.25]]), np.array([[4.0], [0.25]])
    assert highest_minimum(left, right, -inf) == pytest.approx(1.0)
    third = np.array([[0.0], [1.25], [0.5]]), np.array([[4.0], [0.25], [0.5]])
    assert highest_minimum(*third, -inf) == pytest.approx(0.5)
    assert highest_minimum(left, right, 1.5) == 1.5
    assert highest_minimum(np.array([[2.0, 0.0]]), np.array([[1.0, 3.0]]), -inf) == 3.0
    draw = np.random.default_rng(3)
    shares = np.linspace(0.0, 1.0, 2001)
    for _, count in product(range(12), (2, 3, 5)):
        ends = draw.uniform(0.0, 1.0, (2, count, 3))
        lines = ends[0][..., np.newaxis] + (ends[1] - ends[0])[..., np.newaxis] * shares
        best = float(lines.min(axis=0).max())
        assert best - 1e-12 <= highest_minimum(ends[0], ends[1], -inf) <= best + 1e-3


@pytest.mark.parametrize(
    ("first_s", "last_s", "vibration_s", "margin"),
    [
        # Of whole vibrations the mean speed is told, wherever they begin; of less, or unasked, the feed.
        (0.0704, 0.0880, 0.0176, 0.96),
        (0.0704, 0.1038, 0.0176, 0.96),
        (0.0714, 0.0879, 0.0176, 0.9636363636),
        (0.0704, 0.0880, None, 0.9636363636),
    ],
)
def test_a_single_crest_is_judged_by_the_mean_speed_that_is_told(
    first_s: float, last_s: float, vibration_s: float | None, margin: float
) -> None:
    """0.12 mm at N 1.5 on a control that is a tenth slow: N is 1.3636, of which a stroke drops by 0.7273.

    In a revolution it is fed 0.0909 mm, not 0.1; 0.0873 of them are what the last pass lies ahead.
    """
    time_s = np.append(0.0, (np.arange(12)[:, None] + np.array([0.5, 1.0])).ravel() * 0.0176)
    place = 0.1 / 0.0264 * time_s + np.append(0.0, np.tile([0.12, 0.0], 12))
    found = judge(
        time_s, place, speed_rpm=2500.0, feed_mm_rev=0.1, steady_s=(first_s, last_s), vibration_s=vibration_s
    )
    assert found.margin == pytest.approx(margin, abs=1e-9)
    assert not found.breaks


def test_each_chip_of_a_few_revolutions_by_hand() -> None:
    """Strokes of 0.2 mm at N 1.5 and 0.1 mm/rev: they lie ahead by twice the feed.

    From the last pass the gap is 0.1 - 0.2 x w, w between 1 and -1 and back within one and a third of a
    revolution: half of that the tool is in the air.  The first chip ends in the second revolution.
    """
    time_s = np.append(0.0, (np.arange(24)[:, None] + np.array([0.5, 1.0])).ravel() * 0.016)
    place = 0.1 / 0.024 * time_s + np.append(0.0, np.tile([0.2, 0.0], 24))
    found = judge(time_s, place, speed_rpm=2500.0, feed_mm_rev=0.1, diameter_mm=10.0)
    assert (found.breaks, found.margin) == (True, pytest.approx(2.0))
    assert (found.per_rev, found.chips_per_rev) == (pytest.approx(1.5), pytest.approx(1.5))
    assert found.stroke_mm == pytest.approx(0.2)
    assert found.longest_chip_mm == pytest.approx(10.0 * pi * found.longest_chip_rev)
    assert found.first_chip_mm == pytest.approx(10.0 * pi * found.first_chip_rev)
    every = np.linspace(0.24, 0.384, 144_001)

    def at(when: Any) -> Any:
        return np.interp(when, time_s, place)

    thickness = np.min([at(every) - at(every - 0.024 * back) for back in (1, 2, 3)], axis=0)
    assert found.cut_share == pytest.approx(float((thickness[:96_000] > 0.0).mean()), abs=1e-3)
    assert found.peak_thickness == pytest.approx(float(thickness.max()) / 0.1, abs=1e-3)
    edges = np.flatnonzero(np.diff((thickness > 0.0).astype(int)))
    chips = np.diff(every[edges])[0 if thickness[edges[0] + 1] > 0.0 else 1 :: 2]
    assert found.longest_chip_rev == pytest.approx(float(chips.max()) / 0.024, abs=1e-3)
    early = np.linspace(0.0, 0.1, 100_001)
    first = early[np.flatnonzero((at(early) - at(early - 0.024) <= 1e-12) & (early > 0.001))[0]]
    assert found.first_chip_rev == pytest.approx(float(first) / 0.024, abs=1e-3)
    assert found.peak_speed_mm_s == pytest.approx(0.2 / 0.008 + 0.1 / 0.024)
