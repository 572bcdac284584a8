"""Further work offsets: G54.1 P1 and G54.1 P2 are two coordinate systems."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.model.trace import interpret
from chipbreak.source import read
from chipbreak.syntax.parse import parse

SETTINGS = chipbreak.load("fanuc-mill")


def positions(*lines: str) -> list[float]:
    """Y behind each line."""
    trace = interpret(parse(read("\n".join([*lines, ""]).encode())), SETTINGS)
    return [trace.before(n).position.y for n in range(1, len(lines) + 1)]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("G54.1 P1", "G54.1 P2"),
        ("G54 P1", "G54 P2"),
        ("G154 P1", "G154 P2"),
        ("G54", "G54.1 P1"),
        ("G54.1 P#1", "G54.1 P#1"),
        ("G110", "G111"),
        ("G129", "G154 P1"),
    ],
)
def test_where_the_tool_stands_in_another_one_is_not_known(one: str, other: str) -> None:
    ys = positions(one, "G0 X1. Y2. Z3.", other, "G0 Y4.")
    assert ys[1] == 2.0
    assert math.isnan(ys[2])
    assert ys[3] == 4.0


@pytest.mark.parametrize("said", ["G54.1 P1", "G54", "G154 P12", "G110"])
def test_the_same_one_again_changes_nothing(said: str) -> None:
    assert positions(said, "G0 X1. Y2. Z3.", said)[2] == 2.0


def test_p_is_read() -> None:
    program = b"T1 M6\nG54.1 P3\nG0 G154 P4 X1.\nM30\n"
    assert [d.code for d in chipbreak.rewrite(program, SETTINGS).diagnostics] == ["CHK005"]


def test_the_code_of_such_an_offset_is_said_with_its_words() -> None:
    assert SETTINGS.dialect.code("work_offset", "G54.1 P3") == "G54.1 P3"
    assert SETTINGS.dialect.code("work_offset", "G55") == "G55"
