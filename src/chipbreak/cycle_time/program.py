"""The time of a whole program, as it is written, from its first line to its end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from chipbreak.cycle_time.blocks import BlockTimer
from chipbreak.cycle_time.clock import Clock, Machine
from chipbreak.cycle_time.runs import time_run
from chipbreak.insertion.subprograms import Subprograms, called_by
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.operations.main_program import MainProgram
from chipbreak.syntax.parse import parse_changed
from chipbreak.text.excerpt import Excerpt, Gap
from chipbreak.text.source import Source, UserLines, line_starts

_ONE_PROGRAM = 10_000  # P51234 calls O1234 five times
_MOST_STEPS = 100_000
_DEEPEST = 8
_LONG_RUN = 16
# So many lines that their columns of numbers stay in the cache.
_PIECE_LINES = 1 << 14


def time_program(interpreted: InterpretedProgram, main: MainProgram, excerpt: Excerpt | None = None) -> Clock:
    """Add up what every line of the main program takes, with the subprograms that are in the file.

    What an ``excerpt`` leaves out is read from its file.  Raises OSError where that cannot be read.
    """
    return _Walk(interpreted, main, excerpt).clock


class _Walk:
    """Goes through a program once: runs of plain moves at a time, other lines one by one."""

    def __init__(self, interpreted: InterpretedProgram, main: MainProgram, excerpt: Excerpt | None) -> None:
        self.interpreted = interpreted
        self.main = main
        self.excerpt = excerpt
        self.clock = Clock(Machine(interpreted.settings), interpreted.program.source)
        self.timer = BlockTimer(interpreted.settings, self.clock)
        self.subprograms = Subprograms(interpreted)
        self.steps = 0
        effects = {effect.block.line: effect for effect in interpreted.effects}
        at = main.first
        specials = interpreted.program.special_lines
        state = interpreted.before(at)
        for line in [*specials[(specials >= at) & (specials < main.last)].tolist(), main.last]:
            state = self._run(state, at, line)
            effect = effects.get(line)
            if effect is not None and line < main.last:
                if main.has(line):
                    self.timer.time(effect)
                    self._call(effect, 0)
                state = effect.after
            at = line + 1

    def _run(self, state: State, first: int, last: int) -> State:
        """Plain lines between two others, a piece at a time; the state behind them."""
        if not self.main.has(first):
            return self.interpreted.skip(state, first, last)
        for part, at, stop in self._pieces(first, last):
            self._piece(part, state, at, stop)
            state = part.skip(state, at, stop)
        return state

    def _pieces(self, first: int, last: int) -> Iterator[tuple[InterpretedProgram, int, int]]:
        """Plain lines, with the program in which they stand; with those that an excerpt leaves out."""
        gaps = self.excerpt.gaps_in(first, last) if self.excerpt is not None else ()
        if gaps and self.excerpt is not None:
            yield from _read_again(self.interpreted, self.excerpt, range(first, last), gaps)
            return
        for at in range(first, last, _PIECE_LINES):
            yield self.interpreted, at, min(at + _PIECE_LINES, last)

    def _piece(self, part: InterpretedProgram, state: State, first: int, last: int) -> None:
        """Plain lines, all at once where that is possible."""
        self.clock.source = part.program.source
        if last - first < _LONG_RUN or not time_run(part, state, first, last, self.clock):
            for effect in _stepped(part, state, first, last):
                self.timer.time(effect)
        self.clock.source = self.interpreted.program.source

    def _call(self, effect: BlockEffect, depth: int) -> None:
        """Add the time of what a block calls, as often as it does."""
        for key in called_by(effect):
            body = self.subprograms.body(key)
            if body is None or depth >= _DEEPEST or self.steps + len(body) > _MOST_STEPS:
                self.clock.cannot(effect.block.line, "what it calls is not followed")
                continue
            count = _count(effect, key)
            self.clock.calls.append((body, count))
            before = self.clock.seconds.copy()
            # The call itself moves nothing: the subprogram begins where the tool stands.
            state = effect.after if effect.move else effect.after._replace(position=effect.before.position)
            self._body(state, body, depth)
            for what, seconds in self.clock.seconds.items():
                self.clock.seconds[what] = before[what] + count * (seconds - before[what])

    def _body(self, state: State, body: range, depth: int) -> None:
        """One run through a subprogram, from the state of its caller."""
        interpreter = Interpreter(self.interpreted.settings, Flow(frozenset(), ()))
        for line in body:
            self.steps += 1
            effect = interpreter.advance(state, self.interpreted.program.block(line))
            if effect.does("subprogram", "return"):  # what stands behind is another branch's
                break
            self.timer.time(effect)
            self._call(effect, depth + 1)
            state = effect.after


def _stepped(part: InterpretedProgram, state: State, first: int, last: int) -> Iterator[BlockEffect]:
    for line in range(first, last):
        effect = part.interpreter.advance(state, part.program.block(line))
        yield effect
        state = effect.after


def _read_again(
    interpreted: InterpretedProgram, excerpt: Excerpt, lines: range, gaps: Sequence[Gap]
) -> Iterator[tuple[InterpretedProgram, int, int]]:
    """A run of plain lines as it stands in the file, where an excerpt has only some of it."""
    source = excerpt.source
    start = excerpt.file_place(lines.start)
    size = int(source.starts[lines.stop] - source.starts[lines.start]) + sum(gap.size for gap in gaps)
    number = source.place(lines.start).line
    for data in excerpt.pieces(start, size, _PIECE_LINES):
        starts = line_starts(data)
        count = len(starts) - 1
        places = UserLines(None, np.arange(number, number + count), np.zeros(count, np.int64))
        number += count
        piece = Source(data, source.name, starts, source.line_end, range(count), source.encoding, places)
        part = parse_changed(piece, interpreted.program, ())
        yield interpreted._replace(program=part, reached={}), 0, count


def _count(effect: BlockEffect, key: str | int) -> int:
    """How often a block calls: ``M98 P1000 L3``, ``M98 P31000``."""
    said = effect.block.number("L")
    if said is not None:
        return max(1, int(said))
    return max(1, key // _ONE_PROGRAM) if isinstance(key, int) and key > _ONE_PROGRAM else 1
