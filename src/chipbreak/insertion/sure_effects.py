"""What a block sets for sure, in the words of a message: modal groups, S, the spindle, coolant, the tool."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.dialects.base import NON_MODAL
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.giving_back import is_same_path_mode
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import TOOLS, State
from chipbreak.operations.operations import calls_tool

# Modal groups as a machinist knows them; a group without words of its own is called what it is.
_GROUP_WORDS: Mapping[str, str] = {
    "motion": "the motion mode (G0, G1)",
    "plane": "the plane (G17, G18, G19)",
    "distance": "the distance mode (G90, G91)",
    "arc_distance": "the arc distance mode (G90.1, G91.1)",
    "feed_mode": "the feed mode (G93, G94, G95)",
    "units": "the units (G20, G21)",
    "compensation": "cutter compensation (G40, G41, G42)",
    "length_offset": "the length offset (G43, G49)",
    "speed_mode": "the speed mode (G96, G97)",
    "work_offset": "the work offset (G54 and on)",
    "path": "the path mode (G61, G64)",
    "return_level": "the return level (G98, G99)",
    "diameter": "the diameter mode (G7, G8)",
    "look_ahead": "look-ahead control",
    "modal_macro": "a modal macro call (G66, G67)",
}
_PARTS = {"the spindle": "spindle", "coolant": "coolant", "the tool": "tool"}


def set_by(effect: BlockEffect, interpreted: InterpretedProgram) -> set[str]:
    """What a block sets for sure."""
    found: set[str] = set()
    dialect = interpreted.settings.dialect
    block = effect.block
    codes = [dialect.g_codes.get(round(number * 10)) for number in block.numbers("G")]
    found |= {code.group for code in codes if code and code.group != NON_MODAL}
    if effect.does("spindle"):
        found.add("the spindle")
    if effect.does("coolant", "off"):  # M7 and M8 leave the other one as it was
        found.add("coolant")
    if effect.says("S"):
        found.add("S")
    return found | ({"the tool"} if calls_tool(effect, dialect) else set())


def words_for(what: str) -> str:
    """What a message calls a modal group or another thing that a block sets."""
    return _GROUP_WORDS.get(what, what)


def differing(one: State, other: State) -> frozenset[str]:
    """What is set otherwise in two states, or may be."""
    parts = {what for what, name in _PARTS.items() if getattr(one, name) != getattr(other, name)}
    speeds = [state.speed and (state.speed.text, state.speed.value) for state in (one, other)]
    if bool(one.spindle_why) != bool(other.spindle_why):
        parts.add("the spindle")
    if not is_same_path_mode(one, other):
        parts.add("path")
    if one.smooth_words != other.smooth_words:
        parts.add("look_ahead")
    left_open = {group for group, _ in {*one.left_open} ^ {*other.left_open}}.difference(TOOLS)
    return frozenset(one.modes.changed(other.modes)) | frozenset(
        parts | left_open | ({"S"} if speeds[0] != speeds[1] else set())
    )
