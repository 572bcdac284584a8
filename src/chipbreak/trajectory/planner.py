"""What a control really does with the blocks of an oscillation: time per block, frequency, feed to command.

A control stops at every reversal and needs acceleration, so a block takes longer than its length divided by
its feed.  Three laws are offered (``ControlModel.law``):

``ideal``
    time = length / feed.
``trapezoid``
    Declared for a control nobody has measured.  The axis rests at every reversal, speeds up and brakes at the
    declared acceleration, and runs through the joints of blocks that go the same way.  A block from rest to
    rest takes d/v + v/a, or 2·sqrt(d/a) when it is too short to reach v, and the time that the control stands
    there until it takes the axis to be in position.
``linuxcnc``
    The trajectory planner of LinuxCNC 2.9 (its ``src/emc/tp/tp.c``, and measured on its simulated machine:
    ``docs/linuxcnc-timing.md``).  It decides once per servo period T, and in a block that ends at rest
    1. it speeds up by at most a·T per period, until the feed is reached;
    2. it keeps the feed until it could not brake any more on v² = 2·a·(way to go);
    3. it brakes by a·T per period, and the last, incomplete period counts as a whole one.
    So such a block takes a whole number of periods, the trapezoid's time rounded up and sometimes one more;
    the fewest are the least k with a·T²·(k² − k mod 2)/4 ≥ d.  The full acceleration is used: half of it
    only where two blocks are blended round a corner, which an oscillation never has.  G61, G61.1 and G64 are
    the same for one block per stroke.  Several blocks per stroke run through their joints in G61 and G64
    (one that would take less than 1/100 s at an even change of speed is run as such a ramp), and each of
    them stops in G61.1.  Feed per minute and inverse time give the same times, and so does feed per
    revolution for one block per stroke; several are joined in another way (``per_revolution``).

Lengths [mm] are signed along the path, feeds [mm/s] are positive, times [s].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory import stretch_laws as laws
from chipbreak.trajectory.model import ControlModel
from chipbreak.units import S_PER_MIN

Floats = NDArray[np.float64]

_NOTHING = 1e-12  # mm that count as none


def predict(
    lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, model: ControlModel, *, before_mm_s: float = 0.0
) -> Floats:
    """Time [s] of each block, (n,), from rest before the first to rest after the last.

    ``lengths_mm`` (n,) are signed along the path, none of them zero; ``feeds_mm_s`` (n,) or one for all.
    Give the feeds as the F words print them: at the edge of a period, rounding decides.  ``before_mm_s`` is
    the feed of the block before, which counts for feed per revolution.  Errors: VIB033 when the control could
    merge strokes away.
    """
    lengths, feeds = _checked(lengths_mm, feeds_mm_s, model)
    times = np.empty(len(lengths))
    for first, last in _runs(lengths, model):
        times[first:last] = _run(lengths, feeds, first, last, model, before_mm_s=before_mm_s)[0]
    return times


def run_stretch(
    lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, model: ControlModel, *, before_mm_s: float = 0.0
) -> tuple[Floats, Floats]:
    """:func:`predict` for one stretch between rests, and its way [mm] after each period of ``linuxcnc``."""
    lengths, feeds = _checked(lengths_mm, feeds_mm_s, model)
    return _run(lengths, feeds, 0, len(lengths), model, before_mm_s=before_mm_s)


def trace(lengths_mm: ArrayLike, feeds_mm_s: ArrayLike, model: ControlModel) -> Floats:
    """Where the axis is commanded: (m, 2) of time [s] and signed distance from the start [mm].

    ``linuxcnc``: one row per servo period, after the (1, 4, 1)/6 average of its joint interpolator, which
    blunts every reversal by a third of the planner's last step; the interpolator's lag of two periods is left
    out.  The other laws: the ends of the blocks.  Errors as :func:`predict`.
    """
    lengths, feeds = _checked(lengths_mm, feeds_mm_s, model)
    if model.law != "linuxcnc":
        ends = np.cumsum(predict(lengths, feeds, model))
        return np.column_stack([np.r_[0.0, ends], np.r_[0.0, np.cumsum(lengths)]])
    parts, at = [np.zeros(2)], 0.0
    for first, last in _runs(lengths, model):
        sign = np.sign(lengths[first])
        parts.append(at + sign * _run(lengths, feeds, first, last, model)[1])
        at += float(np.sum(lengths[first:last]))
    places = np.r_[0.0, interpolated(np.r_[np.concatenate(parts), at]), at]
    return np.column_stack([np.arange(len(places)) * model.servo_period_s, places])


def interpolated(places_mm: Floats) -> Floats:
    """What LinuxCNC's joint interpolator makes of places in servo periods: (n,) -> (n - 2,)."""
    return (places_mm[:-2] + 4.0 * places_mm[1:-1] + places_mm[2:]) / 6.0


def reached(times_s: ArrayLike, vibrations: float, speed_rpm: float) -> tuple[float, float]:
    """Frequency [Hz] and vibrations per revolution that blocks lasting ``times_s`` really have."""
    frequency_hz = vibrations / float(np.sum(np.asarray(times_s, dtype=np.float64)))
    return frequency_hz, frequency_hz * S_PER_MIN / speed_rpm


def shortest_time(length_mm: float, model: ControlModel) -> float:
    """The least time [s] from rest to rest over ``length_mm``, whatever the feed.

    t = 2·sqrt(d/a) while the speed allows it; in whole periods for ``linuxcnc``.
    """
    length, read_s = abs(length_mm), 1.0 / model.blocks_per_s if model.blocks_per_s else 0.0
    if model.law == "ideal":
        return max(length / model.velocity_mm_s, read_s)
    top = min(model.velocity_mm_s, sqrt(length * model.acceleration_mm_s2))
    return max(float(predict([length], [top], replace(model, merge_mm=0.0))[0]), read_s)


def feed_for_time(length_mm: float, time_s: float, model: ControlModel) -> float:
    """The feed [mm/s] to command so that a block from rest to rest really takes ``time_s``.

    v = (a·t − sqrt(a²t² − 4·a·d))/2, d/t for ``ideal``.  ``linuxcnc`` runs whole servo periods, so ``time_s``
    is rounded to one, and the feed is the middle of those that give it, so that rounding F does not tip it
    over.  Errors: VIB030 acceleration, VIB031 speed, VIB032 blocks per second.
    """
    if not (abs(length_mm) > _NOTHING and 0 < time_s < inf):
        raise ValueError(f"no feed for {length_mm} mm in {time_s} s")
    return _feed(abs(float(length_mm)), float(time_s), replace(model, merge_mm=0.0))


def feeds_for_times(lengths_mm: ArrayLike, times_s: ArrayLike, model: ControlModel) -> Floats:
    """:func:`feed_for_time` for strokes in a row, (n,), each of them from rest to rest.

    ``linuxcnc`` runs whole periods; what one stroke lacks to its wanted time the next one gets, so that the
    mean frequency is the wanted one.  Errors as there, and VIB033 as in :func:`predict`.
    """
    lengths, times = _checked(lengths_mm, times_s, model)
    if model.law == "linuxcnc":
        ends = np.rint(np.cumsum(times) / model.servo_period_s)
        times = np.diff(ends, prepend=0.0) * model.servo_period_s
    return np.array([feed_for_time(*pair, model) for pair in zip(lengths, times, strict=True)])


def refuse_too_fast(length_mm: float, time_s: float, model: ControlModel) -> None:
    """The errors of :func:`feed_for_time`, without a feed."""
    period = model.servo_period_s
    wanted = round(time_s / period) * period if model.law == "linuxcnc" else time_s
    _refuse_too_fast(length_mm, wanted, model)
    # Less by two periods: no feed in the middle is that fast, so only beyond it there is need to look.
    if laws.speed_for_time(length_mm, wanted - 2.0 * period, model.acceleration_mm_s2) > model.velocity_mm_s:
        feed_for_time(length_mm, time_s, model)


@lru_cache(maxsize=4096)
def _feed(length: float, time: float, model: ControlModel) -> float:
    period = model.servo_period_s
    wanted = round(time / period) * period if model.law == "linuxcnc" else time
    _refuse_too_fast(length, wanted, model)
    if model.law == "ideal":
        feed = length / wanted
    elif model.law == "trapezoid":
        feed = laws.speed_for_time(length, wanted - model.reversal_stop_s, model.acceleration_mm_s2)
    else:
        feed = _middle_feed(length, round(time / period), model)
    if feed > model.velocity_mm_s:
        told = f"{feed:.4g} mm/s for {length:.4g} mm in {wanted * 1000:.4g} ms"
        help_text = "ask for a lower frequency or a smaller stroke"
        raise RefusalError("VIB031", f"needs {told}, {_of(model)} {model.velocity_mm_s:.4g} mm/s", help_text)
    return feed


def _refuse_too_fast(length: float, wanted: float, model: ControlModel) -> None:
    stroke = f"a stroke of {length:.4g} mm in {wanted * 1000:.4g} ms"
    if model.blocks_per_s and wanted * model.blocks_per_s < 1.0 - 1e-9:
        told = (
            f"{stroke} needs {1 / wanted:.4g} blocks per second, the control reads {model.blocks_per_s:.4g}"
        )
        raise RefusalError("VIB032", told, "ask for a lower frequency, or one block per stroke")
    least = shortest_time(length, replace(model, velocity_mm_s=inf, blocks_per_s=None))
    if model.law == "ideal" or wanted >= least * (1.0 - 1e-9):
        return
    moving_s = wanted - model.reversal_stop_s
    needed = 4.0 * length / moving_s**2 if moving_s > 0.0 else inf
    if model.law == "linuxcnc":
        periods = max(round(wanted / model.servo_period_s), 2)
        needed = 4.0 * length / (periods**2 - periods % 2) / model.servo_period_s**2
    way = f"this stroke takes at least {least * 1000:.4g} ms; ask for a lower frequency or a smaller stroke"
    told = f"{stroke} needs {needed / 1000:.3g} m/s², {_of(model)} {model.acceleration_mm_s2 / 1000:.3g} m/s²"
    raise RefusalError("VIB030", told, way)


def _of(model: ControlModel) -> str:
    return f"{model.axis} has" if model.axis else "the axis has"


def _middle_feed(length: float, periods: int, model: ControlModel) -> float:
    """The feed in the middle, by time, of all feeds that make LinuxCNC take this many periods."""
    period, acceleration = model.servo_period_s, model.acceleration_mm_s2

    def slowest(most: int) -> float:
        """The longest trapezoid time, in periods, that LinuxCNC still runs in ``most`` of its periods."""
        low, high = max(most - 2.0, 2.0 * sqrt(length / acceleration) / period), float(most)
        for _ in range(14):
            time = (low + high) / 2.0
            feed = laws.speed_for_time(length, time * period, acceleration)
            took = laws.linuxcnc((length,), (feed,), acceleration, period, model.ramp_s)[0][0]
            low, high = (time, high) if round(took / period) <= most else (low, time)
        return low

    late, early = slowest(periods), 2.0 * sqrt(length / acceleration) / period
    if early < periods - 1.0:
        early = max(early, slowest(periods - 1))
    return laws.speed_for_time(length, (late + early) / 2.0 * period, acceleration)


def _checked(lengths_mm: ArrayLike, feeds: ArrayLike, model: ControlModel) -> tuple[Floats, Floats]:
    lengths = np.atleast_1d(np.asarray(lengths_mm, dtype=np.float64))
    rates = np.broadcast_to(np.asarray(feeds, dtype=np.float64), lengths.shape)
    if not (np.all(np.isfinite(lengths)) and np.all(np.abs(lengths) > _NOTHING) and np.all(rates > 0)):
        raise ValueError("every block needs a length and a feed or time above zero")
    if model.law == "linuxcnc" and model.acceleration_mm_s2 == inf:
        raise ValueError("LinuxCNC's law needs an acceleration: give it, or the axes with along()")
    refuse_merging(lengths, model)
    return lengths, rates


def refuse_merging(lengths_mm: Floats, model: ControlModel) -> None:
    """Errors: VIB033 when a stroke is so small that the control's path mode drops it."""
    if model.merge_mm <= 0.0:
        return
    strokes = np.abs(np.add.reduceat(lengths_mm, np.r_[0, _turns(lengths_mm)]))
    if len(strokes) > 1 and np.min(strokes) <= model.merge_mm:
        told = f"the control joins points within {model.merge_mm:.4g} mm of a line and would drop strokes"
        small = f"the smallest stroke is {np.min(strokes):.4g} mm; "
        raise RefusalError("VIB033", told, small + "switch to G61, or G64 with a smaller P or Q")


def _turns(lengths: Floats) -> NDArray[np.intp]:
    """The blocks that go the other way than the one before."""
    return np.flatnonzero(np.diff(np.sign(lengths))) + 1


def _runs(lengths: Floats, model: ControlModel) -> Iterator[tuple[int, int]]:
    """First and behind-last block of each stretch from rest to rest."""
    if model.every_block_stops:
        return ((i, i + 1) for i in range(len(lengths)))
    return pairwise([0, *_turns(lengths).tolist(), len(lengths)])


def _run(
    lengths: Floats, feeds: Floats, first: int, last: int, model: ControlModel, *, before_mm_s: float = 0.0
) -> tuple[Floats, Floats]:
    """Times of the blocks of one stretch, and where LinuxCNC is after each period of it."""
    ways = np.abs(lengths[first:last])
    speeds = np.minimum(feeds[first:last], model.velocity_mm_s)
    places: Sequence[float] = ()
    if model.law == "linuxcnc":
        # Blocks of one feed are one block to a control that joins points on a line.
        same = model.merge_mm > 0.0
        starts = np.flatnonzero(np.r_[True, (np.diff(speeds) != 0.0) | (not same)])
        joined, rates = np.add.reduceat(ways, starts), speeds[starts]
        alone = not model.per_revolution or len(joined) == 1
        before = None if alone else float(feeds[first - 1]) if first else before_mm_s
        args = (model.acceleration_mm_s2, model.servo_period_s, model.ramp_s)
        took, places = laws.linuxcnc(tuple(joined.tolist()), tuple(rates.tolist()), *args, before=before)
        times = np.repeat(np.array(took) / joined, np.diff(np.r_[starts, len(ways)])) * ways
    elif model.law == "trapezoid":
        times = np.array(laws.trapezoid(ways.tolist(), speeds.tolist(), model.acceleration_mm_s2))
        times[-1] += model.reversal_stop_s
    else:
        times = ways / speeds
    read_s = 1.0 / model.blocks_per_s if model.blocks_per_s else 0.0
    return np.maximum(times, read_s), np.array(places)
