"""Verdicts on the edge: the margin is nearer to 1 than the numbers of the machine are known."""

from __future__ import annotations

from collections.abc import Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.ways_out import ways_out

ON_THE_EDGE = "VIB097"
_OF_MORE = {1: "", 2: " (and that of one more cut)"}


def on_the_edge(interpreted: InterpretedProgram, reports: Sequence[CutReport]) -> list[Diagnostic]:
    """One warning for all such cuts of a program, at the nearest to 1; an error under strict."""
    cuts = [cut for cut in reports if cut.verdict.breaks and cut.is_on_edge]
    if not cuts:
        return []
    nearest = min(cuts, key=lambda cut: cut.verdict.margin)
    more = _OF_MORE.get(len(cuts), f" (and that of {len(cuts) - 1} more cuts)")
    message = (
        f"unproven: the margin of {nearest.verdict.margin:z.2f}{more} may be"
        f" {max(0.005, nearest.margin_off):z.2f} less, as the numbers of the machine may be off by"
        f" {interpreted.settings.planner.uncertainty:.2g} (planner.uncertainty)"
    )
    works = ways_out(interpreted.settings, nearest)
    help_text = f"works: {works}" if works else "take a larger stroke or a lower f, or try this cut with care"
    severity = Severity.ERROR if interpreted.settings.checks.strict else Severity.WARNING
    line = nearest.plan.chain.first
    return [interpreted.program.diagnose(line, ON_THE_EDGE, message, help_text, severity=severity)]
