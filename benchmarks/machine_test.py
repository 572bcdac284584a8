"""Machines whose numbers are drawn at random, measured by the machine test, and new cuts on them.

``python benchmarks/machine_test.py [COUNT]``: for each machine a trace with noise is recorded of the program
of ``chipbreak machine-test write``, ``read`` makes a profile of it, and cuts that are promised with this
profile are run on the machine: N, stroke and verdict as promised and as run.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from bench_machine import Kept, drawn_cut, drawn_machine, fanuc_cut, measured_profile

CUTS = 3
TRIES = 20


def cuts_on(seed: int) -> tuple[str, list[Kept]]:
    """What a machine is called, and what it made of its cuts; none where the test refused it."""
    draw = np.random.default_rng(seed)
    name, machine = drawn_machine(draw)
    settling_s = sum(machine.averages_s) + 7.0 * sum(machine.lags_s)
    found: list[Kept] = []
    with tempfile.TemporaryDirectory() as folder:
        try:
            profile = measured_profile(machine, draw, Path(folder))
        except AssertionError as error:
            return f"{name}, refused: {str(error).splitlines()[0]}", []
        for _ in range(TRIES):
            kept = fanuc_cut(drawn_cut(draw, settling_s), profile, machine)
            found += [kept] if kept is not None else []
            if len(found) == CUTS:
                break
    return name, found


def main(count: int) -> None:
    """A line a machine, and the sums."""
    print("| machine | N off by at most % | stroke off by at most % | verdicts as promised |")
    print("| --- | --- | --- | --- |")
    every: list[Kept] = []
    for seed in range(count):
        name, found = cuts_on(seed)
        every += found
        counts = max((one.count_error for one in found), default=0.0)
        strokes = max((one.stroke_error for one in found), default=0.0)
        same = sum(one.same_verdict for one in found)
        print(
            f"| {seed} {name} | {100 * counts:.2f} | {100 * strokes:.1f} | {same} of {len(found)} |",
            flush=True,
        )
    print(
        f"{len(every)} cuts: N within 1 % {sum(one.count_error <= 0.01 for one in every)},"
        f" stroke within 5 % {sum(one.stroke_error <= 0.05 for one in every)},"
        f" verdict {sum(one.same_verdict for one in every)}"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
