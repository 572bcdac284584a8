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
from chipbreak.settings import Settings
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import RefusalError, SelfCheckError
from chipbreak.text.source import read
from chipbreak.vibration.advice import few
from chipbreak.vibration.chain import Chain
from chipbreak.vibration.cut_edit import PlannedCut, planned_cut
from chipbreak.vibration.measure import CutReport, measure_cut
from chipbreak.vibration.plan import command_group

_STROKES = (1.05, 1.25, 1.5, 2.0, 2.5, 3.0)  # times the least stroke by the formula
_SLOWER = (0.8, 0.6, 0.45, 0.3, 0.2, 0.12)
_ORIGIN = "proposal"


def ways_out(interpreted: InterpretedProgram, settings: Settings, checked: CutReport) -> str:
    """A larger Q, and a lower frequency, that break the chips of this cut; empty where none was found."""
    found = (_larger_stroke(interpreted, settings, checked), _lower_frequency(interpreted, settings, checked))
    return ", or ".join(way for way in found if way)


def _larger_stroke(interpreted: InterpretedProgram, settings: Settings, checked: CutReport) -> str:
    cut, margin = checked.plan, checked.verdict.margin
    ratio = cut.wave.stroke_mm / cut.wave.feed_mm_rev
    least = ratio / margin if margin > 0.0 else ratio
    count = checked.move_count
    tried = dict.fromkeys(round(least * factor + 0.005, 2) for factor in few(_STROKES, cut, settings, count))
    for stroke in (s for s in tried if s > ratio):
        if _breaks(interpreted, settings, cut.chain, {"Q": stroke}, without="A"):
            return f"Q {stroke:g} with the same S, N and f"
    return ""


def _lower_frequency(interpreted: InterpretedProgram, settings: Settings, checked: CutReport) -> str:
    cut, group = checked.plan, command_group(settings)
    per_rev = round(cut.solution.per_rev, 4)
    for factor in few(_SLOWER, cut, settings, checked.move_count):
        frequency_hz = group.nearest(cut.solution.frequency_hz * factor).frequency_hz
        if frequency_hz >= cut.solution.frequency_hz:
            continue
        wish = {"N": per_rev, "F": frequency_hz}
        done = _breaks(interpreted, settings, cut.chain, wish, without="SE")
        if done is not None:
            speed = f"S {done.plan.solution.speed_rpm:.0f}"
            return f"N {shown(per_rev)} f {shown(frequency_hz)} Hz ({speed}) with the same feed and stroke"
    return ""


def _breaks(
    interpreted: InterpretedProgram,
    settings: Settings,
    chain: Chain,
    wish: Mapping[str, float],
    *,
    without: str,
) -> PlannedCut | None:
    """The cut as it would be with other values, if its chips break."""
    values = {k: g for k, g in chain.requests[0].values.items() if k not in without}
    values |= {key: SourcedValue(value, _ORIGIN) for key, value in wish.items()}
    other = Chain(tuple(request._replace(values=values) for request in chain.requests))
    try:
        planned = planned_cut(other, interpreted, settings)
        source = read(
            b"".join(render(interpreted.program, [planned.edit], settings)), interpreted.program.source.name
        )
        (region,) = regions(source)
        checked = measure_cut(interpret(parse(source), settings), region, planned.plan, planned.expansion)
    except (RefusalError, SelfCheckError):
        return None
    return planned if checked.verdict.breaks and not checked.misses_plan else None
