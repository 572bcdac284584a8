"""What a program shares with the programs behind the calls: variables, and program numbers.

A macro that works in #105 leaves its limit there, and ``X#105`` after the check goes to that place.  So a
program that names one of their variables anywhere gets no check that calls them.  A program that calls P8900
with X and Y means the program of another maker, which then is on the control instead of ours; one that
defines O8901 would be called itself.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

from chipbreak.checks.findings import SHARED_NUMBER, SHARED_OFFSET, SHARED_VARIABLE
from chipbreak.checks.ways_out import (
    OR_MOVE_THE_STORE,
    OTHER_CALLS,
    RENAME_THE_PROGRAM,
    USE_OTHER_OFFSETS,
    USE_OTHER_VARIABLES,
)
from chipbreak.dialects import BUILT_IN, PROBE_MAKERS, MacroSet
from chipbreak.dialects.check_programs import SETTER
from chipbreak.dialects.modes import UNSAID
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program
from chipbreak.syntax.variables import variables_of
from chipbreak.text.named_tuple import NamedTuple

_ONE_PROGRAM = 10_000  # M98 P38900 calls O8900 three times
_NO_ARGUMENTS = frozenset("GPLN")
_PROGRAM = re.compile(r"\bP(\d+)\b")


class Clash(NamedTuple):
    """The line that shares something, what is wrong with it, and the way out."""

    code: str
    line: int
    message: str
    help: str


class _Needs(NamedTuple):
    """Variables of the macros: those they work in, those of their store, and how their names begin."""

    working: range
    store: range
    prefix: str

    def has(self, key: int | str | None) -> bool:
        """True for a variable that is theirs, or may be: one by a number worked out."""
        if isinstance(key, str):
            return bool(self.prefix) and key.startswith(self.prefix)
        return key is None or key in self.working or key in self.store

    def shown(self, key: int | str | None) -> str:
        """The variables that such a one is among."""
        if isinstance(key, str):
            return f"those that begin with {self.prefix}"
        return " and ".join(f"#{one[0]} to #{one[-1]}" for one in (self.working, self.store) if one)


class _Call(NamedTuple):
    """A call of a program by its number; ``letters`` of its arguments, None where it takes none (M98)."""

    line: int
    number: int
    letters: frozenset[str] | None

    @property
    def how(self) -> str:
        """Its arguments, as a message says them."""
        if self.letters is None:
            return " without arguments"
        return f" with {', '.join(sorted(self.letters))}" if self.letters else " without arguments"


def clash_of(interpreted: InterpretedProgram) -> Clash | None:
    """The first thing that a program shares with the programs of its calls, None where there is none.

    A shop that describes calls of its own knows its programs.
    """
    settings = interpreted.settings
    if settings.checks.calls in settings.call_sets:
        return None
    macros = settings.dialect.macros
    keeps = settings.dialect.call_sets[settings.checks.calls].keeps
    if keeps:
        return _shared_offset(interpreted, keeps)
    if settings.checks.calls not in (BUILT_IN, SETTER) or macros is None:
        return _defined_number(interpreted, _numbers_of(settings), "")
    macros = _moved(macros, settings)
    return (
        _defined_number(interpreted, macros.numbers, macros.name_prefix)
        or _called_number(interpreted, macros)
        or _shared_variable(interpreted, macros)
    )


def _shared_offset(interpreted: InterpretedProgram, keeps: str) -> Clash | None:
    """Something by which the length that the checks keep in a work offset would mean another one."""
    for effect in interpreted.effects:
        used = _moves_offset(effect, keeps)
        if used:
            said = f"this program uses {used}, and the checks keep the tool's length in {keeps}"
            return Clash(SHARED_OFFSET, effect.block.line, f"left out: all checks; {said}", USE_OTHER_OFFSETS)
    return None


def _moves_offset(effect: BlockEffect, keeps: str) -> str:
    modes = effect.after.modes
    found = {
        keeps: modes.work_offset == keeps,
        "G92": "set-position" in effect.non_modal,
        "G10": "data-setting" in effect.non_modal,
        "G43.1": modes.length_offset not in ("off", UNSAID),
        "G93": modes.feed_mode == "inverse",
    }
    return next((name for name, is_used in found.items() if is_used), "")


def _moved(macros: MacroSet, settings: Settings) -> MacroSet:
    """The programs with the numbers that the profile gives them."""
    if not macros.numbers:
        return macros
    programs = settings.macros.first_program - macros.numbers[0]
    first_variable = settings.macros.first_variable
    return macros._replace(
        numbers=range(settings.macros.first_program, settings.macros.first_program + len(macros.numbers)),
        arguments={number + programs: letters for number, letters in macros.arguments.items()},
        working=range(first_variable, first_variable + len(macros.working)),
    )


def _numbers_of(settings: Settings) -> frozenset[int]:
    """The program numbers that the calls of a maker's set name."""
    templates = settings.dialect.call_sets[settings.checks.calls].blocks.values()
    return frozenset(int(hit[1]) for texts in templates for text in texts for hit in _PROGRAM.finditer(text))


def _shared_variable(interpreted: InterpretedProgram, macros: MacroSet) -> Clash | None:
    needs = _needs(interpreted.settings, macros)
    for line, key in _named(interpreted.program):
        if needs.has(key):
            uses = f"this program uses {_variable(key)}, and the macros they call use {needs.shown(key)}"
            way_out = USE_OTHER_VARIABLES + (OR_MOVE_THE_STORE if key in needs.store else "")
            return Clash(SHARED_VARIABLE, line, f"left out: all checks; {uses}", way_out)
    return None


def _needs(settings: Settings, macros: MacroSet) -> _Needs:
    store = range(settings.macros.store_first, settings.macros.store_last + 1)
    return _Needs(macros.working, store, macros.prefix)


def _defined_number(
    interpreted: InterpretedProgram, numbers: Collection[int], name_prefix: str
) -> Clash | None:
    """A program or a subprogram with a number or a name that a check would call."""
    for block in interpreted.program.event_blocks():
        name = _defined(block, numbers, name_prefix)
        if name:
            why = f"{name} is defined in this program, and the checks would call a program of that name"
            return Clash(SHARED_NUMBER, block.line, f"left out: all checks; {why}", RENAME_THE_PROGRAM)
    return None


def _defined(block: Block, numbers: Collection[int], name_prefix: str) -> str:
    for control in block.controls:
        is_ours = bool(name_prefix) and control.label.lower().startswith(f"<{name_prefix}")
        if control.keyword == "O-SUB" and is_ours:
            return f"o{control.label}"
    number = None if block.controls else block.number("O")
    return f"O{number:z.0f}" if number in numbers else ""


def _called_number(interpreted: InterpretedProgram, macros: MacroSet) -> Clash | None:
    """A call that means another maker's program: first of a number of ours, or else of one beside ours."""
    others = [call for call in _calls(interpreted) if not _is_ours(call, macros)]
    for call in others:
        if call.number in macros.numbers:
            said = f"this program calls P{call.number}{call.how}"
            return _not_ours(call, f"{said}, as no check does: another program has that number")
    for call in others:
        makers = makers_of(call.number, macros.numbers)
        if makers:
            why = (
                f"this program calls P{call.number}, a number of probe makers ({', '.join(makers)}), whose"
                f" programs also take P{macros.numbers[0]} to P{macros.numbers[-1]}"
            )
            return _not_ours(call, why)
    return None


def makers_of(number: int, ours: range) -> list[str]:
    """The makers among whose programs a number is, where some of ours are among theirs."""
    return [
        maker
        for maker, theirs in PROBE_MAKERS.items()
        if number in theirs and any(one in theirs for one in ours)
    ]


def _not_ours(call: _Call, why: str) -> Clash:
    return Clash(SHARED_NUMBER, call.line, f"left out: all checks; {why}", OTHER_CALLS)


def _calls(interpreted: InterpretedProgram) -> Iterator[_Call]:
    for effect in interpreted.effects:
        number = effect.block.number("P")
        if number is None or number != int(number):
            continue
        if _calls_macro(effect, interpreted):
            letters = frozenset(word.address for word in effect.block.words) - _NO_ARGUMENTS
            yield _Call(effect.block.line, int(number), letters)
        elif calls_subprogram(effect) and not effect.does("subprogram", "local-call"):
            yield _Call(effect.block.line, int(number) % _ONE_PROGRAM, None)


def _calls_macro(effect: BlockEffect, interpreted: InterpretedProgram) -> bool:
    """G65, or G66 and its like."""
    return "macro-call" in effect.non_modal or bool(
        codes_of(effect.block, "modal_macro", interpreted.settings.dialect)
    )


def _is_ours(call: _Call, macros: MacroSet) -> bool:
    """True for a call with the letters that our program takes; all but the first want the tool."""
    letters = macros.arguments.get(call.number)
    if letters is None or call.letters is None:
        return False
    return call.letters <= set(letters) and ("T" in call.letters or "T" not in letters)


def _variable(key: int | str | None) -> str:
    if key is None:
        return "a variable by a number worked out"
    return f"#<{key}>" if isinstance(key, str) else f"#{key}"


def _named(program: Program) -> Iterator[tuple[int, int | str | None]]:
    for block in program.event_blocks():
        for key in variables_of(block):
            yield block.line, key
