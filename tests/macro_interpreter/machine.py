"""A three-axis machine with a spindle that turns: it goes where it is told, in time, and skips at the beam.

Positions are those of the spindle nose, in machine coordinates [mm].  With ``reads_ahead`` moves wait until
a block that stops the reading ahead, as on a control that runs macro statements when they are buffered: a
macro that asks for a position too early gets an old one.

The beam sees each edge at the angle at which it is at that moment.  What it says to the control is the signal
of the barrier, which stays for a while after each edge so that no input misses one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from macro_interpreter.controls import FANUC_0I_F, FanucControl
from macro_interpreter.faults import MOTION, fault

AXES = "XYZ"
Floats = NDArray[np.float64]
Position = tuple[float, float, float]
_SCAN_MM = 0.02  # no chip or gap that matters is thinner
_FINER = 128  # parts of a step of the scan, and of a part of it: most of a look is the call
_EXACT_S = 1e-6
_EXACT_MM = 1e-8
_RAPID_MM_S = 400.0
_MOVE_S = 0.08  # what a rapid move takes to start and to stop
_LONG_AGO = -1e9


class Barrier(Protocol):
    """Something that gives a skip signal."""

    def broken(
        self, tool: int, points: Floats, begin_deg: ArrayLike, end_deg: ArrayLike | None = None
    ) -> NDArray[np.bool_]:
        """True where the beam is broken at some moment, with the spindle nose at points [mm]; (n, 3) -> (n,).

        The spindle turns from ``begin_deg`` to ``end_deg``; without it, it stands.
        """
        ...

    def teeth(self, tool: int) -> int:
        """How often a revolution of a tool may break the beam."""
        ...


class OpenBarrier:
    """A barrier that nothing breaks."""

    def broken(
        self, tool: int, points: Floats, begin_deg: ArrayLike, end_deg: ArrayLike | None = None
    ) -> NDArray[np.bool_]:
        """Never."""
        return np.zeros(len(points), np.bool_)

    def teeth(self, tool: int) -> int:
        """One."""
        return 1


@dataclass
class Machine:
    """The state of the machine, and a record of what it did.

    ``work_mm`` is the work offset in force, ``sample_s`` the time between two looks at the skip signal (0:
    without end), ``pulse_s`` how long the signal stays after an edge, ``gap_s`` after how long without an
    edge the barrier gives its signal when it looks for a missing one.  ``drops_s`` are the moments at which
    a drop of coolant breaks the beam.  ``crossings`` are the positions where something other than a skip
    move broke the beam, ``clock_s`` the time since power-on.
    """

    barrier: Barrier = field(default_factory=OpenBarrier)
    at: Position = (0.0, 0.0, 0.0)
    work_mm: Position = (0.0, 0.0, 0.0)
    control: FanucControl = FANUC_0I_F
    reads_ahead: bool = True
    sample_s: float = 0.0
    pulse_s: float = 0.01
    gap_s: float = 0.015
    drops_s: Floats = field(default_factory=lambda: np.empty(0))
    tool: int = 0
    speed_rpm: float = 0.0
    angle_deg: float = 0.0
    looks_for_gap: bool = False
    skipped_at: Position = (0.0, 0.0, 0.0)
    skip_count: int = 0
    crossings: list[Position] = field(default_factory=list)
    waiting: list[Callable[[], None]] = field(default_factory=list)
    planned: Position = (0.0, 0.0, 0.0)
    clock_s: float = 0.0

    def __post_init__(self) -> None:
        self.planned = self.at
        self._here_since_s = 0.0  # at this place, turning like this
        self._turned_from_s = 0.0
        self._last_edge_s = self._busy_until_s = _LONG_AGO

    @property
    def is_turning(self) -> bool:
        """The spindle turns."""
        return self.speed_rpm > 0.0

    def angles(self, times_s: Floats) -> Floats:
        """The angle of the spindle at times [deg]."""
        return self.angle_deg + (times_s - self._turned_from_s) * self.speed_rpm * 6.0

    def is_broken(self) -> bool:
        """The signal of the barrier now."""
        if self.looks_for_gap:
            self._look_back(self.gap_s)
            return self.clock_s - self._last_edge_s >= self.gap_s
        self._look_back(max(self.pulse_s, 0.0))
        return self.clock_s - self._last_edge_s <= self.pulse_s

    def _look_back(self, how_long_s: float) -> None:
        """Bring the time of the last edge up to now, as far back as it can matter."""
        begin = max(self._here_since_s, self.clock_s - how_long_s)
        times = self._steps_of(begin, self.clock_s, 0.0)
        seen = np.flatnonzero(self._seen(np.repeat([self.at], len(times) - 1, axis=0), times))
        if len(seen):
            self._last_edge_s = max(self._last_edge_s, float(times[seen[-1] + 1]))

    def wait(self, seconds: float) -> None:
        """Time passes."""
        self.clock_s += seconds

    def catch_up(self) -> None:
        """Do everything that is waiting."""
        waiting, self.waiting = self.waiting, []
        for action in waiting:
            action()

    def do(self, action: Callable[[], None]) -> None:
        """Do something in its turn: at once, or when the reading ahead stops."""
        if self.reads_ahead:
            self.waiting.append(action)
        else:
            action()

    def move(self, target: Position, feed_mm_min: float = 0.0) -> None:
        """Go straight to a position, in rapid or with a feed."""
        start, self.planned = self.planned, target
        self.do(lambda: self._go(start, target, feed_mm_min))

    def skip(self, target: Position, feed_mm_min: float) -> None:
        """Go straight to a position or to where the signal comes."""
        if not feed_mm_min > 0.0:
            raise fault(MOTION, "G31 without a feed", "give F")
        self.catch_up()
        self.skip_count += 1
        self.wait(2.0 * self.control.block_s)
        if self.is_broken():
            self.skipped_at = self.planned = self.at
            return
        start, end = np.array(self.at), np.array(target)
        length = float(np.linalg.norm(end - start))
        duration = max(length / (feed_mm_min / 60.0), 1e-6)
        late_s = self._first_signal(start, end, duration)
        took = duration if late_s is None else late_s
        if late_s is not None and self.sample_s > 0.0:
            took = min(duration, float(np.ceil(late_s / self.sample_s - 1e-9)) * self.sample_s)
        if late_s is not None and not self.looks_for_gap:
            self._last_edge_s = self.clock_s + late_s
        self.clock_s += took
        self._arrive(_position(start + took / duration * (end - start)))
        self.skipped_at = self.planned = self.at

    def turn(self, speed_rpm: float, angle_deg: float | None = None, *, moves_too: bool = False) -> None:
        """Start, stop or orient the spindle; a block that also moves ends when both are done."""

        def act() -> None:
            before, was_turning = self._is_in_beam(self.at), self.is_turning
            now = float(self.angles(np.array([self.clock_s]))[0]) % 360.0
            self.angle_deg = now if angle_deg is None else angle_deg
            self.speed_rpm = speed_rpm
            takes = self.control.spindle_s if speed_rpm or was_turning else 0.0
            takes = takes if angle_deg is None else self.control.orient_s
            if moves_too:
                self._busy_until_s = self.clock_s + takes
            else:
                self.wait(takes)
            self._turned_from_s = self._here_since_s = self.clock_s
            if self._is_in_beam(self.at) and not before:
                self.crossings.append(self.at)

        self.do(act)

    def end_block(self) -> None:
        """The spindle is as fast as it should be before the next block begins."""

        def act() -> None:
            self.wait(max(0.0, self._busy_until_s - self.clock_s))

        self.do(act)

    def look_for_gap(self, *, is_on: bool) -> None:
        """The barrier gives its signal for a missing edge, or for a broken beam."""

        def act() -> None:
            self.looks_for_gap = is_on
            # It starts to look now.
            self._last_edge_s = self.clock_s if is_on else _LONG_AGO
            self._here_since_s = self.clock_s if is_on else self._here_since_s

        self.do(act)

    def load(self, tool: int) -> None:
        """Put a tool into the spindle."""

        def act() -> None:
            self.tool, self.speed_rpm = tool, 0.0
            self.wait(5.0)

        self.do(act)

    def _arrive(self, place: Position) -> None:
        self.at, self._here_since_s = place, self.clock_s

    def _go(self, start: Position, target: Position, feed_mm_min: float) -> None:
        """A move that should not break the beam; leaving it is no crossing."""
        begin, end = np.array(start), np.array(target)
        length = float(np.linalg.norm(end - begin))
        if not length:
            return
        points = _points(begin, end, max(2, int(np.ceil(length / _SCAN_MM)) + 1))
        broken = self._swept(points)
        entries = np.flatnonzero(broken[1:] & ~broken[:-1])
        if len(entries) and not self.looks_for_gap:
            self.crossings.append(_position(points[entries[0] + 1]))
        self.clock_s += length / (feed_mm_min / 60.0) if feed_mm_min else length / _RAPID_MM_S + _MOVE_S
        if broken.any():
            share = float(np.flatnonzero(broken)[-1]) / (len(points) - 1)
            left_s = (1.0 - share) * length / (feed_mm_min / 60.0 if feed_mm_min else _RAPID_MM_S)
            self._last_edge_s = max(self._last_edge_s, self.clock_s - left_s)
        self._arrive(target)

    def _is_in_beam(self, place: Position) -> bool:
        return bool(self._swept(np.array([place]))[0])

    def _swept(self, points: Floats) -> NDArray[np.bool_]:
        """Where the tool breaks the beam in some revolution."""
        begin = float(self.angles(np.array([self.clock_s]))[0])
        return self.barrier.broken(self.tool, points, begin, begin + 360.0 * self.is_turning)

    def _first_signal(self, start: Floats, end: Floats, duration: float) -> float | None:
        """The time after which the signal comes on the way, None where it never does."""
        length = float(np.linalg.norm(end - start))
        begin = self.clock_s
        times = self._steps_of(begin, begin + duration, length)
        seen = self._seen(start + _shares(times, begin, duration) * (end - start), times)
        if self.looks_for_gap:
            return self._first_gap(times, seen)
        if not seen.any():
            return None
        first = int(np.argmax(seen))
        low, high = float(times[first]), float(times[first + 1])
        while high - low > _EXACT_S or (high - low) / duration * length > _EXACT_MM:
            finer = np.linspace(low, high, _FINER + 1)
            here = self._seen(start + _shares(finer, begin, duration) * (end - start), finer)
            at = int(np.argmax(here)) if here.any() else _FINER - 1
            low, high = float(finer[at]), float(finer[at + 1])
        return high - begin

    def _first_gap(self, times: Floats, seen: NDArray[np.bool_]) -> float | None:
        last = np.maximum.accumulate(np.where(seen, times[1:], self._last_edge_s))
        late = np.flatnonzero(times[1:] - last >= self.gap_s)
        self._last_edge_s = float(last[-1])
        return float(times[late[0] + 1] - self.clock_s) if len(late) else None

    def _steps_of(self, begin_s: float, end_s: float, length_mm: float) -> Floats:
        """Moments between two, near enough to each other for the way and for the spindle; shape (n,)."""
        count = max(2, int(np.ceil(length_mm / _SCAN_MM)) + 1)
        if self.is_turning:
            edge_s = 60.0 / self.speed_rpm / self.barrier.teeth(self.tool)
            count = max(count, int(np.ceil((end_s - begin_s) / edge_s * 8.0)) + 1)
        return np.linspace(begin_s, end_s, count)

    def _seen(self, points: Floats, times: Floats) -> NDArray[np.bool_]:
        """Whether an edge or a drop broke the beam between each two moments; n + 1 moments -> (n,)."""
        angles = self.angles(times) if self.is_turning else np.full(len(times), self.angle_deg)
        seen = self.barrier.broken(self.tool, points, angles[:-1], angles[1:])
        if len(self.drops_s):
            seen = seen | (np.diff(np.searchsorted(self.drops_s, times)) > 0)
        return seen


def _shares(times: Floats, begin_s: float, duration_s: float) -> Floats:
    """How far on its way a move is at the end of each step; n + 1 moments -> (n, 1)."""
    shares: Floats = ((times[1:] - begin_s) / duration_s)[:, np.newaxis]
    return shares


def _points(start: Floats, end: Floats, count: int) -> Floats:
    """Points along a line; shape (count, 3)."""
    points: Floats = start + np.linspace(0.0, 1.0, count)[:, np.newaxis] * (end - start)
    return points


def _position(point: Floats) -> Position:
    x, y, z = (float(value) for value in point)
    return x, y, z
