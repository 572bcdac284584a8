"""What the blocks behind a candidate rely on is the same whichever candidates were looked at before it."""

from __future__ import annotations

from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.insertion import position_dependencies as looked_at
from chipbreak.insertion.position_dependencies import QuietRuns, position_dependencies
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

BLOCKS = (
    *("G0 Z10.", "G0 X1.", "G0 X5. Y5.", "X2.", "G0.0000001 X3.", "G1 X1. F100.", "G0 X1. Y2. Z3."),
    *("G53 G0 Z0.", "G91 G28 Z0.", "G90", "/G91", "G43 H1", "G49", "G43", "M6 T1", "M98 P1", "#1=#5041"),
    *("M5", "M9", "(NOTE)", "", "G68 R10.", "M30", "G0 U1.", "G28 U0. W0."),
)


def _interpreted(blocks: list[str], profile: str) -> InterpretedProgram:
    settings = chipbreak.load(profile)
    text = "%\nO1\n" + "\n".join(blocks) + "\n"
    return interpret(parse(read(text.encode()), settings.dialect), settings)


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill", "fanuc-lathe"])
@given(
    blocks=st.lists(st.sampled_from(BLOCKS), min_size=1, max_size=30),
    order=st.randoms(use_true_random=False),
    homed=st.sampled_from(["", "Z", "XY"]),
    horizon=st.integers(3, 30),
)
def test_earlier_looks_change_nothing(
    profile: str, blocks: list[str], order: object, homed: str, horizon: int
) -> None:
    program = _interpreted(blocks, profile)
    lines = list(range(2, 2 + len(blocks)))
    order.shuffle(lines)  # type: ignore[attr-defined]
    quiet_runs: QuietRuns = {}
    with patch.object(looked_at, "HORIZON", horizon):
        for line in lines:
            for has_offset in (True, False):
                alone, together = (
                    position_dependencies(program, line, homed, runs, has_offset=has_offset)
                    for runs in ({}, quiet_runs)
                )
                assert together == alone, (line, has_offset)


def test_blocks_that_were_looked_at_in_vain_are_not_looked_at_again() -> None:
    """A hundred candidates, of which none is decided, take one walk and not a hundred."""
    program = _interpreted(["G0 X1.", "G0 Z10."] * 150, "fanuc-mill")
    looked = 0
    walk = looked_at._Walk
    look = walk._look_at

    def counted(self: object, effect: object) -> None:
        nonlocal looked
        looked += 1
        look(self, effect)  # type: ignore[arg-type]

    runs: QuietRuns = {}
    with patch.object(walk, "_look_at", counted):
        for line in range(2, 202):
            position_dependencies(program, line, "", runs, has_offset=False)
    assert looked < 300 + 5 * 200
