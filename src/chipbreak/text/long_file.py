"""A program in a file that is open, for what need not be read whole."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from typing import BinaryIO

from chipbreak.text.named_tuple import NamedTuple

CHANGES = "it changes while it is read; try again when it is whole"
_BLOCK_BYTES = 1 << 20


class LongFile(NamedTuple):
    """A program in a file that is open.  ``stamp`` is its size and time when it was opened."""

    file: BinaryIO
    name: str
    stamp: tuple[int, int]

    @classmethod
    def of(cls, file: BinaryIO, name: str) -> LongFile:
        """Raises OSError."""
        return cls(file, name, _stamp(file))

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return self.stamp[0]

    def has_changed(self) -> bool:
        """True where somebody has written into it since it was opened.  Raises OSError."""
        return _stamp(self.file) != self.stamp

    def blocks(self, start: int, size: int, most: int = _BLOCK_BYTES) -> Iterator[bytes]:
        """Bytes from ``start`` on, a block at a time.  Raises OSError."""
        self.file.seek(start)
        while size:
            block = self.file.read(min(size, most))
            if not block:
                raise OSError(errno.EBUSY, CHANGES)
            size -= len(block)
            yield block


def _stamp(file: BinaryIO) -> tuple[int, int]:
    found = os.fstat(file.fileno())
    return found.st_size, found.st_mtime_ns
