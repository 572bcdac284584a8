"""A cut's strokes, cut where the control rests on the way, against parts cut by hand."""

from __future__ import annotations

import numpy as np
import pytest

from chipbreak.trajectory.junctions import four_digits, least_of_parts, parts_of

# Two blocks ahead, two back, three ahead.
LENGTHS = np.array([1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0])
STRAIGHT = np.zeros(7)


@pytest.mark.parametrize(
    ("last", "wanted"),
    [
        pytest.param(7, [(0, 2, 0), (2, 4, 1), (4, 7, 2)], id="all"),
        pytest.param(6, [(0, 2, 0), (2, 4, 1)], id="the third stroke ends in the plain feed"),
        pytest.param(4, [(0, 2, 0), (2, 4, 1)], id="to the end of the second"),
        pytest.param(3, [(0, 2, 0)], id="the second stroke ends in the plain feed"),
        pytest.param(1, [], id="none"),
    ],
)
def test_strokes_that_end_before_a_block(last: int, wanted: list[tuple[int, int, int]]) -> None:
    parts = parts_of(LENGTHS, STRAIGHT, last)
    assert list(zip(parts.starts, parts.stops, parts.strokes, strict=True)) == wanted


@pytest.mark.parametrize(
    ("corner", "wanted"),
    [
        pytest.param(0, [(0, 1, 0), (1, 2, 0), (2, 4, 1)], id="inside the first stroke"),
        pytest.param(1, [(0, 2, 0), (2, 4, 1)], id="where the tool turns back anyway"),
        pytest.param(3, [(0, 2, 0), (2, 4, 1)], id="at the end of the last stroke"),
        pytest.param(5, [(0, 2, 0), (2, 4, 1)], id="in the plain feed"),
    ],
)
def test_a_corner_at_its_limit_is_a_rest(corner: int, wanted: list[tuple[int, int, int]]) -> None:
    shares = STRAIGHT.copy()
    shares[corner] = 1.0
    parts = parts_of(LENGTHS, shares, 4)
    assert list(zip(parts.starts, parts.stops, parts.strokes, strict=True)) == wanted
    shares[corner] = 0.999
    assert parts_of(LENGTHS, shares, 4).starts.tolist() == [0, 2]


def test_what_is_known_of_blocks_by_parts() -> None:
    parts = parts_of(LENGTHS, STRAIGHT, 4)
    assert least_of_parts(parts, np.array([5.0, 3.0, 4.0, 8.0, 1.0, 1.0, 1.0])).tolist() == [3.0, 4.0]


@pytest.mark.parametrize(
    ("value", "wanted"), [(1234.56, 1235.0), (0.0123456, 0.01235), (123456.0, 123500.0), (1.0, 1.0)]
)
def test_four_digits(value: float, wanted: float) -> None:
    assert four_digits(np.array([value])).tolist() == [wanted]
