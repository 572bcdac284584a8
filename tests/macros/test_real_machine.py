"""What a real machine does that a patient one does not: slow spindles, drops, other tools in the spindle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chipbreak.dialects import FANUC_MILL
from chipbreak.macros import macro_files
from laser_simulator.tool import Chip

from .cases import FLAT, STRAIGHT
from .stand import BAR, BAR_NUMBER, SETTINGS, Stand
from .table import TOOLS, Row, by_macros, by_numpy, drawn, rows

# A few of them; `make check-table` runs all.
ROWS = [row for index, row in enumerate(rows()) if index % 97 == 7]
BY_HAND = replace(SETTINGS, master_tool=0)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.text)
def test_macros_and_numpy_say_the_same(row: Row) -> None:
    assert by_macros(row) == by_numpy(row)


def test_the_rows_meet_every_control_unit_and_speed() -> None:
    whole = rows()
    assert len(whole) >= 600
    assert len({(row.control, row.is_inch, row.rpm) for row in whole}) == 32
    assert {row.tool for row in whole} <= set(TOOLS)
    assert len({row.fault for row in whole}) == 12


@pytest.mark.parametrize(
    ("runout_mm", "expected"), [((0.0, 0.004), ""), ((0.01, 0.01), "RUNOUT")], ids=["good", "runout"]
)
def test_runout_is_judged_at_any_speed(runout_mm: tuple[float, float], expected: str) -> None:
    assert [by_macros(row) for row in drawn(3, runout_mm)] == [expected] * 3


def test_a_drop_of_coolant_is_no_edge_and_hides_no_broken_tool() -> None:
    """Two drops a second, whenever they like."""
    rng = np.random.default_rng(5)
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    stand.machine.drops_s = np.sort(rng.uniform(0.0, 2000.0, 600))
    for _ in range(3):
        assert stand.check_alone() == ""
    stand.change(STRAIGHT.real(length_mm=35.0))
    assert stand.run("G65 P8902 T1. Z0. S5000.") in ("NO CONTACT", "CALL")
    stand.change(STRAIGHT.real())
    assert stand.trace(0.0) == ""
    stand.change(STRAIGHT.real(length_mm=49.0))
    assert {stand.chip_check(0.05, 0) for _ in range(4)} <= {"CHIP", "NO CONTACT"}


def test_the_second_workpiece_is_calibrated_on_the_bar_and_on_nothing_else() -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    first = stand.control.variables.commons[500]
    stand.run("T1 M6")
    assert stand.run("G65 P8900") == ""
    assert stand.control.variables.commons[500] == first
    for wrong in (
        replace(BAR, length_mm=147.0),
        replace(BAR, diameter_mm=19.8),
        FLAT.real(diameter_mm=20.0, length_mm=70.0, holder_mm=80.0),  # as long and as thick, and not round
        STRAIGHT.real(is_missing=True),
    ):
        stand.station.tools[BAR_NUMBER] = wrong
        assert stand.run("G65 P8900") == "NOT THE BAR"
        assert stand.check_alone() == "NOT CALIBRATED"


def test_without_a_tool_number_somebody_is_asked_for_the_bar() -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real(), settings=BY_HAND)
    said = []

    def put_it_in(text: str) -> None:
        said.append(text)
        stand.machine.tool = BAR_NUMBER

    stand.control.at_stop = put_it_in
    for _ in range(2):
        stand.run("T1 M6")
        assert stand.run("G65 P8900") == ""
    assert said == ["PUT MASTER BAR IN SPINDLE"] * 2
    stand.control.at_stop = None
    stand.run("T1 M6")
    assert stand.run("G65 P8900") == "NOT THE BAR"


@pytest.mark.parametrize("height_mm", [0.31, 4.444, 7.85])
def test_no_chip_hides_between_two_heights(height_mm: float) -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    assert stand.run("T1 M6") == stand.trace(8.0) == ""
    stand.change(STRAIGHT.real(chips=(Chip(2, height_mm, 0.03, 0.2),)))
    assert stand.chip_check(0.02) == "CHIP"
    assert stand.chip_check(0.05) == ""


def test_the_length_alone_is_checked_in_seconds() -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    assert stand.run("T1 M6") == stand.trace(0.0) == ""
    assert stand.seconds("G65 P8903 T1. W0.05 D0.") < 2.5
    stand.change(STRAIGHT.real(length_mm=STRAIGHT.length_mm + 0.95))
    assert stand.chip_check(0.05, 0) == "CHIP"
    stand.change(STRAIGHT.real(length_mm=STRAIGHT.length_mm + 0.951))
    assert stand.chip_check(0.05, 0) == ""


def test_shutter_air_locks_and_spinning_off_are_lines_of_the_profile() -> None:
    settings = replace(
        SETTINGS, laser_on="M71", laser_off="M72", air_on="M73", air_off="M74", lock_on="M77", lock_off="M78",
        spin_off="S8000 M3\nG4 X1.\nM5",
    )  # fmt: skip
    files = {
        name: data.decode().split("\n")[2:-3] for name, data in macro_files(FANUC_MILL, settings).items()
    }
    assert files["O8913.nc"] == ["M77", "M71", "M73"]
    assert files["O8916.nc"] == ["M74", "M72", "M78"]
    assert files["O8929.nc"] == ["S8000 M3", "G4 X1.", "M5"]
    stand = Stand(STRAIGHT, STRAIGHT.real(), settings=settings)
    stand.calibrate()
    assert stand.check_alone() == ""
    m_codes = [code for code in stand.control.blocks.m_codes if code > 70]
    assert m_codes == [77, 71, 73, 74, 72, 78] * 2
    assert stand.control.variables.locks == {3003: 0.0, 3004: 0.0}
