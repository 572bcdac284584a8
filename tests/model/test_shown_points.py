"""A number without a decimal point is worth what the whole numbers of its program show, or not known."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.settings import load

PROGRAM = """O0011
G21 G40 G99
T0101
G97 S900 M3
G0 X62. Z2.
G71 U2. R1.
G71 P10 Q20 U1. W0.1 F0.25
N10 G0 X20.
G1 Z-15.
X30.
Z-30.
X40. Z-45.
N20 X62.
G0 X90. Z50.
M30
"""
WISH = ['cycles.unroll="always"']


def pointless(text: str, times: int) -> str:
    """Whole lengths without their points, in steps of the control where ``times`` is 1000."""

    def without(match: re.Match[str]) -> str:
        return f"{match[1]}{round(float(match[2]) * times)}"

    return re.sub(r"([XZUWR])(-?\d+\.)(?!\d)", without, text)


def passes(data: bytes) -> list[bytes]:
    """The blocks of the passes, as they are written."""
    lines = data.split(b"\n")
    begin = next(i for i, line in enumerate(lines) if b"PASS 1" in line)
    return lines[begin : next(i for i, line in enumerate(lines) if b"CHIPBREAK ROLLED" in line)]


def blocks(data: bytes) -> list[bytes]:
    """The same without comments."""
    return [line for line in passes(data) if not line.startswith(b"(")]


@pytest.mark.parametrize(("times", "rule"), [(1, "calculator"), (1000, "increment")])
def test_a_program_shows_its_reading(times: int, rule: str) -> None:
    """The passes are those of the program with points."""
    program = pointless(PROGRAM, times).encode()
    settings = load("fanuc-lathe", WISH)
    result = chipbreak.rewrite(program, settings)
    with_points = chipbreak.rewrite(PROGRAM.encode(), settings)
    assert passes(result.data) == passes(with_points.data)
    assert not with_points.shown.rule
    assert result.shown.rule == rule
    assert chipbreak.restore(result.data) == program
    assert chipbreak.rewrite(result.data, settings).data == result.data
    (said,) = [one for one in result.diagnostics if one.code == "MOD006"]
    # The way out: the value that it names says the same, and nothing is said any more.
    known = load("fanuc-lathe", [*WISH, f"control.decimal_point={rule}"])
    assert f'control.decimal_point = "{rule}"' in said.help
    again = chipbreak.rewrite(program, known)
    assert again.data == result.data
    assert not [one for one in again.diagnostics if one.code == "MOD006"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("X62. Z2.", "X62 Z2."),
        ("G1 Z-15.", "G1 Z-15"),
        ("X30.", "X30"),
        ("U2. R1.", "U2 R1."),
        ("X62. Z2.", "X62 Z2"),
    ],
)
def test_a_slip_among_numbers_with_points_shows_nothing(old: str, new: str) -> None:
    program = PROGRAM.replace(old, new, 1).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", WISH))
    assert result.data == program
    assert not result.shown.rule


@pytest.mark.parametrize(
    "places",
    [
        "G0 X62000 Z2\nG1 Z-15 F0.2\nX50\nZ-30000\nX70000",
        "G0 X500 Z300\nG1 Z-400 F0.2\nX600",
        "G0 X5000 Z300\nG1 Z-40 F0.2\nX60",
    ],
    ids=["both", "neither", "places and more"],
)
def test_numbers_of_both_kinds_or_of_neither_show_nothing(places: str) -> None:
    program = f"T0101\nG97 S900 M3\n{places}\nM30\n".encode()
    assert not chipbreak.rewrite(program, load("fanuc-lathe")).shown.rule


def test_a_profile_that_says_it_is_not_asked() -> None:
    program = pointless(PROGRAM, 1).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", [*WISH, "control.decimal_point=required"]))
    assert result.data == program
    assert not result.shown.rule


POINTED = PROGRAM.replace("X62. Z2.", "X62.5 Z2.5")


@pytest.mark.parametrize("unit", ["G20", "G21"])
def test_the_depths_of_cycles_show_increments(unit: str) -> None:
    """Beside places with points: no pass is 1500 mm or inches deep."""
    per_unit = 10_000 if unit == "G20" else 1_000
    depths = [f"U{round(0.15 * per_unit)} R{round(0.05 * per_unit)}", f"U{round(0.1 * per_unit)} W100"]
    pointless_depths = POINTED.replace("U2. R1.", depths[0]).replace("U1. W0.1", depths[1])
    pointless_depths = pointless_depths.replace("G21", unit)
    pointed = POINTED.replace("U2. R1.", "U0.15 R0.05").replace("U1. W0.1", f"U0.1 W{100 / per_unit}")
    settings = load("fanuc-lathe", WISH)
    result = chipbreak.rewrite(pointless_depths.encode(), settings)
    wanted = chipbreak.rewrite(pointed.replace("G21", unit).encode(), settings)
    assert blocks(result.data) == blocks(wanted.data)
    assert result.shown.rule == "increment"
    assert chipbreak.restore(result.data) == pointless_depths.encode()
    (said,) = [one for one in result.diagnostics if one.code == "MOD006"]
    assert said.place is not None
    assert said.place.line == 6
    assert depths[0].split()[0] in said.message


@pytest.mark.parametrize(
    ("depths", "allowances"),
    [
        ("U1500 R0.5", "U1. W0.1"),  # one number alone is a slip
        ("U2 R500", "U1000 W100"),  # 2 steps are no depth
        ("U20 R50", "U50 W10"),  # each may be either
    ],
)
def test_depths_that_show_neither(depths: str, allowances: str) -> None:
    program = POINTED.replace("U2. R1.", depths).replace("U1. W0.1", allowances).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", WISH))
    assert result.data == program
    assert not result.shown.rule


def test_a_place_that_shows_the_other_reading_keeps_depths_unknown() -> None:
    program = POINTED.replace("U2. R1.", "U1500 R500").replace("Z-15.", "Z-15").encode()
    assert not chipbreak.rewrite(program, load("fanuc-lathe", WISH)).shown.rule
