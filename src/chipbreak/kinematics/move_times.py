"""How long moves take: lengths of lines and arcs, rapids axis by axis, feed per revolution on a diameter.

Points are rows (x, y, z) in mm with X as radius.  Acceleration counts in rapids, where it is known, and not
in feed.
"""

from __future__ import annotations

import math

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.toolpath import PLANE_AXES
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

_FULL_CIRCLE_RAD = 1e-9  # an arc that ends where it begins goes all the way round


def line_lengths_mm(start_mm: Floats, end_mm: Floats) -> Floats:
    """Lengths of straight moves, (n, 3) and (n, 3) -> (n,)."""
    lengths: Floats = np.sqrt(((end_mm - start_mm) ** 2).sum(axis=1))
    return lengths


class Arcs(NamedTuple):
    """Arcs and helices of one ``plane``: ``start_mm`` and ``end_mm`` (n, 3).

    ``turn`` (n,) is -1 for clockwise and 1 for the other way; ``offset_mm`` (n, 3) runs from the start to the
    centre, NaN where a block does not say it; ``radius_mm`` (n,) is R, negative for the longer arc, or NaN.
    ``more_turns`` (n,) are whole turns beside the way to the end.
    """

    start_mm: Floats
    end_mm: Floats
    turn: Floats
    plane: str
    offset_mm: Floats
    radius_mm: Floats
    more_turns: Floats | float = 0.0


def arc_lengths_mm(arcs: Arcs) -> Floats:
    """Their lengths, (n,)."""
    start_mm, end_mm, turn, plane, offset_mm, radius_mm, more_turns = arcs
    one, two = PLANE_AXES[plane]
    along = 3 - one - two
    offset = np.nan_to_num(offset_mm[:, (one, two)])
    out = -offset
    back = end_mm[:, (one, two)] - start_mm[:, (one, two)] - offset
    angle = np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(out[:, 1], out[:, 0])
    sweep = (turn * angle) % (2.0 * math.pi)
    sweep = np.where(sweep < _FULL_CIRCLE_RAD, 2.0 * math.pi, sweep)
    radius = np.hypot(out[:, 0], out[:, 1])
    has_radius = np.isfinite(radius_mm) & np.isnan(offset_mm[:, (one, two)]).all(axis=1)
    chord = np.hypot(*(end_mm - start_mm)[:, (one, two)].T)
    size = np.where(has_radius, np.abs(radius_mm), 1.0)
    half = np.arcsin(np.clip(chord / (2.0 * np.maximum(size, 1e-12)), 0.0, 1.0))
    by_radius = np.where(radius_mm < 0.0, 2.0 * (math.pi - half), 2.0 * half)
    turned = 2.0 * math.pi * np.asarray(more_turns)
    flat = np.where(has_radius, size * (by_radius + turned), radius * (sweep + turned))
    lengths: Floats = np.hypot(flat, end_mm[:, along] - start_mm[:, along])
    return lengths


def rapid_times_s(way_mm: Floats, speed_mm_s: Floats, acceleration_mm_s2: Floats) -> Floats:
    """Times of rapids, ways (n, 3) with the speed and acceleration of each axis (3,) -> (n,).

    The slowest axis says how long; an infinite acceleration costs no time.
    """
    way = np.abs(way_mm)
    ramp_mm = speed_mm_s**2 / acceleration_mm_s2
    reaches = way >= ramp_mm
    with np.errstate(invalid="ignore"):
        long_s = way / speed_mm_s + speed_mm_s / acceleration_mm_s2
        short_s = 2.0 * np.sqrt(way / acceleration_mm_s2)
    times: Floats = np.where(way > 0.0, np.where(reaches, long_s, short_s), 0.0).max(axis=1)
    return times


def surface_turn_s(
    start_radius_mm: Floats, end_radius_mm: Floats, speed_m_min: float, limit_rpm: float
) -> Floats:
    """The mean time of a revolution under constant surface speed, (n,) and (n,) -> (n,).

    The radius changes evenly along each move; below some radius the limit of the spindle holds.
    """
    low = np.minimum(np.abs(start_radius_mm), np.abs(end_radius_mm))
    high = np.maximum(np.abs(start_radius_mm), np.abs(end_radius_mm))
    least_mm = 1000.0 * speed_m_min / (2.0 * math.pi * limit_rpm)
    above = np.maximum(high, least_mm)
    from_mm = np.clip(least_mm, low, high)
    span = np.maximum(high - low, 1e-12)
    mixed = (least_mm * (from_mm - low) + (above**2 - from_mm**2) / 2.0) / span
    mean_mm = np.where(high <= least_mm, least_mm, np.where(high - low < 1e-9, high, mixed))
    turns: Floats = 2.0 * math.pi * mean_mm / (1000.0 * speed_m_min) * S_PER_MIN
    return turns
