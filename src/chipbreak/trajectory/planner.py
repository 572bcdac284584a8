"""What planners of any control work out: joint speeds, and the speed that takes a time."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

Numbers = tuple[float, ...]


def joint_speeds(lengths: Sequence[float], limits: Sequence[float], acceleration: float) -> list[float]:
    """The highest speed at the end of each block from which all later ones can still brake to rest.

    ``limits`` are those of the joints.  Lengths in mm, speeds in mm/s, acceleration in mm/s².
    """
    ends = [*limits, 0.0]
    for index in range(len(lengths) - 1, 0, -1):
        ends[index - 1] = min(ends[index - 1], sqrt(ends[index] ** 2 + 2.0 * acceleration * lengths[index]))
    return ends


def speed_for_time(length: float, time: float, acceleration: float) -> float:
    """The speed of a trapezoid over ``length`` in ``time``: (a·t − sqrt(a²t² − 4·a·d))/2.

    The peak of the triangle where the acceleration leaves no time at an even speed.

    >>> round(speed_for_time(0.1, 0.0375, 2000.0), 3)
    2.769
    """
    if acceleration == inf:
        return length / time
    rate = acceleration * time
    return (rate - sqrt(max(rate * rate - 4.0 * acceleration * length, 0.0))) / 2.0
