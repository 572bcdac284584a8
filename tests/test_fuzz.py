"""The search for new failures ends when its time is over, whatever number of examples a test asks for."""

from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import fuzz

MANY = hypothesis_settings(max_examples=2000, deadline=None, database=None)


class Clock:
    """Every example takes a second."""

    def __init__(self) -> None:
        self.now = 0.0
        self.tried: list[int] = []

    def take(self, number: int) -> None:
        self.now += 1.0
        self.tried.append(number)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(fuzz.time, "time", lambda: clock.now)
    return clock


def test_no_example_is_tried_when_the_time_is_over(clock: Clock) -> None:
    @given(st.integers())
    @MANY
    def slow(number: int) -> None:
        clock.take(number)
        assume(number % 5)

    slow.hypothesis.inner_test = fuzz.until_the_end(slow.hypothesis.inner_test, 20.0)
    slow()
    assert len(clock.tried) == 21


def test_an_example_that_failed_is_made_small_behind_the_end(clock: Clock) -> None:
    @given(st.integers(0, 10**6))
    @MANY
    def wrong(number: int) -> None:
        clock.take(number)
        assert number < 1000

    wrong.hypothesis.inner_test = fuzz.until_the_end(wrong.hypothesis.inner_test, 20.0)
    with pytest.raises(AssertionError):
        wrong()
    assert clock.now > 21.0
    assert min(number for number in clock.tried if number >= 1000) == 1000
