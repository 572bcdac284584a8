"""What nobody knows for sure, because it may be left out: block delete, branches, loops, jumps, subprograms.

A part that may be left out is one whose lines may never run: ``o10 if``, ``WHILE``, what a jump forward
passes by.  Behind it everything counts as perhaps set that it sets otherwise than it was.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from chipbreak.insertion.subprograms import Subprograms
from chipbreak.insertion.sure_effects import differing, set_by
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.syntax.nodes import Number

_OPENERS = {"O-IF": "O-ENDIF", "O-REPEAT": "O-ENDREPEAT", "O-DO": "O-WHILE", "DO": "END"}
_WAYS_OUT = frozenset({"O-ELSE", "O-ELSEIF", "O-BREAK", "O-CONTINUE", "O-RETURN", "GOTO"})


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


def nests_of(interpreted: InterpretedProgram) -> Iterator[Nest]:
    """Loops and branches; one that is never closed runs to the end."""
    opened: list[tuple[str, str, int, bool]] = []
    for effect in interpreted.effects:
        for control in effect.block.controls:
            keyword, label, line = control.keyword, control.label, effect.block.line
            closes = bool(opened) and opened[-1][0] == keyword and opened[-1][1] in ("", label)
            if closes:
                _, _, first, is_optional = opened.pop()
                yield Nest(first, line, is_optional)
            elif keyword in _OPENERS:
                closer = label if keyword == "O-DO" else ""
                opened.append((_OPENERS[keyword], closer, line, _may_never_run(effect, keyword)))
            elif keyword == "O-WHILE":
                opened.append(("O-ENDWHILE", "", line, True))
    for _, _, line, is_optional in opened:
        yield Nest(line, interpreted.program.source.body.stop, is_optional)


def _may_never_run(effect: BlockEffect, keyword: str) -> bool:
    controls = effect.block.controls
    if keyword == "DO":
        return any(control.keyword == "WHILE" for control in controls)
    if keyword == "O-REPEAT":
        times = [one for control in controls for one in control.arguments]
        return not (times and isinstance(times[0], Number) and times[0].value >= 1.0)
    return keyword == "O-IF"


def jumps_of(interpreted: InterpretedProgram) -> tuple[int, int] | None:
    """From the first to the last line that a jump leaves or reaches."""
    lines = _jump_lines(interpreted)
    if not lines:
        return None
    lines += interpreted.flow.targets
    return min(lines), max(lines)


def _jump_lines(interpreted: InterpretedProgram) -> list[int]:
    return [s.block.line for s in interpreted.effects if any(c.keyword == "GOTO" for c in s.block.controls)]


def optional_parts(
    interpreted: InterpretedProgram, nests: Sequence[Nest], jumps: tuple[int, int] | None
) -> list[Part]:
    """The parts that may be left out, by their last lines."""
    parts = []
    lines = [effect.block.line for effect in interpreted.effects]
    for nest in nests:
        inner = interpreted.effects[bisect_left(lines, nest.first) : bisect_right(lines, nest.last)]
        ways = {control.keyword for effect in inner for control in effect.block.controls}
        if ways & _WAYS_OUT:
            parts.append(Part(nest.first, nest.last, _all_set(inner, interpreted)))
        elif nest.is_optional:
            # A loop and a branch end with a speed that is not known: that is seen without this.
            one, other = inner[0].before, inner[-1].after
            parts.append(Part(nest.first, nest.last, differing(one, other) - {"S"}))
    if jumps and any(target > min(_jump_lines(interpreted)) for target in interpreted.flow.targets):
        passed = [effect for effect in interpreted.effects if jumps[0] <= effect.block.line <= jumps[1]]
        parts.append(Part(*jumps, _all_set(passed, interpreted)))
    return sorted(parts, key=lambda part: part.last)


def _all_set(effects_of: Sequence[BlockEffect], interpreted: InterpretedProgram) -> frozenset[str]:
    sets = {
        what
        for effect in effects_of
        for what in set_by(effect, interpreted) | differing(effect.before, effect.after)
    }
    return frozenset(sets | {"motion"})


def doubts_of(
    interpreted: InterpretedProgram, main: MainProgram, subprograms: Subprograms, parts: Sequence[Part]
) -> Iterator[tuple[int, dict[str, int]]]:
    """(line, what is left open there -> the line that did it), wherever it changes.

    What stands in the body of a subprogram counts where it is called.
    """
    open_now: dict[str, int] = {}
    ends = [part for part in parts if main.has(part.first) or main.has(part.last)]
    outermost = list(_outermost(ends))
    for effect in interpreted.effects:
        line = effect.block.line
        if not main.has(line):
            continue
        while ends and ends[0].last < line:
            yield _closed(ends.pop(0), open_now)
        changed = _changed(effect) | (subprograms.changes(effect) or frozenset())
        before = dict(open_now)
        if effect.block.skip or subprograms.changes(effect):
            open_now |= dict.fromkeys(changed, line)
        elif open_now and not _is_within(line, outermost):
            for what in set_by(effect, interpreted):
                open_now.pop(what, None)
        if open_now != before:
            yield line, dict(open_now)
    for part in ends:
        yield _closed(part, open_now)


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


def _closed(part: Part, open_now: dict[str, int]) -> tuple[int, dict[str, int]]:
    open_now |= dict.fromkeys(part.sets, part.last)
    return part.last, dict(open_now)


def _changed(effect: BlockEffect) -> set[str]:
    """What a block changed that an insertion has to know."""
    one, other = effect.before, effect.after
    if not effect.block.skip:
        return set()
    changed = set(one.modes.changed(other.modes))
    parts = {"the spindle": "spindle", "coolant": "coolant", "S": "speed", "the tool": "tool"}
    return changed | {what for what, name in parts.items() if getattr(one, name) != getattr(other, name)}
