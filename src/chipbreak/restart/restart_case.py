"""A line at which a program may be started again, and what must be in force there."""

from __future__ import annotations

import math
from functools import cached_property

from chipbreak.insertion.candidate_rules import Case, Surroundings
from chipbreak.insertion.candidates import Candidate
from chipbreak.insertion.length_offset import offset_words
from chipbreak.insertion.looking_back import effects_before
from chipbreak.model.modal import State
from chipbreak.model.words import codes_of
from chipbreak.operations.operations import calls_tool
from chipbreak.restart.standing import Standing


class RestartCase(Case):
    """What an insertion would find there, but that nothing is in force and no axis is in its place.

    ``file_line`` is the line of the file; ``calls_tool`` says that the program calls a tool next.
    """

    def __init__(
        self,
        surroundings: Surroundings,
        candidate: Candidate,
        program: Standing,
        file_line: int,
        *,
        calls_tool: bool,
    ) -> None:
        super().__init__(surroundings, candidate)
        self.program = program
        self.file_line = file_line
        self.calls_tool = calls_tool

    @property
    def spindle_is_unsure(self) -> bool:
        """A tool call that comes next starts it anew."""
        return not self.calls_tool and super().spindle_is_unsure

    @cached_property
    def has_offset(self) -> bool:
        """A length offset is in force."""
        return self.state.modes.length_offset != "off"

    @cached_property
    def axes(self) -> frozenset[str]:
        """The axes that go to where they stood: all that is known of them, and what the rest relies on."""
        needed = self.dependencies.axes
        if "Z" in needed:  # the way to it starts where the others were
            needed |= frozenset(self.place_axes)
        if self.calls_tool:
            return needed
        position = self.state.position._asdict()
        known = {axis for axis in self.place_axes if not math.isnan(position[axis.lower()])}
        return needed | known

    @cached_property
    def restarts(self) -> bool:
        """The spindle turns, and no tool call comes first after which the program may say that itself."""
        return self.in_force.turns and (not self.calls_tool or super().restarts)

    @cached_property
    def coolant(self) -> frozenset[str]:
        """The coolant that flows, with the same exception."""
        return super().coolant if self.calls_tool else self.in_force.coolant

    @property
    def place_axes(self) -> str:
        """The axes that a place has on this control."""
        return "XZ" if self.dialect.is_lathe else "XYZ"

    @cached_property
    def offset_words(self) -> str | None:
        """What brings the length offset into force, "" where none is needed, None where it is not known."""
        if not self.has_offset or not (self.dependencies.length_offset or "Z" in self.axes):
            return ""
        return offset_words(self.interpreted, self.line) or self._offset_of_the_tool()

    def _offset_of_the_tool(self) -> str | None:
        """``G43`` without H, where no H was ever given: that of the tool that was in the spindle then."""
        for effect in effects_before(self.interpreted, self.line):
            codes = codes_of(effect.block, "length_offset", self.dialect)
            if codes:
                return None if codes[-1] != _OFFSET or self._has_h() else "G43"
            if calls_tool(effect, self.dialect):
                return None
        return None

    def _has_h(self) -> bool:
        return any(
            effect.says("H") and not effect.non_modal
            for effect in effects_before(self.interpreted, self.line)
        )

    @cached_property
    def in_force(self) -> State:
        """What must be in force: what the filtered program has, and the place of the original."""
        runs = self.program.runs_before(self.file_line)
        return runs._replace(position=self.state.position, unknown_why=self.state.unknown_why)


_OFFSET = 430
