"""Where in a program nothing may be inserted, whatever the modal state says.

Loops, branches and jumps (nobody knows how often the place is passed), lines that could not be read, codes
that nobody knows, blocks with block delete whose effect still lasts, and look-ahead control.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Collection, Iterator

from chipbreak.dialects.modes import Group
from chipbreak.insertion.conditional_state import doubts_of, jumps_of, nests_of, optional_parts
from chipbreak.insertion.subprograms import Subprograms
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import codes_of, plain_value
from chipbreak.operations.main_program import MainProgram
from chipbreak.operations.operations import calls_tool

# Modal groups that must be at rest, and what the user knows them as.
_AT_REST: dict[Group, str] = {
    "compensation": "cutter compensation (G41, G42) is on",
    "rotation": "the coordinate system is rotated (G68)",
    "polar": "polar coordinates are on",
    "interpolation": "polar interpolation is on",
    "cylinder": "cylindrical interpolation (G7.1) is on",
    "polygon": "polygon turning is on",
    "scaling": "scaling (G51) is on",
    "mirror": "mirror image (G51.1) is on",
    "modal_macro": "a modal macro call (G66) is on",
}
# What the numbers of a place depend on.
_PLACING: frozenset[Group] = frozenset({"distance", "units", "work_offset", "length_offset", "diameter"})
# Coolant through the spindle: M9 does not end it, and this profile has no code that is sure to do so.
_THROUGH_ON, _THROUGH_OFF = 88.0, 89.0


class Ground:
    """What is known about the lines of a program before any border is looked for."""

    def __init__(self, interpreted: InterpretedProgram, main: MainProgram) -> None:
        self.interpreted, self.main = interpreted, main
        tool_change = interpreted.settings.dialect.tool_change
        self._nests = list(nests_of(interpreted))
        self._jumps = jumps_of(interpreted)
        subprograms = Subprograms(interpreted)
        self._unknown = dict(_unknown(interpreted, subprograms))
        self._opaque = sorted(self._unknown)
        self._calls = [effect.block.line for effect in interpreted.effects if calls_tool(effect, tool_change)]
        self._doubts = list(
            doubts_of(interpreted, main, subprograms, optional_parts(interpreted, self._nests, self._jumps))
        )
        self._through = list(_through(interpreted))
        self._turned = list(_turned(interpreted))
        self._units = list(_switches_of_units(interpreted))

    def why_not(self, line: int, state: State) -> str:
        """Why nothing may be inserted before a line, or "" when its place and modes allow it."""
        if state.ended or not (self.main.has(line) or line == self.main.last):
            return "it stands in a subprogram or behind the end of the program"
        if any(nest.first < line <= nest.last for nest in self._nests):
            return "it stands in a loop or a branch"
        if self._jumps and self._jumps[0] < line <= self._jumps[1]:
            return "a jump (GOTO) may pass it by, or come back to it"
        if self.interpreted.flow.in_contour(line):
            return "it stands inside the shape of a cycle"
        return self.unreadable(line) or self._doubted(line) or self._not_at_rest(line, state)

    def unreadable(self, line: int) -> str:
        """What nobody knows the effect of, "" where all is known.

        A tool call ends what an unreadable line or a call may have switched, as far as it matters here.
        """
        at = bisect_right(self._calls, line - 1) - 1
        since = self._calls[at] if at >= 0 else self.main.first
        passed = bisect_right(self._opaque, line - 1) - 1
        if passed >= 0 and self._opaque[passed] >= since:
            line = self._opaque[passed]
            return self._unknown[line].format(line=self._user_line(line))
        return ""

    def _doubted(self, line: int) -> str:
        at = bisect_right(self._doubts, line - 1, key=lambda doubt: doubt[0]) - 1
        for what, doubt in self._doubts[at][1].items() if at >= 0 else ():
            if what != "motion" or not self._moves_between(self._doubts[at][0], line):
                return f"line {self._user_line(doubt)} {self._who(doubt)} may or may not have set {what}"
        return ""

    def place_in_doubt(self, line: int, axes: Collection[str]) -> str:
        """Why nobody knows where axes stand that moved while a G91 was in doubt, "" where all is known.

        Each must have been sent to a place again since.
        """
        at = bisect_right(self._doubts, line - 1, key=lambda doubt: doubt[0]) - 1
        while at >= 0 and not self._doubts[at][1].keys() & _PLACING:
            at -= 1
        if at < 0:
            return ""
        closed = self._doubts[at + 1][0] if at + 1 < len(self._doubts) else line
        moves = (effect.move for effect in self.interpreted.effects_of(closed, line))
        placed = {axis for move in moves if move is not None and not move.incremental for axis in move.axes}
        what, doubt = next(one for one in self._doubts[at][1].items() if one[0] in _PLACING)
        return (
            f"it moved after line {self._user_line(doubt)}, which may or may not have set {what}"
            if set(axes) - placed
            else ""
        )

    def _who(self, line: int) -> str:
        block = self.interpreted.program.block(line)
        if block.skip:
            return "with block delete (/)"
        if (self._jumps and line == self._jumps[1]) or any(line == nest.last for nest in self._nests):
            return "ends a loop, a branch or a jump, which"
        return "calls a subprogram, which"

    def _moves_between(self, first: int, last: int) -> bool:
        program = self.interpreted.program
        shapes = {int(i) for i in program.plain[first:last]}
        return any(i >= 0 and program.shapes[i].motion is not None for i in shapes)

    def _not_at_rest(self, line: int, state: State) -> str:
        for group, what in _AT_REST.items():
            if state.modes.value(group) != "off":
                return what
        dialect = self.interpreted.settings.dialect
        is_surface = state.modes.speed_mode == "surface"
        if is_surface and not (dialect.keeps_modes or dialect.is_lathe):
            return "constant surface speed (G96) is on: S of a check would be a speed of the edge"
        turned, through = _last(self._turned, line), _last(self._through, line)
        if turned is not None:
            return f"the coordinate system is rotated (G10 with R, line {self._user_line(turned)})"
        if through is not None:
            where = self._user_line(through)
            return f"coolant through the spindle (M88, line {where}) is on: no M89 behind it"
        if is_surface and dialect.surface_limit and state.speed_limit is not None:
            return "constant surface speed (G96) has a limit (D), which the macros cannot give back"
        crossed = self._crossed(line, state) if dialect.converts_feed else ""
        if crossed:
            return crossed
        if state.modes.path == "tapping":
            return "tapping mode (G63) is on"
        if state.modes.look_ahead and not self._looks_no_further(line):
            return "look-ahead control (G5, G5.1, G8) is on"
        return ""

    def _crossed(self, line: int, state: State) -> str:
        """F and the P of G64 from before G20 or G21: given back as a number they would mean another value."""
        at = bisect_right(self._units, (line - 1, True, True)) - 1
        if at < 0:
            return ""
        switch, has_feed, has_tolerance = self._units[at]
        has_feed = has_feed and state.feed is None
        if has_tolerance:
            path = [
                s
                for s in self.interpreted.effects
                if codes_of(s.block, "path", self.interpreted.settings.dialect)
            ]
            has_tolerance = not any(switch <= effect.block.line < line for effect in path)
        what = "F" if has_feed else "the P of G64" if has_tolerance else ""
        return what and f"{what} is from before the change of units in line {self._user_line(switch)}"

    def _looks_no_further(self, line: int) -> bool:
        """True when the last such code switched it off: ``G8 P0``, ``G5 P0``, ``G5.1 Q0``."""
        dialect = self.interpreted.settings.dialect
        for effect in reversed(self.interpreted.effects):
            if effect.block.line < line and codes_of(effect.block, "look_ahead", dialect):
                return effect.block.has("P", 0) or effect.block.has("Q", 0)
        return True

    def _user_line(self, line: int) -> int:
        return self.interpreted.program.source.place(line).line


def _last(switches: list[tuple[int, int]], line: int) -> int | None:
    """The line before a line that switched something on, None where it is off."""
    at = bisect_right(switches, (line - 1, 1 << 62)) - 1
    return switches[at][0] if at >= 0 and switches[at][1] else None


def _unknown(interpreted: InterpretedProgram, subprograms: Subprograms) -> Iterator[tuple[int, str]]:
    """(line, why) wherever nobody knows what was left in force."""
    for effect in interpreted.effects:
        unknown_code = _unknown_code(effect, interpreted)
        if effect.block.opaque:
            yield effect.block.line, "line {line} before it cannot be read"
        elif unknown_code:
            yield (
                effect.block.line,
                f"line {{line}} before it says {unknown_code}, which this profile does not know",
            )
        elif subprograms.changes(effect) is None:
            what = "calls tools" if subprograms.call_tools(effect) else "is not in this file"
            yield (
                effect.block.line,
                f"what is called in line {{line}} {what}; nobody knows what it leaves in force",
            )


def _unknown_code(effect: BlockEffect, interpreted: InterpretedProgram) -> str:
    """A G code that may have switched anything, "" where there is none."""
    for word in effect.block.words_of("G"):
        value = plain_value(word)
        if math.isnan(value) or round(value * 10) not in interpreted.settings.dialect.g_codes:
            return effect.block.text_of(word)
    return ""


def _through(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether coolant runs through the spindle behind it), wherever that is said."""
    dialect = interpreted.settings.dialect
    if dialect.is_lathe or dialect.tool_change != "M6":
        return
    for effect in interpreted.effects:
        if effect.block.has("M", _THROUGH_ON):
            yield effect.block.line, 1
        elif effect.block.has("M", _THROUGH_OFF) or calls_tool(effect, dialect.tool_change):
            yield effect.block.line, 0


def _switches_of_units(interpreted: InterpretedProgram) -> Iterator[tuple[int, bool, bool]]:
    """(line, whether an F, whether a tolerance is in force there from other units)."""
    has_feed = has_tolerance = False
    for effect in interpreted.effects:
        before, after = effect.before, effect.after
        has_feed |= before.feed is not None  # behind a loop it is not known any more, but in force
        if before.modes.units != after.modes.units:
            has_tolerance = has_tolerance or "P" in before.path_words
            yield effect.block.line, has_feed, has_tolerance
        elif codes_of(effect.block, "path", interpreted.settings.dialect):
            has_tolerance = False


def _turned(interpreted: InterpretedProgram) -> Iterator[tuple[int, int]]:
    """(line, whether LinuxCNC's ``G10 L2 P1 R45`` turns a work offset), wherever that is said."""
    if not interpreted.settings.dialect.turns_offsets:
        return
    for effect in interpreted.effects:
        angle, kind = effect.block.word("R"), effect.block.word("L")
        if "data-setting" in effect.non_modal and angle and kind and plain_value(kind) in (2.0, 20.0):
            yield effect.block.line, int(plain_value(angle) != 0.0)
