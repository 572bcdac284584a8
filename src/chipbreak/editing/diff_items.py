"""What a program says, block by block, in a form that can be compared.

Block numbers, spacing and the way numbers are written do not count; comments count unless told otherwise.  A
part that chipbreak wrote is one item.  A number that names another block (GOTO, M97 P, M98 P, M99 P, P and Q
of a cycle) stands for the block it names, so that a right renumbering is no difference and a target that
moved is one.  In a list of data (G10 L50) block numbers are data, and so they are wherever a program computes
the number of a block that it goes to.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from math import isnan

from chipbreak.dialects import GENERIC_LATHE, NON_MODAL
from chipbreak.editing.beside import with_brackets
from chipbreak.editing.diff_targets import Labels, Named, as_written, bare, computes_a_target, named_blocks
from chipbreak.editing.restore import Region, regions
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Assignment, Block, Control, Word
from chipbreak.syntax.parse import Program, parse
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.utf_16 import refuse_utf_16
from chipbreak.units import mm_per_unit

# Letters whose number is a length, an angle, a feed or a time: there a control may read 5 and 5. differently.
DIMENSIONS = frozenset((*"XYZUVWABCIJKRQEFHD", ",A", ",C", ",R"))
# Of these a tolerance holds: lengths and angles, but no feeds, times, leads and numbers of offsets.
LENGTHS = DIMENSIONS - frozenset("EFHD")
_NAMED = "->"  # in a key, instead of a number that names a block
_LISTS_OF_DATA = (50.0, 51.0, 52.0)
_CONTOUR_CODES = (70.0, 71.0, 72.0, 73.0)
_CONTOUR_VALUES = ("rough-cycle", "finish-cycle")
_DWELL = 4.0
# Comments that do something count always: wishes to the filter, and files that LinuxCNC writes.
_ACTS = LazyPattern(r"\s*(?:VIB|OP|LOG\w*|PROBE\w*)(?![A-Z])", re.IGNORECASE)


class Reference(NamedTuple):
    """A number that names a block: the word as written, and the item it names, None where there is none."""

    text: str
    target: int | None


@dataclass(frozen=True)
class Item:
    """A block, or a whole part that chipbreak wrote: its key, its text, its line (from 1).

    ``references`` are the numbers of the block that name other blocks, in their order.  ``note`` says what
    cannot be seen in the text: where a number leads.  ``numbers`` are the block numbers by which it is found;
    ``computes`` is True where it goes to one that the control works out.
    """

    key: Hashable
    text: str
    line: int
    references: tuple[Reference, ...] = ()
    note: str = ""
    numbers: tuple[int, ...] = ()
    computes: bool = False

    def with_numbers(self) -> Item:
        """The same, its block numbers being part of what it says."""
        return replace(self, key=(self.numbers, self.key))

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
            return _meaning(word.expression)
        if word.address not in DIMENSIONS or word.has_point or word.number == 0.0:
            return word.number
        if self.settings is None:
            return ("no point", word.number)
        rule = self.settings.number_rule
        if rule.reads_whole or (word.address == "F" and not self.feeds_per_rev):
            return word.number
        length_mm = rule.length_mm(word.number, self.settings.control.increment_mm, self.is_inch)
        return ("no point", word.number) if isnan(length_mm) else _in_units(length_mm, self.is_inch)

    def time(self, word: Word) -> Hashable:
        """What a word of a dwell is worth: P5 may be 5 ms where P5. is 5 s; no tolerance holds for it."""
        reads_whole = self.settings is not None and self.settings.number_rule.reads_whole
        if word.address == "P" and word.number and not word.has_point and not reads_whole:
            return ("no point", word.number)
        return ("time", self.value(word))

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
        self.named: list[tuple[int, tuple[Named, ...]]] = []
        self.labels = Labels()
        self.numbers: list[int] = []  # by which the next item is found

    def part(self, region: Region) -> None:
        """A part that chipbreak wrote."""
        source = self.program.source
        moves = region.last - region.body - 1
        text = f"[{region.title}: {moves} block{'s' if moves != 1 else ''}]"
        for line in range(region.first, region.last):
            self._label(self.program.block(line))
        content = bytes(source.data[source.starts[region.body] : source.starts[region.last]])
        self._add(Item(("part", content), text, region.first + 1))

    def blocks(self, first: int, last: int) -> None:
        """The blocks of some lines."""
        for line in range(first, last):
            block = self.program.block(line)
            self._label(block)
            self.reading = self.reading.behind(block)
            calls_a_contour = self.reading.calls_a_contour(block)
            named = tuple(named_blocks(block, calls_a_contour=calls_a_contour))
            key = self._key(block, {one.text for one in named})
            if key:
                if named:
                    self.named.append((len(self.items), named))
                computes = computes_a_target(block, calls_a_contour=calls_a_contour)
                self._add(Item(key, self.program.source.meant(block.text), line + 1, computes=computes))

    def _add(self, item: Item) -> None:
        self.items.append(replace(item, numbers=tuple(self.numbers)) if self.numbers else item)
        self.numbers.clear()

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
            self.numbers.append(int(block.sequence.number))
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
        worth = self.reading.time if block.has("G", _DWELL) else self.reading.value
        said = tuple(_said(part, named, worth) for part in _in_order(block))
        number = block.sequence.number if self.in_data and block.sequence else None
        if _begins_data(block):
            self.in_data = True
        texts = (c.text.strip() for c in block.comments if not self.ignore_comments or _ACTS.match(c.text))
        comments = tuple(filter(None, texts))
        return (block.skip, number, said, comments) if said or comments else ()


def _said(part: Word | Assignment | Control, named: set[str], worth: Callable[[Word], Hashable]) -> Hashable:
    if isinstance(part, Assignment):
        return ("=", _meaning(part.target), _meaning(part.value))
    if isinstance(part, Control):
        label = _NAMED if f"N{bare(part.label)}" in named else _plain_label(part.label)
        return (part.keyword, label, tuple(map(_meaning, part.arguments)))
    letter = part.address if part.letter != "f" else "f"
    is_named = part.number is not None and as_written(part) in named
    return (letter, _NAMED if is_named else worth(part))


def _meaning(expression: object) -> Hashable:
    """An expression with the kind of each of its parts, without which #5 and 5 are one number."""
    if isinstance(expression, tuple):
        return (type(expression).__name__, *map(_meaning, expression))
    return expression if isinstance(expression, Hashable) else repr(expression)


def _in_units(length_mm: float, is_inch: bool) -> float:
    return round(length_mm / mm_per_unit(is_inch=is_inch), 9)


def _in_order(block: Block) -> list[Word | Assignment | Control]:
    parts: list[Word | Assignment | Control] = [*block.words, *block.assignments, *block.controls]
    return sorted(parts, key=lambda part: part.start) if len(parts) > len(block.words) else parts


def _begins_data(block: Block) -> bool:
    return block.has("G", 10) and block.number("L") in _LISTS_OF_DATA


def _ends_data(block: Block) -> bool:
    return block.has("G", 11)


def _plain_label(label: str) -> str:
    return "".join(label.split()).lower()
