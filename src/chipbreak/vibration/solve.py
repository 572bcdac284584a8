"""Two of spindle speed S, vibrations per revolution N and vibration frequency f give all three.

N = 60 f / S ties the three together (JP6416218B2, claims 1 and 4).  A control that commands positions once
per base period can only vibrate at f = 1 / (n T0), so whatever was asked has to move to that group
(claim 5); what moves with it is said in ``Solution.reasons``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from chipbreak.diagnostics import RefusalError
from chipbreak.units import MS_PER_S, S_PER_MIN

# An f given as a word this far outside the group is more likely a feed or a slip of the pen.
FAR_RATIO = 1.25

# Nearer to a whole number than this, the stroke would have to be hundreds of times the feed.
WHOLE_WITHIN = 1e-3

_FUZZ = 1e-9  # two numbers that differ by less were meant to be equal


@dataclass(frozen=True)
class Given:
    """A number somebody asked for, and where ("N word, line 12")."""

    value: float
    origin: str


@dataclass(frozen=True)
class Period:
    """One command period: its frequency, its length and the whole base periods (ticks, at least 2) in it."""

    frequency_hz: float
    period_s: float
    ticks: int


@dataclass(frozen=True)
class CommandGroup:
    """The vibration frequencies a control can command: f = 1 / (n T0), JP6416218B2 first embodiment.

    ``n`` runs from ``min_multiple`` to ``max_multiple`` (None: no end), or through ``multiples`` when those
    are listed.  ``periods_s`` lists the periods themselves, for controls whose periods are not multiples of
    the base period.  One vibration needs a tick forward and a tick back, so n is at least 2.
    Errors: VIB009 for a group that is empty or cannot be.
    """

    base_period_s: float = 0.004
    min_multiple: int = 4
    max_multiple: int | None = None
    multiples: tuple[int, ...] | None = None
    periods_s: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        if not _is_positive(self.base_period_s):
            raise _impossible(f"base period {self.base_period_s} s", "give a base period above zero, such as 0.004")
        if self.multiples is not None and self.periods_s is not None:
            raise _impossible("multiples and explicit periods together", "give one of the two")
        if self.multiples is not None and (not self.multiples or min(self.multiples) < 2):
            raise _impossible(f"multiples {self.multiples}", "list whole numbers from 2 up")
        if self.periods_s is not None and not (self.periods_s and all(map(_is_positive, self.periods_s))):
            raise _impossible(f"periods {self.periods_s}", "list periods in seconds, each above zero")
        if self.min_multiple < 2:
            raise _impossible(f"lowest multiple {self.min_multiple}", "one vibration is at least two base periods")
        if self.max_multiple is not None and self.max_multiple < self.min_multiple:
            raise _impossible(f"multiples {self.min_multiple} to {self.max_multiple}", "the highest is below the lowest")

    def around(self, frequency_hz: float, count: int = 3) -> tuple[Period, ...]:
        """The ``count`` periods nearest in frequency, best first; of two equally near the slower comes first.

        Slower, because it asks less of the axis and keeps S = 60 f / N under the clamp.
        """
        periods = self._listed()
        if periods is None:
            middle = 1.0 / (frequency_hz * self.base_period_s)
            last = math.inf if self.max_multiple is None else self.max_multiple
            low = max(self.min_multiple, min(last, math.floor(middle)) - count)
            high = min(last, max(self.min_multiple, math.ceil(middle)) + count)
            periods = [self._multiple(n) for n in range(int(low), int(high) + 1)]
        step_hz = frequency_hz * _FUZZ  # so that a tie survives rounding
        ranked = sorted(periods, key=lambda p: (round(abs(p.frequency_hz - frequency_hz) / step_hz), p.frequency_hz))
        return tuple(ranked[:count])

    def nearest(self, frequency_hz: float) -> Period:
        """The period nearest in frequency (claim 5, step S5); at a tie the slower one.

        >>> CommandGroup().nearest(75.0)
        Period(frequency_hz=62.5, period_s=0.016, ticks=4)
        """
        return self.around(frequency_hz, 1)[0]

    def at_or_below(self, frequency_hz: float) -> Period | None:
        """The fastest period that is not faster than ``frequency_hz``; None when the group has none."""
        periods = self._listed()
        if periods is None:
            n = max(self.min_multiple, math.ceil(1.0 / (frequency_hz * self.base_period_s) - _FUZZ))
            periods = [] if self.max_multiple is not None and n > self.max_multiple else [self._multiple(n)]
        slow = [p for p in periods if p.frequency_hz <= frequency_hz * (1.0 + _FUZZ)]
        return max(slow, key=lambda p: p.frequency_hz, default=None)

    def contains_near(self, frequency_hz: float) -> bool:
        """False when ``frequency_hz`` lies more than a quarter beyond the fastest or the slowest of the group.

        A group without a highest n has no slowest frequency, so there nothing is too slow.
        """
        periods = self._listed()
        if periods is None:
            periods = [self._multiple(self.min_multiple)]
            if self.max_multiple is None:
                return frequency_hz <= periods[0].frequency_hz * FAR_RATIO
            periods.append(self._multiple(self.max_multiple))
        rates_hz = [p.frequency_hz for p in periods]
        return min(rates_hz) / FAR_RATIO <= frequency_hz <= max(rates_hz) * FAR_RATIO

    def _multiple(self, n: int) -> Period:
        return Period(1.0 / (n * self.base_period_s), n * self.base_period_s, n)

    def _listed(self) -> list[Period] | None:
        if self.multiples is not None:
            return [self._multiple(n) for n in self.multiples]
        if self.periods_s is not None:
            return [Period(1.0 / p, p, max(2, round(p / self.base_period_s))) for p in self.periods_s]
        return None


@dataclass(frozen=True)
class SolverRules:
    """How to correct: which N is wanted, what may give way, and what the control can print and turn.

    ``rounding`` "nearest-half" is the nearest n + phase (step S12), "claim-7" the nearest integer + phase.
    ``phase`` is the wanted fraction of N / edges (0.5, or 1 - forward share for an uneven triangle).
    ``pn`` and ``mn`` are the tolerances above and below (claim 6), in units of N.  ``correct`` says what gives
    way: the spindle speed or the count N.  ``resolution_rpm`` is the step of a printed S.
    """

    rounding: Literal["nearest-half", "claim-7"] = "nearest-half"
    phase: float = 0.5
    pn: float | None = None
    mn: float | None = None
    correct: Literal["spindle", "count"] = "spindle"
    resolution_rpm: float = 1.0
    edges: int = 1
    min_rpm: float = 0.0
    max_rpm: float | None = None


@dataclass(frozen=True)
class Solution:
    """All three, consistent: ``per_rev`` = 60 ``frequency_hz`` / ``speed_rpm`` with S as it will be printed.

    ``reasons`` holds one sentence per correction, and is empty when what was asked can be had unchanged.
    ``changed_speed`` is about an S that was given; an S that follows from N and f is not a change.
    """

    speed_rpm: float
    per_rev: float
    frequency_hz: float
    period: Period
    reasons: tuple[str, ...]
    changed_speed: bool
    changed_per_rev: bool
    changed_frequency: bool


def number_text(value: float) -> str:
    """A number for people: four decimals at most, no trailing zeros.

    >>> number_text(2586.20690), number_text(3000.0), number_text(0.00002)
    ('2586.2069', '3000', '2e-05')
    """
    if value != 0.0 and not 1e-3 <= abs(value) < 1e12:
        return f"{value:.4g}"
    return f"{value:.4f}".rstrip("0").rstrip(".")


def never_breaks(per_rev: float, edges: int = 1) -> bool:
    """True when N / edges is a whole number: each pass repeats the last, so the chip never breaks."""
    share = per_rev / edges
    return abs(share - round(share)) <= WHOLE_WITHIN


def preferred_per_rev(per_rev: float, rules: SolverRules) -> float:
    """The N that breaks best near ``per_rev``: edges * (n + phase), n = 0, 1, 2, ...

    At a tie "nearest-half" takes the larger N (shorter chips, slower spindle); "claim-7" takes the smaller
    integer, so that an N which is already n + 0.5 stays.

    >>> preferred_per_rev(1.75, SolverRules()), preferred_per_rev(1.75, SolverRules(rounding="claim-7"))
    (1.5, 2.5)
    """
    share = per_rev / rules.edges
    if rules.rounding == "claim-7":
        n = math.ceil(share - 0.5 - _FUZZ)
    else:
        n = math.floor(share - rules.phase + 0.5 + _FUZZ)
    return rules.edges * (max(n, 0) + rules.phase)


def solve(
    *, speed: Given | None, per_rev: Given | None, frequency: Given | None, group: CommandGroup, rules: SolverRules
) -> Solution:
    """Determine S, N and f from exactly two of them (JP6416218B2, steps S1 to S13, claims 4 to 7).

    ``speed`` is in rpm, ``per_rev`` in 1/rev, ``frequency`` in Hz.  Errors: VIB001 fewer than two given,
    VIB002 three given, VIB003 not a number above zero, VIB004 f far outside the group, VIB005 N / edges whole,
    VIB006 S above the clamp, VIB007 S below the least, VIB008 f too slow for S, VIB009 impossible rules.
    """
    _check_rules(rules)
    _check_given((("S", speed), ("N", per_rev), ("f", frequency)))
    reasons: list[str] = []
    if frequency is not None:
        _check_near(frequency, group)
        asked_hz = frequency.value
    else:
        assert speed is not None and per_rev is not None
        asked_hz = per_rev.value * speed.value / S_PER_MIN
    period = group.nearest(asked_hz)
    changed_frequency = not math.isclose(asked_hz, period.frequency_hz, rel_tol=1e-4)
    if changed_frequency:
        change = f"f {number_text(asked_hz)} -> {number_text(period.frequency_hz)} Hz"
        reasons.append(f"{change}, nearest the control can command ({_how_long(period, group)})")

    if per_rev is not None:
        wanted = per_rev.value
        if speed is None or rules.correct == "spindle":
            _check_breaks(wanted, rules, per_rev.origin)
    else:
        assert speed is not None and frequency is not None
        wanted = _count_from(speed, frequency, period, rules, reasons)
    speed_rpm = _speed(speed, wanted, period, rules, reasons, keeps_count=per_rev is not None)
    reached = S_PER_MIN * period.frequency_hz / speed_rpm
    _check_breaks(reached, rules, f"from S {number_text(speed_rpm)} and f {number_text(period.frequency_hz)}")
    _check_speed(speed_rpm, wanted, group, rules)
    return Solution(
        speed_rpm=speed_rpm,
        per_rev=reached,
        frequency_hz=period.frequency_hz,
        period=period,
        reasons=tuple(reasons),
        changed_speed=speed is not None and speed_rpm != speed.value,
        changed_per_rev=per_rev is not None and not math.isclose(reached, per_rev.value, rel_tol=1e-9),
        changed_frequency=changed_frequency,
    )


def _count_from(
    speed: Given, frequency: Given, period: Period, rules: SolverRules, reasons: list[str]
) -> float:
    """N of given S and f (steps S8 to S12); nothing is corrected when S already is right to its resolution."""
    raw = S_PER_MIN * period.frequency_hz / speed.value
    if rules.correct == "count":
        return raw
    half_step_rpm = rules.resolution_rpm / 2 + _FUZZ
    best = preferred_per_rev(raw, SolverRules(phase=rules.phase, edges=rules.edges))
    if abs(S_PER_MIN * period.frequency_hz / best - speed.value) > half_step_rpm:
        best = preferred_per_rev(raw, rules)
    low, high = best - (rules.mn or 0.0), best + (rules.pn or 0.0)
    count = min(max(raw, low), high)
    if raw < min(count, rules.edges * rules.phase) / 2:
        raise RefusalError(
            "VIB008",
            f"f {number_text(frequency.value)} ({frequency.origin}) with S {number_text(speed.value)} ({speed.origin})"
            f" is N {number_text(raw)}; N {number_text(count)} would need less than half that spindle speed",
            f"give a higher f, or give N and f and let S follow (S {number_text(raw * speed.value / count)})",
        )
    if abs(S_PER_MIN * period.frequency_hz / count - speed.value) > half_step_rpm:
        rule = "nearest integer + phase (claim 7)" if rules.rounding == "claim-7" else "nearest n + phase"
        why = f"{rule}, phase {number_text(rules.phase)}"
        if rules.edges > 1:
            why += f", {rules.edges} edges"
        if count != best:
            why = f"the tolerance {number_text(low)} to {number_text(high)} around {number_text(best)}, {why}"
        reasons.append(f"N {number_text(raw)} -> {number_text(count)}, {why}")
    return count


def _speed(
    given: Given | None, wanted: float, period: Period, rules: SolverRules, reasons: list[str], *, keeps_count: bool
) -> float:
    """S as it will be printed; a given S that is right to its resolution, or that must stay, is returned as is."""
    exact_rpm = S_PER_MIN * period.frequency_hz / wanted
    if given is not None and rules.correct == "count":
        reached = S_PER_MIN * period.frequency_hz / given.value
        if not math.isclose(reached, wanted, rel_tol=1e-9):
            change = f"N {number_text(wanted)} -> {number_text(reached)}"
            reasons.append(f"{change}, so that S stays {number_text(given.value)} rpm")
        return given.value
    if given is not None and abs(exact_rpm - given.value) <= rules.resolution_rpm / 2 + _FUZZ:
        return given.value
    # Rounded again because 25862 * 0.1 is not 2586.2 in binary.
    printed_rpm = round(math.floor(exact_rpm / rules.resolution_rpm + 0.5) * rules.resolution_rpm, 9)
    if printed_rpm <= 0.0:
        raise RefusalError("VIB007", f"S {number_text(exact_rpm)} rpm prints as zero", "give a smaller N or a higher f")
    if given is not None:
        verb = "stays" if keeps_count else "becomes"
        change = f"S {number_text(given.value)} -> {number_text(printed_rpm)} rpm"
        reasons.append(f"{change} so that N {verb} {number_text(wanted)}")
    if not math.isclose(printed_rpm, exact_rpm, rel_tol=1e-9):
        reached = number_text(S_PER_MIN * period.frequency_hz / printed_rpm)
        reasons.append(
            f"S {number_text(exact_rpm)} prints as {number_text(printed_rpm)} rpm, which makes N {reached}"
        )
    return printed_rpm


def _check_given(values: Iterable[tuple[str, Given | None]]) -> None:
    given = [(name, value) for name, value in values if value is not None]
    told = ", ".join(f"{name} {number_text(v.value)} ({v.origin})" for name, v in given) or "none"
    if len(given) > 2:
        raise RefusalError(
            "VIB002", f"S, N and f are all given: {told}", "leave one out; it follows from N = 60 f / S"
        )
    if len(given) < 2:
        raise RefusalError(
            "VIB001", f"two of S, N and f are needed, given: {told}", "give another of S, N and f"
        )
    for name, value in given:
        if not _is_positive(value.value):
            raise RefusalError(
                "VIB003", f"{name} {value.value:g} ({value.origin}) is not a number above zero", f"correct {name}"
            )


def _check_near(frequency: Given, group: CommandGroup) -> None:
    if not group.contains_near(frequency.value):
        near = ", ".join(number_text(p.frequency_hz) for p in group.around(frequency.value))
        raise RefusalError(
            "VIB004",
            f"f {number_text(frequency.value)} Hz ({frequency.origin}) is far from what the control can command",
            f"the nearest are {near} Hz; a feed is written with an upper-case F",
        )


def _check_breaks(per_rev: float, rules: SolverRules, origin: str) -> None:
    if never_breaks(per_rev, rules.edges):
        whole = round(per_rev / rules.edges)
        low, high = (rules.edges * (n + rules.phase) for n in (max(whole - 1, 0), whole))
        edges = f" / {rules.edges} edges" if rules.edges > 1 else ""
        raise RefusalError(
            "VIB005",
            f"N {number_text(per_rev)} ({origin}){edges} is a whole number: each pass repeats the last, no chip breaks",
            f"N {number_text(low)} or {number_text(high)} breaks best",
        )


def _check_speed(speed_rpm: float, wanted: float, group: CommandGroup, rules: SolverRules) -> None:
    if rules.max_rpm is not None and speed_rpm > rules.max_rpm + _FUZZ:
        slower = group.at_or_below(rules.max_rpm * wanted / S_PER_MIN)
        way = f"f {number_text(slower.frequency_hz)} Hz with N {number_text(wanted)} stays below it" if slower else ""
        raise RefusalError(
            "VIB006",
            f"S {number_text(speed_rpm)} rpm is above the clamp of {number_text(rules.max_rpm)} rpm",
            way or "give a larger N",
        )
    if speed_rpm < rules.min_rpm - _FUZZ:
        raise RefusalError(
            "VIB007",
            f"S {number_text(speed_rpm)} rpm is below the least of {number_text(rules.min_rpm)} rpm",
            "give a smaller N or a higher f",
        )


def _check_rules(rules: SolverRules) -> None:
    if not 0.0 < rules.phase < 1.0:
        raise _impossible(f"phase {rules.phase}", "the phase lies between 0 and 1")
    if not _is_positive(rules.resolution_rpm):
        raise _impossible(f"spindle resolution {rules.resolution_rpm} rpm", "give a step above zero, such as 1")
    if rules.edges < 1:
        raise _impossible(f"{rules.edges} cutting edges", "give 1 or more")
    for name, tolerance in (("PN", rules.pn), ("MN", rules.mn)):
        if tolerance is not None and not (math.isfinite(tolerance) and tolerance >= 0.0):
            raise _impossible(f"tolerance {name} {tolerance}", "a tolerance is zero or more")


def _how_long(period: Period, group: CommandGroup) -> str:
    return f"{number_text(period.period_s * MS_PER_S)} ms" if group.periods_s else f"n = {period.ticks}"


def _is_positive(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _impossible(what: str, way_out: str) -> RefusalError:
    return RefusalError("VIB009", f"vibration settings cannot have {what}", way_out)
