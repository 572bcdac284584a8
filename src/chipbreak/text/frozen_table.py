"""A table that nobody can change, and that can go to another process."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class FrozenTable(dict[K, V]):
    """A dict that refuses every change.

    It is read as fast as a dict, equals one with the same entries, pickles and copies; Python's own read-only
    mapping does neither of the last two.  ``table | other`` is a frozen table again.
    """

    __slots__ = ()

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("this table cannot be changed: make a new one")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __or__(self, other: dict[Any, Any]) -> FrozenTable[Any, Any]:
        return FrozenTable({**self, **other})

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenTable, (dict(self),)

    def __repr__(self) -> str:
        return f"FrozenTable({dict.__repr__(self)})"
