"""The thickest chip over many passes, of which most lie behind others."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chipbreak.kinematics import piecewise
from chipbreak.kinematics.piecewise import Motion, highest_minimum


def every_pass(motion: Motion, part: tuple[float, float], passes: int) -> float:
    """The same from the gap to each pass at each place where one can turn."""
    shifts = motion.pass_s * np.arange(passes + 1)
    corners = (motion.time_s + shifts[:, np.newaxis]).ravel()
    inside = corners[(corners > part[0]) & (corners < part[1])]
    places = np.unique(np.concatenate([part, inside]))
    gaps = np.array([motion.at(places) - motion.at(places - shift) for shift in shifts[1:]])
    return highest_minimum(gaps[:, :-1], gaps[:, 1:], -math.inf)


@pytest.mark.parametrize("passes", [24, 25, 60])
@pytest.mark.parametrize("stroke_mm", [0.3, 2.0, 9.0])
def test_as_if_every_pass_were_asked(passes: int, stroke_mm: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where a part is worked out some places at a time."""
    monkeypatch.setattr(piecewise, "_HEIGHTS_AT_ONCE", 1 << 14)
    draw = np.random.default_rng(passes)
    time_s = np.cumsum(draw.uniform(0.02, 0.2, 300))
    swing_mm = stroke_mm * np.sin(time_s * 5.0) * np.linspace(0.0, 1.0, 300) ** 2
    motion = Motion(time_s, 0.8 * time_s + swing_mm + draw.uniform(0.0, 0.02, 300), 0.31, 1e-6)
    for part in ((0.0, float(time_s[-1])), (4.0, 9.0), (float(time_s[250]), float(time_s[-1]) + 1.0)):
        expected = every_pass(motion, part, passes)
        assert motion.peak_thickness(part, passes, -math.inf) == pytest.approx(expected, rel=1e-12)
        assert motion.peak_thickness(part, passes, expected + 1.0) == expected + 1.0
