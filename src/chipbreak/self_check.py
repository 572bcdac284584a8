"""The output distrusts itself: it is read again, put back, interpreted and measured before a byte is written.

What must hold: putting it back gives the original bytes; at the borders of every change the control is in
the state of the original, but for what its promise leaves open; and each promise holds.  Who made a change
does not matter here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from chipbreak.editing.bracket import UNROLLED_CYCLES, Layer
from chipbreak.editing.edits import Edit, in_order
from chipbreak.editing.promise import Promise, Written
from chipbreak.editing.restore import Region, regions, restores
from chipbreak.editing.unroll import unrolled
from chipbreak.model.deeds import deeds_in
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import State
from chipbreak.model.paths import begins_program
from chipbreak.model.state_difference import difference, is_same_place, moved, spindle_speed
from chipbreak.model.stops import stops
from chipbreak.model.words import settles_motion
from chipbreak.syntax.parse import parse_changed
from chipbreak.text.diagnostics import ChipbreakError, SelfCheckError
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source, UserLines, in_a_row, read, user_lines

_NO_SOURCES: Mapping[int, Sequence[int]] = FrozenTable({})


class Kept(NamedTuple):
    """A promise that holds, with what was found when it was looked after."""

    edit: Edit
    report: object


def verify(interpreted: InterpretedProgram, output: bytes, edits: Sequence[Edit]) -> list[Kept]:
    """Check the output against the original; the promises that have something to report.

    Raises SelfCheckError.
    """
    source = read(output, interpreted.program.source.name, encoding=interpreted.program.source.encoding)
    found = regions(source)
    if not restores(source, found, interpreted.program.source.data):
        raise SelfCheckError("putting the output back does not give the original bytes")
    ordered = in_order(edits)
    if len(found) != len(ordered):
        raise SelfCheckError(f"{len(ordered)} changes were planned, {len(found)} stand in the output")
    _check_lengths(source, found, ordered, interpreted)
    kept = []
    motion_from = 0  # before this line the motion code may be another one
    for written in _written(interpreted, source, ordered, found):
        promise = written.edit.promise
        if promise.leaves_motion:
            motion_from = _next_motion_code(interpreted, written.edit.last)
        _check_stops(written)
        _check_deeds(written)
        _check_borders(written, motion_from)
        _check_motion(written, motion_from)
        _check_return(written)
        _check_speed(written)
        report = _report(written)
        reports = report if isinstance(report, tuple) else (report,)
        kept += [Kept(written.edit, one) for one in reports if one is not None]
    return kept


def verify_unrolled(
    interpreted: InterpretedProgram,
    output: bytes,
    edits: Sequence[Edit],
    layer: Layer = UNROLLED_CYCLES,
    sources: Mapping[int, Sequence[int]] = _NO_SOURCES,
) -> InterpretedProgram:
    """Check a program whose cycles have been written out; it, read and interpreted.

    The original does not say where its cycles move, so what must hold is said by their promises alone.
    ``sources``: for an edit, by its first line, the lines for which its new ones stand.
    Raises SelfCheckError.
    """
    original = interpreted.program.source
    source = read(output, original.name, encoding=original.encoding)
    found = regions(source, layer)
    if not restores(source, found, original.data):
        raise SelfCheckError("putting the cycles back does not give the original bytes")
    ordered = in_order(edits)
    if len(found) != len(ordered):
        raise SelfCheckError(f"{len(ordered)} cycles were planned, {len(found)} stand in the output")
    _check_lengths(source, found, ordered, interpreted)
    kept = _kept(interpreted, source, ordered, found)
    source = source._replace(user_lines=_user_lines(original, ordered, found, kept, sources))
    result = interpret(parse_changed(source, interpreted.program, kept), interpreted.settings, interpreted)
    for edit, region in zip(ordered, found, strict=True):
        written = Written(edit, region, interpreted, result, original.body.stop)
        _check_deeds(written)
        _report(written)
    return result


def _user_lines(
    original: Source,
    edits: Sequence[Edit],
    found: Sequence[Region],
    kept: Sequence[tuple[int, int, int]],
    sources: Mapping[int, Sequence[int]],
) -> UserLines:
    """Where every line of the output stands in the user's file; a new block stands where its cycle does."""
    pieces = [user_lines(original, kept[0][2], kept[0][2] + kept[0][1] - kept[0][0])]
    for edit, region, (first, last, old_first) in zip(edits, found, kept[1:], strict=True):
        lines = np.full(region.last - region.first, edit.first)
        if edit.first in sources:
            lines[region.body - region.first : -1] = sources[edit.first]
        file, numbers, shifts = user_lines(original, edit.first, edit.last)
        there = lines - edit.first
        pieces.append(UserLines(file, numbers[there], np.full_like(shifts, -1)[there]))
        pieces.append(user_lines(original, old_first, old_first + last - first))
    return in_a_row(pieces)


def written_edits(interpreted: InterpretedProgram, output: bytes, edits: Sequence[Edit]) -> Iterator[Written]:
    """The edits of an output that has been verified, each with its place in it."""
    source = read(output, interpreted.program.source.name)
    return _written(interpreted, source, in_order(edits), regions(source))


def _report(written: Written) -> object | None:
    """What a promise reports.  One that cannot be looked after does not hold."""
    edit = written.edit
    try:
        return edit.promise.check(written)
    except (ChipbreakError, MemoryError):
        raise
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        message = f"the promise of {edit.pass_name} at line {edit.first + 1} cannot be checked: {what}"
        raise SelfCheckError(message) from error


def _written(
    interpreted: InterpretedProgram, source: Source, edits: Sequence[Edit], found: Sequence[Region]
) -> Iterator[Written]:
    """Every edit with its place in the output, which is read and interpreted for it."""
    source, found = unrolled(source, found, interpreted.settings.dialect.loop)
    # What stands between the changes has just been found equal, so it need not be classified twice.
    kept = _kept(interpreted, source, edits, found)
    result = interpret(parse_changed(source, interpreted.program, kept), interpreted.settings, interpreted)
    stops = [edit.first for edit in edits[1:]] + [interpreted.program.source.body.stop]
    for edit, region, stop in zip(edits, found, stops, strict=True):
        yield Written(edit, region, interpreted, result, stop)


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
    """No new block is longer than the control takes, or than the program's own that it stands for."""
    limit = interpreted.settings.control.max_line_chars
    original = interpreted.program.source
    for region, edit in zip(found, edits, strict=True):
        sizes = np.diff(source.starts[region.first : region.last + 1])
        for line in (np.flatnonzero(sizes > limit) + region.first).tolist():
            text = source.text(line)
            most = max([limit, *(len(original.text(old)) for old in range(edit.first, edit.last))])
            if len(text) > most:
                raise SelfCheckError(f"a new block has {len(text)} characters, the control takes {limit}")


def _check_stops(written: Written) -> None:
    """The control does not stop at a new block."""
    region = written.region
    found = stops(written.result, range(region.first, region.last))
    if found:
        raise SelfCheckError(f"{found[0].message}, and it stands in a new block")


def _check_deeds(written: Written) -> None:
    """What the blocks did beside moving, those that stand for them do, too."""
    edit = written.edit
    region = written.region
    wanted = deeds_in(written.original, edit.first, edit.last)
    if not wanted:
        return
    done = deeds_in(written.result, region.body, region.last)
    for deed, line in wanted.items():
        if deed not in done:
            raise SelfCheckError(f"{deed} of line {line + 1} is lost in the new blocks")


def _next_motion_code(interpreted: InterpretedProgram, first: int) -> int:
    """The next line that says G0 to G3 or another motion code; the last line where there is none."""
    stop = interpreted.program.source.body.stop
    path = interpreted.before(first).path
    for effect in interpreted.effects_of(first, stop):
        if effect.in_contour:
            continue  # the control passes over it
        if effect.after.path == path and settles_motion(effect.block, interpreted.settings.dialect):
            return effect.block.line
    return stop


def _check_borders(written: Written, motion_from: int) -> None:
    """The control is in the same state before and behind a change as it was in the original.

    The motion code counts only behind line ``motion_from``.
    """
    edit = written.edit
    region = written.region
    for where, line, new_line in (("before", edit.first, region.first), ("behind", edit.last, region.last)):
        was = written.original.before(line)
        now = written.result.before(new_line)
        if was.ended or _begins_another(written.original, line):
            continue  # the next block starts another program, from the power-on state
        if line <= motion_from:
            now = now.with_motion(was.modes.motion)
        if where == "behind":
            now = _but_what_is_left(edit.promise, was, now)
        wrong = difference(was, now)
        if not wrong and edit.first != edit.last:
            wrong = moved(was, now)
        if wrong:
            raise SelfCheckError(f"{where} line {line + 1} {wrong} differs from the original")


def _begins_another(original: InterpretedProgram, line: int) -> bool:
    """Another program of the file begins, where the one before it has not said its end."""
    program = original.program
    return line < program.source.body.stop and begins_program(program.block(line), program.dialect)


def _but_what_is_left(promise: Promise, was: State, now: State) -> State:
    """The state behind an edit, as if what its promise leaves to the program were given back."""
    if promise.leaves_spindle:
        now = now._replace(spindle=was.spindle)
    if promise.leaves_feed:
        now = now._replace(feed=was.feed)
    return now._replace(coolant=was.coolant) if promise.leaves_coolant else now


def _check_motion(written: Written, motion_from: int) -> None:
    """Where another motion code was left in force, nothing moves before the program says its own."""
    is_left = written.was_behind.modes.motion != written.now_behind.modes.motion
    if written.edit.last > motion_from or not is_left:
        return
    for effect in written.blocks_behind():
        if settles_motion(effect.block, written.original.settings.dialect):
            return
        if effect.move is not None and effect.after.modes.motion != "cycle":
            raise SelfCheckError(f"line {effect.block.line + 1} moves under another motion code")


def _check_return(written: Written) -> None:
    """Insertions may leave the tool elsewhere as long as the program itself takes it to the next cut.

    From the next change on, that one looks after this itself.
    """
    edit = written.edit
    if edit.first != edit.last or is_same_place(written.was_behind, written.now_behind):
        return
    cut = written.first_cut_behind()
    if cut is None:
        return
    now = written.result.before(written.line_in_result(cut.block.line))
    wrong = moved(cut.before, now)
    if wrong:
        raise SelfCheckError(f"behind the insertion at line {edit.first + 1} a cut begins elsewhere: {wrong}")


def _check_speed(written: Written) -> None:
    """An edit that does not say so changes no spindle speed.

    An edit before it may have left another one, so what counts is what happens inside.
    """
    edit = written.edit
    region = written.region
    if edit.promise.leaves_speed or written.was_behind.ended:
        return
    was, now = (
        spindle_speed(state)
        for state in (written.original.before(edit.first), written.result.before(region.first))
    )
    was_behind, now_behind = spindle_speed(written.was_behind), spindle_speed(written.now_behind)
    wanted = now if was == was_behind else was_behind
    if now_behind != wanted:
        raise SelfCheckError(f"behind line {edit.last + 1} the spindle speed differs from the original")
