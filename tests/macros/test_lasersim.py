"""The simulated laser and tool, against geometry that needs no program."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, radians, sqrt, tan

import numpy as np
import pytest

from laser_simulator.barrier import Beam, Station, is_broken
from laser_simulator.tool import Chip, Kind, SimulatedTool, table

FLAT = SimulatedTool(length_mm=50.0, holder_mm=30.0)
BEAM = Beam(0.0, 0.0, -100.0, focus_half_mm=3.0)
TIP_Z = -20.0  # of the spindle nose, with the tip of FLAT in the beam


def edge_y(
    tool: SimulatedTool, angle_deg: float | None, z: float, side: float = -1.0, x: float = 0.0
) -> float:
    """How far from the beam the spindle's axis is when a tool from one side first breaks it."""
    y = side * np.arange(12.0, -0.001, -0.001)
    points = np.column_stack([np.full(len(y), x), y, np.full(len(y), z)])
    begin, end = (0.0, 360.0) if angle_deg is None else (angle_deg, angle_deg)
    hits = np.flatnonzero(is_broken(BEAM, tool, points, begin, end))
    return abs(float(y[hits[0]])) if len(hits) else -1.0


@pytest.mark.parametrize(
    ("tool", "height", "radius"),
    [
        (FLAT, 0.0, 5.0),
        (replace(FLAT, corner_mm=1.0), 0.0, 4.0),
        (replace(FLAT, corner_mm=1.0), 0.4, 4.0 + sqrt(1 - 0.36)),
        (replace(FLAT, kind=Kind.BALL), 0.0, 0.0),
        (replace(FLAT, kind=Kind.BALL), 2.0, 4.0),
        (replace(FLAT, kind=Kind.BALL), 9.0, 5.0),
        (replace(FLAT, kind=Kind.DRILL, point_deg=118.0), 1.0, tan(radians(59.0))),
        (replace(FLAT, kind=Kind.DRILL), 20.0, 5.0),
        (replace(FLAT, kind=Kind.REAMER, diameter_mm=8.0), 3.0, 4.0),
        (replace(FLAT, runout_mm=0.01, runout_deg=90.0), 3.0, 5.01),
        (replace(FLAT, runout_mm=0.01, runout_deg=45.0), 3.0, hypot(5 + 0.01 * cos(radians(45)), 0.0071)),
        (replace(FLAT, chips=(Chip(1, 3.0, 0.5),)), 3.0, 5.0),
        (replace(FLAT, teeth=1, chips=(Chip(0, 3.0, 0.5),)), 3.0, 4.5),
    ],
)
def test_the_turning_tool_sweeps_its_profile(tool: SimulatedTool, height: float, radius: float) -> None:
    assert tool.envelope(height) == pytest.approx(radius, abs=1e-4)
    assert edge_y(tool, None, TIP_Z - height) == pytest.approx(radius, abs=0.0011)


def test_nothing_is_below_the_tip_or_in_an_empty_holder() -> None:
    assert edge_y(FLAT, None, TIP_Z + 0.001) == -1.0
    assert edge_y(replace(FLAT, is_missing=True), None, TIP_Z - 5.0) == -1.0
    station = Station(replace(BEAM, is_blocked=True), {})
    assert station.broken(1, np.array([[0.0, 99.0, 99.0]]), 0.0).all()


def test_a_standing_tool_shows_the_edge_that_is_turned_to_the_beam() -> None:
    chipped = replace(FLAT, chips=(Chip(1, 5.0, 0.1),))
    z = TIP_Z - 5.0
    # Seen from above, edge 1 of 4 stands at 90 degrees; M3 turns clockwise, so 90 more bring edge 2 there.
    assert edge_y(chipped, 0.0, z) == pytest.approx(4.9, abs=0.0011)
    assert edge_y(chipped, 90.0, z) == pytest.approx(5.0, abs=0.0011)
    assert edge_y(chipped, 30.0, z) == pytest.approx(4.9 * cos(radians(30)), abs=0.0011)
    assert edge_y(chipped, 180.0, z, side=1.0) == pytest.approx(4.9, abs=0.0011)
    assert edge_y(chipped, 0.0, z - 2.0) == pytest.approx(5.0, abs=0.0011)


def test_a_right_hand_helix_is_followed_by_turning_the_way_m3_does() -> None:
    tool = replace(FLAT, helix_deg=30.0, chips=(Chip(1, 5.0, 0.1),))
    turn = np.degrees(5.0 * tan(radians(30.0)) / 5.0)
    assert edge_y(tool, turn, TIP_Z - 5.0) == pytest.approx(4.9, abs=0.0011)
    assert edge_y(tool, turn + 90.0, TIP_Z - 5.0) == pytest.approx(5.0, abs=0.0011)
    assert edge_y(tool, -turn, TIP_Z - 5.0) < 4.8


def test_a_hollow_end_is_seen_in_focus_only() -> None:
    dished = replace(FLAT, dish_mm=0.1)
    at = np.array([[0.0, 0.0, TIP_Z - 0.03], [0.0, -4.8, TIP_Z - 0.03], [3.0, 0.0, TIP_Z - 0.03]])
    assert is_broken(BEAM, dished, at, 0.0, 360.0).tolist() == [False, True, True]
    assert is_broken(BEAM, dished, at - [0.0, 0.0, 0.05], 0.0, 360.0).tolist() == [True, True, True]
    assert edge_y(FLAT, None, TIP_Z - 1.0, x=6.0) == pytest.approx(4.0, abs=0.0011)


def test_a_chip_on_a_curve_goes_inward_along_its_normal() -> None:
    ball = replace(FLAT, kind=Kind.BALL, chips=(Chip(0, 2.0, 0.02),))
    way = ball.profile(2.0) - ball.tooth_radius(0, 2.0)
    assert way == pytest.approx(0.02 / (4.0 / 5.0), rel=1e-3)


def test_the_table_holds_the_same_tool() -> None:
    tool = replace(FLAT, helix_deg=20.0, dish_mm=0.2, chips=(Chip(2, 1.0, 0.1),))
    rows = table(tool, [0.1, 1.0])
    assert len(rows[0]) == 1 + 2 * tool.teeth
    assert rows[0][0] == pytest.approx(2.5)
    assert [row[5] for row in rows] == pytest.approx([5.0, 4.9])
    assert np.degrees(rows[1][6]) == pytest.approx(180 + np.degrees(tan(radians(20)) / 5))
