"""What would break the chips of a cut that does not break them: conditions that have been tried.

A larger stroke does not always help: round a corner, or on a control that cannot keep up, the weakest
vibration stays weak.  So each proposal is planned, printed, read back and judged like any cut.
"""

from __future__ import annotations

from collections.abc import Mapping

from chipbreak.editing.render import render
from chipbreak.editing.restore import regions
from chipbreak.kinematics.sourced_value import SourcedValue, shown
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.text.source import read
from chipbreak.vibration.advice import few
from chipbreak.vibration.blocks import moves_of
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.cut_edit import Step, cut_edit
from chipbreak.vibration.measure import CutReport, measure_cut
from chipbreak.vibration.plan import CutPlan, command_group, plan_cut
from chipbreak.vibration.speeds import speed_words

_STROKES = (1.05, 1.25, 1.5, 2.0, 2.5, 3.0)  # times the least stroke by the formula
_SLOWER = (0.8, 0.6, 0.45, 0.3, 0.2, 0.12)
_ORIGIN = "proposal"


def ways_out(interpreted: InterpretedProgram, report: CutReport) -> str:
    """A larger Q, and a lower frequency, that break the chips of this cut; empty where none was found."""
    found = (_larger_stroke(interpreted, report), _lower_frequency(interpreted, report))
    return ", or ".join(way for way in found if way)


def _larger_stroke(interpreted: InterpretedProgram, report: CutReport) -> str:
    plan = report.plan
    margin = report.verdict.margin
    ratio = plan.wave.stroke_mm / plan.wave.feed_mm_rev
    least = ratio / margin if margin > 0.0 else ratio
    factors = few(_STROKES, plan, interpreted.settings, report.move_count)
    tried = dict.fromkeys(round(least * factor + 0.005, 2) for factor in factors)
    for stroke in (s for s in tried if s > ratio):
        if _breaks(interpreted, plan.chain, {"Q": stroke}, without="A"):
            return f"Q {stroke:g} with the same S, N and f"
    return ""


def _lower_frequency(interpreted: InterpretedProgram, report: CutReport) -> str:
    plan = report.plan
    group = command_group(interpreted.settings)
    per_rev = round(plan.solution.per_rev, 4)
    for factor in few(_SLOWER, plan, interpreted.settings, report.move_count):
        frequency_hz = group.nearest(plan.solution.frequency_hz * factor).frequency_hz
        if frequency_hz >= plan.solution.frequency_hz:
            continue
        wish = {"N": per_rev, "F": frequency_hz}
        works = _breaks(interpreted, plan.chain, wish, without="SE")
        if works is not None:
            speed = f"S {works.solution.speed_rpm:z.0f}"
            return f"N {shown(per_rev)} f {shown(frequency_hz)} Hz ({speed}) with the same feed and stroke"
    return ""


def _breaks(
    interpreted: InterpretedProgram, chain: Chain, wish: Mapping[str, float], *, without: str
) -> CutPlan | None:
    """The cut as it would be planned with other values, if its chips break."""
    values = {k: g for k, g in chain.requests[0].values.items() if k not in without}
    values |= {key: SourcedValue(value, _ORIGIN) for key, value in wish.items()}
    other = Chain(tuple(request._replace(values=values) for request in chain.requests))
    try:
        report = _tried(interpreted, other)
    except (RefusalError, SelfCheckError):
        return None
    return report.plan if report.verdict.breaks and not report.misses_plan else None


def _tried(interpreted: InterpretedProgram, chain: Chain) -> CutReport:
    """One cut alone in its program, with its speed said, read back.  Errors: RefusalError, SelfCheckError."""
    settings = interpreted.settings
    plan = plan_cut(chain, settings)
    expansion = moves_of(plan, settings)
    speed = speed_words(None, ("rpm", plan.solution.speed_rpm), plan.chain.before, settings)
    edit = cut_edit([Step(plan, expansion, speed)], interpreted)
    output = b"".join(render(interpreted.program, [edit], settings))
    source = read(output, interpreted.program.source.name)
    (region,) = regions(source)
    return measure_cut(interpret(parse(source, settings.dialect), settings), region, plan, expansion)
