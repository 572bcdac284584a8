"""Measures of a tool against closed forms: every limit at it, just below and just above."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from chipbreak.inspection import edges
from macros import measures

Floats = NDArray[np.float64]
BALL_MM = 3.0
CONE_SLOPE = np.tan(np.radians(59.0))  # a drill of 118 degrees: radius per height


@pytest.mark.parametrize(("measured", "passes"), [(5.005, True), (5.0050001, False), (4.0, True)])
def test_runout_may_reach_its_limit(measured: float, passes: bool) -> None:
    assert measures.runout_passes(measured, 5.0) is passes


@pytest.mark.parametrize("radius", [0.1, 1.0, 3.0, 8.7, 12.7])
def test_runout_limit_in_binary_fractions(radius: float) -> None:
    """R + 0.005 typed as a decimal number is the limit itself, whatever the sum of floats is."""
    assert measures.runout_passes(float(f"{radius + 0.005:.6f}"), radius)
    assert not measures.runout_passes(float(f"{radius + 0.005001:.6f}"), radius)


@pytest.mark.parametrize(
    ("measured", "passes"),
    [(40.0, False), (40.000001, True), (43.0, True), (43.000001, False), (39.9, False)],
)
def test_length_is_strict_on_the_left_only(measured: float, passes: bool) -> None:
    assert measures.length_passes(measured, 40.0) is passes


@pytest.mark.parametrize(
    ("measured", "passes"),
    [([9.5], False), ([9.500001], True), ([10.499999], True), ([10.5], False), ([9.0, 9.8, 9.2], True)],
)
def test_diameter_is_strict_on_both_sides_and_the_largest_counts(measured: list[float], passes: bool) -> None:
    assert measures.diameter_passes(measured, 10.0) is passes


def test_stick_out_is_beam_less_contact_less_holder() -> None:
    assert measures.stick_out_mm(beam_mm=400.0, contact_mm=290.5, holder_mm=70.0) == pytest.approx(39.5)


def wall(heights: Floats) -> Floats:
    return np.column_stack((heights, np.full_like(heights, 6.0)))


def ball(heights: Floats) -> Floats:
    below = np.minimum(heights, BALL_MM)
    return np.column_stack((heights, np.sqrt(BALL_MM**2 - (BALL_MM - below) ** 2)))


def drill(heights: Floats) -> Floats:
    return np.column_stack((heights, np.minimum(heights * CONE_SLOPE, 4.0)))


def with_point(shape: Floats, height: float, radius: float) -> Floats:
    kept = shape[np.abs(shape[:, 0] - height) > 1e-6]
    merged = np.vstack((kept, [[height, radius]]))
    return merged[np.argsort(merged[:, 0])]


UNEVEN = np.sort(np.append(np.random.default_rng(7).uniform(0.0, 20.0, 300), [0.0, 20.0]))
EVEN = np.linspace(0.0, 20.0, 201)


@pytest.mark.parametrize("heights", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("depth", [0.02, 0.3, 5.9])
def test_a_chip_in_a_wall(heights: Floats, depth: float) -> None:
    stored = wall(heights)
    verdict = edges.judge_edge(stored, with_point(stored, 7.123, 6.0 - depth), 0.02)
    assert verdict.inward_mm == pytest.approx(depth, abs=1e-9)
    assert verdict.height_mm == 7.123
    assert verdict.is_chipped


@pytest.mark.parametrize("heights", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("angle_deg", [12.0, 45.0, 80.0])
@pytest.mark.parametrize("depth", [0.02, 0.3])
def test_a_chip_in_a_ball_is_measured_along_its_normal(
    heights: Floats, angle_deg: float, depth: float
) -> None:
    stored = ball(heights)
    angle = np.radians(angle_deg)
    height, radius = BALL_MM - (BALL_MM - depth) * np.cos(angle), (BALL_MM - depth) * np.sin(angle)
    verdict = edges.judge_edge(stored, with_point(stored, height, radius), 0.02)
    assert verdict.inward_mm == pytest.approx(depth, abs=1e-9)
    radial = ball(np.array([height]))[0, 1] - radius
    assert radial > verdict.inward_mm * 1.01  # the radial distance is another one, and larger
    assert verdict.is_chipped


@pytest.mark.parametrize("depth", [0.02, 0.3])
def test_a_chip_in_a_cone(depth: float) -> None:
    stored = drill(EVEN)
    normal = np.array([1.0, -1.0 / CONE_SLOPE]) / np.hypot(1.0, 1.0 / CONE_SLOPE) * depth
    height, radius = 1.234 + normal[0], 1.234 * CONE_SLOPE + normal[1]
    # From the cone to the wall the nearest place is on the cone.
    verdict = edges.judge_edge(stored, with_point(stored, height, radius), 0.02)
    assert verdict.inward_mm == pytest.approx(depth, abs=1e-9)


@pytest.mark.parametrize("limit", [0.02, 0.05])
@pytest.mark.parametrize(("less", "chipped"), [(0.0, True), (1e-6, False), (-1e-6, True)])
def test_exactly_w_is_chipped_and_a_millionth_less_is_not(limit: float, less: float, chipped: bool) -> None:
    depth = limit - less
    stored = wall(EVEN)
    assert edges.judge_edge(stored, with_point(stored, 9.0, 6.0 - depth), limit).is_chipped is chipped
    stored = ball(EVEN)
    at = BALL_MM - (BALL_MM - depth) * np.sqrt(0.5)
    traced = with_point(stored, at, (BALL_MM - depth) * np.sqrt(0.5))
    assert edges.judge_edge(stored, traced, limit).is_chipped is chipped


@pytest.mark.parametrize("shape", [wall, ball, drill])
def test_an_edge_that_has_not_changed_lies_on_itself(shape: object) -> None:
    assert callable(shape)
    inward = edges.inward_mm(shape(EVEN), shape(EVEN))
    assert np.abs(inward).max() < 1e-9


def test_other_heights_of_the_same_ball_lie_on_it_too() -> None:
    """The chord between two points stands up to 0.02 mm inward of the arc; a chord would show a chip."""
    inward = edges.inward_mm(ball(np.linspace(0.0, 3.0, 31)), ball(np.linspace(0.0, 3.0, 53)))
    assert np.abs(inward).max() < 1e-9


def test_beside_a_corner_no_arc_cuts_it() -> None:
    """Between cone and wall a circle through three points would bulge beyond the straight pieces."""
    corner = 4.0 / CONE_SLOPE
    heights = np.sort(np.append(EVEN, corner))
    finer = np.sort(np.append(np.linspace(0.0, 20.0, 777), corner))
    assert np.abs(edges.inward_mm(drill(heights), drill(finer))).max() < 1e-9


def test_a_tool_that_grew_is_not_chipped() -> None:
    stored = wall(EVEN)
    verdict = edges.judge_edge(stored, stored + np.array([0.0, 0.2]), 0.02)
    assert verdict.inward_mm == pytest.approx(-0.2)
    assert not verdict.is_chipped


@pytest.mark.parametrize("shape", [wall, ball, drill])
def test_a_missing_tool_is_chipped(shape: object) -> None:
    assert callable(shape)
    stored = shape(EVEN)
    traced = np.column_stack((EVEN, np.zeros_like(EVEN)))
    verdict = edges.judge_edge(stored, traced, 0.05)
    assert verdict.is_chipped
    assert verdict.inward_mm > 2.5


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("shape", [wall, ball, drill])
def test_noise_moves_the_distance_by_no_more_than_itself(shape: object, seed: int) -> None:
    assert callable(shape)
    noise = np.random.default_rng(seed)

    def traced(heights: Floats) -> Floats:
        points: Floats = shape(heights)
        points[:, 1] = np.maximum(0.0, points[:, 1] + noise.uniform(-0.002, 0.002, len(points)))
        return points

    stored, fresh = traced(EVEN), traced(UNEVEN)
    assert not edges.judge_edge(stored, fresh, 0.02).is_chipped
    at = int(np.searchsorted(fresh[:, 0], 11.0))
    fresh[at, 1] -= 0.03
    verdict = edges.judge_edge(stored, fresh, 0.02)
    assert verdict.is_chipped
    assert verdict.height_mm == fresh[at, 0]
    assert verdict.inward_mm == pytest.approx(0.03, abs=0.0041)


@pytest.mark.parametrize("angle_deg", [10.0, 20.0, 40.0])
def test_a_normal_may_meet_the_shape_below_its_first_height(angle_deg: float) -> None:
    """A trace that starts above the tip: the even wear of a ball must not look deeper at its first point."""
    heights = np.linspace(BALL_MM * (1.0 - np.cos(np.radians(angle_deg))), 20.0, 300)
    worn = heights[:200]
    inside = np.sqrt(np.maximum(0.0, (BALL_MM - 0.015) ** 2 - (BALL_MM - np.minimum(worn, BALL_MM)) ** 2))
    traced = np.vstack((np.column_stack((worn, inside)), ball(heights[200:])))
    verdict = edges.judge_edge(ball(heights), traced, 0.02)
    assert verdict.inward_mm == pytest.approx(0.015, abs=1e-6)


def test_what_is_beyond_the_stored_heights_is_not_compared() -> None:
    stored = wall(np.linspace(0.0, 10.0, 101))
    traced = np.vstack((wall(np.linspace(-1.0, 10.0, 111)), [[10.5, 0.0]]))
    inward = edges.inward_mm(stored, traced)
    assert np.isneginf(inward[[0, -1]]).all()
    assert not edges.judge_edge(stored, traced, 0.02).is_chipped


@pytest.mark.parametrize(
    ("traced", "reason"),
    [
        (wall(np.append(np.linspace(0.0, 5.0, 51), np.linspace(9.0, 20.0, 111))), "from height 5 to 9"),
        (wall(np.linspace(0.0, 12.0, 121)), "from height 12 to 20"),
        (wall(np.linspace(4.0, 20.0, 161)), "from height 0 to 4"),
        (wall(np.linspace(0.3, 20.0, 198)), "from height 0 to 0.3"),
        (wall(np.linspace(30.0, 40.0, 101)), "no point"),
        (wall(np.array([10.0])), "no point"),
        (wall(np.zeros(0)), "at least 1"),
        (wall(np.array([0.0, 1.0, 1.0])), "rise"),
        (wall(np.array([0.0, np.nan])), "numbers"),
    ],
)
def test_where_a_chip_could_hide_there_is_no_verdict(traced: Floats, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        edges.inward_mm(wall(EVEN), traced)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_few_points_are_a_shape_too(count: int) -> None:
    stored = wall(np.linspace(0.0, 2.0, count))
    assert edges.judge_edge(stored, stored - np.array([0.0, 0.03]), 0.02).inward_mm == pytest.approx(0.03)


def test_one_point_is_none() -> None:
    with pytest.raises(ValueError, match="at least 2"):
        edges.inward_mm(wall(np.array([1.0])), wall(np.array([1.0])))


def test_the_limit_line_stands_w_inside() -> None:
    line = edges.limit_line(ball(EVEN), 0.05)
    below = line[line[:, 0] < BALL_MM - 0.15]
    assert len(below) > 100
    centre_to_line = np.hypot(BALL_MM - below[:, 0], below[:, 1])
    assert centre_to_line == pytest.approx(BALL_MM - 0.05, abs=1e-4)
    assert line[line[:, 0] > BALL_MM + 0.2, 1] == pytest.approx(BALL_MM - 0.05, abs=1e-9)


def test_in_an_inner_corner_the_limit_line_has_no_loop() -> None:
    heights = np.linspace(0.0, 4.0, 41)
    stepped = np.column_stack((heights, np.where(heights < 2.0, 5.0, 4.0)))
    line = edges.limit_line(stepped, 0.3)
    curve = edges._Curve(stepped)
    assert curve.nearest(line).min() > 0.3 - 1e-5


def test_a_long_trace_is_judged_in_blocks() -> None:
    heights = np.linspace(0.0, 20.0, 1501)
    stored = wall(heights)
    traced = stored.copy()
    traced[1499, 1] -= 0.021
    assert edges.judge_edge(stored, traced, 0.02).height_mm == heights[1499]
