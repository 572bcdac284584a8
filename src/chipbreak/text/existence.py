"""Whether a path leads to something; one that nothing can have, or that may not be looked at, does not.

Whoever opens it says then why it cannot be read.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path


def is_there(path: str | Path) -> bool:
    """True where it leads to anything."""
    return _asked(Path(path).exists)


def is_file(path: str | Path) -> bool:
    """True for a file, also behind links."""
    return _asked(Path(path).is_file)


def is_folder(path: str | Path) -> bool:
    """True for a folder, also behind links."""
    return _asked(Path(path).is_dir)


def _asked(question: Callable[[], bool]) -> bool:
    try:
        return question()
    except OSError:  # a name that is too long, a folder that may not be searched
        return False
