"""How a vibrated cut would have run as it was written."""

from __future__ import annotations

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
    per_minute = feed.value * (speed_rpm if state.modes.feed_mode == "rev" else 1.0)
    return Programmed(speed_rpm, plan.path.length_mm / per_minute * S_PER_MIN)
