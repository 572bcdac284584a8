"""Cuts drawn at random, and what of their promise a recorded motion keeps.

A seed gives a cut: its path, units, feed modes, wave, and the machine that it is meant for.  So a grid of any
size, and another one of the same kinds that nobody has looked at, are one number apart.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

import chipbreak
from chipbreak.kinematics.waveform import full_window
from chipbreak.vibration.measure import CutReport

from . import machine
from .chips import Floats, Leg, Point, chips, follow, stands, vibration
from .machine import Run
from .settled import SPEEDS, UNSETTLED, Seen, is_settled, tries_of

MM_PER_INCH = 25.4
_STAND_SHARE = 0.5  # of a revolution: a rest at a corner is shorter


class Machine(NamedTuple):
    """What a simulated machine is started with: limits of X and Z [mm/s², mm/s], servo period, override."""

    acceleration_mm_s2: tuple[float, float]
    velocity_mm_s: tuple[float, float]
    servo_period_s: float
    max_feed_override: float


@dataclass(frozen=True)
class Cut:
    """A program with one vibrated cut, the settings to filter it with, and the path that it should follow."""

    kind: str
    seed: int
    program: bytes
    sets: tuple[str, ...]
    legs: tuple[Leg, ...]
    machine: Machine

    def __str__(self) -> str:
        return f"{self.kind} #{self.seed}"

    def settings(self, *, says_override: bool = True) -> chipbreak.Settings:
        """The profile with the numbers of the machine; the override may be one that it does not know."""
        sets = list(self.sets)
        for axis, acceleration, velocity in zip(
            "XZ", self.machine.acceleration_mm_s2, self.machine.velocity_mm_s, strict=True
        ):
            sets.append(f"axes.{axis}.max_acceleration_mm_s2={acceleration:g}")
            sets.append(f"axes.{axis}.max_velocity_mm_min={velocity * 60.0:g}")
        sets.append(f"planner.servo_period_ms={self.machine.servo_period_s * 1000.0:g}")
        if says_override:
            sets.append(f"planner.max_feed_override={self.machine.max_feed_override:g}")
        return chipbreak.load("linuxcnc-lathe", sets)

    def filtered(self, *, says_override: bool = True) -> chipbreak.Result:
        """The corrected program.  Raises ProgramRejectedError where it is refused."""
        settings = self.settings(says_override=says_override)
        return chipbreak.rewrite(self.program, settings, str(self), allow_unbroken=True)


class _Draw:
    """Random choices, and numbers as a program prints them."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.is_inch = self.random.random() < 0.15
        self.is_diameter = self.random.random() < 0.4
        self.unit_mm = MM_PER_INCH if self.is_inch else 1.0
        self.decimals = 4 if self.is_inch else 3

    def of(self, *values: object) -> object:
        return self.random.choice(values)

    def between(self, low: float, high: float) -> float:
        return self.random.uniform(low, high)

    def near(self, mm: float) -> float:
        """A length that the program can print exactly [mm]; X stays exact as a diameter."""
        return round(mm / self.unit_mm, self.decimals) * self.unit_mm

    def text(self, mm: float) -> str:
        return f"{round(mm / self.unit_mm, self.decimals + 1):g}"

    def x(self, mm: float) -> str:
        return self.text(2.0 * mm if self.is_diameter else mm)


class Path(NamedTuple):
    """Legs, and their blocks without feed and wish."""

    legs: tuple[Leg, ...]
    blocks: tuple[str, ...]


def _lines(draw: _Draw, *points: Point) -> Path:
    legs = tuple(Leg(a, b) for a, b in pairwise(points))
    blocks = tuple(f"G1 X{draw.x(x)} Z{draw.text(z)}" for x, z in points[1:])
    return Path(legs, blocks)


def _turning(draw: _Draw, length: float) -> Path:
    x, z = draw.near(draw.between(3.0, 12.0)), draw.near(1.0)
    return _lines(draw, (x, z), (x, draw.near(z - length)))


def _facing(draw: _Draw, length: float) -> Path:
    x, z = draw.near(draw.between(length + 2.0, length + 10.0)), draw.near(-0.4)
    return _lines(draw, (x, z), (draw.near(x - length), z))


def _boring(draw: _Draw, length: float) -> Path:
    x, z = draw.near(6.0), draw.near(-5.0)
    return _lines(draw, (x, z), (x, draw.near(z + length)))


def _taper(draw: _Draw, length: float) -> Path:
    x, z, angle = draw.near(8.0), draw.near(0.0), draw.between(0.05, 1.5)
    end = (draw.near(x + length * np.sin(angle)), draw.near(z - length * np.cos(angle)))
    return _lines(draw, (x, z), end)


def _chamfer(draw: _Draw, length: float) -> Path:
    x, z, share = draw.near(9.0), draw.near(1.0), draw.between(0.3, 0.7)
    middle = (x, draw.near(z - share * length))
    angle = draw.of(0.2, 0.5235988, 0.7853982, 1.2)
    rest = (1.0 - share) * length
    end = (draw.near(x + rest * np.sin(angle)), draw.near(middle[1] - rest * np.cos(angle)))
    return _lines(draw, (x, z), middle, end)


def _shoulder(draw: _Draw, length: float) -> Path:
    x, z, share = draw.near(9.0), draw.near(1.0), draw.between(0.3, 0.7)
    middle = (x, draw.near(z - share * length))
    return _lines(draw, (x, z), middle, (draw.near(x + (1.0 - share) * length), middle[1]))


def _chain(draw: _Draw, length: float) -> Path:
    """Several lines in a row, some nearly straight on."""
    points = [(draw.near(8.0), draw.near(0.0))]
    heading = 0.0
    for _ in range(int(draw.random.randint(3, 5))):
        x, z = points[-1]
        way = length / 4.0
        points.append((draw.near(x + way * np.sin(heading)), draw.near(z - way * np.cos(heading))))
        heading = min(1.5, max(0.0, heading + draw.of(0.01, 0.05, 0.2, 0.6, 0.9, -0.3)))  # type: ignore[operator]
    return _lines(draw, *points)


def _arc_leg(draw: _Draw, start: Point, radius: float, *, is_hollow: bool) -> tuple[Leg, str]:
    x, z = start
    end = (x + radius, z - radius)
    centre = (x + radius, z) if is_hollow else (x, z - radius)
    code = "G2" if is_hollow else "G3"
    i, k = (draw.text(c - s) for c, s in zip(centre, start, strict=True))
    return Leg(start, end, centre), f"{code} X{draw.x(end[0])} Z{draw.text(end[1])} I{i} K{k}"


def _arc(draw: _Draw, length: float) -> Path:
    start = (draw.near(8.0), draw.near(0.0))
    leg, block = _arc_leg(draw, start, draw.near(length / 1.5708), is_hollow=draw.random.random() < 0.5)
    return Path((leg,), (block,))


def _around(draw: _Draw, length: float, radius: float) -> Path:
    """A line, a hollow arc, a line across."""
    x, z = draw.near(8.0), draw.near(0.5)
    straight = max(0.2, (length - 1.5708 * radius) / 2.0)
    corner = (x, draw.near(z - straight))
    leg, block = _arc_leg(draw, corner, draw.near(radius), is_hollow=True)
    end = (draw.near(leg.end[0] + straight), leg.end[1])
    before, after = _lines(draw, (x, z), corner), _lines(draw, leg.end, end)
    return Path((*before.legs, leg, *after.legs), (*before.blocks, block, *after.blocks))


def _rounded(draw: _Draw, length: float) -> Path:
    return _around(draw, length, draw.between(0.5, length / 3.0) if length > 2.0 else 0.4)


def _fillet(draw: _Draw, length: float) -> Path:
    return _around(draw, length, float(draw.of(0.02, 0.05, 0.1, 0.2)))  # type: ignore[arg-type]


PATHS: dict[str, Callable[[_Draw, float], Path]] = {
    "turning": _turning,
    "facing": _facing,
    "boring": _boring,
    "taper": _taper,
    "chamfer": _chamfer,
    "shoulder": _shoulder,
    "chain": _chain,
    "arc": _arc,
    "rounded shoulder": _rounded,
    "fillet": _fillet,
}
MACHINES = (
    Machine((2000.0, 2000.0), (50.0, 100.0), 0.001, 1.0),
    Machine((5000.0, 5000.0), (50.0, 100.0), 0.001, 1.2),
    Machine((10000.0, 10000.0), (80.0, 80.0), 0.001, 1.0),
    Machine((20000.0, 20000.0), (50.0, 100.0), 0.001, 1.2),
    Machine((5000.0, 12000.0), (100.0, 60.0), 0.001, 1.0),
    Machine((12000.0, 4000.0), (50.0, 100.0), 0.001, 1.2),
    Machine((8000.0, 20000.0), (80.0, 80.0), 0.0005, 1.0),
    Machine((10000.0, 10000.0), (50.0, 100.0), 0.0005, 1.2),
    Machine((20000.0, 6000.0), (100.0, 60.0), 0.002, 1.2),
    Machine((10000.0, 10000.0), (50.0, 100.0), 0.002, 1.0),
)


def drawn(seed: int, kind: str | None = None) -> Cut:
    """The cut of a seed; ``kind`` is one of ``PATHS``, by turns where none is given."""
    draw = _Draw(seed)
    kind = kind or list(PATHS)[seed % len(PATHS)]
    wave = str(draw.of("triangle", "triangle", "triangle", "tick", "sine", "alpha", "dwell"))
    per_rev = float(draw.of(0.5, 0.5, 1.5, 1.5, 1.5, 2.4, 2.5, 3.5, 0.4))  # type: ignore[arg-type]
    if wave == "alpha":
        per_rev = float(draw.of(0.5, 1.25, 1.4, 1.5))  # type: ignore[arg-type]
    if wave == "dwell":
        per_rev = 1.0 / float(draw.of(2.6, 3.0, 4.0))  # type: ignore[arg-type]
    hertz = float(draw.of(5.0, 8.0, 12.5, 16.0, 20.0, 31.25, 50.0, 62.5, 125.0))  # type: ignore[arg-type]
    if wave == "dwell":
        hertz = min(hertz, 12.5)
    speed = round(hertz * 60.0 / per_rev)
    if speed > 6000:
        speed, hertz = 6000, 100.0 * per_rev
    speed = max(speed, 100)
    feed = draw.near(draw.between(0.02, 0.15))
    vibrations = draw.between(14.0, 30.0)
    length = max(feed * vibrations / per_rev, 0.3)
    if kind in ("chain", "rounded shoulder", "fillet"):
        length = max(length * 1.5, 0.9)
    path = PATHS[kind](draw, length)
    sets = _sets(draw, wave, hertz)
    feed_text = f"G95 F{feed / draw.unit_mm:.5f}"
    if draw.random.random() < 0.3:
        feed_text = f"G94 F{round(feed * speed / draw.unit_mm, 2):g}"
    wish = f"E{1.0 / per_rev:g}" if per_rev < 1.0 else f"N{per_rev:g}"
    if wave != "dwell" and draw.random.random() < 0.3:
        wish += f" Q{draw.between(1.6, 2.4) if per_rev > 1.0 else draw.between(1.3, 2.0):.2f}"
    program = _program(draw, path, speed, feed_text, wish)
    meant_for = MACHINES[draw.random.randrange(len(MACHINES))]
    return Cut(f"{kind}, {wave}", seed, program, sets, path.legs, meant_for)


def _sets(draw: _Draw, wave: str, hertz: float) -> tuple[str, ...]:
    sets = [f"output.feed_mode={draw.of('rev', 'rev', 'minute', 'inverse')}"]
    if wave in ("sine", "dwell"):
        sets.append(f"vibration.waveform={wave}")
    if wave == "tick":
        sets.append("output.segments=tick")
    if wave == "alpha":
        sets.append(f"vibration.alpha={draw.of(0.25, 0.4, 0.6, 0.75)}")
    if hertz > 62.5:
        sets.append("command.min_multiple=2")
    sets.append(f"vibration.ramp_exponent={draw.of(1.0, 1.0, 2.0, 0.5)}")
    sets.append(f"vibration.ramp_vibrations={draw.of(3.0, 3.0, 0.0, 5.0)}")
    if wave != "dwell":
        sets.append(f"vibration.end={draw.of('feed', 'feed', 'dwell')}")
    return tuple(sets)


def _program(draw: _Draw, path: Path, speed: int, feed: str, wish: str) -> bytes:
    """What the user would write: to the start, the cut, away from it."""
    units = f"{'G20' if draw.is_inch else 'G21'} G18 G90 {'G7' if draw.is_diameter else 'G8'}"
    (x, z), (end_x, end_z) = path.legs[0].start, path.legs[-1].end
    feed_code, feed_word = feed.split()
    blocks = "\n".join(f"{block} {feed_word} {wish}" for block in path.blocks)
    waits = "G4 P0.03\n"  # a move that starts in the same period would not be told from the cut
    return (
        f"{units} G97 {feed_code} S{speed} M3\nG0 X{draw.x(x)} Z{draw.text(z)}\n{waits}{blocks}\n{waits}"
        f"G0 X{draw.x(end_x + 1.0)} Z{draw.text(end_z + 0.6)}\nM2\n"
    ).encode()


@dataclass(frozen=True, eq=False)
class Kept:
    """What was promised against what a recorded motion does; shares of the promise."""

    count_error: float
    stroke_error: float
    time_error: float
    ramp_error: float
    verdict: bool
    off_mm: float
    gap_mm: float

    def misses(self) -> list[str]:
        """The bounds that are not kept: 1 % in N and time, 5 % in stroke, the verdict always.

        The strokes of the ramp are off by at most 15 % of the full one.
        """
        found = {
            "N": self.count_error <= 0.01,
            "stroke": self.stroke_error <= 0.05,
            "time": self.time_error <= 0.01,
            "ramp": self.ramp_error <= 0.15,
            "verdict": self.verdict,
            "path": self.off_mm <= 0.003,
            "ends": self.gap_mm <= 1e-4,
        }
        return [name for name, kept in found.items() if not kept]

    def is_like(self, other: Kept) -> bool:
        """The same figures; of one sample more or less they would be others."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return all(math.isclose(one, two, abs_tol=1e-9) for one, two in pairs)


def kept(cut: Cut, promise: CutReport, time_s: Floats, points_mm: Floats) -> Kept:
    """Judge a motion, (n,) and (n, 2) of X as a radius and Z, from the last moment at rest to the first."""
    along, off = follow(cut.legs, points_mm)
    wave, verdict = promise.wave, promise.verdict
    ends = cut.legs[0].start, cut.legs[-1].end
    gap = max(float(np.linalg.norm(p - e)) for p, e in zip(points_mm[[0, -1]], ends, strict=True))
    rev_s, shift = 60.0 / wave.speed_rpm, time_s[-1] / _moving_s(promise)
    full_s, end_s = (moment * shift for moment in full_window(wave))
    start_s = full_s + rev_s
    seen = vibration(time_s, along, (full_s, end_s))
    broken = chips(time_s, along, wave.speed_rpm, (start_s, end_s)).broken
    turns_back = wave.shape.turns_back
    count_error = stroke_error = 0.0
    if turns_back and verdict.per_rev > 0.0 and seen.turns >= 3:
        count_error = abs(seen.frequency_hz * rev_s / promise.plan.solution.per_rev - 1.0)
        misses = np.abs(seen.strokes_mm / verdict.stroke_mm - 1.0)
        # A stroke across a corner, or bent round an arc, is no longer measured along one line.
        stroke_error = float(misses.max() if len(cut.legs) == 1 else np.median(misses))
    period_s = wave.period_s * shift
    if not turns_back:
        # Dwells end the chips whatever N is, so the N that is promised is the one that is reached.
        period_s = rev_s / verdict.per_rev
        begun_s = stands(time_s, along, _STAND_SHARE * rev_s)
        count_error = abs(float(np.diff(begun_s).mean()) / period_s - 1.0)
    wanted = max(0.0, (end_s - start_s) / period_s) if verdict.breaks else 0.0
    return Kept(
        count_error,
        stroke_error,
        abs(time_s[-1] / _moving_s(promise) - 1.0),
        _ramp_error(promise, time_s, along) if turns_back and len(cut.legs) == 1 else 0.0,
        abs(broken - wanted) <= 1.5 if wanted else broken <= 1 or not verdict.breaks,
        float(off.max()),
        gap,
    )


# Of a cut that the machine never came to: run.errors says why.
NOTHING_KEPT = Kept(math.inf, math.inf, math.inf, math.inf, False, math.inf, math.inf)


def _moving_s(promise: CutReport) -> float:
    return promise.duration_s - promise.plan.end_dwell_s


def _ramp_error(promise: CutReport, time_s: Floats, along: Floats) -> float:
    """How far the crests of the growing strokes are from the ramp, as a share of the full stroke."""
    wave = promise.wave
    if wave.ramp_in_s <= 0.0:
        return 0.0
    ahead = (along - wave.speed_mm_s * time_s) / wave.stroke_mm
    worst = 0.0
    for index in range(round(wave.ramp_in_s / wave.period_s)):
        crest_s = (index + wave.alpha_share) * wave.period_s
        wanted = min(1.0, crest_s / wave.ramp_in_s) ** wave.ramp_exponent
        near = np.abs(time_s - crest_s) <= wave.period_s / 4.0
        worst = max(worst, abs(float(ahead[near].max()) - wanted))
    return worst


def in_record(cut: Cut, result: chipbreak.Result, run: Run) -> Kept:
    """Judge what the simulated machine recorded of a filtered cut."""
    lines = result.data.decode("latin-1").split("\n")
    first, last = (
        next(number for number, line in enumerate(lines, 1) if mark in line)
        for mark in ("CHIPBREAK BEGIN", "CHIPBREAK END")
    )
    inside = np.flatnonzero((run.lines > first) & (run.lines < last))
    if not len(inside):
        return NOTHING_KEPT
    part = run.samples[inside[0] - 3 : inside[-1] + 4]
    moves = np.flatnonzero(np.any(np.diff(part[:, 1:], axis=0) != 0.0, axis=1))
    if not len(moves):
        return NOTHING_KEPT
    part = part[moves[0] : moves[-1] + 2]
    return kept(cut, result.cuts[0], part[:, 0] - part[0, 0], part[:, [1, 3]])


class Ran(NamedTuple):
    """A cut that was run, what it kept, and whether that says something about the cut."""

    cut: Cut
    breaks: bool
    kept: Kept
    errors: tuple[str, ...]
    is_settled: bool = True

    @property
    def misses(self) -> list[str]:
        """What it did not keep."""
        found = [*self.kept.misses(), *self.errors]
        return found if self.is_settled else [*found, UNSETTLED]

    def is_like(self, other: Seen) -> bool:
        """Both were the same motion, as far as it was judged."""
        assert isinstance(other, Ran)
        return self.errors == other.errors and self.kept.is_like(other.kept)


def _result(cut: Cut) -> chipbreak.Result | None:
    """The filtered cut; None where it is refused or does not vibrate."""
    try:
        result = cut.filtered()
    except chipbreak.ProgramRejectedError:
        return None
    return result if result.cuts else None


def _run_at(waiting: Mapping[Cut, chipbreak.Result], speed: float) -> dict[Cut, Ran]:
    """What ran: all cuts of one machine at a time."""
    kinds = {cut: (cut.machine, 1.0 if "dwell" in cut.kind else speed) for cut in waiting}
    done: dict[Cut, Ran] = {}
    for kind in dict.fromkeys(kinds.values()):
        group = [(cut, result) for cut, result in waiting.items() if kinds[cut] == kind]
        done |= {ran.cut: ran for ran in _run_group(group, *kind)}
    return done


def run_cuts(cuts: Sequence[Cut], *, speeds: Sequence[float] = SPEEDS) -> tuple[list[Ran], list[Cut]]:
    """Filter and run cuts, a start of the machine for all of one machine; those run, and those refused.

    A dwell is waited for by the clock on the wall: its cuts are not slowed down, and their last run counts.
    """
    results = {cut: _result(cut) for cut in cuts}
    refused = [cut for cut, result in results.items() if result is None]
    waiting = {cut: result for cut, result in results.items() if result is not None}
    tries = tries_of(
        list(waiting), lambda some, speed: _run_at({cut: waiting[cut] for cut in some}, speed), speeds
    )
    unseen = [str(cut) for cut, found in tries.items() if not found]
    if unseen:
        raise machine.MachineError(f"never ran: {unseen}")
    return [_verdict(found) for found in tries.values()], refused


def _verdict(tries: Sequence[Ran]) -> Ran:
    last = tries[-1]
    return last._replace(is_settled=is_settled(tries) or "dwell" in last.cut.kind)


def _run_group(group: Sequence[tuple[Cut, chipbreak.Result]], one: Machine, speed_up: float) -> Iterator[Ran]:
    """Run cuts in one start of the machine; none where it did not start, on a busy computer."""
    programs = [result.data for _, result in group]
    try:
        runs = machine.run(programs, lathe=True, speed_up=speed_up, **one._asdict())
    except machine.MachineError:
        return
    for (cut, result), run in zip(group, runs, strict=True):
        yield Ran(cut, result.cuts[0].verdict.breaks, in_record(cut, result, run), run.errors)
