"""The dwell form on LinuxCNC: its interpreter waits where it should, and on its machine the chips break.

LinuxCNC waits by the clock of its task, not of the servo thread: a dwell takes a few milliseconds more than
G4 says, and on a busy computer now and then a few less.  So the simulation runs at its own speed here, and
what is promised is that every chip ends, not the frequency to a percent.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from . import rs274
from .vibrated import CHAMFER, FACING, SHOULDER, TURNING, Job, Outcome, run

DWELL, LOOP = "vibration.waveform=dwell", "output.form=loop"
EXACT_MM, NEAR_MM = 1e-6, 0.002
JOBS = [
    Job(TURNING, 1200, "E2.6", 2000, (DWELL,)),
    Job(TURNING, 1200, "E3", 2000, (DWELL, LOOP, "vibration.end=dwell")),
    Job(FACING, 1200, "E3", 5000, (DWELL, "vibration.alpha=0.4")),
    Job(CHAMFER, 900, "E2.6", 5000, (DWELL, "output.feed_mode=minute")),
    Job(SHOULDER, 1200, "E3", 5000, (DWELL,)),
]


@pytest.mark.linuxcnc
@pytest.mark.parametrize("job", JOBS, ids=str)
def test_the_interpreter_waits_as_promised(job: Job) -> None:
    result = job.filtered()
    (cut,) = result.cuts
    judgement = rs274.judge(result.data, lathe=True)
    assert (judgement.accepted, judgement.message) == (True, "")
    inside = [m for m in judgement.motion if m.path_mode == "G61"]
    waits = [m.time_s for m in inside if m.kind == "dwell"]
    planned = cut.expansion.dwell_s
    assert waits == pytest.approx(planned[planned > 0.0].tolist())
    assert {m.feed for m in inside if m.kind == "feed"} == {0.1}
    moves_s = sum(m.time_s for m in inside if m.kind == "feed")
    assert moves_s == pytest.approx(job.shape.length_mm / 0.1 / inside[-1].speed * 60.0, rel=1e-3)


def stands_s(outcome: Outcome) -> np.ndarray:
    """How long the axes were still, each time, between the first move and the last."""
    moving = np.flatnonzero(np.diff(outcome.along_mm) != 0.0)
    still = np.array([b - a - 1 for a, b in pairwise(moving) if b - a > 5], float)
    return still * 0.001


def broken_promises(outcome: Outcome) -> list[str]:
    cut, verdict = outcome.promise.wave, outcome.promise.verdict
    stands, rev_s = stands_s(outcome), 60.0 / cut.speed_rpm
    chips = outcome.chips(settled=1.0)
    found = {
        "an operator error": not outcome.errors,
        "the verdict": verdict.breaks,
        "the number of stands": len(stands) == cut.vibrations,
        "a revolution in each": stands.min(initial=np.inf) >= rev_s,
        "the mean stand": abs(stands.mean() / verdict.margin / rev_s - 1.0) <= 0.1,
        "the chips": chips.broken >= len(stands) - 4,
        "the longest chip": chips.longest_rev <= verdict.longest_chip_rev + 0.3,
        "start and end": outcome.gap_mm <= EXACT_MM,
        "the path": outcome.off_mm <= NEAR_MM,
        "back": np.diff(outcome.along_mm).min() >= -EXACT_MM,
        "the time": abs(outcome.time_s[-1] / outcome.promise.duration_s - 1.0) <= 0.06,
    }
    said = f"({stands.min():.3f} to {stands.max():.3f} s, {chips}, {verdict}, {outcome.time_s[-1]} s)"
    return [f"{outcome.job}: {what} {said}" for what, kept in found.items() if not kept]


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("jobs", [JOBS[1::2], pytest.param(JOBS, marks=pytest.mark.long)], ids=["few", "all"])
def test_every_chip_ends(jobs: list[Job]) -> None:
    wrong = {outcome.job: broken_promises(outcome) for outcome in run(jobs, speed=1.0)}
    for _ in range(3):  # a busy computer lets the task oversleep
        suspects = [job for job, found in wrong.items() if found]
        wrong |= {one.job: broken_promises(one) for one in run(suspects, speed=1.0)}
    assert [promise for found in wrong.values() for promise in found] == []
