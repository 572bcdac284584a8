"""A machine stepped through time: what it makes of printed blocks, found without the package's own filters.

Every quantity is stepped with a fixed small step.  The command is a position that goes on at the speed of
the block of that moment; a moving average is a queue of past positions; a lag is integrated by the classical
Runge-Kutta rule.  The chips are judged on the same steps: how far the tool is ahead of where it was one
revolution (or pass of an edge) before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Machine:
    """Linear or bell acc/dec times, times of lags in a row, and for look-ahead the joint speed and ramps."""

    averages_s: tuple[float, ...]
    lags_s: tuple[float, ...]
    joint_mm_s: float | None = None
    ramp_mm_s2: float = 0.0


@dataclass(frozen=True)
class Seen:
    """What the machine did: margin of the weakest vibration, stroke, and N where it turns back (else 0)."""

    margin: float
    stroke_mm: float
    per_rev: float


def commanded(
    lengths_mm: Floats, feeds_mm_s: Floats, machine: Machine, step_s: float
) -> tuple[Floats, float]:
    """The position after each step, and the time of all blocks."""
    if machine.joint_mm_s is None:
        return _at_even_feeds(lengths_mm, feeds_mm_s, step_s)
    return _with_ramps(lengths_mm, feeds_mm_s, machine, step_s)


def _at_even_feeds(lengths_mm: Floats, feeds_mm_s: Floats, step_s: float) -> tuple[Floats, float]:
    ends_s = np.cumsum(np.abs(lengths_mm) / feeds_mm_s)
    places = np.concatenate([[0.0], np.cumsum(lengths_mm)])
    steps = np.arange(int(ends_s[-1] / step_s) + 2) * step_s
    block = np.minimum(np.searchsorted(ends_s, steps, "right"), len(ends_s) - 1)
    left_s = np.maximum(ends_s[block] - steps, 0.0)
    return places[block + 1] - np.sign(lengths_mm[block]) * feeds_mm_s[block] * left_s, float(ends_s[-1])


def _with_ramps(
    lengths_mm: Floats, feeds_mm_s: Floats, machine: Machine, step_s: float
) -> tuple[Floats, float]:
    """Each block by its own: from joint speed up to the feed and down to the next joint speed."""
    assert machine.joint_mm_s is not None
    has = machine.ramp_mm_s2
    tops = np.minimum(feeds_mm_s[:-1], feeds_mm_s[1:])
    turns = lengths_mm[:-1] * lengths_mm[1:] < 0.0
    joints = [0.0, *np.where(turns, np.minimum(tops, machine.joint_mm_s / 2.0), tops).tolist(), 0.0]
    for at in range(len(lengths_mm) - 1, -1, -1):
        joints[at] = min(joints[at], np.sqrt(joints[at + 1] ** 2 + 2.0 * has * abs(lengths_mm[at])))
    for at in range(len(lengths_mm)):
        joints[at + 1] = min(joints[at + 1], np.sqrt(joints[at] ** 2 + 2.0 * has * abs(lengths_mm[at])))
    knots_s, knots_mm = [0.0], [0.0]
    for at, (length, feed) in enumerate(zip(lengths_mm.tolist(), feeds_mm_s.tolist(), strict=True)):
        begin, end = joints[at], joints[at + 1]
        top = min(feed, np.sqrt((begin**2 + end**2) / 2.0 + has * abs(length)))
        parts = [(begin, top), (top, end)]
        ramps_mm = sum(abs(b * b - a * a) / (2.0 * has) for a, b in parts)
        even_s = max(abs(length) - ramps_mm, 0.0) / top
        now_s, now_mm, way = knots_s[-1], knots_mm[-1], np.sign(length)
        for share in np.linspace(0.0, 1.0, 40)[1:]:  # up
            gone_s = (top - begin) / has * share
            knots_s.append(now_s + gone_s)
            knots_mm.append(now_mm + way * (begin * gone_s + has * gone_s**2 / 2.0))
        now_s, now_mm = knots_s[-1] + even_s, knots_mm[-1] + way * top * even_s
        knots_s.append(now_s)
        knots_mm.append(now_mm)
        for share in np.linspace(0.0, 1.0, 40)[1:]:  # down
            gone_s = (top - end) / has * share
            knots_s.append(now_s + gone_s)
            knots_mm.append(now_mm + way * (top * gone_s - has * gone_s**2 / 2.0))
    steps = np.arange(int(knots_s[-1] / step_s) + 2) * step_s
    return np.interp(steps, knots_s, knots_mm), knots_s[-1]


def behind_filters(place_mm: Floats, machine: Machine, step_s: float) -> Floats:
    """The positions behind queues and lags; the machine rests before the first step."""
    found = place_mm
    for average_s in machine.averages_s:
        whole, part = divmod(average_s / step_s, 1.0)
        weights = np.ones(int(whole) + 2)
        weights[[0, -1]] = 0.5  # the queue as a trapezoid
        weights[-1] = part / 2.0
        weights[-2] = (1.0 + part) / 2.0
        padded = np.concatenate([np.full(len(weights) - 1, found[0]), found])
        found = np.convolve(padded, weights / weights.sum(), "valid")
    for lag_s in machine.lags_s:
        found = _stepped(found, lag_s, step_s)
    return found


def _stepped(command_mm: Floats, lag_s: float, step_s: float) -> Floats:
    """y' = (x - y) / T by the classical rule of Runge and Kutta, x straight within a step."""
    out = command_mm.copy()
    y = float(command_mm[0])
    x = command_mm.tolist()
    h = step_s / lag_s
    for at in range(1, len(x)):
        begin, middle, end = x[at - 1], (x[at - 1] + x[at]) / 2.0, x[at]
        one = begin - y
        two = middle - (y + h / 2.0 * one)
        three = middle - (y + h / 2.0 * two)
        four = end - (y + h * three)
        y += h / 6.0 * (one + 2.0 * two + 2.0 * three + four)
        out[at] = y
    return out


def seen(
    place_mm: Floats, step_s: float, pass_s: float, period_s: float, steady_s: tuple[float, float]
) -> Seen:
    """Judge the vibrations that lie whole in the steady part."""
    first, last = (int(np.ceil(one / step_s)) for one in steady_s)
    late = pass_s / step_s
    # Behind one pass every pass of the steady part meets one of the steady part.
    at = np.arange(first + int(np.ceil(late)), last)
    gap = place_mm[at] - np.interp(at - late, np.arange(len(place_mm)), place_mm)
    goes = np.diff(place_mm[first : last + 1]) > 0.0
    turns = first + 1 + np.flatnonzero(goes[:-1] & ~goes[1:])
    per_period = period_s / step_s
    ends = (last - int(len(at) / per_period) * per_period, last)
    per_rev = 0.0
    if len(turns) > 1:
        per_period = (turns[-1] - turns[0]) / (len(turns) - 1)
        ends = (turns[0], turns[-1])
        per_rev = late / per_period
    begin_mm, end_mm = np.interp(ends, np.arange(len(place_mm)), place_mm)
    speed = (end_mm - begin_mm) / ((ends[1] - ends[0]) * step_s)
    begins = at[0] + np.arange(int(len(at) / per_period)) * per_period
    least = [gap[(at >= b) & (at < b + per_period)].min() for b in begins]
    ahead = place_mm[first:last] - speed * np.arange(first, last) * step_s
    return Seen(1.0 - max(least) / (speed * pass_s), float(np.ptp(ahead)), per_rev)
