"""What a call of a shop would leave behind it, and nobody gives back: found when the profile is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from chipbreak.dialects.modes import Group
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block

_TURNS = "turns, scales or bends the coordinates"
_ZEROS = (2.0, 20.0)  # L of G10: the zero of a coordinate system
# Modes that more than their code would have to give back, and how they are called.
_MODES: Mapping[Group, str] = {
    "units": "changes the units",
    "feed_mode": "changes the feed mode",
    "speed_mode": "changes the speed mode",
    "length_offset": "changes the length offset",
    "modal_macro": "begins or ends a modal macro call",
    "rotation": _TURNS,
    "scaling": _TURNS,
    "mirror": _TURNS,
    "polar": _TURNS,
    "interpolation": _TURNS,
    "polygon": _TURNS,
    "cylinder": _TURNS,
    "diameter": "changes between radius and diameter",
}


def left_behind(block: Block, settings: Settings) -> str:
    """What the block of a call does that would last; empty where it is given back, or does not last."""
    interpreter = Interpreter(settings, Flow(frozenset(), ()))
    known = settings.dialect.m_codes
    # An M beside G65 is a number for the macro; who writes one there may mean what it does.
    meant = tuple(known[int(number)] for number in block.numbers("M") if number in known)
    effect = interpreter.advance(initial_state(settings), block)._replace(functions=meant)
    said = next((said for rule in _RULES if (said := rule(effect))), "")
    return said or next(
        (what for group, what in _MODES.items() if codes_of(block, group, settings.dialect)), ""
    )


def _ends_program(effect: BlockEffect) -> str:
    ends = effect.does("program", "end") or effect.does("subprogram", "return")
    return "ends the program" if ends else ""


def _begins_program(effect: BlockEffect) -> str:
    # A number as the first word: what stands behind it is another program.
    begins = effect.block.word("O") is not None and not effect.block.controls
    return "begins a program" if begins else ""


def _jumps(effect: BlockEffect) -> str:
    jumps = any(control.keyword != "O-CALL" for control in effect.block.controls)
    return "jumps, loops, or waits for another path" if jumps else ""


def _sets_feed(effect: BlockEffect) -> str:
    return "sets the feed F" if effect.after.feed != effect.before.feed else ""


def _calls_tool(effect: BlockEffect) -> str:
    was, now = effect.before, effect.after
    is_called = (was.tool, was.next_tool) != (now.tool, now.next_tool) or effect.does("tool")
    return "calls a tool" if is_called else ""


def _limits_speed(effect: BlockEffect) -> str:
    return "limits the spindle" if effect.after.speed_limit != effect.before.speed_limit else ""


def _moves_zero(effect: BlockEffect) -> str:
    sets = effect.non_modal & {"set-position", "shift"}
    sets |= effect.non_modal & {"data-setting"} if effect.block.has("L", *_ZEROS) else set()
    return "moves the zero" if sets else ""


def _compensates(effect: BlockEffect) -> str:
    # The way back to where the tool was would be offset, too.
    return "begins a compensation of the cutter" if effect.after.modes.compensation != "off" else ""


_RULES: tuple[Callable[[BlockEffect], str], ...] = (
    _ends_program,
    _begins_program,
    _jumps,
    _sets_feed,
    _calls_tool,
    _limits_speed,
    _moves_zero,
    _compensates,
)
