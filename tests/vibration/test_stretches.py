"""LinuxCNC's law for many stretches at once is that for one stretch, and so are the feeds found with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.feed_search import Stretch, feed_factors, feeds_of_single_blocks
from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.linuxcnc_many import linuxcnc_many
from chipbreak.trajectory.linuxcnc_planner import linuxcnc

MODEL = LinuxCnc(velocity_mm_s=100.0, acceleration_mm_s2=2000.0)

lengths = st.floats(0.0002, 0.06)
speeds = st.floats(1.0, 60.0)


@st.composite
def stretches(draw: st.DrawFn) -> tuple[list[list[float]], list[list[float]], list[float]]:
    """Lengths and speeds of some stretches of as many blocks each, and what the axes allow in each."""
    count, rows = draw(st.integers(1, 7)), draw(st.integers(1, 4))
    row_of = [st.lists(of, min_size=count, max_size=count) for of in (lengths, speeds)]
    ways, rates = (draw(st.lists(row, min_size=rows, max_size=rows)) for row in row_of)
    allowed = st.lists(st.sampled_from([500.0, 2000.0, 20000.0]), min_size=rows, max_size=rows)
    return ways, rates, draw(allowed)


@settings(deadline=None)
@given(stretches(), st.sampled_from([0.001, 0.0005, 0.002]), st.one_of(st.none(), speeds))
def test_many_stretches_run_like_one(
    drawn: tuple[list[list[float]], list[list[float]], list[float]], period: float, before: float | None
) -> None:
    ways, rates, allowed = drawn
    seen = None if before is None else np.full(len(ways), before)
    columns = np.array(ways), np.array(rates), np.array(allowed)
    times, places = linuxcnc_many(*columns, period, 0.01, before=seen)
    for row, (way, rate, has) in enumerate(zip(ways, rates, allowed, strict=True)):
        wanted = linuxcnc(tuple(way), tuple(rate), has, period, 0.01, before=before)
        assert times[row].tolist() == pytest.approx(wanted[0], abs=1e-8)
        assert places[row][~np.isnan(places[row])].tolist() == pytest.approx(wanted[1], abs=1e-7)


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(0.005, 0.3), st.integers(4, 60)), min_size=1, max_size=5))
def test_feeds_of_single_blocks_are_those_of_each(blocks: list[tuple[float, int]]) -> None:
    ways, times = np.array(blocks).T
    times = times * 0.001
    try:
        feeds = feeds_of_single_blocks(ways, times, np.full(len(ways), 2000.0), MODEL)
    except RefusalError as error:
        with pytest.raises(RefusalError) as alone:
            [MODEL.feed_for_time(*pair) for pair in zip(ways.tolist(), times.tolist(), strict=True)]
        assert (alone.value.code, alone.value.message) == (error.code, error.message)
        return
    pairs = zip(ways.tolist(), times.tolist(), strict=True)
    assert feeds.tolist() == pytest.approx([MODEL.feed_for_time(*pair) for pair in pairs], rel=1e-9)


@pytest.mark.parametrize("per_revolution", [False, True])
@pytest.mark.parametrize("before", [0.0, np.inf])
def test_the_factor_gives_the_wanted_time(per_revolution: bool, before: float) -> None:
    model = replace(MODEL, per_revolution=per_revolution)
    wave = 0.03 * (1.0 - np.cos(np.linspace(0.0, np.pi, 9))) + 0.0005 * np.arange(9)
    nominal = np.diff(wave) / 0.004
    several = [
        Stretch(tuple(np.diff(wave).tolist()), tuple(nominal.tolist()), wanted_s, 2000.0)
        for wanted_s in (0.028, 0.032, 0.036, 0.041)
    ]
    for stretch, factor in zip(several, feed_factors(several, before, model), strict=True):
        assert isinstance(factor, float)
        took = model.block_times(stretch.lengths_mm, nominal * factor, before_mm_s=before).sum()
        assert took == pytest.approx(stretch.wanted_s, abs=0.000501)
        # It stands in the middle of those that do.
        for near in (0.99, 1.01):
            took = model.block_times(stretch.lengths_mm, nominal * factor * near, before_mm_s=before).sum()
            assert took == pytest.approx(stretch.wanted_s, abs=0.001001)


def test_what_no_factor_does_is_a_refusal() -> None:
    hopping = Stretch((0.0004,) * 40, (0.1,) * 40, 0.02, 2000.0)
    (found,) = feed_factors([hopping], 0.0, MODEL)
    assert isinstance(found, RefusalError)
    assert found.code == "VIB030"
    with pytest.raises(RefusalError, match="needs"):
        feed_factors([hopping._replace(wanted_s=0.002)], 0.0, MODEL)
