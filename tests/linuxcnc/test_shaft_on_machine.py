"""The sample shaft, filtered, run whole on LinuxCNC's simulated machine: every roughing pass breaks chips.

The verdict of each pass is made again from the motion that the machine was measured to make; finish, groove,
thread and part-off are in the output as they were.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import chipbreak
from chipbreak.vibration.measure import CutReport

from . import machine, rs274
from .chips import Floats, Leg, chips, follow
from .vibrated import VELOCITY_MM_S

SHAFT = (Path(__file__).parents[2] / "samples" / "shaft.ngc").read_bytes()
ACCELERATION_MM_S2 = 10_000.0
NEAR_MM = 0.003
# The joints take the mean of three servo periods, so corners are rounded by what the tool moves in two.
NEAR_CORNERS_MM = 2.0 * 0.001 * 17.2
BESIDE = 8  # samples in which the moves before and behind are still running out
REV_S = 60.0 / 800.0


def filtered() -> chipbreak.Result:
    axes = [f"axes.{axis}.max_acceleration_mm_s2={ACCELERATION_MM_S2:g}" for axis in "XZ"]
    return chipbreak.rewrite(SHAFT, chipbreak.load("linuxcnc-lathe", [*axes, "planner.max_feed_override=1"]))


def inside_lines(output: bytes) -> list[tuple[int, int]]:
    """Between which lines, from 1, each vibrated cut stands."""
    lines = output.decode("latin-1").split("\n")
    begins = [i for i, line in enumerate(lines, 1) if "CHIPBREAK BEGIN VIB" in line]
    ends = [i for i, line in enumerate(lines, 1) if "CHIPBREAK END" in line]
    return [(begin, next(end for end in ends if end > begin)) for begin in begins]


def legs_of(cut: CutReport) -> tuple[Leg, ...]:
    moves = cut.plan.chain.moves
    return tuple(Leg((m.start.x, m.start.z), (m.end.x, m.end.z)) for m in moves)


def broken_promises(cut: CutReport, run: machine.Run, lines: tuple[int, int]) -> list[str]:
    """What a pass did otherwise than the filter said."""
    inside = np.flatnonzero((run.lines > lines[0]) & (run.lines < lines[1]))
    part = run.samples[inside[0] - 3 : inside[-1] + 4]
    along, off = follow(legs_of(cut), part[:, [1, 3]])
    moves = np.flatnonzero(np.diff(along) != 0.0)
    part, along, off = (a[moves[0] : moves[-1] + 2] for a in (part, along, off))
    time_s: Floats = part[:, 0] - part[0, 0]
    wave = cut.plan.wave
    window_s = (wave.ramp_in_s + REV_S, wave.vibrations * wave.period_s - wave.ramp_in_s)
    found = chips(time_s, along, wave.speed_rpm, window_s)
    near_mm = NEAR_MM if len(legs_of(cut)) == 1 else NEAR_CORNERS_MM
    wanted = (window_s[1] - window_s[0]) / wave.period_s
    kept = {
        f"{found.broken} chips broken of {wanted:.1f}": abs(found.broken - wanted) <= 1.5,
        f"longest chip {found.longest_rev:.2f} rev": found.longest_rev <= 1.05 * cut.verdict.longest_chip_rev,
        f"{off[BESIDE:-BESIDE].max():.4f} mm off the path": off[BESIDE:-BESIDE].max() <= near_mm,
        f"takes {time_s[-1]:.3f} s, not {cut.duration_s:.3f}": abs(time_s[-1] / cut.duration_s - 1.0) <= 0.02,
    }
    return [what for what, holds in kept.items() if not holds]


@pytest.mark.linuxcnc
def test_the_shaft_is_taken_and_only_its_roughing_is_another() -> None:
    result = filtered()
    assert rs274.judge(SHAFT, lathe=True).accepted
    assert rs274.judge(result.data, lathe=True).accepted
    assert [cut.verdict.breaks for cut in result.cuts] == [True] * 4
    behind = SHAFT.index(b"T2 M6")
    assert result.data.endswith(SHAFT[behind:])
    assert chipbreak.restore(result.data) == SHAFT
    report = chipbreak.explain(
        result, chipbreak.load("linuxcnc-lathe", ["axes.X.max_acceleration_mm_s2=10000"])
    )
    (cycle,) = report.cycles
    assert (cycle.passes, cycle.depth_mm, cycle.vibrated) == (4, 2.0, 4)
    assert report.time is not None
    assert cycle.before_s < cycle.after_s < report.time.after_s
    assert report.time.after_s - report.time.before_s == pytest.approx(cycle.after_s - cycle.before_s)


@pytest.mark.linuxcnc("machine")
def test_every_roughing_pass_breaks_its_chips_on_the_machine() -> None:
    result = filtered()
    wrong: list[list[str]] = []
    for speed_up in (10.0, 3.0, 1.0):  # a busy computer lets the machine wait for the program
        (run,) = machine.run(
            [result.data],
            acceleration_mm_s2=ACCELERATION_MM_S2,
            velocity_mm_s=VELOCITY_MM_S,
            lathe=True,
            speed_up=speed_up,
        )
        assert run.errors == ()
        places = inside_lines(result.data)
        wrong = [broken_promises(cut, run, lines) for cut, lines in zip(result.cuts, places, strict=True)]
        if not any(wrong):
            return
    assert not any(wrong), wrong
