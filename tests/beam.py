"""A laser barrier, as a profile names it: without one nothing is checked."""

from __future__ import annotations

VALUES = {
    "beam_x_mm": 120,
    "beam_y_mm": -35,
    "beam_z_mm": -400,
    "safe_z_mm": 0,
    "master_length_mm": 150,
    "master_diameter_mm": 20,
    "master_tool": 90,
}
OPTIONS = tuple(f"--set=macros.{key}={value}" for key, value in VALUES.items())
BEAM = tuple(f"macros.{key}={value}" for key, value in VALUES.items())
