"""What the rest of a program has from the lines before it, and a start block cannot give: reasons in words.

Variables, other origins, shapes of cycles, rotary axes, a feed or a tool that is not known.  What is plain is
said again: a variable that was set to a number, the last place of a rotary axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from functools import cached_property

import numpy as np

from chipbreak.dialects.base import NON_MODAL
from chipbreak.insertion.looking_back import effects_before
from chipbreak.insertion.obstacles import Obstacles
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import contour_calls, sequence_lines
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.restart.restart_case import RestartCase
from chipbreak.restart.standing import Standing
from chipbreak.restart.variables import Variables, variables_before
from chipbreak.syntax.shapes import bits_of

# How far it is looked for the next F: a program says it with its first cut.
_HORIZON = 2000
_ROTARY = "ABC"
# Cycles of Fanuc-type lathes that are programmed in two lines.
_TWO_LINES = frozenset({"rough-cycle", "peck-cycle", "thread-cycle"})


class Before:
    """A line at which a program might be started, and what stands before it."""

    def __init__(self, program: Standing, obstacles: Obstacles, case: RestartCase) -> None:
        self.program = program
        self.obstacles = obstacles
        self.case = case
        self.interpreted: InterpretedProgram = program.original
        self.dialect = self.interpreted.settings.dialect
        self.line = case.line

    def user_line(self, line: int) -> int:
        """The number of a line of the original in the user's file."""
        return self.program.number(int(self.program.places[line]))

    def effects(self) -> Iterator[BlockEffect]:
        """The blocks of the main program before the line that are more than plain motion."""
        for effect in self.interpreted.effects:
            if effect.block.line >= self.line:
                return
            if self.program.main.has(effect.block.line):
                yield effect

    @cached_property
    def variables(self) -> Variables:
        """The variables that the lines before have set."""
        return variables_before(self.interpreted, self.program.main, self.obstacles, self.line)


def _variables(before: Before) -> str:
    unknown = before.variables.unknown
    if not unknown:
        return ""
    key, line = next(iter(unknown.items()))
    return f"the rest reads #{_shown(key)}, which line {before.user_line(line)} has set"


def _shown(key: int | str) -> str:
    return f"<{key}>" if isinstance(key, str) else str(key)


def _other_origin(before: Before) -> str:
    """G50 X Z, G92, G52, G10: what they have set is in the control, and what is in it now nobody knows."""
    for effect in before.effects():
        names_axes = effect.block.has_any(before.interpreted.settings.axis_words.axes)
        if ("set-position" in effect.non_modal and names_axes) or "data-setting" in effect.non_modal:
            what = effect.block.text.strip()[:30]
            return f"line {before.user_line(effect.block.line)} ({what}) has set origins or offsets"
        if "store-home" in effect.non_modal:
            return f"line {before.user_line(effect.block.line)} has stored a place for G28 or G30"
        if "shift" in effect.non_modal and names_axes:
            return f"line {before.user_line(effect.block.line)} has shifted the origin"
    return ""


def _modes_are_kept(before: Before) -> str:
    return "M70 has kept modes that the rest gives back" if before.case.state.kept is not None else ""


def _shape_stands_before(before: Before) -> str:
    """A cycle behind the line whose P and Q name a shape in front of it."""
    for call in contour_calls(before.interpreted.program, before.dialect):
        if call.line >= before.line and call.first is not None and call.first < before.line:
            lines = f"{before.user_line(call.first)} to {before.user_line(call.last or call.first)}"
            return f"the cycle in line {before.user_line(call.line)} reads its shape from lines {lines}"
    return ""


def _between_the_lines_of_a_cycle(before: Before) -> str:
    """``G71 U2. R1.`` says what the ``G71 P10 Q20`` behind it works with."""
    was = next(effects_before(before.interpreted, before.line), None)
    now = next((one for one in before.interpreted.effects if one.block.line >= before.line), None)
    if was is None or now is None or not was.non_modal & now.non_modal & _TWO_LINES:
        return ""
    return "it is between the two lines of a cycle"


def _called_block_stands_before(before: Before) -> str:
    """``M97 P100`` behind the line, and N100 in front of it."""
    calls = [one for one in before.interpreted.effects if one.does("subprogram", "local-call")]
    calls = [one for one in calls if one.block.line >= before.line]
    numbers = sequence_lines(before.interpreted.program) if calls else {}
    for effect in calls:
        target = effect.block.number("P")
        places = [] if target is None else numbers.get(int(target), [])
        if any(before.program.main.has(place) and place < before.line for place in places):
            return f"line {before.user_line(effect.block.line)} calls a block that stands before"
    return ""


def _tool_is_not_known(before: Before) -> str:
    state = before.case.state
    calls = [line for line in before.obstacles.tool_changes if line < before.line]
    if before.case.calls_tool or not calls or state.tool is not None:
        return ""
    return f"which tool line {before.user_line(calls[-1])} has called is not known"


def _speed_is_not_known(before: Before) -> str:
    speed = before.case.in_force.speed
    is_known = speed is not None and speed.value > 0.0
    return (
        "the spindle must turn, and its S cannot be known" if before.case.needs_speed and not is_known else ""
    )


def _limit_is_not_known(before: Before) -> str:
    limit = before.case.in_force.speed_limit
    is_unknown = limit is not None and math.isnan(limit.value)
    return "the limit of the spindle speed is a variable" if is_unknown else ""


def _speed_is_in_other_units(before: Before) -> str:
    """Such a control keeps the number of S and reads it in the units of the moment."""
    state = before.case.in_force
    if state.speed is None or state.modes.speed_mode != "surface" or not before.dialect.feed_before_units:
        return ""
    return "S is from before the change of units" if state.speed.units != state.modes.units else ""


def _feed_is_not_known(before: Before) -> str:
    """An F is in force that cannot be known, and the next cut counts on it."""
    if not _has_lost_its_feed(before):
        return ""
    stop = min(before.line + _HORIZON, before.interpreted.program.source.body.stop)
    for effect in before.interpreted.effects_of(before.line, stop):
        if effect.in_contour:
            continue  # its F is that of G70 alone
        if effect.says("F") or effect.after.ended:
            return ""
        feeds = effect.move is not None and effect.move.kind != "rapid"
        if feeds or _calls(effect):
            return f"which F is in force in line {before.user_line(effect.block.line)} is not known"
    return ""


def _has_lost_its_feed(before: Before) -> bool:
    """A call since the last F may have set another; behind a loop it is not known, but in force."""
    said = next(_lines_with(before, "F"), -1)
    since = [effect for effect in before.effects() if effect.block.line > said]
    if any(_calls(effect) for effect in since):
        return True
    feed = before.case.in_force.feed
    is_known = feed is not None and not math.isnan(feed.value)
    ends = any(codes_of(effect.block, "feed_mode", before.dialect) for effect in since)
    return said >= 0 and not is_known and not ends


def _calls(effect: BlockEffect) -> bool:
    return calls_subprogram(effect) or "macro-call" in effect.non_modal


def _rotary_axis_is_not_known(before: Before) -> str:
    """Rotary axes are put back where a mill has sent them to a number."""
    for letter, effect in rotary_places(before).items():
        word = effect.block.word(letter)
        is_plain = word is not None and word.number is not None and not effect.block.is_optional
        is_placed = effect.before.modes.distance == "absolute" == effect.after.modes.distance
        if not (is_plain and is_placed and effect.move is not None) or before.dialect.is_lathe:
            return f"where axis {letter} stands after line {before.user_line(effect.block.line)} is not known"
    return ""


def rotary_places(before: Before) -> dict[str, BlockEffect]:
    """The last block before the line that moves each rotary axis."""
    linear = before.interpreted.settings.axis_words.axes
    letters = [one for one in _ROTARY if one in before.dialect.axis_letters and one not in linear]
    found: dict[str, BlockEffect] = {}
    for line in reversed(list(_lines_with(before, letters))):
        effect = before.interpreted.effect(line)
        taken = {letter for word in effect.block.words_of("GM") for letter in _taken(word.number, before)}
        if effect.non_modal & {"macro-call", "service"} or effect.after.modes.motion.endswith("-cycle"):
            continue
        found |= {one: effect for one in letters if effect.block.has(one) and one not in taken}
    return found


def _lines_with(before: Before, letters: Collection[str]) -> Iterator[int]:
    """The lines of the main program before the line that have one of these letters, the last one first."""
    program = before.interpreted.program
    plain = np.flatnonzero(program.bits[: before.line] & bits_of("".join(letters)))
    special = {one.block.line for one in before.effects() if one.block.has_any(letters)}
    for line in sorted(special.union(plain.tolist()), reverse=True):
        if before.program.main.has(line):
            yield line


def _taken(number: float | None, before: Before) -> str:
    """Letters that a code of the block takes for itself: A of a thread."""
    code = None if number is None else before.dialect.g_codes.get(round(number * 10))
    if code is None:
        return ""
    return before.dialect.own_words.get(code, "") if code.group in (NON_MODAL, "modal_macro") else ""


# In the order in which a user would look; the first that says something is the reason.
WHY: tuple[Callable[[Before], str], ...] = (
    _other_origin,
    _modes_are_kept,
    _tool_is_not_known,
    _shape_stands_before,
    _between_the_lines_of_a_cycle,
    _called_block_stands_before,
    _variables,
    _rotary_axis_is_not_known,
    _speed_is_not_known,
    _limit_is_not_known,
    _speed_is_in_other_units,
    _feed_is_not_known,
)
