"""Lines and arcs as one path by arc length: closed forms, joints, chords, and arcs that cannot be."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chipbreak.kinematics.toolpath import Leg, path_of, split_at
from chipbreak.text.diagnostics import RefusalError

NAN = math.nan
coordinates = st.floats(-50.0, 50.0)
places = st.tuples(coordinates, coordinates, coordinates)


def refused(*legs: Leg) -> str:
    with pytest.raises(RefusalError) as caught:
        path_of(legs)
    assert caught.value.help
    return caught.value.code


@given(st.lists(places, min_size=2, max_size=6), st.floats(0.0, 1.0))
def test_a_polyline_is_its_own_arc_length(corners: list[tuple[float, float, float]], share: float) -> None:
    lengths = [math.dist(a, b) for a, b in itertools.pairwise(corners)]
    assume(sum(lengths) > 1e-3)
    path = path_of([Leg(a, b) for a, b in itertools.pairwise(corners)])
    assert path.length_mm == pytest.approx(sum(lengths))
    s = np.array([0.0, share * path.length_mm, path.length_mm])
    knots = path.points(s)
    assert knots[0] == pytest.approx(corners[0], abs=1e-8)
    assert knots[-1] == pytest.approx(corners[-1], abs=1e-8)
    assert math.dist(knots[0], knots[1]) <= s[1] + 1e-9, "no chord is longer than its path"
    assert np.linalg.norm(path.tangents(s), axis=1) == pytest.approx(np.ones(3))


@given(st.lists(places, min_size=2, max_size=6))
def test_a_polyline_ends_at_its_very_ends(corners: list[tuple[float, float, float]]) -> None:
    legs = [Leg(a, b) for a, b in itertools.pairwise(corners)]
    assume(all(math.dist(leg.start, leg.end) > 1e-3 for leg in legs))
    path = path_of(legs)
    first, last, before, beyond = path.points(np.array([0.0, path.length_mm, -1e-12, path.length_mm + 1e-12]))
    assert tuple(first) == tuple(before) == corners[0]
    assert tuple(last) == tuple(beyond) == corners[-1]


def test_an_arc_ends_where_its_block_says_though_that_is_beside_the_circle() -> None:
    end = (4.0, 4.004, -3.0)
    path = path_of([Leg((8.0, 0.0, 0.0), end, 1, "XY", (-4.0, 0.0, NAN))])
    assert tuple(path.points(np.array([path.length_mm]))[0]) == end
    assert math.dist(path.points(np.array([path.length_mm - 1e-6]))[0], end) > 0.003


@pytest.mark.few(50)
@given(
    radius=st.floats(0.5, 40.0),
    first=st.floats(-math.pi, math.pi),
    sweep=st.floats(0.05, 2 * math.pi - 0.05),
    turn=st.sampled_from([-1, 1]),
    plane=st.sampled_from(["XY", "ZX", "YZ"]),
    rise=st.floats(-5.0, 5.0),
)
def test_an_arc_is_a_circle(
    *, radius: float, first: float, sweep: float, turn: int, plane: str, rise: float
) -> None:
    a, b = {"XY": (0, 1), "ZX": (2, 0), "YZ": (1, 2)}[plane]
    start, end, offset = [0.0] * 3, [0.0] * 3, [0.0] * 3
    start[a], start[b] = radius * math.cos(first), radius * math.sin(first)
    last = first + turn * sweep
    end[a], end[b], end[3 - a - b] = radius * math.cos(last), radius * math.sin(last), rise
    offset[a], offset[b] = -start[a], -start[b]
    by_centre = path_of([Leg(tuple(start), tuple(end), turn, plane, tuple(offset))])
    assert by_centre.length_mm == pytest.approx(math.hypot(radius * sweep, rise), rel=1e-9)
    s = np.linspace(0.0, by_centre.length_mm, 50)
    knots = by_centre.points(s)
    assert np.hypot(knots[:, a], knots[:, b]) == pytest.approx(np.full(50, radius), rel=1e-9)
    assert knots[-1] == pytest.approx(end, abs=1e-9)
    tangents = by_centre.tangents(s[1:-1])
    slope = (by_centre.points(s[1:-1] + 1e-6) - by_centre.points(s[1:-1] - 1e-6)) / 2e-6
    assert tangents == pytest.approx(slope, abs=1e-5)

    # R reaches the same arc, negative for more than half a turn.
    assume(abs(sweep - math.pi) > 1e-3)
    r = math.copysign(radius, math.pi - sweep)
    by_radius = path_of([Leg(tuple(start), tuple(end), turn, plane, (NAN, NAN, NAN), r)])
    assert by_radius.points(s) == pytest.approx(knots, abs=1e-5 * radius)


@pytest.mark.parametrize("turn", [-1, 1])
def test_a_full_circle(turn: int) -> None:
    path = path_of([Leg((10.0, 0.0, 0.0), (10.0, 0.0, 0.0), turn, "ZX", (-4.0, NAN, NAN))])
    assert path.length_mm == pytest.approx(8 * math.pi)
    quarter = path.points(np.array([path.length_mm / 4]))[0]
    assert quarter == pytest.approx([6.0, 0.0, -4.0 * turn])


def test_a_radius_goes_before_a_centre() -> None:
    ends = (10.0, 0.0, 0.0), (12.0, 0.0, -2.0), 1, "ZX"
    by_both = path_of([Leg(*ends, (7.0, NAN, 1.0), 2.0)])
    by_radius = path_of([Leg(*ends, (NAN, NAN, NAN), 2.0)])
    assert by_both.length_mm == by_radius.length_mm == pytest.approx(math.pi)


def test_clockwise_in_the_turning_plane() -> None:
    """From Z to X is counter-clockwise: G3 from the face outwards goes round a convex corner."""
    path = path_of([Leg((10.0, 0.0, 0.0), (12.0, 0.0, -2.0), 1, "ZX", (NAN, NAN, NAN), 2.0)])
    middle = path.points(np.array([path.length_mm / 2]))[0]
    assert middle == pytest.approx([10.0 + 2 * math.sin(math.pi / 4), 0.0, -2.0 + 2 * math.cos(math.pi / 4)])


@given(st.floats(0.1, 200.0), st.floats(0.1, 6.2), st.floats(1e-4, 0.1))
def test_chords_stay_close(radius: float, sweep: float, chord: float) -> None:
    end = (radius * math.cos(sweep), radius * math.sin(sweep), 0.0)
    path = path_of([Leg((radius, 0.0, 0.0), end, 1, "XY", (-radius, 0.0, NAN))])
    s = np.concatenate(([0.0], path.breakpoints(chord), [path.length_mm]))
    middles = path.points(s)[:-1] / 2 + path.points(s)[1:] / 2
    away = radius - np.hypot(middles[:, 0], middles[:, 1])
    assert away.max() <= chord * 1.0001


@given(
    st.floats(0.1, 200.0), st.floats(0.5, 6.2), st.floats(1e-3, 0.1), st.floats(0.0, 0.4), st.floats(0.6, 1.0)
)
def test_a_move_is_cut_into_as_few_chords_as_stay_close(
    radius: float, sweep: float, chord: float, first: float, last: float
) -> None:
    assume(chord < radius / 10.0)
    end = (radius * math.cos(sweep), radius * math.sin(sweep), 0.0)
    path = path_of([Leg((radius, 0.0, 0.0), end, 1, "XY", (-radius, 0.0, NAN)), Leg(end, (0.0, 0.0, 50.0))])
    arc_mm = float(path.ends_mm[1])
    start_mm, end_mm = np.array([first, last]) * arc_mm
    for from_mm, to_mm in ((start_mm, end_mm), (end_mm, start_mm)):
        [pieces] = path.pieces(np.array([from_mm]), np.array([to_mm]), chord).tolist()
        for count, stays in ((pieces, True), (pieces - 1, False)):
            if count:
                away = radius * (1.0 - math.cos((end_mm - start_mm) / count / radius / 2.0))
                assert away <= chord * 1.001 if stays else away > chord * 0.9
    assert path.pieces(np.array([arc_mm]), np.array([arc_mm + 20.0]), chord).tolist() == [1], (
        "a line is one move"
    )


@pytest.mark.parametrize(
    ("leg", "code"),
    [
        pytest.param(Leg((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), "VIB023", id="no length"),
        pytest.param(Leg((0.0, 0.0, 0.0), (9.0, 0.0, 0.0), 1), "VIB022", id="neither centre nor radius"),
        pytest.param(
            Leg((0.0, 0.0, 0.0), (9.0, 0.0, 0.0), 1, radius_mm=4.0), "VIB022", id="radius too small"
        ),
        pytest.param(
            Leg((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1, radius_mm=4.0), "VIB022", id="full circle by radius"
        ),
        pytest.param(
            Leg((0.0, 0.0, 0.0), (9.0, 0.0, 0.0), 1, "XY", (4.0, 0.0, NAN)), "VIB022", id="end off the circle"
        ),
        pytest.param(
            Leg((0.0, 0.0, 0.0), (8.03, 0.0, 0.0), 1, "XY", (4.0, 0.0, NAN)), "VIB022", id="end just off"
        ),
        pytest.param(
            Leg((0.0, 0.0, 0.0), (9.0, 0.0, 0.0), 1, "XY", (0.0, 0.0, NAN)), "VIB022", id="centre at start"
        ),
    ],
)
def test_what_cannot_be(leg: Leg, code: str) -> None:
    assert refused(leg) == code


def test_a_radius_short_by_rounding_is_half_a_circle() -> None:
    path = path_of([Leg((0.0, 0.0, 0.0), (10.003, 0.0, 0.0), 1, "XY", (NAN, NAN, NAN), 5.001)])
    assert path.length_mm == pytest.approx(5.0015 * math.pi, rel=1e-3)


@pytest.mark.few(50)
@given(
    st.lists(st.floats(-1.0, 3.0), min_size=1, max_size=30),
    st.lists(st.floats(-5.0, 60.0), unique=True, max_size=15),
)
def test_splitting_adds_knots_and_keeps_the_motion(steps: list[float], cuts: list[float]) -> None:
    time_s = np.arange(len(steps) + 1, dtype=float)
    distance = np.concatenate(([0.0], np.cumsum(steps)))
    breakpoints = np.sort(np.array(cuts))
    new_time, new_distance = split_at(time_s, distance, breakpoints)
    assert np.interp(new_time, time_s, distance) == pytest.approx(new_distance, abs=1e-9)
    assert set(time_s) <= set(new_time)
    low = np.minimum(new_distance[:-1], new_distance[1:])
    high = np.maximum(new_distance[:-1], new_distance[1:])
    for at in breakpoints:
        assert not np.any((low + 1e-9 < at) & (at < high - 1e-9)), "a move runs across a breakpoint"


@pytest.mark.parametrize("length_mm", [1.0, 10.0, 12.0, 10.0 + math.pi, 18.0])
def test_the_beginning_of_a_path(length_mm: float) -> None:
    leg = Leg((10.0, 0.0, -10.0), (14.0, 0.0, -14.0), turn=1, plane="ZX", radius_mm=4.0)
    path = path_of([Leg((10.0, 0.0, 0.0), leg.start), leg, Leg(leg.end, (20.0, 0.0, -14.0))])
    beginning = path.beginning(length_mm)
    places = np.linspace(0.0, length_mm, 30)
    assert beginning.length_mm == length_mm
    assert np.abs(beginning.points(places) - path.points(places)).max() < 1e-12
    assert np.abs(beginning.tangents(places[:-1]) - path.tangents(places[:-1])).max() < 1e-12
