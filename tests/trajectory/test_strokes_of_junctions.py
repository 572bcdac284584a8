"""Strokes as a control with junction deviation gets them: times that are moved on, limits of each block."""

from __future__ import annotations

from math import inf, sqrt
from typing import Any

import numpy as np
import pytest

from chipbreak.trajectory.filters import _Later, _merged
from chipbreak.trajectory.junction import Junction, _least_in_time, _Strokes, _strokes_before
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import AxisLimits

AXES = (
    AxisLimits("X", 50.0, 400.0, step_mm=0.01),
    AxisLimits("Y", inf, inf),
    AxisLimits("Z", 100.0, 1000.0, step_mm=0.004),
)


def strokes(wanted_s: list[float], sizes: list[int] | None = None) -> _Strokes:
    """Strokes of so many blocks each, which should take these times."""
    counts = np.array(sizes or [1] * len(wanted_s))
    starts = np.cumsum(counts) - counts
    return _Strokes(starts, int(counts.sum()), np.array(wanted_s), np.zeros(len(counts), np.bool_))


def test_values_of_blocks_and_of_strokes() -> None:
    some = strokes([1.0, 1.0, 1.0], [2, 1, 3])
    values = np.array([1.0, 5.0, 3.0, 2.0, 7.0, 4.0, 99.0])
    assert some.sums(values).tolist() == [6.0, 3.0, 13.0]
    assert some.most(values).tolist() == [5.0, 3.0, 7.0]
    assert some.spread(np.array([1.0, 2.0, 3.0])).tolist() == [1.0, 1.0, 2.0, 3.0, 3.0, 3.0]
    assert [some.run(at) for at in range(3)] == [slice(0, 2), slice(2, 3), slice(3, 6)]


@pytest.mark.parametrize(
    ("wanted", "longest", "given"),
    [
        # What one cannot take the next one gets, and what that cannot the one behind it.
        ([5.0, 5.0, 5.0], [9.0, 9.0, 9.0], [5.0, 5.0, 5.0]),
        ([5.0, 5.0, 5.0], [3.0, 9.0, 9.0], [3.0, 7.0, 5.0]),
        ([5.0, 5.0, 5.0], [3.0, 4.0, 9.0], [3.0, 4.0, 8.0]),
        ([5.0, 5.0, 5.0], [9.0, 3.0, 9.0], [5.0, 3.0, 7.0]),
        ([5.0, 5.0, 5.0], [9.0, 9.0, 2.0], [5.0, 5.0, 2.0]),
        ([5.0, 5.0, 5.0, 5.0], [3.0, 9.0, 3.0, inf], [3.0, 7.0, 3.0, 7.0]),
        ([5.0, 5.0], [inf, inf], [5.0, 5.0]),
    ],
)
def test_what_a_stroke_cannot_take_the_next_one_gets(
    wanted: list[float], longest: list[float], given: list[float]
) -> None:
    assert strokes(wanted).at_most(np.array(longest)).wanted_s.tolist() == pytest.approx(given)


def test_the_longest_time_of_a_stroke_is_that_of_its_blocks() -> None:
    found = strokes([5.0, 5.0], [2, 1]).at_most(np.array([1.0, 2.5, inf]))
    assert found.wanted_s.tolist() == [3.5, 6.5]


@pytest.mark.parametrize(
    ("wanted_ms", "given_ms"),
    [
        (20.0, 20.005),
        (20.004, 20.005),
        (19.996, 20.005),
        (20.006, 20.006),
        (19.994, 19.994),
        (16.0, 16.0),
        (25.0, 25.0),
    ],
)
def test_no_stroke_of_one_block_ends_with_a_segment(wanted_ms: float, given_ms: float) -> None:
    found = strokes([wanted_ms / 1000.0] * 2, [1, 2]).off_segments(0.01)
    assert (found.wanted_s * 1000.0).tolist() == pytest.approx([given_ms, wanted_ms])
    assert strokes([0.02]).off_segments(0.0).wanted_s.tolist() == [0.02]


def blocks_of(lengths: list[float], corners: list[float] | None = None) -> Blocks:
    ways = np.array(lengths)
    return Blocks(
        ways,
        np.outer(ways, [0.0, 0.0, 1.0]),
        np.array(corners or [0.0] * len(ways)),
        np.full(len(ways), 1000.0),
    )


@pytest.mark.parametrize(
    ("last", "starts", "stop"), [(7, [0, 2, 4], 7), (6, [0, 2], 4), (4, [0, 2], 4), (3, [0], 2), (2, [0], 2)]
)
def test_the_strokes_before_a_block(last: int, starts: list[int], stop: int) -> None:
    spans = np.arange(1.0, 8.0)
    found = _strokes_before(blocks_of([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0]), spans, last)
    assert found is not None
    assert (found.starts.tolist(), found.stop) == (starts, stop)
    ends = [*starts[1:], stop]
    assert found.wanted_s.tolist() == [
        spans[first:end].sum() for first, end in zip(starts, ends, strict=True)
    ]
    assert _strokes_before(blocks_of([1.0, 1.0, -1.0]), spans[:3], 1) is None
    assert _strokes_before(blocks_of([1.0, 1.0, -1.0]), spans[:3], 0) is None


@pytest.mark.parametrize(
    ("corner", "bends"), [(0, [True, False]), (1, [False, False]), (2, [False, True]), (3, [False, False])]
)
def test_a_stroke_bends_where_a_corner_is_inside(corner: int, bends: list[bool]) -> None:
    corners = [0.0] * 4
    for turn, counts in ((0.11, True), (0.1, False)):
        corners[corner] = turn
        found = _strokes_before(blocks_of([1.0, 1.0, -1.0, -1.0], corners), np.ones(4), 4)
        assert found is not None and found.bends.tolist() == (bends if counts else [False, False])


def test_the_least_factors_in_time_are_found_by_halving() -> None:
    wanted = np.array([1.5, 3.0, 2.0])
    found = _least_in_time(np.ones(3), np.full(3, 4.0), lambda factors: wanted - factors)
    assert found.tolist() == pytest.approx(wanted.tolist(), rel=1e-8)
    assert (found >= wanted).all()


def plan(points: list[tuple[float, float]], **more: Any) -> Any:
    law = Junction(**more).along((0.0, 0.0, 1.0), AXES)
    moved = np.zeros((len(points) - 1, 3))
    moved[:, [0, 2]] = np.diff(np.array(points), axis=0)
    return law._plan_of(law.blocks(moved, np.ones(len(moved))))


def test_what_limits_each_block() -> None:
    """Along Z, along X, and 3 to 4: the axis that reaches its limit first, or the path."""
    points = [(0.0, 0.0), (0.0, 2.0), (3.0, 2.0), (6.0, 6.0)]
    found = plan(points)
    assert found.tops_mm_s.tolist() == pytest.approx([100.0, 50.0, 50.0 / 0.6])
    assert found.moves.accelerations_mm_s2.tolist() == pytest.approx([1000.0, 400.0, 400.0 / 0.6])
    assert found.moves.lengths_mm.tolist() == [2.0, 3.0, 5.0]
    assert found.moves.ways[2].tolist() == pytest.approx([0.6, 0.0, 0.8])
    path = plan(points, path_velocity_mm_s=60.0, path_acceleration_mm_s2=500.0)
    assert path.tops_mm_s.tolist() == pytest.approx([60.0, 50.0, 60.0])
    assert path.moves.accelerations_mm_s2.tolist() == pytest.approx([500.0, 400.0, 500.0])
    # Steps of 0.01 mm in X and 0.004 in Z: the axis that has most to make.
    assert found._steps.tolist() == pytest.approx([500.0, 300.0, 1000.0])
    slow = plan(points, least_steps_per_s=100.0, least_feed_mm_s=1.0)
    assert slow.longest_s.tolist() == pytest.approx([2.0, 3.0, 5.0])
    assert plan(points, least_steps_per_s=200.0, least_feed_mm_s=1.0).longest_s.tolist() == pytest.approx(
        [2.0, 1.5, 5.0]
    )
    assert plan(points, least_steps_per_s=200.0).longest_s.tolist() == pytest.approx([2.5, 1.5, 5.0])
    assert plan(points).longest_s.tolist() == [inf] * 3
    # No feed is below the least one, and no block is over before it is read.
    assert slow.spans_s(np.full(3, 0.01))[0] == pytest.approx(2.0)
    assert plan(points, blocks_per_s=2.0).spans_s(np.full(3, 100.0)).tolist()[0] == 0.5


def test_the_limits_of_a_path_and_its_name() -> None:
    law = Junction(path_velocity_mm_s=80.0, path_acceleration_mm_s2=999.0).along((0.0, 0.0, 1.0), AXES)
    assert (law.velocity_mm_s, law.acceleration_mm_s2, law.axis) == (80.0, 999.0, "the path")
    equal = Junction(path_velocity_mm_s=200.0, path_acceleration_mm_s2=1000.0).along((0.0, 0.0, 1.0), AXES)
    assert (equal.velocity_mm_s, equal.acceleration_mm_s2, equal.axis) == (100.0, 1000.0, "Z")
    assert law._acceleration_for(0.1, 0.01) == pytest.approx(4000.0)
    assert law._feed_for(0.1, 0.025) == pytest.approx((24.975 - sqrt(24.975**2 - 4.0 * 99.9)) / 2.0)
    # The square corner is meant with the acceleration of the path, or with that of the axes.
    assert (law._square_mm_s2, Junction(acceleration_mm_s2=7.0)._square_mm_s2) == (999.0, 7.0)


def test_rising_times_are_taken_once_each() -> None:
    row = _Later(np.array([0.0, 1.0, 2.0, 3.0]), 0.5, 0.25)
    assert row.before(1.75).tolist() == [0.75]
    assert row.before(1.76).tolist() == [1.75]
    assert row.before(2.0).tolist() == []
    assert row.before(inf).tolist() == [2.75, 3.75]
    assert row.before(inf).tolist() == []


def test_rows_of_times_are_merged_piece_by_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    time_s = np.arange(10.0)
    shifts = (0.0, 0.25, 3.5)
    every = sorted(at + shift for at in time_s.tolist() for shift in shifts)
    for at_once in (2, 3, 100):
        monkeypatch.setattr("chipbreak.trajectory.filters._KNOTS_AT_ONCE", at_once)
        pieces = list(_merged([_Later(time_s, shift) for shift in shifts], time_s))
        assert np.concatenate(pieces).tolist() == every
        assert len(pieces) == len(range(at_once, 10, at_once)) + 1
        for end, piece in zip(range(at_once, 10, at_once), pieces, strict=False):
            assert (piece < end).all()
