"""A program that is gone through again, as its loops and calls ask for, is what it was."""

from __future__ import annotations

import pytest

from chipbreak import load
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpret import Interpreter
from chipbreak.text.source import read


@pytest.mark.parametrize(
    "program",
    [
        "(EXPECT A)\nG0 X1.\n(VIB OFF)\nN5 G1 X2. F0.1\n#1=#1+1\nG91\nIF[#1LT3]GOTO5\nG1 X3.\nS500\nM30\n",
        "G97 S900 M3\nWHILE[#1LT3]DO1\nG1 U1. F0.2\n(B)\n\nG1 Z1.\n#1=#1+1\nEND1\n"
        "M98 P7\nG0 X9.\nM30\nO7\nG91\nS40\nM99\n",
    ],
)
def test_going_through_it_again_with_what_is_known_changes_nothing(
    program: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A block that begins in the same state does the same; nothing is known of where other ways come in."""
    found = interpret_source(read(program.encode()), load("fanuc-lathe"))
    monkeypatch.setattr(Interpreter, "advance", lambda self, state, block: self._advanced(state, block))
    alone = interpret_source(read(program.encode()), load("fanuc-lathe"))
    assert found.lines == alone.lines
    assert repr(found.states) == repr(alone.states)
    assert repr(found.effects) == repr(alone.effects)


@pytest.mark.parametrize("motion", ["G1", "G0"])
def test_a_run_of_whole_numbers_leaves_the_motion_as_it_was(motion: str) -> None:
    """What is kept of a block says whether it has points, and whether it has a code: one beside the other."""
    moves = "".join(f"X{i} Y{2 * i}\n" for i in range(40))
    program = f"G21 G90 G94 F100\nG0 X5 Y5\n{motion} X1 Y1\n{moves}M2\n"
    interpreted = interpret_source(read(program.encode()), load("linuxcnc-mill"))
    state = interpreted.before(43)
    assert state.modes.motion == {"G1": "line", "G0": "rapid"}[motion]
    assert (state.position.x, state.position.y) == (39.0, 78.0)
