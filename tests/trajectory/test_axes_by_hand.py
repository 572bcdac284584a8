"""What axes make of a motion, and strokes that rest on the way: function by function, by closed forms."""

from __future__ import annotations

import math
from math import inf, pi, sqrt

import numpy as np
import pytest

from chipbreak.trajectory.feed_search import Stretch
from chipbreak.trajectory.filters import (
    NO_FILTER,
    STILL_MM,
    AxisFilter,
    _in_pieces,
    _lagging,
    _sharp_bends,
    _soon_after,
    _until,
    axis_filter,
    filtered,
    times_to_look_at,
)
from chipbreak.trajectory.junctions import Blocks, Parts
from chipbreak.trajectory.law import AxisLimits
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.real_motion import _is_straight, _on_a_line, _Polyline, _resting, _step_s, followed
from chipbreak.trajectory.resting import _several, _strokes
from chipbreak.trajectory.trapezoid import Trapezoid

# --- filters ----------------------------------------------------------------------------------------------


def test_what_a_filter_says_of_itself() -> None:
    both = AxisFilter((0.02, 0.01), (0.03, 0.004))
    assert both.delay_s == pytest.approx(0.015 + 0.034)
    assert both.settling_s == pytest.approx(0.03 + 7.0 * 0.034)
    assert both.rest_s == pytest.approx(0.03 + 18.0 * 0.034)
    assert both.shifts_s == pytest.approx((0.0, 0.02, 0.01, 0.03))
    assert both.slower(0.5) == AxisFilter(pytest.approx((0.03, 0.015)), pytest.approx((0.045, 0.006)))  # type: ignore[arg-type]
    assert (NO_FILTER.delay_s, NO_FILTER.settling_s, NO_FILTER.rest_s, NO_FILTER.shifts_s) == (
        0.0,
        0.0,
        0.0,
        (0.0,),
    )
    # Behind by v (T1 + T2) at most, twice for two lags, of which half a step is left after a while.
    assert both.late_s(10.0) == pytest.approx(0.03 + 0.034 * math.log(10.0 * 0.034 * 2.0 / STILL_MM))
    one = AxisFilter((), (0.02,))
    assert one.late_s(STILL_MM / 0.02 * 1.0001) == pytest.approx(0.0, abs=1e-5)
    assert (one.late_s(STILL_MM / 0.02 * 0.999), AxisFilter((0.02,), ()).late_s(1e9)) == (0.0, 0.02)


@pytest.mark.parametrize(
    ("given", "found"),
    [
        (("linear", 0.016, None, None, 0.0), AxisFilter((0.016,), ())),
        (("bell", 0.016, 0.008, None, 0.0), AxisFilter((0.016, 0.008), ())),
        (("exponential", 0.016, 0.008, None, 0.0), AxisFilter((0.008,), (0.016,))),
        (("exponential", 0.016, None, 50.0, 0.5), AxisFilter((), (0.016, 0.01))),
        (("linear", None, None, 50.0, 0.0), AxisFilter((), (0.02,))),
        (("linear", None, None, 50.0, 1.0), NO_FILTER),
        (("exponential", None, None, None, 0.0), NO_FILTER),
    ],
)
def test_filters_from_the_numbers_of_a_profile(
    given: tuple[str, float | None, float | None, float | None, float], found: AxisFilter
) -> None:
    assert axis_filter(*given) == found


def test_an_average_of_a_move_at_an_even_speed() -> None:
    """From rest at 5 mm/s for a second behind 0.2 s: v t² / 2 T, then half of T behind, then it comes in."""
    time_s, place = np.array([0.0, 1.0]), np.array([2.0, 7.0])
    at_s = np.array([0.0, 0.1, 0.2, 0.6, 1.0, 1.1, 1.2, 1.5])
    found = filtered(time_s, place, AxisFilter((0.2,), ()), at_s)
    wanted = [2.0, 2.0 + 5.0 * 0.01 / 0.4, 2.5, 4.5, 6.5, 7.0 - 5.0 * 0.01 / 0.4, 7.0, 7.0]
    assert found.tolist() == pytest.approx(wanted)
    # Two in a row: the cube while the first one fills, then behind by half of both.
    twice = filtered(
        time_s, place, AxisFilter((0.2, 0.1), ()), np.array([0.0, 0.05, 0.3, 0.7, 1.0, 1.25, 1.3])
    )
    early = 2.0 + 5.0 * 0.05**3 / (6.0 * 0.2 * 0.1)
    assert twice.tolist() == pytest.approx(
        [2.0, early, 2.0 + 0.15 * 5.0, 4.75, 6.25, 7.0 - (early - 2.0), 7.0]
    )


def test_a_lag_of_a_move_at_an_even_speed() -> None:
    """Behind by v T (1 - exp(-t / T))."""
    at_s = np.linspace(0.0, 1.0, 41)
    lag = _lagging(at_s, 2.0 + 5.0 * at_s, 0.07)
    assert lag.tolist() == pytest.approx(
        (2.0 + 5.0 * at_s - 5.0 * 0.07 * (1.0 - np.exp(-at_s / 0.07))).tolist()
    )
    behind = _lagging(at_s, np.full(41, 3.0), 0.07, -0.4)
    assert behind.tolist() == pytest.approx((3.0 - 0.4 * np.exp(-at_s / 0.07)).tolist())
    assert _lagging(np.array([0.0]), np.array([3.0]), 0.07, -0.4).tolist() == [2.6]
    # So long a step that nothing is left.
    assert _lagging(np.array([0.0, 9.0]), np.array([3.0, 3.0]), 0.07, -0.4)[1] == pytest.approx(3.0)


def test_times_in_pieces() -> None:
    times = _in_pieces(np.array([0.0, 1.0, 1.0 + 1e-10, 1.5, 3.5]), 1.0)
    assert times.tolist() == pytest.approx([0.0, 1.0 + 1e-10, 1.5, 2.5])
    assert _in_pieces(np.array([0.0, 1.0]), 0.3).tolist() == pytest.approx([0.0, 0.25, 0.5, 0.75])
    assert _in_pieces(np.array([0.0, 0.9]), 0.3).tolist() == pytest.approx([0.0, 0.3, 0.6])


@pytest.mark.parametrize(
    ("pieces", "end", "wanted"),
    [
        ([[0.0, 1.0], [2.0, 3.0]], 2.5, [[0.0, 1.0], [1.0, 2.0, 2.5]]),
        ([[0.0, 1.0], [2.0, 3.0]], 3.0, [[0.0, 1.0], [1.0, 2.0, 3.0]]),
        ([[0.0, 1.0], [2.0, 3.0]], 3.0 + 5e-10, [[0.0, 1.0], [1.0, 2.0, 3.0 + 5e-10]]),
        ([[0.0, 1.0], [2.0, 3.0]], 4.0, [[0.0, 1.0], [1.0, 2.0, 3.0], [3.0, 4.0]]),
        ([[0.0, 1.0], [2.0, 3.0], [4.0]], 0.5, [[0.0, 0.5]]),
    ],
)
def test_times_until_an_end(pieces: list[list[float]], end: float, wanted: list[list[float]]) -> None:
    found = [piece.tolist() for piece in _until(map(np.array, pieces), end)]
    assert found == wanted


def test_sharp_bends_are_those_of_a_quarter_of_the_largest() -> None:
    """Speeds of 0, 4, 3, 1, 0.9, 0: changes of 4, 1, 2, 0.1, 0.9."""
    time_s = np.arange(5.0)
    place = np.array([0.0, 4.0, 7.0, 8.0, 8.9])
    assert _sharp_bends(time_s, place).tolist() == [0.0, 1.0, 2.0]
    assert _sharp_bends(time_s, place * np.array([1, 1, 1, 1, 1.02]))[-1] == 4.0


def test_soon_after_a_sharp_bend() -> None:
    """Ladders where a filter is over in fewer than eight steps, as dense as there is room for."""
    axis = AxisFilter((0.007,), (0.007,))
    found = _soon_after(axis, 0.001, 1.0)
    assert found[:15] == pytest.approx([-0.014 * math.log(1.0 - k / 16.0) for k in range(1, 16)])
    assert found[15:] == pytest.approx([0.007 * k / 8.0 for k in range(1, 8)])
    assert _soon_after(axis, 0.00087, 1.0) == [] and len(_soon_after(axis, 0.00088, 1.0)) == 22
    assert len(_soon_after(axis, 0.001, 0.5)) == 7 + 3
    assert len(_soon_after(axis, 0.001, 0.6)) == 8 + 3
    assert len(_soon_after(axis, 0.001, 0.01)) == 3 + 3
    assert len(_soon_after(axis, 0.001, 9.0)) == 22


def test_times_to_look_at_are_knots_bends_and_steps_until_the_axes_rest() -> None:
    axis = AxisFilter((0.5,), ())
    found = times_to_look_at(np.array([0.0, 1.0]), np.array([0.0, 5.0]), [axis], 0.4)
    every = sorted(
        {0.0, 1.0, 0.5, 1.5, *(0.5 * k / 8 + at for k in range(1, 8) for at in (0.0, 0.5, 1.0, 1.5))}
    )
    wanted = [at for at in every if at < 1.5]
    assert found[0] == 0.0 and found[-1] == 1.5
    assert all(np.abs(found - at).min() < 1e-9 for at in wanted)
    assert np.diff(found).max() <= 0.4 + 1e-9 and (np.diff(found) > 0.0).all()
    few = times_to_look_at(np.array([0.0, 1.0]), np.array([0.0, 5.0]), [axis], 0.4, most=1.0)
    assert len(few) < len(found)


# --- the motion of the machine ----------------------------------------------------------------------------


def straight(moved: list[tuple[float, float, float]]) -> Blocks:
    every = np.array(moved)
    sizes = np.sqrt((every**2).sum(axis=1))
    return Blocks(sizes, every, np.zeros(len(every)), np.full(len(every), inf))


def even(length: float, speed: float) -> Motion:
    """One move at an even speed."""
    took = length / speed
    return Motion(np.array([took]), np.array([0.0, took]), np.array([0.0, length]))


@pytest.mark.parametrize(
    ("points", "is_straight"),
    [
        ([(0.0, 0.0, 0.0), (3.0, 0.0019, 4.0), (6.0, 0.0, 8.0)], True),
        ([(0.0, 0.0, 0.0), (3.0, 0.0021, 4.0), (6.0, 0.0, 8.0)], False),
        ([(1.0, 1.0, 1.0), (2.0, 2.0, 2.0), (-5.0, -5.0, -5.0)], True),
        ([(1.0, 1.0, 1.0)], True),
        ([(0.0, 0.0, 0.0), (0.0, 0.0, 5.0), (0.0, 0.003, 2.0)], False),
    ],
)
def test_which_points_lie_on_a_line(points: list[tuple[float, float, float]], is_straight: bool) -> None:
    assert _is_straight(np.array(points)) is is_straight


def test_how_dense_a_motion_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    axis = AxisFilter((0.012,), (0.02,))
    swings = Motion(
        np.ones(1), np.arange(9.0) * 0.016, np.array([0.0, 1.0, 0.5, 1.5, 1.0, 2.0, 1.5, 2.5, 2.0])
    )
    assert _step_s(swings, [axis]) == pytest.approx(0.016 / 32.0)
    # A stand is no turn; two turns are too few to tell a stroke by.
    rests = swings._replace(distance_mm=np.array([0.0, 1.0, 1.0, 0.5, 0.5, 1.5, 1.5, 2.5, 2.5]))
    assert _step_s(rests, [axis]) == pytest.approx(8.0 * 0.02 / 32.0)
    assert _step_s(even(1.0, 5.0), [AxisFilter((0.012,), ()), AxisFilter((), (0.004,))]) == pytest.approx(
        0.003
    )
    monkeypatch.setattr("chipbreak.trajectory.real_motion._MOST_TIMES", 10)
    assert _step_s(swings, [axis]) == pytest.approx(0.128 / 10.0)


def test_near_enough_to_its_rest_an_axis_rests() -> None:
    motion = Motion(np.ones(1), np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 5.0, 5.0, 9.0]))
    at_s = np.array([0.5, 1.0, 1.5, 1.9, 2.0, 3.0])
    along = np.array([2.0, 4.9994, 5.0005, 4.9996, 4.9999, 8.9999])
    assert _resting(motion, at_s, along).tolist() == [2.0, 4.9994, 5.0, 5.0, 4.9999, 8.9999]
    # The last knot is the end of what comes before it.
    still = motion._replace(distance_mm=np.array([0.0, 5.0, 9.0, 9.0]))
    assert _resting(still, np.array([2.5, 3.0, 3.5]), np.array([8.9996, 8.9996, 8.9996])).tolist() == [
        9.0,
        9.0,
        9.0,
    ]


def test_axes_without_filters_do_what_they_are_told() -> None:
    motion = even(5.0, 5.0)
    blocks = straight([(3.0, 0.0, 4.0)])
    for filters in ([NO_FILTER] * 3, [NO_FILTER, AxisFilter((1.0,), ()), NO_FILTER], []):
        assert followed(motion, np.array([0.0, 5.0]), blocks, filters) is motion


def test_axes_of_one_filter_are_behind_along_the_path() -> None:
    axis = AxisFilter((0.2,), ())
    real = followed(
        even(5.0, 5.0), np.array([0.0, 5.0]), straight([(3.0, 0.0, 4.0)]), [axis, NO_FILTER, axis]
    )
    assert np.interp([0.6, 0.9], real.time_s, real.distance_mm).tolist() == pytest.approx([2.5, 4.0])
    assert (real.delay_s, real.settling_s, real.path_error_mm) == pytest.approx((0.1, 0.2, 0.0))
    assert real.look_s == pytest.approx(8.0 * 0.2 / 32.0)
    assert (real.time_s[-1], real.distance_mm[-1]) == pytest.approx((1.2, 5.0))
    assert real.spans_s.tolist() == [1.0]


@pytest.mark.parametrize("way", [(3.0, 0.0, 4.0), (4.0, 0.0, -3.0), (5.0, 0.0, 0.0)])
def test_axes_of_unlike_filters_leave_a_line(way: tuple[float, float, float]) -> None:
    """X is 0.1 s behind and Z 0.02 s: along the line by squares of shares, beside it by the product."""
    filters = [AxisFilter((0.2,), ()), NO_FILTER, AxisFilter((0.04,), ())]
    real = followed(even(5.0, 5.0), np.array([0.0, 5.0]), straight([way]), filters)
    x, z = way[0] / 5.0, way[2] / 5.0
    behind = 5.0 * (x * x * 0.1 + z * z * 0.02)
    assert np.interp(0.6, real.time_s, real.distance_mm) == pytest.approx(3.0 - behind, abs=1e-9)
    assert real.path_error_mm == pytest.approx(abs(x * z) * 5.0 * 0.08, abs=1e-9)
    assert real.delay_s == pytest.approx(0.1)
    if z:
        own = filters[::2]
        _, off = _on_a_line(
            even(5.0, 5.0), np.array([[0.0, 0.0, 0.0], way]), [0, 2], own, np.array([0.0, 0.6])
        )
        assert off == pytest.approx(abs(x * z) * 5.0 * 0.08)


def test_round_a_corner_the_tool_leaves_the_path_by_what_the_average_cuts_off() -> None:
    """At v round a right angle an average of T leaves each axis v T / 8 short where both have half of it."""
    axis = AxisFilter((0.2,), ())
    motion = Motion(np.array([1.0, 1.0]), np.array([0.0, 1.0, 2.0]), np.array([0.0, 5.0, 10.0]))
    blocks = straight([(5.0, 0.0, 0.0), (0.0, 0.0, 5.0)])
    real = followed(motion, np.array([0.0, 5.0, 10.0]), blocks, [axis, NO_FILTER, axis])
    # In the middle of the average, at 1.1 s, both axes are off by 5 x 0.2 / 8; beside a leg by that of one.
    assert real.path_error_mm == pytest.approx(5.0 * 0.2 / 8.0, rel=0.02)
    assert np.interp([0.7, 1.7], real.time_s, real.distance_mm).tolist() == pytest.approx(
        [3.0, 8.0], abs=1e-6
    )


def test_places_on_a_polyline() -> None:
    """3 mm along X and 4 along Z, one of whose places is there twice; the path is longer than its chords."""
    path = _Polyline(
        np.array([0.0, 3.0, 3.0, 8.0]), np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.0], [3.0, 4.0]])
    )
    spot = path.at(np.array([1.5, 3.0, 5.5, 8.0]))
    assert [column.tolist() for column in spot.points_mm] == [
        pytest.approx([1.5, 3.0, 3.0, 3.0]),
        pytest.approx([0.0, 0.0, 2.0, 4.0]),
    ]
    assert [column.tolist() for column in spot.ways] == [
        pytest.approx([1.0, 0.0, 0.0, 0.0]),
        pytest.approx([0.0, 1.0, 1.0, 1.0]),
    ]
    assert path.within(np.array([-1.0, 4.0, 9.0])).tolist() == [0.0, 4.0, 8.0]
    assert spot.along_mm.tolist() == [1.5, 3.0, 5.5, 8.0]
    still = _Polyline(np.array([0.0, 1.0, 1.5]), np.array([[0.0], [2.0], [2.0]]))
    assert [column.tolist() for column in still.at(np.array([0.5, 1.2])).ways] == [[1.0, 0.0]]


# --- strokes that rest on the way -------------------------------------------------------------------------


def blocks_of_x_and_z(law: Trapezoid, points: list[tuple[float, float]], signs: list[float]) -> Blocks:
    moved = np.zeros((len(points) - 1, 3))
    moved[:, [0, 2]] = np.diff(np.array(points), axis=0)
    return law.blocks(moved, np.array(signs))


AXES = (AxisLimits("X", 100.0, 400.0), AxisLimits("Y", inf, inf), AxisLimits("Z", 100.0, 1000.0))


def test_a_stroke_round_a_corner_rests_there_and_shares_its_time() -> None:
    """0.3 mm along Z at 1000 mm/s2 and 0.1 mm along X at 400: the least of each, and the rest by length."""
    law = Trapezoid().along((0.0, 0.0, 1.0), AXES)
    blocks = blocks_of_x_and_z(law, [(0.0, 0.0), (0.0, 0.3), (0.1, 0.3), (0.0, 0.3)], [1.0, 1.0, -1.0])
    spans = np.array([0.05, 0.05, 0.06])
    feeds = law.feeds_for_spans(blocks, spans, 3)
    motion = law.motion_between_dwells(np.array([0.0, 0.3, 0.4, 0.3]), blocks, feeds)
    least = [2.0 * sqrt(0.3 / 1000.0), 2.0 * sqrt(0.1 / 400.0)]
    spare = 0.1 - sum(least)
    wanted = [least[0] + spare * 0.75, least[1] + spare * 0.25, 0.06]
    assert motion.spans_s.tolist() == pytest.approx(wanted, rel=1e-6)
    assert law.corner_shares(blocks, feeds).tolist() == pytest.approx([10.0, 20.0, 0.0])
    # What it lacks makes the next one late, by what is more than a period.
    quick = law.feeds_for_spans(blocks, np.array([0.02, 0.02, 0.06]), 3)
    late = law.motion_between_dwells(np.array([0.0, 0.3, 0.4, 0.3]), blocks, quick)
    assert late.spans_s[:2].tolist() == pytest.approx(least, rel=1e-6)
    assert late.spans_s.sum() == pytest.approx(0.1 + (sum(least) - 0.04 - 0.001), rel=1e-6)


def test_a_corner_of_less_than_a_tenth_is_run_through() -> None:
    law = Trapezoid().along((0.0, 0.0, 1.0), AXES)
    for turn, rests in ((0.099, False), (0.101, True)):
        end = (0.3 * math.sin(turn), 0.3 + 0.3 * math.cos(turn))
        blocks = blocks_of_x_and_z(law, [(0.0, 0.0), (0.0, 0.3), end], [1.0, 1.0])
        motion = law.motion_between_dwells(np.array([0.0, 0.3, 0.6]), blocks, np.full(2, 5.0))
        through = 0.3 / 5.0 + 5.0 / 1000.0 / 2.0
        assert bool(motion.spans_s[0] > through + 1e-6) is rests
    stops = Trapezoid(every_block_stops=True).along((0.0, 0.0, 1.0), AXES)
    assert stops.corner_shares(blocks, np.ones(2)).tolist() == [1.0, 1.0]
    assert stops.motion_between_dwells(np.array([0.0, 0.3, 0.6]), blocks, np.full(2, 5.0)).spans_s[
        0
    ] == pytest.approx(0.3 / 5.0 + 5.0 / 1000.0)


def test_first_and_last_parts_of_strokes_and_when_they_should_end() -> None:
    parts = Parts(np.array([0, 2, 3, 5]), np.array([2, 3, 5, 6]), np.array([0, 0, 1, 2]))
    spans = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
    assert list(_strokes(parts, spans)) == [
        (0, 2, pytest.approx(0.6)),
        (2, 3, pytest.approx(1.5)),
        (3, 4, pytest.approx(2.1)),
    ]
    nothing = np.empty(0, np.intp)
    assert list(_strokes(Parts(nothing, nothing, nothing), spans)) == []


def test_parts_of_several_blocks_as_stretches() -> None:
    parts = Parts(np.array([0, 1, 3]), np.array([1, 3, 6]), np.array([0, 1, 2]))
    ways, feeds = np.arange(1.0, 7.0), np.arange(11.0, 17.0)
    found = _several(parts, ways, feeds, np.array([0.1, 0.2, 0.3]), np.array([9.0, 8.0, 7.0]))
    assert found == [
        (slice(1, 3), Stretch((2.0, 3.0), (12.0, 13.0), 0.2, 8.0)),
        (slice(3, 6), Stretch((4.0, 5.0, 6.0), (14.0, 15.0, 16.0), 0.3, 7.0)),
    ]
    assert (
        _several(Parts(np.array([0]), np.array([1]), np.array([0])), ways, feeds, np.ones(1), np.ones(1))
        == []
    )


def test_several_blocks_of_a_stroke_take_its_time_together() -> None:
    """A round wave of four blocks a stroke, each stroke 20 ms; the last one keeps its feed."""
    law = Trapezoid(servo_period_s=1e-4).along((0.0, 0.0, 1.0), AXES)
    wave = 0.03 * (1.0 - np.cos(np.linspace(0.0, pi, 5)))
    lengths = np.concatenate([np.diff(wave), -np.diff(wave) * 0.8, np.diff(wave)])
    moved = np.zeros((12, 3))
    moved[:, 2] = lengths
    blocks = law.blocks(moved, lengths)
    feeds = law.feeds_for_spans(blocks, np.full(12, 0.006), 8)
    assert feeds[8:].tolist() == pytest.approx((np.abs(lengths[8:]) / 0.006).tolist())
    took = law.block_times(lengths, feeds)
    assert took[:4].sum() == pytest.approx(0.024, rel=0.0021)
    assert took[:8].sum() == pytest.approx(0.048, rel=0.0021)
    # One factor on all feeds of a stroke.
    nominal = np.abs(lengths) / 0.006
    assert np.ptp(feeds[:4] / nominal[:4]) == pytest.approx(0.0, abs=1e-6)
    assert np.ptp(feeds[4:8] / nominal[4:8]) == pytest.approx(0.0, abs=1e-6)
    assert (feeds[:4] / nominal[:4])[0] > 1.01
