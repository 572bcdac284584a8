"""Feeds that make this control take the wanted time, and the time it will take for given feeds.

The planner knows one stretch from rest to rest; a vibrated cut is many thousands of them, of few kinds.  Each
kind is worked out once.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import cast

import numpy as np
from numpy.typing import NDArray

from chipbreak.diagnostics import RefusalError
from chipbreak.settings.sections import Axis, Settings
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.path import Path
from chipbreak.vibration.planner import AxisLimits, ControlModel, Law, feed_for_time, predict

Floats = NDArray[np.float64]
Stretch = tuple[tuple[float, ...], tuple[float, ...]]
_HALVINGS = 40


def control_model(settings: Settings, path: Path) -> ControlModel:
    """The control and its axes along a path: the limits of the direction that is limited most."""
    planner = settings.planner
    model = ControlModel(
        law=cast(Law, planner.model),
        servo_period_s=planner.servo_period_ms / MS_PER_S,
        blocks_per_s=planner.max_blocks_per_s,
    )
    axes = [_limits(name, axis) for name, axis in settings.axes.items()]
    models = [model.along(direction, axes) for direction in _directions(path)]
    return min(models, key=lambda m: (m.acceleration_mm_s2, m.velocity_mm_s))


def _limits(name: str, axis: Axis) -> AxisLimits:
    velocity = math.inf if axis.max_velocity_mm_min is None else axis.max_velocity_mm_min / S_PER_MIN
    acceleration = math.inf if axis.max_acceleration_mm_s2 is None else axis.max_acceleration_mm_s2
    return AxisLimits(name, velocity, acceleration)


def _directions(path: Path) -> list[tuple[float, float, float]]:
    """The directions of the lines; an arc takes every direction of its plane, its axes limit most."""
    directions = []
    for leg, arc in zip(path.legs, path.arcs, strict=True):
        if arc is None:
            x, y, z = (e - s for s, e in zip(leg.start, leg.end, strict=True))
            directions.append((x, y, z))
            continue
        for axis in arc.axes:
            directions.append((float(axis == 0), float(axis == 1), float(axis == 2)))
    return directions


def feeds_for_spans(lengths_mm: Floats, spans_s: Floats, model: ControlModel, plain_from: int) -> Floats:
    """Feed [mm/s] of each block, (n,), so that every stroke takes its time on this control.

    ``lengths_mm`` are signed along the path, (n,); blocks from ``plain_from`` on run at their own feed.
    Errors: VIB030 acceleration, VIB031 speed, VIB032 blocks per second.
    """
    feeds = np.abs(lengths_mm) / spans_s
    if model.law == "ideal":
        _check_limits(feeds, spans_s, model)
        return feeds
    known: dict[Stretch, Floats] = {}
    ends_s = np.cumsum(spans_s)
    done_s = 0.0
    for first, last in _stretches(lengths_mm):
        if last > plain_from:
            break
        # What rounding to servo periods takes from one stroke, the next one gets.
        wanted_s = float(ends_s[last - 1]) - done_s
        if model.law == "linuxcnc":
            wanted_s = round(wanted_s / model.servo_period_s) * model.servo_period_s
        done_s += wanted_s
        key = (tuple(np.abs(lengths_mm[first:last]).tolist()), (*feeds[first:last].tolist(), wanted_s))
        if key not in known:
            known[key] = _stretch_feeds(key[0], np.array(key[1][:-1]), wanted_s, model)
        feeds[first:last] = known[key]
    return feeds


def _check_limits(feeds: Floats, spans_s: Floats, model: ControlModel) -> None:
    """Speed and block rate on a control that follows any acceleration."""
    top = float(feeds.max())
    if top > model.velocity_mm_s:
        message = (
            f"the strokes need {top * S_PER_MIN:.0f} mm/min,"
            f" {model.axis or 'the axis'} has {model.velocity_mm_s * S_PER_MIN:.0f}"
        )
        raise RefusalError("VIB031", message, "ask for a lower frequency, a smaller stroke or less feed")
    least_s = float(spans_s.min())
    if model.blocks_per_s is not None and least_s * model.blocks_per_s < 1.0 - 1e-9:
        message = f"needs {1.0 / least_s:.0f} blocks per second, the control reads {model.blocks_per_s:g}"
        help_text = 'ask for a lower frequency, or take output.segments = "stroke"'
        raise RefusalError("VIB032", message, help_text)


def _stretch_feeds(lengths: tuple[float, ...], feeds: Floats, wanted_s: float, model: ControlModel) -> Floats:
    """Feeds of one stretch from rest to rest that together take ``wanted_s``: one factor on all of them."""
    if len(lengths) == 1:
        return np.array([feed_for_time(lengths[0], wanted_s, model)])
    # Refuses, with the numbers, what even one block over the whole stretch could not do.
    feed_for_time(sum(lengths), wanted_s, model)

    def takes(factor: float) -> float:
        return float(predict(lengths, feeds * factor, model).sum())

    half_period_s = model.servo_period_s / 2.0 if model.law == "linuxcnc" else 0.0
    high = 1.0
    while takes(high) > wanted_s + half_period_s and high < 1e3:
        high *= 2.0
    if takes(high) > wanted_s + half_period_s:
        message = (
            f"a stroke of {sum(lengths):.4g} mm in {len(lengths)} blocks takes"
            f" {takes(high) * MS_PER_S:.4g} ms"
            f" at any feed, {wanted_s * MS_PER_S:.4g} ms are wanted"
        )
        raise RefusalError("VIB030", message, 'take output.segments = "stroke", or a lower frequency')
    low = high / 2.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if takes(middle) > wanted_s + half_period_s else (low, middle)
    return feeds * high


def times_of(lengths_mm: Floats, feeds_mm_s: Floats, model: ControlModel) -> Floats:
    """How long each block takes on this control [s], (n,); lengths are signed along the path."""
    if model.law == "ideal":
        return np.abs(lengths_mm) / np.minimum(feeds_mm_s, model.velocity_mm_s)
    known: dict[Stretch, Floats] = {}
    times = np.empty(len(lengths_mm))
    for first, last in _stretches(lengths_mm):
        key = (tuple(np.abs(lengths_mm[first:last]).tolist()), tuple(feeds_mm_s[first:last].tolist()))
        if key not in known:
            known[key] = predict(key[0], key[1], model)
        times[first:last] = known[key]
    return times


def _stretches(lengths_mm: Floats) -> list[tuple[int, int]]:
    """First and behind-last block of each stretch between two reversals."""
    turns = np.flatnonzero(np.diff(np.sign(lengths_mm))) + 1
    bounds = [0, *turns.tolist(), len(lengths_mm)]
    return list(pairwise(bounds))


