"""The time of a whole program before and after: what its lines take, what vibration and checks change."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

from chipbreak.cycle_time.clock import CHANGES, CUTTING, DWELLS, RAPIDS, Clock
from chipbreak.cycle_time.program import time_program
from chipbreak.editing.restore import restore
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.passes import CHECK_TOOLS
from chipbreak.pipeline import Result, Whole
from chipbreak.report.model import Assumption, CycleTime, TimePart, UntimedLine
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import ProgramRejectedError, SelfCheckError
from chipbreak.text.source import Source
from chipbreak.unrolling import unroll
from chipbreak.vibration.cut_edit import settling

if TYPE_CHECKING:
    from chipbreak.vibration.measure import CutReport

_CHECKS = "tool checks"


def whole_time(result: Result, settings: Settings) -> CycleTime | None:
    """The time of a program before and after; None where nothing of it can be timed.

    Cycles are timed by the passes that the control makes of them.
    """
    interpreted, main = _written_out(result, settings)
    clock = time_program(interpreted, main, result.whole.excerpt if result.whole else None)
    cutting_s = clock.seconds[CUTTING]
    if not cutting_s:
        return None
    source = interpreted.program.source
    called = _called(clock, source)
    lines = [result.source.place(cut.plan.chain.first).line for cut in result.cuts]
    longer_s = sum(_longer_s(cut, line, called) for cut, line in zip(result.cuts, lines, strict=True))
    waits_s = _settling_s(result, settings)
    checks_s = sum(edit.duration_s or 0.0 for edit in result.edits if edit.pass_name == CHECK_TOOLS)
    dwells_s = clock.seconds[DWELLS]
    parts = [
        TimePart(CUTTING, cutting_s, cutting_s + longer_s),
        TimePart(RAPIDS, clock.seconds[RAPIDS], clock.seconds[RAPIDS]),
        TimePart(DWELLS, dwells_s, dwells_s + waits_s),
        TimePart(CHANGES, clock.seconds[CHANGES], clock.seconds[CHANGES]),
        TimePart(_CHECKS, 0.0, checks_s),
    ]
    return CycleTime(
        before_s=sum(part.before_s for part in parts),
        after_s=sum(part.after_s for part in parts),
        parts=tuple(part for part in parts if part.before_s or part.after_s),
        assumed=tuple(Assumption(*one) for one in clock.assumptions()),
        untimed=tuple(UntimedLine(*one) for one in sorted(set(clock.untimed))),
    )


def cutting_s(time: CycleTime | None) -> float | None:
    """How long the program feeds as it is written; None where that is not known."""
    parts = time.parts if time is not None else ()
    return next((part.before_s for part in parts if part.name == CUTTING), None)


def _written_out(result: Result, settings: Settings) -> tuple[InterpretedProgram, MainProgram]:
    """The program as it came in, with every cycle that can be written out as plain blocks."""
    whole = result.whole or Whole.of(interpret_source(restore(result.source), settings))
    plain = whole.interpreted
    settings = plain.settings
    always = dataclasses.replace(settings, cycles=dataclasses.replace(settings.cycles, unroll="always"))
    try:
        unrolled = unroll(plain._replace(settings=always), whole.main, (), {})
    except (ProgramRejectedError, SelfCheckError):
        return plain, whole.main
    return unrolled.interpreted, unrolled.main


def _longer_s(cut: CutReport, line: int, called: Sequence[tuple[range, int]]) -> float:
    """How much longer a cut in a line takes, in all calls of the subprogram in which it stands."""
    was_s = cut.programmed_s
    if was_s is None:
        return 0.0
    return (cut.duration_s - was_s) * (sum(count for body, count in called if line in body) or 1)


def _called(clock: Clock, source: Source) -> list[tuple[range, int]]:
    """The lines of the user's file that are called, and how often, once for each call."""
    return [
        (range(source.place(body.start).line, source.place(body.stop).line), count)
        for body, count in clock.calls
        if body
    ]


def _settling_s(result: Result, settings: Settings) -> float:
    """The dwells in which the spindle reaches another speed."""
    waits = settling(settings)
    if not waits:
        return 0.0
    count = sum(edit.content.count(waits[0]) for edit in result.edits)
    return count * settings.spindle.settle_s
