"""Words in plain moves that nothing reads: passed through, but said."""

from __future__ import annotations

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity

UNREAD_WORD = "MOD001"


def unread_words(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning for every such word."""
    return [
        interpreted.program.diagnose(
            effect.block.line,
            UNREAD_WORD,
            f"{effect.block.text_of(word)} has no meaning here that this profile knows",
            "it is passed through as it is; check the letter",
            at=(word.start, word.end),
            severity=Severity.WARNING,
        )
        for effect in interpreted.effects
        for word in effect.unread
    ]
