"""Numbers without a decimal point, where a profile says that nobody knows what they are worth."""

from __future__ import annotations

import math
from collections.abc import Iterable

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Word

WRITE_THE_POINT = 'write the point, or set control.decimal_point to "calculator" or "increment"'


def has_unknown_length(word: Word, state: State, settings: Settings) -> bool:
    """True for a number of unknown worth; False where the control works it out."""
    return word.number is not None and math.isnan(length_mm(word, state, settings))


def first_without_point(words: Iterable[Word], state: State, settings: Settings) -> str:
    """The first of these words that has no point and needs one, as written; empty for none."""
    found = (word for word in words if has_unknown_length(word, state, settings))
    word = next(found, None)
    return "" if word is None else f"{word.letter}{word.value_text}"


def moved_without_point(interpreted: InterpretedProgram, line: int, why: str, axis: str) -> str:
    """The word, with its line, that took an axis to an unknown place before ``line``; or nothing.

    ``why`` is why the place is not known there (``State.unknown_why``).
    """
    letter = interpreted.settings.axis_words.letters[axis]
    for at in range(line - 1, -1, -1):
        word = interpreted.program.block(at).word(letter)
        if word is not None:
            before = interpreted.before(at)
            was = before.unknown_why == why and has_unknown_length(word, before, interpreted.settings)
            said = interpreted.program.source.place(at).line
            return f"{letter}{word.value_text} in line {said}" if was else ""
    return ""
