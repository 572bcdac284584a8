"""Feeds that make this control take the wanted time, and the time it will take for given feeds.

The planner knows one stretch from rest to rest; a vibrated cut is many thousands of them, of few kinds.  Each
kind is worked out once.  A control rests where the tool turns back, and where the path bends by more than it
can follow at speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.diagnostics import RefusalError
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.bends import Blocks, bend_strengths, parts, strokes
from chipbreak.vibration.control import ControlModel
from chipbreak.vibration.planner import (
    feed_for_time,
    interpolated,
    predict,
    refuse_merging,
    run_stretch,
    shortest_time,
)

Floats = NDArray[np.float64]
Numbers = tuple[float, ...]
Key = tuple[Numbers, Numbers, float, ControlModel]  # lengths, feeds and time, the feed before, control
_ROUNDS = 4
_STILL_EVEN_MM = 1e-9
_FACTORS = np.geomspace(0.5, 20.0, 75)


def feeds_for_spans(blocks: Blocks, spans_s: Floats, model: ControlModel, plain_from: int) -> Floats:
    """Feed [mm/s] of each block, (n,), so that every stroke takes its time on this control.

    Blocks from ``plain_from`` on run at their own feed.  A stroke round a corner, where the control rests,
    may be too short for its time: then it runs as fast as it can, and those behind it are so much later.
    Errors: VIB030 acceleration, VIB031 speed, VIB032 blocks per second, VIB033 strokes that would be lost.
    """
    refuse_merging(blocks.lengths_mm, model)
    feeds = np.abs(blocks.lengths_mm) / spans_s
    if model.law == "ideal":
        _check_limits(feeds, spans_s, model)
        return feeds
    # Where the control rests at a bend depends on the feeds, and the feeds on where it rests.
    strengths = bend_strengths(blocks, feeds, model)
    for _ in range(_ROUNDS):
        found = _feeds(blocks, spans_s, strengths, model, plain_from)
        before, strengths = strengths, bend_strengths(blocks, found, model)
        if np.array_equal(before >= 1.0, strengths >= 1.0):
            break
        strengths = np.maximum(before, strengths)
    return found


def _feeds(
    blocks: Blocks, spans_s: Floats, strengths: Floats, model: ControlModel, plain_from: int
) -> Floats:
    """:func:`feeds_for_spans` where the strengths of the bends are known."""
    ways_mm = np.abs(blocks.lengths_mm)
    feeds = ways_mm / spans_s
    known: dict[Key, Floats] = {}
    ends_s = np.cumsum(spans_s)
    done_s = late_s = before = 0.0
    for first, last in strokes(blocks.lengths_mm):
        if last > plain_from:
            break
        # What rounding to servo periods takes from one stroke, the next one gets.
        wanted_s = float(ends_s[last - 1]) + late_s - done_s
        if model.law == "linuxcnc":
            wanted_s = round(wanted_s / model.servo_period_s) * model.servo_period_s
        pieces = parts(first, last, strengths)
        models = [blocks.model(start, stop, model, strengths) for start, stop in pieces]
        times_s = _shares([float(ways_mm[start:stop].sum()) for start, stop in pieces], wanted_s, models)
        for (start, stop), part_model, time_s in zip(pieces, models, times_s, strict=True):
            lengths, nominal = ways_mm[start:stop], feeds[start:stop]
            if stop - start == 1:
                nominal, before = nominal[:0], 0.0  # one block depends on its time alone
            key = (tuple(lengths.tolist()), (*nominal.tolist(), time_s), before, part_model)
            if key not in known:
                known[key] = _stretch_feeds(lengths, nominal, time_s, part_model, before)
            feeds[start:stop] = known[key]
            done_s, before = done_s + time_s, float(feeds[stop - 1])
        late_s += max(0.0, done_s - float(ends_s[last - 1]) - late_s - model.servo_period_s)
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


def _shares(ways_mm: Sequence[float], wanted_s: float, models: Sequence[ControlModel]) -> list[float]:
    """The time of each part of a stroke that rests between them: the least each needs, and more by length."""
    if len(ways_mm) == 1:
        return [wanted_s]
    least_s = [shortest_time(way, model) for way, model in zip(ways_mm, models, strict=True)]
    step_s = models[0].servo_period_s if models[0].law == "linuxcnc" else wanted_s * 1e-9
    spare = max(0, round((wanted_s - sum(least_s)) / step_s))
    given = [int(spare * way / sum(ways_mm)) for way in ways_mm]
    given[ways_mm.index(max(ways_mm))] += spare - sum(given)
    return [least + more * step_s for least, more in zip(least_s, given, strict=True)]


def _stretch_feeds(
    lengths: Floats, feeds: Floats, wanted_s: float, model: ControlModel, before: float
) -> Floats:
    """Feeds of one stretch from rest to rest that together take ``wanted_s``: one factor on all of them.

    The factor stands in the middle of those that do, so that rounding F does not tip it over.
    """
    # Refuses, with the numbers, what even one block over the whole stretch could not do.
    feed = feed_for_time(float(lengths.sum()), wanted_s, model)
    if len(lengths) == 1:
        return np.array([feed])
    slack_s = model.servo_period_s / 2.0 if model.law == "linuxcnc" else 0.002 * wanted_s

    def misses(factor: float) -> float:
        return float(predict(lengths, feeds * factor, model, before_mm_s=before).sum()) - wanted_s

    late_s = np.array([misses(factor) for factor in _FACTORS])
    hits = np.flatnonzero(np.abs(late_s) <= slack_s)
    if not len(hits):
        crossing = np.flatnonzero((late_s[:-1] > 0.0) & (late_s[1:] <= 0.0))
        if not len(crossing):
            message = (
                f"a stroke of {lengths.sum():.4g} mm in {len(lengths)} blocks takes"
                f" {(late_s.min() + wanted_s) * MS_PER_S:.4g} ms"
                f" at any feed, {wanted_s * MS_PER_S:.4g} ms are wanted"
            )
            help_text = "take one block per stroke (WAVE TRIANGLE), or a lower frequency"
            raise RefusalError("VIB030", message, help_text)
        between = np.geomspace(float(_FACTORS[crossing[0]]), float(_FACTORS[crossing[0] + 1]), 40)
        late_s = np.array([misses(factor) for factor in between])
        best = np.flatnonzero(np.abs(late_s) == np.abs(late_s).min())
        return feeds * float(between[best[len(best) // 2]])
    runs = np.split(hits, np.flatnonzero(np.diff(hits) > 1) + 1)
    widest = max(runs, key=len)
    return feeds * math.sqrt(float(_FACTORS[widest[0]] * _FACTORS[widest[-1]]))


@dataclass(frozen=True, eq=False)
class Motion:
    """What a control makes of some blocks: how long each takes [s], (n,), and where the tool is when.

    ``time_s`` and ``distance_mm`` are the knots of the motion along the path, (m,); between them it is even.
    For ``linuxcnc`` they follow every servo period, behind the joint interpolator; else they are the ends of
    the blocks.
    """

    spans_s: Floats
    time_s: Floats
    distance_mm: Floats


def motion_of(distance_mm: Floats, blocks: Blocks, feeds_mm_s: Floats, model: ControlModel) -> Motion:
    """The motion of blocks between the places ``distance_mm`` along the path, (n + 1,)."""
    refuse_merging(blocks.lengths_mm, model)
    ways_mm = np.abs(blocks.lengths_mm)
    spans_s, before = ways_mm / np.minimum(feeds_mm_s, model.velocity_mm_s), 0.0
    if model.law == "ideal":
        return Motion(spans_s, np.append(0.0, np.cumsum(spans_s)), distance_mm)
    places, rests = [np.zeros(2)], list[int]()
    known: dict[Key, tuple[Floats, Floats]] = {}
    strengths = bend_strengths(blocks, feeds_mm_s, model)
    for first, last in strokes(blocks.lengths_mm):
        sign = np.sign(blocks.lengths_mm[first])
        for start, stop in parts(first, last, strengths):
            part_model = blocks.model(start, stop, model, strengths)
            lengths, feeds = ways_mm[start:stop], feeds_mm_s[start:stop]
            before = before if stop - start > 1 else 0.0
            key = (tuple(lengths.tolist()), tuple(feeds.tolist()), before, part_model)
            if key not in known:
                known[key] = run_stretch(lengths, feeds, part_model, before_mm_s=before)
            spans_s[start:stop], way_mm = known[key]
            places.append(distance_mm[start] + sign * way_mm)
            before = float(feeds[-1])
            rests.append(stop)
    if model.law != "linuxcnc":
        return _with_rests(spans_s, distance_mm, np.array(rests), model.reversal_stop_s)
    planned = np.concatenate([*places, distance_mm[-1:]])
    knots_mm = np.concatenate([np.zeros(1), interpolated(planned), distance_mm[-1:]])
    bent = np.abs(np.diff(knots_mm, 2)) > _STILL_EVEN_MM
    kept = np.flatnonzero(np.concatenate([[True], bent, [True]]))
    return Motion(spans_s, kept.astype(np.float64) * model.servo_period_s, knots_mm[kept])


def _with_rests(spans_s: Floats, distance_mm: Floats, rests: NDArray[np.intp], stop_s: float) -> Motion:
    """Even motion between the ends of blocks, with the time that the control stands at some of them."""
    time_s = np.append(0.0, np.cumsum(spans_s))
    if stop_s <= 0.0:
        return Motion(spans_s, time_s, distance_mm)
    knots_s = np.insert(time_s, rests, time_s[rests] - stop_s)
    return Motion(spans_s, knots_s, np.insert(distance_mm, rests, distance_mm[rests]))
