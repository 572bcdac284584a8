"""Named tuples that a short run does not wait for.

``typing.NamedTuple`` compiles the annotation of every field when its class is made.  With a hundred classes
that was a tenth of the time of a program of a hundred blocks.  Here annotations stay text, which is all that
this package needs of them while it runs.
"""

from __future__ import annotations

from collections import namedtuple
from typing import TYPE_CHECKING, Any

__all__ = ["NamedTuple"]

if TYPE_CHECKING:
    from typing import NamedTuple
else:

    class _NamedTupleType(type):
        """Makes a class with annotations a named tuple, with its defaults, methods and properties."""

        def __new__(mcs, name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> type:
            if not bases:
                return super().__new__(mcs, name, bases, namespace)
            fields = [*namespace.get("__annotations__", ())]
            defaults = {field: namespace.pop(field) for field in fields if field in namespace}
            if [*defaults] != fields[len(fields) - len(defaults) :]:
                raise TypeError(f"{name}: a field without a default stands behind one that has it")
            made = namedtuple(name, fields, defaults=defaults.values(), module=namespace["__module__"])
            # This class and none derived from it: objects of a derived one would have a dictionary each.
            for key, value in namespace.items():
                if key != "__module__":
                    setattr(made, key, value)
            return made

    class NamedTuple(metaclass=_NamedTupleType):
        """The base to derive from, as ``typing.NamedTuple``."""
