"""A program of which long stretches are left out, and the file in which they stand.

What is left out stays in the file until it is written into another one, a block of bytes at a time, so a
program of any length takes the memory of what was kept.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator

import numpy as np

from chipbreak.text.long_file import LongFile
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source, UserLines, line_starts, read


class Kept(NamedTuple):
    """Lines that were kept: the first one's number in the file, from 0, its place there, and their bytes."""

    line: int
    start: int
    data: bytes
    line_count: int


class Gap(NamedTuple):
    """Lines that were left out before ``line`` of the excerpt: how many, from which byte of the file."""

    line: int
    start: int
    size: int
    line_count: int


class Excerpt(NamedTuple):
    """The lines of a program that were kept, as a program of its own, and the gaps between them."""

    whole: LongFile
    source: Source
    gaps: tuple[Gap, ...]

    def gaps_in(self, first: int, last: int) -> tuple[Gap, ...]:
        """The gaps before lines ``first`` to ``last``, that one included."""
        at = bisect_left(self.gaps, first, key=lambda gap: gap.line)
        return self.gaps[at : bisect_right(self.gaps, last, key=lambda gap: gap.line)]

    def file_place(self, line: int) -> int:
        """Where a line of the excerpt begins in the file, with the gap before it."""
        passed = sum(gap.size for gap in self.gaps[: bisect_left(self.gaps, line, key=lambda gap: gap.line)])
        return int(self.source.starts[line]) + passed

    def pieces(self, start: int, size: int, lines: int) -> Iterator[bytes]:
        """Bytes of the file, so many lines at a time; the last piece may have fewer.  Raises OSError."""
        rest = b""
        for block in self.whole.blocks(start, size):
            data = rest + block
            starts = line_starts(data)
            complete = (len(starts) - 2) // lines * lines  # the last line may go on
            for at in range(0, complete, lines):
                yield data[starts[at] : starts[at + lines]]
            rest = data[starts[complete] :]
        if rest:
            yield rest


def excerpt_of(whole: LongFile, kept: list[Kept], encoding: str) -> Excerpt:
    """The excerpt that these lines make, in order."""
    gaps: list[Gap] = []
    lines = 0
    line = 0
    place = 0
    for one in kept:
        if one.start > place:
            gaps.append(Gap(lines, place, one.start - place, one.line - line))
        lines += one.line_count
        line = one.line + one.line_count
        place = one.start + len(one.data)
    numbers = np.concatenate([np.arange(one.line, one.line + one.line_count) for one in kept]) + 1
    places = UserLines(None, numbers, np.zeros(len(numbers), np.int64))
    data = b"".join(one.data for one in kept)
    return Excerpt(whole, read(data, whole.name, places, encoding=encoding), tuple(gaps))
