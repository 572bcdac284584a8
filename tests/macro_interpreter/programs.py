"""Programs by number, read by the project's parser, with their sequence numbers and loops."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache

from chipbreak.dialects import FANUC_MILL
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from macro_interpreter.faults import NO_LOOP, NO_PROGRAM, UNREADABLE, fault

_NUMBER = re.compile(r"\s*[O:]([0-9]+)", re.IGNORECASE)


@dataclass(frozen=True)
class MacroProgram:
    """One program: its blocks, where each N stands, and the partner of each DO and END."""

    number: int
    blocks: tuple[Block, ...]
    labels: dict[int, int] = field(default_factory=dict)
    partners: dict[int, int] = field(default_factory=dict)

    def line_of(self, label: int) -> int:
        """The block with a sequence number."""
        if label not in self.labels:
            raise fault(NO_PROGRAM, f"O{self.number:04}: there is no block N{label}")
        return self.labels[label]


class Library:
    """All programs in the control's memory."""

    def __init__(self, texts: Iterable[str | bytes] = ()) -> None:
        self.programs: dict[int, MacroProgram] = {}
        for text in texts:
            self.add(text)

    def add(self, text: str | bytes) -> list[int]:
        """Read the programs of a text; each starts with its O number.  Returns the numbers."""
        found = _programs_of(text.encode("latin-1") if isinstance(text, str) else text)
        self.programs |= {program.number: program for program in found}
        return [program.number for program in found]

    def get(self, number: int) -> MacroProgram:
        """A program by its number."""
        if number not in self.programs:
            raise fault(NO_PROGRAM, f"there is no program O{number:04}")
        return self.programs[number]


@lru_cache(maxsize=256)
def _programs_of(data: bytes) -> tuple[MacroProgram, ...]:
    """The programs of a text: the same macros go into the memory of many controls."""
    program = parse(read(data), FANUC_MILL)
    found: list[tuple[int, list[Block]]] = []
    for line in program.source.body:
        block = program.block(line)
        start = _NUMBER.match(block.text)
        if start:
            found.append((int(start[1]), []))
        if block.opaque:
            place = f"line {line + 1}: {block.text.strip()}"
            raise fault(UNREADABLE, f"{place} cannot be read ({block.opaque})")
        if found and not block.mark:
            found[-1][1].append(block)
    if not found:
        raise fault(NO_PROGRAM, "the text holds no program number")
    return tuple(
        MacroProgram(number, tuple(blocks), _labels(blocks), _loops(number, blocks))
        for number, blocks in found
    )


def _labels(blocks: list[Block]) -> dict[int, int]:
    labels: dict[int, int] = {}
    for index, block in enumerate(blocks):
        if block.sequence is not None and block.sequence.number is not None:
            labels.setdefault(int(block.sequence.number), index)
    return labels


def _check_label(number: int, label: str, opened: list[str]) -> None:
    """Refuse a DO that there is not, or that is open already."""
    if label not in ("1", "2", "3"):
        raise fault(NO_LOOP, f"O{number:04}: DO{label}; there are DO1, DO2 and DO3")
    if label in opened:
        raise fault(NO_LOOP, f"O{number:04}: DO{label} inside DO{label}")


def _loops(number: int, blocks: list[Block]) -> dict[int, int]:
    """DO to END and back; loops may lie in each other, not across."""
    partners: dict[int, int] = {}
    opened: list[tuple[str, int]] = []
    controls = [(index, control) for index, block in enumerate(blocks) for control in block.controls]
    for index, control in controls:
        if control.keyword == "DO":
            _check_label(number, control.label, [label for label, _ in opened])
            opened.append((control.label, index))
        elif control.keyword == "END":
            if not opened or opened[-1][0] != control.label:
                raise fault(NO_LOOP, f"O{number:04}: END{control.label} without its DO")
            partners[index] = opened.pop()[1]
            partners[partners[index]] = index
    if opened:
        raise fault(NO_LOOP, f"O{number:04}: DO{opened[-1][0]} without its END")
    return partners
