"""What is read of a program for a comparison, item by item, and where each number leads."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.editing.diff import compare, differs
from chipbreak.editing.diff_items import Item, items_of
from chipbreak.editing.diff_targets import Labels, bare
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import KEPT
from chipbreak.editing.render import render
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

PROGRAM = b"""%
O0001 (PART)
N10
N20 G0 X1.

M98 P8 Q20
IF [#1 EQ 1] GOTO 0030
(ONLY A COMMENT)
/2 N30 G71 P40 Q50 R1
N40 X1. ( A )
N50 X2.
GOTO#1
M30
:8
N20 M99 P10
"""
# Line, text, numbers by which it is found, what its own numbers lead to (item), whether it computes one.
ITEMS = [
    (1, "%", (), [], False),
    (2, "O0001 (PART)", (), [], False),
    (4, "N20 G0 X1.", (10, 20), [], False),
    (6, "M98 P8 Q20", (), [("P8", 11), ("Q20", 12)], False),
    (7, "IF [#1 EQ 1] GOTO 0030", (), [("N30", 6)], False),
    (8, "(ONLY A COMMENT)", (), [], False),
    (9, "/2 N30 G71 P40 Q50 R1", (30,), [("P40", 7), ("Q50", 8)], False),
    (10, "N40 X1. ( A )", (40,), [], False),
    (11, "N50 X2.", (50,), [], False),
    (12, "GOTO#1", (), [], True),
    (13, "M30", (), [], False),
    (14, ":8", (), [], False),
    (15, "N20 M99 P10", (20,), [("P10", 2)], False),
]


def told(items: list[Item]) -> list[tuple[int, str, tuple[int, ...], list[tuple[str, int | None]], bool]]:
    return [
        (one.line, one.text, one.numbers, list(map(tuple, one.references)), one.computes) for one in items
    ]  # type: ignore[misc]


@pytest.mark.parametrize("profile", ["", "fanuc-lathe"])
def test_items_of_a_program(profile: str) -> None:
    assert told(items_of(PROGRAM, "x", chipbreak.load(profile) if profile else None)) == ITEMS


def test_a_note_says_where_each_number_leads() -> None:
    items = items_of(b"G71 P10 Q20 U.4\n\nN10 G0 X1.\nX2.\n", "x")
    assert items[0].with_note(items).note == "P10 is line 3, no Q20"
    assert items[1].with_note(items).note == ""


def test_items_of_a_change() -> None:
    """It is one item, found by every number in it; what comes behind it keeps its line."""
    settings = chipbreak.load("generic-lathe")
    data = b"N1\nG0 X1.\nN2 X2.\nGOTO 51\nGOTO 50\nM30\n"
    edit = Edit(1, 2, ("N50 G1 X2. F0.1", "N51 X3.", "X4."), "TEST", "a reason", KEPT, "test")
    out = b"".join(render(parse(read(data), settings.dialect), [edit], settings))
    assert out.count(b"\n") == 11
    assert told(items_of(out, "x")) == [
        (2, "[TEST: 3 blocks]", (1, 50, 51), [], False),
        (8, "N2 X2.", (2,), [], False),
        (9, "GOTO 51", (), [("N51", 0)], False),
        (10, "GOTO 50", (), [("N50", 0)], False),
        (11, "M30", (), [], False),
    ]
    # A change at the end is not in front of the first block.
    last = Edit(7, 7, ("S900",), "TEST", "a reason", KEPT, "test")
    out = b"".join(
        render(parse(read(b"N1\n" + data.replace(b"51", b"1")), settings.dialect), [last], settings)
    )
    assert told(items_of(out, "x"))[2] == (5, "GOTO 1", (), [("N1", 0)], False)


def test_lines_are_those_of_the_file_that_a_user_sees() -> None:
    """Brackets that stand in a file beside the program are no lines of it."""
    settings = chipbreak.load("generic-lathe", ["output.brackets=none"])
    data = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nG1 X30.\nN9 M30\n"
    result = chipbreak.rewrite(data, settings)
    lines = result.data.split(b"\n")
    seen = [(one.line, one.text) for one in items_of(result.data, "x", beside=result.beside)]
    assert [text for _, text in seen if text[0] != "["] == [
        "G97 S3000 M3",
        "G0 X20. Z2.",
        "G1 X30.",
        "N9 M30",
    ]
    for line, text in seen:
        assert text[0] == "[" or lines[line - 1].decode() == text
    assert seen[2][0] == 3 and seen[-1][0] == len(lines) - 1


def test_a_block_that_jumps_to_its_own_number_finds_the_next_one() -> None:
    assert told(items_of(b"N20 GOTO20\nN20 X2.\n", "x"))[0][3] == [("N20", 1)]
    assert told(items_of(b"X1.\nN20 GOTO20\nX2.\n", "x"))[1][3] == [("N20", 1)]


def labels() -> Labels:
    """Numbers 1 and 2 in front of any program, 1 twice in program 7, and 2 and 3 in program 8."""
    found = Labels()
    for number, line in ((1, 0), (2, 3)):
        found.add_number(number, line)
    found.add_program(7, 10)
    for number, line in ((1, 11), (1, 15)):
        found.add_number(number, line)
    found.add_program(8, 20)
    for number, line in ((2, 20), (3, 25)):
        found.add_number(number, line)
    return found


@pytest.mark.parametrize(
    ("number", "line", "at"),
    [
        # From the next line to the end of the program, then from its top.
        (1, 10, 11),
        (1, 11, 15),
        (1, 14, 15),
        (1, 15, 11),
        (1, 19, 11),
        (1, 9, 0),
        (2, 0, 3),
        (2, 3, 3),
        (2, 20, 20),
        (2, 24, 20),
        # Of another program only where this one has none.
        (1, 20, 0),
        (2, 10, 3),
        (3, 19, 25),
        (3, 20, 25),
        (4, 0, None),
    ],
)
def test_a_jump_finds_a_number_of_its_own_program(number: int, line: int, at: int | None) -> None:
    assert labels().jump(number, line) == at


@pytest.mark.parametrize(
    ("number", "line", "at"),
    [(1, 0, 11), (1, 10, 11), (1, 11, 15), (1, 15, 0), (3, 0, 25), (3, 25, 25), (9, 0, None)],
)
def test_a_cycle_finds_the_next_such_number(number: int, line: int, at: int | None) -> None:
    assert labels().contour(number, line) == at


@pytest.mark.parametrize(
    ("program", "number", "at"),
    [(7, 1, 11), (7, 2, None), (8, 2, 20), (8, 3, 25), (8, 1, None), (9, 1, None)],
)
def test_a_call_finds_a_number_of_that_program(program: int, number: int, at: int | None) -> None:
    assert labels().block_of(program, number) == at


def test_of_two_programs_of_one_number_the_first_is_called() -> None:
    found = labels()
    found.add_program(7, 30)
    assert found.program(7, 0) == 10
    assert found.program(9, 0) is None


@pytest.mark.parametrize(
    ("label", "said"), [("N0010", "10"), (" n5\t", "5"), ("0", "0"), ("000", "0"), ("", "0"), ("100", "100")]
)
def test_a_label_without_n_and_leading_zeros(label: str, said: str) -> None:
    assert bare(label) == said


INCREMENT = ('control.decimal_point="increment"',)
REQUIRED = ('control.decimal_point="required"',)


@pytest.mark.parametrize(
    ("profile", "sets", "a", "b", "is_same"),
    [
        # A lathe starts with feed per revolution, a mill with feed per minute, which takes whole numbers.
        ("fanuc-lathe", REQUIRED, "G1 X1. F200", "G1 X1. F200.", False),
        ("fanuc-mill", REQUIRED, "G1 X1. F200", "G1 X1. F200.", True),
        ("fanuc-mill", REQUIRED, "G95;G1 X1. F2", "G95;G1 X1. F2.", False),
        ("fanuc-mill", REQUIRED, "G95;G94;G1 X1. F200", "G95;G94;G1 X1. F200.", True),
        ("fanuc-mill", REQUIRED, "G95;G91;G1 X1. F2", "G95;G91;G1 X1. F2.", False),
        # That is about F alone.
        ("fanuc-mill", REQUIRED, "G1 X1. A5 F2.", "G1 X1. A5. F2.", False),
        ("fanuc-mill", REQUIRED, "G1 X5 F2.", "G1 X5. F2.", False),
        ("fanuc-mill", REQUIRED, "G2 X1. I5", "G2 X1. I5.", False),
        # Millimetres at power-on, and what G20 and G21 say from their block on.
        ("fanuc-lathe", INCREMENT, "X10000", "X10.", True),
        ("fanuc-lathe", INCREMENT, "X10000;G20", "X10.;G20", True),
        ("fanuc-lathe", INCREMENT, "G20;X10000", "X10.;G20", False),
        ("fanuc-lathe", INCREMENT, "G20;X10000", "G20;X1.", True),
        ("fanuc-lathe", INCREMENT, "G20;G21;X10000", "G20;G21;X10.", True),
        ("fanuc-lathe", INCREMENT, "G20;G0;X10000", "G20;G0;X1.", True),
        ("fanuc-lathe", INCREMENT, "G20;X12345", "G20;X1.2345", True),
        ("fanuc-lathe", INCREMENT, "G20;X12345", "G20;X1.2346", False),
        ("fanuc-lathe", INCREMENT, "X1", "X.001", True),
        # They are words of G alone, whatever else has the number 20 or 94.
        *(
            ("fanuc-lathe", INCREMENT, f"{word};X10000", f"{word};X10.", True)
            for word in ("M20", "X20.", "A20.")
        ),
        ("fanuc-mill", REQUIRED, "G95;S94;G1 X1. F2", "G95;S94;G1 X1. F2.", False),
        ("fanuc-lathe", REQUIRED, "M70 P10 Q20;N10 X1.;N20 X2.", "M70 P1 Q2;N1 X1.;N2 X2.", False),
        # What does not count as a dimension is read whole.
        ("fanuc-lathe", REQUIRED, "M3 S5", "M3 S5.", True),
        ("fanuc-lathe", REQUIRED, "G65 P1 T5", "G65 P1 T5.", True),
    ],
)
def test_how_numbers_without_a_point_are_read(
    profile: str, sets: tuple[str, ...], a: str, b: str, is_same: bool
) -> None:
    assert same(a, b, profile, sets) is is_same


def same(a: str, b: str, profile: str = "", sets: tuple[str, ...] = ()) -> bool:
    """Two programs whose lines are separated by ``;``, asked in both directions."""
    settings = chipbreak.load(profile, sets) if profile else None
    one, other = (items_of(text.replace(";", "\n").encode(), "x", settings) for text in (a, b))
    found = [not differs(compare(*sides)) for sides in ((one, other), (other, one))]
    assert found[0] == found[1]
    return found[0]


@pytest.mark.parametrize("letter", [*"XYZUVWABCIJKRQEFHD", ",A", ",C", ",R"])
def test_every_letter_of_a_dimension_needs_its_point(letter: str) -> None:
    assert not same(f"G1 {letter}5", f"G1 {letter}5.")
    assert same(f"G1 {letter}0", f"G1 {letter}0.")


@pytest.mark.parametrize("letter", [*"GLMOPST"])
def test_every_other_letter_does_not(letter: str) -> None:
    assert same(f"{letter}5", f"{letter}5.")


CONTOURS = ("G70", "G71", "G72", "G73")
NO_CONTOURS = ("G69", "G74", "G76", "G71 X5.", "G71 Y5.", "G71 Z5.")


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        # G4: P in milliseconds without a point; X and U are read as dimensions.
        ("G4 P5", "G4 P5.", False),
        ("G4 P5", "G4 P05", True),
        ("G4 P0", "G4 P0.", True),
        ("G4 P5", "G4 P6", False),
        ("G4 P5.", "G4 P6.", False),
        ("G4 X5", "G4 X5.", False),
        ("G4.1 P5", "G4.1 P5.", True),
        # The blocks of a shape are named where a cycle has P and Q and no coordinate.
        *((f"{code} P10 Q20;N10 X1.;N20 X2.", f"{code} P1 Q2;N1 X1.;N2 X2.", True) for code in CONTOURS),
        *((f"{code} P10 Q20;N10 X1.;N20 X2.", f"{code} P1 Q2;N1 X1.;N2 X2.", False) for code in NO_CONTOURS),
        ("G71 P10 Q20 U5.;N10 X1.;N20 X2.", "G71 P1 Q2 U5.;N1 X1.;N2 X2.", True),
        ("G71 P10;N10 X1.", "G71 P1;N1 X1.", False),
        ("G71 Q10;N10 X1.", "G71 Q1;N1 X1.", False),
        # Calls and jumps.
        ("M97 P10;M30;N10 X1.", "M97 P1;M30;N1 X1.", True),
        ("M96 P10;M30;N10 X1.", "M96 P1;M30;N1 X1.", False),
        ("M99 P10;N10 X1.", "M99 P1;N1 X1.", True),
        ("M98 H10;M30;N10 X1.", "M98 H1;M30;N1 X1.", True),
        ("M98 Q10;M30;N10 X1.", "M98 Q1;M30;N1 X1.", True),
        ("M99 Q10;M30;N10 X1.", "M99 Q1;M30;N1 X1.", False),
        ("M98 P8 H10;M30;O8;N10 X1.", "M98 P8 H1;M30;O8;N1 X1.", True),
        ("M98 P8 H10;N10 X1.;M30;O8;N10 X2.", "M98 P8 H1;N10 X1.;M30;O8;N1 X2.", True),
        # A number that the control works out may be any.
        ("M97 P#1;N10 X1.", "M97 P#1;N1 X1.", False),
        ("M98 P#1;N10 X1.", "M98 P#1;N1 X1.", True),
        ("M99 P#1;N10 X1.", "M99 P#1;N1 X1.", False),
        ("M96 P#1;N10 X1.", "M96 P#1;N1 X1.", True),
        ("M98 P8 Q#1;N10 X1.", "M98 P8 Q#1;N1 X1.", False),
        ("M98 H#1;N10 X1.", "M98 H#1;N1 X1.", False),
        ("M99 H#1;N10 X1.", "M99 H#1;N1 X1.", True),
        ("G71 P#1 Q10;N10 X1.", "G71 P#1 Q10;N1 X1.", False),
        ("G71 P5 Q#1;N5 X1.;N10 X2.", "G71 P5 Q#1;N5 X1.;N1 X2.", False),
        ("G76 P#1 Q#2;N10 X1.", "G76 P#1 Q#2;N1 X1.", True),
        # Block numbers of a list of data are data, from the block behind G10 to the one before G11.
        ("N1 G10 L50;N5 P1 R1.;N2 G11;N3 M30", "N7 G10 L50;N5 P1 R1.;N8 G11;N9 M30", True),
        ("N1 G10 L50;N5 P1 R1.;G11", "N1 G10 L50;N6 P1 R1.;G11", False),
        ("G10 L50;N5 P1 R1.;G11;GOTO5;N5 M30", "G10 L50;N5 P1 R1.;G11;GOTO6;N6 M30", True),
        ("G10 L49;N5 P1 R1.;G11", "G10 L49;N6 P1 R1.;G11", True),
        ("G11;N5 M30", "G11;N6 M30", True),
        # What is no block counts as its text, but for the spaces.
        ("? A  B", "? A B", True),
        ("? A B", "? AB", False),
        # An empty comment says nothing; of others each counts.
        ("()", "", True),
        ("M8 ()", "M8", True),
        ("M8 ( ) (B)", "M8 (B)", True),
        ("M8 (A) (B)", "M8 (A) (C)", False),
        ("M8 (A) (B)", "M8 ( A) (B )", True),
        ("/M8", "/1 M8", True),
        ("/2 M8", "/M8", False),
        # f is the vibration's, F the feed.
        ("X1. f50", "X1. F50", False),
        ("x1. F50", "X1. F50", True),
    ],
)  # fmt: skip
def test_what_a_block_says(a: str, b: str, is_same: bool) -> None:
    assert same(a, b) is is_same
