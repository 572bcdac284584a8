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

from chipbreak.dialects.modes import UNSAID
from chipbreak.editing.edits import Edit, in_order
from chipbreak.editing.restore import Region, regions, restores
from chipbreak.editing.unroll import unrolled
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import Setting, State
from chipbreak.model.words import codes_of
from chipbreak.syntax.parse import parse_changed
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.source import Source, read
from chipbreak.units import MM_PER_INCH
from chipbreak.vibration.cut_edit import VIBRATE

if TYPE_CHECKING:
    from chipbreak.vibration.cut_edit import PlannedCut
    from chipbreak.vibration.measure import CutReport


def verify(
    interpreted: InterpretedProgram, output: bytes, edits: Sequence[Edit], cuts: Sequence[PlannedCut]
) -> list[CutReport]:
    """Check the output against the original.  Raises SelfCheckError."""
    source = read(output, interpreted.program.source.name)
    found = regions(source)
    if not restores(source, found, interpreted.program.source.data):
        raise SelfCheckError("putting the output back does not give the original bytes")
    ordered = in_order(edits)
    if len(found) != len(ordered):
        raise SelfCheckError(f"{len(ordered)} changes were planned, {len(found)} stand in the output")
    _check_lengths(source, found, ordered, interpreted)
    source, found = unrolled(source, found, interpreted.settings.dialect.loop)
    # What stands between the changes has just been found equal, so it need not be classified twice.
    kept = _kept(interpreted, source, ordered, found)
    result = interpret(parse_changed(source, interpreted.program, kept), interpreted.settings)
    by_edit = {id(cut.edit): cut for cut in cuts}
    checked = []
    motion_from = 0
    following = [edit.first for edit in ordered[1:]] + [interpreted.program.source.body.stop]
    for edit, region, stop in zip(ordered, found, following, strict=True):
        planned = by_edit.get(id(edit))
        if planned is not None and planned.plan.chain.after.modes.motion != "line":
            motion_from = _next_motion_code(interpreted, edit.last)
        _check_states(interpreted, result, edit, region, motion_from)
        _check_return(interpreted, result, edit, region, stop)
        if planned is not None:
            # Only programs that vibrate pay for loading the measuring of cuts.
            from chipbreak.vibration.measure import measure_cut

            checked.append(measure_cut(result, region, planned.plan, planned.expansion))
        elif edit.pass_name == VIBRATE:
            _check_speed_back(interpreted, result, edit, region)
    return checked


def _kept(
    interpreted: InterpretedProgram, source: Source, edits: Sequence[Edit], found: Sequence[Region]
) -> list[tuple[int, int, int]]:
    """The stretches of lines between changes: first, last, first in the original."""
    firsts = [0, *(region.last for region in found)]
    lasts = [*(region.first for region in found), source.line_count]
    old_firsts = [0, *(edit.last for edit in edits)]
    old_lasts = [*(edit.first for edit in edits), interpreted.program.source.line_count]
    kept = list(zip(firsts, lasts, old_firsts, strict=True))
    old_counts = [last - first for first, last in zip(old_firsts, old_lasts, strict=True)]
    if [last - first for first, last, _ in kept] != old_counts:
        raise SelfCheckError("the lines between the changes are not those of the original")
    return kept


def _check_lengths(
    source: Source, found: Sequence[Region], edits: Sequence[Edit], interpreted: InterpretedProgram
) -> None:
    """No new block is longer than the control takes; a comment that is kept may be as long as it was."""
    limit, original = interpreted.settings.control.max_line_chars, interpreted.program.source
    for region, edit in zip(found, edits, strict=True):
        sizes = np.diff(source.starts[region.first : region.last + 1])
        for line in (np.flatnonzero(sizes > limit) + region.first).tolist():
            text = source.text(line)
            if len(text) > limit and text not in map(original.text, range(edit.first, edit.last)):
                raise SelfCheckError(f"a new block has {len(text)} characters, the control takes {limit}")


def _next_motion_code(interpreted: InterpretedProgram, first: int) -> int:
    """The next line that says G0 to G3 or another motion code; the last line where there is none."""
    stop = interpreted.program.source.body.stop
    for effect in interpreted.effects_of(first, stop):
        if codes_of(effect.block, "motion", interpreted.settings.dialect):
            return effect.block.line
    return stop


def _check_states(
    interpreted: InterpretedProgram, result: InterpretedProgram, edit: Edit, region: Region, motion_from: int
) -> None:
    """The control is in the same state before and behind a change as it was in the original.

    A chain that ends in an arc leaves G1 behind; the pass made sure that the next move says its own code, so
    the motion code counts only behind line ``motion_from``.
    """
    for where, line, new_line in (("before", edit.first, region.first), ("behind", edit.last, region.last)):
        was, now = interpreted.before(line), result.before(new_line)
        if was.ended:
            continue  # the next block starts another program, from the power-on state
        if line <= motion_from:
            now = now.with_motion(was.modes.motion)
        wrong = _difference(was, now)
        if not wrong and edit.first != edit.last:
            wrong = _moved(was, now, interpreted)
        if wrong:
            raise SelfCheckError(f"{where} line {line + 1} {wrong} differs from the original")


def _check_speed_back(
    interpreted: InterpretedProgram, result: InterpretedProgram, edit: Edit, region: Region
) -> None:
    """What gives the programmed spindle speed back gives back that speed, in its mode."""
    was, now = interpreted.before(edit.last), result.before(region.last)
    spoken = [(s.modes.speed_mode, _value(s.speed), _value(s.speed_limit)) for s in (was, now)]
    if spoken[0] != spoken[1]:
        raise SelfCheckError(f"before line {edit.last + 1} the spindle speed is not the programmed one")


def _check_return(
    interpreted: InterpretedProgram, result: InterpretedProgram, edit: Edit, region: Region, stop: int
) -> None:
    """Insertions may leave the tool elsewhere as long as the program itself takes it to the next cut.

    From ``stop`` on, the next change looks after that itself.
    """
    if edit.first != edit.last or _is_same(interpreted.before(edit.last), result.before(region.last)):
        return
    for effect in interpreted.effects_of(edit.last, stop):
        if effect.after.ended:
            return
        if effect.move is None or effect.move.kind == "rapid":
            continue
        new_line = region.last + effect.block.line - edit.last
        wrong = _moved(effect.before, result.before(new_line), interpreted)
        if wrong:
            message = f"behind the insertion at line {edit.first + 1} a cut begins elsewhere: {wrong}"
            raise SelfCheckError(message)
        return


def _is_same(was: State, now: State) -> bool:
    pairs = zip(was.position, now.position, strict=True)
    return all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in pairs)


def _moved(was: State, now: State, interpreted: InterpretedProgram) -> str:
    """Which axis does not stand where it stood."""
    tolerance = 0.51 * 10.0**-interpreted.settings.output.decimals * (MM_PER_INCH if was.is_inch else 1.0)
    for axis, a, b in zip("XYZ", was.position, now.position, strict=True):
        if not (math.isnan(a) and math.isnan(b)) and not abs(a - b) <= tolerance:
            return f"the position of {axis} ({a:g} and {b:g})"
    return ""


def _difference(was: State, now: State) -> str:
    # A group that the original never set (a path mode given back as usual) has nothing to differ from.
    changed = was.modes.changed(now.modes)
    groups = {group for group in changed if was.modes.value(group) != UNSAID} - {"speed_mode"}
    if groups:
        return f"the modal state ({', '.join(sorted(groups))})"
    if was.path_words and was.path_words != now.path_words:
        return "the path mode"
    if was.smooth_words and was.smooth_words != now.smooth_words:
        return "the smoothing"
    if _value(was.feed) != _value(now.feed):
        return "the feed"
    # A speed mode that was changed on purpose takes its limit with it, until both come back.
    same_mode = was.modes.speed_mode == now.modes.speed_mode
    if same_mode and _value(was.speed_limit) != _value(now.speed_limit):
        return "the limit of the spindle"
    pairs = (("tool", was.tool, now.tool), ("spindle", was.spindle, now.spindle))
    for name, one, other in (*pairs, ("coolant", was.coolant, now.coolant)):
        if one != other:
            return f"the {name}"
    return ""


def _value(setting: Setting | None) -> float | None:
    return None if setting is None or math.isnan(setting.value) else setting.value
