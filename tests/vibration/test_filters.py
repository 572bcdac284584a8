"""What filters of an axis leave of a motion, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from chipbreak.trajectory.filters import AxisFilter, axis_filter, filtered, times_to_look_at

Floats = NDArray[np.float64]


def swings(period_s: float, count: int = 60) -> tuple[Floats, Floats]:
    """The knots of a symmetric triangle of stroke 1."""
    knots = np.arange(2 * count + 1)
    return knots * period_s / 2.0, (knots % 2).astype(np.float64)


def left_of(axis: AxisFilter, period_s: float) -> float:
    """The stroke that is left where the motion has become steady."""
    time_s, place_mm = swings(period_s)
    at_s = times_to_look_at(time_s, place_mm, [axis], period_s / 64.0)
    real = filtered(time_s, place_mm, axis, at_s)
    return float(np.ptp(real[(at_s > 40.0 * period_s) & (at_s < 60.0 * period_s)]))


@pytest.mark.parametrize("average_ms", [1.0, 4.0, 8.0])
def test_a_moving_average_leaves_one_minus_its_share_of_the_period(average_ms: float) -> None:
    left = left_of(axis_filter("linear", average_ms / 1000.0, None, None, 0.0), 0.016)
    assert left == pytest.approx(1.0 - average_ms / 16.0, abs=1e-9)


@pytest.mark.parametrize(
    ("gain_1_s", "frequency_hz", "share"),
    [(50.0, 62.5, 0.0993), (300.0, 62.5, 0.4947), (50.0, 25.0, 0.2402), (1000.0, 10.0, 0.9723)],
)
def test_a_lag_leaves_what_its_closed_form_says(gain_1_s: float, frequency_hz: float, share: float) -> None:
    """1 - (4 T / Tp) ln(2 / (1 + exp(-Tp / 2 T))), as acc/dec of that time and as a position loop."""
    lag_s, period_s = 1.0 / gain_1_s, 1.0 / frequency_hz
    exact = 1.0 - 4.0 * lag_s / period_s * np.log(2.0 / (1.0 + np.exp(-period_s / 2.0 / lag_s)))
    assert exact == pytest.approx(share, abs=1e-4)
    loop = axis_filter("linear", None, None, gain_1_s, 0.0)
    acc_dec = axis_filter("exponential", lag_s, None, None, 0.0)
    half = axis_filter("linear", None, None, gain_1_s / 2.0, 0.5)
    for axis in (loop, acc_dec, half):
        assert left_of(axis, period_s) == pytest.approx(exact, rel=1e-3)


def test_whole_feed_forward_leaves_everything() -> None:
    assert axis_filter("linear", 0.0, None, 50.0, 1.0) == AxisFilter()


def test_a_bell_is_two_moving_averages_one_after_the_other() -> None:
    """The second one as the mean of very many shifted copies of what the first one leaves."""
    time_s, place_mm = swings(0.040, 12)
    at_s = np.linspace(0.0, 0.5, 2001)
    bell = filtered(time_s, place_mm, axis_filter("bell", 0.012, 0.007, None, 0.0), at_s)
    fine_s = np.linspace(-0.1, 0.6, 140_001)
    once = filtered(time_s, place_mm, axis_filter("linear", 0.012, None, None, 0.0), fine_s)
    shifts = (np.arange(700) + 0.5) / 700 * 0.007
    twice = np.mean([np.interp(at_s - shift, fine_s, once) for shift in shifts], axis=0)
    assert bell == pytest.approx(twice, abs=1e-5)


@pytest.mark.parametrize(
    ("axis", "delay_s"),
    [
        (AxisFilter((0.016,)), 0.008),
        (AxisFilter((0.016, 0.010)), 0.013),
        (AxisFilter((), (0.032,)), 0.032),
        (AxisFilter((0.016,), (0.020,)), 0.028),
    ],
)
def test_the_end_is_late_by_half_an_average_and_a_whole_lag(axis: AxisFilter, delay_s: float) -> None:
    """At an even speed the axis is behind by that time, and then it still comes to the end."""
    time_s = np.array([0.0, 1.0])
    place_mm = np.array([0.0, 50.0])
    at_s = times_to_look_at(time_s, place_mm, [axis], 0.001)
    real = filtered(time_s, place_mm, axis, at_s)
    assert axis.delay_s == pytest.approx(delay_s)
    assert np.interp(1.0, at_s, real) == pytest.approx(50.0 * (1.0 - delay_s), abs=1e-6)
    assert real[-1] == pytest.approx(50.0, abs=1e-6)
    assert (np.diff(real) >= -1e-12).all()
