"""The way of even ramps as knots, against the way that they are."""

from __future__ import annotations

import numpy as np
import pytest

from chipbreak.trajectory.junction_plan import Moves, Speeds
from chipbreak.trajectory.ramps import ramp_knots

# From rest to 20 mm/s within 2 mm and 0.2 s, on for 6 mm and 0.3 s, down to 10 mm/s within 1.5 mm and 0.1 s;
# then 4 mm at 10 mm/s, and from there to rest within 0.5 mm and 0.1 s.
MOVES = Moves(np.array([9.5, 4.5]), np.full(2, 100.0), np.tile([1.0, 0.0, 0.0], (2, 1)))
SPEEDS = Speeds(np.array([0.0, 100.0]), np.array([400.0, 100.0]), np.array([100.0, 0.0]))
SPANS_S = np.array([0.6, 0.5])


def place_mm(time_s: float) -> float:
    """The same by hand."""
    if time_s <= 0.2:
        return 50.0 * time_s**2
    if time_s <= 0.5:
        return 2.0 + 20.0 * (time_s - 0.2)
    if time_s <= 0.6:
        return 8.0 + 20.0 * (time_s - 0.5) - 50.0 * (time_s - 0.5) ** 2
    if time_s <= 1.0:
        return 9.5 + 10.0 * (time_s - 0.6)
    return 13.5 + 10.0 * (time_s - 1.0) - 50.0 * (time_s - 1.0) ** 2


def test_the_knots_lie_on_the_way_and_close_enough() -> None:
    """Four to a ramp: between them a chord leaves the parabola by a 64th of what the ramp gains."""
    time_s, places_mm = ramp_knots(np.array([0.0, 9.5, 14.0]), MOVES, SPEEDS, SPANS_S)
    assert SPEEDS.times_s(MOVES) == pytest.approx(SPANS_S)
    assert places_mm == pytest.approx([place_mm(at) for at in time_s], abs=1e-9)
    every = np.linspace(0.0, 1.1, 1101)
    off_mm = np.abs(np.interp(every, time_s, places_mm) - [place_mm(at) for at in every])
    assert off_mm.max() <= 2.0 / 64.0 + 1e-9
    assert (time_s[-1], places_mm[-1]) == pytest.approx((1.1, 14.0))


def test_a_move_that_takes_longer_is_stretched_and_a_path_that_is_bent_is_as_long_as_it_is() -> None:
    time_s, places_mm = ramp_knots(np.array([3.0, 12.5, 21.5]), MOVES, SPEEDS, np.array([1.2, 0.5]))
    first = time_s <= 1.2 + 1e-9
    assert places_mm[first] == pytest.approx([3.0 + place_mm(at / 2.0) for at in time_s[first]], abs=1e-9)
    behind = [12.5 + 2.0 * (place_mm(at - 0.6) - 9.5) for at in time_s[~first]]
    assert places_mm[~first] == pytest.approx(behind, abs=1e-9)
