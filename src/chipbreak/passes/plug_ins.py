"""Passes of other installed packages: they run behind ours, in the order of their names.

What such a pass does wrong is said with its name.  It can do nothing that another pass cannot: its edits are
applied, and their promises looked after, as those of all others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from chipbreak.editing.edits import Edit, MoveTable
from chipbreak.editing.promise import Promise
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.settings.plug_ins import offered
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import ChipbreakError, Diagnostic, RefusalError, SelfCheckError, Severity


def plug_ins_of(settings: Settings) -> list[Pass]:
    """The passes that a profile names in ``passes.extra``.

    Raises SelfCheckError for one that does not load.
    """
    names = sorted(set(settings.passes.extra))
    if not names:
        return []
    known = offered()
    found: list[Pass] = []
    for name in names:
        said = f"plug-in {name}"  # so that none can be taken for one of ours
        with _blamed(said):
            (entry,) = known[name]
            found.append(PlugIn(said, entry.load()()))
    return found


class PlugIn(Pass):
    """A pass that another package has written."""

    def __init__(self, name: str, inner: Pass) -> None:
        self.name = name
        self.inner = inner

    def plan(self, context: Context) -> Planned:
        """What the pass plans, when it can be used; a refusal is an error without a place."""
        with _blamed(self.name):
            try:
                edits, diagnostics, left = Planned(*self.inner.plan(context))
            except RefusalError as error:
                return Planned((), [_without_place(error)])
            planned = Planned(list(edits), _all_diagnostics(diagnostics), list(left))
            for edit in planned.edits:
                _check_edit(edit, context.interpreted.program.source.line_count)
        return planned

    def findings(self, context: Context, reports: Sequence[object]) -> Sequence[Diagnostic]:
        """What the pass says of its reports."""
        with _blamed(self.name):
            try:
                return _all_diagnostics(self.inner.findings(context, reports))
            except RefusalError as error:
                return [_without_place(error)]

    def gives_up(self, context: Context, reports: Sequence[object]) -> Mapping[int, Diagnostic]:
        """What the pass does not want to keep of what it planned."""
        with _blamed(self.name):
            return dict(self.inner.gives_up(context, reports))


@contextmanager
def _blamed(name: str) -> Iterator[None]:
    """Whatever goes wrong inside is the fault of the plug-in, and is said so."""
    try:
        yield
    except (ChipbreakError, MemoryError):
        raise
    except (Exception, SystemExit) as error:
        raise SelfCheckError(f"{name} failed: {type(error).__name__}: {error}") from error


def _without_place(error: RefusalError) -> Diagnostic:
    return Diagnostic(error.code, Severity.ERROR, error.message, error.help)


def _all_diagnostics(found: Sequence[Diagnostic]) -> list[Diagnostic]:
    for one in found:
        if not isinstance(one, Diagnostic):
            raise TypeError(f"{one!r} is no Diagnostic")
    return list(found)


def _check_edit(edit: Edit, line_count: int) -> None:
    """An edit that can be applied: lines of the program, blocks of one line each, and a promise."""
    if not isinstance(edit, Edit):
        raise TypeError(f"{edit!r} is no Edit")
    if not isinstance(edit.promise, Promise):
        raise TypeError(f"the promise of {edit.title!r} is no Promise")
    if not 0 <= edit.first <= edit.last <= line_count:
        raise ValueError(f"{edit.title!r} changes lines that are not there: {edit.first} to {edit.last}")
    for block in edit.content:
        if not isinstance(block, MoveTable):
            _check_block(block)


def _check_block(block: str) -> None:
    if "\n" in block or "\r" in block:
        raise ValueError(f"{block!r} is more than one line")
    block.encode("latin-1")
