"""From a chain to its vibration: which S, N and f, which stroke, and the knots of the motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, cast

from chipbreak.kinematics.floats import Floats
from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.kinematics.speed_solver import (
    NEVER_BREAKS,
    TOO_FEW,
    CommandGroup,
    Solution,
    SolverRules,
    solve,
)
from chipbreak.kinematics.toolpath import Path, path_of
from chipbreak.kinematics.waveform import WaveformParameters, forward_ticks, sample
from chipbreak.model.modal import LOOPED, UNREAD, State
from chipbreak.model.words import JUMPED
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.trajectory.filters import NO_FILTER
from chipbreak.trajectory.law import ControlLaw
from chipbreak.units import MS_PER_S, S_PER_MIN, typed_surface_speed
from chipbreak.vibration.chain import Chain, legs_of
from chipbreak.vibration.compensation import Asked, compensated
from chipbreak.vibration.expander import Expander, StrokeAsked
from chipbreak.vibration.expanders import expander_named
from chipbreak.vibration.least_stroke import refuse_too_fine, with_feed_per_minute
from chipbreak.vibration.machine import axes_follow_exactly, control_along, directions_of
from chipbreak.vibration.request import OUT_OF_RANGE, solver_inputs
from chipbreak.vibration.surface_speed import active_speed, limit_rpm

TOO_MANY = "VIB021"
# Of one cut, so that it is followed in about two seconds and half a gigabyte.
MOST_MOVES = 450_000
MOST_PLANNED_MOVES = 250_000  # planned as a whole, or by several laws because the profile leaves one open
MOST_DWELLS = 50_000
MOST_UNLIKE_MOVES = 100_000  # of strokes of several blocks round bends, each run in its own way
MOST_STROKES_ROUND_BENDS = 170_000  # each axis behind its own filter
MOST_PERIODS = 20_000_000  # hours; each takes 8 to 16 bytes where a law is followed period by period
MOST_MOVES_IN_ALL = 2_000_000  # of all cuts of a program: hours of cutting
_FEWER = "take a lower N or a higher feed, or make it several cuts with a rapid between"
_MOST_GAPS = 40_000  # between a knot of a vibration and the passes before it, for every such pass
_NO_REVOLUTIONS = 1e-9


@dataclass(frozen=True, eq=False)
class CutPlan:
    """A chain with everything decided.

    ``given`` keeps what was asked, for the report; ``time_s`` and ``distance_mm`` are the knots of the
    motion along ``path``, shape (n,).  ``end_dwell_s`` is how long the tool then dwells at the end.
    """

    chain: Chain
    path: Path
    solution: Solution
    given: Mapping[str, SourcedValue]
    wave: WaveformParameters
    edges: int
    time_s: Floats
    distance_mm: Floats
    reasons: tuple[str, ...]
    end_dwell_s: float = 0.0

    def __repr__(self) -> str:
        lines = f"lines {self.chain.first} to {self.chain.last}"
        return f"<CutPlan of {lines}: N {self.solution.per_rev:.4g} at S{self.solution.speed_rpm:g}>"

    @property
    def expander(self) -> Expander:
        """How a cut of this wave becomes blocks."""
        return expander_named(self.wave.waveform)


class SpeedsAsked(NamedTuple):
    """S, N and f as asked for, two of them."""

    speed: SourcedValue | None
    per_rev: SourcedValue | None
    frequency: SourcedValue | None

    @property
    def given(self) -> dict[str, SourcedValue]:
        """Those that were, for the report."""
        return {k: g for k, g in zip("SNF", self, strict=True) if g is not None}


def command_group(settings: Settings) -> CommandGroup:
    """The frequencies the control can command."""
    command = settings.command
    periods = command.periods_ms
    return CommandGroup(
        base_period_s=command.base_period_ms / MS_PER_S,
        min_multiple=command.min_multiple,
        max_multiple=command.max_multiple,
        multiples=command.multiples,
        periods_s=None if periods is None else tuple(p / MS_PER_S for p in periods),
    )


def plan_cut(chain: Chain, settings: Settings) -> CutPlan:
    """Decide speed, count, frequency and stroke of a chain and sample its motion.

    Errors: RefusalError with the codes of the solver, the path and the waveform, VIB021 for a cut of too many
    blocks, and VIB053 for a spindle speed that cannot be known.
    """
    request = chain.requests[0]
    state = chain.before
    expander = expander_named(request.waveform)
    reasons: list[str] = []
    asked = asked_of(chain, settings, reasons)
    expander.refuse_share(request.values["ALPHA"])
    path = path_of(legs_of(chain))
    solution = _solved(asked, chain, expander, settings)
    wave = _wave_of(chain, path.length_mm, solution, expander, settings)
    values = request.values
    edges = int(values["EDGES"].value)
    alpha = values["ALPHA"].value
    if settings.planner.dwell_step_ms is not None:
        wave = expander.in_whole_dwells(wave, control_along(settings, path, state), edges)
    _check_passes(wave, edges)
    _check_size(wave, expander, path, state, settings)
    wave = _commanded(wave, chain, path, settings, reasons)
    refuse_too_fine(wave, path, state, expander.larger, settings)
    time_s, distance_mm = sample(wave)
    reasons += wave.shape.remarks(wave.ticks)
    if not math.isclose(wave.alpha_share, alpha, abs_tol=1e-9):
        whole = f"{wave.forward_ticks * solution.period.ticks / wave.ticks:.5g} of {solution.period.ticks}"
        whole += " base periods"
        reasons.append(f"forward share {alpha:g} -> {wave.alpha_share:g}, {whole}")
    if asked.speed is None and state.speed is not None and state.speed.value != solution.speed_rpm:
        reasons.append(f"S {_typed_speed(state)} -> {solution.speed_rpm:g} rpm, which N and f fix")
    return CutPlan(
        chain,
        path,
        solution,
        asked.given,
        wave,
        edges,
        time_s,
        distance_mm,
        (*reasons, *solution.reasons),
        _end_dwell_s(wave, chain, path, settings),
    )


def _end_revolutions(settings: Settings) -> float:
    """Those of the plain end; so few that no block stands for them are none."""
    asked = settings.vibration.end_revolutions
    return asked if asked > _NO_REVOLUTIONS else 0.0


def _end_dwell_s(wave: WaveformParameters, chain: Chain, path: Path, settings: Settings) -> float:
    """How long the tool dwells at the end so that it rests there for the revolutions asked for."""
    if not _dwells_at_end(settings):
        return 0.0
    end_s = settings.vibration.end_revolutions * S_PER_MIN / wave.speed_rpm
    if axes_follow_exactly(settings):
        return end_s
    return end_s + control_along(settings, path, chain.before).axes_late_s(wave.feed_speed_mm_s)


def _commanded(
    wave: WaveformParameters, chain: Chain, path: Path, settings: Settings, reasons: list[str]
) -> WaveformParameters:
    """The wave with the stroke of which the axes make enough; one that was asked for stays as it is."""
    is_given = chain.requests[0].values.keys() & {"Q", "A"}
    if is_given or not wave.shape.turns_back or axes_follow_exactly(settings):
        return wave
    law = control_along(settings, path, chain.before)
    edges = int(chain.requests[0].values["EDGES"].value)
    asked = Asked(settings.vibration.margin, edges)
    found = compensated(wave, asked, law, directions_of(path))
    if found.stroke_mm > wave.stroke_mm:
        reasons.append(
            f"stroke {wave.stroke_mm:.4g} -> {found.stroke_mm:.4g} mm commanded: the axes leave the rest"
        )
    if found.ramp_in_s > wave.ramp_in_s:
        reasons.append(
            f"ramp {wave.ramp_in_s:.3g} -> {found.ramp_in_s:.3g} s, as the stroke is so much larger"
        )
    return found


def _dwells_at_end(settings: Settings) -> bool:
    """True where the tool dwells at the end of a cut instead of feeding plainly."""
    return settings.vibration.end == "dwell"


def asked_of(chain: Chain, settings: Settings, reasons: list[str]) -> SpeedsAsked:
    """S, N and f as a chain asks for them; under constant surface speed S is that of its start.

    Errors: VIB053 and VIB054 for a speed that cannot be known.
    """
    asked = SpeedsAsked(*solver_inputs(chain.requests[0], chain.before))
    if "S" in chain.requests[0].values or asked.speed is None:
        return asked
    return asked._replace(speed=active_speed(chain, asked.speed, settings, reasons))


def _solved(asked: SpeedsAsked, chain: Chain, expander: Expander, settings: Settings) -> Solution:
    """S, N and f; a refusal with the way out that this cut has."""
    values = chain.requests[0].values
    state = chain.before
    edges = int(values["EDGES"].value)
    alpha = values["ALPHA"].value
    rules = rules_of(settings, state, alpha, edges)
    try:
        return solve(**asked._asdict(), group=command_group(settings), rules=rules)
    except RefusalError as error:
        way_out = expander.way_out_of_whole(edges, alpha)
        if error.code == NEVER_BREAKS and way_out:
            raise RefusalError(error.code, error.message, way_out) from None
        why = state.unknown_why
        if error.code == TOO_FEW and asked.speed is None and _hides_speed(why):
            message = f"{error.message}; the active S is not known: {why}"
            raise RefusalError(error.code, message, "give S between there and this cut") from None
        raise


def _hides_speed(unknown_why: str) -> bool:
    """True where what hides a place also hides the active S."""
    return unknown_why in (JUMPED, LOOPED) or unknown_why.endswith(UNREAD)


def _wave_of(
    chain: Chain, length_mm: float, solution: Solution, expander: Expander, settings: Settings
) -> WaveformParameters:
    """The wave of a chain: its stroke, its ramp, and the form of its moves."""
    values = chain.requests[0].values
    wave = expander.wave
    feed_mm_rev = feed_per_rev_mm(chain.before, solution.speed_rpm)
    ticks = solution.period.ticks
    forward = forward_ticks(ticks, values["ALPHA"].value, rounds_down=wave.rounds_down)
    asked = StrokeAsked(
        values,
        per_rev=solution.per_rev,
        feed_mm_rev=feed_mm_rev,
        alpha_share=wave.share(forward, ticks),
        edges=int(values["EDGES"].value),
        margin=settings.vibration.margin,
        ticks=ticks,
    )
    return WaveformParameters(
        length_mm=length_mm,
        feed_mm_rev=feed_mm_rev,
        speed_rpm=solution.speed_rpm,
        period_s=solution.period.period_s,
        ticks=ticks,
        forward_ticks=forward,
        stroke_mm=expander.stroke_mm(asked),
        waveform=wave.name,
        ramp_in_s=expander.ramp_s(_ramp_s(values, solution, settings)),
        ramp_exponent=values["K"].value,
        end_revolutions=0.0 if _dwells_at_end(settings) else _end_revolutions(settings),
        form=expander.form(settings.output.segments),
    )


class _Bound(NamedTuple):
    """How many of something a cut would have, the most that it may have, and the way out."""

    found: int
    most: int
    of: str
    help: str


def _check_size(
    wave: WaveformParameters, expander: Expander, path: Path, state: State, settings: Settings
) -> None:
    for bound in _bounds(wave, expander, path, control_along(settings, path, state)):
        if bound.found > bound.most:
            message = f"this cut would become {bound.found} {bound.of}; {bound.most} of them are the most"
            raise RefusalError(TOO_MANY, *with_feed_per_minute(message, bound.help, state, wave.feed_mm_rev))


def _bounds(wave: WaveformParameters, expander: Expander, path: Path, law: ControlLaw) -> Iterator[_Bound]:
    if expander.keeps_feed:
        yield _Bound(wave.vibrations, MOST_DWELLS, "moves with a dwell each", _FEWER)
    elif _follows_bends(law, path):
        of = "strokes round corners or arcs, where each axis follows behind its own filter"
        yield _Bound(2 * wave.vibrations, MOST_STROKES_ROUND_BENDS, of, _FEWER)
    moves = wave.vibrations * wave.knots_per_vibration
    if wave.form == "tick" and law.unlike_stroke_costs > 1 and _bends(path):
        of = f"blocks round corners or arcs, where this control ({law.name}) runs no two strokes alike"
        yield _Bound(moves, MOST_UNLIKE_MOVES, of, _FEWER)
    fewer = 'take output.segments "stroke", a lower f, or a higher feed'
    if law.plans_whole or len(law.variants()) > 1:
        of = f"blocks, which the law of this control ({law.name}) plans again and again"
        yield _Bound(moves, MOST_PLANNED_MOVES, of, fewer)
    yield _Bound(moves, MOST_MOVES, "blocks", fewer)
    if law.runs_whole_periods:
        periods = round(path.length_mm / wave.feed_speed_mm_s / law.servo_period_s)
        hint = "take a higher S or feed, or make it several cuts with a rapid between"
        yield _Bound(periods, MOST_PERIODS, "servo periods of the control", hint)


def _follows_bends(law: ControlLaw, path: Path) -> bool:
    """True where each axis follows on its own, and what they make must be sought along the path."""
    return any(axis.filter != NO_FILTER for axis in law.axes) and _bends(path)


def _bends(path: Path) -> bool:
    return any(arc is not None for arc in path.arcs) or len(path.corners_mm()) > 0


def _check_passes(wave: WaveformParameters, edges: int) -> None:
    """Refuse a stroke over so many passes that judging its chips would take minutes.

    Nearer than that to a whole N no stroke is asked for, so it is a feed or a stroke in another unit.
    """
    passes = wave.stroke_mm / wave.feed_mm_rev * edges
    turn_s = S_PER_MIN / wave.speed_rpm / edges
    knots = wave.knots_per_vibration * max(1.0, turn_s / wave.period_s)
    if knots * passes**2 > _MOST_GAPS:
        times = f"{wave.stroke_mm / wave.feed_mm_rev:z.0f} times the feed of {shown(wave.feed_mm_rev)} mm/rev"
        message = f"the stroke of {shown(wave.stroke_mm)} mm is {times}, out of range"
        help_text = "give a higher feed (is its unit the right one?), or a smaller Q or A"
        if wave.form == "tick":
            help_text += ', or take output.segments "stroke"'
        raise RefusalError(OUT_OF_RANGE, message, help_text)


def _typed_speed(state: State) -> str:
    """The S in force as the program counts it."""
    assert state.speed is not None
    if state.modes.speed_mode == "rpm":
        return f"{state.speed.value:g}"
    return f"{typed_surface_speed(state.speed.value, is_inch=state.is_inch):g} (G96)"


def rules_of(settings: Settings, state: State, alpha: float, edges: int) -> SolverRules:
    """How the solver may correct S, N and f of a cut."""
    vibration = settings.vibration
    phase = 1.0 - alpha if isinstance(vibration.phase, str) else vibration.phase
    return SolverRules(
        rounding=cast(Literal["nearest-half", "claim-7"], vibration.rounding),
        phase=phase,
        pn=vibration.pn,
        mn=vibration.mn,
        correct=cast(Literal["spindle", "count"], vibration.correct),
        resolution_rpm=settings.spindle.resolution_rpm,
        edges=edges,
        min_rpm=settings.spindle.min_rpm,
        max_rpm=limit_rpm(state, settings),
    )


def feed_per_rev_mm(state: State, speed_rpm: float) -> float:
    """The feed per revolution of a state at a spindle speed."""
    assert state.feed is not None
    feed_mm = state.feed.value
    return feed_mm if state.modes.feed_mode == "rev" else feed_mm / speed_rpm


def _ramp_s(values: Mapping[str, SourcedValue], solution: Solution, settings: Settings) -> float:
    if "RAMP" in values:
        return values["RAMP"].value * solution.period.period_s
    return settings.vibration.ramp_s or 0.0
