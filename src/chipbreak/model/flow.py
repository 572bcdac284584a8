"""Where a program does not simply run from one line to the next."""

from __future__ import annotations

from bisect import bisect_right
from itertools import chain
from typing import NamedTuple

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import NON_MODAL
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program

CONTOUR_CYCLES = ("rough-cycle", "finish-cycle")


class ContourCall(NamedTuple):
    """A block that calls a contour by P and Q: lines ``first`` to ``last``, None where there is none."""

    line: int
    first: int | None = None
    last: int | None = None


class Flow(NamedTuple):
    """Jump targets and cycle contours.

    ``targets``   lines that a GOTO may reach
    ``contours``  [first, last] lines of shapes that G70 to G73 call by P and Q: no moves of their own
    """

    targets: frozenset[int]
    contours: tuple[tuple[int, int], ...]

    @property
    def is_straight(self) -> bool:
        """True when every line follows the one before it."""
        return not self.targets and not self.contours

    def in_contour(self, line: int) -> bool:
        """True inside the shape of a cycle."""
        at = bisect_right(self.contours, (line, 1 << 62)) - 1
        return at >= 0 and self.contours[at][0] <= line <= self.contours[at][1]


def read_flow(program: Program, dialect: Dialect) -> Flow:
    """Find the jumps and the contours of a program."""
    labels: set[str] = set()
    cycles: list[tuple[Block, int, int]] = []
    for block in program.event_blocks():
        labels.update(control.label.strip("Nn") for control in block.controls if control.keyword == "GOTO")
        cycle = _contour_cycle(block, dialect)
        if cycle:
            cycles.append((block, *cycle))
    numbers = _sequence_lines(program) if labels or cycles else {}
    return Flow(_targets(labels, numbers), _contours(_calls(cycles, numbers)))


def contour_calls(program: Program, dialect: Dialect) -> list[ContourCall]:
    """The cycles of a program that call a contour, in order."""
    found = [(block, _contour_cycle(block, dialect)) for block in program.event_blocks()]
    cycles = [(block, *names) for block, names in found if names]
    return _calls(cycles, _sequence_lines(program) if cycles else {})


def _targets(labels: set[str], numbers: dict[int, list[int]]) -> frozenset[int]:
    """Lines that the jumps to these labels may reach: any numbered one where a label is worked out."""
    if all(label.isdigit() for label in labels):
        reached = [numbers.get(number, []) for number in set(map(int, labels))]
    else:
        reached = list(numbers.values())
    return frozenset(chain.from_iterable(reached))


def _contour_cycle(block: Block, dialect: Dialect) -> tuple[int, int] | None:
    """P and Q of a cycle that reads a shape from the program."""
    first = block.number("P")
    last = block.number("Q")
    if first is None or last is None:
        return None
    codes = [dialect.g_codes.get(round(number * 10)) for number in block.numbers("G")]
    calls = any(code and code.group == NON_MODAL and code.value in CONTOUR_CYCLES for code in codes)
    return (int(first), int(last)) if calls else None


def _sequence_lines(program: Program) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    for line in program.source.body:
        sequence = program.block(line).sequence
        if sequence is not None and sequence.number is not None:
            found.setdefault(int(sequence.number), []).append(line)
    return found


def _calls(cycles: list[tuple[Block, int, int]], numbers: dict[int, list[int]]) -> list[ContourCall]:
    """The control takes the next such number behind the cycle; G70 may look back to the roughing's shape."""
    calls = []
    for block, first, last in cycles:
        starts = numbers.get(first, [])
        ahead = [line for line in starts if line > block.line] or starts[-1:]
        ends = [line for line in numbers.get(last, []) if ahead and line >= ahead[0]]
        lines = (ahead[0], ends[0]) if ends else (None, None)
        calls.append(ContourCall(block.line, *lines))
    return calls


def _contours(calls: list[ContourCall]) -> tuple[tuple[int, int], ...]:
    ranges = {(one.first, one.last) for one in calls if one.first is not None and one.last is not None}
    return tuple(sorted(ranges))
