"""What a control can run instead of a cut that it cannot, for the way out of a refusal; all of it tried."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace

from chipbreak.kinematics.sourced_value import shown
from chipbreak.kinematics.speed_solver import ABOVE_CLAMP, NEVER_BREAKS, TOO_SLOW, Period
from chipbreak.kinematics.waveform import forward_ticks
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.beginning import LIMITS, failure_of
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.choice import NO_STROKE_MM, NOTHING_FITS, Chooser
from chipbreak.vibration.diameter_steps import diameter_steps
from chipbreak.vibration.dwell import NO_STAND
from chipbreak.vibration.machine import control_along
from chipbreak.vibration.plan import CutPlan, command_group, plan_cut
from chipbreak.vibration.trial import Trials, first_by_halving, with_values

_ACCELERATION = "VIB030"
_LEAST_SHARE = 0.05  # no cut is made at a twentieth of its speed
_NEED = re.compile(r"needs ([0-9.e+]+) m/s2")
_TURNS = re.compile(r"take E ([0-9.]+)")
_NUMBERS = re.compile(r"\b([SNf]) ([0-9.]+(?: Hz)?(?:(?: or |, | and )[0-9.]+)*)")
# What is left of a help whose numbers do not work.
_WITHOUT_NUMBERS = {
    NEVER_BREAKS: "take another N that is not whole, or another S",
    ABOVE_CLAMP: "give a lower f or a larger N",
    TOO_SLOW: "give another S, or N and f without S",
}
_MOST_LENGTHENED = 8
_LONGER = 1.07  # times a vibration that was not long enough
_MORE = 1.12  # times what was not enough, where the refusal does not say more
_MOST_RAISED = 7
_DIGITS = 3


def with_advice(error: RefusalError, cut: CutPlan, settings: Settings) -> RefusalError:
    """The same refusal; where a limit of the control is the cause, with what has been tried and works.

    That is the next slower frequency with the same N, what the machine would choose, and a dwell; and the
    acceleration that it names is one that suffices for every stroke of the cut.
    """
    if error.code not in LIMITS:
        return tried(error, cut.chain, settings)
    message = _with_all_strokes(error, cut, settings)
    ways = [_first_help(error, cut)]
    slower = _slower(cut, settings)
    if slower is not None:
        ways.append(slower.text)
    ways += _other_ways(cut, settings)
    return RefusalError(error.code, message, "; ".join(ways), (slower.word,) if slower else ())


def tried(error: RefusalError, chain: Chain, settings: Settings) -> RefusalError:
    """The same refusal of S, N and f, or of a dwell: of the numbers in its help those that work."""
    if error.code == NO_STAND:
        return _with_longer_stand(error, chain, settings)
    named = _named_in(error)
    trials = Trials(settings)
    works = [one for one in named if trials.works(one.in_chain(chain)) is not None]
    if len(works) == len(named):
        return error
    if not works:
        way = _from_there(named[0].in_chain(chain), settings)
        return RefusalError(error.code, error.message, way) if way else untried(error)
    said = " or ".join(one.text for one in works)
    words = {one.word for one in works}
    instead = tuple(word for word in error.instead if word in words)
    return RefusalError(error.code, error.message, f"works: {said}", instead)


def _from_there(chain: Chain, settings: Settings) -> str:
    """What works where a chain with the numbers of a help does not: lower, or as the machine chooses."""
    try:
        cut = plan_cut(chain, settings)
    except RefusalError:
        return ""
    slower = _slower(cut, settings)
    return slower.text if slower is not None else chosen(cut, settings)


def untried(error: RefusalError) -> RefusalError:
    """The same refusal without the numbers that nobody has tried."""
    message = _NEED.sub(r"needs more than \1 m/s2", error.message) if error.code in LIMITS else error.message
    if error.code == NO_STAND:
        return RefusalError(error.code, message, _TURNS.sub("take a larger E", error.help, count=1))
    if _named_in(error):
        return RefusalError(error.code, message, _WITHOUT_NUMBERS[error.code])
    return RefusalError(error.code, message, error.help, error.instead)


class _Named(NamedTuple):
    """A number that a help names: S, N or f."""

    letter: str
    number: str

    @property
    def text(self) -> str:
        """As people read it."""
        return f"{self.letter} {self.number}" + (" Hz" if self.letter == "f" else "")

    @property
    def word(self) -> str:
        """As a word of the block."""
        return f"{self.letter}{self.number}"

    def in_chain(self, chain: Chain) -> Chain:
        """The chain with it."""
        key = self.letter.upper()
        return with_values(chain, {key: float(self.number)}, without="NE" if key == "N" else key)


def _named_in(error: RefusalError) -> list[_Named]:
    if error.code not in _WITHOUT_NUMBERS:
        return []
    return [
        _Named(match[1], number)
        for match in _NUMBERS.finditer(error.help)
        for number in re.findall(r"[0-9.]+", match[2])
    ]


def _with_longer_stand(error: RefusalError, chain: Chain, settings: Settings) -> RefusalError:
    """The same refusal of a dwell, with an E that has been tried: S and whole base periods go with it."""
    said = _TURNS.search(error.help)
    trials = Trials(settings)
    turns = float(said[1]) if said else 0.0
    for _ in range(_MOST_LENGTHENED if said else 0):
        longer = with_values(chain, {"E": turns}, without="NF")
        if trials.works(longer) is not None:
            help_text = _TURNS.sub(f"take E {turns:g}", error.help, count=1)
            return RefusalError(error.code, error.message, help_text, error.instead)
        turns = math.ceil(turns * _LONGER * 10.0) / 10.0
    return untried(error)


class _Slower(NamedTuple):
    """A frequency that works, in a sentence and as a word of the block."""

    text: str
    word: str


def _other_ways(cut: CutPlan, settings: Settings) -> Iterator[str]:
    for rule in (chosen, _standing):
        way = rule(cut, settings)
        if way:
            yield way


def _first_help(error: RefusalError, cut: CutPlan) -> str:
    """The help of a refusal, but of too many blocks that which is left with the form of this cut."""
    if error.code != "VIB032":
        return error.help
    return cut.expander.way_out_of_too_many_blocks(cut.wave.form)


def _with_all_strokes(error: RefusalError, cut: CutPlan, settings: Settings) -> str:
    """The message with the acceleration that every stroke can run with, in place of that of the first."""
    said = _NEED.search(error.message)
    if error.code != _ACCELERATION or said is None:
        return error.message
    need = max(
        float(said[1]), cut.wave.shape.least_acceleration_mm_s2(cut.wave, cut.solution.per_rev) / 1000.0
    )
    trials = Trials(settings)
    for _ in range(_MOST_RAISED):
        need = _rounded_up(need)
        if trials.works(cut.chain, _with_acceleration(settings, cut.chain.axes, need * 1000.0)) is not None:
            return error.message.replace(said[0], f"needs {need:.{_DIGITS}g} m/s2", 1)
        more = _NEED.search(trials.refusal)
        if trials.refusal and more is None:
            break  # something else is in the way too
        need = max(_MORE * need, float(more[1]) if more else 0.0)
    return error.message.replace(said[0], f"needs more than {said[1]} m/s2", 1)


def _rounded_up(value: float) -> float:
    """To as many digits as are shown."""
    unit = 10.0 ** (math.floor(math.log10(value)) - _DIGITS + 1)
    return math.ceil(value / unit - 1e-9) * unit


def _with_acceleration(settings: Settings, axes: str, acceleration_mm_s2: float) -> Settings:
    """A machine whose axes have at least so much, and along the path too where that has a limit."""
    changed = {}
    for name in axes:
        axis = settings.axes[name]
        has = axis.max_acceleration_mm_s2
        changed[name] = replace(axis, max_acceleration_mm_s2=max(has or 0.0, acceleration_mm_s2))
    path = settings.planner.path_acceleration_mm_s2
    most = None if path is None else max(path, acceleration_mm_s2)
    planner = replace(settings.planner, path_acceleration_mm_s2=most)
    return replace(settings, axes={**settings.axes, **changed}, planner=planner)


def _slower(cut: CutPlan, settings: Settings) -> _Slower | None:
    """The next slower frequency that works with the same N."""
    trials = Trials(settings)
    law = control_along(settings, cut.path, cut.chain.before)
    per_rev = round(cut.solution.per_rev, 4)
    top_hz = cut.solution.frequency_hz
    slower = command_group(settings).between(_LEAST_SHARE * top_hz, top_hz * (1.0 - 1e-6))
    found: dict[int, float] = {}

    def works(place: int) -> bool:
        # The digits that are shown are those that people type.
        wish = {"N": per_rev, "F": float(shown(slower[place].frequency_hz))}
        report = None
        if _runs(cut, slower[place], law):
            report = trials.works(with_values(cut.chain, wish, without="SE"))
        if report is not None:
            found[place] = report.plan.solution.speed_rpm
        return report is not None

    place = _first(works, len(slower))
    if place is None:
        return None
    frequency = shown(slower[place].frequency_hz)
    text = f"N {shown(per_rev)} with the same feed works at f {frequency} Hz, S {found[place]:z.0f}"
    return _Slower(text, f"f{frequency}")


def _first(holds: Callable[[int], bool], count: int) -> int | None:
    """The first place, below ``count``, from which on something holds; None where it holds nowhere."""
    before = -1
    step = 1
    while (place := min(before + step, count - 1)) > before:
        if holds(place):
            return first_by_halving(holds, before, place)
        before = place
        step *= 2
    return None


def chosen(cut: CutPlan, settings: Settings) -> str:
    """What the machine would choose near the programmed speed, for the whole chain or each of its blocks."""
    if not cut.wave.shape.turns_back:
        return ""
    whole = cut.chain.whole or cut.chain
    requests = []
    for request in whole.requests:
        values = {key: given for key, given in request.values.items() if key not in "NEF"}
        requests.append(request._replace(values=values, chosen_by="AUTO"))
    instead = "(VIB AUTO) in place of N and f takes"
    steps = diameter_steps(Chain(tuple(requests)), settings, is_open=True)
    found = [_choice(step, settings) for step in steps]
    if found[0] is not None and len(found) == 1:
        solution = found[0].solution
        chosen_here = f"N {solution.per_rev:.4g} f {solution.frequency_hz:.4g} Hz S {solution.speed_rpm:z.0f}"
        return f"{instead} {chosen_here}"
    if all(one is not None for one in found):
        return f"{instead} each step of this cut on its own"
    is_chain = len(requests) > 1 and len(steps) == 1
    if is_chain and all(_choice(Chain((request,)), settings) is not None for request in requests):
        return f"{instead} each block of this cut on its own"
    return ""


def _choice(chain: Chain, settings: Settings) -> CutPlan | None:
    """What the machine chooses; None where it finds nothing in a few tries."""
    trials = Trials(settings)
    try:
        return Chooser(settings).cut(chain, lambda one: _made(one, trials))[0]
    except (RefusalError, SelfCheckError):
        return None


def _made(chain: Chain, trials: Trials) -> tuple[CutPlan, Expansion]:
    """Errors: RefusalError, also where no more may be tried."""
    plan = plan_cut(chain, trials.settings)
    if not trials.affords(plan):
        raise RefusalError(NOTHING_FITS, "nothing was found in as many tries as are made", "give N, f and S")
    if failure_of(plan, trials.settings) is not None:
        raise RefusalError(NOTHING_FITS, "it fails from its beginning on", "give N, f and S")
    return plan, moves_of(plan, trials.settings)


def _standing(cut: CutPlan, settings: Settings) -> str:
    """What needs no reversal: at this E half of what is left to the stand is to spare."""
    turns = round(1.5 / cut.edges / (1.0 - cut.wave.alpha_share), 2)
    standing = with_values(cut.chain, {"E": turns}, without="NEFQA", waveform="dwell")
    if Trials(settings).works(standing) is None:
        return ""
    has_stroke = cut.chain.requests[0].values.keys() & {"Q", "A"}
    without = ", without Q and A," if has_stroke else ""
    return f"WAVE DWELL with E {shown(turns)}{without} never turns back and stands instead"


def _runs(cut: CutPlan, period: Period, law: ControlLaw) -> bool:
    """True when both strokes of a full vibration can be run in a slower period."""
    share = forward_ticks(period.ticks, cut.wave.alpha_share) / period.ticks
    # A feed per minute is spread over the revolutions of the slower spindle.
    speed_rpm = S_PER_MIN * period.frequency_hz / cut.solution.per_rev
    is_per_rev = cut.chain.before.modes.feed_mode == "rev"
    longer = 1.0 if is_per_rev else cut.solution.speed_rpm / speed_rpm
    advance_mm = longer * cut.wave.feed_mm_rev / cut.solution.per_rev
    stroke_mm = longer * cut.wave.stroke_mm
    back_mm = stroke_mm - (1.0 - share) * advance_mm
    try:
        law.feed_for_time(stroke_mm + share * advance_mm, share * period.period_s)
        if back_mm > NO_STROKE_MM:
            law.feed_for_time(back_mm, (1.0 - share) * period.period_s)
    except RefusalError:
        return False
    return True
