"""The names of the laws of control, and the keys of ``[planner]`` that only some of them read.

A profile is checked without the laws themselves, which need much more.
"""

from __future__ import annotations

from typing import Final

# In the order of ``laws.LAWS``; the first is what profiles have that say nothing.
LAW_KEYS: Final = {
    "ideal": (),
    "trapezoid": ("reversal_stop_ms",),
    "after-interpolation": (),
    "look-ahead": ("joint_speed_mm_min",),
    "junction": (
        "junction_deviation_mm",
        "corner_velocity_mm_s",
        "min_cruise_ratio",
        "path_velocity_mm_min",
        "path_acceleration_mm_s2",
        "look_ahead_blocks",
        "least_steps_per_s",
        "least_feed_mm_min",
        "segment_ms",
    ),
    "linuxcnc": ("max_feed_override",),
}


def foreign_keys(name: str) -> dict[str, list[str]]:
    """Keys of ``[planner]`` that mean nothing to this law, with the laws to which they mean something."""
    own = LAW_KEYS[name]
    found: dict[str, list[str]] = {}
    for law, keys in LAW_KEYS.items():
        for key in keys:
            if key not in own:
                found.setdefault(key, []).append(law)
    return found
