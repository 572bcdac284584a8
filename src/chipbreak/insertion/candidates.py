"""Lines before which something might be inserted, each with the state there and what moved the tool last."""

from __future__ import annotations

from bisect import bisect_right
from typing import Final, Literal

import numpy as np

from chipbreak.insertion.position_dependencies import homed_axes, named_axes
from chipbreak.insertion.retract import Retract
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.plain_run import MODES, RAPID, modes_of
from chipbreak.model.words import codes_of
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.operations.operations import calls_tool
from chipbreak.settings.sections import Settings
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.named_tuple import NamedTuple

# "nothing" yet, "rapid", "home" (or the machine's own tool change), "call" of a subprogram or a macro, or
# "cut" for all else.
Mover = Literal["nothing", "rapid", "home", "call", "cut"]
_Deed = Literal["tool change", "home", "call", "rapid", "cut", "nothing"]
_AXES: Final = frozenset("XYZ")
_CENTRES = "IJK"
_CW = MODES.index("cw")
_LONG_RUN = 16
_MOVERS: dict[_Deed, Mover] = {
    "tool change": "home",
    "home": "home",
    "call": "call",
    "rapid": "rapid",
    "cut": "cut",
}


class Candidate(NamedTuple):
    """A line, the state before it, and what brought the tool there.

    ``mover``   what moved last
    ``homed``   axes that the program sent to a fixed place where our own retract does not take them
    ``z_is_home``  the last move of Z was a reference return, which ends the length offset as ours does
    ``z_is_shifted``  the length offset changed after the last move of Z: its number says nothing now
    ``is_displaced``  X and Y are beside their numbers: G40 has ended cutter compensation without a move
    ``is_low``  Z has not gone up since the last cut; not said behind a run that was not stepped through
    """

    line: int
    state: State
    mover: Mover
    homed: frozenset[str] = frozenset()
    z_is_home: bool = False
    z_is_shifted: bool = False
    is_displaced: bool = False
    is_low: bool = False


def candidates(
    interpreted: InterpretedProgram, retract: Retract, first: int, last: int, mover: Mover
) -> list[Candidate]:
    """The lines ``first`` to ``last``; ``mover`` is what moved before the first one."""
    state = interpreted.before(first)
    found = [Candidate(first, state, mover, is_displaced=_compensates(state), is_low=mover == "cut")]
    for effect in interpreted.effects_of(first, last):
        found.append(_Step(effect, interpreted.settings, retract).after(found[-1]))
    return found


class Candidates:
    """The same lines, each when it is asked for: long runs of plain motion are not stepped through."""

    def __init__(
        self, interpreted: InterpretedProgram, retract: Retract, first: int, last: int, mover: Mover
    ) -> None:
        self._interpreted = interpreted
        self._retract = retract
        state = interpreted.before(first)
        found = Candidate(first, state, mover, is_displaced=_compensates(state))
        self._known = [found]
        special = interpreted.program.special_lines
        for line in special[(special >= first) & (special < last)].tolist():
            found = self._stepped(self._over_run(found, line), line + 1)
            self._known.append(found)

    def at(self, line: int) -> Candidate:
        """The candidate before a line."""
        at = bisect_right(self._known, line, key=lambda one: one.line) - 1
        return self._over_run(self._known[at], line)

    def _over_run(self, before: Candidate, line: int) -> Candidate:
        """The candidate behind a run of plain lines."""
        modes = before.state.modes
        is_straight = self._interpreted.flow.straight_until(before.line, line) == line
        is_plain = modes.motion in MODES and not before.state.ended and is_straight
        if line - before.line < _LONG_RUN or not is_plain:
            return self._stepped(before, line)
        program = self._interpreted.program
        words = self._interpreted.settings.axis_words
        bits = program.bits[before.line : line]
        used = int(np.bitwise_or.reduce(bits))
        named = frozenset(axis for letter, axis in words.axes.items() if used & bits_of(letter)) & _AXES
        mode = modes_of(self._interpreted, before.state, before.line, line)
        letters = bits_of(self._interpreted.interpreter.axis_letters)
        moves = ((bits & letters) != 0) | ((mode >= _CW) & ((bits & bits_of(_CENTRES)) != 0))
        moving = np.flatnonzero(moves)
        if not len(moving):
            return before._replace(line=line, state=self._interpreted.before(line))
        return Candidate(
            line,
            self._interpreted.before(line),
            "rapid" if mode[moving[-1]] == RAPID else "cut",
            before.homed - named,
            before.z_is_home and "Z" not in named,
            before.z_is_shifted and "Z" not in named,
            before.is_displaced and (_compensates(before.state) or not named & {"X", "Y"}),
        )

    def _stepped(self, before: Candidate, line: int) -> Candidate:
        for effect in self._interpreted.effects_of(before.line, line):
            before = _Step(effect, self._interpreted.settings, self._retract).after(before)
        return before


class _Step:
    """One block, and what it makes of each fact about the line before it."""

    def __init__(self, effect: BlockEffect, settings: Settings, retract: Retract) -> None:
        self.effect = effect
        self.settings = settings
        self.retract = retract
        self.deed = _deed_of(effect, settings)
        axes_of = homed_axes if "home" in effect.non_modal else named_axes
        self.named = axes_of(effect, settings)

    def after(self, before: Candidate) -> Candidate:
        """The next line."""
        mover = _MOVERS.get(self.deed, before.mover)
        return Candidate(
            before.line + 1,
            self.effect.after,
            mover,
            self._homed(before),
            self._z_is_home(before),
            self._z_is_shifted(before),
            self._is_displaced(before, mover),
            self._is_low(before),
        )

    def _homed(self, before: Candidate) -> frozenset[str]:
        if self.deed == "tool change":
            return frozenset()
        if self.deed == "home":
            return before.homed | (self.named - self.retract.repeats(self.effect))
        return before.homed - self.named if self.deed in ("rapid", "cut") else before.homed

    def _z_is_home(self, before: Candidate) -> bool:
        if "Z" in self.named and "home" in self.effect.non_modal:
            return True
        return before.z_is_home and not ("Z" in self.named and self.deed in ("rapid", "cut"))

    def _z_is_shifted(self, before: Candidate) -> bool:
        if self._moves("Z"):
            return False
        shifts = bool(codes_of(self.effect.block, "length_offset", self.settings.dialect))
        return shifts or before.z_is_shifted

    def _is_displaced(self, before: Candidate, mover: Mover) -> bool:
        if _compensates(self.effect.after):
            return True
        return before.is_displaced and mover != "home" and not self._moves("XY")

    def _is_low(self, before: Candidate) -> bool:
        if self.deed in ("tool change", "home") and (self.deed == "tool change" or "Z" in self.named):
            return False
        move = self.effect.move
        if move is None or self.deed not in ("rapid", "cut"):
            return before.is_low
        if self.effect.after.modes.motion == "cycle":  # which ends with its own way out
            return False
        # Where it was is not known behind a cycle or a call; a rapid that names Z is the way up there, and
        # behind a cut in the air it has nowhere to go.
        rises = "Z" in move.axes and not move.end.z < move.start.z
        if self.deed == "cut":
            return not (rises and move.axes == "Z" and move.kind == "line")
        return before.is_low and not rises

    def _moves(self, axes: str) -> bool:
        move = self.effect.move
        return move is not None and any(axis in move.axes for axis in axes)


def _deed_of(effect: BlockEffect, settings: Settings) -> _Deed:
    """What a block does with the tool."""
    motion = effect.after.modes.motion
    if calls_tool(effect, settings.dialect):
        return "tool change"
    if "home" in effect.non_modal or ("machine" in effect.non_modal and motion == "rapid"):
        return "home"
    if calls_subprogram(effect) or effect.non_modal & {"macro-call", "service"}:
        return "call"
    if effect.move is None:
        return "nothing"
    # A canned cycle ends with its own way out.
    is_rapid = effect.move.kind == "rapid" or (motion == "cycle" and not effect.non_modal)
    return "rapid" if is_rapid else "cut"


def _compensates(state: State) -> bool:
    return state.modes.compensation != "off"
