"""The motion of one vibrated cut as knots of distance against time.

The displacement lies ahead of the mean feed: s(t) = v t + y(t) P w(tau), with v the feed speed, P the stroke
peak to peak, tau the time within one vibration and w between 0 and 1, w(0) = 0.  So no knot ever lies before
the start, and y keeps every knot from passing the end.  ``w`` is that of a wave (``kinematics.waves``).
Between knots the motion is straight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.remembered import remembered
from chipbreak.kinematics.sourced_value import shown
from chipbreak.kinematics.speed_solver import never_breaks
from chipbreak.kinematics.waves import FUZZ, Wave, wave_named
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import S_PER_MIN

TOO_SHORT = "VIB013"
_OVERRIDE_STEP = 0.0025
_LEAST_OVERRIDE = 0.05
_MOST_OVERRIDE = 2.0


@dataclass(frozen=True)
class WaveformParameters:
    """One vibrated cut; a vibration lasts ``period_s``, which is ``ticks`` base periods.

    ``forward_ticks`` of them go forward (triangle), see :func:`forward_ticks`.  ``stroke_mm`` is peak to peak
    about the mean feed.  It grows over ``ramp_in_s`` as x ** ``ramp_exponent`` (claim 9), shrinks the same
    way, and at least the last ``end_revolutions`` are plain feed.  ``form`` "tick" gives one knot per base
    period, "stroke" one per end of a forward or return stroke.  Errors: VIB010 for values that cannot be,
    VIB011 for a sine in "stroke" form.
    """

    length_mm: float
    feed_mm_rev: float
    speed_rpm: float
    period_s: float
    ticks: int
    forward_ticks: int
    stroke_mm: float
    waveform: str = "triangle"
    ramp_in_s: float = 0.0
    ramp_exponent: float = 1.0
    end_revolutions: float = 1.0
    form: Literal["tick", "stroke"] = "tick"

    def __post_init__(self) -> None:
        for name in ("length_mm", "feed_mm_rev", "speed_rpm", "period_s", "stroke_mm", "ramp_exponent"):
            _require(0.0 < getattr(self, name) < math.inf, name, getattr(self, name), "above zero")
        for name in ("ramp_in_s", "end_revolutions"):
            _require(0.0 <= getattr(self, name) < math.inf, name, getattr(self, name), "zero or more")
        inside = 0 < self.forward_ticks < self.ticks
        _require(inside, "forward_ticks", self.forward_ticks, f"between 0 and {self.ticks} ticks")
        self.shape.refuse_form(self.form)

    @property
    def shape(self) -> Wave:
        """The wave."""
        return wave_named(self.waveform)

    @property
    def alpha_share(self) -> float:
        """The forward share of one vibration that whole ticks allow; a sine is even."""
        return self.shape.share(self.forward_ticks, self.ticks)

    @property
    def speed_mm_s(self) -> float:
        """The mean feed speed v."""
        return self.feed_speed_mm_s * self.shape.speed_share(self.alpha_share)

    @property
    def feed_speed_mm_s(self) -> float:
        """The programmed feed as a speed."""
        return self.feed_mm_rev * self.speed_rpm / S_PER_MIN

    @property
    def duration_s(self) -> float:
        """The time of the motion: the same as without vibration, or longer by all its dwells."""
        return self.length_mm / self.feed_speed_mm_s + self.shape.standing_s(self)

    @property
    def vibrations(self) -> int:
        """Whole vibrations that fit before the plain revolutions at the end."""
        return self.shape.vibrations(self)

    @property
    def knots_per_vibration(self) -> int:
        """How many knots of the motion one vibration has."""
        return 2 if self.form == "stroke" else self.ticks

    @property
    def moves_per_vibration(self) -> int:
        """How many blocks of motion one vibration has."""
        return self.shape.moves(self.knots_per_vibration)


def forward_ticks(ticks: int, alpha_share: float, *, rounds_down: bool = False) -> int:
    """Whole base periods of the forward stroke, 1 to ``ticks`` - 1, nearest ``alpha_share`` of the vibration.

    At a tie the forward stroke gets the longer part, so that it is never the faster one.  A tool that dwells
    for the rest must not do so for less: ``rounds_down``.  Errors: VIB010.

    >>> forward_ticks(4, 0.75), forward_ticks(5, 0.5)
    (3, 3)
    """
    _require(0.0 < alpha_share < 1.0, "forward share", alpha_share, "between 0 and 1")
    _require(ticks >= 2, "base periods in one vibration", ticks, "2 or more")
    half = 0.0 if rounds_down else 0.5
    return min(max(math.floor(alpha_share * ticks + half + FUZZ), 1), ticks - 1)


def largest_drop(
    waveform: str, per_rev: float, alpha_share: float = 0.5, edges: int = 1, ticks: int | None = None
) -> float:
    """D: by how much of the stroke the last pass can lie ahead; the chip breaks when P D >= feed / edges.

    It follows from the fraction of N / edges, see the waves.  ``ticks`` are those of a vibration of so few
    that its corners matter.  Earlier passes never lie further ahead, for D(m delta) <= m D(delta).
    """
    return wave_named(waveform).largest_drop(per_rev / edges % 1.0, alpha_share, ticks)


def least_stroke_mm(
    waveform: str,
    per_rev: float,
    feed_mm_rev: float,
    *,
    alpha_share: float = 0.5,
    edges: int = 1,
    margin: float = 1.2,
    ticks: int | None = None,
) -> float:
    """The stroke [mm, peak to peak] that breaks chips with ``margin``: P D = margin * feed / edges.

    ``alpha_share`` is the real forward share (whole ticks), unused for a sine; ``ticks`` as for
    :func:`largest_drop`.  Errors: VIB010 for values that cannot be, VIB012 when N / edges is whole, where no
    stroke is large enough.
    """
    _require(0.0 < per_rev < math.inf, "N", per_rev, "above zero")
    _require(0.0 < feed_mm_rev < math.inf, "feed per revolution", feed_mm_rev, "above zero")
    _require(0.0 < alpha_share < 1.0, "forward share", alpha_share, "between 0 and 1")
    _require(0.0 < margin < math.inf, "margin", margin, "above zero")
    if never_breaks(per_rev, edges):
        what = f"N {shown(per_rev)}" + (f" / {edges} edges" if edges > 1 else "")
        way_out = f"take N {shown(per_rev + edges / 2)}, or another that is not whole"
        raise RefusalError("VIB012", f"{what} is a whole number: no stroke breaks the chip", way_out)
    return margin * feed_mm_rev / edges / largest_drop(waveform, per_rev, alpha_share, edges, ticks)


def speed_band_rpm(
    waveform: str,
    speed_rpm: float,
    per_rev: float,
    stroke_ratio: float,
    *,
    alpha_share: float = 0.5,
    edges: int = 1,
) -> tuple[float, float] | None:
    """Lowest and highest spindle speed that still break while the frequency N S / 60 stays.

    With rho = edges * ``stroke_ratio`` (stroke / feed per revolution) the fraction of N / z may lie where
    the wave says; its whole part is kept.  None when the stroke is too small at any speed (rho < 1).
    """
    rho = stroke_ratio * edges
    if rho < 1.0 - FUZZ:
        return None
    low, high = wave_named(waveform).breaking_fractions(rho, alpha_share)
    whole = math.floor(per_rev / edges)
    passes_rpm = speed_rpm * per_rev / edges
    return passes_rpm / (whole + high), passes_rpm / (whole + low)


def feed_override_band(
    waveform: str, per_rev: float, stroke_ratio: float, *, alpha_share: float = 0.5, edges: int = 1
) -> tuple[float, float] | None:
    """Lowest and highest feed override, 1 for 100 %, that still breaks while the spindle keeps its speed.

    Every block then takes its time divided by the override, so that N and the feed per revolution go with it:
    with r the override, P D(N r / z) >= r f_r / z must hold.  ``stroke_ratio`` is P / f_r.  None when the
    chips do not break as programmed.  An axis is taken to follow.
    """
    wave = wave_named(waveform)

    def breaks(override: float) -> bool:
        drop = wave.largest_drop(per_rev * override / edges % 1.0, alpha_share, None)
        return stroke_ratio * edges * drop >= override - FUZZ

    if not breaks(1.0):
        return None
    low = high = 1.0
    while low > _LEAST_OVERRIDE and breaks(low - _OVERRIDE_STEP):
        low -= _OVERRIDE_STEP
    while high < _MOST_OVERRIDE and breaks(high + _OVERRIDE_STEP):
        high += _OVERRIDE_STEP
    return low, high


def sample(cut: WaveformParameters) -> tuple[Floats, Floats]:
    """The knots ``(time_s, distance_mm)`` of the cut, each of shape (n,), from (0, 0) to (duration, length).

    Time rises strictly; distance stays within 0 and the length; both ends are exact.  The vibration covers
    ``cut.vibrations`` whole vibrations of whole ticks, then one plain move leads to the end.
    Errors: VIB013 when not even one vibration of full stroke fits.
    """
    time_s, ahead, scale = _vibrating_part(cut)
    _full_vibrations(cut, scale)
    distance_mm = cut.speed_mm_s * time_s + scale * cut.stroke_mm * ahead
    np.clip(distance_mm, 0.0, cut.length_mm, out=distance_mm)  # only rounding is left to clip
    # When the last vibration ends with the cut, to within rounding, its last knot is the end.
    kept = time_s.size - int(cut.duration_s - time_s[-1] <= FUZZ * cut.period_s)
    time_s = np.append(np.append(0.0, time_s[:kept]), cut.duration_s)
    return time_s, np.append(np.append(0.0, distance_mm[:kept]), cut.length_mm)


def full_window(cut: WaveformParameters) -> tuple[float, float]:
    """From when to when [s] the vibrations have their full stroke: whole vibrations, at least one.

    Errors: VIB013 when there is none.
    """
    first, last = _full_vibrations(cut, _vibrating_part(cut)[2])
    return first * cut.period_s, last * cut.period_s


@remembered
def _vibrating_part(cut: WaveformParameters) -> tuple[Floats, Floats, Floats]:
    """Time, w and y at the knots of the whole vibrations but the one at 0: three arrays of shape (n,)."""
    knots = np.arange(1, cut.ticks + 1) if cut.form == "tick" else np.array([cut.forward_ticks, cut.ticks])
    heights = cut.shape.heights_at(knots.astype(np.float64), cut.ticks, cut.forward_ticks)
    tick = (np.arange(cut.vibrations)[:, np.newaxis] * cut.ticks + knots).ravel()
    time_s = tick * (cut.period_s / cut.ticks)
    # y is what the room before the end of the cut allows, the same throughout a vibration so that its shape
    # stays, and the ramp on the way in and, mirrored, on the way out.
    room_mm = (cut.length_mm - cut.speed_mm_s * time_s).reshape(-1, knots.size)[:, :-1]
    room_share = (room_mm / (cut.stroke_mm * heights[:-1])).min(axis=1)
    scale = np.repeat(np.clip(room_share, 0.0, 1.0), knots.size)
    if cut.ramp_in_s > 0.0 and time_s.size:
        nearest_end_s = np.minimum(time_s, time_s[-1] - time_s)
        np.minimum(
            scale, (np.minimum(nearest_end_s, cut.ramp_in_s) / cut.ramp_in_s) ** cut.ramp_exponent, out=scale
        )
    return time_s, np.tile(heights, cut.vibrations), scale


def _full_vibrations(cut: WaveformParameters, scale: Floats) -> tuple[int, int]:
    """The first vibration of full stroke, and the one after the last; y at the end of one does not count."""
    if cut.vibrations:
        inner = scale.reshape(cut.vibrations, -1)[:, :-1]
        full = np.flatnonzero(inner.min(axis=1) >= 1.0 - FUZZ)
        if full.size:
            return int(full[0]), int(full[-1]) + 1
    have = f"{shown(cut.length_mm)} mm at F {shown(cut.feed_mm_rev)} mm/rev takes {shown(cut.duration_s)} s"
    plain = f"the plain end {shown(cut.end_revolutions)} rev of {shown(S_PER_MIN / cut.speed_rpm)} s"
    one = f"one vibration of {shown(cut.stroke_mm)} mm {shown(cut.period_s)} s"
    raise RefusalError(
        TOO_SHORT,
        f"too short to vibrate: {have}; two ramps take {shown(cut.ramp_in_s)} s each, {one}, {plain}",
        "shorten the ramp, raise f, or cut this block without vibration",
    )


def _require(ok: bool, name: str, value: float, rule: str) -> None:
    if not ok:
        raise RefusalError("VIB010", f"{name} {shown(value)} is not {rule}", f"give a value {rule}")
