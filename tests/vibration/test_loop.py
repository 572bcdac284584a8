"""The loop form against the expanded one, both run by the tests' own machine."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import assume, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.kinematics.waveform import sample
from chipbreak.settings import SettingsError
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.source import read
from machine_reader import Run, filtered, points, rejected, run_program, times

LOOP = "output.form=loop"
FANUC = chipbreak.load("fanuc-lathe", [LOOP])
TURNING = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-48. F0.05 N1.5\nG0 X30.\nM30\n"


def written_out(text: str) -> str:
    """Every loop block by block, as a control runs it: the tests' own reading."""
    out: list[str] = []
    lines = iter(text.splitlines())
    for line in lines:
        head = re.fullmatch(r"WHILE\[(#\d+)LT(\d+)\]DO(\d)|o(\d+) repeat \[(\d+)\]", line)
        if head is None:
            out.append(line)
            continue
        variable, fanuc, label, o_word, linuxcnc = head.groups()
        body = []
        foot = f"END{label}" if label else f"o{o_word} endrepeat"
        while (inner := next(lines)) != foot:
            body.append(inner)
        if label:
            assert out.pop() == f"{variable}=0"
            assert body.pop() == f"{variable}={variable}+1"
        assert not any(mark in inner for inner in body for mark in "#[o")
        out += body * int(fanuc or linuxcnc)
    return "\n".join(out) + "\n"


def both(program: str, profile: str, *sets: str, diameter: bool = True) -> tuple[Run, Run, str]:
    """The expanded form, run; the loop form, run; and its text."""
    expanded = filtered(program, profile, *sets, allow_unbroken=True)
    loop = filtered(program, profile, LOOP, *sets, allow_unbroken=True)
    mode = "minute" if "linuxcnc" in profile else "rev"
    runs = [run_program(t, diameter=diameter, feed_mode=mode) for t in (expanded, written_out(loop))]
    return runs[0], runs[1], loop


def cuts_of(program: str, profile: str, *sets: str) -> tuple[chipbreak.Result, list[float]]:
    """The result in loop form, and how far the points of each cut may lie from the exact motion [steps]."""
    settings = chipbreak.load(profile, [LOOP, *sets])
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    loops = [cut.expansion.loops or () for cut in result.cuts]
    return result, [0.5 + max((loop.drift_steps / 2 for loop in one), default=0.0) for one in loops]


# --- the same motion --------------------------------------------------------------------------------------

ON_AN_AXIS = [
    pytest.param("G1 Z-48. F0.05 N1.5", (), id="turning"),
    pytest.param("G1 Z-48. F0.1 N3.5", (), id="seven vibrations in two turns"),
    pytest.param("G1 Z-48. F0.07 E2", (), id="two turns a vibration"),
    pytest.param("G1 X4. F0.1 N1.5", (), id="facing"),
    pytest.param("G1 W-50. F0.05 N1.5", (), id="incremental"),
    pytest.param("G1 Z-48. F0.05 N1.5", ("output.segments=tick", "vibration.waveform=sine"), id="sine"),
    pytest.param("G1 Z-48. F0.08 N1.25", ("vibration.alpha=0.75",), id="uneven"),
    pytest.param("G1 Z-48. F0.05 N1.5", ("vibration.ramp_vibrations=0",), id="no ramp"),
    pytest.param(
        "G1 Z-48. F0.05 N1.5", ("vibration.ramp_vibrations=0", "vibration.end_revolutions=0"), id="no ends"
    ),
    pytest.param("G1 Z-48. F0.05 N1.5", ("control.lathe_system=B",), id="G91"),
    pytest.param("G1 Z-48. F0.05 N1.5", ("axes.Z.sign=-1",), id="the work moves"),
]


@pytest.mark.parametrize(("block", "sets"), ON_AN_AXIS)
def test_on_an_axis_the_motion_is_that_of_the_expanded_form(block: str, sets: tuple[str, ...]) -> None:
    program = TURNING.replace("G1 Z-48. F0.05 N1.5", block)
    expanded, loop, text = both(program, "fanuc-lathe", *sets)
    (one,), (other,) = expanded.cuts, loop.cuts
    assert "WHILE[" in text
    assert len(one) == len(other)
    gap = np.abs(points(one) - points(other)).max(axis=1)
    # A place that lies half way between two steps may be rounded either way.
    assert gap.max() <= 0.001 + 1e-9
    assert (gap > 1e-9).mean() < 0.01
    assert points(other)[-1] == pytest.approx(points(one)[-1], abs=1e-9)
    assert times(other) == pytest.approx(times(one), rel=1e-3, abs=1e-3)
    assert {move.speed_rpm for move in one} == {move.speed_rpm for move in other}
    assert loop.state == expanded.state


@pytest.mark.parametrize(("block", "sets"), ON_AN_AXIS)
def test_loops_save_memory_and_are_stable(block: str, sets: tuple[str, ...]) -> None:
    program = TURNING.replace("G1 Z-48. F0.05 N1.5", block)
    expanded = filtered(program, "fanuc-lathe", *sets, allow_unbroken=True)
    loop = filtered(program, "fanuc-lathe", LOOP, *sets, allow_unbroken=True)
    assert len(loop) < len(expanded) / 5
    assert filtered(loop, "fanuc-lathe", LOOP, *sets, allow_unbroken=True) == loop
    assert restore(read(loop.encode())).data.decode() == program


@st.composite
def cuts(draw: st.DrawFn) -> tuple[str, tuple[str, ...]]:
    """One cut or a chain of two, in any direction, with any feed, speed and count."""
    dx, dz = draw(st.sampled_from([(0.0, -1.0), (-0.4, 0.0), (0.3, -1.0), (-0.2, -0.7), (0.0, 1.0)]))
    size = draw(st.floats(6.0, 40.0))
    style = draw(st.sampled_from(["absolute", "G91", "UW"]))
    x, z = (round(d * size, 3) for d in (2 * dx, dz))
    end = f"X{60.0 + x:.3f} Z{5.0 + z:.3f}"
    if style != "absolute":
        end = f"X{x:.3f} Z{z:.3f}" if style == "G91" else f"U{x:.3f} W{z:.3f}"
    switch = "G91\n" if style == "G91" else ""
    behind = draw(st.sampled_from(["", "", f"{'U' if style == 'UW' else 'X'}{4.0 if switch else 75.0}\n"]))
    behind = "" if style == "UW" else behind
    feed = draw(st.sampled_from([0.05, 0.07, 0.1, 0.123, 0.2]))
    count = draw(st.sampled_from(["N0.5", "N1.5", "N2.4", "N3.5", "E3"]))
    speed = draw(st.integers(500, 3000))
    program = (
        f"G97 S{speed} M3\nG95 G0 X60. Z5.\n{switch}(VIB {count})\nG1 {end} F{feed}\n{behind}(VIB OFF)\n"
        "G90 G0 X200. Z100.\nM30\n"
    )
    segments = draw(st.sampled_from(["tick", "stroke"]))
    wave = "triangle" if segments == "stroke" else draw(st.sampled_from(["triangle", "sine"]))
    sets = (
        "control.lathe_system=B",
        f"output.segments={segments}",
        f"vibration.waveform={wave}",
        f"vibration.ramp_vibrations={draw(st.sampled_from([0, 3]))}",
    )
    return program, sets


@pytest.mark.few(6)
@given(cuts())
@hypothesis_settings(max_examples=30)
def test_no_point_leaves_the_exact_motion_by_more_than_promised(cut: tuple[str, tuple[str, ...]]) -> None:
    program, sets = cut
    try:
        result, bounds = cuts_of(program, "fanuc-lathe", *sets)
    except chipbreak.ProgramRejectedError:
        assume(False)
    assume(result.cuts)  # too short a cut may stay plain here
    (checked,), (bound,) = result.cuts, bounds
    loops = checked.expansion.loops or ()
    event("loops" if loops else "no loop")
    event("drift" if bound > 0.5 else "alike")
    (real,) = run_program(written_out(result.data.decode())).cuts
    assert len(real) == checked.move_count
    # Where the blocks should end in the exact motion, by the time at which they should.
    plan, ends_s = checked.plan, np.append(0.0, checked.expansion.time_s)
    wanted = plan.path.points(np.interp(ends_s, *sample(plan.wave)))
    step = np.array([0.0005, 0.001, 0.001])
    away = np.abs(points(real) - wanted) / step
    # An incremental program counts from its start, so its points have the digits of that.
    assert away[:-1].max() <= bound + 0.02
    assert bound <= 0.5 + 0.125
    assert points(real)[-1] == pytest.approx(wanted[-1], abs=1e-7)
    assert times(real)[-1] == pytest.approx(plan.wave.duration_s, rel=0.004)
    again = chipbreak.rewrite(result.data, chipbreak.load("fanuc-lathe", [LOOP, *sets]), allow_unbroken=True)
    assert again.data == result.data
    assert restore(read(result.data)).data.decode() == program


# --- what a loop is made of -------------------------------------------------------------------------------


def test_only_the_vibrations_of_full_stroke_on_a_line_are_looped() -> None:
    chain = "G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-10. F0.05\nG3 X40. Z-20. R10.\nG1 X60.\nM30\n"
    text = filtered(chain, "fanuc-lathe", LOOP)
    assert text.count("WHILE[") == 2
    assert text.count("#33=0") == 2
    assert all(re.search(r"^[UW]", body) for body in re.findall(r"DO1\n(.*?)\n#33", text, re.DOTALL))


def test_a_vibration_stands_between_two_loops() -> None:
    """Blocks that go straight on, joined where one vibration ends: each loop starts from its own point."""
    swing, dwell = "S2500 M3\n(VIB N1.5)", "S1200 M3\n(VIB E2.4 WAVE DWELL)"
    for joint, wish in (("-18.", swing), ("-18.01", swing), ("-12.4", dwell), ("-12.333", dwell)):
        chain = f"G97 {wish}\nG0 X20. Z2.\nG1 Z{joint} F0.12\nZ-38.\n(VIB OFF)\nM30\n"
        expanded, loop, text = both(chain, "fanuc-lathe")
        assert text.count("WHILE[") == 2
        (one,), (other,) = expanded.cuts, loop.cuts
        assert np.abs(points(one) - points(other)).max() <= 0.001 + 1e-9


def test_statements_are_reckoned_with_where_blocks_per_second_are_limited() -> None:
    """200 a second, 125 of them motion: a pass with its three statements has three vibrations or more."""
    program = TURNING.replace("F0.05", "F0.06")  # 0.04 mm in a vibration: one would do
    short = filtered(program, "fanuc-lathe", LOOP)
    assert len(re.findall(r"(?m)^W-?[0-9]", short)) == 2
    slow = filtered(program, "fanuc-lathe", LOOP, "planner.max_blocks_per_s=200")
    assert len(re.findall(r"(?m)^W-?[0-9]", slow)) == 2 * 3
    assert rejected(program, "fanuc-lathe", LOOP, "planner.max_blocks_per_s=100")[0][0] == "VIB032"


def test_on_linuxcnc_a_pass_takes_whole_servo_periods() -> None:
    """Of 49.75 ms: only four vibrations, or eight, take whole periods."""
    program = "G21 G18 G90 G8 G97 G95 S1200 M3\nG0 X10 Z1\nG1 Z-20 F0.1 f20.1005 N1.5\nM2\n"
    sets = ("command.periods_ms=[49.75]", "axes.Z.max_acceleration_mm_s2=20000", "vibration.q=3")
    result, _ = cuts_of(program, "linuxcnc-lathe", *sets)
    (cut,) = result.cuts
    assert cut.expansion.loops
    for loop in cut.expansion.loops:
        assert loop.vibrations % 4 == 0
    assert cut.duration_s == pytest.approx(cut.wave.duration_s, rel=1e-3)


def test_explain_says_what_repeats() -> None:
    result, _ = cuts_of(TURNING, "fanuc-lathe")
    report = chipbreak.explain(result, FANUC)
    assert "loop     3 vibrations 497 times; 21 blocks of motion" in str(report).split("\n    ")[-1]
    (cut,) = report.as_dict()["cuts"]
    assert cut["loops"] == [{"vibrations": 3, "passes": 497, "drift_steps": 0.0, "blocks": 6}]
    assert cut["moves"] == 2997
    arc, _ = cuts_of(TURNING.replace("G1 Z-48.", "G3 X40. Z-8. R10."), "fanuc-lathe")
    assert "loop     none" in str(chipbreak.explain(arc, FANUC))


# --- reading back -----------------------------------------------------------------------------------------


def test_a_loop_form_is_judged_as_it_stands() -> None:
    """By a profile that would write the expanded form too: the motion is the same."""
    loop = filtered(TURNING, "fanuc-lathe", LOOP)
    settings = chipbreak.load("fanuc-lathe", [])
    from chipbreak.pipeline import verify_filtered

    (cut,) = verify_filtered(loop.encode(), settings).cuts
    assert cut.move_count == 2997
    assert cut.verdict.breaks


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("LT497]", "LT496]"),
        ("#33=#33+1", "#33=#34+1"),
        ("#33=#33+1", "#33=#33+2"),
        ("W-0.077 F0.2310", "W-0.080 F0.2310"),
        ("W-0.077 F0.2310", "W-0.077 F0.2910"),
        ("END1", "END2"),
    ],
)
def test_a_loop_that_does_something_else_is_found(text: str, other: str) -> None:
    from chipbreak.editing import bracket
    from chipbreak.pipeline import verify_filtered

    loop = filtered(TURNING, "fanuc-lathe", LOOP)
    head, body, tail = re.split(r"(?<=STROKE 0.06\)\n)(.*?)(?=\(CHIPBREAK END)", loop, maxsplit=1, flags=re.S)
    body = body.replace(text, other, 1)
    tail = re.sub("END [0-9A-F]{8}", f"END {bracket.checksum(body.encode())}", tail, count=1)
    with pytest.raises(SelfCheckError):
        verify_filtered((head + body + tail).encode(), chipbreak.load("fanuc-lathe", [LOOP]))


def test_line_ends_of_the_file() -> None:
    for end in ("\r\n", "\r"):
        out = filtered(TURNING.replace("\n", end), "fanuc-lathe", LOOP)
        assert out.replace(end, "\n") == filtered(TURNING, "fanuc-lathe", LOOP)


def test_names_that_the_program_needs_are_not_taken() -> None:
    used = "#100=3\n#33=#100\n"
    assert rejected(used + TURNING, "fanuc-lathe", LOOP) == [("VIB080", 5, 16)]
    assert "#101=#101+1" in filtered(used + TURNING, "fanuc-lathe", LOOP, "output.loop_variable=101")
    looped = "#1=0\nWHILE[#1LT2]DO1\n#1=#1+1\nEND1\n" + TURNING
    assert "DO2" in filtered(looped, "fanuc-lathe", LOOP)


def test_a_counter_that_the_control_has_not_is_refused() -> None:
    with pytest.raises(SettingsError) as caught:
        chipbreak.load("fanuc-mill", [LOOP, "output.loop_variable=50"])
    assert caught.value.diagnostic.code == "SET003"
    assert "100 to 199" in caught.value.diagnostic.help
    assert chipbreak.load("linuxcnc-lathe", [LOOP, "output.loop_variable=50"])  # it counts by itself


def test_a_control_without_a_known_loop_is_refused() -> None:
    with pytest.raises(SettingsError) as caught:
        chipbreak.load("generic-lathe", [LOOP])
    assert caught.value.diagnostic.code == "SET003"
    assert "fanuc-lathe" in caught.value.diagnostic.help
