"""A machine as the print-out of its Fanuc parameters describes it."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.machine_files.fanuc_parameters import machine_of_parameters
from chipbreak.machine_files.found import profile_text
from chipbreak.text.diagnostics import RefusalError

LATHE = """\
%
N00000Q1P00000010
N01006Q1A1P00001000A2P00000000
N01013Q1A1P00000000A2P00000000
N01020Q1A1P88A2P90
N01420Q1A1P8000.A2P10000.
N01430Q1A1P0.A2P6000.
N01610Q1A1P00000000A2P00000001
N01622Q1A1P64A2P48
N01825Q1A1P5000A2P3300
N02005Q1A1P00000010A2P00000000
N02092Q1A1P9800A2P9800
N03401Q1P01000001
N03772Q1S1P4000
%
"""


def values(path: Path) -> dict[str, object]:
    return {one.key: one.value for one in machine_of_parameters(path).found}


@pytest.mark.parametrize("spread", [False, True], ids=["close", "spread"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\r\r"])
def test_the_numbers_of_a_lathe(spread: bool, end: str, tmp_path: Path) -> None:
    text = LATHE.replace("A", " A").replace("P", " P ").replace("N0", "N") if spread else LATHE
    path = tmp_path / "CNC-PARA.TXT"
    path.write_bytes(text.replace("\n", end).encode())
    machine = machine_of_parameters(path)
    assert machine.base == "fanuc-lathe"
    assert values(path) == {
        "control.decimal_point": "calculator",
        "planner.model": "after-interpolation",
        "control.increment_mm": 0.001,
        "control.lathe_system": "B",
        "control.x_diameter": True,
        "axes.X.max_velocity_mm_min": 8000.0,
        "axes.Z.max_velocity_mm_min": 6000.0,
        "axes.X.acc_dec": "exponential",
        "axes.Z.acc_dec": "linear",
        "axes.X.acc_dec_ms": 64.0,
        "axes.Z.acc_dec_ms": 48.0,
        "axes.X.position_gain_1_s": 50.0,
        "axes.Z.position_gain_1_s": 33.0,
        "axes.X.feed_forward": 0.98,
        "spindle.max_rpm": 4000.0,
    }
    assert machine.missing == ()


def test_blanks_and_digits_by_the_thousand(tmp_path: Path) -> None:
    path = tmp_path / "CNC-PARA.TXT"
    blanks, digits = " " * 50_000, "1" * 5_000
    path.write_text(f"N1825 A1{blanks}M{blanks}P3000{blanks}A2{blanks}P{digits}\nN1620 A{digits} P3\n{LATHE}")
    found = values(path)
    assert found["axes.X.position_gain_1_s"] == 30.0
    assert "axes.Z.position_gain_1_s" not in found
    assert found["spindle.max_rpm"] == 4000.0


def test_the_profile_can_be_loaded(tmp_path: Path) -> None:
    path = tmp_path / "CNC-PARA.TXT"
    path.write_text(LATHE)
    profile = tmp_path / "lathe.toml"
    profile.write_text(profile_text(machine_of_parameters(path), "A lathe"))
    settings = chipbreak.load(profile)
    assert settings.axes["Z"].position_gain_1_s == 33.0
    assert settings.control.lathe_system == "B"


def test_what_is_missing_is_named_with_its_parameter(tmp_path: Path) -> None:
    path = tmp_path / "CNC-PARA.TXT"
    path.write_text("N1020A1P88A2P89A3P90\nN1825A1P3000A2P3000\nN1420A1P9000\nN3401P00000000\n")
    machine = machine_of_parameters(path)
    assert machine.base == "fanuc-mill"
    assert values(path)["control.decimal_point"] == "increment"
    assert "axes.Z.position_gain_1_s: parameter 1825, in 0.01/s" in machine.missing
    assert "spindle.max_rpm: parameter 3772" in machine.missing


@pytest.mark.parametrize(
    "data", [b"", b"O0001\nG0 X1.\nM30\n", b"\x00" * 100, b"N10 G1 X1. P1\nN20 G4 P500\n"]
)
def test_what_is_no_print_out(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.txt"
    path.write_bytes(data)
    with pytest.raises(RefusalError) as caught:
        machine_of_parameters(path)
    assert caught.value.code == "PAR001"


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(RefusalError, match="cannot read") as caught:
        machine_of_parameters(tmp_path / "gone.txt")
    assert caught.value.code == "PAR001"
