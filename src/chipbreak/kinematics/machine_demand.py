"""What a vibration asks of the machine and of the tool: acceleration, flank clearance."""

from __future__ import annotations

import math

from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.units import S_PER_MIN


def least_acceleration_mm_s2(cut: WaveformParameters, per_rev: float) -> float:
    """The acceleration below which no control can run the strokes [mm/s^2]; the waves say how it follows."""
    return cut.shape.least_acceleration_mm_s2(cut, per_rev)


def flank_clearance_deg(forward_mm_s: float, diameter_mm: float, speed_rpm: float) -> float:
    """How far the forward stroke turns the path of the edge into the flank: atan(v / (pi D S / 60)) [deg].

    The tool's clearance angle must be larger.
    """
    return math.degrees(math.atan2(forward_mm_s, math.pi * diameter_mm * speed_rpm / S_PER_MIN))
