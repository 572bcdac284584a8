"""``chipbreak macros`` and the settings behind it."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path

import click.testing
import pytest

from chipbreak.cli import cli
from chipbreak.dialects import FANUC_MILL
from chipbreak.dialects.fanuc import FANUC_LATHE_A
from chipbreak.macros import MacroSettings, macro_files
from chipbreak.settings import load
from chipbreak.text.diagnostics import RefusalError
from macro_interpreter import Library

from .stand import FLAT_OK, SETTINGS, Stand

OPTIONS = [
    f"--set=macros.{key}={value}"
    for key, value in {
        "beam_x_mm": 120,
        "beam_y_mm": -35.2,
        "beam_z_mm": -400,
        "safe_z_mm": 0,
        "master_length_mm": 150,
        "master_diameter_mm": 20,
        "master_tool": 90,
    }.items()
]


def invoke(*args: str) -> click.testing.Result:
    return click.testing.CliRunner().invoke(cli, ["macros", *args])


def test_the_command_writes_macros_that_run(tmp_path: Path) -> None:
    done = invoke("-o", str(tmp_path / "new"), "-p", "fanuc-mill", *OPTIONS)
    assert (done.exit_code, done.output) == (0, "")
    files = sorted((tmp_path / "new").iterdir())
    assert len(files) == 33
    stand = Stand(FLAT_OK, FLAT_OK.real(), programs=Library(file.read_bytes() for file in files))
    stand.calibrate()
    assert stand.check_alone() == ""


def test_another_s_file_is_not_written_over(tmp_path: Path) -> None:
    mine = tmp_path / "O8901.nc"
    mine.write_text("%\nO8901(MY OWN)\nM99\n%\n")
    done = invoke("-o", str(tmp_path), "-p", "fanuc-mill", *OPTIONS)
    assert done.exit_code == 2
    assert "O8901.nc is not a file of chipbreak; nothing was written" in done.output
    assert [file.name for file in tmp_path.iterdir()] == [mine.name]
    mine.unlink()
    for _ in range(2):
        assert invoke("-o", str(tmp_path), "-p", "fanuc-mill", *OPTIONS).exit_code == 0


def test_numbers_of_probe_makers_are_warned_about(tmp_path: Path) -> None:
    moved = ["--set=macros.first_program=9810", "--set=macros.first_variable=110"]
    done = invoke("-o", str(tmp_path), "-p", "fanuc-mill", *OPTIONS, *moved)
    assert done.exit_code == 0
    assert (
        "warning MCR005: O9810 to O9842 are also numbers of programs of Renishaw, Blum, Haas" in done.output
    )
    files = sorted(tmp_path.iterdir())
    assert (files[0].name, len(files)) == ("O9810.nc", 33)
    text = "".join(file.read_text() for file in files)
    assert "P89" not in text and "#103" not in text
    stand = Stand(FLAT_OK, FLAT_OK.real(), programs=Library(file.read_bytes() for file in files))
    assert stand.run("T90 M6\nG65 P9810") == ""
    assert stand.run(f"T1 M6\n{FLAT_OK.data(1)}\nG65 P9811 T1. S5000.".replace("P8904", "P9814")) == ""


def test_the_command_writes_subroutines(tmp_path: Path) -> None:
    assert invoke("-o", str(tmp_path), "-p", "linuxcnc-mill", *OPTIONS).exit_code == 0
    assert "#<_cb_beam_y> = -35.2 (" in (tmp_path / "cb_settings.ngc").read_text()
    assert "M19 R#<angle>" in (tmp_path / "cb_orient.ngc").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (
            OPTIONS[1:],
            "MCR001: fanuc-mill: the macros need 1 more values\n  help: macros.beam_x_mm: machine X",
        ),
        ([*OPTIONS, "--set=macros.beam_x=1"], "SET001: there is no key macros.beam_x"),
        ([*OPTIONS, "--set=macros.slow_feed=0"], "SET003: macros.slow_feed = 0.0 is not possible"),
        ([*OPTIONS, "--set=checks.retries=many"], "SET002"),
        ([*OPTIONS, "--set=macros.store_first=100"], "SET003: macros.store_first = 100, store_last = 999"),
        ([*OPTIONS, "--set=macros.store_last=1200"], "keeps values in 500 to 999, or 98000 to 98499"),
        ([*OPTIONS, "--set=vibration.nonsense=1"], "SET001"),
    ],
)
def test_what_cannot_be_writes_nothing(tmp_path: Path, args: list[str], said: str) -> None:
    done = invoke("-o", str(tmp_path / "new"), "-p", "fanuc-mill", *args)
    assert done.exit_code == 2
    assert said in done.output
    assert not (tmp_path / "new").exists()


def test_a_lathe_has_no_macros() -> None:
    with pytest.raises(RefusalError) as caught:
        macro_files(FANUC_LATHE_A, SETTINGS)
    assert caught.value.code == "MCR004"


PROFILE = """base = "fanuc-mill"
[macros]
beam_x_mm = 120
beam_y_mm = -35.2
beam_z_mm = -400
safe_z_mm = 0
master_length_mm = 150
master_diameter_mm = 20
master_tool = 90
laser_on = "M70"
[checks]
runout_mm = 0.008
length_over_mm = 2
diameter_mm = 0.4
trace_step_mm = 1.5
retries = 3
alarm_base = 140
"""


def test_a_profile_says_all_that_the_macros_need(tmp_path: Path) -> None:
    profile = tmp_path / "machine.toml"
    profile.write_text(PROFILE)
    done = invoke("-o", str(tmp_path / "new"), "-p", str(profile), "--set=macros.clear_mm=3")
    assert (done.exit_code, done.output) == (0, "")
    settings = (tmp_path / "new" / "O8905.nc").read_text()
    for line in ("#120=120.(", "#128=3.(", "#131=140(", "#132=3(", "#136=0.008(", "#137=2.(", "#138=0.4("):
        assert f"\n{line}" in settings
    assert "\n#139=1.5(" in settings
    shown = click.testing.CliRunner().invoke(cli, ["profile", "show", str(profile)])
    assert shown.exit_code == 0
    assert f"beam_x_mm = 120.0  # profile {profile}, line 3" in shown.output
    assert "slow_feed = 12.0  # default" in shown.output
    again = tmp_path / "again.toml"
    again.write_text(shown.output)
    assert MacroSettings.of(load(str(again))) == MacroSettings.of(load(str(profile)))


def test_the_machine_builder_s_codes_stand_in_the_macros() -> None:
    settings = replace(
        SETTINGS, orient="M219 S{angle}", laser_on="M70\nG4 P500", laser_off="M71", beam_input=3
    )
    files = {name: data.decode() for name, data in macro_files(FANUC_MILL, settings).items()}
    assert "M219 S#1\nM99" in files["O8912.nc"]
    assert "M70\nG4 P500\nM99" in files["O8913.nc"]
    assert "M71\nM99" in files["O8916.nc"]
    assert "#124=1003(" in files["O8905.nc"]


def test_no_line_is_longer_than_a_screen_and_every_line_is_read() -> None:
    for name, data in macro_files(FANUC_MILL, SETTINGS).items():
        lines = data.decode("ascii").splitlines()
        assert max(map(len, lines)) <= 80, name
        assert lines[0] == lines[-1] == "%"
        assert not any(";" in line for line in lines), name  # the end of a block, even in a comment


def test_then_stands_before_macro_statements_only() -> None:
    """Many controls stop at ``IF [..] THEN F#148``: what follows THEN is an assignment."""
    folder = resources.files("chipbreak") / "macros" / "fanuc"
    files = [file for file in folder.iterdir() if file.name.endswith(".nc")]
    lines = [line for file in files for line in file.read_text("ascii").splitlines()]
    behind = [line.partition(" THEN ")[2] for line in lines if line.startswith("IF") and " THEN " in line]
    assert behind
    assert [text for text in behind if not text.startswith("#")] == []
