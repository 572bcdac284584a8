"""Cycles of any words, and contours with corners and angles: written out whole, or refused; never a fault."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.settings import load

MANY = 20 if settings.default and settings.default.derandomize else 300  # in a search
LATHE = load("fanuc-lathe", ['cycles.unroll="always"'])
CONTROL = load("linuxcnc-lathe", ['cycles.unroll="always"'])
LENGTHS = st.one_of(st.integers(0, 6000), st.integers(0, 6)).map(lambda step: step / 1000.0)
CORNERS = st.one_of(
    st.just(""), st.tuples(st.sampled_from([",C", ",R", "C", "R", "K"]), st.integers(0, 900)).map(
        lambda said: f" {said[0]}{said[1] / 1000.0:.3f}"
    )
)  # fmt: skip
STEPS = st.lists(
    st.tuples(st.sampled_from("XZBA"), LENGTHS, LENGTHS, st.sampled_from([95, 120, 150, 175]), CORNERS),
    min_size=2,
    max_size=6,
)
HEADS = st.one_of(
    st.integers(300, 3000).map(lambda d: f"G71 U{d / 1000.0:.3f} R0.5\nG71 P10 Q20 U0.4 W0.1 F0.3\n"),
    st.tuples(st.integers(500, 3000), LENGTHS, LENGTHS).map(
        lambda d: f"G71 P10 Q20 U0.4 W0.1 D{d[0] / 1000.0:.3f} I{d[1] / 9:.3f} K{d[2] / 9:.3f} R1 F0.3\n"
    ),
    st.tuples(LENGTHS, LENGTHS, st.integers(1, 5)).map(
        lambda d: f"G73 U{d[0]:.3f} W{d[1]:.3f} R{d[2]}\nG73 P10 Q20 U0.4 W0.1 F0.3\n"
    ),
)


def contour_of(steps: list[tuple[str, float, float, int, str]]) -> tuple[str, float]:
    """The blocks of a contour that goes out and to the left, and the diameter of its end."""
    x, z = 16.0, 0.0
    lines = ["N10 G0 X16.", "G1 Z0."]
    for kind, dx, dz, angle, corner in steps:
        x += 2.0 * dx if kind in "XB" else 2.0 * dz * -math.tan(math.radians(angle)) if kind == "A" else 0.0
        z -= dz if kind != "X" else 0.0
        words = {"X": f"X{x:.3f}", "Z": f"Z{z:.3f}", "B": f"X{x:.3f} Z{z:.3f}", "A": f"Z{z:.3f} ,A{angle}."}
        lines.append(words[kind] + corner)
    return "\n".join([*lines, f"Z{z - 3.0:.3f}", f"N20 X{x + 4.0:.3f}", ""]), x + 4.0


@settings(max_examples=MANY)
@given(HEADS, STEPS, st.integers(0, 6))
def test_contours_with_corners(head: str, steps: list[tuple[str, float, float, int, str]], over: int) -> None:
    contour, diameter = contour_of(steps)
    start = f"G21 G99\nT0101\nG97 S1200 M3\nG0 X{diameter + over:.3f} Z2.\n"
    program = f"{start}{head}{contour}G70 P10 Q20\nG0 X300. Z50.\nM30\n".encode()
    result = chipbreak.rewrite(program, LATHE)
    refused = {d.code for d in result.diagnostics if d.code.startswith("CYC")}
    assert (b"UNROLLED" in result.data) != bool(refused)
    assert chipbreak.restore(result.data) == program


@pytest.mark.few(8)
@settings(max_examples=MANY)
@given(
    st.lists(st.tuples(st.integers(-2500, 4000), st.integers(0, 7000)), min_size=2, max_size=6),
    st.sampled_from(["G71", "G71.1", "G71.2", "G70"]),
    st.integers(300, 3000),
    LENGTHS,
)
def test_contours_in_subroutines(
    steps: list[tuple[int, int]], code: str, depth: int, distance: float
) -> None:
    x, z = 20.0, -2.0
    lines = ["G0 X20", "G1 Z-2"]
    for dx, dz in steps:
        x += dx / 1000.0
        z -= dz / 1000.0
        lines.append(f"G1 X{x:.3f} Z{z:.3f}")
    shape = "\n".join([*lines, f"G1 X{x + 9.0:.3f}"])
    cycle = f"{code} Q100 I{depth / 1000.0:.3f} D{distance / 10.0:.3f}"
    start = f"G8 G18 G21 G90 G94 G40\nF200 S800 M3\no100 sub\n{shape}\no100 endsub\nG0 X{x + 30.0:.3f} Z2\n"
    program = f"{start}{cycle}\nG0 X90 Z10\nM2\n".encode()
    result = chipbreak.rewrite(program, CONTROL)
    refused = {d.code for d in result.diagnostics if d.code.startswith("CYC")}
    assert (b"UNROLLED" in result.data) != bool(refused)
    assert chipbreak.restore(result.data) == program
