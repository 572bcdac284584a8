"""The shape of a line: its text with every run of digits made one mark.

``N120 X10.5 Y-3.25`` and ``N125 X7.0 Y-12.`` have one shape, and a program of a million blocks has a few
hundred.  So each shape is read once; a line whose shape is a plain motion block needs no more.  The digits
of a G word stay, so that G1 and G10 have different shapes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chipbreak.source import Source
from chipbreak.syntax.grammar import terminals

PLAIN_LETTERS = "XYZUVWABCIJKRF"
# A longer line gets a closer look; in a shorter one every number is finite.
LONGEST_PLAIN = 255
_DIGITS = b"0123456789"
_CHUNK_BYTES = 1 << 20
# Digits become NUL; a real NUL becomes SOH, which no plain block has.
_TO_SHAPE = bytes.maketrans(_DIGITS + b"\0", b"\0" * 10 + b"\1")
_IS_DIGIT = np.isin(np.arange(256), np.frombuffer(_DIGITS, np.uint8))


class Shape(NamedTuple):
    """A plain motion block: at most one of G0 to G3, then words of ``PLAIN_LETTERS``, each once.

    ``has_points`` is True when each of these words has a decimal point.
    """

    letters: str
    motion: int | None
    has_points: bool


@lru_cache(maxsize=1)
def _shape_patterns() -> tuple[re.Pattern[bytes], re.Pattern[bytes]]:
    """The plain block as a shape, from the grammar's own number; other blanks than these are rare enough."""
    blank = r"[ 	]*+"  # possessive: a long run of blanks must not be tried twice
    number = terminals()["NUMBER"].replace("[0-9]+", r"\x00").replace("[0-9]*", r"\x00?")
    word = f"[{PLAIN_LETTERS}]{blank}{number}{blank}"
    head = rf"{blank}(?:N{blank}{number}{blank})?(?:G0?([0-3]){blank})?"
    return re.compile(f"{head}((?:{word})+)".encode("latin-1")), re.compile(f"[{PLAIN_LETTERS}]".encode())


def read_shape(shape: bytes) -> Shape | None:
    """The plain block that a shape stands for, or None when the line needs a closer look."""
    if len(shape) > LONGEST_PLAIN:
        return None
    whole, letter = _shape_patterns()
    match = whole.fullmatch(shape)
    if match is None:
        return None
    letters = b"".join(letter.findall(match[2])).decode("ascii")
    if len(set(letters)) != len(letters):
        return None
    motion = None if match[1] is None else int(match[1])
    return Shape(letters, motion, match[2].count(b".") == len(letters))


def line_shapes(source: Source, first: int, stop: int) -> Iterator[list[bytes]]:
    """The shapes of lines ``first`` to ``stop`` (exclusive), in order, a chunk of lines at a time."""
    while first < stop:
        limit = source.starts[first] + _CHUNK_BYTES
        last = max(first + 1, int(np.searchsorted(source.starts, limit, "right")) - 1)
        last = min(last, stop)
        shapes = _chunk_shapes(source.data[source.starts[first] : source.starts[last]])
        yield shapes[: last - first]
        first = last


def _chunk_shapes(data: bytes) -> list[bytes]:
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    raw = np.frombuffer(data, np.uint8)
    marks = np.frombuffer(data.translate(_TO_SHAPE), np.uint8).copy()
    at = np.flatnonzero(raw == ord("G")) + 1
    for _ in range(2):
        at = at[at < len(raw)]
        at = at[_IS_DIGIT[raw[at]]]
        marks[at] = raw[at]
        at = at + 1
    is_mark = marks == 0
    keep = np.ones(len(marks), np.bool_)
    np.logical_and(is_mark[1:], is_mark[:-1], out=keep[1:])
    np.logical_not(keep[1:], out=keep[1:])
    return marks[keep].tobytes().split(b"\n")


class ShapeTable(dict[bytes, int]):
    """Shape to its index in ``shapes``, -1 for one that is not plain; each is read once."""

    def __init__(self) -> None:
        super().__init__()
        self.shapes: list[Shape] = []

    def __missing__(self, shape: bytes) -> int:
        read = read_shape(shape)
        index = -1
        if read is not None:
            index = len(self.shapes)
            self.shapes.append(read)
        self[shape] = index
        return index


def classify(source: Source, table: ShapeTable, first: int, stop: int) -> NDArray[np.int32]:
    """For lines ``first`` to ``stop`` (exclusive) the index of the plain shape in ``table.shapes``, or -1."""
    chunks = line_shapes(source, first, stop)
    parts = [np.array(list(map(table.__getitem__, chunk)), np.int32) for chunk in chunks]
    plain = np.concatenate(parts) if parts else np.empty(0, np.int32)
    plain[np.diff(source.starts[first : stop + 1]) > LONGEST_PLAIN] = -1
    return plain
