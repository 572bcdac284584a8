"""Every sentence of the solver of S, N and f, and of the waves, with the numbers in it."""

from __future__ import annotations

import math
from itertools import pairwise
from math import nan
from typing import Any

import numpy as np
import pytest

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.kinematics.speed_solver import (
    MOST_TICKS,
    CommandGroup,
    Period,
    SolverRules,
    _counts,
    never_breaks,
    preferred_per_rev,
    solve,
)
from chipbreak.kinematics.waveform import (
    WaveformParameters,
    feed_override_band,
    forward_ticks,
    full_window,
    largest_drop,
    least_stroke_mm,
    sample,
    speed_band_rpm,
)
from chipbreak.kinematics.waves import WAVES, wave_named
from chipbreak.text.diagnostics import RefusalError

HALF = CommandGroup(periods_s=(0.05,))


def outcome(given: dict[str, float], group: CommandGroup, rules: dict[str, Any]) -> Any:
    """S, N, f, ticks, the reasons, whether S was changed; or code, message, way out and words to write."""
    values = {
        name: SourcedValue(given[letter], f"{letter} word") if letter in given else None
        for name, letter in (("speed", "S"), ("per_rev", "N"), ("frequency", "f"))
    }
    try:
        found = solve(**values, group=group, rules=SolverRules(**rules))  # type: ignore[arg-type]
    except RefusalError as error:
        return error.code, error.message, error.help, error.instead
    return (
        found.speed_rpm,
        round(found.per_rev, 6),
        round(found.frequency_hz, 4),
        found.period.ticks,
        found.reasons,
        found.changed_speed,
    )


NEAREST = "f {} -> {} Hz, nearest the control can command ({})"
SLOWER = "f 75 -> 50 Hz, the next that the clamp of 2400 rpm allows (n = 5)"
WHOLE = "is a whole number, so no chip ever breaks"
CASES: list[tuple[dict[str, float], CommandGroup, dict[str, Any], Any]] = [
    # What is corrected, and why.
    (
        {"S": 3000, "N": 1.5},
        CommandGroup(),
        {},
        (
            2500.0,
            1.5,
            62.5,
            4,
            (NEAREST.format(75, 62.5, "n = 4"), "S 3000 -> 2500 rpm so that N is 1.5"),
            True,
        ),
    ),
    (
        {"S": 1000, "N": 0.6},
        HALF,
        {},
        (
            2000.0,
            0.6,
            20.0,
            12,
            (NEAREST.format(10, 20, "50 ms"), "S 1000 -> 2000 rpm so that N is 0.6"),
            True,
        ),
    ),
    ({"N": 1.5, "f": 62.5}, CommandGroup(), {}, (2500.0, 1.5, 62.5, 4, (), False)),
    ({"N": 3, "f": 62.5}, CommandGroup(), {"edges": 2}, (1250.0, 3.0, 62.5, 4, (), False)),
    (
        {"N": 1.5, "f": 41.667},
        CommandGroup(),
        {},
        (1667.0, 1.4997, 41.6667, 6, ("S 1666.6667 prints as 1667 rpm, which makes N 1.4997",), False),
    ),
    (
        {"N": 1.5, "f": 41.68},
        CommandGroup(),
        {"resolution_rpm": 0.1},
        (
            1666.7,
            1.49997,
            41.6667,
            6,
            (
                NEAREST.format(41.68, 41.6667, "n = 6"),
                "S 1666.6667 prints as 1666.7 rpm, which makes N 1.49997",
            ),
            False,
        ),
    ),
    ({"S": 100, "f": 62.5}, CommandGroup(), {}, (100, 37.5, 62.5, 4, (), False)),
    (
        {"S": 3000, "f": 62.5},
        CommandGroup(),
        {},
        (
            2500.0,
            1.5,
            62.5,
            4,
            ("N 1.25 -> 1.5, nearest n + phase, phase 0.5", "S 3000 -> 2500 rpm so that N is 1.5"),
            True,
        ),
    ),
    (
        {"S": 1900, "f": 62.5},
        CommandGroup(),
        {"pn": 0.2, "mn": 0.1},
        (
            2206.0,
            1.699909,
            62.5,
            4,
            (
                "N 1.97368 -> 1.7, tolerance 1.4 to 1.7 around 1.5 (nearest n + phase, phase 0.5)",
                "S 1900 -> 2206 rpm so that N is 1.7",
                "S 2205.8824 prints as 2206 rpm, which makes N 1.69991",
            ),
            True,
        ),
    ),
    (
        {"S": 2900, "f": 62.5},
        CommandGroup(),
        {"pn": 0.2, "mn": 0.1},
        (
            2679.0,
            1.399776,
            62.5,
            4,
            (
                "N 1.2931 -> 1.4, tolerance 1.4 to 1.7 around 1.5 (nearest n + phase, phase 0.5)",
                "S 2900 -> 2679 rpm so that N is 1.4",
                "S 2678.5714 prints as 2679 rpm, which makes N 1.39978",
            ),
            True,
        ),
    ),
    (
        {"S": 2600, "f": 62.5},
        CommandGroup(),
        {"rounding": "claim-7"},
        (
            2500.0,
            1.5,
            62.5,
            4,
            (
                "N 1.44231 -> 1.5, nearest integer + phase (claim 7), phase 0.5",
                "S 2600 -> 2500 rpm so that N is 1.5",
            ),
            True,
        ),
    ),
    (
        {"S": 2345, "f": 62.5},
        CommandGroup(),
        {"edges": 2, "phase": 0.25},
        (
            1500.0,
            2.5,
            62.5,
            4,
            (
                "N 1.59915 -> 2.5, nearest n + phase, phase 0.25, 2 edges",
                "S 2345 -> 1500 rpm so that N is 2.5",
            ),
            True,
        ),
    ),
    ({"S": 3000, "f": 62.5}, CommandGroup(), {"correct": "count"}, (3000, 1.25, 62.5, 4, (), False)),
    (
        {"S": 2500, "N": 1.6},
        CommandGroup(),
        {"correct": "count"},
        (
            2500,
            1.5,
            62.5,
            4,
            (NEAREST.format(66.6667, 62.5, "n = 4"), "N 1.6 -> 1.5 so that S stays 2500 rpm"),
            False,
        ),
    ),
    (
        {"S": 2400, "N": 1.875},
        CommandGroup(),
        {"max_rpm": 2400},
        (
            2000.0,
            1.875,
            62.5,
            4,
            (NEAREST.format(75, 62.5, "n = 4"), "S 2400 -> 2000 rpm so that N is 1.875"),
            True,
        ),
    ),
    # Below a clamp.
    (
        {"S": 2400, "N": 1.875},
        CommandGroup(multiples=(3, 5)),
        {"max_rpm": 2400},
        (1600.0, 1.875, 50.0, 5, (SLOWER, "S 2400 -> 1600 rpm so that N is 1.875"), True),
    ),
    (
        {"S": 3000, "N": 1.5},
        CommandGroup(),
        {"max_rpm": 2000},
        ("VIB006", "S 2500 rpm is above the clamp of 2000 rpm", "give f 50 Hz or a larger N", ("f50",)),
    ),
    (
        {"N": 0.5, "f": 62.5},
        CommandGroup(max_multiple=4),
        {"max_rpm": 5000},
        ("VIB006", "S 7500 rpm is above the clamp of 5000 rpm", "give a larger N", ()),
    ),
    ({"N": 0.75, "f": 62.5}, CommandGroup(), {"max_rpm": 5000}, (5000.0, 0.75, 62.5, 4, (), False)),
    (
        {"N": 1.5, "f": 62.5},
        CommandGroup(),
        {"min_rpm": 2501},
        ("VIB007", "S 2500 rpm is below the least of 2501 rpm", "give a smaller N", ()),
    ),
    ({"N": 1.5, "f": 62.5}, CommandGroup(), {"min_rpm": 2500}, (2500.0, 1.5, 62.5, 4, (), False)),
    (
        {"N": 9000.4, "f": 62.5},
        CommandGroup(),
        {},
        ("VIB007", "S 0.416648 rpm prints as zero", "give a smaller N", ()),
    ),
    # Whole numbers.
    (
        {"S": 3000, "N": 2},
        CommandGroup(),
        {},
        ("VIB005", f"N 2 (N word) {WHOLE}", "N 1.5 or 2.5 breaks best", ("N1.5", "N2.5")),
    ),
    (
        {"N": 1.0005, "f": 62.5},
        CommandGroup(),
        {},
        ("VIB005", f"N 1.0005 (N word) {WHOLE}", "N 0.5 or 1.5 breaks best", ("N0.5", "N1.5")),
    ),
    (
        {"N": 0.0005, "f": 62.5},
        CommandGroup(),
        {},
        ("VIB005", f"N 0.0005 (N word) {WHOLE}", "N 0.5 breaks best", ("N0.5",)),
    ),
    (
        {"N": 4, "f": 62.5},
        CommandGroup(),
        {"edges": 2, "phase": 0.25},
        ("VIB005", f"N 4 (N word) / 2 edges {WHOLE}", "N 2.5 or 4.5 breaks best", ("N2.5", "N4.5")),
    ),
    (
        {"S": 3750, "f": 62.5},
        CommandGroup(),
        {"correct": "count"},
        ("VIB005", f"N 1 (S 3750, f 62.5) {WHOLE}", "N 0.5 or 1.5 breaks best: give S 7500 or 2500", ()),
    ),
    # S 25 is what makes it whole.
    (
        {"N": 150.3, "f": 62.5},
        CommandGroup(),
        {},
        ("VIB005", f"N 150 (S 25, f 62.5) {WHOLE}", "N 149.5 or 150.5 breaks best: give S 24", ()),
    ),
    (
        {"N": 3749.6, "f": 62.5},
        CommandGroup(),
        {},
        (
            "VIB005",
            f"N 3750 (S 1, f 62.5) {WHOLE}",
            "N 3749.5 or 3750.5 breaks best, which needs another S or f",
            (),
        ),
    ),
    (
        {"S": 2500, "N": 2.5},
        CommandGroup(periods_s=(0.012,)),
        {"correct": "count"},
        ("VIB005", f"N 2 (S 2500, f 83.3333) {WHOLE}", "give S 3333 or 2000", ()),
    ),
    # What would be a surprise.
    (
        {"S": 3000, "f": 0.2},
        CommandGroup(),
        {},
        (
            "VIB008",
            "S 3000 (S word) with f 0.2 Hz makes N 0.004; N 0.5 would need less than half that spindle speed",
            "give S 24, or N and f without S",
            (),
        ),
    ),
    (
        {"S": 990, "N": 0.6},
        HALF,
        {},
        ("VIB008", "S 990 (S word) would become 2000 rpm", "give a larger N", ()),
    ),
    (
        {"S": 3000, "f": 200},
        CommandGroup(),
        {},
        (
            "VIB004",
            "f 200 (f word) is far from all the control can command",
            "the nearest are 62.5, 50, 41.6667 Hz; a feed is written with an upper-case F",
            ("f62.5", "f50", "f41.6667"),
        ),
    ),
    # What is given.
    (
        {"N": 1.5},
        CommandGroup(),
        {},
        ("VIB001", "two of S, N and f are needed, given: N 1.5 (N word)", "give one more", ()),
    ),
    ({}, CommandGroup(), {}, ("VIB001", "two of S, N and f are needed, given: none", "give one more", ())),
    (
        {"S": 1, "N": 2, "f": 3},
        CommandGroup(),
        {},
        (
            "VIB002",
            "S, N and f are all given: S 1 (S word), N 2 (N word), f 3 (f word)",
            "leave one out: N = 60 f / S",
            (),
        ),
    ),
    (
        {"S": 1, "N": -1},
        CommandGroup(),
        {},
        ("VIB003", "N -1 (N word) is not a number above zero", "correct N", ()),
    ),
    (
        {"S": nan, "N": 1.5},
        CommandGroup(),
        {},
        ("VIB003", "S nan (S word) is not a number above zero", "correct S", ()),
    ),
    (
        {"N": 1.5, "f": 0},
        CommandGroup(),
        {},
        ("VIB003", "f 0 (f word) is not a number above zero", "correct f", ()),
    ),
]


@pytest.mark.parametrize(("given", "group", "rules", "wanted"), CASES, ids=[f"{c[0]} {c[2]}" for c in CASES])
def test_what_the_solver_says(
    given: dict[str, float], group: CommandGroup, rules: dict[str, Any], wanted: Any
) -> None:
    assert outcome(given, group, rules) == wanted


@pytest.mark.parametrize(
    ("settings", "need"),
    [
        ({"base_period_s": 0.0}, "a base period above zero"),
        ({"base_period_s": math.inf}, "a base period above zero"),
        ({"multiples": (4,), "periods_s": (0.01,)}, "multiples or explicit periods, not both"),
        ({"multiples": (1, 4)}, "multiples from 2 up"),
        ({"multiples": ()}, "multiples from 2 up"),
        ({"periods_s": ()}, "periods above zero"),
        ({"periods_s": (0.01, 0.0)}, "periods above zero"),
        ({"min_multiple": 1}, f"a lowest multiple from 2 to {MOST_TICKS}"),
        ({"min_multiple": MOST_TICKS + 1}, "a lowest multiple from 2 to 1000000"),
        ({"max_multiple": 3}, "multiples in order"),
    ],
)
def test_what_a_group_needs(settings: dict[str, Any], need: str) -> None:
    with pytest.raises(RefusalError) as caught:
        CommandGroup(**settings)
    error = caught.value
    assert (error.code, error.message) == ("VIB009", f"vibration settings need {need}")
    assert error.help == "correct the machine profile"


def test_groups_at_their_edges() -> None:
    assert CommandGroup(multiples=(2,)).nearest(1.0).ticks == 2
    assert CommandGroup(min_multiple=2, max_multiple=2).nearest(1.0).ticks == 2
    assert CommandGroup(min_multiple=MOST_TICKS).nearest(9.0) == Period(1.0 / 4000.0, 4000.0, MOST_TICKS)
    # A period has two ticks at least, and the nearest whole number of them.
    ticks = [one.ticks for one in CommandGroup(periods_s=(0.001, 0.0139, 0.0141)).around(70.0, 3)]
    assert ticks == [4, 3, 2]
    assert [one.ticks for one in CommandGroup().around(1e9, 2)] == [4, 5]
    assert [one.ticks for one in CommandGroup(max_multiple=9).around(1e-9, 2)] == [9, 8]
    assert [one.ticks for one in CommandGroup().around(1.0 / (6.5 * 0.004), 4)] == [7, 6, 8, 9]


@pytest.mark.parametrize(
    ("settings", "low_hz", "high_hz", "ticks"),
    [
        ({}, 31.25, 50.0, [5, 6, 7, 8]),
        ({}, 31.26, 49.9, [6, 7]),
        ({}, 50.0, 1e9, [4, 5]),
        ({"max_multiple": 6}, 1e-3, 50.0, [5, 6]),
        ({}, 51.0, 61.0, []),
        ({"multiples": (5, 4, 8, 9)}, 31.25, 50.0, [5, 8]),
        ({"periods_s": (0.02, 0.016, 0.04)}, 25.0, 50.0, [5, 10]),
    ],
)
def test_periods_between_two_frequencies(
    settings: dict[str, Any], low_hz: float, high_hz: float, ticks: list[int]
) -> None:
    found = CommandGroup(**settings).between(low_hz, high_hz)
    assert [one.ticks for one in found] == ticks
    assert all(
        one.period_s == pytest.approx(one.ticks * 0.004)
        and one.frequency_hz * one.period_s == pytest.approx(1.0)
        for one in found
    )


def test_some_of_very_many_counts() -> None:
    assert _counts(5, 4004) == range(5, 4005)
    some = list(_counts(5, 4005))
    assert (some[0], some[-1]) == (5, 4005) and len(some) < 4000
    assert some == sorted(set(some))
    wide = list(_counts(2, 10**6))
    assert max(other / one for one, other in pairwise(wide[1000:])) < 1.004


@pytest.mark.parametrize(
    ("frequency", "near"),
    [(62.5 * 1.25, True), (62.5 * 1.2501, False), (25.0 / 1.25, True), (25.0 / 1.2501, False)],
)
def test_a_quarter_beyond_the_group_is_near(frequency: float, near: bool) -> None:
    assert CommandGroup(max_multiple=10).contains_near(frequency) is near


@pytest.mark.parametrize(
    ("off", "never"), [(0.0009, True), (0.0011, False), (-0.0009, True), (-0.0011, False)]
)
@pytest.mark.parametrize("edges", [1, 3])
def test_how_near_to_a_whole_number_never_breaks(off: float, never: bool, edges: int) -> None:
    assert never_breaks((2.0 + off) * edges, edges) is never


@pytest.mark.parametrize(
    ("per_rev", "rules", "best"),
    [
        (1.99, {}, 1.5),
        (2.0, {}, 2.5),
        (0.01, {}, 0.5),
        (1.99, {"rounding": "claim-7"}, 2.5),
        (1.5, {"rounding": "claim-7"}, 1.5),
        (1.51, {"rounding": "claim-7"}, 2.5),
        (0.4, {"rounding": "claim-7"}, 0.5),
        (4.1, {"edges": 2, "phase": 0.25}, 4.5),
        (3.4, {"edges": 2, "phase": 0.25}, 2.5),
    ],
)
def test_the_count_that_breaks_best(per_rev: float, rules: dict[str, Any], best: float) -> None:
    assert preferred_per_rev(per_rev, SolverRules(**rules)) == best


# --- waves ------------------------------------------------------------------------------------------------


def cut(**changes: Any) -> WaveformParameters:
    values: dict[str, Any] = {"length_mm": 1.0, "feed_mm_rev": 0.05, "speed_rpm": 3000.0, "period_s": 0.016}
    values |= {"ticks": 4, "forward_ticks": 2, "stroke_mm": 0.06}
    return WaveformParameters(**(values | changes))


def said(call: Any, *arguments: Any, **words: Any) -> tuple[str, str, str]:
    with pytest.raises(RefusalError) as caught:
        call(*arguments, **words)
    return caught.value.code, caught.value.message, caught.value.help


@pytest.mark.parametrize(
    ("changes", "told", "rule"),
    [
        ({"length_mm": 0.0}, "length_mm 0", "above zero"),
        ({"feed_mm_rev": -1.0}, "feed_mm_rev -1", "above zero"),
        ({"speed_rpm": math.inf}, "speed_rpm inf", "above zero"),
        ({"period_s": 0.0}, "period_s 0", "above zero"),
        ({"stroke_mm": nan}, "stroke_mm nan", "above zero"),
        ({"ramp_exponent": 0.0}, "ramp_exponent 0", "above zero"),
        ({"ramp_in_s": -0.1}, "ramp_in_s -0.1", "zero or more"),
        ({"end_revolutions": math.inf}, "end_revolutions inf", "zero or more"),
        ({"forward_ticks": 0}, "forward_ticks 0", "between 0 and 4 ticks"),
        ({"forward_ticks": 4}, "forward_ticks 4", "between 0 and 4 ticks"),
    ],
)
def test_what_a_cut_cannot_have(changes: dict[str, Any], told: str, rule: str) -> None:
    assert said(cut, **changes) == ("VIB010", f"{told} is not {rule}", f"give a value {rule}")


def test_what_else_waves_refuse() -> None:
    assert said(forward_ticks, 4, 1.0) == (
        "VIB010",
        "forward share 1 is not between 0 and 1",
        "give a value between 0 and 1",
    )
    assert said(forward_ticks, 4, 0.0)[0] == "VIB010"
    assert said(forward_ticks, 1, 0.5)[1] == "base periods in one vibration 1 is not 2 or more"
    assert said(least_stroke_mm, "triangle", 0.0, 0.05)[1] == "N 0 is not above zero"
    assert said(least_stroke_mm, "triangle", 1.5, 0.0)[1] == "feed per revolution 0 is not above zero"
    assert (
        said(least_stroke_mm, "triangle", 1.5, 0.05, alpha_share=1.0)[1]
        == "forward share 1 is not between 0 and 1"
    )
    assert said(least_stroke_mm, "triangle", 1.5, 0.05, margin=0.0)[1] == "margin 0 is not above zero"
    assert said(least_stroke_mm, "triangle", 3.0, 0.05) == (
        "VIB012",
        "N 3 is a whole number: no stroke breaks the chip",
        "take N 3.5, or another that is not whole",
    )
    assert said(least_stroke_mm, "triangle", 4.0, 0.05, edges=2) == (
        "VIB012",
        "N 4 / 2 edges is a whole number: no stroke breaks the chip",
        "take N 5, or another that is not whole",
    )
    assert said(cut, waveform="sine", form="stroke") == (
        "VIB011",
        "one move per stroke is a triangle; a sine needs one move per base period",
        'take segments "tick" or waveform TRIANGLE',
    )
    assert said(sample, cut(length_mm=0.06, ramp_in_s=0.02)) == (
        "VIB013",
        "too short to vibrate: 0.06 mm at F 0.05 mm/rev takes 0.024 s; two ramps take 0.02 s each,"
        " one vibration of 0.06 mm 0.016 s, the plain end 1 rev of 0.02 s",
        "shorten the ramp, raise f, or cut this block without vibration",
    )


@pytest.mark.parametrize(
    ("ticks", "alpha", "down", "forward"),
    [
        (4, 0.5, False, 2),
        (5, 0.5, False, 3),
        (5, 0.5, True, 2),
        (4, 0.01, False, 1),
        (4, 0.99, False, 3),
        (2, 0.9, True, 1),
        (10, 0.7, True, 7),
        (4, 0.624, False, 2),
        (4, 0.625, False, 3),
    ],
)
def test_whole_ticks_of_a_share(ticks: int, alpha: float, down: bool, forward: int) -> None:
    assert forward_ticks(ticks, alpha, rounds_down=down) == forward


def test_waves_by_their_formulas() -> None:
    triangle, sine, dwell = WAVES
    assert triangle.heights(4, 3).tolist() == pytest.approx([1 / 3, 2 / 3, 1.0, 0.0])
    assert sine.heights(4, 1).tolist() == pytest.approx([0.5, 1.0, 0.5, 0.0], abs=1e-15)
    assert (triangle.share(3, 4), sine.share(3, 4), dwell.share(3, 4)) == (0.75, 0.5, 0.75)
    assert [wave.remarks(4) for wave in WAVES] == [
        (),
        ("a sine of 4 base periods is a triangle: blocks are straight",),
        (),
    ]
    assert sine.remarks(2) and not sine.remarks(3) and not sine.remarks(8)
    assert [(one.turns_back, one.is_even, one.rounds_down, one.moves(3)) for one in WAVES] == [
        (True, False, False, 3),
        (True, True, False, 3),
        (False, False, True, 1),
    ]
    assert triangle.largest_drop(0.3, 0.75, None) == pytest.approx(min(0.3 / 0.25, 0.7 / 0.75))
    assert triangle.largest_drop(0.1, 0.75, 9) == pytest.approx(0.1 / 0.25)
    assert sine.largest_drop(0.3, 0.5, None) == pytest.approx(math.sin(0.3 * math.pi))
    assert sine.largest_drop(0.25, 0.5, 4) == pytest.approx(0.5)
    assert triangle.breaking_fractions(1.5, 0.75) == pytest.approx((0.25 / 1.5, 0.5))
    assert sine.breaking_fractions(2.0, 0.5) == pytest.approx((0.5 - 1 / 3, 0.5 + 1 / 3))
    assert largest_drop("triangle", 5.4, 0.5, 3) == pytest.approx(0.4)  # 0.8 of a vibration late
    one = cut()
    # 0.06 + 0.5 x 0.05 / 1.5 mm forward in 8 ms, and 0.06 - the same back.
    assert triangle.least_acceleration_mm_s2(one, 1.5) == pytest.approx(4.0 * (0.06 + 0.025 / 1.5) / 0.008**2)
    slow_back = cut(forward_ticks=1)
    back = 4.0 * (0.06 - 0.75 * 0.05 / 1.5) / 0.012**2
    forward = 4.0 * (0.06 + 0.25 * 0.05 / 1.5) / 0.004**2
    assert triangle.least_acceleration_mm_s2(slow_back, 1.5) == pytest.approx(max(forward, back))
    quick_back = cut(forward_ticks=3)
    assert triangle.least_acceleration_mm_s2(quick_back, 1.5) == pytest.approx(
        4.0 * (0.06 - 0.25 * 0.05 / 1.5) / 0.004**2
    )
    assert sine.least_acceleration_mm_s2(one, 1.5) == pytest.approx((2.0 * math.pi / 0.016) ** 2 * 0.03)
    assert dwell.least_acceleration_mm_s2(one, 1.5) == 0.0
    assert wave_named("dwell") is dwell


def test_what_a_cut_takes() -> None:
    """1 mm at 2.5 mm/s is 0.4 s; less a revolution of 20 ms there are 23 vibrations of 16 ms."""
    one = cut()
    assert (one.feed_speed_mm_s, one.speed_mm_s, one.duration_s, one.vibrations) == (2.5, 2.5, 0.4, 23)
    assert (one.knots_per_vibration, one.moves_per_vibration) == (4, 4)
    assert (cut(form="stroke").knots_per_vibration, cut(end_revolutions=0.0).vibrations) == (2, 25)
    assert cut(length_mm=0.04).vibrations == 0
    # A dwell feeds over half of the time, so that it takes as much longer.
    dwell = cut(waveform="dwell", form="stroke")
    assert (dwell.speed_mm_s, dwell.moves_per_vibration) == (1.25, 1)
    assert dwell.vibrations == 47  # 0.95 mm at 1.25 mm/s and 16 ms
    assert cut(waveform="dwell", form="stroke", end_revolutions=3.0).vibrations == 42  # 0.85 mm
    assert dwell.duration_s == pytest.approx(0.4 + 47 * 0.008)


def test_the_knots_of_a_cut_by_hand() -> None:
    """Ramps of two vibrations, growing with the square of time; forward in one tick of four."""
    one = cut(
        length_mm=0.5,
        forward_ticks=1,
        ramp_in_s=0.032,
        ramp_exponent=2.0,
        stroke_mm=0.06,
        end_revolutions=2.0,
    )
    time_s, place_mm = sample(one)
    assert one.vibrations == 10
    assert time_s.tolist() == pytest.approx([*np.arange(41) * 0.004, 0.2])
    assert (place_mm[0], place_mm[-1]) == (0.0, 0.5)
    for at in range(1, 41):
        tick = at % 4
        height = 1.0 if tick == 1 else (4 - tick) / 3 if tick else 0.0
        grown = min(min(at, 40 - at) * 0.004 / 0.032, 1.0) ** 2
        assert place_mm[at] == pytest.approx(2.5 * at * 0.004 + 0.06 * height * grown)
    assert full_window(one) == pytest.approx((0.032, 0.128))
    # Before the end there must be room for the stroke.
    late = cut(length_mm=0.5, end_revolutions=0.0)
    _, places = sample(late)
    assert places.max() == 0.5
    assert full_window(late)[1] == pytest.approx(11 * 0.016)


@pytest.mark.parametrize(
    ("wave", "per_rev", "ratio", "alpha", "edges"),
    [
        ("triangle", 1.5, 1.2, 0.5, 1),
        ("triangle", 1.25, 1.4, 0.75, 1),
        ("sine", 1.5, 1.3, 0.5, 1),
        ("triangle", 3.2, 0.7, 0.5, 2),
    ],
)
def test_bands_end_where_the_chips_no_longer_break(
    wave: str, per_rev: float, ratio: float, alpha: float, edges: int
) -> None:
    """At each end the drop is just what the feed asks for, and beyond it is less."""
    band = speed_band_rpm(wave, 1000.0, per_rev, ratio, alpha_share=alpha, edges=edges)
    assert band is not None and band[0] < 1000.0 < band[1]
    for end, outside in zip(band, (-1.0, 1.0), strict=True):
        for step, breaks in ((0.0, 1.0), (outside, 0.0)):
            drop = largest_drop(wave, per_rev * 1000.0 / (end + step), alpha, edges)
            assert (ratio * edges * drop >= 1.0 - 1e-9) is bool(breaks)
    feeds = feed_override_band(wave, per_rev, ratio, alpha_share=alpha, edges=edges)
    assert feeds is not None and feeds[0] < 1.0 < feeds[1]
    for end, outside in zip(feeds, (-0.0025, 0.0025), strict=True):
        for override, breaks in ((end, True), (end + outside, False)):
            drop = largest_drop(wave, per_rev * override, alpha, edges)
            assert (ratio * edges * drop >= override - 1e-9) is breaks


def test_bands_that_are_none_and_those_that_have_no_end() -> None:
    assert speed_band_rpm("triangle", 1000.0, 1.5, 0.999) is None
    assert speed_band_rpm("triangle", 1000.0, 1.5, 1.0) == pytest.approx((1000.0, 1000.0))
    assert speed_band_rpm("triangle", 1000.0, 3.0, 0.5, edges=2) == pytest.approx((1000.0, 1000.0))
    assert feed_override_band("triangle", 1.5, 0.999) is None
    # A stroke of a hundred feeds breaks far beyond what an override can be.
    low, high = feed_override_band("triangle", 0.5, 100.0) or (0.0, 0.0)
    assert low == pytest.approx(0.05, abs=0.0025)
    assert high == pytest.approx(1.98, abs=0.01) or high == pytest.approx(2.0, abs=0.0026)
