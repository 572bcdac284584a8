"""What the subprograms that a program calls leave switched.

One that is in the same file is followed, from the state of its caller.  Where it branches, all that its
blocks set counts as perhaps set, but for an S that all its ways bring to its end.  Of one that is not in the
file, or that calls tools itself, nothing is known.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property
from math import isnan

from chipbreak.insertion.sure_effects import differing, set_by
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram, called_programs, numbered_programs
from chipbreak.model.modal import State
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.operations.operations import calls_tool
from chipbreak.text.named_tuple import NamedTuple

_ONE_PROGRAM = 10_000  # P51234 calls O1234 five times
# Longer ones are whole programs: nobody waits for them to be followed at each call.
_LONGEST = 5_000
_Key = str | int


class _Return(NamedTuple):
    """The state after a call, and what branches may have set besides."""

    state: State
    perhaps: frozenset[str]


class Subprograms:
    """The bodies in a file, by label or number."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.bodies: Mapping[_Key, range] = _bodies(interpreted)
        self._interpreter = Interpreter(interpreted.settings, Flow(frozenset(), ()))
        self._seen: dict[int, frozenset[str] | None] = {}
        self._runs: dict[tuple[object, ...], _Return | None] = {}

    def changes(self, effect: BlockEffect) -> frozenset[str] | None:
        """What the call in a block sets or may set; None where it is not known, empty without a call."""
        line = effect.block.line
        if line not in self._seen:
            end = self._after(effect, ())
            self._seen[line] = end and differing(effect.after, end.state) | end.perhaps
        return self._seen[line]

    def call_tools(self, effect: BlockEffect) -> bool:
        """True when a subprogram in this file, called by a block, calls tools."""
        bodies = [self.body(key) for key in called_by(effect)]
        return any(
            bisect_left(self._tool_lines, body.start) < bisect_left(self._tool_lines, body.stop)
            for body in bodies
            if body is not None
        )

    @cached_property
    def _tool_lines(self) -> list[int]:
        """The lines that call tools."""
        dialect = self.interpreted.settings.dialect
        return [one.block.line for one in self.interpreted.effects if calls_tool(one, dialect)]

    def body(self, key: _Key) -> range | None:
        """The lines of a subprogram in this file, None for one that is not there."""
        if isinstance(key, int) and key not in self.bodies:
            key %= _ONE_PROGRAM
        return self.bodies.get(key)

    def _after(self, effect: BlockEffect, callers: tuple[_Key, ...]) -> _Return | None:
        """The state after a block with all that it calls."""
        found = _Return(effect.after, frozenset())
        for key in called_by(effect):
            end = self._run(key, found.state, callers)
            if end is None:
                return None
            found = _Return(end.state, found.perhaps | end.perhaps)
        return found

    def _run(self, key: _Key, state: State, callers: tuple[_Key, ...]) -> _Return | None:
        if key in callers:
            return None
        speed = state.speed and state.speed.text
        words = (state.path_words, state.path_units, state.smooth_words)
        here = (key, state.modes, state.left_open, state.spindle, state.coolant, speed, *words)
        if here not in self._runs:
            self._runs[here] = self._follow(key, state, callers)
        return self._runs[here]

    def _follow(self, key: _Key, state: State, callers: tuple[_Key, ...]) -> _Return | None:
        body = self.body(key)
        if body is None or len(body) > _LONGEST:
            return None
        walk = _BodyWalk(self.interpreted, state)
        for line in body:
            effect = self._interpreter.advance(walk.state, self.interpreted.program.block(line))
            if effect.does("subprogram", "return"):  # of one branch; another jumps past it
                walk.has_one_end = False
                continue
            end = self._after(effect, (*callers, key))
            if end is None or not walk.take(effect, end):
                return None
        return walk.at_end(body.stop)


class _BodyWalk:
    """What one walk over the blocks of a subprogram has seen: the ``state``, and what they may have set."""

    def __init__(self, interpreted: InterpretedProgram, state: State) -> None:
        self.interpreted = interpreted
        self.state = state
        self.has_one_end = True
        self._is_straight = True
        self._perhaps: set[str] = set()
        self._by_calls: set[str] = set()
        self._is_optional = False

    def take(self, effect: BlockEffect, end: _Return) -> bool:
        """Take in a block and what it calls; False where nothing is known behind it."""
        dialect = self.interpreted.settings.dialect
        if effect.block.opaque or effect.after.ended or calls_tool(effect, dialect):
            return False
        keywords = {control.keyword for control in effect.block.controls} - {"O-CALL"}
        self._is_optional = self._is_optional or effect.block.is_optional
        self.has_one_end = self.has_one_end and "O-RETURN" not in keywords
        self._is_straight = self._is_straight and not keywords and not effect.block.is_optional
        by_calls = differing(effect.after, end.state) | end.perhaps
        self._by_calls |= by_calls
        self._perhaps |= set_by(effect, self.interpreted) | differing(self.state, effect.after) | by_calls
        self.state = end.state
        return True

    def at_end(self, line: int) -> _Return:
        """What holds in the line in which the body ends."""
        if self._is_straight:
            return _Return(self.state, frozenset())
        speed = self.interpreted.before(line).speed
        says_itself = "S" in self._perhaps and "S" not in self._by_calls and not self._is_optional
        if says_itself and self.has_one_end and speed is not None and not isnan(speed.value):
            # All its ways bring this one, wherever it is called from.
            return _Return(self.state._replace(speed=speed), frozenset(self._perhaps - {"S"}))
        return _Return(self.state, frozenset(self._perhaps))


def called_by(effect: BlockEffect) -> Iterator[_Key]:
    """The labels or numbers of what a block calls; an empty text where it has no name that can be read."""
    for control in effect.block.controls:
        if control.keyword == "O-CALL":
            yield control.label.lower()
    is_macro = "macro-call" in effect.non_modal or effect.after.modes.modal_macro == "on"
    if is_macro or (calls_subprogram(effect) and not effect.block.controls):
        number = effect.block.number("P")
        if number is None:
            yield ""
        else:
            yield _part(int(number)) if effect.does("subprogram", "local-call") else int(number)


def _part(number: int) -> str:
    """The key of the part of a program that its M97 calls; labels are in lower case."""
    return f"N{number}"


def _bodies(interpreted: InterpretedProgram) -> dict[_Key, range]:
    """The lines of ``o<name> sub`` to ``endsub``, of ``O1000`` and of parts to M99, without these."""
    found: dict[_Key, range] = _parts(interpreted)
    for one in numbered_programs(interpreted):
        if one.returns:
            found.setdefault(one.number, range(one.first + 1, one.last_return))
    opened: tuple[_Key, int] | None = None
    for effect in interpreted.effects:
        line = effect.block.line
        labels = {control.keyword: control.label.lower() for control in effect.block.controls}
        if opened and "O-ENDSUB" in labels:
            found.setdefault(opened[0], range(opened[1], line))
            opened = None
        if "O-SUB" in labels:
            opened = labels["O-SUB"], line + 1
    return found


def _parts(interpreted: InterpretedProgram) -> dict[_Key, range]:
    """The parts of the programs that a number names alone."""
    parts = [one for one in called_programs(interpreted) if one.is_part and one.returns]
    counts = Counter(one.number for one in parts)
    return {_part(one.number): range(one.first, one.last_return) for one in parts if counts[one.number] == 1}
