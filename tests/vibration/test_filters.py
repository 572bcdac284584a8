"""What filters of an axis leave of a motion, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import chipbreak
from chipbreak.kinematics.remembered import forget
from chipbreak.kinematics.waveform import WaveformParameters, sample
from chipbreak.trajectory.filters import AxisFilter, axis_filter, filtered, times_to_look_at
from chipbreak.trajectory.look_ahead import LookAhead
from chipbreak.vibration import compensation
from chipbreak.vibration.measure import CutReport

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


def cut_of(program: str, *sets: str) -> CutReport:
    settings = chipbreak.load("fanuc-lathe", sets)
    (cut,) = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True).cuts
    return cut


FAST = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5 Q1.2\nM30\n"
SLOW = "G97 S1200 M3\nG0 X20. Z2.\nG1 Z-30. F0.1 E3 Q1.8\nM30\n"


@pytest.mark.parametrize(
    ("program", "keys", "margin"),
    [
        (FAST, ["acc_dec_ms=16"], 0.0),
        (FAST, ["acc_dec=exponential", "acc_dec_ms=32"], 0.075),
        (FAST, ["position_gain_1_s=33"], 0.08),
        (SLOW, ["acc_dec_ms=32"], 1.18),
        (FAST, ["acc_dec_ms=8"], 0.6),
    ],
)
def test_the_verdict_is_that_of_the_filtered_motion(program: str, keys: list[str], margin: float) -> None:
    """A factor for the sine of that frequency says 1 - 0, 0.19, 0.17, 1.13 and 0.76 of the promise."""
    cut = cut_of(program, *(f"axes.Z.{key}" for key in keys))
    assert cut.verdict.margin == pytest.approx(margin, abs=0.006)
    assert cut.verdict.breaks == (margin >= 1.0)


def test_an_uneven_wave_loses_more_margin_than_stroke() -> None:
    sets = ("vibration.alpha=0.75",)
    program = FAST.replace("N1.5", "N1.25")
    plain = cut_of(program, *sets).verdict
    behind = cut_of(program, *sets, "axes.Z.position_gain_1_s=300").verdict
    assert behind.stroke_mm / plain.stroke_mm == pytest.approx(0.49, abs=0.01)
    assert behind.margin / plain.margin == pytest.approx(0.42, abs=0.005)


@pytest.mark.parametrize(
    "keys",
    [
        ["position_gain_1_s=33"],
        ["acc_dec_ms=8", "position_gain_1_s=50"],
        ["acc_dec=bell", "acc_dec_ms=6", "bell_ms=4", "position_gain_1_s=80", "feed_forward=0.5"],
    ],
)
@pytest.mark.parametrize("words", ["N1.5", "N2.6", "E3"])
def test_a_stroke_that_nobody_asked_for_is_raised_until_the_axes_make_enough(
    keys: list[str], words: str
) -> None:
    cut = cut_of(FAST.replace("N1.5 Q1.2", words), *(f"axes.Z.{key}" for key in keys))
    assert cut.verdict.margin == pytest.approx(1.2, rel=0.02)
    assert cut.wave.stroke_mm > cut.verdict.stroke_mm
    assert any("commanded" in reason for reason in cut.plan.reasons)
    # Neither the command nor the axes leave the path.
    assert cut.expansion.distance_mm.min() > 0.0
    assert cut.expansion.distance_mm.max() <= cut.plan.path.length_mm


def test_no_stroke_is_raised_beyond_what_the_axis_can_do() -> None:
    sets = ("axes.Z.acc_dec_ms=8", "axes.Z.position_gain_1_s=50", "axes.Z.max_acceleration_mm_s2=3000")
    program = FAST.replace(" Q1.2", "")
    cut = cut_of(program, *sets)
    assert 0.5 < cut.verdict.margin < 1.0
    assert cut.acceleration_mm_s2 <= 3000.0
    slow = cut_of(program, *sets[:2], "axes.Z.max_velocity_mm_min=4000")
    assert slow.verdict.margin < 1.0
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe", sets))
    assert "VIB062" in [d.code for d in caught.value.diagnostics]


def test_nothing_is_run_behind_a_filter_of_a_minute(monkeypatch: pytest.MonkeyPatch) -> None:
    """It settles over 3,750 vibrations and leaves nothing of any; an axis that stands does not count."""
    seen: list[int] = []

    def counted(wave: WaveformParameters) -> tuple[Floats, Floats]:
        time_s, distance_mm = sample(wave)
        seen.append(len(time_s))
        return time_s, distance_mm

    monkeypatch.setattr(compensation, "sample", counted)
    program = FAST.replace(" Q1.2", "")
    assert cut_of(program, "axes.Z.acc_dec_ms=60000").verdict.margin == pytest.approx(0.0, abs=0.001)
    assert not seen
    cut = cut_of(program, "axes.X.acc_dec_ms=60000", "axes.Z.acc_dec_ms=8")
    assert cut.verdict.margin == pytest.approx(1.2, rel=0.02)
    assert 0 < max(seen) < 1000


def test_what_the_control_makes_of_strokes_must_be_known() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError, match="position_gain_1_s"):
        cut_of(FAST, "planner.model=after-interpolation", "axes.Z.acc_dec_ms=8")


DWELL = "G97 S500 M3\nG0 X20. Z2.\n(VIB WAVE DWELL E4)\nG1 Z-5. F0.1\nM30\n"


@pytest.mark.parametrize("average_ms", [8.0, 32.0, 64.0])
def test_the_axes_come_to_rest_after_a_dwell_has_begun(average_ms: float) -> None:
    """A stand of two revolutions of 120 ms, less the average but for the last half step of 0.001 mm."""
    cut = cut_of(DWELL, f"axes.Z.acc_dec_ms={average_ms}")
    feed_mm_s = 0.1 * 500.0 / 60.0
    soon_ms = np.sqrt(2.0 * average_ms * 0.0005 / feed_mm_s * 1000.0)
    assert cut.verdict.margin == pytest.approx(2.0 - (average_ms - soon_ms) / 120.0, abs=0.03)
    assert cut.verdict.breaks


def test_a_dwell_that_a_slow_axis_eats_up_is_refused_with_what_works() -> None:
    sets = ("axes.Z.acc_dec_ms=32", "axes.Z.position_gain_1_s=15")
    short = DWELL.replace("E4", "E2.2")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        cut_of(short, *sets)
    (found,) = caught.value.diagnostics
    assert found.code == "VIB086"
    turns = found.help.split("take E ")[1].split(",")[0]
    assert cut_of(short.replace("E2.2", f"E{turns}"), *sets).verdict.breaks


def test_a_dwell_at_the_end_waits_for_the_axes() -> None:
    program = FAST.replace(" Q1.2", "")
    plain = cut_of(program, "vibration.end=dwell").plan.end_dwell_s
    late = cut_of(program, "vibration.end=dwell", "axes.Z.acc_dec_ms=6").plan.end_dwell_s
    assert late == pytest.approx(plain + 0.006)


def test_a_stroke_that_needs_more_than_the_axis_has_behind_its_filters_is_refused() -> None:
    program = FAST.replace("Q1.2", "Q12")
    sets = ("axes.Z.acc_dec_ms=4", "axes.Z.position_gain_1_s=90", "axes.Z.max_acceleration_mm_s2=3000")
    sets = ("planner.model=after-interpolation", *sets)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        cut_of(program, *sets)
    assert [d.code for d in caught.value.diagnostics] == ["VIB030"]
    assert cut_of(program, *sets[:-1]).verdict.breaks


def test_axes_of_unlike_filters_leave_the_path_of_a_taper_and_say_by_how_much() -> None:
    program = FAST.replace("G1 Z-30.", "G1 X60. Z-18.").replace(" Q1.2", "")
    alike = [f"axes.{axis}.position_gain_1_s=60" for axis in "XZ"]
    same = cut_of(program, *alike)
    other = cut_of(program, alike[0], "axes.Z.position_gain_1_s=45")
    assert same.following is not None and other.following is not None
    assert same.following.path_error_mm == 0.0
    # At an even feed of 2.08 mm/s along 45 degrees one axis is 1/45 - 1/60 s behind the other.
    speed_mm_s = 0.05 * 2500.0 / 60.0
    steady_mm = speed_mm_s * np.sqrt(0.5) * (1.0 / 45.0 - 1.0 / 60.0) * np.sqrt(0.5)
    assert steady_mm < other.following.path_error_mm < 12.0 * steady_mm
    assert other.verdict.margin == pytest.approx(1.2, rel=0.03)


@pytest.mark.parametrize(("average_ms", "gain_1_s"), [(16, 200), (48, 30), (32, 40)])
def test_what_a_refusal_names_breaks_on_these_axes(average_ms: float, gain_1_s: float) -> None:
    sets = ("planner.model=after-interpolation", f"axes.Z.acc_dec_ms={average_ms}")
    sets = (*sets, f"axes.Z.position_gain_1_s={gain_1_s}")
    program = FAST.replace(" Q1.2", "")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe", sets))
    (found,) = caught.value.diagnostics
    ways = found.help.split("works: ")[1].split("; --allow")[0].split(", or ")
    assert len(ways) >= 2
    for way in ways:
        words = way.split()
        wish = f"E{words[1]}" if words[0] == "E" else f"N{words[1]} f{words[3]}"
        result = chipbreak.rewrite(
            program.replace("N1.5", wish).encode(),
            chipbreak.load("fanuc-lathe", sets),
        )
        assert all(cut.verdict.breaks for cut in result.cuts)


@pytest.mark.parametrize(("joint_mm_min", "passed_mm_s"), [(0.0, 0.0), (600.0, 5.0), (6000.0, 12.5)])
def test_look_ahead_passes_a_reversal_at_half_the_joint_speed_or_the_lower_feed(
    joint_mm_min: float, passed_mm_s: float
) -> None:
    """Strokes of 0.2 mm: at rest before and behind, up and down at 8 m/s^2, 20 and 12.5 mm/s in between."""
    law = LookAhead(acceleration_mm_s2=8000.0, joint_speed_mm_s=joint_mm_min / 60.0)
    times_s = law.block_times([0.2, -0.2], [20.0, 12.5])
    for time_s, feed_mm_s in zip(times_s.tolist(), (20.0, 12.5), strict=True):
        ramps_s = feed_mm_s / 8000.0 + (feed_mm_s - passed_mm_s) / 8000.0
        ramps_mm = (2.0 * feed_mm_s**2 - passed_mm_s**2) / 16000.0
        assert time_s == pytest.approx(ramps_s + (0.2 - ramps_mm) / feed_mm_s)


def test_a_cut_so_long_that_its_motion_is_looked_at_less_often_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sets = ["planner.model=after-interpolation", "axes.Z.acc_dec_ms=4", "axes.Z.position_gain_1_s=200"]
    settings = chipbreak.load("generic-lathe", sets)

    def told() -> tuple[float | None, str]:
        result = chipbreak.rewrite(FAST.replace("N1.5 Q1.2", "E2").encode(), settings)
        report = chipbreak.explain(result, settings)
        return report.cuts[0].looks, str(report)

    looks, text = told()
    assert looks is not None
    assert looks >= 60.0
    assert "looked at" not in text
    monkeypatch.setattr("chipbreak.trajectory.real_motion._MOST_TIMES", 10_000)
    forget()
    looks, text = told()
    assert looks is not None
    assert looks < 60.0
    assert f"looked at {looks:.0f} times a vibration only" in text
