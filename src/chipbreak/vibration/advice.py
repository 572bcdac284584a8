"""The nearest conditions that a control can run, for the way out of a refusal."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.kinematics.speed_solver import Period
from chipbreak.kinematics.waveform import forward_ticks
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError
from chipbreak.trajectory.law import ControlLaw
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.machine import control_along, law_of
from chipbreak.vibration.plan import MOST_MOVES, CutPlan, command_group, plan_cut

LIMITS = ("VIB030", "VIB031", "VIB032")
_STEP = 0.93  # from one frequency tried to the next
_LARGE_STEP = 0.6  # where each try takes seconds
_TRIES = 80
_LEAST_SHARE = 0.05  # no cut is made at a twentieth of its speed
_MOST_SLOW_MOVES = 2000
_FEW_CORNERS = 8
_MANY_IN_STROKES = 500  # moves of a cut whose strokes are several moves each


def with_advice(
    error: RefusalError,
    cut: CutPlan,
    settings: Settings,
    expand: Callable[[CutPlan, Settings], object],
) -> RefusalError:
    """The same refusal; where a limit of the control is the cause, with a slower frequency that works.

    ``expand`` makes the blocks of a cut, or refuses: what is advised has been tried.
    """
    if error.code not in LIMITS:
        return error
    law = control_along(settings, cut.path, cut.chain.before)
    group = command_group(settings)
    frequency_hz = cut.solution.frequency_hz
    tried = {cut.solution.frequency_hz}
    is_slow = _is_slow_to_plan(cut, settings, len(cut.time_s))
    moves_left = _MOST_SLOW_MOVES if is_slow else MOST_MOVES
    for _ in range(_TRIES):
        frequency_hz *= _LARGE_STEP if is_slow else _STEP
        if frequency_hz < _LEAST_SHARE * cut.solution.frequency_hz:
            break
        period = group.nearest(frequency_hz)
        if period.frequency_hz in tried or not _runs(cut, period, law):
            continue
        tried.add(period.frequency_hz)
        if moves_left <= 0:
            break
        try:
            slower = _slower(cut, period, settings)
            moves_left -= len(slower.time_s)
            expand(slower, settings)
        except RefusalError:
            continue
        works = (
            f"N {shown(round(cut.solution.per_rev, 4))} with the same feed works at"
            f" f {shown(period.frequency_hz)} Hz, S {slower.solution.speed_rpm:z.0f}"
        )
        return RefusalError(error.code, error.message, f"{_first_help(error, cut)}; {works}{_standing(cut)}")
    return RefusalError(error.code, error.message, f"{_first_help(error, cut)}{_standing(cut)}")


def _first_help(error: RefusalError, cut: CutPlan) -> str:
    """The help of a refusal, but of too many blocks that which is left with the form of this cut."""
    if error.code != "VIB032":
        return error.help
    return cut.expander.way_out_of_too_many_blocks(cut.wave.form)


def _is_slow_to_plan(cut: CutPlan, settings: Settings, move_count: int) -> bool:
    """True where hardly two strokes are alike, so that each move takes milliseconds to plan.

    Of several blocks, which are rounded each on its own, a stroke is seldom like another.
    """
    is_long = cut.wave.form == "tick" and move_count > _MANY_IN_STROKES
    bends = any(arc is not None for arc in cut.path.arcs) or len(cut.path.corners_mm()) > _FEW_CORNERS
    return law_of(settings).is_slow_to_try and (bends or is_long)


def few(factors: Sequence[float], cut: CutPlan, settings: Settings, move_count: int) -> Sequence[float]:
    """All factors to try, or as many of them, evenly chosen, as may be tried with a cut of so many moves."""
    if not _is_slow_to_plan(cut, settings, move_count):
        return factors
    step = math.ceil(len(factors) / max(1, _MOST_SLOW_MOVES // move_count))
    return factors[step // 2 :: step]


def _standing(cut: CutPlan) -> str:
    """What needs no reversal: at this E half of what is left to the stand is to spare."""
    turns = 1.5 / cut.edges / (1.0 - cut.wave.alpha_share)
    has_stroke = cut.chain.requests[0].values.keys() & {"Q", "A"}
    without = ", without Q and A," if has_stroke else ""
    return f"; WAVE DWELL with E {shown(round(turns, 2))}{without} never turns back and stands instead"


def _slower(cut: CutPlan, period: Period, settings: Settings) -> CutPlan:
    """The cut as it would be planned with the same N and a slower f, as the advice says."""
    wish = {"N": round(cut.solution.per_rev, 4), "F": period.frequency_hz}
    requests = []
    for request in cut.chain.requests:
        values = {k: given for k, given in request.values.items() if k not in "SE"}
        values |= {key: SourcedValue(value, "advice") for key, value in wish.items()}
        requests.append(request._replace(values=values))
    return plan_cut(Chain(tuple(requests)), settings)


def _runs(cut: CutPlan, period: Period, law: ControlLaw) -> bool:
    """True when both strokes of a full vibration can be run in a slower period."""
    ahead = forward_ticks(period.ticks, cut.wave.alpha_share)
    share = ahead / period.ticks
    advance_mm = cut.wave.feed_mm_rev / cut.solution.per_rev
    forward_mm = cut.wave.stroke_mm + share * advance_mm
    back_mm = cut.wave.stroke_mm - (1.0 - share) * advance_mm
    try:
        law.feed_for_time(forward_mm, share * period.period_s)
        if back_mm > 0.0:
            law.feed_for_time(back_mm, (1.0 - share) * period.period_s)
    except RefusalError:
        return False
    return True
