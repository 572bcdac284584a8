"""Where in a program nothing may be inserted, whatever brought the tool there.

Loops, branches and jumps (it is not known how often the place is passed), lines that could not be read,
codes that the profile does not know, blocks with block delete whose effect still lasts, modes that a check
could not give back, and look-ahead control.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping
from itertools import takewhile
from math import isnan
from typing import ClassVar

from chipbreak.dialects.base import PATH, WAIT
from chipbreak.dialects.modes import Group
from chipbreak.insertion.conditional_state import conditional_state, jumps_of, nests_of, optional_parts
from chipbreak.insertion.lasting_effects import (
    UnitSwitch,
    coolant_through,
    last_switch,
    orientations,
    turned_offsets,
    unit_switches,
    unreadable_lines,
    unsure_spindles,
)
from chipbreak.insertion.looking_back import effects_before
from chipbreak.insertion.subprograms import Subprograms
from chipbreak.insertion.sure_effects import words_for
from chipbreak.insertion.ways_out import CALL_THE_TOOL_AGAIN, MAKE_A_PLACE, ONE_PATH_A_FILE, Obstacle
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.paths import marks_that
from chipbreak.model.words import codes_of
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


class Obstacles:
    """What is known about the lines of a program before any candidate is looked at.

    ``tool_changes``: the lines that change the tool, in order.  ``says_surface_speed``: what is inserted can
    say a surface speed (G96) and its limit again.
    """

    def __init__(
        self, interpreted: InterpretedProgram, main: MainProgram, *, says_surface_speed: bool = False
    ) -> None:
        self._left_out = self._OF_SURFACE_SPEED if says_surface_speed else ()
        self.interpreted = interpreted
        self.main = main
        self.dialect = interpreted.settings.dialect
        self._paths = self._why_of_paths()
        subprograms = Subprograms(interpreted)
        self._nests = list(nests_of(interpreted))
        self._jumps = jumps_of(interpreted)
        self._unreadable = list(unreadable_lines(interpreted, subprograms))
        calls = (effect for effect in interpreted.effects if calls_tool(effect, self.dialect))
        self.tool_changes = [effect.block.line for effect in calls]
        parts = optional_parts(interpreted, self._nests, self._jumps)
        self._conditional = list(conditional_state(interpreted, main, subprograms, self._nests, parts))
        self._through = list(coolant_through(interpreted))
        self._turned = list(turned_offsets(interpreted))
        self._oriented = list(orientations(interpreted))
        self._unsure_spindles = list(unsure_spindles(interpreted))
        self._units = list(unit_switches(interpreted))

    def at(self, line: int, state: State) -> Obstacle | None:
        """What does not let anything be inserted before a line, None when its place and modes allow it."""
        for rule in self._RULES:
            why = "" if rule in self._left_out else rule(self, line, state)
            if why:
                return Obstacle(why, self._WAYS_OUT.get(rule, MAKE_A_PLACE))
        return None

    def why_place_is_conditional(self, line: int, axes: Collection[str]) -> str:
        """Why it is not known where axes are that moved while a G91 was conditional, "" where all is known.

        Each must have been sent to a place again since.
        """
        at = self._conditional_at(line)
        while at >= 0 and not self._conditional[at].setters.keys() & _PLACING:
            at -= 1
        if at < 0:
            return ""
        closed = self._conditional[at + 1].line if at + 1 < len(self._conditional) else line
        moves = (effect.move for effect in self.interpreted.effects_of(closed, line))
        placed = {axis for move in moves if move is not None and not move.incremental for axis in move.axes}
        if not set(axes) - placed:
            return ""
        what, setter = next(one for one in self._conditional[at].setters.items() if one[0] in _PLACING)
        return (
            f"it moved after line {self._user_line(setter)}, which may or may not have set {words_for(what)}"
        )

    def runs_once(self, line: int) -> bool:
        """False for a line in a loop or a branch, or where a jump may pass by or come back."""
        inside = any(nest.first <= line <= nest.last for nest in self._nests)
        return not inside and not (self._jumps and self._jumps[0] <= line <= self._jumps[1])

    def is_oriented(self, line: int) -> bool:
        """True where M19 holds the spindle at an angle before a line."""
        return last_switch(self._oriented, line) is not None

    def spindle_is_unsure(self, line: int) -> bool:
        """True where a tool change may have stopped the spindle before a line."""
        return last_switch(self._unsure_spindles, line) is not None

    def _conditional_at(self, line: int) -> int:
        """Index of what is conditional before a line, -1 where nothing has been yet."""
        return bisect_right(self._conditional, line - 1, key=lambda one: one.line) - 1

    # --- the rules: why nothing may be inserted before a line, "" where one has nothing to say ------------
    def _outside_the_main_program(self, line: int, state: State) -> str:
        is_inside = self.main.has(line) or line == self.main.last
        return (
            "" if is_inside and not state.ended else "it is in a subprogram or after the end of the program"
        )

    def _in_one_of_several_paths(self, _line: int, _: State) -> str:
        return self._paths

    def _in_a_nest(self, line: int, _: State) -> str:
        is_in = any(nest.first < line <= nest.last for nest in self._nests)
        return "it is in a loop or a branch" if is_in else ""

    def _between_jumps(self, line: int, _: State) -> str:
        is_between = self._jumps is not None and self._jumps[0] < line <= self._jumps[1]
        return "a jump (GOTO) may pass it by, or come back to it" if is_between else ""

    def _in_a_contour(self, line: int, _: State) -> str:
        return "it is inside the shape of a cycle" if self.interpreted.flow.in_contour(line) else ""

    def _behind_what_is_unreadable(self, line: int, _: State) -> str:
        """A tool call ends what an unreadable line or a call may have switched, as far as it matters here."""
        at = bisect_right(self.tool_changes, line - 1) - 1
        since = self.tool_changes[at] if at >= 0 else self.main.first
        passed = bisect_right(self._unreadable, line - 1, key=lambda one: one.line) - 1
        if passed < 0 or self._unreadable[passed].line < since:
            return ""
        unreadable = self._unreadable[passed]
        return unreadable.why(self._user_line(unreadable.line))

    def _is_conditional(self, line: int, _: State) -> str:
        at = self._conditional_at(line)
        if at < 0:
            return ""
        for what, setter in self._conditional[at].setters.items():
            if what != "motion" or not self._moves_between(self._conditional[at].line, line):
                where = f"line {self._user_line(setter)} {self._how(setter)}"
                return f"{where} may or may not have set {words_for(what)}"
        return ""

    def _group_is_on(self, _: int, state: State) -> str:
        return next((what for group, what in _AT_REST.items() if state.modes.value(group) != "off"), "")

    def _surface_speed_is_on(self, _: int, state: State) -> str:
        if state.modes.speed_mode != "surface" or self.dialect.keeps_modes or self.dialect.is_lathe:
            return ""
        return "constant surface speed (G96) is on: S of a check would be a speed of the edge"

    def _offset_is_turned(self, line: int, _: State) -> str:
        turned = last_switch(self._turned, line)
        where = "" if turned is None else f"G10 with R, line {self._user_line(turned)}"
        return where and f"the coordinate system is rotated ({where})"

    def _coolant_goes_through(self, line: int, _: State) -> str:
        through = last_switch(self._through, line)
        where = "" if through is None else f"M88, line {self._user_line(through)}"
        return where and f"coolant through the spindle ({where}) is on: no M89 after it"

    def _surface_speed_has_a_limit(self, _: int, state: State) -> str:
        is_limited = bool(self.dialect.surface_limit) and state.speed_limit is not None
        if state.modes.speed_mode != "surface" or not is_limited:
            return ""
        return "constant surface speed (G96) has a limit (D), which the macros cannot give back"

    def _value_is_in_other_units(self, line: int, state: State) -> str:
        """F and the P of G64 from before G20 or G21: given back as a number they would mean another value."""
        at = bisect_right(self._units, line - 1, key=lambda one: one.line) - 1
        if at < 0 or not self.dialect.converts_feed:
            return ""
        switch = self._units[at]
        feed = state.feed
        is_open = feed is None or isnan(feed.value)  # it may be one from before
        has_feed = switch.has_feed and (is_open or (feed is not None and feed.units != state.modes.units))
        what = "F" if has_feed else "the P of G64" if self._keeps_tolerance(switch, line) else ""
        return what and f"{what} is from before the change of units in line {self._user_line(switch.line)}"

    def _keeps_tolerance(self, switch: UnitSwitch, line: int) -> bool:
        if not switch.has_tolerance:
            return False
        since = takewhile(
            lambda effect: effect.block.line >= switch.line, effects_before(self.interpreted, line)
        )
        return not any(codes_of(effect.block, "path", self.dialect) for effect in since)

    def _taps(self, _: int, state: State) -> str:
        return "tapping mode (G63) is on" if state.modes.path == "tapping" else ""

    def _looks_ahead(self, line: int, state: State) -> str:
        if not state.modes.look_ahead or self._look_ahead_is_off(line):
            return ""
        return "look-ahead control (G5, G5.1, G8) is on"

    def _look_ahead_is_off(self, line: int) -> bool:
        """True when the last such code switched it off: ``G8 P0``, ``G5 P0``, ``G5.1 Q0``."""
        for effect in effects_before(self.interpreted, line):
            if codes_of(effect.block, "look_ahead", self.dialect):
                return effect.block.has("P", 0) or effect.block.has("Q", 0)
        return True

    _RULES = (
        _in_one_of_several_paths,
        _outside_the_main_program,
        _in_a_nest,
        _between_jumps,
        _in_a_contour,
        _behind_what_is_unreadable,
        _is_conditional,
        _group_is_on,
        _surface_speed_is_on,
        _offset_is_turned,
        _coolant_goes_through,
        _surface_speed_has_a_limit,
        _value_is_in_other_units,
        _taps,
        _looks_ahead,
    )
    _OF_SURFACE_SPEED = (_surface_speed_is_on, _surface_speed_has_a_limit)
    _WAYS_OUT: ClassVar[Mapping[Callable[[Obstacles, int, State], str], str]] = {
        _behind_what_is_unreadable: CALL_THE_TOOL_AGAIN,
        _in_one_of_several_paths: ONE_PATH_A_FILE,
    }

    def _why_of_paths(self) -> str:
        """Why nothing may be inserted into a program of several paths, "" where it has one."""
        for effect in self.interpreted.effects:
            for mark in marks_that(effect.block, self.dialect, PATH, WAIT):
                where = f"{mark.label}, line {self._user_line(effect.block.line)}"
                return f"the program has several paths ({where}), of which none is followed into another"
        return ""

    # --- words of messages ----------------------------------------------------------------------------
    def _how(self, line: int) -> str:
        """How a line has left open what it sets."""
        block = self.interpreted.program.block(line)
        if block.is_optional:
            return "with block delete (/)" if block.skip else "with its condition"
        if (self._jumps and line == self._jumps[1]) or any(line == nest.last for nest in self._nests):
            return "ends a loop, a branch or a jump, which"
        return "calls a subprogram, which"

    def _moves_between(self, first: int, last: int) -> bool:
        program = self.interpreted.program
        shapes = {int(i) for i in program.plain[first:last]}
        return any(i >= 0 and program.shapes[i].motion is not None for i in shapes)

    def _user_line(self, line: int) -> int:
        return self.interpreted.program.source.place(line).line
