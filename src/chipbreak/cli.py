"""The command line.

Everything heavy is imported inside the commands, so that help and completion answer at once.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar

import click

from chipbreak.streams import Reporter, read_input, replace_file, write_stdout

if TYPE_CHECKING:
    from chipbreak.pipeline import Result
    from chipbreak.settings import Settings

DONE, DIFFERENT, USAGE, REJECTED, FAILED = 0, 1, 2, 3, 4
_Command = TypeVar("_Command", bound=Callable[..., Any])


_PROFILE = "Machine profile: a shipped name or a TOML file."
_SET = "Change a value of the profile."


def _options(command: _Command) -> _Command:
    """The options every command that reads programs has."""
    decorators = [
        click.option("-p", "--profile", metavar="FILE|NAME", envvar="CHIPBREAK_PROFILE", help=_PROFILE),
        click.option("--set", "sets", metavar="SECTION.KEY=VALUE", multiple=True, help=_SET),
        click.option("--allow-unbroken", is_flag=True, help="Let cuts pass that do not break their chips."),
        *_REPORTING,
    ]
    for decorate in reversed(decorators):
        command = decorate(command)
    return command


_REPORTING = [
    click.option("--json", "as_json", is_flag=True, help="Diagnostics and reports as JSON."),
    click.option("-q", "--quiet", is_flag=True, help="Only errors on stderr."),
    click.option(
        "--color", type=click.Choice(["auto", "always", "never"]), default="auto", help="Colour on stderr."
    ),
]


def _reporting(command: _Command) -> _Command:
    for decorate in reversed(_REPORTING):
        command = decorate(command)
    return command


def _reporter(as_json: bool, quiet: bool, color: str) -> Reporter:
    colour = color == "always" or (color == "auto" and sys.stderr.isatty() and "NO_COLOR" not in os.environ)
    return Reporter(as_json=as_json, quiet=quiet, colour=colour)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="chipbreak")
def cli() -> None:
    """Break chips and watch tools on a control that cannot.

    chipbreak reads an NC program and writes a corrected one: cuts that ask for vibration are expanded into
    timed moves, and tool checks are inserted between operations.  Everything else stays as it is, byte for
    byte, and a program with an error in it gives no output at all.
    """


@cli.command("filter")
@click.argument("source", metavar="[INPUT]", default="-")
@click.option("-o", "--output", metavar="OUT", help="Write to this file, replaced in one step.")
@click.option("-i", "--in-place", is_flag=True, help="Replace the input file in one step.")
@click.option("--backup", metavar="SUFFIX", help="With -i: keep the original under its name plus this.")
@click.option("--check", is_flag=True, help="Write nothing; exit 1 if anything would change.")
@_options
def filter_command(
    source: str,
    output: str | None,
    in_place: bool,
    backup: str | None,
    check: bool,
    profile: str | None,
    sets: tuple[str, ...],
    allow_unbroken: bool,
    as_json: bool,
    quiet: bool,
    color: str,
) -> None:
    """Filter a program: from stdin or INPUT to stdout, OUT or INPUT itself."""
    reporter = _reporter(as_json, quiet, color)
    if in_place and (source == "-" or output):
        raise click.UsageError("-i replaces INPUT itself: name a file, and leave -o out")
    if backup is not None and (not in_place or not backup or "/" in backup):
        raise click.UsageError("--backup goes with -i and takes a suffix such as .bak")
    data = read_input(source)
    result = _run(data, source, profile, sets, allow_unbroken, reporter)
    reporter.show(result.diagnostics)
    if check:
        sys.exit(DIFFERENT if result.changed else DONE)
    target = source if in_place else output
    if target is None or target == "-":
        write_stdout(result.output)
        return
    if in_place and not result.changed:
        return
    if backup is not None:
        replace_file(Path(source + backup), [data])
    replace_file(Path(target), result.output)


@cli.command()
@click.argument("sources", metavar="INPUT...", nargs=-1, required=True)
@_options
def check(
    sources: tuple[str, ...],
    profile: str | None,
    sets: tuple[str, ...],
    allow_unbroken: bool,
    as_json: bool,
    quiet: bool,
    color: str,
) -> None:
    """Say everything that is wrong with programs; write none."""
    from chipbreak.diagnostics import ProgramRejectedError, has_errors

    reporter = _reporter(as_json, quiet, color)
    failed = False
    for source in sources:
        data = read_input(source)
        settings = _settings(profile, sets, source, reporter)
        try:
            diagnostics = _rewrite(data, settings, source, allow_unbroken).diagnostics
        except ProgramRejectedError as error:
            diagnostics = error.diagnostics
        failed |= has_errors(diagnostics)
        reporter.show(diagnostics)
    sys.exit(DIFFERENT if failed else DONE)


@cli.command()
@click.argument("source", metavar="INPUT", default="-")
@_options
def explain(
    source: str,
    profile: str | None,
    sets: tuple[str, ...],
    allow_unbroken: bool,
    as_json: bool,
    quiet: bool,
    color: str,
) -> None:
    """Show each vibrated cut, operation and check, with its reasons."""
    from chipbreak.report import explain_json, explain_text

    reporter = _reporter(as_json, quiet, color)
    settings = _settings(profile, sets, source, reporter)
    result = _run(read_input(source), source, profile, sets, allow_unbroken, reporter)
    if as_json:
        click.echo(json.dumps(explain_json(result, settings.name), indent=2))
        return
    reporter.show(result.diagnostics)
    for line in explain_text(result, settings.name):
        click.echo(line)


@cli.command()
@click.argument("a")
@click.argument("b")
@click.option("--ignore-comments", is_flag=True, help="Comments do not count.")
@_reporting
def diff(a: str, b: str, ignore_comments: bool, as_json: bool, quiet: bool, color: str) -> None:
    """Compare two programs by what their blocks say.

    Block numbers, spacing and number format do not count; a part that chipbreak wrote is one line.  Exit 0:
    the same, 1: different, 2: trouble.
    """
    from chipbreak.diagnostics import ProgramRejectedError
    from chipbreak.diff import as_json as hunks_json
    from chipbreak.diff import compare, differs, items_of, unified

    reporter = _reporter(as_json, quiet, color)
    try:
        sides = [items_of(read_input(name), name, ignore_comments=ignore_comments) for name in (a, b)]
    except ProgramRejectedError as error:
        reporter.show(error.diagnostics)
        sys.exit(USAGE)
    hunks = compare(*sides)
    if as_json:
        click.echo(json.dumps(hunks_json(hunks), indent=2))
    else:
        write_stdout([f"{line}\n".encode("latin-1", "replace") for line in unified(hunks, a, b)])
    sys.exit(DIFFERENT if differs(hunks) else DONE)


@cli.command()
@click.argument("source", metavar="INPUT", default="-")
@click.option("-o", "--output", metavar="OUT", help="Write to this file, replaced in one step.")
@_reporting
def restore(source: str, output: str | None, as_json: bool, quiet: bool, color: str) -> None:
    """Give the original bytes back from a filtered program."""
    from chipbreak.diagnostics import ProgramRejectedError
    from chipbreak.restore import restore as put_back
    from chipbreak.source import read

    reporter = _reporter(as_json, quiet, color)
    try:
        original = put_back(read(read_input(source), source)).data
    except ProgramRejectedError as error:
        reporter.show(error.diagnostics)
        sys.exit(REJECTED)
    if output is None or output == "-":
        write_stdout([original])
    else:
        replace_file(Path(output), [original])


@cli.group()
def profile() -> None:
    """Machine profiles."""


@profile.command("list")
def profile_list() -> None:
    """The shipped profiles."""
    from chipbreak.settings import load, profile_names

    for name in profile_names():
        click.echo(f"{name:16} {load(name).dialect.title}")


@profile.command("show")
@click.argument("name")
@click.option("--set", "sets", metavar="SECTION.KEY=VALUE", multiple=True, help=_SET)
def profile_show(name: str, sets: tuple[str, ...]) -> None:
    """Every value of a profile, and where it comes from."""
    from chipbreak.settings.show import show_profile

    reporter = Reporter(as_json=False, quiet=False, colour=False)
    for line in show_profile(_settings(name, sets, "-", reporter)):
        click.echo(line)


def _settings(profile: str | None, sets: Sequence[str], source: str, reporter: Reporter) -> Settings:
    """The profile by option, environment, or ``chipbreak.toml`` beside the input; exits with 2 without one."""
    from chipbreak.settings import SettingsError, load, profile_names

    if profile is None:
        beside = (Path() if source == "-" else Path(source).parent) / "chipbreak.toml"
        if not beside.is_file():
            names = ", ".join(profile_names())
            raise click.UsageError(
                "which machine? give -p PROFILE, set CHIPBREAK_PROFILE,"
                f" or put a chipbreak.toml beside the program (shipped: {names})"
            )
        profile = str(beside)
    try:
        return load(profile, sets)
    except SettingsError as error:
        reporter.show([error.diagnostic])
        sys.exit(USAGE)


def _run(
    data: bytes,
    source: str,
    profile: str | None,
    sets: tuple[str, ...],
    allow_unbroken: bool,
    reporter: Reporter,
) -> Result:
    from chipbreak.diagnostics import ProgramRejectedError

    settings = _settings(profile, sets, source, reporter)
    try:
        return _rewrite(data, settings, source, allow_unbroken)
    except ProgramRejectedError as error:
        reporter.show(error.diagnostics)
        sys.exit(REJECTED)


def _rewrite(data: bytes, settings: Settings, source: str, allow_unbroken: bool) -> Result:
    from chipbreak.pipeline import rewrite
    from chipbreak.verify import SelfCheckError

    name = "<stdin>" if source == "-" else source
    try:
        return rewrite(data, settings, name, allow_unbroken=allow_unbroken)
    except SelfCheckError as error:
        _fail(f"{name}: error SLF001: the output failed its self-check: {error}")
    except MemoryError:
        _fail(f"{name}: error SLF002: not enough memory for this program")


def _fail(message: str) -> NoReturn:
    click.echo(message, err=True)
    click.echo("  help: nothing was written; please report this with the program", err=True)
    sys.exit(FAILED)


def main() -> None:
    """The ``chipbreak`` command; whatever happens, no traceback."""
    try:
        cli()
    except Exception as error:
        if os.environ.get("CHIPBREAK_TRACEBACK"):
            raise
        _fail(f"error SLF002: internal fault, {type(error).__name__}: {error}")
