"""Rows of lines of one shape are looked up at once: that gives what a look at each line gives."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.dialects import find
from chipbreak.syntax.parse import parse
from chipbreak.syntax.shapes import Shape
from chipbreak.text.source import read

FANUC = find("fanuc-mill", "A")
LINES = [
    "X1. Y2.",
    "X-1. Y2.5",
    "X-.5",
    "X5",
    "N10 X1. Y-2.",
    "N10 G1 X1. Y2.",
    "G0 X1. Y2.",
    "X--5.",
    "X1-5.",
    "G-1 X5.",
    "X -5. Y+2.",
    "/X1. Y2.",
    "",
    " ",
    "M8",
    "(X-1. Y2.)",
    "XX1. Y2.",
    "Y2.",
    "1X1. Y2.",
    "%",
]
rows = st.lists(
    st.tuples(st.sampled_from(LINES), st.sampled_from([1, 2, 3, 7, 63, 64, 65, 130])), min_size=1, max_size=12
)


def shape_of(line: str) -> Shape | None:
    """What a line is, alone in a program."""
    program = parse(read(line.encode() + b"\n"), FANUC)
    return program.shapes[program.plain[0]] if program.plain[0] >= 0 else None


ALONE = {line: shape_of(line) for line in LINES}


@pytest.mark.few(60)
@given(rows, st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_rows_and_single_lines(found: list[tuple[str, int]], end: str, ends: bool) -> None:
    lines = [line for line, count in found for _ in range(count)]
    program = parse(read((end.join(lines) + end * ends).encode()), FANUC)
    wanted = [ALONE[line] for line in lines]
    ids = program.plain.tolist()
    assert [program.shapes[i] if i >= 0 else None for i in ids] == wanted[: len(ids)]
    assert len(ids) >= len(lines) - 1  # an empty last line without an end is none


def test_what_a_sign_is() -> None:
    plain = {line for line, shape in ALONE.items() if shape is not None}
    assert plain == {
        "X1. Y2.",
        "X-1. Y2.5",
        "X-.5",
        "X5",
        "N10 X1. Y-2.",
        "N10 G1 X1. Y2.",
        "G0 X1. Y2.",
        "X -5. Y+2.",
        "Y2.",
    }
