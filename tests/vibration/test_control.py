"""The declared control of a profile: path modes, stops at reversals, what filters leave of a stroke."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.measure import CheckedCut
from chipbreak.settings import SettingsError
from chipbreak.vibration.load import servo_share

PROGRAM = "G21 G99 G97 S1250 M3\nG0 X20. Z2.\nG1 Z-3. F0.1 N1.5\nM30\n"
DECLARED = ("planner.model=trapezoid", "axes.Z.max_acceleration_mm_s2=5000", "checks.enabled=false")


def cut_of(*sets: str, program: str = PROGRAM, profile: str = "fanuc-lathe") -> CheckedCut:
    (cut,) = chipbreak.rewrite(program.encode(), chipbreak.load(profile, sets)).cuts
    return cut


def test_the_stop_at_a_reversal_is_made_up_for_by_the_feed() -> None:
    plain, stopping = cut_of(*DECLARED), cut_of(*DECLARED, "planner.reversal_stop_ms=3")
    for cut in (plain, stopping):
        assert cut.verdict.per_rev == pytest.approx(1.5, rel=0.001)
        assert not cut.misses_plan
    # The same strokes in 3 ms less.
    assert stopping.verdict.peak_speed_mm_s > 1.1 * plain.verdict.peak_speed_mm_s


def test_a_stop_too_long_for_the_stroke_is_refused() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        cut_of(*DECLARED, "planner.reversal_stop_ms=16")
    assert [d.code for d in caught.value.diagnostics] == ["VIB030"]


@pytest.mark.parametrize("model", ["ideal", "linuxcnc"])
def test_a_stop_belongs_to_the_declared_law(model: str) -> None:
    with pytest.raises(SettingsError, match="reversal_stop_ms"):
        chipbreak.load("linuxcnc-lathe", [f"planner.model={model}", "planner.reversal_stop_ms=3"])


def test_exact_stop_of_the_program_counts() -> None:
    """A sine is several blocks per stroke; in G61 a Fanuc control rests behind each of them."""
    program = PROGRAM.replace("G99", "G95").replace("S1250", "S500")
    sets = (*DECLARED, "output.segments=tick", "output.feed_mode=rev")
    through = cut_of(*sets, program=program, profile="fanuc-mill")
    resting = cut_of(*sets, program=program.replace("G21", "G21 G61"), profile="fanuc-mill")
    assert resting.verdict.per_rev == pytest.approx(through.verdict.per_rev, rel=0.01)
    assert resting.verdict.peak_speed_mm_s > 1.1 * through.verdict.peak_speed_mm_s


@given(frequency_hz=st.floats(1.0, 60.0), acc_dec_s=st.floats(0.001, 0.1))
def test_an_acc_dec_filter_is_a_moving_average(frequency_hz: float, acc_dec_s: float) -> None:
    step_s = acc_dec_s / 400.0
    time_s = np.arange(0.0, acc_dec_s + 2.0 / frequency_hz, step_s)
    seen = np.convolve(np.sin(2.0 * np.pi * frequency_hz * time_s), np.full(400, 1.0 / 400.0), "valid")
    share = (seen.max() - seen.min()) / 2.0
    assert servo_share(frequency_hz, None, acc_dec_s) == pytest.approx(share, abs=0.005)


def test_an_acc_dec_time_of_one_vibration_leaves_nothing() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        cut_of("axes.Z.acc_dec_ms=32")
    assert [d.code for d in caught.value.diagnostics] == ["VIB062"]
    assert "0% of the stroke" in caught.value.diagnostics[0].message
    both = cut_of("axes.Z.acc_dec_ms=4", "axes.Z.position_gain_1_s=500").servo_share
    assert both == pytest.approx(servo_share(31.25, 500.0) * servo_share(31.25, None, 0.004))
