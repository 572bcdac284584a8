"""The output distrusts itself: it is read again, put back, interpreted and measured before a byte is written.

What must hold: putting it back gives the original bytes; at the borders of every change the control is in
the state of the original, but for a spindle speed that was changed on purpose; every vibrated cut starts and
ends where it was programmed, stays on its path and takes its time.  The verdict on the chips comes from the
moves as they stand in the output.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from chipbreak.diagnostics import SelfCheckError
from chipbreak.edits import Edit, in_order
from chipbreak.model.modal import Setting, State
from chipbreak.model.trace import Trace, interpret
from chipbreak.model.words import codes_of
from chipbreak.passes import VIBRATE
from chipbreak.restore import Region, regions, restores
from chipbreak.source import Source, read
from chipbreak.syntax.parse import parse_changed
from chipbreak.units import MM_PER_INCH
from chipbreak.unroll import unrolled

if TYPE_CHECKING:
    from chipbreak.measure import CheckedCut
    from chipbreak.passes.vibrate import PlannedCut


def verify(
    trace: Trace, output: bytes, edits: Sequence[Edit], cuts: Sequence[PlannedCut]
) -> list[CheckedCut]:
    """Check the output against the original.  Raises SelfCheckError."""
    source = read(output, trace.program.source.name)
    found = regions(source)
    if not restores(source, found, trace.program.source.data):
        raise SelfCheckError("putting the output back does not give the original bytes")
    ordered = in_order(edits)
    if len(found) != len(ordered):
        raise SelfCheckError(f"{len(ordered)} changes were planned, {len(found)} stand in the output")
    _check_lengths(source, found, ordered, trace)
    source, found = unrolled(source, found, trace.settings.dialect.loop)
    # What stands between the changes has just been found equal, so it need not be classified twice.
    kept = _kept(trace, source, ordered, found)
    result = interpret(parse_changed(source, trace.program, kept), trace.settings)
    by_edit = {id(cut.edit): cut for cut in cuts}
    checked = []
    motion_from = 0
    following = [edit.first for edit in ordered[1:]] + [trace.program.source.body.stop]
    for edit, region, stop in zip(ordered, found, following, strict=True):
        planned = by_edit.get(id(edit))
        if planned is not None and planned.cut.chain.after.modes["motion"] != "line":
            motion_from = _next_motion_code(trace, edit.last)
        _check_states(trace, result, edit, region, motion_from)
        _check_return(trace, result, edit, region, stop)
        if planned is not None:
            # Only programs that vibrate pay for loading the measuring of cuts.
            from chipbreak.measure import measure_cut

            checked.append(measure_cut(result, region, planned))
        elif edit.pass_name == VIBRATE:
            _check_speed_back(trace, result, edit, region)
    return checked


def _kept(
    trace: Trace, source: Source, edits: Sequence[Edit], found: Sequence[Region]
) -> list[tuple[int, int, int]]:
    """The stretches of lines between changes: first, last, first in the original."""
    firsts = [0, *(region.last for region in found)]
    lasts = [*(region.first for region in found), source.line_count]
    old_firsts = [0, *(edit.last for edit in edits)]
    old_lasts = [*(edit.first for edit in edits), trace.program.source.line_count]
    kept = list(zip(firsts, lasts, old_firsts, strict=True))
    old_counts = [last - first for first, last in zip(old_firsts, old_lasts, strict=True)]
    if [last - first for first, last, _ in kept] != old_counts:
        raise SelfCheckError("the lines between the changes are not those of the original")
    return kept


def _check_lengths(source: Source, found: Sequence[Region], edits: Sequence[Edit], trace: Trace) -> None:
    """No new block is longer than the control takes; a comment that is kept may be as long as it was."""
    limit, original = trace.settings.control.max_line_chars, trace.program.source
    for region, edit in zip(found, edits, strict=True):
        sizes = np.diff(source.starts[region.first : region.last + 1])
        for line in (np.flatnonzero(sizes > limit) + region.first).tolist():
            text = source.text(line)
            if len(text) > limit and text not in map(original.text, range(edit.first, edit.last)):
                raise SelfCheckError(f"a new block has {len(text)} characters, the control takes {limit}")


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
        if was.ended:
            continue  # the next block starts another program, from the power-on state
        if line <= motion_from:
            now = now.with_modes({"motion": was.modes["motion"]})
        wrong = _difference(was, now)
        if not wrong and edit.first != edit.last:
            wrong = _moved(was, now, trace)
        if wrong:
            raise SelfCheckError(f"{where} line {line + 1} {wrong} differs from the original")


def _check_speed_back(trace: Trace, result: Trace, edit: Edit, region: Region) -> None:
    """What gives the programmed spindle speed back gives back that speed, in its mode."""
    was, now = trace.before(edit.last), result.before(region.last)
    spoken = [(s.modes["speed_mode"], _value(s.speed), _value(s.speed_limit)) for s in (was, now)]
    if spoken[0] != spoken[1]:
        raise SelfCheckError(f"before line {edit.last + 1} the spindle speed is not the programmed one")


def _check_return(trace: Trace, result: Trace, edit: Edit, region: Region, stop: int) -> None:
    """Insertions may leave the tool elsewhere as long as the program itself takes it to the next cut.

    From ``stop`` on, the next change looks after that itself.
    """
    if edit.first != edit.last or _is_same(trace.before(edit.last), result.before(region.last)):
        return
    for step in trace.steps(edit.last, stop):
        if step.after.ended:
            return
        if step.move is None or step.move.kind == "rapid":
            continue
        new_line = region.last + step.block.line - edit.last
        wrong = _moved(step.before, result.before(new_line), trace)
        if wrong:
            message = f"behind the insertion at line {edit.first + 1} a cut begins elsewhere: {wrong}"
            raise SelfCheckError(message)
        return


def _is_same(was: State, now: State) -> bool:
    pairs = zip(was.position, now.position, strict=True)
    return all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in pairs)


def _moved(was: State, now: State, trace: Trace) -> str:
    """Which axis does not stand where it stood."""
    tolerance = 0.51 * 10.0**-trace.settings.output.decimals * (MM_PER_INCH if was.is_inch else 1.0)
    for axis, a, b in zip("XYZ", was.position, now.position, strict=True):
        if not (math.isnan(a) and math.isnan(b)) and not abs(a - b) <= tolerance:
            return f"the position of {axis} ({a:g} and {b:g})"
    return ""


def _difference(was: State, now: State) -> str:
    # A group that the original never set (a path mode given back as usual) has nothing to differ from.
    groups = {g for g in was.modes if was.modes[g] != now.modes.get(g)} - {"speed_mode"}
    if groups:
        return f"the modal state ({', '.join(sorted(groups))})"
    if was.path_words and was.path_words != now.path_words:
        return "the path mode"
    if was.smooth_words and was.smooth_words != now.smooth_words:
        return "the smoothing"
    if _value(was.feed) != _value(now.feed):
        return "the feed"
    # A speed mode that was changed on purpose takes its limit with it, until both come back.
    same_mode = was.modes["speed_mode"] == now.modes["speed_mode"]
    if same_mode and _value(was.speed_limit) != _value(now.speed_limit):
        return "the limit of the spindle"
    pairs = (("tool", was.tool, now.tool), ("spindle", was.spindle, now.spindle))
    for name, one, other in (*pairs, ("coolant", was.coolant, now.coolant)):
        if one != other:
            return f"the {name}"
    return ""


def _value(setting: Setting | None) -> float | None:
    return None if setting is None or math.isnan(setting.value) else setting.value
