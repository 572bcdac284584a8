"""What the lines before a line have done to variables: plain values are said again, all else is not known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from chipbreak.insertion.obstacles import Obstacles
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram, calls_subprogram
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.variables import variables_in, variables_of
from chipbreak.text.named_tuple import NamedTuple

_Key = int | str
# Up to here a variable may be a subprogram's own.
_LAST_LOCAL = 33
# Where a probe has touched: numbers on Fanuc-type controls and on LinuxCNC.
_TOUCHED = range(5061, 5081)


class Variables(NamedTuple):
    """``texts`` are blocks that set again what can be; ``unknown`` what cannot and is read, with its line."""

    texts: tuple[str, ...]
    unknown: Mapping[_Key, int]


def variables_before(
    interpreted: InterpretedProgram, main: MainProgram, obstacles: Obstacles, line: int
) -> Variables:
    """What is set before a line of the main program, and read behind it."""
    walk = _Walk(interpreted, obstacles)
    for effect in interpreted.effects:
        if effect.block.line >= line:
            break
        if main.has(effect.block.line):
            walk.read(effect)
    if not (walk.unknown or walk.texts):
        return Variables((), {})
    if walk.calls:
        walk.unknown |= _set_outside(interpreted, main)
    read = _read_behind(interpreted, main, line)
    return Variables(tuple(walk.texts), {key: at for key, at in walk.unknown.items() if _is_read(key, read)})


class _Walk:
    """One walk over the blocks before the line."""

    def __init__(self, interpreted: InterpretedProgram, obstacles: Obstacles) -> None:
        self.interpreted = interpreted
        self.obstacles = obstacles
        self.known: set[int | str | None] = set()
        self.texts: list[str] = []
        self.unknown: dict[_Key, int] = {}
        self.calls = False

    def read(self, effect: BlockEffect) -> None:
        """Take in a block."""
        block = effect.block
        self.calls |= calls_subprogram(effect) or "macro-call" in effect.non_modal
        if "skip" in effect.non_modal or effect.after.modes.motion == "probe":
            self.unknown |= dict.fromkeys(_TOUCHED, block.line)
        if block.assignments:
            self._assigned(block)

    def _assigned(self, block: Block) -> None:
        targets = [next(variables_in(one.target)) for one in block.assignments]
        keys = {key for key in targets if key is not None}
        reads = {key for one in block.assignments for key in variables_in(one.value)}
        if reads <= self.known and None not in targets and self._always_runs(block):
            self.texts.append(block.text.strip())
            self.known |= keys
            self.unknown = {key: line for key, line in self.unknown.items() if key not in keys}
            return
        self.known -= keys
        self.unknown |= dict.fromkeys(keys, block.line)

    def _always_runs(self, block: Block) -> bool:
        alone = not (block.words or block.controls or block.skip)
        return alone and self.obstacles.runs_once(block.line)


def _set_outside(interpreted: InterpretedProgram, main: MainProgram) -> dict[_Key, int]:
    """What subprograms set."""
    found: dict[_Key, int] = {}
    for effect in interpreted.effects:
        if main.has(effect.block.line):
            continue
        targets = [next(variables_in(one.target)) for one in effect.block.assignments]
        found |= {key: effect.block.line for key in targets if key is not None}
    return found


class _Read(NamedTuple):
    """The variables that the main program names behind a line, and those that subprograms name."""

    in_main: set[int | str | None]
    outside: set[int | str | None]


def _read_behind(interpreted: InterpretedProgram, main: MainProgram, line: int) -> _Read:
    in_main: set[int | str | None] = set()
    outside: set[int | str | None] = set()
    for block in _blocks(interpreted, main, line):
        (in_main if main.has(block.line) else outside).update(variables_of(block))
    return _Read(in_main, outside)


def _blocks(interpreted: InterpretedProgram, main: MainProgram, line: int) -> Iterator[Block]:
    for effect in interpreted.effects:
        if effect.block.line >= line or not main.has(effect.block.line):
            yield effect.block


def _is_read(key: _Key, read: _Read) -> bool:
    """True where the rest names it, or may: by a number that is worked out."""
    if None in read.in_main or key in read.in_main:
        return True
    is_global = key.startswith("_") if isinstance(key, str) else key > _LAST_LOCAL
    return is_global and (None in read.outside or key in read.outside)
