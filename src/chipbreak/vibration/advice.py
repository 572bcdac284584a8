"""The nearest conditions that a control can run, for the way out of a refusal."""

from __future__ import annotations

from dataclasses import replace

from chipbreak.diagnostics import RefusalError
from chipbreak.settings.sections import Settings
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.plan import VibratedCut, command_group
from chipbreak.vibration.planner import ControlModel, feed_for_time
from chipbreak.vibration.solve import Period, shown
from chipbreak.vibration.timing import control_model
from chipbreak.vibration.waveform import forward_ticks

LIMITS = ("VIB030", "VIB031", "VIB032")
_STEP = 0.93  # from one frequency tried to the next
_TRIES = 80


def with_advice(error: RefusalError, cut: VibratedCut, settings: Settings) -> RefusalError:
    """The same refusal; where a limit of the control is the cause, with a slower frequency that works."""
    if error.code not in LIMITS:
        return error
    model = control_model(settings, cut.path)
    group = command_group(settings)
    frequency_hz = cut.solution.frequency_hz
    for _ in range(_TRIES):
        frequency_hz *= _STEP
        period = group.nearest(frequency_hz)
        if period.frequency_hz < cut.solution.frequency_hz and _runs(cut, period, model):
            speed_rpm = round(S_PER_MIN * period.frequency_hz / cut.solution.per_rev)
            works = (
                f"N {shown(round(cut.solution.per_rev, 4))} with the same feed and stroke works at"
                f" f {shown(period.frequency_hz)} Hz, S {speed_rpm}"
            )
            return RefusalError(error.code, error.message, f"{error.help}; {works}")
    return error


def _runs(cut: VibratedCut, period: Period, model: ControlModel) -> bool:
    """True when both strokes of a full vibration can be run in a slower period."""
    ahead = forward_ticks(period.ticks, cut.cut.alpha_share)
    share = ahead / period.ticks
    advance_mm = cut.cut.feed_mm_rev / cut.solution.per_rev
    forward_mm = cut.cut.stroke_mm + share * advance_mm
    back_mm = cut.cut.stroke_mm - (1.0 - share) * advance_mm
    plain = replace(model, merge_mm=0.0)
    try:
        feed_for_time(forward_mm, share * period.period_s, plain)
        if back_mm > 0.0:
            feed_for_time(back_mm, (1.0 - share) * period.period_s, plain)
    except RefusalError:
        return False
    return True
