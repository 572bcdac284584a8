"""The declared control of a profile: path modes, stops at reversals, what a stroke needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.kinematics.machine_demand import least_acceleration_mm_s2
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.settings import SettingsError
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.trapezoid import Trapezoid
from chipbreak.vibration.measure import CutReport

PROGRAM = "G21 G99 G97 S1250 M3\nG0 X20. Z2.\nG1 Z-3. F0.1 N1.5\nM30\n"
DECLARED = ("planner.model=trapezoid", "axes.Z.max_acceleration_mm_s2=5000", "checks.enabled=false")


def cut_of(*sets: str, program: str = PROGRAM, profile: str = "fanuc-lathe") -> CutReport:
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


def swing(
    waveform: str, frequency_hz: float, stroke_mm: float, feed_mm_rev: float = 1e-9
) -> WaveformParameters:
    return WaveformParameters(
        length_mm=10.0,
        feed_mm_rev=feed_mm_rev,
        speed_rpm=1000.0,
        period_s=1.0 / frequency_hz,
        ticks=4,
        forward_ticks=2,
        stroke_mm=stroke_mm,
        waveform=waveform,
    )


@pytest.mark.parametrize(("frequency_hz", "needed"), [(62.5, 7711), (31.25, 1928), (10.0, 197)])
def test_acceleration_of_a_sine(frequency_hz: float, needed: float) -> None:
    """The second difference of the motion itself says the same."""
    least = least_acceleration_mm_s2(swing("sine", frequency_hz, 0.1), 1.5)
    assert least == pytest.approx(needed, abs=0.5)
    time_s = np.linspace(0.0, 1.0 / frequency_hz, 20001)
    place_mm = 0.05 * np.sin(2.0 * np.pi * frequency_hz * time_s)
    measured = np.abs(np.diff(place_mm, 2)).max() / (time_s[1] - time_s[0]) ** 2
    assert measured == pytest.approx(least, rel=1e-5)


@given(frequency_hz=st.floats(1.0, 100.0), stroke_mm=st.floats(0.01, 1.0))
def test_acceleration_of_an_even_triangle(frequency_hz: float, stroke_mm: float) -> None:
    least = least_acceleration_mm_s2(swing("triangle", frequency_hz, stroke_mm), 1.5)
    assert least == pytest.approx(16.0 * frequency_hz**2 * stroke_mm, rel=1e-6)
    stroke_s = 0.5 / frequency_hz
    assert Trapezoid(1e9, least * 1.0001).shortest_time(stroke_mm) <= stroke_s
    with pytest.raises(RefusalError):
        Trapezoid(1e9, least * 0.999).feed_for_time(stroke_mm, stroke_s)


@pytest.mark.parametrize(
    ("forward_ticks", "needed"),
    [
        pytest.param(2, 4.0 * (0.1 + 0.2 * 0.04) / 0.02**2, id="forward in 20 ms of 100"),
        pytest.param(8, 4.0 * (0.1 - 0.2 * 0.04) / 0.02**2, id="back in 20 ms of 100"),
    ],
)
def test_acceleration_of_an_uneven_triangle_is_that_of_its_harder_stroke(
    forward_ticks: int, needed: float
) -> None:
    """The tool speeds up over half of the quicker stroke, and slows down over the rest: A = 4 d / t^2."""
    even = swing("triangle", 10.0, 0.1, feed_mm_rev=0.06)
    cut = replace(even, ticks=10, forward_ticks=forward_ticks)
    assert least_acceleration_mm_s2(cut, 1.5) == pytest.approx(needed, rel=1e-9)


def test_a_feed_is_reached_only_over_a_long_enough_block() -> None:
    """d = F^2 / A: 1 in/s at 10 in/s^2 needs 0.1 in."""
    inch, feed, acceleration = 25.4, 25.4, 254.0
    model = Trapezoid(1e9, acceleration)
    edge_mm = feed**2 / acceleration
    assert edge_mm == pytest.approx(0.1 * inch)
    for length_mm, reaches in ((edge_mm * 1.01, True), (edge_mm * 0.99, False)):
        (time_s,) = model.block_times([length_mm], feed)
        assert (time_s == pytest.approx(length_mm / feed + feed / acceleration, rel=1e-9)) == reaches


@pytest.mark.parametrize("period_ms", [16.5, 18.5, 20.25])
def test_a_period_of_no_whole_servo_periods_is_kept_on_average(period_ms: float) -> None:
    """Its vibrations are of one servo period more and one less; none of them has the N of the cut."""
    program = "G7 G95 G97 S1818 M3\nG0 X40. Z2.\nG1 Z-20. F0.05 N1.5\nM2\n"
    sets = ("axes.Z.max_acceleration_mm_s2=20000", f"command.periods_ms=[{period_ms}]")
    cut = cut_of(*sets, program=program, profile="linuxcnc-lathe")
    assert cut.verdict.per_rev == pytest.approx(1.5, rel=0.001)
    assert not cut.misses_plan


def test_crests_moved_by_rounding_do_not_move_the_count() -> None:
    """Return ticks of less than an increment are merged: most crests lie some ticks away from the plan."""
    program = "G20 G95 G90 G97 S900 M3\nG0 X0.9293 Y0. Z0.1\nG1 X0.7327 F0.00197 E2\nM30\n"
    sets = ("output.segments=tick", "spindle.resolution_rpm=0.1", "output.feed_mode=inverse")
    cut = cut_of(*sets, "checks.enabled=false", program=program, profile="haas-mill")
    assert cut.verdict.per_rev == pytest.approx(0.5, rel=0.002)


def test_a_short_cut_is_not_refused_for_rounded_crests() -> None:
    """Of four crests, one moved by a tick is more than 1 %; but the blocks take their times."""
    program = "G20 G94 G90 G97 S1250 M3\nG0 X1.2109 Z0.0787\nG1 X1.0509 F4.92126 E2\nM5\nM30\n"
    sets = ("vibration.waveform=sine", "vibration.end=dwell", "control.lathe_system=B")
    cut = cut_of(*sets, "planner.model=ideal", program=program)
    assert cut.verdict.per_rev == pytest.approx(0.5, rel=0.02)
    assert not cut.misses_plan


def test_a_stroke_larger_than_the_fillet_that_it_goes_round_is_told_with_the_n_that_is_left() -> None:
    """Vibrations in the fillet take up to twice as long: these are no two vibrations of which one is lost."""
    program = (
        "G20 G18 G90 G8 G97 G95 S1250 M3\nG0 X0.315 Z0.0197\nG1 Z-0.0159 F0.0051 N1.5 Q2.29\n"
        "G2 X0.3229 Z-0.0238 I0.0079 K0 F0.0051 N1.5 Q2.29\nG1 X0.3585 F0.0051 N1.5 Q2.29\nM2\n"
    )
    sets = ["output.feed_mode=minute", "vibration.ramp_vibrations=0", "vibration.end=dwell"]
    sets += [f"axes.{axis}.max_acceleration_mm_s2=10000" for axis in "XZ"]
    sets += ["planner.servo_period_ms=0.5", "planner.max_feed_override=1.2"]
    settings = chipbreak.load("linuxcnc-lathe", sets)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    (said,) = caught.value.diagnostics
    # On the simulated machine there are 20 vibrations in the 771.5 ms from the first crest to the last.
    assert (
        f"make N {20 / 0.7715 * 60 / 1250:.3f} of 1.500: it slows down at bends of the path" in said.message
    )
    assert said.code == "VIB034"


IN_INCHES = "G20 G18 G90 G8 G97 G95 S200 M3\nG0 X0.315 Z0.0197\nG1 Z-0.0183 F0.0009 N1.5 Q1.71\nM2\n"
IN_MM = "G21 G18 G90 G8 G97 G95 S6 M3\nG0 X8 Z0.5\nG1 Z-0.466 F0.023 N1.5 Q1.71\nM2\n"


@pytest.mark.parametrize(
    ("program", "unit_mm", "sets"),
    [(IN_INCHES, 25.4, ()), (IN_MM, 1.0, ("command.periods_ms=[6666]", "output.decimals=5"))],
    ids=["inch", "mm"],
)
def test_no_block_of_inverse_time_is_slower_than_linuxcnc_makes_it(
    program: str, unit_mm: float, sets: tuple[str, ...]
) -> None:
    """Its interpreter before 2.9.0 makes 0.1 of anything slower: others of the cut get the time."""
    settings = chipbreak.load("linuxcnc-lathe", ["output.feed_mode=inverse", *sets])
    result = chipbreak.rewrite(program.encode(), settings)
    (cut,) = result.cuts
    blocks = [line.split() for line in result.data.decode().split("\n") if " F" in line and "Z" in line]
    blocks = [words for words in blocks if not words[0].startswith("(")]
    ends = [float(word[1:]) for words in blocks for word in words if word[0] == "Z"]
    rates = [float(words[-1][1:]) for words in blocks]
    start = float(program.split("\n")[1].split("Z")[1])
    slowest = min(abs(way) * rate for way, rate in zip(np.diff(ends, prepend=start), rates, strict=True))
    assert 0.1 * 0.999 <= slowest < 0.15
    spans = np.abs(np.diff(cut.expansion.time_s, prepend=0.0))
    assert (np.abs(np.diff(ends, prepend=start)) / spans * 60.0).min() < 0.05  # so slow they were meant to be
    assert cut.duration_s == pytest.approx(cut.wave.duration_s, rel=0.001)
    assert cut.verdict.per_rev == pytest.approx(1.5, rel=0.001)


TICKS = "G21 G18 G90 G8 G97 G94 S6000 M3\nG0 X14.664 Z-0.4\nG1 X9.966 F840 E2\nG0 X10.966 Z0.2\nM2\n"
FAST = ("axes.X.max_acceleration_mm_s2=20000", "planner.max_feed_override=1.2")
FROM_FULL = ("vibration.ramp_vibrations=0",)


@pytest.mark.parametrize(
    ("mode", "sets", "stands"),
    [
        ("minute", ("output.segments=tick",), True),
        ("inverse", ("output.segments=tick",), True),
        ("rev", ("output.segments=tick", *FROM_FULL), False),
        ("minute", FROM_FULL, False),
    ],
)
def test_where_the_first_block_depends_on_what_was_read_the_tool_stands_before_it(
    mode: str, sets: tuple[str, ...], stands: bool
) -> None:
    settings = chipbreak.load("linuxcnc-lathe", [*FAST, f"output.feed_mode={mode}", *sets])
    lines = chipbreak.rewrite(TICKS.encode(), settings).data.decode().split("\n")
    first = next(number for number, line in enumerate(lines) if line.startswith("G1 X"))
    assert ("G4 P0" in lines[:first]) == stands


@pytest.mark.parametrize(
    ("mode", "period_ms", "wish", "first_s"),
    [
        ("rev", 1.0, "E2", 0.008),
        ("rev", 2.0, "E2", 0.016),
        ("minute", 1.0, "E2", 0.004),
        ("minute", 2.0, "E2", 0.008),
        # As far as the first crest, which stays.
        ("rev", 2.0, "E2 f62.5", 0.008),
    ],
)
def test_a_wave_in_short_blocks_begins_with_one_that_need_not_rest(
    mode: str, period_ms: float, wish: str, first_s: float
) -> None:
    sets = ["axes.Z.max_acceleration_mm_s2=20000", f"output.feed_mode={mode}", "vibration.waveform=sine"]
    settings = chipbreak.load("linuxcnc-lathe", [*sets, f"planner.servo_period_ms={period_ms}"])
    program = f"G21 G18 G90 G8 G97 G95 S1920 M3\nG0 X6.444 Z1\nG1 Z-3.1 F0.08 {wish}\nM2\n"
    (cut,) = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True).cuts
    assert cut.expansion.time_s[0] == pytest.approx(first_s)
    assert cut.expansion.time_s[1] == pytest.approx(first_s + 0.004)
