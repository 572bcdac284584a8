"""How long a feed move takes: revolutions, cutting speed on a diameter, leads of threads."""

from __future__ import annotations

import math

import numpy as np

from chipbreak.cycle_time.clock import Machine
from chipbreak.kinematics.move_times import (
    Arcs,
    arc_lengths_mm,
    line_lengths_mm,
    rapid_times_s,
    surface_turn_s,
)
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.modal import Position, State
from chipbreak.model.words import length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Word
from chipbreak.units import S_PER_MIN

_TURNS = {"cw": -1.0, "ccw": 1.0}


def way_mm(end: Position, start: Position, axis: str, named: str) -> float:
    """How far an axis goes; one that the block does not name stays, wherever it is."""
    if axis not in named:
        return 0.0
    return float(getattr(end, axis.lower()) - getattr(start, axis.lower()))


def path_length_mm(move: Move) -> float:
    """The length of a line or an arc, NaN where its ends are not known."""
    ends = (_known(move.start, move), _known(move.end, move))
    start, end = (np.array(one)[np.newaxis] for one in ends)
    if move.kind not in _TURNS:
        return float(line_lengths_mm(start, end)[0])
    offset = np.array(move.offsets if move.offsets is not None else (math.nan,) * 3)[np.newaxis]
    turn = np.array([_TURNS[move.kind]])
    radius = np.array([move.radius_mm])
    arc = Arcs(start, end, turn, move.plane, offset, radius, np.array([move.more_turns]))
    return float(arc_lengths_mm(arc)[0])


def _known(place: Position, move: Move) -> list[float]:
    """A place where an axis that the block does not name, and nobody knows, counts as 0."""
    pairs = zip("XYZ", place, strict=True)
    return [0.0 if math.isnan(value) and axis not in move.axes else value for axis, value in pairs]


def turn_s(state: State, start_radius_mm: float, end_radius_mm: float, settings: Settings) -> float:
    """The mean time of a revolution [s], NaN where it is not known."""
    speed = state.speed
    if speed is None or not speed.value > 0.0:
        return math.nan
    limit = settings.spindle.max_rpm or math.inf
    if state.modes.speed_mode == "rpm":
        return S_PER_MIN / min(speed.value, limit)
    if state.speed_limit is not None and state.speed_limit.value > 0.0:
        limit = min(limit, state.speed_limit.value)
    radii = np.array([start_radius_mm]), np.array([end_radius_mm])
    found_s = float(surface_turn_s(*radii, speed.value, limit)[0])
    return found_s if found_s > 0.0 else math.nan  # on the axis, without a limit


def feed_time_s(state: State, move: Move, way: float, settings: Settings) -> float:
    """The time of a feed move of the length ``way`` [mm], NaN where feed or speed are not known."""
    feed = state.feed
    if feed is None or not feed.value > 0.0:
        return math.nan
    mode = state.modes.feed_mode
    if move.kind == "thread":
        ways = [abs(way_mm(move.end, move.start, axis, move.axes)) for axis in "XZ"]
        return max(ways) / feed.value * turn_s(state, move.start.x, move.end.x, settings)
    if mode == "inverse":
        return S_PER_MIN / feed.value
    if mode == "minute":
        return way / feed.value * S_PER_MIN
    return way / feed.value * turn_s(state, move.start.x, move.end.x, settings)


def rapid_s(machine: Machine, x_mm: float = 0.0, y_mm: float = 0.0, z_mm: float = 0.0) -> float:
    """The time of a rapid over these ways [s]."""
    way = np.array([[x_mm, y_mm, z_mm]])
    return float(rapid_times_s(way, machine.speed_mm_s, machine.acceleration_mm_s2)[0])


def word_mm(effect: BlockEffect, letter: str, settings: Settings) -> float:
    """A length that a word of a block says [mm], NaN without it."""
    word = effect.block.word(letter)
    return math.nan if word is None else length_mm(word, effect.after, settings)


def counted_mm(effect: BlockEffect, letter: str, settings: Settings) -> float:
    """A length that counts increments where it has no point, as P and Q of cycles do [mm], NaN without it."""
    word = effect.block.word(letter)
    if word is None:
        return math.nan
    return length_mm(word, effect.after, settings) if word.has_point else _increments(word, settings)


def _increments(word: Word, settings: Settings) -> float:
    value = math.nan if word.number is None else word.number
    return value * settings.control.increment_mm
