"""Streams and files: bytes in, bytes out, diagnostics to stderr, nothing half written."""

from __future__ import annotations

import errno
import gc
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from chipbreak.text.encoding import escaped
from chipbreak.text.existence import is_file
from chipbreak.text.long_file import CHANGES, LongFile

if TYPE_CHECKING:
    from chipbreak.text.diagnostics import Diagnostic

INTERRUPTED = 130  # what a shell says of a command that Ctrl-C has ended
_LONG_BYTES = 1 << 18
_written: list[str] = []
_COLOURS = {"error": "red", "warning": "yellow", "note": "cyan"}


class Reporter:
    """Writes diagnostics to stderr, for people or for programs."""

    def __init__(self, *, as_json: bool, quiet: bool, colour: bool, log: str | None = None) -> None:
        self.as_json = as_json
        self.quiet = quiet
        self.colour = colour
        self.log = log

    def show(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Errors always; warnings unless quiet.  The log file gets all of them, as text."""
        diagnostics = tuple(diagnostics)
        self.note("\n".join(one.render() for one in diagnostics))
        chosen = [d for d in diagnostics if not self.quiet or d.severity.value == "error"]
        if self.as_json:
            write_json([d.as_json() for d in chosen], err=True)
            return
        for diagnostic in chosen:
            text = diagnostic.render()
            if self.colour:
                mark = f"{diagnostic.severity.value} {diagnostic.code}"
                styled = click.style(mark, fg=_COLOURS[diagnostic.severity.value], bold=True)
                text = text.replace(mark, styled, 1)
            complain(text, colour=self.colour)

    def tell(self, text: str) -> None:
        """Text to stderr and to the log file."""
        self.note(text)
        complain(text)

    @contextmanager
    def logging(self, command: str, names: Iterable[str]) -> Iterator[None]:
        """Say in the log file, if there is one, when this run began, and what ended it early."""
        if self.log is not None:
            now = time.strftime("%Y-%m-%d %H:%M:%S")
            self.note(f"{now} chipbreak {command} {escaped(' '.join(names))}")
        try:
            yield
        except click.UsageError as error:
            self.note(f"error: {error.message}")
            raise

    def note(self, text: str) -> None:
        """Add text to the log file, if there is one.  Raises click.UsageError (exit 2)."""
        if self.log is None or not text:
            return
        try:
            with Path(self.log).open("ab") as file:
                file.write(f"{text}\n".encode("utf-8", "backslashreplace"))
        except OSError as error:
            log, self.log = self.log, None
            raise click.UsageError(escaped(f"cannot write {log}: {error.strerror}")) from None


def say_interrupted() -> None:
    """Say which files are new; the others are as they were."""
    files = ", ".join(_written)
    said = f"written: {files}; nothing else was" if files else "nothing was written"
    complain(escaped(f"Interrupted; {said}"))


def write_json(value: Any, *, indent: int | None = None, err: bool = False, versioned: bool = True) -> None:
    """A value as JSON to stdout, or to stderr; an object of ours says the version of its keys."""
    import json  # noqa: PLC0415 (most runs print none)

    from chipbreak.report.schema import SCHEMA  # noqa: PLC0415

    if versioned and isinstance(value, dict):
        value = {"schema": SCHEMA, **value}
    # Of what is not printable, JSON leaves this one character as it is.
    text = json.dumps(value, indent=indent).replace("\x7f", "\\u007f")
    if err:
        complain(text)
    else:
        write_stdout([f"{text}\n".encode("ascii")])


def complain(text: str, *, colour: bool | None = None) -> None:
    """A line to stderr.  Where that takes none, the exit code says it all the same."""
    with suppress(OSError):
        click.echo(text, err=True, color=colour)


def say(line: str) -> None:
    """A line to stdout; what its encoding does not have, and what cannot be printed, is escaped."""
    write_lines([escaped(line)])


def write_lines(lines: Iterable[str]) -> None:
    """Lines to stdout, with colours where they have some; what its encoding does not have is escaped."""
    encoding = _stdout_encoding()
    write_stdout([f"{line}\n".encode(encoding, "backslashreplace") for line in lines])


def _stdout_encoding() -> str:
    return getattr(sys.stdout, "encoding", None) or "utf-8"


def read_input(source: str) -> bytes:
    """All bytes of a file, or of stdin for ``-``.  Raises click.UsageError (exit 2).

    A long program is worth collecting garbage for, which the command line leaves off.
    """
    if source == "-" and sys.stdin is not None and sys.stdin.isatty():
        complain(
            "waiting for a program from the keyboard, up to Ctrl-D (Windows: Ctrl-Z, Enter); or name a file"
        )
    data = _read(source)
    if len(data) > _LONG_BYTES:
        gc.enable()
    return data


def open_long(source: str, least_bytes: int) -> LongFile | bytes | None:
    """A long program, open; what was read of a shorter one on stdin; None for what is read as ever.

    Of stdin a copy is made, which goes when it is closed.  Raises click.UsageError (exit 2).
    """
    if source == "-":
        is_there = sys.stdin is not None and not sys.stdin.isatty()
        return _long_stdin(least_bytes) if is_there else None
    try:
        if not is_file(source) or Path(source).stat().st_size < least_bytes:
            return None
        return LongFile.of(Path(source).open("rb", buffering=0), source)
    except OSError:
        return None  # said by who reads it


def _long_stdin(least_bytes: int) -> LongFile | bytes:
    import shutil  # noqa: PLC0415 (few programs are long)
    import tempfile  # noqa: PLC0415

    with _reading("-"):
        head = sys.stdin.buffer.read(least_bytes)
        if len(head) < least_bytes:
            return head
        copy = tempfile.TemporaryFile()  # noqa: SIM115 (its user closes it)
        copy.write(head)
        shutil.copyfileobj(sys.stdin.buffer, copy)
        copy.flush()
        return LongFile.of(copy, "-")


@contextmanager
def _reading(source: str) -> Iterator[None]:
    """Raises click.UsageError (exit 2) for what cannot be read."""
    try:
        yield
    except OSError as error:
        shown = "standard input" if source == "-" else source or "a file without a name"
        raise click.UsageError(escaped(f"cannot read {shown}: {error.strerror}")) from None


def _read(source: str) -> bytes:
    if source == "-" and sys.stdin is None:
        raise click.UsageError("standard input is closed: name a file, or send the program there")
    with _reading(source):
        return sys.stdin.buffer.read() if source == "-" else _read_whole(Path(source))


def _read_whole(path: Path) -> bytes:
    """All bytes of a file that stays the same meanwhile.  Raises OSError."""
    with path.open("rb") as file:
        before = os.fstat(file.fileno())
        data = file.read()
        after = os.fstat(file.fileno())
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise OSError(errno.EBUSY, CHANGES)
    return data


def write_stdout(pieces: Iterable[bytes]) -> None:
    """Bytes to stdout, as they are.  Raises click.UsageError (exit 2) when it takes none."""
    if sys.stdout is None:
        raise click.UsageError("standard output is closed: name a file with -o")
    try:
        for piece in pieces:
            rest = memoryview(piece)
            while rest:  # with PYTHONUNBUFFERED a write may take a part only
                rest = rest[sys.stdout.buffer.write(rest) or 0 :]
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        _forget_stdout()
        sys.exit(1)
    except OSError as error:
        _forget_stdout()
        raise click.UsageError(f"cannot write standard output: {error.strerror}") from None


def _forget_stdout() -> None:
    """Nobody takes what is still there; keep Python from complaining when it closes stdout at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def replace_file(
    target: Path,
    pieces: Iterable[bytes],
    *,
    instead_of: bytes | None = None,
    read_from: LongFile | None = None,
) -> None:
    """Write a file so that it has either the old or the new content, never a part.

    ``instead_of`` is what was read from it: a file that says something else by now is left alone.  So is any
    where the pieces are ``read_from`` a file that has changed meanwhile.  Raises click.UsageError (exit 2),
    which says what is there now.
    """
    from chipbreak import whole_files  # noqa: PLC0415 (most runs write to stdout)

    pieces = pieces if instead_of is None else list(pieces)

    def before(real: Path) -> None:
        if read_from is not None and read_from.has_changed():
            raise whole_files.NotReplacedError(f"of the program that was read: {CHANGES}")
        if instead_of is not None and real.read_bytes() not in (instead_of, b"".join(pieces)):
            raise whole_files.NotReplacedError("somebody else has changed it since it was read")

    try:
        with _noted(target):
            whole_files.replace(target, pieces, before=before)
    except OSError as error:
        raise click.UsageError(escaped(f"cannot write {target}: {error.strerror}{_left(target)}")) from None


def replace_files(files: Mapping[Path, bytes]) -> None:
    """Write some files, each old or new.  Raises click.UsageError (exit 2), which says which ones are new."""
    written: list[str] = []
    for target, data in files.items():
        try:
            replace_file(target, [data])
        except click.UsageError as error:
            done = escaped(f"; written before: {', '.join(written)}") if written else ""
            raise click.UsageError(f"{error.message}{done}") from None
        written.append(str(target))


@contextmanager
def _noted(target: Path) -> Iterator[None]:
    """Remember a file that has been replaced, for the message of an interrupted run."""
    was = _file_at(target)
    _written.append(str(target))
    try:
        yield
    except BaseException:
        if _file_at(target) == was:  # an interruption may come when the new file is in its place
            _written.pop()
        raise


def _file_at(target: Path) -> tuple[int, int] | None:
    """Which file stands under a name, whatever is in it."""
    try:
        found = target.stat()
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _left(target: Path) -> str:
    """What a target is when it could not be written; a device or pipe may have taken a part."""
    if is_file(target):
        return "; the file is as it was"
    return "" if os.path.lexists(target) else "; no part of it is there"


def keep_file(original: Path, data: bytes, suffix: str) -> Path:
    """Keep the content of a file under its name with a suffix, and a number where that name is taken.

    Raises click.UsageError (exit 2).
    """
    from chipbreak import whole_files  # noqa: PLC0415

    try:
        return whole_files.keep(original, data, suffix)
    except OSError as error:
        name = f"{original}{suffix}"
        why = f"cannot write the backup {name}: {error.strerror}; {original} is as it was"
        raise click.UsageError(escaped(why)) from None


def remove_file(target: Path) -> None:
    """Remove a file, if it is there.  Raises click.UsageError (exit 2)."""
    try:
        target.unlink(missing_ok=True)
    except OSError as error:
        raise click.UsageError(escaped(f"cannot remove {target}: {error.strerror}")) from None


def note_rejection(target: Path, diagnostics: Iterable[Diagnostic] | None) -> None:
    """Say in ``target``.rejected what stands in the way of a program; None: nothing does, remove it."""
    note = target.with_name(f"{target.name}.rejected")
    if diagnostics is None:
        remove_file(note)
        return
    said = "\n".join(one.render() for one in diagnostics)
    replace_file(note, [f"{said}\n".encode("utf-8", "backslashreplace")])
