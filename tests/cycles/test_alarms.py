"""Where a Fanuc stops with an alarm for the very fault that is refused, the message and the page name it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak
from chipbreak.settings import load

PAGE = Path(__file__).parents[2] / "docs" / "cycles.md"
HEAD = "O1\nG21 G99 G40\nT0101\nG97 S900 M3\nG0 X62. Z2.\n"
CYCLE = "G71 U2. R1.\nG71 P10 Q20 U1. W0.1 F0.25\n"
SHAPE = "N10 G0 X20.\nG1 Z-15.\nX30.\nZ-30.\nN20 X62.\n"
TAIL = "G0 X90. Z50.\nM30\n"
ACROSS = CYCLE.replace("G71 U2.", "G72 W2.").replace("G71", "G72")
SHAPE_ACROSS = "N10 G0 Z-30.\nG1 X50.\nZ-15.\nX40.\nN20 Z2.\n"
FAULTS = {
    "no such block": ("CYC001", "PS0063", CYCLE.replace("Q20", "Q21") + SHAPE),
    "an arc first": ("CYC002", "PS0065", CYCLE + SHAPE.replace("N10 G0 X20.", "N10 G2 X20. Z0. R30.")),
    "a foreign code": ("CYC002", "PS0325", CYCLE + SHAPE.replace("X30.", "G53 X30.")),
    "a corner last": ("CYC002", "PS0069", CYCLE + SHAPE.replace("N20 X62.", "N20 X60. ,C1.")),
    "back in Z": ("CYC003", "PS0064", CYCLE + SHAPE.replace("X30.\n", "X30. Z-10.\n")),
    "back in X": ("CYC003", "PS0329", CYCLE + SHAPE.replace("X30.\n", "X30.\nX26. Z-20.\n")),
    "across, back in X": ("CYC003", "PS0329", ACROSS + SHAPE_ACROSS.replace("Z-15.\n", "X54. Z-15.\n")),
    "across, back in Z": (
        "CYC003",
        "PS0064",
        ACROSS + SHAPE_ACROSS.replace("Z-15.\n", "Z-15.\nX45. Z-20.\n"),
    ),
    "no depth": ("CYC004", "PS0062", CYCLE.replace("U2.", "U0.") + SHAPE),
    "no pass": ("CYC004", "PS0321", CYCLE.replace("U2. R1.", "U4. W1. R0").replace("G71", "G73") + SHAPE),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_the_alarm_stands_beside_our_code(fault: str) -> None:
    code, alarm, cycle = FAULTS[fault]
    program = (HEAD + cycle + TAIL).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ['cycles.unroll="always"']))
    assert result.data == program
    (said,) = [one for one in result.diagnostics if one.code.startswith("CYC")]
    assert said.code == code
    assert alarm in said.help


def test_the_page_has_each_of_them() -> None:
    rows = re.findall(r"^\| (CYC\d+) \| [^|]* \| (PS[^|]*) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    told = {(code, alarm) for code, alarms in rows for alarm in alarms.split(", ")}
    assert told == {(code, alarm) for code, alarm, _ in FAULTS.values()}


def test_an_angle_without_a_point_is_called_so() -> None:
    """It is 30 or 0.03 degrees."""
    shape = SHAPE.replace("Z-15.", "Z-15. ,A170")
    result = chipbreak.rewrite(
        (HEAD + CYCLE + shape + TAIL).encode(), load("fanuc-lathe", ['cycles.unroll="always"'])
    )
    (said,) = [one for one in result.diagnostics if one.code == "CYC002"]
    assert "says ,A170 without a decimal point" in said.message
