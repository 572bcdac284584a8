"""Text to Program.

Two roads lead to a Block.  A block of plain words and comments is read by one regular expression made of
the terminals of the dialect's grammar; whatever that cannot read goes to the grammar.  A property test holds
the two roads equal.  What neither can read becomes an opaque block, with a diagnostic, and prints as it came.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from chipbreak.dialects import Dialect
from chipbreak.syntax.build import BlockBuilder, build_block, opaque
from chipbreak.syntax.expressions import UnreadableError
from chipbreak.syntax.grammar import grammar_of
from chipbreak.syntax.nodes import Block, Number, Word
from chipbreak.syntax.shapes import LONGEST_PLAIN, Shape, ShapeTable, classify
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import BLANKS, Source

UNREADABLE = "SYN001"
# No control reads blocks of this length; without a bound one line could fill the memory.
LONGEST_LINE = 1 << 16
_MOST_TEXTS = 4096  # of plain lines; the passes of cycles say the same again and again
_COMMENT_HAS_ENDED = "where the comment has ended at its first ')'"
_INNER = "take the inner parentheses out; "
_NOTHING_CHANGED = "nothing is changed here; vibration and checks refuse to cross it"
_FOREIGN_RUN = re.compile(r"[\xa1-\xff][\x80-\xff]{0,29}")
_NESTED = re.compile(r"\([^()]*\([^()]*\)")
_BLANK_CHARACTERS = BLANKS.decode("latin-1")


class Program(NamedTuple):
    """A program as lines, without losing a byte, as a control reads them (``dialect``).

    ``plain`` holds for every line the index of its shape in ``table.shapes``, or -1 where the line is more
    than a plain motion block; ``special_lines`` are those lines of the body.  ``bits`` says for every plain
    line what it has (see ``Shape.bits``), 0 for the others.  Blocks are read when asked for, and
    of lines with the same text as a rule only one.
    """

    source: Source
    dialect: Dialect
    plain: NDArray[np.int32]
    table: ShapeTable
    special_lines: NDArray[np.int64]
    bits: NDArray[np.uint16]
    known: dict[int, Block]
    texts: dict[str, Block]

    @property
    def shapes(self) -> Sequence[Shape]:
        """The shapes of its plain lines."""
        return self.table.shapes

    def block(self, line: int) -> Block:
        """The block on a line."""
        block = self.known.get(line)
        if block is not None:
            return block
        is_special = bool(self.plain[line] < 0)
        text = self.source.text(line)
        like = self.texts.get(text)
        if like is not None:
            block = Block(line, *like[1:])
        else:
            block = read_block(line, text, self.dialect)
            if is_special or len(self.texts) < _MOST_TEXTS:
                self.texts[text] = block
        if is_special:
            self.known[line] = block
        return block

    def event_blocks(self) -> Iterator[Block]:
        """Every block of the body that is more than a plain motion."""
        return (self.block(int(line)) for line in self.special_lines)

    def lines_with_numbers(self) -> list[int]:
        """The lines of the body that may begin with a block number: plain ones that do, and all others."""
        body = slice(self.source.body.start, self.source.body.stop)
        # The last one is for lines that have no shape.
        of_shape = np.array([*(shape.numbered for shape in self.shapes), True])
        lines: list[int] = (np.flatnonzero(of_shape[self.plain[body]]) + body.start).tolist()
        return lines

    def diagnose(
        self,
        line: int,
        code: str,
        message: str,
        help: str = "",
        *,
        at: tuple[int, int] | None = None,
        severity: Severity = Severity.ERROR,
        instead: tuple[str, ...] = (),
    ) -> Diagnostic:
        """A diagnostic at characters ``at`` of a line, or at its first word."""
        source = self.source
        text = self.known[line].text if line in self.known else source.text(line)
        start, end = at or _first_word(text)
        said = (source.meant(message), source.meant(help))
        place = source.place(line, start, end)
        shown = text if source.user_lines is None else source.shown(line)
        return Diagnostic(
            code, severity, *said, place, shown, source.encoding, tuple(map(source.meant, instead))
        )

    def unreadable(self) -> list[Diagnostic]:
        """A warning for every line that could not be read."""
        return [
            self.diagnose(
                block.line,
                UNREADABLE,
                f"this line cannot be read ({block.opaque}); it is passed through as it is",
                f"{_INNER if _COMMENT_HAS_ENDED in block.opaque else ''}{_NOTHING_CHANGED}",
                at=(block.opaque_column, block.opaque_column + 1),
                severity=Severity.WARNING,
            )
            for block in self.event_blocks()
            if block.opaque
        ]


def _first_word(text: str) -> tuple[int, int]:
    """Where the first word of a line begins, and where the last one ends; a line of blanks has its start."""
    end = len(text.rstrip())
    return (end - len(text[:end].lstrip()) if end else 0), end


def parse(source: Source, dialect: Dialect) -> Program:
    """Classify every line as the dialect's grammar reads it; blocks are read on demand.

    Any bytes are a program: what cannot be read becomes an opaque block.  Raises ProgramRejectedError
    (SYN002) only for a dialect whose grammar cannot be used.
    """
    table = ShapeTable(grammar_of(dialect))
    return _program(source, dialect, classify(source, table, 0, source.line_count), table)


def parse_changed(source: Source, original: Program, kept: Sequence[tuple[int, int, int]]) -> Program:
    """Parse a program of which stretches of lines are those of ``original``, byte for byte.

    ``kept`` holds (first, last, first in the original) for each stretch, in order; only the lines between
    them are classified anew, because what a line is depends on nothing but its own bytes.
    """
    parts = []
    line = 0
    for first, last, old_first in kept:
        parts.append(classify(source, original.table, line, first))
        parts.append(original.plain[old_first : old_first + last - first])
        line = last
    parts.append(classify(source, original.table, line, source.line_count))
    return _program(source, original.dialect, np.concatenate(parts), original.table)


def _program(source: Source, dialect: Dialect, plain: NDArray[np.int32], table: ShapeTable) -> Program:
    body = source.body
    special_lines = np.flatnonzero(plain[body.start : body.stop] < 0).astype(np.int64) + body.start
    bits = np.array([shape.bits for shape in table.shapes] + [0], np.uint16)
    return Program(source, dialect, plain, table, special_lines, bits[plain], {}, {})


def emit(program: Program) -> bytes:
    """The bytes of a program: the join of its lines."""
    return b"".join(program.source.raw(line) for line in range(program.source.line_count))


def read_block(line: int, text: str, dialect: Dialect) -> Block:
    """One block by the fast road where it is plain, by the grammar where it is not."""
    if text.lstrip(_BLANK_CHARACTERS).startswith("%"):
        return Block(line, text, mark=True)
    if len(text) > LONGEST_LINE and len(text.strip(_BLANK_CHARACTERS)) > LONGEST_LINE:
        return opaque(line, text, f"it is longer than {LONGEST_LINE} characters", LONGEST_LINE)
    block = read_plain(line, text, dialect)
    return block if block is not None else read_by_grammar(line, text, dialect)


def read_plain(line: int, text: str, dialect: Dialect) -> Block | None:
    """Words and calls with literal numbers, comments, block delete; None when there is anything else."""
    if len(text) > LONGEST_PLAIN:
        return None
    grammar = grammar_of(dialect)
    builder = BlockBuilder(line, text)
    at = 0
    head = grammar.head.match(text)
    if head:
        builder.add_delete(head["delete"], head.start("delete"))
        at = head.end()
    match_item = grammar.item.match
    while at < len(text):
        match = match_item(text, at) or grammar.call.match(text, at)
        if match is None:
            return None
        at = match.end()
        kind = match.lastgroup
        if kind == "word":
            number = match["number"]
            builder.add_word(Word(match["letter"], number, float(number), None, match.start(), at))
        elif kind == "comment":
            builder.add_comment(match.start(), at)
        elif kind == "numbers":
            numbers = map(float, grammar.argument.findall(match["numbers"]))
            builder.add_call(match["label"], tuple(map(Number, numbers)), match.start(), at)
    return builder.done()


def read_by_grammar(line: int, text: str, dialect: Dialect) -> Block:
    """The law: the grammar's reading of any block."""
    from lark.exceptions import UnexpectedInput, UnexpectedToken  # noqa: PLC0415 (loaded when it is needed)

    parser = grammar_of(dialect).parser
    try:
        return build_block(parser.parse(text), line, text, dialect.precedence)
    except UnexpectedInput as error:
        ended = isinstance(error, UnexpectedToken) and error.token.type == "$END"
        column = len(text.rstrip(_BLANK_CHARACTERS)) - 1 if ended else int(error.pos_in_stream or 0)
        return opaque(line, text, _why(text, column, ended=ended), column)
    except UnreadableError as error:
        return opaque(line, text, error.why, error.column)


def _why(text: str, column: int, *, ended: bool) -> str:
    if ended:
        return "it ends in the middle of a word or an expression"
    nested = _NESTED.search(text, 0, column)
    behind = f", {_COMMENT_HAS_ENDED}" if nested else ""
    # Of other alphabets the whole run is shown, for one byte of it may mean nothing.
    shown = _FOREIGN_RUN.match(text, column)
    if shown:
        return f"'{shown[0]}' is not expected here{behind}"
    one = repr(text[column]) if text[column].isprintable() else f"byte 0x{ord(text[column]):02X}"
    return f"{one} is not expected here{behind}"
