"""Which tools a program calls, as LinuxCNC's interpreter sees it: T0 leaves none, a comment calls none."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.model.interpreted_program import interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from chipbreak.tools.program import called_tools

from . import rs274

pytestmark = pytest.mark.linuxcnc


def tools_of_the_control(program: bytes) -> list[int]:
    """What the interpreter brings into the spindle, in its order; 0 for nothing."""
    judgement = rs274.judge(program, lathe=False)
    assert judgement.accepted, judgement.message
    selected = 0
    found = []
    for name, arguments in rs274.calls(judgement.canon):
        if name == "SELECT_TOOL":
            selected = int(arguments[0])
        elif name == "CHANGE_TOOL":
            found.append(selected)
    return found


@pytest.mark.parametrize(
    "program",
    [
        b"T1 (M6 T3)\nM6\nG0 X1\n(TC: 6mm Endmill, M6 T4)\nM6 T2\nG0 X2\nT0 M6\nM2\n",
        b"T0 M6\nG0 X1\nT7 M6 (T0 M6)\nT0\nM6\nT00 M6\nT9\nM2\n",
    ],
)
def test_the_tools_that_are_called_are_those_the_control_changes_to(program: bytes) -> None:
    settings = chipbreak.load("linuxcnc-mill")
    ours = interpret(parse(read(program), settings.dialect), settings)
    theirs = tools_of_the_control(program)
    assert 0 in theirs
    assert called_tools(ours) == list(dict.fromkeys(tool for tool in theirs if tool))
    changes = [effect.after.tool for effect in ours.effects if effect.does("tool", "change")]
    assert changes == theirs
