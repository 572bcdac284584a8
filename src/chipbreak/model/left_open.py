"""What a block leaves open that block delete may skip, and a place that several ways reach.

What is in force behind it is one thing or the other.  F and S are known again when the program says them,
a modal group when it says a code of it.
"""

from __future__ import annotations

from collections.abc import Iterable

from chipbreak.dialects.modes import Modes
from chipbreak.model.giving_back import is_same, is_same_path_mode
from chipbreak.model.modal import TOOLS, UNKNOWN, LeftOpen, Position, Setting, State


def either(before: State, after: State, line: int) -> State:
    """The state behind a block that may be skipped; ``line`` is its number in the user's file."""
    why = f"line {line} is skipped while block delete is on"
    pairs = zip(before.position, after.position, strict=True)
    position = Position(*(b if a == b else UNKNOWN for a, b in pairs))
    feed, speed, limit = (
        _either_setting(getattr(before, name), getattr(after, name))
        for name in ("feed", "speed", "speed_limit")
    )
    spindle_why = after.spindle_why
    if before.choice != after.choice:
        spindle_why = f"line {line}, which chooses it, is skipped with block delete on"
    elif before.spindle != after.spindle or before.spindle_why != after.spindle_why:
        spindle_why = f"line {line}, which starts or stops it, is skipped with block delete on"
    return after._replace(
        position=position,
        unknown_why=why if position != after.position else after.unknown_why,
        feed=feed,
        speed=speed,
        speed_limit=limit,
        spindle_why=spindle_why,
        left_open=merged([*before.left_open, *after.left_open], _changed(before, after), why),
        kept=_either_kept(before.kept, after.kept, line),
        ended=before.ended,
    )


def merged(known: Iterable[tuple[str, str]], groups: Iterable[str], why: str) -> LeftOpen:
    """Groups that are left open already, each with why, and others that are for one reason; sorted."""
    return tuple(sorted({**dict.fromkeys(groups, why), **dict(known)}.items()))


def differing(one: Modes, others: Iterable[Modes]) -> frozenset[str]:
    """The groups in which some of the others are not what the first is."""
    return frozenset(group for other in others for group in one.changed(other))


def _either_kept(before: State | None, after: State | None, line: int) -> State | None:
    """What M70 has kept, where one may have been skipped."""
    return after if before is None or after is None or before is after else either(before, after, line)


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
