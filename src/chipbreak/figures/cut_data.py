"""What the figures of a cut are drawn from: its report, and its motion as the output commands it."""

from __future__ import annotations

import math

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.report.model import ExplainedCut
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.measure import CutMotion

_SAMPLES_PER_TURN = 721


class DrawnCut(NamedTuple):
    """A vibrated cut: what is said of it, its motion, and the cutting edges of its tool."""

    told: ExplainedCut
    motion: CutMotion
    edges: int = 1

    @property
    def turn_s(self) -> float:
        """The time of a revolution."""
        return S_PER_MIN / self.told.speed_rpm

    @property
    def pass_s(self) -> float:
        """The time from one edge to the next at one place of the work."""
        return self.turn_s / self.edges

    @property
    def feed_mm(self) -> float:
        """The feed of one edge."""
        return self.told.feed_mm_rev / self.edges

    def at(self, time_s: Floats) -> Floats:
        """Where the tool is along the path [mm], at times of any shape."""
        return np.interp(time_s, self.motion.time_s, self.motion.distance_mm)

    def middle_s(self) -> float:
        """The begin of a revolution in the middle of the cut, where the stroke is full."""
        turns = self.motion.time_s[-1] / self.turn_s
        return math.floor(float(turns) / 2.0) * self.turn_s

    def thickness_mm(self, time_s: Floats) -> Floats:
        """Uncut chip thickness with every earlier pass left on the part, at times (n,); below 0 is air.

        The same as :mod:`chipbreak.kinematics.chip_model` says, at given times.
        """
        passes = math.floor(self.told.verdict.stroke_mm / self.feed_mm) + 2
        earlier_s = time_s - self.pass_s * np.arange(1, passes + 1)[:, np.newaxis]
        walls = np.where(earlier_s >= 0.0, self.at(earlier_s), self.motion.distance_mm[0])
        height: Floats = self.at(time_s) - walls.max(axis=0)
        return height


def turn_samples() -> Floats:
    """Shares of a revolution, (n,), fine enough to draw."""
    return np.linspace(0.0, 1.0, _SAMPLES_PER_TURN)
