"""G73: passes of one shape; the words of one block and of two; rapids that would cross the contour."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.settings import load

HEAD = "G21 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
SHAPE = "N10 G0 X16.\nG1 Z-15.\nX30.\nX26. Z-25.\nG2 X30. Z-30. R6.\nN20 G1 X52.\n"
TWO = "G73 U4. W1. R3\nG73 P10 Q20 U0.4 W0.1 F0.3\n"
ONE = "G73 P10 Q20 U0.4 W0.1 I4. K1. D3 F0.3\n"
TAIL = "G0 X100. Z100.\nM30\n"
ALWAYS = 'cycles.unroll="always"'


def blocks_of(program: str, *options: str) -> list[str]:
    """The blocks of the cycle, without comments."""
    settings = load("fanuc-lathe", [ALWAYS, *options])
    output = chipbreak.rewrite(program.encode(), settings).data
    assert chipbreak.restore(output) == program.encode()
    assert chipbreak.rewrite(output, settings).data == output
    lines = output.decode().splitlines()
    return [line for line in lines[HEAD.count("\n") : -TAIL.count("\n")] if not re.match(r"(N10 )?\(", line)]


def test_each_pass_is_the_contour_off_by_less() -> None:
    blocks = blocks_of(HEAD + TWO + SHAPE + TAIL)
    assert blocks[:9] == [
        *("G0 X60.4 Z3.1", "G0 X24.4", "G1 Z-13.9 F0.3", "G1 X38.4", "G1 X34.4 Z-23.9"),
        *("G2 X38.4 Z-28.9 I5.978 K-0.509", "G1 X60.4", "G0 Z2.6", "G0 X56.4"),
    ]
    assert blocks[-7:] == [
        *("G1 Z-14.9", "G1 X30.4", "G1 X26.4 Z-24.9", "G2 X30.4 Z-29.9 I5.978 K-0.509", "G1 X52.4"),
        *("G0 Z2.", "G0 X52."),
    ]
    assert blocks.count("G1 Z-14.4") == 1


def test_one_block_says_the_same() -> None:
    assert blocks_of(HEAD + ONE + SHAPE + TAIL) == blocks_of(HEAD + TWO + SHAPE + TAIL)
    one_pass = [block.replace("D3", "D1") for block in (HEAD + ONE + SHAPE + TAIL,)]
    assert blocks_of(one_pass[0])[:3] == ["G0 X52.4 Z2.1", "G0 X16.4", "G1 Z-14.9 F0.3"]


def test_an_inner_pattern_goes_the_other_way() -> None:
    program = HEAD.replace("X52.", "X18.") + TWO.replace("U4.", "U-4.").replace("U0.4", "U-0.4")
    program += "N10 G0 X40.\nG1 Z-15.\nX30.\nZ-30.\nN20 X18.\n" + TAIL
    assert blocks_of(program)[:4] == ["G0 X9.6 Z3.1", "G0 X31.6", "G1 Z-13.9 F0.3", "G1 X21.6"]


def test_cuts_vibrate_where_the_profile_asks() -> None:
    program = (HEAD + TWO + SHAPE + TAIL).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.n=1.5"]))
    assert len(result.cuts) == 3
    assert chipbreak.restore(result.data) == program


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("R3", "R0", "CYC004"),
        ("R3", "R2.5", "CYC007"),
        (" R3", "", "CYC007"),
        ("G73 U4. W1. R3\n", "", "CYC004"),
        ("W0.1 F", "W0.1 I2. F", "CYC007"),
        ("N20 G1 X52.", "G1 X60.\nZ-40.\nN20 X26.", "CYC006"),
    ],
)
def test_what_is_no_pattern_stays(old: str, new: str, code: str) -> None:
    program = (HEAD + TWO + SHAPE + TAIL).replace(old, new).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS]))
    assert result.data == program
    assert [d.code for d in result.diagnostics if d.code.startswith("CYC")] == [code]


def test_a_way_back_over_the_contour_crosses_none_of_it() -> None:
    """It leads over X52 from Z-30 to Z2; the cone would come up there behind its end, at Z-16."""
    shape = "N10 G0 X16.\nG1 X40. Z-10.\nZ-30.\nN20 X52.\n"
    blocks = blocks_of(HEAD + TWO + shape + TAIL)
    assert blocks[-5:] == ["G1 X40.4 Z-9.9", "G1 Z-29.9", "G1 X52.4", "G0 Z2.", "G0 X52."]
