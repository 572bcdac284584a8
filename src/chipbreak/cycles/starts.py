"""What must hold where a cycle starts, so that its passes can be written out from there."""

from __future__ import annotations

import math

from chipbreak.cycles.call import UNREAD_FORM, Call, refuse_modes
from chipbreak.cycles.corners import BAD_CONTOUR
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.points import WRITE_THE_POINT, moved_without_point
from chipbreak.text.diagnostics import RefusalError

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
    refuse_modes(state.modes)
    refuse_unknown_start(interpreted, call.first, state)
    if state.modes.motion not in ("rapid", "line"):
        raise RefusalError(UNREAD_FORM, "an arc or a cycle is in force at this cycle", MOVE_THERE)


def refuse_unknown_start(interpreted: InterpretedProgram, line: int, state: State) -> None:
    """A cycle in a line starts where the tool stands, so that must be known.  Errors: CYC007."""
    for axis, place in (("X", state.position.x), ("Z", state.position.z)):
        if math.isnan(place):
            shown = moved_without_point(interpreted, line, state.unknown_why, axis)
            why = f"{shown} has no decimal point" if shown else state.unknown_why
            message = f"where this cycle starts is not known: {why}"
            raise RefusalError(UNREAD_FORM, message, WRITE_THE_POINT if shown else MOVE_THERE)
