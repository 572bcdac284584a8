"""From a chain to its vibration: which S, N and f, which stroke, and the knots of the motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

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
from chipbreak.kinematics.waveform import Waveform, WaveformParameters, forward_ticks, least_stroke_mm, sample
from chipbreak.model.modal import LOOPED, UNREAD, State
from chipbreak.model.words import JUMPED
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.units import MM_PER_INCH, MS_PER_S, S_PER_MIN, spindle_speed_rpm
from chipbreak.vibration.chain import Chain, legs_of
from chipbreak.vibration.request import OUT_OF_RANGE, solver_inputs

_MOST_RPM = 1e7
MOST_MOVES = 10_000_000
_MOST_GAPS = 4_000_000  # between a knot of a vibration and the passes before it, for every such pass
_FEET_PER_M = 1000.0 / 304.8


@dataclass(frozen=True, eq=False)
class CutPlan:
    """A chain with everything decided.

    ``given`` keeps what was asked, for the report; ``time_s`` and ``distance_mm`` are the knots of the
    motion along ``path``, shape (n,).  ``end_stand_s`` is how long the tool then stands at the end.
    """

    chain: Chain
    path: Path
    solution: Solution
    given: Mapping[str, SourcedValue]
    wave: WaveformParameters
    edges: int
    time_s: NDArray[np.float64]
    distance_mm: NDArray[np.float64]
    reasons: tuple[str, ...]
    end_stand_s: float = 0.0

    @property
    def keeps_feed(self) -> bool:
        """True when every move has the program's own feed, in its own mode."""
        return self.wave.waveform == "dwell"


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
    request, state = chain.requests[0], chain.before
    edges = int(request.values["EDGES"].value)
    speed, per_rev, frequency = solver_inputs(request, state)
    reasons: list[str] = []
    if "S" not in request.values and speed is not None:
        speed = _active_speed(chain, state, speed, settings, reasons)
    alpha = _forward_share(request.values["ALPHA"], cast(Waveform, request.waveform))
    path = path_of(legs_of(chain))
    group = command_group(settings)
    rules = _rules(settings, state, alpha, edges)
    try:
        solution = solve(speed=speed, per_rev=per_rev, frequency=frequency, group=group, rules=rules)
    except RefusalError as error:
        if request.waveform == "dwell" and error.code == NEVER_BREAKS:
            turns = 1.0 / edges / (1.0 - alpha)
            way_out = f"take E {turns:.4g} or more: a dwell stands for a revolution (per edge)"
            raise RefusalError(error.code, error.message, way_out) from None
        why = state.unknown_why
        if error.code == TOO_FEW and speed is None and (why in (JUMPED, LOOPED) or why.endswith(UNREAD)):
            message = f"{error.message}; the active S is not known: {why}"
            raise RefusalError(error.code, message, "give S between there and this cut") from None
        raise
    cut = _cut_of(chain, path.length_mm, solution, settings)
    if cut.waveform != "sine" and not math.isclose(cut.alpha_share, alpha, abs_tol=1e-9):
        whole = f"{cut.forward_ticks} of {cut.ticks} base periods"
        reasons.append(f"forward share {alpha:g} -> {cut.alpha_share:g}, {whole}")
    _check_size(cut)
    _check_passes(cut, edges)
    time_s, distance_mm = sample(cut)
    if speed is None and state.speed is not None and state.speed.value != solution.speed_rpm:
        mode = " (G96)" if state.modes.speed_mode == "surface" else ""
        reasons.append(f"S {state.speed.value:g}{mode} -> {solution.speed_rpm:g} rpm, which N and f fix")
    given = {k: g for k, g in (("S", speed), ("N", per_rev), ("F", frequency)) if g is not None}
    all_reasons = (*reasons, *solution.reasons)
    end_stand_s = 0.0
    if settings.vibration.end == "dwell":
        end_stand_s = settings.vibration.end_revolutions * S_PER_MIN / solution.speed_rpm
    return CutPlan(chain, path, solution, given, cut, edges, time_s, distance_mm, all_reasons, end_stand_s)


def _cut_of(chain: Chain, length_mm: float, solution: Solution, settings: Settings) -> WaveformParameters:
    """The wave of a chain: its stroke, its ramp, and the form of its moves."""
    request = chain.requests[0]
    values, waveform = request.values, cast(Waveform, request.waveform)
    feed_mm_rev = _feed_mm_rev(chain.before, solution.speed_rpm)
    ticks = solution.period.ticks
    forward = forward_ticks(ticks, values["ALPHA"].value, rounds_down=waveform == "dwell")
    form = settings.output.segments
    if form == "auto" or waveform == "dwell":
        form = "tick" if waveform == "sine" else "stroke"
    stroke_mm = _stroke_mm(
        values,
        solution,
        waveform=waveform,
        feed_mm_rev=feed_mm_rev,
        alpha=0.5 if waveform == "sine" else forward / ticks,
        edges=int(values["EDGES"].value),
        margin=settings.vibration.margin,
    )
    return WaveformParameters(
        length_mm=length_mm,
        feed_mm_rev=feed_mm_rev,
        speed_rpm=solution.speed_rpm,
        period_s=solution.period.period_s,
        ticks=ticks,
        forward_ticks=forward,
        stroke_mm=stroke_mm,
        waveform=waveform,
        ramp_in_s=0.0 if waveform == "dwell" else _ramp_s(values, solution, settings),
        ramp_exponent=values["K"].value,
        end_revolutions=0.0 if settings.vibration.end == "dwell" else settings.vibration.end_revolutions,
        form=cast(Literal["tick", "stroke"], form),
    )


def _check_size(cut: WaveformParameters) -> None:
    moves = cut.vibrations * cut.knots_per_vibration
    if moves > MOST_MOVES:
        message = f"this cut would become {moves} blocks; no program may have more than {MOST_MOVES} of them"
        raise RefusalError("VIB021", message, 'take output.segments "stroke", a lower f, or a higher feed')


def _check_passes(cut: WaveformParameters, edges: int) -> None:
    """Refuse a stroke over so many passes that judging its chips would take minutes.

    Nearer than that to a whole N no stroke is asked for, so it is a feed or a stroke in another unit.
    """
    passes = cut.stroke_mm / cut.feed_mm_rev * edges
    turn_s = S_PER_MIN / cut.speed_rpm / edges
    knots = cut.knots_per_vibration * max(1.0, turn_s / cut.period_s)
    if knots * passes**2 > _MOST_GAPS:
        times = f"{cut.stroke_mm / cut.feed_mm_rev:.0f} times the feed of {shown(cut.feed_mm_rev)} mm/rev"
        message = f"the stroke of {shown(cut.stroke_mm)} mm is {times}, out of range"
        help_text = "give a higher feed (is its unit the right one?), or a smaller Q or A"
        if cut.form == "tick":
            help_text += ', or take output.segments "stroke"'
        raise RefusalError(OUT_OF_RANGE, message, help_text)


def _active_speed(
    chain: Chain, state: State, speed: SourcedValue, settings: Settings, reasons: list[str]
) -> SourcedValue:
    """The modal S as rpm; under constant surface speed, the speed at the start of the cut."""
    if not 0.0 < speed.value < _MOST_RPM:
        message = f"the spindle speed ({speed.origin}) cannot be known, is zero, or is none of a spindle"
        raise RefusalError("VIB053", message, "give S as a number before the cut")
    if state.modes.speed_mode != "surface":
        return speed
    diameter_mm = 2.0 * abs(next(chain.moves).start.x)
    limit = _limit_rpm(state, settings)
    surface_m_min = speed.value / (_FEET_PER_M if state.is_inch else 1.0)
    rpm = spindle_speed_rpm(surface_m_min, diameter_mm) if diameter_mm > 0.0 else math.inf
    if math.isnan(rpm) or (math.isinf(rpm) and limit is None):
        message = "constant surface speed (G96) has no finite speed where this cut starts"
        raise RefusalError("VIB054", message, "give G97 S, or limit the spindle (G50 S, G92 S, G96 D)")
    step = settings.spindle.resolution_rpm
    rpm = math.floor(min(rpm, limit or math.inf) / step + 0.5) * step
    if limit is not None and rpm > limit:
        rpm = math.floor(limit / step) * step
    rpm = round(rpm, 9)  # 25862 * 0.1 is not 2586.2 in binary
    reasons.append(f"G96 S{speed.value:g} -> G97 at the start diameter {diameter_mm:g} mm: {rpm:.0f} rpm")
    return SourcedValue(rpm, f"G96 at diameter {diameter_mm:g} mm, {speed.origin}")


def _limit_rpm(state: State, settings: Settings) -> float | None:
    limits = [settings.spindle.max_rpm, state.speed_limit.value if state.speed_limit else None]
    known = [limit for limit in limits if limit is not None and not math.isnan(limit)]
    return min(known) if known else None


def _rules(settings: Settings, state: State, alpha: float, edges: int) -> SolverRules:
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
        max_rpm=_limit_rpm(state, settings),
    )


def _forward_share(alpha: SourcedValue, waveform: Waveform) -> float:
    if waveform == "sine" and alpha.value != 0.5:
        message = f"a sine goes forward and back in equal times; ALPHA {alpha.value:g} ({alpha.origin})"
        raise RefusalError("VIB055", message, "take WAVE TRIANGLE, or leave ALPHA at 0.5")
    return alpha.value


def _feed_mm_rev(state: State, speed_rpm: float) -> float:
    assert state.feed is not None
    feed_mm = state.feed.value * (MM_PER_INCH if state.is_inch else 1.0)
    return feed_mm if state.modes.feed_mode == "rev" else feed_mm / speed_rpm


def _stroke_mm(
    values: Mapping[str, SourcedValue],
    solution: Solution,
    *,
    waveform: Waveform,
    feed_mm_rev: float,
    alpha: float,
    edges: int,
    margin: float,
) -> float:
    """A, or Q times the feed, or the least stroke that breaks with the margin; a dwell has its own."""
    if waveform == "dwell":
        for key in ("Q", "A"):
            if key in values:
                given = f"{key} {values[key].value:g} ({values[key].origin})"
                message = f"{given} is a stroke, and a dwell has none"
                raise RefusalError("VIB085", message, f"leave {key} out, or take WAVE TRIANGLE")
        return (1.0 - alpha) * alpha * feed_mm_rev / solution.per_rev
    if "A" in values:
        return values["A"].value
    if "Q" in values:
        return values["Q"].value * feed_mm_rev
    return least_stroke_mm(
        waveform,
        solution.per_rev,
        feed_mm_rev,
        alpha_share=alpha,
        edges=edges,
        margin=margin,
        ticks=solution.period.ticks,
    )


def _ramp_s(values: Mapping[str, SourcedValue], solution: Solution, settings: Settings) -> float:
    if "RAMP" in values:
        return values["RAMP"].value * solution.period.period_s
    return settings.vibration.ramp_s or 0.0
