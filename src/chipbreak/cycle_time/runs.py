"""A run of plain moves at once: lines, arcs and rapids as columns of numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from chipbreak.cycle_time.clock import CUTTING, RAPIDS, Clock
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.move_times import (
    Arcs,
    arc_lengths_mm,
    line_lengths_mm,
    rapid_times_s,
    surface_turn_s,
)
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import is_diameter
from chipbreak.settings.sections import Settings
from chipbreak.syntax.columns import read_words
from chipbreak.syntax.shapes import NO_POINT, bits_of
from chipbreak.units import S_PER_MIN

_MODES = ("rapid", "line", "cw", "ccw")
_RAPID, _LINE, _CW = 0, 1, 2
_CENTRES = "IJK"


def time_run(interpreted: InterpretedProgram, state: State, first: int, last: int, clock: Clock) -> bool:
    """Add the times of plain lines ``first`` to ``last`` (exclusive); False where they must be stepped."""
    settings = interpreted.settings
    bits = interpreted.program.bits[first:last]
    if not _is_simple(interpreted, state, int(np.bitwise_or.reduce(bits))):
        return False
    words = settings.axis_words
    letters = "".join(words.letters[axis] for axis in "XYZ")
    table = read_words(interpreted.program, first, last, letters + _CENTRES + "RF")
    if table is None:
        return False
    halved = 2.0 if is_diameter(state, settings.control) else 1.0
    scale = state.mm_per_unit * np.array([words.signs[axis] for axis in "XYZ"])
    said = table[:, :3] * scale / (halved, 1.0, 1.0)
    end = _kept(said, np.array(state.position))
    start = np.vstack((np.array(state.position)[np.newaxis], end[:-1]))
    moves = ~np.isnan(said).all(axis=1) | ~np.isnan(table[:, 3:6]).all(axis=1)
    mode = _modes(interpreted, state, first, last)
    _rapids(clock, (said, start, end), moves & (mode == _RAPID))
    feed = _kept(table[:, 7:8] * state.mm_per_unit, np.array([state.feed.value if state.feed else math.nan]))
    feeding = moves & (mode != _RAPID)
    # An axis that has not moved yet counts for nothing.
    start, end = (np.where(np.isnan(end) & np.isnan(said), 0.0, one) for one in (start, end))
    lengths = line_lengths_mm(start, end)
    arcs = feeding & (mode >= _CW)
    if arcs.any():
        turn = np.where(mode[arcs] == _CW, -1.0, 1.0)
        offsets = table[arcs, 3:6] * scale
        radius = table[arcs, 6] * state.mm_per_unit
        lengths[arcs] = arc_lengths_mm(Arcs(start[arcs], end[arcs], turn, state.modes.plane, offsets, radius))
    turns = _turns_s(state, start[:, 0], end[:, 0], settings)
    per_minute = state.modes.feed_mode == "minute"
    times = lengths / feed[:, 0] * (S_PER_MIN if per_minute else turns)
    known = feeding & np.isfinite(times)
    clock.add(CUTTING, float(times[known].sum()))
    for line in np.flatnonzero(feeding & ~known).tolist():
        clock.cannot(first + line, "its place, its feed or its spindle speed is not known")
    return True


def _is_simple(interpreted: InterpretedProgram, state: State, used: int) -> bool:
    """True where every word is the place that it says, or a centre from the start."""
    modes = state.modes
    is_plain = modes.motion in _MODES and not state.ended and interpreted.flow.is_straight
    absolute = modes.distance == "absolute" and not used & bits_of(interpreted.settings.axis_words.distances)
    points = interpreted.settings.number_rule.reads_whole or not used & NO_POINT
    arcs = modes.arc_distance == "incremental" and modes.feed_mode in ("minute", "rev")
    return is_plain and absolute and points and arcs


def _kept(said: Floats, before: Floats) -> Floats:
    """What is in force behind each line: the last number that was said, (n, k)."""
    rows = np.vstack((before[np.newaxis], said))
    index = np.where(np.isnan(rows), 0, np.arange(len(rows))[:, np.newaxis])
    latest = np.maximum.accumulate(index, axis=0)
    kept: Floats = np.take_along_axis(rows, latest, axis=0)[1:]
    return kept


def _modes(interpreted: InterpretedProgram, state: State, first: int, last: int) -> NDArray[np.int64]:
    """Which of G0 to G3 is in force on each line."""
    program = interpreted.program
    said = np.array([-1 if shape.motion is None else shape.motion for shape in program.shapes])
    of_line = np.concatenate(([_MODES.index(state.modes.motion)], said[program.plain[first:last]]))
    at = np.maximum.accumulate(np.where(of_line < 0, 0, np.arange(len(of_line))))
    modes: NDArray[np.int64] = of_line[at][1:]
    return modes


def _rapids(clock: Clock, places: tuple[Floats, Floats, Floats], rapid: NDArray[np.bool_]) -> None:
    said, start, end = (one[rapid] for one in places)
    way = np.where(np.isnan(said), 0.0, end - start)
    unknown = np.isnan(way).any(axis=1)
    clock.rapid_without_place(int(unknown.sum()))
    way = way[~unknown]
    if len(way):
        clock.moved(way)
        machine = clock.machine
        clock.add(RAPIDS, float(rapid_times_s(way, machine.speed_mm_s, machine.acceleration_mm_s2).sum()))


def _turns_s(state: State, start_mm: Floats, end_mm: Floats, settings: Settings) -> Floats | float:
    """The mean time of a revolution on each line [s]."""
    speed = state.speed.value if state.speed else math.nan
    limit = settings.spindle.max_rpm or math.inf
    if not speed > 0.0:
        return math.nan
    if state.modes.speed_mode == "rpm":
        return S_PER_MIN / min(speed, limit)
    if state.speed_limit is not None and state.speed_limit.value > 0.0:
        limit = min(limit, state.speed_limit.value)
    return surface_turn_s(start_mm, end_mm, speed, limit)
