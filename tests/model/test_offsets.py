"""Further work offsets: G54.1 P1 and G54.1 P2 are two coordinate systems."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.model.giving_back import feed_text
from chipbreak.model.interpreted_program import interpret
from chipbreak.model.modal import Setting, State
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

SETTINGS = chipbreak.load("fanuc-mill")


def positions(*lines: str) -> list[float]:
    """Y behind each line."""
    interpreted = interpret(parse(read("\n".join([*lines, ""]).encode()), SETTINGS.dialect), SETTINGS)
    return [interpreted.before(n).position.y for n in range(1, len(lines) + 1)]


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("G54.1 P1", "G54.1 P2"),
        ("G54 P1", "G54 P2"),
        ("G154 P1", "G154 P2"),
        ("G54", "G54.1 P1"),
        ("G54.1 P#1", "G54.1 P#1"),
        ("G110", "G111"),
        ("G129", "G154 P1"),
    ],
)
def test_where_the_tool_stands_in_another_one_is_not_known(one: str, other: str) -> None:
    ys = positions(one, "G0 X1. Y2. Z3.", other, "G0 Y4.")
    assert ys[1] == 2.0
    assert math.isnan(ys[2])
    assert ys[3] == 4.0


@pytest.mark.parametrize("said", ["G54.1 P1", "G54", "G154 P12", "G110"])
def test_the_same_one_again_changes_nothing(said: str) -> None:
    assert positions(said, "G0 X1. Y2. Z3.", said)[2] == 2.0


def test_p_is_read() -> None:
    program = b"T1 M6\nG54.1 P3\nG0 G154 P4 X1.\nM30\n"
    assert [d.code for d in chipbreak.rewrite(program, SETTINGS).diagnostics] == ["CHK005"]


def test_the_code_of_such_an_offset_is_said_with_its_words() -> None:
    assert SETTINGS.dialect.code("work_offset", "G54.1 P3") == "G54.1 P3"
    assert SETTINGS.dialect.code("work_offset", "G55") == "G55"


def linuxcnc(*lines: str) -> State:
    settings = chipbreak.load("linuxcnc-mill")
    program = parse(read("\n".join([*lines, ""]).encode()), settings.dialect)
    return interpret(program, settings).end()


def test_the_axis_words_of_a_given_length_offset_are_no_move() -> None:
    end = linuxcnc("G0 X1 Y2 Z3", "G43.1 X7 Z60")
    assert end.position[:2] == (1.0, 2.0)
    assert math.isnan(end.position.z)
    assert math.isnan(linuxcnc("G43 H1 Z3", "G91", "G49 G0 Z200").position.z)


def test_what_m70_keeps_m72_gives_back() -> None:
    kept = ("G94 F90", "S500 M3", "M8", "M70", "G91 G95 F1", "S9 M5", "M9", "G1")
    end = linuxcnc(*kept, "M72")
    assert (end.modes.distance, end.modes.feed_mode, end.modes.motion) == (
        "absolute",
        "minute",
        "line",
    )
    assert (end.feed and end.feed.text, end.speed and end.speed.text, end.spindle) == ("90", "500", "cw")
    assert end.coolant == {"flood"}
    assert linuxcnc("G91", "M72").modes.distance == "incremental"  # nothing was kept
    assert math.isnan(linuxcnc("M70", "G55", "G0 X1", "M72").position.x)
    assert linuxcnc("M70", "G0 X1", "M72").position.x == 1.0


@pytest.mark.parametrize(
    ("between", "feed", "speed"),
    [
        # What LinuxCNC commands then; where it rounds, or its releases differ, nothing is taken for granted:
        # before 2.9 M72 says no number that is the same.
        ("F100|M70|F3", 100.0, 2000.0),
        ("F0.1|M70|G94 F100", 0.1, 2000.0),
        ("F0.1|M70|G94 F0.1", math.nan, 2000.0),  # where it is not said, G95 has ended it
        ("F0.1|M70|G94", 0.1, 2000.0),
        ("F0.05|M70|F3", math.nan, 2000.0),
        ("F0.05|M70|G91", math.nan, 2000.0),
        ("F0.1|G20|M70|F3", 2.54, 2000.0),
        ("F0.1|G20|M70", math.nan, 2000.0),
        ("F0.1|M70|G20|F0.1", math.nan, 2000.0),
        # G20 makes another number of a feed per minute, and none of one per revolution.
        ("G94 F254|G20|M70|F3", 254.0, 2000.0),
        ("G94 F100|G20|M70|F3", math.nan, 2000.0),
        ("G94 F254|G20|M70", 254.0, 2000.0),
        ("S123.5|M70|S3", None, math.nan),
        ("S123.5|M70|G91", None, math.nan),
    ],
)
def test_m72_says_f_and_s_where_they_are_others(between: str, feed: float | None, speed: float) -> None:
    state = linuxcnc("G21 G95 M3 S2000", *between.split("|"), "M72")
    assert (state.feed and state.feed.value) == pytest.approx(feed, nan_ok=True)
    assert state.speed and state.speed.value == pytest.approx(speed, nan_ok=True)


def test_m72_leaves_the_limit_of_a_surface_speed_where_it_stays() -> None:
    limits = [
        linuxcnc("M3 S2000", "G96 D1800 S100", "M70", *between, "M72").speed_limit
        for between in ([], ["G96 D2500 S120"], ["G97 S800"])
    ]
    assert [limit and limit.value for limit in limits] == [1800.0, 2500.0, None]


def test_linuxcnc_keeps_a_feed_over_a_change_of_units() -> None:
    state = linuxcnc("F300", "G20")
    assert state.feed == Setting(300.0, "300", 0, "mm")
    assert feed_text(state) == "11.811024"
    assert feed_text(linuxcnc("F300", "G21")) == "300"
    assert feed_text(linuxcnc("G20", "F.1", "G21")) == "2.54"
