"""Whatever is mixed around the cuts, LinuxCNC does the same outside the changes as it did before.

The original is held against the filtered program: each block outside the brackets with the state that it
meets, and the state behind each bracket.  ``make test`` draws some hundred programs, ``make fuzz`` others.
"""

from __future__ import annotations

from itertools import zip_longest

import pytest
from hypothesis import event, given, reject
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.editing.restore import regions
from chipbreak.text.source import read

from . import rs274
from .mixed_programs import differing, is_same, program, records

# The same each time, or a search: see tests/fuzz.py.
EXAMPLES = 300 if hypothesis_settings.default and hypothesis_settings.default.derandomize else 2000
SETTINGS = ['planner.model="ideal"', 'output.segments="stroke"', "checks.enabled=false"]


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


def check(data: bytes, *, lathe: bool) -> str:
    """Filter a program and compare; what became of it in a word."""
    if not rs274.judge(data, lathe=lathe).accepted:
        return "not a program"
    settings = chipbreak.load(f"linuxcnc-{'lathe' if lathe else 'mill'}", SETTINGS)
    try:
        result = chipbreak.rewrite(data, settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        return "refused"
    if not result.changed:
        return "unchanged"
    was = rs274.judge(marked(result.data), lathe=lathe)
    now = rs274.judge(result.data, lathe=lathe)
    assert was.accepted, was.message
    assert now.accepted, f"{now.message}\n{data.decode()}"
    for one, other in zip_longest(records(was.canon), records(now.canon)):
        assert one is not None and other is not None, data.decode()
        assert is_same(one, other), f"{differing(one, other)}\n{data.decode()}"
    return "changed"


@pytest.mark.linuxcnc
@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=EXAMPLES)
def test_all_else_stays_as_it_was(seed: int) -> None:
    data, lathe = program(seed)
    found = check(data, lathe=lathe)
    event(found)
    if found == "not a program":
        reject()
