"""What a program does outside its vibrated cuts must stay as it was, as LinuxCNC's interpreter sees it.

Programs with every modal change a shop writes are filtered; then all moves outside the vibrated cuts are
held against those of the original, with feed, feed mode, spindle speed, its mode and limit, and path mode.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from hypothesis import Phase, event, example, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak

from . import rs274
from .compared import assert_same_outside

_PLACE = st.integers(8, 20)
_ITEMS = st.one_of(
    st.builds("G0 X{} Z{}".format, _PLACE, _PLACE),
    st.builds("G1 X{} F0.2".format, _PLACE),
    st.builds("G90 G0 X{} Z9\n(VIB N1.5)\nG1 Z{} F0.4\n(VIB OFF)".format, _PLACE, st.integers(-4, 5)),
    st.builds("G90 G0 X{} Z30\n(VIB E2)\nG1 X{} F0.4\nZ26\n(VIB OFF)".format, _PLACE, st.integers(-2, 5)),
    st.builds("S{}".format, st.integers(50, 90)),
    st.builds("G97 S{}".format, st.integers(500, 1500)),
    st.builds("G96 D{} S{}".format, st.integers(1500, 2500), st.integers(50, 90)),
    st.sampled_from(["G94 F200", "G95 F0.3", "M3", "M4", "M8", "M9", "G4 P0.1", "G7", "G8", "M5\nM3"]),
    st.sampled_from(["G64 P0.01", "G64", "G61", "G61.1", "(so)", "G91 G1 X0.5 F0.3\nG90", "G40", "G55"]),
)


def state_at_moves(program: bytes) -> Iterator[tuple[object, ...]]:
    """Every move outside the vibrated cuts: where it goes; for a cut also how, and how the spindle turns."""
    judgement = rs274.judge(program, lathe=True)
    assert judgement.accepted, judgement.message
    moves = iter(judgement.motion)
    inside, limit = False, "0"
    for name, arguments in rs274.calls(judgement.canon):
        if name == "COMMENT":
            inside = inside or arguments[0] in ("VIB N1.5", "VIB E2")
            inside = inside and arguments[0] != "VIB OFF"
        elif name == "SET_SPINDLE_MODE":
            limit = arguments[1]
        elif name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE", "DWELL"):
            move = next(moves)
            if not inside and move.kind == "feed":
                yield (*move[:-1], limit)
            elif not inside:
                yield move[:4]


_SLOW = "G90 G0 X10 Z30\n(VIB E2)\nG1 X-1 F0.4\nZ26\n(VIB OFF)"  # 0.4 mm per minute in G94
_SLOW_TURNING = "G90 G0 X17 Z9\n(VIB N1.5)\nG1 Z-3 F0.4\n(VIB OFF)"


@pytest.mark.few(4)
@pytest.mark.linuxcnc
@example(["G94 F200", _SLOW, "G94 F200"])
@example(["G94 F200", _SLOW_TURNING, "G96 D1631 S83", "G95 F0.3"])
@example(["S57", "G61", "G96 D1631 S83", _SLOW_TURNING, _SLOW])
@given(st.lists(_ITEMS, min_size=3, max_size=14))
@hypothesis_settings(max_examples=60, phases=[Phase.explicit, Phase.reuse, Phase.generate])
def test_all_else_stays_as_it_was(items: list[str]) -> None:
    lines = ["G21 G18 G8 G90 G95 G64 P0.02", "G97 S900 M3", "G0 X20 Z30", *items, "G1 X30 F0.25", "M2", ""]
    program = "\n".join(lines).encode()
    settings = chipbreak.load("linuxcnc-lathe", ['planner.model="ideal"', 'output.segments="stroke"'])
    try:
        out = chipbreak.rewrite(program, settings, allow_unbroken=True).data
    except chipbreak.ProgramRejectedError as error:
        codes = {d.code for d in error.diagnostics if d.severity.value == "error"}
        event(f"refused {sorted(codes)}")
        # N and f under a slow G96, a clamp, a feed of the wrong mode (so slow that F has too few decimals to
        # keep the time, VIB059): no other reason.
        legitimate = {"VIB006", "VIB008", "VIB013", "VIB021", "VIB057", "VIB023", "VIB059"}
        assert codes <= legitimate, program.decode()
        return
    event("taken")
    assert list(state_at_moves(out)) == list(state_at_moves(program))


@pytest.mark.linuxcnc
@pytest.mark.parametrize(("first", "then"), [("G21", "G20"), ("G20", "G21"), ("G21", "G21"), ("G20", "G20")])
@pytest.mark.parametrize("behind", ["G0 Z1", "M3", "M5\nM3", "M5\nS120 M3"])
def test_a_check_gives_back_a_surface_speed_as_it_was_set(first: str, then: str, behind: str) -> None:
    """In the units in which it was set: where the spindle starts, the control reads its number again."""
    program = (
        f"G17 G40 G49 G54 G80 G90 G94\nT1 M6\n{first}\nG96 S100 M3\n{then}\nG0 X1 Y1 Z1\n(ROUGH)\n"
        f"G1 Z-1 F10\nG0 Z1\n(FINISH)\nG0 Z1\n{behind}\nG1 Z-1 F10\nM5\nM3\nG1 Z-2\nG0 Z1\nM2\n"
    ).encode()
    own = ['calls.own={chip_check="G4 P0.001"}', "checks.calls=own", "checks.enabled=true"]
    result = chipbreak.rewrite(program, chipbreak.load("linuxcnc-mill", own))
    assert b"CHIP CHECK T1 W0.02" in result.data
    assert_same_outside(program, result.data, lathe=False, comes_back=False)
