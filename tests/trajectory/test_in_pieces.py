"""What is worked out in pieces, so that a long cut needs little memory, is what comes of it at once."""

from __future__ import annotations

import math

import numpy as np
import pytest

from chipbreak.kinematics import chip_model
from chipbreak.kinematics.cells import cells_of
from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory import filters, linuxcnc_runs, resting
from chipbreak.trajectory.filters import AxisFilter, filtered, times_to_look_at
from chipbreak.trajectory.junctions import blocks_of
from chipbreak.trajectory.motion import Motion
from chipbreak.trajectory.real_motion import followed
from chipbreak.trajectory.trapezoid import Trapezoid

LAGGED = AxisFilter((0.016,), (0.02,))
TWICE = AxisFilter((0.012, 0.005), (0.008, 0.003))
NONE_BUT_LAG = AxisFilter((), (0.02,))
AXES = [LAGGED, TWICE, NONE_BUT_LAG]
SMALL = 64


def vibrated(count: int = 300) -> tuple[Floats, Floats]:
    """The knots of a vibration, forward and back, and no two strokes alike."""
    draw = np.random.default_rng(3)
    time_s = np.append(0.0, np.cumsum(draw.uniform(0.015, 0.03, count)))
    steps_mm = np.where(np.arange(count) % 2, -0.05, 0.07) + draw.uniform(-0.01, 0.01, count)
    return time_s, np.append(0.0, np.cumsum(steps_mm))


def in_small_pieces(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(filters, "_TIMES_AT_ONCE", SMALL)
    patch.setattr(filters, "_KNOTS_AT_ONCE", 7)
    patch.setattr(resting, "_PARTS_AT_ONCE", 5)


@pytest.mark.parametrize("most", [math.inf, 2000])
@pytest.mark.parametrize("axes", [AXES[:1], AXES[1:2], AXES], ids=["one", "two averages", "all"])
def test_times_to_look_at_do_not_depend_on_the_pieces(
    axes: list[AxisFilter], most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    time_s, place_mm = vibrated()
    whole = times_to_look_at(time_s, place_mm, axes, 0.004, most)
    in_small_pieces(monkeypatch)
    assert times_to_look_at(time_s, place_mm, axes, 0.004, most).tolist() == whole.tolist()
    steps = np.diff(whole)
    assert steps.min() > 0.0
    assert steps.max() <= 0.004 * (1.0 + 1e-5)
    assert whole[0] == 0.0
    assert whole[-1] == time_s[-1] + max(axis.rest_s for axis in axes)
    knots = whole[np.searchsorted(whole, time_s - 2e-9)]
    assert np.abs(knots - time_s).max() <= 2e-9


@pytest.mark.parametrize("axis", AXES, ids=["one average", "two averages", "a lag"])
def test_a_filter_carries_over_what_it_is_behind(axis: AxisFilter, monkeypatch: pytest.MonkeyPatch) -> None:
    time_s, place_mm = vibrated(100)
    at_s = times_to_look_at(time_s, place_mm, [axis], 0.004)
    whole = filtered(time_s, place_mm, axis, at_s)
    in_small_pieces(monkeypatch)
    assert len(at_s) > 5 * SMALL
    assert np.abs(filtered(time_s, place_mm, axis, at_s) - whole).max() < 1e-12


@pytest.mark.parametrize("axes", [[LAGGED, LAGGED], [LAGGED, TWICE]], ids=["alike", "unlike"])
def test_a_bent_path_is_followed_piece_by_piece(
    axes: list[AxisFilter], monkeypatch: pytest.MonkeyPatch
) -> None:
    time_s, along_mm = vibrated(60)
    turn = along_mm / 5.0
    points_mm = 5.0 * np.stack([np.sin(turn), 1.0 - np.cos(turn), np.zeros(len(turn))], axis=1)
    blocks = blocks_of(np.diff(points_mm, axis=0), np.diff(along_mm), [1000.0, 1000.0])
    command = Motion(np.diff(time_s), time_s, along_mm)
    whole = followed(command, along_mm, blocks, axes)
    in_small_pieces(monkeypatch)
    pieces = followed(command, along_mm, blocks, axes)
    assert pieces.time_s.tolist() == whole.time_s.tolist()
    assert np.abs(pieces.distance_mm - whole.distance_mm).max() < 1e-12
    assert pieces.path_error_mm == pytest.approx(whole.path_error_mm, rel=1e-9)
    assert 0.0 < whole.path_error_mm < 0.05
    # It is late, and comes to where the command ends.
    late_mm = along_mm[20:40] - np.interp(time_s[20:40], whole.time_s, whole.distance_mm)
    assert late_mm.mean() > 0.0
    assert whole.distance_mm[-1] == along_mm[-1]


def test_cells_are_those_of_all_knots() -> None:
    draw = np.random.default_rng(5)
    knots = np.unique(draw.integers(0, 90, 60)).astype(np.float64)
    for low, high in ((-5.0, 3.0), (10.0, 20.0), (40.0, 40.5), (85.0, 99.0), (-9.0, 99.0)):
        values = np.append(draw.uniform(low, high, 50), knots[(knots >= low) & (knots <= high)])
        expected = [min(max(sum(knots <= value) - 1, 0), len(knots) - 2) for value in values]
        assert cells_of(knots, values).tolist() == expected


@pytest.mark.parametrize("stops", [False, True])
def test_strokes_alone_take_the_time_that_each_of_them_takes(
    stops: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Among them are some of two and three blocks."""
    in_small_pieces(monkeypatch)
    draw = np.random.default_rng(7)
    ways_mm = draw.uniform(0.05, 0.1, 40) * np.where(np.arange(40) % 2, -1.0, 1.0)
    ways_mm[11:13] = 0.03
    ways_mm[20:23] = -0.04
    moved_mm = np.stack([np.zeros(40), np.zeros(40), ways_mm], axis=1)
    law = Trapezoid(acceleration_mm_s2=900.0, reversal_stop_s=0.001, every_block_stops=stops)
    feeds_mm_s = draw.uniform(2.0, 9.0, 40)
    blocks = blocks_of(moved_mm, ways_mm, [np.inf, np.inf, 900.0])
    motion = law.motion_between_dwells(np.append(0.0, np.cumsum(ways_mm)), blocks, feeds_mm_s)
    assert motion.spans_s.tolist() == law.block_times(blocks.lengths_mm, feeds_mm_s).tolist()


@pytest.mark.parametrize("width", [1, 3, 40])
def test_kinds_of_rows_are_those_of_their_digits(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    draw = np.random.default_rng(9)
    rows = draw.choice([0.1, 0.2, 0.3], (60, width))
    rows[:20] = rows[20:40]
    rows[5, -1] = np.nextafter(rows[5, -1], 1.0)
    first, kind = linuxcnc_runs.kinds_of(rows)
    seen = list(map(tuple, rows.tolist()))
    assert [seen[first[one]] for one in kind] == seen
    assert sorted(first.tolist()) == sorted({seen.index(row) for row in seen})
    # Where all rows have the same number they are told apart by themselves, and come in the same order.
    monkeypatch.setattr(linuxcnc_runs, "_FACTOR", 0)
    again = linuxcnc_runs.kinds_of(rows)
    assert [column.tolist() for column in again] == [first.tolist(), kind.tolist()]


def test_the_least_of_each_cell_is_that_of_all_its_values() -> None:
    """Cells without a value keep what they had; values come in pieces, and a cell may go on in the next."""
    draw = np.random.default_rng(11)
    between = np.sort(draw.uniform(0.0, 9.0, 30))
    between[7] = between[8]
    at = np.sort(np.append(draw.uniform(0.0, 9.0, 100), between[12]))
    at = at[(at < 3.0) | (at > 4.0)]
    values = draw.uniform(0.0, 1.0, len(at))
    least = np.full(31, 2.0)
    for piece in np.array_split(np.arange(len(at)), 7):
        chip_model._lower(least, between, at[piece], values[piece])
    chip_model._lower(least, between, at[:0], values[:0])
    cell = np.array([(between <= place).sum() for place in at])
    assert least.tolist() == [values[cell == one].min(initial=2.0) for one in range(31)]
