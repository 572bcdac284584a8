"""From the program of the machine test over a machine nobody knows to its profile, and to cuts on it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import chipbreak
from bench_machine import drawn_cut, drawn_machine, fanuc_cut, groups_of, held, measured_profile, recorded
from bench_planners import PLANNER, drawn_klipper, klipper_cut, klipper_profile
from chipbreak.cli import cli
from stepped_machine import Machine

MACHINE = Machine((0.016,), (0.02,))


def run(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(cli, ["machine-test", *arguments])
    return done.exit_code, done.output


@pytest.fixture
def written(tmp_path: Path) -> Path:
    code, said = run("write", "-p", "fanuc-lathe", "-o", str(tmp_path / "t.nc"), "--axes", "Z")
    assert code == 0, said
    return tmp_path


@pytest.mark.parametrize("seed", [pytest.param(2, marks=pytest.mark.long), 3])
def test_cuts_on_a_measured_machine_are_as_promised(seed: int, tmp_path: Path) -> None:
    draw = np.random.default_rng(seed)
    _, machine = drawn_machine(draw)
    profile = measured_profile(machine, draw, tmp_path)
    within = held(machine, tmp_path)
    assert within
    assert all(within)
    settling_s = sum(machine.averages_s) + 7.0 * sum(machine.lags_s)
    found = [fanuc_cut(drawn_cut(draw, settling_s), profile, machine) for _ in range(3)]
    kept = [one for one in found if one is not None]
    assert len(kept) >= 2
    assert max(one.count_error for one in kept) <= 0.01
    assert max(one.stroke_error for one in kept) <= 0.05
    assert all(one.same_verdict for one in kept)


@pytest.mark.long
@pytest.mark.parametrize("seed", [7017, 7015])
def test_a_look_ahead_is_found_before_what_stands_behind_it(seed: int, tmp_path: Path) -> None:
    """Behind two lags alike, or a bell: searched for together, all its numbers go astray."""
    draw = np.random.default_rng(seed)
    _, machine = drawn_machine(draw)
    measured_profile(machine, draw, tmp_path)
    said = json.loads((tmp_path / "said.json").read_text())
    found = {one["key"]: one["value"] for one in said["measured"]}
    assert found["planner.joint_speed_mm_min"] == pytest.approx(60.0 * machine.joint_mm_s, rel=0.01)
    assert found["axes.Z.max_acceleration_mm_s2"] == pytest.approx(machine.ramp_mm_s2, rel=0.01)


def test_two_lags_of_which_one_is_short_are_found(tmp_path: Path) -> None:
    """In too few rounds they were taken for a bell, and 20 % of a stroke was promised that there is not."""
    draw = np.random.default_rng(9002)
    _, machine = drawn_machine(draw)
    profile = chipbreak.load(measured_profile(machine, draw, tmp_path))
    axis = profile.axes["Z"]
    assert axis.acc_dec == "exponential"
    lags_ms = sorted([1000.0 / (axis.position_gain_1_s or 1.0), axis.acc_dec_ms or 0.0])
    assert lags_ms == pytest.approx([1000.0 * lag_s for lag_s in sorted(machine.lags_s)], rel=0.02)


@pytest.mark.long
@pytest.mark.klipper
@pytest.mark.skipif(
    not (PLANNER / "klippy" / "toolhead.py").is_file(), reason="Klipper's planner is not here"
)
def test_cuts_on_a_machine_of_which_only_times_are_known(tmp_path: Path) -> None:
    draw = np.random.default_rng(2)
    machine = drawn_klipper(draw)
    profile = klipper_profile(machine, draw, tmp_path)
    kept = [one for one in (klipper_cut(machine, profile, draw) for _ in range(2)) if one is not None]
    assert kept
    assert max(one.count_error for one in kept) <= 0.01
    assert max(one.stroke_error for one in kept) <= 0.05
    assert all(one.same_verdict for one in kept)


@pytest.mark.parametrize(
    "profile",
    ["fanuc-lathe", "fanuc-mill", "linuxcnc-lathe", "grblhal-lathe", "grbl", "klipper", "haas-lathe"],
)
def test_the_program_is_read_and_stays_where_it_says(profile: str, tmp_path: Path) -> None:
    program = tmp_path / "t.nc"
    assert run("write", "-p", profile, "-o", str(program))[0] == 0
    data = program.read_bytes()
    assert chipbreak.rewrite(data, chipbreak.load(profile)).data == data
    assert all("." in number for number in re.findall(r"^(?:G1 )?[XYZUVW](-?[\d.]+)", data.decode(), re.M))
    for group in groups_of(data.decode(), x_is_diameter="lathe" in profile and "grbl" not in profile):
        for ways in ([block.x_mm for block in group], [block.z_mm for block in group]):
            places = np.cumsum(ways)
            assert places.min(initial=0.0) >= -1e-9
            assert places.max(initial=0.0) <= 10.0 + 1e-9
            assert not ways or abs(places[-1]) < 1e-9


def test_klipper_gets_no_code_that_it_does_not_know(tmp_path: Path) -> None:
    """Its host runs the file: nothing stops at M0 there, so the program gives time instead."""
    program = tmp_path / "t.nc"
    assert run("write", "-p", "klipper", "-o", str(program))[0] == 0
    codes = [line.split(";")[0].split() for line in program.read_text().splitlines()]
    assert {words[0] for words in codes if words} == {"G1", "G4", "G21", "G90", "G91"}
    assert next(words for words in codes if words) == ["G4", "P10000."]


@pytest.mark.linuxcnc("interpreter")
def test_linuxcnc_reads_its_program(tmp_path: Path) -> None:
    if shutil.which("rs274") is None:
        pytest.skip("LinuxCNC is not here")
    program = tmp_path / "t.ngc"
    assert run("write", "-p", "linuxcnc-lathe", "-o", str(program))[0] == 0
    done = subprocess.run(["rs274", "-g", str(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("STRAIGHT_FEED") == sum(
        map(len, groups_of(program.read_text(), x_is_diameter=False))
    )


def test_times_alone_say_what_they_cannot_tell(written: Path) -> None:
    form = written / "t.toml"
    groups = groups_of((written / "t.nc").read_text(), x_is_diameter=True)
    times = recorded(groups, {"Z": MACHINE}, np.random.default_rng(1)).times_s
    text = form.read_text()
    for time_s in times:
        text = text.replace("ms = 0  #", f"ms = {time_s * 1000.0:.0f}  #", 1)
    form.write_text(text)
    code, said = run("read", str(form), "-o", str(written / "p.toml"))
    assert code == 0, said
    assert chipbreak.load(written / "p.toml").planner.model == "after-interpolation"
    assert "times do not show what the axis makes of its command" in said


def test_nothing_filled_in_is_refused(written: Path) -> None:
    code, said = run("read", str(written / "t.toml"))
    assert (code, "MTS005" in said) == (2, True)


def test_a_form_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "t.toml").write_text("[[group]]\nname = 1\n")
    code, said = run("read", str(tmp_path / "t.toml"))
    assert (code, "MTS002" in said) == (2, True)


def test_times_that_no_law_explains(written: Path) -> None:
    form = written / "t.toml"
    text = form.read_text()
    for number in range(16):
        text = text.replace("ms = 0  #", f"ms = {(number * 7919) % 3000 + 100}  #", 1)
    form.write_text(text)
    code, said = run("read", str(form))
    assert (code, "MTS006" in said) == (2, True)


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (lambda rows: [*rows[:5000], *rows[5100:]], "MTS003", "gap"),
        (lambda rows: rows[:20000], "MTS003", "come back"),
        (lambda rows: rows[:50], "MTS003", "no trace"),
        (lambda rows: rows[:1], "MTS003", "0 lines of numbers"),
        (lambda rows: ["\x00\x01"], "MTS003", "0 lines of numbers"),
        (lambda rows: [rows[0].replace("z_mm", "q"), *rows[1:]], "MTS003", "--columns"),
        (lambda rows: [rows[0].replace("time_ms", "time_s"), *rows[1:]], "MTS003", "time_ms"),
        (lambda rows: [rows[0].replace("z_mm", "z_inch"), *rows[1:]], "MTS004", "unit"),
    ],
    ids=["gap", "half", "short", "header", "bytes", "names", "seconds", "inches"],
)
def test_a_bad_trace(change, code: str, words: str, trace_rows: list[str], written: Path) -> None:
    trace = written / "t.csv"
    trace.write_text("\n".join(change(trace_rows)) + "\n")
    exit_code, said = run("read", str(written / "t.toml"), "--trace", str(trace))
    assert exit_code == 2
    assert code in said
    assert words in said


@pytest.fixture(scope="module")
def trace_rows(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    program = tmp_path_factory.mktemp("trace") / "t.nc"
    assert run("write", "-p", "fanuc-lathe", "-o", str(program), "--axes", "Z")[0] == 0
    groups = groups_of(program.read_text(), x_is_diameter=True)
    return recorded(groups, {"Z": MACHINE}, np.random.default_rng(1)).csv("Z").splitlines()


def test_a_control_that_cannot_be_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("chipbreak.machine_test.program._has_minutes", lambda settings: False)
    code, said = run("write", "-p", "linuxcnc-lathe", "-o", str(tmp_path / "t.nc"))
    assert (code, "MTS001" in said) == (2, True)


def test_axes_that_are_too_slow_for_the_strokes_are_said(tmp_path: Path) -> None:
    program = tmp_path / "t.nc"
    slow = ("--set", "axes.Y.max_velocity_mm_min=2")
    code, said = run("write", "-p", "klipper", "-o", str(program), *slow)
    assert code == 2
    assert "the slowest of XYZ makes 2 mm/min" in said
    assert not program.exists()
    assert run("write", "-p", "klipper", "-o", str(program), *slow, "--axes", "XZ")[0] == 0
