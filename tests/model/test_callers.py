"""Programs behind the first one of a file begin as their callers leave the control, or by themselves."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.model.modal import State
from chipbreak.settings import load
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

MAIN = """O0010
T0101
G99 G97 S800 M3
G0 X60. Z2. M8
F0.2
M98 P0101
G0 X200. Z100.
M30
"""
BODY = "G1 Z-30.\nG0 X62.\n"
SUB = f"O0101\n{BODY}M99\n"
SETTINGS = load("fanuc-lathe", ["vibration.n=1.5"])


def entry(program: str) -> State:
    """The state in which O0101 begins."""
    line = program.splitlines().index("O0101")
    return interpret(parse(read(program.encode()), SETTINGS.dialect), SETTINGS).before(line + 1)


def is_followed(program: str) -> bool:
    return not entry(program).spindle_why


def test_a_called_program_begins_as_its_call_finds_the_control() -> None:
    state = entry(MAIN + SUB)
    assert state.position[::2] == (30.0, 2.0)
    assert (state.spindle, state.coolant) == ("cw", frozenset({"flood"}))
    assert state.speed is not None and state.speed.value == 800.0
    assert state.feed is not None and state.feed.value == 0.2


def test_its_cuts_vibrate_as_they_would_in_the_place_of_the_call() -> None:
    """Held against the same blocks written out where the call stands."""
    called = chipbreak.rewrite((MAIN + SUB).encode(), SETTINGS)
    inline = chipbreak.rewrite(MAIN.replace("M98 P0101\n", BODY).encode(), SETTINGS)
    assert len(called.cuts) == len(inline.cuts) == 1
    blocks = [
        data.data.decode().partition("(CHIPBREAK BEGIN")[2].partition("(CHIPBREAK END")[0]
        for data in (called, inline)
    ]
    assert blocks[0] == blocks[1]
    assert chipbreak.restore(called.data) == (MAIN + SUB).encode()
    assert chipbreak.rewrite(called.data, SETTINGS).data == called.data


def test_that_others_may_call_it_is_said() -> None:
    (said,) = [
        one for one in chipbreak.rewrite((MAIN + SUB).encode(), SETTINGS).diagnostics if one.code == "VIB096"
    ]
    assert "O0101 vibrates with S, F and the start that its calls in this file give it" in said.message


AGAIN = MAIN.replace("M98 P0101\n", "M98 P0101\nG0 X60. Z2.\nM98 P0101\n")


@pytest.mark.parametrize(
    "program",
    [
        AGAIN + SUB,
        MAIN.replace("P0101", "P10101") + SUB,
        MAIN.replace("M98 P0101", "M98 P101 L1") + SUB,
        MAIN + SUB.replace("O0101\n", "O0101\n/M8\n"),
        AGAIN.replace("G0 X60. Z2.\nM98", "G55\nG0 X60. Z2.\nM98") + SUB,
    ],
)
def test_calls_that_agree(program: str) -> None:
    assert is_followed(program)


@pytest.mark.parametrize(
    "program",
    [
        MAIN.replace("P0101", "P20101") + SUB,
        MAIN.replace("M98 P0101", "M98 P0101 L2") + SUB,
        MAIN.replace("M98 P0101", "/M98 P0101") + SUB,
        MAIN.replace("M98 P0101", "M98 P#1") + SUB,
        MAIN.replace("M98 P0101", "G0 X58. M98 P0101") + SUB,
        MAIN.replace("M98 P0101", "M98 P0101\nG65 P0101 A1.") + SUB,
        AGAIN + SUB.replace("G1 Z", "G98 G1 Z"),
        AGAIN + SUB.replace("M99", "M5\nM99"),
        AGAIN + SUB.replace("G1 Z", "T0202\nG1 Z"),
        MAIN.replace("M98 P0101", "M1") + SUB,
    ],
    ids=[
        "twice",
        "L2",
        "skip",
        "variable",
        "moves",
        "macro",
        "mode",
        "stops",
        "tool",
        "none",
    ],
)
def test_what_is_not_followed(program: str) -> None:
    """Calls that differ, repeat, may be left out, or come behind what nobody knows."""
    assert not is_followed(program)


def test_calls_from_two_places_leave_the_places_unknown() -> None:
    state = entry(AGAIN.replace("G0 X60. Z2.\nM98", "G0 X60. Z9.\nM98") + SUB)
    assert state.spindle == "cw"
    assert state.position.x == 30.0
    assert math.isnan(state.position.z)


def test_calls_with_different_speeds_leave_the_speed_unknown() -> None:
    """So a cut that says none itself is refused."""
    program = AGAIN.replace("G0 X60. Z2.\nM98", "G97 S900\nG0 X60. Z2.\nM98") + SUB
    assert entry(program).speed is None
    assert not chipbreak.rewrite(program.encode(), SETTINGS).cuts
    assert chipbreak.rewrite(program.replace("G1 Z-30.", "S800 G1 Z-30.").encode(), SETTINGS).cuts


def test_a_feed_that_the_program_itself_says_is_not_that_of_its_next_call() -> None:
    assert entry(AGAIN + SUB.replace("Z-30.", "Z-30. F0.1")).feed is None


def test_a_call_in_a_called_program() -> None:
    between = "O0100\nG0 X50.\nM98 P0101\nM99\n"
    assert entry(MAIN.replace("P0101", "P0100") + between + SUB).position[::2] == (25.0, 2.0)


def test_a_second_main_program_begins_as_the_first_one() -> None:
    """It ends itself, so nobody calls it; where its tool stands is known from its first moves on."""
    second = "O0101\nT0202\nG97 S500 M3\nG0 X40. Z1.\nG1 Z-10. F0.1\nG0 X60.\nM30\n"
    state = entry(MAIN.replace("M98 P0101\n", "") + second)
    assert (state.spindle, state.spindle_why) == ("stop", "")
    assert (
        len(chipbreak.rewrite((MAIN.replace("M98 P0101\n", "G1 Z-30.\n") + second).encode(), SETTINGS).cuts)
        == 2
    )


def test_one_that_never_says_that_it_turns_is_not_taken_for_turning() -> None:
    second = "O0101\nG0 X40. Z1.\nG1 Z-10. F0.1\nM30\n"
    assert not entry(MAIN.replace("M98 P0101\n", "") + second).turns


PART = "N500 G1 Z-30.\nG0 X62.\nM99\n"
HAAS = MAIN.replace("M98 P0101", "M97 P500")


def part_entry(program: str) -> State:
    """The state in which the part at N500 begins."""
    line = next(at for at, text in enumerate(program.splitlines()) if text.startswith("N500"))
    return interpret(parse(read(program.encode()), SETTINGS.dialect), SETTINGS).before(line)


def test_a_part_of_a_program_begins_as_its_own_call_finds_the_control() -> None:
    state = part_entry(HAAS + PART)
    assert state.position[::2] == (30.0, 2.0)
    assert (state.spindle, state.spindle_why) == ("cw", "")
    assert state.feed is not None and state.feed.value == 0.2


def blocks_of_cut(data: bytes) -> list[str]:
    """What stands for the first vibrated cut, without what it was."""
    inside = data.decode().partition("(CHIPBREAK BEGIN")[2].partition("(CHIPBREAK END")[0]
    return [line for line in inside.splitlines() if "WAS" not in line]


def test_the_cuts_of_a_part_vibrate_and_the_way_back_is_whole() -> None:
    program = (HAAS + PART).encode()
    result = chipbreak.rewrite(program, SETTINGS)
    inline = chipbreak.rewrite(MAIN.replace("M98 P0101\n", BODY).encode(), SETTINGS)
    assert len(result.cuts) == 1
    assert blocks_of_cut(result.data) == blocks_of_cut(inline.data)
    assert b"N500 (CHIPBREAK BEGIN" in result.data  # the call finds its number
    assert chipbreak.restore(result.data) == program
    assert chipbreak.rewrite(result.data, SETTINGS).data == result.data
    # Nothing else calls it, it is in this file, and its cuts vibrate.
    assert not {"VIB067", "VIB095", "VIB096"} & {one.code for one in result.diagnostics}


def test_a_cycle_in_a_part_is_written_out_behind_its_number() -> None:
    cycle = "N500 G71 U2. R.5\nG71 P1 Q2 U.4 W.1 F.2\nN1 G0 X30.\nG1 Z-20. F.1\nX50. Z-30.\nN2 X60.\nM99\n"
    program = (HAAS + cycle).encode()
    result = chipbreak.rewrite(program, SETTINGS)
    assert result.cuts
    assert b"N500 (CHIPBREAK UNROLLED G71" in result.data
    assert chipbreak.restore(result.data) == program
    assert chipbreak.rewrite(result.data, SETTINGS).data == result.data


def test_parts_of_two_programs_with_one_number_are_two() -> None:
    second = HAAS.replace("O0010", "O0020").replace("X60. Z2.", "X40. Z1.")
    program = HAAS + PART + second + PART
    lines = [at for at, text in enumerate(program.splitlines()) if text.startswith("N500")]
    interpreted = interpret(parse(read(program.encode()), SETTINGS.dialect), SETTINGS)
    assert [interpreted.before(line).position.x for line in lines] == [30.0, 20.0]


@pytest.mark.parametrize(
    "program",
    [
        HAAS.replace("M30\n", "") + PART,
        HAAS.replace("M30", "/M30") + PART,
        HAAS.replace("P500", "P500 L3") + PART,
        HAAS.replace("M97 P500", "M97 P500\nG0 X58. M97 P500") + PART,
        HAAS + PART.replace("M99", "M30"),
        HAAS.replace("M97 P500", "M98 P500") + PART,
    ],
    ids=["also reached", "perhaps reached", "repeats", "moves", "ends", "another program"],
)
def test_parts_that_are_not_followed(program: str) -> None:
    state = part_entry(program)
    assert state.ended or state.position.x != 30.0
    line = next(at for at, text in enumerate(program.splitlines()) if text.startswith("N500"))
    interpreted = interpret(parse(read(program.encode()), SETTINGS.dialect), SETTINGS)
    assert line not in interpreted.interpreter.entries
