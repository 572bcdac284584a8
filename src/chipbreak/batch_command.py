"""The command for many programs."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from chipbreak.batch.inputs import Input, inputs_of
from chipbreak.options import FAILED, LOG, READING, USAGE, Asked, asking, settings_for
from chipbreak.program_files import read_program, write_or_note
from chipbreak.streams import say, write_json
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_there
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.batch.work import Finished, Task
    from chipbreak.settings import Settings

_T = TypeVar("_T")


@click.command()
@click.argument("sources", metavar="INPUT...", nargs=-1, required=True, type=click.Path())
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    required=True,
    type=click.Path(),
    help="Write the programs into this folder.",
)
@click.option(
    "-j",
    "--jobs",
    type=click.IntRange(1),
    default=None,
    metavar="N",
    help="Processes that filter at a time; as many as there are cores.",
)
@click.option(
    "--dask",
    metavar="ADDRESS",
    help="Filter on this Dask cluster; 'local' starts one of --jobs processes.",
)
@asking(*READING, LOG)
def batch(asked: Asked, sources: tuple[str, ...], output: str, jobs: int | None, dask: str | None) -> None:
    """Filter many programs and folders of programs into a folder.

    Below DIR stands what stood below a folder; DIR itself may be in there, and is no input then.  Each
    program is what a run of its own would give; one that is rejected leaves no program but a file
    NAME.rejected that says why.  Exit with the worst of all exit codes.
    """
    with asked.reporter.logging("batch", sources):
        inputs = inputs_of(sources, Path(output))
        if not inputs:
            raise click.UsageError(
                "no programs in there: name files, or folders with files such as .nc or O1234"
            )
        targets = _targets(inputs, Path(output))
        results = _filtered(inputs, targets, asked, _Workers(jobs or os.cpu_count() or 1, dask))
        _tell(results, asked)
    sys.exit(max(one.code for one in results))


class _Workers(NamedTuple):
    """How many processes, or which Dask cluster."""

    jobs: int
    dask: str | None


def _filtered(
    inputs: Sequence[Input], targets: Sequence[Path], asked: Asked, workers: _Workers
) -> list[Finished]:
    """Filter all and write each as it comes; what became of them, in their order."""
    unread: list[Finished] = []
    results: list[Finished] = []
    for finished in _progress(_run(_tasks(inputs, asked, unread), workers, asked), len(inputs), asked):
        results.append(_written(finished, targets[finished.number]))
    results += [_written(finished, targets[finished.number]) for finished in unread]
    return sorted(results, key=lambda one: one.number)


def _written(finished: Finished, target: Path) -> Finished:
    """A result that is on the disk, or says that it is not: the others go on."""
    from chipbreak.batch.table import NOT_WRITTEN
    from chipbreak.text.diagnostics import Diagnostic, Severity

    try:
        write_or_note(target, finished)
    except click.UsageError as error:
        said = Diagnostic(NOT_WRITTEN, Severity.ERROR, error.message)
        code = max(finished.code, USAGE)
        finished = finished._replace(code=code, diagnostics=(said, *finished.diagnostics), report=None)
    return finished._replace(data=None, beside=None)


def _targets(inputs: Sequence[Input], folder: Path) -> list[Path]:
    """Where each program goes; no two to one place, none onto itself.  Raises click.UsageError."""
    targets = [folder / one.name for one in inputs]
    sources: dict[Path, Path] = {}
    for one, target in zip(inputs, targets, strict=True):
        other = sources.setdefault(target, one.path)
        if other != one.path:
            raise click.UsageError(escaped(f"{other} and {one.path} would both become {target}"))
        if is_there(target) and target.samefile(one.path):
            raise click.UsageError(escaped(f"{target} would replace itself: name another folder with -o"))
    return targets


def _tasks(inputs: Sequence[Input], asked: Asked, unread: list[Finished]) -> Iterator[Task]:
    """The programs, each read when its turn comes; those that cannot be read go to ``unread``."""
    from chipbreak.batch.work import Finished, Task
    from chipbreak.settings import SettingsError
    from chipbreak.text.diagnostics import Diagnostic, Severity

    known: dict[Path, Settings] = {}
    for number, one in enumerate(inputs):
        name = str(one.path)
        try:
            if one.path.parent not in known:
                known[one.path.parent] = settings_for(asked, name)
            program = read_program(name)
        except SettingsError as error:
            unread.append(Finished(number, name, USAGE, (error.diagnostic,)))
        except click.UsageError as error:
            said = Diagnostic("BAT003", Severity.ERROR, error.message)
            unread.append(Finished(number, name, USAGE, (said,)))
        else:
            settings = known[one.path.parent]
            yield Task(number, name, program.data, settings, asked.allow_unbroken, program.beside)


def _run(tasks: Iterable[Task], workers: _Workers, asked: Asked) -> Iterator[Finished]:
    from chipbreak.batch.processes import by_processes
    from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity

    if workers.dask is None:
        yield from by_processes(tasks, workers.jobs)
        return
    from chipbreak.batch.dask_cluster import by_dask

    try:
        yield from by_dask(tasks, workers.dask, workers.jobs)
    except RefusalError as error:
        asked.reporter.show([Diagnostic(error.code, Severity.ERROR, error.message, error.help)])
        sys.exit(USAGE)


def _progress(results: Iterator[_T], count: int, asked: Asked) -> Iterator[_T]:
    """The results, with a bar on a terminal while they come."""
    if asked.quiet or not sys.stderr.isatty():
        yield from results
        return
    with click.progressbar(results, length=count, label="filtering", file=sys.stderr) as bar:
        yield from bar


def _tell(results: Sequence[Finished], asked: Asked) -> None:
    from chipbreak.batch.table import as_dicts, table_lines, total

    if asked.as_json:
        write_json({"programs": as_dicts(results), "summary": total(results)}, indent=2)
        return
    for one in results:
        if one.code == FAILED:
            asked.reporter.tell(
                "\n".join(f"{escaped(one.name)}: {said.render()}" for said in one.diagnostics)
            )
        else:
            asked.reporter.show(one.diagnostics)
    if not asked.quiet:
        for line in table_lines(results):
            say(line)
