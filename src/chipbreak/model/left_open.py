"""What is not known behind a block: one that may be skipped, or that says what nobody can read.

So it is at a place that several ways reach.  F and S are known again when the program says them, a modal
group when it says a code of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import CYCLE_END, NON_MODAL, Code
from chipbreak.dialects.modes import Modes
from chipbreak.model.giving_back import is_same, is_same_path_mode
from chipbreak.model.modal import TOOLS, UNKNOWN, UNREAD, LeftOpen, Position, Setting, State
from chipbreak.syntax.nodes import Block

# A code as it may stand in a line that cannot be read; without digits where the control works it out.
_CODE = re.compile(r"(?<![A-Z])([GMT])[ \t]*(?:([0-9]{1,9}(?:\.[0-9]{0,9})?)|[#\[])", re.ASCII)


def behind_unread(state: State, block: Block, dialect: Dialect, line: int) -> State:
    """The state behind a line that cannot be read: what its codes set, or do to spindle and tool, is open.

    ``line`` is its number in the user's file.
    """
    why = f"line {line} {UNREAD}"
    said = _CODE.findall(block.text.upper())
    codes = [_code_of(float(number), dialect) if number else None for letter, number in said if letter == "G"]
    after = _with_codes_open(state.forgotten(why), codes, dialect, why)
    letters = {letter for letter, _ in said}
    if "T" in letters:
        after = after._replace(left_open=merged(after.left_open, TOOLS, why))
    return after._replace(spindle_why=why) if "M" in letters else after


def behind_worked_out(state: State, block: Block, taken: str, dialect: Dialect, line: int) -> State:
    """The state behind a block that may say ``G#1`` or ``M[#2+3]``, which can be any code.

    ``taken`` are the letters of words that are numbers for a macro.
    """
    unknown = {word.address for word in block.words_of("GM") if word.number is None}.difference(taken)
    if "G" in unknown:
        why = f"line {line} works out a G code"  # which may be one of another origin
        state = _with_codes_open(state.lost(why), [None], dialect, why)
    return state._replace(spindle_why=f"line {line} works out an M code") if "M" in unknown else state


def _with_codes_open(state: State, codes: Iterable[Code | None], dialect: Dialect, why: str) -> State:
    """The same with the groups of some codes left open: all of them where a code is not known."""
    every = {code.group for code in dialect.g_codes.values()} - {NON_MODAL, CYCLE_END}
    groups = set[str]().union(*(every if code is None else every & {code.group} for code in codes))
    return state._replace(left_open=merged(state.left_open, groups, why))


def _code_of(number: float, dialect: Dialect) -> Code | None:
    return dialect.g_codes.get(round(number * 10), Code(NON_MODAL, ""))


def either(before: State, after: State, block: Block, line: int) -> State:
    """The state behind a block that may be skipped; ``line`` is its number in the user's file."""
    skipped = "is skipped while block delete is on" if block.skip else "acts only where its condition is met"
    why = f"line {line} {skipped}"
    pairs = zip(before.position, after.position, strict=True)
    position = Position(*(b if a == b else UNKNOWN for a, b in pairs))
    feed, speed, limit = (
        _either_setting(getattr(before, name), getattr(after, name))
        for name in ("feed", "speed", "speed_limit")
    )
    spindle_why = after.spindle_why
    if before.choice != after.choice:
        spindle_why = f"line {line}, which chooses it, {skipped}"
    elif before.spindle != after.spindle or before.spindle_why != after.spindle_why:
        spindle_why = f"line {line}, which starts or stops it, {skipped}"
    return after._replace(
        position=position,
        unknown_why=why if position != after.position else after.unknown_why,
        feed=feed,
        speed=speed,
        speed_limit=limit,
        spindle_why=spindle_why,
        left_open=merged([*before.left_open, *after.left_open], _changed(before, after), why),
        kept=_either_kept(before.kept, after.kept, block, line),
        ended=before.ended,
    )


def merged(known: Iterable[tuple[str, str]], groups: Iterable[str], why: str) -> LeftOpen:
    """Groups that are left open already, each with why, and others that are for one reason; sorted."""
    return tuple(sorted({**dict.fromkeys(groups, why), **dict(known)}.items()))


def differing(one: Modes, others: Iterable[Modes]) -> frozenset[str]:
    """The groups in which some of the others are not what the first is."""
    return frozenset(group for other in others for group in one.changed(other))


def _either_kept(before: State | None, after: State | None, block: Block, line: int) -> State | None:
    """What M70 has kept, where one may have been skipped."""
    return after if before is None or after is None or before is after else either(before, after, block, line)


def _either_setting(before: Setting | None, after: Setting | None) -> Setting | None:
    """What both are, else one whose value is not known."""
    if before == after or after is None:
        return after
    if before is not None and is_same(before, after):
        return before  # it has not been said anew for sure
    return after._replace(value=UNKNOWN)


def _changed(before: State, after: State) -> tuple[str, ...]:
    """The groups that the block changes, with the words that belong to their codes, and the tool."""
    groups = before.modes.changed(after.modes)
    if not is_same_path_mode(before, after):
        groups += ("path",)
    if before.smooth_words != after.smooth_words:
        groups += ("look_ahead",)
    groups += tuple(name for name in TOOLS if getattr(before, name) != getattr(after, name))
    return groups
