"""Our named tuples are those of ``typing``, but for what is done with annotations."""

from __future__ import annotations

import pickle
import typing

import pytest

from chipbreak.text import named_tuple


class Ours(named_tuple.NamedTuple):
    """Says what it is."""

    one: int
    two: unknown = 2  # type: ignore[name-defined]  # noqa: F821 (nobody looks at it)

    @property
    def total(self) -> int:
        return self.one + self.two


class Theirs(typing.NamedTuple):
    """Says what it is."""

    one: int
    two: int = 2

    @property
    def total(self) -> int:
        return self.one + self.two


def test_the_same_in_use() -> None:
    for cls in (Ours, Theirs):
        made = cls(1)
        assert (made.total, made, made._replace(two=5), cls._fields) == (3, (1, 2), (1, 5), ("one", "two"))
        assert repr(made) == f"{cls.__name__}(one=1, two=2)"
        assert not hasattr(made, "__dict__")
        assert pickle.loads(pickle.dumps(made)) == made
        assert type(pickle.loads(pickle.dumps(made))) is cls
        assert (cls.__doc__, cls.__module__) == ("Says what it is.", __name__)


@pytest.mark.parametrize("base", [named_tuple.NamedTuple, typing.NamedTuple])
def test_a_default_before_none_is_refused(base: type) -> None:
    with pytest.raises(TypeError, match="default"):
        exec("class Wrong(base):\n    one: int = 1\n    two: int\n", {"base": base, "__name__": __name__})
