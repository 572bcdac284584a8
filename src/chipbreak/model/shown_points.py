"""What numbers without a decimal point are worth, where a program shows it (``decimal_point = "shown"``).

``X62`` is 62 mm on one control and 0.062 mm on the next.  Who writes whole numbers without a point all
through a program writes for one of the two, and the part shows for which: no lathe turns a diameter of
0.062 mm, and none is 62 m long.  A number that stands alone among others with a point is a slip, and shows
nothing.

Cycles show it by themselves: many programs write ``X2.5`` and ``G71 U1250 R500`` beside each other, for the
depth is no place of the drawing.  No pass is 1250 mm or inches deep, and no depth is a few steps of the
control.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.syntax.parse import Program
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

READ_AS = "MOD006"
_LENGTHS = "XZUWRIK"
_MOST_BLOCKS = 2_000
_LEAST_WORDS = 3
# As increments no place of a part, as millimetres or inches places of most.
_NO_PLACE_BELOW = {"X": 100.0, "Z": 20.0}
# As increments usual, as millimetres longer than any lathe.
_LONGER_THAN_LATHES = {"X": 2_000.0, "U": 2_000.0, "Z": 10_000.0, "W": 10_000.0}
# As millimetres or inches no depth and no allowance of a pass; as increments no depth.
_NO_DEPTH_FROM = 100.0
_NO_DEPTH_BELOW = 10.0
_DEPTHS = "UWR"
_WITHOUT_LENGTHS = frozenset({4.0, 10.0, 65.0, 66.0, 74.0, 75.0, 76.0, 92.0, 97.0, 98.0})


class _Counted(NamedTuple):
    """Whole numbers of a program: with and without a point, and those that only one reading makes places."""

    with_point: int = 0
    without_point: int = 0
    places_as_written: int = 0
    places_as_increments: int = 0
    depths_as_written: int = 0
    depths_as_increments: int = 0


def shown_rule(program: Program) -> str:
    """``calculator`` or ``increment``; empty where a program does not show which."""
    counted = _counted(program)
    as_written = counted.places_as_written + counted.depths_as_written
    if counted.depths_as_increments >= 2 and not as_written:
        return "increment"
    if counted.without_point < max(_LEAST_WORDS, 2 * counted.with_point):
        return ""
    if counted.places_as_written >= 2 and not counted.places_as_increments:
        return "calculator"
    if counted.places_as_increments >= 2 and not counted.places_as_written:
        return "increment"
    return ""


def read_as_shown(program: Program, settings: Settings) -> list[Diagnostic]:
    """A warning at the first number that is read as the program shows."""
    if not settings.shown.rule:
        return []
    words = ((b, w) for b, w in _whole_lengths(program) if not w.has_point)
    block, word = next(words, (None, None))
    whole = settings.shown.rule == "calculator"
    first = "" if block is None or word is None else f" ({block.text_of(word)} is {_told(word, whole=whole)})"
    unit = "millimetres or inches" if whole else "increments"
    message = f"numbers without a decimal point are read as {unit}{first}: read otherwise, the places of this"
    message += " program are none of a part, or the depths of its cycles none of a pass"
    help_text = f'set control.decimal_point = "{settings.shown.rule}", or "required" where that is not so'
    line = program.source.body.start if block is None else block.line
    return [program.diagnose(line, READ_AS, message, help_text, severity=Severity.WARNING)]


def has_number_without_point(program: Program) -> bool:
    """True where a length of a program is a whole number without a point."""
    return any(not word.has_point for _, word in _whole_lengths(program))


def _told(word: Word, *, whole: bool) -> str:
    return f"{word.value_text}." if whole else f"{word.value_text} steps of the control"


def _counted(program: Program) -> _Counted:
    found = [0, 0, 0, 0, 0, 0]
    for block, word in _whole_lengths(program):
        number = abs(word.number or 0.0)
        if word.has_point:
            found[0] += 1
            continue
        found[1] += 1
        found[2] += number < _NO_PLACE_BELOW.get(word.address, 0.0)
        found[3] += number >= _LONGER_THAN_LATHES.get(word.address, float("inf"))
        if word.address in _DEPTHS and _roughs(block, program):
            found[4] += number < _NO_DEPTH_BELOW and not block.has("P")  # allowances may be that small
            found[5] += number >= _NO_DEPTH_FROM
    return _Counted(*found)


def _roughs(block: Block, program: Program) -> bool:
    """True for a block of a roughing cycle whose depths and allowances are lengths."""
    cycles = program.dialect.contour_cycles
    return any(cycles.get(round(number * 10)) in ("along-z", "along-x") for number in block.numbers("G"))


def _whole_lengths(program: Program) -> Iterator[tuple[Block, Word]]:
    """Lengths that are whole numbers, without zeros, which are the same in every reading."""
    for line in islice(_lines(program), _MOST_BLOCKS):
        block = program.block(line)
        if block.opaque or not _WITHOUT_LENGTHS.isdisjoint(block.numbers("G")):
            continue
        for word in block.words_of(_LENGTHS):
            if word.number and word.number == int(word.number):
                yield block, word


def _lines(program: Program) -> Iterator[int]:
    """The lines that may say a length, in order."""
    body = program.source.body
    says = np.zeros(len(program.plain), dtype=bool)
    says[program.special_lines] = True
    says |= (program.bits & bits_of(_LENGTHS)) != 0
    return (int(line) for line in np.flatnonzero(says) if body.start <= line < body.stop)
