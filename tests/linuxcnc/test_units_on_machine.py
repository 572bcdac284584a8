"""What a change of units leaves of F and of a tolerance, on LinuxCNC's simulated machine.

``rs274`` cannot be asked: without a machine behind it, it keeps both as the numbers that were typed.
"""

from __future__ import annotations

import numpy as np
import pytest

from . import machine

_WITHIN_MM = 0.3
_CORNER_MM = (30.0, 10.0)
_CYCLE = ("G17", "G81 X0.9 Y0 Z0.2 R0.5 F50", "G80", "G18")
_KEPT = ("M70", "G61", "M72")


def program(*between: str) -> bytes:
    """F and a tolerance in mm, something in inches, and a corner in mm again."""
    lines = (
        f"G21 G18 G90 G94 G40 G64 P{_WITHIN_MM}",
        "S100 M3",
        "F2540",
        "G20",
        "(debug, #<_feed>)",
        *between,
        "G21",
        "F2500",
        "G0 X30 Z30",
        "G1 X30 Z10",
        "G1 X10 Z10",
        "G0 Z30",
        "G95 F0.5",
        "G20",
        "(debug, #<_feed>)",
        "M2",
    )
    return "\n".join([*lines, ""]).encode()


@pytest.mark.linuxcnc("machine")
def test_a_change_of_units_converts_a_feed_per_minute_and_a_tolerance() -> None:
    """Also where a cycle or M72 says the tolerance again; of a feed per revolution it keeps the number."""
    runs = machine.run([program(), program(*_CYCLE), program(*_KEPT)], acceleration_mm_s2=500.0)
    for run in runs:
        assert [float(message) for message in run.messages] == pytest.approx([100.0, 0.5])
        from_corner_mm = np.hypot(*(run.samples[:, [1, 3]] - _CORNER_MM).T)
        assert from_corner_mm.min() == pytest.approx(_WITHIN_MM, rel=0.05)
