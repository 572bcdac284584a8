"""The steps in which the axes move: positions that lie between two of them cannot be reached."""

from __future__ import annotations

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.model.modal import State
from chipbreak.model.words import is_diameter
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings


def axis_steps_mm(settings: Settings, state: State) -> Floats:
    """The step of each axis [mm of travel], (3,); 0 where nobody said it."""
    by_diameter = is_diameter(state, settings.control)
    return np.array([settings.axis_step_mm(axis, is_diameter=by_diameter and axis == "X") for axis in AXES])


def steps_per_unit(steps_mm: Floats, scale: Floats, decimals: int) -> Floats:
    """Steps in a unit of each axis word, (3,): those of the axis, or of the last digit where it is larger.

    ``scale`` turns mm of travel into the numbers of words.  Two words that differ never mean one step.
    """
    printed = 10.0**decimals
    step = steps_mm * np.abs(scale)
    with np.errstate(divide="ignore"):
        coarse = np.where(step * printed > 0.5 + 1e-9, 1.0 / (2.0 * step), printed)
        return np.where(step * printed > 1.0 - 1e-9, 1.0 / step, coarse)


def reached(points_mm: Floats, steps_mm: Floats, origin_mm: Floats) -> Floats:
    """Where the axes really stand for commanded points, (n, 3): on whole steps from ``origin_mm``."""
    with np.errstate(divide="ignore", invalid="ignore"):
        steps = (points_mm - origin_mm) / steps_mm
        # Halves away from zero, as controls round them.
        whole = np.copysign(np.floor(np.abs(steps) + 0.5), steps) * steps_mm + origin_mm
    return np.where(steps_mm > 0.0, whole, points_mm)
