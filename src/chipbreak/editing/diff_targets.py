"""Numbers of a block that name another block, and where the control finds it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator

from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.named_tuple import NamedTuple


class Labels:
    """Where block numbers and program numbers stand, and which of several a control takes."""

    def __init__(self) -> None:
        self.numbers: dict[int, list[int]] = {}
        self.programs: dict[int, int] = {}
        self.program_lines: list[int] = []

    def add_number(self, number: int, line: int) -> None:
        """A block number."""
        self.numbers.setdefault(number, []).append(line)

    def add_program(self, number: int, line: int) -> None:
        """A program number."""
        self.programs.setdefault(number, line)
        self.program_lines.append(line)

    def jump(self, number: int, line: int) -> int | None:
        """The block that GOTO finds: from here to the end of this program, then from its top.

        The return to a number of the caller (M99 P) finds it in another program of the file.
        """
        lines = self.numbers.get(number, [])
        own = self._of_program(number, line)
        return next((one for one in own if one > line), next(iter(own or lines), None))

    def contour(self, number: int, line: int) -> int | None:
        """The block that a cycle finds: the next such number behind it, then from the top."""
        lines = self.numbers.get(number, [])
        return next((one for one in lines if one > line), next(iter(lines), None))

    def program(self, number: int, line: int) -> int | None:
        """The program of this file that a call names."""
        return self.programs.get(number)

    def block_of(self, program: int, number: int) -> int | None:
        """The block of another program of this file."""
        start = self.programs.get(program)
        return None if start is None else next(iter(self._of_program(number, start)), None)

    def _of_program(self, number: int, line: int) -> list[int]:
        """Where a number stands in the program that a line is of."""
        at = bisect_right(self.program_lines, line)
        first = self.program_lines[at - 1] if at else 0
        stop = self.program_lines[at] if at < len(self.program_lines) else 1 << 62
        return [one for one in self.numbers.get(number, []) if first <= one < stop]


LookUp = Callable[[Labels, int, int], int | None]


class Named(NamedTuple):
    """A number of a block that names another one: how it is looked up, the number, the word as written."""

    look_up: LookUp
    number: int
    text: str


def bare(label: str) -> str:
    """A label without N and leading zeros."""
    return label.strip("Nn \t").lstrip("0") or "0"


def _is_number(label: str) -> bool:
    return label.strip("Nn \t").isdigit()


def as_written(word: Word) -> str:
    """A word that names a block, as it is shown."""
    return f"{word.address}{int(word.number or 0)}"


def named_blocks(block: Block, *, calls_a_contour: bool) -> Iterator[Named]:
    """Every number of a block that names another block; ``calls_a_contour``: so do its P and Q."""
    yield from _jumps(block)
    yield from _calls(block)
    yield from _starts(block)
    if calls_a_contour:
        yield from (
            Named(Labels.contour, int(word.number or 0), as_written(word)) for word in _of(block, "PQ")
        )


def _jumps(block: Block) -> Iterator[Named]:
    """``GOTO 100``."""
    for control in block.controls:
        if control.keyword == "GOTO" and _is_number(control.label):
            yield Named(Labels.jump, int(bare(control.label)), f"N{bare(control.label)}")


def _calls(block: Block) -> Iterator[Named]:
    """``M97 P100``, ``M98 P1000``, ``M99 P100``."""
    for word in _of(block, "P"):
        for function, look_up in _FUNCTIONS.items():
            if block.has("M", function):
                yield Named(look_up, int(word.number or 0), as_written(word))


def _starts(block: Block) -> Iterator[Named]:
    """Where a called program starts: ``M98 P1000 Q20``, ``M98 P1000 H20``, or ``M98 H20`` in this program."""
    if not block.has("M", 98):
        return
    program = block.number("P")
    for word in _of(block, "QH"):
        yield Named(_start_in(program), int(word.number or 0), as_written(word))


def _start_in(program: float | None) -> LookUp:
    if program is None:
        return Labels.jump
    return lambda labels, number, line: labels.block_of(int(program), number)


def _of(block: Block, letters: str) -> Iterator[Word]:
    """The words of these letters that have a number."""
    words = (block.word(letter) for letter in letters)
    yield from (word for word in words if word is not None and word.number is not None)


def computes_a_target(block: Block, *, calls_a_contour: bool) -> bool:
    """True where the control works out which block is meant: ``GOTO #1``, ``M99 P#2``, ``G71 P#1 Q#2``."""
    if any(control.keyword == "GOTO" and not _is_number(control.label) for control in block.controls):
        return True
    letters = "P" if block.has("M", 97, 99) else ""
    letters += "QH" if block.has("M", 98) else ""
    letters += "PQ" if calls_a_contour else ""
    words = (block.word(letter) for letter in letters)
    return any(word is not None and word.number is None for word in words)


# The call of a block and of a program, and the return to a block of the caller.
_FUNCTIONS: dict[float, LookUp] = {97.0: Labels.jump, 98.0: Labels.program, 99.0: Labels.jump}
