"""The regular expression, the shapes and the grammar read the same: three roads to a block, one meaning."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from chipbreak.dialects import GENERIC_LATHE, Dialect
from chipbreak.syntax import shapes
from chipbreak.syntax.columns import read_columns, read_words, uniform_run
from chipbreak.syntax.grammar import grammar_of
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import parse, parse_changed, read_block, read_by_grammar, read_plain
from chipbreak.syntax.shapes import PLAIN_LETTERS, Shape
from chipbreak.text.source import Source, read

from .controls import every_grammar, every_iso_control
from .fragments import good_lines, lines, programs, set_off_lines

TRICKY = [
    "",
    " ",
    "G1.5",
    "G1.",
    "G001",
    "G01",
    "G 1",
    "G1X1",
    "G1 .5X1",
    "G1-5",
    "G1 2X1",
    "G10X1",
    "G00X1",
    "G03X1",
    "G04X1",
    "G30X1",
    "G003X1",
    "G0.3X1",
    "X1G1",
    "G",
    "GX1",
    "\x03X1",
    "\x031X1",
    "\x03\x00X1",
    "G\x031X1",
    "G\x00X1",
    "X1\xff",
    "X\xff1",
    "X1\xff2",
    "G1\xffX1",
    "G13 X1",
    "G4X1",
    "G1G2X1",
    "G1 G1 X1",
    "X1G1",
    "X1 2",
    "X1.2.3",
    "X1-2",
    "X--1",
    "X+-1",
    "X- 1",
    "X .5",
    "X.",
    "X-.",
    "X",
    "X1.Y",
    "X1Y2X3",
    "N10X1",
    "N10N20X1",
    "N10 N20",
    "N1.5X1",
    "N-5X1",
    "N+5X1",
    "N X1",
    "NX1",
    "X1N10",
    "G1N10X1",
    "n10 g1 x1",
    "(A)N10X1",
    "/X1",
    "/2X1",
    "/12X1",
    "/0X1",
    "/ X1",
    "//X1",
    " /X1",
    "N10/X1",
    "N10 /2 N20 X1",
    "N10./X1",
    "X1/2",
    "x1",
    "g1 X1",
    "X1\tY2",
    "X\t1",
    "X\x001",
    "X\x00",
    "G1X1Y\x00",
    "X1.\x00",
    "X1\x1a",
    "\x00X1",
    "\x01X1",
    "\xef\xbb\xbfX1",
    "X\xef\xbb\xbf1",
    "X1\xef",
    "X\xb2",
    "X1(A",
    "X1(A)Y2",
    "X(A)1",
    "X1;Y2",
    "X1,R5",
    "X1,5",
    ",X1",
    "X1, R5",
    "X1E5",
    "X1e5",
    "X1_0",
    "X1D0",
    "O1234",
    "o<a> call",
    "o<a> call [1.] [-.5] [+2]",
    "N5 o<a>CALL[1][ 2. ] (c)",
    "o<A b>\tcall [1] X5.",
    "o<a> call [1] [#2]",
    "o<a> call [1 2]",
    "o<a> call [1",
    "o<a> call1",
    "o<a> calls",
    "o<a> callsub [1]",
    "o <> call",
    "o<a call [1]",
    "X1 o<a> call [1]",
    "/o<a> call [1]",
    "o<a>\x0bcall [1]",
    "o<a> call [1]\x0b[2]",
    "O1 X1",
    "X" + "9" * 250,
    "X" + "9" * 300,
    "X" + " " * 300 + "1",
    "N" + "9" * 400 + "/X1",
    "X=1",
    "X=-1.5 Y = 2",
    "X==1",
    "X=",
    "N10 G1 X=10.5 Y=3 F=.2",
    "N=10 X=1",
    "G=1 X=1",
    "G1 X=1 ; X=2",
    "X=1=2",
    "=1",
]


def compare_regular_expression_and_grammar(text: str, dialect: Dialect) -> None:
    plain = read_plain(0, text, dialect)
    if plain is not None:
        assert plain == read_by_grammar(0, text, dialect)


def compare_shape_and_block(shape: Shape, block: Block) -> None:
    """A shape says that the block is words only: a motion in front, then each letter once."""
    words = list(block.words)
    if shape.motion is not None:
        motion = words.pop(0)
        assert (motion.letter, motion.number) == ("G", shape.motion)
    assert "".join(word.letter for word in words) == shape.letters
    assert len(set(shape.letters)) == len(shape.letters) > 0
    assert set(shape.letters) <= set(PLAIN_LETTERS)
    assert all(word.number is not None for word in words)
    assert shape.has_points == all(word.has_point for word in words)
    assert block.sequence is None or block.sequence.number is not None
    assert shape.numbered == (block.sequence is not None)
    assert not (
        block.comments or block.assignments or block.controls or block.skip or block.opaque or block.mark
    )


def compare_shapes(source: Source, dialect: Dialect) -> None:
    program = parse(source, dialect)
    plain, found = program.plain, program.shapes
    assert len(plain) == source.line_count
    blocks = map(program.block, source.body)
    numbered = {block.line for block in blocks if block.sequence is not None}
    said = program.lines_with_numbers()
    assert numbered == {line for line in said if plain[line] >= 0 or line in numbered}
    for line, index in enumerate(plain.tolist()):
        if index >= 0:
            compare_shape_and_block(found[index], read_block(line, source.text(line), dialect))


@every_grammar
def test_tricky_lines_are_read_alike(dialect: Dialect) -> None:
    for text in TRICKY:
        compare_regular_expression_and_grammar(text, dialect)
        compare_shapes(read(text.encode("latin-1")), dialect)


@every_grammar
@pytest.mark.few(15)
@given(st.one_of(good_lines, lines, set_off_lines))
@example("X\x001")
@example("N10 /2 N20 X1")
def test_regular_expression_and_grammar_agree(dialect: Dialect, text: str) -> None:
    compare_regular_expression_and_grammar(text, dialect)


@every_grammar
@pytest.mark.few(15)
@given(st.text("GNXYFR0123456789.+-= \t/,;()\0", max_size=14))
def test_they_agree_on_every_order_of_the_signs_of_a_block(dialect: Dialect, text: str) -> None:
    compare_regular_expression_and_grammar(text, dialect)
    compare_shapes(read(text.encode("latin-1")), dialect)


@every_grammar
def test_regular_expression_and_grammar_agree_on_the_corpus(
    dialect: Dialect, corpus_lines: list[str]
) -> None:
    for text in corpus_lines:
        compare_regular_expression_and_grammar(text, dialect)


@every_iso_control
def test_most_of_the_corpus_needs_no_grammar(dialect: Dialect, corpus_lines: list[str]) -> None:
    read_fast = sum(read_plain(0, text, dialect) is not None for text in corpus_lines)
    assert read_fast > len(corpus_lines) / 3


@every_grammar
@pytest.mark.few(15)
@given(st.one_of(programs, st.lists(set_off_lines).map(lambda parts: "\n".join(parts).encode("latin-1"))))
def test_shapes_and_blocks_agree(dialect: Dialect, data: bytes) -> None:
    compare_shapes(read(data), dialect)


@every_grammar
def test_shapes_and_blocks_agree_on_the_corpus(dialect: Dialect, corpus_file: Path) -> None:
    compare_shapes(read(corpus_file.read_bytes()), dialect)


@pytest.mark.few(20)
@given(programs, st.integers(1, 40))
@example(b"X1\r\nY2\r\n", 3)
@example(b"X1\rY2\r", 1)
@example(b"\n\nG1", 1)
def test_shapes_do_not_depend_on_the_size_of_the_pieces(data: bytes, size: int) -> None:
    source = read(data)
    whole = parse(source, GENERIC_LATHE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shapes, "_CHUNK_BYTES", size)
        pieces = parse(source, GENERIC_LATHE)
    assert pieces.plain.tolist() == whole.plain.tolist()
    assert pieces.shapes == whole.shapes


@pytest.mark.few(20)
@given(programs, programs, st.data())
def test_a_changed_program_is_classified_like_a_new_one(old: bytes, new: bytes, data: st.DataObject) -> None:
    original = parse(read(old), GENERIC_LATHE)
    count = original.source.line_count
    first = data.draw(st.integers(0, count))
    last = data.draw(st.integers(first, count))
    starts = original.source.starts
    head, tail = old[: starts[first]], old[starts[last] :]
    insert = read(new if new.endswith((b"\r", b"\n")) else new + b"\n")
    changed = read(head + insert.data + tail)
    same_cut = changed.line_count == first + insert.line_count + count - last
    if not same_cut:  # a line end was split or joined at the border
        return
    kept = [(0, first, 0), (first + insert.line_count, changed.line_count, last)]
    spliced, fresh = parse_changed(changed, original, kept), parse(changed, GENERIC_LATHE)
    assert spliced.special_lines.tolist() == fresh.special_lines.tolist()
    for line in np.flatnonzero(fresh.plain >= 0).tolist():
        assert spliced.shapes[spliced.plain[line]] == fresh.shapes[fresh.plain[line]]


blank = st.sampled_from(["", "", " ", "\t", "  "])
number = st.from_regex(r"[+-]?([0-9]{1,5}\.?[0-9]{0,5}|\.[0-9]{1,5})", fullmatch=True)


@st.composite
def plain_blocks(draw: st.DrawFn) -> tuple[str, Shape]:
    """A plain motion block and the shape it must have."""
    motion = draw(st.sampled_from([None, 0, 1, 2, 3]))
    letters = draw(st.lists(st.sampled_from(PLAIN_LETTERS), min_size=1, unique=True))
    numbers = [draw(number) for _ in letters]
    text = draw(blank)
    numbered = draw(st.booleans())
    if numbered:
        text += "N" + draw(blank) + draw(number) + draw(blank)
    if motion is not None:
        text += draw(st.sampled_from(["G", "G0"])) + str(motion) + draw(blank)
    for letter, value in zip(letters, numbers, strict=True):
        text += letter + draw(blank) + value + draw(blank)
    return text, Shape("".join(letters), motion, all("." in value for value in numbers), numbered)


@every_grammar
@pytest.mark.few(15)
@given(plain_blocks())
def test_every_plain_block_is_found(dialect: Dialect, case: tuple[str, Shape]) -> None:
    text, shape = case
    program = parse(read(text.encode("latin-1")), dialect)
    assert [program.shapes[index] for index in program.plain] == [shape]
    assert not len(program.special_lines)
    compare_shape_and_block(shape, read_by_grammar(0, text, dialect))


@every_grammar
@pytest.mark.few(8)
@settings(max_examples=30)
@given(st.lists(plain_blocks(), min_size=1, max_size=5))
def test_words_hold_the_numbers_of_blocks_of_any_shape(
    dialect: Dialect, cases: list[tuple[str, Shape]]
) -> None:
    program = parse(read("\n".join(text for text, _ in cases).encode("latin-1")), dialect)
    columns = read_words(program, 0, len(cases), PLAIN_LETTERS)
    assert columns is not None
    for line, row in enumerate(columns.tolist()):
        words = {word.letter: word.number for word in program.block(line).words}
        assert [words.get(letter) for letter in PLAIN_LETTERS] == [None if math.isnan(n) else n for n in row]


@every_grammar
@pytest.mark.few(15)
@given(
    st.lists(st.sampled_from(PLAIN_LETTERS), min_size=1, max_size=4, unique=True),
    st.lists(st.lists(number, min_size=4, max_size=4), min_size=1, max_size=5),
    st.sampled_from(["\n", "\r\n", "\r"]),
)
def test_columns_hold_the_numbers_of_the_blocks(
    dialect: Dialect, letters: list[str], rows: list[list[str]], end: str
) -> None:
    set_off = [letter + grammar_of(dialect).separators for letter in letters]
    text = [" ".join(map(str.__add__, set_off, row)) for row in rows]
    program = parse(read(end.join(text).encode()), dialect)
    columns = read_columns(program, 0, len(rows))
    assert columns is not None
    assert columns[0] == "".join(letters)
    words = [[word.number for word in program.block(line).words] for line in range(len(rows))]
    assert columns[1].tolist() == words


@pytest.mark.parametrize(
    "texts",
    [
        pytest.param(["X5.", "X-6.", "X17."], id="no decimals"),
        pytest.param(["X5.0", "X6.", "X7.25"], id="other decimals in each row"),
        pytest.param(["X5.25", "X6.5", "X7.75"], id="fewer decimals in a row between"),
        pytest.param(["X5.25", "X6.5"], id="fewer decimals in the last row"),
        pytest.param(["X5.", "X6.25"], id="decimals behind a row without"),
        pytest.param(["X.5", "X-.7"], id="no digit before the point"),
        pytest.param(["X1523478257594680.9", "X0.5"], id="more digits than a double holds"),
        pytest.param(["X-1523478257594680.9", "X0.5"], id="the same below zero"),
        pytest.param(["X900719925474099.1", "X900719925474099.2"], id="the last whole numbers that it holds"),
        pytest.param(["X99999999999999999999.5", "X0.5"], id="more digits than a whole number holds"),
        pytest.param(["X0.1234567891", "X0.1234567892"], id="ten decimals"),
        pytest.param(["X0.123456789", "X0.123456788"], id="nine decimals"),
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_columns_hold_numbers_of_every_length(texts: list[str], end: str) -> None:
    text = "".join(one + end for one in texts)
    columns = read_columns(parse(read(text.encode()), GENERIC_LATHE), 0, len(texts))
    assert columns is not None
    assert columns[1].ravel().tolist() == [float(text[1:]) for text in texts]


@pytest.mark.parametrize(
    "text", ["X1\nY2", "X1\nX2Y2", "N1X1\nX2", "G1X1\nX2", "X1\nX2(A)", "X1\n\nX2", "X1\nX2 3"]
)
def test_columns_are_for_blocks_with_the_same_words_only(text: str) -> None:
    program = parse(read(text.encode()), GENERIC_LATHE)
    assert read_columns(program, 0, program.source.line_count) is None


@pytest.mark.few(30)
@given(
    st.lists(st.tuples(st.sampled_from(["X1", "X2.", "N5X3", "G1X1", "X1Y2", "M5", ""]), st.integers(1, 150)))
)
def test_a_uniform_run_ends_where_the_words_change(parts: list[tuple[str, int]]) -> None:
    program = parse(read("".join(f"{text}\n" * times for text, times in parts).encode()), GENERIC_LATHE)
    plain = program.plain.tolist()
    words = [(program.shapes[i].letters, program.shapes[i].motion) if i >= 0 else None for i in plain]
    for first in range(0, len(words), 37):
        end = first + 1
        while words[first] and end < len(words) and words[end] == words[first]:
            end += 1
        assert uniform_run(program, first, len(words)) == end
        assert uniform_run(program, first, first + 1) == first + 1
        assert uniform_run(program, first, first) == first


@pytest.mark.parametrize(
    "text",
    [
        "G1",
        "N10",
        "G1X1(A)",
        "G1X1;",
        "/G1X1",
        "G1X1X2",
        "G1X1S500",
        "G1X1M8",
        "G4X1",
        "G1.X1",
        "G1.1X1",
        "G001X1",
        "G11X1",
        "G1G90X1",
        "X1G1",
        "g1x1",
        "X#1",
        "X[1]",
        "X1N10",
        "X1\x1a",
        "X1f0.1",
        "X1,R2",
        "%X1",
    ],
)
def test_a_block_with_more_in_it_is_not_plain(text: str) -> None:
    program = parse(read(f"G1X1\n{text}\nX2\n".encode("latin-1")), GENERIC_LATHE)
    assert [line in program.special_lines for line in range(3)] == [False, True, False]
