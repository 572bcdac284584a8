"""The original held against the filtered program on LinuxCNC's interpreter, but for what the changes do."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

from brackets import marked

from . import rs274
from .actions import difference
from .mixed_programs import Record, differing, is_same, records

_OF_MOVES = ("place", "spindle", "MIST", "FLOOD")
# What a rapid does not depend on: it comes back where something does, or where the program says it.
_SPINDLE = frozenset({"SET_SPINDLE_SPEED", "SET_SPINDLE_MODE", "SPINDLE", "MIST", "FLOOD"})
# N with a decimal point behind other words is ours: the control does not know it.
_OUR_WORDS = re.compile(rb"(?<=[^\n]) N\d*\.\d*")


def assert_same_outside(
    data: bytes, output: bytes, *, lathe: bool, comes_back: bool = True, block_delete: bool = False
) -> None:
    """Each block outside the brackets meets the same state, and behind each bracket is the same state.

    ``comes_back`` is False for checks: place, spindle and coolant count where the tool moves.
    """
    how = {"lathe": lathe, "comes_back": comes_back, "block_delete": block_delete}
    assert is_taken_and_same(data, output, **how), data.decode()


def is_taken_and_same(
    data: bytes, output: bytes, *, lathe: bool, comes_back: bool = True, block_delete: bool = False
) -> bool:
    """The same, but False where LinuxCNC does not take the original."""
    ran = _both(data, output, lathe=lathe, block_delete=block_delete)
    for before, after in zip_longest(*(records(one.canon) for one in ran)):
        assert before is not None and after is not None, data.decode()
        one, other = (before, after) if comes_back else (_at_moves(before), _at_moves(after))
        assert is_same(one, other), f"{differing(one, other)}\n{data.decode()}"
    return bool(ran)


def _at_moves(record: Record) -> Record:
    """A record without what counts only where the tool moves."""
    name, state = record
    if name.startswith(("STRAIGHT", "ARC")):
        return record
    return name, {key: value for key, value in state.items() if key not in _OF_MOVES}


def is_taken_and_same_with_checks(
    data: bytes, output: bytes, *, subroutines: Path, tools: Sequence[rs274.Tool], block_delete: bool
) -> bool:
    """Each move outside the brackets is the same in the same state; a check may leave the tool elsewhere."""
    ran = _both(data, output, lathe=False, block_delete=block_delete, subroutines=subroutines, tools=tools)
    if ran:
        said = difference(ran[0].canon, ran[1].canon, free=_SPINDLE)
        assert not said, f"{said}\n{data.decode()}"
    return bool(ran)


def _both(data: bytes, output: bytes, **how: Any) -> tuple[rs274.Judgement, ...]:
    """What the original, with the brackets marked in it, and the output do; nothing where it is not taken."""
    was = rs274.judge(_OUR_WORDS.sub(b"", marked(output)), **how)
    if not was.accepted:
        assert not rs274.judge(data, **how).accepted, f"{was.message}\n{data.decode()}"
        return ()
    now = rs274.judge(output, **how)
    assert now.accepted, f"{now.message}\n{data.decode()}"
    return was, now
