"""Subprograms that are called before a cut: what they may have left otherwise than the cut is read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from chipbreak.dialects.modes import Group
from chipbreak.insertion.subprograms import Subprograms, called_by
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram, called_programs
from chipbreak.model.words import codes_of
from chipbreak.text.diagnostics import Diagnostic, Severity

if TYPE_CHECKING:
    from chipbreak.vibration.chain import Chain

NOT_FOLLOWED = "VIB095"
IN_A_CALLED_PROGRAM = "VIB096"
# By these a cut is read, in these it cannot vibrate, and the path mode is given back behind it.
READ_BY: tuple[Group, ...] = (
    *("units", "distance", "feed_mode", "speed_mode", "plane", "diameter", "arc_distance", "motion"),
    *("compensation", "rotation", "polar", "interpolation", "cylinder", "polygon", "scaling", "mirror"),
    *("modal_macro", "path", "look_ahead"),
)


class Called:
    """The calls of a program, followed when a cut asks for it."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.subprograms = Subprograms(interpreted)
        self.calls = [one for one in interpreted.effects if any(True for _ in called_by(one))]

    def line_that_says(self, letter: str, since: int, line: int) -> int | None:
        """The last line from ``since`` to before ``line`` that calls something which may say F or S."""
        calls = self._between(since, line)
        return next((call.block.line for call in calls if self._says(call, letter)), None)

    def line_not_followed(self, letter: str, since: int, line: int) -> int | None:
        """The same for something that is not in this file."""
        calls = self._between(since, line)
        return next((call.block.line for call in calls if self._says(call, letter) is None), None)

    def line_that_changes(self, line: int) -> tuple[int, Group] | None:
        """The last line before ``line`` that calls something which leaves the cut to be read otherwise.

        The other thing is the modal group; the program has said no code of it since.
        """
        for call in self._between(0, line):
            changed = self.subprograms.changes(call) or ()
            for group in READ_BY:
                if group in changed and not self._is_said(group, call.block.line + 1, line):
                    return call.block.line, group
        return None

    def _between(self, first: int, last: int) -> Iterator[BlockEffect]:
        return (call for call in reversed(self.calls) if first <= call.block.line < last)

    def _says(self, call: BlockEffect, letter: str) -> bool | None:
        """Whether what is called says a word, or cannot be read; None where some is not in this file."""
        seen: set[str | int] = set()
        left = list(called_by(call))
        is_whole = True
        while left:
            key = left.pop()
            body = self.subprograms.body(key)
            is_whole = is_whole and body is not None
            if body is None or key in seen:
                continue
            seen.add(key)
            for effect in self.interpreted.effects_of(body.start, body.stop):
                if effect.block.opaque or effect.block.has(letter):
                    return True
                left += called_by(effect)
        return False if is_whole else None

    def _is_said(self, group: Group, first: int, last: int) -> bool:
        dialect = self.interpreted.settings.dialect
        blocks = (self.interpreted.program.block(line) for line in range(first, last + 1))
        return any(codes_of(block, group, dialect) for block in blocks if not block.is_optional)


def not_followed(interpreted: InterpretedProgram, chains: Sequence[Chain]) -> list[Diagnostic]:
    """Cuts that take it for granted that F and S are what they were before a call that nobody can follow."""
    called = Called(interpreted)
    found: dict[int, Diagnostic] = {}
    for chain in chains:
        state = chain.before
        for letter, setting in (("F", state.feed), ("S", state.speed)):
            if setting is None:
                continue
            call = called.line_not_followed(letter, setting.line, chain.first)
            if call is not None and call not in found:
                where = int(interpreted.program.source.place(call).line)
                granted = f"that {letter}{setting.text} holds behind it is taken for granted"
                message = f"what line {where} calls is not in this file; {granted}"
                found[call] = interpreted.program.diagnose(
                    chain.first,
                    NOT_FOLLOWED,
                    message,
                    f"say {letter} again between line {where} and this cut",
                    severity=Severity.WARNING,
                )
    return list(found.values())


def in_called_programs(interpreted: InterpretedProgram, chains: Sequence[Chain]) -> list[Diagnostic]:
    """Programs that return whose cuts vibrate as their calls in this file find them: others may call them."""
    entries = interpreted.interpreter.entries
    if not entries:
        return []
    found = []
    for one in called_programs(interpreted):
        chain = next((c for c in chains if one.first <= c.first < one.last), None)
        may_be_others = one.returns and not one.is_part
        if may_be_others and one.first in entries and chain is not None:
            message = (
                f"O{one.number:04d} vibrates with S, F and the start that its calls in this file give it"
            )
            help_text = "call it in the same way wherever else it is called, or give it a number of its own"
            found.append(
                interpreted.program.diagnose(
                    chain.first, IN_A_CALLED_PROGRAM, message, help_text, severity=Severity.WARNING
                )
            )
    return found
