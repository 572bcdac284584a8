"""The motion that the machine really makes of a commanded one: each axis behind its own filter.

Where all axes that move have the same filter and the path is straight, that is the filter of the distance.
Elsewhere each axis is filtered on its own, and what comes out is seen along the path, at the place where the
tool then is; how far it leaves the path is told too.  Between two knots of the command the tool is taken to
move evenly in each axis, which on arcs it does but for the chord of a block.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from chipbreak.kinematics.cells import cells_of
from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.filters import (
    NO_FILTER,
    STILL_MM,
    AxisFilter,
    filtered,
    filtered_together,
    times_to_look_at,
)
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.motion import Motion

_PIECES = 32  # of a stroke: a parabola in so many chords is off by a thousandth of its height
_MOST_TIMES = 3_200_000  # at even steps
_MOST_SOON = 1_600_000  # after sharp bends
_STRAIGHT_MM = 0.002  # off a line by no more than rounding
_STILL_MM = 1e-12
_LOOKS = 2  # along the path, each from the place that the last one found


def followed(motion: Motion, distance_mm: Floats, blocks: Blocks, filters: Sequence[AxisFilter]) -> Motion:
    """What axes with these filters, one a coordinate of a point, make of a commanded motion.

    ``distance_mm`` (n + 1,) is where along the path each of the blocks ends.
    """
    ways_mm = np.abs(blocks.moved_mm).max(axis=0, initial=0.0)
    moving = [axis for axis, way_mm in enumerate(ways_mm[: len(filters)]) if way_mm > _STILL_MM]
    own = [filters[axis] for axis in moving]
    if all(one == NO_FILTER for one in own):
        return motion
    step_s = _step_s(motion, own)
    at_s = times_to_look_at(motion.time_s, motion.distance_mm, own, step_s, _MOST_SOON)
    points_mm = np.concatenate([np.zeros((1, 3)), np.cumsum(blocks.moved_mm, axis=0)])
    if _is_straight(points_mm):
        along_mm, off_mm = _on_a_line(motion, points_mm, moving, own, at_s)
    else:
        path = _Polyline(distance_mm, points_mm[:, moving])
        along_mm, off_mm = _on_a_bent_path(motion, path, own, at_s)
    along_mm[-1] = motion.distance_mm[-1]
    if (np.diff(motion.distance_mm) >= 0.0).all():
        along_mm = _resting(motion, at_s, along_mm)
    return motion._replace(
        time_s=at_s,
        distance_mm=along_mm,
        delay_s=max(one.delay_s for one in own),
        settling_s=max(one.settling_s for one in own),
        path_error_mm=off_mm,
        look_s=step_s,
    )


def _resting(motion: Motion, at_s: Floats, along_mm: Floats) -> Floats:
    """The motion of a tool that only goes on: near enough to where it is told to rest, it rests there."""
    cell = np.clip(np.searchsorted(motion.time_s, at_s, "right") - 1, 0, len(motion.time_s) - 2)
    rests = np.diff(motion.distance_mm)[cell] <= _STILL_MM
    there_mm = motion.distance_mm[cell]
    resting: Floats = np.where(rests & (np.abs(along_mm - there_mm) <= STILL_MM), there_mm, along_mm)
    return resting


def _step_s(motion: Motion, filters: Sequence[AxisFilter]) -> float:
    """How dense the times must lie: so many pieces a stroke, within what memory holds."""
    ways = np.diff(motion.distance_mm)
    moving = np.flatnonzero(np.abs(ways) > _STILL_MM)
    turns = moving[np.flatnonzero(np.diff(np.sign(ways[moving]))) + 1]
    slowest_s = max(max((*one.averages_s, *one.lags_s), default=0.0) for one in filters)
    stroke_s = float(np.median(np.diff(motion.time_s[turns]))) if len(turns) > 2 else 8.0 * slowest_s
    whole_s = float(motion.time_s[-1])
    return max(stroke_s / _PIECES, whole_s / _MOST_TIMES)


def _is_straight(points_mm: Floats) -> bool:
    """True where no point lies further from the line through the first and the furthest than rounding."""
    from_start = points_mm - points_mm[0]
    sizes = np.einsum("ij,ij->i", from_start, from_start)
    furthest = from_start[int(sizes.argmax())]
    way = furthest / np.sqrt(max(float(sizes.max()), _STILL_MM**2))
    across = from_start - np.outer(from_start @ way, way)
    return bool(np.abs(across).max() <= _STRAIGHT_MM)


def _on_a_line(
    motion: Motion, points_mm: Floats, moving: Sequence[int], filters: Sequence[AxisFilter], at_s: Floats
) -> tuple[Floats, float]:
    """Where the tool is along a line, and how far beside it at most: each axis takes its share of the way."""
    places = {one: filtered(motion.time_s, motion.distance_mm, one, at_s) for one in dict.fromkeys(filters)}
    if len(places) == 1:
        return places[filters[0]], 0.0
    way = points_mm[int(np.abs(points_mm).max(axis=1).argmax())][list(moving)]
    shares = (way / np.sqrt(way @ way)) ** 2
    along = sum(share * places[one] for share, one in zip(shares.tolist(), filters, strict=True))
    assert isinstance(along, np.ndarray)
    off = sum(share * (places[one] - along) ** 2 for share, one in zip(shares.tolist(), filters, strict=True))
    return along, float(np.sqrt(np.max(off)))


def _on_a_bent_path(
    motion: Motion, path: _Polyline, filters: Sequence[AxisFilter], at_s: Floats
) -> tuple[Floats, float]:
    """Where the tool is along arcs and corners, and how far off the path at most."""
    commanded = [*path.at(motion.distance_mm).points_mm, motion.distance_mm]
    along_mm = np.empty(len(at_s))
    furthest = 0.0
    kinds = list(dict.fromkeys(filters))
    # A long cut has millions of times: all axes are worked out for some of them at once.
    pieces = (filtered_together(motion.time_s, commanded, one, at_s) for one in kinds)
    for together in zip(*pieces, strict=True):
        of_kind = {one: places for one, (_, places) in zip(kinds, together, strict=True)}
        real = [of_kind[one][row] for row, one in enumerate(filters)]
        # A first guess, on the path, then what is left seen along the path there.
        guess = np.mean([places[-1] for places in of_kind.values()], axis=0)
        spot = path.at(path.within(guess))
        for _ in range(_LOOKS):
            ahead = sum(
                way * (one - on) for way, one, on in zip(spot.ways, real, spot.points_mm, strict=True)
            )
            spot = path.at(path.within(spot.along_mm + ahead))
        off = sum((one - on) ** 2 for one, on in zip(real, spot.points_mm, strict=True))
        furthest = max(furthest, float(np.max(off)))
        along_mm[together[0][0]] = spot.along_mm
    return along_mm, math.sqrt(furthest)


class _Spot(NamedTuple):
    """Places along a path, (n,), the points there and the directions, a column an axis, (n,) each."""

    along_mm: Floats
    points_mm: list[Floats]
    ways: list[Floats]


class _Polyline:
    """The path of some blocks, as far as they say it: places along it, (k,), and points there, (k, axes)."""

    def __init__(self, distance_mm: Floats, points_mm: Floats) -> None:
        self.places_mm, first = np.unique(distance_mm, return_index=True)
        corners_mm = points_mm[first]
        self.columns_mm = [np.ascontiguousarray(column) for column in corners_mm.T]
        steps_mm = np.diff(self.places_mm)
        self.slopes = [np.diff(column) / steps_mm for column in self.columns_mm]
        ways = np.diff(corners_mm, axis=0)
        sizes = np.sqrt(np.einsum("ij,ij->i", ways, ways))
        # Two places may be rounded to one point, from which no way leads.
        sizes[sizes <= 0.0] = 1.0
        self.ways = [np.ascontiguousarray(column) / sizes for column in ways.T]

    def at(self, along_mm: Floats) -> _Spot:
        """What is at places that the path has, (n,)."""
        cell = cells_of(self.places_mm, along_mm)
        since_mm = along_mm - self.places_mm[cell]
        is_end = along_mm >= self.places_mm[-1]
        points_mm = []
        for column, slope in zip(self.columns_mm, self.slopes, strict=True):
            points_mm.append(slope[cell] * since_mm + column[cell])
            points_mm[-1][is_end] = column[-1]
        return _Spot(along_mm, points_mm, [way[cell] for way in self.ways])

    def within(self, along_mm: Floats) -> Floats:
        """Places that the path has."""
        return np.clip(along_mm, self.places_mm[0], self.places_mm[-1])
