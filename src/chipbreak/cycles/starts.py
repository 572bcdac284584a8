"""What must hold where a cycle starts, so that its passes can be written out from there."""

from __future__ import annotations

import math

from chipbreak.cycles.call import UNREAD_FORM, Call, refuse_modes
from chipbreak.cycles.corners import BAD_CONTOUR
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.points import WRITE_THE_POINT, moved_without_point
from chipbreak.model.words import settles_motion
from chipbreak.text.diagnostics import RefusalError

_MOST_LINES = 2000
UNDER_COMPENSATION = "nose compensation is in force at this cycle"
END_COMPENSATION = "write G40 and a move to its start before the cycle"
MOVE_THERE = "move to its start with G0 X Z in plain absolute numbers before it"


def refuse_contour_before(interpreted: InterpretedProgram, call: Call) -> None:
    """A contour to which the control comes before any of its cycles is cut there, and must stay.

    Errors: CYC002.
    """
    if not interpreted.flow.in_contour(call.contour_first):
        place = interpreted.program.source.place(call.contour_first).line
        message = f"the contour in line {place} stands before its cycle, and the control cuts along it there"
        raise RefusalError(BAD_CONTOUR, message, "write the contour behind the cycle")


def refuse_start(interpreted: InterpretedProgram, call: Call, state: State) -> None:
    """The blocks are written for absolute numbers, without compensation, from a known place.

    Errors: CYC007.
    """
    refuse_modes(state)
    refuse_unknown_start(interpreted, call.first, state)
    if leaves_motion(state):
        refuse_next_move(interpreted, call.last - 1)


def leaves_motion(state: State) -> bool:
    """True where no block gives back the motion code that was in force: that of an arc, or of a G94."""
    return state.modes.motion not in ("rapid", "line")


def refuse_next_move(interpreted: InterpretedProgram, line: int) -> None:
    """Behind the cycle in a line another motion code is in force, so the next move must say its own.

    Errors: CYC007.
    """
    stop = min(interpreted.program.source.body.stop, line + _MOST_LINES)
    for effect in interpreted.effects_of(line + 1, stop):
        if effect.in_contour:
            continue
        if settles_motion(effect.block, interpreted.settings.dialect) or effect.non_modal:
            return
        if effect.after.modes.motion == "cycle":
            continue
        if effect.move is not None:
            message = "the next move behind this cycle says no motion code of its own"
            raise RefusalError(UNREAD_FORM, message, "write G0 or G1 into it")


def refuse_unknown_start(interpreted: InterpretedProgram, line: int, state: State) -> None:
    """A cycle in a line starts where the tool stands, so that must be known.  Errors: CYC007."""
    for axis, place in (("X", state.position.x), ("Z", state.position.z)):
        if math.isnan(place):
            shown = moved_without_point(interpreted, line, state.unknown_why, axis)
            why = f"{shown} has no decimal point" if shown else state.unknown_why
            message = f"where this cycle starts is not known: {why}"
            raise RefusalError(UNREAD_FORM, message, WRITE_THE_POINT if shown else MOVE_THERE)
