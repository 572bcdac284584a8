"""A cut in which the tool dwells again and again: one dwell, a move, the same dwell, a move.

What such a dwell does is worked out once, and where the moves between end at once for all of them: block by
block the same would take twenty times as long.  A test holds the two equal.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.modal import Position, State
from chipbreak.model.words import is_diameter
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.columns import Repeats, repeats
from chipbreak.syntax.parse import Program

_DWELLS = frozenset({"dwell"})
_FOLLOWED = ("rapid", "line")


def repeated_dwells(
    program: Program, effect: BlockEffect, last: int, settings: Settings
) -> tuple[Repeats, Floats] | None:
    """The stretch from a dwell (at most to line ``last``) in which it comes again, and where its moves end.

    These are the place at its start and one for each plain line, (n + 1, 3).  None where the block is no
    dwell, says anything else, or moves are not plain places and distances.
    """
    if not _only_dwells(effect):
        return None
    found = repeats(program, effect.block.line, last)
    if found is None or not settings.axis_words.signs.keys() >= _axes(found, settings):
        return None
    if found.says_line and effect.after.modes.motion != "line":
        return None
    return found, _ends_mm(effect.after, found, settings)


def effects_of(
    program: Program, effect: BlockEffect, found: Repeats, ends_mm: Floats
) -> Iterator[BlockEffect]:
    """What the dwells of such a stretch do, from the second one on."""
    places = ends_mm.tolist()
    lines, before = found.repeated.tolist(), found.before.tolist()
    for line, count in zip(lines[1:], before[1:], strict=True):
        state = effect.after._replace(position=Position(*places[count]))
        yield effect._replace(block=program.block(line), before=state, after=state)


def _only_dwells(effect: BlockEffect) -> bool:
    block = effect.block
    is_more = block.comments or block.controls or block.assignments or block.sequence or block.skip
    if is_more or effect.non_modal != _DWELLS or effect.move is not None or effect.functions:
        return False
    state = effect.after
    return effect.before == state and state.modes.motion in _FOLLOWED and not state.ended


def _axes(found: Repeats, settings: Settings) -> set[str]:
    """The axes of its moves; one without a name for a letter that is none."""
    return {settings.axis_words.axes.get(letter, "") for letter in found.letters}


def _ends_mm(state: State, found: Repeats, settings: Settings) -> Floats:
    """Where the moves of a stretch end, which begins in a state: added up one by one, as a control does."""
    words = settings.axis_words
    ends_mm = np.tile(np.array(state.position), (len(found.numbers) + 1, 1))
    for column, letter in enumerate(found.letters):
        name = words.axes[letter]
        values = found.numbers[:, column] * state.mm_per_unit * words.signs[name]
        if name == "X" and is_diameter(state, settings.control):
            values = values / 2.0
        ends_mm[1:, AXES.index(name)] = values
        if state.modes.distance == "incremental" or letter in words.distances:
            ends_mm[:, AXES.index(name)] = np.cumsum(ends_mm[:, AXES.index(name)])
    return ends_mm
