"""The loop form as a Fanuc control runs it: in the project's macro interpreter, move by move."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest

from machine_reader import filtered
from macro_interpreter import Interpreter, Library, Machine

SETS = ("checks.enabled=false", "output.feed_mode=minute", "output.segments=stroke")


@dataclass
class Recorder(Machine):
    """A machine that writes down where it was sent, at which feed [mm/min]."""

    ends: list[tuple[float, float, float]] = field(default_factory=list)
    feeds: list[float] = field(default_factory=list)
    words: dict[str, float] = field(default_factory=dict)

    def move(self, target: tuple[float, float, float], feed_mm_min: float = 0.0) -> None:
        self.ends.append(target)
        self.feeds.append(self.words.get("F", 0.0))
        super().move(target, feed_mm_min)


def run(program: str, reads_ahead: bool) -> tuple[np.ndarray, np.ndarray]:
    machine = Recorder(reads_ahead=reads_ahead)
    interpreter = Interpreter(Library(), machine)
    machine.words = interpreter.modes.words
    outcome = interpreter.run(program)
    assert outcome.alarm == 0
    assert machine.at == machine.ends[-1]
    return np.array(machine.ends), np.array(machine.feeds)


CUTS = {
    "along Z": ("G1 Z-48. F125. N1.5", 0.0),
    "along X": ("G1 X50. F125. N3.5", 0.0),
    "incremental": ("G91\nG1 X50. F125. N1.5\nG90", 0.0),
    "in space": ("G1 X30. Y20. Z-30. F125. N1.5", 0.25),
}
# Each cut on one of the controls, which take turns; on the other one in the long form.
BOTH = [
    pytest.param(*cut, ahead, id=f"{name}-{how}", marks=pytest.mark.long if (at + ahead) % 2 else ())
    for at, (name, cut) in enumerate(CUTS.items())
    for ahead, how in enumerate(["block by block", "reading ahead"])
]


@pytest.mark.parametrize(("cut", "drift_steps", "reads_ahead"), BOTH)
def test_the_moves_are_those_of_the_expanded_form(cut: str, drift_steps: float, reads_ahead: bool) -> None:
    program = f"G90 G94 G97 S2500 M3\nG0 X0. Y0. Z2.\n{cut}\nG0 Z50.\nM30\n"
    expanded = run(filtered(program, "fanuc-mill", *SETS), reads_ahead)
    text = filtered(program, "fanuc-mill", *SETS, "output.form=loop")
    loop = run(text, reads_ahead)
    assert "WHILE[#33LT" in text
    assert len(expanded[0]) == len(loop[0]) > 1000
    away = np.abs(expanded[0] - loop[0])
    assert away.max() <= 0.001 + 1e-9
    if not drift_steps:
        assert (away > 1e-9).mean() < 0.01  # places half way between two steps
        assert loop[1] == pytest.approx(expanded[1], rel=0.06)  # one step more or less of a stroke
    assert loop[0][-2] == pytest.approx(expanded[0][-2], abs=1e-9)
