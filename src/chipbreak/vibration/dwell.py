"""Standing still: a chip ends where the tool stands for a revolution, and a shoulder is cleaned that way.

A control waits with G4, in seconds; the tool comes to rest before it and starts again behind it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.sourced_value import shown
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.plan import CutPlan

Floats = NDArray[np.float64]
STAND_DECIMALS = 3  # of the seconds in a G4 block
_PER_S = 1000.0
_STILL_MM = 1e-9
_SOON_S = 1e-9


def printed_s(stand_s: float) -> float:
    """A time as G4 says it, never shorter."""
    return math.ceil(stand_s * _PER_S - 1e-6) / _PER_S


def dwell_s(cut: CutPlan, settings: Settings) -> float:
    """How long the tool stands in each vibration of a dwell: what this control leaves of it behind the move.

    0 for another wave.  Errors: VIB086 when that is less than a revolution.
    """
    motion = cut.wave
    if motion.waveform != "dwell":
        return 0.0
    way_mm = motion.speed_mm_s * motion.period_s
    law = control_along(settings, cut.path, cut.chain.before)
    feed_mm_s = min(motion.feed_speed_mm_s, law.velocity_mm_s)
    moves_s = float(law.block_times([way_mm], [feed_mm_s])[0])
    stand_s = float(round(motion.period_s - moves_s, STAND_DECIMALS))
    still_s = stand_s - law.late_s
    revolution_s = S_PER_MIN / motion.speed_rpm
    if still_s < revolution_s / cut.edges - _SOON_S:
        more = ((1.0 - motion.alpha_share) * motion.period_s - still_s) / revolution_s
        turns = math.ceil((1.0 / cut.edges + more) / (1.0 - motion.alpha_share) * 10.0 + 1.0) / 10.0
        message = (
            f"at N {shown(round(cut.solution.per_rev, 4))} the tool feeds for {moves_s * MS_PER_S:.4g} ms of"
            f" {motion.period_s * MS_PER_S:.4g} and stands for {max(0.0, still_s) / revolution_s:.3g}"
            f" revolutions; the chip ends only behind {1.0 / cut.edges:.3g}"
        )
        raise RefusalError("VIB086", message, f"take E {turns:g}, or a smaller ALPHA")
    return stand_s


def without_stands(time_s: Floats, distance_mm: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Knots with each stand taken into the knot that it begins at, and where there was one; (n,) each.

    The time of such a knot is the end of the stand.
    """
    still = np.diff(distance_mm, append=np.inf) <= _STILL_MM
    still &= np.diff(distance_mm, append=np.inf) >= -_STILL_MM
    kept = ~np.append(False, still[:-1])
    time_s = np.where(still, np.append(time_s[1:], 0.0), time_s)
    return time_s[kept], distance_mm[kept], still[kept]
