"""The planner model: measured figures of LinuxCNC's simulated machine, the closed forms, and the refusals."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.ideal import Ideal
from chipbreak.trajectory.law import AxisLimits, ControlLaw
from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.trapezoid import Trapezoid
from strokes import feeds_for_times, reached, trace

STROKES_MM = (0.02, 0.05, 0.06, 0.11, 0.31)
FEEDS_MM_S = (2.0, 5.0, 10.0, 20.0, 50.0)
# Servo periods of 1 ms per stroke, measured on the simulated machine, the same in G61, G61.1 and G64:
# one table per acceleration, one row per length, one column per feed.
MEASURED_PERIODS = {
    2000.0: """
        11   7   7   7   7
        26  13  10  10  10
        31  15  11  11  11
        56  25  16  15  15
       156  65  36  26  25""",
    5000.0: """
        11   5   4   4   4
        26  11   7   7   7
        31  13   8   7   7
        56  23  13  10  10
       156  63  33  20  16""",
    20000.0: """
        11   5   3   2   2
        26  11   6   4   4
        31  13   7   4   4
        56  23  12   7   5
       156  63  32  17   9""",
}
# Vibrations per second of a triangle of 0.1 mm that moves on by 0.001 mm per block, in 4 ms blocks, measured:
# acceleration, blocks per stroke: G61 and G64, G61.1, G64 P0.005.
MEASURED_HZ = {
    (2000.0, 2): (31.25, 23.81, 33.33),
    (2000.0, 4): (22.73, 16.67, 25.64),
    (5000.0, 2): (35.71, 35.71, 45.45),
    (5000.0, 4): (23.81, 20.83, 27.78),
    (20000.0, 2): (38.46, 50.00, 55.56),
    (20000.0, 4): (23.81, 25.00, 29.41),
}


def linuxcnc(acceleration_mm_s2: float, **more: float | bool) -> LinuxCnc:
    return LinuxCnc(500.0, acceleration_mm_s2, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("acceleration", MEASURED_PERIODS)
@pytest.mark.parametrize("exact_stop", [False, True])
def test_single_strokes_take_the_measured_periods(acceleration: float, exact_stop: bool) -> None:
    model = linuxcnc(acceleration, every_block_stops=exact_stop)
    lengths = np.repeat(STROKES_MM, 2 * len(FEEDS_MM_S)) * np.tile([1, -1], len(STROKES_MM) * len(FEEDS_MM_S))
    feeds = np.tile(np.repeat(FEEDS_MM_S, 2), len(STROKES_MM))

    periods = np.rint(model.block_times(lengths, feeds) / 0.001).reshape(len(STROKES_MM), len(FEEDS_MM_S), 2)

    measured = np.array(MEASURED_PERIODS[acceleration].split(), dtype=float).reshape(periods.shape[:2])
    assert periods[:, :, 0].tolist() == measured.tolist()
    assert periods[:, :, 1].tolist() == measured.tolist()


@pytest.mark.parametrize(("acceleration", "blocks"), MEASURED_HZ)
def test_several_blocks_per_stroke_reach_the_measured_frequency(acceleration: float, blocks: int) -> None:
    count = np.arange(1, 20 * 2 * blocks + 1)
    wave = 0.1 * np.minimum(count % (2 * blocks), 2 * blocks - count % (2 * blocks)) / blocks
    lengths = np.diff((wave + 0.001 * count).round(4), prepend=0.0)
    feeds = (np.abs(lengths) / 0.004 * 60).round(2) / 60
    models = (
        linuxcnc(acceleration),
        linuxcnc(acceleration, every_block_stops=True),
        linuxcnc(acceleration, merge_mm=0.005),
    )

    found = []
    for model in models:
        whole = model.block_times(lengths, feeds).reshape(-1, 2 * blocks)[2:-2]
        found.append(reached(whole, len(whole), 1500.0)[0])

    assert found == pytest.approx(MEASURED_HZ[acceleration, blocks], abs=0.006)


@given(
    acceleration=st.sampled_from([500.0, 2000.0, 5000.0, 20000.0]),
    length=st.floats(0.01, 0.5),
    periods=st.integers(3, 120),
)
def test_the_feed_found_takes_the_periods_asked_for(acceleration: float, length: float, periods: int) -> None:
    model = linuxcnc(acceleration)
    fewest = next(
        k for k in range(2, 200) if acceleration * 1e-6 * (k * k - k % 2) / 4 >= length * (1 - 1e-9)
    )
    assert round(model.shortest_time(length) * 1000) in (fewest, fewest + 1)  # + 1: just on the edge
    if periods <= fewest:
        return
    feed = model.feed_for_time(length, periods * 1e-3)
    assert model.block_times([length], [feed])[0] == pytest.approx(periods * 1e-3, abs=1e-9)
    # The trapezoid of the same feed is at most two periods shorter, and never longer.
    assert 0 <= periods * 1e-3 - Trapezoid(500, acceleration).block_times([length], [feed])[0] <= 2e-3


def test_half_periods_are_made_up_for_by_the_next_stroke() -> None:
    model = linuxcnc(20000.0)
    lengths = np.tile([0.06, -0.05], 20)
    times = np.full(40, 0.0083)

    found = model.block_times(lengths, feeds_for_times(lengths, times, model))

    assert set(np.rint(found * 1000)) == {8.0, 9.0}
    assert np.abs(np.cumsum(found - times)).max() <= 0.0005 + 1e-9


def test_the_trace_ends_where_the_blocks_do_and_blunts_the_reversals() -> None:
    model = linuxcnc(20000.0)
    lengths, feeds = [0.06, -0.04, 0.02], [10.0, 10.0, 10.0]
    times, places = trace(lengths, feeds, model).T

    assert places[0] == 0.0
    assert places[-1] == pytest.approx(0.04)
    assert times[-1] == pytest.approx(model.block_times(lengths, feeds).sum() + 0.002)
    tip = 0.06 - places.max()
    assert 0.0001 < tip < 20000.0 * 0.001**2 / 6  # a third of the last step, which is a·T²/2 at most


def test_the_trapezoid_is_the_closed_form() -> None:
    model = Trapezoid(500.0, 2000.0)
    assert model.block_times([0.1, -0.1], [2.0, 400.0]) == pytest.approx([0.05 + 0.001, 2 * sqrt(0.1 / 2000)])
    assert model.feed_for_time(0.1, 0.0375) == pytest.approx(2.769, abs=5e-4)
    assert model.block_times([0.1], [model.feed_for_time(0.1, 0.0375)])[0] == pytest.approx(0.0375)


def test_the_trapezoid_runs_through_joints_and_stops_where_told() -> None:
    model = Trapezoid(500.0, 1000.0)
    whole = model.block_times([3.0], [20.0])[0]
    parts = model.block_times([1.0, 1.0, 1.0], 20.0)
    assert parts.sum() == pytest.approx(whole)
    assert parts[1] == pytest.approx(0.05)
    exact = Trapezoid(500.0, 1000.0, every_block_stops=True).block_times([1.0, 1.0], 20.0)
    assert exact == pytest.approx([0.07, 0.07])
    # A fast block behind a slow one starts at the slow one's speed, and the other way round.
    slow_fast = model.block_times([1.0, 1.0], [10.0, 20.0])
    assert slow_fast == pytest.approx([0.1 + 0.005, 0.01 + 0.02 + (1 - 0.15 - 0.2) / 20])
    assert model.block_times([1.0, 1.0], [20.0, 10.0]) == pytest.approx(slow_fast[::-1])


def test_a_control_that_waits_until_the_axis_is_in_position() -> None:
    model = Trapezoid(500.0, 2000.0, reversal_stop_s=0.005)
    lengths = [0.1, 0.1, -0.1]
    moving = Trapezoid(500.0, 2000.0).block_times(lengths, 5.0)
    assert model.block_times(lengths, 5.0) == pytest.approx(moving + np.array([0.0, 0.005, 0.005]))
    assert model.feed_for_time(0.1, 0.0425) == pytest.approx(2.769, abs=5e-4)
    assert model.block_times([0.1], [model.feed_for_time(0.1, 0.0425)]) == pytest.approx([0.0425])
    with pytest.raises(RefusalError) as refused:
        model.feed_for_time(0.1, 0.005)
    assert refused.value.code == "VIB030"


def test_ideal_and_the_limits_of_reading_and_speed() -> None:
    assert Ideal().block_times([1.0, -0.5], [10.0, 10.0]) == pytest.approx([0.1, 0.05])
    slow = Ideal(5.0, blocks_per_s=8.0)
    assert slow.block_times([1.0, -0.5], [10.0, 10.0]) == pytest.approx([0.2, 0.125])
    assert slow.shortest_time(0.1) == pytest.approx(0.125)
    assert reached([0.02, 0.02], 1, 2000.0) == pytest.approx((25.0, 0.75))


def test_the_axis_that_gives_up_first_sets_the_limits() -> None:
    axes = (AxisLimits("X", 100.0, 3000.0), AxisLimits("Z", 200.0, 5000.0))
    model = LinuxCnc().along((3.0, -4.0), axes)
    assert model.acceleration_mm_s2 == pytest.approx(3000 / 0.6)
    assert (model.velocity_mm_s, model.axis) == (pytest.approx(100 / 0.6), "X")
    straight = LinuxCnc().along((0.0, 2.0), axes)
    assert (straight.acceleration_mm_s2, straight.velocity_mm_s, straight.axis) == (5000.0, 200.0, "Z")


@pytest.mark.parametrize(
    ("model", "time", "code", "told"),
    [
        (Trapezoid(500, 3000, axis="Z"), 0.008, "VIB030", "needs 6.25 m/s2, Z has 3 m/s2"),
        (linuxcnc(3000.0), 0.008, "VIB030", "needs 6.25 m/s2, the axis has 3 m/s2"),
        (linuxcnc(3000.0), 0.009, "VIB030", "needs 5 m/s2, the axis has 3 m/s2"),
        (Trapezoid(10, 90000), 0.008, "VIB031", "the axis has 10 mm/s"),
        (Ideal(10), 0.008, "VIB031", "needs 12.5 mm/s for 0.1 mm in 8 ms"),
        (linuxcnc(20000.0, blocks_per_s=100.0), 0.008, "VIB032", "needs 125 blocks per second"),
    ],
)
def test_what_cannot_be_is_refused_with_the_numbers(
    model: ControlLaw, time: float, code: str, told: str
) -> None:
    with pytest.raises(RefusalError) as refused:
        model.feed_for_time(0.1, time)
    assert refused.value.code == code
    assert told in refused.value.message
    assert refused.value.help


def test_strokes_within_the_tolerance_are_refused() -> None:
    swallowing = linuxcnc(20000.0, merge_mm=0.04)
    with pytest.raises(RefusalError) as refused:
        swallowing.block_times([0.06, -0.04, 0.06], 10.0)
    assert refused.value.code == "VIB033"
    assert swallowing.block_times([0.06, -0.041, 0.06], 10.0)[0] == pytest.approx(0.007)
    assert swallowing.block_times([0.03], 10.0)[0] > 0  # a single short block has nothing to be merged with


def test_impossible_input_is_an_error_of_the_caller() -> None:
    for lengths, feeds in (([0.0], [1.0]), ([1.0], [0.0]), ([np.nan], [1.0])):
        with pytest.raises(ValueError, match="length"):
            linuxcnc(1000.0).block_times(lengths, feeds)
    with pytest.raises(ValueError, match="no feed"):
        linuxcnc(1000.0).feed_for_time(0.1, 0.0)
    with pytest.raises(ValueError, match="limits"):
        linuxcnc(0.0)
    with pytest.raises(ValueError, match="acceleration"):
        LinuxCnc().feed_for_time(0.1, 0.1)
