"""Long programs are looked at in columns: what that gives is what a step for each block gives."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import chipbreak
from chipbreak.insertion import candidates, clearance
from chipbreak.insertion.retract import Retract
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.state_difference import difference
from chipbreak.operations.main_program import MainProgram, main_program
from chipbreak.restart.resume import resume
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

TESTS = Path(__file__).parents[1]
FILES = sorted(
    [*(TESTS / "cases").rglob("*.nc"), *(TESTS / "bad").glob("*.nc"), *TESTS.glob("../samples/*.nc")]
)
PROFILES = ("fanuc-lathe", pytest.param("fanuc-mill", marks=pytest.mark.long), "linuxcnc-mill")
LINES = 20_000


@cache
def programs(profile: str) -> list[tuple[InterpretedProgram, MainProgram]]:
    settings = chipbreak.load(profile)
    found = []
    for file in FILES:
        interpreted = interpret(parse(read(file.read_bytes(), file.name), settings.dialect), settings)
        found.append((interpreted, main_program(interpreted)))
    return found


@pytest.mark.parametrize("profile", PROFILES)
def test_candidates_one_by_one_and_over_runs(profile: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(candidates, "_LONG_RUN", 2)
    seen = 0
    for interpreted, main in programs(profile):
        retract = Retract(interpreted.settings)
        wanted = candidates.candidates(interpreted, retract, main.first, main.last, "nothing")
        found = candidates.Candidates(interpreted, retract, main.first, main.last, "nothing")
        for one in wanted:
            other = found.at(one.line)
            assert not difference(one.state, other.state)
            # Whether the tool is low is asked by nobody who goes over runs, and not said behind them.
            assert other._replace(state=one.state, is_low=one.is_low) == one
            assert np.allclose(one.state.position, other.state.position, equal_nan=True)
            seen += 1
    assert seen > 1000


@pytest.mark.parametrize("profile", PROFILES)
def test_clearance_by_columns_and_by_steps(profile: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = 0
    for interpreted, main in programs(profile):
        both = []
        for long_run in (2, 1 << 60):
            monkeypatch.setattr(clearance, "_LONG_RUN", long_run)
            both.append(clearance.Clearance(interpreted, main))
        assert both[0]._lines == both[1]._lines
        assert np.allclose(both[0]._reach, both[1]._reach)
        seen += len(both[0]._lines)
    assert seen > 100


def long_program(form: str) -> bytes:
    head = ["%", "O1000", "G21 G40 G99", "G54", "T0101", "G97 S1200 M3", "G0 X52. Z2. M8"]
    one_cut = (f"G1 X{50 - (i % 1000) * 0.01:.3f} Z-{i * 0.0003:.4f} F0.2" for i in range(LINES))
    passes = (
        line
        for i in range(LINES // 5)
        for line in (
            f"G0 X{50 - i * 0.001:.3f}",
            f"G1 Z-{30 + i * 0.001:.3f} F0.2",
            "G1 X52.",
            "G0 Z2.",
            "X50.",
        )
    )
    body = list(one_cut if form == "one cut" else passes)
    return "\n".join([*head, *body, "G0 X60. Z5.", "G28 U0 W0 M9", "M5", "M30", "%", ""]).encode()


@pytest.mark.parametrize("form", ["one cut", "passes"])
def test_few_blocks_of_a_long_program_are_stepped_through(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    data = long_program(form)
    steps = 0
    real = Interpreter.advance

    def counted(self: Interpreter, *arguments: object) -> object:
        nonlocal steps
        steps += 1
        return real(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Interpreter, "advance", counted)
    result = resume(data, chipbreak.load("fanuc-lathe"), LINES - 1)
    nearest = range(8, 9) if form == "one cut" else range(LINES - 6, LINES)
    assert result.line in nearest
    assert steps < LINES / 10
