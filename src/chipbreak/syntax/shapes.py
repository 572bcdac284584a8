"""The shape of a line: its text with every run of digits made one mark, and without the signs of numbers.

``N120 X10.5 Y-3.25`` and ``N125 X7.0 Y12.`` have one shape, and a program of a million blocks has a few
dozen.  So each shape is read once; a line whose shape is a plain motion block needs no more.  The G of a
motion code becomes a mark of its own, so that G1 and G2 have different shapes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from chipbreak.syntax.grammar import Grammar
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import TAPE_END, TAPE_LINE_END, Source

PLAIN_LETTERS = "XYZUVWABCIJKRF"
# What a plain line has, as bits: its letters, a code of motion, a number without a point.
MOTION_CODE, NO_POINT = 1 << 14, 1 << 15
# A longer line gets a closer look; in a shorter one every number is finite.
LONGEST_PLAIN = 255
_CHUNK_BYTES = 1 << 18
# In a shape NUL is a run of digits, and one of these the G of G0 to G3; 0xFF is left out.  Where such a byte
# stands in a program, it becomes SOH, which no plain block has.
_MOTIONS, _LEFT_OUT, _FOREIGN = b"\2\3\4\5", b"\xff", b"\1"
# Rows of equal shapes: so many are compared at once; shorter ones than these are not worth it, and are tried
# so often.
_TOGETHER = 64
_SHORT_ROW = 8
_FIRST_ROWS = 8
_FRACTION_BEHIND_N = re.compile(rb"N[ \t]*\x00?\.\x00")
_TO_SHAPE = bytes.maketrans(b"0123456789\0", b"\0" * 10 + _FOREIGN)


class Shape(NamedTuple):
    """A plain motion block: at most one of G0 to G3, then words of ``PLAIN_LETTERS``, each once.

    ``has_points`` is True when each of these words has a decimal point, ``numbered`` when the block begins
    with its number.
    """

    letters: str
    motion: int | None
    has_points: bool
    numbered: bool

    @property
    def bits(self) -> int:
        """Its letters, and what else can be asked of many lines at once."""
        code = 0 if self.motion is None else MOTION_CODE
        return bits_of(self.letters) | code | (0 if self.has_points else NO_POINT)


@lru_cache(maxsize=256)
def bits_of(letters: str | frozenset[str]) -> int:
    """Those of ``PLAIN_LETTERS`` that are among the letters, as bits."""
    return sum(1 << bit for bit, letter in enumerate(PLAIN_LETTERS) if letter in letters)


class ShapeReader:
    """The plain block of a grammar as a shape, made of the grammar's own number and separator."""

    def __init__(self, grammar: Grammar) -> None:
        letters = "".join(filter(grammar.reads_letter, PLAIN_LETTERS)) or "\xff"  # a byte that no shape has
        blank = r"[ 	]*+"  # possessive: a long run of blanks must not be tried twice; others are rare
        number = grammar.terminals["NUMBER"].replace("[0-9]+", r"\x00").replace("[0-9]*", r"\x00?")
        # A letter that is set off from its number may have any of the grammar's separators.
        set_off = f"(?:[{re.escape(grammar.separators)}]{blank})?+" if grammar.separators else ""
        word = f"[{letters}]{blank}{set_off}{number}{blank}"
        sequence = f"(N{blank}{set_off}{number}{blank})?" if grammar.reads_letter("N") else "()"
        motion = rf"(?:([\x02-\x05])\x00{blank})?" if grammar.reads_letter("G") else "()"
        head = f"{blank}{sequence}{motion}"
        self._whole = re.compile(f"{head}((?:{word})+)".encode("latin-1"))
        self._letter = re.compile(f"[{letters}]".encode("latin-1"))

    def read(self, shape: bytes) -> Shape | None:
        """The plain block that a shape stands for, or None when the line needs a closer look."""
        if len(shape) > LONGEST_PLAIN:
            return None
        match = self._whole.fullmatch(shape)
        if match is None:
            return None
        number, code, words = match.groups()
        letters = b"".join(self._letter.findall(words)).decode("ascii")
        if len(set(letters)) != len(letters):
            return None
        motion = _MOTIONS.index(code) if code else None
        return Shape(letters, motion, words.count(b".") == len(letters), bool(number))


def _texts(source: Source, first: int, stop: int) -> Iterator[tuple[bytes, int]]:
    """The shapes of lines ``first`` to ``stop`` (exclusive), a chunk of lines at a time, and how many."""
    is_tape = source.line_end == TAPE_END
    while first < stop:
        limit = source.starts[first] + _CHUNK_BYTES
        last = max(first + 1, int(np.searchsorted(source.starts, limit, "right")) - 1)
        last = min(last, stop)
        data = source.data[source.starts[first] : min(source.starts[last], limit + LONGEST_PLAIN)]
        yield _shapes_of(data, is_tape=is_tape), last - first
        first = last


def _shapes_of(data: bytes, *, is_tape: bool) -> bytes:
    """The shapes of some lines, each with a line end but the last."""
    if b"\r" in data:
        if is_tape:
            data = TAPE_LINE_END.sub(b"\n", data)
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    for byte in _MOTIONS + _LEFT_OUT:
        if byte in data:
            data = data.replace(bytes((byte,)), _FOREIGN)
    raw = np.frombuffer(data, np.uint8)
    marks = raw.copy()
    is_digit = _digits(raw) < 10
    goes_on = (is_digit[1:] & is_digit[:-1]).view(np.uint8)
    marks[1:] |= np.negative(goes_on)  # 0xFF where a digit follows a digit
    # And at a sign right between a letter and a number: with it or without, that is the same word.
    is_number = is_digit[2:] | (raw[2:] == ord("."))
    is_sign = (raw[1:-1] == ord("-")) & (raw[:-2] - np.uint8(ord("A")) < 26) & is_number
    marks[1:-1] |= np.negative(is_sign.view(np.uint8))
    codes = np.flatnonzero(raw == ord("G"))
    marks[codes] = _motion_marks(raw, codes)
    return marks.tobytes().translate(_TO_SHAPE, _LEFT_OUT)


def _digits(raw: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The values of digits; 10 or more for anything else."""
    return raw - np.uint8(ord("0"))


def _motion_marks(raw: NDArray[np.uint8], codes: NDArray[np.int64]) -> NDArray[np.uint8]:
    """What the G at each of these places becomes: a mark of its own where G0 to G3 (or G00 to G03) begin."""
    one, two, three = (_digits(raw.take(codes + ahead, mode="clip")) for ahead in (1, 2, 3))
    number = np.where(two < 10, one * np.uint8(10) + two, one)
    is_motion = (one < 10) & (number < len(_MOTIONS)) & ((two >= 10) | (three >= 10))
    return np.where(is_motion, number + np.uint8(_MOTIONS[0]), np.uint8(ord("G")))


class ShapeTable(dict[bytes, int]):
    """Shape to its index in ``shapes``, -1 for one that is not plain; each is read once."""

    def __init__(self, grammar: Grammar) -> None:
        super().__init__()
        self.grammar = grammar
        self.shapes: list[Shape] = []
        self._first: dict[tuple[str, int | None], int] = {}
        self._alike = np.array([-1])
        self._read = ShapeReader(grammar).read

    def may_have_fraction_behind_n(self) -> bool:
        """False where no line that was classified has a number such as that of ``N1.5``."""
        return any(map(_FRACTION_BEHIND_N.search, self))

    def alike(self) -> NDArray[np.intp]:
        """For each shape the first one with the same words in the same order.

        At the end stands -1, for lines that have no shape.
        """
        if len(self._alike) <= len(self.shapes):
            firsts = [self._first[shape.letters, shape.motion] for shape in self.shapes]
            self._alike = np.array([*firsts, -1])
        return self._alike

    def __missing__(self, shape: bytes) -> int:
        read = self._read(shape)
        index = -1
        if read is not None:
            index = len(self.shapes)
            self.shapes.append(read)
            self._first.setdefault((read.letters, read.motion), index)
        self[shape] = index
        return index


def classify(source: Source, table: ShapeTable, first: int, stop: int) -> NDArray[np.int32]:
    """For lines ``first`` to ``stop`` (exclusive) the index of the plain shape in ``table.shapes``, or -1."""
    parts = [_looked_up(text, table)[:count] for text, count in _texts(source, first, stop)]
    plain = np.concatenate(parts) if parts else np.empty(0, np.int32)
    plain[np.diff(source.starts[first : stop + 1]) > LONGEST_PLAIN] = -1
    return plain


def _looked_up(text: bytes, table: ShapeTable) -> NDArray[np.int32]:
    """The indices of the shapes in a text.

    Moves one behind the other mostly have one shape.  Such a row is looked up once, and its end is found by
    comparing; where rows turn out to be short, the shapes are looked up one by one.
    """
    rows: list[int] = []
    counts: list[int] = []
    at = 0
    lines = 0
    while lines >= _SHORT_ROW * (len(rows) - _FIRST_ROWS):
        end = text.find(b"\n", at) + 1
        if not end:
            break
        behind = _behind_row(text, at, end)
        rows.append(table[text[at : end - 1]])
        counts.append((behind - at) // (end - at))
        lines += counts[-1]
        at = behind
    shapes = text[at:].split(b"\n")
    rest = np.fromiter(map(table.__getitem__, shapes), np.int32, len(shapes))
    return np.concatenate((np.repeat(np.array(rows, np.int32), counts), rest))


def _behind_row(text: bytes, at: int, end: int) -> int:
    """Where a row of lines ends that are equal to the one from ``at`` to ``end``."""
    line = text[at:end]
    many = line * _TOGETHER
    while text.startswith(many, end):
        end += len(many)
    while text.startswith(line, end):
        end += len(line)
    return end
