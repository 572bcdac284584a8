"""Bytes to lines and back: nothing is decoded strictly, nothing is normalised.

A line keeps its own end (LF, CRLF, CR, or the LF CR CR of punched tape).  What stands before the first ``%``
and after the last one is read by no control: it is leader and trailer, outside ``body``, and passes through.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chipbreak.text.encoding import LATIN_1, encoding_of, meant
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.span import Place

LF = 10
CR = 13
TAPE_END = b"\n\r\r"
# Every line end that may be in a program with such ends, the longest first.
TAPE_LINE_END = re.compile(rb"\n\r\r|\r\n|\n|\r")
_PIECE_BYTES = 1 << 17
# What controls read past: the bytes of BLANK in grammar/iso.lark.
BLANKS = b" \t\0\x0b\x0c\x1a\x7f\xef\xbb\xbf"


class Source(NamedTuple):
    """A program as bytes, cut into lines.

    ``starts`` holds n + 1 offsets: line i, with its line end, is ``data[starts[i]:starts[i + 1]]``.
    ``body`` is the range of lines a control reads.  ``encoding`` is what its bytes mean to people.
    ``user_lines`` says where the lines stand in the user's file when that is another one (a program that was
    filtered before is put back first).
    """

    data: bytes
    name: str
    starts: NDArray[np.int64]
    line_end: bytes
    body: range
    encoding: str = LATIN_1
    user_lines: UserLines | None = None

    def __repr__(self) -> str:
        return f"<Source {self.name!r}: {self.line_count} lines>"

    @property
    def line_count(self) -> int:
        """How many lines there are; a last line without an end counts."""
        return len(self.starts) - 1

    def raw(self, line: int) -> bytes:
        """Line with its end."""
        return self.data[self.starts[line] : self.starts[line + 1]]

    def text(self, line: int) -> str:
        """Line without its end, one character a byte (latin-1)."""
        return self._bare(line).decode("latin-1")

    def _bare(self, line: int) -> bytes:
        return self.raw(line).rstrip(b"\r\n")

    def place(self, line: int, start: int = 0, end: int | None = None) -> Place:
        """Where characters ``start`` to ``end`` of a line stand in the user's file."""
        number = line + 1
        stop = len(self._bare(line)) if end is None else end
        if self.user_lines is not None:
            number = int(self.user_lines.numbers[line])
            shift = int(self.user_lines.shifts[line])
            start, stop = (start + shift, stop + shift) if shift >= 0 else (0, len(self.shown(line)))
        return Place(self.name, number, start + 1, max(stop, start + 1) + 1)

    def shown(self, line: int) -> str:
        """The line of the user's file to which :meth:`place` points."""
        if self.user_lines is None or self.user_lines.file is None:
            return self.text(line)
        return self.user_lines.file.text(int(self.user_lines.numbers[line]) - 1)

    def meant(self, text: str) -> str:
        """Text of the program as its encoding means it, for messages."""
        return meant(text, self.encoding)


class UserLines(NamedTuple):
    """Where the lines of a program stand in the user's ``file``, None where they are its very lines.

    ``numbers`` are those of lines, from 1.  ``shifts`` are the characters before a line's own text there, -1
    where the user's line is another text altogether.
    """

    file: Source | None
    numbers: NDArray[np.int64]
    shifts: NDArray[np.int64]


def user_lines(source: Source, first: int, last: int) -> UserLines:
    """Where lines ``first`` to ``last`` (exclusive) stand in the user's file."""
    if source.user_lines is None:
        return UserLines(source, np.arange(first, last) + 1, np.zeros(last - first, np.int64))
    file, numbers, shifts = source.user_lines
    return UserLines(file, numbers[first:last], shifts[first:last])


def in_a_row(pieces: Sequence[UserLines]) -> UserLines:
    """The lines of all pieces, at least one, of one file."""
    _, numbers, shifts = zip(*pieces, strict=True)
    return UserLines(pieces[0].file, np.concatenate(numbers), np.concatenate(shifts))


def read(
    data: bytes, name: str = "<stdin>", user_lines: UserLines | None = None, *, encoding: str = ""
) -> Source:
    """Cut bytes into lines.  Any bytes are a program; nothing is refused here.

    ``encoding`` is what the bytes mean where it is known; without it, it is guessed.
    """
    starts = line_starts(data)
    encoding = encoding or encoding_of(data)
    return Source(data, name, starts, _usual_end(data, starts), _body(data, starts), encoding, user_lines)


def line_starts(data: bytes) -> NDArray[np.int64]:
    """Where lines begin, and behind them where the last one ends."""
    array = np.frombuffer(data, np.uint8)
    after_end = _behind(array, LF)
    if has_tape_ends(data):
        after_end = np.array([match.end() for match in TAPE_LINE_END.finditer(data)], np.int64)
    elif b"\r" in data:
        returns = _behind(array, CR)
        lone = returns[np.append(array, 0)[returns] != LF]
        after_end = np.sort(np.concatenate((after_end, lone)))
    starts = np.concatenate((np.zeros(1, np.int64), after_end))
    return starts if starts[-1] == len(data) else np.append(starts, len(data))


def has_tape_ends(data: bytes) -> bool:
    """True where the first line ends with LF CR CR: CR before LF is another matter (CR CR LF)."""
    first = data.find(b"\n")
    return first >= 0 and data.startswith(TAPE_END, first) and data.find(b"\r", 0, first) < 0


def _behind(array: NDArray[np.uint8], byte: int) -> NDArray[np.int64]:
    """The places behind each such byte; a piece at a time, so that the pieces stay in the cache."""
    pieces = range(0, len(array), _PIECE_BYTES)
    places = [np.flatnonzero(array[at : at + _PIECE_BYTES] == byte) + (at + 1) for at in pieces]
    return np.concatenate(places) if places else np.empty(0, np.int64)


def _usual_end(data: bytes, starts: NDArray[np.int64]) -> bytes:
    """The line end new blocks take: the most frequent one among the first lines.

    A lone CR is taken only where nothing else is found: controls that read LF do not see it (CR CR LF).
    """
    ends: Counter[bytes] = Counter()
    for line in range(min(len(starts) - 1, 1000)):
        raw = data[max(starts[line], starts[line + 1] - 3) : starts[line + 1]]
        ends[raw[len(raw.rstrip(b"\r\n")) :]] += 1
    if has_tape_ends(data):
        return TAPE_END
    if not ends[b"\n"] and not ends[b"\r\n"]:
        return b"\r" if ends[b"\r"] else b"\n"
    return b"\r\n" if ends[b"\r\n"] > ends[b"\n"] else b"\n"


def _body(data: bytes, starts: NDArray[np.int64]) -> range:
    """Lines between the first and the last ``%``.

    With one ``%`` only, it starts the program when nothing but blanks stands before it, and ends it when
    nothing but blanks stands behind it.  With text on both sides nobody can say, and all lines are read.
    """
    count = len(starts) - 1
    marks = _mark_lines(data, starts)
    if not marks:
        return range(count)
    if len(marks) == 1:
        only = marks[0]
        blanks = BLANKS + b"\r\n"
        if not data[: starts[only]].strip(blanks):
            return range(only, count)
        return range(count) if data[starts[only + 1] :].strip(blanks) else range(only + 1)
    return range(marks[0], marks[-1] + 1)


def _mark_lines(data: bytes, starts: NDArray[np.int64]) -> list[int]:
    """Lines whose first character that is no blank is ``%``."""
    marks = []
    at = data.find(b"%")
    while at >= 0:
        line = int(np.searchsorted(starts, at, "right")) - 1
        if not data[starts[line] : at].strip(BLANKS):
            marks.append(line)
        at = data.find(b"%", int(starts[line + 1]))
    return marks
