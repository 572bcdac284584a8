"""What git calls to compare programs: neither of them ever makes git fail."""

from __future__ import annotations

import difflib
import os
from typing import TYPE_CHECKING

import click

from chipbreak.options import PROFILE, SET, Asked, asking
from chipbreak.streams import read_input, write_stdout

if TYPE_CHECKING:
    from chipbreak.settings import Settings

_NOTHING = os.devnull


@click.command("textconv")
@click.argument("file", type=click.Path())
def textconv(file: str) -> None:
    """Print a program for git to compare: a part that chipbreak wrote is one line.

    A program that cannot be read so is printed as it is.
    """
    write_stdout([f"{line}\n".encode("latin-1", "replace") for line in _lines(read_input(file), file)])


@click.command("git-diff")
@click.argument("arguments", nargs=-1, metavar="PATH OLD OLD-HEX OLD-MODE NEW NEW-HEX NEW-MODE")
@asking(PROFILE, SET)
def git_diff(asked: Asked, arguments: tuple[str, ...]) -> None:
    """Compare two versions of a program as git's external diff driver.

    git gives seven arguments, two more for a file that was renamed, and one for a file that is in conflict.
    With -p, CHIPBREAK_PROFILE or a chipbreak.toml beside the program or above it, numbers are read as its
    control reads them.
    """
    if len(arguments) < 7:
        click.echo(f"{' '.join(arguments[:1])}: in conflict, not compared")
        return
    path, old, new = arguments[0], arguments[1], arguments[4]
    name = arguments[7] if len(arguments) > 7 else path
    shown = _compared(asked, path, (old, new), (_name("a", path, old), _name("b", name, new)))
    write_stdout([f"{line}\n".encode("latin-1", "replace") for line in shown])


def _name(side: str, path: str, file: str) -> str:
    return _NOTHING if file == _NOTHING else f"{side}/{path}"


def _compared(asked: Asked, path: str, files: tuple[str, str], names: tuple[str, str]) -> list[str]:
    """The patch by what blocks say; by their text where a program cannot be read."""
    from chipbreak.editing import diff_output
    from chipbreak.editing.diff import compare, items_of
    from chipbreak.text.diagnostics import ProgramRejectedError

    data = [b"" if file == _NOTHING else read_input(file) for file in files]
    head = [f"diff --chipbreak {names[0]} {names[1]}"]
    settings = _settings(asked, path)
    try:
        sides = [items_of(one, name, settings) for one, name in zip(data, names, strict=True)]
    except ProgramRejectedError as error:
        head += [f"compared by its text: {error}"]
        a, b = (one.decode("latin-1").splitlines() for one in data)
        return head + list(difflib.unified_diff(a, b, *names, lineterm=""))
    patch = list(diff_output.unified(compare(*sides), *names))
    return head + (patch or ["the same blocks"])


def _settings(asked: Asked, path: str) -> Settings | None:
    """The profile for numbers; none where nothing names a machine, or what does cannot be read."""
    from chipbreak.options import settings_for
    from chipbreak.settings import SettingsError

    try:
        return settings_for(asked, path)
    except (SettingsError, click.UsageError):
        return None


def _lines(data: bytes, name: str) -> list[str]:
    from chipbreak.editing.diff import items_of
    from chipbreak.text.diagnostics import ProgramRejectedError

    try:
        return [item.text for item in items_of(data, name, None)]
    except ProgramRejectedError:
        return data.decode("latin-1").splitlines()
