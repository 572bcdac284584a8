"""Does a motion break chips?  Uncut chip thickness with every earlier pass left on the part.

The tool position s(t) is piecewise linear between knots.  Each of z cutting edges meets the wall that the
passes m = 1, 2, ... before it left, so the thickness is h(t) = min over m of g_m(t) with
g_m(t) = s(t) - s(t - m T / z), T the time of a revolution; where h is not positive the tool cuts air and the
chip has ended (JP6416218B2, claim 3).  For a periodic wave the last pass (m = 1) alone decides whether h ever
reaches zero; for any motion g_1 <= 0 is enough.  Thickness is measured along the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
import numpy.typing as npt

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.piecewise import Gaps, Motion, Rests, mean_step_s, rests_of
from chipbreak.kinematics.remembered import remembered
from chipbreak.kinematics.waveform import speed_band_rpm
from chipbreak.kinematics.waves import wave_named
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

_TOUCH = 1e-9  # a gap below this share of the feed is a touch, and a touch ends the chip
_FULL = 0.98  # return strokes of at least this share of the longest belong to the steady part
_EDGE = 0.01  # a crest that rounding has moved this share of a pass out of the steady part is still in it
_SAMPLE_UNITS = 200  # vibrations or revolutions worked out in full
_SAMPLE_POINTS = 60_000  # corners in them
_MOST_GAPS = 1_000_000  # in one vibration or revolution, to each older pass from each corner
_CRESTS_AT_ONCE = 1 << 12
_ROUGHNESS_PASSES = 60
_ROUGHNESS_ANGLES = 1025


@dataclass(frozen=True)
class Verdict:
    """What the chips of one cut will be.  "Steady" is the part of full stroke, "one edge" each of z.

    ``margin``: stroke / least stroke that breaks, for the weakest vibration of the steady part; precisely
    1 - (least gap g_1 of that vibration) / (feed / z as reached), so ``breaks`` is the same as margin >= 1.
    Of a dwell it is the shortest stand in revolutions (per edge).
    ``per_rev`` and ``stroke_mm`` are as reached (N is 0 when the tool never turns back, which cannot break);
    the stroke is that of the middle one of all vibrations.
    Chips are those of one edge: the longest in the steady part (the whole cut when it does not break), the
    first from the start of the cut to its first gap; in mm on the circumference, None without a diameter.
    ``peak_thickness`` is in feed / z, that of the steady part; ``ramp_peak_thickness`` is that of the rest,
    where a pass meets one of another stroke.  ``roughness_factor`` is Rt against the cut without vibration.
    """

    breaks: bool
    margin: float
    per_rev: float
    stroke_mm: float
    chips_per_rev: float
    longest_chip_rev: float
    longest_chip_mm: float | None
    first_chip_rev: float
    first_chip_mm: float | None
    cut_share: float
    peak_thickness: float
    ramp_peak_thickness: float
    roughness_factor: float
    peak_speed_mm_s: float
    speed_band_rpm: tuple[float, float] | None


@dataclass(frozen=True)
class _Steady:
    """The part of full stroke: crests (indices of knots), ends, begin of judging, mean feed as reached."""

    crest: npt.NDArray[np.intp]
    start_s: float
    begin_s: float
    end_s: float
    period_s: float
    speed_mm_s: float


def judge(
    time_s: Floats,
    distance_mm: Floats,
    *,
    speed_rpm: float,
    feed_mm_rev: float,
    edges: int = 1,
    diameter_mm: float | None = None,
    steady_s: tuple[float, float] | None = None,
    waveform: str | None = None,
    alpha_share: float = 0.5,
    vibration_s: float | None = None,
    meant_s: tuple[Floats, Floats] | None = None,
) -> Verdict:
    """The verdict on knots of shape (n,) as they will really be run; time rises strictly.

    ``steady_s`` is the part of full stroke [s]; without it, it runs from the first to the last crest whose
    return stroke has at least 98 % of the longest.  Breaking is checked in every vibration of it, in O(n).
    The rest comes from its last 200 vibrations or revolutions (fewer when they have very many knots), worked
    out exactly: it repeats.  Where the wave never turns back,
    its rests are judged; else ``waveform`` and ``alpha_share`` serve only the speed band.  ``vibration_s`` is
    how long a vibration was meant to take: of a tool that never turns back nothing else tells its mean speed.
    ``meant_s`` are moments of the motion and when they were meant to be, (k,) each: what is late is told from
    what is missing by them.
    Errors: VIB020.
    """
    _check(time_s, distance_mm, speed_rpm, feed_mm_rev, edges)
    turning = _Turning(speed_rpm, feed_mm_rev, edges)
    wave = _Wave(waveform, alpha_share, vibration_s, steady_s, meant_s)
    verdict = _judged(time_s, distance_mm, turning, wave)
    around_mm = None if diameter_mm is None else math.pi * diameter_mm
    return replace(
        verdict,
        longest_chip_mm=around_mm and around_mm * verdict.longest_chip_rev,
        first_chip_mm=around_mm and around_mm * verdict.first_chip_rev,
    )


def weakest_margin(
    time_s: Floats,
    distance_mm: Floats,
    *,
    speed_rpm: float,
    feed_mm_rev: float,
    edges: int = 1,
    steady_s: tuple[float, float] | None = None,
    waveform: str | None = None,
    vibration_s: float | None = None,
    meant_s: tuple[Floats, Floats] | None = None,
) -> float:
    """The margin of :func:`judge` alone, for who tries one stroke after the other."""
    _check(time_s, distance_mm, speed_rpm, feed_mm_rev, edges)
    turning = _Turning(speed_rpm, feed_mm_rev, edges)
    return _seen(time_s, distance_mm, turning, _Wave(waveform, 0.0, vibration_s, steady_s, meant_s)).margin()


class _Turning(NamedTuple):
    """How fast the work turns, and what is fed in a revolution of so many edges."""

    speed_rpm: float
    feed_mm_rev: float
    edges: int


class _Wave(NamedTuple):
    """What is known of the vibration, see :func:`judge`."""

    waveform: str | None
    alpha_share: float
    vibration_s: float | None
    steady_s: tuple[float, float] | None
    meant_s: tuple[Floats, Floats] | None


@remembered
def _judged(time_s: Floats, distance_mm: Floats, turning: _Turning, wave: _Wave) -> Verdict:
    """See :func:`judge`; without a diameter."""
    speed_rpm, feed_mm_rev, edges = turning
    waveform, alpha_share = wave.waveform, wave.alpha_share
    seen = _seen(time_s, distance_mm, turning, wave)
    motion, rests, steady = seen
    rev_s = S_PER_MIN / speed_rpm
    feed_mm = feed_mm_rev / edges
    margin = seen.margin()
    breaks = margin >= 1.0 - _TOUCH
    reach_mm = _reach(motion, steady)
    stroke_mm = reach_mm if rests is not None else _stroke(motion, steady, reach_mm)
    passes = math.floor(reach_mm / feed_mm) + 1  # an older pass lies wholly behind the tool
    passes = min(passes, _most_passes(motion, steady))
    if rests is None and bool((distance_mm[1:] >= distance_mm[:-1]).all()):
        passes = 1  # it never turns back, so every pass lies behind the one that follows it
    chips_per_s, cut_share, longest_s, peak_mm = _chips(motion, _sampled_part(motion, steady, passes), passes)
    longest_rev = (longest_s if breaks else float(time_s[-1] - time_s[0])) / rev_s
    first_rev = _first_chip(motion) / rev_s
    per_rev = rev_s / steady.period_s
    ratio = stroke_mm / (steady.speed_mm_s * rev_s)
    band = None
    if waveform is not None and rests is None and per_rev > 0.0:
        band = speed_band_rpm(waveform, speed_rpm, per_rev, ratio, alpha_share=alpha_share, edges=edges)
    return Verdict(
        breaks=breaks,
        margin=margin,
        per_rev=per_rev,
        stroke_mm=stroke_mm,
        chips_per_rev=chips_per_s * rev_s,
        longest_chip_rev=longest_rev,
        longest_chip_mm=None,
        first_chip_rev=first_rev,
        first_chip_mm=None,
        cut_share=cut_share,
        peak_thickness=peak_mm / feed_mm,
        ramp_peak_thickness=_ramp_peak_mm(motion, steady, passes) / feed_mm,
        # No ridge is higher than the thickest chip, which stands in where the part is too short to tell.
        roughness_factor=((_widest_gap(motion, steady, passes) or peak_mm) / feed_mm) ** 2,
        peak_speed_mm_s=motion.peak_speed_mm_s(),
        speed_band_rpm=band,
    )


class _Seen(NamedTuple):
    """A motion, where the tool rests if it never turns back, and its part of full stroke."""

    motion: Motion
    rests: Rests | None
    steady: _Steady

    def margin(self) -> float:
        """That of the weakest vibration, see :class:`Verdict`."""
        if self.rests is None:
            return _margin(self.motion, self.steady)
        return self.rests.shortest_s(self.steady.crest) / self.motion.pass_s


def _seen(time_s: Floats, distance_mm: Floats, turning: _Turning, wave: _Wave) -> _Seen:
    speed_rpm, feed_mm_rev, edges = turning
    rev_s = S_PER_MIN / speed_rpm
    motion = Motion(time_s, distance_mm, rev_s / edges, _TOUCH * (feed_mm_rev / edges))
    turns_back = wave.waveform is None or wave_named(wave.waveform).turns_back
    rests = None if turns_back else rests_of(time_s, distance_mm, motion.touch_mm)
    steady = _steady_part(motion, wave.steady_s, feed_mm_rev / rev_s, rests)
    steady = _as_meant(steady, motion, wave.vibration_s, wave.meant_s)
    if rests is None and steady.crest.size <= 1 and wave.vibration_s is not None:
        steady = replace(steady, speed_mm_s=_mean_speed_mm_s(motion, steady, wave.vibration_s))
    return _Seen(motion, rests, steady)


def _steady_part(
    motion: Motion, steady_s: tuple[float, float] | None, speed_mm_s: float, rests: Rests | None
) -> _Steady:
    crest, trough = motion.reversals()
    crest = crest if rests is None else rests.begin  # a tool that never turns back comes to rest
    start_s, end_s = steady_s or (float(motion.time_s[0]), float(motion.time_s[-1]))
    if steady_s is None and crest.size:
        low = np.append(trough[trough > crest[0]], motion.time_s.size - 1)[: crest.size]
        back_mm = motion.distance_mm[crest] - motion.distance_mm[low]
        # A tool that never turns back has no return stroke: of its rests each counts.
        full = np.flatnonzero((back_mm >= _FULL * back_mm.max()) | (rests is not None))
        start_s, end_s = (float(t) for t in motion.time_s[crest[full[[0, -1]]]])
    crest = crest[(motion.time_s[crest] >= start_s) & (motion.time_s[crest] <= end_s)]
    period_s = math.inf
    if crest.size > 1:
        period_s = mean_step_s(motion.time_s[crest])
        moved_mm = float(np.ptp(motion.distance_mm[crest[[0, -1]]]))
        speed_mm_s = moved_mm / float(np.ptp(motion.time_s[crest[[0, -1]]])) or speed_mm_s
    # After one pass, every pass of full stroke follows one of full stroke; a shorter part is taken whole.
    begin_s = start_s + motion.pass_s
    if end_s - begin_s < min(period_s, motion.pass_s):
        begin_s = start_s
    return _Steady(crest, start_s, begin_s, end_s, period_s, speed_mm_s)


def _as_meant(
    steady: _Steady, motion: Motion, vibration_s: float | None, meant_s: tuple[Floats, Floats] | None
) -> _Steady:
    """The same part with the period of as many vibrations as were meant to be in it."""
    if steady.crest.size < 2 or vibration_s is None or meant_s is None:
        return steady
    crest_s = motion.time_s[steady.crest]
    vibrations = float(np.ptp(np.interp(crest_s[[0, -1]], *meant_s))) / vibration_s
    return replace(steady, period_s=mean_step_s(crest_s, vibrations))


def _mean_speed_mm_s(motion: Motion, steady: _Steady, vibration_s: float) -> float:
    """The mean speed over as many whole vibrations as there are.

    The programmed one where there is none, or the tool only stands there: what is fed is told by neither.
    """
    whole_s = math.floor((steady.end_s - steady.start_s) / vibration_s + _EDGE) * vibration_s
    if whole_s <= 0.0:
        return steady.speed_mm_s
    ends_mm = motion.at(np.array([steady.end_s - whole_s, steady.end_s]))
    return max(float(ends_mm[1] - ends_mm[0]), 0.0) / whole_s or steady.speed_mm_s


def _margin(motion: Motion, steady: _Steady) -> float:
    """1 - g / feed, g the least gap of that vibration (crest to crest) which comes least near to air."""
    pass_s = motion.pass_s
    window_s = np.array([steady.begin_s, steady.end_s])
    crest_s = motion.time_s[steady.crest]
    crest_s = crest_s[crest_s >= steady.begin_s - _EDGE * pass_s]
    bounds = crest_s if crest_s.size > 1 else window_s
    least = np.full(bounds.size - 1, np.inf)
    for corner_s, gap_mm in chain.from_iterable(motion.corner_gaps()):
        inside = slice(np.searchsorted(corner_s, bounds[0]), np.searchsorted(corner_s, bounds[-1], "right"))
        _lower(least, bounds[1:-1], corner_s[inside], gap_mm[inside])
    worst_mm = float(least.max())
    if math.isinf(worst_mm):
        return 0.0  # nothing turns back there
    margin = 1.0 - worst_mm / (steady.speed_mm_s * pass_s)
    # A stretch without a crest is a missing vibration; the touch that ends it elsewhere does not excuse it.
    stretch_s = np.diff(np.insert(window_s, 1, crest_s)).max()
    missing = crest_s.size == 0 or stretch_s > 1.5 * steady.period_s
    return 0.0 if missing and margin >= 1.0 - _TOUCH else margin


def _lower(least: Floats, between: Floats, at: Floats, values: Floats) -> None:
    """Change ``least``, (n + 1,), to the least of the values in each cell.

    ``between`` (n,) are the places between cells, ``at`` those of the values, (m,) each; all of them rise.
    """
    if not at.size:
        return
    low, high = np.searchsorted(between, at[[0, -1]], "right").tolist()
    # The cells are far fewer than the values, so these are not looked for one by one.
    starts = np.append(0, np.searchsorted(at, between[low:high]))
    is_filled = np.diff(starts, append=at.size) > 0
    own = np.flatnonzero(is_filled) + low
    least[own] = np.minimum(least[own], np.minimum.reduceat(values, starts[is_filled]))


def _reach(motion: Motion, steady: _Steady) -> float:
    """Peak to peak distance [mm] from the mean feed in the steady part, with what is late at corners."""
    low, high = np.searchsorted(motion.time_s, [steady.start_s, steady.end_s]).tolist()
    parts = (
        _ahead_mm(motion, steady, some) for some in motion.pieces(low, min(high + 1, motion.time_s.size))
    )
    ends_mm = [(float(part.min()), float(part.max())) for part in parts]
    return max(top for _, top in ends_mm) - min(bottom for bottom, _ in ends_mm)


def _stroke(motion: Motion, steady: _Steady, reach_mm: float) -> float:
    """Peak to peak distance [mm] from the mean feed of the middle one of all vibrations of the steady part.

    Where rounding makes wrinkles, these are no vibrations.
    """
    if steady.crest.size < 3:
        return reach_mm
    parts = range(0, steady.crest.size - 1, _CRESTS_AT_ONCE)
    sizes_mm = np.concatenate([_strokes(motion, steady, first) for first in parts])
    return float(np.median(sizes_mm[sizes_mm >= sizes_mm.max() / 2.0]))


def _strokes(motion: Motion, steady: _Steady, first: int) -> Floats:
    """The strokes [mm] of some vibrations from the crest of number ``first`` on."""
    crest = steady.crest[first : first + _CRESTS_AT_ONCE + 1]
    ahead_mm = _ahead_mm(motion, steady, slice(int(crest[0]), int(crest[-1]) + 1))
    starts = crest[:-1] - crest[0]
    # From the higher of its two crests, as rounding leaves them.
    highest_mm = np.maximum(np.maximum.reduceat(ahead_mm, starts), ahead_mm[crest[1:] - crest[0]])
    sizes_mm: Floats = highest_mm - np.minimum.reduceat(ahead_mm, starts)
    return sizes_mm


def _ahead_mm(motion: Motion, steady: _Steady, knots: slice) -> Floats:
    """How far the tool is ahead of the mean feed at some knots."""
    ahead_mm: Floats = motion.distance_mm[knots] - steady.speed_mm_s * motion.time_s[knots]
    return ahead_mm


def _most_passes(motion: Motion, steady: _Steady) -> int:
    """As many as can be looked at: a tool that is late at corners may reach thousands of feeds far.

    Where older ones are left out, metal counts that they have taken: chips are said to be thicker than they
    are, and never thinner.
    """
    low, high = np.searchsorted(motion.time_s, [steady.end_s - _unit_s(motion, steady), steady.end_s])
    return max(math.isqrt(_MOST_GAPS // int(high - low + 1)), 1)


def _unit_s(motion: Motion, steady: _Steady) -> float:
    """A revolution or a vibration, whichever is longer: behind it all comes again."""
    return max(motion.pass_s, steady.period_s if steady.crest.size > 1 else 0.0)


def _sampled_part(motion: Motion, steady: _Steady, passes: int) -> tuple[float, float]:
    """The end of the steady part that is worked out in full: its start and end [s]."""
    begin_s = steady.begin_s
    end_s = steady.end_s
    unit_s = _unit_s(motion, steady)
    settled_s = begin_s + (passes - 1) * motion.pass_s
    if end_s - settled_s > 3.0 * unit_s:  # room enough to wait until all older passes were full too
        begin_s = settled_s
    low, high = np.searchsorted(motion.time_s, [begin_s, end_s])
    affordable_s = (end_s - begin_s) * _SAMPLE_POINTS / float((high - low + 1) * (passes + 1) ** 2)
    length_s = max(4.0 * unit_s, min(_SAMPLE_UNITS * unit_s, affordable_s))
    begin_s = max(begin_s, end_s - length_s)
    whole = (end_s - begin_s) / steady.period_s + _EDGE  # half of a few is a large share
    return (end_s - math.floor(whole) * steady.period_s if 1.0 <= whole < 4.0 else begin_s), end_s


def _chips(motion: Motion, part: tuple[float, float], passes: int) -> tuple[float, float, float, float]:
    """Chips per second, share of time in the cut, longest chip [s] and greatest thickness [mm]."""
    corners, peak_mm, enter, leave = motion.thickness(part, passes)
    cuts = leave > enter
    step_s = np.diff(corners)
    goes_on = cuts[:-1] & cuts[1:] & (leave[:-1] == 1.0) & (enter[1:] == 0.0)
    starts = np.flatnonzero(cuts & ~np.append(False, goes_on))
    stops = np.flatnonzero(cuts & ~np.append(goes_on, False))
    start_s = corners[starts] + enter[starts] * step_s[starts]
    chip_s = corners[stops] + leave[stops] * step_s[stops] - start_s
    if starts.size < 3:  # too few to tell whole chips from those that the ends of the part cut off
        ended = int((start_s + chip_s < part[1]).sum())
        span_s = part[1] - part[0]
    else:
        ended = starts.size - 2
        span_s = float(start_s[-1] - start_s[1])
        chip_s = chip_s[1:-1]
    return ended / span_s, float(chip_s.sum()) / span_s, float(chip_s.max(initial=0.0)), peak_mm


def _ramp_peak_mm(motion: Motion, steady: _Steady, passes: int) -> float:
    """Greatest thickness while older passes are not yet those of the steady part, and behind it."""
    begin_s = float(motion.time_s[0])
    end_s = float(motion.time_s[-1])
    grown_s = min(steady.begin_s + passes * motion.pass_s, end_s)
    parts = [part for part in ((begin_s, grown_s), (steady.end_s, end_s)) if part[1] > part[0]]
    peak_mm = -math.inf
    for part in parts:
        peak_mm = motion.peak_thickness(part, passes, peak_mm)
    return peak_mm if parts else 0.0


def _first_chip(motion: Motion) -> float:
    """Time [s] from the first knot to the first gap; the whole motion when there is none.

    Only the last pass is asked, so while the stroke still grows the answer is never too short.
    """
    start_s = float(motion.time_s[0])
    hit_s = min(_first_hit_s(motion, gaps) for gaps in motion.corner_gaps())
    if math.isinf(hit_s):
        return float(motion.time_s[-1]) - start_s
    # The gap closes on the straight piece between the corner found and the one before it.
    before_s = motion.corner_before(hit_s)
    ends_s = np.array([before_s, hit_s])
    before_mm, hit_mm = motion.at(ends_s) - motion.at(ends_s - motion.pass_s) - motion.touch_mm
    closes_s = hit_s if before_mm <= 0.0 else before_s + before_mm / (before_mm - hit_mm) * (hit_s - before_s)
    return float(closes_s) - start_s


def _first_hit_s(motion: Motion, gaps: Gaps) -> float:
    """The first time of some gaps at which the tool touches nothing; infinite where there is none."""
    begun_mm = motion.distance_mm[0] + motion.touch_mm
    for corner_s, gap_mm in gaps:
        air = np.flatnonzero((gap_mm <= motion.touch_mm) & (motion.at(corner_s) > begun_mm))
        if air.size:
            return float(corner_s[air[0]])
    return math.inf


def _widest_gap(motion: Motion, steady: _Steady, passes: int) -> float:
    """Largest distance [mm] between neighbouring tool positions at one angle, over all angles.

    Rt = gap ** 2 / (8 nose radius).  Positions that a pass before or after those looked at may come between
    are left out; 0 when that leaves none.
    """
    most = math.floor((steady.end_s - steady.begin_s) / motion.pass_s)
    count = max(2, min(_ROUGHNESS_PASSES + 2 * passes, most))
    turn_s = steady.end_s - motion.pass_s * np.arange(count, 0, -1)[:, np.newaxis]
    turns_s = [turn_s[0, 0], turn_s[0, 0] + motion.pass_s, turn_s[-1, 0], steady.end_s]
    low, after, until, high = np.searchsorted(motion.time_s, turns_s)
    floor_mm = motion.distance_mm[low:after].max(initial=-np.inf)
    ceiling_mm = motion.distance_mm[until:high].min(initial=np.inf)

    def widest(angle_s: Floats) -> tuple[float, float]:
        place = np.sort(motion.at(turn_s + angle_s), axis=0)
        known = (place[:-1] >= floor_mm) & (place[1:] <= ceiling_mm)
        column = np.where(known, np.diff(place, axis=0), 0.0).max(axis=0)
        best = int(column.argmax())
        return float(column[best]), float(angle_s[best])

    grid_s = np.linspace(0.0, motion.pass_s, _ROUGHNESS_ANGLES)
    coarse_mm, angle_s = widest(grid_s)
    return max(coarse_mm, widest(angle_s + np.linspace(-grid_s[1], grid_s[1], 129))[0])


def _check(time_s: Floats, distance_mm: Floats, speed_rpm: float, feed_mm_rev: float, edges: int) -> None:
    rises = time_s.ndim == 1 and time_s.size >= 2 and bool((time_s[1:] > time_s[:-1]).all())
    if not (rises and time_s.shape == distance_mm.shape and np.isfinite(distance_mm.sum() + time_s[-1])):
        raise RefusalError("VIB020", "a motion needs two knots or more, in rising time", "check the times")
    if not (0.0 < speed_rpm < math.inf and 0.0 < feed_mm_rev < math.inf and edges >= 1):
        raise RefusalError("VIB020", "speed, feed and edges must be above zero", "give S, F and EDGES")
