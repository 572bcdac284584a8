"""What each promise asks of the output, one promise at a time; stamps and messages; loops written out."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

import chipbreak
from chipbreak.dialects.base import Loop
from chipbreak.editing.edits import Edit
from chipbreak.editing.notes import Stamp, does_something, messages_edit, stamp_edit, stamp_of
from chipbreak.editing.promise import (
    KEPT,
    Promise,
    SpeedCommanded,
    SpeedGivenBack,
    SpindleRestarted,
    Written,
)
from chipbreak.editing.render import render
from chipbreak.editing.restore import regions
from chipbreak.editing.unroll import unrolled
from chipbreak.model.interpreted_program import interpret
from chipbreak.self_check import written_edits
from chipbreak.settings.fingerprint import fingerprint
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import Diagnostic, SelfCheckError, Severity
from chipbreak.text.source import read
from chipbreak.text.span import Place

SETTINGS = chipbreak.load("fanuc-mill")


def written(text: str, *edits: tuple[int, int, str], promise: Promise = KEPT) -> list[Written]:
    """Edits (first, last, content) of a program with ``;`` between its lines, as they stand in the output."""
    data = text.replace(";", "\n").encode() + b"\n"
    interpreted = interpret(parse(read(data), SETTINGS.dialect), SETTINGS)
    every = [
        Edit(first, last, tuple(filter(None, content.split(";"))), "TEST", "a reason", promise, "test")
        for first, last, content in edits
    ]
    output = b"".join(render(interpreted.program, every, SETTINGS))
    return list(written_edits(interpreted, output, every))


def said(text: str, content: str, promise: Promise, first: int, last: int | None = None) -> str:
    """What the check of a promise says; nothing where it holds."""
    (one,) = written(text, (first, first if last is None else last, content), promise=promise)
    try:
        assert one.edit.promise.check(one) is None
    except SelfCheckError as error:
        return str(error)
    return ""


# --- what stands for an edit ------------------------------------------------------------------------------

PROGRAM = "G21 G90 G94;M3 S1000;G0 X1. Y0.;Z2.;G1 Z-1. F100.;X5.;G0 Z5.;M30;G1 X9."


def test_an_edit_and_what_stands_for_it() -> None:
    first, second = written(PROGRAM, (2, 3, "G0 X2. Y0.;M8;G0 X1."), (6, 6, "S900;M9"))
    assert (first.stop, second.stop) == (6, 9)
    assert (first.was_behind.position[0], first.now_behind.position[0]) == (1.0, 1.0)
    assert (second.was_behind.speed, second.now_behind.speed) == (
        first.was_behind.speed,
        second.result.before(second.region.last).speed,
    )
    assert first.line_in_result(3) == first.region.last == 8
    assert first.line_in_result(5) == 10
    cut = first.first_cut_behind()
    assert cut is not None and cut.block.line == 4
    assert [one.block.line for one in first.blocks_behind()] == [3, 4, 5]
    # Another edit or the end of the program comes first; what stands behind it is another one.
    assert second.first_cut_behind() is None
    assert [one.block.line for one in second.blocks_behind()] == [6]
    (before,) = written(PROGRAM, (1, 1, "M8"))
    assert [one.block.line for one in before.blocks_behind()] == [1, 2, 3, 4, 5, 6]


def test_what_a_promise_leaves_open_is_nothing_unless_it_is_said() -> None:
    names = ("leaves_motion", "leaves_speed", "leaves_spindle", "leaves_coolant", "leaves_feed")
    assert [getattr(KEPT, name) for name in names] == [False] * 5
    for promise in (SpeedCommanded(speed_rpm=1.0), SpeedGivenBack(), SpindleRestarted()):
        assert [getattr(promise, name) for name in names] == [False, True, False, False, False]
    assert KEPT.check(written(PROGRAM, (2, 2, "S900"))[0]) is None


# --- promises ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "rpm", "message"),
    [
        ("S900", 900.0, ""),
        ("S900", 901.0, "the spindle needs 901 rpm behind line 3, S900 is commanded"),
        ("M8", 1000.0, ""),
        ("M8", 900.0, "the spindle needs 900 rpm behind line 3, S1000 is commanded"),
        ("S#1", 900.0, ""),  # nobody knows
        ("S900;S950", 950.0, ""),
    ],
)
def test_a_speed_that_is_commanded(content: str, rpm: float, message: str) -> None:
    assert said(PROGRAM, content, SpeedCommanded(speed_rpm=rpm), 2) == message


def test_a_surface_speed_is_no_spindle_speed() -> None:
    settings = chipbreak.load("fanuc-lathe")
    data = b"G97 S100 M3\nG0 X50. Z2.\nG0 Z3.\nM30\n"
    interpreted = interpret(parse(read(data), settings.dialect), settings)
    edit = Edit(2, 2, ("G96 S100",), "TEST", "a reason", SpeedCommanded(speed_rpm=100.0), "test")
    output = b"".join(render(interpreted.program, [edit], settings))
    (one,) = written_edits(interpreted, output, [edit])
    with pytest.raises(SelfCheckError, match="the spindle needs 100 rpm behind line 3, S100 is commanded"):
        edit.promise.check(one)


@pytest.mark.parametrize(
    ("content", "last", "message"),
    [
        ("S900;S1000", 2, ""),
        ("S900", 2, "before line 3 the spindle speed is not the programmed one"),
        ("G0 X1. Y0.;S900", 4, "before line 5 the spindle speed is not the programmed one"),
    ],
)
def test_a_speed_that_is_given_back(content: str, last: int, message: str) -> None:
    assert said(PROGRAM, content, SpeedGivenBack(), 2, last) == message


SPEED = "behind the insertion at line 3 a cut begins at another speed"


@pytest.mark.parametrize(
    ("text", "content", "message"),
    [
        (PROGRAM, "S900", SPEED),
        (PROGRAM, "S900;S1000", ""),
        # The program says its own before it cuts, or never cuts.
        ("G21;M3 S1000;G0 X1.;S800;G1 X5. F100.;M30", "S900", ""),
        ("G21;M3 S1000;G0 X1.;G1 X5. F100. S800;M30", "S900", ""),
        ("G21;M3 S1000;G0 X1.;G1 X5. F100.;S800;M30", "S900", SPEED),
        ("G21;M3 S1000;G0 X1.;X5.;M30", "S900", ""),
        ("G21;M3 S1000;G0 X1.;M30;G1 X5.", "S900", ""),
        ("G21;M3 S1000;G0 X1.;G2 X5. R9. F9.;M30", "S900", SPEED),
    ],
)
def test_a_spindle_that_is_started_again_has_its_speed_before_the_next_cut(
    text: str, content: str, message: str
) -> None:
    assert said(text, content, SpindleRestarted(), 2) == message


FEED = "behind the insertion at line 3 a cut begins with another F"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G21;F50.;G0 X1.;G1 X5. F100.;M30", ""),
        ("G21;F50.;G0 X1.;G1 X5.;M30", FEED),
        ("G21;F50.;G0 X1.;/G1 X5. F100.;M30", FEED),
        ("G21;F50.;G0 X1. F80.;G1 X5.;M30", ""),
        ("G21;F50.;G0 X1.;X2.;M30", ""),
        ("G21;F50.;G0 X1.;G3 X2. R5.;M30", FEED),
        ("G21;F50.;G0 X1.;M30;G1 X5.", ""),
    ],
)
def test_where_another_feed_is_left_the_next_cut_says_its_own(text: str, message: str) -> None:
    assert said(text, "F7.", SpindleRestarted(leaves_feed=True), 2) == message
    assert said(text, "M8", SpindleRestarted(), 2) == ""


@pytest.mark.parametrize(("group", "word", "other"), [("spindle", "M3", "M8"), ("coolant", "M8", "M3")])
@pytest.mark.parametrize(
    ("between", "is_back"),
    [
        ("{word}", True),
        ("G4 P100;{word}", True),
        ("{other};{word}", True),
        ("X2. {word}", True),
        ("X2.;{word}", False),
        ("G1 X2. F9.;{word}", False),
        ("G28 Z0.;{word}", True),
        ("G53 Z0.;{word}", True),
        ("M0;{word}", False),
        ("M98 P5;{word}", False),
        ("IF[#1EQ0]GOTO5;{word}", False),
        ("", True),
    ],
)
def test_where_spindle_or_coolant_stand_the_program_commands_them_before_it_moves(
    group: str, word: str, other: str, between: str, is_back: bool
) -> None:
    text = ";".join(filter(None, ["G21", "M3 S1000", between.format(word=word, other=other), "M30"]))
    promise = SpindleRestarted(leaves_spindle=group == "spindle", leaves_coolant=group == "coolant")
    wanted = "" if is_back else f"behind the insertion at line 3 the {group} is not given back"
    assert said(text, "G4 P100", promise, 2) == wanted
    assert said(text, "G4 P100", SpindleRestarted(), 2) == ""


# --- stamps and messages ----------------------------------------------------------------------------------


def program_of(text: str, profile: str) -> tuple[chipbreak.syntax.parse.Program, chipbreak.Settings]:
    settings = chipbreak.load(profile)
    return parse(read(text.replace(";", "\n").encode()), settings.dialect), settings


def test_a_stamp_as_it_is_written_and_read() -> None:
    program, settings = program_of("%;O0001 (X);(T);G0 X1.;M30;%;", "fanuc-lathe")
    edit = stamp_edit(program, settings)
    assert (edit.first, edit.last, edit.content, edit.reason, edit.pass_name) == (
        3,
        3,
        (),
        "the profile stamps what it filters",
        "chipbreak",
    )
    assert re.fullmatch(rf"STAMP [0-9][^+ ]* fanuc-lathe {fingerprint(settings)}", edit.title)
    named = replace(settings, name="some\\folder/my lathe.toml")
    assert " my lathe " in stamp_edit(program, named).title
    data = b"".join(render(program, [edit], settings))
    stamp = stamp_of(data)
    assert stamp is not None and (stamp.profile, stamp.fingerprint) == ("FANUC-LATHE", fingerprint(settings))
    assert stamp_of(b"(CHIPBREAK BEGIN STAMP 0.1.0 MY LATHE 01AB23CD)") == Stamp(
        "0.1.0", "MY LATHE", "01AB23CD"
    )
    assert stamp_of(b"(CHIPBREAK BEGIN STAMP 0.1.0 MY LATHE 01AB23C)") is None


WARNINGS = [
    Diagnostic("VIB001", Severity.WARNING, "a 50% 'word' and  more (x)", "", Place("a", 7, 1, 2)),
    Diagnostic("VIB002", Severity.ERROR, "no warning"),
    Diagnostic("VIB003", Severity.WARNING, "ends with a blank here " * 20),
]


@pytest.mark.parametrize(
    ("profile", "first", "width"),
    [
        ("fanuc-lathe", "(CHIPBREAK LINE 7, VIB001 A 50 PERCENT WORD AND MORE X)", 80),
        ("linuxcnc-lathe", "(MSG, chipbreak line 7, VIB001 a 50 percent word and more x)", 255),
    ],
)
def test_messages_as_they_are_written(profile: str, first: str, width: int) -> None:
    program, settings = program_of("%;O0001 (X);(T);G0 X1.;M30;%;", profile)
    edit = messages_edit(program, settings, WARNINGS)
    assert edit is not None
    assert (edit.first, edit.last, edit.title, edit.reason, edit.pass_name) == (
        3,
        3,
        "MESSAGES",
        "asked for",
        "chipbreak",
    )
    one, other = map(str, edit.content)
    assert one == first
    # As long as a line may be, but for a blank at the end.
    assert width - 1 <= len(other) <= width and not other.endswith(" )")
    assert messages_edit(program, settings, WARNINGS[1:2]) is None
    for nothing in ("%;O0001;(T);", "%;O0001;%;M30;"):
        empty, _ = program_of(nothing, profile)
        assert messages_edit(empty, settings, WARNINGS) is None


@pytest.mark.parametrize(
    ("line", "does"),
    [
        ("", False),
        ("(A)", False),
        ("O0001", False),
        ("O1 X1.", True),
        ("M8", True),
        ("N5", False),
        ("#1=2", True),
        ("?", True),
        (":5", False),
    ],
)
def test_which_lines_do_something(line: str, does: bool) -> None:
    program, _ = program_of(f"{line};", "fanuc-lathe")
    assert does_something(program, 0) is does


# --- loops ------------------------------------------------------------------------------------------------

LOOP = Loop(
    ("#{variable}=0", "WHILE[#{variable}LT{passes}]DO{label}"),
    ("#{variable}=#{variable}+1", "END{label}"),
    range(1, 4),
    reuses=True,
)


def looped(passes: int, body: str, label: int = 1, variable: int = 100) -> str:
    head = f"#{variable}=0;WHILE[#{variable}LT{passes}]DO{label};"
    return f"{head}{body};#{variable}=#{variable}+1;END{label};"


def test_loops_in_changes_are_written_out() -> None:
    program, settings = program_of("M3;M5;M30;", "fanuc-lathe")
    contents = (looped(2, "X1.;X2.") + "X9.", "M8", "X0.;" + looped(3, "Z1.") + looped(1, "Z2.", 2))
    edits = [
        Edit(at, at, tuple(filter(None, content.split(";"))), "TEST", "a reason", KEPT, "test")
        for at, content in enumerate(contents)
    ]
    source = read(b"".join(render(program, edits, settings)), "part.nc")
    found = regions(source)
    out, moved = unrolled(source, found, LOOP)
    lines = out.data.decode().split("\n")
    bodies = [lines[one.body : one.last - 1] for one in moved]
    assert bodies == [["X1.", "X2.", "X1.", "X2.", "X9."], ["M8"], ["X0.", "Z1.", "Z1.", "Z1.", "Z2."]]
    assert [lines[one.first][:16] for one in moved] == ["(CHIPBREAK BEGIN"] * 3
    assert [lines[one.last - 1][:14] for one in moved] == ["(CHIPBREAK END"] * 3
    assert [(one.title, one.original) for one in moved] == [(one.title, one.original) for one in found]
    assert [line for line in lines if line in ("M3", "M5", "M30")] == ["M3", "M5", "M30"]
    assert out.name == "part.nc"
    for nothing in (None, LOOP._replace(begin=("REPEAT {passes}",))):
        same, where = unrolled(source, found, nothing)
        assert same is source and where == found
    # Outside of a change, with two labels, or a count that is none, it is no loop of ours.
    for body in (
        looped(2, "X1.").replace("END1", "END2"),
        looped(2, "X1.").replace("LT2", "LT#5"),
        looped(2, "X1.").replace("#100+1", "#101+1"),
    ):
        other = Edit(0, 0, tuple(filter(None, body.split(";"))), "TEST", "a reason", KEPT, "test")
        data = read(b"".join(render(program, [other], settings)))
        assert unrolled(data, regions(data), LOOP)[0].data == data.data
