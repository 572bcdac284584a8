"""What the words of a block are worth: units, decimal points, diameters, constants."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import CYCLE_END
from chipbreak.dialects.modes import UNSAID, Group, SpeedMode, Units
from chipbreak.dialects.numbers import NumberRule
from chipbreak.model.modal import UNKNOWN, Setting, State, one_unknown
from chipbreak.settings.sections import Control, Settings
from chipbreak.syntax.evaluate import constant
from chipbreak.syntax.nodes import Block, Word
from chipbreak.units import surface_speed_m_min, typed_surface_speed

NO_POINT = "a number without a decimal point; this control may read it as increments"


_G80 = 800  # ten times the number, as in the table of codes
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


def settles_motion(block: Block, dialect: Dialect) -> bool:
    """True for a motion code that holds whatever was in force before.

    A canned cycle does not on a control whose G80 brings back what was before it.
    """
    end = dialect.g_codes.get(_G80)
    gives_back = end is not None and end.group == CYCLE_END
    said = (dialect.g_codes[code].value for code in codes_of(block, "motion", dialect))
    return any(value != "cycle" or not gives_back for value in said)


def makes_a_limit(block: Block, dialect: Dialect) -> bool:
    """``G50``: a code with which S is no speed but the highest one."""
    return any(round(number * 10) in dialect.speed_limit for number in block.numbers("G"))


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


def length_mm(word: Word, state: State, settings: Settings) -> float:
    """A length in mm under the control's decimal-point rule; NaN when it cannot be known."""
    value = plain_value(word)
    if word.number is None or word.has_point or value == 0.0:
        return value * state.mm_per_unit
    return settings.number_rule.length_mm(value, settings.control.increment_mm, state.is_inch)


def feed_of(word: Word, state: State, rule: NumberRule, line: int) -> Setting:
    """What an F sets: mm/rev, mm/min or 1/min as the feed mode says; NaN where it may count increments.

    Feed per minute is a whole number on most controls, so only feed per revolution needs its point.
    """
    value = plain_value(word)
    if state.modes.feed_mode != "inverse":
        value = one_unknown(value * state.mm_per_unit)
    may_count_increments = state.modes.feed_mode == "rev" and not rule.reads_whole
    if may_count_increments and word.number is not None and not word.has_point and value != 0.0:
        value = UNKNOWN
    return Setting(value, word.value_text, line, state.modes.units)


def speed_of(word: Word, state: State, line: int) -> Setting:
    """What an S sets: rpm, or m/min under constant surface speed."""
    value = plain_value(word)
    if state.modes.speed_mode == "surface":
        value = one_unknown(surface_speed_m_min(value, is_inch=state.is_inch))
    return Setting(value, word.value_text, line, state.modes.units)


def reread_speed(state: State, units: Units) -> State:
    """The state with the number of its S read again, in these units."""
    speed = state.speed
    if speed is None or speed.units == units or state.modes.speed_mode == "rpm":
        return state
    to_inch = units == "inch"
    value = surface_speed_m_min(typed_surface_speed(speed.value, is_inch=not to_inch), is_inch=to_inch)
    return state._replace(speed=speed._replace(value=value, units=units))


def is_diameter(state: State, control: Control) -> bool:
    """True while X words are diameters."""
    mode = state.modes.diameter
    return control.x_diameter if mode == UNSAID else mode == "diameter"
