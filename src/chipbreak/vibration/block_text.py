"""The blocks of a vibrated cut as text and tables: axis words, feeds, dwells, loops."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from chipbreak.dialects import Dialect
from chipbreak.editing.edits import MoveTable
from chipbreak.kinematics.floats import Floats
from chipbreak.model.giving_back import feed_text
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.dwell import dwell_block
from chipbreak.vibration.forms import OutputForm
from chipbreak.vibration.loop import Loop

# More than anybody writes of a position; what a program wrote in fewer comes back as it was.
END_DECIMALS = 8
_CODE = "G1 "


@dataclass(frozen=True, eq=False)
class Words:
    """Axis words of every knot, in program units, rounded; (n, axes).

    ``letters`` are for the places themselves, or for distances where the cut is ``incremental``;
    ``distance_letters`` are those of loops.  The last row is the programmed end, with all its digits.
    """

    letters: tuple[str, ...]
    absolute: Floats
    points_mm: Floats
    decimals: int
    incremental: bool
    distance_letters: tuple[str, ...]
    loops: Sequence[Loop]


@dataclass(frozen=True, eq=False)
class Columns:
    """What the blocks say: axis words, how long the tool dwells behind each, (n,), and its F, (n,).

    ``dwell_s`` is empty where the tool never dwells.  Without ``feeds`` all blocks have the feed that the
    program gives them.
    """

    words: Words
    dwell_s: Floats
    form: OutputForm
    feeds: Floats | None = None
    feed_decimals: int = 0

    def table(self, letters: Sequence[str], axis_columns: Floats) -> MoveTable:
        """All blocks; ``letters`` as they are written, ``axis_columns`` (n, axes)."""
        columns = tuple(axis_columns.T)
        decimals = (self.words.decimals,) * len(letters)
        if self.feeds is None:
            return MoveTable(tuple(letters), columns, decimals)
        return MoveTable((*letters, "F"), (*columns, self.feeds), (*decimals, self.feed_decimals))


def block_text(
    columns: Columns, chain: Chain, settings: Settings, *, plain_end: bool
) -> tuple[str | MoveTable, ...]:
    """First and last block as text, the rest as tables, the loops between their lines.

    With ``plain_end`` the last block has the program's own F, in its own text.
    """
    words = columns.words
    places = np.diff(words.absolute, axis=0) if words.incremental else words.absolute[1:]
    table = columns.table(_written(words.letters, settings.dialect), places)
    last = len(table) - 1
    code = "" if settings.dialect.repeats_codes else _CODE
    text: list[str | MoveTable] = [code + _row(table if last else _with_all_digits(table, words), 0)]
    if columns.feeds is None:
        assert chain.before.feed is not None
        text[0] = f"{text[0]} F{feed_text(chain.before)}"
    dwells = _Dwells(columns.dwell_s, settings.dialect)
    text += dwells.behind(0)
    at = 1
    for loop, passes in zip(words.loops, _passes(columns, dwells, settings), strict=True):
        text += [*dwells.rows(table, at, loop.first), *passes]
        at = loop.stop
    text += dwells.rows(table, at, last)
    if last:
        is_own = plain_end and columns.feeds is not None
        end = _with_all_digits(table, words)
        text.append(_row(end, last, feed_text(chain.after) if is_own else ""))
        text += dwells.behind(last)
    return tuple(text)


def _written(letters: Sequence[str], dialect: Dialect) -> list[str]:
    """The letters as they stand in a block, with the code in front where each block says it."""
    written = [letter + dialect.set_off for letter in letters]
    return [_CODE + written[0], *written[1:]] if dialect.repeats_codes else written


def _passes(columns: Columns, dwells: _Dwells, settings: Settings) -> Iterator[list[str | MoveTable]]:
    """The blocks of one pass of each loop, between the lines that repeat them."""
    words = columns.words
    if not words.loops:
        return
    letters = _written(words.distance_letters, settings.dialect)
    table = columns.table(letters, np.diff(words.absolute, axis=0))
    switch = _switch(words, settings)
    for number, loop in enumerate(words.loops):
        before, behind = columns.form.lines(number, loop.passes)
        blocks = dwells.rows(table, loop.first, loop.first + loop.count)
        yield [*switch[:1], *before, *blocks, *behind, *switch[1:]]


@dataclass(frozen=True, eq=False)
class _Dwells:
    """The dwells behind the blocks that move."""

    dwell_s: Floats
    dialect: Dialect

    def behind(self, row: int) -> list[str]:
        """The dwell behind one block, if there is one."""
        dwell_s = float(self.dwell_s[row]) if len(self.dwell_s) else 0.0
        return [dwell_block(dwell_s, self.dialect)] if dwell_s > 0.0 else []

    def rows(self, table: MoveTable, first: int, stop: int) -> list[MoveTable]:
        """Rows in tables, each of which has the same dwell behind every row."""
        if stop <= first:
            return []
        if not self.dwell_s[first:stop].any():
            return [table.rows(first, stop)]
        changes = first + 1 + np.flatnonzero(np.diff(self.dwell_s[first:stop]))
        bounds = pairwise([first, *changes.tolist(), stop])
        return [replace(table.rows(a, b), behind="".join(self.behind(a))) for a, b in bounds]


def _with_all_digits(table: MoveTable, words: Words) -> MoveTable:
    """The table, its positions printed with all the digits that they have."""
    if words.incremental:
        return table
    axes = len(words.letters)
    return replace(table, decimals=(*[END_DECIMALS] * axes, *table.decimals[axes:]))


def _switch(words: Words, settings: Settings) -> list[str]:
    """The blocks that switch to distances and back, where other letters do not say it."""
    if words.incremental or words.distance_letters != words.letters:
        return []
    return [settings.dialect.code("distance", way) for way in ("incremental", "absolute")]


def _row(table: MoveTable, row: int, feed: str = "") -> str:
    """One block; with ``feed`` that is its F."""
    words = [
        letter + print_number(float(column[row]), decimals)
        for letter, column, decimals in zip(table.letters, table.columns, table.decimals, strict=True)
    ]
    if feed:
        words[-1] = f"F{feed}"
    return " ".join(words)
