"""How a vibrated cut would have run as it was written."""

from __future__ import annotations

import math

import numpy as np

from chipbreak.kinematics.move_times import surface_turn_s
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.plan import CutPlan


class Programmed(NamedTuple):
    """How a cut would have run as it was written: spindle speed, and how long, None where nobody knows."""

    speed_rpm: float
    duration_s: float | None


def programmed(plan: CutPlan) -> Programmed | None:
    """The cut without vibration; None where its spindle speed is not known."""
    given = plan.given.get("S")
    state = plan.chain.before
    if given is not None:
        speed_rpm = given.value
    elif state.speed is not None and state.modes.speed_mode == "rpm":
        speed_rpm = state.speed.value
    else:
        return None
    if not speed_rpm > 0.0:
        return None
    feed = state.feed
    if feed is None or not feed.value > 0.0:
        return Programmed(speed_rpm, None)
    if state.modes.feed_mode == "rev" and state.modes.speed_mode == "surface" and state.speed is not None:
        return Programmed(speed_rpm, _under_surface_speed_s(plan, feed.value, state.speed.value))
    per_minute = feed.value * (speed_rpm if state.modes.feed_mode == "rev" else 1.0)
    return Programmed(speed_rpm, plan.path.length_mm / per_minute * S_PER_MIN)


def _under_surface_speed_s(plan: CutPlan, feed_mm_rev: float, speed_m_min: float) -> float | None:
    """The time of the cut while the spindle follows its diameter; None without a speed."""
    if not speed_m_min > 0.0:
        return None
    limit = plan.chain.before.speed_limit
    limit_rpm = limit.value if limit is not None and limit.value > 0.0 else math.inf
    legs = plan.path.legs
    radii = (np.array([leg.start[0] for leg in legs]), np.array([leg.end[0] for leg in legs]))
    turns = np.diff(plan.path.ends_mm) / feed_mm_rev
    return float((turns * surface_turn_s(*radii, speed_m_min, limit_rpm)).sum())
