"""Knots of a vibrated cut: whole ticks, exact ends, never outside, and the closed forms of the stroke."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chipbreak.kinematics.waveform import (
    WaveformParameters,
    forward_ticks,
    full_window,
    largest_drop,
    least_stroke_mm,
    sample,
)
from chipbreak.kinematics.waves import wave_named
from chipbreak.text.diagnostics import RefusalError

# N 1.5 at 62.5 Hz, the worked example: 16 ms in four ticks, 24 ms per revolution.
CUT = WaveformParameters(
    length_mm=5.0,
    feed_mm_rev=0.1,
    speed_rpm=2500.0,
    period_s=0.016,
    ticks=4,
    forward_ticks=2,
    stroke_mm=0.16,
    ramp_in_s=0.2,
)


def refused(code: str, **changes: Any) -> RefusalError:
    with pytest.raises(RefusalError) as caught:
        sample(replace(CUT, **changes))
    assert caught.value.code == code
    assert caught.value.help
    return caught.value


# --- ticks -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("ticks", "alpha", "expected"),
    [(4, 0.75, 3), (4, 0.5, 2), (5, 0.5, 3), (7, 0.5, 4), (4, 0.99, 3), (4, 0.01, 1), (2, 0.9, 1)],
)
def test_forward_ticks(ticks: int, alpha: float, expected: int) -> None:
    assert forward_ticks(ticks, alpha) == expected


@pytest.mark.parametrize(("ticks", "alpha"), [(4, 0.0), (4, 1.0), (4, math.nan), (1, 0.5)])
def test_forward_ticks_that_cannot_be(ticks: int, alpha: float) -> None:
    with pytest.raises(RefusalError) as caught:
        forward_ticks(ticks, alpha)
    assert caught.value.code == "VIB010"


def test_waves_start_and_end_on_the_mean_feed() -> None:
    assert wave_named("triangle").heights(4, 3).tolist() == pytest.approx([1 / 3, 2 / 3, 1, 0])
    assert wave_named("sine").heights(8, 4)[:4].tolist() == pytest.approx([0.1464466, 0.5, 0.8535534, 1])
    assert wave_named("sine").heights(8, 4)[4:].tolist() == pytest.approx([0.8535534, 0.5, 0.1464466, 0])
    assert wave_named("sine").heights(7, 1)[-1] == wave_named("triangle").heights(7, 2)[-1] == 0.0


# --- the least stroke ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("per_rev", "raf"),
    [
        *((n, 0.5) for n in (0.5, 1.5, 2.5, 3.5)),
        (1.45, 0.506),
        (2.6, 0.526),
        *((n, 0.707) for n in (1.25, 3.75)),
        *((n, 1.618) for n in (1.1, 0.9)),
    ],
)
def test_least_amplitude_of_the_sine(per_rev: float, raf: float) -> None:
    assert least_stroke_mm("sine", per_rev, 0.1, margin=1.0) / 2 / 0.1 == pytest.approx(raf, abs=5e-4)


@pytest.mark.parametrize(
    ("per_rev", "alpha", "stroke"),
    [(1.5, 0.5, 0.1), (1.5, 0.75, 0.15), (1.25, 0.75, 0.1), (3.25, 0.75, 0.1), (4 / 3, 2 / 3, 0.1)],
)
def test_least_stroke_of_the_triangle(per_rev: float, alpha: float, stroke: float) -> None:
    assert least_stroke_mm("triangle", per_rev, 0.1, alpha_share=alpha, margin=1.0) == pytest.approx(stroke)
    assert least_stroke_mm("triangle", per_rev, 0.1, alpha_share=alpha) == pytest.approx(1.2 * stroke)


@pytest.mark.parametrize("waveform", ["sine", "triangle"])
def test_more_edges_take_their_share_of_the_feed(waveform: str) -> None:
    one = least_stroke_mm(waveform, 0.6, 0.05)
    assert least_stroke_mm(waveform, 1.2, 0.1, edges=2) == pytest.approx(one)
    # A two-flute drill at N = 1.5 needs 1.41 times the stroke of its best N = 1.
    best, half = (least_stroke_mm("sine", n, 0.1, edges=2) for n in (1.0, 1.5))
    assert half / best == pytest.approx(math.sqrt(2))


def test_a_sine_of_few_ticks_is_the_polygon_it_is() -> None:
    # Four ticks of a sine are a triangle; five never stand on the crest.
    assert largest_drop("sine", 1.3, ticks=4) == pytest.approx(largest_drop("triangle", 1.3))
    assert largest_drop("sine", 1.5, ticks=5) == pytest.approx(0.9045085)
    assert largest_drop("sine", 1.3, ticks=4000) == pytest.approx(largest_drop("sine", 1.3), abs=1e-6)


@pytest.mark.parametrize(("per_rev", "edges"), [(1, 1), (3, 1), (2, 2), (2.0005, 1), (6, 3)])
def test_no_stroke_breaks_a_whole_number_of_vibrations(per_rev: float, edges: int) -> None:
    with pytest.raises(RefusalError) as caught:
        least_stroke_mm("sine", per_rev, 0.1, edges=edges)
    assert caught.value.code == "VIB012"


# --- strokes and feeds in the steady part ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("per_rev", "stroke", "alpha", "strokes_mm", "feeds_mm_rev"),
    [
        (1.5, 0.16, 0.5, (0.19333, -0.12667), (0.58, 0.38)),
        (1.25, 0.13, 0.75, (0.19, -0.11), (0.31667, 0.55)),
        (3.5, 0.16, 0.5, (0.17429, -0.14571), (1.22, 1.02)),
        (0.5, 0.16, 0.5, (0.26, -0.06), (0.26, 0.06)),
    ],
)
def test_stroke_and_feed_table(
    per_rev: float,
    stroke: float,
    alpha: float,
    strokes_mm: tuple[float, float],
    feeds_mm_rev: tuple[float, float],
) -> None:
    ahead = forward_ticks(4, alpha)
    period_s = 60 / 2500 / per_rev
    cut = replace(CUT, period_s=period_s, forward_ticks=ahead, stroke_mm=stroke, ramp_in_s=0.1)
    time_s, distance_mm = sample(cut)
    start, _ = full_window(cut)
    turns = np.array([start, start + alpha * period_s, start + period_s])
    moved = np.diff(np.interp(turns, time_s, distance_mm))
    assert moved == pytest.approx(strokes_mm, abs=1e-5)
    revs = np.diff(turns) * 2500 / 60
    assert np.abs(moved) / revs == pytest.approx(feeds_mm_rev, abs=1e-5)
    # The closed forms, and the identity Lf / F_fwd + Lb / F_back = 1 / N.
    assert np.abs(moved) / revs == pytest.approx(
        [per_rev * stroke / alpha + 0.1, per_rev * stroke / (1 - alpha) - 0.1], rel=1e-9
    )
    assert revs.sum() == pytest.approx(1 / per_rev, rel=1e-9)


# --- knots -----------------------------------------------------------------------------------------------


def test_one_knot_per_base_period_in_whole_ticks() -> None:
    time_s, _ = sample(CUT)
    steps = np.diff(time_s)
    assert steps[:-1] == pytest.approx(0.004, rel=1e-9)
    assert time_s.size == 1 + 4 * CUT.vibrations + 1
    # 50 revolutions of 24 ms, the last one plain: 49 * 24 / 16 = 73.5 vibrations.
    assert CUT.vibrations == 73
    assert time_s[-1] - time_s[-2] == pytest.approx(1.2 - 73 * 0.016)
    assert time_s[-1] - time_s[-2] >= 0.024


def test_one_knot_per_stroke_is_the_same_motion() -> None:
    tick_time_s, tick_mm = sample(replace(CUT, forward_ticks=3, ramp_in_s=0.0))
    time_s, distance_mm = sample(replace(CUT, forward_ticks=3, ramp_in_s=0.0, form="stroke"))
    assert time_s.size == 1 + 2 * CUT.vibrations + 1
    assert np.interp(tick_time_s, time_s, distance_mm) == pytest.approx(tick_mm, abs=1e-12)
    assert np.diff(time_s)[:-1:2] == pytest.approx(0.012, rel=1e-9)
    # On a ramp the stroke ends still agree.
    tick_time_s, tick_mm = sample(CUT)
    time_s, distance_mm = sample(replace(CUT, form="stroke"))
    assert np.interp(time_s, tick_time_s, tick_mm) == pytest.approx(distance_mm, abs=1e-12)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 3.0])
def test_the_ramp_can_be_read_back_from_the_knots(exponent: float) -> None:
    cut = replace(CUT, ramp_exponent=exponent, form="stroke")
    time_s, distance_mm = sample(cut)
    crest_s = time_s[1:-1:2]
    share = (distance_mm - cut.speed_mm_s * time_s)[1:-1:2] / cut.stroke_mm
    growing = crest_s < 0.2
    slope, offset = np.polyfit(np.log(crest_s[growing] / 0.2), np.log(share[growing]), 1)
    assert (slope, offset) == pytest.approx((exponent, 0.0), abs=1e-9)
    end_s = cut.vibrations * cut.period_s
    shrinking = crest_s > end_s - 0.2
    assert share[shrinking] == pytest.approx(((end_s - crest_s[shrinking]) / 0.2) ** exponent, abs=1e-9)
    full = ~growing & ~shrinking
    assert full.sum() > 40
    assert share[full] == pytest.approx(1.0, abs=1e-9)


def test_the_full_window_is_whole_vibrations_and_no_more() -> None:
    start, end = full_window(CUT)
    # Ramp of 12.5 vibrations: the crest of vibration 12 stands at 12.5 and is full; mirrored at the end.
    assert (start / 0.016, end / 0.016) == pytest.approx((13, 60))
    assert full_window(replace(CUT, form="stroke")) == pytest.approx((12 * 0.016, 61 * 0.016))
    assert full_window(replace(CUT, ramp_in_s=0.0)) == pytest.approx((0.0, 73 * 0.016))


def test_through_cuts_may_vibrate_to_the_end_but_never_past_it() -> None:
    cut = replace(CUT, end_revolutions=0.0, ramp_in_s=0.0, length_mm=4.8)
    time_s, distance_mm = sample(cut)
    assert cut.vibrations == 72
    # 1.152 s is exactly 72 vibrations: no sliver of a move is left at the end.
    assert np.diff(time_s).min() == pytest.approx(0.004)
    assert (time_s[-1], distance_mm[-1]) == (cut.duration_s, 4.8)
    assert distance_mm.max() == 4.8


def test_a_sine_moves_smoothly_and_starts_at_rest_against_the_feed() -> None:
    cut = replace(CUT, waveform="sine", ticks=16, ramp_in_s=0.0)
    time_s, distance_mm = sample(cut)
    ahead = distance_mm - cut.speed_mm_s * time_s
    steady = ahead[: 16 * cut.vibrations + 1]
    expected = 0.08 * (1 - np.cos(2 * np.pi * np.arange(steady.size) / 16))
    assert steady == pytest.approx(expected, abs=1e-12)
    assert cut.alpha_share == 0.5


def test_a_long_cut() -> None:
    cut = replace(CUT, length_mm=16_800.0)
    time_s, distance_mm = sample(cut)
    assert time_s.size > 1_000_000
    assert (time_s[-1], distance_mm[-1]) == (cut.duration_s, 16_800.0)


CUTS = st.builds(
    WaveformParameters,
    length_mm=st.floats(0.5, 40),
    feed_mm_rev=st.floats(0.01, 0.5),
    speed_rpm=st.floats(50, 6000),
    period_s=st.floats(0.008, 0.5),
    ticks=st.integers(2, 12),
    forward_ticks=st.just(1),
    stroke_mm=st.floats(0.005, 1.5),
    waveform=st.sampled_from(["triangle", "sine"]),
    ramp_in_s=st.one_of(st.just(0.0), st.floats(0.01, 2)),
    ramp_exponent=st.floats(0.3, 4),
    end_revolutions=st.floats(0, 3),
)


@pytest.mark.few(50)
@given(cut=CUTS, share=st.floats(0.1, 0.9), per_stroke=st.booleans())
def test_every_cut_stays_inside_and_ends_exactly(
    cut: WaveformParameters, share: float, per_stroke: bool
) -> None:
    form = "stroke" if per_stroke and cut.waveform == "triangle" else "tick"
    cut = replace(cut, forward_ticks=forward_ticks(cut.ticks, share), form=form)
    try:
        time_s, distance_mm = sample(cut)
    except RefusalError as error:
        assert error.code == "VIB013"
        assume(False)
    assert (time_s[0], distance_mm[0]) == (0.0, 0.0)
    assert (time_s[-1], distance_mm[-1]) == (cut.duration_s, cut.length_mm)
    assert (np.diff(time_s) > 0).all()
    assert (distance_mm >= 0).all()
    assert (distance_mm <= cut.length_mm).all()
    ahead = distance_mm - cut.speed_mm_s * time_s
    assert ahead.min() >= -1e-9
    assert ahead.max() <= cut.stroke_mm + 1e-9
    plain = time_s[:-1] >= cut.duration_s - cut.end_revolutions * 60 / cut.speed_rpm + 1e-6 * cut.period_s
    assert not plain.any()
    start, end = full_window(cut)
    assert 0 <= start < end <= cut.vibrations * cut.period_s + 1e-9
    crest = (time_s > start - 1e-9) & (time_s < end + 1e-9)
    reach = cut.shape.heights(cut.ticks, cut.forward_ticks).max() * cut.stroke_mm
    assert ahead[crest].max() == pytest.approx(reach, rel=1e-6)


# --- refusals --------------------------------------------------------------------------------------------


def test_too_short_a_cut_says_the_numbers() -> None:
    told = str(refused("VIB013", length_mm=1.0))
    assert "1 mm at F 0.1 mm/rev takes 0.24 s" in told
    assert "0.2 s each" in told
    refused("VIB013", length_mm=0.1, ramp_in_s=0.0)
    refused("VIB013", length_mm=0.15, ramp_in_s=0.0, end_revolutions=0.0)  # the stroke is longer than the cut
    assert sample(replace(CUT, length_mm=0.3, ramp_in_s=0.0))[0].size > 3


def test_a_sine_cannot_go_stroke_by_stroke() -> None:
    assert "tick" in refused("VIB011", waveform="sine", form="stroke").help


@pytest.mark.parametrize(
    "changes",
    [
        {"length_mm": 0.0},
        {"feed_mm_rev": -0.1},
        {"speed_rpm": math.nan},
        {"period_s": math.inf},
        {"stroke_mm": 0.0},
        {"ramp_exponent": 0.0},
        {"ramp_in_s": -1.0},
        {"end_revolutions": math.nan},
        {"forward_ticks": 0},
        {"forward_ticks": 4},
    ],
)
def test_values_that_cannot_be(changes: dict[str, Any]) -> None:
    refused("VIB010", **changes)


@pytest.mark.parametrize(
    "changes", [{"per_rev": 0.0}, {"feed_mm_rev": 0.0}, {"alpha_share": 1.0}, {"margin": math.nan}]
)
def test_least_stroke_of_values_that_cannot_be(changes: dict[str, Any]) -> None:
    values: dict[str, Any] = {"waveform": "sine", "per_rev": 1.5, "feed_mm_rev": 0.1}
    with pytest.raises(RefusalError) as caught:
        least_stroke_mm(**{**values, **changes})
    assert caught.value.code == "VIB010"


def test_a_ramp_as_short_as_a_number_can_be() -> None:
    """A division by it must not overflow."""
    none, shortest = (sample(replace(CUT, ramp_in_s=time_s)) for time_s in (0.0, 5e-324))
    assert np.array_equal(shortest, none)
