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


def test_the_first_spindle_may_be_named() -> None:
    """``$0`` stands for the spindle that turns anyway: what is written around it is taken as without it."""
    program = b"G21 G7 G18 G95\nS1000 M3 $0\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nG0 X30.\nM2\n"
    settings = chipbreak.load("linuxcnc-lathe")
    judged = [
        rs274.judge(chipbreak.rewrite(one, settings).data, lathe=True)
        for one in (program, program.replace(b" $0", b""))
    ]
    assert judged[0].accepted
    assert judged[0].motion == judged[1].motion
