"""The spindle speed of a cut under constant surface speed (G96), which vibrates at one speed in rpm."""

from __future__ import annotations

import math

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.model.modal import State
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import spindle_speed_rpm, typed_surface_speed
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.left_cut import UNKNOWN_SPEED

_LEAST_RPM, _MOST_RPM = 1e-3, 1e7
_FUZZ = 1e-6


class SurfaceSpeed(NamedTuple):
    """What G96 asks for: the cutting speed [m/min], and the speed that the spindle never exceeds [rpm]."""

    m_min: float
    most_rpm: float

    def rpm(self, radius_mm: float) -> float:
        """The speed at a signed radius."""
        if radius_mm == 0.0:
            return self.most_rpm
        return min(spindle_speed_rpm(self.m_min, 2.0 * abs(radius_mm)), self.most_rpm)

    def radius_mm(self, rpm: float) -> float:
        """Where the spindle turns at a speed below the highest; the other way round."""
        return spindle_speed_rpm(self.m_min, 2.0 * rpm)


def surface_speed_of(chain: Chain, settings: Settings) -> SurfaceSpeed | None:
    """What a chain under G96 asks for; None elsewhere, and where the start has no speed above zero.

    Without any limit the spindle is not asked for more than at the start of the cut.
    """
    state = chain.before
    speed = state.speed
    if state.modes.speed_mode != "surface" or speed is None or not 0.0 < speed.value < _MOST_RPM:
        return None
    limit = limit_rpm(state, settings)
    asked = SurfaceSpeed(speed.value, math.inf if limit is None else limit)
    start_rpm = asked.rpm(next(chain.moves).start.x)
    if not 0.0 < start_rpm < math.inf:
        return None
    return asked if limit is not None else asked._replace(most_rpm=start_rpm)


def active_speed(chain: Chain, speed: SourcedValue, settings: Settings, reasons: list[str]) -> SourcedValue:
    """The modal S as rpm; under constant surface speed, one that suits the diameters of the cut.

    That is the speed at its start, or where the tolerance of the profile asks for it a middle one.  Errors:
    VIB053 and VIB054 for a speed that cannot be known.
    """
    if not _LEAST_RPM <= speed.value < _MOST_RPM:
        message = f"the spindle speed ({speed.origin}) cannot be known, is zero, or is none of a spindle"
        raise RefusalError(UNKNOWN_SPEED, message, "give S as a number before the cut")
    state = chain.before
    if state.modes.speed_mode != "surface":
        return speed
    asked = surface_speed_of(chain, settings)
    if asked is None:
        raise _no_speed(limit_rpm(state, settings))
    diameter_mm = 2.0 * abs(next(chain.moves).start.x)
    middle = _middle_rpm(chain, asked, settings)
    rpm = _printed(middle or asked.rpm(diameter_mm / 2.0), limit_rpm(state, settings), settings)
    typed = typed_surface_speed(speed.value, is_inch=state.is_inch)
    if middle is None:
        reasons.append(f"G96 S{typed:g} -> G97 at the start diameter {diameter_mm:g} mm: {rpm:z.0f} rpm")
        return SourcedValue(rpm, f"G96 at diameter {diameter_mm:g} mm, {speed.origin}")
    where = f"diameters {diameter_mm:.4g} to {2.0 * abs(list(chain.moves)[-1].end.x):.4g} mm"
    reasons.append(f"G96 S{typed:g} -> G97 for {where}: {rpm:z.0f} rpm")
    return SourcedValue(rpm, f"G96 at {where}, {speed.origin}")


def _no_speed(limit: float | None) -> RefusalError:
    if limit is not None and limit <= 0.0:
        message = f"constant surface speed (G96) is limited to S{limit:g}, so the spindle stands in this cut"
        return RefusalError("VIB054", message, "give a limit above zero (G50 S, G92 S, G96 D), or G97 S")
    message = "constant surface speed (G96) has no finite speed where this cut starts"
    return RefusalError("VIB054", message, "give G97 S, or limit the spindle (G50 S, G92 S, G96 D)")


def bounds_rpm(chain: Chain, asked: SurfaceSpeed) -> tuple[float, float]:
    """The lowest and the highest speed that the joints of a chain ask for."""
    speeds = [asked.rpm(move.end.x) for move in chain.moves]
    speeds.append(asked.rpm(next(chain.moves).start.x))
    return min(speeds), max(speeds)


def _middle_rpm(chain: Chain, asked: SurfaceSpeed, settings: Settings) -> float | None:
    """A speed within the tolerance from end to end; None where that at the start is, or none can be."""
    tolerance = settings.spindle.surface_tolerance
    low, high = bounds_rpm(chain, asked)
    start = asked.rpm(next(chain.moves).start.x)
    if start / low <= 1.0 + tolerance + _FUZZ and start / high >= 1.0 - tolerance - _FUZZ:
        return None
    if high / low > (1.0 + tolerance) / (1.0 - tolerance) + _FUZZ:
        return None
    return 2.0 / (1.0 / low + 1.0 / high)


def _printed(rpm: float, limit: float | None, settings: Settings) -> float:
    """A speed to the resolution of the spindle, not above its limit."""
    step = settings.spindle.resolution_rpm
    printed = math.floor(rpm / step + 0.5) * step
    if limit is not None and printed > limit:
        printed = math.floor(limit / step) * step
    return round(printed, 9)  # 25862 * 0.1 is not 2586.2 in binary


def limit_rpm(state: State, settings: Settings) -> float | None:
    """The highest spindle speed of program and profile; None where neither says one."""
    limits = [settings.spindle.max_rpm, state.speed_limit.value if state.speed_limit else None]
    known = [limit for limit in limits if limit is not None and not math.isnan(limit)]
    return min(known) if known else None
