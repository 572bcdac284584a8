"""Adds up seconds by what they are spent on, and keeps what could not be timed."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.settings.sections import Settings
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source
from chipbreak.units import S_PER_MIN

CUTTING, RAPIDS, DWELLS, CHANGES = "cutting", "rapids", "dwells", "tool changes"
# What is taken where neither the profile nor the program says it.
ASSUMED_RAPID_MM_MIN = 10_000.0
_ASSUMED_CHANGE_S = {True: 2.0, False: 5.0}  # a turret, a changer
_UNKNOWN_RAPID_S = 1.0
_AXES = "XYZ"


class Untimed(NamedTuple):
    """A line of the user's file (from 1) whose time nobody knows, and why."""

    line: int
    why: str


class Machine:
    """What a machine's axes and its tool changer need, from the profile or assumed."""

    def __init__(self, settings: Settings) -> None:
        times = settings.times
        said = [settings.axes[axis].max_velocity_mm_min for axis in _AXES]
        speeds = [times.rapid_mm_min or one or ASSUMED_RAPID_MM_MIN for one in said]
        self.speed_mm_s: Floats = np.array(speeds) / S_PER_MIN
        known = [settings.acceleration_mm_s2(axis) or math.inf for axis in _AXES]
        self.acceleration_mm_s2: Floats = np.array(known)
        self.assumes_rapids: tuple[bool, ...] = tuple(not (times.rapid_mm_min or one) for one in said)
        self.assumes_change = times.tool_change_s is None
        change_s = times.tool_change_s
        self.change_s = _ASSUMED_CHANGE_S[settings.dialect.is_lathe] if change_s is None else change_s


class Clock:
    """The seconds of a program as they are found; ``source`` has the lines that are looked at."""

    def __init__(self, machine: Machine, source: Source) -> None:
        self.machine = machine
        self.source = source
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.untimed: list[Untimed] = []
        self.changes = 0
        self.unknown_rapids = 0
        self.assumed_axes: set[str] = set()
        self.counted_once = False
        self.calls: list[tuple[range, int]] = []

    def add(self, what: str, time_s: float) -> None:
        """Seconds spent on something."""
        self.seconds[what] += time_s

    def cannot(self, line: int, why: str) -> None:
        """A line of the source, from 0, that cannot be timed."""
        self.untimed.append(Untimed(self.source.place(line).line, why))

    def change_tool(self) -> None:
        """A tool comes into the spindle, or the turret turns."""
        self.changes += 1
        self.add(CHANGES, self.machine.change_s)

    def rapid_without_place(self, count: int = 1) -> None:
        """Rapids whose start or end nobody knows."""
        self.unknown_rapids += count
        self.add(RAPIDS, count * _UNKNOWN_RAPID_S)

    def moved(self, way_mm: Floats) -> None:
        """Rapids with these ways, (n, 3), use the speed of these axes."""
        for axis, used, assumed in zip(
            _AXES, (way_mm != 0.0).any(axis=0), self.machine.assumes_rapids, strict=True
        ):
            if used and assumed:
                self.assumed_axes.add(axis)

    def assumptions(self) -> Iterator[tuple[str, str]]:
        """What was taken where nobody says it, in short words, and the key of the profile that would."""
        if self.assumed_axes:
            yield f"rapids {ASSUMED_RAPID_MM_MIN / 1000.0:g} m/min", "times.rapid_mm_min"
        if self.unknown_rapids:
            yield f"{_UNKNOWN_RAPID_S:g} s a rapid where a place is unknown", ""
        if self.changes and self.machine.assumes_change:
            yield f"tool change {self.machine.change_s:g} s", "times.tool_change_s"
        if self.counted_once:
            yield "loops and jumps run once", ""
