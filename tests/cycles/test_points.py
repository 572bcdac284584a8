"""Numbers without a decimal point in cycles: what the profile says counts in every word."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.settings import load

HEAD = "G21 G40 G99\nT0101\nG97 S1200 M3\n"
TAIL = "G0 X100. Z100.\nM30\n"
CONTOUR = "N10 G0 X16. F0.1\nG1 Z-10.\nN20 X52.\n"
CURVED = (
    "N10 G0 X16. F0.1\nG1 Z-10.\nG2 X26. Z-15. R5.\nG1 X30. Z-20. ,C2.\nZ-30.\n"
    "G3 X40. Z-35. I0. K-5.\nN20 G1 X52.\n"
)
TWO_BLOCKS = "G0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U1. W1. F0.3\n"
FACING = "G0 X52. Z3.\nG72 W1. R1.\nG72 P10 Q20 U1. W1. F0.3\n"
PATTERN = "G0 X60. Z5.\nG73 U4. W2. R3\nG73 P10 Q20 U1. W1. F0.3\n"
PROGRAMS = {
    "two blocks": f"{TWO_BLOCKS}{CURVED}G70 P10 Q20\n",
    "facing": f"{FACING}N10 G0 Z-12.\nG1 X30. F0.1\nZ-3.\nN20 X-2.\n",
    "pattern": f"{PATTERN}{CONTOUR}",
    "one block": f"G0 X52. Z2.\nG71 P10 Q20 U1. W1. D2. I1. K1. R0 F0.3\n{CONTOUR}",
    "single": "G0 X52. Z2.\nG90 X46. Z-20. F0.3\nX42.\nX40. R-2.\n",
    "distances": f"{TWO_BLOCKS}N10 G0 U-36. F0.1\nG1 W-12.\nN20 U36.\n",
}
UNROLL = 'cycles.unroll="always"'


def pointless(text: str, times: int) -> str:
    """Every length with a bare point without it, in thousandths where ``times`` is 1000; D, F and S stay."""

    def without(match: re.Match[str]) -> str:
        number = int(match[2]) * times
        return f"{match[1]}{number}"

    return re.sub(r"(,?[XZUWRIKC])(-?\d+)\.(?!\d)", without, text)


@pytest.mark.parametrize("text", PROGRAMS.values(), ids=list(PROGRAMS))
@pytest.mark.parametrize(("rule", "times"), [("calculator", 1), ("increment", 1000)])
def test_the_passes_are_those_of_the_program_with_points(text: str, rule: str, times: int) -> None:
    """The same program in both ways of writing it: only what is kept of it in comments differs."""
    plain = chipbreak.rewrite((HEAD + text + TAIL).encode(), load("fanuc-lathe", [UNROLL])).data
    settings = load("fanuc-lathe", [UNROLL, f"control.decimal_point={rule}"])
    program = (HEAD + pointless(text, times) + pointless(TAIL, times)).encode()
    output = chipbreak.rewrite(program, settings).data
    assert b"CHIPBREAK UNROLLED" in output
    assert chipbreak.restore(output) == program
    passes = [re.sub(rb"\(CHIPBREAK .*\)\n", b"", data) for data in (plain, output)]
    firsts = [data.split(b"\n") for data in passes]
    assert len(firsts[0]) == len(firsts[1])
    for one, other in zip(*firsts, strict=True):
        assert one == other or pointless(one.decode(), times) == pointless(other.decode(), times)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("U1. W1.", "U1 W1.", "U1 of this cycle has no decimal point"),
        ("W1. F", "W1 F", "W1 of this cycle has no decimal point"),
        ("U2. R1.", "U2 R1.", "U2 of this cycle has no decimal point"),
        ("U2. R1.", "U2. R1", "R1 of this cycle has no decimal point"),
        ("X16. F", "X16 F", "X16 in the contour has no decimal point"),
        ("Z-10.", "Z-10", "Z-10 in the contour has no decimal point"),
        (",C2.", ",C2", "has a corner of unknown size"),
        ("G0 X52. Z2.", "G0 X52 Z2.", "X52 in line 4 has no decimal point"),
        ("G0 X52. Z2.", "G0 X52. Z2", "Z2 in line 4 has no decimal point"),
    ],
)
def test_where_nobody_knows_the_word_is_named_and_the_way_out_works(old: str, new: str, message: str) -> None:
    """``required``: no number is taken for what it may not be."""
    text = PROGRAMS["two blocks"]
    assert old in text
    program = (HEAD + text.replace(old, new, 1) + TAIL).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", [UNROLL]))
    assert result.data == program
    said = next(one for one in result.diagnostics if one.code.startswith("CYC"))
    assert message in said.message
    assert 'set control.decimal_point to "calculator" or "increment"' in said.help
    known = load("fanuc-lathe", [UNROLL, "control.decimal_point=calculator"])
    assert b"CHIPBREAK UNROLLED G71" in chipbreak.rewrite(program, known).data


def test_a_single_pass_names_its_word() -> None:
    program = (HEAD + PROGRAMS["single"].replace("X42.", "X42") + TAIL).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", [UNROLL]))
    assert any("X42 of this cycle has no decimal point" in one.message for one in result.diagnostics)
