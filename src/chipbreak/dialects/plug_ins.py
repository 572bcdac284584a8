"""Dialects that other installed packages offer; they are looked at only for a name that is not shipped."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from chipbreak.dialects.base import Dialect, check_dialect
from chipbreak.text.diagnostics import RefusalError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP: Final = "chipbreak.dialects"
UNUSABLE_DIALECT: Final = "SET006"


def offered_names() -> list[str]:
    """The names that installed packages offer, without loading any."""
    return sorted({entry.name for entry in _entries()})


def offered(name: str) -> tuple[Dialect, ...]:
    """The dialects of a name that an installed package offers; none where there is no such package.

    Raises RefusalError (SET006) for a package that offers something else, or fails, and where two packages
    offer one name.
    """
    entries = [entry for entry in _entries() if entry.name == name]
    if len(entries) > 1:
        targets = " and ".join(sorted(entry.value for entry in entries))
        message = f"the dialect {name!r} is offered twice, by {targets}"
        raise RefusalError(UNUSABLE_DIALECT, message, "uninstall one of the two packages")
    return _loaded(entries[0]) if entries else ()


def _entries() -> list[EntryPoint]:
    from importlib.metadata import entry_points  # noqa: PLC0415 (slow to import, and few profiles need it)

    return list(entry_points(group=GROUP))


def _loaded(entry: EntryPoint) -> tuple[Dialect, ...]:
    try:
        found = entry.load()
        dialects = (found,) if isinstance(found, Dialect) else tuple(found)
        if not dialects or not all(isinstance(dialect, Dialect) for dialect in dialects):
            raise TypeError("it is no Dialect, and no tuple of them")
        others = {dialect.name for dialect in dialects} - {entry.name}
        if others:
            raise ValueError(f"its name is {', '.join(sorted(others))}")
        for dialect in dialects:
            check_dialect(dialect)
    except Exception as error:
        message = (
            f"the dialect {entry.name!r} of {entry.value} cannot be used: {type(error).__name__}: {error}"
        )
        raise RefusalError(
            UNUSABLE_DIALECT, message, "update or remove the package that offers it"
        ) from error
    return dialects
