"""Programs with subprograms, laid out flat: what a check puts back is what the subprogram had left."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from checks.filtered import Filtered, filtered, pairs, same_states, traced

LINES = (
    "X5. Y5.",
    "Z20.",
    "G0 Z20.",
    "G1 Z-1. F70.",
    "G91",
    "G90",
    "G20",
    "S333",
    "M3",
    "M5",
    "M8",
    "M9",
    "G43 H5 Z9.",
    "G49",
    "G81 Z-3. R1. F90.",
    "G80",
    "T2 M6",
    "/S444",
    "#5=1",
    "IF [#1 EQ 2] GOTO 3",
)


START = "O1\nG90 G21\nT1 M6\nS1000 M3\nM8\nG0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nG0 Z15.\n"
AGAIN = ("G0 Z15.", "G90", "G21", "S900", "S900 M3", "M8", "M9", "G80", "G49", "G43 H1 Z15.", "G0 X3. Y4.")
BEHIND = "(FINISH)\nG0 X1. Y2.\nG43 H1 Z15.\nG1 Z-1. F100.\nX2.\nG0 Z15.\nM30\n"


@st.composite
def with_subprogram(draw: DrawFn) -> tuple[bytes, bytes]:
    """A program that calls O1000 between two operations, and the subprogram behind it."""
    again = draw(st.lists(st.sampled_from(AGAIN), max_size=5))
    body = draw(st.lists(st.sampled_from(LINES), max_size=4))
    program = START + "\n".join(["M98 P1000 ", *again, BEHIND])
    return program.encode(), "\n".join(["O1000", *body, "M99", ""]).encode()


def flat(program: bytes, body: bytes) -> bytes:
    return re.sub(rb"(?m)^M98 P1000 .*?$", lambda _: body.rstrip(b"\n"), program)


@pytest.mark.few(20)
@given(with_subprogram())
def test_a_check_puts_back_what_a_subprogram_left(parts: tuple[bytes, bytes]) -> None:
    program, sub = parts
    result = filtered(program + sub, "fanuc-mill")
    lines = sub.split(b"\n")[1:-2]
    inner = b"\n".join(line for line in lines if not line.startswith(b"IF"))
    assert result.output.endswith(sub)
    original, output = flat(program, inner), flat(result.output.removesuffix(sub), inner)
    laid_out = replace(result, data=original, output=output, interpreted=traced(original, result.settings))
    assert isinstance(laid_out, Filtered)
    same_states(pairs(laid_out))
