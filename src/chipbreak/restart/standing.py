"""A program as it stands in its file, filtered or not: what it was, and what the control runs."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from chipbreak.editing.beside import with_brackets
from chipbreak.editing.restore import outermost, regions, restore
from chipbreak.editing.unroll import unrolled
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import State
from chipbreak.operations.main_program import MainProgram, main_program
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import parse
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source


class Standing(NamedTuple):
    """``file`` is the program as it stands, with its brackets where they are in a file beside it.

    Lines are counted from 0, those of ``file`` and of ``original``; users count those of :meth:`number`.

    ``original``  what was filtered;  ``main`` its main program
    ``runs``      what the control runs: ``file`` with the loops of vibrated cuts written out
    ``written``   the lines of ``file`` that chipbreak wrote, comments included
    ``places``    the line of ``file`` at which each line of ``original`` stands
    ``shifts``    (line of ``file``, how much further behind it a line stands in ``runs``), in order
    """

    file: Source
    original: InterpretedProgram
    main: MainProgram
    runs: InterpretedProgram
    written: tuple[range, ...]
    places: NDArray[np.int64]
    shifts: tuple[tuple[int, int], ...]

    def number(self, file_line: int) -> int:
        """The number of a line of ``file`` in the user's own one, from 1."""
        return self.file.place(file_line).line

    def line_of_number(self, number: int) -> int:
        """The line of ``file`` that is a line of the user's own one.  Raises ValueError where it has none."""
        user = self.file.user_lines
        count = (self.file if user is None or user.file is None else user.file).line_count
        if not 1 <= number <= count:
            raise ValueError(f"{self.file.name} has {count} lines, and no line {number}")
        if user is None:
            return number - 1
        return int(np.flatnonzero((user.numbers == number) & (user.shifts >= 0))[0])

    def numbers(self, lines: range) -> tuple[int, int]:
        """The numbers of the first and the last of some lines of ``file`` in the user's own one."""
        user = self.file.user_lines
        own = (line for line in reversed(lines) if user is None or user.shifts[line] >= 0)
        return self.number(lines.start), self.number(next(own, lines.start))

    def line_of(self, file_line: int) -> int:
        """The line of ``original`` that comes at, or next behind, a line of ``file``."""
        return int(np.searchsorted(self.places, file_line, "left"))

    def written_at(self, file_line: int) -> range | None:
        """What chipbreak wrote around a line of ``file``, None where it is the program's own."""
        at = bisect_right(self.written, file_line, key=lambda one: one.start) - 1
        return self.written[at] if at >= 0 and file_line in self.written[at] else None

    def runs_before(self, file_line: int) -> State:
        """What is in force before a line of ``file`` that no change stands around."""
        at = bisect_right(self.shifts, (file_line, 1 << 62)) - 1
        return self.runs.before(file_line + (self.shifts[at][1] if at >= 0 else 0))


def standing(data: bytes, settings: Settings, name: str, beside: bytes | None) -> Standing:
    """Read a program.  Raises ProgramRejectedError for a filtered part that somebody has edited."""
    file = with_brackets(data, name, beside)
    plain = file._replace(user_lines=None)
    written = tuple(outermost(plain))
    source = restore(plain)
    original = interpret_source(source, settings)
    found = regions(plain)
    expanded, moved = unrolled(plain, found, settings.dialect.loop)
    runs = interpret(parse(expanded, settings.dialect), original.settings)
    shifts = tuple((was.last, now.last - was.last) for was, now in zip(found, moved, strict=True))
    return Standing(file, original, main_program(original), runs, written, _places(source), shifts)


def _places(source: Source) -> NDArray[np.int64]:
    if source.user_lines is None:
        return np.arange(source.line_count, dtype=np.int64)
    return source.user_lines.numbers - 1
