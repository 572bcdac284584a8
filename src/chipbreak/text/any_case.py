"""Regular expressions for words that people write in capitals or not.

``re.IGNORECASE`` makes an expression of many words two to three times as dear to compile, and nearly every
program has a comment that asks for some.  So capitals are compiled, and sought in the capitals of a text;
what is found is said as the text has it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property

# What is no letter of the words: escapes, and the names of groups.
_PIECE = r"(\\.|\(\?P[<=]\w+)|([^\W\d_]+)"
# Capitals of one character that ``str.upper`` leaves as they are, and ``re.IGNORECASE`` does not.
_FURTHER = {0x130: "I", 0x212A: "K"}


class Hit:
    """Where an expression was found: as ``re.Match``, with the letters of the text."""

    __slots__ = ("_match", "_text")

    def __init__(self, match: re.Match[str], text: str) -> None:
        self._match = match
        self._text = text

    def __getitem__(self, group: int | str) -> str:
        """The text of a group; None, though the type does not say so, where it took no part."""
        start, end = self._match.span(group)
        return self._text[start:end] if start >= 0 else None  # type: ignore[return-value]

    def group(self) -> str:
        """All of it."""
        return self[0]

    def groups(self) -> tuple[str | None, ...]:
        """The text of every group, None for those that took no part."""
        return tuple(self[number + 1] for number in range(self._match.re.groups))

    @property
    def lastgroup(self) -> str | None:
        """The name of the last group that took part."""
        return self._match.lastgroup

    def start(self) -> int:
        """Where it begins."""
        return self._match.start()

    def end(self) -> int:
        """Where it ends."""
        return self._match.end()


class AnyCase:
    """A regular expression for capitals and small letters alike, compiled when it is first used."""

    def __init__(self, pattern: str) -> None:
        self.source = pattern

    @cached_property
    def compiled(self) -> re.Pattern[str]:
        """The compiled expression, which finds capitals only."""
        return re.compile(re.sub(_PIECE, lambda piece: piece[1] or capitals(piece[2]), self.source))

    def search(self, text: str) -> Hit | None:
        """The first place where it is."""
        match = self.compiled.search(capitals(text))
        return Hit(match, text) if match else None

    def match(self, text: str) -> Hit | None:
        """The text begins with it."""
        match = self.compiled.match(capitals(text))
        return Hit(match, text) if match else None

    def finditer(self, text: str) -> Iterator[Hit]:
        """Every place where it is."""
        return (Hit(match, text) for match in self.compiled.finditer(capitals(text)))

    def sub(self, new: str, text: str) -> str:
        """The text with ``new`` in all those places."""
        pieces = []
        at = 0
        for hit in self.finditer(text):
            pieces += [text[at : hit.start()], new]
            at = hit.end()
        return "".join((*pieces, text[at:]))


def capitals(text: str) -> str:
    """The text in capitals, each character where it was."""
    upper = text.upper()
    if upper.isascii() and len(upper) == len(text):
        return upper
    return "".join(map(_capital, text))


def _capital(character: str) -> str:
    upper = character.upper()
    return _FURTHER.get(ord(character), upper if len(upper) == 1 else character)
