"""The words that bring the tool back to where it stood."""

from __future__ import annotations

from chipbreak.model.modal import State
from chipbreak.model.words import is_diameter
from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number

# As many as any program has: a position is printed back as it was programmed, never rounder.
_DECIMALS = 6


def place_word(axis: str, state: State, settings: Settings) -> str:
    """Where an axis of the geometry stands in a state, as an absolute word of the control."""
    value = getattr(state.position, axis.lower()) / state.mm_per_unit
    if axis == "X" and is_diameter(state, settings.control):
        value *= 2.0
    words = settings.axis_words
    number = print_number(value * words.signs[axis], _DECIMALS)
    return words.letters[axis] + settings.dialect.set_off + number
