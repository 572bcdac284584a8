"""The stage before the passes: cycles that are asked become plain blocks.

What comes out is a program of its own, with the kinds of its operations as they were; the passes plan on it
as if it had come in.  Where nothing asks, it is the program itself.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from chipbreak.editing.bracket import UNROLLED_CYCLES
from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.editing.restore import regions
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.kinds import Kind
from chipbreak.operations.main_program import MainProgram, main_program
from chipbreak.operations.operations import Operation
from chipbreak.self_check import verify_unrolled
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.left_cut import LeftCut
from chipbreak.vibration.request import may_be_left, profile_directive, requests_of
from chipbreak.vibration.scope import Scope
from chipbreak.vibration.wish import AskedBy

if TYPE_CHECKING:
    from chipbreak.cycles.plan import Refused, UnrollPlan

_NO_REASONS: Mapping[int, RefusalError] = FrozenTable({})
UNROLL = "unroll"
_UNKNOWN_REASON = "none of its passes can vibrate"


class Span(NamedTuple):
    """Lines ``first`` to ``last`` (exclusive) that stand for a cycle, the kind of its cuts, and its group.

    A cycle that says no kind has that of its operation.  ``title``, ``passes`` and ``depth_mm`` (None where
    the passes have no common one) say what was written.
    """

    first: int
    last: int
    kind: Kind | None
    group: int
    title: str = ""
    passes: int = 1
    depth_mm: float | None = None


class Unrolled(NamedTuple):
    """A program whose cycles are plain blocks, or the program itself.

    ``cut_operations`` are the operations with the cycles as operations of their own, for wishes by kind.
    ``diagnostics`` and ``left`` are about cycles that stay; ``named`` are their lines.  ``runs`` are lines
    under nose compensation that were offset; ``reasons`` say, by line, why other cuts under it stay, and
    why corners are not drawn.
    """

    interpreted: InterpretedProgram
    main: MainProgram
    operations: Sequence[Operation]
    cut_operations: Sequence[Operation]
    spans: Sequence[Span] = ()
    edits: Sequence[Edit] = ()
    diagnostics: Sequence[Diagnostic] = ()
    left: Sequence[LeftCut] = ()
    named: frozenset[int] = frozenset()
    runs: Sequence[Span] = ()
    reasons: Mapping[int, RefusalError] = _NO_REASONS

    def idle(self, edits: Sequence[Edit]) -> set[int]:
        """The groups of cycles in whose blocks none of the edits lies."""
        return _idle(self.spans, edits)

    def idle_runs(self, edits: Sequence[Edit]) -> set[int]:
        """The same of the runs that were offset."""
        return _idle(self.runs, edits)


def _idle(spans: Sequence[Span], edits: Sequence[Edit]) -> set[int]:
    groups = {span.group for span in spans}
    lines = [(edit.first, edit.last) for edit in edits]
    busy = {s.group for s in spans if any(first < s.last and s.first < last for first, last in lines)}
    return groups - busy


def unroll(
    interpreted: InterpretedProgram,
    main: MainProgram,
    operations: Sequence[Operation],
    idle: Mapping[int, RefusalError],
) -> Unrolled:
    """Write out the cycles that are asked.

    ``idle`` are groups of cycles whose blocks could not vibrate, by their line, and why.
    """
    asked, cuts = _asked(interpreted, operations)
    plain = Unrolled(interpreted, main, operations, operations)
    if not (asked or cuts):
        return plain
    # Few programs pay for loading the cycles.
    from chipbreak.cycles.plan import Refused, UnrollPlan, plan_unrolling

    plan = plan_unrolling(interpreted, asked, cuts)
    plan = UnrollPlan(
        [one for one in plan.edits if one.group not in idle],
        [*plan.refused, *(Refused(line, error) for line, error in idle.items() if line in asked)],
        plan.notes,
        plan.undrawn,
    )
    diagnostics, left = _said(interpreted, plan.refused, asked)
    diagnostics += _noted(interpreted, plan)
    named = {line for one in plan.refused for line in (one.line, *one.others)}
    if not plan.edits:
        named_lines = frozenset(named)
        return plain._replace(diagnostics=diagnostics, left=left, named=named_lines, reasons=plan.undrawn)
    edits = [one.edit._replace(pass_name=UNROLL) for one in plan.edits]
    output = b"".join(render(interpreted.program, edits, interpreted.settings, UNROLLED_CYCLES))
    result = verify_unrolled(interpreted, output, edits)
    found = regions(result.program.source, UNROLLED_CYCLES)
    ordered = sorted(plan.edits, key=lambda one: one.edit.first)
    spans = [
        Span(region.first, region.last, one.kind, one.group, one.edit.title, one.passes, one.depth_mm)
        for region, one in zip(found, ordered, strict=True)
        if one.edit.content and one.is_cycle
    ]
    new_main = main_program(result)
    place = _places([one.edit for one in ordered], [(region.first, region.last) for region in found])
    moved = [moved_operation(operation, place, new_main) for operation in operations]
    return Unrolled(
        result,
        new_main,
        moved,
        [*_split(moved, spans), *_beyond(moved, spans, result)],
        spans,
        edits,
        diagnostics,
        left,
        frozenset(map(place, named)),
        reasons={place(line): error for line, error in plan.undrawn.items()},
    )


def _asked(
    interpreted: InterpretedProgram, operations: Sequence[Operation]
) -> tuple[dict[int, AskedBy | None], list[int]]:
    """The lines of the cycles that are to be written out, with who asked, and those of other cuts.

    Nobody has asked (None) where all are written out.
    """
    settings = interpreted.settings
    rule = settings.cycles.unroll
    if rule == "never" or (rule == "asked" and not _may_wish(interpreted)):
        return {}, []
    from chipbreak.cycles.pecks import is_deep_hole, is_peck
    from chipbreak.cycles.plan import cycle_lines

    requests = requests_of(interpreted, operations)
    cuts = [request.effect.block.line for request in requests.requests]
    kinds = cycle_lines(interpreted)
    pecks = (one for one in requests.pecks if is_peck(interpreted, one) or is_deep_hole(interpreted, one))
    kinds |= dict.fromkeys(pecks)
    wishes = {line: by for line, by in _of_cuts(interpreted, requests.cycles) if line in kinds}
    if rule == "always":
        words = {line: by for line, by in wishes.items() if by == "word"}
        return dict[int, AskedBy | None].fromkeys(kinds) | words, cuts
    scope = Scope(settings.vibration.only, operations)
    return _meant(wishes, kinds, scope), cuts


def _meant(
    wishes: Mapping[int, AskedBy], kinds: Mapping[int, Kind | None], scope: Scope
) -> dict[int, AskedBy | None]:
    """The cycles that a wish is for, with who asked."""
    return {line: by for line, by in wishes.items() if by != "profile" or _is_meant(line, kinds[line], scope)}


def _of_cuts(interpreted: InterpretedProgram, asked: Mapping[int, AskedBy]) -> Iterator[tuple[int, AskedBy]]:
    """The cycles that are asked, but for those of a profile that run while the spindle stands: no cuts."""
    for line, by in asked.items():
        effect = interpreted.effect(line)
        may_cut = any(state.turns or state.spindle_why for state in (effect.before, effect.after))
        if by != "profile" or may_cut:
            yield line, by


def _may_wish(interpreted: InterpretedProgram) -> bool:
    """False where neither the profile, nor a comment, nor a word of a cycle can ask for vibration."""
    blocks = interpreted.program.event_blocks()
    return profile_directive(interpreted.settings).on or any(
        block.has("N") or any("VIB" in comment.text.upper() for comment in block.comments) for block in blocks
    )


def _is_meant(line: int, kind: Kind | None, scope: Scope) -> bool:
    """True where the profile's wish is for this cycle; one that says no kind has that of its operation."""
    if kind is None:
        return scope.is_asked(line)
    if not scope.only:
        return kind is Kind.ROUGH
    operation = scope.operation_of(line)
    return kind.value in scope.only or (operation is not None and f"T{operation.tool}" in scope.only)


def _said(
    interpreted: InterpretedProgram, refused: Sequence[Refused], asked: Mapping[int, AskedBy | None]
) -> tuple[list[Diagnostic], list[LeftCut]]:
    """An error for a cycle that must be written out; a warning where it may stay as it was."""
    diagnostics = []
    left = []
    rule = interpreted.settings.vibration.refused
    for line, error, _ in refused:
        asked_by = asked.get(line)
        stays = asked_by is None or may_be_left(asked_by, rule)
        severity = Severity.WARNING if stays else Severity.ERROR
        said = interpreted.program.diagnose(line, error.code, error.message, error.help, severity=severity)
        if stays:
            said = said._replace(message=f"{said.message}; the cycle stays as it was")
        diagnostics.append(said)
        if stays and asked_by is not None:
            left.append(LeftCut(line, line + 1, said, asked_by))
    return diagnostics, left


def _noted(interpreted: InterpretedProgram, plan: UnrollPlan) -> list[Diagnostic]:
    """What is to be known of cycles that are written out."""
    lines = {line for one in plan.edits for line in range(one.edit.first, one.edit.last)}
    said = [(one.line, one.error) for one in plan.notes if one.line in lines]
    program = interpreted.program
    return [
        program.diagnose(line, error.code, error.message, error.help, severity=Severity.WARNING)
        for line, error in said
    ]


def _places(edits: Sequence[Edit], regions: Sequence[tuple[int, int]]) -> Callable[[int], int]:
    """From a line of the original to one of the result; a replaced line is where its blocks begin."""
    firsts = [edit.first for edit in edits]

    def place(line: int) -> int:
        at = bisect_right(firsts, line) - 1
        if at < 0:
            return line
        first, last = regions[at]
        return first if line < edits[at].last else last + line - edits[at].last

    return place


def moved_operation(operation: Operation, place: Callable[[int], int], main: MainProgram) -> Operation:
    """An operation where its lines stand now; what it is stays."""
    first, last = place(operation.first_line), place(operation.last_line)
    first_cut, last_cut = main.cut_ends(first, last) or (None, None)
    call = None if operation.call_line is None else place(operation.call_line)
    return replace(
        operation, first_line=first, last_line=last, call_line=call, first_cut=first_cut, last_cut=last_cut
    )


def _split(operations: Sequence[Operation], spans: Sequence[Span]) -> list[Operation]:
    """The operations, with each cycle in one of its own."""
    found: list[Operation] = []
    for operation in operations:
        line = operation.first_line
        for span in spans:
            if span.kind is not None and operation.first_line <= span.first < operation.last_line:
                found.append(replace(operation, first_line=line, last_line=span.first))
                found.append(_of_cycle(operation, span.first, span.last, span.kind))
                line = span.last
        found.append(replace(operation, first_line=line))
    return found


def _beyond(
    operations: Sequence[Operation], spans: Sequence[Span], result: InterpretedProgram
) -> Iterator[Operation]:
    """The cycles of other programs behind the main one, where nothing is read as an operation."""
    behind = max((one.last_line for one in operations), default=0)
    for span in spans:
        if span.kind is not None and span.first >= behind:
            at = result.before(span.first)
            reason = "its cycle was written out"
            yield Operation(
                -1, at.tool, span.kind, reason, "", span.first, span.last, None, None, None, None, at.spindle
            )


def _of_cycle(operation: Operation, first: int, last: int, kind: Kind) -> Operation:
    reason = "its cycle was written out"
    return replace(operation, first_line=first, last_line=last, kind=kind, reason=reason)


def reason_of(left: Sequence[LeftCut], spans: Sequence[Span], group: int) -> RefusalError:
    """Why nothing in a group of cycles vibrates: what its first cut that was left says."""
    for cut in left:
        if cut.said.code and any(s.group == group and s.first <= cut.first < s.last for s in spans):
            message = f"{_UNKNOWN_REASON}: {cut.said.message}"
            return RefusalError(cut.said.code, message, cut.said.help)
    from chipbreak.cycles.call import UNREAD_FORM

    return RefusalError(UNREAD_FORM, _UNKNOWN_REASON, "ask for another n, f or S, or take the wish out")
