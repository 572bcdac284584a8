"""Where a program can be started again: lines before which all that the rest of it needs is known.

What lets nothing be inserted lets nothing be started either: the tool comes from the safe end of its travel
to where it stood.  So the rules of insertion hold here, and what the rest of the program has from the lines
before comes on top (``from_before``).  Before a tool call it does not matter where the tool before it stood.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from chipbreak.insertion.candidate_rules import RULES, Surroundings
from chipbreak.insertion.candidates import Candidate, Candidates
from chipbreak.insertion.clearance import Clearance
from chipbreak.insertion.obstacles import Obstacles
from chipbreak.insertion.retract import Retract
from chipbreak.operations.operations import calls_tool
from chipbreak.restart.from_before import WHY, Before
from chipbreak.restart.restart_case import RestartCase
from chipbreak.restart.standing import Standing
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.named_tuple import NamedTuple

# Between a comment and the tool call that it names nothing else stands.
_AHEAD = 40


class Refused(NamedTuple):
    """Why the program cannot be started at a line of the file."""

    file_line: int
    why: str


class RestartPoints:
    """The lines of one program, each looked at when it is asked for."""

    def __init__(self, program: Standing) -> None:
        self.program = program
        self.interpreted = program.original
        settings = self.interpreted.settings
        self.dialect = settings.dialect
        self.obstacles = Obstacles(self.interpreted, program.main, says_surface_speed=True)
        self.retract = Retract(settings)
        clearance = Clearance(self.interpreted, program.main) if self.dialect.is_lathe else None
        self.around = Surroundings(
            self.interpreted, self.obstacles, self.retract, clearance, calls_end_offset=False
        )
        self._worth = self._worth_a_look()

    def last_before(self, file_line: int) -> tuple[RestartCase | None, list[Refused]]:
        """The last line up to ``file_line`` at which the program can be started, and why none nearer does."""
        refused: list[Refused] = []
        for place, candidate in self._candidates(file_line):
            case = self._case(place, candidate)
            why = self._why_not(case)
            if not why:
                return case, refused
            refused.append(Refused(place, why))
        return None, refused

    def _candidates(self, file_line: int) -> Iterator[tuple[int, Candidate]]:
        """Places in the file, the nearest first; a stretch from one tool call to the next at a time."""
        main = self.program.main
        place = file_line
        calls = [line for line in self.obstacles.tool_changes if main.has(line)]
        for first in [*reversed(calls), main.first]:
            start = self._start(first)
            if start > place:
                continue
            last = max(first, min(self.program.line_of(place), main.last))
            stretch = Candidates(self.interpreted, self.retract, first, last, "nothing")
            while place >= start:
                written = self.program.written_at(place)
                place = place if written is None else written.start
                yield place, stretch.at(max(first, min(self.program.line_of(place), last)))
                place = self._before(place)

    def _before(self, place: int) -> int:
        """The next place that is worth a look: no move of a cut ends there, but where a tool call comes."""
        line = self.program.line_of(place - 1)
        at = int(np.searchsorted(self._worth, line, "right")) - 1
        if at < 0:
            return place - 1
        worth = int(self._worth[at])
        return place - 1 if worth == line else min(place - 1, int(self.program.places[worth]))

    def _worth_a_look(self) -> NDArray[np.int64]:
        """The lines of the original that plain cutting does not rule out, in order."""
        program = self.interpreted.program
        is_worth = np.ones(len(program.plain) + 1, np.bool_)
        cuts = self.program.main.cuts
        letters = bits_of(self.interpreted.interpreter.axis_letters)
        plain = cuts[(program.plain[cuts] >= 0) & ((program.bits[cuts] & letters) != 0)]
        is_worth[plain + 1] = False
        for line in self.obstacles.tool_changes:
            is_worth[max(line - _AHEAD, 0) : line + 1] = True
        return np.flatnonzero(is_worth[:-1])

    def _start(self, line: int) -> int:
        """Where a line of the original stands, with what chipbreak wrote around it."""
        place = int(self.program.places[line])
        written = self.program.written_at(place)
        return place if written is None else written.start

    def _case(self, place: int, candidate: Candidate) -> RestartCase:
        calls = self._calls_tool_next(candidate.line)
        if calls:  # whatever moved the tool before it: it is changed at the safe end of its travel
            candidate = candidate._replace(mover="home")
        return RestartCase(self.around, candidate, self.program, place, calls_tool=calls)

    def _why_not(self, case: RestartCase) -> str:
        for rule in RULES:
            found = rule(case)
            if found is not None:
                return found.why
        before = Before(self.program, self.obstacles, case)
        return next((why for one in WHY if (why := one(before))), "")

    def _calls_tool_next(self, line: int) -> bool:
        last = min(line + _AHEAD, self.interpreted.program.source.body.stop)
        at = bisect_left(self.obstacles.tool_changes, line)
        if at == len(self.obstacles.tool_changes) or self.obstacles.tool_changes[at] >= last:
            return False
        for effect in self.interpreted.effects_of(line, last):
            if calls_tool(effect, self.dialect):
                return not effect.block.is_optional
            if not (effect.block.is_empty or effect.does("stop")):
                return False
        return False
