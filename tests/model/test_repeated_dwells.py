"""A cut in which the tool dwells again and again is interpreted as block by block, and in a few steps."""

from __future__ import annotations

import pytest

from chipbreak import load
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

DWELL = "G4 X0.028"
HEAD = ["G21 G97 S900 M3", "G0 X20. Z2.", "G1 Z1.9 F0.1"]
BEHIND = ["G4 X0.5", "X30.", "G0 X40."]


def cut(*moves: str, dwell: str = DWELL) -> list[str]:
    """A dwell in front of each move."""
    return [line for move in moves for line in (dwell, move)]


def places(letters: str, *, head: str = "", start: float = 1.7, step: float = -0.1) -> list[str]:
    """Twelve moves to places, or of distances, with one decimal each."""
    return [
        head + "".join(f"{letter}{start + step * at:.1f}" for letter in letters).replace("Z", " Z").lstrip()
        for at in range(12)
    ]


CASES = {
    "places": (cut(*places("Z")), True),
    "along two axes": (cut(*places("XZ")), True),
    "distances": (cut(*places("W", start=-0.1, step=0.0)), True),
    "G91": (["G91", *cut(*places("Z", start=-0.3, step=0.0)), "G90"], True),
    "inch": (["G20", *cut(*places("X"))], True),
    "each says G1": (cut(*places("Z", head="G1 ")), True),
    "G1 in rapid": (["G0 Z1.8", *cut(*places("Z", head="G1 "))], True),
    "two dwells in a row": ([DWELL, *cut(*places("Z"))], True),
    "another dwell between": ([*cut(*places("Z")), *cut(*places("X"), dwell="G4 X0.1")], True),
    "a dwell that says S": (cut(*places("Z"), dwell="G4 X0.1 S800"), False),
    "a dwell with a comment": (cut(*places("Z"), dwell="G4 X0.1 (SPEED V100 D20)"), False),
    "feeds": (cut(*places("ZF", step=0.1)), False),
    "numbered": (cut(*places("Z", head="N5 ")), False),
    "no points": (cut(*(f"Z{at}" for at in range(12))), False),
    "jumped to": (["GOTO5", *cut(*places("Z")), "N5 Z9.", *cut(*places("X"))], True),
    "an arc in force": (["G3 X22. Z1.8 R9.", *cut(*places("Z"))], False),
    "the last lines": (cut(*places("Z")), True),
}


def interpreted(lines: list[str]) -> InterpretedProgram:
    settings = load("fanuc-lathe")
    return interpret(parse(read("\n".join(lines).encode(), "dwells.nc"), settings.dialect), settings)


@pytest.mark.parametrize("case", CASES)
def test_repeated_dwells_are_interpreted_as_one_by_one(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    body, is_quick = CASES[case]
    lines = HEAD + body + ([] if case == "the last lines" else BEHIND)
    steps = list[int]()
    advance = Interpreter.advance

    def counted(self: Interpreter, state: object, block: object) -> object:
        steps.append(1)
        return advance(self, state, block)  # type: ignore[arg-type]

    with monkeypatch.context() as patch:
        patch.setattr(Interpreter, "advance", counted)
        found = interpreted(lines)
    assert (len(steps) < len(body)) == is_quick
    state = initial_state(found.settings)
    effects = {effect.block.line: effect for effect in found.effects}
    dwells = 0
    for line in range(len(lines)):
        effect = found.interpreter.advance(state, found.program.block(line))
        # At a jump target the block itself begins with another state.
        assert repr(found.before(line)) in (repr(state), repr(effect.before)), lines[line]
        if lines[line].startswith("G4"):
            dwells += 1
            assert repr(effects[line]) == repr(effect) == repr(found.effect(line))
        state = effect.after
    assert dwells >= 12
    assert repr(found.end()) == repr(state)
