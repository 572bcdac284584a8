"""Feed per revolution in a program of a machine that may not be able to do it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.plan import CutPlan

NEEDS_ENCODER = "VIB088"


def needs_encoder(interpreted: InterpretedProgram, plans: Sequence[CutPlan]) -> Iterator[Diagnostic]:
    """A warning at the first cut that is written per revolution where the program never feeds so.

    A lathe has the encoder that this takes; a machining centre may have none.
    """
    settings = interpreted.settings
    if settings.dialect.is_lathe or settings.output.feed_mode != "rev":
        return
    if any(effect.after.modes.feed_mode == "rev" for effect in interpreted.effects):
        return
    plan = next((plan for plan in plans if not plan.expander.keeps_feed), None)
    if plan is None:
        return
    code = settings.dialect.code("feed_mode", "rev")
    message = f"the blocks of this cut feed per revolution ({code}), which the program does nowhere"
    help_text = f'{code} needs an encoder on the spindle; without one set output.feed_mode = "minute"'
    yield interpreted.program.diagnose(
        plan.chain.first, NEEDS_ENCODER, message, help_text, severity=Severity.WARNING
    )
