"""The known name that was probably meant."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(word: str, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The known name most like ``word``, or None when none is like it."""
    from difflib import get_close_matches  # noqa: PLC0415 (only errors need it, and it is slow to import)

    found = get_close_matches(word, list(known), 1, cutoff)
    return found[0] if found else None
