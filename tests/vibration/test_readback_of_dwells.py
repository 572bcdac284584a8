"""The moves and dwells of a cut that dwells are read back at once as they are one by one."""

from __future__ import annotations

import pytest

from chipbreak import load
from chipbreak.model.interpreted_program import interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from chipbreak.vibration import readback
from chipbreak.vibration.readback import ReadBack, read_moves

HEAD = "G21 G18 G97 S900 M3\nG0 X20. Z2.\nG1 Z1.9 F0.1\n"
BODIES = {
    "a move a dwell": "".join(f"G4 X0.05\nZ{1.8 - 0.1 * at:.1f}\n" for at in range(20)),
    "distances": "".join("G4 X0.05\nW-0.1\n" for _ in range(20)),
    "two moves": "".join(f"G4 X0.05\nZ{1.8 - 0.1 * at:.1f}\nZ{1.75 - 0.1 * at:.2f}\n" for at in range(20)),
    "two dwells": "".join(f"G4 X0.05\nG4 X0.05\nZ{1.8 - 0.1 * at:.1f}\n" for at in range(20)) + "G4 X0.05\n",
    "another one": "".join(
        f"G4 X0.05\nZ{1.8 - 0.1 * at:.1f}\n" + "G4 X0.1\n" * (at == 15) for at in range(30)
    ),
}


@pytest.mark.parametrize("case", BODIES)
def test_dwells_are_read_back_as_one_by_one(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    settings = load("fanuc-lathe")
    text = HEAD + BODIES[case] + "X30.\n"
    program = interpret(parse(read(text.encode(), "cut.nc"), settings.dialect), settings)

    def read_it() -> ReadBack:
        return read_moves(program, 2, text.count("\n"))

    at_once = read_it()
    monkeypatch.setattr(readback, "repeated_dwells", lambda *_: None)
    one_by_one = read_it()
    for name in ("points_mm", "lengths_mm", "feed_mm_s", "dwell_s"):
        assert getattr(at_once, name).tolist() == getattr(one_by_one, name).tolist(), name
    assert at_once.strangers == one_by_one.strangers == 0
    assert at_once.dwell_s.sum() > 0.9
