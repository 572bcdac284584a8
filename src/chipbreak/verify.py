"""The output distrusts itself: it is read again, put back, interpreted and measured before a byte is written.

What must hold: putting it back gives the original bytes; at the borders of every change the control is in
the state of the original, but for a spindle speed that was changed on purpose; every vibrated cut starts and
ends where it was programmed, stays on its path and takes its time.  The verdict on the chips comes from the
moves as they stand in the output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from chipbreak.edits import Edit, in_order
from chipbreak.model.modal import State
from chipbreak.model.trace import Trace, interpret
from chipbreak.model.words import codes_of
from chipbreak.passes.vibrate import PlannedCut
from chipbreak.restore import Region, regions, restore
from chipbreak.source import read
from chipbreak.syntax.parse import parse
from chipbreak.units import MM_PER_INCH
from chipbreak.vibration.blocks import CHORD_MM
from chipbreak.vibration.readback import ReadBack, read_moves
from chipbreak.vibration.verdict import Verdict, judge
from chipbreak.vibration.waveform import full_window

# Feeds are rounded, so the time of a cut differs from the plan by about half a unit in their last place.
_TIME_TOLERANCE = 0.005


class SelfCheckError(Exception):
    """The output does not do what was promised: a fault of this program.  Nothing may be written."""


@dataclass(frozen=True, eq=False)
class CheckedCut:
    """A vibrated cut with what its emitted moves do: seconds, and the verdict on its chips."""

    planned: PlannedCut
    duration_s: float
    move_count: int
    verdict: Verdict


def verify(
    trace: Trace, output: bytes, edits: Sequence[Edit], cuts: Sequence[PlannedCut]
) -> list[CheckedCut]:
    """Check the output against the original.  Raises SelfCheckError."""
    source = read(output, trace.program.source.name)
    if restore(source).data != trace.program.source.data:
        raise SelfCheckError("putting the output back does not give the original bytes")
    result = interpret(parse(source), trace.settings)
    found = regions(source)
    ordered = in_order(edits)
    if len(found) != len(ordered):
        raise SelfCheckError(f"{len(ordered)} changes were planned, {len(found)} stand in the output")
    by_edit = {id(cut.edit): cut for cut in cuts}
    checked = []
    motion_from = 0
    for edit, region in zip(ordered, found, strict=True):
        planned = by_edit.get(id(edit))
        if planned is not None and planned.cut.chain.after.modes["motion"] != "line":
            motion_from = _next_motion_code(trace, edit.last)
        _check_length(result, region)
        _check_states(trace, result, edit, region, motion_from)
        if planned is not None:
            checked.append(_check_cut(result, region, planned))
    return checked


def _check_length(result: Trace, region: Region) -> None:
    limit = result.settings.control.max_line_chars
    starts = result.program.source.starts[region.first : region.last + 1]
    longest = int(np.diff(starts).max()) - 1
    if longest > limit:
        raise SelfCheckError(f"a new block has {longest} characters, the control takes {limit}")


def _next_motion_code(trace: Trace, first: int) -> int:
    """The next line that says G0 to G3 or another motion code; the last line where there is none."""
    stop = trace.program.source.body.stop
    for step in trace.steps(first, stop):
        if codes_of(step.block, "motion", trace.settings.dialect):
            return step.block.line
    return stop


def _check_states(trace: Trace, result: Trace, edit: Edit, region: Region, motion_from: int) -> None:
    """The control is in the same state before and behind a change as it was in the original.

    A chain that ends in an arc leaves G1 behind; the pass made sure that the next move says its own code, so
    the motion code counts only behind line ``motion_from``.
    """
    for where, line, new_line in (("before", edit.first, region.first), ("behind", edit.last, region.last)):
        was, now = trace.before(line), result.before(new_line)
        if line <= motion_from:
            now = now.with_modes({"motion": was.modes["motion"]})
        wrong = _difference(was, now, trace)
        if wrong:
            raise SelfCheckError(f"{where} line {line + 1} {wrong} differs from the original")


def _difference(was: State, now: State, trace: Trace) -> str:
    if dict(was.modes) | {"speed_mode": ""} != dict(now.modes) | {"speed_mode": ""}:
        groups = {g for g in was.modes if was.modes[g] != now.modes.get(g)} - {"speed_mode"}
        return f"the modal state ({', '.join(sorted(groups))})"
    tolerance = 0.51 * 10.0**-trace.settings.output.decimals * (MM_PER_INCH if was.is_inch else 1.0)
    for axis, a, b in zip("XYZ", was.position, now.position, strict=True):
        if not (math.isnan(a) and math.isnan(b)) and not abs(a - b) <= tolerance:
            return f"the position of {axis} ({a:g} and {b:g})"
    if _value(was.feed) != _value(now.feed):
        return "the feed"
    pairs = (("tool", was.tool, now.tool), ("spindle", was.spindle, now.spindle))
    for name, one, other in (*pairs, ("coolant", was.coolant, now.coolant)):
        if one != other:
            return f"the {name}"
    return ""


def _value(setting: object) -> float | None:
    value = getattr(setting, "value", None)
    return None if value is None or math.isnan(value) else float(value)


def _check_cut(result: Trace, region: Region, planned: PlannedCut) -> CheckedCut:
    cut, meant = planned.cut, planned.expansion.distance_mm
    moves = read_moves(result, region.body, region.last)
    if len(moves.span_s) != len(meant):
        raise SelfCheckError(f"{len(meant)} moves were planned, {len(moves.span_s)} stand in the output")
    _check_speed(result, region, planned)
    distance_mm = _check_path(result, moves, planned)
    time_s = np.concatenate(([0.0], np.cumsum(moves.span_s)))
    if not np.all(moves.span_s > 0.0):
        raise SelfCheckError("a move takes no time")
    planned_s = cut.cut.duration_s
    if abs(time_s[-1] - planned_s) > _TIME_TOLERANCE * planned_s:
        raise SelfCheckError(f"a cut planned to take {planned_s:.3f} s takes {time_s[-1]:.3f} s")
    start = next(cut.chain.moves).start
    diameter_mm = 2.0 * max(abs(start.x), abs(cut.chain.after.position.x))
    verdict = judge(
        time_s,
        distance_mm,
        speed_rpm=cut.solution.speed_rpm,
        feed_mm_rev=cut.cut.feed_mm_rev,
        edges=cut.edges,
        diameter_mm=diameter_mm if diameter_mm > 0.0 else None,
        steady_s=full_window(cut.cut),
        waveform=cut.cut.waveform,
        alpha_share=cut.cut.alpha_share,
    )
    return CheckedCut(planned, float(time_s[-1]), len(meant), verdict)


def _check_speed(result: Trace, region: Region, planned: PlannedCut) -> None:
    state = result.before(region.last)
    wanted = planned.cut.solution.speed_rpm
    speed = _value(state.speed)
    if state.modes["speed_mode"] != "rpm" or speed is None or abs(speed - wanted) > 1e-6 * wanted:
        raise SelfCheckError(f"the cut needs {wanted:g} rpm, the output commands {speed}")


def _check_path(
    result: Trace, moves: ReadBack, planned: PlannedCut
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Distance along the path at every knot; never off it, before its start or past its end."""
    cut = planned.cut
    state = cut.chain.before
    unit = MM_PER_INCH if state.is_inch else 1.0
    increment = 10.0**-result.settings.output.decimals * unit / (10.0 if state.is_inch else 1.0)
    along, away = moves.along(cut.path, planned.expansion.distance_mm)
    # Half an increment in each of up to three axes.
    tolerance = math.sqrt(3.0) * 0.5 * increment + 1e-6
    if away.max() > tolerance + CHORD_MM:
        raise SelfCheckError(f"a point lies {away.max():.4f} mm off the path")
    if along.min() < -tolerance or along.max() > cut.path.length_mm + tolerance:
        raise SelfCheckError("a point lies before the start or past the end of the cut")
    if not abs(along[-1] - cut.path.length_mm) <= tolerance:
        raise SelfCheckError("the cut does not end at its programmed end")
    return np.concatenate(([0.0], along))
