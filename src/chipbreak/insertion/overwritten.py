"""What the next blocks say again before anything counts on it: that need not be put back."""

from __future__ import annotations

from collections.abc import Iterator

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.operations import calls_tool

# A program says these things in a row; who looks further does not find more.
_HORIZON = 40
# Ways home, away from the work.
_WAYS_HOME = frozenset({"home", "machine"})
# M codes that ask nothing of a spindle that turns.
_IDLE_FUNCTIONS = frozenset({"coolant", "coolant_through", "spindle"})


def spindle_is_overwritten(interpreted: InterpretedProgram, line: int) -> bool:
    """True where the program starts or stops the spindle, or ends, before a block counts on it."""
    return _says_first(interpreted, line, "spindle", ())


def coolant_is_overwritten(interpreted: InterpretedProgram, line: int) -> bool:
    """True where the program ends all coolant, or itself, before a block counts on it."""
    return _says_first(interpreted, line, "coolant", ("off",))


def feed_is_said(interpreted: InterpretedProgram, line: int) -> bool:
    """True where the next block that feeds says F, or the program ends before one."""
    for effect in interpreted.effects_of(line, interpreted.program.source.body.stop):
        block = effect.block
        if effect.after.ended:
            return True
        if block.opaque or block.controls:
            return False
        if effect.says("F"):
            return not block.skip and not block.has_macro
        if effect.move is not None and effect.move.kind != "rapid":
            return False
    return True


def _says_first(interpreted: InterpretedProgram, line: int, group: str, values: tuple[str, ...]) -> bool:
    for effect in _ahead(interpreted, line):
        says = effect.does(group, *values) or effect.does("program", "end")
        # A dwell in the block itself comes behind what its M code does.
        if not _is_idle(effect, interpreted, _WAYS_HOME | {"dwell"} if says else _WAYS_HOME):
            return False
        if says:
            return True
    return False


def _ahead(interpreted: InterpretedProgram, line: int) -> Iterator[BlockEffect]:
    yield from interpreted.effects_of(line, min(line + _HORIZON, interpreted.program.source.body.stop))


def _is_idle(effect: BlockEffect, interpreted: InterpretedProgram, free: frozenset[str]) -> bool:
    """True for a block that does the same whether the spindle turns and coolant flows or not."""
    block = effect.block
    if block.is_empty:
        return not block.opaque
    is_always_run = not (block.skip or block.opaque or block.has_macro or block.controls or block.assignments)
    is_plain = is_always_run and block.line not in interpreted.flow.targets and not effect.in_contour
    goes_home = not effect.feeds_others if effect.move is None else _is_way_home(effect)
    does_little = goes_home and effect.non_modal <= free and _has_idle_functions(effect, interpreted)
    return is_plain and does_little and not calls_tool(effect, interpreted.settings.dialect)


def _is_way_home(effect: BlockEffect) -> bool:
    """G53 G1 feeds."""
    is_rapid = effect.move is not None and effect.move.kind == "rapid"
    return is_rapid and bool(effect.non_modal & _WAYS_HOME)


def _has_idle_functions(effect: BlockEffect, interpreted: InterpretedProgram) -> bool:
    known = interpreted.settings.dialect.m_codes
    if any(number not in known for number in effect.block.numbers("M")):
        return False
    return effect.does("program", "end") or all(code.group in _IDLE_FUNCTIONS for code in effect.functions)
