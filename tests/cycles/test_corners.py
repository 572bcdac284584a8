"""Corners and angles that a contour says: drawn as moves for roughing, and for finishing."""

from __future__ import annotations

import math
import re

import pytest

import chipbreak
from chipbreak.settings import load

ALWAYS = 'cycles.unroll="always"'
HEAD = "G21 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
CYCLE = "G71 U2. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.3\n"
TAIL = "G70 P10 Q20\nG0 X100. Z100.\nM30\n"


def program_of(*blocks: str) -> bytes:
    shape = ["N10 G0 X16.", *blocks, "N20 G1 X50."]
    return "\n".join([HEAD + CYCLE + shape[0], *shape[1:], TAIL]).encode()


def finish_of(program: bytes, *options: str) -> list[str]:
    """The blocks that stand for the G70, without the way to the first point and back."""
    output = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS, *options])).data.decode()
    assert chipbreak.restore(output.encode()) == program
    finish = output[output.index("UNROLLED G70") :].splitlines()[1:]
    lines = [line for line in finish[: finish.index("G0 X100. Z100.")] if not line.startswith("(")]
    return lines[1:-2]


@pytest.mark.parametrize("corner", [",C2.", "C2.", "C-2.", "K2."])
def test_a_chamfer_begins_and_ends_its_size_off_the_corner(corner: str) -> None:
    assert finish_of(program_of("G1 Z0.", f"X30. {corner}", "Z-20.")) == [
        *("G1 Z0.", "G1 X26.", "G1 X30. Z-2.", "G1 Z-20."),
    ]


@pytest.mark.parametrize("corner", [",R2.", "R2."])
def test_a_radius_touches_both_lines(corner: str) -> None:
    out = finish_of(program_of("G1 Z0.", f"X30. {corner}", f"Z-20. {corner}", "X40.", "Z-30."))
    assert out[1:5] == ["G1 X26.", "G3 X30. Z-2. I0. K-2.", "G1 Z-18.", "G2 X34. Z-20. I2. K0."]


def test_a_radius_between_slanted_lines() -> None:
    """The distance of the centre from both lines is the radius."""
    blocks = finish_of(program_of("G1 Z-10.", "X30. Z-20. ,R3.", "X34. Z-40."))
    x1, z1 = map(float, re.match(r"G1 X([\d.]+) Z([-\d.]+)", blocks[1]).groups())  # type: ignore[union-attr]
    arc = re.match(r"G3 X([\d.]+) Z([-\d.]+) I([-\d.]+) K([-\d.]+)", blocks[2])
    assert arc is not None
    _, _, i, k = map(float, arc.groups())
    centre = (z1 + k, x1 / 2.0 + i)
    for a, b in (((-10.0, 8.0), (-20.0, 15.0)), ((-20.0, 15.0), (-40.0, 17.0))):
        cross = (b[0] - a[0]) * (centre[1] - a[1]) - (b[1] - a[1]) * (centre[0] - a[0])
        assert abs(cross) / math.dist(a, b) == pytest.approx(3.0, abs=2e-3)


def test_an_angle_gives_the_other_axis() -> None:
    assert finish_of(program_of("G1 Z-10.", "Z-20. ,A135.", "Z-30.")) == [
        *("G1 Z-10.", "G1 X36. Z-20.", "G1 Z-30."),
    ]
    assert finish_of(program_of("G1 Z-10.", "X36. A135.", "Z-30.")) == [
        *("G1 Z-10.", "G1 X36. Z-20.", "G1 Z-30."),
    ]


def test_other_words_of_a_block_stay() -> None:
    shape = program_of("G42 G1 Z0. F0.2", "X30. ,C2. S900 M8", "M9 G40 Z-20.")
    assert finish_of(shape)[:3] == ["G42 F0.2 G1 Z0.", "S900 M8 G1 X26.", "G1 X30. Z-2."]


def test_roughing_leaves_the_drawn_contour() -> None:
    """What is left is looked after; here, that the last pass goes round the corner."""
    output = chipbreak.rewrite(program_of("G1 Z0.", "X30. ,R2.", "Z-20."), load("fanuc-lathe", [ALWAYS])).data
    assert b"\nG1 X26.4\nG3 X30.4 Z-1.9 I0. K-2.\nG1 Z-19.9\n" in output


def test_plain_corners_can_be_switched_off() -> None:
    program = program_of("G1 Z0.", "X30. C2.", "Z-20.")
    rule = "cycles.plain_corners=false"
    result = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS, rule]))
    assert result.data == program
    assert {d.code for d in result.diagnostics if d.code.startswith("CYC")} == {"CYC002"}


def test_a_pass_of_its_own_leaves_i_and_k_before_the_last() -> None:
    one = "G71 P10 Q20 U0.4 W0.1 I0.3 K0.2 D2. R1 F0.3\n"
    program = program_of("G1 Z-10.", "X30.", "X26. Z-20.", "X30. Z-24.").replace(CYCLE.encode(), one.encode())
    output = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS])).data
    assert output.count(b"ALONG THE CONTOUR") == 2
    assert b"\nG1 Z-9.7\nG1 X31.\n" in output
    assert b"\nG1 Z-9.9\nG1 X30.4\n" in output
    without = program.replace(b" R1", b"")
    assert chipbreak.rewrite(without, load("fanuc-lathe", [ALWAYS])).data == without, (
        "a pocket, and no type II"
    )


@pytest.mark.parametrize("slope", ["Z-2. ,A95.", "X30. Z-12.", "X17. Z-2."])
def test_a_pass_along_a_steep_line_is_as_thick_as_what_stands_before_it(slope: str) -> None:
    """In height it takes more than the depth."""
    one = "G71 P10 Q20 U0.4 W0.1 I0.3 K0.2 D0.871 F0.3\n"
    program = program_of("G1 Z-1.", slope, "X49.", "Z-20.").replace(CYCLE.encode(), one.encode())
    output = chipbreak.rewrite(program.replace(b"X50.", b"X51."), load("fanuc-lathe", [ALWAYS])).data
    assert output.count(b"ALONG THE CONTOUR") == 2


def test_i_and_k_together_are_no_deeper_than_a_pass() -> None:
    one = "G71 P10 Q20 U0.4 W0.1 I0.6 K0.5 D1. F0.3\n"
    program = program_of("G1 Z-10.", "X30.").replace(CYCLE.encode(), one.encode())
    result = chipbreak.rewrite(program, load("fanuc-lathe", [ALWAYS]))
    assert [d.code for d in result.diagnostics if d.code.startswith("CYC")] == ["CYC004"]


@pytest.mark.parametrize("behind", ["X70.\n", "X70. Z-30. ,A135.\n"])
def test_two_angles_with_no_place_are_refused(behind: str) -> None:
    """Only that which stands right before a move meets its line: the one before it has no place."""
    contour = f"N10 G0 X16.\nG1 ,A180. F0.1\nG1 ,A135.\nG1 X60. Z-20. ,A90.\n{behind}N20 X80.\n"
    program = f"G99\nT0101\nG97 S600 M3\nG0 X52. Z2.\nG71 U2. R0.5\nG71 P10 Q20 U0.4 F0.3\n{contour}M30\n"
    settings = chipbreak.load("fanuc-lathe", ['cycles.unroll="always"'])
    result = chipbreak.rewrite(program.encode(), settings)
    assert not result.changed
    assert any("has an angle beside" in one.message for one in result.diagnostics)
