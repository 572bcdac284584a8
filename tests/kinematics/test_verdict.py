"""Chips by full regeneration against closed forms, a table, and a second simulation that shares no code."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chipbreak.kinematics.chip_model import Verdict, judge, weakest_margin
from chipbreak.kinematics.waveform import (
    WaveformParameters,
    forward_ticks,
    full_window,
    largest_drop,
    least_stroke_mm,
    sample,
    speed_band_rpm,
)
from chipbreak.kinematics.waves import wave_named
from chipbreak.text.diagnostics import RefusalError
from longer import short_where

Floats = npt.NDArray[np.float64]
FEED_MM = 0.1
REV_S = 60 / 2500
CUT = WaveformParameters(
    length_mm=20.0,
    feed_mm_rev=FEED_MM,
    speed_rpm=2500.0,
    period_s=0.016,
    ticks=4,
    forward_ticks=2,
    stroke_mm=0.12,
    ramp_in_s=0.5,
)


def steady_wave(
    waveform: str, per_rev: float, rho: float, alpha: float = 0.5, revs: int = 80
) -> tuple[Floats, Floats]:
    """Knots of a wave of full stroke from the first to the last; a sine of 240 straight pieces."""
    count, period_s = round(revs * per_rev), REV_S / per_rev
    share, height = np.array([alpha, 1.0]), np.array([1.0, 0.0])
    if waveform == "sine":
        share, height = np.arange(1, 241) / 240, wave_named("sine").heights(240, 120)
    time_s = np.append(0.0, ((np.arange(count)[:, None] + share) * period_s).ravel())
    return time_s, FEED_MM / REV_S * time_s + rho * FEED_MM * np.append(0.0, np.tile(height, count))


def judged(time_s: Floats, distance_mm: Floats, **options: Any) -> Verdict:
    return judge(time_s, distance_mm, speed_rpm=2500, feed_mm_rev=FEED_MM, **options)


def regenerated(time_s: Floats, distance_mm: Floats, edges: int = 1, settled: int = 10) -> tuple[Floats, int]:
    """Thickness after ten revolutions on a plain grid, and its points per revolution: the slow way."""
    points = 3600
    grid = np.interp(np.arange(0.0, time_s[-1], REV_S / points), time_s, distance_mm)
    step = points // edges
    wall = np.zeros_like(grid)
    for start in range(step, grid.size, step):
        stop = min(start + step, grid.size)
        last = slice(start - step, stop - step)
        wall[start:stop] = np.maximum(wall[last], grid[last])
    return (grid - wall)[settled * points :], points


# --- the table -------------------------------------------------------------------------------------------

# The two sines off k + 0.5 were printed as 0.747 and 0.734; worked out exactly, like the closed form
# 1 - arccos(1 / (rho sin pi N)) / pi, they are 0.750 and 0.736.
TABLE = [
    ("sine", 0.5, 1.2, 0.5, True, 0.814, 1.627, 2.00, 4.0),
    ("sine", 1.5, 1.5, 0.5, True, 0.732, 0.488, 2.00, 4.0),
    ("sine", 3.5, 2.0, 0.5, True, 0.667, 0.190, 2.00, 4.0),
    ("sine", 1.25, 1.2, 0.5, False, 1.0, None, 1.85, 3.4),
    ("sine", 1.25, 2.0, 0.5, True, 0.750, 0.600, 2.41, 5.8),
    ("sine", 1.45, 1.5, 0.5, True, 0.736, 0.507, 2.29, 3.4),
    ("triangle", 1.5, 1.2, 0.5, True, 0.917, 0.611, 2.00, 4.0),
    ("triangle", 1.5, 1.2, 0.75, False, 1.0, None, 1.80, 3.2),
    ("triangle", 1.5, 1.5, 0.75, True, 0.750, 0.500, 2.00, 4.0),
    ("triangle", 1.25, 1.2, 0.75, True, 0.937, 0.750, 1.40, 1.96),
    ("triangle", 1.25, 1.5, 0.75, True, 0.875, 0.700, 1.50, 2.25),
    ("triangle", 4 / 3, 1.2, 2 / 3, True, 0.926, 0.695, 1.60, 2.56),
    ("triangle", 3.25, 1.2, 0.75, True, 0.937, 0.289, 1.40, 1.96),
]


@pytest.mark.parametrize(
    "row", TABLE, ids=lambda row: f"{row[0]} N {row[1]:.2f} rho {row[2]} alpha {row[3]:.2f}"
)
def test_table_of_waveforms(row: tuple[Any, ...]) -> None:
    waveform, per_rev, rho, alpha, breaks, cut_share, longest_rev, peak, roughness = row
    got = judged(*steady_wave(waveform, per_rev, rho, alpha), diameter_mm=20)
    assert got.breaks == breaks
    assert got.cut_share == pytest.approx(cut_share, abs=1e-3)
    assert got.chips_per_rev == pytest.approx(per_rev if breaks else 0.0, rel=1e-6)
    assert got.peak_thickness == pytest.approx(peak, abs=6e-3)
    assert got.roughness_factor == pytest.approx(roughness, abs=0.06)
    assert (got.per_rev, got.stroke_mm) == pytest.approx((per_rev, rho * FEED_MM))
    if longest_rev is None:
        assert got.longest_chip_rev == pytest.approx(80)  # the whole cut is one chip
    else:
        assert got.longest_chip_rev == pytest.approx(longest_rev, abs=1e-3)
    assert got.longest_chip_mm == pytest.approx(math.pi * 20 * got.longest_chip_rev)


@pytest.mark.parametrize(("per_rev", "chip_mm"), [(1.5, 29.9), (3.5, 12.8), (0.5, 89.8)])
def test_chip_lengths_on_20_mm(per_rev: float, chip_mm: float) -> None:
    got = judged(*steady_wave("sine", per_rev, 1.6), diameter_mm=20)
    assert got.longest_chip_mm == pytest.approx(chip_mm, abs=0.06)


def test_without_a_diameter_there_is_no_length_in_mm() -> None:
    got = judged(*steady_wave("sine", 1.5, 1.6))
    assert (got.longest_chip_mm, got.first_chip_mm) == (None, None)


@pytest.mark.parametrize(
    ("alpha", "per_rev"), [(0.5, 1.5), (0.75, 1.25), (0.75, 3.25), (0.6, 0.4), (0.6, 2.4)]
)
@pytest.mark.parametrize("rho", [1.05, 1.2, 2.0])
def test_cut_share_at_the_best_phase(alpha: float, per_rev: float, rho: float) -> None:
    got = judged(*steady_wave("triangle", per_rev, rho, alpha))
    assert got.cut_share == pytest.approx(1 - 2 * alpha * (1 - alpha) * (1 - 1 / rho), abs=1e-6)
    assert got.chips_per_rev * got.longest_chip_rev == pytest.approx(got.cut_share, abs=1e-6)


def test_older_passes_shorten_the_cut_where_the_stroke_is_large() -> None:
    got = judged(*steady_wave("sine", 1.25, 3.0))
    # The closed form asks the last pass only; min over m of m + rho (w(tau) - w(tau - m N)) gives 0.569.
    assert 1 - math.acos(1 / (3 * math.sin(math.pi * 0.25))) / math.pi == pytest.approx(0.656, abs=1e-3)
    assert got.cut_share == pytest.approx(0.569, abs=1e-3)


# --- breaking against the closed form --------------------------------------------------------------------


@pytest.mark.few(50)
@given(per_rev=st.floats(0.2, 6.0), rho=st.floats(0.2, 6.0), alpha=st.floats(0.3, 0.85))
def test_margin_of_the_triangle_is_its_closed_form(per_rev: float, rho: float, alpha: float) -> None:
    expected = rho * largest_drop("triangle", per_rev, alpha)
    assume(abs(expected - 1) > 1e-6)
    got = judged(*steady_wave("triangle", per_rev, rho, alpha, revs=25))
    assert got.margin == pytest.approx(expected, abs=1e-6)
    assert got.breaks == (expected > 1)


def alone(time_s: Floats, distance_mm: Floats, **options: Any) -> float:
    return weakest_margin(time_s, distance_mm, speed_rpm=2500, feed_mm_rev=FEED_MM, **options)


@pytest.mark.parametrize("waveform", ["triangle", "sine", None])
@pytest.mark.parametrize("edges", [1, 2])
def test_the_margin_alone_is_that_of_the_verdict(waveform: str | None, edges: int) -> None:
    wave = steady_wave(waveform or "triangle", 1.5, 1.3)
    said = {"edges": edges, "waveform": waveform, "vibration_s": REV_S / 1.5, "steady_s": (0.1, 1.5)}
    assert alone(*wave, **said) == judged(*wave, **said).margin
    stands = np.array([0.0, 0.01, 0.05, 0.06, 0.1, 0.11]), FEED_MM * np.array([0.0, 1, 1, 2, 2, 3])
    assert alone(*stands, waveform="dwell") == judged(*stands, waveform="dwell").margin
    with pytest.raises(RefusalError):
        alone(np.array([0.0, 0.0]), np.zeros(2))


@pytest.mark.few(25)
@given(per_rev=st.floats(0.3, 10.5), rho=st.floats(0.2, 6.0))
def test_margin_of_the_sine_is_its_closed_form(per_rev: float, rho: float) -> None:
    expected = rho * largest_drop("sine", per_rev)
    got = judged(*steady_wave("sine", per_rev, rho, revs=25))
    assert got.margin == pytest.approx(expected, abs=2e-4 * rho)
    assume(abs(expected - 1) > 2e-3)
    assert got.breaks == (expected > 1)


@pytest.mark.parametrize("waveform", ["sine", "triangle"])
@pytest.mark.parametrize("edges", [1, 2, 3])
@pytest.mark.parametrize(
    ("per_rev", "rho", "alpha"),
    [(1.5, 0.9, 0.5), (1.37, 1.4, 0.75), (0.5, 1.9, 0.6), (2.8, 2.6, 0.5), (1.1, 3.5, 0.7), (3.3, 0.6, 0.4)],
)
def test_a_second_simulation_agrees(
    waveform: str, edges: int, per_rev: float, rho: float, alpha: float
) -> None:
    motion = steady_wave(waveform, per_rev, rho, alpha, revs=60)
    thickness_mm, points = regenerated(*motion, edges)
    in_cut = thickness_mm > 1e-9
    starts = np.flatnonzero(in_cut[1:] & ~in_cut[:-1])
    got = judged(*motion, edges=edges)
    assert got.breaks == (starts.size > 0)
    assert got.peak_thickness * FEED_MM / edges == pytest.approx(thickness_mm.max(), rel=0.01)
    assert got.cut_share == pytest.approx(in_cut.mean(), abs=0.01)
    if got.breaks:
        stops = np.flatnonzero(in_cut[:-1] & ~in_cut[1:])
        stops = stops[stops > starts[0]]
        longest_rev = (stops - starts[: stops.size]).max() / points
        assert got.longest_chip_rev == pytest.approx(longest_rev, abs=0.005)
        revs = (starts[-1] - starts[0]) / points
        assert got.chips_per_rev == pytest.approx((starts.size - 1) / revs, rel=0.01)


@pytest.mark.parametrize("edges", [1, 2])
@pytest.mark.parametrize(("rho", "ramp_s"), [(1.2, 0.05), (2.2, 0.05), (2.2, 0.5), (3.0, 0.02)])
def test_chips_of_the_ramps_are_those_of_a_second_simulation(rho: float, ramp_s: float, edges: int) -> None:
    """Ten revolutions are the longest ramp; a short one meets passes of no stroke with its full one."""
    cut = replace(CUT, stroke_mm=rho * FEED_MM, ramp_in_s=ramp_s, end_revolutions=1.0)
    motion = sample(cut)
    got = judged(*motion, edges=edges, steady_s=full_window(cut))
    thickness_mm, _ = regenerated(*motion, edges, settled=0)
    either = max(got.peak_thickness, got.ramp_peak_thickness)
    assert either * FEED_MM / edges == pytest.approx(thickness_mm.max(), rel=0.01)
    if ramp_s < REV_S:
        assert got.ramp_peak_thickness > 1.05 * got.peak_thickness


@pytest.mark.parametrize("per_rev", [1.0, 3.0])
def test_a_whole_number_of_vibrations_never_breaks(per_rev: float) -> None:
    got = judged(*steady_wave("sine", per_rev, 40.0))
    assert (got.breaks, got.cut_share, got.chips_per_rev) == (False, 1.0, 0.0)
    assert got.margin == pytest.approx(0.0, abs=1e-6)


def test_two_edges_break_best_at_an_odd_number() -> None:
    assert judged(*steady_wave("sine", 1.0, 0.51), edges=2).breaks
    assert not judged(*steady_wave("sine", 2.0, 5.0), edges=2).breaks
    assert judged(*steady_wave("sine", 1.5, 0.72), edges=2).breaks
    assert not judged(*steady_wave("sine", 1.5, 0.70), edges=2).breaks


def test_plain_feed_is_one_chip() -> None:
    time_s = np.array([0.0, 40 * REV_S])
    got = judged(time_s, time_s * FEED_MM / REV_S, diameter_mm=10, waveform="sine")
    assert (got.breaks, got.per_rev, got.chips_per_rev, got.cut_share) == (False, 0.0, 0.0, 1.0)
    assert got.margin == pytest.approx(0.0, abs=1e-9)
    assert (got.peak_thickness, got.roughness_factor) == pytest.approx((1.0, 1.0))
    assert (got.longest_chip_rev, got.first_chip_rev) == pytest.approx((40, 40))
    assert got.speed_band_rpm is None
    assert got.peak_speed_mm_s == pytest.approx(FEED_MM / REV_S)


# --- the band of spindle speeds --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("waveform", "speed", "per_rev", "rho", "alpha", "band"),
    [
        ("sine", 2500, 1.5, 1.6, 0.5, (2101, 3087)),
        ("sine", 62.5 * 60 / 3.5, 3.5, 1.6, 0.5, (991, 1166)),
        ("triangle", 2500, 1.5, 1.5, 0.75, (2500, 3214)),
    ],
)
def test_band_edges(
    *, waveform: str, speed: float, per_rev: float, rho: float, alpha: float, band: Any
) -> None:
    got = speed_band_rpm(waveform, speed, per_rev, rho, alpha_share=alpha)
    assert got == pytest.approx(band, abs=0.6)
    # At either edge the margin is one; inside it breaks, outside it does not.
    for edge_rpm, inward in zip(got or (), (1.002, 0.998), strict=True):
        count = speed * per_rev / edge_rpm
        assert rho * largest_drop(waveform, count, alpha) == pytest.approx(1.0)
        assert judged(*steady_wave(waveform, count / inward, rho, alpha)).breaks
        assert not judged(*steady_wave(waveform, count * inward, rho, alpha)).breaks


def test_band_in_the_verdict_and_with_edges() -> None:
    got = judged(*steady_wave("triangle", 1.5, 1.5, 0.75), waveform="triangle", alpha_share=0.75)
    assert got.speed_band_rpm == pytest.approx((2500, 3214.2857))
    assert speed_band_rpm("sine", 2500, 1.5, 0.9) is None
    assert speed_band_rpm("sine", 2500, 3.0, 0.8, edges=2) == pytest.approx((2101, 3087), abs=0.6)


# --- whole cuts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["tick", "stroke"])
def test_a_whole_cut_keeps_its_margin(form: Any) -> None:
    cut = replace(CUT, form=form)
    got = judged(*sample(cut), steady_s=full_window(cut))
    assert (got.breaks, got.margin) == (True, pytest.approx(1.2, abs=1e-6))
    assert (got.per_rev, got.stroke_mm) == pytest.approx((1.5, 0.12))
    assert got.cut_share == pytest.approx(0.917, abs=1e-3)
    found = judged(*sample(cut))
    assert found.breaks
    assert 1.2 * 0.97 < found.margin <= 1.2 + 1e-9


@pytest.mark.few(50)
@given(
    per_rev=st.floats(0.3, 4.0),
    ticks=st.integers(4, 9),
    share=st.floats(0.3, 0.8),
    waveform=st.sampled_from(["sine", "triangle"]),
    edges=st.integers(1, 3),
    wanted=st.sampled_from([0.9, 1.1, 1.2]),
)
def test_the_least_stroke_keeps_its_promise(
    *, per_rev: float, ticks: int, share: float, waveform: str, edges: int, wanted: float
) -> None:
    assume(0.03 < per_rev / edges % 1 < 0.97)
    forward = forward_ticks(ticks, share)
    stroke_mm = least_stroke_mm(
        waveform, per_rev, FEED_MM, alpha_share=forward / ticks, edges=edges, margin=wanted, ticks=ticks
    )
    cut = replace(
        CUT,
        period_s=REV_S / per_rev,
        ticks=ticks,
        forward_ticks=forward,
        stroke_mm=stroke_mm,
        waveform=waveform,
    )
    got = judged(*sample(cut), edges=edges, steady_s=full_window(cut))
    assert got.margin == pytest.approx(wanted, rel=1e-6)
    assert got.breaks == (wanted > 1)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 3.0])
def test_the_first_chip_is_as_long_as_the_ramp_is_weak(exponent: float) -> None:
    cut = replace(CUT, stroke_mm=0.16, ramp_in_s=2.0, ramp_exponent=exponent)
    got = judged(*sample(cut), diameter_mm=20)
    # Breaking starts where y P = P_min: 0.625, 0.731, 0.855 of the ramp; then at the next vibration.
    broken_s = 2.0 * (0.1 / 0.16) ** (1 / exponent)
    assert 0 < got.first_chip_rev - broken_s / REV_S < 1.5
    assert got.first_chip_mm == pytest.approx(math.pi * 20 * got.first_chip_rev)


def test_without_a_ramp_the_first_chip_ends_in_the_second_revolution() -> None:
    motion = steady_wave("triangle", 1.5, 1.2)
    got = judged(*motion)
    thickness_mm = motion[1] - np.interp(motion[0] - REV_S, *motion)
    assert thickness_mm[motion[0] <= REV_S][1:].min() > 0
    # Air from the crossing on the stroke before the meeting of trough and crest at 4/3 rev.
    assert got.first_chip_rev == pytest.approx(4 / 3 - 1 / 36)


def test_one_missing_vibration_of_a_thousand_is_found() -> None:
    time_s, distance_mm = sample(replace(CUT, length_mm=80.0, form="stroke"))
    assert judged(time_s, distance_mm).breaks
    without = np.delete(np.arange(time_s.size), [1001, 1002, 1003])
    got = judged(time_s[without], distance_mm[without])
    assert (got.breaks, got.margin < 1) == (False, True)


@pytest.mark.parametrize("vibration_s", [0.02, None])
def test_a_part_in_which_the_tool_only_stands_breaks_nothing(vibration_s: float | None) -> None:
    """No mean speed can be told from it; the programmed feed is the measure."""
    time_s, distance_mm = np.array([0.0, 1.0, 1.5, 3.0]), np.array([0.0, 4.0, 4.0, 4.0])
    verdict = judge(
        time_s,
        distance_mm,
        speed_rpm=2500.0,
        feed_mm_rev=FEED_MM,
        steady_s=(2.0, 2.5),
        vibration_s=vibration_s,
        waveform="triangle",
    )
    assert not verdict.breaks
    assert verdict.margin == 0.0


def test_a_vibration_that_is_missing_in_the_last_revolution_is_found() -> None:
    """No later pass meets the place where it is missing, and its neighbour touches the last pass."""
    time_s, distance_mm = steady_wave("triangle", 1.5, 1.2)
    whole = judged(time_s, distance_mm, steady_s=(0.0, time_s[-1]))
    assert (whole.breaks, whole.margin) == (True, pytest.approx(1.2))
    crest, trough = time_s.size - 4, time_s.size - 3
    got = judged(
        np.delete(time_s, [crest, trough]),
        np.delete(distance_mm, [crest, trough]),
        steady_s=(0.0, time_s[-1]),
    )
    assert (got.breaks, got.margin) == (False, 0.0)


def test_the_thickest_chip_on_the_way_out_counts() -> None:
    """The stroke grows slowly, and at its end the tool goes on in plain feed as far ahead as the crests."""
    time_s, _ = steady_wave("triangle", 1.5, 1.2)
    plain_mm = FEED_MM / REV_S * time_s
    crests = np.arange(time_s.size) % 2 == 1
    stroke_mm = 1.2 * FEED_MM * np.minimum(time_s / (30.0 * REV_S), 1.0)
    distance_mm = plain_mm + np.where(crests, stroke_mm, 0.0)
    distance_mm[-1] += stroke_mm[-1]  # behind the last crest it does not turn back
    time_s = np.append(time_s, time_s[-1] + 2.0 * REV_S)
    distance_mm = np.append(distance_mm, distance_mm[-1] + 2.0 * FEED_MM)
    got = judged(time_s, distance_mm, steady_s=(30.0 * REV_S, time_s[-3]))
    thickness_mm, _ = regenerated(time_s, distance_mm, settled=0)
    assert got.ramp_peak_thickness == pytest.approx(thickness_mm.max() / FEED_MM, rel=1e-3)
    assert got.ramp_peak_thickness == pytest.approx(2.1, rel=1e-3)
    assert got.peak_thickness == pytest.approx(2.0, rel=1e-3)


def test_the_weakest_vibration_decides() -> None:
    time_s, distance_mm = sample(replace(CUT, length_mm=80.0, form="stroke"))
    weak_mm = distance_mm.copy()
    weak_mm[1001] -= 0.01  # its crest is 0.01 mm short, which the next revolution feels
    got = judged(time_s, weak_mm, steady_s=full_window(replace(CUT, length_mm=80.0, form="stroke")))
    assert got.margin == pytest.approx(1.1, abs=1e-6)
    weak_mm[1001] -= 0.015
    assert not judged(time_s, weak_mm).breaks


def test_a_control_that_stretches_the_blocks_loses_the_count() -> None:
    # LinuxCNC ran 62.5 Hz as 38.6 Hz: at 2500 rpm N = 1.5 becomes 0.93, and no chip breaks.
    time_s, distance_mm = sample(CUT)
    got = judged(time_s * 62.5 / 38.6, distance_mm)
    assert got.per_rev == pytest.approx(0.926, abs=1e-3)
    assert not got.breaks
    # The margin is about the feed as reached, which shrinks with the count.
    reached = largest_drop("triangle", got.per_rev) * 0.12 / (FEED_MM * 38.6 / 62.5)
    assert got.margin == pytest.approx(reached, rel=0.03)


def test_rounding_to_the_increment_is_felt_but_does_no_harm() -> None:
    time_s, distance_mm = sample(CUT)
    got = judged(time_s, np.round(distance_mm, 3), steady_s=full_window(CUT))
    assert got.breaks
    assert got.margin == pytest.approx(1.2, abs=0.02)
    assert got.margin < 1.2


def test_a_stroke_that_only_stops_the_tool_is_no_vibration_to_count() -> None:
    # P = (1 - alpha) feed / N: the return stroke stands still, and rounding must not make turns of it.
    cut = replace(CUT, period_s=REV_S / 1.2, ticks=8, forward_ticks=5, stroke_mm=0.03125)
    got = judged(*sample(cut), edges=3, steady_s=full_window(cut))
    assert (got.breaks, got.per_rev) == (False, 0.0)
    assert got.margin == pytest.approx(0.9, abs=1e-6)


def test_peak_speed_of_the_axis() -> None:
    got = judged(*sample(CUT))
    # Forward in 8 ms: 0.12 mm of stroke on top of the feed.
    assert got.peak_speed_mm_s == pytest.approx(0.12 / 0.008 + FEED_MM / REV_S)


def test_a_million_knots() -> None:
    cut = replace(CUT, length_mm=16_800.0)
    got = judged(*sample(cut), steady_s=full_window(cut))
    assert got.margin == pytest.approx(1.2, abs=1e-6)


def test_a_crest_on_the_edge_of_a_short_steady_part_is_no_missing_vibration() -> None:
    """One vibration of full stroke: behind one pass stands just its crest."""
    cut = replace(CUT, length_mm=5.0, period_s=2 * REV_S, stroke_mm=0.12, ramp_in_s=0.0)
    time_s, distance_mm = sample(cut)
    start_s, end_s = 20 * REV_S, 22 * REV_S
    for moved_s in (-1e-5, 0.0, 1e-5):
        got = judged(time_s, distance_mm, steady_s=(start_s + moved_s, end_s + 1e-4))
        assert got.breaks
        assert got.margin == pytest.approx(1.2, abs=0.01)


@pytest.mark.parametrize("vibrations", [1.9, 2.0, 2.3, 3.5])
def test_few_vibrations_are_counted_whole(vibrations: float) -> None:
    """Half a vibration more than a whole number may bring a chip more, and is no chip more per revolution."""
    period_s = 2.0 * REV_S
    time_s, distance_mm = steady_wave("triangle", 0.5, 1.92, 0.8)
    start_s = 10.0 * period_s
    got = judged(time_s, distance_mm, steady_s=(start_s, start_s + vibrations * period_s))
    assert got.chips_per_rev == pytest.approx(0.5, rel=1e-3)
    assert got.cut_share == pytest.approx(2.0 / 3.0, abs=1e-3)


def test_a_steady_part_shorter_than_a_revolution_is_still_judged() -> None:
    cut = replace(CUT, length_mm=0.3, ramp_in_s=0.0)
    got = judged(*sample(cut), steady_s=full_window(cut))
    assert (got.breaks, got.longest_chip_rev > 0) == (True, True)


# --- refusals --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("time_s", "distance_mm"),
    [
        ([0.0], [0.0]),
        ([0.0, 0.0], [0.0, 1.0]),
        ([0.0, 1.0], [0.0, math.nan]),
        ([0.0, 1.0, 2.0], [0.0, 1.0]),
        ([0.0, 1.0, math.inf], [0.0, 1.0, 2.0]),
    ],
)
def test_motions_that_cannot_be(time_s: list[float], distance_mm: list[float]) -> None:
    with pytest.raises(RefusalError) as caught:
        judged(np.array(time_s), np.array(distance_mm))
    assert caught.value.code == "VIB020"


@pytest.mark.parametrize("changes", [{"speed_rpm": 0.0}, {"feed_mm_rev": math.nan}, {"edges": 0}])
def test_values_that_cannot_be(changes: dict[str, Any]) -> None:
    values: dict[str, Any] = {"speed_rpm": 2500.0, "feed_mm_rev": FEED_MM}
    with pytest.raises(RefusalError) as caught:
        judge(*steady_wave("sine", 1.5, 1.2), **{**values, **changes})
    assert caught.value.code == "VIB020"


def test_many_passes_are_judged_alike_a_few_corners_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    cut = WaveformParameters(9.0, 0.05, 1500.0, 0.04, 10, 5, 1.5, ramp_in_s=0.12)
    whole = judge(*sample(cut), speed_rpm=1500.0, feed_mm_rev=0.05)
    monkeypatch.setattr("chipbreak.kinematics.piecewise._HEIGHTS_AT_ONCE", 100)
    assert judge(*sample(cut), speed_rpm=1500.0, feed_mm_rev=0.05) == whole


SOME_AT_ONCE = ((1, "sine"), (2, "triangle"), (7, "dwell"), (100, "triangle"))


@pytest.mark.parametrize(
    ("at_once", "waveform"),
    short_where(product([1, 2, 7, 100], ["triangle", "sine", "dwell"]), SOME_AT_ONCE.__contains__),
)
def test_a_long_motion_is_judged_alike_some_knots_at_a_time(
    monkeypatch: pytest.MonkeyPatch, at_once: int, waveform: str
) -> None:
    cut = WaveformParameters(9.0, 0.05, 1500.0, 0.06, 15, 8, 0.06, waveform=waveform, ramp_in_s=0.12)
    options = {"speed_rpm": 1500.0, "feed_mm_rev": 0.05, "waveform": waveform}
    whole = judge(*sample(cut), **options)
    monkeypatch.setattr("chipbreak.kinematics.piecewise.KNOTS_AT_ONCE", at_once)
    monkeypatch.setattr("chipbreak.kinematics.chip_model._CRESTS_AT_ONCE", at_once)
    assert judge(*sample(cut), **options) == whole


def test_a_tool_that_never_turns_back_meets_only_the_last_pass() -> None:
    """However far the feed that a control makes of it is from the one that was asked for."""
    time_s = np.arange(0.0, 400.0, 0.04)
    distance_mm = np.cumsum(np.where(np.arange(time_s.size) % 2, 0.004, 0.001))
    verdict = judge(time_s, distance_mm, speed_rpm=1500.0, feed_mm_rev=1e-5)
    assert not verdict.breaks
    assert (verdict.cut_share, verdict.chips_per_rev) == (1.0, 0.0)
    assert verdict.peak_thickness == pytest.approx(400.0)


@pytest.mark.parametrize("late_s", [0.0, 0.2 * REV_S, REV_S])
def test_a_vibration_that_takes_as_long_as_two_is_one(late_s: float) -> None:
    """N is that of the vibrations that were meant, over the time that they take, however late one is."""
    time_s, distance_mm = steady_wave("triangle", 1.5, 1.2, revs=20)
    late = time_s + np.where(np.arange(len(time_s)) > 30, late_s, 0.0)
    got = judged(late, distance_mm, vibration_s=REV_S / 1.5, meant_s=(late, time_s))
    crests = 29  # steps between the 30 crests
    assert got.per_rev == pytest.approx(crests / (crests / 1.5 + late_s / REV_S), rel=1e-9)


def test_a_vibration_that_was_swallowed_still_has_its_time() -> None:
    time_s, distance_mm = steady_wave("triangle", 1.5, 1.2, revs=20)
    kept = ~np.isin(np.arange(len(time_s)), (30, 31))
    got = judged(time_s[kept], distance_mm[kept], vibration_s=REV_S / 1.5, meant_s=(time_s, time_s))
    assert got.per_rev == pytest.approx(1.5, rel=1e-9)
    assert not got.breaks
