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
    block = effect.block
    codes = [dialect.g_codes.get(round(number * 10)) for number in block.numbers("G")]
    found |= {code.group for code in codes if code and code.group != NON_MODAL}
    if block.has("M", 3, 4, 5, 19):
        found.add("the spindle")
    if block.has("M", 9):  # M7 and M8 leave the other one as it was
        found.add("coolant")
    if block.has("S"):
        found.add("S")
    return found | ({"the tool"} if calls_tool(effect, dialect.tool_change) else set())


def differing(one: State, other: State) -> frozenset[str]:
    """What is set otherwise in two states."""
    parts = {what for what, name in _PARTS.items() if getattr(one, name) != getattr(other, name)}
    speeds = [state.speed and (state.speed.text, state.speed.value) for state in (one, other)]
    return frozenset(one.modes.changed(other.modes)) | frozenset(
        parts | ({"S"} if speeds[0] != speeds[1] else set())
    )
