"""Milling programs as shops write them, with checks, past LinuxCNC's own interpreter.

In several hands: Fusion, FreeCAD and Mastercam as their posts write, programs typed at the machine, inch,
distances from place to place, subprograms, loops, drilling cycles, several work offsets, coolants, stops.
Each does with its checks what it did without: every move, and all that is in force at it.
"""

from __future__ import annotations

from collections import Counter
from functools import cache
from itertools import product
from pathlib import Path

import pytest

import chipbreak
from beam import BEAM
from chipbreak.editing.restore import regions
from chipbreak.text.source import read
from longer import short_where

from . import rs274
from .actions import actions
from .test_checks_on_interpreter import TOOLS, compared, wooden_macros

FOLDER = Path(__file__).parents[1] / "shop_mills"
# How many TOOL CHECKs and CHIP CHECKs each of them gets, and how often no place is found.
EXPECTED = {
    "arcs_and_planes.ngc": (1, 2, 0),
    "back_and_forth.ngc": (3, 3, 0),
    "bolt_row_g91.ngc": (2, 3, 0),
    "by_hand.ngc": (2, 3, 1),
    "coolants.ngc": (1, 4, 0),
    "drilling_inch.ngc": (3, 4, 0),
    "freecad_pocket.ngc": (2, 3, 0),
    "fusion_bracket.ngc": (3, 4, 0),
    "loops.ngc": (2, 3, 0),
    "mastercam_inch.nc": (2, 3, 0),
    "stops_and_slashes.ngc": (2, 3, 0),
    "subprograms.ngc": (2, 3, 0),
    "three_setups.ngc": (2, 2, 0),
}
FEW = {"coolants.ngc", "stops_and_slashes.ngc", "subprograms.ngc"}
LEFT = {"SPINDLE", "SET_SPINDLE_SPEED", "MIST", "FLOOD"}


@cache
def checked(name: str) -> chipbreak.Result:
    tools = f'tools.files=["{wooden_macros() / "tools.csv"}"]'
    profile = chipbreak.load("linuxcnc-mill", [*BEAM, tools])
    return chipbreak.rewrite((FOLDER / name).read_bytes(), profile, name)


def test_all_of_them_are_looked_at() -> None:
    assert {path.name for path in FOLDER.iterdir()} == set(EXPECTED)
    assert len(EXPECTED) >= 12


@pytest.mark.parametrize("name", EXPECTED)
def test_each_tool_is_checked(name: str) -> None:
    result = checked(name)
    titles = Counter(part.split(" T")[0] for edit in result.edits for part in edit.title.split(", "))
    left_out = sum(one.code == "CHK002" for one in result.diagnostics)
    assert titles["CALIBRATE"] == 1
    assert titles["TRACE"] <= titles["TOOL CHECK"]
    assert (titles["TOOL CHECK"], titles["CHIP CHECK"], left_out) == EXPECTED[name]


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    ("name", "block_delete"),
    short_where(product(EXPECTED, [False, True]), lambda case: not case[1] or case[0] in FEW),
)
def test_it_does_what_it_did(name: str, block_delete: bool) -> None:
    program = (FOLDER / name).read_bytes()
    assert compared(program, block_delete=block_delete) == "checked"


@pytest.mark.linuxcnc
@pytest.mark.parametrize("name", short_where(EXPECTED, lambda name: name in FEW))
def test_at_the_end_of_each_bracket_all_is_in_force_that_was_before(name: str) -> None:
    """Cut off behind a bracket, a program has in force what it has when it is cut off before it.

    But for spindle and coolant, which are left to the program where it says them next.
    """
    result = checked(name)
    lines = result.data.split(b"\n")
    source = read(result.data)
    for region in regions(source):
        before = in_force(lines[: region.first])
        behind = in_force(lines[: region.last])
        assert behind == before, lines[region.first]


def in_force(lines: list[bytes]) -> dict[str, tuple[str, ...]]:
    """What is in force at a last rapid that is put behind these lines."""
    program = b"\n".join([*lines, b"G0 X999 Y999", b"M2", b""])
    judged = rs274.judge(program, lathe=False, subroutines=wooden_macros(), tools=TOOLS)
    assert judged.accepted, judged.message
    (*_, last, _) = actions(judged.canon)
    assert last.name == "STRAIGHT_TRAVERSE"
    return {name: value for name, value in last.in_force.items() if name not in LEFT}
