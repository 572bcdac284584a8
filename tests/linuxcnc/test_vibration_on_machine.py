"""Filtered programs on LinuxCNC's simulated machine: its motion cuts the chips that were promised.

What is compared is what the filter says and what an independent reckoning (``chips.py``) makes of the sampled
positions.  None of it depends on how fast the simulation runs.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

import chipbreak

from . import machine
from .settled import SPEEDS, UNSETTLED, Seen, is_settled, tries_of
from .vibrated import (
    ARC,
    FACING,
    NAIVE,
    SHOULDER,
    TAPER,
    TURNING,
    VELOCITY_MM_S,
    Job,
    Outcome,
    few_of_the_grid,
    grid,
    run,
)

NEAR_MM = 0.002
EXACT_MM = 1e-6
SPED_UP = math.inf  # each job as fast as its blocks allow
ALL = pytest.param(slice(None), marks=pytest.mark.long)


def broken_promises(outcome: Outcome) -> list[str]:
    """What the machine did otherwise than the filter said; empty when all is well."""
    promise, shape = outcome.promise, outcome.job.shape
    cut, verdict = promise.wave, promise.verdict
    vibration, chips, settled = outcome.vibration(), outcome.chips(), outcome.chips(settled=3.0)
    start_s, end_s = outcome.window_s
    vibrations = (end_s - start_s) / cut.period_s
    per_rev = vibration.frequency_hz * 60.0 / cut.speed_rpm
    thickest = settled.thickest_mm / cut.feed_mm_rev
    turns_back = verdict.per_rev > 0.0
    found = {
        "an operator error": not outcome.errors,
        "the verdict": verdict.breaks == outcome.job.breaks,
        "the frequency": not turns_back or abs(vibration.frequency_hz * cut.period_s - 1.0) <= 0.01,
        "N": not turns_back or abs(per_rev / promise.plan.solution.per_rev - 1.0) <= 0.01,
        "the number of turns": abs(vibration.turns - vibrations * turns_back) <= 1.0,
        "the stroke": not turns_back or np.all(np.abs(vibration.strokes_mm / cut.stroke_mm - 1.0) <= 0.05),
        "the chips": abs(chips.broken - vibrations * verdict.breaks) <= 1.0,
        "the longest chip": not verdict.breaks
        or abs(settled.longest_rev / verdict.longest_chip_rev - 1.0) <= 0.05,
        "the thickest chip": abs(thickest / verdict.peak_thickness - 1.0) <= 0.05,
        "start and end": outcome.gap_mm <= EXACT_MM,
        "the path": outcome.off_mm <= NEAR_MM,
        "before the start": outcome.along_mm.min() >= -NEAR_MM,
        "past the end": outcome.along_mm.max() <= shape.length_mm + NEAR_MM,
        "the time": abs(outcome.time_s[-1] / promise.duration_s - 1.0) <= 0.02,
    }
    said = f"({vibration}, {chips}, {verdict}, {outcome.time_s[-1]} s)"
    return [f"{outcome.job}: {what} {said}" for what, kept in found.items() if not kept]


def what_went_wrong(jobs: list[Job]) -> list[str]:
    """The broken promises of all jobs: sped up first, and what went wrong again without (settled.py)."""
    tries = tries_of(jobs, _judged, (SPED_UP, *SPEEDS))
    wrong = [promise for found in tries.values() for promise in found[-1].misses]
    return wrong + [f"{job}: {UNSETTLED}" for job, found in tries.items() if not is_settled(found)]


class Judged(NamedTuple):
    """What a run broke; the text says every figure, so that it is the same for the same motion alone."""

    misses: tuple[str, ...]

    def is_like(self, other: Seen) -> bool:
        return self.misses == other.misses


def _judged(jobs: Sequence[Job], speed: float) -> dict[Job, Judged]:
    outcomes = run(jobs, speed=None if speed == SPED_UP else speed)
    return {outcome.job: Judged(tuple(broken_promises(outcome))) for outcome in outcomes}


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    ("jobs", "least"),
    [(few_of_the_grid(), 10), pytest.param(grid(), 24, marks=pytest.mark.long)],
    ids=["few", "all"],
)
def test_every_promise_is_kept(jobs: list[Job], least: int) -> None:
    assert len(jobs) >= least
    assert any(not job.breaks for job in jobs)

    assert what_went_wrong(jobs) == []


def test_the_few_meet_every_shape_feed_mode_and_path_mode() -> None:
    few, whole = few_of_the_grid(), grid()
    assert {job.shape for job in few} == {job.shape for job in whole}
    assert {one for job in few for one in job.sets} == {one for job in whole for one in job.sets}
    assert sum(not job.breaks for job in whole) >= 3


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("which", [slice(0, None, 3), ALL], ids=["few", "all"])
def test_what_is_too_fast_is_refused_and_the_way_out_works(which: slice) -> None:
    minute, uneven, sine = "output.feed_mode=minute", "vibration.alpha=0.75", "vibration.waveform=sine"
    too_fast = [
        Job(TURNING, 2500, "N1.5", 2000),
        Job(TURNING, 2500, "N1.5", 5000),
        Job(TURNING, 1250, "N1.5", 2000, (sine,)),
        Job(TURNING, 2500, "N1.25", 10000, (uneven,)),
        Job(TURNING, 2500, "N0.5 Q4", 3000),
        Job(FACING, 1250, "N1.5", 2000, (minute,)),
        Job(ARC, 1250, "N1.5", 2000),
    ]
    advised = []
    for job in too_fast[which]:
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            job.filtered()
        (refusal,) = caught.value.diagnostics
        assert refusal.code == "VIB030"
        needs, has = map(float, re.findall(r"(?:needs|has) ([0-9.]+) m/s2", refusal.message))
        assert has * 1000 == job.acceleration_mm_s2 < needs * 1000
        works = re.search(r"works at f ([0-9.]+) Hz, S ([0-9]+)", refusal.help)
        assert works, refusal.help
        advised.append(replace(job, speed_rpm=float(works[2])))
        solution = advised[-1].filtered().cuts[0].plan.solution
        assert solution.frequency_hz == pytest.approx(float(works[1]), rel=1e-4)
        assert solution.speed_rpm == float(works[2])

    assert what_went_wrong(advised) == []


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("which", [slice(0, 2), ALL], ids=["few", "all"])
def test_a_chip_that_only_just_breaks_breaks(which: slice) -> None:
    """With little to spare, what the control takes from the stroke must have been reckoned with."""
    jobs = []
    cases = ((TURNING, 20000.0), (SHOULDER, 20000.0), (TURNING, 5000.0), (TAPER, 10000.0))[which]
    for shape, acceleration in cases:
        for ratio in np.arange(1.0, 1.13, 0.01):
            job = Job(shape, 1250, f"N1.5 Q{ratio:.2f}", acceleration)
            try:
                job.filtered()
            except chipbreak.ProgramRejectedError as error:
                assert {d.code for d in error.diagnostics} == {"VIB060"}
            else:
                jobs.append(job)
                break
    assert len(jobs) == len(cases)
    margins = [job.filtered().cuts[0].verdict.margin for job in jobs]
    assert min(margins) >= 1.0
    assert max(margins) < 1.03
    assert what_went_wrong(jobs) == []


@pytest.mark.linuxcnc("machine")
def test_blocks_as_if_the_control_were_ideal_reach_neither_the_frequency_nor_the_chips() -> None:
    job = Job(TURNING, 2500, "N1.5", 20000)
    jobs = [job, replace(job, sets=("output.feed_mode=inverse",))]
    for outcome in run(jobs, *NAIVE):
        vibration, chips = outcome.vibration(), outcome.chips()
        assert outcome.promise.verdict.breaks
        assert vibration.frequency_hz < 0.8 * 62.5
        assert (vibration.turns, chips.broken) == (pytest.approx(49, abs=1), 0)


@pytest.mark.linuxcnc("machine")
def test_cuts_before_and_behind_are_not_run_into() -> None:
    """In G64 the control would round the corners between them."""
    settings = chipbreak.load(
        "linuxcnc-lathe", [f"axes.{axis}.max_acceleration_mm_s2=10000" for axis in "XZ"]
    )
    programs = []
    for mode in ("G64", "G64 P0.02"):
        program = f"G21 G18 G90 G8 G97 G95 {mode} S1250 M3\nG0 X8 Z1\nG1 X10 F0.1\n"
        program += "G1 Z-2 F0.1 N1.5\nG1 X12 F0.1\nZ-2.5\nM2\n"
        programs.append(chipbreak.rewrite(program.encode(), settings).data)
        assert f"{mode}\nM50 P1\nM51 P1\n(CHIPBREAK END" in programs[-1].decode()
    for done in machine.run(
        programs, acceleration_mm_s2=10000, velocity_mm_s=VELOCITY_MM_S, lathe=True, speed_up=5.0
    ):
        assert done.errors == ()
        places = done.samples[:, [1, 3]]
        at_start, at_end, after = (
            np.linalg.norm(places - point, axis=1).min() for point in ((10, 1), (10, -2), (12, -2))
        )
        assert at_start <= EXACT_MM
        assert at_end <= NEAR_MM  # the drives do not rest there, and the interpolator blunts the corner
        assert after > NEAR_MM  # G64 is back


def test_an_arc_is_one_block_per_stroke() -> None:
    """A stroke that is cut into pieces bends, and LinuxCNC rests at each bend or slows down."""
    result = Job(ARC, 1250, "N1.5", 20000).filtered()
    (cut,) = result.cuts
    # A small return stroke that goes on forward has a step back of its own before it.
    small = int(np.count_nonzero(np.abs(np.diff(cut.expansion.distance_mm)) < 2e-4))
    assert small <= 2
    assert cut.move_count <= 2 * cut.wave.vibrations + 2 + small


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("which", [slice(0, 2), ALL], ids=["few", "all"])
def test_a_period_between_two_servo_periods_is_kept_on_average(which: slice) -> None:
    periods = {16.5: (TURNING, 2424, 20000), 40.25: (TAPER, 988, 20000)}
    periods |= {18.5: (TURNING, 2162, 20000), 40.5: (FACING, 988, 10000)}
    jobs = [
        Job(shape, speed, "N1.5", acceleration, (f"command.periods_ms=[{period}]",))
        for period, (shape, speed, acceleration) in periods.items()
    ]
    assert what_went_wrong(jobs[which]) == []
