"""What the words of a block are worth: units, decimal points, diameters, constants."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.dialects.modes import UNSAID, Group, SpeedMode
from chipbreak.model.evaluate import constant
from chipbreak.model.modal import UNKNOWN, Setting, State
from chipbreak.settings.sections import Control
from chipbreak.syntax.nodes import Block, Word
from chipbreak.units import MM_PER_INCH

NO_POINT = "a number without a decimal point; this control may read it as increments"


# Why nothing is known at the target of a jump.
JUMPED = "a jump (GOTO) can arrive at this block"


def plain_value(word: Word) -> float:
    """The number itself, NaN where it is not a constant."""
    if word.number is not None:
        return word.number
    value = constant(word.expression) if word.expression is not None else None
    return UNKNOWN if value is None else value


def codes_of(block: Block, group: Group, dialect: Dialect) -> list[int]:
    """The codes of a modal group that a block says, ten times the G number each."""
    numbers = [round(number * 10) for number in block.numbers("G")]
    return [n for n in numbers if n in dialect.g_codes and dialect.g_codes[n].group == group]


def cylinder_of(block: Block) -> str:
    """``G7.1 C0`` ends what ``G7.1 C20.`` began: the radius of the cylinder is zero."""
    radii = [plain_value(w) for w in block.words_of("ABCH")]
    return "off" if radii and all(radius == 0.0 for radius in radii) else "on"


def offset_of(block: Block, code: str) -> str:
    """``G54.1 P3`` (or ``G54 P3``, Haas ``G154 P3``) is another offset than with P4."""
    word = block.word("P") if code in ("G54", "G54.1", "G154") else None
    return code if word is None else f"{code} P{word.value_text}"


def surface_limit(block: Block, mode: SpeedMode, dialect: Dialect) -> Setting | None:
    """``G96 D2000 S120``: the limit stands with its G96; one without it has none, and G97 ends it."""
    word = block.word(dialect.surface_limit) if mode == "surface" else None
    return None if word is None else Setting(plain_value(word), word.value_text, block.line)


def length_mm(word: Word, state: State, control: Control) -> float:
    """A length in mm under the control's decimal-point rule; NaN when it cannot be known."""
    value = plain_value(word)
    scale = MM_PER_INCH if state.is_inch else 1.0
    if word.number is None or word.has_point or value == 0.0:
        return value * scale
    if control.decimal_point == "calculator":
        return value * scale
    if control.decimal_point == "increment":
        # The least increment of an inch program is a tenth as many inches as that of a metric one is mm.
        return value * control.increment_mm * (MM_PER_INCH / 10.0 if state.is_inch else 1.0)
    return UNKNOWN


def feed_value(word: Word, state: State, control: Control) -> float:
    """F in program units; NaN where the control may read it in increments.

    Feed per minute is a whole number on most controls, so only feed per revolution needs its point.
    """
    value = plain_value(word)
    if word.number is None or word.has_point or control.decimal_point == "calculator":
        return value
    return UNKNOWN if state.modes.feed_mode == "rev" and value != 0.0 else value


def is_diameter(state: State, control: Control) -> bool:
    """True while X words are diameters."""
    mode = state.modes.diameter
    return control.x_diameter if mode == UNSAID else mode == "diameter"
