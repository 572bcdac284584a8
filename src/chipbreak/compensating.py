"""The stage behind the unrolled cycles: asked shapes under nose compensation are offset by the filter.

What comes out moves the tool where the control would have moved it, under G40.  The passes plan on it as if
it had come in.  Where nothing under G41 or G42 is asked to vibrate, it is the program itself.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from chipbreak.editing.bracket import OFFSET_RUNS
from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.editing.restore import Region, regions
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import main_program
from chipbreak.self_check import verify_unrolled
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.tools.merge import ToolTable
from chipbreak.unrolling import Span, Unrolled, moved_operation
from chipbreak.vibration.request import requests_of

if TYPE_CHECKING:
    from chipbreak.cycles.nose_runs import Run, Written

OFFSET_HERE = "CYC010"
_OTHERS = "tools.other_nose_radius_mm, other_nose_tip"


def offset_noses(
    unrolled: Unrolled,
    read_tools: Callable[[], ToolTable],
    idle: Mapping[int, RefusalError],
) -> Unrolled:
    """Offset the runs under nose compensation in which a cut is asked.

    ``idle`` are runs whose blocks could not vibrate, by their line in the user's file, and why.
    Raises ToolFileError.
    """
    lines = _asked_lines(unrolled)
    if not lines:
        return unrolled
    # Few programs pay for loading what offsets.
    from chipbreak.cycles.nose_runs import compensated_runs

    why = dict(unrolled.reasons)
    written: list[Written] = []
    table = read_tools()
    for run in compensated_runs(unrolled.interpreted):
        asked = lines[bisect_left(lines, run.first) : bisect_left(lines, run.last)]
        if not asked:
            continue
        try:
            written.append(_written(unrolled.interpreted, run, table, idle))
        except RefusalError as error:
            why |= dict.fromkeys(asked, error)
    return _rewritten(unrolled, written, why) if written else unrolled._replace(reasons=why)


def _asked_lines(unrolled: Unrolled) -> list[int]:
    """The lines of the cuts under compensation that are asked to vibrate."""
    interpreted = unrolled.interpreted
    if interpreted.settings.dialect.nose is None or not _may_compensate(interpreted):
        return []
    asked = requests_of(interpreted, unrolled.cut_operations, unrolled.named).requests
    found = (one.effect for one in asked if one.effect.after.modes.compensation != "off")
    return sorted(effect.block.line for effect in found if not effect.in_contour)


def _may_compensate(interpreted: InterpretedProgram) -> bool:
    return any(effect.after.modes.compensation != "off" for effect in interpreted.effects)


def _written(
    interpreted: InterpretedProgram, run: Run, table: ToolTable, idle: Mapping[int, RefusalError]
) -> Written:
    """The edit of a run.  Errors: VIB040 and CYC007, or why nothing in it could vibrate."""
    from chipbreak.cycles.nose_runs import offset_run
    from chipbreak.tools.nose import nose_of

    error = idle.get(_user_line(interpreted, run.first))
    if error is not None:
        raise error
    return offset_run(interpreted, run, nose_of(interpreted, run.first, table))


def _user_line(interpreted: InterpretedProgram, line: int) -> int:
    return interpreted.program.source.place(line).line


def _rewritten(unrolled: Unrolled, written: Sequence[Written], why: Mapping[int, RefusalError]) -> Unrolled:
    """The program with its runs offset, and all that names its lines moved with them."""
    from chipbreak.tools.nose import says_its_nose

    interpreted = unrolled.interpreted
    edits = [one.edit._replace(pass_name="offset") for one in written]
    notes = [
        _note(interpreted, one) for one in edits if not says_its_nose(interpreted.program.block(one.first))
    ]
    output = b"".join(render(interpreted.program, edits, interpreted.settings, OFFSET_RUNS))
    sources = {one.edit.first: one.sources for one in written}
    result = verify_unrolled(interpreted, output, edits, OFFSET_RUNS, sources)
    found = regions(result.program.source, OFFSET_RUNS)
    place = _places(written, found)
    main = main_program(result)
    runs = [
        Span(region.first, region.last, None, _user_line(interpreted, one.edit.first))
        for one, region in zip(written, found, strict=True)
    ]
    return unrolled._replace(
        interpreted=result,
        main=main,
        operations=[moved_operation(one, place, main) for one in unrolled.operations],
        cut_operations=[moved_operation(one, place, main) for one in unrolled.cut_operations],
        spans=[one._replace(first=place(one.first), last=place(one.last)) for one in unrolled.spans],
        edits=[*unrolled.edits, *edits],
        named=frozenset(map(place, unrolled.named)),
        diagnostics=[*unrolled.diagnostics, *notes],
        runs=runs,
        reasons={place(line): error for line, error in why.items()},
    )


def _note(interpreted: InterpretedProgram, edit: Edit) -> Diagnostic:
    """What the operator has to know: numbers of the control that count no more."""
    from chipbreak.cycles.nose_runs import ASSUMED

    message = f"{edit.title}: the filter offsets this run, and the control no more"
    if edit.title.endswith(ASSUMED):
        message += f"; R and T are assumed ({_OTHERS}), for nothing says them of this offset"
    help_text = (
        "R and T of the offset screen, and wear of the nose that is entered there, change nothing here:"
    )
    help_text += " the numbers above must be those of the nose"
    return interpreted.program.diagnose(
        edit.first, OFFSET_HERE, message, help_text, severity=Severity.WARNING
    )


def _places(written: Sequence[Written], found: Sequence[Region]) -> Callable[[int], int]:
    """From a line of the program to the one that stands for it now, or for the next that has one."""
    firsts = [one.edit.first for one in written]

    def place(line: int) -> int:
        at = bisect_right(firsts, line) - 1
        if at < 0:
            return line
        edit = written[at].edit
        if line >= edit.last:
            return found[at].last + line - edit.last
        if line == edit.first:
            return found[at].first
        return found[at].body + bisect_left(written[at].sources, line)

    return place
