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

from collections.abc import Sequence

from chipbreak.editing.promise import SpindleRestarted
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.vibration.request import requests_of


class Vibrate(Pass):
    """Cuts that break their chips by swinging or by standing."""

    name = "vibrate"

    def plan(self, context: Context) -> Planned:
        """The blocks of every vibrated cut, and the programmed spindle speed where it is needed again."""
        requests, diagnostics = requests_of(context.interpreted)
        if not requests:
            return Planned((), diagnostics)
        from chipbreak.vibration.cuts import edits_of_cuts

        edits, found = edits_of_cuts(
            context.interpreted,
            requests,
            restarted_at=context.lines_of(SpindleRestarted),
            allow_unbroken=context.options.allow_unbroken,
        )
        return Planned(edits, diagnostics + found)

    def findings(self, context: Context, reports: Sequence[object]) -> Sequence[Diagnostic]:
        """What the emitted moves of the cuts do not do, and how it would work."""
        if not reports:
            return ()
        from chipbreak.vibration.findings import findings_of_cuts

        return findings_of_cuts(
            context.interpreted,
            context.operations,
            reports,
            allow_unbroken=context.options.allow_unbroken,
        )
