"""Options that several commands share, and what they lead to: settings, a run, an exit code."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

import click

from chipbreak.outcome import (
    DIFFERENT,
    DONE,
    FAILED,
    REJECTED,
    USAGE,
    Outcome,
    outcome_of,
)
from chipbreak.streams import Reporter, complain
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_file
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from chipbreak.pipeline import Result
    from chipbreak.program_files import ProgramFile
    from chipbreak.settings import Settings
    from chipbreak.text.long_file import LongFile

__all__ = ["DIFFERENT", "DONE", "FAILED", "REJECTED", "USAGE", "Outcome"]
_Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


class Asked(NamedTuple):
    """What the options that commands share were set to."""

    profile: str | None = None
    sets: tuple[str, ...] = ()
    tool_files: tuple[str, ...] = ()
    strict: bool = False
    allow_unbroken: bool = False
    unroll: bool = False
    as_json: bool = False
    quiet: bool = False
    verbose: bool = False
    color: str = "never"
    log: str | None = None
    messages: bool = False
    beside: str | None = None

    @property
    def reporter(self) -> Reporter:
        """Says what is to be said as the options ask for it."""
        colour = self.colours(sys.stderr)
        return Reporter(as_json=self.as_json, quiet=self.quiet, colour=colour, log=self.log)

    def colours(self, stream: TextIO | None) -> bool:
        """True when what goes to this stream, None for a closed one, is to be coloured."""
        is_screen = stream is not None and stream.isatty()
        on_screen = self.color == "auto" and is_screen and "NO_COLOR" not in os.environ
        return self.color == "always" or on_screen


def _profiles_for(context: click.Context, option: click.Parameter, begun: str) -> list[CompletionItem]:
    """Files, and shipped profiles.  It only lists a folder: a shell waits for it when the key is pressed."""
    from click.shell_completion import CompletionItem

    shipped = sorted(file.stem for file in (Path(__file__).parent / "profiles").glob("*.toml"))
    names = [CompletionItem(name) for name in shipped if name.startswith(begun)]
    return [CompletionItem(begun, type="file"), *names]  # bash forgets what stands before a file


PROFILE = click.option(
    "-p",
    "--profile",
    metavar="FILE|NAME",
    envvar="CHIPBREAK_PROFILE",
    help="Machine profile: a shipped name or a TOML file.",
    shell_complete=_profiles_for,
)
SET = click.option(
    "--set", "sets", metavar="SECTION.KEY=VALUE", multiple=True, help="Change a value of the profile."
)
TOOLS = click.option(
    "--tools",
    "tool_files",
    metavar="FILE",
    multiple=True,
    help="File with tool data; the first that says something wins.",
)
STRICT = click.option(
    "--strict",
    is_flag=True,
    help="A tool check without a place, and a wish for vibration that reaches no cut, are errors.",
)
UNBROKEN = click.option("--allow-unbroken", is_flag=True, help="Let cuts pass that do not break their chips.")
UNROLL = click.option("--unroll", is_flag=True, help="Write out all cycles as plain blocks, asked or not.")
REPORTING = (
    click.option("--json", "as_json", is_flag=True, help="Diagnostics and reports as JSON."),
    click.option("-q", "--quiet", is_flag=True, help="Only errors on stderr."),
    click.option("-v", "--verbose", is_flag=True, help="Say which profile and tool files are used."),
    click.option(
        "--color",
        type=click.Choice(["auto", "always", "never"]),
        default="auto",
        help="Colour.",
    ),
)
LOG = click.option(
    "--log", metavar="FILE", type=click.Path(), help="Add everything that is said to this file as well."
)
MESSAGES = click.option(
    "--operator-messages",
    "messages",
    is_flag=True,
    help="Write warnings into the program as comments too; LinuxCNC shows them to the operator.",
)
BESIDE = click.option(
    "--beside",
    metavar="FILE",
    type=click.Path(),
    help="Instead of NAME.chipbreak: what 'restore' needs where the profile says output.brackets = none.",
)
READING = (PROFILE, SET, TOOLS, STRICT, UNBROKEN, UNROLL, *REPORTING)


def asking(*options: _Decorator) -> _Decorator:
    """Give a command these options, as one :class:`Asked` in front of its own arguments."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(command)
        def run(**values: Any) -> Any:
            shared = {key: values.pop(key) for key in Asked._fields if key in values}
            return command(Asked(**shared), **values)

        decorated: Callable[..., Any] = run
        for option in reversed(options):
            decorated = option(decorated)
        return decorated

    return decorate


def settings_of(asked: Asked, source: str) -> Settings:
    """:func:`settings_for`; says what is wrong with the profile and exits with 2."""
    from chipbreak.settings import SettingsError

    try:
        return settings_for(asked, source)
    except SettingsError as error:
        asked.reporter.show([error.diagnostic])
        sys.exit(USAGE)


def settings_for(asked: Asked, source: str) -> Settings:
    """The profile by option, environment, or the ``chipbreak.toml`` that :func:`found_profile` finds.

    The files of ``--tools`` come before those of the profile.  Raises SettingsError, and click.UsageError
    where nothing names a machine.
    """
    from chipbreak.settings import load

    settings = load(_profile_for(asked, source), asked.sets)
    _check_rules(settings)
    if asked.strict:
        settings = replace(settings, checks=replace(settings.checks, strict=True))
    if asked.unroll:
        settings = replace(settings, cycles=replace(settings.cycles, unroll="always"))
    if asked.tool_files:
        settings = _with_tool_files(settings, asked.tool_files)
    if asked.verbose and not asked.quiet and not asked.as_json:
        _say_what_is_used(settings, asked, source)
    return settings


def _say_what_is_used(settings: Settings, asked: Asked, source: str) -> None:
    """One line a file on stderr: where a value comes from that nobody expects is asked for here."""
    from chipbreak.tools.files import files_of

    where = f", {where_found(source)}" if asked.profile is None else ""
    lines = [f"profile {settings.name}{where}; 'chipbreak profile show' says every value of it"]
    lines += [f"--set {one}" for one in asked.sets]
    lines += [f"tools {name}" for name in files_of(settings)]
    for line in lines:
        complain(escaped(f"{shown(source)}: {line}"))


def settings_of_filtered(asked: Asked, source: str, program: ProgramFile) -> Settings:
    """The profile that filtered a program, by its stamp; without a stamp as :func:`settings_of`.

    Raises click.UsageError where no profile here is the one of the stamp.
    """
    from chipbreak.editing.notes import stamp_of
    from chipbreak.settings import SettingsError
    from chipbreak.settings.fingerprint import fingerprint

    stamp = None if asked.profile is not None else stamp_of(program.data + (program.beside or b""))
    if stamp is None:
        return settings_of(asked, source)
    stamped = asked._replace(sets=("output.stamp=true", *asked.sets))  # for there is one
    for profile in _profiles_called(stamp.profile, source):
        try:
            settings = settings_for(stamped._replace(profile=profile), source)
        except SettingsError:
            continue
        if fingerprint(settings) == stamp.fingerprint:
            return settings
    raise click.UsageError(
        escaped(
            f"{shown(source)} was filtered with profile {stamp.profile} ({stamp.fingerprint}) by chipbreak"
            f" {stamp.version}, and none here says the same: give it with -p, and what --set changed"
        )
    )


def _profiles_called(name: str, source: str) -> Iterator[str]:
    """Profiles whose name in capitals is that of a stamp: beside the program, and shipped."""
    from chipbreak.settings import profile_names

    folder = _folder_of(source)
    yield from sorted(str(one) for one in folder.glob("*.toml") if one.stem.upper() == name.upper())
    found = found_profile(source)
    if found is not None and found.stem.upper() == name.upper():
        yield str(found)
    yield from (one for one in profile_names() if one.upper() == name.upper())


def _profile_for(asked: Asked, source: str) -> str:
    if asked.profile is not None:
        return asked.profile
    found = found_profile(source)
    if found is not None:
        return str(found)
    from chipbreak.settings import profile_names

    names = ", ".join(profile_names())
    raise click.UsageError(
        "which machine? give -p PROFILE, set CHIPBREAK_PROFILE, or put a chipbreak.toml beside the program"
        f" or in a folder above it: chipbreak profile init chipbreak.toml makes one (shipped: {names})"
    )


def user_folder() -> Path:
    """Where a user keeps the profile that holds for all of their programs."""
    return Path(click.get_app_dir("chipbreak"))


def found_profile(source: str) -> Path | None:
    """The ``chipbreak.toml`` nearest to a program: beside it, in a folder above, in the user's folder."""
    folder = _folder_of(source)
    above = folder.absolute().parents
    for one in (folder, *above, user_folder()):
        file = one / "chipbreak.toml"
        if is_file(file):
            return file
    return None


def _folder_of(source: str) -> Path:
    return Path() if source == "-" else Path(source).parent


def where_found(source: str) -> str:
    """Where the profile of a program was found, in words."""
    found = found_profile(source)
    if found is None or found.parent == _folder_of(source):
        return "found beside it"
    return f"found as {found}"


def _check_rules(settings: Settings) -> None:
    """Calls and operation rules that a program may never come to are checked all the same."""
    if not (settings.checks.enabled or settings.call_sets or settings.operations):
        return
    from chipbreak.checks.calls import check_sets
    from chipbreak.operations.kinds import KindRules
    from chipbreak.settings import SettingsError
    from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity

    try:
        check_sets(settings)
        KindRules.from_profile(settings.operations)
    except RefusalError as error:
        message = f"{settings.name}: {error.message}"
        raise SettingsError(Diagnostic(error.code, Severity.ERROR, message, error.help)) from None


def _with_tool_files(settings: Settings, names: Sequence[str]) -> Settings:
    """The settings with files of tools before those of the profile."""
    from chipbreak.text.frozen_table import FrozenTable
    from chipbreak.tools.files import files_of

    tools = replace(settings.tools, files=(*names, *files_of(settings)))
    origins = FrozenTable({**settings.origins, "tools.files": "--tools"})
    return replace(settings, tools=tools, origins=origins)


def run_filter(program: ProgramFile, settings: Settings, source: str, asked: Asked) -> Result:
    """Filter a program; says what is wrong with it and exits with 3 when it is rejected."""
    outcome = rewrite_program(program, settings, source, asked)
    if outcome.result is None:
        asked.reporter.show(outcome.diagnostics)
        sys.exit(outcome.code)
    return outcome.result


def rewrite_program(program: ProgramFile, settings: Settings, source: str, asked: Asked) -> Outcome:
    """Filter a program; exits with 2 or 4 when something else than the program is at fault."""
    from chipbreak.pipeline import rewrite

    name = shown(source)
    return _unless_failed(
        name,
        asked,
        outcome_of(
            lambda: rewrite(
                program.data,
                settings,
                name,
                beside=program.beside,
                allow_unbroken=asked.allow_unbroken,
                messages=asked.messages,
                progress=_progress(),
            )
        ),
    )


def rewrite_long_program(program: LongFile, settings: Settings, source: str, asked: Asked) -> Outcome | None:
    """The same of a long program that is not read whole; None where it must be."""
    from chipbreak.long_programs import rewrite_long
    from chipbreak.text.diagnostics import ChipbreakError

    def work() -> Result:
        if isinstance(found, Exception):
            raise found
        assert found is not None
        return found

    found: Result | Exception | None
    try:
        found = rewrite_long(
            program._replace(name=shown(source)),
            settings,
            allow_unbroken=asked.allow_unbroken,
            messages=asked.messages,
            progress=_progress(),
        )
    except OSError as error:
        raise click.UsageError(escaped(f"cannot read {shown(source)}: {error.strerror}")) from None
    except (ChipbreakError, MemoryError) as error:
        found = error
    return None if found is None else _unless_failed(shown(source), asked, outcome_of(work))


def _progress() -> Callable[[int], None] | None:
    """What LinuxCNC's AXIS reads of a filter while it runs; nobody else sets the variable."""
    if "AXIS_PROGRESS_BAR" not in os.environ:
        return None
    most = -1

    def tell(percent: int) -> None:
        nonlocal most
        if percent > most:  # a stage may be gone through again
            most = percent
            complain(f"FILTER_PROGRESS={percent}")

    tell(0)
    return tell


def verify_program(program: ProgramFile, settings: Settings, source: str, asked: Asked) -> Result:
    """Judge a filtered program; exits with 3 or 4 when it is not as it was written."""
    from chipbreak.editing.beside import with_brackets
    from chipbreak.editing.bracket import BEGIN, find
    from chipbreak.editing.notes import stamp_of
    from chipbreak.pipeline import verify_filtered
    from chipbreak.settings.fingerprint import fingerprint
    from chipbreak.text.diagnostics import SelfCheckError

    name = shown(source)

    def work() -> Result:
        try:
            return verify_filtered(program.data, settings, name, beside=program.beside)
        except SelfCheckError as error:  # nobody's fault but the choice of program and profile
            what = f"this is not what profile {settings.name} makes of it: {error}"
            way_out = "verify it with the profile and the settings that filtered it, or filter it again"
            stamp = stamp_of(program.data + (program.beside or b""))
            if stamp is not None and stamp.fingerprint != fingerprint(settings):
                what += f"; its stamp says profile {stamp.profile} ({stamp.fingerprint}), which this is not"
            if find(with_brackets(program.data, name, program.beside).data, BEGIN) < 0:
                way_out = "nothing in it was written by chipbreak: filter it first"
            complain(escaped(f"{name}: error SLF003: {what}") + f"\n  help: {way_out}")
            sys.exit(FAILED)

    outcome = _unless_failed(name, asked, outcome_of(work))
    if outcome.result is None:
        asked.reporter.show(outcome.diagnostics)
        sys.exit(outcome.code)
    return outcome.result


def shown(source: str) -> str:
    """A source in messages."""
    return "<stdin>" if source == "-" else source


def _unless_failed(name: str, asked: Asked, outcome: Outcome) -> Outcome:
    """The outcome of a program that was done or rejected; says any other and exits with its code."""
    if outcome.code == FAILED:
        asked.reporter.tell("\n".join(escaped(f"{name}: ") + said.render() for said in outcome.diagnostics))
        sys.exit(FAILED)
    if outcome.code == USAGE:
        asked.reporter.show(outcome.diagnostics)
        sys.exit(USAGE)
    return outcome


def fail(message: str) -> NoReturn:
    """Say that the fault is ours, and exit with 4."""
    complain(escaped(message))
    complain("  help: nothing was written; please report this with the program")
    sys.exit(FAILED)
