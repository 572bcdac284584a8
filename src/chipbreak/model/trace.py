"""The whole program, interpreted.

Blocks that are more than plain motion (events) are stepped through one by one.  A run of plain motion
between two events is skipped over: its end needs only the last word of each axis.  ``Trace.skip`` must give
what advancing block by block gives; a property test holds them equal.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from chipbreak.model.flow import Flow, read_flow
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.model.modal import Position, Setting, State
from chipbreak.model.steps import Step
from chipbreak.model.words import feed_value, is_diameter, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.columns import read_columns, uniform_run
from chipbreak.syntax.parse import Program
from chipbreak.units import MM_PER_INCH

_MOTION = ("rapid", "line", "cw", "ccw")
_SHORT_RUN = 8


@dataclass(frozen=True, eq=False)
class Trace:
    """States and steps of a program.

    ``lines`` and ``states`` hold the state before each line that is no plain motion, and before the line
    after it, so that the state anywhere is a short walk away.  ``events`` are the steps of blocks that do
    something.
    """

    program: Program
    settings: Settings
    flow: Flow
    interpreter: Interpreter
    lines: list[int] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    events: list[Step] = field(default_factory=list)

    def before(self, line: int) -> State:
        """The state before a line."""
        at = bisect_right(self.lines, line) - 1
        return self.skip(self.states[at], self.lines[at], line)

    def steps(self, first: int, last: int) -> Iterator[Step]:
        """The steps of lines ``first`` to ``last`` (exclusive), one by one."""
        state = self.before(first)
        for line in range(first, last):
            step = self.interpreter.advance(state, self.program.block(line))
            state = step.after
            yield step

    def step(self, line: int) -> Step:
        """The step of one line."""
        return next(self.steps(line, line + 1))

    def end(self) -> State:
        """The state behind the last line."""
        return self.before(self.program.source.body.stop)

    def skip(self, state: State, first: int, last: int) -> State:
        """The state behind a run of plain lines."""
        if last <= first:
            return state
        moving = state.modes.get("motion") in _MOTION and not state.ended
        if moving and self.flow.is_straight and last - first > _SHORT_RUN:
            if not self._has_distances(state, first, last):
                return self._jump(state, first, last)
            return self._add_up(state, first, last)
        for line in range(first, last):
            state = self.interpreter.advance(state, self.program.block(line)).after
        return state

    def _add_up(self, state: State, first: int, last: int) -> State:
        """Skip a run with distances: many blocks of the same words at once, others one by one."""
        line = first
        while line < last:
            stop = uniform_run(self.program, line, last)
            long = stop - line > _SHORT_RUN and self._values_are_plain(line, stop)
            table = read_columns(self.program, line, stop) if long else None
            if table is not None:
                state = self._sum(state, stop, *table)
                line = stop
                continue
            stop = stop if long else min(stop, line + _SHORT_RUN)
            for at in range(line, stop):
                state = self.interpreter.advance(state, self.program.block(at)).after
            line = stop
        return state

    def _has_distances(self, state: State, first: int, last: int) -> bool:
        """True when a run gives distances, by G91 or by U and W."""
        if state.modes.get("distance", "absolute") == "incremental":
            return True
        distances = self.settings.axis_words.distances
        used = _used(self.program.plain[first:last])
        return any(distances.intersection(self.program.shapes[i].letters) for i in used)

    def _values_are_plain(self, first: int, last: int) -> bool:
        """True when every number of a run means what it says."""
        if self.settings.control.decimal_point == "calculator":
            return True
        return all(self.program.shapes[i].has_points for i in _used(self.program.plain[first:last]))

    def _sum(self, state: State, last: int, letters: str, numbers: NDArray[np.float64]) -> State:
        """Add up the distances of a run whose blocks all have the same words."""
        control, words = self.settings.control, self.settings.axis_words
        word_of = {w.address: w for w in self.program.block(last - 1).words}
        ends = state.position._asdict()
        for column, letter in enumerate(letters):
            axis = words.axes.get(letter, "")
            if axis not in words.signs:
                continue
            scale = (MM_PER_INCH if state.is_inch else 1.0) * words.signs[axis]
            if axis == "X" and is_diameter(state, control):
                scale /= 2.0
            is_distance = letter in words.distances or state.modes.get("distance") == "incremental"
            total = numbers[:, column].sum() if is_distance else numbers[-1, column]
            ends[axis.lower()] = (ends[axis.lower()] if is_distance else 0.0) + float(total) * scale
        feed = word_of.get("F")
        if feed is not None:
            setting = Setting(feed_value(feed, state, control), feed.value_text, last - 1)
            state = replace(state, feed=setting)
        return replace(state, position=Position(**ends))

    def _jump(self, state: State, first: int, last: int) -> State:
        """Take the last word of each letter in a run."""
        shapes = self.program.shapes
        ids = self.program.plain[first:last]
        used = _used(ids)
        control, words = self.settings.control, self.settings.axis_words
        motion_at = _last_of(ids, [i for i in used if shapes[i].motion is not None], len(shapes))
        if motion_at >= 0:
            state = state.with_modes({"motion": _MOTION[shapes[ids[motion_at]].motion or 0]})
        position = {}
        for axis, letter in (*words.letters.items(), ("", "F")):
            at = _last_of(ids, [i for i in used if letter in shapes[i].letters], len(shapes))
            if at < 0:
                continue
            word = self.program.block(first + at).word(letter)
            assert word is not None
            if not axis:
                state = replace(
                    state, feed=Setting(feed_value(word, state, control), word.value_text, first + at)
                )
                continue
            value = length_mm(word, state, control) * words.signs[axis]
            if axis == "X" and is_diameter(state, control):
                value /= 2.0
            position[axis.lower()] = value
        return replace(state, position=state.position._replace(**position))


def _used(ids: NDArray[np.int32]) -> list[int]:
    """The shapes that occur; what is no plain block there is a blank line or a comment."""
    return (np.flatnonzero(np.bincount(ids + 1)[1:])).tolist()


def _last_of(ids: NDArray[np.int32], wanted: list[int], shape_count: int) -> int:
    """Index of the last element that is one of ``wanted``, -1 for none."""
    if not wanted:
        return -1
    is_wanted = np.zeros(shape_count + 1, np.bool_)  # one more, for the -1 of lines that are no plain block
    is_wanted[wanted] = True
    stop, window = len(ids), 64
    while stop > 0:
        start = max(0, stop - window)
        found = np.flatnonzero(is_wanted[ids[start:stop]])
        if len(found):
            return start + int(found[-1])
        stop, window = start, window * 4
    return -1


def interpret(program: Program, settings: Settings) -> Trace:
    """Interpret a program from its first to its last line."""
    flow = read_flow(program, settings.dialect)
    interpreter = Interpreter(settings, flow)
    trace = Trace(program, settings, flow, interpreter)
    state = initial_state(settings)
    line = program.source.body.start
    trace.lines.append(line)
    trace.states.append(state)
    for event in program.events.tolist():
        state = trace.skip(state, line, event)
        step = interpreter.advance(state, program.block(event))
        line = event + 1
        if step.after is not state or not step.block.is_empty:
            trace.events.append(step)
            if event > trace.lines[-1]:
                # Not step.before: a jump target forgets, but what stands before its line does not.
                trace.lines.append(event)
                trace.states.append(state)
            state = step.after
            trace.lines.append(line)
            trace.states.append(state)
    return trace
