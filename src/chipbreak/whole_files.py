"""Files that are old or new, never a part, whatever ends the run; and backups that overwrite nothing.

New content is written into a file of its own beside the target, brought to the disk, and renamed.  Such a
file is called ``.chipbreak-NUMBER-LETTERS.part``.  It is locked as long as its writer lives, so the next run
that writes into the folder knows one that a killed run has left, and removes it.
"""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from chipbreak.text.existence import is_file, is_folder, is_there

_PART = re.compile(r"\.chipbreak-\d+-[0-9a-f]{8}\.part")
_STREAM = re.compile(r"/(?:dev|proc/(?:self|\d+))/fd/(\d+)")
_MOST_LINKS = 40
_MOST_BACKUPS = 10_000
SWEPT: set[Path] = set()
"""The folders in which this run has looked for what killed runs have left."""


class NotReplacedError(OSError):
    """A file that could only be replaced by something less than it is; ``strerror`` says why."""

    def __init__(self, why: str) -> None:
        super().__init__(errno.EPERM, why)
        self.why = why

    def __reduce__(self) -> tuple[type[NotReplacedError], tuple[str]]:
        return type(self), (self.why,)


def replace(target: Path, pieces: Iterable[bytes], *, before: Callable[[Path], None] | None = None) -> None:
    """Write a file so that it has either the old or the new content, never a part.

    A link stays, and what it leads to is replaced; owner, group and mode stay those of the old file.  A
    device or a pipe is written into: a file in its place would be no device any more.  ``before`` looks at
    the file at the last moment, when only the renaming is left, and raises where it must not be replaced.

    Raises OSError, and NotReplacedError where the new file would not be what the old one is.
    """
    stream = _stream(target)
    if stream is not None:
        _write_into(stream, pieces)
        return
    real = _behind_links(target)
    with _part_beside(real, pieces, real if _is_replaceable(real) else None) as part:
        if before is not None:
            before(real)
        part.replace(real)


def keep(original: Path, data: bytes, suffix: str) -> Path:
    """Keep the content of a file under its name with a suffix; the name, ``a.nc.bak`` or ``a.nc.bak.2``.

    An older backup is never overwritten; one that says the same is taken.  Raises OSError.
    """
    first = original.with_name(original.name + suffix)
    with _part_beside(first, [data], _behind_links(original)) as part:
        for name in _numbered(first):
            if _is_new(part, name):
                _to_disk(first.parent)
                return name
            if is_file(name) and name.read_bytes() == data:
                return name
    raise OSError(errno.EEXIST, f"there are {_MOST_BACKUPS} of it")


def _numbered(first: Path) -> Iterator[Path]:
    yield first
    for number in range(2, _MOST_BACKUPS + 1):
        yield first.with_name(f"{first.name}.{number}")


def _is_new(part: Path, name: Path) -> bool:
    """Give a file a name that nobody has; False where somebody has it."""
    if os.path.lexists(name):
        return False
    try:
        os.link(part, name)
    except FileExistsError:
        return False
    except OSError:  # a file system without hard links, as on memory cards
        part.replace(name)
        return True
    part.unlink()
    return True


def _stream(target: Path) -> int | None:
    """The open file that a name stands for: /dev/stdout, /dev/fd/3, or a device or pipe, opened here."""
    path = target.absolute()
    for _ in range(_MOST_LINKS):
        found = _STREAM.fullmatch(str(path))
        if found is not None:
            return os.dup(int(found[1]))
        if not path.is_symlink():
            break
        path = path.parent / path.readlink()
    if is_there(target) and not is_file(target) and not is_folder(target):
        return os.open(target, os.O_WRONLY)
    return None


def _write_into(stream: int, pieces: Iterable[bytes]) -> None:
    with os.fdopen(stream, "wb") as file:
        file.writelines(pieces)


def _behind_links(target: Path) -> Path:
    real = Path(os.path.realpath(target))
    if real.is_symlink():  # only a link that leads back to itself is left
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
    return real


def _is_replaceable(real: Path) -> bool:
    """True where a file stands that may be replaced, False where there is none."""
    try:
        old = real.stat()
    except FileNotFoundError:
        return False
    if not os.access(real, os.W_OK):  # renaming would not ask
        raise OSError(errno.EACCES, os.strerror(errno.EACCES))
    if old.st_nlink > 1 and is_file(real):
        raise NotReplacedError(
            f"it has {old.st_nlink} names (hard links), and the others would keep the old program:"
            " write to another file, or give it a file of its own first (cp it, and mv the copy over it)"
        )
    return True


@contextmanager
def _part_beside(target: Path, pieces: Iterable[bytes], like: Path | None) -> Iterator[Path]:
    """A whole file with the new content beside the target, for the time being; gone behind it."""
    _sweep(target.parent)
    # A new file gets the mode that the system gives to new files; else nobody may look into it
    # until it has the mode of the file it replaces.
    part, file = _new_part(target.parent, 0o666 if like is None else 0o600)
    try:
        with file:
            file.writelines(pieces)
            file.flush()
            if like is not None:
                _make_alike(part, like)
            os.fsync(file.fileno())
            if os.name == "nt":  # which renames no file that is open
                file.close()
            yield part
    finally:
        part.unlink(missing_ok=True)


def _new_part(folder: Path, mode: int) -> tuple[Path, BinaryIO]:
    """A new file, locked.  Never one that is there, or behind a link that somebody put there."""
    flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
    while True:
        part = folder / f".chipbreak-{os.getpid()}-{os.urandom(4).hex()}.part"
        try:
            descriptor = os.open(part, flags, mode)
        except PermissionError as error:
            raise OSError(error.errno, f"no file can be made beside it: {error.strerror}") from None
        with suppress(OSError):  # where nothing can be locked, nothing is swept away either
            _lock(descriptor)
        if os.fstat(descriptor).st_nlink:
            return part, os.fdopen(descriptor, "wb")
        os.close(descriptor)  # another run swept it away before it was locked


def _make_alike(part: Path, old: Path) -> None:
    """Owner, group, mode and attributes of an old file.  Raises NotReplacedError where it cannot be."""
    new, like = part.stat(), old.stat()
    if (new.st_uid, new.st_gid) != (like.st_uid, like.st_gid):
        try:
            os.chown(part, like.st_uid, like.st_gid)
        except OSError:
            raise NotReplacedError(
                f"it belongs to user {like.st_uid} and group {like.st_gid}, and a new file in its place"
                f" to {new.st_uid} and {new.st_gid}: write to another file, or remove this one first"
            ) from None
    part.chmod(like.st_mode & 0o7777)
    with suppress(OSError, AttributeError):  # not every system has attributes
        for name in os.listxattr(old):
            os.setxattr(part, name, os.getxattr(old, name))


def _sweep(folder: Path) -> None:
    """Remove what killed runs have left in a folder; once a run."""
    if folder in SWEPT:
        return
    SWEPT.add(folder)
    with suppress(OSError):
        for name in os.listdir(folder):  # noqa: PTH208
            if _PART.fullmatch(name):
                _remove_if_left(folder / name)


def _remove_if_left(part: Path) -> None:
    with suppress(OSError):
        if os.name == "nt":  # which does not remove what somebody has open
            part.unlink()
            return
        descriptor = os.open(part, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | os.O_NONBLOCK)
        try:
            _lock(descriptor)
            part.unlink()
        finally:
            os.close(descriptor)


def _lock(descriptor: int) -> None:
    """Lock an open file, until it is closed.  Raises BlockingIOError when another run has it."""
    if os.name == "nt":
        return
    import fcntl  # noqa: PLC0415

    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _to_disk(folder: Path) -> None:
    """A name that was given is on the disk before anything is built on it."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
