"""LinuxCNC's law for many stretches at once is that for one stretch, and so are the feeds found with it."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import chipbreak.trajectory.linuxcnc_many as linuxcnc_many_module
from chipbreak.trajectory import linuxcnc_planner
from chipbreak.trajectory.junctions import Blocks, blocks_of
from chipbreak.trajectory.linuxcnc import LinuxCnc, interpolated
from chipbreak.trajectory.linuxcnc_feeds import Wanted, _factor_of_all, _halved, _one_factor, factors_for
from chipbreak.trajectory.linuxcnc_joints import bends_of
from chipbreak.trajectory.linuxcnc_many import Stretches, linuxcnc_many, times_of_many
from chipbreak.trajectory.linuxcnc_planner import NOTHING, Clock, Stretch, block_times, linuxcnc
from chipbreak.trajectory.linuxcnc_runs import counted
from chipbreak.trajectory.linuxcnc_strokes import middle_feeds, places_of

MODEL = LinuxCnc(velocity_mm_s=100.0, acceleration_mm_s2=2000.0)

# No whole number of periods: there the last digit says which period a block ends in.
lengths = st.floats(0.0002, 0.06).map(lambda length_mm: length_mm * 1.000_012_3)
speeds = st.floats(1.0, 60.0)
accelerations = st.sampled_from([500.0, 2000.0, 20000.0])
clocks = st.builds(
    Clock, st.sampled_from([0.001, 0.0005, 0.002]), st.just(0.01), st.sampled_from([1.0, 1.2, 2.0, inf])
)


@st.composite
def stretches(draw: st.DrawFn) -> Stretches:
    """Some stretches of as many blocks each."""
    count, rows = draw(st.integers(1, 7)), draw(st.integers(1, 4))
    row_of = [st.lists(of, min_size=count, max_size=count) for of in (lengths, speeds, accelerations)]
    columns = [np.array([draw(row) for _ in range(rows)]) for row in row_of]
    return Stretches(columns[0], columns[1], np.full((rows, count), 40.0), columns[2], np.zeros(rows))


@pytest.mark.few(20)
@settings(deadline=None)
@given(stretches(), clocks, st.sampled_from([0.0, inf]))
def test_many_stretches_run_like_one(drawn: Stretches, clock: Clock, before: float) -> None:
    drawn = drawn._replace(before=np.full(len(drawn.before), before))
    times, places = linuxcnc_many(drawn, clock)
    alone = times_of_many(drawn, clock, drawn.lengths.shape[1])
    for row in range(len(drawn.before)):
        one = Stretch(*(tuple(column[row].tolist()) for column in drawn[:4]), before)
        took, ways = linuxcnc(one, clock)
        assert block_times(one, clock) == took
        assert times[row].tolist() == pytest.approx(took, abs=1e-8)
        assert alone[row].tolist() == pytest.approx(took, abs=1e-8)
        assert places[row][~np.isnan(places[row])].tolist() == pytest.approx(ways, abs=1e-7)


@pytest.mark.parametrize("override", [inf, 1.0])
@pytest.mark.parametrize("length", [0.0002, 0.001, 0.005, 0.02])
def test_blocks_of_a_round_wave_run_like_many(override: float, length: float) -> None:
    """Blocks of a few periods each, which one by one are gone through in one loop, and many step by step."""
    rise = np.sin(np.linspace(0.1, np.pi - 0.1, 30))
    lengths = length * np.array([rise, rise**2, np.round(rise, 1) + 0.1])
    speeds = lengths / 0.0041
    drawn = Stretches(
        lengths, speeds, np.full_like(speeds, 100.0), np.full_like(speeds, 2000.0), np.zeros(3) + 0.5
    )
    clock = Clock(0.001, 0.01, override)
    many = times_of_many(drawn, clock, 30)
    for row in range(3):
        one = Stretch(*(tuple(column[row].tolist()) for column in drawn[:4]), 0.5)
        assert block_times(one, clock) == pytest.approx(many[row].tolist(), abs=1e-8)


@pytest.mark.parametrize("override", [inf, 1.0])
@pytest.mark.parametrize(
    ("ways", "feeds"),
    [
        ((0.00021, 0.0012), (0.00027, 0.0016)),
        ((0.00021, 0.001, 0.0013), (0.00027, 0.00067, 0.0016)),
        ((0.00317, 0.0007), (0.0016, 0.0003)),
    ],
)
def test_a_long_change_of_speed_is_gone_through_at_once(
    ways: tuple[float, ...], feeds: tuple[float, ...], override: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As if each of its thousand periods were gone through."""
    count = len(ways)
    stretch = Stretch(ways, feeds, (40.0,) * count, (2000.0,) * count, inf)
    clock = Clock(0.001, 0.01, override)
    rows = Stretches(*(np.array([column]) for column in stretch[:4]), np.array([inf]))
    linuxcnc.cache_clear()
    took, places = linuxcnc(stretch, clock)
    together = times_of_many(rows, clock, count)[0]
    for module in (linuxcnc_planner, linuxcnc_many_module):
        monkeypatch.setattr(module, "LONG_CHANGE", inf)
    linuxcnc.cache_clear()
    by_periods, every_place = linuxcnc(stretch, clock)
    linuxcnc.cache_clear()
    assert took == pytest.approx(by_periods, abs=1e-9)
    assert together.tolist() == pytest.approx(by_periods, abs=1e-9)
    assert len(places) == len(every_place) > 1000
    assert places.tolist() == pytest.approx(every_place.tolist(), abs=1e-12)


@settings(deadline=None)
@given(stretches(), clocks, st.one_of(st.just(0.0), speeds))
def test_of_the_block_before_one_of_three_speeds_stands_for_all(
    drawn: Stretches, clock: Clock, before: float
) -> None:
    rows = len(drawn.before)
    stands_for = counted(np.full(rows, before), drawn.lengths[:, 0], clock)
    assert set(stands_for) <= {0.0, NOTHING, inf}
    for row in range(rows):
        columns = [tuple(column[row].tolist()) for column in drawn[:4]]
        took = linuxcnc(Stretch(*columns, before), clock)[0]
        assert linuxcnc(Stretch(*columns, float(stands_for[row])), clock)[0] == pytest.approx(took, abs=1e-9)


@settings(deadline=None)
@given(st.floats(0.0002, 0.5), st.floats(0.1, 60.0), accelerations, clocks)
def test_a_single_block_needs_no_walk_through_its_periods(
    length: float, feed: float, acceleration: float, clock: Clock
) -> None:
    near = [feed * factor for factor in (0.9999, 1.0, 1.0001)]
    walked = [linuxcnc(Stretch((length,), (one,), (inf,), (acceleration,)), clock)[1] for one in near]
    if len({len(places) for places in walked}) > 1:
        return  # at the edge of a period rounding decides
    counts, places = places_of(np.array([length]), np.array([feed]), np.array([acceleration]), clock.period_s)
    assert counts.tolist() == [len(walked[1])]
    assert places.tolist() == pytest.approx(walked[1], abs=1e-7)


@pytest.mark.few(40)
@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(0.005, 0.3), st.integers(4, 60)), min_size=1, max_size=5))
def test_the_feeds_of_single_blocks_take_their_times(blocks: list[tuple[float, int]]) -> None:
    for length, periods in blocks:
        if periods * 0.001 < MODEL.shortest_time(length) - 1e-9:
            continue
        feed = middle_feeds(np.array([length]), np.array([periods * 0.001]), np.array([2000.0]), 0.001)
        assert MODEL.block_times([length], feed)[0] == pytest.approx(periods * 0.001, abs=1e-9)


def wanted_for(times_s: list[float], before: float) -> Wanted:
    wave = 0.03 * (1.0 - np.cos(np.linspace(0.0, np.pi, 9))) + 0.0005 * np.arange(9)
    rows = len(times_s)
    ways = np.tile(np.diff(wave), (rows, 1))
    kinds = Stretches(
        ways, ways / 0.004, np.full(ways.shape, 100.0), np.full(ways.shape, 2000.0), np.full(rows, before)
    )
    return Wanted(kinds, np.full(ways.shape, 0.004), 8, np.array(times_s))


@pytest.mark.parametrize("override", [1.0, 2.0, inf])
@pytest.mark.parametrize("before", [0.0, inf])
def test_the_factor_gives_the_wanted_time(override: float, before: float) -> None:
    clock = Clock(0.001, 0.01, override)
    wanted = wanted_for([0.028, 0.032, 0.036, 0.041], before)
    found = factors_for(wanted, [clock])
    assert not found.never.any()
    for near in (1.0, 0.99, 1.01):  # it stands in the middle of those that do
        rates = wanted.stretches.speeds * found.factors * near
        took = times_of_many(wanted.stretches._replace(speeds=rates), clock, 8).sum(axis=1)
        assert took == pytest.approx(wanted.time, abs=0.000501 if near == 1.0 else 0.001001)


def long_wanted(times_s: list[float], blocks: int = 60) -> Wanted:
    """A rise of so many blocks, which is wanted to take each of the times."""
    share = np.linspace(0.0, 1.0, blocks + 1)
    ways = np.tile(np.diff(0.2 * share + 0.1 * (1.0 - np.cos(np.pi * share))), (len(times_s), 1))
    rows = len(times_s)
    span_s = 0.004
    kinds = Stretches(
        ways, ways / span_s, np.full(ways.shape, 100.0), np.full(ways.shape, 2000.0), np.zeros(rows)
    )
    return Wanted(kinds, np.full(ways.shape, span_s), blocks, np.array(times_s))


@pytest.mark.parametrize("override", [1.0, 2.0, inf])
def test_one_factor_of_many_blocks_is_found_as_well_by_halving(override: float) -> None:
    clock = Clock(0.001, 0.01, override)
    wanted = long_wanted([0.22, 0.24, 0.25, 0.301, 0.4])
    factors, missed = _halved(wanted, [clock])
    assert np.abs(missed).tolist() == [0.0] * 5
    everyones, *_ = _factor_of_all(wanted, [clock])
    assert factors == pytest.approx(everyones, rel=0.02)
    rates = wanted.stretches._replace(speeds=wanted.stretches.speeds * factors[:, np.newaxis])
    took = times_of_many(rates, clock, 60).sum(axis=1)
    assert took == pytest.approx(wanted.time, abs=0.000501)


def test_what_no_factor_does_is_not_found_by_halving() -> None:
    """From rest to rest it takes 28 ms at least; twenty times as fast as wanted is the most that is tried."""
    factors, missed = _halved(long_wanted([0.01, 0.25, 20.0]), [Clock(0.001)])
    assert np.isnan(missed).tolist() == [True, False, True]
    assert factors[[0, 2]].tolist() == [1.0, 1.0]


def test_where_steps_of_the_feed_are_too_wide_the_nearest_is_taken() -> None:
    """Feeds in steps of 1 mm/s: with none of them does the stretch take 250 ms."""
    wanted = long_wanted([0.25])
    wide = wanted._replace(steps=np.full(wanted.spans.shape, 1.0))
    (factor,), (missed,) = _halved(wide, [Clock(0.001)])
    speeds = wide.typed_speeds(wide.stretches.speeds * factor)
    took = times_of_many(wide.stretches._replace(speeds=speeds), Clock(0.001), 60).sum()
    assert took - 0.25 == pytest.approx(missed, abs=1e-9)
    assert 0.0005 < abs(missed) < 0.05


def test_between_two_factors_that_do_may_be_some_that_do_not() -> None:
    """A larger factor may take a period more: 12 ms at 1.17 and 1.23, 11 ms at 1.2."""
    lengths = np.array([[0.0206, 0.0356, 0.0206]])
    columns = lengths / 0.004, np.full((1, 3), 160.0), np.full((1, 3), 8000.0)
    drawn = Stretches(lengths, *columns, np.full(1, NOTHING))
    clock = Clock(0.001, 0.01, inf)
    took = [
        times_of_many(drawn._replace(speeds=drawn.speeds * factor), clock, 3).sum()
        for factor in (1.17, 1.2, 1.23)
    ]
    assert took == pytest.approx([0.012, 0.011, 0.012])
    found = factors_for(Wanted(drawn, np.full((1, 3), 0.004), 3, np.array([0.012])), [clock])
    for share in (0.995, 1.0, 1.005):  # F is rounded
        times = times_of_many(drawn._replace(speeds=drawn.speeds * found.factors * share), clock, 3)
        assert times.sum() == pytest.approx(0.012)
    assert found.late.tolist() == [0.0]


def test_where_nobody_knows_the_override_the_worst_counts() -> None:
    clocks = [Clock(0.001, 0.01, override) for override in (1.0, 1.2, 1.5, 2.0)]
    wanted = wanted_for([0.036, 0.041], 0.0)
    found = factors_for(wanted, clocks)
    rates = wanted.stretches._replace(speeds=wanted.stretches.speeds * found.factors)
    late = np.array([times_of_many(rates, clock, 8).sum(axis=1) - wanted.time for clock in clocks])
    assert np.abs(late).max(axis=0) == pytest.approx(np.abs(found.late), abs=0.000501)


def test_own_factors_of_blocks_are_never_worse_than_one_for_all() -> None:
    """Of 200 stretches with a slow block between fast ones; and of many they are better."""
    draw = np.random.default_rng(5)
    ways = draw.uniform(0.02, 0.2, (200, 4))
    ways[:, 2] *= draw.uniform(0.1, 0.5, 200)
    kinds = Stretches(
        ways, ways * 250.0, np.full(ways.shape, 160.0), np.full(ways.shape, 8000.0), np.zeros(200)
    )
    clock = Clock(0.001, 0.01, inf)
    total_s = 0.016 + 0.001 * draw.integers(0, 4, 200)
    spans_s = np.repeat(total_s[:, np.newaxis] / 4.0, 4, axis=1)
    wanted = Wanted(kinds, spans_s, 4, total_s)

    def uneven_s(factors: NDArray[np.float64]) -> NDArray[np.float64]:
        times_s = times_of_many(kinds._replace(speeds=kinds.speeds * factors), clock, 4)
        return np.abs(np.cumsum(times_s, axis=1) - np.cumsum(spans_s, axis=1)).max(axis=1)

    one, _, never = _one_factor(wanted, [clock])
    own_s = uneven_s(factors_for(wanted, [clock]).factors)[~never]
    one_s = uneven_s(np.repeat(one[:, np.newaxis], 4, axis=1))[~never]
    assert (own_s <= one_s + 1e-9).all()
    assert np.count_nonzero(own_s < one_s - 1e-5) > 40


def test_what_no_factor_does_is_never() -> None:
    ways = np.full((1, 40), 0.0004)
    kinds = Stretches(ways, ways * 250.0, np.full((1, 40), 100.0), np.full((1, 40), 2000.0), np.zeros(1))
    found = factors_for(Wanted(kinds, np.full((1, 40), 0.0005), 40, np.array([0.02])), [Clock(0.001)])
    assert found.never.tolist() == [True]


def test_a_joint_that_does_not_turn_straight_back_costs_a_tenth_though_the_tool_rests() -> None:
    def left(degrees: float) -> tuple[list[bool], list[float]]:
        turn = np.radians(degrees)
        moved = np.array([[0.0, 0.0, 1.0], [np.sin(turn), 0.0, np.cos(turn)]])
        limits = np.array([5000.0, inf, 2000.0])
        bends = bends_of(blocks_along(moved), np.full(3, 100.0), limits, (100.0, 2000.0))
        joints = bends.joints(np.full(2, 10.0), 0.001, 1.0, every_block_stops=False)
        share = joints.acceleration_mm_s2 / bends.acceleration_mm_s2
        return joints.runs_on.tolist(), share.round(4).tolist()

    assert left(180.0) == ([False], [1.0, 1.0])
    assert left(178.5) == ([False], [1.0, 1.0])
    assert left(177.5) == ([False], [0.9, 0.9])
    assert left(90.0) == ([False], [0.9, 0.9])
    runs_on, share = left(0.1)
    assert runs_on == [True]
    # (10 / 0.001 + 2000) mm/s2 times the turn, in X as a part of 5000 mm/s2.
    assert share == pytest.approx([1.0 - 12000.0 * np.radians(0.1) / 5000.0] * 2, abs=1e-4)


def blocks_along(moved: np.ndarray) -> Blocks:
    return blocks_of(moved, np.ones(len(moved)), [inf, inf, inf])


def test_exact_stop_looks_at_no_joint() -> None:
    moved = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    bends = bends_of(blocks_along(moved), np.full(3, 100.0), np.full(3, 2000.0), (100.0, 2000.0))
    joints = bends.joints(np.full(2, 10.0), 0.001, 1.0, every_block_stops=True)
    assert joints.acceleration_mm_s2.tolist() == [2000.0, 2000.0]


def test_only_where_the_override_is_open_there_are_several_laws() -> None:
    assert [law.max_feed_override for law in MODEL.variants()] == [1.0, 1.2, 1.5, 2.0]
    assert replace(MODEL, max_feed_override=1.2).variants() == (replace(MODEL, max_feed_override=1.2),)
    assert len(replace(MODEL, per_revolution=True).variants()) == 1


@pytest.mark.parametrize("stops", [False, True])
def test_a_long_motion_is_worked_out_in_pieces(monkeypatch: pytest.MonkeyPatch, stops: bool) -> None:
    model = replace(MODEL, every_block_stops=stops)
    wave = np.concatenate([[0.0], np.cumsum(np.tile([0.4, 0.4, -0.3, -0.4], 20))])
    ahead = np.diff(wave)
    blocks = blocks_of(np.column_stack([0.0 * ahead, 0.0 * ahead, ahead]), ahead, [2000.0] * 3)
    feeds = np.tile([20.0, 25.0, 40.0, 31.0], 20)
    whole = model.motion_between_dwells(wave, blocks, feeds)
    peak_mm_s2 = whole.peak_acceleration_mm_s2
    assert whole.time_s[-1] > 1.0
    assert whole.distance_mm[[0, -1]].tolist() == [0.0, wave[-1]]
    for periods in (1, 7, 250):
        monkeypatch.setattr("chipbreak.trajectory.linuxcnc._PERIODS_AT_ONCE", periods)
        monkeypatch.setattr("chipbreak.trajectory.motion._KNOTS_AT_ONCE", periods)
        pieces = model.motion_between_dwells(wave, blocks, feeds)
        assert pieces.time_s.tolist() == whole.time_s.tolist()
        assert pieces.distance_mm.tolist() == whole.distance_mm.tolist()
        assert pieces.peak_acceleration_mm_s2 == peak_mm_s2
        assert pieces.fingerprint == whole.fingerprint
    monkeypatch.setattr("chipbreak.trajectory.linuxcnc_runs._AT_ONCE", 3)
    pieces = model.motion_between_dwells(wave, blocks, feeds)
    assert pieces.time_s.tolist() == whole.time_s.tolist()
    assert pieces.distance_mm.tolist() == pytest.approx(whole.distance_mm.tolist(), abs=1e-12)
    assert whole._replace(look_s=1.0).fingerprint != whole.fingerprint
    assert whole._replace(spans_s=whole.spans_s + 1e-12).fingerprint != whole.fingerprint


def test_a_first_block_from_a_stand_speeds_up_as_if_it_was_the_only_one() -> None:
    """LinuxCNC begins it in the period in which it hands it over, before it knows another one."""
    acceleration, period = 20000.0, 0.001
    blocks = Stretch((0.06, 0.07), (20.0, 20.0), (50.0, 50.0), (acceleration, acceleration))
    for override in (1.0, 1.2, 2.0, inf):
        clock = Clock(period, 0.01, override)
        _, places = linuxcnc(blocks, clock)
        assert places[0] == pytest.approx(acceleration * period**2 / 2.0)
    _, behind_another = linuxcnc(blocks._replace(before=20.0), Clock(period, 0.01, 1.0))
    # Evenly to 20 mm/s at the end of 0.06 mm: v dv/ds is the same all the way.
    assert behind_another[0] == pytest.approx(20.0**2 / (2.0 * 0.06) * period**2 / 2.0)


def test_a_first_block_that_has_come_far_before_the_next_one_is_known_ends_at_rest() -> None:
    """Feed per revolution is handed over as a command of its own: the second block comes two periods later.

    The blocks, feeds and places are those of a sine of 64 ms on the simulated machine, as sampled.
    """
    ways = (0.0152, 0.0155, 0.0163, 0.017)
    feeds = (0.12001, 0.12238, 0.1287, 0.13422)
    blocks = Stretch(ways, tuple(feed * 1875.0 / 60.0 for feed in feeds), (100.0,) * 4, (2000.0,) * 4)
    clock = Clock(0.001, 0.01, inf)
    _, places = linuxcnc(blocks, clock)
    seen = [
        0.000167,
        0.001313,
        0.004021,
        0.007625,
        0.011227,
        0.013919,
        0.015084,
        0.015549,
        0.016291,
        0.017504,
    ]
    assert interpolated(np.append([0.0, 0.0], places))[:10] == pytest.approx(seen, abs=6e-7)
    # A little longer, it has not come a quarter of its way after the two periods, and runs on.
    _, longer = linuxcnc(blocks._replace(lengths=(0.0157, *ways[1:])), clock)
    _, known = linuxcnc(blocks._replace(lengths=(0.0157, *ways[1:]), before=NOTHING), clock)
    assert longer.tolist() == known.tolist()


@pytest.mark.parametrize(
    ("way", "per_revolution", "stands"),
    [(0.06, False, True), (0.2, False, False), (0.06, True, True), (0.2, True, False)],
)
def test_a_tool_must_stand_where_a_first_block_would_run_otherwise_behind_a_rapid(
    way: float, per_revolution: bool, stands: bool
) -> None:
    ahead = np.array([way, 0.07, -0.06])
    blocks = blocks_of(np.column_stack([ahead, 0.0 * ahead, 0.0 * ahead]), ahead, [20000.0] * 3)
    model = LinuxCnc(velocity_mm_s=50.0, acceleration_mm_s2=20000.0, per_revolution=per_revolution)
    feeds = np.full(3, 20.0)
    assert model.must_stand_before(blocks, feeds) == stands
    assert not replace(model, every_block_stops=True).must_stand_before(blocks, feeds)


def test_blocks_that_are_too_slow_get_the_lowest_feed_and_others_their_time() -> None:
    least = 0.1 * 25.4 / 60.0
    model = replace(MODEL, least_feed_mm_s=least)
    ahead = np.array([0.014224, 0.001016, 0.02717, -0.0008, 0.03, -0.02])
    blocks = blocks_of(np.column_stack([0.0 * ahead, 0.0 * ahead, ahead]), ahead, [2000.0] * 3)
    spans = np.full(6, 0.1)
    feeds = model.feeds_for_spans(blocks, spans, 6)
    assert feeds.min() == least
    # The slowest ones take as long as their way at the lowest feed; what they lack the others have.
    took = model.block_times(ahead, feeds)
    assert took.sum() == pytest.approx(0.6)
    assert took[:3].sum() == pytest.approx(0.3)
    assert took[3] == pytest.approx(0.0008 / least, abs=0.0015)
    assert took[3:5].sum() == pytest.approx(0.2)
    # As on the machine: 24 ms for 0.001016 mm, whatever F asks for.
    assert model.block_times([0.001016], [0.0102])[0] == pytest.approx(0.024, abs=0.0011)
    assert MODEL.block_times([0.001016], [0.0102])[0] > 0.099
