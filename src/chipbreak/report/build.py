"""From the result of a run to its report: the only place that looks into both."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from chipbreak.operations.operations import Operation
from chipbreak.passes import CHECK_TOOLS
from chipbreak.pipeline import Result
from chipbreak.report.model import (
    ExplainedCheck,
    ExplainedCut,
    ExplainedLeft,
    ExplainedLoop,
    ExplainedOperation,
    FlankClearance,
    MovedAxis,
    Report,
    ToldMotion,
)
from chipbreak.report.unasked import unasked_cuts
from chipbreak.report.whole_time import cutting_s, whole_time
from chipbreak.report.written_cycles import written_cycles
from chipbreak.settings import Settings
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.source import Source
from chipbreak.vibration.left_cut import LeftCut, joined

if TYPE_CHECKING:
    from chipbreak.vibration.measure import CutReport


def report_of(result: Result, settings: Settings) -> Report:
    """Every vibrated cut, operation and check of a run, with the reasons."""
    settings = settings.as_shown(result.shown)
    source = result.source
    checks = [edit for edit in result.edits if edit.pass_name == CHECK_TOOLS]
    time = whole_time(result, settings)
    return Report(
        file=source.name,
        profile=settings.name,
        changed=result.changed,
        cuts=tuple(_cut(cut, source, settings) for cut in result.cuts),
        operations=tuple(_operation(operation, source) for operation in result.operations),
        checks=tuple(
            ExplainedCheck(
                line=_line_number(source, edit.first),
                title=edit.title,
                reason=source.meant(edit.reason),
                is_at_end=edit.first == source.line_count,
                duration_s=edit.duration_s,
                otherwise_s=dict(edit.otherwise_s),
            )
            for edit in checks
        ),
        diagnostics=result.diagnostics,
        left=tuple(_left(cut, source) for cut in joined(result.left)),
        feed_s=cutting_s(time) if checks else None,
        time=time,
        unasked=unasked_cuts(result, settings),
        cycles=written_cycles(result, settings),
        without_axis_data=any(
            settings.acceleration_mm_s2(axis) is None for cut in result.cuts for axis in cut.plan.chain.axes
        ),
    )


def _left(cut: LeftCut, source: Source) -> ExplainedLeft:
    return ExplainedLeft(
        first_line=source.place(cut.first).line,
        last_line=source.place(cut.last - 1).line,
        block=source.meant(source.text(cut.first).strip()),
        code=cut.said.code,
        reason=cut.said.message,
        way_out=cut.said.help,
        asked_by=cut.asked_by,
        is_cut=cut.is_cut,
    )


def _cut(cut: CutReport, source: Source, settings: Settings) -> ExplainedCut:
    plan = cut.plan
    wave = plan.wave
    solution = plan.solution
    loops = cut.expansion.loops
    return ExplainedCut(
        first_line=source.place(plan.chain.first).line,
        last_line=source.place(plan.chain.last - 1).line,
        given=FrozenTable(plan.given),
        reasons=tuple(plan.reasons),
        speed_rpm=solution.speed_rpm,
        per_rev=solution.per_rev,
        frequency_hz=solution.frequency_hz,
        feed_mm_rev=wave.feed_mm_rev,
        stroke_mm=wave.stroke_mm,
        waveform=wave.waveform,
        alpha_share=wave.alpha_share,
        stand_s=cut.each_dwell_s,
        end_stand_s=plan.end_dwell_s,
        moves=cut.move_count,
        loops=tuple(
            ExplainedLoop(loop.vibrations, loop.passes, loop.drift_steps, loop.count) for loop in loops or ()
        ),
        duration_s=cut.duration_s,
        control=cut.control,
        acceleration_mm_s2=cut.acceleration_mm_s2,
        servo_share=cut.following and cut.following.stroke_share,
        flank_clearance=tuple(FlankClearance(c.diameter_mm, c.degrees) for c in cut.clearances),
        moved=_moved(plan.chain.axes, settings),
        verdict=cut.verdict,
        block=source.meant(plan.chain.requests[0].effect.block.text.strip()),
        period_s=solution.period.period_s,
        advance_mm=wave.speed_mm_s * wave.period_s,
        output_form="expanded" if loops is None else "loop",
        motion=_motion(cut),
        programmed_s=cut.programmed_s,
        delay_s=cut.following and cut.following.delay_s,
        path_error_mm=cut.following and cut.following.path_error_mm,
        looks=cut.following and cut.following.looks,
        unproven=cut.is_unproven,
        acceleration_share=_share(cut.acceleration_mm_s2, cut.allowed_mm_s2),
        override_band=cut.override_band,
        follows_spindle=plan.expander.feed_mode(plan.chain.before.modes.feed_mode, settings.output.feed_mode)
        == "rev",
        holds_override=cut.holds_override,
        margin_off=cut.margin_off,
        on_edge=cut.is_on_edge,
    )


def _share(used: float, there: float) -> float | None:
    """The part that is used; None where the profile does not say how much there is."""
    return used / there if math.isfinite(there) else None


def _motion(cut: CutReport) -> ToldMotion:
    expander = cut.plan.expander
    name, size = expander.told(cut.wave, cut.each_dwell_s)
    return ToldMotion(
        name=name,
        size=size,
        need=expander.told_need(cut.acceleration_mm_s2),
        without_count=expander.told_without_count(),
    )


def _moved(axes: str, settings: Settings) -> FrozenTable[str, MovedAxis]:
    """What moves the axes of a cut, where the profile says it."""
    is_said = any(key.startswith("axes.") and key.endswith((".letter", ".sign")) for key in settings.origins)
    words = settings.axis_words
    members = {1: "tool", -1: "work"}
    moved = {axis: MovedAxis(words.letters[axis], members[words.signs[axis]]) for axis in axes}
    return FrozenTable(moved if is_said else {})


def _operation(operation: Operation, source: Source) -> ExplainedOperation:
    return ExplainedOperation(
        tool=operation.tool,
        kind=operation.kind.value,
        label=source.meant(operation.label),
        reason=source.meant(operation.reason),
        first_line=_line_number(source, operation.first_line),
        last_line=_line_number(source, operation.last_line - 1),
    )


def _line_number(source: Source, line: int) -> int:
    """The line in the user's file; one behind the last where a change stands at the end of the program."""
    count = source.line_count
    return source.place(line).line if line < count else source.place(count - 1).line + 1
