"""Feed per revolution on a control that looks ahead only where feed is per minute."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.machine import law_of
from chipbreak.vibration.plan import CutPlan

NO_LOOK_AHEAD = "VIB089"


def without_look_ahead(interpreted: InterpretedProgram, plans: Sequence[CutPlan]) -> Iterator[Diagnostic]:
    """At the first cut whose blocks feed per revolution: the control may not look ahead in them.

    The manual of AI contour control says that it plans speeds ahead when feed per minute is specified.
    """
    settings = interpreted.settings
    if not law_of(settings).needs_feed_per_minute:
        return
    plan = next((plan for plan in plans if _feeds_per_revolution(plan, interpreted)), None)
    if plan is None:
        return
    code = settings.dialect.code("feed_mode", "rev")
    message = f"look-ahead needs feed per minute, and the blocks of this cut feed per revolution ({code})"
    instead = 'planner.model = "after-interpolation" without joint_speed_mm_min'
    help_text = f'set output.feed_mode = "minute", or {instead}'
    severity = Severity.ERROR if settings.checks.strict else Severity.WARNING
    yield interpreted.program.diagnose(plan.chain.first, NO_LOOK_AHEAD, message, help_text, severity=severity)


def _feeds_per_revolution(plan: CutPlan, interpreted: InterpretedProgram) -> bool:
    was = plan.chain.before.modes.feed_mode
    return plan.expander.feed_mode(was, interpreted.settings.output.feed_mode) == "rev"
