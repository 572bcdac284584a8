"""What every wave and its expander must answer; a new one is met by the same test."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.waveform import WaveformParameters, forward_ticks, sample
from chipbreak.kinematics.waves import WAVES, Wave, wave_named
from chipbreak.settings.sections import Vibration
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.ideal import Ideal
from chipbreak.vibration.directive import KEYS, read_directive
from chipbreak.vibration.expander import Expander, StrokeAsked
from chipbreak.vibration.expanders import EXPANDERS, expander_named

EVERY_WAVE = pytest.mark.parametrize("wave", WAVES, ids=lambda wave: wave.name)
EVERY_EXPANDER = pytest.mark.parametrize("expander", EXPANDERS, ids=lambda expander: expander.wave.name)
PROGRAM = b"G21 G99 G97 S900 M3\nG0 X20. Z2.\nG1 Z-3. F0.1 E2\nM30\n"


def asked(alpha: float = 0.5, **values: float) -> StrokeAsked:
    words = {key: SourcedValue(value, "test") for key, value in values.items()}
    return StrokeAsked(words, 1.5, 0.1, alpha, 1, 1.2, 8)


def parameters(expander: Expander, alpha: float = 0.5) -> WaveformParameters:
    wave, forward = expander.wave, forward_ticks(8, alpha, rounds_down=expander.wave.rounds_down)
    share = wave.share(forward, 8)
    return WaveformParameters(
        length_mm=5.0,
        feed_mm_rev=0.1,
        speed_rpm=900.0,
        period_s=60.0 / 900.0 / 1.5,
        ticks=8,
        forward_ticks=forward,
        stroke_mm=expander.stroke_mm(asked(share)),
        waveform=wave.name,
        ramp_in_s=expander.ramp_s(0.1),
        form=expander.form("auto"),
    )


def test_the_waves_are_those_of_profile_and_directive() -> None:
    names = [wave.name for wave in WAVES]
    assert len(set(names)) == len(names)
    assert Vibration.__dataclass_fields__["waveform"].metadata["choices"] == tuple(names)
    assert [expander.wave for expander in EXPANDERS] == list(WAVES)
    for name in names:
        assert wave_named(name).name == expander_named(name).wave.name == name
        assert name.upper() in KEYS["WAVE"]
        directive = read_directive(f"VIB N1.5 WAVE {name.upper()}", 1)
        assert directive is not None
        assert directive.waveform == name


@EVERY_WAVE
@given(ticks=st.integers(2, 40), alpha=st.floats(0.05, 0.95))
def test_a_wave_starts_and_ends_at_its_low_point(wave: Wave, ticks: int, alpha: float) -> None:
    forward = forward_ticks(ticks, alpha, rounds_down=wave.rounds_down)
    heights = wave.heights(ticks, forward)
    assert heights.shape == (ticks,)
    assert heights[-1] == pytest.approx(0.0, abs=1e-12)
    assert heights.min() >= 0.0
    assert heights.max() <= 1.0 + 1e-12
    assert 0.0 < wave.share(forward, ticks) < 1.0
    assert 0.0 < wave.speed_share(alpha) <= 1.0
    assert wave.moves(ticks) in (1, ticks)


@EVERY_WAVE
@given(ticks=st.integers(2, 40), alpha=st.floats(0.05, 0.95), data=st.data())
def test_a_wave_is_as_high_at_some_of_its_ticks(
    wave: Wave, ticks: int, alpha: float, data: st.DataObject
) -> None:
    forward = forward_ticks(ticks, alpha, rounds_down=wave.rounds_down)
    some = np.array(data.draw(st.lists(st.integers(1, ticks), min_size=1)))
    every = wave.heights(ticks, forward)
    assert wave.heights_at(some.astype(np.float64), ticks, forward).tolist() == every[some - 1].tolist()


def test_a_slow_vibration_of_short_periods_takes_no_memory() -> None:
    """Of its base periods, which would fill a hundred gigabytes, two have a knot."""
    slow = replace(parameters(expander_named("triangle")), form="stroke")
    ticks = 10_000_000_000
    time_s, distance_mm = sample(replace(slow, ticks=ticks, forward_ticks=ticks // 2))
    same_s, same_mm = sample(replace(slow, ticks=1000, forward_ticks=500))
    assert time_s.tolist() == pytest.approx(same_s.tolist())
    assert distance_mm.tolist() == pytest.approx(same_mm.tolist())


@EVERY_WAVE
@given(delta=st.floats(0.05, 0.95), alpha=st.floats(0.1, 0.9), rho=st.floats(1.05, 4.0))
def test_the_fractions_that_break_are_those_whose_drop_is_large_enough(
    wave: Wave, delta: float, alpha: float, rho: float
) -> None:
    alpha = 0.5 if wave.is_even else alpha
    low, high = wave.breaking_fractions(rho, alpha)
    drop = wave.largest_drop(delta, alpha, None) * rho
    if low + 1e-9 < delta < high - 1e-9:
        assert drop >= 1.0 - 1e-9
    elif not low - 1e-9 <= delta <= high + 1e-9:
        assert drop <= 1.0 + 1e-9


@EVERY_EXPANDER
@pytest.mark.parametrize("alpha", [0.5, 0.7])
def test_a_planned_motion_ends_in_time_and_only_swings_turn_back(expander: Expander, alpha: float) -> None:
    cut = parameters(expander, 0.5 if expander.wave.is_even else alpha)
    time_s, distance_mm = sample(cut)
    assert (np.diff(time_s) > 0.0).all()
    assert (time_s[-1], distance_mm[-1]) == (pytest.approx(cut.duration_s), pytest.approx(5.0))
    assert (np.diff(distance_mm) < -1e-9).any() == expander.wave.turns_back
    plain_s = cut.length_mm / cut.feed_speed_mm_s
    assert cut.duration_s == pytest.approx(plain_s + expander.wave.standing_s(cut))
    assert (expander.wave.standing_s(cut) > 0.0) == (not expander.wave.turns_back)
    least = expander.wave.least_acceleration_mm_s2(cut, 1.5)
    assert (least > 0.0) == expander.wave.turns_back


@EVERY_EXPANDER
def test_knots_and_dwells_are_the_whole_motion(expander: Expander) -> None:
    cut = parameters(expander)
    time_s, distance_mm = sample(cut)
    ends_s, ends_mm, dwells = expander.knots(time_s, distance_mm)
    assert len(ends_s) == len(ends_mm) == len(dwells)
    assert (ends_s[-1], ends_mm[-1]) == (time_s[-1], distance_mm[-1])
    assert dwells.sum() == (0 if expander.wave.turns_back else cut.vibrations)
    slow = replace(cut, period_s=4.0 * 60.0 / 900.0)
    dwell_s = expander.dwell_s(slow, Ideal(), 1, 0.25)
    assert dwell_s == (0.0 if expander.wave.turns_back else pytest.approx(slow.period_s / 2.0, abs=0.001))
    if not expander.wave.turns_back:
        with pytest.raises(RefusalError) as refused:
            expander.dwell_s(cut, Ideal(), 1, 1.5)
        assert refused.value.code == "VIB086"
    assert expander.feed_mode("minute", "rev") == ("minute" if expander.keeps_feed else "rev")


@EVERY_EXPANDER
def test_a_stroke_asked_for_is_kept_or_refused(expander: Expander) -> None:
    if expander.wave.turns_back:
        assert expander.stroke_mm(asked(A=0.3, Q=9.0)) == 0.3
        assert expander.stroke_mm(asked(Q=2.0)) == pytest.approx(0.2)
        assert expander.stroke_mm(asked()) > 0.1
        return
    for key in "AQ":
        with pytest.raises(RefusalError) as refused:
            expander.stroke_mm(asked(**{key: 1.0}))
        assert refused.value.code == "VIB085"


@EVERY_EXPANDER
def test_an_uneven_share_is_refused_where_the_wave_is_even(expander: Expander) -> None:
    uneven = SourcedValue(0.7, "test")
    if not expander.wave.is_even:
        expander.refuse_share(uneven)
        return
    with pytest.raises(RefusalError) as refused:
        expander.refuse_share(uneven)
    assert refused.value.code == "VIB055"


@EVERY_EXPANDER
def test_every_wave_is_written_and_told(expander: Expander) -> None:
    name = expander.wave.name
    result = chipbreak.rewrite(PROGRAM, chipbreak.load("fanuc-lathe", [f"vibration.waveform={name}"]))
    (cut,) = result.cuts
    assert cut.verdict.breaks
    assert expander.title(cut.wave) in result.edits[0].title
    heading, told = expander.told(cut.wave, cut.each_dwell_s)
    assert heading
    assert f"{cut.wave.feed_mm_rev:.4g} mm/rev" in told
    assert expander.told_need(cut.acceleration_mm_s2)
    for form in ("tick", "stroke"):
        assert expander.way_out_of_too_many_blocks(form)  # type: ignore[arg-type]


@EVERY_WAVE
def test_a_cut_of_a_wave_is_a_value(wave: Wave) -> None:
    cut = parameters(expander_named(wave.name))
    again = pickle.loads(pickle.dumps(cut))
    assert again == cut
    assert again.shape is wave
