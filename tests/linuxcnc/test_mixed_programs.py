"""Whatever is mixed around the cuts, LinuxCNC does the same outside the changes as it did before.

The original is held against the filtered program: each block outside the brackets with the state that it
meets, and the state behind each bracket.  ``make test`` draws some hundred programs, ``make fuzz`` others.
"""

from __future__ import annotations

from functools import cache

import pytest
from hypothesis import event, given, reject
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from beam import BEAM

from .compared import is_taken_and_same, is_taken_and_same_with_checks
from .mixed_programs import Mixed, program
from .test_checks_on_interpreter import TOOLS, wooden_macros

# The same each time, or a search: see tests/fuzz.py.
EXAMPLES = 300 if hypothesis_settings.default and hypothesis_settings.default.derandomize else 2000
SETTINGS = (
    'planner.model="ideal"',
    'output.segments="stroke"',
    'vibration.refused="leave"',
)
WITHOUT_CHECKS = "checks.enabled=false"


def check(mixed: Mixed) -> str:
    """Filter a program and compare; what became of it in a word."""
    try:
        result = chipbreak.rewrite(mixed.data, profile_of(mixed), allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        return "refused"
    if not result.changed:
        return "unchanged"
    for block_delete in (False, True) if b"\n/" in mixed.data else (False,):
        if not _is_taken_and_same(mixed, result.data, block_delete=block_delete):
            return "not a program"
    kinds = {
        "checked" if b" CALIBRATE" in result.data or b" CHECK" in result.data else "",
        "vibrated" if b"BEGIN VIB" in result.data else "",
    }
    return " and ".join(sorted(kinds - {""})) or "changed"


@cache
def _profile(machine: str, *sets: str) -> chipbreak.Settings:
    return chipbreak.load(machine, [*SETTINGS, *sets])


def profile_of(mixed: Mixed) -> chipbreak.Settings:
    """The machine of a program."""
    if mixed.checked:
        return _profile("linuxcnc-mill", *BEAM, f'tools.files=["{wooden_macros() / "tools.csv"}"]')
    return _profile(f"linuxcnc-{'lathe' if mixed.lathe else 'mill'}", WITHOUT_CHECKS)


def _is_taken_and_same(mixed: Mixed, output: bytes, *, block_delete: bool) -> bool:
    if mixed.checked:
        return is_taken_and_same_with_checks(
            mixed.data, output, subroutines=wooden_macros(), tools=TOOLS, block_delete=block_delete
        )
    return is_taken_and_same(mixed.data, output, lathe=mixed.lathe, block_delete=block_delete)


@pytest.mark.few(20)
@pytest.mark.linuxcnc
@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=EXAMPLES)
def test_all_else_stays_as_it_was(seed: int) -> None:
    found = check(program(seed))
    event(found)
    if found == "not a program":
        reject()


PATH_MODES = ("G64 P0.01", "G64 P0.254 Q0.05", "G61", "G64")


@pytest.mark.linuxcnc
@pytest.mark.parametrize("mode", PATH_MODES)
@pytest.mark.parametrize("units", [("G21", "G20"), ("G20", "G21"), ("G20", "G20")])
def test_a_path_mode_of_other_units_is_as_wide_behind_a_cut(*, mode: str, units: tuple[str, str]) -> None:
    first, then = units
    scale = 25.4 if then == "G21" else 1.0
    cut = ("(VIB N0.5)", f"G1 Z{0.02 * scale:.4f} F{0.15 * scale:.4f}", "(VIB OFF)")
    lines = ("G17 G90 G94 G61", first, mode, then, "M3 S2000", f"G0 X0 Y0 Z{0.1 * scale:.4f}", *cut, "M2", "")
    assert check(Mixed("\n".join(lines).encode(), lathe=False, checked=False)) == "vibrated"


@pytest.mark.linuxcnc
@pytest.mark.parametrize("reads", ["G4 P#<_feed>", "M70\nG94 F5\nM72\nG4 P#<_feed>", "#5=#<_feed>\nG4 P#5"])
@pytest.mark.parametrize("mode", ["G94 F200", "G95 F0.1"])
def test_what_reads_a_feed_of_other_units_finds_its_number(*, mode: str, reads: str) -> None:
    lines = ("G17 G90", "G21", mode, "G20", "M3 S2000", "G0 X0 Y0 Z0.1")
    program = "\n".join([*lines, "(VIB N0.5)", "G1 Z-0.05", "(VIB OFF)", reads, "G1 Z-0.06", "M2", ""])
    assert check(Mixed(program.encode(), lathe=False, checked=False)) == "vibrated"


@pytest.mark.linuxcnc
@pytest.mark.parametrize("home", ["G28", "G30"])
def test_a_home_of_the_programs_own_is_reached_from_where_the_tool_was(home: str) -> None:
    moves = ("G0 X18 Y11.8", "G0 X17.7 Y12.3 Z16.3", "T1 M6", f"S1250 F0.1 {home}.1", "M3", home)
    program = "\n".join([*moves, "G1 X10.6 Y9.8 Z13.4 F2", "M2", ""])
    assert check(Mixed(program.encode(), lathe=False, checked=True)) in ("checked", "unchanged")
