"""A number that somebody asked for."""

from __future__ import annotations

from chipbreak.text.named_tuple import NamedTuple


def shown(value: float) -> str:
    """A number for people, six digits at most: ``2586.21``."""
    return f"{value:.6g}"


class SourcedValue(NamedTuple):
    """A number somebody asked for, and where ("N word, line 12")."""

    value: float
    origin: str

    def __str__(self) -> str:
        return f"{shown(self.value)} ({self.origin})"
