"""The machine chooses N, f and S of a cut near its programmed speed: ``n = "auto"``, ``(VIB AUTO)``.

Closed forms sort all that the control can command, the law of the control says which of these strokes it can
run, and what is left is planned, and judged by the numbers of its blocks, until one breaks the chips.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import islice
from operator import sub

from chipbreak.kinematics.conditions import (
    LEAST_PER_REV,
    MOST_PER_REV,
    Conditions,
    Limits,
    Wanted,
    best_first,
    least_demand,
)
from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.kinematics.speed_solver import TOO_FEW, CommandGroup, Period, SolverRules
from chipbreak.kinematics.toolpath import Leg, path_of
from chipbreak.kinematics.waveform import TOO_SHORT
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import MS_PER_S, S_PER_MIN
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.chain import Chain, legs_of
from chipbreak.vibration.expanders import expander_named
from chipbreak.vibration.least_stroke import TOO_FINE
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.measure import measure_planned
from chipbreak.vibration.plan import CutPlan, asked_of, command_group, feed_per_rev_mm, rules_of
from chipbreak.vibration.surface_speed import bounds_rpm, surface_speed_of
from chipbreak.vibration.trial import fed
from chipbreak.vibration.try_cost import cost_of

NOTHING_FITS = "VIB036"
NO_STROKE_MM = 1e-9
_USUAL_MM_S2 = 10_000.0  # of axes whose acceleration the profile does not say, no more is asked
_MOST_COST_OF_A_CHAIN = 300_000  # of all tries together
_MOST_TRIED = 10  # of what closed forms find, to say that there is something
_LEAST_HZ = 0.1
_MANY = 10  # vibrations, of which the ramps are a small part
_WITH_ROUNDING = 1.05
_STANDS = (1.25, 1.5, 2.0, 3.0, 5.0)  # revolutions per edge
_SLOWER = 0.85  # of a frequency that did not work, the next that is tried at most
_FEW = 4  # tries of a cut of which each may take a second
_ENOUGH_FAILED = 3  # cuts of a kind for which none of so many did it
_FEW_OF_DEAR_OTHERS = 2  # the same of one at another speed or feed, of which there are several
_FEW_OF_OTHERS = 6
_MOST_OTHERS = 4  # of other speeds, and feeds, that are tried to the verdict
_MOST_OTHERS_IN_ALL = 8  # for all cuts of a run together
_STEP = 0.9  # from one speed or feed that is tried for a way out to the next
_FEED_STEP_MM = 0.001
_PLENTY = 0.5  # of the asked margin beyond 1 must be left for a choice to be taken at once
_ENOUGH_OF_DEAR = 0.25  # the same where every try takes long

MakeCut = Callable[[Chain], tuple[CutPlan, Expansion]]


class _Cut(NamedTuple):
    """A chain for which conditions are chosen, with what they depend on."""

    chain: Chain
    wanted: Wanted
    rules: SolverRules
    law: ControlLaw
    limits: Limits
    length_mm: float
    speed_origin: str


class _Tried(NamedTuple):
    """A choice with the margin that its blocks have."""

    margin: float
    conditions: Conditions
    made: tuple[CutPlan, Expansion]


def is_open(chain: Chain) -> bool:
    """True where the machine chooses N and f."""
    return bool(chain.requests[0].chosen_by)


class Chooser:
    """Chooses for the cuts of one run; what worked for a cut is taken for others like it."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.worked: dict[tuple[object, ...], Conditions] = {}
        self.failed: Counter[tuple[object, ...]] = Counter()
        self.others_left = _MOST_OTHERS_IN_ALL

    def cut(self, chain: Chain, make: MakeCut, *, advise: bool = False) -> tuple[CutPlan, Expansion]:
        """The plan and the blocks of a chain with the best conditions that break its chips.

        ``make`` plans a chain with conditions and makes its blocks.  ``advise``: where none do it, another
        speed and another feed are tried.  Errors: VIB036 where nothing does it
        within the limits of the machine, VIB013 where the cut is too short, and those of a chain that cannot
        be planned at all.
        """
        cut = _cut_of(chain, self.settings)
        kind = _kind(cut)
        known = self.worked.get(kind)
        if known is not None and _fits(known, cut, self.settings):
            again = self._again(cut, known, make)
            if again is not None:
                return again
        try:
            found = self._tried(cut, make, self._most_tries(cut, kind))
        except RefusalError as error:
            self.failed[kind] += 1
            if advise and error.code == NOTHING_FITS:
                ways = self._ways_out(cut, make) or error.help
                raise RefusalError(error.code, error.message, ways) from None
            raise
        self.worked.setdefault(kind, found.conditions)
        return found.made

    def _most_tries(self, cut: _Cut, kind: tuple[object, ...]) -> float:
        """How many choices are tried; where each may take a second, one behind several cuts that had none."""
        if not _is_dear(cut, self.settings):
            return math.inf
        return _FEW if self.failed[kind] < _ENOUGH_FAILED else 1

    def _again(self, cut: _Cut, known: Conditions, make: MakeCut) -> tuple[CutPlan, Expansion] | None:
        """What worked for another cut; None where this one is so short that it does not hold here."""
        try:
            if _vibrations(known, cut, self.settings) >= _MANY:
                return make(_with(cut, known, self.settings))
            tried = self._try(cut, known, make)
        except RefusalError:
            return None
        return tried.made if tried.margin >= 1.0 else None

    def candidates(self, chain: Chain) -> Iterator[Conditions]:
        """What closed forms and the law of the control find for a chain, the best first, untried.

        Errors: those of :meth:`cut`.
        """
        cut = _cut_of(chain, self.settings)
        return (one for one in self._candidates(cut) if _runs(one, cut))

    def _tried(self, cut: _Cut, make: MakeCut, most: float) -> _Tried:
        """The first choice with margin to spare, else that with the most; so many are tried."""
        tried: list[_Tried] = []
        refused: list[RefusalError] = []
        slower = _Slower(most)
        for conditions in self._candidates(cut):
            # What the control makes of a stroke takes long to find, so that is asked last.
            if not slower.takes(conditions) or not _runs(conditions, cut):
                continue
            slower.behind(conditions, self._attempt(cut, conditions, make, tried, refused))
            if slower.is_over or (tried and self._is_enough(cut, tried)):
                break
        best = max(tried, key=lambda one: one.margin, default=None)
        if best is None or best.margin < 1.0:
            why = (one for one in refused if one.code != NOTHING_FITS)
            raise next(why, None) or _nothing_fits(cut, self.settings)
        return best

    def _attempt(
        self,
        cut: _Cut,
        conditions: Conditions,
        make: MakeCut,
        tried: list[_Tried],
        refused: list[RefusalError],
    ) -> str:
        """Try a choice, and add what comes of it; why it is none, empty where it is one."""
        try:
            tried.append(self._try(cut, conditions, make))
        except RefusalError as error:
            refused.append(error)
            return error.code
        return "" if tried[-1].margin > 0.0 else NOTHING_FITS

    def _is_enough(self, cut: _Cut, tried: Sequence[_Tried]) -> bool:
        """True where the last one has margin to spare; where blocks of a chain are better tried alone."""
        plenty = _ENOUGH_OF_DEAR if _is_dear(cut, self.settings) else _PLENTY
        if tried[-1].margin >= 1.0 + plenty * (cut.wanted.margin - 1.0):
            return True
        return len(cut.chain.requests) > 1 and self._cost_of(tried) > _MOST_COST_OF_A_CHAIN

    def _cost_of(self, tried: Sequence[_Tried]) -> int:
        return sum(cost_of(one.made[0], self.settings) for one in tried)

    def _try(self, cut: _Cut, conditions: Conditions, make: MakeCut) -> _Tried:
        """One choice, made and judged; margin 0 where the control would not keep to it."""
        made = make(_with(cut, conditions, self.settings))
        plan = made[0]
        # A stroke that makes up for what filters take may be more than anybody would command.
        commanded = plan.wave.shape.least_acceleration_mm_s2(plan.wave, plan.solution.per_rev)
        if commanded > cut.limits.acceleration_mm_s2 * _WITH_ROUNDING:
            return _Tried(0.0, conditions, made)
        try:
            report = measure_planned(self.settings, *made)
        except SelfCheckError:
            return _Tried(0.0, conditions, made)
        return _Tried(report.verdict.margin if report.holds else 0.0, conditions, made)

    def _ways_out(self, cut: _Cut, make: MakeCut) -> str:
        """A lower speed, and a lower feed, with which the machine finds conditions; empty for none."""
        share = _share_of_limits(cut, self.settings)
        ways = []
        speed_rpm = self._first_that_works(cut, _lower_speeds(cut, math.sqrt(share)), make)
        if speed_rpm is not None:
            ways.append(f"S {shown(speed_rpm.wanted.speed_rpm)} with this feed")
        feed = self._first_that_works(cut, _lower_feeds(cut, share), make)
        if feed is not None:
            ways.append(f"a feed of {shown(feed.wanted.feed_mm_rev)} mm/rev")
        return f"give {', or '.join(ways)}" if ways else ""

    def _first_that_works(self, cut: _Cut, others: Iterator[_Cut], make: MakeCut) -> _Cut | None:
        """The first of a few cuts for which conditions are found and break its chips."""
        group = command_group(self.settings)
        form = expander_named(cut.chain.requests[0].waveform).form(self.settings.output.segments)
        is_dear = form == "tick" or cut.law.unlike_stroke_costs > 1
        most = _FEW_OF_DEAR_OTHERS if is_dear else _FEW_OF_OTHERS
        for one in islice((one for one in others if _finds(one, group)), _MOST_OTHERS):
            # Where each try takes long, there are half as many.
            self.others_left -= 2 if is_dear else 1
            if self.others_left < 0:
                return None
            try:
                self._tried(one, make, most)
            except RefusalError as error:
                if error.code == TOO_FINE:
                    return None  # what is too fine for the digits is finer still with less
            else:
                return one
        return None

    def _candidates(self, cut: _Cut) -> Iterator[Conditions]:
        """What closed forms find, the best first.  Errors: VIB036, and VIB013 for what is too short."""
        if not expander_named(cut.chain.requests[0].waveform).wave.turns_back:
            return _standing(cut, command_group(self.settings))
        found = _best(cut.wanted, command_group(self.settings), cut.rules, cut.limits)
        if not found:
            raise _nothing_fits(cut, self.settings)
        long_enough = [one for one in found if _fits(one, cut, self.settings)]
        if not long_enough:
            raise _too_short(cut, found[0])
        return iter(long_enough)


class _Slower:
    """Which conditions are tried: each much slower than all before it, down to the least frequency.

    Where one is refused for the same reason as the one before it, the next is slower still.  ``most`` are
    tried.
    """

    def __init__(self, most: float) -> None:
        self.left = most
        self.below_hz = math.inf
        self.share = _SLOWER
        self.code = ""
        self.is_over = False

    def takes(self, conditions: Conditions) -> bool:
        """True for one that is worth a try."""
        return conditions.period.frequency_hz <= self.below_hz

    def behind(self, conditions: Conditions, code: str) -> None:
        """One was tried; ``code`` says why it was refused."""
        self.share = self.share * _SLOWER if code and code == self.code else _SLOWER
        self.code = code
        self.below_hz = self.share * conditions.period.frequency_hz
        self.left -= 1
        self.is_over = conditions.period.frequency_hz < _LEAST_HZ or self.left <= 0


def _cut_of(chain: Chain, settings: Settings) -> _Cut:
    """Errors: VIB001 where no speed is given, and those of the speed, the path and the control."""
    values = chain.requests[0].values
    speed = asked_of(chain, settings, []).speed
    if speed is None:
        message = f"the machine chooses N and f ({chain.requests[0].chosen_by}) near S, which is not given"
        raise RefusalError(TOO_FEW, message, "give S before the cut")
    path = path_of(legs_of(chain))
    state = chain.before
    feed_mm_rev = feed_per_rev_mm(state, speed.value)
    alpha = values["ALPHA"]
    is_even = expander_named(chain.requests[0].waveform).wave.is_even
    edges = int(values["EDGES"].value)
    wanted = Wanted(
        feed_mm_rev,
        speed.value,
        edges,
        settings.vibration.margin,
        _tolerance(chain, speed.value, settings),
        alpha.value if is_even or not alpha.origin.endswith("default") else None,
        values["A"].value if "A" in values else _times(values.get("Q"), feed_mm_rev),
    )
    law = control_along(settings, path, state)
    share = 1.0 - settings.vibration.reserve
    most_mm_s2 = law.acceleration_mm_s2 if math.isfinite(law.acceleration_mm_s2) else _USUAL_MM_S2
    limits = Limits(
        share * most_mm_s2, share * law.velocity_mm_s, settings.planner.reversal_stop_ms / MS_PER_S
    )
    rules = rules_of(settings, state, alpha.value, edges)
    return _Cut(chain, wanted, rules, law, limits, path.length_mm, speed.origin)


def _tolerance(chain: Chain, speed_rpm: float, settings: Settings) -> float:
    """How far S may go; under constant surface speed no further than all diameters of the cut allow."""
    most = settings.spindle.speed_tolerance
    surface = surface_speed_of(chain, settings)
    if surface is None or "S" in chain.requests[0].values:
        return most
    low, high = bounds_rpm(chain, surface)
    share = settings.spindle.surface_tolerance
    return max(0.0, min(most, 1.0 - high * (1.0 - share) / speed_rpm, low * (1.0 + share) / speed_rpm - 1.0))


def _times(ratio: SourcedValue | None, feed_mm: float) -> float | None:
    return None if ratio is None else ratio.value * feed_mm


@lru_cache(maxsize=256)
def _best(wanted: Wanted, group: CommandGroup, rules: SolverRules, limits: Limits) -> list[Conditions]:
    return best_first(wanted, _periods(wanted, group), rules, limits)


def _periods(wanted: Wanted, group: CommandGroup) -> tuple[Period, ...]:
    turns_hz = wanted.speed_rpm * wanted.edges / S_PER_MIN
    low_hz = LEAST_PER_REV * turns_hz * (1.0 - wanted.tolerance)
    return group.between(low_hz, MOST_PER_REV * turns_hz * (1.0 + wanted.tolerance))


def _standing(cut: _Cut, group: CommandGroup) -> Iterator[Conditions]:
    """Dwells need no acceleration: the shortest that stand for a revolution (per edge) with time to spare."""
    alpha = cut.chain.requests[0].values["ALPHA"].value
    wanted = cut.wanted
    for turns in _STANDS:
        per_rev = wanted.edges * (1.0 - alpha) / turns
        period = group.nearest(per_rev * wanted.speed_rpm / S_PER_MIN)
        per_rev = S_PER_MIN * period.frequency_hz / wanted.speed_rpm
        chip_rev = wanted.edges / per_rev
        yield Conditions(wanted.speed_rpm, per_rev, period, alpha, 0.0, 0.0, chip_rev)


def _kind(cut: _Cut) -> tuple[object, ...]:
    """What cuts have in common that run alike: straight ones of any length, others of the same shape."""
    return (cut.wanted, cut.rules, cut.law, cut.chain.axes, _shape(legs_of(cut.chain)))


def _shape(legs: Sequence[Leg]) -> tuple[object, ...]:
    """The legs of a path wherever it lies; empty for a straight one."""
    if len(legs) == 1 and not legs[0].turn:
        return ()
    return tuple((*map(sub, leg.end, leg.start), *leg[2:]) for leg in legs)


def _fits(conditions: Conditions, cut: _Cut, settings: Settings) -> bool:
    """True where the cut is long enough for one vibration of full stroke, and a ramp of half of one."""
    return _vibrations(conditions, cut, settings) >= (2.0 if _may_shorten(cut.chain) else 1.0)


def _vibrations(conditions: Conditions, cut: _Cut, settings: Settings) -> int:
    """Whole vibrations that the length has room for before the plain end."""
    dwells = settings.vibration.end == "dwell"
    turns = cut.length_mm / cut.wanted.feed_mm_rev - (0.0 if dwells else settings.vibration.end_revolutions)
    return math.floor(turns * conditions.per_rev + 1e-9)


def _is_dear(cut: _Cut, settings: Settings) -> bool:
    """True where strokes of several blocks each are run through to find their feeds."""
    form = expander_named(cut.chain.requests[0].waveform).form(settings.output.segments)
    return form == "tick" and cut.law.unlike_stroke_costs > 1


def _may_shorten(chain: Chain) -> bool:
    """True where nobody asked for the length of the ramp."""
    ramp = chain.requests[0].values.get("RAMP")
    return ramp is not None and ramp.origin.endswith("default")


def _runs(conditions: Conditions, cut: _Cut) -> bool:
    """True where the law of the control can run both strokes; a cut that dwells has none."""
    if not expander_named(cut.chain.requests[0].waveform).wave.turns_back:
        return True
    period_s = conditions.period.period_s
    advance_mm = cut.wanted.feed_mm_rev / conditions.per_rev
    back = 1.0 - conditions.alpha
    try:
        cut.law.feed_for_time(
            conditions.stroke_mm + conditions.alpha * advance_mm, conditions.alpha * period_s
        )
        back_mm = conditions.stroke_mm - back * advance_mm
        if abs(back_mm) > NO_STROKE_MM:
            cut.law.feed_for_time(back_mm, back * period_s)
    except RefusalError:
        return False
    return True


def _with(cut: _Cut, conditions: Conditions, settings: Settings) -> Chain:
    """The chain with its conditions given."""
    by = cut.chain.requests[0].chosen_by
    origin = f"chosen near S {shown(cut.wanted.speed_rpm)}, {cut.speed_origin}; {by}"
    chosen = {
        "N": SourcedValue(conditions.per_rev, origin),
        "F": SourcedValue(conditions.period.frequency_hz, origin),
    }
    if not expander_named(cut.chain.requests[0].waveform).wave.is_even:
        chosen["ALPHA"] = SourcedValue(conditions.alpha, origin)
    if _may_shorten(cut.chain):
        ramp = cut.chain.requests[0].values["RAMP"]
        room = (_vibrations(conditions, cut, settings) - 1.0) / 2.0
        if room < ramp.value:
            chosen["RAMP"] = SourcedValue(max(0.0, room), "as long as the cut allows")
    requests = []
    for request in cut.chain.requests:
        values = {key: given for key, given in request.values.items() if key != "S"}
        requests.append(request._replace(values=values | chosen, chosen_by=""))
    return Chain(tuple(requests))


def _nothing_fits(cut: _Cut, settings: Settings) -> RefusalError:
    """What the least demanding choice would need."""
    near = f"near S {shown(cut.wanted.speed_rpm)}"
    help_text = "take a lower S or a lower feed, or cut this block without vibration"
    least = least_demand(cut.wanted, _periods(cut.wanted, command_group(settings)), cut.rules, cut.limits)
    if least is None:
        message = f"no N and f that the control can command {near} break these chips"
        return RefusalError(NOTHING_FITS, message, help_text)
    has = cut.limits.acceleration_mm_s2
    if least.acceleration_mm_s2 <= has:
        message = f"no N and f {near} break these chips by the law of this control ({cut.law.name})"
        return RefusalError(NOTHING_FITS, message, help_text)
    needs = (
        f"N {shown(round(least.per_rev, 4))} at f {shown(least.period.frequency_hz)} Hz needs"
        f" {least.acceleration_mm_s2 / 1000.0:z.2f} m/s2, {cut.law.limiting} {has / 1000.0:z.2f} to give"
    )
    message = f"no N and f {near} break these chips on this machine: {needs}"
    return RefusalError(NOTHING_FITS, message, help_text)


def _share_of_limits(cut: _Cut, settings: Settings) -> float:
    """What the axes have, as a share of what the least demanding choice needs: 1 where that is enough."""
    least = least_demand(cut.wanted, _periods(cut.wanted, command_group(settings)), cut.rules, cut.limits)
    return 1.0 if least is None else min(1.0, cut.limits.acceleration_mm_s2 / least.acceleration_mm_s2)


def _lower_speeds(cut: _Cut, share: float) -> Iterator[_Cut]:
    """The cut at lower and lower speeds, from a share on; load goes with the square of the speed."""
    speed_rpm = _lowered(cut.wanted.speed_rpm, share, 1.0)
    is_per_rev = cut.chain.before.modes.feed_mode == "rev"
    while speed_rpm > cut.rules.min_rpm:
        # A feed per minute is spread over fewer revolutions.
        longer = 1.0 if is_per_rev else cut.wanted.speed_rpm / speed_rpm
        yield cut._replace(wanted=_with_feed(cut.wanted, longer * cut.wanted.feed_mm_rev, speed_rpm))
        speed_rpm = _lowered(speed_rpm, _STEP, 1.0)


def _lower_feeds(cut: _Cut, share: float) -> Iterator[_Cut]:
    """The cut with lower and lower feeds: load goes with the feed."""
    feed_mm_rev = _lowered(cut.wanted.feed_mm_rev, share, _FEED_STEP_MM)
    while feed_mm_rev > 0.0:
        wanted = _with_feed(cut.wanted, feed_mm_rev, cut.wanted.speed_rpm)
        yield cut._replace(wanted=wanted, chain=fed(cut.chain, feed_mm_rev / cut.wanted.feed_mm_rev))
        feed_mm_rev = _lowered(feed_mm_rev, _STEP, _FEED_STEP_MM)


def _lowered(value: float, share: float, step: float) -> float:
    """The value times a share, in whole steps downwards."""
    return max(0.0, round(math.floor(min(value * share, value - step) / step + 1e-9) * step, 9))


def _with_feed(wanted: Wanted, feed_mm_rev: float, speed_rpm: float) -> Wanted:
    """The same cut with another feed and speed; a stroke that was asked for goes with the feed."""
    share = feed_mm_rev / wanted.feed_mm_rev
    stroke_mm = None if wanted.stroke_mm is None else wanted.stroke_mm * share
    return wanted._replace(feed_mm_rev=feed_mm_rev, stroke_mm=stroke_mm, speed_rpm=speed_rpm)


def _finds(cut: _Cut, group: CommandGroup) -> bool:
    """True where closed forms and the law find conditions for a cut."""
    best = _best(cut.wanted, group, cut.rules, cut.limits)[:_MOST_TRIED]
    return any(_runs(one, cut) for one in best)


def _too_short(cut: _Cut, best: Conditions) -> RefusalError:
    turns = cut.length_mm / cut.wanted.feed_mm_rev
    message = (
        f"too short to vibrate: {shown(round(cut.length_mm, 4))} mm is {turns:z.2f} revolutions, and two"
        f" vibrations of N {shown(round(best.per_rev, 4))} take {2.0 / best.per_rev:z.2f} and the plain end"
    )
    return RefusalError(TOO_SHORT, message, "cut this block without vibration: its chips are short")
