"""CALIBRATE where nobody but the machine knows where the tool is: at the start of a program, before any move.

Its program comes back to X and Y of its call, so blocks that rely on these may follow it.
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from beam import BEAM as NAMED
from linuxcnc import laser
from linuxcnc.machine import Run
from macros.lc_stand import LC_SETTINGS, subroutines
from macros.stand import BAR, BEAM, FLAT_OK, Stand

from .filtered import Filtered, check, filtered

BUILT_IN = ("checks.calls=builtin", *NAMED)
CUT = "G1 Z-2. F300.\nX30.\nG0 Z15.\n"
END = "M5\nG91 G28 Z0.\nG90\nM30\n"
# How tools come to their first cut; the first blocks rely on what nobody has said in the program.
WAYS = {
    "down before X and Y": "T1 M6\nS5000 M3\nG0 G43 H1 Z15.\nX10. Y10.\n",
    "a safe height first": "G0 Z50.\nT1 M6\nS5000 M3\nG0 Z50.\nG0 X10. Y10.\nZ15.\n",
    "X alone, then down": "T1 M6\nS5000 M3\nG0 X10.\nG43 H1 Z15.\nY10.\n",
    "Y alone before the tool": "G0 Y10.\nT1 M6\nS5000 M3\nG0 G43 H1 Z15.\nX10. Y20.\n",
    "an offset moved in between": "G0 X0 Y0\nG10 L2 P1 X-200.\nT1 M6\nS5000 M3\nG43 H1 Z15.\nG0 X10. Y10.\n",
}


def through(way: str, profile: str, head: str = "G21 G90 G94 G17 G40 G80 G54\n") -> Filtered:
    text = f"{head}{way}{CUT}{END}"
    if profile.startswith("linuxcnc"):
        text = text.replace("G91 G28 Z0.\nG90\n", "G53 G0 Z0\n")
    return filtered(text.encode(), profile, *BUILT_IN)


@pytest.mark.parametrize("profile", ["fanuc-mill", "linuxcnc-mill"])
@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_the_beam_is_measured_before_the_first_tool_wherever_the_operator_left_the_machine(
    profile: str, way: str
) -> None:
    result = through(way, profile)
    assert result.titles[:2] == ["CALIBRATE", "TOOL CHECK T1, TRACE T1"]
    assert not [d for d in result.diagnostics if d.code == "CHK002"]
    assert result.edits[0].first <= result.data.decode().splitlines().index("T1 M6")
    check(result)


def test_what_is_known_is_put_back_by_the_program_itself() -> None:
    edit = through(WAYS["Y alone before the tool"], "fanuc-mill").edits[0]
    assert list(edit.content[-2:]) == ["G65 P8900", "G0 Y10."]


@pytest.mark.parametrize(
    ("way", "why"),
    [
        ("T1 M6\nS5000 M3\nG1 Z-2. F100.\n", "where Z is"),
        ("G0 X5. Y5.\nT1 M6\nS5000 M3\nG91\nG0 Z-5.\nG90\n", "where Z is"),
    ],
    ids=["a cut from where it is", "a distance from where it is"],
)
def test_no_call_comes_back_to_a_height(way: str, why: str) -> None:
    result = through(way, "fanuc-mill")
    assert "CALIBRATE" not in result.titles
    assert any(
        d.code == "CHK002" and "CALIBRATE" in d.message and why in d.message for d in result.diagnostics
    )


def test_calls_of_a_shop_are_not_counted_on_to_come_back() -> None:
    text = f"G21 G90 G94 G17 G40 G80 G54\n{WAYS['down before X and Y']}{CUT}{END}"
    result = filtered(text.encode(), "fanuc-mill")
    assert "CALIBRATE" not in result.titles
    assert "CHK002" in result.codes


@pytest.mark.parametrize(("units", "distance", "every"), [*product((20, 21), (90, 91), (1, 2))])
def test_the_macro_comes_back_over_where_it_was_called(units: int, distance: int, every: int) -> None:
    stand = Stand(FLAT_OK, FLAT_OK.real())
    where_mm = np.array([-150.43, 88.9])
    stand.machine.at = stand.machine.planned = (*where_mm, -30.0)
    for _ in range(every):
        assert stand.run(f"G{units} G{distance}\nG65 P8900 K{every}.") == ""
        stand.machine.catch_up()
        # Nothing finer than 0.0001 inch can be commanded in an inch program.
        np.testing.assert_allclose(stand.machine.at[:2], where_mm, atol=0.002 if units == 20 else 1e-6)
        assert stand.machine.at[2] == 0.0


@pytest.mark.linuxcnc("machine")
def test_the_same_on_the_simulated_linuxcnc(tmp_path: Path) -> None:
    places = {"G21": (-150.4, 88.9), "G20": (-5.5, 3.25)}
    programs = [
        f"M68 E0 Q0\n{units} G90\nG53 G0 X{x} Y{y}\nG91\no<cb_calibrate> call\nG0 X0.1\n(debug, end)\nM2\n"
        for units, (x, y) in places.items()
    ]
    wanted_mm = np.array([(-150.3, 88.9), (-5.4 * 25.4, 3.25 * 25.4)])

    def is_right(runs: list[Run]) -> bool:
        return all(not run.errors and " end" in run.messages for run in runs)

    runs = laser.run_until(
        is_right,
        [program.encode() for program in programs],
        tools=[BAR],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, tmp_path),
    )
    assert is_right(runs)
    np.testing.assert_allclose([run.samples[-1, 1:3] for run in runs], wanted_mm, atol=1e-3)
