"""A check before a block that ends the program, feeds in machine coordinates, or changes the tool anew."""

from __future__ import annotations

import pytest

import chipbreak
from checks.filtered import Filtered, check, filtered

CUT = "T1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nX9.\nG0 Z15.\n"
HEAD = "G21 G90 G94 G17 G49 G40 G80\nG0 G53 Z0.\n"


def run(program: str, profile: str = "fanuc-mill") -> Filtered:
    result = filtered((HEAD + program).encode(), profile)
    check(result)
    return result


@pytest.mark.parametrize(
    ("last", "back"),
    [
        ("G0 Z40. M30", ["G0 X9. Y2.", "G0 G43 H1 Z15."]),  # straight up where the tool was
        ("G0 X20. Y30. Z40. M30", ["G0 X9. Y2.", "G0 G43 H1 Z15."]),  # no slant from the tool setter
        ("G0 X20. Y30. M30", []),
        ("M30", []),
    ],
)
def test_what_the_last_block_moves_it_moves_from_where_the_tool_was(last: str, back: list[str]) -> None:
    result = run(f"{CUT}{last}\n")
    edit = next(edit for edit in result.edits if "CHIP CHECK" in edit.title)
    assert [text for text in edit.content if isinstance(text, str) and text.startswith("G0 ")] == back


@pytest.mark.parametrize(("feeds", "turns"), [("G53 G1 X1. F50.", True), ("G53 G0 X1.", False)])
def test_a_feed_in_machine_coordinates_finds_the_spindle_turning(feeds: str, *, turns: bool) -> None:
    result = run(f"{CUT}{feeds}\nM5\nM2\n", "linuxcnc-mill")
    edit = next(edit for edit in result.edits if "CHIP CHECK" in edit.title)
    assert ("S1000 M3" in edit.content) is turns


@pytest.mark.parametrize(("starts", "why"), [("M3\n", ""), ("", "whether it still turns cannot be known")])
def test_m6_alone_may_stop_the_spindle(starts: str, why: str) -> None:
    """A check behind it would start it again, where it had stood."""
    operation = "G0 X3. Y4.\nG43 Z40. H1\nG1 Z-2. F100.\nG0 Z40.\n"
    result = run(f"{CUT}M6\n{starts}{operation}(ROUGH)\n{operation}M5\nM2\n", "linuxcnc-mill")
    assert [title for title in result.titles if "T1 W0.05" in title] == (
        [] if why else ["CHIP CHECK T1 W0.05"]
    )
    assert why in str(result.diagnostics)


def test_coolant_that_m72_gives_back_is_no_surer_than_it_was() -> None:
    program = f"/M8\nM70\nM9\nM72\n{CUT}G0 Z50.\nM5\nM9\nM2\n"
    assert "coolant" in str(run(program, "linuxcnc-mill").diagnostics)
    assert "coolant" not in str(run(program.replace("/M8", "M8"), "linuxcnc-mill").diagnostics)


_ONE_ARM = "o10 if [#1 EQ 1]\n{}\nM70\n{}\no10 endif\n"


@pytest.mark.parametrize(
    ("kept", "is_sure"),
    [
        ("M70\n", True),
        (_ONE_ARM.format("M4", "M3") + "M70\n", True),
        ("M70\n" + _ONE_ARM.format("M3", "M3"), True),
        ("M70\n" + _ONE_ARM.format("M4", "M3"), False),
        ("M70\n" + _ONE_ARM.format("M5", "M3"), False),
        ("M70\n" + _ONE_ARM.format("M8", "M9"), False),
        (_ONE_ARM.format("M4", "M3").replace("o10 endif", "o10 else\nM70\no10 endif"), False),
        ("M70\nM4\n/M70\nM3\n", False),
        ("o10 do\nM70\nM4\no10 while [#1 LT 3]\nM3\n", False),
    ],
)
def test_what_m72_gives_back_may_be_of_another_m70(kept: str, is_sure: bool) -> None:
    """A check behind it would start the spindle the other way round, or one that stood."""
    cut = "G0 X3. Y4. Z5.\nG1 Z-1. F100.\nX9.\nG0 Z50.\n"
    program = f"T1 M6\nG43 H1\nS900 M3\n{cut}{kept}M72\n{cut}M1\n(ROUGH)\n{cut}M5\nM9\nM2\n"
    result = run(program, "linuxcnc-mill")
    behind = (HEAD + program).split("\n").index("M72")
    restarts = [
        text for edit in result.edits if edit.first > behind for text in edit.content if "S900" in text
    ]
    assert restarts == (["S900 M3"] if is_sure else [])


@pytest.mark.parametrize(
    ("part", "is_sure"), [("M[3]", True), ("M#1", False), ("G#1", False), ("M#1\nM3\nM9", True)]
)
def test_a_check_behind_a_code_that_the_machine_works_out(part: str, is_sure: bool) -> None:
    """It may be M5, another direction, or another plane: nothing can be put back."""
    cut = "G0 X3. Y4. Z5.\nG1 Z-1. F100.\nX9.\nG0 Z50.\n"
    program = f"T1 M6\nG43 H1\nS900 M3\n{cut}{part}\n{cut}M1\n(ROUGH)\n{cut}M5\nM9\nM30\n"
    result = run(program)
    behind = (HEAD + program).split("\n").index(part.split("\n", maxsplit=1)[0])
    restarts = [
        text for edit in result.edits if edit.first > behind for text in edit.content if "S900" in text
    ]
    assert restarts == (["S900 M3"] if is_sure else [])


def test_a_program_without_an_end_is_checked_behind_its_last_cut() -> None:
    settings = chipbreak.load("haas-mill")
    cut = "T1\nM6\nS800 M3\nZ25.\nG95\nG1 Z-3. F0.1 E2.\nG0 Z25.\n"
    assert b"BEGIN VIB" in chipbreak.rewrite(cut.encode(), settings, allow_unbroken=True).data


def test_a_block_that_begins_another_program_with_a_cut() -> None:
    """``O5 G98 G73 ..``: what it starts from is none of the program before it."""
    first = "T1\nM6\nG1 Z-4. F0.1\nG0 Z25.\nT2 M6\nG0 X10. Y0.\nG43 H2 Z25.\n"
    program = f"{first}O5 G98 G73 Z-5. R2. Q1. F100.\n".encode()
    result = chipbreak.rewrite(program, chipbreak.load("fanuc-mill-renishaw"))
    assert result.changed
    assert chipbreak.restore(result.data) == program


@pytest.mark.parametrize(
    ("line", "is_checked"), [("F100. G20", False), ("F100.\nG20", False), ("G20\nF4.", True)]
)
def test_an_f_that_is_read_before_the_units_change_lets_no_check_in(line: str, *, is_checked: bool) -> None:
    """LinuxCNC's M72 would give it back as a number in the other units; F stands beside G20 or before it."""
    operation = "G0 X3. Y4.\nG43 Z10. H2\nG1 Z-2. F100.\nG0 Z10.\n"
    result = run(f"{line}\nT2 M6\nS900 M3\n(ROUGH)\n{operation}M5\nM2\n", "linuxcnc-mill")
    assert bool(result.edits) is is_checked
    assert ("F is from before the change of units" in str(result.diagnostics)) is not is_checked
