"""Strokes in a row under a law of control: their feeds, where the axis is commanded, what they reach."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chipbreak.trajectory.law import AxisLimits, ControlLaw

Floats = NDArray[np.float64]


def on_z(law: ControlLaw) -> ControlLaw:
    """The law on a path along Z, whose limits are its own."""
    free, z = AxisLimits("", inf, inf), AxisLimits("Z", law.velocity_mm_s, law.acceleration_mm_s2)
    return law.along((0.0, 0.0, 1.0), (free, free, z))


def feeds_for_times(lengths_mm: ArrayLike, times_s: ArrayLike, law: ControlLaw) -> Floats:
    """The feed of each stroke; what one lacks to its wanted time for whole periods, the next one gets."""
    ends_s = [law.rounded(end_s) for end_s in np.cumsum(times_s).tolist()]
    pairs = zip(np.asarray(lengths_mm).tolist(), np.diff(ends_s, prepend=0.0).tolist(), strict=True)
    return np.array([law.feed_for_time(length, time) for length, time in pairs])


def trace(lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, law: ControlLaw) -> Floats:
    """Where Z is commanded in every servo period: (m, 2) of time [s] and distance [mm]."""
    law = on_z(law)
    lengths = np.asarray(lengths_mm, dtype=np.float64)
    moved = np.column_stack([np.zeros(len(lengths)), np.zeros(len(lengths)), lengths])
    places = np.append(0.0, np.cumsum(lengths))
    motion = law.motion(places, law.blocks(moved, lengths), np.asarray(feeds_mm_s, dtype=np.float64))
    periods = np.arange(round(motion.time_s[-1] / law.servo_period_s) + 1) * law.servo_period_s
    return np.column_stack([periods, np.interp(periods, motion.time_s, motion.distance_mm)])


def reached(times_s: ArrayLike, vibrations: float, speed_rpm: float) -> tuple[float, float]:
    """Frequency [Hz] and vibrations per revolution of blocks that last ``times_s``."""
    frequency_hz = vibrations / float(np.sum(times_s))
    return frequency_hz, frequency_hz * 60.0 / speed_rpm
