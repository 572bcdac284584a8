"""Functions of small arrays that remember what they gave: the cuts of a program are often alike.

The passes of a roughing operation differ in their diameter; their strokes, times and feeds are the same to
the last bit.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import is_dataclass
from functools import wraps
from threading import Lock
from typing import Any, Final, ParamSpec, TypeVar

import numpy as np

_MOST_NUMBERS = 1 << 13  # in one array: a longer cut is worked out anew
_MOST_KEPT = 1 << 19  # numbers of all arrays, given and asked for, by one function: 4 MB

_P = ParamSpec("_P")
_R = TypeVar("_R")
_ENTRY = 128  # what one costs beside its arrays, in numbers
_one_at_a_time: Final = Lock()
_every: Final[list[dict[Hashable, Any]]] = []


def remembered(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """The function, which gives the same object again for arguments that are the same to the last bit.

    Arguments are arrays, tuples and dataclasses of them, and what can be hashed.  Nobody may change what it
    gives: its arrays cannot be written.  It gives no None.
    """
    known: dict[Hashable, _R] = {}
    sizes: dict[Hashable, int] = {}  # of what is known, in numbers
    _every.extend((known, sizes))

    @wraps(function)
    def work(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        asked = (args, tuple(kwargs.items()))
        if _is_long(asked):
            return function(*args, **kwargs)
        key = _key_of(asked)
        found = known.get(key)
        if found is None:
            found = function(*args, **kwargs)
            for array in _arrays_in(found):
                array.flags.writeable = False
            if not _is_long(found):
                with _one_at_a_time:
                    known[key] = found
                    sizes[key] = sum(array.size for array in _arrays_in((asked, found))) + _ENTRY
                    _forget_oldest(known, sizes)
        return found

    return work


def _forget_oldest(known: dict[Hashable, _R], sizes: dict[Hashable, int]) -> None:
    """Forget what was found first, while all is more than is kept."""
    too_many = sum(sizes.values()) - _MOST_KEPT
    while too_many > 0 and len(known) > 1:
        oldest = next(iter(known))
        del known[oldest]
        too_many -= sizes.pop(oldest)


def forget() -> None:
    """Forget all that any function has given, for who changes how they work, or measures how long."""
    with _one_at_a_time:
        for known in _every:
            known.clear()


def _parts_of(value: object) -> tuple[object, ...] | None:
    """What a tuple, or a dataclass that does not compare its parts, is made of; None of anything else."""
    if isinstance(value, tuple):
        return value
    if type(value).__hash__ is object.__hash__ and is_dataclass(value):
        return tuple(vars(value).values())
    return None


def _is_long(value: object) -> bool:
    return any(array.size > _MOST_NUMBERS for array in _arrays_in(value))


def _arrays_in(value: object) -> Iterator[np.ndarray[Any, Any]]:
    if isinstance(value, np.ndarray):
        yield value
    for part in _parts_of(value) or ():
        yield from _arrays_in(part)


def _key_of(value: object) -> Hashable:
    """What is equal for equal bits."""
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.char, value.tobytes()
    parts = _parts_of(value)
    if parts is not None:
        return type(value), tuple(map(_key_of, parts))
    assert isinstance(value, Hashable)
    return value
