"""A run of plain moves as columns of numbers: where each line begins and ends, without a step for each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import is_diameter
from chipbreak.syntax.columns import read_words
from chipbreak.syntax.shapes import NO_POINT, bits_of
from chipbreak.text.named_tuple import NamedTuple

MODES = ("rapid", "line", "cw", "ccw")
RAPID = 0
_CENTRES = "IJK"


class PlainRun(NamedTuple):
    """Lines one behind the other, of shape (n, 3) for X, Y, Z in mm, X as a radius; NaN is not known.

    ``said`` is what each line names, ``start`` and ``end`` where it begins and ends; ``moves`` says which
    lines move, ``mode`` (of :data:`MODES`) how.  ``more`` has the numbers of the other letters, as written.
    """

    said: Floats
    start: Floats
    end: Floats
    moves: NDArray[np.bool_]
    mode: NDArray[np.int64]
    more: Floats


def plain_run(
    interpreted: InterpretedProgram, state: State, first: int, last: int, letters: str
) -> PlainRun | None:
    """Plain lines ``first`` to ``last`` (exclusive), from ``state`` on; None where they must be stepped.

    ``letters`` are those of ``more``, which begins with I, J and K.
    """
    settings = interpreted.settings
    if not _is_simple(interpreted, state, first, last):
        return None
    words = settings.axis_words
    axes = "".join(words.letters[axis] for axis in "XYZ")
    table = read_words(interpreted.program, first, last, axes + _CENTRES + letters)
    if table is None:
        return None
    halved = 2.0 if is_diameter(state, settings.control) else 1.0
    scale = state.mm_per_unit * np.array([words.signs[axis] for axis in "XYZ"])
    said = table[:, :3] * scale / (halved, 1.0, 1.0)
    end = kept(said, np.array(state.position))
    start = np.vstack((np.array(state.position)[np.newaxis], end[:-1]))
    moves = ~np.isnan(np.hstack((said, table[:, 3:6]))).all(axis=1)
    mode = modes_of(interpreted, state, first, last)
    return PlainRun(said, start, end, np.asarray(moves), mode, table[:, 3:])


def _is_simple(interpreted: InterpretedProgram, state: State, first: int, last: int) -> bool:
    """True where every word is the place that it says, or a centre from the start."""
    modes = state.modes
    used = int(np.bitwise_or.reduce(interpreted.program.bits[first:last]))
    is_straight = interpreted.flow.straight_until(first, last) == last
    is_plain = modes.motion in MODES and not state.ended and is_straight
    absolute = modes.distance == "absolute" and not used & bits_of(interpreted.settings.axis_words.distances)
    points = interpreted.settings.number_rule.reads_whole or not used & NO_POINT
    return is_plain and absolute and points


def kept(said: Floats, before: Floats) -> Floats:
    """What is in force behind each line: the last number that was said, (n, k)."""
    rows = np.vstack((before[np.newaxis], said))
    index = np.where(np.isnan(rows), 0, np.arange(len(rows))[:, np.newaxis])
    latest = np.maximum.accumulate(index, axis=0)
    found: Floats = np.take_along_axis(rows, latest, axis=0)[1:]
    return found


def modes_of(interpreted: InterpretedProgram, state: State, first: int, last: int) -> NDArray[np.int64]:
    """Which of :data:`MODES` is in force on each line of a plain run; one of them is in ``state``."""
    program = interpreted.program
    said = np.array([-1 if shape.motion is None else shape.motion for shape in program.shapes])
    of_line = np.concatenate(([MODES.index(state.modes.motion)], said[program.plain[first:last]]))
    at = np.maximum.accumulate(np.where(of_line < 0, 0, np.arange(len(of_line))))
    modes: NDArray[np.int64] = of_line[at][1:]
    return modes
