"""One cut as long as the filter takes it, with each law of a control: the whole filter's time and memory.

    python benchmarks/long_cuts.py                  the table of docs/performance.md, a minute or two
    python benchmarks/long_cuts.py "klipper line"   one row

Each row is a process of its own, one after the other: seconds of the processor, the most memory, and the
blocks that came out.
"""

from __future__ import annotations

import json
import math
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import chipbreak


class Law(NamedTuple):
    """A profile, and how a program for it is written."""

    profile: str
    sets: tuple[str, ...]
    head: str
    speed_rpm: float
    per_rev: float = 1.5
    wish: str = "(VIB {})"
    end: str = "M30\n"
    is_diameter: bool = True
    per_minute: bool = False


FEED_MM = 0.05
_FAST = ("axes.X.max_acceleration_mm_s2=5000", "axes.Z.max_acceleration_mm_s2=5000")
_LOOP = (
    "axes.X.position_gain_1_s=50",
    "axes.Z.position_gain_1_s=50",
    "axes.X.acc_dec_ms=0",
    "axes.Z.acc_dec_ms=0",
)
_LINEAR = tuple(
    f"axes.{axis}.{key}"
    for axis in "XZ"
    for key in ('acc_dec="linear"', "acc_dec_ms=16", "position_gain_1_s=50")
)
_STEPS = ("steps_per_mm=250", "max_velocity_mm_min=5000", "max_acceleration_mm_s2=500")
_PATH = ("planner.path_velocity_mm_min=6000", "planner.path_acceleration_mm_s2=500")
_LATHE = "O1\nG21 G40 G99\n"
_LINUXCNC = "G21 G40 G95\n"

LAWS = {
    "ideal": Law("generic-lathe", (), _LINUXCNC, 3000.0),
    "trapezoid": Law("fanuc-lathe", ('planner.model="trapezoid"', *_FAST), _LATHE, 3000.0),
    "LinuxCNC": Law("linuxcnc-lathe", (), _LINUXCNC, 900.0, is_diameter=False),
    "LinuxCNC, any override": Law(
        "linuxcnc-lathe", ('output.feed_mode="minute"',), _LINUXCNC, 900.0, is_diameter=False
    ),
    "linear acc/dec": Law(
        "fanuc-lathe", ('planner.model="after-interpolation"', *_FAST, *_LINEAR), _LATHE, 600.0
    ),
    "position loop": Law(
        "fanuc-lathe", ('planner.model="after-interpolation"', *_FAST, *_LOOP), _LATHE, 900.0
    ),
    "look-ahead": Law(
        "fanuc-lathe",
        (
            'planner.model="look-ahead"',
            'output.feed_mode="minute"',
            "planner.joint_speed_mm_min=600",
            *_FAST,
            *_LOOP,
        ),
        _LATHE,
        900.0,
    ),
    "Klipper": Law(
        "klipper",
        (*_PATH, "axes.Z.max_velocity_mm_min=6000", "axes.Z.max_acceleration_mm_s2=500"),
        "G21\nG90\nG18\n",
        300.0,
        per_rev=0.5,
        wish="; VIB {}",
        end="",
        is_diameter=False,
        per_minute=True,
    ),
    "Grbl": Law(
        "grblhal-lathe",
        tuple(f"axes.{axis}.{key}" for axis in "XZ" for key in _STEPS),
        "G21\nG90\nG94\nG18\nG0 Y0\n",
        300.0,
        per_rev=0.5,
        is_diameter=False,
        per_minute=True,
    ),
}


class Cut(NamedTuple):
    """What is cut, with so many ``blocks_each`` vibration, and by the law what is not as usual."""

    block: Callable[[Law, float], tuple[str, str]]
    blocks_each: float = 2.0
    wave: str = ""
    speed_rpm: Mapping[str, float] = MappingProxyType({})
    per_rev: Mapping[str, float] = MappingProxyType({})
    sets: Mapping[str, tuple[str, ...]] = MappingProxyType({})


def _line(law: Law, length_mm: float) -> tuple[str, str]:
    return "G0 X20. Z2.", f"G1 Z{2.0 - length_mm:.3f}"


def _taper(law: Law, length_mm: float) -> tuple[str, str]:
    leg_mm = length_mm / math.sqrt(2.0)
    return "G0 X20. Z2.", f"G1 X{20.0 + _typed(law) * leg_mm:.3f} Z{2.0 - leg_mm:.3f}"


def _facing(law: Law, length_mm: float) -> tuple[str, str]:
    most_mm = 1.2 * length_mm
    return f"G0 X{_typed(law) * most_mm:.3f} Z2.", f"G1 X{_typed(law) * 0.25 * most_mm:.3f}"


def _arc(law: Law, length_mm: float) -> tuple[str, str]:
    """Sixty degrees, from along Z towards X."""
    sweep = math.radians(60.0)
    radius_mm = length_mm / sweep
    x_mm = 10.0 + radius_mm * (1.0 - math.cos(sweep))
    z_mm = 2.0 - radius_mm * math.sin(sweep)
    start = f"G0 X{_typed(law) * 10.0:.4f} Z2."
    return start, f"G2 X{_typed(law) * x_mm:.4f} Z{z_mm:.4f} I{radius_mm:.4f} K0."


def _typed(law: Law) -> float:
    """What X says of a radius."""
    return 2.0 if law.is_diameter else 1.0


_SLOW = dict.fromkeys(LAWS, 300.0)
CUTS = {
    "line": Cut(_line),
    "taper": Cut(_taper),
    "facing": Cut(_facing, sets=dict.fromkeys(LAWS, ("spindle.surface_tolerance=0.05",))),
    "arc": Cut(_arc),
    "arc, refused at its end": Cut(_arc, sets={"linear acc/dec": ("axes.X.position_gain_1_s=10",)}),
    "sine": Cut(_line, 33.0, " WAVE SINE", _SLOW),
    "sine round an arc": Cut(_arc, 30.0, " WAVE SINE", _SLOW),
    "dwell": Cut(_line, 2.0, " WAVE DWELL", per_rev={"position loop": 0.2, "LinuxCNC": 0.4}),
}

ROWS = (
    ("ideal", "line", 440_000),
    ("LinuxCNC", "line", 440_000),
    ("LinuxCNC", "arc", 440_000),
    ("LinuxCNC", "facing", 440_000),
    ("LinuxCNC", "sine", 415_000),
    ("LinuxCNC, any override", "line", 245_000),
    ("LinuxCNC, any override", "arc", 245_000),
    ("trapezoid", "line", 440_000),
    ("trapezoid", "sine round an arc", 89_000),
    ("Klipper", "line", 245_000),
    ("Grbl", "line", 245_000),
    ("linear acc/dec", "line", 440_000),
    ("linear acc/dec", "taper", 440_000),
    ("linear acc/dec", "facing", 440_000),
    ("linear acc/dec", "arc", 165_000),
    ("linear acc/dec", "arc, refused at its end", 165_000),
    ("look-ahead", "arc", 165_000),
    ("position loop", "dwell", 49_000),
    ("LinuxCNC", "dwell", 49_000),
)


def program(law: Law, cut: Cut, name: str, blocks: int) -> str:
    """A program with one cut of so many blocks."""
    per_rev = cut.per_rev.get(name, law.per_rev)
    speed_rpm = cut.speed_rpm.get(name, law.speed_rpm)
    length_mm = blocks / cut.blocks_each / per_rev * FEED_MM
    start, block = cut.block(law, length_mm)
    feed = FEED_MM * speed_rpm if law.per_minute else FEED_MM
    speed = f"M3 S{speed_rpm:g}" if law.per_minute else f"G97 S{speed_rpm:g} M3"
    if cut.block is _facing:
        surface = f"S{2.0 * math.pi * 1.2 * length_mm * speed_rpm / 1000.0:.1f} M3"
        speed = (
            f"G96 D{2.0 * speed_rpm:g} {surface}" if law.profile.startswith("linuxcnc") else f"G96 {surface}"
        )
    wish = law.wish.format(f"N{per_rev:g}{cut.wave}")
    return f"{law.head}{speed}\n{start}\n{wish}\n{block} F{feed:g}\n{law.end}"


def measured(name: str, kind: str, blocks: int) -> tuple[float, int, str]:
    """Seconds of the processor, the most memory [MB], and what came out."""
    law, cut = LAWS[name], CUTS[kind]
    settings = chipbreak.load(law.profile, (*law.sets, *cut.sets.get(name, ())))
    data = program(law, cut, name, blocks).encode()
    begin_s = time.process_time()
    try:
        came = f"{sum(one.move_count for one in chipbreak.rewrite(data, settings).cuts):,} blocks"
    except chipbreak.ProgramRejectedError as error:
        came = f"{error.diagnostics[0].code}: {error.diagnostics[0].message}"
    took_s = time.process_time() - begin_s
    return took_s, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1000, came


def main() -> int:
    """All rows, those that are named, or (with ``--one``) one of them in this process."""
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measured(*ROWS[int(sys.argv[2])])))
        return 0
    for number, (name, kind, blocks) in enumerate(ROWS):
        if sys.argv[1:] and f"{name} {kind}".lower() not in map(str.lower, sys.argv[1:]):
            continue
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}
        command = [sys.executable, __file__, "--one", str(number)]
        run = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
        took_s, memory_mb, came = json.loads(run.stdout)
        print(f"{name:24}{kind:26}{blocks:9,}  {took_s:5.2f} s {memory_mb:4} MB  {came}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
