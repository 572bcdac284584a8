"""Any bytes are a program, and no byte of it is lost, neither in the lines nor in the blocks."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from chipbreak.dialects import GENERIC_LATHE, Dialect
from chipbreak.syntax.grammar import grammar_of
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import LONGEST_LINE, emit, parse, read_block
from chipbreak.text.source import BLANKS, UserLines, read

from .controls import ISO, every_grammar
from .fragments import lines, programs

LINE = re.compile(rb"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")
# Of a program that comes from a paper tape: its first line ends so.
TAPE = re.compile(rb"[^\r\n]*(?:\n\r\r|\r\n|\r|\n)|[^\r\n]+")
FROM_TAPE = re.compile(rb"[^\r\n]*\n\r\r")
BLANK = re.compile(f"[{re.escape(BLANKS.decode('latin-1'))}]")


def check_round_trip(data: bytes, dialect: Dialect = GENERIC_LATHE) -> None:
    program = parse(read(data), dialect)
    assert emit(program) == data
    for block in program.event_blocks():
        assert block.text == program.source.text(block.line)
    program.unreadable()


def check_nothing_dropped(block: Block, dialect: Dialect) -> None:
    """Between the items of a block there are blanks only, and a block-delete mark where ``skip`` says so."""
    if block.opaque or block.mark:
        assert not (block.words or block.comments or block.assignments or block.controls or block.sequence)
        return
    items = [*block.words, *block.comments, *block.assignments, *block.controls]
    items += [block.sequence] if block.sequence else []
    at, between = 0, ""
    for item in sorted(items, key=lambda item: item.start):
        assert at <= item.start < item.end, f"two items share bytes in {block.text!r}"
        between += block.text[at : item.start]
        at = item.end
    between += block.text[at:]
    marks = {0: [""], 1: ["/", "/1"]}.get(block.skip, [f"/{block.skip}"])
    assert BLANK.sub("", between) in marks, f"{block.text!r} was read with a part left out"
    for word in block.words:
        inside = block.text[word.start : word.end]
        assert inside.startswith(word.letter)
        assert inside.endswith(word.value_text)
        set_off = BLANK.sub("", inside[len(word.letter) : len(inside) - len(word.value_text)])
        assert set_off in ("", *grammar_of(dialect).separators)


def test_every_program_of_the_corpus_comes_back(corpus_file: Path) -> None:
    check_round_trip(corpus_file.read_bytes())


@every_grammar
@pytest.mark.few(50)
@given(st.binary(max_size=200))
def test_any_bytes_come_back(dialect: Dialect, data: bytes) -> None:
    check_round_trip(data, dialect)


@pytest.mark.few(50)
@given(programs)
@example(b"")
@example(b"\r")
@example(b"\n\r")
@example(b"%\r%\r")
@example(b"X1\r\r\nX2\r\r\n")
@example(b"\xef\xbb\xbf%\r\nG1X1\r\n%\x1a")
def test_programs_come_back(data: bytes) -> None:
    check_round_trip(data)


@pytest.mark.few(50)
@given(programs)
@example(b"\n\r\r\n")
@example(b"X1\n\r\rX2\rX3\n\r\r")
@example(b"X1\nX2\n\r\r")
def test_lines_are_cut_at_every_line_end_and_nowhere_else(data: bytes) -> None:
    source = read(data)
    raw = [source.raw(line) for line in range(source.line_count)]
    assert raw == (TAPE if FROM_TAPE.match(data) else LINE).findall(data)
    assert [source.text(line).encode("latin-1") for line in range(source.line_count)] == [
        line.rstrip(b"\r\n") for line in raw
    ]


@every_grammar
@pytest.mark.few(50)
@given(lines)
@example("X1 (A)) Y2")
@example("N10 /2 X1")
@example("/1X1")
@example("/0X1")
@example("X\x001")
@example("G1 (A (B) X1) Y2")
def test_reading_a_block_drops_nothing(dialect: Dialect, text: str) -> None:
    check_nothing_dropped(read_block(0, text, dialect), dialect)


@every_grammar
def test_reading_the_corpus_drops_nothing(dialect: Dialect, corpus_lines: list[str]) -> None:
    for text in corpus_lines:
        check_nothing_dropped(read_block(0, text, dialect), dialect)


@pytest.mark.parametrize(
    ("data", "body"),
    [
        (b"", range(0)),
        (b"G1X1", range(1)),
        (b"G1X1\nM30\n", range(2)),
        (b"%\nG1X1\n%\n", range(3)),
        (b"%", range(1)),
        (b"LEADER\n%\nG1X1\n%\nTRAILER\n", range(1, 4)),
        (b"LEADER\n\x00 %O1(A)\nG1X1\n%", range(1, 4)),
        (b"\xef\xbb\xbf%\rG1X1\r%\r\x1a", range(3)),
        (b"%\nO1\nM30\n%\n%\nO2\nM30\n%\n\n", range(8)),
        # one mark only: the start, the end, or nobody knows
        (b"\n\n%\nG1X1\nM30\n", range(2, 5)),
        (b"\x1a%\nG1X1\nM30\n", range(3)),
        (b"G1X1\nM30\n%\n", range(3)),
        (b"G1X1\nM30\n%\n\0\0\n\x1a", range(3)),
        (b"LEADER\n%\nG1X1\nM30\n", range(4)),
        # a mark inside a line is none
        (b"G1X1 %\n(100%)\n", range(2)),
        (b"(5%)\n%\nG1\n%\n(6%)\n", range(1, 4)),
    ],
)
def test_the_body_is_what_a_control_reads(data: bytes, body: range) -> None:
    source = read(data)
    assert source.body == body
    events = parse(source, GENERIC_LATHE).special_lines
    assert all(line in body for line in events)


@pytest.mark.few(50)
@given(programs)
def test_marks_bound_the_body(data: bytes) -> None:
    source = read(data)
    marks = [i for i in range(source.line_count) if read_block(i, source.text(i), GENERIC_LATHE).mark]
    if not marks:
        assert source.body == range(source.line_count)
    elif len(marks) > 1:
        assert source.body == range(marks[0], marks[-1] + 1)
    else:
        assert marks[0] in source.body
        assert {source.body.start, source.body.stop} <= {0, marks[0], marks[0] + 1, source.line_count}


@every_grammar
def test_source_and_grammar_agree_on_blanks(dialect: Dialect) -> None:
    blank = re.compile(grammar_of(dialect).terminals["BLANK"])
    read_past = {c for c in range(256) if blank.fullmatch(chr(c))} | set(b"\xef\xbb\xbf")
    assert blank.fullmatch("\xef\xbb\xbf")
    assert set(BLANKS) == read_past


@pytest.mark.parametrize(
    ("data", "end"),
    [
        (b"", b"\n"),
        (b"X1", b"\n"),
        (b"X1\nX2", b"\n"),
        (b"X1\r\nX2\r\n", b"\r\n"),
        (b"X1\rX2\r", b"\r"),
        (b"X1\r\nX2\nX3\r\n", b"\r\n"),
        (b"X1\nX2\nX3\r\n", b"\n"),
        (b"\n\n\n", b"\n"),
        (b"\r\r\r", b"\r"),
        # CR CR LF, and CR among LF: a control that reads LF would not see the end of a block ended by CR
        (b"X1\r\r\nX2\r\r\n", b"\r\n"),
        (b"A\rB\rC\rX1\n", b"\n"),
    ],
)
def test_new_blocks_take_the_usual_line_end(data: bytes, end: bytes) -> None:
    assert read(data).line_end == end


def test_places_count_from_one_and_follow_the_numbers_of_the_user() -> None:
    data = b"G1 X1\nG2 Y\r\n"
    assert str(read(data, "a.nc").place(1, 3)) == "a.nc:2:4"
    assert read(data).place(0, 0, 2)[2:] == (1, 3)
    assert read(data).place(1)[2:] == (1, 5)
    filtered = read(b"\n" * 6 + b"(CHIPBREAK WAS G1 X1)\n(CHIPBREAK HEX 4732)\n", "a.nc")
    source = read(data, "a.nc", UserLines(filtered, np.array([7, 8]), np.array([15, -1])))
    assert (str(source.place(0, 3)), source.shown(0)) == ("a.nc:7:19", "(CHIPBREAK WAS G1 X1)")
    assert (str(source.place(1, 3)), source.shown(1)) == ("a.nc:8:1", "(CHIPBREAK HEX 4732)")


def test_an_unreadable_line_is_reported_where_it_is() -> None:
    program = parse(read(b"%\nG1 X1 @5 Y2\nX2\nX[1+]\n%\nTRAILER\n", "a.nc"), GENERIC_LATHE)
    found = program.unreadable()
    assert [str(d.place) for d in found] == ["a.nc:2:7", "a.nc:4:5"]
    assert {d.code for d in found} == {"SYN001"}
    assert found[0].line_text == "G1 X1 @5 Y2"


MANY = 1_000_000
ENDLESS = {
    "a line of a hundred megabytes": ("X" * 100 * MANY, "longer"),
    "a million words": ("X1" * MANY, "longer"),
    "a million letters N": ("N" * MANY, "longer"),
    "four million parentheses": ("((((" * MANY, "longer"),
    "a million brackets deep": ("X" + "[" * MANY + "1" + "]" * MANY, "longer"),
    "a million blanks": (" " * MANY, ""),
    "a million blanks and a word": (" " * MANY + "X1", ""),
    "a million blanks and a stray byte": (" " * MANY + "!", "not expected"),
    "a million NULs": ("\0" * MANY, ""),
    "the longest comment": ("(" + "A" * (LONGEST_LINE - 2) + ")", ""),
    "one more than the longest": ("(" + "A" * (LONGEST_LINE - 1) + ")", "longer"),
    "brackets that only group": ("X" + "[" * 30_000 + "1" + "]" * 30_000, ""),
    "brackets never closed": ("X" + "[" * 60_000, "ends in the middle"),
    "parentheses": ("(" * 60_000, ""),
    "comments": ("()" * 30_000, ""),
    "letters": ("N" * 60_000, "not expected"),
    "functions in each other": ("X" + "ABS[" * 10_000 + "1" + "]" * 10_000, "nested"),
    "indirect variables": ("#" * 60_000 + "1=1", "nested"),
    "a long sum": ("#1=1" + "+1" * 30_000, "nested"),
    "names never closed": ("O<" * 30_000, "not expected"),
    "names": ("O<a>" * 15_000, ""),
    "labels never closed": ("O[" * 30_000, "not expected"),
    "labels and blanks": (("O" + " " * 250) * 250, "not expected"),
    "functions and blanks": ("X" + ("SIN" + " " * 250) * 250, "not expected"),
    "a huge code": ("G" + "9" * 308, "too many digits"),
    "a huge number": ("X" + "9" * 400, "too many digits"),
    "a huge number in an expression": ("X[" + "9" * 400 + "]", "too many digits"),
    "a huge sequence number before a block delete": ("N" + "9" * 400 + "/X1", "too many digits"),
    "a variable number of 5000 digits": ("#" + "9" * 5000 + "=1", "too many digits"),
    "a small number with many digits": ("X." + "3" * 5000, ""),
}


# Each line with one control, the controls in turn; with the others in the long form.
_ONE_CONTROL = [
    pytest.param(
        name, dialect, id=f"{control}-{name}", marks=() if (at - turn) % len(ISO) == 0 else pytest.mark.long
    )
    for at, name in enumerate(ENDLESS)
    for turn, (control, dialect) in enumerate(ISO.items())
]


@pytest.mark.parametrize(("name", "dialect"), _ONE_CONTROL)
def test_no_line_is_too_long_or_too_deep(name: str, dialect: Dialect) -> None:
    text, why = ENDLESS[name]
    block = read_block(0, text, dialect)
    assert why in block.opaque
    assert bool(why) == bool(block.opaque)
    assert 0 <= block.opaque_column <= len(text)
    data = text.encode("latin-1")
    program = parse(read(data), dialect)
    assert emit(program) == data
    assert program.plain.tolist() == [-1]
    hash(block), repr(block)  # an expression can be walked by recursion
