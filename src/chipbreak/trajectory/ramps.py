"""The way of a tool that speeds up and brakes evenly, as knots between which it moves evenly."""

from __future__ import annotations

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.trajectory.junction_plan import Moves, Speeds

_PIECES = 4  # of each ramp: the way is off by a 64th of what the ramp gains at most
_MOST_KNOTS = 4_000_000
_SAME_S = 1e-12


def ramp_knots(distance_mm: Floats, moves: Moves, speeds: Speeds, spans_s: Floats) -> tuple[Floats, Floats]:
    """Time [s] and place [mm] of the knots of moves between places along the path, (n + 1,) -> (m,) each.

    ``spans_s`` (n,) is how long each move takes; where that is longer than its ramps say, it is stretched.
    """
    times, ways = _within_moves(moves, speeds)
    begins_s = np.append(0.0, np.cumsum(spans_s))
    with np.errstate(divide="ignore", invalid="ignore"):
        times *= np.nan_to_num(spans_s / times[:, -1], nan=0.0, posinf=0.0)[:, np.newaxis]
    times += begins_s[:-1, np.newaxis]
    ways *= (np.diff(distance_mm) / moves.lengths_mm)[:, np.newaxis]
    ways += distance_mm[:-1, np.newaxis]
    time_s = np.append(0.0, times.ravel())
    places_mm = np.append(distance_mm[0], ways.ravel())
    # A ramp of no length leaves knots in one place.
    kept = np.append(np.diff(time_s) > _SAME_S, True)
    kept[0] = True
    return time_s[kept], places_mm[kept]


def _within_moves(moves: Moves, speeds: Speeds) -> tuple[Floats, Floats]:
    """Time and way of the knots of each move since it began, (n, k) each; its end is the last one."""
    start, peak, end = map(np.sqrt, speeds)
    has = moves.accelerations_mm_s2
    pieces = max(1, min(_PIECES, _MOST_KNOTS // (2 * len(moves))))
    steps = np.arange(1, pieces + 1) / pieces
    up_s = np.outer((peak - start) / has, steps)
    up_mm = start[:, np.newaxis] * up_s + has[:, np.newaxis] * up_s**2 / 2.0
    down_s = np.outer((peak - end) / has, steps)
    down_mm = peak[:, np.newaxis] * down_s - has[:, np.newaxis] * down_s**2 / 2.0
    even_mm = np.maximum(moves.lengths_mm - up_mm[:, -1] - down_mm[:, -1], 0.0)
    even_s = even_mm / np.maximum(peak, _SAME_S)
    flat_s = up_s[:, -1:] + even_s[:, np.newaxis]
    flat_mm = up_mm[:, -1:] + even_mm[:, np.newaxis]
    times = np.hstack([up_s, flat_s, flat_s + down_s])
    ways = np.hstack([up_mm, flat_mm, flat_mm + down_mm])
    ways[:, -1] = moves.lengths_mm
    return times, ways
