"""Where a program does not simply run from one line to the next."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import NON_MODAL
from chipbreak.model.arrivals import Arrivals, Jump, at_nests, at_targets
from chipbreak.model.paths import begins_program
from chipbreak.model.values import MODE_LETTERS
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple

CONTOUR_CYCLES = ("rough-cycle", "finish-cycle")
_LineRange = tuple[int, int]


class ContourCall(NamedTuple):
    """A block that calls a contour by P and Q: lines ``first`` to ``last``, None where there is none."""

    line: int
    first: int | None = None
    last: int | None = None


class MissingNumber(NamedTuple):
    """A cycle in ``line`` asks for a block ``N number`` that is not there; ``letter`` is its P or Q."""

    line: int
    letter: str
    number: int

    @property
    def message(self) -> str:
        """What is missing, in words."""
        where = "no block" if self.letter == "P" else "no block behind the first one of its shape"
        return (
            f"this cycle looks for N{self.number} ({self.letter}{self.number}), and {where} has that number"
        )


class Flow(NamedTuple):
    """Jump targets and cycle contours.

    ``targets``   lines that a GOTO may reach
    ``contours``  [first, last] lines of shapes that G70 to G73 before them call by P and Q: no moves there
    ``run_again`` those that a cycle behind them calls: the control comes through them, and cuts them again
    ``missing``   the ends of shapes that are not in the program
    ``finishes``  line of a finishing cycle -> the last F and S of its shape, those that it says
    ``arrivals``  where other ways come in -> these ways; to a place that is not named they are not known
    ``ordered_targets``  the targets from the first to the last
    ``said_otherwise``  the modal groups, and "tool", of which the program says more than one thing
    """

    targets: frozenset[int]
    contours: tuple[_LineRange, ...]
    missing: tuple[MissingNumber, ...] = ()
    finishes: Mapping[int, Mapping[str, str]] = FrozenTable()
    arrivals: Arrivals = FrozenTable()
    ordered_targets: tuple[int, ...] = ()
    run_again: tuple[_LineRange, ...] = ()
    said_otherwise: frozenset[str] = frozenset()

    def straight_until(self, line: int, last: int) -> int:
        """Where lines ``line`` to ``last`` (exclusive) end that each follow the one before them and move."""
        if not self.targets and not self.contours:
            return last
        if self.in_contour(line):
            return line
        at = bisect_left(self.contours, (line, line))
        contour = self.contours[at][0] if at < len(self.contours) else last
        at = bisect_left(self.ordered_targets, line)
        target = self.ordered_targets[at] if at < len(self.ordered_targets) else last
        return min(contour, target, last)

    def in_contour(self, line: int) -> bool:
        """True inside the shape of a cycle."""
        return _is_in(line, self.contours)

    def is_run_again(self, line: int) -> bool:
        """True where the control comes through a line that a cycle behind it takes for its shape."""
        return _is_in(line, self.run_again)


def _is_in(line: int, ranges: Sequence[_LineRange]) -> bool:
    """True inside one of some ranges, which rise."""
    at = bisect_right(ranges, (line, 1 << 62)) - 1
    return at >= 0 and ranges[at][0] <= line <= ranges[at][1]


class _Cycle(NamedTuple):
    """A cycle that reads a shape from the program: its line, and the numbers of the ends of the shape.

    ``finishes``: it runs the shape with its F and S, which the others do not.
    """

    line: int
    first: int
    last: int
    finishes: bool


def read_flow(program: Program, dialect: Dialect) -> Flow:
    """Find the jumps and the contours of a program."""
    jumps: list[Jump] = []
    cycles: list[_Cycle] = []
    ruled: list[Block] = []
    called: set[int] = set()
    returned_to: set[int] = set()
    for block in program.event_blocks():
        cycles += _cycles_of(block, dialect)
        called.update(_called_numbers(block, dialect))
        returned_to.update(_returned_to(block, dialect))
        if block.controls:
            jumps += _jumps_of(block)
            ruled.append(block)
    numbers = sequence_lines(program) if jumps or cycles or returned_to else {}
    shapes = [_shape(cycle, numbers) for cycle in cycles]
    contours = _merged(_passed_over(cycles, shapes))
    begins = _beginnings(program, dialect) if cycles else ()
    again = _merged(one for one in _run_again(cycles, shapes, begins) if not _is_in(one[0], contours))
    missing = tuple(shape for shape in shapes if isinstance(shape, MissingNumber) and dialect.contour_cycles)
    finishes = dict(_finishes(program, cycles, shapes))
    arrivals = FrozenTable({**at_nests(ruled), **dict(at_targets(jumps, numbers, called))})
    targets = _targets({*(jump.number for jump in jumps), *returned_to}, numbers)
    ordered = tuple(sorted(targets))
    otherwise = _said_otherwise(program, dialect) if targets or ruled else frozenset[str]()
    return Flow(targets, contours, missing, FrozenTable(finishes), arrivals, ordered, again, otherwise)


def _said_otherwise(program: Program, dialect: Dialect) -> frozenset[str]:
    """The modal groups of which a program says more than one code, and "tool" where it names several."""
    said: dict[str, set[object]] = {"motion": {"rapid", "linear"}}  # no program does without
    for block in program.event_blocks():
        for number in block.numbers("G"):
            code = dialect.g_codes.get(round(number * 10))
            if code is not None and code.group != NON_MODAL:
                own = [(w.address, w.value_text) for w in block.words_of(MODE_LETTERS.get(code.group, ""))]
                said.setdefault(code.group, set()).add((code.value, *own))
        said.setdefault("tool", set()).update(word.value_text for word in block.words_of("T"))
    return frozenset(group for group, values in said.items() if len(values) > 1)


def _passed_over(
    cycles: Sequence[_Cycle], shapes: Sequence[_LineRange | MissingNumber]
) -> Iterator[_LineRange]:
    """The shapes that a cycle before them calls: to any other the control comes first, and cuts along it."""
    for cycle, shape in zip(cycles, shapes, strict=True):
        if not isinstance(shape, MissingNumber) and cycle.line < shape[0]:
            yield shape


def _beginnings(program: Program, dialect: Dialect) -> list[int]:
    """The lines in which the programs of a file begin."""
    return [block.line for block in program.event_blocks() if begins_program(block, dialect)]


def _run_again(
    cycles: Sequence[_Cycle], shapes: Sequence[_LineRange | MissingNumber], begins: Sequence[int]
) -> Iterator[_LineRange]:
    """The shapes that a cycle behind them calls, in the same program: ``begins`` are their first lines."""
    for cycle, shape in zip(cycles, shapes, strict=True):
        if isinstance(shape, MissingNumber) or cycle.line <= shape[1]:
            continue
        if bisect_right(begins, shape[0]) == bisect_right(begins, cycle.line):
            yield shape


def _finishes(
    program: Program, cycles: Sequence[_Cycle], shapes: Sequence[_LineRange | MissingNumber]
) -> Iterator[tuple[int, dict[str, str]]]:
    """The lines of the finishing cycles, with the last F and S of their shapes, where these say any."""
    for cycle, shape in zip(cycles, shapes, strict=True):
        if cycle.finishes and not isinstance(shape, MissingNumber) and (said := _last_said(program, shape)):
            yield cycle.line, said


def _last_said(program: Program, shape: _LineRange) -> dict[str, str]:
    """The last F and S of a shape."""
    blocks = map(program.block, range(shape[0], shape[1] + 1))
    return {word.address: word.value_text for block in blocks for word in block.words_of("FS")}


def contour_calls(program: Program, dialect: Dialect) -> list[ContourCall]:
    """The cycles of a program that call a contour, in order."""
    cycles = [cycle for block in program.event_blocks() for cycle in _cycles_of(block, dialect)]
    numbers = sequence_lines(program) if cycles else {}
    shapes = [(cycle.line, _shape(cycle, numbers)) for cycle in cycles]
    return [
        ContourCall(line) if isinstance(shape, MissingNumber) else ContourCall(line, *shape)
        for line, shape in shapes
    ]


def _jumps_of(block: Block) -> Iterator[Jump]:
    """The jumps of a block."""
    for control in block.controls:
        if control.keyword == "GOTO":
            number = control.label.strip("Nn")
            yield Jump(block.line, int(number) if number.isdigit() else None)


def _returned_to(block: Block, dialect: Dialect) -> Iterator[int]:
    """The number that ``M99 P100`` goes to: in a main program it is a jump, with what is in force there."""
    codes = [dialect.m_codes.get(int(number)) for number in block.numbers("M")]
    if any(code is not None and (code.group, code.value) == ("subprogram", "return") for code in codes):
        yield from (int(word.number) for word in block.words_of("P") if word.number is not None)


def _called_numbers(block: Block, dialect: Dialect) -> Iterator[int]:
    """The block numbers that a call or a return may name: ``M99 P100``, ``M98 P2000 Q100``, ``M97 P100``."""
    codes = [dialect.m_codes.get(int(number)) for number in block.numbers("M")]
    if any(code is not None and code.group == "subprogram" for code in codes):
        yield from (int(word.number) for word in block.words_of("PQH") if word.number is not None)


def _targets(jumps: set[int | None], numbers: Mapping[int, Sequence[int]]) -> frozenset[int]:
    """The lines of these numbers; all numbered lines where one is worked out."""
    reached = numbers if None in jumps else jumps & numbers.keys()
    return frozenset(line for number in reached if number is not None for line in numbers[number])


def _cycles_of(block: Block, dialect: Dialect) -> list[_Cycle]:
    """P and Q of a cycle that reads a shape from the program."""
    first = block.number("P")
    last = block.number("Q")
    if (
        not dialect.contour_cycles
        or first is None
        or last is None
        or not _calls(block, dialect, CONTOUR_CYCLES)
    ):
        return []
    return [_Cycle(block.line, int(first), int(last), _calls(block, dialect, CONTOUR_CYCLES[1:]))]


def _calls(block: Block, dialect: Dialect, cycles: Sequence[str]) -> bool:
    codes = [dialect.g_codes.get(round(number * 10)) for number in block.numbers("G")]
    return any(code and code.group == NON_MODAL and code.value in cycles for code in codes)


def sequence_lines(program: Program) -> dict[int, list[int]]:
    """The lines on which each block number stands."""
    found: dict[int, list[int]] = {}
    for line in program.lines_with_numbers():
        sequence = program.block(line).sequence
        if sequence is not None and sequence.number is not None:
            found.setdefault(int(sequence.number), []).append(line)
    return found


def _shape(cycle: _Cycle, numbers: Mapping[int, Sequence[int]]) -> _LineRange | MissingNumber:
    """The control searches on from the cycle, then from the top of the program."""
    starts = numbers.get(cycle.first, ())
    ahead = next((line for line in starts if line > cycle.line), starts[0] if starts else None)
    if ahead is None:
        return MissingNumber(cycle.line, "P", cycle.first)
    end = next((line for line in numbers.get(cycle.last, ()) if line >= ahead), None)
    return MissingNumber(cycle.line, "Q", cycle.last) if end is None else (ahead, end)


def _merged(ranges: Iterable[_LineRange]) -> tuple[_LineRange, ...]:
    """Ranges in order; those that share a line are one."""
    merged: list[_LineRange] = []
    for first, last in sorted(set(ranges)):
        if merged and first <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], last))
        else:
            merged.append((first, last))
    return tuple(merged)
