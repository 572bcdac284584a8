"""Which lines belong to the main program, and which of them cut.

Plain lines are judged by their shapes, all at once; only blocks that are more than plain motion are looked
at one by one.
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.paths import begins_program
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.named_tuple import NamedTuple

# What acts in its own block and cuts, or may cut.
_CUTTING_CODES = frozenset(
    {"rough-cycle", "finish-cycle", "peck-cycle", "thread-cycle", "macro-call", "service"}
)
_NOTHING = 0
_CUTS = 1
_PROBES = 2
_MOVING = "XYZUVWABC"
_WORK_OF_MOTION = {"rapid": _NOTHING, "none": _NOTHING, "probe": _PROBES}


class MainProgram(NamedTuple):
    """The lines that run from the start to the program's end: ``first`` to ``last`` (exclusive).

    ``bodies``  [first, last] lines of subprograms between them
    ``cuts``    the lines that cut, or call what may cut, in order;  ``works`` the same with probing
    ``after_end`` the first line after the end that cuts: another program or a subprogram
    """

    first: int
    last: int
    bodies: tuple[tuple[int, int], ...]
    cuts: NDArray[np.int32]
    works: NDArray[np.int32]
    after_end: int | None

    def has(self, line: int) -> bool:
        """True for a line of the main program."""
        at = bisect_right(self.bodies, (line, 1 << 62)) - 1
        in_body = at >= 0 and line <= self.bodies[at][1]
        return self.first <= line < self.last and not in_body

    def has_work(self, first: int, last: int) -> bool:
        """True when one of the lines cuts or probes."""
        at, end = _between(self.works, first, last)
        return at < end

    def cut_ends(self, first: int, last: int) -> tuple[int, int] | None:
        """First and last line of a range that cut, None where none does."""
        at, end = _between(self.cuts, first, last)
        return (int(self.cuts[at]), int(self.cuts[end - 1])) if at < end else None


def _between(lines: NDArray[np.int32], first: int, last: int) -> tuple[int, int]:
    """Where the lines from ``first`` to ``last`` (exclusive) begin and end among these."""
    at, end = np.searchsorted(lines, np.array((first, last), np.int32))
    return int(at), int(end)


def main_program(interpreted: InterpretedProgram) -> MainProgram:
    """Find the main program of a file."""
    body = interpreted.program.source.body
    bodies, last = _bodies(interpreted)
    work = _work(interpreted)
    for first, final in bodies:
        work[first : final + 1] = _NOTHING
    after_end = np.flatnonzero(work[last : body.stop] == _CUTS)
    work[last:] = _NOTHING
    # They are kept while the program is rewritten, so they are small, and mostly one array.
    works = np.flatnonzero(work).astype(np.int32)
    is_cut = work[works] == _CUTS
    return MainProgram(
        body.start,
        last,
        bodies,
        works if is_cut.all() else works[is_cut],
        works,
        last + int(after_end[0]) if len(after_end) else None,
    )


def _bodies(interpreted: InterpretedProgram) -> tuple[tuple[tuple[int, int], ...], int]:
    """Subprogram bodies, and the line of the program's end."""
    dialect = interpreted.settings.dialect
    bodies: list[tuple[int, int]] = []
    opened: int | None = None
    last = interpreted.program.source.body.stop
    begun = False
    for effect in interpreted.effects:
        keywords = {control.keyword for control in effect.block.controls}
        if "O-SUB" in keywords and opened is None:
            opened = effect.block.line
        elif "O-ENDSUB" in keywords and opened is not None:
            bodies.append((opened, effect.block.line))
            opened = None
        elif opened is None and (_ends(effect) or (begun and begins_program(effect.block, dialect))):
            last = effect.block.line
            break
        begun = begun or not (effect.block.is_empty or effect.block.opaque)
    if opened is not None:
        bodies.append((opened, last))
    return tuple(bodies), _before_marks(interpreted, last)


def _ends(effect: BlockEffect) -> bool:
    return effect.after.ended and not effect.before.ended


def _before_marks(interpreted: InterpretedProgram, last: int) -> int:
    """The line after the last one that is no mark of this filter."""
    while last > interpreted.program.source.body.start and interpreted.program.block(last - 1).mark:
        last -= 1
    return last


def _work(interpreted: InterpretedProgram) -> NDArray[np.int8]:
    """What each line of the file does to the workpiece."""
    program = interpreted.program
    given = np.array([-1 if s.motion is None else min(s.motion, 1) for s in program.shapes] + [-1], np.int8)
    mode = given[program.plain]
    for effect in interpreted.effects:
        mode[effect.block.line] = _WORK_OF_MOTION.get(effect.after.modes.motion, _CUTS)
    lines = np.arange(len(mode), dtype=np.int32)
    lines[mode < 0] = 0
    mode = mode[np.maximum.accumulate(lines)]
    work = np.where(program.bits & bits_of(_MOVING + "IJK"), np.maximum(mode, _NOTHING), np.int8(_NOTHING))
    for effect in interpreted.effects:
        work[effect.block.line] = _work_of(effect)
    for first, last in interpreted.flow.contours:
        work[first : last + 1] = _NOTHING
    outside = np.ones(len(work), np.bool_)
    outside[program.source.body.start : program.source.body.stop] = False
    work[outside] = _NOTHING
    return work


def _work_of(effect: BlockEffect) -> int:
    """What a block that is more than plain motion does."""
    block = effect.block
    modes = effect.after.modes
    if effect.in_contour or effect.before.ended or "machine" in effect.non_modal:
        return _NOTHING
    if "skip" in effect.non_modal:
        return _PROBES
    if calls_subprogram(effect) or effect.non_modal & _CUTTING_CODES:
        return _CUTS
    if effect.move is not None:
        return _CUTS if modes.modal_macro == "on" else _WORK_OF_MOTION.get(modes.motion, _CUTS)
    if effect.non_modal:
        return _NOTHING
    # Full circles name no axis; under a G code this profile does not know the axes have not been read.
    moving = _MOVING + "IJK" if modes.motion in ("cw", "ccw") else _MOVING
    if block.has_any(moving):
        return _WORK_OF_MOTION.get(modes.motion, _CUTS)
    return _NOTHING


def calls_subprogram(effect: BlockEffect) -> bool:
    """True for M98 and its like and for ``o<name> call``."""
    is_call = any(control.keyword == "O-CALL" for control in effect.block.controls)
    return is_call or effect.does("subprogram", "call", "local-call", "external-call")
