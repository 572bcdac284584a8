"""Columns of blocks that each say their G1, as controls want it that keep no motion code in force."""

from __future__ import annotations

import pytest

from chipbreak.dialects import find
from chipbreak.syntax.columns import read_columns
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read


@pytest.mark.parametrize(
    ("code", "asked", "found"),
    [
        ("G1 ", True, True),
        ("", True, True),
        ("G1 ", False, False),
        ("G01 ", True, False),
        ("G0 ", True, False),
    ],
)
def test_columns_of_lines_with_a_code(code: str, asked: bool, found: bool) -> None:
    text = "".join(f"{code}Z{number}.50 F{number + 1}.25\n" for number in range(20))
    program = parse(read(text.encode(), "a.nc"), find("klipper", ""))
    columns = read_columns(program, 0, 20, with_line_code=asked)
    if not found:
        assert columns is None
        return
    assert columns is not None
    assert columns[0] == "ZF"
    assert columns[1].tolist() == [[number + 0.5, number + 1.25] for number in range(20)]
