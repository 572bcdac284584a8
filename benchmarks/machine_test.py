"""Machines whose numbers are drawn at random, measured by the machine test, and new cuts on them.

``python benchmarks/machine_test.py [COUNT [KLIPPER [LINUXCNC [FIRST]]]]``: so many of each sort.  Each runs
the program of ``chipbreak machine-test write``; ``read`` makes a profile of a trace with noise (of Klipper:
of its times), and cuts that are promised with this profile are run on the machine: N, stroke and verdict as
promised and as run; and how many of the numbers of the machines with filters lie within the uncertainty that
was said.  Klipper's planner and LinuxCNC's simulated machine are left out where they are not here.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from bench_machine import Kept, drawn_cut, drawn_machine, fanuc_cut, held, measured_profile
from bench_planners import (
    PLANNER,
    drawn_klipper,
    klipper_cut,
    klipper_profile,
    linuxcnc_cuts,
    linuxcnc_profile,
)
from linuxcnc import machine

CUTS = 3
TRIES = 20


class OneMachine(NamedTuple):
    """What it is called, its cuts, and which of its numbers lie within what was said of them."""

    name: str
    cuts: list[Kept]
    held: list[bool]


Sort = Callable[[np.random.Generator, Path], OneMachine]


def _so_many(cut: Callable[[], Kept | None]) -> list[Kept]:
    found: list[Kept] = []
    for _ in range(TRIES):
        kept = cut()
        found += [kept] if kept is not None else []
        if len(found) == CUTS:
            break
    return found


def on_fanuc(draw: np.random.Generator, folder: Path) -> OneMachine:
    """A machine with acc/dec filters, stepped through time."""
    name, one = drawn_machine(draw)
    profile = measured_profile(one, draw, folder)
    settling_s = sum(one.averages_s) + 7.0 * sum(one.lags_s)
    cuts = _so_many(lambda: fanuc_cut(drawn_cut(draw, settling_s), profile, one))
    return OneMachine(name, cuts, held(one, folder))


def on_klipper(draw: np.random.Generator, folder: Path) -> OneMachine:
    """Klipper's own planner."""
    one = drawn_klipper(draw)
    profile = klipper_profile(one, draw, folder)
    return OneMachine("junction, Klipper", _so_many(lambda: klipper_cut(one, profile, draw)), [])


def on_linuxcnc(draw: np.random.Generator, folder: Path) -> OneMachine:
    """LinuxCNC's simulated machine."""
    acceleration_mm_s2 = float(draw.uniform(2000.0, 15000.0))
    profile = linuxcnc_profile(acceleration_mm_s2, folder)
    return OneMachine("linuxcnc", linuxcnc_cuts(acceleration_mm_s2, profile, draw), [])


def _measured(sort: Sort, seed: int, folder: Path) -> OneMachine:
    """A machine and its cuts; none where the test refuses what it sees."""
    try:
        return sort(np.random.default_rng(seed), folder)
    except AssertionError as error:
        return OneMachine(f"{sort.__name__}, refused: {str(error).splitlines()[0]}", [], [])


def main(fanuc: int = 30, klipper: int = 10, linuxcnc: int = 3, first: int = 0) -> None:
    """A line a machine, and the sums; machines number ``first`` and on."""
    sorts: list[tuple[Sort, int]] = [
        (on_fanuc, fanuc),
        (on_klipper, klipper if (PLANNER / "klippy" / "toolhead.py").is_file() else 0),
        (on_linuxcnc, linuxcnc if machine.available() else 0),
    ]
    print("| machine | N off by at most % | stroke off by at most % | verdicts as promised |")
    print("| --- | --- | --- | --- |")
    every: list[Kept] = []
    within: list[bool] = []
    for sort, count in sorts:
        for seed in range(first, first + count):
            with tempfile.TemporaryDirectory() as folder:
                name, found, own = _measured(sort, seed, Path(folder))
            every += found
            within += own
            counts = max((one.count_error for one in found), default=0.0)
            strokes = max((one.stroke_error for one in found), default=0.0)
            same = sum(one.same_verdict for one in found)
            row = f"| {name} {seed} | {100 * counts:.2f} | {100 * strokes:.1f} | {same} of {len(found)} |"
            print(row, flush=True)
    print(
        f"{len(every)} cuts: N within 1 % {sum(one.count_error <= 0.01 for one in every)},"
        f" stroke within 5 % {sum(one.stroke_error <= 0.05 for one in every)},"
        f" verdict {sum(one.same_verdict for one in every)},"
        f" {sum(one.is_on_edge for one in every)} of them said to be on the edge;"
        f" chips break in {sum(one.run[2] for one in every)};"
        f" {sum(within)} of {len(within)} numbers within what was said of them"
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
