"""Two of spindle speed S, vibrations per revolution N and vibration frequency f give all three.

N = 60 f / S ties the three together (JP6416218B2, claims 1 and 4).  A control that commands positions once
per base period can only vibrate at f = 1 / (n T0), so what was asked moves to that group (claim 5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import MS_PER_S, S_PER_MIN

FAR_RATIO = 1.25  # an f given as a word that far outside the group is more likely a feed
MOST_TICKS = 1_000_000  # the end of a group without a highest multiple: over an hour per vibration
WHOLE_WITHIN = 1e-3  # nearer to a whole number, the stroke would have to be hundreds of times the feed
TOO_FEW = "VIB001"
NEVER_BREAKS = "VIB005"
ABOVE_CLAMP = "VIB006"
TOO_SLOW = "VIB008"
_FUZZ = 1e-9  # two numbers that differ by less were meant to be equal
_MOST_COUNTS = 4000  # of periods to choose from


@dataclass(frozen=True)
class Period:
    """One command period: its frequency, its length and the whole base periods (ticks, at least 2) in it."""

    frequency_hz: float
    period_s: float
    ticks: int


@dataclass(frozen=True)
class CommandGroup:
    """The vibration frequencies a control can command: f = 1 / (n T0), JP6416218B2 first embodiment.

    ``n`` runs from ``min_multiple`` to ``max_multiple`` (None: no end) or through ``multiples``; controls
    whose periods are not multiples of the base period list ``periods_s``.  A vibration needs a tick forward
    and a tick back, so n is at least 2.  Errors: VIB009.
    """

    base_period_s: float = 0.004
    min_multiple: int = 4
    max_multiple: int | None = None
    multiples: tuple[int, ...] | None = None
    periods_s: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        _require(_is_positive(self.base_period_s), "a base period above zero")
        _require(self.multiples is None or self.periods_s is None, "multiples or explicit periods, not both")
        _require(self.multiples is None or min(self.multiples, default=0) >= 2, "multiples from 2 up")
        _require(self.periods_s != () and all(map(_is_positive, self.periods_s or ())), "periods above zero")
        _require(2 <= self.min_multiple <= MOST_TICKS, f"a lowest multiple from 2 to {MOST_TICKS}")
        _require(self.max_multiple is None or self.max_multiple >= self.min_multiple, "multiples in order")

    def around(self, frequency_hz: float, count: int = 3) -> tuple[Period, ...]:
        """The ``count`` periods nearest in frequency, best first; of two equally near the slower first."""
        if self.periods_s is not None:
            periods = [Period(1.0 / p, p, max(2, round(p / self.base_period_s))) for p in self.periods_s]
        else:
            last = self.max_multiple or MOST_TICKS
            shares = frequency_hz * self.base_period_s
            wanted = 1.0 / shares if shares > 0.0 else math.inf  # a spindle that is held at 0 rpm
            middle = min(max(wanted, self.min_multiple), last)
            low = max(self.min_multiple, math.floor(middle) - count)
            multiples = self.multiples or range(low, min(math.ceil(middle) + count, last) + 1)
            periods = [Period(1.0 / (n * self.base_period_s), n * self.base_period_s, n) for n in multiples]
        # The distance is rounded so that a tie survives binary arithmetic.
        periods.sort(key=lambda p: (round(abs(p.frequency_hz - frequency_hz), 9), p.frequency_hz))
        return tuple(periods[:count])

    def nearest(self, frequency_hz: float) -> Period:
        """The period nearest in frequency (claim 5, step S5); at a tie the slower: it asks less of the axis.

        >>> CommandGroup().nearest(75.0)
        Period(frequency_hz=62.5, period_s=0.016, ticks=4)
        """
        return self.around(frequency_hz, 1)[0]

    def between(self, low_hz: float, high_hz: float) -> tuple[Period, ...]:
        """All periods with a frequency within these bounds, the fastest first.

        Of more than some thousands, as a spindle that hardly turns has them, those that are some thousandths
        apart.
        """
        if self.periods_s is not None or self.multiples is not None:
            count = len(self.periods_s or self.multiples or ())
            every = self.around(high_hz, count)
            return tuple(sorted((p for p in every if low_hz <= p.frequency_hz <= high_hz), key=_length))
        fewest = max(self.min_multiple, math.ceil(1.0 / (high_hz * self.base_period_s) - _FUZZ))
        most = min(self.max_multiple or MOST_TICKS, math.floor(1.0 / (low_hz * self.base_period_s) + _FUZZ))
        periods = ((n, n * self.base_period_s) for n in _counts(fewest, most))
        return tuple(Period(1.0 / period_s, period_s, n) for n, period_s in periods)

    def contains_near(self, frequency_hz: float) -> bool:
        """False when the frequency lies over a quarter beyond the fastest or the slowest of the group."""
        slowest_hz = self.nearest(1e-6).frequency_hz
        fastest_hz = self.nearest(1e6).frequency_hz
        return slowest_hz / FAR_RATIO <= frequency_hz <= fastest_hz * FAR_RATIO


def _counts(fewest: int, most: int) -> Sequence[int]:
    """So many base periods, from few to many."""
    if most - fewest < _MOST_COUNTS:
        return range(fewest, most + 1)
    spread: list[int] = np.unique(
        np.rint(np.geomspace(max(fewest, 1), most, _MOST_COUNTS)).astype(int)
    ).tolist()
    return spread


def _length(period: Period) -> float:
    return period.period_s


@dataclass(frozen=True)
class SolverRules:
    """How to correct: which N is wanted, what may give way, and what the control can print and turn.

    ``rounding`` "nearest-half" is the nearest n + phase (step S12), "claim-7" the nearest integer + phase.
    ``phase`` is the wanted fraction of N / edges (0.5, or 1 - forward share for an uneven triangle).
    ``pn`` and ``mn`` are the tolerances above and below (claim 6), in units of N.  ``correct`` says what
    gives way: the spindle speed or the count N.  ``resolution_rpm`` is the step of a printed S.  VIB009.
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

    def __post_init__(self) -> None:
        _require(0.0 < self.phase < 1.0, "a phase between 0 and 1")
        _require(_is_positive(self.resolution_rpm), "a spindle resolution above zero")
        _require(self.edges >= 1, "one cutting edge or more")
        _require(all(0.0 <= (t or 0.0) < math.inf for t in (self.pn, self.mn)), "PN and MN of zero or more")


@dataclass(frozen=True)
class Solution:
    """All three, consistent: N = 60 f / S with S as it will be printed; one sentence per correction."""

    speed_rpm: float
    per_rev: float
    frequency_hz: float
    period: Period
    reasons: tuple[str, ...]
    changed_speed: bool


def never_breaks(per_rev: float, edges: int = 1) -> bool:
    """True when N / edges is a whole number: each pass repeats the last, so the chip never breaks."""
    share = per_rev / edges
    return abs(share - round(share)) <= WHOLE_WITHIN


def preferred_per_rev(per_rev: float, rules: SolverRules) -> float:
    """The N that breaks best near ``per_rev``: edges * (n + phase), n = 0, 1, 2, ...

    At a tie "nearest-half" takes the larger N (shorter chips), "claim-7" the smaller integer (n + 0.5 stays).

    >>> preferred_per_rev(1.75, SolverRules()), preferred_per_rev(1.75, SolverRules(rounding="claim-7"))
    (1.5, 2.5)
    """
    share = per_rev / rules.edges
    by_claim_7 = rules.rounding == "claim-7"
    n = math.ceil(share - 0.5 - _FUZZ) if by_claim_7 else math.floor(share - rules.phase + 0.5 + _FUZZ)
    return rules.edges * (max(n, 0) + rules.phase)


def solve(
    *,
    speed: SourcedValue | None,
    per_rev: SourcedValue | None,
    frequency: SourcedValue | None,
    group: CommandGroup,
    rules: SolverRules,
) -> Solution:
    """Determine S, N and f from exactly two of them (JP6416218B2, steps S1 to S13, claims 4 to 7).

    In rpm, 1/rev and Hz.  Errors: VIB001 fewer than two given, VIB002 all three, VIB003 not above zero,
    VIB004 f far outside the group, VIB005 N / edges whole, VIB006 S above the clamp, VIB007 S below the
    least, VIB008 S changed beyond reason: more than doubled, or more than halved for an f that was given.
    """
    _check_given({"S": speed, "N": per_rev, "f": frequency})
    reasons: list[str] = []
    period, why = _period(speed, per_rev, frequency, group, rules)
    reasons += why
    wanted = _wanted(speed, per_rev, period, rules, reasons)
    speed_rpm = _speed(speed, wanted, period, rules, reasons)
    reached = _ratio(period, speed_rpm)
    made_by = f"S {shown(speed_rpm)}, f {shown(period.frequency_hz)}"
    if frequency is None and speed is not None and per_rev is not None:
        _check_made(reached, rules, made_by, _Made(speed.value, per_rev.value, group))
    else:
        _check_breaks(reached, rules, made_by, period)
    _check_speed(speed_rpm, wanted, group, rules)
    if speed is not None and speed_rpm > 2.0 * speed.value:  # a surprise that can throw the part
        raise RefusalError(TOO_SLOW, f"S {speed} would become {shown(speed_rpm)} rpm", "give a larger N")
    changed = speed is not None and speed_rpm != speed.value
    return Solution(speed_rpm, reached, period.frequency_hz, period, tuple(reasons), changed)


def _period(
    speed: SourcedValue | None,
    per_rev: SourcedValue | None,
    frequency: SourcedValue | None,
    group: CommandGroup,
    rules: SolverRules,
) -> tuple[Period, list[str]]:
    """What the control can command nearest the f that was given or that S and N make; why, if another."""
    if frequency is not None:
        asked_hz = frequency.value
        _check_near(frequency, group)
        slower = None
    else:
        assert speed is not None and per_rev is not None
        asked_hz = per_rev.value * speed.value / S_PER_MIN
        slower = _below_clamp(group.nearest(asked_hz), speed.value, per_rev.value, group, rules)
    period = slower or group.nearest(asked_hz)
    # 41.667 Hz is how people write 1 / 24 ms; that is no correction.
    if math.isclose(asked_hz, period.frequency_hz, rel_tol=1e-4):
        return period, []
    size = f"{shown(period.period_s * MS_PER_S)} ms" if group.periods_s else f"n = {period.ticks}"
    why = "nearest the control can command"
    if slower is not None:
        why = f"the next that the clamp of {shown(rules.max_rpm or 0.0)} rpm allows"
    return period, [f"f {shown(asked_hz)} -> {shown(period.frequency_hz)} Hz, {why} ({size})"]


def _below_clamp(
    period: Period, given_rpm: float, count: float, group: CommandGroup, rules: SolverRules
) -> Period | None:
    """The next slower period where this one would take an allowed speed above the clamp; else None."""
    if rules.max_rpm is None or given_rpm > rules.max_rpm + _FUZZ or rules.correct == "count":
        return None
    if _printed(_ratio(period, count), rules) <= rules.max_rpm + _FUZZ:
        return None
    most_hz = rules.max_rpm * count / S_PER_MIN
    slower = [one for one in group.around(most_hz) if one.frequency_hz <= most_hz + _FUZZ]
    return slower[0] if slower else None


def _printed(speed_rpm: float, rules: SolverRules) -> float:
    """A speed to the resolution of the control."""
    # Rounded again because 25862 * 0.1 is not 2586.2 in binary.
    return round(math.floor(speed_rpm / rules.resolution_rpm + 0.5) * rules.resolution_rpm, 9)


def _check_near(frequency: SourcedValue, group: CommandGroup) -> None:
    if not group.contains_near(frequency.value):
        near = ", ".join(shown(period.frequency_hz) for period in group.around(frequency.value))
        way_out = f"the nearest are {near} Hz; a feed is written with an upper-case F"
        instead = tuple(f"f{shown(period.frequency_hz)}" for period in group.around(frequency.value))
        message = f"f {frequency} is far from all the control can command"
        raise RefusalError("VIB004", message, way_out, instead)


def _wanted(
    speed: SourcedValue | None,
    per_rev: SourcedValue | None,
    period: Period,
    rules: SolverRules,
    reasons: list[str],
) -> float:
    """N as given, or as S and f make it."""
    if per_rev is None:
        assert speed is not None
        return _count(speed, period, rules, reasons)
    if speed is None or rules.correct == "spindle":
        _check_breaks(per_rev.value, rules, per_rev.origin)
    return per_rev.value


def _count(speed: SourcedValue, period: Period, rules: SolverRules, reasons: list[str]) -> float:
    """N of given S and f (steps S8 to S12); nothing changes when S is right to its resolution already."""
    raw = _ratio(period, speed.value)
    if rules.correct == "count":
        return raw
    best = preferred_per_rev(raw, replace(rules, rounding="nearest-half"))
    if not _prints_as(speed, best, period, rules):
        best = preferred_per_rev(raw, rules)
    low = best - (rules.mn or 0.0)
    high = best + (rules.pn or 0.0)
    count = min(max(raw, low), high)
    if raw < min(count, rules.edges * rules.phase) / 2:
        what = f"S {speed} with f {shown(period.frequency_hz)} Hz makes N {shown(raw)}"
        slower = f"N {shown(count)} would need less than half that spindle speed"
        turns = shown(math.floor(_ratio(period, count)))
        raise RefusalError(TOO_SLOW, f"{what}; {slower}", f"give S {turns}, or N and f without S")
    if not _prints_as(speed, count, period, rules):
        why = "nearest integer + phase (claim 7)" if rules.rounding == "claim-7" else "nearest n + phase"
        why += f", phase {shown(rules.phase)}" + (f", {rules.edges} edges" if rules.edges > 1 else "")
        if count != best:
            why = f"tolerance {shown(low)} to {shown(high)} around {shown(best)} ({why})"
        reasons.append(f"N {shown(raw)} -> {shown(count)}, {why}")
    return count


def _speed(
    given: SourcedValue | None, wanted: float, period: Period, rules: SolverRules, why: list[str]
) -> float:
    """S [rpm] as it will be printed; a given S that is right to its resolution, or must stay, is kept."""
    if given is not None and rules.correct == "count":
        kept = _ratio(period, given.value)
        if not math.isclose(kept, wanted, rel_tol=1e-9):
            why.append(f"N {shown(wanted)} -> {shown(kept)} so that S stays {shown(given.value)} rpm")
        return given.value
    if given is not None and _prints_as(given, wanted, period, rules):
        return given.value
    exact_rpm = _ratio(period, wanted)
    printed_rpm = _printed(exact_rpm, rules)
    if printed_rpm <= 0.0:
        raise RefusalError("VIB007", f"S {shown(exact_rpm)} rpm prints as zero", "give a smaller N")
    if given is not None:
        why.append(f"S {shown(given.value)} -> {shown(printed_rpm)} rpm so that N is {shown(wanted)}")
    if not math.isclose(printed_rpm, exact_rpm, rel_tol=1e-9):
        count = shown(_ratio(period, printed_rpm))
        why.append(f"S {exact_rpm:z.4f} prints as {shown(printed_rpm)} rpm, which makes N {count}")
    return printed_rpm


def _ratio(period: Period, speed_or_count: float) -> float:
    """60 f / S = N, and 60 f / N = S."""
    return S_PER_MIN * period.frequency_hz / speed_or_count


def _prints_as(speed: SourcedValue, count: float, period: Period, rules: SolverRules) -> bool:
    """True when the given S is what N ``count`` needs, to the resolution of the control."""
    return abs(_ratio(period, count) - speed.value) <= rules.resolution_rpm / 2 + _FUZZ


def _check_given(values: dict[str, SourcedValue | None]) -> None:
    given = {name: value for name, value in values.items() if value is not None}
    told = ", ".join(f"{name} {value}" for name, value in given.items()) or "none"
    if len(given) > 2:
        raise RefusalError("VIB002", f"S, N and f are all given: {told}", "leave one out: N = 60 f / S")
    if len(given) < 2:
        raise RefusalError(TOO_FEW, f"two of S, N and f are needed, given: {told}", "give one more")
    for name, value in given.items():
        if not _is_positive(value.value):
            raise RefusalError("VIB003", f"{name} {value} is not a number above zero", f"correct {name}")


class _Made(NamedTuple):
    """An S that stays, and the N that it was to make with what the control can command."""

    speed_rpm: float
    per_rev: float
    group: CommandGroup

    def breaks(self, edges: int) -> bool:
        """True where the N that comes out is not whole, and the spindle turns."""
        if self.speed_rpm <= 0.0:
            return False
        period = self.group.nearest(self.per_rev * self.speed_rpm / S_PER_MIN)
        return not never_breaks(_ratio(period, self.speed_rpm), edges)


def _check_made(reached: float, rules: SolverRules, origin: str, made: _Made) -> None:
    """Refuse a whole number that S, which stays, and the nearest f make; with what makes another one."""
    try:
        _check_breaks(reached, rules, origin)
    except RefusalError as error:
        way_out, good = _way_out_of(made, reached, rules)
        raise RefusalError(error.code, error.message, way_out, tuple(f"N{n}" for n in good)) from None


def _way_out_of(made: _Made, reached: float, rules: SolverRules) -> tuple[str, list[str]]:
    """Another N at this S, or another S with this N; and such N."""
    better = _better_counts(reached, rules)
    good = [shown(n) for n in better if made._replace(per_rev=n).breaks(rules.edges)]
    if good:
        return f"N {' or '.join(good)} breaks best", good
    speeds = [math.floor(made.speed_rpm * reached / n) for n in better]
    others = [shown(rpm) for rpm in speeds if made._replace(speed_rpm=rpm).breaks(rules.edges)]
    return (f"give S {' or '.join(others)}" if others else "give N and f without S"), good


def _better_counts(per_rev: float, rules: SolverRules) -> list[float]:
    """What breaks best next to a whole number."""
    whole = round(per_rev / rules.edges)
    return list(dict.fromkeys(rules.edges * (n + rules.phase) for n in (max(whole - 1, 0), whole)))


def _check_breaks(per_rev: float, rules: SolverRules, origin: str, period: Period | None = None) -> None:
    """Refuse a whole number.  Where S makes it, at ``period``, another N asked for would not help."""
    if never_breaks(per_rev, rules.edges):
        counts = _better_counts(per_rev, rules)
        good = [shown(count) for count in counts]
        what = f"N {shown(per_rev)} ({origin})" + (f" / {rules.edges} edges" if rules.edges > 1 else "")
        way_out = f"N {' or '.join(good)} breaks best"
        if period is not None:
            way_out += _speeds_for(counts, period, rules.edges)
        instead = tuple(f"N{count}" for count in good) if period is None else ()
        message = f"{what} is a whole number, so no chip ever breaks"
        raise RefusalError(NEVER_BREAKS, message, way_out, instead)


def _speeds_for(counts: Sequence[float], period: Period, edges: int) -> str:
    """The whole S that make about these N, behind a way out; but for those that make a whole number again."""
    speeds = [rpm for rpm in (math.floor(_ratio(period, count)) for count in counts) if rpm > 0]
    good = [shown(rpm) for rpm in speeds if not never_breaks(_ratio(period, rpm), edges)]
    return f": give S {' or '.join(good)}" if good else ", which needs another S or f"


def _check_speed(speed_rpm: float, wanted: float, group: CommandGroup, rules: SolverRules) -> None:
    if rules.max_rpm is not None and speed_rpm > rules.max_rpm + _FUZZ:
        most_hz = rules.max_rpm * wanted / S_PER_MIN
        slower = [p.frequency_hz for p in group.around(most_hz) if p.frequency_hz <= most_hz]
        way_out = f"give f {shown(slower[0])} Hz or a larger N" if slower else "give a larger N"
        clamp = f"S {shown(speed_rpm)} rpm is above the clamp of {shown(rules.max_rpm)} rpm"
        raise RefusalError(ABOVE_CLAMP, clamp, way_out, tuple(f"f{shown(one)}" for one in slower[:1]))
    if speed_rpm < rules.min_rpm - _FUZZ:
        least = f"S {shown(speed_rpm)} rpm is below the least of {shown(rules.min_rpm)} rpm"
        raise RefusalError("VIB007", least, "give a smaller N")


def _is_positive(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _require(ok: bool, what: str) -> None:
    if not ok:
        raise RefusalError("VIB009", f"vibration settings need {what}", "correct the machine profile")
