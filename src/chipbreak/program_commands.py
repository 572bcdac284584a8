"""Commands about programs: filter, check, explain, verify and compare them, put them back; and macros.

Everything heavy is imported inside the commands, so that help and completion answer at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING

import click

from chipbreak.options import (
    BESIDE,
    DIFFERENT,
    DONE,
    LOG,
    MESSAGES,
    PROFILE,
    READING,
    REJECTED,
    REPORTING,
    SET,
    USAGE,
    Asked,
    Outcome,
    asking,
    rewrite_long_program,
    rewrite_program,
    run_filter,
    settings_of,
    settings_of_filtered,
    verify_program,
    where_found,
)
from chipbreak.program_files import (
    LONG_BYTES,
    ProgramFile,
    has_beside,
    read_program,
    replace_program,
    write_program,
)
from chipbreak.streams import (
    keep_file,
    note_rejection,
    open_long,
    replace_file,
    replace_files,
    say,
    write_json,
    write_lines,
    write_stdout,
)
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_file, is_folder, is_there
from chipbreak.text.long_file import LongFile
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.pipeline import Result
    from chipbreak.settings import Settings


@click.command("filter")
@click.argument("sources", metavar="[INPUT]...", nargs=-1, type=click.Path(allow_dash=True))
@click.option(
    "-o",
    "--output",
    metavar="OUT",
    type=click.Path(allow_dash=True),
    help="Write to this file, replaced in one step.",
)
@click.option(
    "-i",
    "--in-place",
    is_flag=True,
    help="Replace the input files, and the programs in folders, each in one step.",
)
@click.option("--backup", metavar="SUFFIX", help="With -i: keep the original under its name plus this.")
@click.option("--check", is_flag=True, help="Write nothing; exit 1 if anything would change.")
@click.option(
    "--fresh",
    is_flag=True,
    help="INPUT is new from a CAM system: NAME.chipbreak of a program that stood there before is old.",
)
@click.option(
    "--reject-file", is_flag=True, help="With -o or -i: where a program is rejected, say why in OUT.rejected."
)
@asking(*READING, BESIDE, LOG, MESSAGES)
def filter_command(
    asked: Asked,
    sources: tuple[str, ...],
    output: str | None,
    in_place: bool,
    backup: str | None,
    check: bool,
    fresh: bool,
    reject_file: bool,
) -> None:
    """Filter programs: from stdin or INPUT to stdout, OUT or INPUT itself.

    Several inputs, or a folder, go with -i; "chipbreak batch" writes them into another folder.
    """
    if in_place and (not sources or "-" in sources or output):
        raise click.UsageError("-i replaces INPUT itself: name a file, and leave -o out")
    if backup is not None and (not in_place or not backup or PurePath(f"a{backup}").name != f"a{backup}"):
        raise click.UsageError("--backup goes with -i and takes a suffix such as .bak")
    if reject_file and not in_place and output in (None, "-"):
        raise click.UsageError("--reject-file goes with -o or -i: the file stands beside the program")
    names = _names(sources or ("-",), many=in_place or check)
    if asked.beside is not None and len(names) != 1:
        raise click.UsageError("--beside is about one program; without it each has its own NAME.chipbreak")
    run = _Filter(asked, output, backup, in_place, check, reject_file, fresh)
    with asked.reporter.logging("filter", names):
        sys.exit(max([_filter_one(run, name) for name in names]))


class _Filter(NamedTuple):
    """What the options of ``filter`` ask for."""

    asked: Asked
    output: str | None
    backup: str | None
    in_place: bool
    check: bool
    reject_file: bool
    fresh: bool


def _names(sources: tuple[str, ...], *, many: bool) -> list[str]:
    """The inputs; folders stand for the programs in them.  Raises click.UsageError."""
    if len(sources) == 1 and not is_folder(sources[0]):
        return list(sources)
    if not many:
        raise click.UsageError(
            "one INPUT only: several, or a folder, go with -i, with --check, or to chipbreak batch"
        )
    from chipbreak.batch.inputs import inputs_of

    names = [str(one.path) for one in inputs_of(sources)]
    if not names:
        raise click.UsageError("no programs in there: name files, or folders with files such as .nc or O1234")
    return names


def _filter_one(run: _Filter, source: str) -> int:
    """Filter one program; the exit code it leads to.  What is no fault of the program ends the command."""
    asked = run.asked
    if run.in_place and is_there(source) and not is_file(source):
        raise click.UsageError(f"-i replaces INPUT itself, and {source} is no file")
    opened = None if _is_read_whole(run, source) else open_long(source, LONG_BYTES)
    if not isinstance(opened, LongFile):
        return _filter_whole(run, source, opened, None)
    with opened.file:
        settings = settings_of(asked, source)
        outcome = rewrite_long_program(opened, settings, source, asked)
        if outcome is None:
            data = b"".join(opened.blocks(0, opened.size)) if source == "-" else None
            return _filter_whole(run, source, data, settings)
        return _finish(run, source, settings, outcome, partial(_write_long, run, source, opened))


def _is_read_whole(run: _Filter, source: str) -> bool:
    """True where more than the program is read or written: files beside it, and backups."""
    target = source if run.in_place else run.output
    more = run.asked.beside is not None or run.backup is not None
    # Windows puts nothing in the place of a file that is open.
    is_held = os.name == "nt" and target is not None and os.path.realpath(target) == os.path.realpath(source)
    return more or is_held or has_beside(source) or has_beside(target)


def _filter_whole(run: _Filter, source: str, data: bytes | None, settings: Settings | None) -> int:
    """Filter one program that is read whole; ``data`` is its bytes where they are known."""
    program = _program_to_filter(run, source, data)
    settings = settings_of(run.asked, source) if settings is None else settings
    outcome = rewrite_program(program, settings, source, run.asked)
    return _finish(run, source, settings, outcome, partial(_write, run, source, program))


def _finish(
    run: _Filter, source: str, settings: Settings, outcome: Outcome, write: Callable[[Result], None]
) -> int:
    """Say what was found, and write what came out; the exit code."""
    asked = run.asked
    asked.reporter.show(outcome.diagnostics)
    target = source if run.in_place else run.output
    if run.reject_file and target is not None and not run.check:
        note_rejection(Path(target), outcome.diagnostics if outcome.result is None else None)
    result = outcome.result
    if result is None:
        return outcome.code
    if not run.check:
        write(result)
    if run.check or target not in (None, "-"):
        _print_summary(result, settings, asked)
    return DIFFERENT if run.check and result.changed else DONE


def _program_to_filter(run: _Filter, source: str, data: bytes | None) -> ProgramFile:
    """What is to be filtered; the file of --beside is the input's where that has none of its own."""
    program = read_program(source, run.asked.beside if run.in_place or source == "-" else None, data)
    if not run.fresh or program.beside is None:
        return program
    from chipbreak.editing.beside import fits

    return program if fits(program.data, source, program.beside) else program._replace(beside=None)


def _write(run: _Filter, source: str, program: ProgramFile, result: Result) -> None:
    """The program to where it is asked for; one filtered in place that would not change is left alone."""
    new = ProgramFile(result.data, result.beside)
    if not run.in_place:
        write_program(run.output, new, run.asked.beside)
    elif result.changed:
        if run.backup is not None:
            _keep(source, program, run.backup, run.asked)
        replace_program(Path(source), new, beside=run.asked.beside, instead_of=program.data)


def _write_long(run: _Filter, source: str, program: LongFile, result: Result) -> None:
    """The same of a long program, a piece at a time."""
    from chipbreak.long_programs import pieces_of

    target = source if run.in_place else run.output
    if target in (None, "-"):
        write_stdout(pieces_of(result))
    elif result.changed or not run.in_place:
        replace_file(Path(str(target)), pieces_of(result), read_from=program)


def _keep(source: str, program: ProgramFile, suffix: str, asked: Asked) -> None:
    """The backup of a program; says its name where that is not the one that was asked for."""
    kept = keep_file(Path(source), program.data, suffix)
    if program.beside is not None:
        replace_program(kept, program)
    if kept.name != Path(source).name + suffix and not asked.quiet and not asked.as_json:
        asked.reporter.tell(escaped(f"{source}: an older backup is there; the original is kept as {kept}"))


@click.command()
@click.argument("sources", metavar="INPUT...", nargs=-1, required=True, type=click.Path(allow_dash=True))
@asking(*READING)
def check(asked: Asked, sources: tuple[str, ...]) -> None:
    """Say everything that is wrong with programs, and with those in folders; write none."""
    from chipbreak.text.diagnostics import has_errors

    failed = False
    for source in _names(sources, many=True):
        program = read_program(source)
        settings = settings_of(asked, source)
        diagnostics = rewrite_program(program, settings, source, asked).diagnostics
        failed |= has_errors(diagnostics)
        asked.reporter.show(diagnostics)
    sys.exit(DIFFERENT if failed else DONE)


@click.command()
@click.argument("source", metavar="[INPUT]", default="-", type=click.Path(allow_dash=True))
@asking(*READING, BESIDE)
def explain(asked: Asked, source: str) -> None:
    """Show each vibrated cut, operation and check, with its reasons."""
    settings = settings_of(asked, source)
    _print_report(run_filter(read_program(source, asked.beside), settings, source, asked), settings, asked)


def _print_summary(result: Result, settings: Settings, asked: Asked) -> None:
    """One line to stderr; none where only errors, or only JSON, may stand there."""
    if asked.quiet or asked.as_json:
        return
    from chipbreak.report.build import report_of

    source = result.source.name
    beside = f"; profile {settings.name}, {where_found(source)}" if asked.profile is None else ""
    report = report_of(result, settings)
    how = "" if result.changed or report.cuts or report.left or report.checks else _HOW_TO_ASK
    asked.reporter.tell(escaped(f"{source}: {report.summary()}{how}{beside}"))


_HOW_TO_ASK = " (N1.5 in a cutting block would, or (VIB N1.5) before the cuts)"


def _print_report(result: Result, settings: Settings, asked: Asked) -> None:
    """The report of a run to stdout; as text, its diagnostics to stderr."""
    from chipbreak.report.build import report_of

    report = report_of(result, settings)
    if asked.as_json:
        write_json(report.as_dict(), indent=2)
        return
    asked.reporter.show(result.diagnostics)
    for line in report.lines():
        say(line)


@click.command()
@click.argument("source", metavar="[INPUT]", default="-", type=click.Path(allow_dash=True))
@asking(*READING, BESIDE)
def verify(asked: Asked, source: str) -> None:
    """Judge a filtered program as it stands: end points, times, states and chips.

    Exit 0: it does what was promised; 1: a cut does not break its chips; 3 or 4: it is not as it was
    written.
    """
    from chipbreak.text.diagnostics import has_errors

    program = read_program(source, asked.beside)
    settings = settings_of_filtered(asked, source, program)
    result = verify_program(program, settings, source, asked)
    _print_report(result, settings, asked)
    broken = not asked.allow_unbroken and any(not cut.verdict.breaks for cut in result.cuts)
    sys.exit(DIFFERENT if broken or has_errors(result.diagnostics) else DONE)


@click.command()
@click.argument("a", type=click.Path(allow_dash=True))
@click.argument("b", type=click.Path(allow_dash=True))
@click.option("--ignore-comments", is_flag=True, help="Comments do not count.")
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0),
    default=0.0,
    metavar="LENGTH",
    help="Lengths and angles that differ by no more are the same; feeds and times always count.",
)
@click.option("-y", "--side-by-side", is_flag=True, help="Both programs beside each other.")
@click.option("--html", "as_html", is_flag=True, help="One HTML page that needs nothing else.")
@asking(PROFILE, SET, *REPORTING)
def diff(
    asked: Asked, a: str, b: str, ignore_comments: bool, tolerance: float, side_by_side: bool, as_html: bool
) -> None:
    """Compare two programs by what their blocks say.

    Block numbers, spacing and number format do not count; a number that names a block (GOTO, M97 P, M98 P,
    M99 P, P and Q of a cycle) counts by the block it names, and where a program works such a number out
    (GOTO #1), all block numbers count; a part that chipbreak wrote is one line.  With a profile, numbers are
    read as its control reads them; without one, X50 and X50. are different.  Exit 0: the same, 1: different,
    2: trouble.
    """
    import shutil

    from chipbreak.editing import diff_output
    from chipbreak.editing.diff import compare, differs, items_of
    from chipbreak.text.diagnostics import ProgramRejectedError

    if sum((side_by_side, as_html, asked.as_json)) > 1:
        raise click.UsageError("give one of --side-by-side, --html and --json")
    settings = settings_of(asked, a) if asked.profile or asked.sets else None
    try:
        sides = [
            items_of(one.data, name, settings, beside=one.beside, ignore_comments=ignore_comments)
            for name, one in ((name, read_program(name)) for name in (a, b))
        ]
    except ProgramRejectedError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(USAGE)
    hunks = compare(*sides, tolerance=tolerance)
    if asked.as_json:
        write_json(diff_output.as_json(hunks), indent=2)
    elif as_html:
        write_stdout([diff_output.page(hunks, a, b).encode("utf-8", "replace")])
    else:
        width = shutil.get_terminal_size((130, 24)).columns
        shown = (
            diff_output.side_by_side(hunks, a, b, width) if side_by_side else diff_output.unified(hunks, a, b)
        )
        write_lines(map(_coloured, shown) if asked.colours(sys.stdout) else shown)
    sys.exit(DIFFERENT if differs(hunks) else DONE)


def _coloured(line: str) -> str:
    """A line of a patch in the colours that people know; other lines as they are."""
    colours = {"-": "red", "+": "green", "@": "cyan"}
    return click.style(line, fg=colours[line[0]]) if line[:1] in colours else line


@click.command()
@click.argument("source", metavar="[INPUT]", default="-", type=click.Path(allow_dash=True))
@click.option("-o", "--output", metavar="OUT", help="Write to this file, replaced in one step.")
@asking(BESIDE, *REPORTING)
def restore(asked: Asked, source: str, output: str | None) -> None:
    """Give the original bytes back from a filtered program."""
    from chipbreak.api import restore as put_back
    from chipbreak.text.diagnostics import ProgramRejectedError

    program = read_program(source, asked.beside)
    try:
        original = put_back(program.data, source, beside=program.beside)
    except ProgramRejectedError as error:
        asked.reporter.show(error.diagnostics)
        sys.exit(REJECTED)
    write_program(output, ProgramFile(original))


@click.command()
@click.option("-o", "--output", metavar="DIR", required=True, help="Write the programs into this folder.")
@asking(PROFILE, SET)
def macros(asked: Asked, output: str) -> None:
    """Write the macro programs that the tool checks call.

    What they must know about the laser barrier stands in [macros] of the profile, their limits in [checks].
    """
    from chipbreak.api import macro_programs
    from chipbreak.macros import foreign_files, makers_numbers
    from chipbreak.settings import SettingsError

    settings = settings_of(asked, "-")
    try:
        files = macro_programs(settings)
    except SettingsError as error:
        asked.reporter.show([error.diagnostic])
        sys.exit(USAGE)
    folder = Path(output)
    there = {name: (folder / name).read_bytes() for name in files if is_file(folder / name)}
    macros = settings.dialect.macros
    foreign = foreign_files(macros, there) if macros else []
    if foreign:
        raise click.UsageError(
            f"{output}: {', '.join(foreign)} is not a file of chipbreak; nothing was written"
        )
    warning = makers_numbers(settings.dialect, settings.macros.first_program)
    asked.reporter.show([warning] if warning else [])
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"cannot write {output}: {error.strerror}") from None
    replace_files({folder / name: data for name, data in files.items()})
