"""What was found about a machine, and the profile that says it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from chipbreak.text.named_tuple import NamedTuple

Value = str | float | bool | list[str]


class Found(NamedTuple):
    """A value of a profile, ``section.key``, and where it was found."""

    key: str
    value: Value
    source: str


class Machine(NamedTuple):
    """A machine as its files describe it.

    ``base`` is the shipped profile that it is nearest to; ``missing`` what its files do not say, each a line
    of text.
    """

    base: str
    found: tuple[Found, ...]
    missing: tuple[str, ...]


def profile_text(machine: Machine, title: str) -> str:
    """The profile as TOML, each value with where it came from, and what is still to be said."""
    return "".join(f"{line}\n" for line in _lines(machine, title))


def _lines(machine: Machine, title: str) -> Iterator[str]:
    yield from (f"# {line}".rstrip() for line in title.splitlines())
    yield f"base = {_toml(machine.base)}"
    for section in dict.fromkeys(one.key.rpartition(".")[0] for one in machine.found):
        yield ""
        yield f"[{section}]"
        values = [one for one in machine.found if one.key.rpartition(".")[0] == section]
        texts = [f"{one.key.rpartition('.')[2]} = {_toml(one.value)}" for one in values]
        width = max(map(len, texts))
        for one, text in zip(values, texts, strict=True):
            yield f"{text:{width}}  # {one.source}"
    if machine.missing:
        yield ""
        yield "# Not found, and still to be said:"
        yield from (f"#   {line}" for line in machine.missing)


def _toml(value: Value) -> str:
    """A value as TOML; a text of JSON is one of TOML too, but for DEL."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.10g}"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def plain(text: str) -> str:
    """Text of a file for a comment: one line, nothing in it that a terminal obeys."""
    return "".join(c if c.isprintable() else "?" for c in text)


def first_of(found: Iterable[Found]) -> tuple[Found, ...]:
    """Of several values for one key the first."""
    kept: dict[str, Found] = {}
    for one in found:
        kept.setdefault(one.key, one)
    return tuple(kept.values())
