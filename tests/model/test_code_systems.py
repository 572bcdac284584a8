"""A program that only another code system of lathes gives a meaning is said to be one; others are not."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.settings import load
from chipbreak.text.diagnostics import Diagnostic

HEAD = "T0101\nG97 S800 M3\nG0 X60. Z2.\n"
MIXED = ("O1114",)  # G99 as in A and G92 S3000 as in B: the limit is that of a control that nobody names
OF_ANOTHER_SYSTEM = {"O0008": "B", "O1110": "B", "O1302": "B", "O1303": "C"}
SHOP = Path(__file__).parents[1] / "shop"


def said(program: str, profile: str = "fanuc-lathe", system: str = "A") -> list[Diagnostic]:
    settings = load(profile, [f"control.lathe_system={system}"])
    found = chipbreak.rewrite(program.encode(), settings).diagnostics
    return [one for one in found if one.code == "MOD004"]


@pytest.mark.parametrize(
    ("system", "block", "shown"),
    [
        ("A", "G92 S2500", "B and C"),
        ("A", "G92 S2500 M3", "B and C"),
        ("A", "G95", "B and C"),
        ("A", "G91 G28 X0 Z0", "B and C"),
        ("A", "G54 G90 G40", "B and C"),
        ("A", "G94 G40", "B and C"),
        ("A", "G77 X50. Z-20. F0.2", "B"),
        ("A", "G79 X50. Z-2. F0.2", "B"),
        ("A", "G71", "C"),
        ("B", "G70 G40", "C"),
        ("B", "G99", "A"),
        ("B", "G98 G40", "A"),
        ("B", "G92 X19.2 Z-20. F1.5", "A"),
        ("C", "G21 G40", "A and B"),
        ("C", "G71 P10 Q20 U0.4 W0.1 F0.2", "A and B"),
    ],
)
def test_a_code_of_another_system_is_said_at_its_word(system: str, block: str, shown: str) -> None:
    (one,) = said(f"{HEAD}{block}\nG0 X80.\nM30\n", system=system)
    assert f"in code system {shown}, and the profile says {system}" in one.message
    assert one.place is not None and one.place.line == 4
    # The way out: under each of the systems it names, nothing is said.
    for other in shown.split(" and "):
        assert f'"{other}"' in one.help
        assert not said(f"{HEAD}{block}\nG0 X80.\nM30\n", system=other)


@pytest.mark.parametrize(
    ("system", "blocks"),
    [
        ("A", "G90 X50. Z-20. F0.2\nX48."),
        ("A", "G94 X20. Z-1. F0.2\nZ-2."),
        ("A", "G90\nX50. Z-20. F0.2"),
        ("A", "G92 X19.2 Z-20. F1.5"),
        ("A", "G98 G40\nG99"),
        ("A", "G50 S2500"),
        ("A", "G71 U2. R0.5"),
        ("B", "G90 G95\nG92 S2500\nG92 X100. Z50."),
        ("B", "G94 G98\nG83 Z-20. R2. F100\nG80"),
        ("B", "G71 U2. R0.5"),
        ("C", "G71 G90 G95\nG73 U2. R0.5"),
    ],
)
def test_what_a_system_means_itself_is_not_said(system: str, blocks: str) -> None:
    assert not said(f"{HEAD}{blocks}\nG0 X80.\nM30\n", system=system)


def test_a_program_shows_it_once_where_it_shows_it_first() -> None:
    (one,) = said("G90 G95 G21\nG92 S2500\nG96 S180 M3\nG95\nG77 X50. Z-2. F0.2\nM30\n")
    assert one.place is not None and (one.place.line, one.place.column) == (1, 1)
    assert one.message.startswith("G90 ")


def test_controls_without_such_systems_say_nothing() -> None:
    for profile in ("linuxcnc-lathe", "generic-lathe", "fanuc-mill"):
        found = chipbreak.rewrite(b"G90 G95 G21\nG92 S2500\nM30\n", load(profile)).diagnostics
        assert not [one for one in found if one.code == "MOD004"]


@pytest.mark.parametrize("path", sorted(SHOP.glob("*.nc")), ids=lambda path: path.stem)
def test_programs_of_shops(path: Path) -> None:
    """Those that are written for another system show it, and no other one does but the mixed one."""
    other = path.stem in (*MIXED, *OF_ANOTHER_SYSTEM)
    plain = load("fanuc-lathe", ['cycles.unroll="never"'])
    found = chipbreak.rewrite(path.read_bytes(), plain).diagnostics
    assert bool([one for one in found if one.code == "MOD004"]) is other


@pytest.mark.parametrize(("name", "system"), OF_ANOTHER_SYSTEM.items())
def test_a_program_is_read_in_the_system_that_it_shows(name: str, system: str) -> None:
    """As under a profile that says the system, but for what is said of it."""
    program = (SHOP / f"{name}.nc").read_bytes()
    wish = ['cycles.unroll="always"', "control.decimal_point=required"]
    shown = chipbreak.rewrite(program, load("fanuc-lathe", wish))
    known = chipbreak.rewrite(program, load("fanuc-lathe", [*wish, f"control.lathe_system={system}"]))
    assert shown.data == known.data
    assert shown.shown.system == system
    said = [one for one in shown.diagnostics if one.code == "MOD004"]
    assert f"read in code system {system}" in said[0].message
    assert [one for one in shown.diagnostics if one not in said] == list(known.diagnostics)


@pytest.mark.parametrize(
    "blocks",
    ["G99\nG92 S2500", "G50 S2000\nG90 G54 G40", "G92 X19.2 Z-20. F1.5\nG91 G28 X0", "G71\nG71 P10 Q20 U1."],
)
def test_a_program_that_shows_two_systems_shows_none(blocks: str) -> None:
    (one,) = said(f"{HEAD}{blocks}\nG0 X80.\nM30\n", system="shown")
    assert "the profile says A" in one.message


def test_the_limit_of_the_system_that_is_shown_holds() -> None:
    """G92 S2000 limits the spindle of what is read in system B."""
    program = b"G90 G95\nG92 S2000\nT0101\nG97 S3000 M3\nG0 X60. Z2.\nG1 Z-30. F0.2 N1.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as raised:
        chipbreak.rewrite(program, load("fanuc-lathe"))
    assert any("2000" in one.message for one in raised.value.diagnostics)
