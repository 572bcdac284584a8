"""Effects of blocks that last and that no modal group shows, wherever they change."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence

from chipbreak.dialects.path_mode import has_lengths
from chipbreak.insertion.subprograms import Subprograms
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of, plain_value
from chipbreak.operations.operations import calls_tool
from chipbreak.text.named_tuple import NamedTuple

_ORIENT = 19


class Unreadable(NamedTuple):
    """A line after which it is not known what is in force; its number is between ``before`` and ``after``."""

    line: int
    before: str
    after: str

    def why(self, user_line: int) -> str:
        """The reason, with the line as the user counts it."""
        return f"{self.before}{user_line}{self.after}"


def unreadable_lines(interpreted: InterpretedProgram, subprograms: Subprograms) -> Iterator[Unreadable]:
    """Wherever it is not known what was left in force."""
    for effect in interpreted.effects:
        line = effect.block.line
        unknown_code = _unknown_code(effect, interpreted)
        if effect.block.opaque:
            yield Unreadable(line, "line ", " before it cannot be read")
        elif unknown_code:
            why = f" before it says {unknown_code}, which this profile does not know"
            yield Unreadable(line, "line ", why)
        elif subprograms.changes(effect) is None:
            what = "calls tools" if subprograms.call_tools(effect) else "is not in this file"
            why = f" {what}; nobody knows what it leaves in force"
            yield Unreadable(line, "what is called in line ", why)


def _unknown_code(effect: BlockEffect, interpreted: InterpretedProgram) -> str:
    """A G code that may have switched anything, "" where there is none."""
    for word in effect.block.words_of("G"):
        value = plain_value(word)
        if math.isnan(value) or round(value * 10) not in interpreted.settings.dialect.g_codes:
            return effect.block.text_of(word)
    return ""


def coolant_through(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether coolant runs through the spindle after it), wherever that is said.

    The code that ends coolant outside does not end it.
    """
    dialect = interpreted.settings.dialect
    if not any(code.group == "coolant_through" for code in dialect.m_codes.values()):
        return
    for effect in interpreted.effects:
        if effect.does("coolant_through", "on"):
            yield effect.block.line, 1
        elif effect.does("coolant_through", "off") or calls_tool(effect, dialect):
            yield effect.block.line, 0


def orientations(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether the spindle is held at an angle after it), wherever that is said."""
    dialect = interpreted.settings.dialect
    if _ORIENT not in dialect.m_codes:
        return
    for effect in interpreted.effects:
        if effect.block.has("M", _ORIENT):
            yield effect.block.line, 1
        elif effect.does("spindle") or calls_tool(effect, dialect):
            yield effect.block.line, 0


def unsure_spindles(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether the spindle may have been stopped after it), wherever a tool changes or M3 to M5 stand.

    Some machines stop it at a tool change, some do not.
    """
    dialect = interpreted.settings.dialect
    for effect in interpreted.effects:
        if effect.does("spindle"):
            yield effect.block.line, 0
        elif calls_tool(effect, dialect):
            yield effect.block.line, int(effect.after.turns)


class UnitSwitch(NamedTuple):
    """A line that changes the units; whether an F, and a tolerance, are in force there from other units."""

    line: int
    has_feed: bool
    has_tolerance: bool


def unit_switches(interpreted: InterpretedProgram) -> Iterator[UnitSwitch]:
    """Every change of the units."""
    has_feed = False
    has_tolerance = False
    for effect in interpreted.effects:
        before = effect.before
        # After a loop it is not known any more, but in force; one beside G20 is read before it.
        has_feed |= before.feed is not None or effect.says("F")
        if before.modes.units != effect.after.modes.units:
            has_tolerance = has_tolerance or has_lengths(before.path_words)
            yield UnitSwitch(effect.block.line, has_feed, has_tolerance)
        elif codes_of(effect.block, "path", interpreted.settings.dialect):
            has_tolerance = False


def turned_offsets(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether LinuxCNC's ``G10 L2 P1 R45`` turns a work offset), wherever that is said."""
    if not interpreted.settings.dialect.turns_offsets:
        return
    for effect in interpreted.effects:
        angle = effect.block.word("R")
        kind = effect.block.word("L")
        if "data-setting" in effect.non_modal and angle and kind and plain_value(kind) in (2.0, 20.0):
            yield effect.block.line, int(plain_value(angle) != 0.0)


def last_switch(switches: Sequence[tuple[int, int]], line: int) -> int | None:
    """The line before a line that switched something on, None where it is off."""
    at = bisect_right(switches, (line - 1, 1 << 62)) - 1
    return switches[at][0] if at >= 0 and switches[at][1] else None
