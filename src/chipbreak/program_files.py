"""Programs on the disk, each with the file beside it where its brackets were left out of it.

A program is looked for with its file ``NAME.chipbreak``, and written with it, so that whenever a run ends the
two fit together: first the file beside, which then knows both programs, then the program, then the file that
knows the new one only.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

import click

from chipbreak.streams import note_rejection, read_input, remove_file, replace_file, write_stdout
from chipbreak.text.bounds import read_bounded
from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_file
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from chipbreak.batch.work import Finished

# From here on a program is not read whole where an excerpt does: some 200,000 blocks.
LONG_BYTES = 1 << 23
_MOST_BYTES = 1 << 28
_NO_PLACE = (
    "output.brackets is none, so what 'restore' needs goes into a file beside the program, and there is none:"
    " write the program with -o or -i, or name that file with --beside"
)


class ProgramFile(NamedTuple):
    """The bytes of a program, and those of the file beside it, None where there is none."""

    data: bytes
    beside: bytes | None = None


def read_program(source: str, beside: str | None = None, data: bytes | None = None) -> ProgramFile:
    """A program, or stdin for ``-``, with the file beside it; ``data`` is its bytes where they are known.

    Raises click.UsageError (exit 2).
    """
    data = read_input(source) if data is None else data
    place = _place(Path(source)) if beside is None and source != "-" else beside
    return ProgramFile(data, None if place is None else _read_beside(Path(place)))


def read_beside(program: str) -> bytes | None:
    """The file beside a program, None where there is none.  Raises click.UsageError (exit 2)."""
    return _read_beside(_place(Path(program)))


def has_beside(program: str | None) -> bool:
    """True where there is a file beside a program."""
    return program not in (None, "-") and os.path.lexists(_place(Path(str(program))))


def _place(program: Path) -> Path:
    """Where the file beside a program is: it belongs to the file, not to a link that leads there."""
    from chipbreak.editing.beside import SUFFIX

    real = Path(os.path.realpath(program))
    return real.with_name(real.name + SUFFIX)


def _read_beside(place: Path) -> bytes | None:
    try:
        return read_bounded(place, _MOST_BYTES)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise click.UsageError(escaped(f"cannot read {place}: {error.strerror}")) from None


def write_program(target: str | None, new: ProgramFile, beside: str | None = None) -> None:
    """A program to a file, replaced in one step, or to stdout for None and ``-``.

    Raises click.UsageError (exit 2); then nothing is written.
    """
    if target in (None, "-"):
        check_place(target, new, beside)
        if new.beside is not None:
            replace_file(Path(str(beside)), [new.beside])
        write_stdout([new.data])
    else:
        replace_program(Path(str(target)), new, beside=beside)


def check_place(target: str | None, new: ProgramFile, beside: str | None) -> None:
    """Raises click.UsageError where a program needs a file beside it, and there is no place for one."""
    has_place = target not in (None, "-") and (not os.path.lexists(str(target)) or is_file(str(target)))
    if new.beside is not None and beside is None and not has_place:
        raise click.UsageError(_NO_PLACE)


def replace_program(
    target: Path, new: ProgramFile, *, beside: str | None = None, instead_of: bytes | None = None
) -> None:
    """A program and the file beside it to the disk, so that whenever this ends the two fit together.

    ``instead_of`` is as for :func:`chipbreak.streams.replace_file`.  Raises click.UsageError (exit 2).
    """
    check_place(str(target), new, beside)
    place = _place(target) if beside is None else Path(beside)
    before = _read_beside(place) if new.beside is not None or is_file(target) else None
    if new.beside is None and before is None:
        replace_file(target, [new.data], instead_of=instead_of)
        return
    replace_file(place, [_for_both(target, new, before)])
    try:
        replace_file(target, [new.data], instead_of=instead_of)
    except BaseException:
        _put_back(place, before)
        raise
    _put_back(place, new.beside)


def _for_both(target: Path, new: ProgramFile, before: bytes | None) -> bytes:
    """A file beside that is about the program that is there, and about the one that comes."""
    from chipbreak.editing.beside import both, plain

    if before is None:
        before = plain(read_input(str(target))) if is_file(target) else plain(new.data)
    return both(new.beside or plain(new.data), before, str(target))


def _put_back(place: Path, content: bytes | None) -> None:
    if content is None:
        remove_file(place)
    else:
        replace_file(place, [content])


def write_or_note(target: Path, finished: Finished) -> None:
    """A program into a folder that may have to be made, or beside its place what stands in its way."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise click.UsageError(escaped(f"cannot write {target.parent}: {error.strerror}")) from None
    if finished.data is None:
        note_rejection(target, finished.diagnostics)
        return
    replace_program(target, ProgramFile(finished.data, finished.beside))
    note_rejection(target, None)
