"""What one block of a call would leave behind it, by its words; and what is given back, or does not last."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.checks.left_behind import left_behind
from chipbreak.syntax.parse import read_block

TURNS = "turns, scales or bends the coordinates"
LASTS = {
    "M30": "ends the program",
    "M2": "ends the program",
    "M99": "ends the program",
    "O77": "begins a program",
    "O77 (TITLE)": "begins a program",
    "GOTO 5": "jumps, loops, or waits for another path",
    "IF [#1 EQ 1] GOTO 5": "jumps, loops, or waits for another path",
    "F300.": "sets the feed F",
    "G1 Z5. F300.": "sets the feed F",
    "T5": "calls a tool",
    "M6": "calls a tool",
    "T5 M6": "calls a tool",
    "G92 S2000": "limits the spindle",
    "G92 X0.": "moves the zero",
    "G52 X5.": "moves the zero",
    "G10 L2 P1 X5.": "moves the zero",
    "G10 L20 P1 X5.": "moves the zero",
    "G41 D1": "begins a compensation of the cutter",
    "G42 D1": "begins a compensation of the cutter",
    "G20": "changes the units",
    "G21": "changes the units",
    "G93": "changes the feed mode",
    "G95": "changes the feed mode",
    "G96 S100": "changes the speed mode",
    "G97": "changes the speed mode",
    "G43 H1": "changes the length offset",
    "G49": "changes the length offset",
    "G66 P8900": "begins or ends a modal macro call",
    "G67": "begins or ends a modal macro call",
    "G68 X0. Y0. R30.": TURNS,
    "G51 X1. Y1. P2000": TURNS,
    "G51.1 X0.": TURNS,
    "G16": TURNS,
}
DOES_NOT = (
    *(
        "G65 P9000 T5",
        "M98 P5",
        "G40",
        "G90",
        "G91",
        "G0 Z5.",
        "G53 Z0.",
        "M3 S500",
        "M5",
        "M8",
        "M9",
        "G4 X1.",
    ),
    *("G10 L11 P1 R0.", "G10 L10 P1 R0.", "#100=1", "G17", "G54", "G80", "M19", "G28 Z0."),
)


@pytest.mark.parametrize("text", LASTS)
def test_what_lasts_is_named(text: str) -> None:
    settings = chipbreak.load("fanuc-mill")
    assert left_behind(read_block(0, text, settings.dialect), settings) == LASTS[text]


@pytest.mark.parametrize("text", DOES_NOT)
def test_what_is_given_back_or_is_over_is_not(text: str) -> None:
    settings = chipbreak.load("fanuc-mill")
    assert left_behind(read_block(0, text, settings.dialect), settings) == ""


@pytest.mark.parametrize(
    ("profile", "text", "said"),
    [
        ("linuxcnc-mill", "o<cb_trace> call [1]", ""),
        ("linuxcnc-mill", "o100 sub", "jumps, loops, or waits for another path"),
        ("linuxcnc-mill", "o100 if [#1 EQ 2]", "jumps, loops, or waits for another path"),
        ("linuxcnc-lathe", "G7", "changes between radius and diameter"),
        ("linuxcnc-lathe", "G8", "changes between radius and diameter"),
    ],
)
def test_on_linuxcnc(profile: str, text: str, said: str) -> None:
    settings = chipbreak.load(profile)
    assert left_behind(read_block(0, text, settings.dialect), settings) == said
