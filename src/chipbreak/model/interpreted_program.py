"""The whole program, interpreted.

Blocks that are more than plain motion (special lines) are stepped through one by one.  A run of plain motion
between two of them is skipped over: its end needs only the last word of each axis.
``InterpretedProgram.skip`` must give what advancing block by block gives; a property test holds them equal.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from chipbreak.dialects.modes import Motion
from chipbreak.kinematics.floats import Floats
from chipbreak.model.arrivals import Arrival, Carried, CarriedTo, Place, carried_by, together
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.callers import Program as Called
from chipbreak.model.callers import entry_states, lines_of_calls, local_programs, programs_of
from chipbreak.model.flow import Flow, read_flow
from chipbreak.model.interpret import Interpreter, Steps, initial_state
from chipbreak.model.modal import Position, State, one_unknown
from chipbreak.model.quiet_calls import SAYS_FEED, SAYS_SPEED, calls_that_may_say
from chipbreak.model.repeated_dwells import effects_of, repeated_dwells
from chipbreak.model.words import feed_of, is_diameter, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.columns import read_columns, uniform_run
from chipbreak.syntax.parse import Program
from chipbreak.syntax.shapes import MOTION_CODE, NO_POINT, bits_of
from chipbreak.text.named_tuple import NamedTuple

_MOTION: tuple[Motion, ...] = ("rapid", "line", "cw", "ccw")
_SHORT_RUN = 2  # a step costs a third of a skip
_FAR = 8  # lines that are walked anew rather than their state be kept
_MOST_ROUNDS = 8
_RECENT = 1000  # more than anybody looks ahead


class InterpretedProgram(NamedTuple):
    """The states of a program between its blocks, and what its blocks do.

    ``lines`` and ``states`` hold the state before each line that is no plain motion, and before the line
    after it (behind comments only where moves stand between), so that the state anywhere is a short walk
    away.  ``effects`` are those of blocks that do something.  ``reached`` holds by their line the effects of
    those lines, and the state in which the program reaches them: who walks there in that state need not
    interpret them again.  ``recent`` holds the same of the lines walked last, whatever they are.
    """

    program: Program
    settings: Settings
    flow: Flow
    interpreter: Interpreter
    lines: list[int]
    states: list[State]
    effects: list[BlockEffect]
    reached: dict[int, tuple[State, BlockEffect]]
    recent: dict[int, tuple[State, BlockEffect]]

    def before(self, line: int) -> State:
        """The state before a line; that of its calls where a program begins with it."""
        if line in self.interpreter.entries:
            return self.interpreter.entries[line]
        return self.behind(line)

    def behind(self, line: int) -> State:
        """The state in which what stands before a line leaves the control, whatever begins there."""
        at = bisect_right(self.lines, line) - 1
        return self.skip(self.states[at], self.lines[at], line)

    def effects_of(self, first: int, last: int) -> Iterator[BlockEffect]:
        """The effects of lines ``first`` to ``last`` (exclusive), one by one."""
        state = self.before(first)
        for line in range(first, last):
            effect = self._advance(state, line)
            if _says(effect, "O-ENDSUB"):
                effect = effect._replace(after=self.before(line + 1))
            state = effect.after
            yield effect

    def _advance(self, state: State, line: int) -> BlockEffect:
        """The effect of a line that is reached in a state."""
        for known in (self.reached.get(line), self.recent.get(line)):
            if known is not None and (known[0] is state or known[0] == state):
                return known[1]
        effect = self.interpreter.advance(state, self.program.block(line))
        if len(self.recent) >= _RECENT:
            self.recent.clear()
        self.recent[line] = (state, effect)
        return effect

    def effect(self, line: int) -> BlockEffect:
        """The effect of one line."""
        return next(self.effects_of(line, line + 1))

    def end(self) -> State:
        """The state behind the last line."""
        return self.before(self.program.source.body.stop)

    def skip(self, state: State, first: int, last: int) -> State:
        """The state behind a run of plain lines."""
        line = first
        while line < last:
            stop = self.flow.straight_until(line, last)
            # Step until G0 to G3 is in force; from there on the run needs no steps.
            if stop - line <= _SHORT_RUN or _must_step(state):
                state = self._advance(state, line).after
                line += 1
                continue
            skipped = self._add_up if self._has_distances(state, line, stop) else self._jump
            state = skipped(state, line, stop)
            line = stop
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
                state = self._advance(state, at).after
            line = stop
        return state

    def _has_distances(self, state: State, first: int, last: int) -> bool:
        """True when a run gives distances, by G91 or by U and W."""
        if state.modes.distance == "incremental":
            return True
        return bool(_used(self.program.bits[first:last]) & bits_of(self.settings.axis_words.distances))

    def _values_are_plain(self, first: int, last: int) -> bool:
        """True when every number of a run means what it says."""
        if self.settings.number_rule.reads_whole:
            return True
        return not _used(self.program.bits[first:last]) & NO_POINT

    def _sum(self, state: State, last: int, letters: str, numbers: Floats) -> State:
        """Add up the distances of a run whose blocks all have the same words."""
        control = self.settings.control
        words = self.settings.axis_words
        word_of = {w.address: w for w in self.program.block(last - 1).words}
        ends = state.position._asdict()
        for column, letter in enumerate(letters):
            axis = words.axes.get(letter, "")
            if axis not in words.signs:
                continue
            scale = state.mm_per_unit * words.signs[axis]
            if axis == "X" and is_diameter(state, control):
                scale /= 2.0
            is_distance = letter in words.distances or state.modes.distance == "incremental"
            total = numbers[:, column].sum() if is_distance else numbers[-1, column]
            ends[axis.lower()] = one_unknown(
                (ends[axis.lower()] if is_distance else 0.0) + float(total) * scale
            )
        feed = word_of.get("F")
        if feed is not None:
            state = state._replace(feed=feed_of(feed, state, self.settings.number_rule, last - 1))
        return state._replace(position=Position(**ends))

    def _jump(self, state: State, first: int, last: int) -> State:
        """Take the last word of each letter in a run."""
        bits = self.program.bits[first:last]
        used = _used(bits)
        control = self.settings.control
        words = self.settings.axis_words
        if used & MOTION_CODE:
            shape = self.program.shapes[self.program.plain[first + _last_of(bits, MOTION_CODE)]]
            state = state.with_motion(_MOTION[shape.motion or 0])
        letters = [pair for pair in (*words.letters.items(), ("", "F")) if used & bits_of(pair[1])]
        lines = [first + _last_of(bits, bits_of(letter)) for _, letter in letters]
        blocks = {line: self.program.block(line) for line in set(lines)}
        position = {}
        for (axis, letter), line in zip(letters, lines, strict=True):
            word = blocks[line].word(letter)
            assert word is not None
            if not axis:
                state = state._replace(feed=feed_of(word, state, self.settings.number_rule, line))
                continue
            value = length_mm(word, state, self.settings) * words.signs[axis]
            if axis == "X" and is_diameter(state, control):
                value /= 2.0
            position[axis.lower()] = one_unknown(value)
        return state._replace(position=state.position._replace(**position))


def _must_step(state: State) -> bool:
    """True where the last word of each axis does not say where a run ends."""
    return state.modes.motion not in _MOTION or state.ended


def _says(effect: BlockEffect, keyword: str) -> bool:
    return any(control.keyword == keyword for control in effect.block.controls)


def _used(bits: NDArray[np.uint16]) -> int:
    """What any of the lines has."""
    return int(np.bitwise_or.reduce(bits))


def _last_of(bits: NDArray[np.uint16], wanted: int) -> int:
    """The last line that has a bit which one of them has."""
    stop = len(bits)
    for at, has in enumerate(reversed(bits[-_FAR:].tolist()), 1):
        if has & wanted:
            return stop - at
    window = 64
    while True:
        start = max(0, stop - window)
        found = np.flatnonzero(bits[start:stop] & wanted)
        if len(found):
            return start + int(found[-1])
        stop = start
        window *= 4


def interpret(
    program: Program, settings: Settings, like: InterpretedProgram | None = None
) -> InterpretedProgram:
    """Interpret a program from its first to its last line.

    Further programs of the file begin as their callers leave the control: what those leave is known once they
    are interpreted themselves, so such a file is gone through again.  In one that was made of ``like`` they
    begin as they did there.
    """
    steps: Steps = {}
    interpreted = _as_called(program, settings, like, steps)
    interpreted.interpreter.steps = None  # whoever walks there later may ask for any block
    return interpreted


def _as_called(
    program: Program, settings: Settings, like: InterpretedProgram | None, steps: Steps
) -> InterpretedProgram:
    flow = read_flow(program, settings.dialect)
    # Nearly every file is gone through once, and nothing need be kept of it.
    first = _settled(program, settings, flow, {}, steps if flow.arrivals else None)
    if like is not None:
        entries = _entries_like(first, like)
        return _settled(program, settings, flow, entries, steps) if entries else first
    programs = called_programs(first)
    if not programs:  # as nearly every file
        return first
    interpreted = first
    not_followed: set[int] = set()
    for _ in range(_MOST_ROUNDS):
        before = interpreted.interpreter.entries
        entries = entry_states(interpreted.effects, programs, initial_state(settings), program.block)
        # What a program does from there on may show that it does not begin there.
        not_followed |= before.keys() - entries.keys()
        entries = {line: state for line, state in entries.items() if line not in not_followed}
        if entries == before:
            return interpreted
        interpreted = _settled(program, settings, flow, entries, steps)
    return first


def called_programs(interpreted: InterpretedProgram) -> list[Called]:
    """The programs of a file and the parts that they call; empty where there is nothing but the first one."""
    effects = interpreted.effects
    own = numbered_programs(interpreted)
    parts = local_programs(interpreted.program, effects, interpreted.flow, own)
    return [*own, *parts] if parts or len(own) > 1 else []


def numbered_programs(interpreted: InterpretedProgram) -> list[Called]:
    """The programs of a file that begin with their number, also a single one."""
    stop = interpreted.program.source.body.stop
    return programs_of(interpreted.effects, interpreted.flow, interpreted.settings, stop)


def followed_calls(interpreted: InterpretedProgram) -> frozenset[int]:
    """The lines of the calls whose program, in this file, is known to begin as they leave the control."""
    entries = interpreted.interpreter.entries
    if not entries:
        return frozenset()
    return lines_of_calls(interpreted.effects, called_programs(interpreted), entries)


def _entries_like(interpreted: InterpretedProgram, like: InterpretedProgram) -> dict[int, State]:
    """The states of another program's entries, by the lines in which its programs begin here."""
    known = like.interpreter.entries
    if not known:
        return {}
    here = called_programs(interpreted)
    there = called_programs(like)
    pairs = zip(here, there, strict=True) if len(here) == len(there) else ()
    return {mine.first: known[its.first] for mine, its in pairs if its.first in known}


def _settled(
    program: Program, settings: Settings, flow: Flow, entries: Mapping[int, State], steps: Steps | None
) -> InterpretedProgram:
    """Interpreted again until each way brings what the time before took it to bring.

    The first time nothing has come by any of them yet.
    """
    carried: CarriedTo = dict.fromkeys(flow.arrivals, ())
    for _ in range(_MOST_ROUNDS):
        interpreter = Interpreter(settings, flow, program.source, entries, carried, steps=steps)
        interpreted = _interpreted(program, settings, flow, interpreter)
        found = _carried(interpreted) if carried else carried
        if found == carried:
            return interpreted
        carried = found
    interpreter = Interpreter(settings, flow, program.source, entries, {}, steps=steps)
    return _interpreted(program, settings, flow, interpreter)


def _carried(interpreted: InterpretedProgram) -> CarriedTo:
    """What the ways bring to each place.

    A thousand jumps may go to a thousand blocks of one number: what jumps bring is put together once.
    """
    say_feed = _calls_that_may_say(SAYS_FEED, interpreted)
    say_speed = _calls_that_may_say(SAYS_SPEED, interpreted)
    arrivals = interpreted.flow.arrivals
    each = {id(arrival): arrival for arrival in arrivals.values()}
    shared = {ways: _Brought.by(ways, interpreted) for ways in {one.beside for one in each.values()}}
    brought = {
        key: _Brought.by(arrival.ways, interpreted).beside(shared[arrival.beside])
        for key, arrival in each.items()
    }

    def brought_to(place: Place, arrival: Arrival) -> tuple[Carried, ...]:
        all_ways = brought[id(arrival)]
        # A way that goes back over a call may bring what that says.
        says_feed, says_speed = (
            bisect_left(calls, place.line) < bisect_right(calls, all_ways.last_line)
            for calls in (say_feed, say_speed)
        )
        return tuple(way.without(feed=says_feed, speed=says_speed) for way in all_ways.carried)

    return {place: brought_to(place, arrival) for place, arrival in arrivals.items()}


class _Brought(NamedTuple):
    """What some ways bring, those that bring the same taken together, and the last line they come from."""

    carried: tuple[Carried, ...]
    last_line: int

    @classmethod
    def by(cls, ways: Sequence[Place], interpreted: InterpretedProgram) -> _Brought:
        """What some ways bring."""
        effects = ((way, interpreted.reached[way.line][1]) for way in ways)
        carried = [carried_by(effect.after if way.is_behind else effect.before) for way, effect in effects]
        return cls(together(carried), max((way.line for way in ways), default=0))

    def beside(self, other: _Brought) -> _Brought:
        """What these and other ways bring."""
        if not other.carried:
            return self
        return _Brought(together([*self.carried, *other.carried]), max(self.last_line, other.last_line))


def _calls_that_may_say(says: str, interpreted: InterpretedProgram) -> list[int]:
    own = numbered_programs(interpreted)
    parts = local_programs(interpreted.program, interpreted.effects, interpreted.flow, own)
    programs = [*own, *parts]
    effects = interpreted.effects
    return calls_that_may_say(says, effects, programs, interpreted.program, interpreted.settings)


def _interpreted(
    program: Program, settings: Settings, flow: Flow, interpreter: Interpreter
) -> InterpretedProgram:
    interpreted = InterpretedProgram(program, settings, flow, interpreter, [], [], [], {}, {})
    state = initial_state(settings)
    line = program.source.body.start
    begins = sorted(interpreter.entries)
    around: State | None = None  # a subprogram's body: the program goes on behind it as if it was not there
    interpreted.lines.append(line)
    interpreted.states.append(state)
    for event in program.special_lines.tolist():
        if event < line:  # one of several dwells that were looked at together
            continue
        state = interpreted.skip(state, line, event)
        effect = interpreter.advance(state, program.block(event))
        interpreted.reached[event] = (state, effect)
        if around is None and _says(effect, "O-SUB"):
            around = state
        elif around is not None and _says(effect, "O-ENDSUB"):
            effect = effect._replace(after=around)
            around = None
        line = event + 1
        if effect.after is not state or not effect.block.is_empty:
            _keep(interpreted, effect, state)
            line, state = _behind_dwells(interpreted, effect, begins)
        elif line - interpreted.lines[-1] > _FAR:  # comments alone stand between many moves
            interpreted.lines.append(line)
            interpreted.states.append(state)
    return interpreted


def _keep(interpreted: InterpretedProgram, effect: BlockEffect, state: State) -> None:
    """Add an effect to what is known of a program that reaches its block in a state."""
    line = effect.block.line
    interpreted.effects.append(effect)
    if line > interpreted.lines[-1]:
        # Not effect.before: a jump target forgets, but what stands before its line does not.
        interpreted.lines.append(line)
        interpreted.states.append(state)
    interpreted.lines.append(line + 1)
    interpreted.states.append(effect.after)


def _behind_dwells(
    interpreted: InterpretedProgram, effect: BlockEffect, begins: Sequence[int]
) -> tuple[int, State]:
    """The line behind a dwell, or behind the last one where it comes again and again, and the state there.

    What the others do is added to what is known of the program.  ``begins`` are the lines, in order, in which
    further programs begin.
    """
    program, flow = interpreted.program, interpreted.flow
    line = effect.block.line
    stop = flow.straight_until(line + 1, program.source.body.stop)
    at = bisect_right(begins, line)
    stop = min([stop, *begins[at : at + 1]])
    found = repeated_dwells(program, effect, stop, interpreted.settings)
    state = effect.after
    if found is None:
        return line + 1, state
    for one in effects_of(program, effect, *found):
        line, state = one.block.line, one.after
        interpreted.reached[line] = (state, one)
        _keep(interpreted, one, state)
    return line + 1, state
