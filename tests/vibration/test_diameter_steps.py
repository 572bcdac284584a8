"""Cuts under constant surface speed, in steps of spindle speed that suit their diameters."""

from __future__ import annotations

import math

import pytest

import chipbreak
from machine_reader import run_program

MACHINE = (
    "planner.model=trapezoid",
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
)
CUTS = {
    "facing": "G0 X80. Z0.\nG1 X-1.6 F0.2\n",
    "outwards": "G0 X10. Z0.\nG1 X90. F0.2\n",
    "taper": "G0 X20. Z2.\nG1 X90. Z-40. F0.2\n",
    "contour": "G0 X18. Z2.\nG1 Z0. F0.2\nX20. Z-1.\nZ-20.\nX28.\nG3 X30. Z-21. R1.\nG1 X44. Z-60.\nX70.\n",
    "incremental": "G0 X80. Z0.\nG1 U-60. W-20. F0.2\n",
}


def settings_for(count: str, *sets: str) -> chipbreak.Settings:
    return chipbreak.load("fanuc-lathe", [*MACHINE, f"vibration.n={count}", *sets])


def program(cut: str, speed: str = "G96 S200", limit: str = "G50 S2500") -> bytes:
    return f"G21 G18 G99\n{limit}\n{speed} M3\n{cut}G0 X150. Z100.\nM30\n".encode()


@pytest.mark.parametrize("count", ["auto", "0.5"])
@pytest.mark.parametrize("name", CUTS)
def test_the_cutting_speed_stays_within_the_tolerance(name: str, count: str) -> None:
    result = chipbreak.rewrite(program(CUTS[name]), settings_for(count))
    assert all(cut.verdict.breaks for cut in result.cuts)
    assert not result.left
    assert not [d for d in result.diagnostics if d.code == "VIB064"]
    moves = [move for cut in run_program(result.data.decode()).cuts for move in cut]
    assert len({move.speed_rpm for move in moves}) > 1
    # The frequencies of the control move the speed of a fixed count a little further.
    tolerance = 0.2 if count == "auto" else 0.25
    for move in moves:
        assert move.speed_rpm <= 2500.0
        for x, _, _ in (move.start, move.end):
            wanted = min(2500.0, 1000.0 * 200.0 / (2.0 * math.pi * max(abs(x), 1e-6)))
            # A stroke reaches over the joint of two steps by its own length.
            assert move.speed_rpm / wanted - 1.0 == pytest.approx(0.0, abs=tolerance + 0.03)


@pytest.mark.parametrize("name", CUTS)
def test_the_cut_ends_where_it_did_and_comes_back(name: str) -> None:
    settings = settings_for("auto")
    data = program(CUTS[name])
    result = chipbreak.rewrite(data, settings)
    assert chipbreak.restore(result.data) == data
    assert not chipbreak.rewrite(result.data, settings).changed
    assert len(chipbreak.verify(result.data, settings).cuts) == len(result.cuts)
    assert sum(1 for _ in chipbreak.motions(result, settings)) == len(result.cuts)


def test_a_diameter_within_the_tolerance_is_one_step() -> None:
    (cut,) = chipbreak.rewrite(program("G0 X50. Z2.\nG1 X56. Z-30. F0.2\n"), settings_for("auto")).cuts
    assert cut.plan.solution.speed_rpm == pytest.approx(1273.0, rel=0.2)


def test_without_a_limit_the_spindle_is_asked_for_no_more_than_at_the_start() -> None:
    result = chipbreak.rewrite(program("G0 X80. Z0.\nG1 X20. F0.2\n", limit="G40"), settings_for("auto"))
    assert max(cut.plan.solution.speed_rpm for cut in result.cuts) <= 1000.0 * 200.0 / math.pi / 80.0 * 1.2


def test_the_pass_along_a_contour_gets_its_speeds() -> None:
    cycle = (
        "G0 X62. Z2.\nG71 U2. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.25\n"
        "N10 G0 X18.\nG1 Z0. F0.12\nZ-20.\nX28. Z-30.\nX58. Z-50.\nN20 X62.\n"
    )
    result = chipbreak.rewrite(program("(T1 OD ROUGH)\n" + cycle), settings_for("auto"))
    assert len(result.cuts) > 12
    assert not [d for d in result.diagnostics if d.code == "VIB064"]


def test_loops_step_between_blocks_only() -> None:
    result = chipbreak.rewrite(
        program(CUTS["facing"] + "G0 X20. Z2.\nG1 Z-20. F0.2\nX60. Z-30.\nZ-50.\n"),
        settings_for("0.5", "output.form=loop"),
    )
    assert len(result.edits) >= 3


def test_a_move_along_the_axis_stays_in_its_step() -> None:
    data = program(
        "G0 X85.3096 Z2.\nG3 X87.3096 Z1. R1. F0.35\nX97.3096 Z-4. R5.\nG1 Z-6.\nX77.3096\nG0 X87.3096\nZ2.\n"
        "X30.9602\nG1 X50.9602 F0.1\nZ-23.\nX51.9602 Z-23.5\nZ-23.8\n",
        "G96 S80",
        "G50 S4000",
    )
    result = chipbreak.rewrite(data, settings_for("auto", "axes.Z.max_acceleration_mm_s2=500"))
    assert result.cuts
    assert chipbreak.restore(result.data) == data


def test_a_step_that_cannot_be_planned_leaves_one_speed() -> None:
    result = chipbreak.rewrite(program(CUTS["facing"]), settings_for("1.5"))
    assert [cut.plan.solution.speed_rpm for cut in result.cuts] == [769.0]
