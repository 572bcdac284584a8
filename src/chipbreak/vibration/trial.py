"""A cut tried with other values before they are named: planned, made into blocks, judged by their numbers."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.vibration.blocks import moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.machine import law_of
from chipbreak.vibration.measure import CutReport, measure_planned
from chipbreak.vibration.plan import CutPlan, plan_cut

_MOST_MOVES = 300_000
_MOST_SLOW_MOVES = 2000
_FEW_CORNERS = 8
_LEAST_COST = 150  # in moves, of a try where each stroke takes long to plan: no more than a dozen of them
_MANY_IN_STROKES = 500  # moves of a cut whose strokes are several moves each
_ORIGIN = "proposal"


class Trials:
    """Tries of one refused cut, as many as take no longer than a plan."""

    def __init__(self, cut: CutPlan, settings: Settings) -> None:
        self.settings = settings
        is_slow = _is_slow_to_plan(cut, settings)
        self.moves_left = _MOST_SLOW_MOVES if is_slow else _MOST_MOVES
        self.least_cost = _LEAST_COST if is_slow else 1
        self.refusal = ""  # what the last try was refused for

    def works(self, chain: Chain, settings: Settings | None = None) -> CutReport | None:
        """The cut, if it breaks its chips and runs as planned; None where not, or where it is enough."""
        if self.moves_left <= 0:
            return None
        settings = settings or self.settings
        self.refusal = ""
        try:
            plan = plan_cut(chain, settings)
            moves = plan.wave.vibrations * plan.wave.moves_per_vibration
            self.moves_left -= max(moves, self.least_cost)
            if self.moves_left < 0:
                return None
            report = measure_planned(settings, plan, moves_of(plan, settings))
        except RefusalError as error:
            self.refusal = error.message
            return None
        except SelfCheckError:
            return None
        runs = not (report.misses_plan or report.is_overloaded)
        return report if report.verdict.breaks and runs else None


def with_values(chain: Chain, wish: Mapping[str, float], *, without: str, waveform: str = "") -> Chain:
    """The chain with other values; ``without`` names those that go, a letter a key."""
    requests = []
    for request in chain.requests:
        values = {key: given for key, given in request.values.items() if key not in without}
        values |= {key: SourcedValue(value, _ORIGIN) for key, value in wish.items()}
        requests.append(request._replace(values=values, waveform=waveform or request.waveform))
    return Chain(tuple(requests))


def _is_slow_to_plan(cut: CutPlan, settings: Settings) -> bool:
    """True where hardly two strokes are alike, so that each move takes milliseconds to plan.

    Of several blocks, which are rounded each on its own, a stroke is seldom like another.
    """
    moves = cut.wave.vibrations * cut.wave.moves_per_vibration
    is_long = cut.wave.form == "tick" and moves > _MANY_IN_STROKES
    bends = any(arc is not None for arc in cut.path.arcs) or len(cut.path.corners_mm()) > _FEW_CORNERS
    return law_of(settings).is_slow_to_try and (bends or is_long)
