"""How much is read of a file that is no program: what is larger is no profile, no list of tools."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Final

MOST_PROFILE_BYTES: Final = 4 << 20
MOST_MACHINE_FILE_BYTES: Final = 16 << 20
# Of a line of a table or of TOML: readers may look at a line as often as it has characters.
MOST_LINE_CHARS: Final = 10_000


def read_bounded(path: Path, most_bytes: int) -> bytes:
    """All bytes of a file.  Raises OSError for a larger one, and for a pipe or device: it may have no end."""
    if "\0" in str(path):
        raise OSError(errno.EINVAL, "no file has such a name")
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(descriptor, "rb") as file:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not stat.S_ISREG(mode):
            raise OSError(errno.EINVAL, "it is no file")
        data = file.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise OSError(errno.EFBIG, f"it is larger than {most_bytes >> 20} MB")
    return data


def long_line(lines: Sequence[str]) -> int | None:
    """The number (from 1) of the first line that is longer than any of a table; None where there is none."""
    return next((number for number, line in enumerate(lines, 1) if len(line) > MOST_LINE_CHARS), None)
