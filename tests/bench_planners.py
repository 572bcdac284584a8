"""Other planners on the bench: Klipper's own, in a process of its own, and LinuxCNC's simulated machine.

Klipper gives the times of the groups (there is no trace), LinuxCNC a record of the commanded places.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

import chipbreak
from bench_machine import FINE, Block, Floats, Kept, blocks_of, command_line, groups_of
from linuxcnc import machine, vibrated
from stepped_machine import seen

TESTS = Path(__file__).parent
PLANNER = Path(os.environ.get("CHIPBREAK_KLIPPER") or TESTS.parent / ".venv" / "klipper")


class Klipper(NamedTuple):
    """Limits that the test does not know [mm/s, mm/s²]."""

    max_velocity: float
    max_accel: float
    corner_velocity: float
    min_cruise_ratio: float
    max_z_velocity: float
    max_z_accel: float

    def times_s(self, runs: list[list[Block]]) -> list[Floats]:
        """How long each block of each run takes, from rest to rest."""
        asked = []
        for run in runs:
            places = np.cumsum([[one.x_mm, 0.0, one.z_mm] for one in run], axis=0)
            moves = [[*place, one.feed_mm_s] for place, one in zip(places.tolist(), run, strict=True)]
            asked.append(json.dumps(self._asdict() | {"start": [0.0, 0.0, 0.0], "moves": moves}))
        command = [sys.executable, "-I", str(TESTS / "klipper" / "planner.py"), str(PLANNER)]
        done = subprocess.run(command, input="\n".join(asked), capture_output=True, text=True, check=True)
        return [np.array(json.loads(line)) for line in done.stdout.splitlines()]


def drawn_klipper(draw: np.random.Generator) -> Klipper:
    """One of them."""
    has = float(draw.uniform(500.0, 8000.0))
    own = has * float(draw.choice([1.0, draw.uniform(0.4, 1.0)]))
    ratio = float(draw.choice([0.0, 0.5, draw.uniform(0.2, 0.8)]))
    return Klipper(300.0, has, 5.0, ratio, 200.0, own)


def klipper_profile(machine: Klipper, draw: np.random.Generator, folder: Path) -> str:
    """The profile that the machine test makes of the times of a machine, known to a millisecond."""
    program, form, profile = (folder / name for name in ("t.gcode", "t.toml", "p.toml"))
    command_line("write", "-p", "klipper", "-o", str(program), "--axes", "XZ", "--repeats", "1", "-q")
    groups = groups_of(program.read_text(), x_is_diameter=False)
    text = form.read_text().replace("error_ms = 100", "error_ms = 1")
    for times in machine.times_s(groups):
        text = text.replace("ms = 0\n", f"ms = {times.sum() * 1000.0 + draw.normal(30.0, 1.0):.3f}\n", 1)
    form.write_text(text)
    command_line("read", str(form), "-o", str(profile), "-q")
    return str(profile)


def klipper_cut(machine: Klipper, profile: str, draw: np.random.Generator) -> Kept | None:
    """A cut in Z as promised, and as Klipper runs it; None where it is refused."""
    period_s = float(draw.choice([0.032, 0.048, 0.064, 0.100]))
    per_rev = float(draw.choice([0.5, 0.75, 1.25, 1.5, 2.5]))
    speed_rpm = round(60.0 / period_s / per_rev)
    feed_mm = round(float(draw.uniform(0.02, 0.15)), 3)
    length_mm = 24.0 * feed_mm * max(1.0, 1.0 / per_rev)
    code = (
        f"G21\nG90\nM3 S{speed_rpm}\nG0 X10. Z0.\n; VIB N{per_rev}\n"
        f"G1 Z-{length_mm:.3f} F{feed_mm * speed_rpm:.4f}\n"
        f"; VIB OFF\nG1 F100\nG0 X30.\n"
    )
    settings = chipbreak.load(profile, [f"command.periods_ms=[{period_s * 1000.0}]", *FINE[1:3], FINE[5]])
    try:
        result = chipbreak.rewrite(code.encode(), settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        return None
    if not result.cuts:
        return None
    (report,) = result.cuts
    lengths_mm, feeds_mm_min = blocks_of(result.data.decode(), "; CHIPBREAK")
    run = [Block(0.0, -way, feed / 60.0) for way, feed in zip(lengths_mm, feeds_mm_min, strict=True)]
    (times_s,) = machine.times_s([run])
    step_s = report.wave.period_s / 640.0
    place_mm = _at_rest_between(lengths_mm, times_s, min(machine.max_accel, machine.max_z_accel), step_s)
    speed = report.plan.solution.speed_rpm
    share = len(times_s) // 5
    ends_s = np.cumsum(times_s)
    ran = seen(place_mm, step_s, 60.0 / speed, report.wave.period_s, (ends_s[share], ends_s[-share]))
    verdict = report.verdict
    promised = (verdict.per_rev, verdict.stroke_mm, bool(verdict.breaks))
    return Kept(promised, (ran.per_rev, ran.stroke_mm, ran.margin >= 1.0), report.is_on_edge)


def _at_rest_between(lengths_mm: Floats, times_s: Floats, has_mm_s2: float, step_s: float) -> Floats:
    """The place after each step, of strokes that begin and end at rest with this acceleration."""
    places = np.append(0.0, np.cumsum(lengths_mm))
    ends_s = np.cumsum(times_s)
    at_s = np.arange(int(ends_s[-1] / step_s)) * step_s
    block = np.minimum(np.searchsorted(ends_s, at_s, "right"), len(ends_s) - 1)
    span = times_s[block]
    since = at_s - (ends_s[block] - span)
    room = np.maximum((has_mm_s2 * span) ** 2 - 4.0 * has_mm_s2 * np.abs(lengths_mm[block]), 0.0)
    top = (has_mm_s2 * span - np.sqrt(room)) / 2.0
    ramp = top / has_mm_s2
    left = span - since
    way = np.where(since < ramp, has_mm_s2 * since**2 / 2.0, top * (since - ramp / 2.0))
    way = np.where(left < ramp, np.abs(lengths_mm[block]) - has_mm_s2 * left**2 / 2.0, way)
    found: Floats = places[block] + np.sign(lengths_mm[block]) * way
    return found


def linuxcnc_profile(acceleration_mm_s2: float, folder: Path) -> str:
    """The profile that the machine test makes of a record of the commanded places."""
    program, form, trace, profile = (folder / name for name in ("t.ngc", "t.toml", "t.csv", "p.toml"))
    known = ("--set", "planner.max_feed_override=1")
    command_line("write", "-p", "linuxcnc-lathe", "-o", str(program), *known, "-q")
    text = "".join(f"{line}\n" for line in program.read_text().splitlines() if line != "M0")
    (run,) = machine.run(
        [text.encode()],
        acceleration_mm_s2=acceleration_mm_s2,
        velocity_mm_s=vibrated.VELOCITY_MM_S,
        lathe=True,
        speed_up=5.0,
    )
    rows = [f"{row[0]:.4f},{row[1]:.6f},{row[3]:.6f}" for row in run.samples.tolist()]
    trace.write_text("\n".join(["time_s,x_mm,z_mm", *rows]) + "\n")
    command_line("read", str(form), "--trace", str(trace), "-o", str(profile), *known, "-q")
    return str(profile)


def linuxcnc_cuts(acceleration_mm_s2: float, profile: str, draw: np.random.Generator) -> list[Kept]:
    """Cuts as promised, and as the simulated machine runs them."""
    jobs, results = [], []
    settings = chipbreak.load(profile, ["planner.max_feed_override=1"])
    for _ in range(4):
        wish = f"N{draw.choice([0.5, 1.5, 2.5])}"
        speed_rpm = float(draw.choice([500, 600, 750, 1000]))
        job = vibrated.Job(vibrated.TURNING, speed_rpm, wish, acceleration_mm_s2, feed_mm_rev=0.08)
        try:
            result = chipbreak.rewrite(job.program(), settings, allow_unbroken=True)
        except chipbreak.ProgramRejectedError:
            continue
        if result.cuts:
            jobs.append(job)
            results.append(result)
    runs = machine.run(
        [one.data for one in results],
        acceleration_mm_s2=acceleration_mm_s2,
        velocity_mm_s=vibrated.VELOCITY_MM_S,
        lathe=True,
        speed_up=3.0,
    )
    return [_linuxcnc_kept(*one) for one in zip(jobs, results, runs, strict=True)]


def _linuxcnc_kept(job: vibrated.Job, result: chipbreak.Result, run: machine.Run) -> Kept:
    ran = vibrated.outcome(job, result, run)
    found = ran.vibration()
    verdict = result.cuts[0].verdict
    promised = (verdict.per_rev, verdict.stroke_mm, bool(verdict.breaks))
    per_rev = found.frequency_hz * 60.0 / ran.promise.wave.speed_rpm
    breaks = ran.chips(settled=1.0).broken > 0
    strokes_mm = float(np.median(found.strokes_mm))
    return Kept(promised, (per_rev, strokes_mm, breaks), result.cuts[0].is_on_edge)
