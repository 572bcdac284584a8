"""Dwells: a chip ends where the tool rests for a revolution, and a shoulder is cleaned that way.

A control waits with G4, in seconds; the tool comes to rest before it and starts again behind it.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from chipbreak.dialects import Dialect
from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.sourced_value import shown
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.expander import Expander, Form, StrokeAsked

DWELL_DECIMALS = 3  # of the seconds in a G4 block
_FINE = 1000  # parts of a base period
_TRIES = 3
NO_STAND = "VIB086"
_STILL_MM = 1e-9
_SOON_S = 1e-9


def printed_s(dwell_s: float, step_s: float) -> float:
    """A time as G4 says it, never shorter, in whole steps of the control."""
    return round(math.ceil(dwell_s / step_s - 1e-6) * step_s, 6)


def dwell_block(dwell_s: float, dialect: Dialect) -> str:
    """The G4 block of this control that waits so long."""
    return f"G4 {dialect.dwell_word}{print_number(dwell_s * dialect.dwells_per_s, DWELL_DECIMALS)}"


class DwellExpander(Expander):
    """Moves at the program's own feed, and a dwell behind each."""

    keeps_feed = True
    larger = "take a larger E"

    def way_out_of_whole(self, edges: int, alpha: float) -> str:
        """See :meth:`Expander.way_out_of_whole`."""
        turns = 1.0 / edges / (1.0 - alpha)
        return f"take E {turns:.4g} or more: a dwell stands for a revolution (per edge)"

    def form(self, segments: str) -> Form:
        """One move and one dwell, whatever the profile says."""
        return "stroke"

    def stroke_mm(self, asked: StrokeAsked) -> float:
        """What the mean feed advances while the tool dwells.  Errors: VIB085 for a stroke asked for."""
        for key in ("Q", "A"):
            if key in asked.values:
                given = f"{key} {asked.values[key].value:g} ({asked.values[key].origin})"
                message = f"{given} is a stroke, and a dwell has none"
                raise RefusalError("VIB085", message, f"leave {key} out, or take WAVE TRIANGLE")
        return (1.0 - asked.alpha_share) * asked.alpha_share * asked.feed_mm_rev / asked.per_rev

    def ramp_s(self, ramp_s: float) -> float:
        """None: every dwell is a whole one."""
        return 0.0

    def knots(self, time_s: Floats, distance_mm: Floats) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Each dwell taken into the knot that it begins at."""
        still = np.diff(distance_mm, append=np.inf) <= _STILL_MM
        still &= np.diff(distance_mm, append=np.inf) >= -_STILL_MM
        kept = ~np.append(False, still[:-1])
        # A corner where it dwells has a knot of its own: the dwell goes on to the last knot of one place.
        ends = np.append(np.flatnonzero(kept)[1:], len(kept)) - 1
        return time_s[ends], distance_mm[kept], still[kept]

    def dwell_s(self, wave: WaveformParameters, law: ControlLaw, edges: int, per_rev: float) -> float:
        """What this control leaves of a vibration behind its move."""
        feed_mm_s = min(wave.feed_speed_mm_s, law.velocity_mm_s)
        moves_s = float(law.block_times([wave.speed_mm_s * wave.period_s], [feed_mm_s])[0])
        moves_s += law.dwell_delay_s
        dwell_s = float(round(round((wave.period_s - moves_s) / law.dwell_step_s) * law.dwell_step_s, 6))
        still_s = dwell_s + law.dwell_delay_s - law.late_behind_s(feed_mm_s)
        revolution_s = S_PER_MIN / wave.speed_rpm
        if still_s < revolution_s / edges - _SOON_S:
            more = ((1.0 - wave.alpha_share) * wave.period_s - still_s) / revolution_s
            turns = math.ceil((1.0 / edges + more) / (1.0 - wave.alpha_share) * 10.0 + 1.0) / 10.0
            message = (
                f"at N {shown(round(per_rev, 4))} the tool feeds for {moves_s * MS_PER_S:.4g} ms of"
                f" {wave.period_s * MS_PER_S:.4g} and stands for {max(0.0, still_s) / revolution_s:.3g}"
                f" revolutions; the chip ends only behind {1.0 / edges:.3g}"
            )
            raise RefusalError(NO_STAND, message, f"take E {turns:g}, or a smaller ALPHA")
        return dwell_s

    def in_whole_dwells(self, wave: WaveformParameters, law: ControlLaw, edges: int) -> WaveformParameters:
        """See :meth:`Expander.in_whole_dwells`."""
        step_s = law.dwell_step_s
        revolution_s = S_PER_MIN / wave.speed_rpm / edges
        wanted_s = (1.0 - wave.alpha_share) * wave.period_s
        least = math.ceil((revolution_s + law.late_s - law.dwell_delay_s) / step_s - _SOON_S)
        dwell_s = max(least, round(wanted_s / step_s)) * step_s
        feed_mm_s = min(wave.feed_speed_mm_s, law.velocity_mm_s)
        moves_s = wave.period_s - dwell_s
        way_mm = feed_mm_s * moves_s
        for _ in range(_TRIES):
            if way_mm > _STILL_MM:
                took_s = float(law.block_times([way_mm], [feed_mm_s])[0]) + law.dwell_delay_s
                way_mm += feed_mm_s * (moves_s - took_s)
        share = way_mm / wave.feed_speed_mm_s / wave.period_s
        ticks = wave.ticks * _FINE
        forward = round(share * ticks)
        if not 0 < forward < ticks:
            turns = math.ceil((dwell_s + wanted_s) / revolution_s / edges * 10.0) / 10.0
            message = (
                f"a dwell of this control takes whole {step_s * MS_PER_S:g} ms, and one of"
                f" {dwell_s * MS_PER_S:g} ms leaves no time to feed in {wave.period_s * MS_PER_S:.4g} ms"
            )
            raise RefusalError(NO_STAND, message, f"take E {turns:g}")
        share = wave.shape.share(forward, ticks)
        stroke_mm = (1.0 - share) * share * wave.feed_speed_mm_s * wave.period_s
        return replace(wave, ticks=ticks, forward_ticks=forward, stroke_mm=stroke_mm)

    def title(self, wave: WaveformParameters) -> str:
        """See :meth:`Expander.title`."""
        return "DWELL"

    def told(self, wave: WaveformParameters, dwell_s: float) -> tuple[str, str]:
        """How far the tool feeds, and how long it then dwells."""
        feeds = f"{wave.speed_mm_s * wave.period_s:.4g} mm at {wave.feed_mm_rev:.4g} mm/rev"
        turns = dwell_s / (S_PER_MIN / wave.speed_rpm)
        return "dwell", f"{feeds}, then stands {dwell_s * MS_PER_S:.4g} ms = {turns:.3g} revolutions"

    def told_need(self, acceleration_mm_s2: float) -> str:
        """See :meth:`Expander.told_need`."""
        return "never turns back"

    def told_without_count(self) -> str:
        """See :meth:`Expander.told_without_count`."""
        return ""
