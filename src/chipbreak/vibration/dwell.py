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
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.model import ControlModel, control_model
from chipbreak.trajectory.planner import predict
from chipbreak.trajectory.timing import Motion, motion_of
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.plan import CutPlan

Floats = NDArray[np.float64]
STAND_DECIMALS = 3  # of the seconds in a G4 block
_PER_S = 1000.0
_STILL_MM = 1e-9
_SOON_S = 1e-9
_PERIODS_LATE = 2.0


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
    model = control_model(settings, cut.path, cut.chain.before)
    feed_mm_s = min(motion.feed_speed_mm_s, model.velocity_mm_s)
    moves_s = float(predict([way_mm], [feed_mm_s], model)[0])
    stand_s = float(round(motion.period_s - moves_s, STAND_DECIMALS))
    # LinuxCNC's interpolator lets the move go on a little longer than its block.
    still_s = stand_s - (_PERIODS_LATE * model.servo_period_s if model.law == "linuxcnc" else 0.0)
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


def motion_with_stands(
    distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, model: ControlModel, stand_s: Floats
) -> Motion:
    """:func:`timing.motion_of` for blocks behind which the tool stands, (n,) seconds beside the spans."""
    if not stand_s.any():
        return motion_of(distance_mm, blocks, feeds_mm_s, model)
    ends = np.flatnonzero(stand_s > 0.0) + 1
    if ends[-1] != len(stand_s):
        ends = np.append(ends, len(stand_s))
    spans_s = np.empty(len(stand_s))
    known: dict[tuple[bytes, bytes], Motion] = {}
    times, places = list[Floats](), list[Floats]()
    now_s, first = 0.0, 0
    for last in ends.tolist():
        run = slice(first, last)
        key = (blocks.lengths_mm[run].tobytes(), feeds_mm_s[run].tobytes())
        if key not in known:
            part = Blocks(blocks.lengths_mm[run], blocks.bends[run], blocks.acceleration_mm_s2[run])
            ways_mm = np.append(0.0, np.cumsum(part.lengths_mm))
            known[key] = motion_of(ways_mm, part, feeds_mm_s[run], model)
        motion = known[key]
        spans_s[run] = motion.spans_s
        times.append(now_s + motion.time_s)
        places.append(distance_mm[first] + motion.distance_mm)
        places[-1][-1] = distance_mm[last]
        # Behind LinuxCNC's interpolator the motion ends a little later than its blocks.
        now_s = max(now_s + float(motion.spans_s.sum() + stand_s[last - 1]), float(times[-1][-1]) + _SOON_S)
        first = last
    if stand_s[-1] > 0.0:
        times.append(np.array([now_s]))
        places.append(distance_mm[-1:])
    return Motion(spans_s, np.concatenate(times), np.concatenate(places))
