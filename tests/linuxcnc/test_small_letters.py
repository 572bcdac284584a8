"""Small letters say the same as capitals: LinuxCNC reads both, and how a word is written decides nothing."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak

from .mixed_programs import program
from .test_mixed_programs import profile_of

_COMMENT = re.compile(rb"(\([^)]*\)|;[^\n]*)")
_KEPT = re.compile(rb"END [0-9A-F]{8}|\(CHIPBREAK HEX [0-9A-F]*\)")  # a sum over the bytes, and the bytes


def written(data: bytes, letters: Callable[[bytes], bytes]) -> bytes:
    """The program with all words in such letters; comments stay."""
    parts = _COMMENT.split(data)
    return b"".join(part if number % 2 else letters(part) for number, part in enumerate(parts))


def outcome(data: bytes, settings: chipbreak.Settings) -> tuple[bytes, list[str]]:
    """What is written, in capitals and without what the letters themselves change, and what is said."""
    try:
        result = chipbreak.rewrite(data, settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError as error:
        return b"", [one.code for one in error.diagnostics]
    return _KEPT.sub(b"", result.data.upper()), [one.code for one in result.diagnostics]


@pytest.mark.few(5)
@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=300)
def test_a_program_in_small_letters_becomes_the_same_as_in_capitals(seed: int) -> None:
    mixed = program(seed)
    small, large = (
        outcome(written(mixed.data, letters), profile_of(mixed)) for letters in (bytes.lower, bytes.upper)
    )
    assert small == large
