"""A LinuxCNC machine as its INI file describes it."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.machine_files.found import profile_text
from chipbreak.machine_files.linuxcnc_ini import machine_of_ini
from chipbreak.text.diagnostics import RefusalError

LATHE = """\
# a lathe in inches
[DISPLAY]
  LATHE = 1
MAX_FEED_OVERRIDE = 1.5
[EMCMOT]
SERVO_PERIOD = 500000
[RS274NGC]
RS274NGC_STARTUP_CODE = G18 G20 G7 G64P.001Q.0005 G97
[TRAJ]
COORDINATES = X Z
LINEAR_UNITS = inch
[AXIS_X]
MAX_VELOCITY = 2.0   # of the drive
MAX_ACCELERATION = 30
[JOINT_0]
MAX_VELOCITY = 1.0
MAX_ACCELERATION = 40
[AXIS_Z]
MAX_VELOCITY = 1e99
;MAX_VELOCITY = 9
MAX_ACCELERATION = 20
MAX_ACCELERATION = 99
[SPINDLE_0]
MAX_FORWARD_VELOCITY = 2800
[EMCIO]
TOOL_TABLE = tool.tbl
"""


def values(path: Path) -> dict[str, object]:
    return {one.key: one.value for one in machine_of_ini(path).found}


def ini(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "machine.ini"
    path.write_text(text)
    return path


def test_the_numbers_of_a_lathe(tmp_path: Path) -> None:
    path = ini(tmp_path, LATHE)
    (tmp_path / "tool.tbl").touch()
    machine = machine_of_ini(path)
    assert machine.base == "linuxcnc-lathe"
    assert values(path) == {
        "planner.servo_period_ms": 0.5,
        "planner.max_feed_override": 1.5,
        "planner.usual_path_mode": "G64 P0.0254 Q0.0127",
        "axes.X.max_velocity_mm_min": pytest.approx(1.0 * 25.4 * 60),
        "axes.X.max_acceleration_mm_s2": pytest.approx(30 * 25.4),
        "axes.Z.max_acceleration_mm_s2": pytest.approx(20 * 25.4),
        "spindle.max_rpm": 2800.0,
        "tools.files": [str(tmp_path / "tool.tbl")],
        "tools.table_unit": "inch",
    }
    assert machine.missing == ()


def test_a_tool_table_that_is_not_there_is_said_and_not_named_in_the_profile(tmp_path: Path) -> None:
    machine = machine_of_ini(ini(tmp_path, LATHE))
    assert "tools.files" not in {one.key for one in machine.found}
    assert machine.missing == (f"tools.files: {tmp_path}/tool.tbl, the TOOL_TABLE of [EMCIO], is not there",)


def test_the_profile_can_be_loaded_and_says_where_numbers_are_from(tmp_path: Path) -> None:
    text = profile_text(machine_of_ini(ini(tmp_path, LATHE)), "A lathe")
    profile = tmp_path / "lathe.toml"
    profile.write_text(text)
    settings = chipbreak.load(profile)
    assert settings.axes["X"].max_acceleration_mm_s2 == pytest.approx(762.0)
    assert settings.dialect.name == "linuxcnc-lathe"
    assert "# [JOINT_0] MAX_VELOCITY = 1.0 (machine.ini, line 16)" in text


def test_a_mill_without_accelerations(tmp_path: Path) -> None:
    path = ini(tmp_path, "[TRAJ]\nCOORDINATES = X Y Z\nLINEAR_UNITS = mm\n[AXIS_X]\nMAX_VELOCITY = 50\n")
    machine = machine_of_ini(path)
    assert machine.base == "linuxcnc-mill"
    assert values(path) == {"axes.X.max_velocity_mm_min": 3000.0}
    assert [line.split(":")[0] for line in machine.missing] == [
        f"axes.{axis}.max_acceleration_mm_s2" for axis in "XYZ"
    ]


def test_joints_are_those_of_their_letters(tmp_path: Path) -> None:
    text = "[TRAJ]\nCOORDINATES = X Y Y Z\nLINEAR_UNITS = mm\n"
    text += "".join(f"[JOINT_{i}]\nMAX_ACCELERATION = {100 + i}\n" for i in range(4))
    found = values(ini(tmp_path, text))
    assert {key[5]: value for key, value in found.items()} == {"X": 100.0, "Y": 101.0, "Z": 103.0}


def test_files_that_are_included(tmp_path: Path) -> None:
    (tmp_path / "axes.inc").write_text("[AXIS_X]\nMAX_ACCELERATION = 5\n")
    text = "[TRAJ]\nLINEAR_UNITS = mm\n#INCLUDE axes.inc\n"
    assert values(ini(tmp_path, text)) == {"axes.X.max_acceleration_mm_s2": 5.0}


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("", "INI001"),
        ("%PDF-1.4\n\0", "INI001"),
        ("[TRAJ]\nCOORDINATES = X Z\n", "INI002"),
        ("[TRAJ]\nLINEAR_UNITS = furlong\n", "INI002"),
        ("[TRAJ]\nLINEAR_UNITS = 0\n", "INI002"),
        ("#INCLUDE machine.ini\n", "INI001"),
        ("#INCLUDE gone.inc\n", "INI001"),
    ],
)
def test_what_is_no_machine(text: str, code: str, tmp_path: Path) -> None:
    with pytest.raises(RefusalError) as caught:
        machine_of_ini(ini(tmp_path, text))
    assert caught.value.code == code
    assert caught.value.help


@pytest.mark.linuxcnc
@pytest.mark.parametrize("every", [8, pytest.param(1, marks=pytest.mark.long)])
def test_every_machine_that_linuxcnc_ships(every: int, tmp_path: Path) -> None:
    files = sorted(Path("/usr/share/doc/linuxcnc/examples").rglob("*.ini"))[::every]
    if not files:
        pytest.skip("LinuxCNC's examples are not installed")
    machines = 0
    for file in files:
        try:
            machine = machine_of_ini(file)
        except RefusalError:  # parts of INI files, and one that includes what is not there
            continue
        profile = tmp_path / "machine.toml"
        profile.write_text(profile_text(machine, "As shipped"))
        chipbreak.load(profile)
        machines += 1
    assert machines > 0.98 * len(files)


@pytest.mark.parametrize("name", ["a\0b.inc", "~nobody-of-this-name/a.inc", "n" * 300])
def test_an_include_of_an_impossible_name_is_said(name: str, tmp_path: Path) -> None:
    with pytest.raises(RefusalError) as refused:
        machine_of_ini(ini(tmp_path, f"[TRAJ]\nLINEAR_UNITS = mm\n#INCLUDE {name}\n"))
    assert refused.value.code == "INI001"
