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
from chipbreak.model.plain_run import MODES, RAPID, kept, plain_run
from chipbreak.settings.sections import Settings
from chipbreak.units import S_PER_MIN

_CW = MODES.index("cw")


def time_run(interpreted: InterpretedProgram, state: State, first: int, last: int, clock: Clock) -> bool:
    """Add the times of plain lines ``first`` to ``last`` (exclusive); False where they must be stepped."""
    settings = interpreted.settings
    modes = state.modes
    if modes.arc_distance != "incremental" or modes.feed_mode not in ("minute", "rev"):
        return False
    run = plain_run(interpreted, state, first, last, "RF")
    if run is None:
        return False
    said, start, end, moves, mode, more = run
    scale = state.mm_per_unit * np.array([settings.axis_words.signs[axis] for axis in "XYZ"])
    _rapids(clock, (said, start, end), moves & (mode == RAPID))
    feed = kept(more[:, 4:5] * state.mm_per_unit, np.array([state.feed.value if state.feed else math.nan]))
    feeding = moves & (mode != RAPID)
    # An axis that has not moved yet counts for nothing.
    start, end = (np.where(np.isnan(end) & np.isnan(said), 0.0, one) for one in (start, end))
    lengths = line_lengths_mm(start, end)
    arcs = feeding & (mode >= _CW)
    if arcs.any():
        turn = np.where(mode[arcs] == _CW, -1.0, 1.0)
        offsets = more[arcs, :3] * scale
        radius = more[arcs, 3] * state.mm_per_unit
        lengths[arcs] = arc_lengths_mm(Arcs(start[arcs], end[arcs], turn, state.modes.plane, offsets, radius))
    turns = _turns_s(state, start[:, 0], end[:, 0], settings)
    per_minute = modes.feed_mode == "minute"
    times = lengths / feed[:, 0] * (S_PER_MIN if per_minute else turns)
    known = feeding & np.isfinite(times)
    clock.add(CUTTING, float(times[known].sum()))
    for line in np.flatnonzero(feeding & ~known).tolist():
        clock.cannot(first + line, "its place, its feed or its spindle speed is not known")
    return True


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
