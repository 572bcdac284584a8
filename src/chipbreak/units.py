"""Unit constants, and the suffixes that carry units in names.

======== ==============================   ======== ===============================
suffix   unit                             suffix   unit
======== ==============================   ======== ===============================
_mm      millimetre                       _rpm     spindle revolutions per minute
_mm_min  millimetre per minute            _rev     spindle revolutions
_mm_rev  millimetre per revolution        _hz      vibrations per second
_mm_s    millimetre per second            _s, _ms  second, millisecond
_mm_s2   millimetre per second squared    _deg     degree
_m_min   metre per minute                 _share   a share of one, 0 to 1
======== ==============================   ======== ===============================

Vibrations per revolution carry ``per_rev``.  Conversion happens where a number is read and where it is
printed; between those two doors everything is mm, s and rpm.
"""

from __future__ import annotations

import math

MM_PER_INCH = 25.4
S_PER_MIN = 60.0
MS_PER_S = 1000.0


def spindle_speed_rpm(cutting_speed_m_min: float, diameter_mm: float) -> float:
    """Spindle speed of a cutting speed on a diameter: S = 1000 V / (pi D).

    >>> round(spindle_speed_rpm(120.0, 20.0))
    1910
    """
    return 1000.0 * cutting_speed_m_min / (math.pi * diameter_mm)
