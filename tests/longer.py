"""Which of many like cases ``make test`` tries; the others are marked ``long``, for ``make test-long``."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Any

import pytest
from _pytest.mark import ParameterSet


def short_where(cases: Iterable[Any], is_short: Callable[[Any], bool]) -> list[ParameterSet]:
    """All cases for ``parametrize``; a tuple is one with several arguments."""
    return [_parameters(case, is_long=not is_short(case)) for case in cases]


def first_of_each(cases: Iterable[Any], kind_of: Callable[[Any], Hashable]) -> list[ParameterSet]:
    """All cases; those behind the first of their kind are long."""
    seen: set[Hashable] = set()
    found = []
    for case in cases:
        kind = kind_of(case)
        found.append(_parameters(case, is_long=kind in seen))
        seen.add(kind)
    return found


def every_second(cases: Iterable[Any]) -> list[ParameterSet]:
    """All cases; each second one is long."""
    return [_parameters(case, is_long=at % 2 == 1) for at, case in enumerate(cases)]


def _parameters(case: Any, *, is_long: bool) -> ParameterSet:
    given = (
        case if isinstance(case, ParameterSet) else pytest.param(*(case if type(case) is tuple else (case,)))
    )
    return pytest.param(*given.values, id=given.id, marks=[*given.marks, *[pytest.mark.long] * is_long])
