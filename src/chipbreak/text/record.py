"""Frozen dataclasses whose methods are written once.

``@dataclass(frozen=True)`` writes and compiles up to six methods anew for every class, and a short run waits
for it.  A class derived from one of these is a dataclass to ``fields`` and ``replace`` and to type checkers;
what it does is here.  Objects that are made by the thousand are better off with a class of their own.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field
from typing import Any, ClassVar, NoReturn, dataclass_transform


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
class Record:
    """Named values that never change; it equals itself alone."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __init_subclass__(cls, *, kw_only: bool = False) -> None:
        dataclass(init=False, repr=False, eq=False, match_args=False, kw_only=kw_only)(cls)

    def __init__(self, *args: Any, **values: Any) -> None:
        fields = self.__dataclass_fields__
        positional = [name for name, one in fields.items() if not one.kw_only]
        given = dict(zip(positional, args, strict=False)) | values
        if len(given) < len(args) + len(values) or given.keys() - fields.keys():
            raise TypeError(f"{type(self).__name__} has {', '.join(fields)}, each once")
        vars(self).update({name: given[name] if name in given else self._default(name) for name in fields})

    def _default(self, name: str) -> Any:
        one = self.__dataclass_fields__[name]
        if one.default is not MISSING:
            return one.default
        if one.default_factory is MISSING:
            raise TypeError(f"{type(self).__name__} needs {name}")
        return one.default_factory()

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> NoReturn:
        raise FrozenInstanceError(f"cannot delete field {name!r}")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class ValueRecord(Record):
    """A record that equals one of its class with the same values, and is shown with them."""

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and vars(other) == vars(self)

    def __hash__(self) -> int:
        return hash(tuple(vars(self).values()))

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={value!r}" for name, value in vars(self).items())
        return f"{type(self).__name__}({said})"
