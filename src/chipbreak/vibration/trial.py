"""A cut tried with other values before they are named: planned, made into blocks, judged by their numbers."""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.vibration.blocks import moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.machine import control_along, law_of
from chipbreak.vibration.measure import CutReport, measure_planned
from chipbreak.vibration.plan import CutPlan, plan_cut

_MOST_MOVES = 300_000
# Where each stroke takes long to plan; a move counts for every law that the profile leaves open.
_MOST_SLOW_MOVES = 1200
_LEAST_COST = 40  # in moves, of such a try
_REFUSED_EARLY = 0.7  # of what a try costs is not spent where it is refused
_FEW_CORNERS = 8
_MANY_IN_STROKES = 500  # moves of a cut whose strokes are several moves each
_ORIGIN = "proposal"


class Trials:
    """Tries of one refused cut, as many as take no longer than a plan."""

    def __init__(self, cut: CutPlan, settings: Settings) -> None:
        self.settings = settings
        self.is_slow = _is_slow_to_plan(cut, settings)
        self.moves_left = _MOST_SLOW_MOVES if self.is_slow else _MOST_MOVES
        self.refusal = ""  # what the last try was refused for

    def works(self, chain: Chain, settings: Settings | None = None) -> CutReport | None:
        """The cut, if it breaks its chips and runs as planned; None where not, or where it is enough."""
        if self.moves_left <= 0:
            return None
        settings = settings or self.settings
        self.refusal = ""
        try:
            plan = plan_cut(chain, settings)
        except RefusalError as error:
            self.refusal = error.message
            return None
        if not self.affords(plan):
            return None
        try:
            report = measure_planned(settings, plan, moves_of(plan, settings))
        except RefusalError as error:
            self.refusal = error.message
            self.moves_left += round(_REFUSED_EARLY * self._cost(plan))
            return None
        except SelfCheckError:
            return None
        runs = not (report.misses_plan or report.is_overloaded)
        return report if report.verdict.breaks and runs else None

    def affords(self, plan: CutPlan) -> bool:
        """Take what a try of this plan costs; False where that is more than is left."""
        self.moves_left -= self._cost(plan)
        return self.moves_left >= 0

    def _cost(self, plan: CutPlan) -> int:
        moves = plan.wave.vibrations * plan.wave.moves_per_vibration
        if not self.is_slow:
            return moves
        law = control_along(self.settings, plan.path, plan.chain.before)
        return max(moves, _LEAST_COST) * len(law.variants())


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
