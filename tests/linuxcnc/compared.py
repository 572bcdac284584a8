"""The original held against the filtered program on LinuxCNC's interpreter, but for what the changes do."""

from __future__ import annotations

import re
from itertools import zip_longest

from brackets import marked

from . import rs274
from .mixed_programs import Record, differing, is_same, records

_OF_MOVES = ("place", "spindle", "MIST", "FLOOD")
# N with a decimal point behind other words is ours: the control does not know it.
_OUR_WORDS = re.compile(rb"(?<=[^\n]) N\d*\.\d*")


def assert_same_outside(
    data: bytes, output: bytes, *, lathe: bool, comes_back: bool = True, block_delete: bool = False
) -> None:
    """Each block outside the brackets meets the same state, and behind each bracket is the same state.

    ``comes_back`` is False for checks: place, spindle and coolant count where the tool moves.
    """
    was = rs274.judge(_OUR_WORDS.sub(b"", marked(output)), lathe=lathe, block_delete=block_delete)
    now = rs274.judge(output, lathe=lathe, block_delete=block_delete)
    assert was.accepted, was.message
    assert now.accepted, f"{now.message}\n{data.decode()}"
    for before, after in zip_longest(records(was.canon), records(now.canon)):
        assert before is not None and after is not None, data.decode()
        one, other = (before, after) if comes_back else (_at_moves(before), _at_moves(after))
        assert is_same(one, other), f"{differing(one, other)}\n{data.decode()}"


def _at_moves(record: Record) -> Record:
    """A record without what counts only where the tool moves."""
    name, state = record
    if name.startswith(("STRAIGHT", "ARC")):
        return record
    return name, {key: value for key, value in state.items() if key not in _OF_MOVES}
