"""The motion of an expanded cut, read back from the bytes that will be written.

Nothing here trusts the plan for what the blocks say: positions and times come from the text.  The plan only
tells which point of the path each block was meant to reach, so that the distance off the path and along it
can be told apart.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.toolpath import Path
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.repeated_dwells import repeated_dwells
from chipbreak.model.words import is_diameter, plain_value
from chipbreak.settings.axis_words import AXES
from chipbreak.syntax.columns import Repeats, read_columns, uniform_run
from chipbreak.units import S_PER_MIN

_SHORT_RUN = 16


@dataclass(frozen=True, eq=False)
class ReadBack:
    """Ends of the moves: ``points_mm`` (n, 3), how long each is, and its commanded feed, (n,) each.

    ``dwell_s`` is how long the tool dwells behind each (G4), (n,), empty where it never does.  ``strangers``
    counts moves that are no feed moves, which an expanded cut never has.
    """

    points_mm: Floats
    lengths_mm: Floats
    feed_mm_s: Floats
    dwell_s: Floats
    strangers: int = 0

    def along(self, path: Path, meant_mm: Floats) -> tuple[Floats, Floats]:
        """Distance along the path and off it [mm], (n,) each; ``meant_mm`` is where each block should end.

        Exact on straight paths; on arcs to second order in the rounding error.
        """
        offset = self.points_mm - path.points(meant_mm)
        tangents = path.tangents(meant_mm)
        ahead = np.einsum("ij,ij->i", offset, tangents)
        away = offset - ahead[:, None] * tangents
        return meant_mm + ahead, np.sqrt(np.einsum("ij,ij->i", away, away))


def read_moves(interpreted: InterpretedProgram, first: int, last: int) -> ReadBack:
    """All feed moves of lines ``first`` to ``last`` (exclusive), with the feed of each."""
    state = interpreted.before(first)
    moves = _Moves()
    line = first
    while line < last:
        run = uniform_run(interpreted.program, line, last)
        is_long = run - line >= _SHORT_RUN
        table = read_columns(interpreted.program, line, run, with_line_code=True) if is_long else None
        if table is not None:
            moves.add(state, *_table_moves(interpreted, state, *table))
            state = interpreted.skip(state, line, run)
            line = run
        else:
            effect = interpreted.interpreter.advance(state, interpreted.program.block(line))
            moves.add_effect(effect, interpreted)
            dwells = repeated_dwells(interpreted.program, effect, last, interpreted.settings)
            state = effect.after
            line += 1
            if dwells is not None:
                line = dwells[0].last
                moves.add_dwells(effect, *dwells, interpreted)
                state = interpreted.before(line)
    return moves.read_back()


class _Moves:
    """The moves read so far: ends, lengths, feeds; how long the tool dwells behind some; strangers."""

    def __init__(self) -> None:
        self.columns: tuple[list[Floats], list[Floats], list[Floats]] = ([], [], [])
        self.dwells: dict[int, float] = {}
        self.strangers = 0
        self.count = 0

    def add(self, state: State, ends: Floats, feed: Floats) -> None:
        """Moves between ``ends``, (n + 1, 3), with their feeds as in a state, (n,)."""
        moved = np.diff(ends, axis=0)
        lengths = np.sqrt(np.einsum("ij,ij->i", moved, moved))
        for column, values in zip(
            self.columns, (ends[1:], lengths, _feeds(state, feed, lengths)), strict=True
        ):
            column.append(values)
        self.count += len(feed)

    def add_effect(self, effect: BlockEffect, interpreted: InterpretedProgram) -> None:
        """What one block does."""
        if effect.move is not None and effect.move.is_cut:
            ends = _clean(np.array([effect.move.start, effect.move.end]))
            feed = np.array([effect.after.feed.value if effect.after.feed else np.nan])
            self.add(effect.after, ends, feed)
        elif effect.move is not None:
            self.strangers += 1
        elif "dwell" in effect.non_modal and self.count:  # before the first move it is no part of the cut
            last = self.count - 1
            self.dwells[last] = self.dwells.get(last, 0.0) + _dwell_of(interpreted, effect)

    def add_dwells(
        self, effect: BlockEffect, found: Repeats, ends_mm: Floats, interpreted: InterpretedProgram
    ) -> None:
        """The moves between dwells like a first one, which is counted already."""
        state = effect.after
        before = self.count
        feed = np.full(len(ends_mm) - 1, state.feed.value if state.feed else np.nan)
        self.add(state, _clean(ends_mm), feed)
        each_s = _dwell_of(interpreted, effect)
        for count in (found.before[1:] + before - 1).tolist():
            self.dwells[count] = self.dwells.get(count, 0.0) + each_s

    def read_back(self) -> ReadBack:
        """All of them."""
        if not self.count:
            return ReadBack(np.empty((0, 3)), np.empty(0), np.empty(0), np.empty(0), self.strangers)
        dwell_s = np.zeros(self.count if self.dwells else 0)
        dwell_s[list(self.dwells)] = list(self.dwells.values())
        points_mm, lengths_mm, feed_mm_s = map(np.concatenate, self.columns)
        return ReadBack(points_mm, lengths_mm, feed_mm_s, dwell_s, self.strangers)


def _dwell_of(interpreted: InterpretedProgram, effect: BlockEffect) -> float:
    """The seconds of a G4 block as this control reads them."""
    dialect = interpreted.settings.dialect
    word = effect.block.word(dialect.dwell_word)
    return plain_value(word) / dialect.dwells_per_s if word is not None else math.nan


def _table_moves(
    interpreted: InterpretedProgram, state: State, letters: str, numbers: Floats
) -> tuple[Floats, Floats]:
    """Start and ends of the moves of a table, (n + 1, 3), and their feeds as in a state, (n,)."""
    settings = interpreted.settings
    words = interpreted.settings.axis_words
    start = _clean(np.array([state.position]))
    points = np.tile(start, (len(numbers), 1))
    incremental = state.modes.distance == "incremental"
    for column, letter in enumerate(letters):
        name = words.axes.get(letter, "")
        if name not in words.signs:
            continue
        values = numbers[:, column] * (state.mm_per_unit * words.signs[name])
        if name == "X" and is_diameter(state, settings.control):
            values = values / 2.0
        axis = AXES.index(name)
        is_distance = incremental or letter in words.distances
        points[:, axis] = start[0, axis] + np.cumsum(values) if is_distance else values
    if "F" in letters:
        is_length = state.modes.feed_mode != "inverse"
        feeds = numbers[:, letters.index("F")] * (state.mm_per_unit if is_length else 1.0)
    else:
        feeds = np.full(len(numbers), state.feed.value if state.feed else np.nan)
    return np.concatenate((start, points)), feeds


def _clean(points: Floats) -> Floats:
    """Axes that cannot be known and do not move count as 0."""
    return np.nan_to_num(points, nan=0.0)


def _feeds(state: State, feed: Floats, lengths_mm: Floats) -> Floats:
    """The feeds [mm/s], (n,), of feeds as in a state."""
    mode = state.modes.feed_mode
    feeds = (lengths_mm * feed if mode == "inverse" else feed) / S_PER_MIN
    if mode == "rev":
        feeds = feeds * (state.speed.value if state.speed else np.nan)
    return feeds
