"""M codes that only the profile knows: which of them turn the spindle, and what is said of others."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.settings import SettingsError, load
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

PROGRAM = b"T0101\nG97 S800 M203\nG0 X40. Z2.\nG1 Z-30. F0.2\nG0 X60.\nM30\n"
ASKED = "vibration.n=1.5"


def behind(
    program: bytes, line: int, *options: str, profile: str = "fanuc-lathe"
) -> tuple[str, frozenset[str]]:
    """What turns, and which coolant flows, before a line (from 0)."""
    settings = load(profile, options)
    state = interpret(parse(read(program), settings.dialect), settings).before(line)
    return state.spindle, state.coolant


@pytest.mark.parametrize(("code", "turns"), [(b"M13", "cw"), (b"M14", "ccw")])
def test_the_codes_of_the_standard_turn_the_spindle_and_switch_coolant_on(code: bytes, turns: str) -> None:
    program = PROGRAM.replace(b"M203", code)
    assert behind(program, 2) == (turns, frozenset({"flood"}))
    assert chipbreak.rewrite(program, load("fanuc-lathe", [ASKED])).cuts


def test_a_haas_gives_them_to_something_else() -> None:
    assert behind(PROGRAM.replace(b"M203", b"M13"), 2, profile="haas-lathe") == ("stop", frozenset())


@pytest.mark.parametrize("code", [b"M203", b"M93", b"M303"])
def test_a_code_that_nobody_knows_is_named_and_its_way_out_works(code: bytes) -> None:
    """The key that the help names makes a cut of it."""
    program = PROGRAM.replace(b"M203", code)
    result = chipbreak.rewrite(program, load("fanuc-lathe", [ASKED]))
    (left,) = [one for one in result.left if one.is_cut]
    assert left.said.code == "VIB069"
    assert code.decode() in left.said.message
    assert "--set spindle.cw_codes" in left.said.help
    number = code.decode()[1:]
    named = chipbreak.rewrite(program, load("fanuc-lathe", [ASKED, f"spindle.cw_codes={number}"]))
    assert len(named.cuts) == 1
    assert chipbreak.restore(named.data) == program


def test_what_stops_the_spindle_by_a_code_of_the_builder() -> None:
    program = PROGRAM.replace(b"M203", b"M3").replace(b"G0 X40. Z2.", b"G0 X40. Z2. M205")
    assert behind(program, 3, "spindle.stop_codes=205") == ("stop", frozenset())


def test_a_gear_with_s_before_the_start_is_no_start() -> None:
    program = PROGRAM.replace(b"G97 S800 M203\n", b"G97 S800 M41\nM3\n")
    assert chipbreak.rewrite(program, load("fanuc-lathe", [ASKED])).cuts


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["spindle.cw_codes=8"], "M8 has a meaning of its own"),
        (["spindle.cw_codes=30"], "M30 has a meaning of its own"),
        (["spindle.cw_codes=[203]", "spindle.ccw_codes=[203]"], "M203 is named twice"),
        (["spindle.stop_codes=13"], "M13 is named twice"),
    ],
)
def test_a_code_has_one_meaning(options: list[str], why: str) -> None:
    with pytest.raises(SettingsError, match=why) as caught:
        load("fanuc-lathe", options)
    assert caught.value.diagnostic.code == "SET003"
