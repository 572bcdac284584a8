"""Controls that look ahead and speed up before they interpolate: Fanuc and alike with AI contour control.

At a joint no axis may change its speed by more than ``joint_speed_mm_s``: where the tool turns back, it has
half of that, and on both sides the control speeds up and brakes evenly along the path.  The filters of the
axes follow.  The speeds at joints are planned like those of a control with junction deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junction import Junction
from chipbreak.trajectory.junction_plan import Moves

_NO_STEP = 1e-12


@dataclass(frozen=True)
class LookAhead(Junction):
    """Even acceleration along the path, speed steps of ``joint_speed_mm_s`` at most at joints."""

    name: ClassVar[str] = "look-ahead"
    needs_filters: ClassVar[bool] = True
    needs_feed_per_minute: ClassVar[bool] = True

    joint_speed_mm_s: float = 0.0

    def slower(self, share: float) -> Self:
        """See :meth:`ControlLaw.slower`."""
        return replace(super().slower(share), joint_speed_mm_s=self.joint_speed_mm_s / (1.0 + share))

    def _limits(self, moves: Moves) -> Floats:
        """See :meth:`Junction._limits`."""
        limits = np.zeros(len(moves) + 1)
        if self.every_block_stops:
            return limits
        steps = np.abs(np.diff(moves.ways, axis=0)).max(axis=1)
        limits[1:-1] = (self.joint_speed_mm_s / np.maximum(steps, _NO_STEP)) ** 2
        return limits
