"""What a vibration asks of the machine and of the tool: acceleration, servo, flank clearance."""

from __future__ import annotations

import math

from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.units import S_PER_MIN


def least_acceleration_mm_s2(cut: WaveformParameters, per_rev: float) -> float:
    """The acceleration below which no control can run the strokes [mm/s^2]; the waves say how it follows."""
    return cut.shape.least_acceleration_mm_s2(cut, per_rev)


def servo_share(
    frequency_hz: float, position_gain_1_s: float | None, acc_dec_s: float | None = None
) -> float:
    """What is left of an oscillation behind the position loop and the control's acc/dec filter.

    A loop of gain Kp leaves 1 / sqrt(1 + (2 pi V / Kp)^2), a moving average over the time T |sinc(V T)|: an
    acc/dec time of one vibration leaves nothing.

    >>> round(servo_share(62.5, 50.0), 2), round(servo_share(31.25, None, 0.032), 6)
    (0.13, 0.0)
    """
    share = 1.0
    if position_gain_1_s is not None:
        share /= math.hypot(1.0, 2.0 * math.pi * frequency_hz / position_gain_1_s)
    if acc_dec_s is not None:
        turn = math.pi * frequency_hz * acc_dec_s
        share *= abs(math.sin(turn) / turn)
    return share


def flank_clearance_deg(forward_mm_s: float, diameter_mm: float, speed_rpm: float) -> float:
    """How far the forward stroke turns the path of the edge into the flank: atan(v / (pi D S / 60)) [deg].

    The tool's clearance angle must be larger.
    """
    return math.degrees(math.atan2(forward_mm_s, math.pi * diameter_mm * speed_rpm / S_PER_MIN))
