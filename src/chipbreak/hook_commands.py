"""Commands for those who call this program: the files by which they do, and a folder that is watched."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import click

from chipbreak.options import LOG, PROFILE, READING, SET, Asked, asking, settings_for, settings_of
from chipbreak.program_files import read_program, write_or_note
from chipbreak.streams import complain, replace_file
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_file, is_there

_NAMES = ("linuxcnc", "freecad", "cam", "git", "editors")


@click.group()
def hooks() -> None:
    """Files by which LinuxCNC, CAM systems, git and editors call this program."""


@hooks.command("list")
def hooks_list() -> None:
    """What there are files for."""
    from chipbreak.hooks.write import HOOKS

    for hook in HOOKS:
        click.echo(f"{hook.name:10} {hook.title}")


@hooks.command("write")
@click.argument("name", type=click.Choice(_NAMES))
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    required=True,
    type=click.Path(),
    help="Write the files into this folder.",
)
@asking(PROFILE, SET)
def hooks_write(asked: Asked, name: str, output: str) -> None:
    """Write the files of a hook, with the paths of this machine and the profile of -p in them.

    A file that is there already is kept, and said.
    """
    from chipbreak.hooks.write import hook_files

    settings_of(asked, "-")  # a hook whose profile cannot be read would fail where nobody looks
    profile = asked.profile or "chipbreak.toml"
    if is_file(profile):
        profile = str(Path(profile).absolute())
    folder = Path(output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"cannot write {output}: {error.strerror}") from None
    written = hook_files(name, program=_this_program(), profile=profile, folder=str(folder.absolute()))
    for file, (data, is_run) in written.items():
        target = folder / file
        if is_there(target) and target.read_bytes() != data:
            raise click.UsageError(f"{target} is there already and says something else: name another folder")
        replace_file(target, [data])
        if is_run:
            target.chmod(0o755)
        click.echo(str(target))


@hooks.command("watch")
@click.argument("folder", type=click.Path(exists=True, file_okay=False))
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    required=True,
    type=click.Path(),
    help="Write the programs into this folder.",
)
@asking(*READING, LOG)
def hooks_watch(asked: Asked, folder: str, output: str) -> None:
    """Filter every program that is written into FOLDER, as soon as it is there, until interrupted.

    What a run of its own would give stands in DIR; where a program is rejected, NAME.rejected says why.
    """
    from chipbreak.batch.inputs import is_program

    if Path(output).resolve() == Path(folder).resolve():
        raise click.UsageError("-o names the folder that is watched: name another one")
    watch = _watcher()
    settings_of(asked, str(Path(folder, "-")))
    complain(escaped(f"watching {folder}; Ctrl-C ends it"))
    for changes in watch(folder, recursive=False, raise_interrupt=False):
        for name in sorted({Path(path).name for _, path in changes}):
            source = Path(folder, name)
            if is_program(name) and is_file(source):
                try:
                    _filter_into(asked, source, Path(output, name))
                except click.UsageError as error:  # gone again, or not yet to be read: the next one may be
                    asked.reporter.tell(escaped(f"{source}: {error.message}"))


def _watcher() -> Callable[..., Iterable[set[tuple[object, str]]]]:
    try:
        from watchfiles import watch
    except ImportError:
        raise click.UsageError("watching needs: pip install 'chipbreak[watch]'") from None
    watcher: Callable[..., Iterable[set[tuple[object, str]]]] = watch
    return watcher


def _filter_into(asked: Asked, source: Path, target: Path) -> None:
    """One program, with one line on what became of it; a profile that has just been broken ends nothing."""
    from chipbreak.batch.table import told
    from chipbreak.batch.work import Task, filtered
    from chipbreak.settings import SettingsError

    try:
        settings = settings_for(asked, str(source))
    except SettingsError as error:
        asked.reporter.show([error.diagnostic])
        return
    with asked.reporter.logging("hooks watch", [str(source)]):
        program = read_program(str(source))
        task = Task(0, str(source), program.data, settings, asked.allow_unbroken, program.beside)
        finished = filtered(task)
        write_or_note(target, finished)
        asked.reporter.show(finished.diagnostics)
        asked.reporter.tell(escaped(f"{source}: {told(finished)}"))


def _this_program() -> str:
    """The path by which a caller without this environment finds the command."""
    beside = Path(sys.executable).with_name("chipbreak")
    found = str(beside) if is_there(beside) else shutil.which("chipbreak")
    return found or "chipbreak"
