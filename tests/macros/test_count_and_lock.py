"""Checks of every n-th workpiece only, and tools that are locked: on the interpreter and on LinuxCNC."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from chipbreak.dialects.check_programs import O_WORDS
from linuxcnc import laser

from .cases import STRAIGHT
from .lc_stand import LC_SETTINGS, alarms, subroutines
from .stand import BAR, BEAM, SETTINGS, Stand

GOOD = STRAIGHT.real()
BAD = STRAIGHT.real(diameter_mm=10.2)
BLOCKED = replace(BEAM, is_blocked=True)
CHECK = f"{STRAIGHT.data(1)}\nG65 P8901 T1 S5000"


@pytest.fixture
def stand() -> Stand:
    stand = Stand(STRAIGHT, GOOD)
    stand.calibrate()
    assert stand.run("T1 M6") == ""
    return stand


def workpiece(stand: Stand, every: int) -> str:
    """What a program does at its start: whether anything was measured."""
    before = stand.machine.skip_count
    assert stand.run(f"T90 M6\nG65 P8900 K{every}.\nT1 M6") == ""
    calibrated = stand.machine.skip_count > before
    between = stand.machine.skip_count
    said = stand.run(f"{CHECK} K{every}.\nG65 P8902 T1 Z4. K{every}.\nG65 P8903 T1 W0.02 Z4. K{every}.")
    assert (stand.machine.skip_count > between) == calibrated
    return said if calibrated else "not its turn"


def test_of_three_workpieces_one_is_checked(stand: Stand) -> None:
    pause = "not its turn"
    assert [workpiece(stand, 3) for _ in range(8)] == [pause, pause, "", pause, pause, "", pause, pause]
    assert [workpiece(stand, 2) for _ in range(3)] == ["", pause, ""]
    assert [workpiece(stand, 1) for _ in range(3)] == ["", "", ""]


def test_the_first_workpiece_of_a_control_is_checked() -> None:
    stand = Stand(STRAIGHT, GOOD)
    assert workpiece(stand, 5) == ""
    assert workpiece(stand, 5) == "not its turn"


def test_a_check_that_is_not_to_be_counted_always_takes_place(stand: Stand) -> None:
    assert workpiece(stand, 9) == "not its turn"
    touched = stand.machine.skip_count
    assert stand.run(CHECK) == ""
    assert stand.machine.skip_count > touched


def test_behind_an_alarm_the_next_workpiece_is_checked(stand: Stand) -> None:
    assert workpiece(stand, 3) == "not its turn"
    stand.change(BAD)
    assert stand.run(CHECK) == "RUNOUT"
    assert workpiece(stand, 3) == "RUNOUT"
    stand.change(GOOD)
    assert workpiece(stand, 3) == ""
    assert workpiece(stand, 3) == "not its turn"


def test_a_tool_with_a_sister_stays_locked_until_it_is_released(stand: Stand) -> None:
    stand.change(BAD)
    assert stand.run(f"{CHECK} K1. U14.") == "RUNOUT"
    stand.change(GOOD)
    touched = stand.machine.skip_count
    outcome = stand.outcome(f"{CHECK} K1. U14.")
    assert (outcome.alarm, outcome.text) == (114, "T#103 LOCKED SISTER #105")
    commons = stand.control.variables.commons
    assert (commons[103], commons[105], stand.machine.skip_count) == (1.0, 14.0, touched)
    assert stand.machine.at[2] == SETTINGS.safe_z_mm
    # Whoever calls it, and whatever workpiece it is.
    for call in (CHECK, f"{CHECK} K9.", f"{STRAIGHT.data(1)}\nG65 P8902 T1 Z4.", "G65 P8903 T1 W0.02"):
        assert stand.run(call) == "LOCKED"
    assert stand.run(CHECK.replace("T1", "T2")) == ""
    assert stand.run("G65 P8919 T1") == ""
    assert stand.run(f"{CHECK} K1. U14.") == ""


def test_every_kind_of_failure_locks(stand: Stand) -> None:
    for real, alarm in (
        (STRAIGHT.real(length_mm=60.0), "LONG"),
        (STRAIGHT.real(is_missing=True), "NO CONTACT"),
    ):
        stand.change(real)
        assert stand.run(f"{CHECK} K1. U14.") == alarm
        assert stand.run(CHECK) == "LOCKED"
        stand.run("G65 P8919 T1")
    stand.change(GOOD)
    assert stand.trace(4.0) == ""
    stand.change(STRAIGHT.real(length_mm=50.9))
    assert stand.chip_check(0.02) == "CHIP"
    assert stand.run("G65 P8903 T1 W0.02 Z4. K1. U14.") == "CHIP"
    assert stand.run(CHECK) == "LOCKED"


def test_a_tool_without_a_sister_is_never_locked(stand: Stand) -> None:
    stand.change(BAD)
    for call in (CHECK, f"{CHECK} K1. U0.", CHECK):
        assert stand.run(call) == "RUNOUT"
    stand.station.beam = BLOCKED
    assert stand.run(f"{CHECK} K1. U14.") == "BEAM"  # no fault of the tool
    stand.station.beam = BEAM
    assert stand.run(CHECK) == "RUNOUT"


def test_ten_tools_are_remembered(stand: Stand) -> None:
    stand.change(BAD)
    for tool in range(21, 33):
        assert stand.run(f"{CHECK.replace('T1', f'T{tool}')} K1. U{tool + 100}.") == "RUNOUT"
    said = [stand.run(CHECK.replace("T1", f"T{tool}")) for tool in range(21, 33)]
    assert said == ["LOCKED"] * 10 + ["RUNOUT"] * 2
    assert stand.run("G65 P8919") == "CALL"


@pytest.mark.linuxcnc("machine")
def test_both_on_the_simulated_linuxcnc(tmp_path: Path) -> None:
    check = f"{STRAIGHT.data(1, O_WORDS)}\no<cb_tool_check> call [1] [5000]"
    count = f"(debug, count #{LC_SETTINGS.store_last - 10})"
    start = "M68 E0 Q0\no<cb_calibrate> call [3]\n"
    pieces = [
        f"{start}M68 E0 Q1\n{check} [3] [14]\n{count}\nM2\n",
        f"{start}M68 E0 Q2\n{check} [3] [14]\no<cb_trace> call [1] [4] [0] [3]\n{count}\nM2\n",
        f"{start}M68 E0 Q2\no<cb_chip_check> call [1] [0.02] [1] [3] [14]\n{count}\nM2\n",
        f"{start}{count}\nM68 E0 Q2\n{check} [3] [14]\nM2\n",
        f"M68 E0 Q1\n{check} [3] [14]\nM2\n",
        "M68 E0 Q1\no<cb_chip_check> call [1] [0.02] [1]\nM2\n",
        f"M68 E0 Q1\no<cb_release> call [1]\n{check}\n{count}\nM2\n",
    ]
    expected = [
        [],
        [],
        [],
        ["101 TOOL 1 RUNOUT 5.100 MAX 5.005"],
        ["114 TOOL 1 LOCKED SISTER 14"],
        ["114 TOOL 1 LOCKED SISTER 0"],
        [],
    ]
    runs = laser.run_until(
        lambda runs: alarms(runs) == expected,
        ["\n".join(["", piece]).encode() for piece in pieces],
        tools=[BAR, GOOD, BAD],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, tmp_path),
    )
    assert alarms(runs) == expected
    said = [[message.strip() for message in run.messages] for run in runs]
    assert said == [
        ["count 1.000000"],
        ["count 2.000000"],
        ["count 3.000000"],
        ["count 1.000000", "TOOL 1 IS LOCKED, ITS SISTER IS 14"],
        [],
        [],
        ["count 1.000000"],
    ]
    up, still = LC_SETTINGS.safe_z_mm, 0.0
    assert [float(run.samples[-1, 3]) for run in runs] == [up, still, still, up, up, up, up]
