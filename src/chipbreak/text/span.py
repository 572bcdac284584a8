"""Places in a program: lines and columns for people."""

from __future__ import annotations

from chipbreak.text.named_tuple import NamedTuple


class Place(NamedTuple):
    """Where a diagnostic points: line and column count from 1, columns in bytes."""

    file: str
    line: int
    column: int
    end_column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"
