"""Programs of several paths: nothing of one path gets into another, and every mark stays."""

from __future__ import annotations

import re

import pytest

import chipbreak
from beam import BEAM
from chipbreak.editing.restore import regions
from chipbreak.text.source import read

_ONE = """G99
G97 S3000 M3
T0100
G0 X20. Z2.
G1 Z-30. F0.05 N1.5
G0 X30.
"""
_TWO = """G97 S1800 M3
T2100
G0 X10. Z5.
G1 Z-10. F0.1 N1.5
G0 Z5.
"""


def _moves_of(parts: list[bytes]) -> list[list[bytes]]:
    """The blocks that move, of the parts that have some; where S is given back may differ."""
    rows = [[row for row in part.splitlines() if re.match(rb"(G1 )?[XZ]", row)] for part in parts]
    assert len(rows) >= 2
    return [row for row in rows if row]


def _filtered(program: str, *sets: str, profile: str = "fanuc-lathe") -> bytes:
    return chipbreak.rewrite(program.encode("ascii"), chipbreak.load(profile, sets)).data


def _new_blocks(program: str) -> list[bytes]:
    """The changed parts of a filtered program, without what was there."""
    source = read(_filtered(program))
    return [source.data[source.starts[r.body] : source.starts[r.last]] for r in regions(source)]


@pytest.mark.parametrize("marks", [("$1", "$2"), ("HEAD1", "HEAD2"), ("head 1", "HEAD 2")])
def test_two_paths_become_what_each_becomes_alone(marks: tuple[str, str]) -> None:
    together = f"O0001\n{marks[0]}\n{_ONE}{marks[1]}\n{_TWO}$0\nM30\n"
    alone = [_new_blocks(f"{marks[0]}\n{one}$0\nM30\n") for one in (_ONE, _TWO)]
    assert _new_blocks(together) == [*alone[0], *alone[1]]
    assert all(alone)


def test_a_path_is_left_and_entered_again() -> None:
    """Position, modes, S, F, motion code and tool are those that the path was left with."""
    whole = _ONE + "G1 X40. F0.2\n" + "X20. Z-40. F0.05 N1.5\nG0 X50.\n"
    lines = whole.splitlines(keepends=True)
    for at in range(1, len(lines)):
        cut = "".join(lines[:at]) + "$2\nG98 G0 X0. Z0.\nS77 M4\n$1\n" + "".join(lines[at:])
        wanted = _new_blocks(f"$1\n{whole}$0\nM30\n")
        got = _new_blocks(f"$1\n{cut}$0\nM30\n")
        assert _moves_of(got) == _moves_of(wanted), at


def test_the_programmed_speed_is_back_where_a_path_is_left_or_waits() -> None:
    for leaves in ("$2", "!2L1", "M203 S500", "S500 P12", "M131", "M100 P12"):
        lines = _filtered(f"$1\n{_ONE}{leaves}\nG0 X1.\n$0\nM30\n").decode().splitlines()
        before = [line for line in lines[: lines.index(leaves)] if re.fullmatch(r"S\d+", line)]
        assert before[-1] == "S3000", leaves


def test_a_speed_that_must_come_back_and_is_not_known() -> None:
    program = "$1\nG99 G97 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5 f62.5\n$2\nG0 X1.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError, match="line 5 needs the spindle speed"):
        _filtered(program)


def test_a_directive_holds_for_its_path() -> None:
    one, two = (path.replace(" N1.5", "") for path in (_ONE, _TWO))
    one = one.replace("G0 X20.", "(VIB N1.5)\nG0 X20.")
    data = _filtered(f"$1\n{one}$2\n{two}$0\nM30\n")
    assert data.count(b"BEGIN VIB") == 1
    assert b"\nG1 Z-10. F0.1\n" in data


def test_an_arc_that_goes_on_in_its_own_path() -> None:
    arc = "$1\nG99\nG97 S3000 M3\nG0 X20. Z2.\nG3 X40. Z-8. R10. F0.05 N1.5\n"
    other = "$2\nG1 X1. F0.1\n$1\nX60. Z-18. R10.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError, match="line 9 goes on as an arc"):
        _filtered(arc + other)


@pytest.mark.parametrize("mark", ["$1", ":100", "<NAME>", "HEAD1"])
@pytest.mark.parametrize("profile", ["fanuc-lathe", "generic-lathe"])
def test_our_words_in_a_marked_block_are_solved_or_refused(mark: str, profile: str) -> None:
    head = f"{mark}\nG97 S3000 M3\nG99 G0 X20. Z2.\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        _filtered(f"{head}{mark} G1 Z-30. F0.05 N1.5\nM30\n", profile=profile)
    assert [d.code for d in caught.value.diagnostics] == ["VIB048"]
    solved = _filtered(f"{mark} G97 V120. D20. M3\nM30\n", profile=profile)
    assert f"\n{mark} G97 S1910 M3\n".encode() in solved
    behind = _filtered(f"{mark} (SPEED V120 D20)\nM30\n", profile=profile)
    assert behind.startswith(f"{mark} (SPEED V120 D20)\n".encode())
    assert b"\nS1910\n" in behind


def test_a_block_number_behind_a_mark_is_no_wish() -> None:
    program = f"$1\n{_ONE.replace(' N1.5', '')}$1 N10 G1 Z-3.\nM30\n"
    assert _filtered(program) == program.encode()


def test_a_mark_of_another_control_is_no_path() -> None:
    """``$0`` of LinuxCNC is the first spindle, which is followed."""
    program = "G21 G7 G18 G95\nS1000 M3 $0\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 X30.\nM2\n"
    plain = program.replace(" $0", "")
    assert _filtered(program, profile="linuxcnc-lathe").replace(b" $0", b"") == _filtered(
        plain, profile="linuxcnc-lathe"
    )


@pytest.mark.parametrize("words", ["G4 P1. S3000", "M19 P90", "M98 P200 S3000"])
def test_a_p_of_another_meaning_chooses_no_spindle(words: str) -> None:
    program = f"G99 G97 S3000 M3\n{words}\nM3 S3000\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    assert b"CHIPBREAK BEGIN VIB" in _filtered(program)


def test_no_check_stands_in_a_program_of_several_paths() -> None:
    head = "$1\nT1 M6\nS3000 M3\nG0 X0 Y0\nG43 H1 Z10.\nG1 Z-1. F100.\nG0 Z10.\n"
    settings = chipbreak.load("fanuc-mill", ["checks.enabled=true", *BEAM])
    result = chipbreak.rewrite((head + "$2\nT2 M6\nM30\n").encode(), settings)
    assert not result.changed
    assert "several paths ($1, line 1)" in " ".join(d.message for d in result.diagnostics)
    assert chipbreak.rewrite((head[3:] + "T2 M6\nM30\n").encode(), settings).changed


def test_a_path_without_a_spindle_may_turn_with_another_ones() -> None:
    guest = "$2\nG0 X10. Z5.\nG1 Z-10. F0.1\nG0 Z5.\n"
    settings = chipbreak.load("fanuc-lathe")

    def said(program: str, *sets: str) -> list[tuple[str, int]]:
        found = chipbreak.check(program.encode(), chipbreak.load("fanuc-lathe", sets) if sets else settings)
        return [(d.code, d.place.line if d.place else 0) for d in found if d.code == "VIB078"]

    program = f"$1\n{_ONE}{guest}$0\nM30\n"
    assert said(program) == [("VIB078", 6)]
    assert said(program, "vibration.correct='count'") == []
    assert said(program.replace("G0 X10.", "S900 M3\nG0 X10.")) == []
    assert said(f"$1\n{_ONE}$0\nM30\n") == []


@pytest.mark.parametrize("profile", ["fanuc-lathe", "generic-lathe"])
@pytest.mark.parametrize(
    ("head", "code", "waits"),
    [
        ("", "M100 P12", True),
        ("", "N5 M198 P123", False),  # a subprogram of another device
        ("", "M250 P13", True),
        ("$1\n", "M131", True),
        ("$1\n", "N7 M100", True),
        ("", "M131", False),  # a machine with one path has such codes of its builder too
        ("$1\n", "M131 B2", False),
        ("", "M100 P21", False),
        ("", "M3 P12", None),  # a choice of spindle
        ("", "M98 P12", False),
        ("$1\n", "M42", False),
    ],
)
def test_an_m_code_by_which_paths_wait_is_not_passed_over(
    profile: str, head: str, code: str, waits: bool | None
) -> None:
    """Behind it another path may have commanded the spindle; S and M3 of its own end the doubt."""
    lines = ["G99", "G97 S3000 M3", "G0 X20. Z2.", code, "G0 X20. Z2.", "G1 Z-30. F0.05 N1.5", "M30", ""]
    settings = chipbreak.load(profile)
    found = chipbreak.check((head + "\n".join(lines)).encode(), settings)
    errors = [one for one in found if one.severity.value == "error"]
    said = [one.message for one in errors if one.code == "VIB069"]
    assert bool(said) == (waits is not False)
    if waits:
        assert f"may wait for another path ({code.removeprefix('N5 ').removeprefix('N7 ')})" in said[0]
    started = "\n".join(lines).replace("G0 X20. Z2.\nG1", "S3000 M3\nG0 X20. Z2.\nG1")
    assert chipbreak.rewrite((head + started).encode(), settings).cuts
