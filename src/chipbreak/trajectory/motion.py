"""The motion of a control, or of the machine behind it, along the path of a cut."""

from __future__ import annotations

import hashlib

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple

_LEAST_S = 1e-6
_KNOTS_AT_ONCE = 1 << 16


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
        starts = range(0, len(self.time_s), _KNOTS_AT_ONCE)
        return max(self._peak_of(slice(first, first + _KNOTS_AT_ONCE + 2)) for first in starts)

    def _peak_of(self, knots: slice) -> float:
        step_s = np.diff(self.time_s[knots])
        speed_mm_s = np.diff(self.distance_mm[knots]) / step_s
        middle_s = np.maximum((step_s[1:] + step_s[:-1]) / 2.0, _LEAST_S)
        return float(np.abs(np.diff(speed_mm_s) / middle_s).max(initial=0.0))

    @property
    def fingerprint(self) -> bytes:
        """The same for motions that are the same to the last digit, and for no others."""
        every = hashlib.blake2b(repr(self[3:]).encode())
        for column in self[:3]:
            every.update(column.tobytes())
        return every.digest()
