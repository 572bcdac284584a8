"""Expand the cuts that are asked to vibrate.

::

    G97 S3000 M3                 G97 S3000 M3
    G0 X20. Z2.           ->     G0 X20. Z2.
    G1 Z-30. F0.05 N1.5          S2500
    M30                          G1 Z1.92 F0.55
                                 Z1.967 F0.305 ...

What plans and judges these cuts is imported when a program asks for one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import SpindleRestarted
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.text.diagnostics import Diagnostic, has_errors
from chipbreak.vibration.left_cut import said_of_left
from chipbreak.vibration.request import requests_of

VIBRATE = "vibrate"


class Vibrate(Pass):
    """Cuts that break their chips by swinging or by standing."""

    name = VIBRATE

    def plan(self, context: Context) -> Planned:
        """The blocks of every vibrated cut, and the programmed spindle speed where it is needed again."""
        asked = requests_of(context.interpreted, context.cut_operations, context.named_cycles)
        left = asked.left
        edits: Sequence[Edit] = ()
        diagnostics = asked.diagnostics
        if asked.requests:
            from chipbreak.vibration.cuts import edits_of_cuts

            cuts = edits_of_cuts(
                context.interpreted,
                asked.requests,
                restarted_at=context.lines_of(SpindleRestarted),
                air_lines=asked.air_lines,
                given_up=context.given_up,
                allow_unbroken=context.options.allow_unbroken,
                reasons=context.reasons,
                is_refused=context.is_refused or has_errors(diagnostics),
            )
            edits = cuts.edits
            diagnostics = diagnostics + cuts.diagnostics
            left = left + cuts.left
        left = sorted(left, key=lambda cut: cut.first)
        return Planned(edits, [*diagnostics, *said_of_left(context.interpreted.program, left)], left)

    def findings(self, context: Context, reports: Sequence[object]) -> Sequence[Diagnostic]:
        """What the emitted moves of the cuts do not do, and how it would work."""
        if not reports:
            return ()
        from chipbreak.vibration.findings import findings_of_cuts

        return findings_of_cuts(
            context.interpreted,
            context.cut_operations,
            reports,
            allow_unbroken=context.options.allow_unbroken,
        )

    def gives_up(self, context: Context, reports: Sequence[object]) -> Mapping[int, Diagnostic]:
        """Cuts that would not break their chips, or not run as planned, and may stay as they are."""
        if not reports:
            return {}
        from chipbreak.vibration.findings import errors_of_cuts

        return errors_of_cuts(
            context.interpreted,
            context.cut_operations,
            reports,
            allow_unbroken=context.options.allow_unbroken,
        )
