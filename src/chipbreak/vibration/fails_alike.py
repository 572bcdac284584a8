"""Cuts that would be refused once all are written, seen while they are planned: many end it there.

A program of a thousand cuts with one mistake in all of them is then refused as soon as one of twenty.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, SelfCheckError
from chipbreak.vibration.beginning import is_long
from chipbreak.vibration.blocks import Expansion
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.choice import is_open
from chipbreak.vibration.findings import findings_of_cuts, first_error
from chipbreak.vibration.judged import Judged
from chipbreak.vibration.measure import CutReport, measure_planned
from chipbreak.vibration.plan import CutPlan


class FailsAlike:
    """The cuts among those looked at that would be refused.

    A kind of cut that held once is not looked at again, nor is a long one, whose beginning was.
    """

    def __init__(self, interpreted: InterpretedProgram, *, allow_unbroken: bool) -> None:
        self._interpreted = interpreted
        self._allow_unbroken = allow_unbroken
        self._held = set[Hashable]()
        self._failed: list[CutReport] = []
        self._blocks = set[int]()  # by their first lines: one may vibrate in several steps

    def look_at(self, chain: Chain, cuts: Iterable[tuple[CutPlan, Expansion]]) -> None:
        """Judge the cuts of a chain by the numbers of their blocks, where nothing says that they hold."""
        settings = self._interpreted.settings
        # What the machine chooses was judged; what may be left is given up once it is written.
        if is_open(chain) or chain.may_be_left(settings.vibration.refused):
            return
        for plan, expansion in cuts:
            kind = _kind_of(plan)
            if kind in self._held or is_long(plan, settings):
                continue
            try:
                report = measure_planned(settings, plan, expansion)
            except SelfCheckError:
                continue  # is said of what is written
            if first_error(Judged(self._interpreted, (), report, self._allow_unbroken, advise=False)):
                self._failed.append(report)
                self._blocks.add(plan.chain.first)
            else:
                self._held.add(kind)

    def __len__(self) -> int:
        """How many would be refused, those of one block counted once."""
        return len(self._blocks)

    def findings(self) -> list[Diagnostic]:
        """What is wrong with them, and what would work."""
        return findings_of_cuts(self._interpreted, (), self._failed, allow_unbroken=self._allow_unbroken)


def _kind_of(plan: CutPlan) -> Hashable:
    """What is the same for cuts that are alike but for their place and length."""
    wave = plan.wave
    numbers = (wave.feed_mm_rev, wave.speed_rpm, wave.period_s, wave.forward_ticks, wave.stroke_mm)
    return numbers, wave.waveform, wave.form, plan.edges
