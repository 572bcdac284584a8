"""Places in a program: half-open byte offsets, and lines and columns for people."""

from __future__ import annotations

from typing import NamedTuple


class Span(NamedTuple):
    """Bytes ``start`` to ``end`` (exclusive) of the file the user gave us."""

    start: int
    end: int


class Place(NamedTuple):
    """Where a diagnostic points: line and column count from 1, columns in bytes."""

    file: str
    line: int
    column: int
    end_column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"
