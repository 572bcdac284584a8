"""The steady part of a cut as a loop: some vibrations in distances, repeated.

K vibrations go on by K times the mean advance, which is rarely a whole number of steps (of the output's last
digit).  A loop goes on by whole steps A, so its points leave the exact ones by A - K advance more with
every pass.  Where that is nothing, they are the rounded points of the expanded form.  Elsewhere they are
centred, so that no point lies further from the exact motion than half a step and half of what the passes add
up to, which is a quarter of a step at most.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.waveform import full_window
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.junctions import Blocks
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import MS_PER_S
from chipbreak.vibration.machine import law_of
from chipbreak.vibration.plan import CutPlan
from chipbreak.vibration.tolerances import PLANNED_TIME_SHARE

MOST_DRIFT_STEPS = 0.25
_NO_DRIFT_STEPS = 1e-6
_FEWEST_PASSES_ALIKE = 4  # fewer passes of a pattern without drift are not worth its length
_LEAST_SAVED_BLOCKS = 12
_MOST_PERIODS = 1000
_SAME_S = 1e-9
_SAME_MM = 1e-9


@dataclass(frozen=True)
class Loop:
    """``passes`` times the same ``count`` blocks, ``vibrations`` vibrations; ``first`` is the first of them.

    ``drift_steps`` is what the advance of all passes lacks to the exact one, in steps of the output.
    """

    first: int
    count: int
    passes: int
    vibrations: int
    drift_steps: float

    @property
    def stop(self) -> int:
        """The block behind the last pass."""
        return self.first + self.count * self.passes


def looped_points(
    cut: CutPlan, time_s: Floats, exact_steps: Floats, settings: Settings
) -> tuple[Floats, list[Loop]]:
    """Whole steps for all knots, (n, axes), and the loops among them, ``first`` and ``count`` being knots.

    ``exact_steps`` is where the knots would lie without rounding.  Errors: VIB081 when no number of
    vibrations takes whole servo periods.
    """
    steps = np.rint(exact_steps)
    loops: list[Loop] = []
    per_vibration = cut.wave.moves_per_vibration
    free = 0
    for begin, last in _stretches(cut):
        every = _closing(cut, settings)
        first = _next_multiple(max(begin, free), every)
        start = int(np.searchsorted(time_s, first * cut.wave.period_s - _SAME_S))
        stop = int(np.searchsorted(time_s, last * cut.wave.period_s - _SAME_S))
        if stop - start != (last - first) * per_vibration:
            continue  # a move was cut in pieces here
        while last > first:
            advance = (exact_steps[stop] - exact_steps[start]) / (last - first)
            found = _pattern(advance, last - first, per_vibration, every, _fewest(cut, settings))
            if found is None:
                break
            _repeat(steps, exact_steps, start, found, per_vibration)
            loops.append(
                Loop(
                    start, found.vibrations * per_vibration, found.passes, found.vibrations, found.drift_steps
                )
            )
            # One vibration leads from the last point of this loop to the first of the next one.
            free = first + found.vibrations * found.passes + 1
            if not found.drift_steps:
                break  # what is left is shorter than one pass; written out it stays exact
            gone = _next_multiple(free, every) - first
            first += gone
            start += gone * per_vibration
    return steps, loops


def _next_multiple(number: int, of: int) -> int:
    return -(-number // of) * of


def _stretches(cut: CutPlan) -> Iterator[tuple[int, int]]:
    """First and behind-last of the vibrations of full stroke that lie in one straight leg.

    The first and the last vibration of the cut are none of them: start and end keep their own points.
    """
    window_s = full_window(cut.wave)
    full = [round(time_s / cut.wave.period_s) for time_s in window_s]
    first = max(full[0], 1)
    last = min(full[1], cut.wave.vibrations - 1)
    each = cut.wave.knots_per_vibration
    if last <= first:
        return
    knots_mm = cut.distance_mm[1 + first * each : 1 + last * each].reshape(-1, each)
    low_mm = cut.distance_mm[first * each : last * each : each]
    high_mm = knots_mm.max(axis=1)
    for index, arc in enumerate(cut.path.arcs):
        start_mm, end_mm = cut.path.ends_mm[index : index + 2]
        inside = np.flatnonzero((low_mm >= start_mm - _SAME_MM) & (high_mm <= end_mm + _SAME_MM))
        if arc is None and len(inside) > 1:
            yield first + int(inside[0]), first + int(inside[-1]) + 1


def _closing(cut: CutPlan, settings: Settings) -> int:
    """How many vibrations take whole servo periods, where the control runs whole ones."""
    if not law_of(settings).runs_whole_periods or cut.expander.keeps_feed:
        return 1
    servo_s = settings.planner.servo_period_ms / MS_PER_S
    periods = np.arange(1, _MOST_PERIODS + 1) * cut.wave.period_s / servo_s
    whole = np.flatnonzero(np.abs(periods - np.rint(periods)) < 1e-6)
    if not len(whole):
        message = (
            f"a vibration takes {cut.wave.period_s * MS_PER_S:.6g} ms, and no number of them up to"
            f" {_MOST_PERIODS} whole servo periods of {settings.planner.servo_period_ms:g} ms"
        )
        help_text = 'ask for an f whose period is a whole number of them, or take output.form "expanded"'
        raise RefusalError("VIB081", message, help_text)
    return int(whole[0]) + 1


def _fewest(cut: CutPlan, settings: Settings) -> int:
    """How many vibrations a pass needs so that its statements can be read beside its blocks."""
    words = settings.dialect.loop
    rate = settings.planner.max_blocks_per_s
    if rate is None or words is None:
        return 1
    spare = cut.wave.period_s * rate - cut.wave.knots_per_vibration
    return int(np.ceil(words.statements / spare)) if spare > 1e-6 else cut.wave.vibrations


class _Pattern(NamedTuple):
    """Vibrations of a pass, passes, and what their advance lacks in all to the exact one [steps]."""

    vibrations: int
    passes: int
    drift_steps: float


def _pattern(
    advance: Floats, vibrations: int, per_vibration: int, every: int, fewest: int
) -> _Pattern | None:
    """The pattern that leaves the fewest blocks; None when none saves any.

    ``advance`` [steps] of one vibration, (axes,).  A pattern without drift goes before a shorter one with it.
    """
    count = np.arange(every, vibrations // 2 + 1, every)
    count = count[count >= fewest]
    if not len(count):
        return None
    lacks = _lacks(count, advance)
    most = vibrations // count
    drifts = lacks * most > _NO_DRIFT_STEPS
    short = np.minimum(most, MOST_DRIFT_STEPS // np.maximum(lacks, _NO_DRIFT_STEPS / vibrations))
    passes = np.where(drifts, short, most).astype(int)
    left = _left(count, passes, vibrations)
    never = 2 * vibrations
    left = np.where((passes - 1) * count * per_vibration >= _LEAST_SAVED_BLOCKS, left, never)
    alike = ~drifts & (passes >= _FEWEST_PASSES_ALIKE)
    if (alike & (left < vibrations)).any():
        left = np.where(alike, left, never)
    best = int(left.argmin())
    if left[best] >= vibrations:
        return None
    drift = float(lacks[best] * passes[best]) if drifts[best] else 0.0
    return _Pattern(int(count[best]), int(passes[best]), drift)


def _lacks(count: NDArray[np.intp], advance: Floats) -> Floats:
    """What so many vibrations lack to whole steps, (n,)."""
    exact = np.outer(count, advance)
    lacks: Floats = np.abs(np.rint(exact) - exact).max(axis=1)
    return lacks


def _left(count: NDArray[np.intp], passes: NDArray[np.int_], vibrations: int) -> NDArray[np.intp]:
    """Vibrations to be written with as many such loops as there is room for, and the rest written out."""
    covered = count * np.maximum(passes, 1)
    left: NDArray[np.intp] = vibrations - vibrations // covered * (covered - count)
    return left


def _repeat(steps: Floats, exact_steps: Floats, start: int, pattern: _Pattern, per_vibration: int) -> None:
    """Put the points of all passes into ``steps``, the one that the first pass starts from included."""
    count, passes, _ = pattern
    knots = count * per_vibration
    exact = exact_steps[start + knots] - exact_steps[start]
    goes = np.rint(exact)
    lacks = goes - exact
    centred = np.rint(exact_steps[start + 1 : start + 1 + knots] - lacks * (passes - 2) / 2.0)
    gone = np.arange(passes)[:, np.newaxis, np.newaxis] * goes
    steps[start + 1 : start + 1 + passes * knots] = (centred + gone).reshape(-1, len(goes))
    steps[start] = centred[-1] - goes


def among_kept(loops: Sequence[Loop], keep: NDArray[np.bool_]) -> list[Loop]:
    """The same loops in blocks instead of knots, when knots that round to one point have gone.

    A pass that loses others than the first one does is written out.
    """
    block = np.cumsum(keep) - 1  # of a knot that stays: the block that begins there
    found = []
    for loop in loops:
        knots = keep[loop.first + 1 : loop.first + 1 + loop.count * loop.passes].reshape(loop.passes, -1)
        alike = (knots == knots[0]).all(axis=1)
        passes = loop.passes if alike.all() else int(alike.argmin())
        if passes > 1 and keep[loop.first]:
            first = int(block[loop.first])
            count = int(knots[0].sum())
            found.append(Loop(first, count, passes, loop.vibrations, loop.drift_steps))
    return found


def same_feeds(
    feeds: Floats, loops: Sequence[Loop], blocks: Blocks, law: ControlLaw, period_s: float
) -> None:
    """Give every pass of a loop the feeds of its second one, in place.

    The first pass may be reached with another feed than its own last one, which LinuxCNC remembers.
    Errors: VIB081 when a pass with these feeds would not take its time.
    """
    for loop in loops:
        passes = feeds[loop.first : loop.stop].reshape(loop.passes, loop.count)
        passes[:] = passes[1]
        two = slice(loop.first, loop.first + 2 * loop.count)
        run = blocks.part(two)
        places_mm = np.append(0.0, np.cumsum(run.lengths_mm))
        took_s = float(law.commanded_motion(places_mm, run, feeds[two]).spans_s[loop.count :].sum())
        wanted_s = loop.vibrations * period_s
        if abs(took_s - wanted_s) > PLANNED_TIME_SHARE * wanted_s:
            message = (
                f"a pass of {loop.vibrations} vibrations would take {took_s * MS_PER_S:.6g} ms"
                f" instead of {wanted_s * MS_PER_S:.6g}"
            )
            raise RefusalError("VIB081", message, 'take another f, or output.form "expanded"')
