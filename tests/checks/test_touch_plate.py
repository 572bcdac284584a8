"""Checks on a touch plate, written out for a control without macros; judged by a model of such a control."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.checks.calls import calls_of
from chipbreak.text.diagnostics import RefusalError
from plain_probe import AlarmError, Control

OPTIONS = [
    "checks.enabled=true",
    "checks.calls=setter",
    "macros.setter_x_mm=-10",
    "macros.setter_y_mm=-20",
    "macros.setter_z_mm=-120",
    "macros.safe_z_mm=-2",
]
TOOL_MM = 60.0
SLACK_MM = 0.005  # the axis runs on, and numbers have so many digits

MM = """(T1 D=6 FLAT END MILL)
G90 G21 G94 {offset}
T1
M0
S1000 M3
(ADAPTIVE1)
G0 X1 Y2
G0 Z15
M8
G1 Z-1 F50
X5
G0 Z15
(FINISH)
G91
G0 X-2
G1 Z-17
X5 F70
G0 Z17
G90
M5
M9
M30
"""
INCH = (
    MM.replace("G21", "G20")
    .replace("F50", "F5")
    .replace("F70", "F7")
    .replace("Z15", "Z.6")
    .replace("17", ".7")
)
BRACKET = re.compile(r"\(CHIPBREAK BEGIN (.*?)\)\n(.*?)\(CHIPBREAK END \w+\)\n", re.S)


def filtered(program: str, *options: str) -> str:
    done = chipbreak.rewrite(program.encode(), chipbreak.load("grbl", [*OPTIONS, *options]))
    assert not [one for one in done.diagnostics if one.code.startswith("CHK")]
    return done.data.decode()


def pieces(text: str) -> list[tuple[str, str]]:
    """(title of the checks, text), in the order of the program; the title is empty for its own blocks."""
    parts = BRACKET.split(text)
    found = [("", parts[0])]
    for title, inside, own in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        found += [(title, inside), ("", own)]
    return found


def run(text: str, control: Control, changes_mm: dict[str, float]) -> str:
    """Run a program; the alarm, "" for none.  Before the checks of a title the tool becomes longer."""
    for title, blocks in pieces(text):
        if control.tool_mm is not None:
            control.tool_mm += changes_mm.get(title, 0.0)
        try:
            control.run(blocks)
        except AlarmError as alarm:
            return f"{title.split(' T')[0]}: alarm {alarm.number}"
    return ""


@pytest.mark.parametrize("offset", ["G54", "G57"])
@pytest.mark.parametrize("program", [MM, INCH], ids=["mm", "inch"])
@pytest.mark.parametrize("tool_mm", [21.0, TOOL_MM, 100.0])
def test_a_good_tool_passes_and_all_is_as_it_was(program: str, offset: str, tool_mm: float) -> None:
    plain = program.format(offset=offset)
    text = filtered(plain)
    assert "".join(own for title, own in pieces(text) if not title) == plain
    with_checks = Control(tool_mm)
    without = Control(tool_mm)
    for title, blocks in pieces(text):
        if title:
            with_checks.run(blocks)
            continue
        for line in blocks.splitlines():
            with_checks.run(line)
            without.run(line)
            if re.search("[XYZ]", line) and "G53" not in line:
                assert with_checks.at_mm[:2] == pytest.approx(without.at_mm[:2], abs=1e-3)
            if "G1" in line or line.startswith("X"):
                assert with_checks.at_mm == pytest.approx(without.at_mm, abs=1e-3)
                assert with_checks.modes == without.modes
    assert with_checks.deepest_press_mm < 0.1


@pytest.mark.parametrize("program", [MM, INCH], ids=["mm", "inch"])
@pytest.mark.parametrize(
    ("title", "w_mm"), [("CHIP CHECK T1 W0.02", 0.02), ("CHIP CHECK T1 W0.05", 0.05)], ids=["finish", "rough"]
)
def test_the_limit_w_counts_both_ways(program: str, title: str, w_mm: float) -> None:
    text = filtered(program.format(offset="G54"))
    alarms = {
        changed: run(text, Control(TOOL_MM), {title: changed})
        for changed in (-20.0, -w_mm - SLACK_MM, -w_mm + SLACK_MM, w_mm - SLACK_MM, w_mm + SLACK_MM, 20.0)
    }
    assert list(alarms.values()) == ["CHIP CHECK: alarm 5"] * 2 + [""] * 2 + ["CHIP CHECK: alarm 4"] * 2


def test_no_tool_and_a_shorted_plate() -> None:
    text = filtered(MM.format(offset="G54"))
    assert run(text, Control(None), {}) == "TOOL CHECK: alarm 5"
    assert run(text, Control(5.0), {}) == "TOOL CHECK: alarm 5"  # shorter than setter_z_mm says
    assert run(text, Control(TOOL_MM, is_shorted=True), {}) == "TOOL CHECK: alarm 4"


@pytest.mark.parametrize("acceleration_mm_s2", [10.0, 500.0])
def test_a_slow_axis_is_not_driven_onto_the_plate(acceleration_mm_s2: float) -> None:
    control = Control(TOOL_MM, acceleration_mm_s2=acceleration_mm_s2)
    assert run(filtered(MM.format(offset="G54")), control, {}) == ""
    assert control.deepest_press_mm < 0.35


def test_the_new_tool_is_measured_behind_the_stop_at_which_it_is_changed() -> None:
    program = MM.format(offset="G54").replace(
        "M5\n", "M5\nM0\nT2\nM0\nS900 M3\nG0 X1 Y2\nZ15\nG1 Z-1 F50\nG0 Z15\nM5\n"
    )
    titles = [title or own for title, own in pieces(filtered(program))]
    changes = [n for n, text in enumerate(titles) if "T2\nM0" in text]
    assert len(changes) == 1
    assert titles[changes[0] - 1].startswith("CHIP CHECK T1")
    assert titles[changes[0]].startswith("M0\nT2\nM0\n")
    assert titles[changes[0] + 1] == "TOOL CHECK T2"


@pytest.mark.parametrize(
    ("old", "new", "used"),
    [
        ("G90\nM5", "G90 G59\nM5", "G59"),
        ("(FINISH)", "G92 X0\n(FINISH)", "G92"),
        ("(FINISH)", "G10 L2 P1 X0\n(FINISH)", "G10"),
        ("(FINISH)", "G43.1 Z1\n(FINISH)", "G43.1"),
        ("(FINISH)", "G93\n(FINISH)", "G93"),
    ],
)
def test_what_would_move_the_stored_length_is_refused(old: str, new: str, used: str) -> None:
    program = MM.format(offset="G54").replace(old, new)
    done = chipbreak.rewrite(program.encode(), chipbreak.load("grbl", OPTIONS))
    found = [one for one in done.diagnostics if one.code == "CHK012"]
    assert not done.changed
    assert [used in one.message and one.help.startswith("use G54 to G58") for one in found] == [True]


@pytest.mark.parametrize(
    ("old", "why"),
    [("G90 ", "distance mode"), ("G21 ", "units"), ("{offset}", "work offset"), (" F50", "F of the check")],
)
def test_what_could_not_be_given_back_must_be_said(old: str, why: str) -> None:
    program = MM.replace("T1\nM0", "T1").replace(old, "").format(offset="G54")
    done = chipbreak.rewrite(program.encode(), chipbreak.load("grbl", OPTIONS))
    found = [one for one in done.diagnostics if one.code == "CHK002"]
    assert found
    assert any(why in one.message for one in found)
    assert all(one.help.startswith("say ") for one in found)


def test_a_plate_must_lie_below() -> None:
    with pytest.raises(RefusalError) as caught:
        calls_of(chipbreak.load("grbl", [*OPTIONS, "macros.safe_z_mm=-120"]))
    assert caught.value.code == "SET037"


def test_a_place_that_nobody_gave_is_asked_for() -> None:
    done = chipbreak.rewrite(MM.format(offset="G54").encode(), chipbreak.load("grbl", OPTIONS[:4]))
    (found,) = [one for one in done.diagnostics if one.code.startswith("CHK")]
    assert found.code == "CHK011"
    assert found.message.endswith("no macros.setter_z_mm, macros.safe_z_mm")


@pytest.mark.parametrize(
    ("profile", "why", "way_out"),
    [
        ("grbl", "no variables, so runout, diameter and edges cannot be measured", "set checks.calls=setter"),
        ("klipper", "it has no G38", "describe your own"),
        ("grblhal-lathe", "the macros measure tools that turn", "describe your own"),
    ],
)
def test_what_a_control_cannot_measure_is_refused_with_the_reason(
    profile: str, why: str, way_out: str
) -> None:
    with pytest.raises(RefusalError) as caught:
        calls_of(chipbreak.load(profile, ["checks.enabled=true"]))
    assert caught.value.code == "SET030"
    assert why in caught.value.message
    assert way_out in caught.value.help


def test_in_inches_the_plate_is_where_it_is_in_mm() -> None:
    text = filtered(INCH.format(offset="G54"))
    (place, *_) = re.findall(r"G53 G0 X(\S+) Y(\S+)", text)
    # Half of the last of four decimals.
    assert [float(inches) * 25.4 for inches in place] == pytest.approx([-10.0, -20.0], abs=0.00005 * 25.4)
