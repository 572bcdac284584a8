"""A vibrated cut with all that is asked of it, for the rules that say what is wrong with it."""

from __future__ import annotations

from collections.abc import Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.operations import Operation
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.ways_out import ways_out


class Judged(NamedTuple):
    """A cut with all that is asked of it; ``advise``: what would work may be tried, which takes time."""

    interpreted: InterpretedProgram
    operations: Sequence[Operation]
    report: CutReport
    allow_unbroken: bool
    advise: bool

    def diagnose(self, code: str, message: str, help_text: str, severity: Severity) -> Diagnostic:
        """A diagnostic at the first line of the cut."""
        line = self.report.plan.chain.first
        return self.interpreted.program.diagnose(line, code, message, help_text, severity=severity)

    @property
    def unbroken_severity(self) -> Severity:
        """How much whole chips weigh in this run."""
        return Severity.WARNING if self.allow_unbroken else Severity.ERROR

    def ways_out(self) -> str:
        """What has been tried and works; empty where nothing does, or nothing may be tried."""
        return ways_out(self.interpreted.settings, self.report) if self.advise else ""
