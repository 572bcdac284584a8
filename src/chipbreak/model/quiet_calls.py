"""Calls behind which F, or S, is what it was before: of programs in this file that do not say it.

::

    WHILE[#1LT3]DO1          O0200
    M98 P0200                G91 G1 X5.
    #1=#1+1                  G90
    END1                     M99

A loop whose body calls such a program keeps the F and S that it was reached with.  One that says an F of its
own still keeps S.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from chipbreak.dialects.modes import Group
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.callers import Program, called_by_number, may_call
from chipbreak.model.words import codes_of
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program as Text

# Words that set F, and those that set S (V and D are a cutting speed); T may be another tool's spindle.
SAYS_FEED = "FT"
SAYS_SPEED = "SVT"
# By these their numbers are read.
_READ_BY: tuple[Group, ...] = ("units", "feed_mode", "speed_mode", "modal_macro")
_LONGEST = 5_000  # lines of a program that are looked through
_DEEPEST = 8


def calls_that_may_say(
    says: str, effects: Sequence[BlockEffect], programs: Sequence[Program], text: Text, settings: Settings
) -> list[int]:
    """The lines of all calls but those that say none of some words."""
    if not any(map(may_call, effects)):
        return []
    quiet = _Quiet(says, effects, programs, text, settings)
    return [line for line, call in quiet.calls.items() if not quiet.is_quiet(call, 0)]


class _Quiet:
    def __init__(
        self,
        says: str,
        effects: Sequence[BlockEffect],
        programs: Sequence[Program],
        text: Text,
        settings: Settings,
    ) -> None:
        self.says = says
        self.programs = programs
        self.text = text
        self.settings = settings
        self.calls = {effect.block.line: effect for effect in effects if may_call(effect)}
        self.returns = {e.block.line for e in effects if e.does("subprogram", "return")}
        self.gives_back = {e.block.line for e in effects if e.does("modes")}
        self.labelled = dict(_labelled(effects))
        self.known: dict[range, bool] = {}

    def is_quiet(self, call: BlockEffect, depth: int) -> bool:
        """True where all that a block calls is in this file and says nothing."""
        bodies = self._bodies(call)
        return bool(bodies) and depth < _DEEPEST and all(self._says_nothing(body, depth) for body in bodies)

    def _bodies(self, call: BlockEffect) -> list[range]:
        """The lines of what a block calls; empty where some of it is not known."""
        labels = [one.label.lower() for one in call.block.controls if one.keyword == "O-CALL"]
        if labels:
            found = [self.labelled[label] for label in labels if label in self.labelled]
            return found if len(found) == len(labels) else []
        if call.after.modes.modal_macro == "on":
            return []
        program = called_by_number(call, self.programs)
        return [] if program is None else [range(program.first + (not program.is_part), program.last)]

    def _says_nothing(self, body: range, depth: int) -> bool:
        if body not in self.known:
            self.known[body] = False  # one that calls itself
            is_short = len(body) <= _LONGEST
            self.known[body] = is_short and all(self._is_idle(line, depth) for line in body)
        return self.known[body]

    def _is_idle(self, line: int, depth: int) -> bool:
        block = self.text.block(line)
        if line in self.calls:
            return not block.has_any(self.says) and self.is_quiet(self.calls[line], depth + 1)
        jumps_to_its_caller = line in self.returns and block.has("P")
        says = block.opaque or block.has_any(self.says) or line in self.gives_back
        speaks = any("SPEED" in comment.text.upper() for comment in block.comments)
        reads = any(codes_of(block, group, self.settings.dialect) for group in _READ_BY)
        return not (jumps_to_its_caller or says or speaks or reads)


def _labelled(effects: Sequence[BlockEffect]) -> Iterator[tuple[str, range]]:
    """The bodies of subprograms with a label."""
    opened: Mapping[str, int] = {}
    for effect in effects:
        for control in effect.block.controls:
            label = control.label.lower()
            if control.keyword == "O-SUB":
                opened = {label: effect.block.line + 1}
            elif control.keyword == "O-ENDSUB" and label in opened:
                yield label, range(opened[label], effect.block.line)
