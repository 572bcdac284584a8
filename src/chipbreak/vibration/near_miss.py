"""What was most likely meant as a wish for vibration, and is none: said with the right spelling."""

from __future__ import annotations

import re
from bisect import bisect_right

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.vibration.directive import WAVE_WORDS, read_directive

NEAR_MISS = "VIB066"
_MOST_LOOKED_AT = 1000
_COMMENT = LazyPattern(
    r"\s*VIB(?:RAT(?:ION|E|ING)?)?[\s:;=,._-]*(?P<rest>(?:(?:[SNEFQAK]|ALPHA|RAMP|EDGES|WAVE)\s*=?\s*"
    rf"(?:[-+]?\.?\d|{'|'.join(WAVE_WORDS)})|ON\b|OFF\b).*?)\s*",
    re.IGNORECASE | re.DOTALL,
)
_COUNT_FIRST = re.compile(rb"N[ \t]*[0-9]*\.[0-9]*[1-9]")


def meant_directive(text: str) -> str:
    """The directive that a comment was meant to be, such as ``(VIB N1.5)``; empty for any other comment."""
    match = _COMMENT.fullmatch(text)
    if match is None:
        return ""
    right = f"VIB {match['rest'].strip()}"
    try:
        read_directive(right, 0)
    except RefusalError:
        return ""
    return f"({right.upper()})"


def counts_as_block_numbers(interpreted: InterpretedProgram) -> list[Diagnostic]:
    """A warning at the first cut whose block begins with a fraction as its block number."""
    if not interpreted.program.table.may_have_fraction_behind_n():
        return []
    source = interpreted.program.source
    starts = source.starts.tolist() if _COUNT_FIRST.search(source.data) else []
    found: list[int] = []
    for match in _COUNT_FIRST.finditer(source.data):
        line = bisect_right(starts, match.start()) - 1
        if line in source.body and len(found) < _MOST_LOOKED_AT and _is_meant(interpreted, line):
            found.append(line)
    if not found:
        return []
    word = interpreted.program.block(found[0]).sequence
    assert word is not None
    number = f"N{word.value_text}"
    more = f" (and of {len(found) - 1} more)" if len(found) > 1 else ""
    message = (
        f"{number} stands first in this block{more}, so it is the block number and no wish for vibration"
    )
    help_text = f"vibrations per revolution stand behind the axis words: G1 Z-30. F0.05 {number}"
    at = (word.start, word.end)
    warning = interpreted.program.diagnose(
        found[0], NEAR_MISS, message, help_text, at=at, severity=Severity.WARNING
    )
    return [warning]


def _is_meant(interpreted: InterpretedProgram, line: int) -> bool:
    """True for a cut with a fraction as its block number, and no count beside it."""
    word = interpreted.program.block(line).sequence
    if word is None or word.number is None or word.number == int(word.number):
        return False
    effect = interpreted.effect(line)
    return effect.move is not None and effect.move.is_cut and not effect.vibration
