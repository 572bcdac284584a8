"""Where the keys of a TOML text stand: in sections, dotted, and in tables within a line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache

from chipbreak.text.named_tuple import NamedTuple

_PART = r"""(?:"(?:\\.|[^"\\])*"|'[^']*'|[\w-]+)"""
_DOTTED = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"\s*\[{{1,2}}\s*({_DOTTED})\s*\]")
# What is no key is passed over in whole, else each of its characters would be looked at as the first of one.
_TOKEN = re.compile(
    rf"""(?P<comment>\#.*)|(?P<key>{_DOTTED})\s*=|(?P<mark>[\[\]{{}}])|(?>{_DOTTED})|["'].*|."""
)
_LONG_TEXT = ('"""', "'''")


class KeyPlace(NamedTuple):
    """A key or a section: its full name, its line from 1, its columns from 0, and the line."""

    name: str
    line: int
    start: int
    end: int
    text: str


def find_key(text: str, name: str) -> KeyPlace:
    """Where a key stands; where it does not, the nearest of what it is in; the first line at last."""
    places = _first_places(text)
    while name not in places and "." in name:
        name = name.rpartition(".")[0]
    return places.get(name) or KeyPlace(name, 1, 0, 1, text.split("\n", 1)[0])


@lru_cache(maxsize=4)
def _first_places(text: str) -> Mapping[str, KeyPlace]:
    """The first place of each key: where a value came from is asked for every value of a profile."""
    return {place.name: place for place in reversed(list(_key_places(text)))}


def _key_places(text: str) -> Iterator[KeyPlace]:
    section = ""
    tables: list[str] = []  # what the braces and brackets that are open belong to
    in_long_text = False
    for number, line in enumerate(text.split("\n"), 1):
        toggles = sum(line.count(mark) for mark in _LONG_TEXT) % 2
        if in_long_text or toggles:
            in_long_text = in_long_text != bool(toggles)
            if in_long_text and not toggles:
                continue
        header = None if tables else _HEADER.match(line)
        if header:
            section = _name(header[1])
            yield KeyPlace(section, number, header.start(1), header.end(1), line)
        else:
            yield from _keys_of(line, number, section, tables)


def _keys_of(line: str, number: int, section: str, tables: list[str]) -> Iterator[KeyPlace]:
    """The keys of one line; ``tables`` goes on from line to line."""
    last = tables[-1] if tables else section
    for token in _TOKEN.finditer(line):
        if token["key"]:
            inside = tables[-1] if tables else section
            last = ".".join(filter(None, (inside, _name(token["key"]))))
            yield KeyPlace(last, number, token.start("key"), token.end("key"), line)
        elif token["mark"] in ("{", "["):
            tables.append(last)
        elif token["mark"] and tables:
            last = tables.pop()


def _name(dotted: str) -> str:
    """``axes . "X"`` is ``axes.X``."""
    return ".".join(part.strip("\"'") for part in re.findall(_PART, dotted))
