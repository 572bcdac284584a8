"""The words that bring a length offset back into force."""

from __future__ import annotations

from chipbreak.dialects import Dialect
from chipbreak.insertion.looking_back import effects_before
from chipbreak.insertion.position_dependencies import homed_axes
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.syntax.nodes import Block

_PLAIN = (430, 440)  # G43 and G44


def offset_words(interpreted: InterpretedProgram, line: int) -> str | None:
    """``G43 H2`` as last given before a line; None where it is not that simple."""
    blocks = _blocks_since_offset(interpreted, line)
    code = _offset_code(blocks[-1], interpreted.settings.dialect) if blocks else None
    with_h = next((block for block in blocks if block.word("H")), None)
    h = with_h.word("H") if with_h else None
    if code not in _PLAIN or with_h is None or with_h.has_macro or h is None or h.number is None:
        return None
    return f"G{code // 10} H{h.value_text}"


def _blocks_since_offset(interpreted: InterpretedProgram, line: int) -> list[Block]:
    """The blocks before a line back to the one that switched the offset on, the nearest first."""
    blocks: list[Block] = []
    for effect in effects_before(interpreted, line):
        if "home" in effect.non_modal and "Z" in homed_axes(effect, interpreted.settings):
            return []  # some controls have dropped it there, some have not
        if effect.non_modal:  # H of a macro call is an argument
            continue
        blocks.append(effect.block)
        if _offset_code(effect.block, interpreted.settings.dialect) is not None:
            return blocks
    return []


def _offset_code(block: Block, dialect: Dialect) -> int | None:
    """The code (times ten) that switches the length offset on in a block."""
    codes = codes_of(block, "length_offset", dialect)
    return codes[-1] if codes and dialect.g_codes[codes[-1]].value != "off" else None
