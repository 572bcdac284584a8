"""The beginning of a long cut, planned as all of it is: what fails there fails in the whole cut.

A refusal then takes as long as that of a short cut, and so does a proposal that does not help.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from chipbreak.kinematics.waveform import sample
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.vibration.blocks import moves_of
from chipbreak.vibration.loop_names import LoopNames
from chipbreak.vibration.measure import CutReport, measure_planned
from chipbreak.vibration.plan import CutPlan
from chipbreak.vibration.try_cost import cost_of

LIMITS = ("VIB030", "VIB031", "VIB032")  # refusals of what the control cannot make
BEGINNINGS_COST = 6_000  # of both, in blocks of a straight stroke
_RAMPS = 4.0  # times both ramps
_LEAST_VIBRATIONS = 30.0
_LONG_COST = 40_000  # of a cut that is worth looking at in two parts
_LONGER = 4.0  # times the fewest vibrations of a beginning it has
_OTHER_END = 1.01  # times one beginning is the other, which ends at another place of a vibration


def beginnings(plan: CutPlan, settings: Settings) -> Iterator[CutPlan]:
    """Two beginnings of a long cut, which end differently; none of a cut that is not long.

    They start as the cut does and then have the same full strokes, so that what both of them fail by does not
    come from where they end.
    """
    if not is_long(plan, settings):
        return
    wave = plan.wave
    share = max(BEGINNINGS_COST / 2.0 / cost_of(plan, settings), _least_vibrations(plan) / wave.vibrations)
    for longer in (1.0, _OTHER_END):
        path = plan.path.beginning(longer * share * plan.path.length_mm)
        shorter = replace(wave, length_mm=path.length_mm)
        time_s, distance_mm = sample(shorter)
        yield replace(plan, path=path, wave=shorter, time_s=time_s, distance_mm=distance_mm)


def is_long(plan: CutPlan, settings: Settings) -> bool:
    """True for a cut that has beginnings worth looking at."""
    return cost_of(plan, settings) >= _LONG_COST and plan.wave.vibrations >= _LONGER * _least_vibrations(plan)


def _least_vibrations(plan: CutPlan) -> float:
    """How many a beginning has at least."""
    return _LEAST_VIBRATIONS + _RAMPS * 2.0 * plan.wave.ramp_in_s / plan.wave.period_s


def failure_of(
    plan: CutPlan, settings: Settings, names: LoopNames | None = None
) -> RefusalError | CutReport | None:
    """Why a long cut fails from its beginning on: the refusal of a limit, or a report that does not hold.

    None where it does not, or the cut is not long.
    """
    found: RefusalError | CutReport | None = None
    for beginning in beginnings(plan, settings):
        try:
            found = measure_planned(settings, beginning, moves_of(beginning, settings, names))
        except RefusalError as error:
            if error.code not in LIMITS:
                return None
            found = error
            continue
        except SelfCheckError:
            return None
        if found.holds:
            return None
    return found
