"""What TRACE has stored outlasts the next CALIBRATE, so that a check of every n-th workpiece misses nothing.

An edge is stored as it hangs from the spindle: its length by the master bar, radii by the place of the beam,
angles by the spindle.  A beam that has moved with the heat of the machine changes none of these.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

from chipbreak.dialects.check_programs import O_WORDS
from laser_simulator.tool import Chip
from linuxcnc import laser
from longer import short_where

from .cases import BULL, STRAIGHT
from .lc_stand import LC_SETTINGS, alarms, subroutines
from .stand import ALARMS, BAR, BEAM, SETTINGS, Nominal, Stand

GOOD = STRAIGHT.real()
HEIGHT_MM = 4.0
CHIPPED = STRAIGHT.real(chips=(Chip(2, 2.0, 0.03, 2.2),))
WORN = STRAIGHT.real(chips=(Chip(2, 2.0, 0.015, 2.2),))
SHORTER = STRAIGHT.real(length_mm=50.97)
NEW = STRAIGHT.real(phase_deg=70.0, length_mm=50.6)
WARM = replace(BEAM, y_mm=BEAM.y_mm + 0.2, z_mm=BEAM.z_mm - 0.15)
FEW = ((BEAM, "D1."), (WARM, "D2."))
SMALL_STORE = replace(SETTINGS, store_last=SETTINGS.store_first + 95)


def calibrate(stand: Stand, every: int = 2) -> str:
    return stand.run(f"T90 M6\nG65 P8900 K{every}.")


def check(stand: Stand, nominal: Nominal = STRAIGHT, *, tool: int = 1, every: int = 2, more: str = "") -> str:
    """TOOL CHECK and TRACE, as the filter calls them."""
    data = nominal.data(tool)
    trace = f"G65 P8902 T{tool}. Z4. K{every}. U0 W0.02 D1.{more}"
    return stand.run(f"T{tool} M6\n{data}\nG65 P8901 T{tool}. S5000. K{every}.\n{trace}")


@pytest.fixture
def stand() -> Stand:
    """A control on which one workpiece has been checked, and the next one is not due."""
    stand = Stand(STRAIGHT, GOOD)
    assert calibrate(stand) == ""
    assert check(stand) == ""
    touched = stand.machine.skip_count
    assert calibrate(stand) == ""
    assert check(stand) == ""
    assert stand.machine.skip_count == touched
    return stand


@pytest.mark.parametrize(
    ("moved", "depth"), short_where(product([BEAM, WARM], ["D0.", "D1.", "D2."]), lambda case: case in FEW)
)
def test_what_chips_on_a_workpiece_between_is_found(stand: Stand, moved: object, depth: str) -> None:
    stand.station.beam = moved  # type: ignore[assignment]
    assert calibrate(stand) == ""
    assert check(stand, more=depth) == ""
    assert calibrate(stand) == ""  # not its turn
    stand.change(SHORTER if depth == "D0." else CHIPPED)
    assert calibrate(stand) == ""
    assert check(stand, more=depth) == "NOT AS STORED"
    # Again and again: RESET does not bring it back into the cut.
    assert calibrate(stand) == ""
    assert check(stand, more=depth) == "NOT AS STORED"


def test_wear_below_the_limit_passes_and_is_stored(stand: Stand) -> None:
    stand.change(WORN)
    assert calibrate(stand) == ""
    assert check(stand) == ""
    assert stand.chip_check(0.02) == ""
    _, radii = stand.stored()
    assert radii.min() < STRAIGHT.diameter_mm / 2 - 0.01


def test_a_new_tool_is_released_first(stand: Stand) -> None:
    stand.change(NEW)
    assert calibrate(stand) == ""
    assert check(stand) == "NOT AS STORED"
    assert stand.run("G65 P8919 T1.") == ""
    assert stand.chip_check(0.02) == "NO EDGE"  # nothing is left of the old one
    assert calibrate(stand) == ""
    assert check(stand) == ""
    assert stand.chip_check(0.02) == ""


def test_a_tool_of_another_kind_is_another_tool(stand: Stand) -> None:
    stand.change(BULL.real())
    assert calibrate(stand) == ""
    assert check(stand, BULL) == ""


def test_a_tool_with_a_sister_is_locked(stand: Stand) -> None:
    stand.change(CHIPPED)
    assert calibrate(stand) == ""
    call = f"{STRAIGHT.data(1)}\nG65 P8902 T1. Z4. S5000. K2. U14. W0.02 D1."
    assert stand.run(f"T1 M6\n{call}") == "NOT AS STORED"
    assert check(stand) == "LOCKED"


def test_each_workpiece_stores_anew_where_each_is_checked() -> None:
    stand = Stand(STRAIGHT, GOOD)
    for real in (GOOD, CHIPPED, NEW):
        stand.change(real)
        assert calibrate(stand, 1) == ""
        assert check(stand, every=1) == ""


def test_a_chip_check_without_a_trace_of_its_own_uses_the_stored_edge(stand: Stand) -> None:
    """A program that is started again in its middle."""
    stand.station.beam = WARM
    assert calibrate(stand, 1) == ""
    assert stand.run("T1 M6") == ""
    assert stand.chip_check(0.02) == ""
    stand.change(CHIPPED)
    assert stand.chip_check(0.02) == "CHIP"


def test_where_room_is_short_edges_of_earlier_workpieces_go() -> None:
    """Four values, three edges of 24 or less, and the eleven that are kept."""
    stand = Stand(STRAIGHT, GOOD, settings=SMALL_STORE)
    stand.station.tools |= {2: GOOD, 3: GOOD, 4: GOOD}
    assert calibrate(stand) == ""
    assert [check(stand, tool=tool) for tool in (1, 2, 3)] == ["", "", ""]
    assert check(stand, tool=4) == "NO ROOM"  # all of them are of this workpiece
    assert calibrate(stand) == ""
    assert [check(stand, tool=tool) for tool in (3, 4, 1)] == ["", "", ""]
    assert stand.run("T3 M6\nG65 P8903 T3. W0.02") == ""
    assert stand.run("T2 M6\nG65 P8903 T2. W0.02") == "NO EDGE"


@pytest.mark.parametrize("values", [(7.5, 3.0), (2.0, 900.0), (2.0, 14.5), (-350.0, 0.0), (1.0, None)])
def test_what_another_program_left_there_is_no_edge(values: tuple[float | None, ...]) -> None:
    stand = Stand(STRAIGHT, GOOD)
    for offset, value in enumerate(values):
        stand.control.variables.commons[SETTINGS.store_first + 4 + offset] = value
    assert calibrate(stand) == ""
    assert check(stand) == ""
    assert stand.chip_check(0.02) == ""


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("count", [5, pytest.param(9, marks=pytest.mark.long)])
def test_all_of_it_on_the_simulated_linuxcnc(tmp_path: Path, count: int) -> None:
    start = "M68 E0 Q0\no<cb_calibrate> call [2]\n"
    data = STRAIGHT.data(1, O_WORDS)
    traced = f"{data}\no<cb_trace> call [1] [4] [5000] [2] [0.02] [14] [1]\n(debug, traced)\nM2\n"
    pause = f"{start}M2\n"
    pieces = [
        f"{start}M68 E0 Q1\n{traced}",
        pause,
        f"{start}M68 E0 Q1\n{traced}",
        pause,
        f"{start}M68 E0 Q2\n{traced}",
        f"M68 E0 Q2\n{traced}",
        f"o<cb_release> call [1]\n{start}M68 E0 Q2\n{traced}",
        pause,
        f"{start}M68 E0 Q3\n{traced}",
    ]
    expected = [
        [], [], [], [],
        ["116 TOOL 1 EDGE NOT AS STORED 0.030 LIMIT 0.020"],
        ["114 TOOL 1 LOCKED SISTER 14"],
        [], [],
        ["116 TOOL 1 EDGE NOT AS STORED 0.030 LIMIT 0.020"],
    ][:count]  # fmt: skip
    runs = laser.run_until(
        lambda runs: alarms(runs) == expected,
        [f"\n{piece}".encode() for piece in pieces[:count]],
        tools=[BAR, GOOD, CHIPPED, replace(CHIPPED, length_mm=50.97)],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, tmp_path),
    )
    assert alarms(runs) == expected
    assert all(run.samples[-1, 3] in (LC_SETTINGS.safe_z_mm, 0.0) for run in runs)


def test_the_alarm_has_a_name() -> None:
    assert ALARMS[116] == "NOT AS STORED"
