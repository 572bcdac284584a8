"""Cutting speed and diameter: ``G97 V120. D20. M3`` or ``(SPEED V120 D20)`` stand for an S word.

V is in m/min, D in mm, in every program; S = 1000 V / (pi D).
"""

from __future__ import annotations

import re

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import NON_MODAL, Code
from chipbreak.model.modal import State
from chipbreak.model.words import makes_a_limit
from chipbreak.syntax.nodes import Block, Word
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import spindle_speed_rpm

_MOST_RPM = 1e7
_DIRECTIVE = LazyPattern(r"\s*SPEED\s+(.*?)\s*$", re.IGNORECASE)
_ITEM = LazyPattern(r"([VD])\s*=?\s*([-+]?(?:\d+\.?\d*|\.\d+))[\s,]*", re.IGNORECASE)
# Words that keep V and D from being ours: axes, offsets, and calls that read every letter.
_FOREIGN = frozenset("XYZUWABCHIJKRPQL")
# Codes with which every letter is an argument.
_MACROS = (Code(NON_MODAL, "macro-call"), Code("modal_macro", "on"))


class CuttingSpeed(NamedTuple):
    """A speed asked by V and D.  ``words`` are V and D of the block, empty for the directive."""

    v_m_min: float
    d_mm: float
    words: tuple[Word, ...]
    at: tuple[int, int]

    def speed_text(self, resolution_rpm: float) -> str:
        """The S that it stands for, on the resolution of the spindle."""
        rpm = spindle_speed_rpm(self.v_m_min, self.d_mm)
        rpm = round(rpm / resolution_rpm) * resolution_rpm
        return print_number(rpm, 0 if resolution_rpm >= 1.0 else 3, point=False)


def cutting_speed_of(
    block: Block, state: State, dialect: Dialect, *, starts_spindle: bool
) -> CuttingSpeed | None:
    """What a block says by V and D, or None.

    ``state`` is the one behind the block, ``starts_spindle`` True for a block with M3 or M4.  Errors: VIB070
    for V or D alone, zero, negative, beside S or beside G50, VIB071 under constant surface speed or in
    inches.
    """
    words = None if _reads_every_letter(block, dialect) else _from_words(block, starts_spindle=starts_spindle)
    found = words or _from_directive(block)
    if found is None:
        return None
    if makes_a_limit(block, dialect):
        message = "V and D stand beside a code with which S is the limit of the spindle"
        raise RefusalError("VIB070", message, "put them into a block of their own")
    if state.modes.speed_mode == "surface":
        message = "V and D give a spindle speed, but constant surface speed (G96) is active"
        raise RefusalError("VIB071", message, "write G97 in this block, or give S in G96 yourself")
    if state.is_inch:
        message = "V and D are metric (m/min and mm), but the program is in inches"
        raise RefusalError("VIB071", message, "give S")
    return found


def _reads_every_letter(block: Block, dialect: Dialect) -> bool:
    """True where V and D are arguments: ``G65 V12. D20.``, whose P may be missing."""
    codes = (dialect.g_codes.get(round(number * 10)) for number in block.numbers("G"))
    return any(code in _MACROS for code in codes)


def _from_words(block: Block, *, starts_spindle: bool) -> CuttingSpeed | None:
    words = {w.address: w for w in block.words_of("VD")}
    if not words or block.has_macro or block.has_any(_FOREIGN):
        return None
    turns = block.has("G", 97) or starts_spindle
    speed = block.word("S")
    if len(words) < 2:
        alone = next(iter(words.values()))
        if not turns or speed is not None:
            return None
        other = "D" if alone.address == "V" else "V"
        message = f"{alone.address} without {other} gives no spindle speed"
        raise RefusalError("VIB070", message, f"add {other}, or give S")
    if speed is not None:
        message = "S, V and D stand in one block: the speed is given twice"
        raise RefusalError("VIB070", message, "give S, or V and D")
    v = words["V"]
    d = words["D"]
    assert v.number is not None and d.number is not None
    at = (min(v.start, d.start), max(v.end, d.end))
    return _checked(CuttingSpeed(v.number, d.number, tuple(sorted((v, d), key=lambda w: w.start)), at))


def _from_directive(block: Block) -> CuttingSpeed | None:
    for comment in block.comments:
        match = _DIRECTIVE.match(comment.text)
        items = _ITEM.findall(match[1]) if match else []
        # Other comments begin with SPEED too; only V and D with numbers, and nothing else, are ours.
        if match is None or not items or _ITEM.sub("", match[1]):
            continue
        values = {key.upper(): float(value) for key, value in items}
        at = (comment.start, comment.end)
        if len(values) < 2:
            raise RefusalError("VIB070", "(SPEED ...) needs V and D", "for example (SPEED V120 D20)")
        return _checked(CuttingSpeed(values["V"], values["D"], (), at))
    return None


def _checked(asked: CuttingSpeed) -> CuttingSpeed:
    for name, value in (("V", asked.v_m_min), ("D", asked.d_mm)):
        if not value > 0.0:
            raise RefusalError("VIB070", f"{name} {value:g} gives no spindle speed", "V and D are above zero")
    if not spindle_speed_rpm(asked.v_m_min, asked.d_mm) < _MOST_RPM:
        message = f"V {asked.v_m_min:g} at D {asked.d_mm:g} is no speed of a spindle"
        raise RefusalError("VIB070", message, "V is in m/min, D in mm")
    return asked
