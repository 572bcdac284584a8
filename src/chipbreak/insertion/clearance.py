"""Whether a turning tool may go home from where it is: X outward first, then Z.

Inside a bore that way leads through the wall.  The workpiece is not known, but where tools have cut is: in
front of all cuts, or further out than all of them, the way is free.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from math import inf

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import Position
from chipbreak.model.plain_run import RAPID, plain_run
from chipbreak.operations.main_program import MainProgram

_LONG_RUN = 64


class Clearance:
    """The furthest places that have been cut before each line of a turning program."""

    def __init__(self, interpreted: InterpretedProgram, main: MainProgram) -> None:
        parts = list(_cuts(interpreted, main.first, main.last))
        lines = np.concatenate([np.empty(0, np.int64), *(part for part, _ in parts)])
        places = np.concatenate([np.empty((0, 2)), *(part for _, part in parts)])
        self._lines: list[int] = lines.tolist()
        reach = np.fmax.accumulate(np.where(np.isnan(places), -inf, places), axis=0)
        self._reach: list[list[float]] = reach.tolist()

    def is_clear(self, line: int, position: Position) -> bool:
        """True when the tool is in front of, or outside, all that was cut before a line."""
        at = bisect_left(self._lines, line)
        if at == 0:
            return True
        x, z = self._reach[at - 1]
        return position.x > x or position.z >= z


_Cuts = tuple[NDArray[np.int64], Floats]


def _cuts(interpreted: InterpretedProgram, first: int, last: int) -> Iterator[_Cuts]:
    """The lines that cut, and how far in X and Z each reaches; NaN where that is not known."""
    line = first
    for event in [*_between(interpreted, first, last), last]:
        yield _plain_cuts(interpreted, line, event)
        if event < last:
            yield _stepped_cuts(interpreted, event, event + 1)
        line = event + 1


def _between(interpreted: InterpretedProgram, first: int, last: int) -> list[int]:
    special = interpreted.program.special_lines
    events: list[int] = special[(special >= first) & (special < last)].tolist()
    return events


def _plain_cuts(interpreted: InterpretedProgram, first: int, last: int) -> _Cuts:
    run = None
    if last - first > _LONG_RUN:
        run = plain_run(interpreted, interpreted.before(first), first, last, "")
    if run is None:
        return _stepped_cuts(interpreted, first, last)
    cuts = run.moves & (run.mode != RAPID)
    reach: Floats = np.fmax(run.start, run.end)[cuts][:, [0, 2]]
    return np.flatnonzero(cuts) + first, reach


def _stepped_cuts(interpreted: InterpretedProgram, first: int, last: int) -> _Cuts:
    lines: list[int] = []
    reach: list[Floats] = []
    for effect in interpreted.effects_of(first, last):
        if effect.move is None or effect.move.kind == "rapid":
            continue
        start, end = effect.before.position, effect.move.end
        lines.append(effect.block.line)
        reach.append(np.fmax((start.x, start.z), (end.x, end.z)))
    return np.array(lines, np.int64), np.array(reach).reshape(-1, 2)
