"""Whatever is mixed around the cuts, LinuxCNC does the same outside the changes as it did before.

The original is held against the filtered program: each block outside the brackets with the state that it
meets, and the state behind each bracket.  ``make test`` draws some hundred programs, ``make fuzz`` others.
"""

from __future__ import annotations

import pytest
from hypothesis import event, given, reject
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak

from . import rs274
from .compared import assert_same_outside
from .mixed_programs import program

# The same each time, or a search: see tests/fuzz.py.
EXAMPLES = 300 if hypothesis_settings.default and hypothesis_settings.default.derandomize else 2000
SETTINGS = [
    'planner.model="ideal"',
    'output.segments="stroke"',
    "checks.enabled=false",
    'vibration.refused="leave"',
]


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
    for block_delete in (False, True) if b"\n/" in data else (False,):
        assert_same_outside(data, result.data, lathe=lathe, block_delete=block_delete)
    return "changed"


@pytest.mark.few(40)
@pytest.mark.linuxcnc
@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=EXAMPLES)
def test_all_else_stays_as_it_was(seed: int) -> None:
    data, lathe = program(seed)
    found = check(data, lathe=lathe)
    event(found)
    if found == "not a program":
        reject()
