"""The Fanuc macros, run on the simulated laser."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chipbreak.dialects import FANUC_MILL, LINUXCNC_MILL, Dialect
from chipbreak.inspection.edges import inward_mm
from chipbreak.macros import ToolValues, macro_files
from chipbreak.syntax.parse import read_block
from laser_simulator.tool import Chip
from longer import first_of_each, short_where
from macro_interpreter import Library

from .cases import (
    BALL,
    BULL,
    CASES,
    CHECKS,
    CHIPS,
    DRILL,
    FINISH_W,
    FLAT,
    ROUGH_W,
    STRAIGHT,
    WITH_A_TWIN,
    Case,
    verdict_table,
)
from .stand import BEAM, SETTINGS, Nominal, Stand, library

NAMED = {case.name: case for case in CASES}
SHAPES = [FLAT, BULL, BALL, DRILL]


def run(
    case: Case, *, reads_ahead: bool = False, sample_s: float = 0.0, programs: Library | None = None
) -> tuple[str, str, str]:
    """The alarm of TOOL CHECK, or those of CHIP CHECK before a rough and before a finish operation."""
    stand = Stand(case.nominal, case.real, settings=case.settings, reads_ahead=reads_ahead, programs=programs)
    stand.machine.sample_s = sample_s
    stand.calibrate()
    stand.station.beam = case.beam
    if case.later is None:
        return stand.check_alone(), "", ""
    assert stand.run("T1 M6") == stand.trace() == ""
    stand.change(case.later)
    return "", stand.chip_check(ROUGH_W), stand.chip_check(FINISH_W)


def said_of(case: Case) -> tuple[str, str, str]:
    """What the checks must say."""
    return case.expected, case.rough, case.finish


@pytest.mark.parametrize(
    "case", short_where(CASES, lambda case: case.name not in WITH_A_TWIN), ids=lambda case: case.name
)
def test_every_tool_gets_its_verdict(case: Case) -> None:
    assert run(case) == said_of(case)


def test_the_table_of_the_manual_is_that_of_the_cases() -> None:
    manual = Path(__file__).parents[2] / "docs" / "measured-tools.md"
    assert verdict_table() in manual.read_text("utf-8")


@pytest.mark.parametrize(
    "case",
    first_of_each([*CHECKS[:14], CHIPS[1]], lambda case: (case.nominal, said_of(case))),
    ids=lambda case: case.name,
)
def test_a_control_that_reads_ahead_comes_to_the_same_verdict(case: Case) -> None:
    assert run(case, reads_ahead=True) == said_of(case)


@pytest.mark.parametrize(
    "case", first_of_each([*CHECKS[6:18], *CHIPS[3:7]], said_of), ids=lambda case: case.name
)
def test_a_signal_seen_a_millisecond_late_changes_no_verdict(case: Case) -> None:
    """0.2 um at the slow feed, and the master bar was measured with the same delay."""
    assert run(case, sample_s=0.001) == said_of(case)


def mutated(name: str, old: str, new: str) -> Library:
    text = macro_files(FANUC_MILL, SETTINGS)[name].decode()
    assert old in text
    changed = Library([text.replace(old, new)])
    changed.programs = library(SETTINGS).programs | changed.programs
    return changed


# Each of these breaks one rule of a check, and the tool beside it shows it.
@pytest.mark.parametrize(
    ("name", "old", "new", "shown_by"),
    [
        ("O8901.nc", "#11=#118-#105-0.4*#169", "#11=#118-#105-1.4*#169", "runout 0.006"),
        ("O8901.nc", "LE ROUND[#109/#135]", "LT ROUND[#109/#135]", "length L+0.000"),
        ("O8901.nc", "GT ROUND[[#109+#137]/#135]", "GE ROUND[[#109+#137]/#135]", "length L+3.000"),
        ("O8901.nc", "LE ROUND[[#107*2.-#138]", "LT ROUND[[#107*2.-#138]", "diameter OD-0.500"),
        ("O8901.nc", "N5 G65 P8909 U#107 C#4", "N5 G65 P8909 C#4", "length L+0.001"),
        ("O8921.nc", "IF [#106 EQ 3] GOTO 1", "#108=0", "drill, a little longer"),
        ("O8921.nc", "IF [#106 EQ 2] GOTO 1", "#108=0", "ball, a little longer"),
        ("O8904.nc", "IF [#6 EQ 2] THEN #108=#107", "", "good ball"),
        ("O8931.nc", "GOTO 26", "GOTO 4", "chip: shortened by 0.03"),
        ("O8915.nc", "LT ROUND[#23/#135]", "LE ROUND[#23/#135]", "chip: exactly 0.02"),
        ("O8923.nc", "#176=#108-#170", "GOTO 9", "chip: too small on a ball"),
        ("O8901.nc", "A[#112+#13*360./#113]", "A0.", "diameter OD-0.498"),
        ("O8920.nc", "#164=0\nN1", "#102=0\nGOTO 4\nN1", "runout 0.006"),
        ("O8925.nc", "IF [ABS[#5023*#100-#110+#7] GT 0.004] GOTO 9", "", "chip: 0.03 on one of four"),
    ],
)
def test_a_broken_macro_is_noticed(name: str, old: str, new: str, shown_by: str) -> None:
    case = NAMED[shown_by]
    assert run(case, programs=mutated(name, old, new)) != said_of(case)


def test_a_macro_that_asks_too_early_is_caught_by_reading_ahead() -> None:
    naive = mutated("O8908.nc", "N1 #11=0\nG90 G53 X[#120/#100]", "N1 #11=0").programs
    asks = Library([b"O9001\nG91 G0 Z-5.\n#500=#5023\nG90\nM99\n"])
    asks.programs |= naive
    seen = {}
    for reads_ahead in (False, True):
        stand = Stand(FLAT, FLAT.real(), reads_ahead=reads_ahead, programs=asks)
        stand.run("G65 P9001\nM30")
        seen[reads_ahead] = stand.control.variables.commons[500]
    assert seen == {False: -5.0, True: 0.0}


@pytest.mark.parametrize("nominal", first_of_each(SHAPES, lambda n: n.kind), ids=lambda n: n.kind.name)
def test_the_stored_shape_is_the_shape_of_each_tooth(nominal: Nominal) -> None:
    """The angle follows the helix, and no tooth is taken for another."""
    chips = (Chip(0, 6.0, 0.11), Chip(nominal.teeth - 1, 12.0, 0.07))
    real = nominal.real(chips=chips)
    stand = Stand(nominal, real, settings=replace(SETTINGS, trace_step_mm=0.5))
    stand.calibrate()
    assert stand.run("T1 M6") == stand.trace() == ""
    heights, radii = stand.stored()
    assert heights[0] == pytest.approx(0.1)
    assert heights[-1] == 20.0
    expected = np.column_stack([real.tooth_radius(k, heights) for k in range(nominal.teeth)])
    # The macro calls that tooth the first which it finds first.
    errors = [np.abs(np.roll(expected, k, axis=1) - radii).max() for k in range(nominal.teeth)]
    assert min(errors) < 0.003  # the tip is known to a micrometre, and a point is flat
    assert max(errors) > 0.05


@pytest.mark.parametrize("nominal", short_where(SHAPES, lambda n: n is BALL), ids=lambda n: n.kind.name)
def test_a_chip_is_as_deep_as_the_measures_of_the_filter_say(nominal: Nominal) -> None:
    """Away from corners, which trace points 0.5 mm apart do not show to anybody; rounded to 1 um."""
    stand = Stand(nominal, nominal.real(), settings=replace(SETTINGS, trace_step_mm=0.5))
    stand.calibrate()
    assert stand.run("T1 M6") == stand.trace(6.0) == ""
    heights, radii = stand.stored()
    stored = np.column_stack([heights, radii[:, 0]])
    for height in heights[[4, 6, 9, -1] if nominal is BALL else [9, -1]]:
        for depth in (0.004, 0.021, 0.06):
            later = nominal.real(chips=(Chip(0, height, depth, 0.4),))
            stand.change(later)
            assert stand.chip_check(0.002) == "CHIP"
            inward = inward_mm(stored, np.column_stack([heights, later.tooth_radius(0, heights)])).max()
            measured = stand.control.variables.commons[104]
            assert measured == pytest.approx(inward, rel=0.01, abs=0.0011), (height, depth)


def in_force(stand: Stand) -> Mapping[object, object]:
    modes = stand.control.modes
    words = {letter: modes.words.get(letter) for letter in "FSTDH"}
    return {**modes.codes, **words, "length": modes.length_mm, "turns": stand.machine.is_turning}


@pytest.mark.parametrize(
    "before",
    [
        "G90 G94 F350. S4000",
        "G91 G95 F0.2 S4000",
        "G20 G90 G94 F20. S4000",
        "G17 G1 G90 G94 F100. S70 G61",
        "G91 G93 G55 G98 G43 H1 S600 F3.",
    ],
)
def test_everything_is_as_it_was_and_the_tool_is_up(before: str) -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.control.length_offsets_mm[1] = 131.0
    stand.run(f"T90 M6\n{before}")
    unit = 25.4 if "G20" in before else 1.0
    calls = ["G65 P8900", f"T1 M6\n{STRAIGHT.data(1)}", "G65 P8901 T1 S5000", f"G65 P8902 T1 Z{4 / unit:g}"]
    for call in [*calls, f"G65 P8903 T1 W{0.02 / unit:g} Z{4 / unit:g}"]:
        stand.run("T1") if "P8900" in call else None
        was = in_force(stand)
        assert stand.run(call) == ""
        now = in_force(stand)
        assert {k: v for k, v in now.items() if k != "T"} == {k: v for k, v in was.items() if k != "T"}
        assert stand.machine.at[2] == 0.0 or "M6" in call


@pytest.mark.parametrize("mode", ["G41", "G68", "G51", "G81"])
def test_no_check_runs_with_compensation_or_a_cycle_on(mode: str) -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    stand.run(f"T1 M6\n{mode}")
    touched = stand.machine.skip_count
    assert stand.check_alone() == "MODES"
    assert stand.machine.skip_count == touched


def test_what_a_call_lacks_is_an_alarm() -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    assert stand.run(f"{STRAIGHT.data(1)}\nG65 P8901 T1 S5000") == "NOT CALIBRATED"
    stand.calibrate()
    stand.run("T1 M6")
    for call in (
        "G65 P8901 T2 S5000",
        "G65 P8901 T1",
        "G65 P8902 T1 S5000",
        "G65 P8902 T1 Z20.",
        "G65 P8903 T1",
    ):
        assert stand.run(f"{STRAIGHT.data(1)}\n{call}") == "CALL", call
    for missing in (" K1.", " D10.", " H50.", " Q4."):
        assert stand.run(STRAIGHT.data(1).replace(f"{missing} ", " ")) == "CALL", missing
    assert stand.run("G65 P8903 T1 W0.02") == "NO EDGE"


def test_a_shape_that_finds_no_room_is_an_alarm() -> None:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.calibrate()
    stand.run("T1 M6")
    for height in (20.0, 4.0, 20.0):  # another size takes another place, the same size the same place
        assert stand.trace(height) == ""
    assert stand.run(f"{STRAIGHT.data(1)}\nG65 P8902 T1 S5000 Z500.") == "NO ROOM"


def test_a_fault_that_goes_away_is_measured_again_before_an_alarm() -> None:
    """A chip on the edge of the tool that the second touch has blown off."""
    stand = Stand(STRAIGHT, STRAIGHT.real(diameter_mm=10.2))
    stand.calibrate()
    stand.run("T1 M6")
    count, real = 0, stand.station.broken

    def broken(tool: int, points: np.ndarray, *angles: np.ndarray) -> np.ndarray:
        nonlocal count
        count += tool == 1 and stand.machine.at[1] == BEAM.y_mm - 5.1
        if count:
            stand.change(STRAIGHT.real())
        return real(tool, points, *angles)

    stand.station.broken = broken  # type: ignore[method-assign]
    assert stand.check_alone() == ""
    assert count


@pytest.mark.parametrize("dialect", [FANUC_MILL, LINUXCNC_MILL], ids=lambda dialect: dialect.name)
def test_no_block_of_tool_data_is_longer_than_a_screen(dialect: Dialect) -> None:
    assert dialect.macros is not None
    widest = ToolValues(99999999, 4, 199.1234, 19.1234, 299.1234, 299.1234, 12, 45.1234)
    blocks = widest.blocks(dialect.macros)
    assert all(60 < len(block) <= 80 or "length" in block for block in blocks), blocks
    assert all(not read_block(0, block, dialect).opaque for block in blocks)


def test_alarms_fit_the_screen_and_their_range() -> None:
    texts = [
        match
        for data in macro_files(FANUC_MILL, SETTINGS).values()
        for match in re.findall(r"#3000=#131(?:\+(\d+))?\((.*)\)", data.decode())
    ]
    assert len(texts) > 15
    assert all(int(number or 0) < 100 and len(text) <= 26 for number, text in texts), texts
    assert all("T#103" in text or number in ("9", "12") for number, text in texts)
