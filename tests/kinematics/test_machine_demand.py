"""What a vibration asks of the machine, against numbers worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chipbreak.kinematics.machine_demand import flank_clearance_deg
from chipbreak.kinematics.piecewise import mean_step_s


def test_the_flank_clearance_is_that_of_the_edge_per_second() -> None:
    """9.63 mm/s ahead while 20 mm at 2500 rpm go round with 2618 mm/s."""
    assert flank_clearance_deg(9.63, 20.0, 2500.0) == pytest.approx(math.degrees(9.63 / 2618.0), rel=1e-3)


def test_a_swallowed_vibration_counts_as_two_steps_and_a_wrinkle_as_none() -> None:
    assert mean_step_s(np.array([0.0, 1.0, 2.0, 4.0, 5.0])) == pytest.approx(1.0)
    assert mean_step_s(np.array([0.0, 1.0, 1.001, 2.0, 3.0])) == pytest.approx(1.0)
