"""Where a block's axis words take the tool."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from chipbreak.dialects.modes import Modes, Motion
from chipbreak.model.block_effect import Move, MoveKind
from chipbreak.model.modal import Position, State, one_unknown
from chipbreak.model.words import is_diameter, length_mm, plain_value
from chipbreak.settings.axis_words import AXES, CENTRES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.named_tuple import NamedTuple

_STRAIGHT: tuple[Motion, ...] = ("rapid", "line", "cw", "ccw", "thread", "spline")
_KINDS: Mapping[Motion, MoveKind] = {
    "rapid": "rapid",
    "line": "line",
    "cw": "cw",
    "ccw": "ccw",
    "thread": "thread",
}
_OTHER_WAY: Mapping[MoveKind, MoveKind] = {"cw": "ccw", "ccw": "cw"}
_ELSEWHERE = frozenset({"machine", "skip"})
_ARC_WORDS = frozenset({*CENTRES, "R"})
ANGLE = ",A"
_TURNED = frozenset("XZ")
_Ends = dict[str, float]


class _Named(NamedTuple):
    """Where axis words lead: the ends by axis [mm], the axes that are named, whether all give distances."""

    ends: _Ends
    axes: str
    relative: bool


def move_of(
    block: Block, state: State, axis_words: Sequence[Word], settings: Settings, non_modal: frozenset[str]
) -> Move:
    """The motion of a block.  Ends are NaN where a value or a start cannot be known."""
    named = _named(state, axis_words, settings)
    kind = _kind(block, state, settings, non_modal)
    goes_elsewhere = state.modes.motion not in _STRAIGHT or not non_modal.isdisjoint(_ELSEWHERE)
    ends = _ends_of_other(state, named, non_modal) if goes_elsewhere else named.ends
    if block.has(ANGLE):  # it gives the other axis of the plane its place
        ends = {axis: math.nan if axis in _TURNED - {*named.axes} else end for axis, end in ends.items()}
    move_end = Position(*(one_unknown(ends[axis]) for axis in AXES))
    move = Move(kind, state.position, move_end, named.axes, named.relative)
    return _as_arc(move, block, state, settings) if kind in _OTHER_WAY else move


def named_place(block: Block, state: State, letters: str, settings: Settings) -> Position:
    """The place that words of a block name which is no move; where the tool stands along the others."""
    ends = _named(state, block.words_of(letters), settings).ends
    return Position(*(ends[axis] for axis in AXES))


def _named(state: State, axis_words: Sequence[Word], settings: Settings) -> _Named:
    """What the axis words say."""
    words = settings.axis_words
    ends = dict(zip(AXES, state.position, strict=True))
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
        # A distance counts from the start, also where the axis is named twice.
        ends[axis] = getattr(state.position, axis.lower()) + value if is_distance else value
        named += axis
    return _Named(ends, named, relative)


def _along_axis_mm(word: Word, axis: str, state: State, settings: Settings) -> float:
    """What a word says along its axis, in the sense of the geometry; a diameter is halved."""
    value_mm = length_mm(word, state, settings) * settings.axis_words.signs[axis]
    return value_mm / 2.0 if axis == "X" and is_diameter(state, settings.control) else value_mm


def _kind(block: Block, state: State, settings: Settings, non_modal: frozenset[str]) -> MoveKind:
    """What the motion code makes of the move; ``other`` ends where the control decides."""
    motion = state.modes.motion
    if "machine" in non_modal:
        return "rapid" if motion == "rapid" else "other"
    if motion not in _STRAIGHT or "skip" in non_modal:
        return "other"
    kind = _KINDS.get(motion, "other")
    is_bare_arc = kind in _OTHER_WAY and not block.has_any(_ARC_WORDS)
    return "line" if is_bare_arc and settings.dialect.bare_arc_is_line else kind


def _as_arc(move: Move, block: Block, state: State, settings: Settings) -> Move:
    """The move with its plane and centre."""
    plane, is_mirrored = settings.axis_words.plane(state.modes.plane)
    offsets, radius_mm = _arc_words(block, state, settings)
    kind = _OTHER_WAY[move.kind] if is_mirrored else move.kind
    turns = _more_turns(block, settings)
    return move._replace(kind=kind, offsets=offsets, radius_mm=radius_mm, plane=plane, more_turns=turns)


def _more_turns(block: Block, settings: Settings) -> float:
    """What ``P3`` on an arc of LinuxCNC adds: two turns."""
    word = block.word(settings.dialect.arc_turns) if settings.dialect.arc_turns else None
    if word is None:
        return 0.0
    turns = plain_value(word)
    return turns - 1.0 if turns >= 1.0 and turns == int(turns) else math.nan


def _ends_of_other(state: State, named: _Named, non_modal: frozenset[str]) -> _Ends:
    """Cycles return to their start or to a clearance plane; the rest ends nowhere we know."""
    starts = dict(zip(AXES, state.position, strict=True))
    found = None if non_modal else _end_of_cycle(state.modes, starts, named)
    return starts | dict.fromkeys(named.axes, math.nan) if found is None else found


def _end_of_cycle(modes: Modes, starts: _Ends, named: _Named) -> _Ends | None:
    """Where a cycle leaves the tool, None where that is not known."""
    if modes.motion in ("turning-cycle", "threading-cycle"):
        return starts
    if modes.motion == "thread-cycle":
        # LinuxCNC's G76 comes back to the drive line, but stays at the end of the thread.
        return {**starts, **dict.fromkeys(named.axes, math.nan), "Z": named.ends["Z"]}
    if modes.motion == "cycle" and modes.plane == "XY":
        return {**named.ends, "Z": math.nan}
    return None


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
