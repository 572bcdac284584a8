"""Which lines of a long file decide what becomes of it: the others are left out.

Left out is the middle of a long run of plain motion.  What a program does about such a run it does at its
ends: before its first cut and behind its last one.  So of a run are kept its lines up to the first cut and
``around`` more, those from ``around`` before its last cut on, and of the middle the last line of each kind:
these leave the same place, feed and motion code in force as all the lines.  Every line that is more than
plain motion is kept.  The file is read once, a piece at a time.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from chipbreak.dialects import Dialect
from chipbreak.syntax.grammar import grammar_of
from chipbreak.syntax.shapes import ShapeTable, bits_of, classify
from chipbreak.text.encoding import LATIN_1, encoding_of
from chipbreak.text.excerpt import Excerpt, Kept, excerpt_of
from chipbreak.text.long_file import LongFile
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source, line_starts

PIECE_BYTES = 1 << 20
# Of a file that is not mostly plain motion an excerpt is no help.
_MOST_KEPT_BYTES = 1 << 24
_MOST_KEPT_SHARE = 0.25
_MOVES = bits_of("XYZUVWABCIJK")
_RAPID = 0
_NOT_SAID = -1
_MOTIONS = range(4)
_COMMENT = re.compile(rb"\([^)]*\)?|;.*")
_CODE = re.compile(rb"[Gg][ \t]*0*(\d{1,3})")
# Codes of other motions: cycles, threads, probing.
_OTHER_MOTIONS = frozenset({33, 38, *range(73, 90)})


def read_long(
    whole: LongFile, dialect: Dialect, around: int, piece_bytes: int = PIECE_BYTES
) -> Excerpt | None:
    """The excerpt of a file; None where it would leave out too little, or cannot be made.

    Raises OSError.
    """
    reader = _Reader(ShapeTable(grammar_of(dialect)), around)
    for block in whole.blocks(0, whole.size, piece_bytes):
        if not reader.read(block):
            return None
    if not reader.read(b"", is_last=True):
        return None
    # N1.5 may be meant for a wish, and then each such line must be asked.
    if not reader.has_gaps or reader.table.may_have_fraction_behind_n():
        return None
    return excerpt_of(whole, reader.kept, encoding_of(b"".join(one.data for one in reader.kept)))


class _Lines(NamedTuple):
    """Some lines of the file: their bytes, where each begins, and the shape of each, -1 for special ones.

    Behind them may stand the beginning of another one.
    """

    data: bytes
    starts: NDArray[np.int64]
    ids: NDArray[np.int32]

    def raw(self, first: int, last: int) -> bytes:
        return self.data[self.starts[first] : self.starts[last]]


_NO_LINES = _Lines(b"", np.zeros(1, np.int64), np.empty(0, np.int32))


class _Reader:
    """Reads pieces, and keeps what is not left out.

    ``lines`` are those at hand; the first of them is line ``line`` of the file and begins at ``place``.
    Those before ``at`` are decided; ``mode`` is the motion in force before the next run, as far as it shows.
    ``lasts`` are the last lines of each kind of what a run that goes on has left out, None where none does.
    """

    def __init__(self, table: ShapeTable, around: int) -> None:
        self.table = table
        self.around = around
        self.kept: list[Kept] = []
        self.kept_bytes = 0
        self.has_gaps = False
        self.lines = _NO_LINES
        self.line = 0
        self.place = 0
        self.at = 0
        self.mode = _NOT_SAID
        self.lasts: dict[int, Kept] | None = None

    def read(self, block: bytes, *, is_last: bool = False) -> bool:
        """The next bytes of the file; False where it must be read whole."""
        self._take(block, is_last=is_last)
        if b"\r" in self.lines.data and self._has_lone_returns():
            return False
        count = len(self.lines.ids)
        first = 0
        for stop in np.flatnonzero(self.lines.ids < 0).tolist():
            self._closed(first, stop)
            self._pass(self.lines.raw(stop, stop + 1))
            first = stop + 1
        if is_last:
            self._closed(first, count)
            self._keep(count)
        else:
            self._open(first, count)
        rest = len(self.lines.data) - int(self.lines.starts[self.at])
        share_bytes = _MOST_KEPT_SHARE * (self.place + len(self.lines.data))
        return self.kept_bytes + rest < max(_MOST_KEPT_BYTES, share_bytes)

    def _has_lone_returns(self) -> bool:
        """True where a line ends with CR alone, as on some controls."""
        data = self.lines.data[: self.lines.starts[-1]]
        return data.count(b"\r") != data.count(b"\r\n")

    def _take(self, block: bytes, *, is_last: bool) -> None:
        """The next lines behind those that are not decided yet."""
        decided = int(self.lines.starts[self.at])
        self.line += self.at
        self.place += decided
        self.at = 0
        data = self.lines.data[decided:] + block
        starts = line_starts(data)
        if data and not (is_last or data.endswith(b"\n")):
            starts = starts[:-1]
        count = len(starts) - 1
        source = Source(data, "", starts, b"\n", range(count), LATIN_1)
        self.lines = _Lines(data, starts, classify(source, self.table, 0, count))

    def _keep(self, stop: int) -> None:
        """Keep the lines up to one that are not decided."""
        if stop > self.at:
            self._add(self._kept(self.at, stop))
            self.at = stop

    def _kept(self, first: int, stop: int) -> Kept:
        place = self.place + int(self.lines.starts[first])
        return Kept(self.line + first, place, self.lines.raw(first, stop), stop - first)

    def _add(self, kept: Kept) -> None:
        self.kept.append(kept)
        self.kept_bytes += len(kept.data)

    def _closed(self, first: int, stop: int) -> None:
        """A run of plain lines, or its end."""
        if first < stop:
            modes = self._modes(first, stop)
            self._leave_out_middle(first, stop, modes)
            self.mode = int(modes[-1])
        if self.lasts is not None:
            for kept in sorted(self.lasts.values()):
                self._add(kept)
            self.lasts = None

    def _open(self, first: int, stop: int) -> None:
        """A run of plain lines that may go on: where its end begins is not known yet."""
        self._keep(first)
        if first < stop:
            modes = self._modes(first, stop)
            self._leave_out_middle(first, stop, modes)
            if self.at > first:
                self.mode = int(modes[self.at - first - 1])

    def _modes(self, first: int, stop: int) -> NDArray[np.int8]:
        """The motion in force on each line of a run."""
        motions = (one.motion for one in self.table.shapes)
        said = np.array([_NOT_SAID if motion is None else motion for motion in motions], np.int8)
        modes = np.concatenate((np.array([self.mode], np.int8), said[self.lines.ids[first:stop]]))
        at = np.arange(len(modes))
        at[modes == _NOT_SAID] = 0
        return modes[np.maximum.accumulate(at)][1:]

    def _leave_out_middle(self, first: int, stop: int, modes: NDArray[np.int8]) -> None:
        """Leave out what lies between the lines around the first cut of a run and those around its last."""
        moving = np.array([bool(one.bits & _MOVES) for one in self.table.shapes])
        cuts = np.flatnonzero((modes != _RAPID) & moving[self.lines.ids[first:stop]])
        if not len(cuts):
            return
        begin = first if self.lasts is not None else first + int(cuts[0]) + self.around + 1
        end = first + int(cuts[-1]) - self.around
        if begin >= end:
            return
        self._keep(begin)
        self._note_lasts(begin, end)
        self.has_gaps = True
        self.at = end

    def _note_lasts(self, first: int, stop: int) -> None:
        """The last of these lines of each kind: with the same letters and the same motion code."""
        self.lasts = {} if self.lasts is None else self.lasts
        last = np.full(len(self.table.shapes), -1)
        last[self.lines.ids[first:stop]] = np.arange(first, stop)  # of equal shapes the last one counts
        found: dict[int, int] = {}
        for shape, line in zip(self.table.shapes, last.tolist(), strict=True):
            if line >= 0:
                kind = shape.bits << 3 | (shape.motion or 0)
                found[kind] = max(line, found.get(kind, -1))
        self.lasts |= {kind: self._kept(line, line + 1) for kind, line in found.items()}

    def _pass(self, special: bytes) -> None:
        """The motion in force behind a line that is more than plain motion, as far as it shows."""
        for code in map(int, _CODE.findall(_COMMENT.sub(b"", special))):
            if code in _MOTIONS:
                self.mode = code
            elif code in _OTHER_MOTIONS:
                self.mode = _NOT_SAID
