"""The seconds of each check, added up by hand from turns, touches and stops of the spindle."""

from __future__ import annotations

import pytest

import chipbreak
from beam import BEAM
from chipbreak.checks.calls import CallValues, CheckKind
from chipbreak.checks.durations import check_s, otherwise_s
from chipbreak.tools.data import ToolData

OPTIONS = (*BEAM, "checks.trace_step_mm=2", "checks.trace_chip_mm=0.5")
STANDING = chipbreak.load("fanuc-mill", OPTIONS)
TURNING = chipbreak.load("fanuc-mill", [*OPTIONS, "macros.gap_ms=13", 'macros.gap_on="M75"'])
# Three teeth at 3000 rpm, 20 ms a turn; 7 mm of edge are 5 heights 2 mm apart, and 14 chips of 0.5 mm.
VALUES = CallValues(1, 3000.0, 7.0, 0.02, data=ToolData(1, "flat end mill", 3), depth=1)
BREAKAGE, LINE, FULL = range(3)
LENGTH_S = 2.0 + 5 * 0.02


@pytest.mark.parametrize(
    ("kind", "values", "seconds"),
    [
        (CheckKind.CALIBRATE, VALUES, 15.0),
        (CheckKind.TOOL_CHECK, VALUES, 22.0 + 3 * 2.2 + 73 * 0.02),
        (CheckKind.TOOL_CHECK, VALUES._replace(data=None), 22.0 + 4 * 2.2 + 73 * 0.02),
        (CheckKind.TOOL_CHECK, VALUES._replace(data=ToolData(1)), 22.0 + 4 * 2.2 + 73 * 0.02),
        (CheckKind.TOOL_CHECK, VALUES._replace(speed_rpm=None), 22.0 + 3 * 2.2 + 73 * 0.06),
        (CheckKind.TRACE, VALUES, 20.0 + 1.27 * 3 * 5 + 36 * 0.02),
        (CheckKind.TRACE, VALUES._replace(height_mm=8.0), 20.0 + 1.27 * 3 * 5 + 36 * 0.02),
        (CheckKind.TRACE, VALUES._replace(height_mm=8.1), 20.0 + 1.27 * 3 * 6 + 36 * 0.02),
        (CheckKind.TRACE, VALUES._replace(height_mm=0.0), 5.0 + 36 * 0.02),
        (CheckKind.TRACE, VALUES._replace(height_mm=None), 5.0 + 36 * 0.02),
        (CheckKind.TRACE, VALUES._replace(height_mm=0.0, every=2, depth=0), LENGTH_S + 5.0 + 36 * 0.02),
        (
            CheckKind.TRACE,
            VALUES._replace(every=2, depth=BREAKAGE),
            LENGTH_S + 20.0 + 1.27 * 3 * 5 + 36 * 0.02,
        ),
        (CheckKind.CHIP_CHECK, VALUES._replace(depth=BREAKAGE), LENGTH_S),
        (CheckKind.CHIP_CHECK, VALUES._replace(depth=LINE), LENGTH_S + 2.0 + 0.8 * 3 * (14 / 0.9 + 1)),
        (CheckKind.CHIP_CHECK, VALUES._replace(depth=FULL), LENGTH_S + 2.0 + 0.8 * 3 * (14 / 0.9 + 1)),
        (CheckKind.CHIP_CHECK, VALUES._replace(height_mm=None), LENGTH_S + 2.0 + 0.8 * 3),
    ],
)
def test_a_check_of_a_barrier_that_sees_a_tool_that_stands(
    kind: CheckKind, values: CallValues, seconds: float
) -> None:
    assert check_s(kind, values, STANDING) == pytest.approx(seconds)


@pytest.mark.parametrize(
    ("depth", "seconds"),
    [
        (BREAKAGE, LENGTH_S),
        # A gap of 13 ms is seen at 1.3 times the speed: 30 ms for the three teeth of a turn.
        (LINE, LENGTH_S + 2.0 + 14 / 0.8 * 0.03),
        (FULL, LENGTH_S + 2.0 + 0.8 * 3 * (14 / 0.9 + 1)),
    ],
)
def test_a_barrier_that_notices_a_missing_edge_follows_the_limit_line(depth: int, seconds: float) -> None:
    assert check_s(CheckKind.CHIP_CHECK, VALUES._replace(depth=depth), TURNING) == pytest.approx(seconds)


def test_no_edge_takes_no_turn_there() -> None:
    found = check_s(CheckKind.CHIP_CHECK, VALUES._replace(height_mm=None), TURNING)
    assert found == pytest.approx(LENGTH_S + 2.0)


NAMES = (
    "macros.gap_ms=15 and a barrier that notices a missing edge",
    "checks.trace_height_mm=5, where no tool cuts higher",
    "checks.depth=breakage, which looks at the length alone",
)


@pytest.mark.parametrize(
    ("kind", "values", "seconds"),
    [
        (
            CheckKind.CHIP_CHECK,
            VALUES,
            (LENGTH_S + 2.0 + 14 / 0.8 * 0.045 / 1.3, LENGTH_S + 2.0 + 2.4 * (10 / 0.9 + 1), LENGTH_S),
        ),
        (
            CheckKind.CHIP_CHECK,
            VALUES._replace(height_mm=3.0),
            (LENGTH_S + 2.0 + 6 / 0.8 * 0.045 / 1.3, LENGTH_S + 2.0 + 2.4 * (6 / 0.9 + 1), LENGTH_S),
        ),
        (CheckKind.TRACE, VALUES, (39.77, 20.0 + 1.27 * 3 * 4 + 0.72, 5.72)),
        (CheckKind.TOOL_CHECK, VALUES, (30.06, 30.06, 30.06)),
        (CheckKind.CALIBRATE, CallValues(), (15.0, 15.0, 15.0)),
    ],
)
def test_what_makes_checks_shorter(kind: CheckKind, values: CallValues, seconds: tuple[float, ...]) -> None:
    found = otherwise_s(kind, values, STANDING)
    assert tuple(name for name, _ in found) == NAMES
    assert tuple(took for _, took in found) == pytest.approx(seconds)


def test_a_gap_that_the_profile_has_is_the_one_that_counts() -> None:
    (_, took), *_ = otherwise_s(CheckKind.CHIP_CHECK, VALUES, TURNING)
    assert took == pytest.approx(LENGTH_S + 2.0 + 14 / 0.8 * 0.03)
