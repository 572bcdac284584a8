"""The waves that a cut may have, one object each: its shape, its times, what it breaks and what it needs.

The displacement of a vibration lies ahead of the mean feed by the stroke times w(tau), tau the time within
one vibration and w between 0 and 1, w(0) = 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar, Protocol

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import S_PER_MIN

FUZZ = 1e-9  # shares of a vibration or of a stroke that differ by less are equal


class CutOfWave(Protocol):
    """What a wave asks of the cut that has it."""

    @property
    def length_mm(self) -> float:
        """How long the path is."""

    @property
    def feed_mm_rev(self) -> float:
        """The programmed feed."""

    @property
    def feed_speed_mm_s(self) -> float:
        """The programmed feed as a speed."""

    @property
    def speed_rpm(self) -> float:
        """The spindle speed."""

    @property
    def speed_mm_s(self) -> float:
        """The mean feed speed."""

    @property
    def period_s(self) -> float:
        """How long one vibration takes."""

    @property
    def alpha_share(self) -> float:
        """The forward share of one vibration."""

    @property
    def stroke_mm(self) -> float:
        """The stroke, peak to peak."""

    @property
    def end_revolutions(self) -> float:
        """The least revolutions of plain feed at the end."""


class Wave(ABC):
    """One wave; ``alpha`` is always the forward share of a vibration."""

    name: ClassVar[str]
    turns_back: ClassVar[bool] = True
    """False where the tool feeds on and comes to rest: then its rests end the chips."""
    is_even: ClassVar[bool] = False
    """Forward and back take equal times, whatever share is asked for."""
    rounds_down: ClassVar[bool] = False
    """The forward ticks may be fewer than asked for, and never more."""

    def share(self, forward: int, ticks: int) -> float:
        """The forward share that so many ticks make."""
        return forward / ticks

    def speed_share(self, alpha: float) -> float:
        """The mean feed speed as a share of the programmed one."""
        return 1.0

    def standing_s(self, cut: CutOfWave) -> float:
        """How long the tool dwells in the whole cut."""
        return 0.0

    def vibrations(self, cut: CutOfWave) -> int:
        """Whole vibrations that fit before the plain revolutions at the end."""
        vibrating_s = cut.length_mm / cut.feed_speed_mm_s - cut.end_revolutions * S_PER_MIN / cut.speed_rpm
        return max(0, math.floor(vibrating_s / cut.period_s + FUZZ))

    def moves(self, knots: int) -> int:
        """How many blocks of motion so many knots of one vibration are."""
        return knots

    def refuse_form(self, form: str) -> None:
        """Errors: VIB011 for a form of moves that the wave does not have."""
        return

    def remarks(self, ticks: int) -> tuple[str, ...]:
        """What so few ticks make of the wave; nothing where it is what it is called."""
        return ()

    def heights(self, ticks: int, forward: int) -> Floats:
        """w at the end of each base period of one vibration, shape (ticks,); the last one is 0."""
        return self.heights_at(np.arange(1, ticks + 1, dtype=np.float64), ticks, forward)

    @abstractmethod
    def heights_at(self, tick: Floats, ticks: int, forward: int) -> Floats:
        """w behind some of them, (n,): of a slow vibration there may be millions."""

    @abstractmethod
    def largest_drop(self, delta: float, alpha: float, ticks: int | None) -> float:
        """By how much of the stroke a pass that is ``delta`` of a vibration late can lie ahead."""

    @abstractmethod
    def breaking_fractions(self, rho: float, alpha: float) -> tuple[float, float]:
        """Between which fractions of N / edges a stroke of ``rho`` times the feed per edge breaks chips."""

    @abstractmethod
    def least_acceleration_mm_s2(self, cut: CutOfWave, per_rev: float) -> float:
        """The acceleration below which no control can run the strokes."""


class Triangle(Wave):
    """Forward and back at even speeds; it rises over the forward share (JP6416218B2, claim 8).

    Above one half the tool enters slower than it returns.
    """

    name = "triangle"

    def heights_at(self, tick: Floats, ticks: int, forward: int) -> Floats:
        """See :meth:`Wave.heights_at`."""
        return np.minimum(tick / forward, (ticks - tick) / (ticks - forward))

    def largest_drop(self, delta: float, alpha: float, ticks: int | None) -> float:
        """min(delta / (1 - alpha), (1 - delta) / alpha)."""
        return min(delta / (1.0 - alpha), (1.0 - delta) / alpha)

    def breaking_fractions(self, rho: float, alpha: float) -> tuple[float, float]:
        """[(1 - alpha) / rho, 1 - alpha / rho]."""
        return (1.0 - alpha) / rho, 1.0 - alpha / rho

    def least_acceleration_mm_s2(self, cut: CutOfWave, per_rev: float) -> float:
        """A straight stroke of length d from rest to rest in time t needs 4 d / t^2.

        The forward stroke is P + alpha f_r / N long and takes alpha / V, the return P - (1 - alpha) f_r / N
        and (1 - alpha) / V.
        """
        alpha = cut.alpha_share
        advance_mm = cut.feed_mm_rev / per_rev
        frequency_hz = 1.0 / cut.period_s
        forward = 4.0 * (cut.stroke_mm + alpha * advance_mm) * (frequency_hz / alpha) ** 2
        back = 4.0 * (cut.stroke_mm - (1.0 - alpha) * advance_mm) * (frequency_hz / (1.0 - alpha)) ** 2
        return max(forward, back)


class Sine(Wave):
    """(1 - cos 2 pi tau) / 2."""

    name = "sine"
    is_even = True

    def share(self, forward: int, ticks: int) -> float:
        """One half."""
        return 0.5

    def refuse_form(self, form: str) -> None:
        """See :meth:`Wave.refuse_form`."""
        if form == "stroke":
            raise RefusalError(
                "VIB011",
                "one move per stroke is a triangle; a sine needs one move per base period",
                'take segments "tick" or waveform TRIANGLE',
            )

    def remarks(self, ticks: int) -> tuple[str, ...]:
        """After a quarter, a half and three quarters a sine is where a triangle is."""
        is_triangle = ticks in (2, 4)
        return (f"a sine of {ticks} base periods is a triangle: blocks are straight",) if is_triangle else ()

    def heights_at(self, tick: Floats, ticks: int, forward: int) -> Floats:
        """See :meth:`Wave.heights_at`."""
        heights: Floats = (1.0 - np.cos(2.0 * np.pi * tick / ticks)) / 2.0
        return heights

    def largest_drop(self, delta: float, alpha: float, ticks: int | None) -> float:
        """|sin pi delta|; of so few ``ticks`` that its corners matter it is taken as the polygon it is."""
        if ticks is None:
            return math.sin(math.pi * delta)
        knots = np.arange(1, ticks + 1) / ticks
        heights = self.heights(ticks, 1)
        # The difference of two polygons is largest at a corner of one of them.
        corners = np.concatenate([knots, knots + delta])
        before = np.interp(corners - delta, knots, heights, period=1.0)
        return float((before - np.interp(corners, knots, heights, period=1.0)).max())

    def breaking_fractions(self, rho: float, alpha: float) -> tuple[float, float]:
        """0.5 +- arccos(1 / rho) / pi."""
        half = math.acos(min(1.0, 1.0 / rho)) / math.pi
        return 0.5 - half, 0.5 + half

    def least_acceleration_mm_s2(self, cut: CutOfWave, per_rev: float) -> float:
        """(2 pi V)^2 P / 2."""
        return (2.0 * math.pi * (1.0 / cut.period_s)) ** 2 * cut.stroke_mm / 2.0


class Dwell(Triangle):
    """It never turns back: the tool feeds over the forward share and dwells for the rest.

    That is the triangle of stroke (1 - alpha) f / N about a mean feed of alpha times the programmed one.
    """

    name = "dwell"
    turns_back = False
    rounds_down = True

    def speed_share(self, alpha: float) -> float:
        """See :meth:`Wave.speed_share`."""
        return alpha

    def standing_s(self, cut: CutOfWave) -> float:
        """See :meth:`Wave.standing_s`."""
        return self.vibrations(cut) * cut.period_s * (1.0 - cut.alpha_share)

    def vibrations(self, cut: CutOfWave) -> int:
        """See :meth:`Wave.vibrations`."""
        vibrating_mm = cut.length_mm - cut.end_revolutions * cut.feed_mm_rev
        return max(0, math.floor(vibrating_mm / (cut.speed_mm_s * cut.period_s) + FUZZ))

    def moves(self, knots: int) -> int:
        """One: the dwell is no move."""
        return 1

    def least_acceleration_mm_s2(self, cut: CutOfWave, per_rev: float) -> float:
        """None: it may take its time."""
        return 0.0


WAVES: tuple[Wave, ...] = (
    Triangle(),  # what a profile has that says nothing: one block a stroke
    Sine(),  # a block per base period
    Dwell(),  # never back
)


def wave_named(name: str) -> Wave:
    """The wave of this name.  Errors: KeyError."""
    return _BY_NAME[name]


_BY_NAME = {wave.name: wave for wave in WAVES}
