"""What git calls to compare programs: neither of them ever makes git fail."""

from __future__ import annotations

import difflib
import os
from typing import TYPE_CHECKING

import click

from chipbreak.options import PROFILE, SET, Asked, asking
from chipbreak.streams import read_input, write_stdout
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.editing.diff import Item
    from chipbreak.git_versions import Beside
    from chipbreak.settings import Settings

_NOTHING = os.devnull


@click.command("textconv")
@click.argument("file", type=click.Path())
def textconv(file: str) -> None:
    """Print a program for git to compare: a part that chipbreak wrote is one line.

    A program without our comments is read with the version of NAME.chipbreak that is about it.  What cannot
    be read so is printed as it is.
    """
    from chipbreak.git_versions import beside_of_copy

    data = read_input(file)
    lines = _lines(data, file, beside_of_copy(file, data).content)
    write_stdout([f"{line}\n".encode("latin-1", "replace") for line in lines])


@click.command("git-diff")
@click.argument("arguments", nargs=-1, metavar="PATH OLD OLD-HEX OLD-MODE NEW NEW-HEX NEW-MODE")
@asking(PROFILE, SET)
def git_diff(asked: Asked, arguments: tuple[str, ...]) -> None:
    """Compare two versions of a program as git's external diff driver.

    git gives seven arguments, two more for a file that was renamed, and one for a file that is in conflict.
    With -p, CHIPBREAK_PROFILE or a chipbreak.toml beside the program or above it, numbers are read as its
    control reads them.  A program without our comments is read with the version of NAME.chipbreak that is
    about it.
    """
    if len(arguments) < 7:
        click.echo(f"{' '.join(arguments[:1])}: in conflict, not compared")
        return
    path, old, new = arguments[0], arguments[1], arguments[4]
    renamed = arguments[7] if len(arguments) > 7 else path
    shown = _compared(asked, _side("a", path, old), _side("b", renamed, new))
    write_stdout([f"{line}\n".encode("latin-1", "replace") for line in shown])


class _Side(NamedTuple):
    """One of two versions: its name in the patch, its path from the root, its bytes, the file beside it."""

    name: str
    path: str
    data: bytes
    beside: Beside

    def items(self, settings: Settings | None) -> list[Item]:
        """What is compared.  Raises ProgramRejectedError."""
        from chipbreak.editing.diff import items_of

        return items_of(self.data, self.name, settings, beside=self.beside.content)


def _side(side: str, path: str, file: str) -> _Side:
    from chipbreak.git_versions import Beside, beside_of_path

    if file == _NOTHING:
        return _Side(_NOTHING, path, b"", Beside())
    data = read_input(file)
    return _Side(f"{side}/{path}", path, data, beside_of_path(path, data))


def _compared(asked: Asked, a: _Side, b: _Side) -> list[str]:
    """The patch by what blocks say; by their text where a program cannot be read."""
    from chipbreak.editing import diff_output
    from chipbreak.editing.diff import compare
    from chipbreak.text.diagnostics import ProgramRejectedError

    head = [f"diff --chipbreak {a.name} {b.name}"]
    head += [
        f"{one.name} as it stands: no version of {one.beside.name} is about it"
        for one in (a, b)
        if one.beside.name and one.beside.content is None
    ]
    settings = _settings(asked, b.path)
    try:
        changes = compare(a.items(settings), b.items(settings))
    except ProgramRejectedError as error:
        head += [f"compared by its text: {error}"]
        old, new = (one.data.decode("latin-1").splitlines() for one in (a, b))
        return head + list(difflib.unified_diff(old, new, a.name, b.name, lineterm=""))
    return head + (list(diff_output.unified(changes, a.name, b.name)) or ["the same blocks"])


def _settings(asked: Asked, path: str) -> Settings | None:
    """The profile for numbers; none where nothing names a machine, or what does cannot be read."""
    from chipbreak.options import settings_for
    from chipbreak.settings import SettingsError

    try:
        return settings_for(asked, path)
    except (SettingsError, click.UsageError):
        return None


def _lines(data: bytes, name: str, beside: bytes | None) -> list[str]:
    from chipbreak.editing.diff import items_of
    from chipbreak.text.diagnostics import ProgramRejectedError

    try:
        return [item.text for item in items_of(data, name, beside=beside)]
    except ProgramRejectedError:
        return data.decode("latin-1").splitlines()
