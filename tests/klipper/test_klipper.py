"""Vibrated cuts for Klipper, run by Klipper's own planner: what was promised of time and N, it does.

The planner runs in a process of its own and is no part of this project; see install.sh.
"""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import chipbreak
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.law import AxisLimits

HERE = Path(__file__).parent
PLANNER = Path(os.environ.get("CHIPBREAK_KLIPPER") or HERE.parents[1] / ".venv" / "klipper")
SHARE = 0.003

pytestmark = [
    pytest.mark.klipper,
    pytest.mark.skipif(
        not (PLANNER / "klippy" / "toolhead.py").is_file(),
        reason="Klipper's planner is not here: sh tests/klipper/install.sh",
    ),
]


class Machine(NamedTuple):
    """Limits [mm/s, mm/s²]."""

    max_velocity: float
    max_accel: float
    corner_velocity: float
    min_cruise_ratio: float
    max_z_velocity: float
    max_z_accel: float

    @property
    def sets(self) -> list[str]:
        """The same in a profile."""
        return [
            f"planner.path_velocity_mm_min={self.max_velocity * 60.0}",
            f"planner.path_acceleration_mm_s2={self.max_accel}",
            f"planner.corner_velocity_mm_s={self.corner_velocity}",
            f"planner.min_cruise_ratio={self.min_cruise_ratio}",
            f"axes.Z.max_velocity_mm_min={self.max_z_velocity * 60.0}",
            f"axes.Z.max_acceleration_mm_s2={self.max_z_accel}",
        ]


MACHINES = [
    Machine(300.0, 3000.0, 5.0, 0.5, 100.0, 3000.0),
    Machine(100.0, 2000.0, 2.0, 0.5, 50.0, 1000.0),
    Machine(200.0, 5000.0, 8.0, 0.0, 60.0, 2500.0),
    Machine(200.0, 8000.0, 5.0, 0.75, 200.0, 8000.0),
]
# Chains from X10 Z2 on: their blocks without F.
CHAINS = {
    "along": ["G1 Z-2."],
    "taper": ["G1 X10.9 Z-1.7"],
    "facing": ["G1 X5."],
    "corner": ["G1 Z-0.5", "G1 X12."],
    "chamfer": ["G1 Z-0.5", "G1 X10.4 Z-0.9", "G1 X12."],
    "shallow corners": ["G1 X10.1 Z0.5", "G1 X10.15 Z-0.5", "G1 X10.6 Z-1.5"],
    "arc": ["G3 X13. Z-1. R3."],
    "fillet": ["G1 Z-0.5", "G2 X11. Z-1.5 R1.", "G1 X13."],
    "two arcs": ["G3 X11.5 Z0.5 R1.5", "G2 X13. Z-1. R1.5"],
}
CASES = [
    (machine, name, speed, count)
    for number, machine in enumerate(MACHINES)
    for name in CHAINS
    for speed, count in ((600, 1.5), (900, 0.5) if number % 2 else (480, 2.5))
]


def program(name: str, speed: int, count: float) -> str:
    """A chain at 0.1 mm a revolution."""
    first, *others = CHAINS[name]
    blocks = "\n".join([f"{first} F{0.1 * speed:g}", *others])
    return (
        f"G21\nG90\nG18\nM3 S{speed}\nG0 X10. Z2.\n; VIB N{count}\n{blocks}\n; VIB OFF\nG1 F{0.1 * speed:g}\n"
        "G0 X30.\n"
    )


def moves(text: str) -> Iterator[list[float]]:
    """Ends and speeds [mm/s] of the moves of the change, read from the text alone."""
    place = {"X": 10.0, "Y": 0.0, "Z": 2.0}
    feed = 0.0
    for line in text.split("CHIPBREAK BEGIN VIB")[1].split("CHIPBREAK END", maxsplit=1)[0].splitlines()[1:]:
        words = {letter: float(number) for letter, number in re.findall(r"([A-Z])(-?[0-9.]+)", line)}
        if line.startswith("G1 "):
            feed = words.get("F", feed)
            place |= {axis: words[axis] for axis in "XYZ" if axis in words}
            yield [*place.values(), feed / 60.0]


class Run(NamedTuple):
    """What was promised, and the times of the moves in Klipper [s]."""

    cut: Any
    times_s: np.ndarray


@pytest.fixture(scope="module")
def runs() -> dict[int, Run | str]:
    """Every case that is not refused, by its number; of the others the code."""
    found: dict[int, Run | str] = {}
    asked: list[str] = []
    cuts = {}
    for number, (machine, name, speed, count) in enumerate(CASES):
        profile = chipbreak.load("klipper", machine.sets)
        try:
            result = chipbreak.rewrite(program(name, speed, count).encode(), profile)
        except chipbreak.ProgramRejectedError as error:
            found[number] = error.diagnostics[-1].code
            continue
        (cuts[number],) = result.cuts
        told = {"start": [10.0, 0.0, 2.0], "moves": list(moves(result.data.decode()))}
        asked.append(json.dumps(machine._asdict() | told))
    for (number, cut), times_s in zip(cuts.items(), run_by_klipper(asked), strict=True):
        found[number] = Run(cut, times_s)
    return found


def run_by_klipper(asked: list[str]) -> list[np.ndarray]:
    """The times of the moves of each of these [s]."""
    command = [sys.executable, "-I", str(HERE / "planner.py"), str(PLANNER)]
    answer = subprocess.run(command, input="\n".join(asked), capture_output=True, text=True, check=True)
    return [np.array(json.loads(line)) for line in answer.stdout.splitlines()]


def test_at_least_sixty_chains_are_run(runs: dict[int, Run | str]) -> None:
    refused = [one for one in runs.values() if isinstance(one, str)]
    assert len(runs) - len(refused) >= 60, refused


@pytest.mark.parametrize("number", range(len(CASES)), ids=lambda n: f"{CASES[n][1]}-{n}")
def test_time_and_count_are_as_promised(runs: dict[int, Run | str], number: int) -> None:
    run = runs[number]
    if isinstance(run, str):
        assert run in {"VIB030", "VIB034"}
        return
    cut, times_s = run
    assert len(times_s) == cut.move_count
    assert times_s.sum() == pytest.approx(cut.duration_s, rel=SHARE)
    ways = np.diff(cut.expansion.distance_mm, prepend=0.0)
    turns = np.flatnonzero((ways[:-1] > 0.0) & (ways[1:] < 0.0))  # the crests
    first, last = len(turns) // 4, len(turns) - 1 - len(turns) // 4
    ends_s = np.cumsum(times_s)[turns]
    count = (last - first) / (ends_s[last] - ends_s[first]) * 60.0 / cut.plan.solution.speed_rpm
    assert count == pytest.approx(cut.plan.solution.per_rev, rel=SHARE)
    assert count == pytest.approx(cut.verdict.per_rev, rel=SHARE)


@pytest.mark.parametrize("count", [12, 2000])
@pytest.mark.parametrize("number", range(len(MACHINES)))
def test_moves_of_any_length_and_feed_take_as_long(number: int, count: int) -> None:
    """Slow ones behind fast ones too, and as many as running sums lose digits in."""
    machine = MACHINES[number]
    draw = np.random.default_rng(number)
    moved = draw.random((count, 3)) * draw.choice([0.05, 0.2, 1.0, 3.0, -1.0], (count, 3))
    moved[:, 1] = 0.0
    moved[:, 2] *= draw.choice([0.0, 0.02, 1.0, -1.0], count)
    speeds = draw.choice([2.0, 10.0, 40.0, 200.0], count)
    points = np.cumsum(moved, axis=0)
    told = {"start": [0.0, 0.0, 0.0], "moves": np.column_stack([points, speeds]).tolist()}
    (times_s,) = run_by_klipper([json.dumps(machine._asdict() | told)])
    law = Junction(
        corner_velocity_mm_s=machine.corner_velocity,
        min_cruise_ratio=machine.min_cruise_ratio,
        path_velocity_mm_s=machine.max_velocity,
        path_acceleration_mm_s2=machine.max_accel,
    )
    free = AxisLimits("", math.inf, math.inf)
    law = law.along(
        (1.0, 0.0, 1.0), (free, free, AxisLimits("Z", machine.max_z_velocity, machine.max_z_accel))
    )
    ahead = np.sqrt((moved**2).sum(axis=1))
    motion = law.motion(np.append(0.0, np.cumsum(ahead)), law.blocks(moved, ahead), speeds)
    assert motion.spans_s == pytest.approx(times_s, rel=1e-4, abs=1e-6)
