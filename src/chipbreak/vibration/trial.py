"""A cut tried with other values before they are named: planned, made into blocks, judged by their numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.vibration.beginning import BEGINNINGS_COST, failure_of
from chipbreak.vibration.blocks import moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.diameter_steps import diameter_steps
from chipbreak.vibration.measure import CutReport, measure_planned
from chipbreak.vibration.plan import CutPlan, plan_cut
from chipbreak.vibration.try_cost import cost_of_way_out

# What a try costs counts in blocks of a straight stroke: 100,000 of these take about half a second.
_MOST_COST = 100_000
_REFUSED_EARLY = 0.7  # of what a try costs is not spent where it is refused
_ORIGIN = "proposal"


class Trials:
    """Tries of one refused cut, as many as take no longer than a plan."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.left = _MOST_COST
        self.refusal = ""  # what the last try was refused for

    def works(self, chain: Chain, settings: Settings | None = None) -> CutReport | None:
        """The cut, if it breaks its chips and runs as planned; None where not, or where it is enough.

        Where it becomes several steps all of them must, and the first is told of.
        """
        if self.left <= 0:
            return None
        settings = settings or self.settings
        reports = list[CutReport]()
        for step in diameter_steps(chain, settings, is_open=bool(chain.requests[0].chosen_by)):
            report = self._works(step, settings)
            if report is None:
                return None
            reports.append(report)
        return reports[0]

    def _works(self, chain: Chain, settings: Settings) -> CutReport | None:
        self.refusal = ""
        try:
            plan = plan_cut(chain, settings)
        except RefusalError as error:
            self.refusal = error.message
            return None
        if not self.affords(plan):
            return None
        failure = failure_of(plan, settings)
        if failure is not None:
            self.left += cost_of_way_out(plan, self.settings) - BEGINNINGS_COST
            self.refusal = failure.message if isinstance(failure, RefusalError) else ""
            return None
        try:
            report = measure_planned(settings, plan, moves_of(plan, settings))
        except RefusalError as error:
            self.refusal = error.message
            self.left += round(_REFUSED_EARLY * cost_of_way_out(plan, settings))
            return None
        except SelfCheckError:
            return None
        return report if report.holds and not report.is_on_edge else None

    def affords(self, plan: CutPlan) -> bool:
        """Take what a try of this plan costs; False where that is more than is left."""
        self.left -= cost_of_way_out(plan, self.settings)
        return self.left >= 0


def first_by_halving(holds: Callable[[int], bool], before: int, place: int) -> int:
    """The first place behind ``before`` from which on something holds; ``place`` where no nearer one does."""
    while place - before > 1:
        middle = (before + place) // 2
        before, place = (before, middle) if holds(middle) else (middle, place)
    return place


def with_values(chain: Chain, wish: Mapping[str, float], *, without: str, waveform: str = "") -> Chain:
    """The chain, all of it where it is a step, with other values; ``without`` names the keys that go."""
    requests = []
    for request in (chain.whole or chain).requests:
        values = {key: given for key, given in request.values.items() if key not in without}
        values |= {key: SourcedValue(value, _ORIGIN) for key, value in wish.items()}
        requests.append(request._replace(values=values, waveform=waveform or request.waveform))
    return Chain(tuple(requests))


def fed(chain: Chain, share: float) -> Chain:
    """The chain, all of it where it is a step, at a share of its feed, or a multiple."""
    requests = []
    for request in (chain.whole or chain).requests:
        after = request.effect.after
        assert after.feed is not None
        feed = after.feed._replace(value=after.feed.value * share)
        requests.append(request._replace(effect=request.effect._replace(after=after._replace(feed=feed))))
    return Chain(tuple(requests))
