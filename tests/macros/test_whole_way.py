"""A program goes through the filter, and what comes out runs with the macros in front of the laser."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from beam import BEAM as NAMED
from laser_simulator.tool import Chip
from linuxcnc import laser

from .cases import FLAT
from .lc_stand import LC_SETTINGS, alarms, subroutines
from .stand import ALARMS, BAR, BEAM, Stand

PROGRAM = b"""O1000
G21 G90 G94 G17 G40 G80
T1 M6
(ROUGH POCKET)
S5000 M3
G0 X10. Y10.
G43 H1 Z15.
G1 Z-2. F300.
X30.
G0 Z15.
(FINISH POCKET)
G0 X10. Y12.
G1 Z-2. F200.
X30.
G0 Z15.
M5
M30
"""
CHIP = FLAT.real(chips=(Chip(2, 12.0, 0.03, 2.2),))


def parts(folder: Path, name: str, *options: str) -> list[str]:
    """The filtered program, cut before each CHIP CHECK."""
    tools = folder / "tools.csv"
    tools.write_text(
        "number,type,teeth,diameter_mm,length_mm,holder_mm,helix_deg\n1,flat end mill,4,10,50,80,30\n"
    )
    settings = chipbreak.load(name, [*NAMED, f'tools.files=["{tools}"]', *options])
    result = chipbreak.rewrite(PROGRAM, settings, "program.nc")
    assert not result.diagnostics
    begin = "(CHIPBREAK BEGIN CHIP CHECK"
    first, *others = result.data.decode("ascii").removeprefix("O1000\n").split(begin)
    assert len(others) == 2
    return [first, *(begin + part for part in others)]


@pytest.mark.parametrize(
    ("chipped_after", "expected"),
    [
        (None, ["", "", ""]),
        (0, ["", "CHIP"]),  # the finish operation comes next
        (1, ["", "", ""]),  # the next workpiece starts with the rough one
    ],
)
def test_a_chip_stops_the_machine_before_the_operation_that_would_suffer(
    tmp_path: Path, chipped_after: int | None, expected: list[str]
) -> None:
    stand = Stand(FLAT, FLAT.real())
    stand.control.length_offsets_mm[1] = 131.0
    stand.machine.load(90)
    said = []
    for number, part in enumerate(parts(tmp_path, "fanuc-mill")):
        said.append(ALARMS[stand.outcome(part).alarm])
        if said[-1]:
            break
        if number == chipped_after:
            stand.change(CHIP)
    assert said == expected
    assert not stand.machine.crossings


def test_every_second_workpiece_until_a_tool_with_a_sister_fails(tmp_path: Path) -> None:
    program = parts(tmp_path, "fanuc-mill", "checks.every=2", "checks.sister.1=11")
    stand = Stand(FLAT, FLAT.real())
    stand.control.length_offsets_mm[1] = 131.0

    def workpiece() -> tuple[bool, str]:
        stand.machine.load(90)
        touched = stand.machine.skip_count
        said = ALARMS[stand.outcome("".join(program)).alarm]
        return stand.machine.skip_count > touched, said

    assert [workpiece() for _ in range(4)] == [(True, ""), (False, ""), (True, ""), (False, "")]
    stand.machine.load(90)
    assert stand.outcome(program[0]).alarm == 0
    stand.change(CHIP)
    assert ALARMS[stand.outcome("".join(program[1:])).alarm] == "CHIP"
    # Whoever starts again without looking: the beam is measured, but this tool does not cut.
    assert [workpiece() for _ in range(2)] == [(True, "LOCKED")] * 2
    stand.change(FLAT.real())
    assert stand.outcome("G65 P8919 T1.").alarm == 0
    assert workpiece() == (True, "")
    assert not stand.machine.crossings


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    "which", [slice(1, 2), pytest.param(slice(3), marks=pytest.mark.long)], ids=["few", "all"]
)
def test_the_same_on_the_simulated_linuxcnc(tmp_path: Path, which: slice) -> None:
    before, middle, after = parts(tmp_path, "linuxcnc-mill")
    before = "M68 E0 Q0\n" + before.replace("T1 M6\n", "T1 M6\nM68 E0 Q1\n")
    programs = [
        before + middle + after,
        f"{before}M68 E0 Q2\n{middle}{after}",
        f"{before}{middle}M68 E0 Q2\n{after}",
    ][which]
    folder = tmp_path / "subs"
    folder.mkdir()
    expected = [[], ["106 TOOL 1 CHIP 0.030 LIMIT 0.020"], []][which]
    runs = laser.run_until(
        lambda runs: alarms(runs) == expected,
        [program.encode() for program in programs],
        tools=[BAR, FLAT.real(), CHIP],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, folder),
    )
    assert alarms(runs) == expected
