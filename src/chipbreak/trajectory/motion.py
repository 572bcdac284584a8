"""The motion of a control, or of the machine behind it, along the path of a cut."""

from __future__ import annotations

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple

_LEAST_S = 1e-6


class Motion(NamedTuple):
    """How long each of some blocks takes [s], (n,), and where the tool is when.

    ``time_s`` and ``distance_mm`` are the knots of the motion along the path, (m,); between them it is even.
    ``delay_s`` is by how much the tool is behind the command, ``settling_s`` how long a change of the command
    is still seen, ``path_error_mm`` how far the tool leaves the path at most, ``look_s`` after how long the
    motion was looked at again: 0 for a command itself.
    """

    spans_s: Floats
    time_s: Floats
    distance_mm: Floats
    delay_s: float = 0.0
    settling_s: float = 0.0
    path_error_mm: float = 0.0
    look_s: float = 0.0

    @property
    def peak_acceleration_mm_s2(self) -> float:
        """The highest acceleration between knots; where these are few, it is a speed step in a knot."""
        step_s = np.diff(self.time_s)
        speed_mm_s = np.diff(self.distance_mm) / step_s
        middle_s = np.maximum((step_s[1:] + step_s[:-1]) / 2.0, _LEAST_S)
        return float(np.abs(np.diff(speed_mm_s) / middle_s).max(initial=0.0))

    def is_same(self, other: Motion) -> bool:
        """True where both are the same to the last digit."""
        pairs = zip(self[:3], other[:3], strict=True)
        return self[3:] == other[3:] and all(np.array_equal(mine, its) for mine, its in pairs)
