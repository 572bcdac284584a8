"""Many words of a block, and many blocks of a program, are read one by one, not held against each other."""

from __future__ import annotations

import contextlib
import sys

import pytest

import chipbreak

FEW, MANY = 100, 400


def calls(profile: str, words: str) -> int:
    """How many functions are called, and how often generators go on, for a program with such words."""
    settings = chipbreak.load(profile)
    program = f"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-1. F.1 {words}\nM30\n".encode()
    count = 0

    def one(_frame: object, _event: str, _argument: object) -> None:
        nonlocal count
        count += 1

    before = sys.getprofile()
    sys.setprofile(one)
    try:
        with contextlib.suppress(chipbreak.ProgramRejectedError):
            chipbreak.rewrite(program, settings, allow_unbroken=True)
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize(
    ("profile", "word"),
    [
        ("fanuc-lathe", "S2500 "),
        ("linuxcnc-lathe", "G4 X1. "),
        ("haas-mill", "\nM98 P5"),
    ],
)
def test_four_times_as_many_take_four_times_as_long(profile: str, word: str) -> None:
    calls(profile, word * FEW)  # what is built once
    none, few, many = (calls(profile, word * count) for count in (0, FEW, MANY))
    assert many - none < 1.5 * (few - none) * MANY / FEW
