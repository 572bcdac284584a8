"""Verdicts that hold on a control that follows the blocks exactly, which no control is known to do."""

from __future__ import annotations

from collections.abc import Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.machine import numbers_at
from chipbreak.vibration.measure import CutReport

UNPROVEN = "VIB079"
_CUTS = {1: "this cut", 2: "this and one more cut"}


def unproven(interpreted: InterpretedProgram, reports: Sequence[CutReport]) -> list[Diagnostic]:
    """One warning for all such cuts of a program, with the keys that are missing; an error under strict."""
    cuts = [report for report in reports if report.is_unproven and report.verdict.breaks]
    if not cuts:
        return []
    axes = sorted({axis for cut in cuts for axis in cut.plan.chain.axes})
    said = _CUTS.get(len(cuts), f"this and {len(cuts) - 1} more cuts")
    message = (
        f"unproven: chips of {said} would break on a control that follows the blocks exactly; the profile"
        " does not say what this one makes of them (planner.model)"
    )
    filters = " and ".join(f"axes.{axis}.acc_dec_ms, position_gain_1_s" for axis in axes)
    has = " and ".join(f"axes.{axis}.max_acceleration_mm_s2" for axis in axes)
    help_text = (
        "chipbreak profile init --from-parameters reads a Fanuc print-out, chipbreak machine-test measures a"
        f' machine; by hand for Fanuc and alike: planner.model = "after-interpolation" with {filters}; a'
        f' control that stops at reversals: "trapezoid" with {has}{numbers_at(interpreted.settings)};'
        " others: docs/control-laws.md"
    )
    severity = Severity.ERROR if interpreted.settings.checks.strict else Severity.WARNING
    line = cuts[0].plan.chain.first
    return [interpreted.program.diagnose(line, UNPROVEN, message, help_text, severity=severity)]
