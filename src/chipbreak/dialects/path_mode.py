"""The lengths in the code of a path mode: how far ``G64 P0.01 Q0.005`` lets the control leave the path."""

from __future__ import annotations

import re

from chipbreak.dialects.modes import Units
from chipbreak.units import mm_per_unit

_LENGTH = re.compile(r"(?<=[PQ])\s*[+]?(\d+\.?\d*|\.\d+)", re.IGNORECASE)
_LETTERS = frozenset("PQ")
_DIGITS = 8
_DECIMALS = 12


def path_mode_in(words: str, was: Units, now: Units) -> str:
    """``G64 P0.254`` of millimetres is ``G64 P0.01`` in inches."""
    if was == now:
        return words
    scale = mm_per_unit(is_inch=was == "inch") / mm_per_unit(is_inch=now == "inch")

    def converted(match: re.Match[str]) -> str:
        value = float(f"{float(match[1]) * scale:.{_DIGITS}g}")
        return f"{value:.{_DECIMALS}f}".rstrip("0")

    return _LENGTH.sub(converted, words)


def tolerances_mm(words: str, units: Units) -> dict[str, float]:
    """The lengths by letter; none of a variable."""
    scale = mm_per_unit(is_inch=units == "inch")
    return {words[match.start() - 1].upper(): float(match[1]) * scale for match in _LENGTH.finditer(words)}


def has_lengths(words: str) -> bool:
    """True where P or Q says one, also by a variable."""
    return not _LETTERS.isdisjoint(words.upper())
