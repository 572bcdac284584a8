"""Paths that feed without a spindle of their own may turn with the one whose speed a vibrated cut changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.vibration.plan import CutPlan

SHARED = "VIB078"


def shared_spindle(interpreted: InterpretedProgram, plans: Sequence[CutPlan]) -> Iterator[Diagnostic]:
    """A warning at the first cut of a path whose speed another path may have to turn with."""
    changed = [plan for plan in plans if plan.chain.before.path and _changes_speed(plan)]
    guests = list(_guests(interpreted)) if changed else []
    said = set()
    for plan in changed:
        path = plan.chain.before.path
        guest = next((effect for effect in guests if effect.after.path != path), None)
        if guest is None or path in said:
            continue
        said.add(path)
        line = interpreted.program.source.place(guest.block.line).line
        where = f"path {guest.after.path}, which feeds in line {line} and has started no spindle"
        message = f"S becomes {plan.solution.speed_rpm:g} for this cut, and may for {where}"
        help_text = 'vibration.correct = "count" keeps S; or start the other path\'s own spindle in it'
        yield interpreted.program.diagnose(
            plan.chain.first, SHARED, message, help_text, severity=Severity.WARNING
        )


def _changes_speed(plan: CutPlan) -> bool:
    speed = plan.chain.before.speed
    return speed is None or speed.value != plan.solution.speed_rpm


def _guests(interpreted: InterpretedProgram) -> Iterator[BlockEffect]:
    """The feed moves of paths that have not started a spindle."""
    body = interpreted.program.source.body
    for effect in interpreted.effects_of(body.start, body.stop):
        feeds = effect.move is not None and effect.move.kind != "rapid"
        if feeds and effect.after.path and effect.after.spindle_why and not effect.after.turns:
            yield effect
