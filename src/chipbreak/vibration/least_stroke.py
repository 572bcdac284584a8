"""The smallest stroke that the output and the axes can make, and what is said of a smaller one."""

from __future__ import annotations

from chipbreak.kinematics.toolpath import Path
from chipbreak.kinematics.waveform import WaveformParameters
from chipbreak.model.modal import State
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.vibration.axis_steps import axis_steps_mm

TOO_FINE = "VIB059"

_LEAST_STEPS = 4
_LEAST_FEED_MM_REV = 0.001  # less is rubbed off, and was meant to be another unit


def refuse_too_fine(
    wave: WaveformParameters, path: Path, state: State, larger: str, settings: Settings
) -> None:
    """Refuse a stroke of few steps, or a feed of next to none, before a million blocks are made of it.

    Errors: VIB059.
    """
    if wave.feed_mm_rev < _LEAST_FEED_MM_REV:
        said = with_feed_per_minute("no chip is that thin", "or give a higher feed", state, wave.feed_mm_rev)
        if state.feed is None or state.modes.feed_mode != "minute":
            said = f"no chip is as thin as {wave.feed_mm_rev:.3g} mm per revolution", "give a higher feed"
        raise RefusalError(TOO_FINE, *said)
    if wave.stroke_mm < _LEAST_STEPS * _step_mm(path, state, settings):
        raise too_fine(wave, path, state, larger, settings)


def too_fine(
    wave: WaveformParameters, path: Path, state: State, larger: str, settings: Settings
) -> RefusalError:
    """The refusal; ``larger`` is how its wave gets a larger stroke."""
    step_mm = _step_mm(path, state, settings)
    message = f"the stroke of {wave.stroke_mm:.4g} mm has fewer than {_LEAST_STEPS} steps of {step_mm:g} mm"
    is_axis = step_mm > settings.output.step_mm(is_inch=state.is_inch)
    help_text = larger if is_axis else f"raise output.decimals, or {larger}"
    return RefusalError(TOO_FINE, *with_feed_per_minute(message, help_text, state, wave.feed_mm_rev))


def _step_mm(path: Path, state: State, settings: Settings) -> float:
    """The coarsest step of the output and of the axes that move."""
    moving = [AXES.index(axis) for axis in moving_axes(path)]
    axes_mm = float(axis_steps_mm(settings, state)[moving].max(initial=0.0))
    return max(settings.output.step_mm(is_inch=state.is_inch), axes_mm)


def moving_axes(path: Path) -> str:
    """The axes whose position changes anywhere on a path."""
    moved = {axis for i, axis in enumerate(AXES) if any(leg.start[i] != leg.end[i] for leg in path.legs)}
    moved |= {AXES[i] for arc in path.arcs if arc is not None for i in arc.axes}
    return "".join(axis for axis in AXES if axis in moved)


def with_feed_per_minute(message: str, help_text: str, state: State, feed_mm_rev: float) -> tuple[str, str]:
    """Both, with the likeliest cause of a tiny feed: a control that starts in G94 reads it per minute."""
    if state.feed is None or state.modes.feed_mode != "minute":
        return message, help_text
    said = f"{message}; the feed F{state.feed.text} is per minute: {feed_mm_rev:.3g} mm per revolution"
    return said, f"command feed per revolution (G95, G99), {help_text}"
