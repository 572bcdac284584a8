"""What LinuxCNC's law is made of, one function after the other, by hand and against plain loops."""

from __future__ import annotations

from itertools import pairwise
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory import linuxcnc, linuxcnc_feeds, linuxcnc_fit
from chipbreak.trajectory.junctions import Blocks, blocks_of
from chipbreak.trajectory.law import AxisLimits
from chipbreak.trajectory.linuxcnc import LinuxCnc, _bent_knots, interpolated
from chipbreak.trajectory.linuxcnc_feeds import (
    _TRIED,
    Found,
    Wanted,
    _between,
    _late_of_all,
    _longest_run,
    _swings,
    _unevenness,
    factors_for,
)
from chipbreak.trajectory.linuxcnc_fit import (
    Asked,
    _Fit,
    _least_periods,
    _no_factor,
    _parts_as_blocks,
    _shared_out,
    _times_of_parts,
    three_digits,
)
from chipbreak.trajectory.linuxcnc_joints import Bends, Joints, bends_of
from chipbreak.trajectory.linuxcnc_many import Stretches, passing_speeds, times_of_many
from chipbreak.trajectory.linuxcnc_planner import NOTHING, Clock, Stretch, runs_alike
from chipbreak.trajectory.linuxcnc_planner import linuxcnc as walk
from chipbreak.trajectory.linuxcnc_runs import (
    Columns,
    Parts,
    Runs,
    counted,
    parts_of,
    run_all,
    starts_alike,
    times_by_clock,
)
from chipbreak.trajectory.linuxcnc_strokes import middle_feeds, places_of, profile_of, speeds_for_times

CLOCK = Clock(0.001, 0.01, 1.0)


# --- joints -----------------------------------------------------------------------------------------------


def bends(
    *moved: tuple[float, float, float], limits: tuple[float, float, float] = (500.0, inf, 1000.0)
) -> Bends:
    every = np.array(moved)
    blocks = blocks_of(every, np.ones(len(every)), [inf] * 3)
    return bends_of(blocks, np.array([50.0, inf, 100.0]), np.array(limits), (70.0, 700.0))


def test_what_of_joints_does_not_depend_on_feeds() -> None:
    found = bends((0.0, 0.0, 2.0), (0.0, 0.0, 1.0), (3.0, 0.0, 4.0), (-3.0, 0.0, -4.0), (0.0, 0.0, 5.0))
    assert found.lengths_mm.tolist() == [2.0, 1.0, 5.0, 5.0, 5.0]
    assert found.velocity_mm_s.tolist() == pytest.approx([100.0, 100.0, 50.0 / 0.6, 50.0 / 0.6, 100.0])
    assert found.acceleration_mm_s2.tolist() == pytest.approx(
        [1000.0, 1000.0, 500.0 / 0.6, 500.0 / 0.6, 1000.0]
    )
    assert found.turns_back.tolist() == [False, False, True, False]
    # The most of X turning by 0.6 / 500 and Z by 0.2 / 1000; back again by twice its way.
    assert found.bend_s2_mm.tolist() == pytest.approx([0.0, 0.6 / 500.0, 1.2 / 500.0, 1.8 / 1000.0])
    for run in (slice(1, 4), np.array([1, 2, 3])):
        part = found.part(run)
        assert part.lengths_mm.tolist() == [1.0, 5.0, 5.0]
        assert part.velocity_mm_s.tolist() == found.velocity_mm_s[1:4].tolist()
        assert part.acceleration_mm_s2.tolist() == found.acceleration_mm_s2[1:4].tolist()
        assert part.turns_back.tolist() == [False, True]
        assert part.bend_s2_mm.tolist() == found.bend_s2_mm[1:3].tolist()


def test_a_path_whose_axes_have_no_limits_has_its_own() -> None:
    free = bends((0.0, 2.0, 0.0), (0.0, 0.0, 1.0))
    assert free.velocity_mm_s.tolist() == [70.0, 100.0]
    assert free.acceleration_mm_s2.tolist() == [700.0, 1000.0]
    assert bends((0.0, 0.0, 1.0)).turns_back.tolist() == []


@pytest.mark.parametrize(("degrees", "turns"), [(180.0, True), (178.1, True), (177.9, False), (182.1, False)])
def test_within_two_degrees_the_tool_turns_back(degrees: float, turns: bool) -> None:
    turn = np.radians(degrees)
    assert bends((0.0, 0.0, 1.0), (float(np.sin(turn)), 0.0, float(np.cos(turn)))).turns_back.tolist() == [
        turns
    ]


def simple(*bend: float, back: tuple[int, ...] = ()) -> Bends:
    """Blocks of 1 mm at 100 mm/s and 1000 mm/s2 at most."""
    count = len(bend) + 1
    turns = np.array([at in back for at in range(len(bend))], np.bool_)
    return Bends(np.ones(count), np.full(count, 100.0), np.full(count, 1000.0), turns, np.array(bend))


@pytest.mark.parametrize(
    ("feeds", "override", "slower"),
    [
        ([10.0, 20.0], 1.0, 10.0),
        ([20.0, 10.0], 1.5, 15.0),
        ([60.0, 80.0], 2.0, 100.0),
        ([300.0, 80.0], 1.2, 96.0),
        ([1.0, 1.0], inf, 100.0),
    ],
)
def test_what_a_bend_costs(feeds: list[float], override: float, slower: float) -> None:
    """(v / T + a) times the turn, where v is the lower speed that the two may ever have."""
    turn = 0.05 / (slower / 0.001 + 1000.0)
    joints = simple(turn).joints(np.array(feeds), 0.001, override, every_block_stops=False)
    assert joints.runs_on.tolist() == [True]
    assert joints.acceleration_mm_s2.tolist() == pytest.approx([950.0, 950.0])
    sharp = simple(2.01 * turn).joints(np.array(feeds), 0.001, override, every_block_stops=False)
    assert (sharp.runs_on.tolist(), sharp.acceleration_mm_s2.tolist()) == ([False], [900.0, 900.0])
    # A block that takes less than a period is no faster than its length in one.
    short = simple(turn).joints(np.array(feeds), 0.1, override, every_block_stops=False)
    assert short.acceleration_mm_s2.tolist() == pytest.approx(
        [1000.0 * (1.0 - turn * (min(slower, 10.0) / 0.1 + 1000.0))] * 2
    )


def test_a_block_loses_what_the_dearer_of_its_two_joints_costs() -> None:
    rate = 10.0 / 0.001 + 1000.0
    joints = simple(0.02 / rate, 0.05 / rate, 0.3 / rate, 0.0, back=(2,)).joints(
        np.full(5, 10.0), 0.001, 1.0, every_block_stops=False
    )
    assert joints.runs_on.tolist() == [True, True, False, True]
    assert joints.acceleration_mm_s2.tolist() == pytest.approx([980.0, 950.0, 950.0, 1000.0, 1000.0])
    stops = simple(0.02, 0.5).joints(np.full(3, 10.0), 0.001, 1.0, every_block_stops=True)
    assert (stops.runs_on.tolist(), stops.acceleration_mm_s2.tolist()) == ([False, False], [1000.0] * 3)


# --- runs -------------------------------------------------------------------------------------------------


def test_parts_between_joints_that_are_rests() -> None:
    parts = parts_of(np.array([True, False, False, True, True]))
    assert (parts.starts.tolist(), parts.stops.tolist(), parts.sizes.tolist()) == (
        [0, 2, 3],
        [2, 3, 6],
        [2, 1, 3],
    )
    assert parts.of_size(1).tolist() == [1]
    assert parts.blocks_of(np.array([0, 2]), 2).tolist() == [[0, 1], [3, 4]]
    assert parts_of(np.empty(0, np.bool_)).stops.tolist() == [1]


@pytest.mark.parametrize(
    ("before", "length", "override", "stands_for"),
    [
        (0.0, 0.06, 1.0, 0.0),
        (5.0, 0.06, 1.0, inf),
        (0.0, 0.06, inf, 0.0),
        (12.1, 0.06, inf, inf),  # 2 x 0.06 mm within 10 ms
        (11.9, 0.06, inf, NOTHING),
    ],
)
def test_what_counts_of_the_block_before(
    before: float, length: float, override: float, stands_for: float
) -> None:
    assert counted(np.array([before]), np.array([length]), Clock(0.001, 0.01, override)).tolist() == [
        stands_for
    ]


def test_columns_of_some_parts() -> None:
    columns = Columns(
        np.arange(1.0, 6.0), np.arange(11.0, 16.0), np.arange(21.0, 26.0), np.arange(31.0, 36.0)
    )
    some = columns.stretches(np.array([[0, 1], [3, 4]]), CLOCK)
    rows = [[one[0].tolist(), one[1].tolist()] for one in some[:4]]
    assert rows == [
        [[ten + at for at in pair] for pair in ((1.0, 2.0), (4.0, 5.0))] for ten in (0.0, 10.0, 20.0, 30.0)
    ]
    assert some.before.tolist() == [0.0, inf]
    assert columns.stretches(np.array([[0, 1]]), CLOCK, 3.0).before.tolist() == [inf]
    assert some.rows(np.array([1])).speeds.tolist() == [[14.0, 15.0]]
    assert some.at_least(12.5).speeds.tolist() == [[12.5, 12.5], [14.0, 15.0]]
    assert some.at_least(0.0) is some


def test_ways_of_parts_in_a_row_and_in_pieces() -> None:
    """Two kinds of ways, of 2 and 3 periods; parts are of kinds 0, 1, 1, 0."""
    runs = Runs(
        np.ones(4), np.array([2, 3, 3, 2]), np.array([0, 2, 2, 0]), np.array([0.1, 0.2, 1.0, 2.0, 3.0])
    )
    assert runs.places(0, 4).tolist() == [0.1, 0.2, 1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 0.1, 0.2]
    assert runs.places(1, 3).tolist() == [1.0, 2.0, 3.0, 1.0, 2.0, 3.0]
    assert runs.places(3, 4).tolist() == [0.1, 0.2]
    for periods in range(1, 12):
        pieces = runs.pieces(periods)
        assert [first for first, _ in pieces] == [0, *(last for _, last in pieces[:-1])]
        assert pieces[-1][1] == 4
    assert runs.pieces(100) == [(0, 4)]
    assert runs.pieces(1) == [(0, 1), (1, 2), (2, 3), (3, 4)]


@pytest.mark.parametrize("override", [1.0, inf])
@pytest.mark.parametrize("before", [0.0, 30.0])
def test_every_part_runs_as_it_does_alone(override: float, before: float) -> None:
    """Parts of one, two and three blocks, two of them alike, one of which stands behind another feed."""
    clock = Clock(0.001, 0.01, override)
    lengths = np.array([0.06, 0.07, 0.05, 0.06, 0.07, 0.3, 0.06, 0.05, 0.04, 0.05])
    speeds = np.array([20.0, 25.0, 9.0, 20.0, 25.0, 60.0, 20.0, 22.0, 24.0, 9.0])
    columns = Columns(lengths, speeds, np.full(10, 50.0), np.full(10, 8000.0))
    parts = parts_of(np.array([True, False, False, True, False, False, True, True, False]))
    runs = run_all(columns, parts, clock, before)
    for at, (first, stop) in enumerate(zip(parts.starts.tolist(), parts.stops.tolist(), strict=True)):
        own = tuple(tuple(column[first:stop].tolist()) for column in columns)
        times, places = walk(Stretch(*own, before=float(speeds[first - 1]) if first else before), clock)
        assert runs.times[first:stop].tolist() == pytest.approx(list(times), abs=1e-9)
        assert runs.places(at, at + 1).tolist() == pytest.approx(places.tolist(), abs=1e-9)
        assert runs.counts[at] == len(places)


@pytest.mark.parametrize("rows", [3, 70])
@pytest.mark.parametrize("least", [0.0, 5.0])
def test_times_by_several_clocks_are_those_of_each(rows: int, least: float) -> None:
    draw = np.random.default_rng(3)
    lengths = draw.uniform(0.01, 0.06, (rows, 3))
    some = Stretches(
        lengths,
        draw.uniform(2.0, 30.0, (rows, 3)),
        np.full((rows, 3), 40.0),
        np.full((rows, 3), 5000.0),
        np.zeros(rows),
    )
    clocks = [Clock(0.001, 0.01, override, least) for override in (1.0, 1.2, 2.0)]
    found = times_by_clock(some, clocks, 2)
    slowest = some._replace(speeds=np.maximum(some.speeds, least))
    for clock, times in zip(clocks, found, strict=True):
        assert times.tolist() == [pytest.approx(row) for row in times_of_many(slowest, clock, 2).tolist()]
    assert rows == 3 or least or not np.allclose(found[0], found[2])
    assert len(times_by_clock(some, clocks[:1], 3)) == 1


def test_how_fast_blocks_may_be_at_their_ends() -> None:
    """No faster than what is left can brake, than the next one, and than its own length in a period."""
    some = Stretches(
        *(np.array([row]) for row in ([0.06, 0.05, 0.02], [30.0, 20.0, 25.0], [40.0] * 3, [5000.0] * 3)),
        np.zeros(1),
    )
    brakes = sqrt(2.0 * 5000.0 * 0.02)
    assert passing_speeds(some, CLOCK)[0].tolist() == pytest.approx([20.0, brakes, 0.0])
    cap = 0.02 / 0.00102
    assert brakes < cap
    faster = passing_speeds(some._replace(accelerations=np.full((1, 3), 1e5)), Clock(0.001, 0.01, 1.2))[0]
    # 1.2 x 20 mm/s; the last one takes a little more than a period at least.
    assert cap < 20.0
    assert faster.tolist() == pytest.approx([24.0, cap, 0.0])


def test_a_first_part_that_runs_the_same_behind_a_stand() -> None:
    columns = Columns(np.array([0.2, 0.07]), np.full(2, 20.0), np.full(2, 50.0), np.full(2, 20000.0))
    parts = parts_of(np.array([True]))
    assert starts_alike(columns, parts, CLOCK)
    assert not starts_alike(columns._replace(lengths=np.array([0.06, 0.07])), parts, CLOCK)
    stretch = Stretch((0.2, 0.07), (20.0, 20.0), (50.0, 50.0), (20000.0, 20000.0))
    assert runs_alike(stretch, CLOCK) and not runs_alike(stretch._replace(lengths=(0.06, 0.07)), CLOCK)


# --- single blocks ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("length", "feed", "wanted"),
    [
        # 1 mm/s a period: 3 up (4.5 µm), 7 even (21), one down to 2 (2.5), 2 down (2).
        (0.030, 3.0, (3, 0, 7, 2.0, 2)),
        # The feed lies between: 3 up, a partial one to 3.5 mm/s.
        (0.030, 3.5, (3, 1, None, None, None)),
        # Too short for its feed.
        (0.009, 50.0, (3, 0, 0, 2.0, 2)),
        (0.0005, 50.0, (0, 1, 0, 0.0, 0)),
    ],
)
def test_a_single_block_period_by_period(length: float, feed: float, wanted: tuple[Any, ...]) -> None:
    profile = profile_of(np.array([length]), np.array([feed]), np.array([1000.0]), 0.001)
    told = [column.tolist()[0] for column in profile]
    for one, known in zip(told, wanted, strict=True):
        assert known is None or one == pytest.approx(known, abs=1e-6)
    counts, places = places_of(np.array([length]), np.array([feed]), np.array([1000.0]), 0.001)
    assert counts.tolist() == profile.periods.tolist() == [len(places)]
    assert places[-1] == length and (np.diff(places, prepend=0.0) >= 0.0).all()
    took, walked = walk(Stretch((length,), (feed,), (inf,), (1000.0,)), CLOCK)
    assert walked.tolist() == pytest.approx(places.tolist(), abs=1e-9) and sum(took) == pytest.approx(
        counts[0] * 0.001
    )


def test_places_of_several_blocks_stand_in_one_line() -> None:
    lengths, feeds, has = (
        np.array([0.03, 0.009, 0.05]),
        np.array([3.0, 50.0, 4.0]),
        np.array([1000.0, 1000.0, 500.0]),
    )
    counts, places = places_of(lengths, feeds, has, 0.001)
    alone = [places_of(*(column[at : at + 1] for column in (lengths, feeds, has)), 0.001) for at in range(3)]
    assert counts.tolist() == [int(one[0]) for one, _ in alone]
    assert places.tolist() == pytest.approx(np.concatenate([one for _, one in alone]).tolist(), abs=1e-15)


@pytest.mark.parametrize(("length", "has"), [(0.05, 2000.0), (0.11, 5000.0), (0.02, 20000.0), (0.31, 500.0)])
def test_the_feed_found_stands_in_the_middle_of_those_that_take_the_time(length: float, has: float) -> None:
    """By time: of all trapezoids, tried one by one, that take so many periods."""
    least = 2.0 * sqrt(length / has)
    tried_s = np.linspace(least, 0.06, 6000)
    every = (
        np.full(len(tried_s), length),
        speeds_for_times(np.full(len(tried_s), length), tried_s, np.full(len(tried_s), has)),
    )
    took = profile_of(*every, np.full(len(tried_s), has), 0.001).periods
    for periods in sorted(set(took.tolist()))[1:-1:3]:
        does = tried_s[took == periods]
        feed = middle_feeds(np.array([length]), np.array([periods * 0.001]), np.array([has]), 0.001)[0]
        middle_s = length / feed + feed / has
        # Where a longer trapezoid takes fewer periods than a shorter one, the longest one ends the search.
        assert does.min() - 1e-5 <= middle_s <= does.max() + 1e-5
        assert middle_s == pytest.approx((does.min() + does.max()) / 2.0, abs=2.5e-4)


# --- feeds of several blocks ------------------------------------------------------------------------------


def test_the_longest_run_of_numbers_that_follow_each_other() -> None:
    assert _longest_run(np.array([1, 2, 5, 6, 7, 9])).tolist() == [5, 6, 7]
    assert _longest_run(np.array([4])).tolist() == [4]
    assert _longest_run(np.array([1, 2, 4, 5])).tolist() == [1, 2]


def ends(*late: float) -> tuple[int, int]:
    """Between which of the factors that were tried; behind those that are told all are far too fast."""
    misses = np.array([*late, *[-9.0] * (75 - len(late))])
    return tuple(_TRIED.tolist().index(one) for one in _between(misses, 0.5))  # type: ignore[return-value]


def test_between_which_factors_the_right_one_lies() -> None:
    assert ends(3.0, 2.0, 0.4, -0.5, -0.6, 0.1) == (2, 3)
    assert ends(3.0, 0.4, -0.6, 0.1, 0.5, -0.5) == (3, 5)
    assert ends(3.0, 2.0, -2.0) == (1, 2)
    assert ends(3.0, 2.0, 2.5, -2.0, 2.0, -2.0) == (2, 3)
    assert ends(-2.0) == (0, 1)
    assert ends(-0.5) == (0, 0)
    late = np.full(75, 9.0)
    late[74] = 7.0
    assert _between(late, 0.5) == (_TRIED[74], _TRIED[74])
    late[74] = 0.0
    assert _between(late, 0.5) == (_TRIED[74], _TRIED[74])
    assert (_TRIED[0], _TRIED[74], len(_TRIED)) == (0.5, 20.0, 75)


def wanted_for(times_s: list[float], blocks: int = 4) -> Wanted:
    lengths = np.tile(np.linspace(0.012, 0.02, blocks), (len(times_s), 1))
    kinds = Stretches(
        lengths,
        lengths / 0.004,
        np.full(lengths.shape, 100.0),
        np.full(lengths.shape, 2000.0),
        np.zeros(len(times_s)),
    )
    return Wanted(kinds, np.full(lengths.shape, 0.004), blocks - 1, np.array(times_s))


def late_of_each(wanted: Wanted, clocks: list[Clock]) -> Floats:
    """How much too long each stretch takes with each factor; of several clocks the worst."""
    late = []
    for at, time_s in enumerate(wanted.time.tolist()):
        every = wanted.stretches.rows(np.full(75, at))
        every.speeds[:, : wanted.fitted] *= _TRIED[:, np.newaxis]
        own = np.array([times_of_many(every, clock, wanted.fitted).sum(axis=1) - time_s for clock in clocks])
        late.append([max(column, key=abs) for column in own.T.tolist()])
    return np.array(late)


@pytest.mark.parametrize("overrides", [(1.0,), (1.0, 2.0)])
def test_factors_that_are_not_tried_are_far_off(overrides: tuple[float, ...]) -> None:
    clocks = [Clock(0.001, 0.01, override) for override in overrides]
    wanted = wanted_for([0.0125, 0.02, 0.0043])
    exact = late_of_each(wanted, clocks)
    found = _late_of_all(wanted, clocks)
    near = np.abs(exact) <= 0.0025
    assert found[near].tolist() == pytest.approx(exact[near].tolist(), abs=1e-12)
    assert (np.sign(found[~near]) == np.sign(exact[~near])).all()
    assert found[:, ::5].tolist() == [pytest.approx(row, abs=1e-12) for row in exact[:, ::5].tolist()]
    assert [_between(row, 0.0005) for row in found] == [_between(row, 0.0005) for row in exact]


@pytest.mark.parametrize(
    ("speeds", "swings"),
    [
        ([10.0, 6.9, 10.0], True),
        ([10.0, 7.1, 10.0], False),
        ([10.0, 6.9, 9.8], False),
        ([10.0, 5.0, 5.0], False),
        ([5.0, 10.0, 5.0], False),
        ([10.0, 8.0, 6.0, 8.0, 10.0], True),
        ([10.0, 4.0, 6.0, 4.0, 1.0], True),
        ([9.0, 5.0, 10.0], True),
    ],
)
def test_which_stretches_get_much_slower_and_faster_again(speeds: list[float], swings: bool) -> None:
    row = np.array([speeds])
    kinds = Stretches(row, row, row, row, np.zeros(1))
    assert _swings(Wanted(kinds, row, len(speeds), np.ones(1))).tolist() == [swings]


@pytest.mark.parametrize(("fitted", "is_shaped"), [(24, True), (25, False)])
def test_strokes_of_many_blocks_are_round_waves_that_slow_down_by_themselves(
    monkeypatch: pytest.MonkeyPatch, fitted: int, is_shaped: bool
) -> None:
    """Others are looked at for swings, whose blocks get factors of their own."""
    looked: list[int] = []

    def looking(wanted: Wanted) -> Any:
        looked.append(wanted.fitted)
        return _swings(wanted)

    monkeypatch.setattr(linuxcnc_feeds, "_swings", looking)
    factors_for(wanted_for([0.12], fitted + 1), [CLOCK])
    assert looked == ([fitted] if is_shaped else [])


def test_by_how_much_the_ends_of_blocks_miss_their_times() -> None:
    wanted = wanted_for([0.012, 0.012])
    clocks = [Clock(0.001, 0.01, 1.0), Clock(0.001, 0.01, 2.0)]
    missed = []
    for clock in clocks:
        times = times_of_many(wanted.stretches, clock, 3)
        missed.append(np.abs(np.cumsum(times, axis=1) - np.array([0.004, 0.008, 0.012])).max(axis=1))
    assert _unevenness(wanted, wanted.stretches.speeds, clocks).tolist() == pytest.approx(
        np.max(missed, axis=0).tolist()
    )
    assert _unevenness(wanted, wanted.stretches.speeds, clocks[1:]).tolist() == pytest.approx(
        missed[1].tolist()
    )


# --- times of parts ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wanted", "ways", "least", "given", "owed"),
    [
        (10.0, [1.0], [20.0], [10.0], 0.0),
        # 4 to spare, by length: 3 and 1.
        (14.0, [3.0, 1.0], [6.0, 4.0], [9.0, 5.0], 0.0),
        # What does not come out even the longest one gets.
        (15.0, [1.0, 3.0], [4.0, 6.0], [5.0, 10.0], 0.0),
        (17.0, [2.0, 2.0, 1.0], [4.0, 4.0, 3.0], [7.0, 6.0, 4.0], 0.0),
        # What it lacks the next stroke makes up for, a period of it.
        (10.0, [1.0, 1.0], [5.0, 5.0], [5.0, 5.0], 0.0),
        (9.0, [1.0, 1.0], [5.0, 5.0], [5.0, 5.0], 1.0),
        (7.0, [1.0, 1.0], [5.0, 5.0], [5.0, 5.0], 1.0),
    ],
)
def test_how_a_stroke_is_shared_out(
    wanted: float, ways: list[float], least: list[float], given: list[float], owed: float
) -> None:
    found, lacks = _shared_out(wanted, ways, least)
    assert (found, lacks) == (given, owed)


def columns_of(lengths: Floats, has: float = 2000.0) -> Columns:
    return Columns(lengths, lengths / 0.004, np.full(len(lengths), 100.0), np.full(len(lengths), has))


def test_times_of_parts_are_whole_periods_and_what_one_stroke_loses_the_next_one_gets() -> None:
    lengths = np.full(8, 0.02)
    asked = Asked(simple(*[0.0] * 7), np.full(8, 0.0103), np.array([2, 4, 6]), 8, stops=False)
    parts = Parts(np.array([0, 2, 3, 4, 6]), np.array([2, 3, 4, 6, 8]))
    # Each stroke of two should take 20.6 ms; the second one rests between its blocks.
    times = _times_of_parts(asked, columns_of(lengths), parts, 0.001)
    assert times.tolist() == pytest.approx([0.021, 0.010, 0.010, 0.021, 0.020])
    # Up to the blocks that keep their feeds.
    some = Parts(parts.starts[:4], parts.stops[:4])
    cut = _times_of_parts(asked._replace(plain_from=5), columns_of(lengths), some, 0.001)
    assert cut.tolist() == pytest.approx([0.021, 0.010, 0.010, 0.011])
    # Two blocks of 20 µm at 2000 mm/s2 need 7 periods each, which is late by one of 13.
    quick = asked._replace(spans=np.full(8, 0.0065))
    assert _least_periods(np.array([0.02]), np.array([2000.0]), 0.001).tolist() == [7.0]
    hurried = _times_of_parts(quick, columns_of(lengths), parts, 0.001)
    assert hurried.tolist() == pytest.approx([0.013, 0.007, 0.007, 0.012, 0.013])


def test_parts_as_blocks() -> None:
    columns = Columns(np.arange(1.0, 7.0), np.ones(6), np.ones(6), np.array([9.0, 8.0, 7.0, 6.0, 7.0, 1.0]))
    ways, has = _parts_as_blocks(columns, Parts(np.array([0, 2, 3]), np.array([2, 3, 5])))
    assert (ways.tolist(), has.tolist()) == ([3.0, 3.0, 9.0], [8.0, 7.0, 6.0])


def test_no_part_takes_longer_than_at_the_lowest_feed() -> None:
    """10 µm at 1 mm/s take about 10 ms; what is more the next one gets, what that cannot the one behind."""
    lengths = np.array([0.01, 0.01, 0.05, 0.05])
    clocks = [Clock(0.001, 0.01, 1.0, 1.0)]
    bends_ = Bends(lengths, np.full(4, 100.0), np.full(4, 2000.0), np.ones(3, np.bool_), np.zeros(3))
    asked = Asked(bends_, np.full(4, 0.03), np.array([1, 2, 3]), 4, stops=False)
    joints = Joints(np.zeros(3, np.bool_), np.full(4, 2000.0))
    fit = _Fit.of(asked, joints, clocks, None)  # type: ignore[arg-type]
    longest = profile_of(lengths, np.ones(4), np.full(4, 2000.0), 0.001).periods * 0.001
    assert longest[0] < 0.03 < longest[2]
    times = fit._in_time(np.array([0.03, 0.02, 0.03, 0.03]))
    over = 0.03 - longest[0]
    assert times[:2].tolist() == pytest.approx([longest[0], longest[1]])
    third = 0.03 + over + 0.02 - longest[1]
    assert times[2:].tolist() == pytest.approx([min(third, longest[2]), 0.03 + max(third - longest[2], 0.0)])
    assert times.sum() == pytest.approx(0.11)
    # Without a lowest feed nothing changes.
    free = _Fit.of(asked, joints, [CLOCK], None)  # type: ignore[arg-type]
    assert free._in_time(np.array([9.0, 0.02, 0.03, 0.03])).tolist() == [9.0, 0.02, 0.03, 0.03]
    # The last one has none behind it: it takes what is left.
    assert fit._in_time(np.array([0.01, 0.01, 0.03, 9.0]))[3] == 9.0


@pytest.mark.parametrize(("share", "keeps"), [(0.5, False), (0.995, True), (1.0, True)])
def test_whether_other_joints_change_the_times(share: float, keeps: bool) -> None:
    lengths = np.full(4, 0.05)
    bends_ = Bends(lengths, np.full(4, 100.0), np.full(4, 2000.0), np.ones(3, np.bool_), np.zeros(3))
    asked = Asked(bends_, np.full(4, 0.02), np.array([1, 2, 3]), 4, stops=False)
    fit = _Fit.of(asked, Joints(np.zeros(3, np.bool_), np.full(4, 2000.0)), [CLOCK], None)  # type: ignore[arg-type]
    feeds = middle_feeds(lengths, np.full(4, 0.02), np.full(4, 2000.0), 0.001)
    has = np.full(4, 2000.0)
    has[2] *= share
    now = Joints(np.zeros(3, np.bool_), has)
    assert fit.keeps_times(feeds, now) is keeps
    # What comes behind the blocks that are fitted does not count.
    early = _Fit.of(
        asked._replace(plain_from=2), Joints(np.zeros(3, np.bool_), np.full(4, 2000.0)), [CLOCK], None
    )  # type: ignore[arg-type]
    whole = Parts(np.arange(4), np.arange(1, 5))
    behind = _Fit(early.asked, early.columns, whole, early.clocks, early.refuse)
    assert behind.keeps_times(feeds, now) is True


@pytest.mark.parametrize(
    ("value", "rounded"),
    [
        (1.2345, 1.23),
        (1.235001, 1.24),
        (99.96, 100.0),
        (0.0123456, 0.0123),
        (123456.0, 123000.0),
        (1.0, 1.0),
        (inf, inf),
    ],
)
def test_three_digits(value: float, rounded: float) -> None:
    assert three_digits(np.array([value, 1.0])).tolist() == pytest.approx([rounded, 1.0], rel=1e-12)


def test_what_is_said_where_no_factor_does() -> None:
    said = _no_factor(np.array([0.01, 0.02, 0.03]), 0.012, 0.0055)
    assert (said.code, said.message, said.help) == (
        "VIB030",
        "a stroke of 0.06 mm in 3 blocks takes 17.5 ms at any feed, 12 ms are wanted",
        "take one block per stroke (WAVE TRIANGLE), or a lower frequency",
    )


# --- a cut ------------------------------------------------------------------------------------------------

AXES = (AxisLimits("X", 50.0, 500.0), AxisLimits("Y", inf, inf), AxisLimits("Z", 100.0, 2000.0))


def on_z(**more: Any) -> LinuxCnc:
    return LinuxCnc(**more).along((0.0, 0.0, 1.0), AXES)


def blocks_on_z(law: LinuxCnc, lengths: Floats) -> Blocks:
    moved = np.zeros((len(lengths), 3))
    moved[:, 2] = lengths
    return law.blocks(moved, lengths)


def refused(law: LinuxCnc, lengths: list[float], spans_s: list[float], plain_from: int | None = None) -> str:
    ways = np.array(lengths)
    with pytest.raises(RefusalError) as caught:
        law.feeds_for_spans(
            blocks_on_z(law, ways), np.array(spans_s), len(ways) if plain_from is None else plain_from
        )
    return f"{caught.value.code} {caught.value.message}; {caught.value.help}"


def test_what_a_cut_is_refused_for() -> None:
    law = on_z(max_feed_override=1.0)
    assert refused(law, [0.1, -0.05, 0.1], [0.03, 0.03, 0.01]) == (
        "VIB030 a stroke of 0.1 mm in 10 ms needs 4 m/s2, Z has 2 m/s2; this stroke takes at least 15 ms;"
        " ask for a lower frequency or a smaller stroke"
    )
    # The first that is too short is told, and before any that is too fast.
    assert "0.05 mm in 8 ms" in refused(law, [0.1, -0.05, 0.1], [0.03, 0.008, 0.01])
    assert refused(
        on_z(max_feed_override=1.0, blocks_per_s=100.0), [0.1, -0.05], [0.03, 0.03 / 3.75]
    ).startswith("VIB032 a stroke of 0.05 mm in 8 ms needs 125 blocks per second, the control reads 100; ")
    slow = LinuxCnc(max_feed_override=1.0).along((0.0, 0.0, 1.0), (*AXES[:2], AxisLimits("Z", 4.0, 2000.0)))
    said = refused(slow, [0.05, -0.1], [0.03, 0.025])
    assert said.startswith("VIB031 needs 4.") and " mm/s for 0.1 mm in 25 ms, Z has 4 mm/s; " in said
    # Of several blocks, what not even one could run.
    several = refused(law, [0.05, 0.05, -0.1], [0.005, 0.005, 0.03])
    assert several.startswith("VIB030 a stroke of 0.1 mm in 10 ms needs 4 m/s2, Z has 2 m/s2; ")
    # Those that keep their feeds are not asked.
    kept = law.feeds_for_spans(blocks_on_z(law, np.array([0.1, -0.05, 0.1])), np.array([0.03, 0.03, 0.01]), 2)
    assert kept[2] == pytest.approx(10.0)
    assert law.block_times([0.1, -0.05], kept[:2]).tolist() == pytest.approx([0.03, 0.03])


def test_the_acceleration_that_a_time_needs_is_that_of_whole_periods() -> None:
    """d = a·T²·(k² - k mod 2) / 4."""
    law = on_z()
    assert law._acceleration_for(0.1, 0.010) == pytest.approx(4.0 * 0.1 / (100.0 * 1e-6))
    assert law._acceleration_for(0.1, 0.011) == pytest.approx(4.0 * 0.1 / (120.0 * 1e-6))
    assert law._acceleration_for(0.1, 0.001) == pytest.approx(4.0 * 0.1 / (4.0 * 1e-6))


def test_where_nobody_knows_the_override_the_least_and_the_highest_both_count() -> None:
    """A wave of several blocks a stroke: at each override it takes its time to half a period and a little."""
    wave = np.concatenate(
        [
            np.diff(0.04 * (1.0 - np.cos(np.linspace(0.0, pi, 5)))),
            -np.diff(0.03 * (1.0 - np.cos(np.linspace(0.0, pi, 5)))),
        ]
    )
    lengths = np.tile(wave, 3)
    spans = np.full(len(lengths), 0.0055)
    both = on_z()
    feeds = both.feeds_for_spans(blocks_on_z(both, lengths), spans, len(lengths))
    for override in (1.0, 2.0):
        law = on_z(max_feed_override=override)
        own = law.feeds_for_spans(blocks_on_z(law, lengths), spans, len(lengths))
        assert law.block_times(lengths, own).reshape(-1, 4).sum(axis=1).tolist() == pytest.approx(
            [0.022] * 6, abs=0.00051
        )
        took = law.block_times(lengths, feeds).reshape(-1, 4).sum(axis=1)
        assert np.abs(took - 0.022).max() <= 0.0016


@pytest.mark.parametrize(
    ("more", "overrides"),
    [({}, [1.0, 2.0]), ({"max_feed_override": 1.2}, [1.2]), ({"per_revolution": True}, [inf])],
)
def test_which_overrides_a_search_for_feeds_goes_by(
    monkeypatch: pytest.MonkeyPatch, more: dict[str, Any], overrides: list[float]
) -> None:
    seen: list[list[float]] = []
    original = linuxcnc.fitted_feeds

    def looking(asked: Asked, clocks: list[Clock], refuse: Any) -> Floats:
        seen.append([clock.override for clock in clocks])
        return original(asked, clocks, refuse)

    monkeypatch.setattr(linuxcnc, "fitted_feeds", looking)
    law = on_z(**more)
    law.feeds_for_spans(blocks_on_z(law, np.array([0.1, -0.05])), np.full(2, 0.03), 2)
    assert seen == [overrides]


def test_joined_points_of_one_feed_are_one_block() -> None:
    """G64 with Q: 0.3 mm in three blocks at one feed take what one block takes, by length."""
    joins = on_z(max_feed_override=1.0, merge_mm=0.01)
    plain = on_z(max_feed_override=1.0)
    times = joins.block_times([0.05, 0.1, 0.15, -0.2, 0.1, 0.1], [10.0, 10.0, 10.0, 10.0, 10.0, 20.0])
    whole = plain.block_times([0.3, -0.2, 0.1, 0.1], [10.0, 10.0, 10.0, 20.0])
    assert times[:3].tolist() == pytest.approx((whole[0] * np.array([0.05, 0.1, 0.15]) / 0.3).tolist())
    assert times[3:].tolist() == pytest.approx(whole[1:].tolist())
    read = on_z(max_feed_override=1.0, merge_mm=0.01, blocks_per_s=100.0).block_times([0.05, 0.1, 0.15], 10.0)
    assert read[0] == 0.01


def test_what_the_interpolator_makes_of_places_and_where_they_bend() -> None:
    assert interpolated(np.array([0.0, 0.0, 6.0, 6.0, 0.0])).tolist() == [1.0, 5.0, 5.0]
    # Even from period 1 to 4, bent there; first and last are kept.
    places = [np.array([1.0, 2.0, 3.0]), np.array([4.0, 4.0, 5.0])]
    times, kept = _bent_knots(places, 9.0, 0.001)
    assert times.tolist() == pytest.approx([0.0, 0.004, 0.005, 0.006, 0.007])
    assert kept.tolist() == [0.0, 4.0, 4.0, 5.0, 9.0]
    # A millionth of a micrometre counts, half of it does not.
    for off, bent in ((2e-9, [0.0, 0.001, 0.002, 0.003]), (0.4e-9, [0.0, 0.003])):
        times, kept = _bent_knots([np.array([1.0, 2.0 + off])], 3.0, 0.001)
        assert times.tolist() == pytest.approx(bent)
        assert (kept[0], kept[-1], len(kept)) == (0.0, 3.0, len(bent))


def test_what_was_found_is_found_once_and_forgotten_when_it_is_too_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[int] = []
    original = linuxcnc_fit.factors_for

    def counting(wanted: Wanted, clocks: Any) -> Found:
        asked.append(len(wanted.time))
        return original(wanted, clocks)

    monkeypatch.setattr(linuxcnc_fit, "factors_for", counting)
    linuxcnc_fit._known.cache_clear()
    wanted = wanted_for([0.0125, 0.02, 0.0125])
    first = linuxcnc_fit._found(wanted, [CLOCK])
    again = linuxcnc_fit._found(wanted, [CLOCK])
    assert asked == [2]
    assert first.factors.tolist() == again.factors.tolist()
    assert first.late.tolist() == again.late.tolist() and first.never.tolist() == again.never.tolist()
    exact = original(wanted, [CLOCK])
    assert first.factors.tolist() == exact.factors.tolist()
    linuxcnc_fit._found(wanted_for([0.02, 0.015]), [CLOCK])
    assert asked == [2, 1]
    for most, more in ((3, []), (2, [2])):
        monkeypatch.setattr(linuxcnc_fit, "_MOST_KNOWN", most)
        linuxcnc_fit._found(wanted, [CLOCK])
        assert asked == [2, 1, *more]


def test_the_numbers_of_the_search() -> None:
    """With these LinuxCNC's simulated machine broke every chip; others find others."""
    assert (linuxcnc_feeds._MUCH_SLOWER, linuxcnc_feeds._FAR_PERIODS) == (0.7, 3.5)
    assert [low for low, high in pairwise(_TRIED) if high / low > 1.0512] == []
