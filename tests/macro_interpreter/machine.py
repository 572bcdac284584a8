"""A simple three-axis machine: it goes where it is told, and stops a skip move where the beam breaks.

Positions are those of the spindle nose, in machine coordinates [mm].  With ``reads_ahead`` moves wait until
a block that stops the reading ahead, as on a control that runs macro statements when they are buffered: a
macro that asks for a position too early gets an old one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from macro_interpreter.faults import MOTION, fault

AXES = "XYZ"
Position = tuple[float, float, float]
_SCAN_MM = 0.02  # no chip or gap that matters is thinner
_EXACT_MM = 1e-8


class Barrier(Protocol):
    """Something that gives a skip signal."""

    def broken(self, tool: int, angle_deg: float | None, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """True where the beam is broken with the spindle nose at points [mm]; (n, 3) -> (n,).

        ``angle_deg`` is None while the spindle turns.
        """
        ...


class OpenBarrier:
    """A barrier that nothing breaks."""

    def broken(self, tool: int, angle_deg: float | None, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Never."""
        return np.zeros(len(points), np.bool_)


@dataclass
class Machine:
    """The state of the machine, and a record of what it did.

    ``work_mm`` is the work offset in force, ``sample_s`` the time between two looks at the skip signal (0:
    without end), ``crossings`` the positions where something other than a skip move broke the beam.
    """

    barrier: Barrier = field(default_factory=OpenBarrier)
    at: Position = (0.0, 0.0, 0.0)
    work_mm: Position = (0.0, 0.0, 0.0)
    reads_ahead: bool = False
    sample_s: float = 0.0
    tool: int = 0
    is_turning: bool = False
    angle_deg: float = 0.0
    skipped_at: Position = (0.0, 0.0, 0.0)
    skip_count: int = 0
    crossings: list[Position] = field(default_factory=list)
    waiting: list[Callable[[], None]] = field(default_factory=list)
    planned: Position = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        self.planned = self.at

    def is_broken(self) -> bool:
        """The skip signal now."""
        return bool(self._broken(np.array([self.at]))[0])

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

    def move(self, target: Position) -> None:
        """Go straight to a position."""
        start, self.planned = self.planned, target
        self.do(lambda: self._go(start, target))

    def skip(self, target: Position, feed_mm_min: float) -> None:
        """Go straight to a position or to where the beam breaks."""
        if not feed_mm_min > 0.0:
            raise fault(MOTION, "G31 without a feed", "give F")
        self.catch_up()
        self.skip_count += 1
        start, end = np.array(self.at), np.array(target)
        length = float(np.linalg.norm(end - start))
        share = self._first_broken(start, end, length)
        if share < 1.0 and self.sample_s > 0.0 and length > 0.0:
            step = feed_mm_min / 60.0 * self.sample_s / length
            share = min(1.0, float(np.ceil(share / step - 1e-9)) * step)
        self.at = _position(start + share * (end - start))
        self.skipped_at = self.planned = self.at

    def turn(self, *, is_turning: bool, angle_deg: float | None = None) -> None:
        """Start, stop or orient the spindle."""

        def act() -> None:
            before = self.is_broken()
            self.is_turning = is_turning
            self.angle_deg = self.angle_deg if angle_deg is None else angle_deg
            if self.is_broken() and not before:
                self.crossings.append(self.at)

        self.do(act)

    def load(self, tool: int) -> None:
        """Put a tool into the spindle."""

        def act() -> None:
            self.tool, self.is_turning = tool, False

        self.do(act)

    def _go(self, start: Position, target: Position) -> None:
        """A move that should not break the beam; leaving it is no crossing."""
        begin, end = np.array(start), np.array(target)
        points = _points(begin, end, float(np.linalg.norm(end - begin)))
        broken = self._broken(points)
        entries = np.flatnonzero(broken[1:] & ~broken[:-1])
        if len(entries):
            self.crossings.append(_position(points[entries[0] + 1]))
        self.at = target

    def _first_broken(self, start: NDArray[np.float64], end: NDArray[np.float64], length: float) -> float:
        """Share of the way after which the beam is broken; 1 where it never is."""
        points = _points(start, end, length)
        hits = np.flatnonzero(self._broken(points))
        if len(hits) == 0:
            return 1.0
        if hits[0] == 0:
            return 0.0
        low, high = float(hits[0] - 1) / (len(points) - 1), float(hits[0]) / (len(points) - 1)
        while (high - low) * length > _EXACT_MM:
            shares = np.linspace(low, high, 65)
            first = int(np.argmax(self._broken(start + shares[1:, np.newaxis] * (end - start))))
            low, high = float(shares[first]), float(shares[first + 1])
        return high

    def _broken(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self.barrier.broken(self.tool, None if self.is_turning else self.angle_deg, points)


def _points(start: NDArray[np.float64], end: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Points along a line, near enough to each other; shape (n, 3)."""
    count = max(2, int(np.ceil(length / _SCAN_MM)) + 1)
    points: NDArray[np.float64] = start + np.linspace(0.0, 1.0, count)[:, np.newaxis] * (end - start)
    return points


def _position(point: NDArray[np.float64]) -> Position:
    x, y, z = (float(value) for value in point)
    return x, y, z
