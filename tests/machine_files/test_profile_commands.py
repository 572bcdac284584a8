"""A profile for a machine is written, asked for, and described for editors."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

import chipbreak
from chipbreak.machine_files.found import Found, Machine, profile_text
from chipbreak.machine_files.questions import QUESTIONS, answer
from chipbreak.settings import load, profile_names
from chipbreak.settings.profile_files import profile_text as shipped_text
from chipbreak.settings.schema import schema_of_profiles
from chipbreak.settings.sections import OPEN_SECTIONS, SECTIONS
from warm import warm_text

INI = "[DISPLAY]\nLATHE = 1\n[TRAJ]\nCOORDINATES = X Z\nLINEAR_UNITS = mm\n[AXIS_X]\nMAX_ACCELERATION = 900\n"


def test_a_profile_from_an_ini_file(tmp_path: Path) -> None:
    (tmp_path / "m.ini").write_text(INI)
    done = warm_text("profile", "init", "chipbreak.toml", "--from-ini", "m.ini", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr.splitlines() == [
        "chipbreak.toml: 1 value over linuxcnc-lathe",
        "  still to be said: axes.Z.max_acceleration_mm_s2: no [AXIS_Z] MAX_ACCELERATION",
    ]
    assert chipbreak.load(tmp_path / "chipbreak.toml").axes["X"].max_acceleration_mm_s2 == 900.0


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    (tmp_path / "m.ini").write_text(INI)
    (tmp_path / "a.toml").write_text("# mine\n")
    done = warm_text("profile", "init", "a.toml", "--from-ini", "m.ini", cwd=tmp_path)
    assert done.returncode == 2
    assert "--force" in done.stderr
    assert (tmp_path / "a.toml").read_text() == "# mine\n"
    assert (
        warm_text("profile", "init", "a.toml", "--from-ini", "m.ini", "--force", cwd=tmp_path).returncode == 0
    )


def test_what_cannot_be_read_writes_nothing(tmp_path: Path) -> None:
    done = warm_text("profile", "init", "a.toml", "--from-parameters", "gone.txt", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error PAR001: cannot read gone.txt")
    assert list(tmp_path.iterdir()) == []


def test_a_wrong_base_writes_nothing(tmp_path: Path) -> None:
    done = warm_text("profile", "init", "a.toml", "--base", "no-such", cwd=tmp_path)
    assert done.returncode == 2
    assert "SET005" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_without_a_terminal_nothing_is_asked(tmp_path: Path) -> None:
    done = warm_text("profile", "init", "a.toml", "--base", "fanuc-lathe", cwd=tmp_path)
    assert done.returncode == 0
    assert tomllib.loads((tmp_path / "a.toml").read_text()) == {"base": "fanuc-lathe"}


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal")
def test_questions_on_a_terminal(tmp_path: Path) -> None:
    import pty

    parent, child = pty.openpty()
    answers = ["fanuc-lathe", "calculator", "8000", "2500", "-1", "10000", "", "4000", "8"]
    os.write(parent, "".join(f"{one}\n" for one in answers).encode())
    command = [sys.executable, "-m", "chipbreak", "profile", "init", "a.toml"]
    done = subprocess.run(command, stdin=child, capture_output=True, text=True, cwd=tmp_path, check=False)
    os.close(parent)
    os.close(child)
    assert done.returncode == 0, done.stderr
    assert tomllib.loads((tmp_path / "a.toml").read_text()) == {
        "base": "fanuc-lathe",
        "control": {"decimal_point": "calculator"},
        "axes": {
            "X": {"max_velocity_mm_min": 8000, "max_acceleration_mm_s2": 2500},
            "Z": {"max_velocity_mm_min": 10000},
        },
        "spindle": {"max_rpm": 4000},
        "command": {"base_period_ms": 8},
    }
    assert "Enter alone leaves out what nobody knows yet." in done.stderr
    assert done.stderr.endswith(
        "a.toml: 6 values over fanuc-lathe\n"
        "  still to be said: axes.Z.max_acceleration_mm_s2: acceleration of Z [mm/s2]\n"
    )


def test_every_question_is_about_a_key() -> None:
    for question in QUESTIONS:
        section, _, key = question.key.rpartition(".")
        assert hasattr(SECTIONS[section](), key)
        assert answer(question, "nonsense") is None
        assert question.expected


def test_any_text_becomes_a_comment_and_a_value() -> None:
    told = Machine('a"b\\c\x7f', (Found("control.dialect", "ä\n\"'\x7f\\", "x"),), ())
    assert tomllib.loads(profile_text(told, "t"))["control"]["dialect"] == "ä\n\"'\x7f\\"


# --- the schema -------------------------------------------------------------------------------------------


@cache
def validator() -> Draft202012Validator:
    """Another program's view of the schema."""
    schema = schema_of_profiles()
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def fits(value: Any) -> bool:
    return validator().is_valid(value)


@pytest.mark.parametrize("name", profile_names())
def test_shipped_profiles_fit_the_schema(name: str) -> None:
    assert fits(tomllib.loads(shipped_text(name)[1]))


@pytest.mark.parametrize(
    "text",
    [
        "[contrl]\n",
        "[control]\ndialekt = 'x'\n",
        "[control]\nlathe_system = 'D'\n",
        "[command]\nbase_period_ms = 0\n",
        "[command]\nmultiples = [1]\n",
        "[vibration]\nn = 'much'\n",
        "[axes.Q]\n",
        "[axes.X]\nsign = 2\n",
        "[checks]\nenabled = 1\n",
    ],
)
def test_what_the_settings_refuse_does_not_fit(text: str, tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text(f'base = "generic-lathe"\n{text}')
    with pytest.raises(chipbreak.SettingsError):
        load(path)
    assert not fits(tomllib.loads(text))


def test_the_schema_names_every_key_with_its_default() -> None:
    properties = schema_of_profiles()["properties"]
    assert set(properties) == {"base", "axes", *OPEN_SECTIONS, *(s for s in SECTIONS if "." not in s)}
    assert properties["command"]["properties"]["base_period_ms"] == {
        "type": "number",
        "exclusiveMinimum": 0.0,
        "default": 4.0,
    }
    assert "versioned" not in json.dumps(properties)


def test_the_command_prints_the_schema(tmp_path: Path) -> None:
    done = warm_text("profile", "schema", cwd=tmp_path)
    assert json.loads(done.stdout) == json.loads(json.dumps(schema_of_profiles()))
