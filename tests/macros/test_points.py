"""Just above the point of a drill the limit line is that of the point, not that of the edge beside it."""

from __future__ import annotations

import pytest

from .table import Row, by_macros, by_numpy, rows

SHORTER = [row for row in rows() if row.text.startswith("drill, shorter by 0.03") and "IS-C" in row.text]


@pytest.mark.parametrize("row", SHORTER, ids=lambda row: row.text)
def test_a_drill_that_is_a_little_shorter_passes_before_a_rough_operation(row: Row) -> None:
    """At S5000 an edge is looked at straight above the point: 0.08 mm off, but 0.03 along the normal."""
    assert by_macros(row) == by_numpy(row) == "/CHIP"


def test_both_speeds_are_tried() -> None:
    assert {row.rpm for row in SHORTER} >= {1500, 5000}
