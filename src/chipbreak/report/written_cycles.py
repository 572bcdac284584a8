"""The cycles of a run that were written out: their passes, and their time before and after."""

from __future__ import annotations

from chipbreak.cycle_time.blocks import BlockTimer
from chipbreak.cycle_time.clock import Clock, Machine
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.pipeline import Result, interpreted_of
from chipbreak.report.model import ExplainedCycle
from chipbreak.settings import Settings
from chipbreak.unrolling import Span


def written_cycles(result: Result, settings: Settings) -> tuple[ExplainedCycle, ...]:
    """Each cycle that was written out, in the order of the program."""
    if not result.cycles:
        return ()
    interpreted = interpreted_of(result, settings)
    return tuple(_explained(span, result, interpreted) for span in result.cycles)


def _explained(span: Span, result: Result, interpreted: InterpretedProgram) -> ExplainedCycle:
    cuts = [cut for cut in result.cuts if span.first <= cut.plan.chain.first < span.last]
    longer_s = sum(cut.duration_s - cut.programmed_s for cut in cuts if cut.programmed_s is not None)
    before_s = _time_s(span, interpreted)
    return ExplainedCycle(
        line=result.source.place(span.first).line,
        block=result.source.meant(span.title),
        kind="" if span.kind is None else span.kind.value,
        passes=span.passes,
        depth_mm=span.depth_mm,
        vibrated=len(cuts),
        before_s=before_s,
        after_s=before_s + longer_s,
    )


def _time_s(span: Span, interpreted: InterpretedProgram) -> float:
    """How long the passes of a cycle take, as the control would make them."""
    clock = Clock(Machine(interpreted.settings), interpreted.program.source)
    timer = BlockTimer(interpreted.settings, clock)
    for effect in interpreted.effects_of(span.first, span.last):
        timer.time(effect)
    return float(sum(clock.seconds.values()))
