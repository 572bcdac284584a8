"""What is said of lines: of comments, of what cannot be read, of grammars; where, and with which way out."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from chipbreak.dialects import find
from chipbreak.syntax.comments import leaves_blocks_open, said_of_comments
from chipbreak.syntax.grammar import Grammar, grammar_dir, grammar_of
from chipbreak.syntax.nodes import Block, Call, Control, Number, Operation, Variable, Word
from chipbreak.syntax.numbers import print_number
from chipbreak.syntax.parse import LONGEST_LINE, Program, emit, parse, parse_changed, read_block
from chipbreak.syntax.shapes import MOTION_CODE, NO_POINT, Shape, bits_of
from chipbreak.syntax.variables import variables_of
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError
from chipbreak.text.source import read

FANUC = chipbreak.load("fanuc-lathe").dialect
LINUXCNC = chipbreak.load("linuxcnc-lathe").dialect


def program_of(text: str, dialect: chipbreak.dialects.Dialect = FANUC) -> Program:
    return parse(read(text.encode("latin-1"), "part.nc"), dialect)


# --- comments ---------------------------------------------------------------------------------------------

OPEN = "this comment is not closed: the control stops here, or reads on to the next ) as comment"
CLOSED_BY = f"{OPEN}; the comments of a change behind it would close it"


def told(one: Diagnostic) -> tuple[str, str, int, int, int, str]:
    assert one.place is not None and one.place.file == "part.nc"
    return one.code, one.severity.value, one.place.line, one.place.column, one.place.end_column, one.message


def said(
    text: str, *changes: tuple[int, int], profile: str = "fanuc-lathe"
) -> list[tuple[str, str, int, int, int, str]]:
    program = program_of(text, chipbreak.load(profile).dialect)
    found = said_of_comments(program, changes)
    for one in found:
        is_open = one.code == "SYN003"
        assert one.help == ("close it with ) on its line" if is_open else "take the inner parentheses out")
        line = program.source.text(one.place.line - 1 if one.place else 0)
        assert one.instead == ((f"{line[one.place.column - 1 :]})",) if is_open and one.place else ())
    return [told(one) for one in found]


@pytest.mark.parametrize(
    ("text", "changes", "severity"),
    [
        # Blocks between it and the next ) may be comment: an error where a change is in its line or behind.
        ("M8 (A\nX1.\n(B)\n", [], "warning"),
        ("M8 (A\nX1.\n(B)\n", [(0, 1)], "error"),
        ("X9.\nM8 (A\nX1.\n(B)\n", [(0, 1)], "warning"),
        ("X9.\nM8 (A\nX1.\n(B)\n", [(0, 2)], "error"),
        ("M8 (A\nX1.\n(B)\n", [(2, 3)], "error"),
        # Nothing but comments are: then only a change between them would close it.
        ("M8 (A\n\n(B)\nX1.\n", [(0, 1)], "warning"),
        ("M8 (A\n\n(B)\nX1.\n", [(1, 1)], "error"),
        ("M8 (A\n\n(B)\nX1.\n", [(2, 2)], "error"),
        ("M8 (A\n\n(B)\nX1.\n", [(3, 4)], "warning"),
        ("M8 (A\n\n(B)\nX1.\n", [(3, 4), (1, 2)], "error"),
        # None closes it.
        ("M8 (A\n\n", [(1, 1)], "error"),
        ("M8 (A\nN5\n(B)\n", [(3, 3)], "error"),
    ],
)
def test_a_comment_that_is_not_closed(text: str, changes: list[tuple[int, int]], severity: str) -> None:
    line = text[: text.index("(A")].count("\n")
    message = OPEN if severity == "warning" else CLOSED_BY
    assert said(text, *changes)[0] == ("SYN003", severity, line + 1, 4, 6, message)
    program = program_of(text)
    ends = text.split("(A\n")[1].split("\n")
    harmless = ends[0] == "" and ")" in "".join(ends)
    assert leaves_blocks_open(program, line) is not harmless
    assert not leaves_blocks_open(program_of("M8 (A)\nX1.\n"), 0)


def test_every_comment_that_is_not_closed_is_told() -> None:
    found = said("X1. (A\nX2. ; (B\nX3. (C) (D\nX& (E\nX& (F) ; (G\n")
    assert [one[2:5] for one in found] == [(1, 5, 7), (3, 9, 11), (4, 4, 6)]


STOPS = "this control stops on a comment inside a comment"
ACTS = "the comment ends at its first ), and the control acts on {} behind it"


@pytest.mark.parametrize(
    ("text", "profile", "found"),
    [
        ("X1. (A (B))\n", "linuxcnc-lathe", (1, 5, 12, STOPS)),
        ("X1. (A (B)\n", "linuxcnc-lathe", (1, 5, 11, STOPS)),
        ("X1. (A (B)\nX1. (A (B)\nX1. (C(D)\n", "linuxcnc-lathe", (1, 5, 11, f"{STOPS}; 2 more like it")),
        ("X1. (A (B)\n", "fanuc-lathe", None),
        ("X1. (A (B) ; X2.\n", "fanuc-lathe", None),
        ("X1. (A (B) (C)\n", "fanuc-lathe", None),
        # The first one is harmless, the second is not.
        ("X1. (A (B) (C(D) X2.\n", "fanuc-lathe", (1, 12, 17, ACTS.format("X2."))),
        ("X1. (A (B)  X50. F0.3\n", "fanuc-lathe", (1, 5, 11, ACTS.format("X50. F0.3"))),
        (
            "X1. (A(B)X1. Y2. Z3. U4. V5. W6. A7. B8.\n",
            "fanuc-lathe",
            (1, 5, 10, ACTS.format("X1. Y2. Z3. U4. V5. W6. A7. B8."[:30])),
        ),
        ("X1. ; (A (B) X2.\n", "fanuc-lathe", None),
    ],
)
def test_a_comment_inside_a_comment(text: str, profile: str, found: tuple[int, int, int, str] | None) -> None:
    assert said(text, profile=profile) == ([("SYN004", "warning", *found)] if found else [])


# --- what cannot be read ----------------------------------------------------------------------------------

ENDS = "it ends in the middle of a word or an expression"
NESTED = "')' is not expected here, where the comment has ended at its first ')'"


@pytest.mark.parametrize(
    ("text", "why", "column"),
    [
        ("G1 X", ENDS, 3),
        ("G1 X[1+  \t", ENDS, 6),
        ("IF[#1EQ0]GOTO", ENDS, 12),
        ("G1 X&1.", "'&' is not expected here", 4),
        ("  & ", "'&' is not expected here", 2),
        ("/2  N5X&", "'&' is not expected here", 7),
        ("G1 X1..", "'.' is not expected here", 6),
        ("G1 X1. \x07", "byte 0x07 is not expected here", 7),
        ("X1. \x8f", "byte 0x8F is not expected here", 4),
        ("X1. \xe4\xb8\xadX", "'\xe4\xb8\xad' is not expected here", 4),
        ("X1. \xe9" + "\x80" * 40, "'\xe9" + "\x80" * 29 + "' is not expected here", 4),
        ("(A (B) C) X", NESTED, 8),
        ("G1 (A(B) C) D&", NESTED, 10),
        ("(A) & (B (C)", "'&' is not expected here", 4),
        ("#123456789012345678901=1", "a variable number has too many digits", 0),
        ("X[1 NOR 2]", "'N' is not expected here", 4),
    ],
)
def test_why_a_line_cannot_be_read(text: str, why: str, column: int) -> None:
    block = read_block(3, text, FANUC)
    assert (block.opaque, block.opaque_column, block.line, block.text) == (why, column, 3, text)
    program = program_of(f"X1.\n{text}\n")
    (one,) = program.unreadable()
    place = ("SYN001", "warning", 2, column + 1, column + 2)
    message = f"this line cannot be read ({why}); it is passed through as it is"
    assert told(one) == (*place, program.source.meant(message))
    inner = "take the inner parentheses out; " if why == NESTED else ""
    assert one.help == f"{inner}nothing is changed here; vibration and checks refuse to cross it"


@pytest.mark.parametrize(("more", "is_read"), [(0, True), (1, False)])
def test_lines_up_to_a_length_are_read(more: int, is_read: bool) -> None:
    text = "(" + "A" * (LONGEST_LINE + more - 2) + ")"
    block = read_block(0, text, FANUC)
    assert (block.opaque == "") is is_read
    if not is_read:
        assert (block.opaque, block.opaque_column) == ("it is longer than 65536 characters", LONGEST_LINE)
    blanks = read_block(0, " " * (LONGEST_LINE + 5) + "M8", FANUC)
    assert blanks.number("M") == 8.0


@pytest.mark.parametrize(
    ("text", "at"),
    [("X1. Z2.", (1, 8)), ("  X1.  ", (3, 6)), ("   ", (1, 2)), ("", (1, 2)), ("\tM8", (2, 4))],
)
def test_a_finding_of_a_line_points_at_its_words(text: str, at: tuple[int, int]) -> None:
    program = program_of(f"M3\n{text}\n")
    one = program.diagnose(1, "XXX001", "message", "help")
    assert one.place is not None and (one.place.line, one.place.column, one.place.end_column) == (2, *at)
    assert (one.code, one.message, one.help, one.severity.value, one.line_text) == (
        "XXX001",
        "message",
        "help",
        "error",
        text,
    )
    there = program.diagnose(1, "XXX001", "message", at=(1, 2))
    assert there.place is not None and (there.place.column, there.place.end_column) == (2, 3)


# --- programs ---------------------------------------------------------------------------------------------


def test_a_program_of_lines() -> None:
    program = program_of("%\nO1\nN5 X1.\nX2. Z3\nM8\nM8\nG1 X4.\n%\nX5.\n")
    assert program.plain.tolist()[:2] == [-1, -1] and (program.plain[[2, 3, 6]] >= 0).all()
    assert program.special_lines.tolist() == [0, 1, 4, 5, 7]
    assert [block.line for block in program.event_blocks()] == [0, 1, 4, 5, 7]
    assert program.lines_with_numbers() == [0, 1, 2, 4, 5, 7]
    assert program.bits.tolist() == [
        0,
        0,
        bits_of("X"),
        bits_of("XZ") | NO_POINT,
        0,
        0,
        bits_of("X") | MOTION_CODE,
        0,
        bits_of("X"),
    ]
    assert emit(program) == program.source.data
    assert program.block(5) == program.block(4)._replace(line=5)
    assert program.block(2).number("X") == 1.0 and program.block(2).sequence is not None


def test_what_a_program_keeps_of_another() -> None:
    old = program_of("X1.\nM8\nX2.\nN5 Z3.\n")
    source = read(b"M9\nX1.\nM8\nG1 Y1.\nN5 Z3.\nM30\n", "part.nc")
    new = parse_changed(source, old, [(1, 3, 0), (4, 5, 3)])
    fresh = parse(source, FANUC)
    assert [new.shapes[at] if at >= 0 else None for at in new.plain] == [
        fresh.shapes[at] if at >= 0 else None for at in fresh.plain
    ]
    assert new.special_lines.tolist() == [0, 2, 5] and new.bits.tolist() == fresh.bits.tolist()


def test_shapes_and_their_bits() -> None:
    assert [bits_of(letter) for letter in "XYZUVWABCIJKRF"] == [1 << bit for bit in range(14)]
    assert Shape("XF", 1, has_points=True, numbered=False).bits == bits_of("XF") | MOTION_CODE
    assert Shape("Z", None, has_points=False, numbered=True).bits == bits_of("Z") | NO_POINT
    shapes = [
        program_of(f"{line}\n").shapes
        for line in ("G2X1.Y2", "N5X1.", "G03 Z-.5", "X1.X2.", "G4 X1.", "G01.5X1.", "G100X1.")
    ]
    assert shapes[:3] == [
        [Shape("XY", 2, False, False)],
        [Shape("X", None, True, True)],
        [Shape("Z", 3, True, False)],
    ]
    assert shapes[3:] == [[], [], [], []]


# --- blocks and expressions -------------------------------------------------------------------------------


def block_of(text: str, dialect: chipbreak.dialects.Dialect = FANUC) -> Block:
    block = read_block(0, text, dialect)
    assert not block.opaque, block.opaque
    return block


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("#1=1+2*3", Operation("+", Number(1.0), Operation("*", Number(2.0), Number(3.0)))),
        ("#1=[1+2]*3", Operation("*", Operation("+", Number(1.0), Number(2.0)), Number(3.0))),
        ("#1=1-2-3", Operation("-", Operation("-", Number(1.0), Number(2.0)), Number(3.0))),
        ("#1=8/4*2", Operation("*", Operation("/", Number(8.0), Number(4.0)), Number(2.0))),
        ("#1=-#2", Operation("-", Number(0.0), Variable(2))),
        ("#1=+5.", Number(5.0)),
        ("#1=sin[#2]", Call("SIN", (Variable(2),))),
        ("#1=ATAN[1]/[2]", Operation("/", Call("ATAN", (Number(1.0),)), Number(2.0))),
        ("#1=#[#2+1]", Variable(Operation("+", Variable(2), Number(1.0)))),
    ],
)
def test_expressions(text: str, value: object) -> None:
    (assignment,) = block_of(text).assignments
    assert (assignment.target, assignment.value) == (Variable(1), value)
    assert (assignment.start, assignment.end) == (0, len(text))


def test_named_variables_of_linuxcnc() -> None:
    (assignment,) = block_of("#<_My Name>=#<other\t1>", LINUXCNC).assignments
    assert (assignment.target, assignment.value) == (Variable("_myname"), Variable("other1"))


def test_what_stands_in_a_block() -> None:
    block = block_of("/3 N10 G1 X-.5 x#1 (A) ;B")
    assert (block.skip, block.sequence, block.is_empty) == (3, Word("N", "10", 10.0, None, 3, 6), False)
    assert [(word.letter, word.value_text, word.number, word.start, word.end) for word in block.words] == [
        ("G", "1", 1.0, 7, 9),
        ("X", "-.5", -0.5, 10, 14),
        ("x", "#1", None, 15, 18),
    ]
    assert [tuple(one) for one in block.comments] == [("A", 19, 22), ("B", 23, 25)]
    assert block.words[2].address == "X" and block.words[1].has_point and not block.words[0].has_point
    assert [block.text_of(word) for word in block.words] == ["G1", "X-.5", "x#1"]
    # The last word of a letter counts; of an expression there is no number.
    assert block.word("X") == block.words[2] and block.number("X") is None and block.number("Y") is None
    assert block.numbers("X") == (-0.5,) and block.numbers("G") == (1.0,)
    assert block.words_of("XG") == block.words and block.words_of("x") == ()
    assert (
        block.has("X"),
        block.has("X", 1.0),
        block.has("X", -0.5),
        block.has("Y"),
        block.has("G", 0, 1),
    ) == (True, False, True, False, True)
    assert (block.has_any("YX"), block.has_any("Y"), block.has_letter("x"), block.has_letter("g")) == (
        True,
        False,
        True,
        False,
    )
    assert block.has_macro and not block_of("G1 X1.").has_macro and block_of("#1=2").has_macro
    assert block_of("GOTO 5").has_macro and not block_of(":100").has_macro


def test_marks_are_no_statements() -> None:
    block = block_of(":100")
    assert [one.keyword for one in block.marks] == ["PROGRAM-NUMBER"] and block.statements == ()
    jump = block_of("IF[#1EQ2]GOTO 30")
    assert [(one.keyword, one.label, one.start, one.end) for one in jump.statements] == [
        ("IF", "", 0, 9),
        ("GOTO", "30", 9, 16),
    ]
    assert jump.statements[0].arguments == (Operation("EQ", Variable(1), Number(2.0)),)
    assert jump.marks == ()
    assert Block(0, "").is_empty and not Block(0, "", controls=(Control("DO", "1", (), 0, 3),)).is_empty
    assert not Block(0, "", opaque="why").is_empty


@pytest.mark.parametrize(
    ("text", "skip"),
    [("/X1.", 1), ("/1 X1.", 1), ("/9X1.", 9), ("X1.", 0), ("N5/2 X1.", 2), ("n5/X1.", 1)],
)
def test_block_delete(text: str, skip: int) -> None:
    assert block_of(text).skip == skip
    numbered = block_of(text).sequence
    assert (numbered is not None) is text.lower().startswith("n")
    assert numbered is None or numbered.number == 5.0


def test_variables_of_a_block() -> None:
    assert list(variables_of(block_of("X#1 Z[#2+SIN[#3]]"))) == [1, 2, 3] or set(
        variables_of(block_of("X#1 Z[#2+SIN[#3]]"))
    ) == {1, 2, 3}
    assert set(variables_of(block_of("#5=#[#6*2]"))) == {5, None, 6}
    assert set(variables_of(block_of("IF[#7GT#8]GOTO 5"))) == {7, 8}
    assert set(variables_of(block_of("#<Abc>=#<_x>", LINUXCNC))) == {"abc", "_x"}
    assert list(variables_of(block_of("X1."))) == []


@pytest.mark.parametrize(
    ("value", "decimals", "point", "text"),
    [
        (20.0, 3, True, "20."),
        (-0.50004, 3, True, "-0.5"),
        (-0.0001, 3, True, "0."),
        (0.0, 0, True, "0."),
        (100.0, 0, True, "100."),
        (1200.0, 1, True, "1200."),
        (2500.0, 0, False, "2500"),
        (2586.2, 1, False, "2586.2"),
        (-0.04, 1, False, "0"),
        (10.0, 2, False, "10"),
        (0.125, 2, True, "0.12"),
        (1e-9, 9, True, "0.000000001"),
    ],
)
def test_how_numbers_are_printed(value: float, decimals: int, point: bool, text: str) -> None:
    assert print_number(value, decimals, point=point) == text
    with pytest.raises(ValueError, match=r"^nan cannot be written in a program$"):
        print_number(float("nan"), decimals)


# --- grammars ---------------------------------------------------------------------------------------------


def unusable(text: str, folder: Path, attribute: str = "terminals") -> str:
    (folder / "own.lark").write_text(text)
    grammar = Grammar(folder / "own.lark", (folder, grammar_dir()))
    with pytest.raises(ProgramRejectedError) as caught:
        getattr(grammar, attribute)
    (one,) = caught.value.diagnostics
    assert (one.code, one.help) == (
        "SYN002",
        "this is a fault of the package that brings the control, not of the program",
    )
    return one.message


def test_what_is_said_of_a_grammar_that_cannot_be_used(tmp_path: Path) -> None:
    says = "the grammar own.lark of this control cannot be used: "
    assert (
        unusable("LETTER: /[A-Z]/\n", tmp_path)
        == f"{says}it has no terminal NUMBER, BLANK on a line of its own"
    )
    assert unusable("%import .nowhere (X)\n", tmp_path) == f"{says}there is no grammar file nowhere.lark"
    assert unusable("NUMBER: /[0-9/\n", tmp_path).startswith(f"{says}unterminated character set")
    message = unusable("LETTER: /[A-Z]/\nNUMBER: /[0-9]+/\nBLANK: / +/\nblock: nothing\n", tmp_path, "parser")
    assert message.startswith(says) and "\n" not in message and "nothing" in message
    # Of what the parser says of it the first line: the others show the grammar.
    start = "LETTER: /[A-Z]/\nNUMBER: /[0-9]+/\nBLANK: / +/\n"
    assert (
        unusable(f"{start}block: ???\n", tmp_path, "parser") == f"{says}Expecting a value, at line 4 column 8"
    )


def test_what_the_fast_road_takes_from_a_grammar(tmp_path: Path) -> None:
    fanuc = grammar_of(find("fanuc-mill", "A"))
    assert fanuc.reads_letter("X") and not fanuc.reads_letter("%")
    assert fanuc.separators == "" and fanuc.head.match(" /2 X1.") is not None
    own = "LETTER: /[A-Z]/\nNUMBER: /[0-9]+/\nBLANK: / +/\nSEPARATOR: /[=\xff]/\n"
    (tmp_path / "own.lark").write_text(own.replace("\xff", "\\xff"))
    grammar = Grammar(tmp_path / "own.lark", (tmp_path,))
    assert grammar.separators == "=\xff"
    assert not grammar.head.match("/X1") and set(grammar.terminals) == {
        "LETTER",
        "NUMBER",
        "BLANK",
        "SEPARATOR",
    }


@pytest.mark.parametrize(
    ("text", "statements"),
    [
        ("IF[#1EQ1]THEN#2=3", [("IF", "", 1, 0, 9), ("THEN", "", 0, 9, 13)]),
        ("if [#1 LT 2] goto  0030", [("IF", "", 1, 0, 12), ("GOTO", "0030", 0, 13, 23)]),
        ("GOTO#1", [("GOTO", "", 1, 0, 6)]),
        ("WHILE[#1LT3]DO2", [("WHILE", "", 1, 0, 12), ("DO", "2", 0, 12, 15)]),
        ("N5 END1", [("END", "1", 0, 3, 7)]),
        ("o100 sub", [("O-SUB", "100", 0, 0, 8)]),
        ("O<abc> CALL [1] [#2]", [("O-CALL", "<abc>", 2, 0, 20)]),
        ("o1 callsub [5]", [("O-CALL", "1", 1, 0, 14)]),
        ("o<abc> if [#1 GT 2]", [("O-IF", "<abc>", 1, 0, 19)]),
    ],
)
def test_control_statements(text: str, statements: list[tuple[str, str, int, int, int]]) -> None:
    found = block_of(text, LINUXCNC).controls
    assert [(one.keyword, one.label, len(one.arguments), one.start, one.end) for one in found] == statements


DIGITS = "a number has too many digits"


@pytest.mark.parametrize(
    ("text", "why", "column"),
    [
        ("#123456789012345=1", "", 0),
        ("#1234567890123456=1", "a variable number has too many digits", 0),
        ("G1 X[#1234567890123456]", "a variable number has too many digits", 5),
        ("X1" + "0" * 254, "", 0),
        ("X" + "0" * 400 + "1", "", 0),
        ("M8 X1" + "0" * 255, DIGITS, 4),
        ("#1=2+1" + "0" * 255, DIGITS, 5),
        ("N1" + "0" * 255 + "/X1.", DIGITS, 0),
        ("G1" + "0" * 400, DIGITS, 1),
        # Two hundred operations in each other, and one more.
        ("#1=1" + "+1" * 200, "", 0),
        ("#1=1" + "+1" * 201, "it is nested too deeply", 3),
        ("M8 #1=1" + "+1" * 201, "it is nested too deeply", 6),
        ("#1=" + "SIN[" * 200 + "1" + "]" * 200, "", 0),
        ("#1=" + "SIN[" * 201 + "1" + "]" * 201, "it is nested too deeply", 3 + 4 * 201),
    ],
)
def test_how_much_a_line_may_hold(text: str, why: str, column: int) -> None:
    block = read_block(0, text, FANUC)
    assert (block.opaque, block.opaque_column) == (why, column)
