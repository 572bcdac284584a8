"""The original held against the filtered program on LinuxCNC's interpreter, but for what the changes do."""

from __future__ import annotations

import re
from itertools import zip_longest

from chipbreak.editing.restore import regions
from chipbreak.text.source import read

from . import rs274
from .mixed_programs import Record, differing, is_same, records

_OF_MOVES = ("place", "spindle", "MIST", "FLOOD")
# N with a decimal point behind other words is ours: the control does not know it.
_OUR_WORDS = re.compile(rb"(?<=[^\n]) N\d*\.\d*")


def marked(output: bytes) -> bytes:
    """The original, with the first and the last line of every bracket that the output has."""
    source = read(output)
    parts = []
    line = 0
    for region in regions(source):
        kept = source.data[source.starts[line] : source.starts[region.first]]
        # A number before BEGIN stands in the original block too.
        begin = source.raw(region.first)
        parts += [kept, begin[begin.index(b"(") :], region.original, source.raw(region.last - 1)]
        line = region.last
    return b"".join([*parts, source.data[source.starts[line] :]])


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
