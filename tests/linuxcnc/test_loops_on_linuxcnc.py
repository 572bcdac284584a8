"""The loop form on LinuxCNC: the same moves to its interpreter, the promised chips on its machine."""

from __future__ import annotations

import numpy as np
import pytest

import chipbreak

from . import rs274
from .test_vibration_on_machine import what_went_wrong
from .vibrated import CHAMFER, FACING, INCREMENTAL, SHOULDER, TAPER, TURNING, Job

LOOP = "output.form=loop"
CANON_MM = 1e-4  # canonical calls have four decimals
STEP_MM = 1e-4


def moves(result: chipbreak.Result) -> list[rs274.Motion]:
    judgement = rs274.judge(result.data, lathe=True)
    assert (judgement.accepted, judgement.message) == (True, "")
    return judgement.motion


@pytest.mark.linuxcnc
@pytest.mark.parametrize(
    ("job", "is_alike"),
    [
        pytest.param(Job(TURNING, 1250, "N1.5", 10000), True, id="turning"),
        pytest.param(Job(TURNING, 480, "N3.5", 10000, ("output.feed_mode=minute",)), True, id="minute"),
        pytest.param(Job(INCREMENTAL, 750, "N2.5", 10000, ("output.feed_mode=inverse",)), True, id="inverse"),
        pytest.param(Job(FACING, 1250, "N1.5", 20000, ("vibration.waveform=sine",)), True, id="sine"),
        pytest.param(Job(SHOULDER, 1250, "N1.5", 20000), True, id="shoulder"),
        pytest.param(Job(TAPER, 1250, "N1.5", 10000), False, id="taper"),
        pytest.param(Job(CHAMFER, 1250, "N1.5", 20000), False, id="chamfer"),
    ],
)
def test_the_canonical_moves_are_those_of_the_expanded_form(job: Job, is_alike: bool) -> None:
    expanded, loop = job.filtered(), job.filtered(LOOP)
    assert b" repeat [" in loop.data
    one, other = moves(expanded), moves(loop)
    assert [move.kind for move in one] == [move.kind for move in other]
    gap = np.array([(a.x_mm - b.x_mm, a.z_mm - b.z_mm) for a, b in zip(one, other, strict=True)])
    # One step of the output where a place is rounded the other way, and one of the canonical calls.
    assert np.abs(gap).max() <= STEP_MM + CANON_MM + 1e-9
    if is_alike:
        # Half a step of a diameter is what canonical calls round.
        same = CANON_MM * (1.01 if job.shape.units == "G7" else 0.01)
        assert (np.abs(gap).max(axis=1) > same).mean() < 0.02
    ends = [i for i, move in enumerate(one) if move.kind != "feed"]
    assert gap[ends] == pytest.approx(np.zeros((len(ends), 2)), abs=1e-9)
    for a, b in zip(one, other, strict=True):
        modes = (a.per_rev, a.speed, a.surface, a.path_mode)
        assert modes == (b.per_rev, b.speed, b.surface, b.path_mode)
        assert a.feed == pytest.approx(b.feed, rel=0.05)
    assert sum(a.time_s for a in one) == pytest.approx(sum(b.time_s for b in other), rel=1e-3)


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    "which", [slice(0, None, 5), pytest.param(slice(None), marks=pytest.mark.long)], ids=["few", "all"]
)
def test_every_promise_is_kept(which: slice) -> None:
    jobs = [
        Job(TURNING, 1250, "N1.5", 10000, (LOOP,)),
        Job(TURNING, 500, "N3.5", 10000, (LOOP, "output.feed_mode=minute")),
        Job(FACING, 1250, "N1.5", 20000, (LOOP, "vibration.waveform=sine")),
        Job(INCREMENTAL, 750, "N2.5", 10000, (LOOP, "output.feed_mode=inverse")),
        Job(TAPER, 1250, "N1.5", 10000, (LOOP,)),
        Job(SHOULDER, 1250, "N1.5", 20000, (LOOP,)),
    ]
    for job in jobs:
        (cut,) = job.filtered().cuts
        assert cut.expansion.loops, job
    assert what_went_wrong(jobs[which]) == []
