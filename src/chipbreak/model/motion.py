"""Where a block's axis words take the tool."""

from __future__ import annotations

import math
from collections.abc import Sequence

from chipbreak.model.modal import Position, State
from chipbreak.model.steps import Move
from chipbreak.model.words import is_diameter, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word

AXES = "XYZ"
_STRAIGHT = ("rapid", "line", "cw", "ccw", "thread", "spline")
_KNOWN = ("rapid", "line", "cw", "ccw", "thread")


def move_of(
    block: Block, state: State, axis_words: Sequence[Word], settings: Settings, once: frozenset[str]
) -> Move:
    """The motion of a block.  Ends are NaN where a value or a start cannot be known."""
    dialect, control = settings.dialect, settings.control
    ends = dict(zip(AXES, state.position, strict=True))
    starts = dict(ends)
    incremental = state.modes.get("distance") == "incremental"
    relative = incremental or bool(axis_words)
    named = ""
    for word in axis_words:
        axis = dialect.incremental.get(word.address, word.address)
        if axis not in ends:
            continue
        value = length_mm(word, state, control)
        if axis == "X" and is_diameter(state, control):
            value /= 2.0
        is_distance = incremental or word.address in dialect.incremental
        relative &= is_distance
        ends[axis] = starts[axis] + value if is_distance else value
        named += axis
    motion = state.modes.get("motion", "none")
    kind = motion if motion in _KNOWN else "other"
    if "machine" in once or motion not in _STRAIGHT or "skip" in once:
        kind = "rapid" if "machine" in once and motion == "rapid" else "other"
        ends = _ends_of_other(motion, starts, ends, named, once)
    move_end = Position(*(ends[a] for a in AXES))
    if kind not in ("cw", "ccw"):
        return Move(kind, state.position, move_end, named, relative)
    offsets, radius = _arc_words(block, state, settings)
    return Move(kind, state.position, move_end, named, relative, offsets, radius)


def _ends_of_other(
    motion: str, starts: dict[str, float], ends: dict[str, float], named: str, once: frozenset[str]
) -> dict[str, float]:
    """Cycles return to their start or to a clearance plane; the rest ends nowhere we know."""
    if motion in ("turning-cycle", "threading-cycle", "thread-cycle") and not once:
        return starts
    if motion == "cycle" and not once:
        return {**ends, "Z": math.nan}
    return starts | dict.fromkeys(named, math.nan)


def _arc_words(block: Block, state: State, settings: Settings) -> tuple[Position, float]:
    """I, J, K and R [mm]; I and R are never diameters."""
    values = dict.fromkeys("IJKR", math.nan)
    for word in block.words:
        if word.address in values:
            values[word.address] = length_mm(word, state, settings.control)
    return Position(values["I"], values["J"], values["K"]), values["R"]
