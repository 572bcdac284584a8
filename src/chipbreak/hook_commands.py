"""Commands for those who call this program: the files by which they do, and a folder that is watched."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from chipbreak.options import PROFILE, SET, Asked, asking, settings_of
from chipbreak.streams import replace_file

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
    if Path(profile).is_file():
        profile = str(Path(profile).absolute())
    folder = Path(output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(f"cannot write {output}: {error.strerror}") from None
    written = hook_files(name, program=_this_program(), profile=profile, folder=str(folder.absolute()))
    for file, (data, is_run) in written.items():
        target = folder / file
        if target.exists() and target.read_bytes() != data:
            raise click.UsageError(f"{target} is there already and says something else: name another folder")
        replace_file(target, [data])
        if is_run:
            target.chmod(0o755)
        click.echo(str(target))


def _this_program() -> str:
    """The path by which a caller without this environment finds the command."""
    beside = Path(sys.executable).with_name("chipbreak")
    found = str(beside) if beside.exists() else shutil.which("chipbreak")
    return found or "chipbreak"
