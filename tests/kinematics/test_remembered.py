"""What is remembered is what would be worked out: for the same bits, and for no others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from chipbreak.kinematics import remembered as module
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.remembered import _ENTRY, _MOST_NUMBERS, remembered


@dataclass(frozen=True, eq=False)
class Pair:
    """Two arrays that are told apart by what they are made of."""

    one: Floats
    other: Floats


class Counted:
    """A function that says what it was asked."""

    def __init__(self) -> None:
        self.asked: list[object] = []

        @remembered
        def work(*values: object) -> list[object]:
            self.asked.append(values)
            return list(values)

        self.work = work


def floats(*values: float) -> Floats:
    """An array."""
    return np.array(values)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (floats(1.0, 2.0), floats(1.0, 2.0 + 2.0**-51)),
        (floats(0.0), floats(-0.0)),
        (floats(1.0, 2.0, 3.0, 4.0), floats(1.0, 2.0, 3.0, 4.0).reshape(2, 2)),
        (np.array([1]), np.array([1]).view(np.float64)),
        ((floats(1.0), floats(2.0, 3.0)), (floats(1.0, 2.0), floats(3.0))),
        (Pair(floats(1.0), floats(2.0)), Pair(floats(2.0), floats(1.0))),
        (Pair(floats(1.0), floats(2.0)), (floats(1.0), floats(2.0))),
        (1.5, 2.5),
        (None, "none"),
    ],
)
def test_what_differs_is_worked_out(one: object, other: object) -> None:
    """Other bits, other shapes, another kind."""
    counted = Counted()
    for value in (one, other, one, other):
        assert counted.work(value)[0] is (one if value is one else other)
    assert len(counted.asked) == 2


@pytest.mark.parametrize(
    "make", [lambda: floats(1.0, 2.0), lambda: Pair(floats(1.0), floats(np.nan)), lambda: 3]
)
def test_what_is_the_same_is_not(make: object) -> None:
    """Another array with the same bits."""
    assert callable(make)
    counted = Counted()
    first = counted.work(make(), 1.0)
    assert counted.work(make(), 1.0) is first
    assert counted.work(make(), 2.0) is not first
    assert len(counted.asked) == 2


def test_long_arrays_are_not_kept() -> None:
    """A long cut is worked out anew, so that memory stays small."""
    counted = Counted()
    most, more = np.zeros(_MOST_NUMBERS), np.zeros(_MOST_NUMBERS + 1)
    for value in (most, most, more, more):
        counted.work(value)
    assert [len(value) for (value,) in counted.asked] == [_MOST_NUMBERS, _MOST_NUMBERS + 1, _MOST_NUMBERS + 1]  # type: ignore[misc, has-type]


def test_long_answers_are_not_kept() -> None:
    """Nor is the motion of a long cut, which a few numbers ask for."""
    asked: list[int] = []

    @remembered
    def work(size: int) -> Floats:
        asked.append(size)
        return np.zeros(size)

    for size in (_MOST_NUMBERS, _MOST_NUMBERS, _MOST_NUMBERS + 1, _MOST_NUMBERS + 1):
        assert work(size).size == size
    assert asked == [_MOST_NUMBERS, _MOST_NUMBERS + 1, _MOST_NUMBERS + 1]


def test_only_so_many_numbers_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oldest is forgotten first: what was asked for counts, and what was given."""
    monkeypatch.setattr(module, "_MOST_KEPT", 4 * (10 + _ENTRY))
    asked: list[int] = []

    @remembered
    def work(number: int, values: Floats) -> Floats:
        asked.append(number)
        return values + number

    for number in (0, 1, 2, 3, 0, 4, 3, 1, 0):
        work(number, np.zeros(5))
    assert asked == [0, 1, 2, 3, 4, 0]


def test_one_is_kept_however_long_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_MOST_KEPT", 1)
    counted = Counted()
    for number in (1, 1, 2, 2, 1):
        counted.work(number)
    assert counted.asked == [(1,), (2,), (1,)]


def test_what_is_kept_cannot_be_written() -> None:
    """Arrays, and those in tuples and dataclasses."""

    @remembered
    def work(value: object) -> tuple[Floats, Pair]:
        return floats(1.0), Pair(floats(2.0), floats(3.0))

    alone, pair = work(1)
    for array in (alone, pair.one, pair.other):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 4.0


def test_an_error_is_said_again() -> None:
    """Nothing is kept of what was refused."""
    tries: list[int] = []

    @remembered
    def refuse(number: int) -> int:
        tries.append(number)
        raise ValueError

    for _ in range(2):
        with pytest.raises(ValueError):
            refuse(1)
    assert tries == [1, 1]
