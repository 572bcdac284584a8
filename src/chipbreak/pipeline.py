"""The whole way of a program, once, in order: read, put back, interpret, plan, apply, verify."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, NamedTuple

from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.editing.restore import restore
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.unread_words import UNREAD_WORD, unread_words
from chipbreak.operations.kinds import KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import Operation, operations_of
from chipbreak.passes import Pass, passes_of
from chipbreak.passes.base import Context, Planned, RunOptions
from chipbreak.self_check import Kept, verify
from chipbreak.settings import Settings, SettingsError
from chipbreak.syntax.parse import UNREADABLE, parse
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, RefusalError, has_errors
from chipbreak.text.place_order import in_place_order
from chipbreak.text.source import Source, read
from chipbreak.tools.merge import ToolTable

if TYPE_CHECKING:
    from chipbreak.vibration.measure import CutReport


class Result(NamedTuple):
    """What became of a program.

    ``data`` is the new program.  ``changed`` says whether it differs from what came in.  ``reports`` are what
    was found when the promises of the edits were looked after, in the order of the program.
    """

    source: Source
    data: bytes
    changed: bool
    diagnostics: tuple[Diagnostic, ...]
    reports: tuple[object, ...]
    operations: tuple[Operation, ...]
    edits: tuple[Edit, ...]

    def __repr__(self) -> str:
        state = "changed" if self.changed else "not changed"
        counts = f"{len(self.edits)} edits, {len(self.diagnostics)} diagnostics"
        return f"<Result of {self.source.name!r}: {state}, {len(self.data)} bytes, {counts}>"

    @property
    def cuts(self) -> tuple[CutReport, ...]:
        """The reports on vibrated cuts."""
        if not self.reports:
            return ()
        from chipbreak.vibration.measure import CutReport

        return tuple(report for report in self.reports if isinstance(report, CutReport))


def rewrite(
    data: bytes, settings: Settings, name: str = "<stdin>", *, allow_unbroken: bool = False
) -> Result:
    """Filter a program.

    A program that was filtered before is put back first, so a second run with the same profile changes
    nothing.  Raises ProgramRejectedError when it has an error in it, and SelfCheckError when the result does
    not do what was promised; then nothing may be written.  Raises SettingsError for a profile whose rules or
    calls cannot be used, and ToolFileError for a file of tools that cannot be read.
    """
    source = restore(read(data, name))
    return _run(source, data, settings, None, RunOptions(allow_unbroken))


def verify_filtered(data: bytes, settings: Settings, name: str = "<stdin>") -> Result:
    """Judge a filtered program as it stands, instead of writing a new one.

    Raises what :func:`rewrite` raises; SelfCheckError also for a program that another profile or version has
    written, whose changes are not those that would be made now.
    """
    source = restore(read(data, name))
    return _run(source, data, settings, data, RunOptions(allow_unbroken=True))


def _run(
    source: Source, data: bytes, settings: Settings, output: bytes | None, options: RunOptions
) -> Result:
    """All stages on an unfiltered source; ``output`` is the program to judge, None to write one."""
    interpreted = interpret(parse(source, settings.dialect), settings)
    diagnostics = interpreted.program.unreadable() + unread_words(interpreted)
    context = _context(interpreted, options)
    passes = passes_of(settings)
    planned = _planned(passes, context)
    diagnostics += [diagnostic for one in planned for diagnostic in one.diagnostics]
    _reject_wrong(diagnostics)
    # Of two insertions before one line, what was planned later stands first.
    edits = [edit for one in reversed(planned) for edit in one.edits]
    if output is None:
        output = b"".join(render(interpreted.program, edits, settings)) if edits else source.data
    kept = verify(interpreted, output, edits) if edits or output != source.data else []
    for one in passes:
        diagnostics += one.findings(context, _reports_of(kept, one))
    _reject_wrong(diagnostics)
    return Result(
        source=source,
        data=output,
        changed=output != data,
        diagnostics=_ordered(diagnostics),
        reports=tuple(one.report for one in kept),
        operations=tuple(context.operations),
        edits=tuple(edits),
    )


def _context(interpreted: InterpretedProgram, options: RunOptions) -> Context:
    """What the passes may look at.  Raises SettingsError for unusable rules of operations."""
    settings = interpreted.settings
    main = main_program(interpreted)
    try:
        operations = operations_of(interpreted, main, KindRules.from_profile(settings.operations))
    except RefusalError as error:
        raise SettingsError.of(error, settings.name) from None
    tools = cache(partial(_tools_for_checks, interpreted))
    return Context(interpreted, main, operations, tools, options)


def _tools_for_checks(interpreted: InterpretedProgram) -> ToolTable:
    """What is known about the tools, where checks will ask for it or files were given that must be right.

    Raises ToolFileError.
    """
    settings = interpreted.settings
    if not (settings.checks.enabled or settings.tools.files):
        return ToolTable({}, ())
    from chipbreak.tools.program import tool_table

    return tool_table(interpreted)


def _planned(passes: Iterable[Pass], context: Context) -> list[Planned]:
    """What each pass plans; each sees in its context what the ones before it have planned."""
    planned: list[Planned] = []
    for one in passes:
        edits, diagnostics = one.plan(context)
        named = [edit._replace(pass_name=one.name) for edit in edits]
        context = replace(context, planned=(*context.planned, *named))
        planned.append(Planned(named, diagnostics))
    return planned


def _reports_of(kept: Sequence[Kept], one: Pass) -> list[object]:
    return [each.report for each in kept if each.edit.pass_name == one.name]


def _reject_wrong(diagnostics: Sequence[Diagnostic]) -> None:
    if has_errors(diagnostics):
        raise ProgramRejectedError(_ordered(diagnostics))


def _ordered(diagnostics: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    return in_place_order(diagnostics, covers_line=UNREADABLE, covers_word=UNREAD_WORD)
