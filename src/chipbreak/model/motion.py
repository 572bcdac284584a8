"""Where a block's axis words take the tool."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from chipbreak.dialects.modes import Modes, Motion
from chipbreak.model.block_effect import Move, MoveKind
from chipbreak.model.modal import Position, State
from chipbreak.model.words import is_diameter, length_mm
from chipbreak.settings.axis_words import AXES, CENTRES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word

_STRAIGHT: tuple[Motion, ...] = ("rapid", "line", "cw", "ccw", "thread", "spline")
_KINDS: Mapping[Motion, MoveKind] = {
    "rapid": "rapid",
    "line": "line",
    "cw": "cw",
    "ccw": "ccw",
    "thread": "thread",
}
_OTHER_WAY: Mapping[MoveKind, MoveKind] = {"cw": "ccw", "ccw": "cw"}


def move_of(
    block: Block, state: State, axis_words: Sequence[Word], settings: Settings, non_modal: frozenset[str]
) -> Move:
    """The motion of a block.  Ends are NaN where a value or a start cannot be known."""
    words = settings.axis_words
    ends = dict(zip(AXES, state.position, strict=True))
    starts = dict(ends)
    incremental = state.modes.distance == "incremental"
    relative = incremental or bool(axis_words)
    named = ""
    for word in axis_words:
        axis = words.axes.get(word.address, "")
        if axis not in ends:
            continue
        value = _along_axis_mm(word, axis, state, settings)
        is_distance = incremental or word.address in words.distances
        relative &= is_distance
        ends[axis] = starts[axis] + value if is_distance else value
        named += axis
    motion = state.modes.motion
    kind = _KINDS.get(motion, "other")
    if "machine" in non_modal or motion not in _STRAIGHT or "skip" in non_modal:
        kind = "rapid" if "machine" in non_modal and motion == "rapid" else "other"
        ends = _ends_of_other(state.modes, starts, ends, named, non_modal)
    move_end = Position(*(ends[a] for a in AXES))
    if kind not in _OTHER_WAY:
        return Move(kind, state.position, move_end, named, relative)
    plane, is_mirrored = words.plane(state.modes.plane)
    offsets, radius = _arc_words(block, state, settings)
    kind = _OTHER_WAY[kind] if is_mirrored else kind
    return Move(kind, state.position, move_end, named, relative, offsets, radius, plane)


def _along_axis_mm(word: Word, axis: str, state: State, settings: Settings) -> float:
    """What a word says along its axis, in the sense of the geometry; a diameter is halved."""
    value_mm = length_mm(word, state, settings) * settings.axis_words.signs[axis]
    return value_mm / 2.0 if axis == "X" and is_diameter(state, settings.control) else value_mm


def _ends_of_other(
    modes: Modes,
    starts: dict[str, float],
    ends: dict[str, float],
    named: str,
    non_modal: frozenset[str],
) -> dict[str, float]:
    """Cycles return to their start or to a clearance plane; the rest ends nowhere we know."""
    motion = modes.motion
    if motion in ("turning-cycle", "threading-cycle", "thread-cycle") and not non_modal:
        return starts
    if motion == "cycle" and not non_modal and modes.plane == "XY":
        return {**ends, "Z": math.nan}
    return starts | dict.fromkeys(named, math.nan)


def _arc_words(block: Block, state: State, settings: Settings) -> tuple[Position, float]:
    """From the start to the centre, and R [mm]; I and R are never diameters."""
    words = settings.axis_words
    radius_mm = math.nan
    offsets = dict.fromkeys(AXES, math.nan)
    for word in block.words:
        if word.address in CENTRES:
            axis = words.centre_axis(word.address)
            offsets[axis] = length_mm(word, state, settings) * words.signs[axis]
        elif word.address == "R":
            radius_mm = length_mm(word, state, settings)
    centre = Position(*offsets.values())
    if state.modes.arc_distance == "absolute":
        centre = Position(*(c - s for c, s in zip(centre, state.position, strict=True)))
    return centre, radius_mm
