"""Numbers without a decimal point, where a profile says that nobody knows what they are worth."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.words import length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Word
from chipbreak.syntax.parse import Program
from chipbreak.syntax.shapes import bits_of

_MOST_LINES = 1000
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

    ``why`` is why the place is not known there (``State.unknown_why``).  Looked for in the lines just before.
    """
    if interpreted.settings.number_rule.reads_whole:
        return ""
    letter = interpreted.settings.axis_words.letters[axis]
    for at in _lines_that_may_say(interpreted.program, letter, line):
        word = interpreted.program.block(at).word(letter)
        if word is not None:
            before = interpreted.before(at)
            was = before.unknown_why == why and has_unknown_length(word, before, interpreted.settings)
            said = interpreted.program.source.place(at).line
            return f"{letter}{word.value_text} in line {said}" if was else ""
    return ""


def _lines_that_may_say(program: Program, letter: str, line: int) -> list[int]:
    """Those of the lines before a line that may have a word of a letter, the last one first."""
    first = max(line - _MOST_LINES, 0)
    may = (program.plain[first:line] < 0) | ((program.bits[first:line] & bits_of(letter)) != 0)
    lines: list[int] = (np.flatnonzero(may)[::-1] + first).tolist()
    return lines
