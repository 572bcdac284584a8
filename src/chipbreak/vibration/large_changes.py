"""What changes by so much that nobody may find it out at the machine: said, and left to the user."""

from __future__ import annotations

from collections.abc import Callable

from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.vibration.judged import Judged
from chipbreak.vibration.programmed import programmed

SPEED_CHANGED = "VIB074"
TAKES_LONGER = "VIB075"
NOT_PROVEN = "VIB076"
NO_MACHINE = "VIB077"

# Shares of what was programmed from which on a change is said.
_SPEED_SHARE = 0.2
_TIME_SHARE = 1.3
# Above this acceleration a profile must say that the axis has it.
_USUAL_MM_S2 = 10_000.0
# No lathe feeds or swings by more.
_MOST_FEED_MM_REV = 5.0
_MOST_STROKE_MM = 5.0
_LOOK_AT_UNITS = "look at the unit of F (G94, G95), decimal points (control.decimal_point), and at Q and A"


def _speed(judged: Judged) -> Diagnostic | None:
    """The spindle turns at a speed that is far from the programmed one."""
    plan = judged.report.plan
    was = programmed(plan)
    now_rpm = plan.solution.speed_rpm
    if was is None or abs(now_rpm - was.speed_rpm) <= _SPEED_SHARE * was.speed_rpm:
        return None
    share = now_rpm / was.speed_rpm - 1.0
    message = f"the spindle turns at {now_rpm:g} rpm instead of {was.speed_rpm:g} ({share:+.0%}) in this cut"
    help_text = "take another N or f, or give S near that speed if the tool and the chuck allow it"
    return judged.diagnose(SPEED_CHANGED, message, help_text, Severity.WARNING)


def _time(judged: Judged) -> Diagnostic | None:
    """The cut takes much longer than it was programmed to."""
    was = programmed(judged.report.plan)
    now_s = judged.report.duration_s
    if was is None or was.duration_s is None or now_s <= _TIME_SHARE * was.duration_s:
        return None
    message = f"this cut takes {now_s:z.1f} s instead of {was.duration_s:z.1f} s"
    help_text = "take a higher f with the same N, so that S stays up, or a shorter stand of a dwell"
    return judged.diagnose(TAKES_LONGER, message, help_text, Severity.WARNING)


def _acceleration(judged: Judged) -> Diagnostic | None:
    """An acceleration that many machines do not have, on axes of which the profile says nothing."""
    report = judged.report
    settings = judged.interpreted.settings
    unknown = [axis for axis in report.plan.chain.axes if settings.acceleration_mm_s2(axis) is None]
    if not unknown or report.acceleration_mm_s2 <= _USUAL_MM_S2:
        return None
    keys = ", ".join(f"axes.{axis}.max_acceleration_mm_s2" for axis in unknown)
    needs = f"{report.acceleration_mm_s2 / 1000.0:z.1f} m/s2"
    message = f"the strokes need {needs}, and the profile does not say that the axis has as much"
    help_text = f"give {keys}, or take a lower f or feed"
    return judged.diagnose(NOT_PROVEN, message, help_text, Severity.WARNING)


def _sizes(judged: Judged) -> Diagnostic | None:
    """A feed or a stroke in another unit than was meant."""
    message = _beyond_any_machine(judged.report.plan.wave)
    return judged.diagnose(NO_MACHINE, message, _LOOK_AT_UNITS, Severity.WARNING) if message else None


def refuse_beyond_any_machine(wave: WaveformParameters) -> None:
    """Refuse what only a slip or a way through air feeds so fast.  Errors: RefusalError VIB077.

    For cuts that stay as they are where they cannot vibrate: whoever asks one cut is warned.
    """
    if message := _beyond_any_machine(wave):
        raise RefusalError(NO_MACHINE, message, _LOOK_AT_UNITS)


def _beyond_any_machine(wave: WaveformParameters) -> str:
    """What is larger than any machine makes it; empty where nothing is."""
    if wave.feed_mm_rev > _MOST_FEED_MM_REV:
        return f"the feed is {wave.feed_mm_rev:.4g} mm per revolution, more than any lathe cuts"
    if wave.stroke_mm > _MOST_STROKE_MM:
        return f"the stroke is {wave.stroke_mm:.4g} mm, more than any machine swings"
    return ""


LARGE_CHANGES: tuple[Callable[[Judged], Diagnostic | None], ...] = (_speed, _time, _acceleration, _sizes)
