"""The steps in which the axes move: positions that lie between two of them cannot be reached."""

from __future__ import annotations

from decimal import Decimal

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.model.modal import State
from chipbreak.model.words import is_diameter
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.vibration.machine import law_of

_SAME = 1e-9
_NEAR_HALF = 1e-3
_READ_DIGITS = 8  # behind the point of a word


def axis_steps_mm(settings: Settings, state: State) -> Floats:
    """The step of each axis [mm of travel], (3,); 0 where nobody said it."""
    by_diameter = is_diameter(state, settings.control)
    return np.array([settings.axis_step_mm(axis, is_diameter=by_diameter and axis == "X") for axis in AXES])


def units_per_mm(settings: Settings, state: State) -> Floats:
    """What a millimetre of X, Y and Z is in the words of the program, (3,)."""
    signs = settings.axis_words.signs
    scale = np.array([float(signs[axis]) for axis in AXES]) / state.mm_per_unit
    if is_diameter(state, settings.control):
        scale[0] *= 2.0
    return scale


def rounding_mm(settings: Settings, state: State) -> float:
    """How far apart two places of an axis can be that are meant to be one [mm of travel]."""
    digit_mm = settings.output.step_mm(is_inch=state.is_inch)
    steps_mm = axis_steps_mm(settings, state)
    scale = units_per_mm(settings, state)
    decimals = settings.output.decimals_of(is_inch=state.is_inch)
    words_mm = 1.0 / (steps_per_unit(steps_mm, scale, decimals) * np.abs(scale))
    # Where a word says every second step it is rounded three times: to those, to digits, to the nearest step.
    is_second = words_mm > 1.5 * steps_mm
    is_second &= words_mm > (1.0 + _SAME) * 10.0**-decimals / np.abs(scale)
    return digit_mm + float((np.where(is_second, 3.0, 1.0) * steps_mm).max())


def steps_per_unit(steps_mm: Floats, scale: Floats, decimals: int) -> Floats:
    """Steps in a unit of each axis word, (3,): those of the axis, or of the last digit where it is larger.

    ``scale`` turns mm of travel into the numbers of words.  Two words that differ never mean one step.
    """
    printed = 10.0**decimals
    step = steps_mm * np.abs(scale)
    with np.errstate(divide="ignore"):
        coarse = np.where(step * printed > 0.5 + _SAME, 1.0 / (2.0 * step), printed)
        return np.where(step * printed > 1.0 - _SAME, 1.0 / step, coarse)


def reached(points_mm: Floats, steps_mm: Floats, origin_mm: Floats) -> Floats:
    """Where the axes really stand for commanded points, (n, 3): on whole steps from ``origin_mm``."""
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = (points_mm - origin_mm) / steps_mm
        # Halves away from zero, as controls round them.
        whole = np.copysign(np.floor(np.abs(steps) + 0.5), steps) * steps_mm + origin_mm
    return np.where(steps_mm > 0.0, whole, points_mm)


def off_halves(printed: Floats, meant: Floats, step: Floats, decimals: int) -> Floats:
    """Words that lie halfway between two steps moved by a digit, (n, 3); all in program units.

    To which of the two an axis goes would be a matter of the last bit.
    """
    digit = 10.0**-decimals
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = printed / step
        is_half = np.abs(steps - np.floor(steps) - 0.5) < _NEAR_HALF
    is_half &= (step * 2.0 > digit * (1.0 + _SAME)) & (step < digit * (1.0 - _SAME))
    return np.where(is_half, printed + np.copysign(digit, meant - printed), printed)


def end_reached(end_mm: Floats, origin_mm: Floats, settings: Settings, state: State) -> Floats:
    """Where the axes stand at the programmed end, (3,), the only place that may be half a step from two.

    Where the control works in single precision, what it loses of the number decides between the two.
    """
    steps_mm = axis_steps_mm(settings, state)
    end = reached(end_mm, steps_mm, origin_mm)
    if origin_mm.any() or not law_of(settings).is_single_precision:
        return end
    scale = units_per_mm(settings, state)
    for axis in np.flatnonzero(steps_mm > 0.0):
        read_mm = _single(round(float(end_mm[axis] * scale[axis]), _READ_DIGITS)) * np.float32(
            1.0 / scale[axis]
        )
        steps = float(read_mm * np.float32(1.0 / steps_mm[axis]))
        end[axis] = np.copysign(np.floor(abs(steps) + 0.5), steps) * steps_mm[axis]
    return end


def _single(word: float) -> np.float32:
    """A number as such a control reads it: its digits as a whole number, and the point by multiplying."""
    sign, digits, exponent = Decimal(repr(word)).normalize().as_tuple()
    value = np.float32(int("".join(map(str, digits))))
    for _ in range(-int(exponent) // 2):
        value *= np.float32(0.01)
    if int(exponent) < 0 and int(exponent) % 2:
        value *= np.float32(0.1)
    if int(exponent) > 0:
        value *= np.float32(10.0 ** int(exponent))
    return np.float32(-value if sign else value)
