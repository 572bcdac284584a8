"""What a pass may do: replace some lines by others, with a reason.  One function applies all edits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from chipbreak.editing.promise import Promise
from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.record import Record


class MoveTable(Record):
    """Many moves as columns of numbers, one row a block.

    ``letters[i]``, such as ``Z`` or ``Z=``, is printed before ``columns[i]`` (shape (n,), program units) with
    ``decimals[i]`` places.
    ``behind`` is a block of its own behind every row; empty for none.
    """

    letters: tuple[str, ...]
    columns: tuple[Floats, ...]
    decimals: tuple[int, ...]
    behind: str = ""

    def __repr__(self) -> str:
        return f"<MoveTable {' '.join(self.letters)}: {len(self)} rows>"

    def __len__(self) -> int:
        return len(self.columns[0])

    def rows(self, first: int, stop: int) -> MoveTable:
        """The same with rows ``first`` to ``stop`` (exclusive) only."""
        return replace(self, columns=tuple(column[first:stop] for column in self.columns))


class Edit(NamedTuple):
    """Lines ``first`` to ``last`` (exclusive) of the original become ``content``; first == last inserts.

    ``title`` names the change in the program itself, ``reason`` explains it to the user, ``promise`` is what
    must hold of it in the bytes that were written.  ``pass_name`` is filled in by who asked the pass.
    ``duration_s`` is about how long the programs take that the edit calls, None where nobody knows;
    ``otherwise_s`` are settings, as they are written, with which they would take another time.
    ``keeps_number``: the number of the first block stays where it was, for what looks for it.
    """

    first: int
    last: int
    content: tuple[str | MoveTable, ...]
    title: str
    reason: str
    promise: Promise
    pass_name: str = ""
    duration_s: float | None = None
    otherwise_s: tuple[tuple[str, float], ...] = ()
    keeps_number: bool = True

    def __repr__(self) -> str:
        return f"<Edit of {self.pass_name or 'no pass yet'}, lines {self.first} to {self.last}: {self.title}>"


class OverlapError(SelfCheckError):
    """Two passes want to change the same lines: a fault of this program, not of the user's."""

    def __init__(self, one: Edit, other: Edit) -> None:
        super().__init__(one, other)
        self.one = one
        self.other = other

    def __str__(self) -> str:
        one, other = (f"{e.pass_name} (lines {e.first + 1} to {e.last})" for e in (self.one, self.other))
        return f"{one} and {other} change the same lines"


def in_order(edits: Sequence[Edit]) -> list[Edit]:
    """Edits by place; insertions stand before a replacement at the same line, in the order given.

    Raises OverlapError.
    """
    ordered = sorted(edits, key=lambda e: (e.first, e.last > e.first))
    for one, other in pairwise(ordered):
        if other.first < one.last:
            raise OverlapError(one, other)
    return ordered
