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
printed, by the functions here; between those two doors everything is mm, s and rpm.
"""

from __future__ import annotations

import math

MM_PER_INCH = 25.4
S_PER_MIN = 60.0
MS_PER_S = 1000.0
_FEET_PER_M = 1000.0 / 304.8
# A number that was typed has fewer digits than this, so what conversion does to its last bits goes away.
_TYPED_DIGITS = 12


def mm_per_unit(*, is_inch: bool) -> float:
    """Millimetres in the unit of length of a program."""
    return MM_PER_INCH if is_inch else 1.0


def mm_per_step(*, is_inch: bool) -> float:
    """What increments and decimals divide: a millimetre, in inch programs a tenth of an inch."""
    return MM_PER_INCH / 10.0 if is_inch else 1.0


def typed_feed(feed_mm: float, *, is_inch: bool) -> float:
    """The number of an F word for a feed per minute or per revolution; what was typed comes back as typed.

    >>> typed_feed(0.005 * MM_PER_INCH, is_inch=True)
    0.005
    """
    return float(f"{feed_mm / MM_PER_INCH:.{_TYPED_DIGITS}g}") if is_inch else feed_mm


def surface_speed_m_min(typed: float, *, is_inch: bool) -> float:
    """The cutting speed of an S word under constant surface speed: feet per minute in inch programs.

    >>> round(surface_speed_m_min(400.0, is_inch=True), 2)
    121.92
    """
    return typed / _FEET_PER_M if is_inch else typed


def typed_surface_speed(speed_m_min: float, *, is_inch: bool) -> float:
    """The number of an S word under constant surface speed; what was typed comes back as typed.

    >>> typed_surface_speed(surface_speed_m_min(400.0, is_inch=True), is_inch=True)
    400.0
    """
    return float(f"{speed_m_min * _FEET_PER_M:.{_TYPED_DIGITS}g}") if is_inch else speed_m_min


def spindle_speed_rpm(cutting_speed_m_min: float, diameter_mm: float) -> float:
    """Spindle speed of a cutting speed on a diameter: S = 1000 V / (pi D).

    >>> round(spindle_speed_rpm(120.0, 20.0))
    1910
    """
    return 1000.0 * cutting_speed_m_min / (math.pi * diameter_mm)
