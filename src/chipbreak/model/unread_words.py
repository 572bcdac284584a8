"""Words in plain moves that nothing reads: passed through, but said.

The turns of an arc are among those that no pass takes over, but they are read: its time counts them.
"""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.syntax.nodes import Word
from chipbreak.text.diagnostics import Diagnostic, Severity

UNREAD_WORD = "MOD001"
_CORNERS = frozenset({",C", ",R", ",A"})


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
        if not says_turns(effect, word, interpreted.settings.dialect)
        and not _is_corner(effect, word, interpreted.settings.dialect)
    ]


def says_turns(effect: BlockEffect, word: Word, dialect: Dialect) -> bool:
    """True for the word that says how many turns an arc makes."""
    is_arc = effect.move is not None and effect.move.kind in ("cw", "ccw")
    return is_arc and word.address == dialect.arc_turns


def _is_corner(effect: BlockEffect, word: Word, dialect: Dialect) -> bool:
    """``,C1.`` ``,R2.`` ``,A135.`` of a straight move, on a control that draws them in contours."""
    is_straight = effect.after.modes.motion in ("rapid", "line")
    return bool(dialect.contour_cycles) and is_straight and word.address in _CORNERS
