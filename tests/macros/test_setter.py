"""A touch plate in the place of the laser: length and breakage, on the simulated LinuxCNC."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import chipbreak
from chipbreak.macros import MacroSettings
from linuxcnc import laser

from .cases import STRAIGHT
from .lc_stand import LC_SETTINGS, alarms, subroutines
from .stand import BAR, BEAM

PLATE = MacroSettings(
    setter_x_mm=BEAM.x_mm,
    setter_y_mm=BEAM.y_mm,
    setter_z_mm=BEAM.z_mm + 100.0,
    safe_z_mm=LC_SETTINGS.safe_z_mm,
    store_first=LC_SETTINGS.store_first,
    store_last=LC_SETTINGS.store_last,
)
OPTIONS = [
    "checks.calls=setter",
    *(f"macros.setter_{axis}_mm={value}" for axis, value in (("x", 120), ("y", -35), ("z", -300))),
]
PROGRAM = b"T1 M6\nS1000 M3\nG0 X1 Y2\nG43 Z15 H1\nG1 Z-1 F50\nG0 Z15\nM30\n"


def test_calls_of_a_setter_need_its_place_alone() -> None:
    done = chipbreak.rewrite(PROGRAM, chipbreak.load("linuxcnc-mill", [*OPTIONS, "macros.safe_z_mm=0"]))
    assert b"o<cb_setter> call [1]\n" in done.data
    assert b"o<cb_setter> call [1] [0.02]\n" in done.data
    assert not done.diagnostics
    lacks = chipbreak.rewrite(PROGRAM, chipbreak.load("linuxcnc-mill", OPTIONS))
    assert not lacks.changed
    (found,) = lacks.diagnostics
    assert found.code == "CHK011"
    assert found.message.endswith("no macros.safe_z_mm")


@pytest.mark.linuxcnc("machine")
def test_a_broken_a_short_and_a_pulled_out_tool(tmp_path: Path) -> None:
    first = "M68 E0 Q1\no<cb_setter> call [1]\n"
    again = "o<cb_setter> call [1] [0.05]\n(debug, fine)\nM2\n"
    pieces = [f"{first}M68 E0 Q{number}\n{again}" for number in range(1, 6)]
    pieces.append(f"G20\n{first}M68 E0 Q2\no<cb_setter> call [1] [0.002]\n(debug, fine)\nM2\n")
    pieces.append("M68 E0 Q1\no<cb_setter> call [7] [0.05]\nM2\n")
    good = STRAIGHT.real()
    lengths = (0.0, -0.04, -0.05, 0.06)
    tools = [BAR, *(replace(good, length_mm=good.length_mm + one) for one in lengths)]
    tools.append(replace(good, is_missing=True))
    expected = [
        [],
        [],
        ["106 TOOL 1 CHIP 0.050 LIMIT 0.050"],
        ["106 TOOL 1 CHIP -0.060 LIMIT 0.050"],
        ["107 TOOL 1 DOES NOT BREAK BEAM"],
        [],
        ["110 TOOL 7 HAS NO STORED EDGE"],
    ]
    runs = laser.run_until(
        lambda runs: alarms(runs) == expected,
        [f"\n{piece}".encode() for piece in pieces],
        tools=tools,
        beam=BEAM,
        subroutines=subroutines(PLATE, tmp_path),
    )
    assert alarms(runs) == expected
    assert all(float(run.samples[-1, 3]) == PLATE.safe_z_mm for run in runs)
