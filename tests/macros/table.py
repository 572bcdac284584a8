"""Faults, tools, controls, units and speeds, judged by the macros and by numpy: do both say the same?

    python tests/macros/table.py [--linuxcnc] [--random N] [-o FILE]

Without options: every tool with every fault, each on eight of the combinations of control, unit and speed.
``--linuxcnc``: every tool with every fault on the simulated LinuxCNC, at its laser and on a touch plate.
``--random N``: N good tools that must pass and N with a runout of 0.010 mm that must not, drawn with a seed.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np

from chipbreak.inspection.edges import judge_edge
from laser_simulator.tool import Chip, Kind, SimulatedTool
from macro_interpreter import CONTROLS, FanucControl
from macros.cases import BALL, BULL, DRILL, FINISH_W, FLAT, ONE_FLUTE, PHASE, REAMER, ROUGH_W, STRAIGHT
from macros.measures import diameter_passes, length_passes, runout_passes
from macros.stand import SETTINGS, Nominal, Stand

ABOVE_MM, HEIGHT_MM = SETTINGS.above_mm, 8.0
TOOLS = {
    "flat": FLAT,
    "straight": STRAIGHT,
    "bull nose": BULL,
    "ball": BALL,
    "drill": DRILL,
    "reamer": REAMER,
    "one flute": ONE_FLUTE,
}
SPEEDS = (400, 1500, 5000, 12000)
PLACES = tuple(itertools.product(CONTROLS, (False, True), SPEEDS))


@dataclass(frozen=True)
class Row:
    """A tool with a fault, before and after its first operation, on a control in a unit at a speed."""

    tool: str
    fault: str
    control: FanucControl
    is_inch: bool
    rpm: int
    real: SimulatedTool
    later: SimulatedTool | None = None

    @property
    def nominal(self) -> Nominal:
        return TOOLS[self.tool]

    @property
    def text(self) -> str:
        unit = "inch" if self.is_inch else "mm"
        return f"{self.tool}, {self.fault}, {self.control.name}, {unit}, S{self.rpm}"


def faults(nominal: Nominal) -> Iterator[tuple[str, SimulatedTool, SimulatedTool | None]]:
    """Each fault: the tool at TOOL CHECK, and where an edge is looked at, what became of it."""
    good = nominal.real()
    yield "good", good, None
    for runout_mm in (0.002, 0.010):
        yield f"runout {runout_mm:.3f}", replace(good, runout_mm=runout_mm, runout_deg=PHASE), None
    for extra_mm in (-0.1, 3.1):
        yield f"length L{extra_mm:+.1f}", nominal.real(length_mm=nominal.length_mm + extra_mm), None
    for extra_mm in (-0.6, 0.1):
        other = nominal.real(diameter_mm=nominal.diameter_mm + extra_mm)
        yield f"diameter OD{extra_mm:+.1f}", other, None
    yield "missing", nominal.real(is_missing=True), None
    last = nominal.teeth - 1
    # As short as must not be missed, and between the heights that are stored.
    for depth_mm, extent_mm in ((0.03, 0.2), (0.06, 0.2), (0.012, 2.0)):
        chip = Chip(last, 3.37, depth_mm, extent_mm)
        yield f"chip {depth_mm:.3f} x {extent_mm}", good, nominal.real(chips=(chip,))
    yield "shorter by 0.03", good, nominal.real(length_mm=good.length_mm - 0.03)


def rows() -> list[Row]:
    """Every tool with every fault, on eight places that change from one to the next."""
    found = []
    for number, (tool, nominal) in enumerate(TOOLS.items()):
        for index, (fault, real, later) in enumerate(faults(nominal)):
            first = number * 12 + index
            for turn in range(8):
                control, is_inch, rpm = PLACES[(first * 5 + turn * 11) % len(PLACES)]
                found.append(Row(tool, fault, control, is_inch, rpm, real, later))
    return found


def by_numpy(row: Row) -> str:
    """The verdict from the measures of the tool: TOOL CHECK, or CHIP CHECK before rough and before finish."""
    if row.later is not None:
        return f"{_chip(row, ROUGH_W)}/{_chip(row, FINISH_W)}"
    nominal, real = row.nominal, row.real
    if real.is_missing or real.length_mm < nominal.length_mm - SETTINGS.search_mm:
        return "NO CONTACT"
    radius = nominal.diameter_mm / 2.0
    height = _corner(nominal) + ABOVE_MM
    if not runout_passes(min(float(real.envelope(height)), radius + SETTINGS.clear_mm), radius):
        return "RUNOUT"
    if not length_passes(real.length_mm, nominal.length_mm):
        return "SHORT" if real.length_mm <= nominal.length_mm else "LONG"
    teeth = [float(real.tooth_radius(k, height)) for k in range(real.teeth)]
    across = [teeth[k] + teeth[(k + real.teeth // 2) % real.teeth] for k in range(real.teeth)]
    if not diameter_passes(across, nominal.diameter_mm):
        return "THIN" if max(across) < nominal.diameter_mm else "THICK"
    return ""


def _corner(nominal: Nominal) -> float:
    """From how high on the tool is as thick as it gets."""
    radius = nominal.diameter_mm / 2.0
    if nominal.kind is Kind.DRILL:
        return radius / float(np.tan(np.radians(nominal.tip / 2.0)))
    return radius if nominal.kind is Kind.BALL else nominal.tip


def _chip(row: Row, limit_mm: float) -> str:
    """A tip or an edge that is W or more inside what it was."""
    assert row.later is not None
    if row.real.length_mm - row.later.length_mm >= limit_mm - 1e-9:
        return "CHIP"
    heights = np.arange(ABOVE_MM, HEIGHT_MM, 0.02)
    for tooth in range(row.real.teeth):
        shapes = [
            np.column_stack([heights, one.tooth_radius(tooth, heights)]) for one in (row.real, row.later)
        ]
        if judge_edge(shapes[0], shapes[1], limit_mm).is_chipped:
            return "CHIP"
    return ""


def by_macros(row: Row) -> str:
    """The verdict of the macros."""
    stand = stand_of(row)
    if row.later is None:
        return stand.check_alone()
    stand.run("T1 M6")
    traced = stand.trace(HEIGHT_MM)
    if traced:
        return f"TRACE {traced}"
    stand.change(row.later)
    return f"{stand.chip_check(ROUGH_W)}/{stand.chip_check(FINISH_W)}"


def stand_of(row: Row) -> Stand:
    """A control that has calibrated, in front of the tool."""
    # What an inch machine tells apart is 0.0001 inch, whatever the program counts in.
    grid_mm = row.control.grid_mm(is_inch=row.control.is_inch_machine)
    settings = replace(SETTINGS, trace_step_mm=0.5, resolution_mm=max(0.001, grid_mm))
    stand = Stand(
        row.nominal, row.real, settings=settings, control=row.control, is_inch=row.is_inch, rpm=row.rpm
    )
    stand.calibrate()
    return stand


def drawn(count: int, runout_mm: tuple[float, float]) -> list[Row]:
    """Good tools with 2 to 8 teeth at 400 to 12,000 rpm, with a runout toward one of their teeth."""
    rng = np.random.default_rng(20)
    found = []
    for number in range(count):
        teeth = int(rng.integers(2, 9))
        helix_deg = float(rng.uniform(0.0, 45.0))
        nominal = Nominal(diameter_mm=float(rng.integers(4, 21)), teeth=teeth, helix_deg=helix_deg)
        TOOLS[f"drawn {number}"] = nominal
        phase_deg = float(rng.uniform(0.0, 360.0))
        above = nominal.real(phase_deg=phase_deg)
        runout = float(rng.uniform(*runout_mm))
        # The tooth that stands out is out at the height that is measured.
        toward = float(above.tooth_angle(int(rng.integers(teeth)), ABOVE_MM))
        real = replace(above, runout_mm=runout, runout_deg=toward)
        control, is_inch, _ = PLACES[int(rng.integers(len(PLACES)))]
        rpm = round(float(np.exp(rng.uniform(np.log(400.0), np.log(12000.0)))))
        found.append(Row(f"drawn {number}", f"runout {runout:.4f}", control, is_inch, rpm, real))
    return found


def _judge(row: Row) -> tuple[Row, str, str]:
    TOOLS.setdefault(row.tool, Nominal())
    return row, by_macros(row), by_numpy(row)


def _judge_drawn(pair: tuple[Row, Nominal]) -> str:
    TOOLS[pair[0].tool] = pair[1]
    return by_macros(pair[0])


def _drawn_tools(pool: Executor, count: int) -> tuple[list[str], int]:
    """What good and bad tools at random came to, and how many of them wrongly."""
    lines: list[str] = []
    wrong = 0
    for name, runout_mm, expected in (("good", (0.0, 0.004), ""), ("runout", (0.01, 0.01), "RUNOUT")):
        pairs = [(row, TOOLS[row.tool]) for row in drawn(count, runout_mm)]
        said = list(pool.map(_judge_drawn, pairs, chunksize=20))
        bad = [pair[0].text for pair, one in zip(pairs, said, strict=True) if one != expected]
        wrong += len(bad)
        lines += [f"{name}: {len(said) - len(bad)} of {len(said)} {expected or 'pass'}", *bad]
    return lines, wrong


def _whole_table(pool: Executor) -> tuple[list[str], int]:
    """A line a row, and how many of them differ from what numpy says."""
    lines: list[str] = []
    wrong = 0
    for row, macros, truth in pool.map(_judge, rows(), chunksize=4):
        wrong += macros != truth
        mark = "" if macros == truth else "  <-- numpy says " + truth
        lines.append(f"{row.text}: {macros or 'passes'}{mark}")
    lines.append(f"{len(lines)} rows, {wrong} differ")
    return lines, wrong


def _asked_table(pool: Executor, asked: argparse.Namespace) -> tuple[list[str], int]:
    if asked.linuxcnc:
        import linuxcnc
        from macros import lc_table

        return lc_table.table(pool) if linuxcnc.available() else (["LinuxCNC is not here: left out"], 0)
    return _drawn_tools(pool, asked.random) if asked.random else _whole_table(pool)


def main() -> int:
    """Write the table, or what the drawn tools came to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--linuxcnc", action="store_true")
    parser.add_argument("-o", "--output", type=Path)
    asked = parser.parse_args()
    with ProcessPoolExecutor(2) as pool:
        lines, wrong = _asked_table(pool, asked)
    text = "\n".join(lines) + "\n"
    sys.stdout.write(text if asked.output is None else lines[-1] + "\n")
    if asked.output is not None:
        asked.output.write_text(text)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
