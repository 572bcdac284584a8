"""What is said of comments is what LinuxCNC makes of them."""

from __future__ import annotations

import pytest

import chipbreak

from . import rs274

pytestmark = pytest.mark.linuxcnc


@pytest.mark.parametrize(
    "line", ["(A)", "(A (B))", "(A", "((A))", "(A ; B)", "(A) (B)", "; (A", "G0 X1. (A", "G0 X1. (A (B) 2.0)"]
)
def test_a_comment_that_stops_the_control_is_said(line: str) -> None:
    program = f"G21 G18\n{line}\nM2\n".encode("ascii")
    said = chipbreak.check(program, chipbreak.load("linuxcnc-lathe"))
    assert bool(said) == (not rs274.judge(program, lathe=True).accepted)
