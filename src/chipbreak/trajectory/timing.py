"""Feeds that make this control take the wanted time, and the time it will take for given feeds.

The planner knows one stretch from rest to rest; a vibrated cut is many thousands of them, of few kinds.  Each
kind is worked out once.  A control rests where the tool turns back, and where the path bends by more than it
can follow at speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.feed_search import Stretch, feed_factors, feeds_of_single_blocks, forget
from chipbreak.trajectory.junctions import Blocks, Parts, bend_strengths, parts_of
from chipbreak.trajectory.linuxcnc_stretches import can_run_many, run_many
from chipbreak.trajectory.model import ControlModel
from chipbreak.trajectory.planner import (
    interpolated,
    refuse_merging,
    run_stretch,
    shortest_time,
)
from chipbreak.units import S_PER_MIN

Floats = NDArray[np.float64]
_Run = tuple[tuple[float, ...], tuple[float, ...], float, float]  # lengths, feeds, acceleration, feed before
_EITHER = (0.0, np.inf)
_ROUNDS = 4
# Fewer stretches are faster one by one: a long even feed, such as a plain end, then takes no time.
_MANY = 8
_STILL_EVEN_MM = 1e-9


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
    forget(model)
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
    parts = parts_of(blocks, strengths, model, plain_from)
    times_s = _times_of_parts(parts, ways_mm, spans_s, model)
    alone = parts.stops - parts.starts == 1
    firsts, allowed = parts.starts[alone], parts.acceleration_mm_s2[alone]
    feeds[firsts] = feeds_of_single_blocks(ways_mm[firsts], times_s[alone], allowed, model)
    _fit_several(parts, ways_mm, feeds, times_s, model)
    return feeds


def _fit_several(parts: Parts, ways_mm: Floats, feeds: Floats, times_s: Floats, model: ControlModel) -> None:
    """Change the feeds of the parts that are several blocks, so that these take their times."""
    several = np.flatnonzero(parts.stops - parts.starts > 1)
    starts, stops = parts.starts[several].tolist(), parts.stops[several].tolist()
    lengths, nominal = (
        [tuple(c[i:j].tolist()) for i, j in zip(starts, stops, strict=True)] for c in (ways_mm, feeds)
    )
    rest = times_s[several].tolist(), parts.acceleration_mm_s2[several].tolist()
    stretches = list(map(Stretch, lengths, nominal, *rest))
    found: dict[tuple[Stretch, float], float | RefusalError] = {}
    if can_run_many(model):
        kinds = list(dict.fromkeys(stretches))
        for before in _EITHER if model.per_revolution else _EITHER[:1]:
            factors = feed_factors(kinds, before, model)
            found |= {(kind, before): factor for kind, factor in zip(kinds, factors, strict=True)}
    for start, stop, stretch in zip(starts, stops, stretches, strict=True):
        before = _before(feeds, start, stretch.lengths_mm[0], model)
        if (stretch, before) not in found:
            [found[stretch, before]] = feed_factors([stretch], before, model)
        factor = found[stretch, before]
        if isinstance(factor, RefusalError):
            raise factor
        feeds[start:stop] *= factor


def _before(feeds: Floats, start: int, length_mm: float, model: ControlModel) -> float:
    """The feed of the block before a part, as far as it counts.

    With feed per revolution LinuxCNC asks it whether the first block is one even change of speed, and nothing
    else; so one of two feeds stands for all.
    """
    before = float(feeds[start - 1]) if start and model.per_revolution else 0.0
    if can_run_many(model):
        return _EITHER[int(2.0 * length_mm < model.ramp_s * before)]
    return before


def _with(model: ControlModel, acceleration_mm_s2: float) -> ControlModel:
    return replace(model, acceleration_mm_s2=acceleration_mm_s2)


def _times_of_parts(parts: Parts, ways_mm: Floats, spans_s: Floats, model: ControlModel) -> Floats:
    """How long each part should take, (p,)."""
    firsts = np.flatnonzero(np.diff(parts.strokes, prepend=-1)).tolist()
    lasts = [*firsts[1:], len(parts.starts)]
    ends_s = np.cumsum(spans_s)[parts.stops[np.array(lasts, np.intp) - 1] - 1] if firsts else np.empty(0)
    times_s: list[float] = []
    done_s = late_s = 0.0
    for first, last, end_s in zip(firsts, lasts, ends_s.tolist(), strict=False):
        # What rounding to servo periods takes from one stroke, the next one gets.
        wanted_s = end_s + late_s - done_s
        if model.law == "linuxcnc":
            wanted_s = round(wanted_s / model.servo_period_s) * model.servo_period_s
        shares = [wanted_s]
        if last - first > 1:
            ways = np.add.reduceat(ways_mm[: parts.stops[last - 1]], parts.starts[first:last]).tolist()
            models = [_with(model, has) for has in parts.acceleration_mm_s2[first:last].tolist()]
            shares = _shares(ways, wanted_s, models)
        times_s += shares
        for share in shares:
            done_s += share
        late_s += max(0.0, done_s - end_s - late_s - model.servo_period_s)
    return np.array(times_s)


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
    if model.law == "ideal":
        spans_s = ways_mm / np.minimum(feeds_mm_s, model.velocity_mm_s)
        return Motion(spans_s, np.append(0.0, np.cumsum(spans_s)), distance_mm)
    strengths = bend_strengths(blocks, feeds_mm_s, model)
    parts = parts_of(blocks, strengths, model, len(ways_mm))
    times, passed = _runs_of_parts(parts, ways_mm, feeds_mm_s, model)
    spans_s = np.concatenate(times)
    if model.law != "linuxcnc":
        return _with_rests(spans_s, distance_mm, parts.stops, model.reversal_stop_s)
    counts = [len(places) for places in passed]
    signs = np.repeat(np.sign(blocks.lengths_mm[parts.starts]), counts)
    along_mm = np.repeat(distance_mm[parts.starts], counts) + signs * np.concatenate(passed)
    planned = np.concatenate([np.zeros(2), along_mm, distance_mm[-1:]])
    knots_mm = np.concatenate([np.zeros(1), interpolated(planned), distance_mm[-1:]])
    bent = np.abs(np.diff(knots_mm, 2)) > _STILL_EVEN_MM
    kept = np.flatnonzero(np.concatenate([[True], bent, [True]]))
    return Motion(spans_s, kept.astype(np.float64) * model.servo_period_s, knots_mm[kept])


def _runs_of_parts(
    parts: Parts, ways_mm: Floats, feeds_mm_s: Floats, model: ControlModel
) -> tuple[list[Floats], list[Floats]]:
    """Of each part the times of its blocks, and where LinuxCNC is after each period of it."""
    keys: list[_Run] = []
    for start, stop, has in zip(
        parts.starts.tolist(), parts.stops.tolist(), parts.acceleration_mm_s2.tolist(), strict=True
    ):
        lengths, feeds = tuple(ways_mm[start:stop].tolist()), tuple(feeds_mm_s[start:stop].tolist())
        before = _before(feeds_mm_s, start, lengths[0], model) if len(lengths) > 1 else 0.0
        keys.append((lengths, feeds, has, before))
    kinds = list(dict.fromkeys(keys))
    found: dict[_Run, tuple[Floats, Floats]] = {}
    for count in {len(kind[0]) for kind in kinds} - {1} if can_run_many(model) else ():
        alike = [kind for kind in kinds if len(kind[0]) == count]
        if len(alike) < _MANY:
            continue
        lengths_mm, feeds_of, has_mm_s2, before_mm_s = map(np.array, zip(*alike, strict=True))
        times, places = run_many(lengths_mm, feeds_of, has_mm_s2, before_mm_s, model)
        ways = [row[~np.isnan(row)] for row in places]
        found |= dict(zip(alike, zip(times, ways, strict=True), strict=True))
    for kind in kinds:
        if kind not in found:
            lengths, feeds, has, before = kind
            found[kind] = run_stretch(lengths, feeds, _with(model, has), before_mm_s=before)
    return [found[key][0] for key in keys], [found[key][1] for key in keys]


def _with_rests(spans_s: Floats, distance_mm: Floats, rests: NDArray[np.intp], stop_s: float) -> Motion:
    """Even motion between the ends of blocks, with the time that the control stands at some of them."""
    time_s = np.append(0.0, np.cumsum(spans_s))
    if stop_s <= 0.0:
        return Motion(spans_s, time_s, distance_mm)
    knots_s = np.insert(time_s, rests, time_s[rests] - stop_s)
    return Motion(spans_s, knots_s, np.insert(distance_mm, rests, distance_mm[rests]))
