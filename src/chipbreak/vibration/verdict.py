"""Does a motion break chips?  Uncut chip thickness with every earlier pass left on the part.

The tool position s(t) is piecewise linear between knots.  Each of z cutting edges meets the wall that the
passes m = 1, 2, ... before it left, so the thickness is h(t) = min over m of g_m(t) with
g_m(t) = s(t) - s(t - m T / z), T the time of a revolution; where h is not positive the tool cuts air and the
chip has ended (JP6416218B2, claim 3).  For a periodic wave the last pass (m = 1) alone decides whether h ever
reaches zero; for any motion g_1 <= 0 is enough.  Thickness is measured along the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from chipbreak.diagnostics import RefusalError
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.waveform import Waveform

Floats = npt.NDArray[np.float64]

_TOUCH = 1e-9  # a gap of less than this share of the feed is a touch, and a touch ends the chip
_FULL = 0.98  # return strokes of at least this share of the longest belong to the steady part
_SAMPLE_VIBRATIONS = 200  # how much of the steady part is worked out in full
_SAMPLE_POINTS = 60_000  # unless it has too many corners


@dataclass(frozen=True)
class Verdict:
    """What the chips of one cut will be.  "Steady" is the part of full stroke, "one edge" each of z.

    ``margin``: stroke / least stroke that breaks, for the weakest vibration of the steady part; precisely
    1 - (least gap g_1 of that vibration) / (feed / z), so ``breaks`` is the same as margin >= 1.
    ``per_rev`` and ``stroke_mm`` are as reached.  ``chips_per_rev`` and the chip lengths are of one edge, the
    longest one in the steady part (the whole cut when it does not break), the first one from the start of the
    cut to its first gap.  Lengths in mm are on the circumference, None without a diameter; the metal chip is
    shorter.  ``peak_thickness`` is in units of feed / z.  ``roughness_factor``: theoretical Rt against the
    same cut without vibration.  ``speed_band_rpm``: see :func:`speed_band_rpm`.
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
    roughness_factor: float
    peak_speed_mm_s: float
    speed_band_rpm: tuple[float, float] | None


@dataclass(frozen=True)
class _Motion:
    """Knots, and g_1 at the corners of both its curves: at the knots, and one pass after them."""

    time_s: Floats
    distance_mm: Floats
    pass_s: float
    touch_mm: float

    def at(self, time_s: Floats) -> Floats:
        return np.interp(time_s, self.time_s, self.distance_mm)

    def corner_gaps(self) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        gap_mm = self.distance_mm - self.at(self.time_s - self.pass_s)
        later_s = self.time_s + self.pass_s
        later_s = later_s[: np.searchsorted(later_s, self.time_s[-1], side="right")]
        return (self.time_s, gap_mm), (later_s, self.at(later_s) - self.distance_mm[: later_s.size])


def judge(
    time_s: Floats,
    distance_mm: Floats,
    *,
    speed_rpm: float,
    feed_mm_rev: float,
    edges: int = 1,
    diameter_mm: float | None = None,
    steady_s: tuple[float, float] | None = None,
    waveform: Waveform | None = None,
    alpha_share: float = 0.5,
) -> Verdict:
    """The verdict on knots of shape (n,) as they will really be run; time rises strictly.

    ``steady_s`` is the part of full stroke [s]; without it, it runs from the first to the last crest whose
    return stroke has at least 98 % of the longest.  Breaking is checked in every vibration of it, in O(n).
    Shares, lengths, thickness and roughness come from its last 200 vibrations (fewer when they have very many
    knots), worked out exactly: the steady part repeats.  ``waveform`` and ``alpha_share`` serve only the speed
    band.  Errors: VIB020 for arrays or values that cannot be.
    """
    _check(time_s, distance_mm, speed_rpm, feed_mm_rev, edges)
    rev_s = S_PER_MIN / speed_rpm
    feed_mm = feed_mm_rev / edges
    motion = _Motion(time_s, distance_mm, rev_s / edges, _TOUCH * feed_mm)
    crest, start_s, end_s = _steady_part(motion, steady_s)
    crest_s = time_s[crest]
    period_s = float(np.median(np.diff(crest_s))) if crest.size > 1 else math.inf
    gaps = motion.corner_gaps()
    # Once round, every pass of full stroke follows one of full stroke; a shorter steady part is taken whole.
    round_s = start_s + motion.pass_s
    begin_s = round_s if end_s - round_s >= min(period_s, motion.pass_s) else start_s
    margin = _margin(gaps, crest_s[crest_s >= begin_s], period_s, (begin_s, end_s), feed_mm)
    breaks = margin >= 1.0 - _TOUCH

    stroke_mm = _stroke(motion, crest, start_s, end_s, feed_mm_rev / rev_s)
    passes = math.floor(stroke_mm / feed_mm) + 1  # an older pass lies wholly behind the tool
    part = _sampled_part(motion, begin_s, end_s, period_s, passes)
    chips_per_s, cut_share, longest_s, peak_mm = _chips(motion, part, passes)
    whole_rev = float(time_s[-1] - time_s[0]) / rev_s
    longest_rev = longest_s / rev_s if breaks and longest_s else whole_rev
    first_rev = _first_chip(motion, gaps) / rev_s
    circumference_mm = None if diameter_mm is None else math.pi * diameter_mm
    per_rev = rev_s / period_s
    band = None
    if waveform is not None and per_rev > 0.0:
        band = speed_band_rpm(
            waveform, per_rev, 1.0 / period_s, stroke_mm / feed_mm_rev, alpha_share=alpha_share, edges=edges
        )
    return Verdict(
        breaks=breaks,
        margin=margin,
        per_rev=per_rev,
        stroke_mm=stroke_mm,
        chips_per_rev=chips_per_s * rev_s,
        longest_chip_rev=longest_rev,
        longest_chip_mm=None if circumference_mm is None else circumference_mm * longest_rev,
        first_chip_rev=first_rev,
        first_chip_mm=None if circumference_mm is None else circumference_mm * first_rev,
        cut_share=cut_share,
        peak_thickness=peak_mm / feed_mm,
        roughness_factor=(_widest_gap(motion, part) / feed_mm) ** 2,
        peak_speed_mm_s=float(np.abs(np.diff(distance_mm) / np.diff(time_s)).max()),
        speed_band_rpm=band,
    )


def speed_band_rpm(
    waveform: Waveform,
    per_rev: float,
    frequency_hz: float,
    stroke_ratio: float,
    *,
    alpha_share: float = 0.5,
    edges: int = 1,
) -> tuple[float, float] | None:
    """Lowest and highest spindle speed that still break at this frequency, with the same whole part of N / z.

    With rho = edges * ``stroke_ratio`` (stroke / feed per revolution) the fraction of N / z may lie in
    [(1 - alpha) / rho, 1 - alpha / rho] for the triangle, 0.5 +- arccos(1 / rho) / pi for the sine, and
    S = 60 f / N.  None when the stroke is too small at any speed (rho < 1).
    """
    rho = stroke_ratio * edges
    if rho < 1.0:
        return None
    if waveform == "sine":
        half = math.acos(1.0 / rho) / math.pi
        low, high = 0.5 - half, 0.5 + half
    else:
        low, high = (1.0 - alpha_share) / rho, 1.0 - alpha_share / rho
    whole = math.floor(per_rev / edges)
    most = S_PER_MIN * frequency_hz / edges
    return most / (whole + high), most / (whole + low)


def _steady_part(
    motion: _Motion, steady_s: tuple[float, float] | None
) -> tuple[npt.NDArray[np.intp], float, float]:
    """Indices of the crests (where the tool turns back) of the steady part, and its start and end [s]."""
    steps = np.diff(motion.distance_mm)
    moving = np.flatnonzero(steps)
    forward = steps[moving] > 0.0
    crest = moving[np.flatnonzero(forward[:-1] & ~forward[1:])] + 1
    trough = moving[np.flatnonzero(~forward[:-1] & forward[1:])] + 1
    first_s, last_s = float(motion.time_s[0]), float(motion.time_s[-1])
    if steady_s is not None:
        first_s, last_s = steady_s
    elif crest.size:
        low = np.append(trough[trough > crest[0]], motion.time_s.size - 1)[: crest.size]
        back_mm = motion.distance_mm[crest] - motion.distance_mm[low]
        full = np.flatnonzero(back_mm >= _FULL * back_mm.max())
        first_s, last_s = float(motion.time_s[crest[full[0]]]), float(motion.time_s[crest[full[-1]]])
    inside = (motion.time_s[crest] >= first_s) & (motion.time_s[crest] <= last_s)
    return crest[inside], first_s, last_s


def _margin(
    gaps: tuple[tuple[Floats, Floats], ...],
    crest_s: Floats,
    period_s: float,
    window_s: tuple[float, float],
    feed_mm: float,
) -> float:
    """1 - g / feed with g the least gap of the vibration, from crest to crest, that comes least near to air."""
    bounds = crest_s if crest_s.size > 1 else np.array(window_s)
    least = np.full(bounds.size - 1, np.inf)
    for corner_s, gap_mm in gaps:
        low, high = np.searchsorted(corner_s, bounds[0]), np.searchsorted(corner_s, bounds[-1], side="right")
        cells = np.searchsorted(corner_s[low:high], bounds[:-1])
        np.minimum(least, np.minimum.reduceat(np.append(gap_mm[low:high], np.inf), cells), out=least)
    margin = 1.0 - float(least.max()) / feed_mm
    # A stretch without a crest is a missing vibration; the touch that ends it elsewhere does not excuse it.
    stretches = np.diff(np.concatenate([window_s[:1], crest_s, window_s[1:]]))
    missing = crest_s.size == 0 or stretches.max() > 1.5 * period_s
    return 0.0 if missing and margin >= 1.0 - _TOUCH else margin


def _stroke(
    motion: _Motion, crest: npt.NDArray[np.intp], start_s: float, end_s: float, speed_mm_s: float
) -> float:
    """Peak to peak distance [mm] from the mean feed in the steady part; the crests tell the mean feed."""
    if crest.size > 1:
        rise = motion.distance_mm[crest[-1]] - motion.distance_mm[crest[0]]
        speed_mm_s = float(rise / (motion.time_s[crest[-1]] - motion.time_s[crest[0]]))
    inside = slice(*np.searchsorted(motion.time_s, [start_s, end_s]))
    ahead_mm = motion.distance_mm[inside] - speed_mm_s * motion.time_s[inside]
    return float(np.ptp(ahead_mm)) if ahead_mm.size else 0.0


def _sampled_part(
    motion: _Motion, begin_s: float, end_s: float, period_s: float, passes: int
) -> tuple[float, float]:
    """The end of the steady part that is worked out in full: its start and end [s]."""
    unit_s = motion.pass_s if math.isinf(period_s) else max(period_s, motion.pass_s)
    knots = int(np.diff(np.searchsorted(motion.time_s, [begin_s, end_s]))[0]) + 1
    affordable_s = (end_s - begin_s) * _SAMPLE_POINTS / (knots * (passes + 1) ** 2)
    length_s = max(4.0 * unit_s, min(_SAMPLE_VIBRATIONS * unit_s, affordable_s))
    return max(begin_s, end_s - length_s), end_s


def _chips(motion: _Motion, part: tuple[float, float], passes: int) -> tuple[float, float, float, float]:
    """Chips per second, share of time in the cut, longest chip [s] and greatest thickness [mm] in ``part``."""
    low, high = np.searchsorted(motion.time_s, [part[0] - passes * motion.pass_s, part[1]])
    shifts = motion.pass_s * np.arange(passes + 1)[:, np.newaxis]
    corners = (motion.time_s[low:high] + shifts).ravel()
    corners = np.unique(np.concatenate([part, corners[(corners > part[0]) & (corners < part[1])]]))
    gaps = motion.at(corners) - motion.at(corners - shifts[1:])
    peak_mm = _highest_minimum(gaps[:, :-1], gaps[:, 1:])
    # Between corners each gap is straight, so each is positive before or after one place, or throughout.
    left, right = gaps[:, :-1] - motion.touch_mm, gaps[:, 1:] - motion.touch_mm
    with np.errstate(divide="ignore", invalid="ignore"):
        place = left / (left - right)
    enter = np.where(left > 0.0, 0.0, np.where(right > 0.0, place, 1.0)).max(axis=0)
    leave = np.where(right > 0.0, 1.0, np.where(left > 0.0, place, 0.0)).min(axis=0)
    cuts = leave > enter
    step_s = np.diff(corners)
    goes_on = cuts[:-1] & cuts[1:] & (leave[:-1] == 1.0) & (enter[1:] == 0.0)
    starts = np.flatnonzero(cuts & ~np.append(False, goes_on))
    stops = np.flatnonzero(cuts & ~np.append(goes_on, False))
    start_s = corners[starts] + enter[starts] * step_s[starts]
    chip_s = corners[stops] + leave[stops] * step_s[stops] - start_s
    if starts.size < 3:  # hardly a chip ended: it is one long one
        in_cut_s = float(chip_s.sum())
        return 0.0, in_cut_s / (part[1] - part[0]), 0.0, peak_mm
    # The first chip began before the part and the last one ends after it: neither counts.
    span_s = float(start_s[-1] - start_s[1])
    whole_s = chip_s[1:-1]
    return whole_s.size / span_s, float(whole_s.sum()) / span_s, float(whole_s.max()), peak_mm


def _highest_minimum(left: Floats, right: Floats) -> float:
    """Greatest value of the least of straight lines, each given at both ends of n segments: shapes (m, n)."""
    best = float(np.append(left, right[:, -1:], axis=1).min(axis=0).max())
    # Above the corners it can only stand where two of the lines cross.
    promising = np.maximum(left, right).min(axis=0) > best
    left, rise = left[:, promising], (right - left)[:, promising]
    for m in range(1, left.shape[0]):
        with np.errstate(divide="ignore", invalid="ignore"):
            place = (left[m] - left[:m]) / (rise[:m] - rise[m])
        place = np.where((place > 0.0) & (place < 1.0), place, 0.0)
        for row in place:
            best = max(best, float((left + row * rise).min(axis=0).max(initial=best)))
    return best


def _first_chip(motion: _Motion, gaps: tuple[tuple[Floats, Floats], ...]) -> float:
    """Time [s] from the first knot to the first gap; the whole motion when there is none.

    Only the last pass is asked, so while the stroke still grows the answer is never too short.
    """
    begun_mm = motion.distance_mm[0] + motion.touch_mm
    before = (float(motion.time_s[0]), math.inf)
    hits = []
    for corner_s, gap_mm in gaps:
        air = np.flatnonzero((gap_mm <= motion.touch_mm) & (motion.at(corner_s) > begun_mm))
        if air.size:
            hits.append((float(corner_s[air[0]]), float(gap_mm[air[0]])))
    if not hits:
        return float(motion.time_s[-1] - motion.time_s[0])
    hit_s, hit_mm = min(hits)
    for corner_s, gap_mm in gaps:
        index = int(np.searchsorted(corner_s, hit_s)) - 1
        if index >= 0:
            before = max(before, (float(corner_s[index]), float(gap_mm[index])))
    before_s, before_mm = before
    drop_mm = before_mm - hit_mm
    share = (before_mm - motion.touch_mm) / drop_mm if 0.0 < drop_mm < math.inf else 1.0
    return before_s + min(max(share, 0.0), 1.0) * (hit_s - before_s) - float(motion.time_s[0])


def _widest_gap(motion: _Motion, part: tuple[float, float]) -> float:
    """Largest distance [mm] between neighbouring tool positions at one angle, over all angles.

    Rt = gap ** 2 / (8 nose radius).  Positions near the ends of ``part`` lack neighbours and are left out.
    """
    passes = max(2, math.floor((part[1] - part[0]) / motion.pass_s))
    turn_s = part[0] + motion.pass_s * np.arange(passes)[:, np.newaxis]
    edge = np.searchsorted(motion.time_s, [part[0] + motion.pass_s, part[1] - motion.pass_s])
    floor_mm = motion.distance_mm[: edge[0]].max(initial=-np.inf)
    ceiling_mm = motion.distance_mm[edge[1] :].min(initial=np.inf)

    def widest(angle_s: Floats) -> tuple[float, float]:
        place = np.sort(motion.at(turn_s + angle_s), axis=0)
        gap = np.diff(place, axis=0)
        known = (place[:-1] >= floor_mm) & (place[1:] <= ceiling_mm)
        column = np.where(known, gap, 0.0).max(axis=0) if known.any() else gap.max(axis=0)
        best = int(column.argmax())
        return float(column[best]), float(angle_s[best])

    grid_s = np.linspace(0.0, motion.pass_s, 1025)
    coarse_mm, angle_s = widest(grid_s)
    return max(coarse_mm, widest(angle_s + np.linspace(-grid_s[1], grid_s[1], 129))[0])


def _check(
    time_s: Floats, distance_mm: Floats, speed_rpm: float, feed_mm_rev: float, edges: int
) -> None:
    ok = time_s.ndim == 1 and time_s.shape == distance_mm.shape and time_s.size >= 2
    ok = ok and bool(np.isfinite(time_s).all() and np.isfinite(distance_mm).all() and (np.diff(time_s) > 0.0).all())
    if not ok:
        raise RefusalError("VIB020", "the motion needs two knots or more, each later than the last", "report this")
    if not (0.0 < speed_rpm < math.inf and 0.0 < feed_mm_rev < math.inf and edges >= 1):
        raise RefusalError("VIB020", "speed, feed and edges must be above zero", "give S, F and EDGES")
