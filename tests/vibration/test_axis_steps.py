"""Points lie on the steps of the axes, and so F and the verdict; the usual path mode comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import chipbreak
from chipbreak.model.modal import State
from chipbreak.pipeline import verify_filtered
from chipbreak.vibration.axis_steps import end_reached, off_halves
from machine_reader import filtered, run_program

CUT = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
TAPER = "G97 S3000 M3\nG0 X20. Z2.\nG1 X23.1 Z-30. F0.05 N1.5\nM30\n"
INCREMENTAL = "G97 S3000 M3\nG0 X20. Z2.\nG91\nG1 Z-32. F0.05 N1.5\nG90\nM30\n"


def verdict(program: str, *sets: str) -> tuple[float, float]:
    """Margin, and the longest chip in revolutions."""
    (cut,) = chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe", sets)).cuts
    return cut.verdict.margin, cut.verdict.longest_chip_rev


def off_step(value: float, step: float) -> float:
    return abs(value / step - round(value / step))


@pytest.mark.parametrize(
    ("program", "sets", "x_mm", "z_mm"),
    [
        pytest.param(CUT, ("axes.Z.increment_mm=0.004",), 0.0005, 0.004, id="Z"),
        pytest.param(CUT, ("axes.Z.steps_per_mm=250",), 0.0005, 0.004, id="steps in a mm"),
        pytest.param(TAPER, ("axes.X.increment_mm=0.002",), 0.002, 0.001, id="X of travel"),
        pytest.param(TAPER, ("control.increment_mm=0.01",), 0.005, 0.01, id="X of the diameter"),
        pytest.param(INCREMENTAL, ("axes.Z.increment_mm=0.004",), 0.0005, 0.004, id="distances"),
        pytest.param(CUT, ("axes.Z.increment_mm=0.0001",), 0.0005, 0.001, id="finer than the digits"),
    ],
)
def test_points_lie_on_steps(program: str, sets: tuple[str, ...], x_mm: float, z_mm: float) -> None:
    run = run_program(filtered(program, "generic-lathe", *sets))
    (cut,) = run.cuts
    assert cut[-1].end[2] == pytest.approx(-30.0, abs=1e-9)
    for move in cut[:-1]:
        assert off_step(move.end[0], x_mm) < 1e-6
        assert off_step(move.end[2], z_mm) < 1e-6
    assert chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe", sets)).changed


def test_the_end_off_the_steps_is_the_programmed_one() -> None:
    program = CUT.replace("Z-30.", "Z-30.001")
    (cut,) = run_program(filtered(program, "generic-lathe", "axes.Z.increment_mm=0.004")).cuts
    assert cut[-1].end[2] == pytest.approx(-30.001, abs=1e-9)


def test_the_verdict_is_that_of_the_steps() -> None:
    fine = verdict(CUT)
    assert verdict(CUT, "control.increment_mm=0.001") == fine
    margin, longest = verdict(CUT, "axes.Z.increment_mm=0.004")
    assert margin < fine[0]
    assert longest > fine[1]
    # Steps that the digits do not show: the axes round what is printed.
    hidden, _ = verdict(CUT, "axes.Z.steps_per_mm=130")
    assert hidden < fine[0]


def test_a_stroke_of_few_steps_is_refused() -> None:
    found = chipbreak.check(CUT.encode(), chipbreak.load("generic-lathe", ["axes.Z.increment_mm=0.02"]))
    assert [one.code for one in found] == ["VIB059"]
    assert found[0].help == "give a larger Q or A"  # more decimals would change nothing
    larger = CUT.replace("N1.5", "N1.5 Q2.")
    assert larger != CUT
    (cut,) = chipbreak.rewrite(
        larger.encode(), chipbreak.load("generic-lathe", ["axes.Z.increment_mm=0.02"])
    ).cuts
    assert cut.verdict.breaks


def test_loops_go_in_steps_too() -> None:
    settings = chipbreak.load("fanuc-lathe", ["axes.Z.increment_mm=0.002", "output.form=loop"])
    result = chipbreak.rewrite(CUT.encode(), settings)
    assert result.cuts[0].verdict.breaks
    assert b"WHILE" in result.data


def test_one_way_to_say_the_step() -> None:
    both = ["axes.Z.increment_mm=0.004", "axes.Z.steps_per_mm=250"]
    with pytest.raises(chipbreak.SettingsError) as caught:
        chipbreak.load("generic-lathe", both)
    assert caught.value.diagnostic.code == "SET003"


# --- path mode --------------------------------------------------------------------------------------------

ON_LINUXCNC = "G97 S3000 M3\nG95 F0.05\nG7 G18\nG0 X20. Z2.\n{said}G1 Z-30. N1.5\nG0 X30.\nM30\n"


@pytest.mark.parametrize("usual", ["G61", "G61.1", "G64", "G64 P0.01"])
@pytest.mark.parametrize("around", ["G61", "G61.1", "G64 P0.001"])
@pytest.mark.parametrize("said", ["", "G64 P0.02\n"], ids=["nothing said", "said"])
def test_the_usual_path_mode_comes_back(usual: str, around: str, said: str) -> None:
    sets = ["planner.model=ideal", f'planner.usual_path_mode="{usual}"', f'planner.path_mode="{around}"']
    program = ON_LINUXCNC.format(said=said)
    result = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-lathe", sets))
    lines = result.data.decode().splitlines()
    modes = [line for line in lines if line.startswith("G6")]
    assert modes[len(said.splitlines()) :] == [around, said.strip() or usual]


def test_nothing_comes_back_where_the_control_has_no_other_mode() -> None:
    """As on a control that has G61 and no G64."""
    settings = chipbreak.load("fanuc-mill", ['planner.path_mode="G61"', "checks.enabled=false"])
    dialect = settings.dialect
    without = dialect._replace(
        g_codes={number: code for number, code in dialect.g_codes.items() if number != 640},
        initial=dialect.initial._replace(path=""),
    )
    planner = replace(settings.planner, usual_path_mode="")
    program = "G95 F0.05\nS3000 M3\nG0 X20. Y2. Z0.\nG1 X-30. N1.5\nM30\n"
    result = chipbreak.rewrite(program.encode(), replace(settings, dialect=without, planner=planner))
    lines = result.data.decode().splitlines()
    assert [line for line in lines if line.startswith("G6")] == ["G61"]


def test_a_usual_mode_is_needed_where_there_are_several() -> None:
    sets = ['planner.path_mode="G61"', 'planner.usual_path_mode=""']
    with pytest.raises(chipbreak.SettingsError):
        chipbreak.load("linuxcnc-lathe", sets)


@pytest.mark.parametrize("steps_per_mm", [320.0, 400.0, 533.33, 1500.0])
@pytest.mark.parametrize(("units", "feed"), [("G20", "6."), ("G21", "150.")])
@pytest.mark.parametrize("decimals", [2, 4])
def test_incremental_cuts_end_where_they_should_on_any_steps(
    steps_per_mm: float, units: str, feed: str, decimals: int
) -> None:
    """A step need not end with the digits of the output: what is printed adds up all the same."""
    program = (
        f"{units} G90 G94 G18 G7\nS1500 M3\nG0 X10. Z2.\nG91\nG1 Z-8. F{feed} N0.5\nG1 X1. Z-3.\n"
        "G90\nG0 X20.\nM30\n"
    )
    sets = [f"axes.{axis}.max_acceleration_mm_s2=1000" for axis in "XZ"]
    sets += [f"axes.Z.steps_per_mm={steps_per_mm}", f"output.decimals={decimals}"]
    profile = chipbreak.load("grblhal-lathe", sets)
    result = chipbreak.rewrite(program.encode(), profile)
    assert len(result.cuts) == 1
    assert verify_filtered(result.data, profile).cuts


@pytest.mark.parametrize(
    ("blocks", "speed", "steps", "sets"),
    [
        pytest.param(
            ["G1 X10. Y0.235 F6.06", "G3 X10.749 Y-0.936 I1.29 J0.", "G1 X10.949 Y-1.956"],
            "S60 (VIB N2.5)",
            (80, 250),
            ["output.feed_mode=inverse"],
            id="the axes stand at the end before the last block",
        ),
        pytest.param(
            ["G1 X10. Y0.06 F27.8", "G3 X11.5 Y-1.44 I1.5 J0.", "G1 X12.44 Y-1.44"],
            "S200 (VIB N1.25 Q1.84)",
            (1280, 1280),
            ["vibration.alpha=0.4"],
            id="words say every second step",
        ),
    ],
)
def test_coarse_steps_pass_their_self_check(
    blocks: list[str], speed: str, steps: tuple[int, int], sets: list[str]
) -> None:
    lines = ["G21 G90 G17 G94", "G0 X10. Y1.", f"M3 {speed}", *blocks, "(VIB OFF)", "G0 X30.", "M2"]
    sets = [*sets, "vibration.end=dwell", "output.decimals=3", "planner.junction_deviation_mm=0.005"]
    for axis, count, acceleration in zip("XY", steps, (500, 200), strict=True):
        sets.append(f"axes.{axis}.max_acceleration_mm_s2={acceleration}")
        sets.append(f"axes.{axis}.steps_per_mm={count}")
    program = "\n".join(lines) + "\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("grbl", sets), allow_unbroken=True)
    assert len(result.cuts) == 1


@pytest.mark.parametrize(
    ("end", "steps"),
    [("9.326", 2331), ("9.33", 2333), ("3.002", 750), ("5.038", 1259), ("7.734", 1933), ("1.002", 251)],
)
def test_an_end_between_two_steps_goes_by_lost_digits(end: str, steps: int) -> None:
    """Where Grbl 1.1h and grblHAL stand at 250 steps per mm behind a move to each of these places."""
    profile = chipbreak.load("grblhal-lathe", ["axes.X.steps_per_mm=250"])
    state = State(profile.dialect.initial)
    place = end_reached(np.array([float(end), 0.0, 0.0]), np.zeros(3), profile, state)
    assert place[0] * 250.0 == pytest.approx(steps)


def test_words_between_two_steps_are_not_written() -> None:
    """Every second step of 0.0008 mm in words of 0.001 mm: 0.002 would be two and a half."""
    words = np.array([0.002, 0.003, 0.004, 0.006])
    meant = np.array([0.0016, 0.0032, 0.004, 0.0064])
    moved = off_halves(words, meant, np.array(0.0008), 3)
    assert moved == pytest.approx([0.001, 0.003, 0.004, 0.007])
