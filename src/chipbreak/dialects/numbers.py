"""What a number is worth that is written without a decimal point: rules that a profile chooses among."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import mm_per_step, mm_per_unit


class NumberRule(NamedTuple):
    """How a control reads numbers without a point.

    ``length_mm``    (number, increment [mm], whether in inches) -> the length [mm], NaN where nobody knows
    ``reads_whole``  True where ``5`` is ``5.``, in every word
    """

    length_mm: Callable[[float, float, bool], float]
    reads_whole: bool = False


def _as_written(number: float, increment_mm: float, is_inch: bool) -> float:
    return number * mm_per_unit(is_inch=is_inch)


def _in_increments(number: float, increment_mm: float, is_inch: bool) -> float:
    return number * increment_mm * mm_per_step(is_inch=is_inch)


def _unknown(number: float, increment_mm: float, is_inch: bool) -> float:
    return math.nan


NUMBER_RULES: Final[Mapping[str, NumberRule]] = FrozenTable(
    {
        "required": NumberRule(_unknown),
        "calculator": NumberRule(_as_written, reads_whole=True),
        "increment": NumberRule(_in_increments),
        "shown": NumberRule(_unknown),  # where a program does not show it
    }
)
