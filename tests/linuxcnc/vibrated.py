"""Programs that ask for vibration, filtered and run on the simulated machine, and what came of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

import chipbreak
from chipbreak.vibration.measure import CutReport

from . import machine
from .chips import Chips, Floats, Leg, Point, Vibration, chips, follow, vibration

VELOCITY_MM_S = (50.0, 100.0)  # of X and Z in the profile
NAIVE = ("planner.model=ideal", "planner.path_mode=", "output.segments=tick")


@dataclass(frozen=True)
class Shape:
    """A path to cut, and its blocks; ``{}`` stands where the first one has its feed and wish."""

    name: str
    legs: tuple[Leg, ...]
    blocks: str
    units: str = "G8"
    ways: str = "G90"

    @property
    def length_mm(self) -> float:
        return sum(leg.length_mm for leg in self.legs)


def _line(*points: Point) -> tuple[Leg, ...]:
    return tuple(Leg(a, b) for a, b in pairwise(points))


TURNING = Shape("turning", _line((10, 1), (10, -3)), "G1 Z-3 {}")
INCREMENTAL = Shape("incremental turning", _line((10, 1), (10, -3)), "G1 Z-4 {}", ways="G91")
FACING = Shape("facing", _line((12, 0), (8, 0)), "G1 X16 {}", units="G7")
TAPER = Shape("taper", _line((10, 0), (12, -3.5)), "G1 X24 Z-3.5 {}", units="G7")
BORING = Shape("boring", _line((6, -5), (6, -1)), "G1 Z-1 {}")
ARC = Shape("arc", (Leg((8, 0), (12, -4), (8, -4)),), "G3 X24 Z-4 I0 K-4 {}", units="G7")
HOLLOW = Shape("hollow arc", (Leg((8, -1), (12, -5), (12, -1)),), "G2 X24 Z-5 I4 K0 {}", units="G7")
CHAMFER = Shape("chamfer", _line((10, 1), (10, -2), (11.5, -3.5)), "G1 Z-2 {}\nX23 Z-3.5 {}", units="G7")
SHOULDER = Shape("shoulder", _line((10, 1), (10, -2), (12, -2)), "G1 Z-2 {}\nX12 {}")
ROUNDED = Shape(
    "rounded shoulder",
    (*_line((8, 1), (8, -2)), Leg((8, -2), (10, -4), (10, -2)), *_line((10, -4), (12, -4))),
    "G1 Z-2 {}\nG2 X20 Z-4 I2 K0 {}\nG1 X24 {}",
    units="G7",
)


@dataclass(frozen=True)
class Job:
    """A shape cut at a speed with a wish for vibration, on a machine of this acceleration."""

    shape: Shape
    speed_rpm: float
    wish: str
    acceleration_mm_s2: float
    sets: tuple[str, ...] = ()
    feed_mm_rev: float = 0.1
    breaks: bool = True

    def __str__(self) -> str:
        extra = " ".join(one.split(".")[1] for one in self.sets)
        return f"{self.shape.name} S{self.speed_rpm:g} {self.wish} a={self.acceleration_mm_s2:g} {extra}"

    def program(self) -> bytes:
        """What the user would write: to the start, the cut, away from it."""
        (x, z), (end_x, end_z) = self.shape.legs[0].start, self.shape.legs[-1].end
        double = 2 if self.shape.units == "G7" else 1
        blocks = self.shape.blocks.replace("{}", f"F{self.feed_mm_rev:g} {self.wish}")
        return (
            f"G21 G18 G90 {self.shape.units} G97 G95 G64 S{self.speed_rpm:g} M3\n"
            f"G0 X{double * x:g} Z{z:g}\nG4 P0.02\n{self.shape.ways}\n{blocks}\nG4 P0.02\nG90\n"
            f"G0 X{double * end_x + 2:g} Z{end_z + 0.5:g}\nM2\n"
        ).encode()

    def filtered(self, *sets: str) -> chipbreak.Result:
        limits = [f"axes.{axis}.max_acceleration_mm_s2={self.acceleration_mm_s2:g}" for axis in "XZ"]
        # The machine of these tests has no more; other laws do not ask for it.
        override = [] if NAIVE[0] in sets else ["planner.max_feed_override=1"]
        settings = chipbreak.load("linuxcnc-lathe", [*limits, *override, *self.sets, *sets])
        return chipbreak.rewrite(self.program(), settings, str(self), allow_unbroken=not self.breaks)


@dataclass(frozen=True)
class Outcome:
    """The promise, and the motion of the cut from its first moment to its last."""

    job: Job
    promise: CutReport
    time_s: Floats
    along_mm: Floats
    off_mm: float
    gap_mm: float
    errors: tuple[str, ...]

    @property
    def window_s(self) -> tuple[float, float]:
        """The part of full stroke, as promised, from one revolution after its begin."""
        cut = self.promise.wave
        rev_s, shift = 60.0 / cut.speed_rpm, self.time_s[-1] / cut.duration_s
        last_s = cut.vibrations * cut.period_s - cut.ramp_in_s
        return (cut.ramp_in_s + rev_s) * shift, min(last_s, cut.duration_s - rev_s) * shift

    def vibration(self) -> Vibration:
        return vibration(self.time_s, self.along_mm, self.window_s)

    def chips(self, *, settled: float = 0.0) -> Chips:
        """In the part of full stroke; the ``settled`` revolutions before it had their full stroke too."""
        speed_rpm = self.promise.wave.speed_rpm
        start_s, end_s = self.window_s
        return chips(self.time_s, self.along_mm, speed_rpm, (start_s + settled * 60.0 / speed_rpm, end_s))


def outcome(job: Job, result: chipbreak.Result, run: machine.Run) -> Outcome:
    """Find the cut in the record.  A commanded position lags the planner by two servo periods."""
    (promise,) = result.cuts
    lines = result.data.decode("latin-1").split("\n")
    first = next(i for i, line in enumerate(lines, 1) if "CHIPBREAK BEGIN" in line)
    last = next(i for i, line in enumerate(lines, 1) if "CHIPBREAK END" in line)
    inside = np.flatnonzero((run.lines > first) & (run.lines < last))
    part = run.samples[inside[0] - 3 : inside[-1] + 4]
    along, off = follow(job.shape.legs, part[:, [1, 3]])
    moves = np.flatnonzero(np.diff(along) != 0.0)
    part, along, off = (a[moves[0] : moves[-1] + 2] for a in (part, along, off))
    start, end = job.shape.legs[0].start, job.shape.legs[-1].end
    gap = max(np.linalg.norm(part[0, [1, 3]] - start), np.linalg.norm(part[-1, [1, 3]] - end))
    return Outcome(job, promise, part[:, 0] - part[0, 0], along, float(off.max()), float(gap), run.errors)


def run(jobs: Sequence[Job], *sets: str, speed: float | None = None) -> list[Outcome]:
    """Filter and run; one start of the machine for each acceleration and speed of the simulation.

    LinuxCNC reads several blocks in a millisecond on the wall.  Where the sped-up machine has to wait for
    them, it stops between blocks that it would have run into each other; ``speed`` is that of the clock, 1
    for the wall's.
    """
    results = [job.filtered(*sets) for job in jobs]
    kinds = [
        (job.acceleration_mm_s2, speed or _speed_up(result))
        for job, result in zip(jobs, results, strict=True)
    ]
    done: dict[int, Outcome] = {}
    for kind in sorted(set(kinds)):
        group = [i for i, one in enumerate(kinds) if one == kind]
        runs = machine.run(
            [results[i].data for i in group],
            acceleration_mm_s2=kind[0],
            velocity_mm_s=VELOCITY_MM_S,
            lathe=True,
            speed_up=kind[1],
        )
        done |= {i: outcome(jobs[i], results[i], ran) for i, ran in zip(group, runs, strict=True)}
    return [done[i] for i in range(len(jobs))]


def _speed_up(result: chipbreak.Result) -> float:
    """So fast that a block lasts a millisecond on the wall, but one of few values."""
    (cut,) = result.cuts
    block_ms = cut.duration_s / cut.move_count * 1000.0
    return max([1.0, *(speed for speed in (3.0, 10.0) if block_ms / speed >= 1.0)])


def grid() -> list[Job]:
    """The programs of the comparison."""
    inverse, minute = ("output.feed_mode=inverse",), ("output.feed_mode=minute",)
    sine, uneven = ("vibration.waveform=sine",), ("vibration.alpha=0.75",)
    jobs = [
        Job(TURNING, 2500, "N1.5", 20000),
        Job(TURNING, 2500, "N1.5", 20000, inverse),
        Job(TURNING, 2500, "N1.5", 20000, minute),
        Job(TURNING, 2500, "N1.5", 20000, sine),
        Job(TURNING, 2500, "N1.25", 20000, uneven, feed_mm_rev=0.05),
        Job(TURNING, 1250, "N1.5", 5000),
        Job(TURNING, 1250, "N1.5", 5000, sine),
        Job(TURNING, 2500, "N1.5", 10000, sine),
        Job(TURNING, 1200, "E2", 2000),
        Job(TURNING, 1200, "E2", 2000, sine),
        Job(TAPER, 1250, "N1.5", 10000, (*sine, *minute)),
        Job(TURNING, 500, "N3.5", 10000, minute),
        Job(INCREMENTAL, 750, "N2.5", 10000, inverse),
        Job(FACING, 1250, "N1.5", 10000),
        Job(FACING, 600, "N2.5", 5000, inverse),
        Job(FACING, 600, "E2", 2000, (*uneven, *minute)),
        Job(FACING, 1250, "N1.5", 20000, sine),
        Job(TAPER, 1250, "N1.5", 10000, inverse),
        Job(TAPER, 600, "N1.25", 5000, uneven),
        Job(TAPER, 500, "N0.5", 2000, minute),
        Job(BORING, 2500, "N0.5", 5000),
        Job(BORING, 1000, "N1.5", 20000, (*inverse, *sine)),
        Job(ARC, 1250, "N1.5", 20000),
        Job(ARC, 600, "N1.5", 5000, inverse),
        Job(ARC, 1200, "E2", 2000, minute),
        Job(HOLLOW, 600, "N2.5", 10000, sine),
        Job(HOLLOW, 500, "N3.5", 20000),
        Job(CHAMFER, 1250, "N1.5", 20000),
        Job(CHAMFER, 600, "N1.5", 5000, inverse),
        Job(CHAMFER, 1200, "E2", 2000, minute),
        Job(SHOULDER, 1250, "N1.5", 20000),
        Job(SHOULDER, 600, "N1.25", 10000, uneven),
        Job(SHOULDER, 600, "E2", 2000, inverse),
        Job(ROUNDED, 1250, "N1.5", 20000),
        Job(ROUNDED, 600, "E2", 5000, minute),
        Job(TURNING, 1250, "N1.5", 10000, ("planner.path_mode=G64",)),
        Job(TURNING, 1250, "N1.5", 10000, ("planner.path_mode=G64 P0.002",)),
        Job(TURNING, 1250, "N1.5", 20000, ("planner.path_mode=G61.1", *sine)),
        Job(SHOULDER, 600, "N1.5", 10000, ("planner.path_mode=G61.1",)),
    ]
    weak = [
        Job(TURNING, 1250, "N1.5 Q0.9", 10000, breaks=False),
        Job(FACING, 600, "N1.25 Q1.2", 10000, breaks=False),
        Job(TAPER, 600, "E2 Q0.8", 5000, inverse, breaks=False),
        Job(BORING, 1250, "N1.5 Q0.9", 20000, sine, breaks=False),
    ]
    return jobs + weak


def few_of_the_grid() -> list[Job]:
    """As few of them as have every shape and every setting that is in the grid, and a weak one."""
    few: list[Job] = []
    left = {what for job in grid() for what in _what_it_shows(job)}
    while left:
        best = max(grid(), key=lambda job: len(left & _what_it_shows(job)))
        few.append(best)
        left -= _what_it_shows(best)
    return few


def _what_it_shows(job: Job) -> set[object]:
    return {job.shape.name, job.breaks, *job.sets}
