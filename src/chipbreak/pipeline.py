"""The whole way of a program, once, in order: read, put back, interpret, plan, apply, verify."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING

from chipbreak.compensating import offset_noses
from chipbreak.editing.beside import Parted, parted, with_brackets
from chipbreak.editing.edits import Edit
from chipbreak.editing.notes import messages_edit, stamp_edit
from chipbreak.editing.render import render
from chipbreak.editing.restore import restore
from chipbreak.model.findings import findings
from chipbreak.model.from_source import interpret_source
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.shown_points import read_as_shown
from chipbreak.model.unread_words import UNREAD_WORD
from chipbreak.operations.kinds import KindRules
from chipbreak.operations.main_program import MainProgram, main_program
from chipbreak.operations.operations import Operation, operations_of
from chipbreak.passes import VIBRATE, Pass, passes_of
from chipbreak.passes.base import Context, Planned, RunOptions
from chipbreak.self_check import Kept, verify
from chipbreak.settings import Settings, SettingsError
from chipbreak.settings.sections import Shown
from chipbreak.syntax.comments import said_of_comments
from chipbreak.syntax.parse import UNREADABLE
from chipbreak.text.diagnostics import (
    Diagnostic,
    ProgramRejectedError,
    RefusalError,
    SelfCheckError,
    has_errors,
)
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.place_order import in_place_order
from chipbreak.text.source import Source
from chipbreak.text.utf_16 import refuse_utf_16
from chipbreak.tools.merge import ToolTable
from chipbreak.unrolling import UNROLL, Span, Unrolled, reason_of, unroll
from chipbreak.vibration.left_cut import LeftCut

if TYPE_CHECKING:
    from chipbreak.text.excerpt import Excerpt
    from chipbreak.vibration.measure import CutReport

# About how much of a run is done behind each stage [%], measured on long programs.
_INTERPRETED = 5
_UNROLLED = 15
_PLANNED = 60
_WRITTEN = 65
_LOOKED_AFTER = 99


class Result(NamedTuple):
    """What became of a program.

    ``data`` is the new program, ``beside`` the file that belongs beside it where ``output.brackets`` is none.
    ``changed`` says whether it differs from what came in.  ``reports`` are what was found when the promises
    of the edits were looked after, in the order of the program.  ``left`` are the cuts that were asked to
    vibrate and stay as they are, with the reason.  ``cycles`` are those that were written out, by their lines
    in ``source``.  ``whole`` is the program as it came in, interpreted, which no other process is sent.
    ``shown`` is what the program showed of its control.
    """

    source: Source
    data: bytes
    changed: bool
    diagnostics: tuple[Diagnostic, ...]
    reports: tuple[object, ...]
    operations: tuple[Operation, ...]
    edits: tuple[Edit, ...]
    left: tuple[LeftCut, ...] = ()
    cycles: tuple[Span, ...] = ()
    beside: bytes | None = None
    whole: Whole | None = None
    shown: Shown = Shown()

    def __reduce__(self) -> tuple[type[Result], tuple[object, ...]]:
        return Result, tuple(self._replace(whole=None))

    def __repr__(self) -> str:
        state = "changed" if self.changed else "not changed"
        counts = f"{len(self.edits)} edits, {len(self.diagnostics)} diagnostics"
        return f"<Result of {self.source.name!r}: {state}, {len(self.data)} bytes, {counts}>"

    @property
    def bracketed(self) -> bytes:
        """The new program with its comments, wherever they are kept."""
        return with_brackets(self.data, self.source.name, self.beside).data

    @property
    def cuts(self) -> tuple[CutReport, ...]:
        """The reports on vibrated cuts."""
        if not self.reports:
            return ()
        from chipbreak.vibration.measure import CutReport

        return tuple(report for report in self.reports if isinstance(report, CutReport))


def interpreted_of(result: Result, settings: Settings) -> InterpretedProgram:
    """The program of a result before its edits, under the settings of the run.

    It is read again only where the run has not kept it: cycles were written out, or it was read in parts.
    """
    settings = settings.as_shown(result.shown)
    kept = result.whole and result.whole.interpreted
    if kept and kept.program.source is result.source and kept.settings == settings:
        return kept
    return interpret_source(result.source, settings)


def rewrite(
    data: bytes,
    settings: Settings,
    name: str = "<stdin>",
    *,
    beside: bytes | None = None,
    allow_unbroken: bool = False,
    messages: bool = False,
    progress: Callable[[int], None] | None = None,
) -> Result:
    """Filter a program.

    A program that was filtered before is put back first, so a second run with the same profile changes
    nothing.  ``beside`` is the file beside such a program, where its brackets were left out of it.
    ``messages``: warnings are written into the program as comments for the operator.  ``progress`` is told
    about how much is done [%], once a stage.

    Raises ProgramRejectedError when it has an error in it, and SelfCheckError when the result does
    not do what was promised; then nothing may be written.  Raises SettingsError for a profile whose rules or
    calls cannot be used, and ToolFileError for a file of tools that cannot be read.
    """
    refuse_utf_16(data, name)
    source = restore(with_brackets(data, name, beside))
    result = _run(source, settings, None, options_of(allow_unbroken, messages, progress))
    return result._replace(changed=(result.data, result.beside) != (data, beside))


def options_of(allow_unbroken: bool, messages: bool, progress: Callable[[int], None] | None) -> RunOptions:
    """The options of a run; ``progress`` is None where nobody waits."""
    options = RunOptions(allow_unbroken, messages)
    return options if progress is None else options._replace(progress=progress)


def verify_filtered(
    data: bytes, settings: Settings, name: str = "<stdin>", *, beside: bytes | None = None
) -> Result:
    """Judge a filtered program as it stands, instead of writing a new one.

    Raises what :func:`rewrite` raises; SelfCheckError also for a program that another profile or version has
    written, whose changes are not those that would be made now.
    """
    refuse_utf_16(data, name)
    written = with_brackets(data, name, beside)
    source = restore(written)
    try:
        return _run(source, settings, written.data, RunOptions(allow_unbroken=True))
    except SelfCheckError:
        # Cuts that did not break their chips may have been left as they were, and cycles that were written
        # out for cuts of which none vibrates.
        tried = (_filtered_again(source, written.data, settings, allow) for allow in (False, True))
        again = next(filter(None, tried), None)
        if again is None:
            raise
        return again


def _filtered_again(source: Source, output: bytes, settings: Settings, allow_unbroken: bool) -> Result | None:
    """The result of filtering anew, where that gives the very bytes of ``output``."""
    try:
        again = _run(source, settings, None, RunOptions(allow_unbroken))
    except (ProgramRejectedError, SelfCheckError):
        return None
    return again._replace(changed=False) if again.bracketed == output else None


def _run(source: Source, settings: Settings, output: bytes | None, options: RunOptions) -> Result:
    """All stages on an unfiltered source; ``output`` is the program to judge, None to write one."""
    return run_stages(Whole.of(interpret_source(source, settings)), output, options)


def run_stages(whole: Whole, output: bytes | None, options: RunOptions) -> Result:
    """All stages behind the first; ``output`` is the program to judge, None to write one."""
    settings = whole.interpreted.settings
    options.progress(_INTERPRETED)
    passes = passes_of(settings)
    idle: dict[int, RefusalError] = {}
    idle_runs: dict[int, RefusalError] = {}
    tools = cache(partial(_tools_of_program, whole.interpreted))
    while True:
        unrolled = unroll(whole.interpreted, whole.main, whole.operations, idle)
        unrolled = offset_noses(unrolled, tools, idle_runs)
        _reject_wrong(unrolled.diagnostics)
        options.progress(_UNROLLED)
        context = _context(whole, unrolled, options)
        context, tried = _settled(context, passes, output)
        # What is written out to vibrate and does not, stays.  Each round leaves one more of it.
        vibrated = [edit for edit in tried.edits if edit.pass_name == VIBRATE]
        runs = unrolled.idle_runs(vibrated)
        groups = set() if settings.cycles.unroll == "always" else unrolled.idle(vibrated)
        if not (groups or runs):
            break
        idle |= {group: reason_of(tried.left, unrolled.spans, group) for group in groups}
        idle_runs |= {run: reason_of(tried.left, unrolled.runs, run) for run in runs}
    _reject_wrong(_comments_around_cycles(whole, unrolled))
    diagnostics = [*unrolled.diagnostics, *tried.diagnostics]
    for one in passes:
        diagnostics += one.findings(context, _reports_of(tried.kept, one))
    _reject_wrong(diagnostics)
    if options.messages:
        tried = _with_messages(context, tried, diagnostics)
    new = _as_kept(tried.output, whole.interpreted.program.source.name, settings)
    return Result(
        source=context.interpreted.program.source,
        data=new.data,
        changed=False,  # than what, knows who called
        diagnostics=_ordered(diagnostics),
        reports=tuple(one.report for one in tried.kept),
        operations=tuple(context.operations),
        edits=tuple(tried.edits),
        left=(*unrolled.left, *tried.left),
        cycles=tuple(unrolled.spans),
        beside=new.beside,
        whole=whole,
        shown=settings.shown,
    )


def _comments_around_cycles(whole: Whole, unrolled: Unrolled) -> list[Diagnostic]:
    """What is said of comments for the sake of the cycles that were written out."""
    lines = [(edit.first, edit.last) for edit in unrolled.edits if edit.pass_name == UNROLL]
    return said_of_comments(whole.interpreted.program, lines) if lines else []


def _as_kept(output: bytes, name: str, settings: Settings) -> Parted:
    """The new program, with its brackets in it or in a file beside it."""
    return parted(output, name) if settings.output.brackets == "none" else Parted(output, None)


def _settled(context: Context, passes: Sequence[Pass], output: bytes | None) -> tuple[Context, _Tried]:
    """Plan until no pass gives up what it planned."""
    while True:
        tried = _tried(context, passes, output)
        given_up = _given_up(context, passes, tried.kept)
        if not given_up:
            return context, tried
        # Each round gives up one edit more, so there is a last one.
        context = replace(context, given_up=FrozenTable({**context.given_up, **given_up}))


class Whole(NamedTuple):
    """A program as it came in, with its operations; or an ``excerpt`` of it, with all that decides."""

    interpreted: InterpretedProgram
    main: MainProgram
    operations: Sequence[Operation]
    excerpt: Excerpt | None = None

    @classmethod
    def of(cls, interpreted: InterpretedProgram) -> Whole:
        """Raises SettingsError for unusable rules of operations."""
        settings = interpreted.settings
        main = main_program(interpreted)
        try:
            operations = operations_of(interpreted, main, KindRules.from_profile(settings.operations))
        except RefusalError as error:
            raise SettingsError.of(error, settings.name) from None
        return cls(interpreted, main, operations)


class _Tried(NamedTuple):
    """What one round of planning has led to."""

    edits: list[Edit]
    diagnostics: list[Diagnostic]
    left: list[LeftCut]
    output: bytes
    kept: list[Kept]


def _tried(context: Context, passes: Sequence[Pass], output: bytes | None) -> _Tried:
    """Plan, write (or take the ``output`` there is) and look after every promise."""
    interpreted = context.interpreted
    diagnostics = [*context.said, *findings(interpreted, context.named_cycles)]
    planned = _planned(passes, replace(context, said=diagnostics))
    context.options.progress(_PLANNED)
    diagnostics += [diagnostic for one in planned for diagnostic in one.diagnostics]
    # Of two insertions before one line, what was planned later stands first.
    edits = [edit for one in reversed(planned) for edit in one.edits]
    diagnostics += said_of_comments(interpreted.program, [(edit.first, edit.last) for edit in edits])
    _reject_wrong(diagnostics)
    if edits and context.settings.output.stamp:
        edits.append(stamp_edit(interpreted.program, context.settings))
    source = interpreted.program.source
    if output is None:
        output = b"".join(render(interpreted.program, edits, context.settings)) if edits else source.data
    context.options.progress(_WRITTEN)
    kept = verify(interpreted, output, edits) if edits or output != source.data else []
    context.options.progress(_LOOKED_AFTER)
    return _Tried(edits, diagnostics, [cut for one in planned for cut in one.left], output, kept)


def _with_messages(context: Context, tried: _Tried, diagnostics: Sequence[Diagnostic]) -> _Tried:
    """The same with the warnings in the program; looked after once more."""
    program = context.interpreted.program
    edit = messages_edit(program, context.settings, _ordered(diagnostics))
    if edit is None:
        return tried
    edits = [edit, *tried.edits]
    output = b"".join(render(program, edits, context.settings))
    return tried._replace(edits=edits, output=output, kept=verify(context.interpreted, output, edits))


def _given_up(context: Context, passes: Iterable[Pass], kept: Sequence[Kept]) -> dict[int, Diagnostic]:
    """What the passes give up now that they see the output, and had not before."""
    found: dict[int, Diagnostic] = {}
    for one in passes:
        found |= one.gives_up(context, _reports_of(kept, one))
    return {line: why for line, why in found.items() if line not in context.given_up}


def _context(whole: Whole, unrolled: Unrolled, options: RunOptions) -> Context:
    """What the passes may look at."""
    tools = cache(partial(_tools_for_checks, whole.interpreted))
    return Context(
        unrolled.interpreted,
        unrolled.main,
        unrolled.operations,
        tools,
        options,
        split_operations=unrolled.cut_operations,
        named_cycles=unrolled.named,
        reasons=unrolled.reasons,
        said=read_as_shown(whole.interpreted.program, whole.interpreted.settings),
    )


def _tools_for_checks(interpreted: InterpretedProgram) -> ToolTable:
    """What is known about the tools, where checks will ask for it or files were given that must be right.

    Raises ToolFileError.
    """
    settings = interpreted.settings
    if not (settings.checks.enabled or settings.tools.files):
        return ToolTable({}, ())
    return _tools_of_program(interpreted)


def _tools_of_program(interpreted: InterpretedProgram) -> ToolTable:
    """What is known about the tools.  Raises ToolFileError."""
    from chipbreak.tools.program import tool_table

    return tool_table(interpreted)


def _planned(passes: Iterable[Pass], context: Context) -> list[Planned]:
    """What each pass plans; each sees in its context what the ones before it have planned."""
    planned: list[Planned] = []
    for one in passes:
        edits, diagnostics, left = one.plan(context)
        named = [edit._replace(pass_name=one.name) for edit in edits]
        context = replace(context, planned=(*context.planned, *named), said=(*context.said, *diagnostics))
        planned.append(Planned(named, diagnostics, left))
    return planned


def _reports_of(kept: Sequence[Kept], one: Pass) -> list[object]:
    return [each.report for each in kept if each.edit.pass_name == one.name]


def _reject_wrong(diagnostics: Sequence[Diagnostic]) -> None:
    if has_errors(diagnostics):
        raise ProgramRejectedError(_ordered(diagnostics))


def _ordered(diagnostics: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    return in_place_order(diagnostics, covers_line=UNREADABLE, covers_word=UNREAD_WORD)
