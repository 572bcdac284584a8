"""Which measures of a tool pass, as patent JP7625807B2 has it; the macros on the control do the same.

R' <= R + 0.005, L < L' <= L + 3, OD - 0.5 < OD' < OD + 0.5; lengths in mm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from chipbreak.inspection.edges import SAME_MM


def runout_passes(measured_mm: float, radius_mm: float, allowed_mm: float = 0.005) -> bool:
    """R' <= R + 0.005: the radius that the turning tool reaches."""
    return measured_mm - radius_mm <= allowed_mm + SAME_MM


def stick_out_mm(beam_mm: float, contact_mm: float, holder_mm: float) -> float:
    """Measured length L' = D - E with D = C - Bα.

    ``beam_mm``     C, from the machine's origin to the beam: master bar and what it measured, A + B
    ``contact_mm``  Bα, travel to where the tool breaks the beam
    ``holder_mm``   E, from the spindle's gauge line to the lower end of the holder
    """
    return beam_mm - contact_mm - holder_mm


def length_passes(measured_mm: float, length_mm: float, over_mm: float = 3.0) -> bool:
    """L < L' <= L + 3: a tool that is only as long as it should be is too short, its holder may touch."""
    excess_mm = measured_mm - length_mm
    return SAME_MM < excess_mm <= over_mm + SAME_MM


def diameter_passes(measured_mm: ArrayLike, diameter_mm: float, allowed_mm: float = 0.5) -> bool:
    """OD - 0.5 < OD' < OD + 0.5, both strictly; of the measurements at several angles the largest counts."""
    largest_mm = float(np.max(np.asarray(measured_mm, np.float64)))
    return abs(largest_mm - diameter_mm) < allowed_mm - SAME_MM
