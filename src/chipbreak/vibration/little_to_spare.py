"""Cuts that use nearly all the acceleration of their axes: a little less of it, and no chip breaks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.measure import CutReport

LITTLE_TO_SPARE = "VIB090"
_USES = {1: "this cut uses", 2: "this and one more cut use up to"}
_WITH_ROUNDING = 1.05  # what a choice may use more than was meant


def little_to_spare(interpreted: InterpretedProgram, cuts: Sequence[CutReport]) -> Iterator[Diagnostic]:
    """One warning for all cuts of a program that leave less than ``vibration.reserve``, at the first.

    Where the machine chooses it keeps the reserve; what is asked for by N and f is run as asked.
    """
    reserve = interpreted.settings.vibration.reserve
    close = [cut for cut in cuts if cut.holds and _share(cut) > _WITH_ROUNDING * (1.0 - reserve)]
    if not close:
        return
    most = max(map(_share, close))
    cut = close[0].plan
    said = _USES.get(len(close), f"this and {len(close) - 1} more cuts use up to")
    axes = " and ".join(cut.chain.axes)
    message = f"{said} {most:.0%} of the acceleration that the profile gives {axes}"
    help_text = (
        "take a lower f with the same N; where the axis surely has what the profile says, set"
        f" vibration.reserve = {_reserve_left_by(most):g}"
    )
    yield interpreted.program.diagnose(
        cut.chain.first, LITTLE_TO_SPARE, message, help_text, severity=Severity.WARNING
    )


def _reserve_left_by(share: float) -> float:
    """The largest reserve with which a cut that uses this share is not spoken of, in hundredths."""
    return max(0.0, math.floor(100.0 * (1.0 - share / _WITH_ROUNDING)) / 100.0)


def _share(cut: CutReport) -> float:
    """The part of the acceleration that is used; 0 where the profile does not say how much there is."""
    allowed_mm_s2 = cut.allowed_mm_s2
    return cut.acceleration_mm_s2 / allowed_mm_s2 if math.isfinite(allowed_mm_s2) else 0.0
