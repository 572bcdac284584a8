"""Cuts that only the profile asked for and that cannot vibrate: LinuxCNC runs them as it ran them before."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import chipbreak

from . import rs274

HEAD = "G21 G18 G8 G90 G95 G64 P0.02\nG97 S900 M3\nG0 X20 Z30\n"
LONG = "G1 Z-20 F0.4\nG0 X22\nG0 Z30\nG0 X19\n"
SHORT = "(LEFT)\nG1 X19.3 F0.2\n(ON)\n"  # too short to vibrate
SETS = ('planner.model="ideal"', 'output.segments="stroke"', "vibration.n=1.5")


def left_moves(program: bytes) -> Iterator[tuple[object, ...]]:
    """Where the moves go that stand between ``(LEFT)`` and ``(ON)``, how, and how the spindle turns."""
    judgement = rs274.judge(program, lathe=True)
    assert judgement.accepted, judgement.message
    moves = iter(judgement.motion)
    is_left = False
    for name, arguments in rs274.calls(judgement.canon):
        if name == "COMMENT":
            is_left = arguments[0] == "LEFT" or (is_left and arguments[0] != "ON")
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "DWELL", "ARC_FEED"):
            move = next(moves)
            if is_left:
                yield move


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    "blocks",
    [
        pytest.param(f"{LONG}{SHORT}{LONG}", id="between two that vibrate"),
        pytest.param(f"G1 Z-20 F0.4\n{SHORT}G1 Z-60 F0.4\n", id="in one run of cuts"),
        pytest.param(f"{LONG}G94 F300\n(LEFT)\nG1 X19.3\n(ON)\nG95 F0.4\n{LONG}", id="of another feed mode"),
        pytest.param(f"{LONG}G96 D2000 S60\n{SHORT}{LONG}G97 S800\n{SHORT}", id="under surface speed"),
        pytest.param(f"{LONG}G61.1\n{SHORT}G64 P0.01\n{LONG}{SHORT}", id="of another path mode"),
        pytest.param("G1 Z-20 F0.4\n(LEFT)\nG1 Z30 F2\n(ON)\nG1 X24 F0.4\n", id="way back through air"),
    ],
)
def test_a_left_cut_runs_as_before(blocks: str) -> None:
    program = f"{HEAD}{blocks}G0 X40\nM2\n".encode()
    result = chipbreak.rewrite(program, chipbreak.load("linuxcnc-lathe", SETS))
    assert result.cuts
    before = list(left_moves(program))
    assert len(before) == sum(blocks.count(line) for line in ("(LEFT)",))
    after = list(left_moves(result.data))
    if "Z30 F2" in blocks:  # through air the spindle keeps the speed it has
        before = [move._replace(speed=after[0].speed, time_s=after[0].time_s) for move in before]
    assert after == before
