"""Chips rebuilt from where a machine really was: nothing here knows the filter or what it promised.

The tool is followed along the programmed path.  At every angle of the spindle the part keeps the deepest
place that the tool ever was at (full regeneration), and the uncut chip is as thick as the tool lies ahead.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Point = tuple[float, float]  # x as a radius, z; mm
_NOTHING_MM = 1e-9  # what single bits of a tool that stands make of its place
_ANGLES = 1000


@dataclass(frozen=True)
class Leg:
    """A line, or with a ``centre`` the shorter arc about it."""

    start: Point
    end: Point
    centre: Point | None = None

    @property
    def length_mm(self) -> float:
        if self.centre is None:
            return float(np.linalg.norm(np.subtract(self.end, self.start)))
        return abs(self._sweep_rad()) * self._radius_mm()

    def along(self, points: Floats) -> Floats:
        """Distance along the leg of the place nearest to each point, beyond its ends too; (n, 2) -> (n,)."""
        if self.centre is None:
            way = np.subtract(self.end, self.start) / self.length_mm
            found: Floats = (points - self.start) @ way
            return found
        return self._turned_rad(points) * np.sign(self._sweep_rad()) * self._radius_mm()

    def at(self, along_mm: Floats) -> Floats:
        """The points at these distances; (n,) -> (n, 2)."""
        if self.centre is None:
            share = along_mm[:, np.newaxis] / self.length_mm
            line: Floats = np.add(self.start, share * np.subtract(self.end, self.start))
            return line
        spoke = np.subtract(self.start, self.centre)
        angle = np.arctan2(spoke[1], spoke[0]) + np.sign(self._sweep_rad()) * along_mm / self._radius_mm()
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        arc: Floats = np.add(self.centre, self._radius_mm() * circle)
        return arc

    def _radius_mm(self) -> float:
        return float(np.linalg.norm(np.subtract(self.start, self.centre)))

    def _sweep_rad(self) -> float:
        return float(self._turned_rad(np.array([self.end]))[0])

    def _turned_rad(self, points: Floats) -> Floats:
        """By what angle, between -pi and pi, points lie further round the centre than the start."""
        spokes, first = np.subtract(points, self.centre), np.subtract(self.start, self.centre)
        cross = first[0] * spokes[:, 1] - first[1] * spokes[:, 0]
        turned: Floats = np.arctan2(cross, spokes @ first)
        return turned


def follow(legs: tuple[Leg, ...], points: Floats) -> tuple[Floats, Floats]:
    """Distance along the legs and off them [mm] of each point, (n, 2) -> (n,) twice.

    The first leg reaches back before its start and the last one beyond its end.
    """
    best, off, before = np.zeros(len(points)), np.full(len(points), np.inf), 0.0
    for index, leg in enumerate(legs):
        low = -np.inf if index == 0 else 0.0
        high = np.inf if index == len(legs) - 1 else leg.length_mm
        along = np.clip(leg.along(points), low, high)
        away = np.linalg.norm(points - leg.at(along), axis=1)
        best, off = np.where(away < off, before + along, best), np.minimum(away, off)
        before += leg.length_mm
    return best, off


@dataclass(frozen=True)
class Chips:
    """What was cut between two times: ``broken`` counts the places where the tool came out into air."""

    broken: int
    longest_rev: float
    thickest_mm: float


def chips(time_s: Floats, along_mm: Floats, speed_rpm: float, window_s: tuple[float, float]) -> Chips:
    """Turn the whole motion, count in the window.  ``time_s`` starts with the cut, on an untouched face."""
    rev_s = 60.0 / speed_rpm
    turns = int(np.ceil(time_s[-1] / rev_s))
    grid_s = np.arange(turns * _ANGLES) * rev_s / _ANGLES
    tool = np.interp(grid_s, time_s, along_mm).reshape(turns, _ANGLES)
    wall = np.maximum.accumulate(np.vstack([np.full(_ANGLES, along_mm[0]), tool]))[:-1]
    thick = (tool - wall).ravel()[(grid_s >= window_s[0]) & (grid_s < window_s[1])]
    cuts = thick > _NOTHING_MM
    ends = np.flatnonzero(np.diff(np.concatenate(([0], cuts, [0]))))
    lengths = ends[1::2] - ends[::2]
    broken = int((cuts[:-1] & ~cuts[1:]).sum())
    return Chips(broken, float(lengths.max(initial=0)) / _ANGLES, float(thick.max(initial=0.0)))


def stands(time_s: Floats, along_mm: Floats, least_s: float) -> Floats:
    """When the tool comes to stand for so long at least; (n,) of (m,)."""
    moves = np.flatnonzero(np.abs(np.diff(along_mm)) > _NOTHING_MM)
    since, until = time_s[moves[:-1] + 1], time_s[moves[1:]]
    return np.asarray(since[until - since >= least_s])


@dataclass(frozen=True)
class Vibration:
    """How a motion swings between two times: turns from forward to back, their mean rate, and the stroke.

    ``strokes_mm`` is the stroke about the mean feed of each vibration; ``forward_share`` their mean.
    """

    turns: int
    frequency_hz: float
    strokes_mm: Floats
    forward_share: float


def vibration(time_s: Floats, along_mm: Floats, window_s: tuple[float, float]) -> Vibration:
    """Measure the vibrations whose crests lie in the window."""
    rests = np.append(True, np.diff(along_mm) != 0.0)  # where it stands still it does not turn twice
    moment, place = time_s[rests], along_mm[rests]
    way = np.sign(np.diff(place))
    crest = np.flatnonzero((way[:-1] > 0) & (way[1:] < 0)) + 1
    trough = np.flatnonzero((way[:-1] < 0) & (way[1:] > 0)) + 1
    crest = crest[(moment[crest] >= window_s[0]) & (moment[crest] <= window_s[1])]
    if len(crest) < 3:
        return Vibration(len(crest), 0.0, np.zeros(1), 0.0)
    first, last = crest[0], crest[-1]
    speed = (place[last] - place[first]) / (moment[last] - moment[first])
    ahead = place - speed * moment
    strokes = np.array([np.ptp(ahead[a : b + 1]) for a, b in pairwise(crest)])
    trough = trough[(trough > first) & (trough < last)]
    back_s = float((moment[trough] - moment[crest[:-1]]).sum()) if len(trough) == len(crest) - 1 else np.nan
    whole_s = float(moment[last] - moment[first])
    return Vibration(len(crest), (len(crest) - 1) / whole_s, strokes, 1.0 - back_s / whole_s)
