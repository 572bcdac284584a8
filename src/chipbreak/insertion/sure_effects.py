"""What a block sets for sure, in the words of a message: modal groups, S, the spindle, coolant, the tool."""

from __future__ import annotations

from chipbreak.dialects.base import NON_MODAL
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.operations.operations import calls_tool

_PARTS = {"the spindle": "spindle", "coolant": "coolant", "the tool": "tool"}


def set_by(effect: BlockEffect, interpreted: InterpretedProgram) -> set[str]:
    """What a block sets for sure."""
    found: set[str] = set()
    dialect = interpreted.settings.dialect
    spindle = {3.0: "the spindle", 4.0: "the spindle", 5.0: "the spindle", 19.0: "the spindle"}
    coolant = {9.0: "coolant"}  # M7 and M8 leave the other one as it was
    for word in effect.block.words:
        if word.address == "G" and word.number is not None:
            code = dialect.g_codes.get(round(word.number * 10))
            found |= {code.group} if code and code.group != NON_MODAL else set()
        elif word.address == "M" and word.number is not None:
            found |= {name for name in ((spindle | coolant).get(word.number),) if name}
        elif word.address == "S":
            found.add("S")
    return found | ({"the tool"} if calls_tool(effect, dialect.tool_change) else set())


def differing(one: State, other: State) -> frozenset[str]:
    """What is set otherwise in two states."""
    parts = {what for what, name in _PARTS.items() if getattr(one, name) != getattr(other, name)}
    speeds = [state.speed and (state.speed.text, state.speed.value) for state in (one, other)]
    return frozenset(one.modes.changed(other.modes)) | frozenset(
        parts | ({"S"} if speeds[0] != speeds[1] else set())
    )
