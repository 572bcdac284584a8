"""Makers' cycles, every n-th workpiece and sister tools, through the whole filter."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import chipbreak
from beam import BEAM, OPTIONS
from chipbreak.cli import cli

SAMPLE = Path(__file__).parents[2] / "samples" / "fusion-mill.nc"
TOOLS = [str(SAMPLE.parent / "tools" / name) for name in ("bracket.json", "bracket.csv")]
HOMED = b"""T1 M6
S1000 M3
G0 X1. Y1.
G43 H1 Z10.
G1 Z-1. F100.
G0 Z10.
G91 G28 Z0.
G90
(FINISH)
G0 X1. Y5.
Z10.
G1 Z-1.
G0 Z10.
G91 G28 Z0.
M30
"""


def filtered(*args: str) -> tuple[int, str, str]:
    done = CliRunner().invoke(cli, ["filter", *args])
    return done.exit_code, done.stdout, done.stderr


def calls(text: str) -> list[str]:
    return re.findall(r"^G65 .*$", text.replace("\r", ""), re.MULTILINE)


@pytest.mark.parametrize(
    ("profile", "block"),
    [
        ("haas-mill", "G65 P9853 T{} B0. H{}"),
        ("fanuc-mill-renishaw", "G65 P9858 T{} H{}"),
        ("speedio-renishaw", "G65 P8858 B1 H{1} T{0}"),
        ("speedio-blum", "G65 P8915 B2 Q{1}"),
    ],
)
def test_a_maker_s_cycle_stands_behind_each_operation(profile: str, block: str) -> None:
    exit_code, out, said = filtered("-p", profile, str(SAMPLE))
    assert (exit_code, said) == (0, "")
    block = block if "{1}" in block else block.replace("{}", "{0}", 1).replace("{}", "{1}")
    expected = [(1, "0.02"), (2, "0.02"), (2, "0.05"), (3, "0.02")]
    assert calls(out) == [block.format(*values) for values in expected]


def test_a_cycle_that_may_end_the_length_offset_waits_where_it_can_be_put_back() -> None:
    own = ["checks.calls=own", 'calls.own={chip_check="G65 P9858 T{tool} H{limit}"}']
    lines = chipbreak.rewrite(HOMED, chipbreak.load("fanuc-mill", own)).data.decode().split("\n")
    assert lines[lines.index("G91 G28 Z0.") + 2] == "(CHIPBREAK BEGIN CHIP CHECK T1 W0.02)"
    lines = chipbreak.rewrite(HOMED, chipbreak.load("fanuc-mill-renishaw")).data.decode().split("\n")
    # Before the program's own way home: some controls keep the offset there, and Z10. counts on it.
    first = lines.index("(CHIPBREAK BEGIN CHIP CHECK T1 W0.02)")
    assert lines[first - 1 : first + 10] == [
        "G0 Z10.",
        "(CHIPBREAK BEGIN CHIP CHECK T1 W0.02)",
        "G91 G28 Z0.",
        "G90",
        "M5",
        "G65 P9858 T1 H0.02",
        "S1000 M3",
        "G0 X1. Y1.",
        "G0 G43 H1 Z10.",
        "(CHIPBREAK END E014872B)",
        "G91 G28 Z0.",
    ]
    no_place = HOMED.replace(b"G0 Z10.\nG91", b"G91", 1)
    found = chipbreak.rewrite(no_place, chipbreak.load("fanuc-mill-renishaw"))
    assert found.data.count(b"P9858") == 1
    assert "rely on a length offset" in next(d.message for d in found.diagnostics if d.code == "CHK002")


def test_every_third_workpiece() -> None:
    _, out, said = filtered(
        "-p",
        "fanuc-mill",
        *OPTIONS,
        "--set=checks.every=3",
        "--tools",
        TOOLS[0],
        "--tools",
        TOOLS[1],
        str(SAMPLE),
    )
    assert said == ""
    found = [call for call in calls(out) if "P8904" not in call]
    assert found[:4] == [
        "G65 P8900 K3.",
        "G65 P8901 T1. S2200. K3. U0.",
        "G65 P8902 T1. Z20. K3. U0. W0.02 D1.",
        "G65 P8903 T1. W0.02 D1. K3. U0.",
    ]
    assert all(" K3" in call for call in found)


def test_nobody_counts_where_the_beam_is_not_measured() -> None:
    program = b"T1 M6\nS1000 M3\nG0 X1. Y1.\nG43 H1 Z10.\nG1 Z-1. F100.\nG0 Z10.\nM30\n"
    settings = chipbreak.load("fanuc-mill", [*BEAM, "checks.every=3"])
    with_beam = chipbreak.rewrite(program, settings).data
    assert b"P8900 K3" in with_beam
    without = chipbreak.rewrite(b"G68 X0. Y0. R9.\n" + program.replace(b"S1000", b"G69\nS1000"), settings)
    assert b"P8900" not in without.data
    assert b"P8901 T1. S1000.\n" in without.data
    assert "CHK002" in [d.code for d in without.diagnostics]


def test_a_sister_is_named_in_the_calls_of_its_tool() -> None:
    _, out, _ = filtered("-p", "fanuc-mill", *OPTIONS, "--set", "checks.sister.2=12", str(SAMPLE))
    assert [call for call in calls(out) if " U" in call] == [
        "G65 P8901 T2. S5300. K1. U12.",
        "G65 P8902 T2. Z20. K1. U12. W0.05 D1.",
        "G65 P8903 T2. W0.02 D1. K1. U12.",
        "G65 P8903 T2. W0.05 D1. K1. U12.",
    ]
    _, out, said = filtered("-p", "fanuc-mill", *OPTIONS, "--set", "checks.sister.2=3", str(SAMPLE))
    assert "warning CHK008: T3 is the sister of T2, and this program cuts with it as well" in said
    assert "U3." in out


def test_the_program_still_calls_the_tool_that_it_called() -> None:
    found = chipbreak.rewrite(
        SAMPLE.read_bytes(), chipbreak.load("fanuc-mill", [*BEAM, "checks.sister.2=12"])
    )
    assert b"T12" not in found.data
    assert "T12 may take its place" in next(
        e.reason for e in found.edits if e.title.startswith("TOOL CHECK T2")
    )
    assert found.data.count(b"M6") == SAMPLE.read_bytes().count(b"M6")
