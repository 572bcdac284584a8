"""Commands about machine profiles: which there are, what one says, and a new one for a machine."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from chipbreak.options import REPORTING, SET, USAGE, Asked, asking, settings_of
from chipbreak.streams import complain, replace_file, say, write_json
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_there

if TYPE_CHECKING:
    from chipbreak.machine_files.found import Found, Machine
    from chipbreak.machine_files.questions import Question


@click.group()
def profile() -> None:
    """Machine profiles."""


@profile.command("list")
def profile_list() -> None:
    """The shipped profiles."""
    from chipbreak.settings import load, profile_names

    for name in profile_names():
        settings = load(name)
        calls = settings.checks.calls
        whose = f", calls of {calls}" if calls != "builtin" else ""
        say(f"{name:20} {settings.dialect.title}{whose}")


@profile.command("show")
@click.argument("name")
@asking(SET)
def profile_show(asked: Asked, name: str) -> None:
    """Every value of a profile, and where it comes from."""
    from chipbreak.settings.show import show_profile

    for line in show_profile(settings_of(asked._replace(profile=name), "-")):
        say(line)


@profile.command("schema")
def profile_schema() -> None:
    """The JSON Schema of profiles, by which an editor completes and checks them."""
    from chipbreak.settings.schema import schema_of_profiles

    write_json(schema_of_profiles(), indent=2, versioned=False)


@profile.command("init")
@click.argument("file", metavar="FILE.toml", type=click.Path())
@click.option("--base", metavar="NAME", help="The shipped profile that is nearest to the machine.")
@click.option(
    "--from-ini",
    metavar="INI",
    type=click.Path(),
    help="Take the numbers of a LinuxCNC machine from its INI file.",
)
@click.option(
    "--from-parameters",
    metavar="TXT",
    type=click.Path(),
    help="Take the numbers of a Fanuc control from a print-out of its parameters.",
)
@click.option("--force", is_flag=True, help="Replace FILE if it is there.")
@asking(*REPORTING)
def profile_init(
    asked: Asked, file: str, base: str | None, from_ini: str | None, from_parameters: str | None, force: bool
) -> None:
    """Write a profile for a machine: from its own files, or by questions on a terminal.

    It says where each value came from and what is still missing.  Name it with -p, or write it as
    chipbreak.toml into the folder of the programs.
    """
    if from_ini is not None and from_parameters is not None:
        raise click.UsageError("give one of --from-ini and --from-parameters")
    target = Path(file)
    if is_there(target) and not force:
        raise click.UsageError(f"{file} is there already: give another name, or --force to replace it")
    machine = _machine(asked, from_ini, from_parameters)
    if base is not None:
        machine = machine._replace(base=base)
    if from_ini is None and from_parameters is None and sys.stdin is not None and sys.stdin.isatty():
        machine = _asked_for(machine, ask_base=base is None)
    _write(asked, target, machine, from_ini or from_parameters)


def _machine(asked: Asked, from_ini: str | None, from_parameters: str | None) -> Machine:
    from chipbreak.machine_files.fanuc_parameters import machine_of_parameters
    from chipbreak.machine_files.found import Machine
    from chipbreak.machine_files.linuxcnc_ini import machine_of_ini
    from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity

    readers: list[tuple[str | None, Callable[[str], Machine]]] = [
        (from_ini, machine_of_ini),
        (from_parameters, machine_of_parameters),
    ]
    try:
        for name, reader in readers:
            if name is not None:
                return reader(name)
    except RefusalError as error:
        asked.reporter.show([Diagnostic(error.code, Severity.ERROR, error.message, error.help)])
        sys.exit(USAGE)
    return Machine("generic-lathe", (), ())


def _asked_for(machine: Machine, *, ask_base: bool) -> Machine:
    """What a person answers; an empty answer leaves a value as the base has it."""
    from chipbreak.machine_files.questions import QUESTIONS
    from chipbreak.settings import load, profile_names

    base = machine.base
    if ask_base:
        click.echo("Which of these is nearest to the machine?  " + ", ".join(profile_names()), err=True)
        base = click.prompt(
            "base", default=base, type=click.Choice(profile_names()), show_choices=False, err=True
        )
    settings = load(base)
    found: list[Found] = []
    missing: list[str] = []
    click.echo("Enter alone leaves out what nobody knows yet.", err=True)
    for question in QUESTIONS:
        if not question.concerns(settings):
            continue
        one = _answered(question)
        if one is not None:
            found.append(one)
        elif question.key.startswith("axes."):
            missing.append(f"{question.key}: {question.text}")
    return machine._replace(base=base, found=tuple(found), missing=tuple(missing))


def _answered(question: Question) -> Found | None:
    """What a person answers to a question, asked again until it can be; None for nothing."""
    from chipbreak.machine_files.questions import answer

    while True:
        text = click.prompt(question.text, default="", show_default=False, err=True)
        one = answer(question, text) if text else None
        if one is not None or not text:
            return one
        click.echo(f"  {question.expected}", err=True)


def _write(asked: Asked, target: Path, machine: Machine, origin: str | None) -> None:
    """The profile, once it is known that it can be read."""
    from chipbreak.machine_files.found import plain, profile_text

    title = f"Machine profile, made by chipbreak profile init{f' from {plain(origin)}' if origin else ''}."
    text = profile_text(machine, title).encode("utf-8", "replace")
    _try_out(asked, target, text)
    replace_file(target, [text])
    if not asked.quiet:
        count = len(machine.found)
        said = f"{target}: {count} value{'s' if count != 1 else ''} over {machine.base}"
        for line in (said, *(f"  still to be said: {one}" for one in machine.missing)):
            complain(escaped(line))


def _try_out(asked: Asked, target: Path, text: bytes) -> None:
    """Load the profile from elsewhere; says what is wrong with it and exits with 2."""
    from chipbreak.settings import SettingsError, load

    with tempfile.TemporaryDirectory() as folder:
        trial = Path(folder, "trial.toml")
        trial.write_bytes(text)
        try:
            load(trial)
        except SettingsError as error:
            place = error.diagnostic.place
            place = place and place._replace(file=str(target))
            asked.reporter.show([error.diagnostic._replace(place=place)])
            sys.exit(USAGE)
