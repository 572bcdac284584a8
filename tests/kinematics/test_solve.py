"""Two of S, N and f: the worked examples of JP6416218B2, both rounding rules, and every refusal."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.speed_solver import (
    CommandGroup,
    Period,
    Solution,
    SolverRules,
    never_breaks,
    preferred_per_rev,
    solve,
)
from chipbreak.text.diagnostics import RefusalError

GROUP = CommandGroup()


def solved(
    speed: float | None = None,
    per_rev: float | None = None,
    frequency: float | None = None,
    group: CommandGroup = GROUP,
    rules: SolverRules | None = None,
) -> Solution:
    return solve(
        speed=None if speed is None else SourcedValue(speed, "active S, line 1"),
        per_rev=None if per_rev is None else SourcedValue(per_rev, "N word, line 12"),
        frequency=None if frequency is None else SourcedValue(frequency, "f word, line 13"),
        group=group,
        rules=rules or SolverRules(),
    )


def refusal(*args: object, **kwargs: object) -> RefusalError:
    with pytest.raises(RefusalError) as caught:
        solved(*args, **kwargs)  # type: ignore[arg-type]
    assert caught.value.help
    return caught.value


@pytest.mark.parametrize(
    ("given", "resolution", "kept"),
    [
        (2500.4, 1.0, True),
        (2500.6, 1.0, False),
        (2499.4, 1.0, False),
        (2500.04, 0.1, True),
        (2500.06, 0.1, False),
    ],
)
def test_a_speed_within_half_of_what_the_control_can_print_is_right_already(
    given: float, resolution: float, kept: bool
) -> None:
    got = solved(speed=given, per_rev=1.5, rules=SolverRules(resolution_rpm=resolution))
    assert got.speed_rpm == (given if kept else 2500.0)
    assert got.changed_speed is not kept


@pytest.mark.parametrize(
    ("per_rev", "edges", "named"),
    [(1, 1, "N 0.5 or 1.5 "), (2, 1, "N 1.5 or 2.5 "), (3, 1, "N 2.5 or 3.5 "), (4, 2, "N 3 or 5 ")],
)
def test_a_whole_count_names_the_good_ones_on_both_sides(per_rev: float, edges: int, named: str) -> None:
    error = refusal(per_rev=per_rev, frequency=62.5, rules=SolverRules(edges=edges))
    assert (error.code, error.help.startswith(named)) == ("VIB005", True)


# --- the table of the patent -----------------------------------------------------------------------------


def test_speed_and_count_move_to_the_nearest_frequency_and_the_speed_follows() -> None:
    got = solved(speed=3000, per_rev=1.5)
    assert (got.speed_rpm, got.per_rev, got.frequency_hz, got.period.ticks) == (2500, 1.5, 62.5, 4)
    assert got.changed_speed
    assert got.reasons == (
        "f 75 -> 62.5 Hz, nearest the control can command (n = 4)",
        "S 3000 -> 2500 rpm so that N is 1.5",
    )


def test_count_and_frequency_give_the_speed_without_any_correction() -> None:
    got = solved(per_rev=1.5, frequency=62.5)
    assert (got.speed_rpm, got.per_rev, got.reasons, got.changed_speed) == (2500, 1.5, (), False)


def test_speed_and_frequency_round_the_count() -> None:
    got = solved(speed=3000, frequency=62.5)
    assert (got.speed_rpm, got.per_rev) == (2500, 1.5)
    assert got.reasons[0] == "N 1.25 -> 1.5, nearest n + phase, phase 0.5"


@pytest.mark.parametrize(("resolution", "expected"), [(1.0, 2586), (0.1, 2586.2), (0.01, 2586.21)])
def test_the_tolerance_below_stops_the_count_at_its_edge(resolution: float, expected: float) -> None:
    got = solved(speed=3000, frequency=62.5, rules=SolverRules(mn=0.05, resolution_rpm=resolution))
    assert got.speed_rpm == expected
    assert got.per_rev == 60 * 62.5 / expected
    assert got.per_rev == pytest.approx(1.45, abs=2e-4)
    assert "tolerance 1.45 to 1.5 around 1.5" in got.reasons[0]


def test_frequencies_of_the_patent() -> None:
    rates = [GROUP.nearest(1 / (n * 0.004)).frequency_hz for n in range(4, 9)]
    assert rates == pytest.approx([62.5, 50, 41.6667, 35.7143, 31.25], abs=1e-4)


# --- rounding rules and tolerances -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("raw", "half", "claim_7"),
    [
        (0.6, 0.5, 1.5),
        (1.25, 1.5, 1.5),
        (1.51, 1.5, 2.5),
        (1.75, 1.5, 2.5),
        (2.75, 2.5, 3.5),
        (0.1, 0.5, 0.5),
        (1.5, 1.5, 1.5),
        (1.0, 1.5, 1.5),
    ],
)
def test_both_readings_of_the_rounding(raw: float, half: float, claim_7: float) -> None:
    assert preferred_per_rev(raw, SolverRules()) == half
    assert preferred_per_rev(raw, SolverRules(rounding="claim-7")) == claim_7


def test_claim_7_is_named_when_it_was_used() -> None:
    got = solved(speed=2142, frequency=62.5, rules=SolverRules(rounding="claim-7"))
    assert got.speed_rpm == 1500
    assert "claim 7" in got.reasons[0]
    assert solved(speed=2142, frequency=62.5).speed_rpm == 2500


def test_claim_7_leaves_a_printed_speed_alone_that_is_already_right() -> None:
    # 857 is how 857.142 prints; its N is 2.50042, whose nearest integer is 3.
    got = solved(speed=857, frequency=1 / 0.028, rules=SolverRules(rounding="claim-7"))
    assert (got.speed_rpm, got.reasons) == (857, ())


@pytest.mark.parametrize(
    ("pn", "mn", "speed", "count"),
    [
        (None, 0.3, 3000, 1.25),  # inside: nothing changes
        (0.1, None, 3000, 1.5),  # mn unset is 0 as soon as pn is set
        (0.1, None, 2200, 1.6),
        (0.3, None, 2200, 60 * 62.5 / 2200),
        (0.1, 0.1, 2500, 1.5),
    ],
)
def test_tolerances(pn: float | None, mn: float | None, speed: float, count: float) -> None:
    got = solved(speed=speed, frequency=62.5, rules=SolverRules(pn=pn, mn=mn, resolution_rpm=1e-6))
    assert got.per_rev == pytest.approx(count, abs=1e-8)
    assert got.changed_speed == (abs(60 * 62.5 / count - speed) > 1e-6)


def test_a_phase_for_the_uneven_triangle() -> None:
    got = solved(speed=3000, frequency=62.5, rules=SolverRules(phase=0.25))
    assert (got.speed_rpm, got.per_rev, got.reasons) == (3000, 1.25, ())


def test_two_edges_double_the_count_that_breaks_best() -> None:
    got = solved(speed=2000, frequency=62.5, rules=SolverRules(edges=2))  # N 1.875: 1 or 3, never 2
    assert (got.per_rev, got.speed_rpm) == (1.0, 3750)
    assert "2 edges" in got.reasons[0]
    assert refusal(per_rev=2, frequency=62.5, rules=SolverRules(edges=2)).code == "VIB005"
    assert solved(per_rev=3, frequency=62.5, rules=SolverRules(edges=2)).speed_rpm == 1250


def test_less_than_one_vibration_per_revolution() -> None:
    assert solved(per_rev=0.5, frequency=62.5).speed_rpm == 7500
    assert solved(speed=7000, frequency=62.5).per_rev == 0.5


# --- what gives way --------------------------------------------------------------------------------------


def test_the_count_gives_way_when_asked() -> None:
    got = solved(speed=3000, per_rev=1.5, rules=SolverRules(correct="count"))
    assert (got.speed_rpm, got.per_rev, got.changed_speed) == (3000, 1.25, False)
    assert "N 1.5 -> 1.25 so that S stays 3000 rpm" in got.reasons
    assert solved(speed=3000, frequency=62.5, rules=SolverRules(correct="count")).per_rev == 1.25


def test_a_speed_that_is_right_to_its_resolution_stays() -> None:
    got = solved(speed=2586, per_rev=1.45)
    assert (got.speed_rpm, got.changed_speed) == (2586, False)
    assert got.per_rev == 60 * 62.5 / 2586


def test_the_printed_speed_decides_the_count() -> None:
    got = solved(per_rev=3.5, frequency=1 / 0.028)
    assert got.speed_rpm == 612
    assert got.per_rev == pytest.approx(3.501401, abs=1e-6)
    assert "prints as 612 rpm, which makes N 3.5014" in got.reasons[-1]


# --- the group -------------------------------------------------------------------------------------------


def test_the_group_starts_at_its_lowest_multiple() -> None:
    # 75 Hz lies nearer to n = 3 (83.3 Hz); the answer of the patent needs a group that starts at 4.
    assert GROUP.nearest(75) == Period(62.5, 0.016, 4)
    assert CommandGroup(min_multiple=3).nearest(75).ticks == 3


def test_nearest_is_measured_in_frequency_and_a_tie_goes_to_the_slower() -> None:
    assert GROUP.nearest(56.26).frequency_hz == 62.5
    assert GROUP.nearest(56.25).frequency_hz == 50  # halfway in frequency; in period it is nearer to 62.5
    assert CommandGroup(base_period_s=0.001, min_multiple=3).nearest((1000 / 7 + 125) / 2).ticks == 8


def test_listed_multiples_and_periods() -> None:
    assert CommandGroup(multiples=(8, 4)).nearest(50).ticks == 4
    assert CommandGroup(max_multiple=8).nearest(1).ticks == 8
    odd = CommandGroup(periods_s=(0.018, 0.031))
    assert odd.nearest(40) == Period(1 / 0.031, 0.031, 8)
    assert odd.nearest(100).ticks == 4
    got = solved(speed=2000, per_rev=1.5, group=odd)
    assert "(18 ms)" in got.reasons[0]


def test_around_lists_the_nearest_first() -> None:
    assert [p.ticks for p in GROUP.around(49)] == [5, 6, 7]
    assert [p.ticks for p in GROUP.around(500)] == [4, 5, 6]
    assert [p.ticks for p in CommandGroup(max_multiple=5).around(1)] == [5, 4]


@pytest.mark.parametrize("frequency_hz", [0.0, 1e-320])
def test_the_slowest_periods_are_nearest_to_standing(frequency_hz: float) -> None:
    """What a program with ``G50 S0`` leaves for a vibration."""
    assert [p.ticks for p in CommandGroup(max_multiple=5).around(frequency_hz)] == [5, 4]


@given(
    frequency=st.floats(0.05, 500),
    low=st.integers(2, 9),
    extra=st.integers(0, 300),
    base=st.sampled_from([0.001, 0.004, 0.002]),
)
def test_nearest_agrees_with_a_search_through_the_whole_group(
    frequency: float, low: int, extra: int, base: float
) -> None:
    group = CommandGroup(base_period_s=base, min_multiple=low, max_multiple=low + extra)
    best = min(abs(1 / (n * base) - frequency) for n in range(low, low + extra + 1))
    assert abs(group.nearest(frequency).frequency_hz - frequency) == pytest.approx(best, abs=1e-8)


@pytest.mark.parametrize(
    ("group", "frequency", "near"),
    [
        (GROUP, 78, True),
        (GROUP, 79, False),
        (GROUP, 0.2, True),
        (CommandGroup(max_multiple=8), 25, True),
        (CommandGroup(max_multiple=8), 24.9, False),
        (CommandGroup(periods_s=(0.1, 0.01)), 50, True),
        (CommandGroup(periods_s=(0.1, 0.01)), 126, False),
    ],
)
def test_far_outside_the_group(group: CommandGroup, frequency: float, near: bool) -> None:
    assert group.contains_near(frequency) == near


# --- refusals --------------------------------------------------------------------------------------------


def test_three_given_names_each_with_its_origin() -> None:
    error = refusal(speed=2500, per_rev=1.5, frequency=62.5)
    assert error.code == "VIB002"
    told = str(error)
    assert "S 2500 (active S, line 1)" in told
    assert "N 1.5 (N word, line 12)" in told
    assert "f 62.5 (f word, line 13)" in told


def test_one_or_none_given() -> None:
    error = refusal(per_rev=1.5)
    assert error.code == "VIB001"
    assert "N 1.5 (N word, line 12)" in str(error)
    assert refusal().code == "VIB001"


@pytest.mark.parametrize("value", [0.0, -1.5, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("name", ["speed", "per_rev", "frequency"])
def test_not_a_number_above_zero(name: str, value: float) -> None:
    values = {"speed": 2500.0, "per_rev": 1.5, "frequency": 62.5}
    values.pop("frequency" if name != "frequency" else "speed")
    assert refusal(**{**values, name: value}).code == "VIB003"


def test_a_sloppy_feed_is_no_frequency() -> None:
    error = refusal(speed=2500, frequency=120000)
    assert error.code == "VIB004"
    assert "62.5, 50" in error.help
    # f0.2 was meant as a feed: the spindle would have to stand almost still.
    assert refusal(speed=2000, frequency=0.2).code == "VIB008"


@pytest.mark.parametrize(
    ("per_rev", "frequency", "edges"), [(1, 62.5, 1), (2, 1 / 0.028, 1), (4, 50, 2), (3, 50, 3)]
)
def test_a_whole_number_of_vibrations_never_breaks(per_rev: float, frequency: float, edges: int) -> None:
    # 2 at 35.7 Hz prints S 1071, which makes N 2.0007: that saves nothing.
    assert refusal(per_rev=per_rev, frequency=frequency, rules=SolverRules(edges=edges)).code == "VIB005"


def test_a_coarse_speed_must_not_turn_the_count_whole() -> None:
    # S 2500 is exact, but prints as 3000 on a spindle with steps of 1500.
    error = refusal(per_rev=1.2, frequency=50, rules=SolverRules(resolution_rpm=1500))
    assert (error.code, "S 3000" in str(error)) == ("VIB005", True)


def test_keeping_the_speed_must_not_turn_the_count_whole() -> None:
    assert refusal(speed=3750, per_rev=1.2, rules=SolverRules(correct="count")).code == "VIB005"


def test_the_clamp_is_an_error() -> None:
    error = refusal(per_rev=1.5, frequency=62.5, rules=SolverRules(max_rpm=2499))
    assert error.code == "VIB006"
    assert "f 50 Hz" in error.help
    assert solved(per_rev=1.5, frequency=62.5, rules=SolverRules(max_rpm=2500)).speed_rpm == 2500
    assert refusal(per_rev=1.5, frequency=62.5, rules=SolverRules(min_rpm=2501)).code == "VIB007"
    assert refusal(per_rev=900.5, frequency=62.5, rules=SolverRules(resolution_rpm=10)).code == "VIB007"


@pytest.mark.parametrize(("edges", "phase"), [(1, 0.5), (2, 0.5), (1, 0.25)])
def test_a_speed_given_with_a_frequency_may_be_halved_and_no_more(edges: int, phase: float) -> None:
    """Below half the least N that breaks, S would fall to less than half: asked for, or a slip of the pen?"""
    rules = SolverRules(edges=edges, phase=phase, resolution_rpm=0.1)
    half = edges * phase / 2.0
    just_too_fast, just_fine = (60.0 * 62.5 / (half * share) for share in (0.999, 1.001))
    error = refusal(speed=just_too_fast, frequency=62.5, rules=rules)
    assert error.code == "VIB008"
    assert "less than half that spindle speed" in error.message
    got = solved(speed=just_fine, frequency=62.5, rules=rules)
    assert got.per_rev == pytest.approx(edges * phase, rel=1e-4)
    assert got.speed_rpm / just_fine == pytest.approx(0.5, rel=2e-3)


def test_a_doubled_speed_is_refused() -> None:
    group = CommandGroup(max_multiple=8)  # 31.25 Hz and more: S 1250 and more at N 1.5
    for speed in (100, 624.9):
        assert refusal(speed=speed, per_rev=1.5, group=group).code == "VIB008"
    assert solved(speed=625, per_rev=1.5, group=group).speed_rpm == 1250


@pytest.mark.parametrize(
    "settings",
    [
        {"base_period_s": 0.0},
        {"base_period_s": math.nan},
        {"min_multiple": 1},
        {"max_multiple": 3},
        {"max_multiple": 0},
        {"multiples": ()},
        {"multiples": (1, 4)},
        {"periods_s": ()},
        {"periods_s": (0.02, math.nan)},
        {"periods_s": (0.02,), "multiples": (4,)},
    ],
)
def test_impossible_groups(settings: dict[str, object]) -> None:
    with pytest.raises(RefusalError) as caught:
        CommandGroup(**settings)  # type: ignore[arg-type]
    assert caught.value.code == "VIB009"


@pytest.mark.parametrize(
    "settings",
    [
        {"phase": 0.0},
        {"phase": 1.0},
        {"pn": -0.1},
        {"mn": math.nan},
        {"mn": math.inf},
        {"resolution_rpm": 0.0},
        {"edges": 0},
    ],
)
def test_impossible_rules(settings: dict[str, object]) -> None:
    with pytest.raises(RefusalError) as caught:
        SolverRules(**settings)  # type: ignore[arg-type]
    assert caught.value.code == "VIB009"


# --- properties ------------------------------------------------------------------------------------------


@given(
    speed=st.floats(50, 8000), frequency=st.floats(5, 78), edges=st.integers(1, 3), phase=st.floats(0.1, 0.9)
)
def test_the_three_always_agree_and_solving_twice_changes_nothing(
    speed: float, frequency: float, edges: int, phase: float
) -> None:
    rules = SolverRules(edges=edges, phase=phase)
    try:
        first = solved(speed=speed, frequency=frequency, rules=rules)
    except RefusalError as error:
        # Whole numbers of revolutions are a coarse scale where N is large; nothing else can be refused.
        assert error.code == "VIB008" or (error.code == "VIB005" and speed < 200)
        assume(False)
    assert first.per_rev * first.speed_rpm == pytest.approx(60 * first.frequency_hz)
    assert not never_breaks(first.per_rev, edges)
    assert GROUP.nearest(first.frequency_hz) == first.period
    again = solved(speed=first.speed_rpm, frequency=first.frequency_hz, rules=rules)
    assert (again.speed_rpm, again.reasons) == (first.speed_rpm, ())


def test_of_very_many_periods_some_are_taken_that_lie_close() -> None:
    group = CommandGroup(base_period_s=0.001)
    few = group.between(1.0, 100.0)
    assert [period.ticks for period in few] == list(range(10, 1001))
    many = [period.ticks for period in group.between(0.001, 100.0)]
    assert (many[0], many[-1]) == (10, 1_000_000)
    assert len(many) <= 4000
    assert all(later <= 1 + now * 1.003 for now, later in pairwise(many))


def test_a_way_out_is_no_spindle_that_stands() -> None:
    assert refusal(speed=0.5, per_rev=1_000_000_000.5).help == "give N and f without S"


def test_the_way_out_is_the_speed_that_makes_the_better_count_with_the_frequency_there_is() -> None:
    """Only 62.5 Hz, so S 3750 makes N 1 whatever N is asked; 60 * 62.5 / S is 0.5 at 7500, 1.5 at 2500."""
    group = CommandGroup(max_multiple=4)
    error = refusal(speed=3750, per_rev=1.2, group=group, rules=SolverRules(correct="count"))
    assert (error.code, error.help, error.instead) == ("VIB005", "give S 7500 or 2500", ())


@pytest.mark.parametrize(
    ("clamp", "speed", "frequency", "ticks"),
    [(2500, 2500, 62.5, 4), (2499, 2000, 50.0, 5), (2300, 2000, 50.0, 5)],
)
def test_below_a_clamp_the_next_slower_frequency_is_taken(
    clamp: float, speed: float, frequency: float, ticks: int
) -> None:
    """S 2300 and N 1.5 ask 57.5 Hz; nearest is 62.5, which needs S 2500, and the next slower one is 50 Hz."""
    got = solved(speed=2300, per_rev=1.5, rules=SolverRules(max_rpm=clamp))
    assert (got.speed_rpm, got.frequency_hz, got.period.ticks) == (speed, frequency, ticks)
    why = (
        "nearest the control can command" if ticks == 4 else f"the next that the clamp of {clamp} rpm allows"
    )
    assert got.reasons[0] == f"f 57.5 -> {frequency:g} Hz, {why} (n = {ticks})"
