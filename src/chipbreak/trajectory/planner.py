"""What planners of any control work out: the speed that takes a time."""

from __future__ import annotations

from math import inf, sqrt

Numbers = tuple[float, ...]


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
