"""How long blocks from rest to rest take on LinuxCNC, without going through their periods."""

from __future__ import annotations

import math
import tracemalloc

import numpy as np
import pytest

from chipbreak.trajectory.linuxcnc import LinuxCnc
from chipbreak.trajectory.linuxcnc_planner import Clock
from chipbreak.trajectory.linuxcnc_runs import Columns, parts_of, run_all, single_times

PERIOD_S = 0.001


def law(**numbers: float) -> LinuxCnc:
    """LinuxCNC with axes of 100 mm/s and 2 m/s2."""
    return LinuxCnc(velocity_mm_s=100.0, acceleration_mm_s2=2000.0, servo_period_s=PERIOD_S, **numbers)  # type: ignore[arg-type]


def test_as_where_every_period_is_gone_through() -> None:
    """Short and long ones, at feeds that are reached and not, above what the axes have and below."""
    draw = np.random.default_rng(5)
    count = 500
    columns = Columns(
        10.0 ** draw.uniform(-4.0, 2.0, count),
        10.0 ** draw.uniform(-1.0, 2.5, count),
        np.full(count, 100.0),
        10.0 ** draw.uniform(1.0, 4.0, count),
    )
    clock = Clock(PERIOD_S, 0.01, 1.0, 0.0)
    every = run_all(columns, parts_of(np.zeros(count - 1, np.bool_)), clock)
    assert np.array_equal(single_times(columns, clock), every.times)


def test_a_block_of_a_day() -> None:
    """The trapezoid's time, rounded up and at most a period more; its 86 million periods take no memory."""
    speed_mm_s = 0.5
    length_mm = 86_400.0 * speed_mm_s
    tracemalloc.start()
    took_s = float(law().block_times([length_mm], [speed_mm_s])[0])
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    trapezoid_s = length_mm / speed_mm_s + speed_mm_s / 2000.0
    assert trapezoid_s <= took_s + 1e-6
    assert took_s <= trapezoid_s + 2.0 * PERIOD_S
    assert most_bytes < 1_000_000


@pytest.mark.parametrize(("read_s", "wanted_s"), [(0.0, 0.002), (0.25, 0.25)])
def test_no_block_is_shorter_than_it_is_read(read_s: float, wanted_s: float) -> None:
    """0.002 mm at 2 m/s2 takes two periods: a T in the first, and none left behind the second."""
    blocks_per_s = math.inf if read_s == 0.0 else 1.0 / read_s
    numbers = {} if math.isinf(blocks_per_s) else {"blocks_per_s": blocks_per_s}
    took = law(**numbers).block_times([0.002, -0.002], [100.0, 100.0])
    assert took.tolist() == pytest.approx([wanted_s, wanted_s])
