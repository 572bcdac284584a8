"""The search for the feeds of blocks in a row, against all factors tried one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from copy import copy
from itertools import groupby, pairwise
from typing import Self

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory import feed_search
from chipbreak.trajectory.feed_search import Stretch, feed_factors, feeds_of_single_blocks, forget

TRIED = [0.5 * 40.0 ** (k / 74.0) for k in range(75)]


class Control:
    """Blocks take length / feed, and what a function makes of that; it keeps what it was asked."""

    def __init__(
        self,
        made: Callable[[float], float] = lambda time_s: time_s,
        slack_s: float = 1e-7,
        period_s: float = 1e-4,
    ) -> None:
        self.made = made
        self.own_slack_s = slack_s
        self.servo_period_s = period_s
        self.has_mm_s2 = 0.0
        self.asked: list[tuple[float, float, float]] = []
        self.counts: list[int] = []
        self.singles: list[tuple[list[float], list[float], list[float]]] = []
        self.before_mm_s: set[float] = set()

    @property
    def tried(self) -> int:
        """How many stretches it was asked for."""
        return sum(self.counts)

    def with_acceleration(self, acceleration_mm_s2: float) -> Self:
        other = copy(self)
        other.has_mm_s2 = acceleration_mm_s2
        return other

    def refuse_too_fast(self, length_mm: float, time_s: float) -> None:
        self.asked.append((length_mm, time_s, self.has_mm_s2))

    def slack_s(self, wanted_s: float) -> float:
        return self.own_slack_s

    def times_alike(
        self, lengths_mm: Floats, feeds_mm_s: Floats, acceleration_mm_s2: Floats, before_mm_s: float
    ) -> Floats:
        self.counts.append(len(lengths_mm))
        self.before_mm_s.add(before_mm_s)
        assert len(acceleration_mm_s2) == len(lengths_mm)
        own = (lengths_mm / feeds_mm_s).sum(axis=1)
        # All of it in the last block, and more of it where the acceleration is less than 100 mm/s2.
        times_s = np.zeros(lengths_mm.shape)
        times_s[:, -1] = [
            self.made(time) * max(1.0, 100.0 / has) for time, has in zip(own, acceleration_mm_s2, strict=True)
        ]
        return times_s

    def single_feeds(self, lengths_mm: Floats, times_s: Floats, acceleration_mm_s2: Floats) -> list[float]:
        self.singles.append((lengths_mm.tolist(), times_s.tolist(), acceleration_mm_s2.tolist()))
        return (lengths_mm / times_s).tolist()


def stretch(share: float = 1.0, has_mm_s2: float = 100.0, blocks: int = 2) -> Stretch:
    """Blocks that take a second as they are, of which that share is wanted."""
    return Stretch((1.0,) * blocks, (float(blocks),) * blocks, share, has_mm_s2)


def by_trying(made: Callable[[float], float], wanted_s: float, slack_s: float) -> float | None:
    """As the search is told: the middle of the longest run of factors that do; else between two."""
    late = [made(1.0 / factor) - wanted_s for factor in TRIED]
    rows = [list(row) for does, row in groupby(range(75), lambda at: abs(late[at]) <= slack_s) if does]
    if rows:
        widest = max(rows, key=len)
        return math.sqrt(TRIED[widest[0]] * TRIED[widest[-1]])
    crossing = next((at for at, (one, other) in enumerate(pairwise(late)) if one > 0.0 >= other), None)
    return None if crossing is None else between(crossing, made, wanted_s)


def between(at: int, made: Callable[[float], float], wanted_s: float) -> float:
    """The best of forty between two factors: the middle of those that miss the time by as little."""
    ratio = TRIED[at + 1] / TRIED[at]
    factors = [TRIED[at] * ratio ** (k / 39.0) for k in range(40)]
    off = [abs(made(1.0 / factor) - wanted_s) for factor in factors]
    best = [k for k, one in enumerate(off) if one <= min(off) + 1e-9]
    return factors[best[len(best) // 2]]


@pytest.mark.few(30)
@given(
    st.floats(0.06, 1.9),
    st.sampled_from([0.001, 0.016, 0.05, 0.11]),
    st.sampled_from([0.0, 0.49, 0.51, 1.2]),
    st.sampled_from([0.0, 0.02]),
)
def test_the_factor_is_the_one_that_trying_all_of_them_finds(
    wanted_s: float, step_s: float, slack_steps: float, more_s: float
) -> None:
    """Of a control that takes whole steps of time, for which several factors do, or none."""

    def made(time_s: float) -> float:
        return math.ceil(time_s / step_s - 1e-9) * step_s + more_s

    slack_s = max(slack_steps * step_s, 1e-7)
    (found,) = feed_factors([stretch(wanted_s)], 0.0, Control(made, slack_s, step_s))
    wanted = by_trying(made, wanted_s, slack_s)
    if wanted is None:
        assert isinstance(found, RefusalError)
    else:
        assert found == pytest.approx(wanted, rel=1e-9)


def bent(time_s: float) -> float:
    """Longer with more feed, between factors of 0.75 and 0.8, of 2.5 and 3."""
    return time_s + (0.2 if 1.25 < time_s < 1.34 or 0.33 < time_s < 0.4 else 0.0)


@pytest.mark.parametrize("wanted_s", [1.2, 1.3, 1.35, 1.5, 0.38, 0.35, 0.3])
@pytest.mark.parametrize("slack_s", [1e-7, 0.03])
def test_where_more_feed_takes_longer_the_longest_run_counts(wanted_s: float, slack_s: float) -> None:
    (found,) = feed_factors([stretch(wanted_s)], 0.0, Control(bent, slack_s, 0.5))
    assert found == pytest.approx(by_trying(bent, wanted_s, slack_s), rel=1e-9)


@pytest.mark.parametrize(
    ("wanted_s", "factor"),
    # At the ends of what is tried, on one of those that are, and off all of them.
    [(2.0, 0.5), (0.05, 20.0), (1.0 / TRIED[10], TRIED[10]), (1.0 / TRIED[37], TRIED[37]), (1.3, 1.0 / 1.3)],
)
def test_a_control_without_ramps_gets_the_feed_of_length_by_time(wanted_s: float, factor: float) -> None:
    (found,) = feed_factors([stretch(wanted_s)], 0.0, Control())
    # Between two that were tried 40 are: 0.13 % apart.
    assert found == pytest.approx(factor, rel=7e-4)


@pytest.mark.parametrize("period_s", [1e-4, 0.02, 0.1, 0.13, 10.0])
@pytest.mark.parametrize("slack_s", [1e-7, 0.0501])
def test_far_from_the_wanted_time_only_every_fifth_factor_is_tried(period_s: float, slack_s: float) -> None:
    """Far is more than three periods beyond what may be missed, on the same side at both ends of five."""
    late = [1.0 / factor - 1.01 for factor in TRIED]
    far = [abs(one) > slack_s + 3.0 * period_s for one in late]
    tried = 16
    for first, last in pairwise([*range(0, 74, 5), 74]):
        is_far = far[first] and far[last] and (late[first] > 0.0) == (late[last] > 0.0)
        tried += 0 if is_far else last - first - 1
    control = Control(slack_s=slack_s, period_s=period_s)
    feed_factors([stretch(1.01)], 0.0, control)
    more = 40 if min(map(abs, late)) > slack_s else 0
    assert control.tried == tried + more


@pytest.mark.parametrize(
    ("made", "least_ms"), [(lambda t: t + 1.0, 1050.0), (lambda t: 2.0 * t + 0.4, 500.0)]
)
def test_what_no_factor_does_is_refused_with_the_least_time(
    made: Callable[[float], float], least_ms: float
) -> None:
    some = Stretch((0.25, 0.5, 0.25), (1.0, 1.0, 1.0), 0.02, 100.0)
    (found,) = feed_factors([some], 0.0, Control(made))
    assert isinstance(found, RefusalError)
    assert (found.code, found.message) == (
        "VIB030",
        f"a stroke of 1 mm in 3 blocks takes {least_ms:.4g} ms at any feed, 20 ms are wanted",
    )
    assert found.help == "take one block per stroke (WAVE TRIANGLE), or a lower frequency"


def test_stretches_of_all_sizes_get_their_own_factor_and_are_asked_for_once() -> None:
    control = Control()
    some = [
        stretch(0.8),
        stretch(1.25, blocks=3),
        stretch(0.8),
        stretch(0.001),
        stretch(1.0, 50.0),
        stretch(0.5, blocks=3),
    ]
    found = feed_factors(some, 7.0, control)
    wanted = [by_trying(lambda t: t, share, 1e-7) for share in (0.8, 1.25, 0.8, 0.5, 0.5)]
    numbers = [one for one in found if isinstance(one, float)]
    assert numbers == pytest.approx(
        [*wanted[:3], by_trying(lambda t: 2.0 * t, 1.0, 1e-7), wanted[4]], rel=1e-9
    )
    assert isinstance(found[3], RefusalError)
    assert control.asked == [
        (2.0, 0.8, 100.0),
        (3.0, 1.25, 100.0),
        (2.0, 0.001, 100.0),
        (2.0, 1.0, 50.0),
        (3.0, 0.5, 100.0),
    ]
    assert control.before_mm_s == {7.0}
    # What was found is not looked for again, but it is with another feed before.
    tried = control.tried
    assert feed_factors(some, 7.0, control) == found
    assert control.tried == tried and len(control.asked) == 5
    feed_factors(some[:1], 8.0, control)
    assert control.tried > tried and len(control.asked) == 6


@pytest.fixture
def few_at_once(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(feed_search, "_ROWS_AT_ONCE", 80)
    return iter(())


@pytest.mark.usefixtures("few_at_once")
def test_many_stretches_are_worked_out_some_at_a_time() -> None:
    some = [stretch(0.1 + 0.05 * number, blocks=1 + number % 3) for number in range(20)]
    found = feed_factors(some, 0.0, Control())
    assert found == pytest.approx([by_trying(lambda t: t, one.wanted_s, 1e-7) for one in some], rel=1e-9)


@pytest.mark.parametrize(("most", "is_kept"), [(2, True), (1, False)])
def test_what_was_found_is_forgotten_when_it_becomes_too_much(
    monkeypatch: pytest.MonkeyPatch, most: int, is_kept: bool
) -> None:
    monkeypatch.setattr(feed_search, "_MOST_KNOWN", most)
    control = Control()
    feed_factors([stretch(0.8), stretch(0.9)], 0.0, control)
    tried = control.tried
    forget(control)
    feed_factors([stretch(0.8)], 0.0, control)
    assert (control.tried == tried) is is_kept


def test_single_blocks_of_one_kind_are_asked_for_once() -> None:
    control = Control()

    def feeds(*rows: tuple[float, float, float]) -> list[float]:
        return list(feeds_of_single_blocks(*np.array(rows).reshape(-1, 3).T, control))

    rows = [(1.0, 0.5, 100.0), (2.0, 0.5, 100.0), (1.0, 0.5, 100.0), (1.0, 0.5, 50.0)]
    assert feeds(*rows) == [2.0, 4.0, 2.0, 2.0]
    assert control.singles == [([1.0, 2.0, 1.0], [0.5, 0.5, 0.5], [100.0, 100.0, 50.0])]
    assert feeds(rows[1], (3.0, 0.5, 100.0)) == [4.0, 6.0]
    assert control.singles[1:] == [([3.0], [0.5], [100.0])]
    assert feeds(*rows) == [2.0, 4.0, 2.0, 2.0] and feeds() == []
    assert len(control.singles) == 2
