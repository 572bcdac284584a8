"""What a program says, block by block, in a form that can be compared.

Block numbers, spacing and the way numbers are written do not count; comments count unless told otherwise.  A
part that chipbreak wrote is one item.  A number that names another block (GOTO, M97 P, M98 P, M99 P, P and Q
of a cycle) stands for the block it names, so that a right renumbering is no difference and a target that
moved is one.  In a list of data (G10 L50) block numbers are data.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import isnan

from chipbreak.dialects import GENERIC_LATHE, NON_MODAL
from chipbreak.editing.beside import with_brackets
from chipbreak.editing.restore import Region, regions
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Assignment, Block, Control, Word
from chipbreak.syntax.parse import Program, parse
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.utf_16 import refuse_utf_16
from chipbreak.units import mm_per_unit

# Letters whose number is a length, an angle, a feed or a time: there a control may read 5 and 5. differently.
DIMENSIONS = frozenset("XYZUVWABCIJKRQEFHD")
_NAMED = "->"  # in a key, instead of a number that names a block
_LISTS_OF_DATA = (50.0, 51.0, 52.0)
_CONTOUR_CODES = (70.0, 71.0, 72.0, 73.0)
_CONTOUR_VALUES = ("rough-cycle", "finish-cycle")


class Reference(NamedTuple):
    """A number that names a block: the word as written, and the item it names, None where there is none."""

    text: str
    target: int | None


@dataclass(frozen=True)
class Item:
    """A block, or a whole part that chipbreak wrote: its key, its text, its line (from 1).

    ``references`` are the numbers of the block that name other blocks, in their order.  ``note`` says what
    cannot be seen in the text: where a number leads.
    """

    key: Hashable
    text: str
    line: int
    references: tuple[Reference, ...] = ()
    note: str = ""

    def with_note(self, items: Sequence[Item]) -> Item:
        """The same, saying where its numbers lead among ``items``."""
        led = [
            f"{one.text} is line {items[one.target].line}" if one.target is not None else f"no {one.text}"
            for one in self.references
        ]
        return replace(self, note=", ".join(led))


@dataclass(frozen=True)
class Reading:
    """How numbers are read: as a control of a profile reads them, or without one, with every point counted.

    ``is_inch`` and ``feeds_per_rev`` follow the program.
    """

    settings: Settings | None = None
    is_inch: bool = False
    feeds_per_rev: bool = True

    def behind(self, block: Block) -> Reading:
        """The reading behind a block."""
        if self.settings is None:
            return self
        reading = self
        for word in block.words:
            code = self._code(word)
            if code is not None and code[0] == "units":
                reading = replace(reading, is_inch=code[1] == "inch")
            elif code is not None and code[0] == "feed_mode":
                reading = replace(reading, feeds_per_rev=code[1] == "rev")
        return reading

    def value(self, word: Word) -> Hashable:
        """What a word is worth; two words of one worth are the same to the control."""
        if word.number is None:
            return word.expression
        if word.address not in DIMENSIONS or word.has_point or word.number == 0.0:
            return word.number
        if self.settings is None:
            return ("no point", word.number)
        rule = self.settings.number_rule
        if rule.reads_whole or (word.address == "F" and not self.feeds_per_rev):
            return word.number
        length_mm = rule.length_mm(word.number, self.settings.control.increment_mm, self.is_inch)
        return ("no point", word.number) if isnan(length_mm) else _in_units(length_mm, self.is_inch)

    def calls_a_contour(self, block: Block) -> bool:
        """True for a cycle whose P and Q name the blocks of its shape."""
        if block.word("P") is None or block.word("Q") is None:
            return False
        if block.has_any("XYZ"):
            return False
        if self.settings is None:
            return block.has("G", *_CONTOUR_CODES)
        codes = [self._code(word) for word in block.words]
        return any(c is not None and c[0] == NON_MODAL and c[1] in _CONTOUR_VALUES for c in codes)

    def _code(self, word: Word) -> tuple[str, str] | None:
        if self.settings is None or word.address != "G" or word.number is None:
            return None
        code = self.settings.dialect.g_codes.get(round(word.number * 10))
        return None if code is None else (code.group, code.value)


def items_of(
    data: bytes,
    name: str,
    settings: Settings | None = None,
    *,
    beside: bytes | None = None,
    ignore_comments: bool = False,
) -> list[Item]:
    """The comparable items of a program.

    With ``settings`` numbers are read as that control reads them; without, 5 and 5. are different lengths.
    Raises ProgramRejectedError for a broken bracket, and for a program in UTF-16.
    """
    refuse_utf_16(data, name)
    source = with_brackets(data, name, beside)
    program = parse(source, settings.dialect if settings else GENERIC_LATHE)
    reader = _Reader(program, settings, ignore_comments=ignore_comments)
    line = 0
    for region in regions(source):
        reader.blocks(line, region.first)
        reader.part(region)
        line = region.last
    reader.blocks(line, source.line_count)
    return reader.done()


class _Named(NamedTuple):
    """A number of a block that names another one: how it is looked up, the number, the word as written."""

    look_up: Callable[[_Labels, int, int], int | None]
    number: int
    text: str


class _Reader:
    """Collects items, and where every block number stands."""

    def __init__(self, program: Program, settings: Settings | None, *, ignore_comments: bool) -> None:
        self.program = program
        self.ignore_comments = ignore_comments
        self.reading = Reading(settings)
        if settings is not None:
            initial = settings.dialect.initial
            self.reading = Reading(settings, initial.units == "inch", initial.feed_mode == "rev")
        self.in_data = False
        self.items: list[Item] = []
        self.named: list[tuple[int, tuple[_Named, ...]]] = []
        self.labels = _Labels()

    def part(self, region: Region) -> None:
        """A part that chipbreak wrote."""
        source = self.program.source
        moves = region.last - region.body - 1
        text = f"[{region.title}: {moves} block{'s' if moves != 1 else ''}]"
        for line in range(region.first, region.last):
            self._label(self.program.block(line))
        content = bytes(source.data[source.starts[region.body] : source.starts[region.last]])
        self.items.append(Item(("part", content), text, region.first + 1))

    def blocks(self, first: int, last: int) -> None:
        """The blocks of some lines."""
        for line in range(first, last):
            block = self.program.block(line)
            self._label(block)
            named = tuple(_named(block, self.reading))
            key = self._key(block, {one.text for one in named})
            self.reading = self.reading.behind(block)
            if key:
                if named:
                    self.named.append((len(self.items), named))
                self.items.append(Item(key, self.program.source.meant(block.text), line + 1))

    def done(self) -> list[Item]:
        """The items, with the blocks that their numbers name."""
        starts = [item.line - 1 for item in self.items]
        for index, named in self.named:
            item = self.items[index]
            references = []
            for one in named:
                line = one.look_up(self.labels, one.number, item.line - 1)
                # A number on a line of its own names the block behind it.
                at = None if line is None else self._item_at(starts, line)
                references.append(Reference(one.text, at))
            self.items[index] = replace(item, references=tuple(references))
        source = self.program.source
        if source.user_lines is None:
            return self.items
        return [replace(item, line=source.place(item.line - 1).line) for item in self.items]

    def _item_at(self, starts: list[int], line: int) -> int | None:
        at = bisect_right(starts, line) - 1
        if at >= 0 and (starts[at] == line or self._is_part(at)):
            return at
        at = bisect_left(starts, line)
        return at if at < len(starts) else None

    def _is_part(self, index: int) -> bool:
        key = self.items[index].key
        return isinstance(key, tuple) and key[:1] == ("part",)

    def _label(self, block: Block) -> None:
        if block.sequence is not None and block.sequence.number is not None and not self.in_data:
            self.labels.add_number(int(block.sequence.number), block.line)
        program = block.number("O")
        if program is not None:
            self.labels.add_program(int(program), block.line)
        for control in block.controls:
            if control.keyword == "PROGRAM-NUMBER":
                self.labels.add_program(int(control.label.strip(": \t") or 0), block.line)

    def _key(self, block: Block, named: set[str]) -> tuple[Hashable, ...]:
        """Equal for blocks that say the same; empty for one that says nothing."""
        if block.opaque or block.mark:
            return ("text", " ".join(block.text.split()))
        if _ends_data(block):
            self.in_data = False
        said = tuple(self._said(part, named) for part in _in_order(block))
        number = block.sequence.number if self.in_data and block.sequence else None
        if _begins_data(block):
            self.in_data = True
        comments = () if self.ignore_comments else tuple(c.text.strip() for c in block.comments)
        return (block.skip, number, said, comments) if said or any(comments) else ()

    def _said(self, part: Word | Assignment | Control, named: set[str]) -> Hashable:
        if isinstance(part, Assignment):
            return ("=", part.target, part.value)
        if isinstance(part, Control):
            label = _NAMED if f"N{_bare(part.label)}" in named else _plain_label(part.label)
            return (part.keyword, label, part.arguments)
        letter = part.address if part.letter != "f" else "f"
        is_named = part.number is not None and _as_written(part) in named
        return (letter, _NAMED if is_named else self.reading.value(part))


def _in_units(length_mm: float, is_inch: bool) -> float:
    return round(length_mm / mm_per_unit(is_inch=is_inch), 9)


def _in_order(block: Block) -> list[Word | Assignment | Control]:
    parts: list[Word | Assignment | Control] = [*block.words, *block.assignments, *block.controls]
    return sorted(parts, key=lambda part: part.start) if len(parts) > len(block.words) else parts


def _begins_data(block: Block) -> bool:
    return block.has("G", 10) and block.number("L") in _LISTS_OF_DATA


def _ends_data(block: Block) -> bool:
    return block.has("G", 11)


def _bare(label: str) -> str:
    return label.strip("Nn \t").lstrip("0") or "0"


def _plain_label(label: str) -> str:
    return "".join(label.split()).lower()


def _as_written(word: Word) -> str:
    return f"{word.address}{int(word.number or 0)}"


def _jumps(block: Block, reading: Reading) -> Iterator[_Named]:
    """``GOTO 100``."""
    for control in block.controls:
        if control.keyword == "GOTO" and _bare(control.label).isdigit():
            yield _Named(_Labels.jump, int(_bare(control.label)), f"N{_bare(control.label)}")


def _calls(block: Block, reading: Reading) -> Iterator[_Named]:
    """``M97 P100``, ``M98 P1000``, ``M99 P100``."""
    word = block.word("P")
    if word is None or word.number is None:
        return
    for function, look_up in _FUNCTIONS.items():
        if block.has("M", function):
            yield _Named(look_up, int(word.number), _as_written(word))


def _contours(block: Block, reading: Reading) -> Iterator[_Named]:
    """``G71 P40 Q70``."""
    words = [block.word(letter) for letter in "PQ"] if reading.calls_a_contour(block) else []
    for word in words:
        if word is not None and word.number is not None:
            yield _Named(_Labels.contour, int(word.number), _as_written(word))


_RULES = (_jumps, _calls, _contours)


def _named(block: Block, reading: Reading) -> Iterator[_Named]:
    """Every number of a block that names another block."""
    for rule in _RULES:
        yield from rule(block, reading)


class _Labels:
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
        at = bisect_right(self.program_lines, line)
        first = self.program_lines[at - 1] if at else 0
        stop = self.program_lines[at] if at < len(self.program_lines) else 1 << 62
        own = [one for one in lines if first <= one < stop]
        return next((one for one in own if one > line), next(iter(own or lines), None))

    def contour(self, number: int, line: int) -> int | None:
        """The block that a cycle finds: the next such number behind it, then from the top."""
        lines = self.numbers.get(number, [])
        return next((one for one in lines if one > line), next(iter(lines), None))

    def program(self, number: int, line: int) -> int | None:
        """The program of this file that a call names."""
        return self.programs.get(number)


# The call of a block and of a program, and the return to a block of the caller.
_FUNCTIONS = {97.0: _Labels.jump, 98.0: _Labels.program, 99.0: _Labels.jump}
