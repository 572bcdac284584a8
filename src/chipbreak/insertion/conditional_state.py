"""What is not known for sure, because it may be left out: block delete, branches, loops, jumps, subprograms.

A part that may be left out is one whose lines may never run: ``o10 if``, ``WHILE``, what a jump forward
passes by.  After it everything counts as perhaps set that it sets otherwise than it was.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

from chipbreak.insertion.subprograms import Subprograms
from chipbreak.insertion.sure_effects import differing, set_by
from chipbreak.model.arrivals import runs_at_least_once
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.text.named_tuple import NamedTuple

_OPENERS = {
    "O-IF": "O-ENDIF",
    "O-REPEAT": "O-ENDREPEAT",
    "O-DO": "O-WHILE",
    "O-WHILE": "O-ENDWHILE",
    "DO": "END",
}
# Where ways meet that bring different speeds, the model knows none: that is seen without this.
_SEEN = frozenset({"S"})
_EXITS = frozenset({"O-ELSE", "O-ELSEIF", "O-BREAK", "O-CONTINUE", "O-RETURN", "GOTO"})


class Nest(NamedTuple):
    """[first, last] lines of a loop or a branch, and whether it may be left out."""

    first: int
    last: int
    is_optional: bool


class Part(NamedTuple):
    """[first, last] lines that may be left out, and what they set otherwise than it was."""

    first: int
    last: int
    sets: frozenset[str]


class Conditional(NamedTuple):
    """What is conditional from a line on: what may or may not have been set -> the line that did it."""

    line: int
    setters: Mapping[str, int]


def nests_of(interpreted: InterpretedProgram) -> Iterator[Nest]:
    """Loops and branches; one that is never closed runs to the end."""
    opened: list[tuple[str, str, int, bool]] = []
    for effect in interpreted.effects:
        has_condition = "WHILE" in _keywords(effect)
        for control in effect.block.controls:
            keyword = control.keyword
            label = control.label
            line = effect.block.line
            closes = bool(opened) and opened[-1][0] == keyword and opened[-1][1] in ("", label)
            if closes:
                _, _, first, is_optional = opened.pop()
                yield Nest(first, line, is_optional)
            elif keyword in _OPENERS:
                closer = label if keyword == "O-DO" else ""
                may_never_run = has_condition or not runs_at_least_once(control)
                opened.append((_OPENERS[keyword], closer, line, may_never_run))
    for _, _, line, is_optional in opened:
        yield Nest(line, interpreted.program.source.body.stop, is_optional)


def _keywords(effect: BlockEffect) -> frozenset[str]:
    return frozenset(control.keyword for control in effect.block.controls)


def jumps_of(interpreted: InterpretedProgram) -> tuple[int, int] | None:
    """From the first to the last line that a jump leaves or reaches."""
    lines = jump_lines(interpreted)
    if not lines:
        return None
    lines += interpreted.flow.targets
    return min(lines), max(lines)


def jump_lines(interpreted: InterpretedProgram) -> list[int]:
    """The lines of all jumps (GOTO)."""
    return [
        effect.block.line
        for effect in interpreted.effects
        if any(control.keyword == "GOTO" for control in effect.block.controls)
    ]


def optional_parts(
    interpreted: InterpretedProgram, nests: Sequence[Nest], jumps: tuple[int, int] | None
) -> list[Part]:
    """The parts that may be left out, by their last lines."""
    parts = []
    lines = [effect.block.line for effect in interpreted.effects]
    keywords = [_keywords(effect) for effect in interpreted.effects] if nests else []
    for nest in nests:
        where = slice(bisect_left(lines, nest.first), bisect_right(lines, nest.last))
        inner = interpreted.effects[where]
        if not _EXITS.isdisjoint(chain.from_iterable(keywords[where])):
            parts.append(Part(nest.first, nest.last, _all_set(inner, interpreted) - _SEEN))
        elif nest.is_optional:
            sets = differing(inner[0].before, inner[-1].after) - _SEEN
            parts.append(Part(nest.first, nest.last, sets))
    if jumps and any(target > min(jump_lines(interpreted)) for target in interpreted.flow.targets):
        passed = [effect for effect in interpreted.effects if jumps[0] <= effect.block.line <= jumps[1]]
        parts.append(Part(*jumps, _all_set(passed, interpreted) - _SEEN))
    return sorted(parts, key=lambda part: part.last)


def _all_set(effects: Sequence[BlockEffect], interpreted: InterpretedProgram) -> frozenset[str]:
    sets = {
        what
        for effect in effects
        for what in set_by(effect, interpreted) | differing(effect.before, effect.after)
    }
    return frozenset(sets | {"motion"})


def conditional_state(
    interpreted: InterpretedProgram,
    main: MainProgram,
    subprograms: Subprograms,
    nests: Sequence[Nest],
    parts: Sequence[Part],
) -> Iterator[Conditional]:
    """What is conditional, wherever that changes, by line.

    What the body of a subprogram sets counts where it is called.
    """
    in_main = [part for part in parts if main.has(part.first) or main.has(part.last)]
    walk = _Walk(interpreted, subprograms, nests, in_main)
    for effect in interpreted.effects:
        if main.has(effect.block.line):
            yield from walk.read(effect)
    yield from walk.close(interpreted.program.source.body.stop + 1)


class _Walk:
    """One walk over the blocks; ``ends`` are the parts that it has not left yet, by their last lines."""

    def __init__(
        self,
        interpreted: InterpretedProgram,
        subprograms: Subprograms,
        nests: Sequence[Nest],
        parts: Sequence[Part],
    ) -> None:
        self.interpreted = interpreted
        self.subprograms = subprograms
        self.nests = nests
        self.ends = list(parts)
        self.outermost = list(_outermost(parts))
        self.setters: dict[str, int] = {}
        self.kept: dict[str, int] = {}  # by LinuxCNC's M70, which M72 gives back
        self.kept_by: BlockEffect | None = None

    def read(self, effect: BlockEffect) -> Iterator[Conditional]:
        """Take in a block, and say what it changes."""
        line = effect.block.line
        yield from self.close(line)
        before = dict(self.setters)
        called = self.subprograms.changes(effect) or frozenset()
        if effect.does("modes", "keep"):
            self._keep(effect)
        elif effect.does("modes"):
            self.setters |= self.kept
        unsure = called | _perhaps_set(effect)
        if unsure or effect.block.is_optional:
            self.setters |= dict.fromkeys(sorted(unsure), line)
        elif self.setters and not _is_within(line, self.outermost):
            for what in set_by(effect, self.interpreted):
                self.setters.pop(what, None)
        if self.setters != before:
            yield Conditional(line, dict(self.setters))

    def _keep(self, effect: BlockEffect) -> None:
        """M70 keeps what is set; where it may be left out, that or what the one before it has kept.

        In a further pass of a loop it may find what the end of the pass before has set.
        """
        line = effect.block.line
        others = [self.interpreted.behind(nest.last) for nest in self.nests if nest.first < line < nest.last]
        kept: dict[str, int] = {}
        if effect.block.is_optional or _is_within(line, self.outermost):
            kept = self.kept
            others += [self.kept_by.before] if self.kept_by is not None else []
        unsure = frozenset[str]().union(*(differing(other, effect.before) for other in others))
        self.kept = kept | dict.fromkeys(sorted(unsure), line) | self.setters
        self.kept_by = effect

    def close(self, line: int) -> Iterator[Conditional]:
        """Leave the parts that end before a line."""
        while self.ends and self.ends[0].last < line:
            part = self.ends.pop(0)
            self.setters |= dict.fromkeys(sorted(part.sets), part.last)
            yield Conditional(part.last, dict(self.setters))


def _outermost(parts: Sequence[Part]) -> Iterator[tuple[int, int]]:
    """[first, last] lines of the parts that lie in no other one, in order."""
    reached = -1
    for part in sorted(parts, key=lambda part: (part.first, -part.last)):
        if part.last > reached:
            yield part.first, part.last
            reached = part.last


def _is_within(line: int, parts: Sequence[tuple[int, int]]) -> bool:
    at = bisect_right(parts, (line, 1 << 62)) - 1
    return at >= 0 and line <= parts[at][1]


def _perhaps_set(effect: BlockEffect) -> frozenset[str]:
    """What a block may set, or may not: one that may be skipped, or whose codes the machine works out."""
    words = effect.block.words_of("GM")
    worked_out = {word.address for word in words if word.number is None}.difference(effect.taken)
    if not (effect.block.is_optional or worked_out):
        return frozenset()
    changed = differing(effect.before, effect.after)
    return changed | {"the spindle", "coolant"} if "M" in worked_out else changed
