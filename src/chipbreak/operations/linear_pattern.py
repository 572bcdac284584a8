"""Regular expressions whose search takes a time that grows with the text and with the expression alone.

Python's own search goes back and tries again, which for an expression such as ``(A+)+B`` takes longer than
anybody waits.  A profile may come from anywhere, so its expressions are followed on all ways at once: the set
of places in the expression that a text can have led to is carried from character to character (K. Thompson,
1968), and what a set becomes is remembered.  Single characters are still judged by :mod:`re`.

Not understood, because they cannot be followed so: ``(?=...)`` and alike, ``\\1``, and possessive repeats.
Where an expression can be met in several ways, the first place counts, and there the longest.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from typing import TypeVar

from chipbreak.text.named_tuple import NamedTuple

_Key = TypeVar("_Key")
MOST_PLACES = 2000
_MOST_SETS = 5000
_DEEPEST = 50
_PLAIN = re.compile(r"[^\\*+?{}()\[\]^$.]*")
_REPEAT = re.compile(r"([*+?]|\{(\d{0,4})(,?)(\d{0,4})\})([?+]?)")
_ATOM = re.compile(
    r"\\(?:x[0-9A-Fa-f]{2}|u[0-9A-Fa-f]{4}|[dDwWsStnrfva]|[^A-Za-z0-9])|\[\^?\]?(?:\\.|[^\]\\])*\]|[^\\\[]",
    re.DOTALL,
)
_AT = {"^": "start", "$": "end", r"\A": "start", r"\Z": "end", r"\b": "border", r"\B": "inside"}
_OPEN = re.compile(r"\((?:\?:|\?P<\w+>|(?!\?))")
_WORD = re.compile(r"\w")


class TooDifficultError(ValueError):
    """An expression that cannot be read, or not in bounded time; the text says why."""


class _Place(NamedTuple):
    """A place in the expression: what leads on from it, and where to.

    ``takes`` is a character that is taken on the way, ``at`` what must be here; both None: nothing.
    """

    takes: re.Pattern[str] | None = None
    at: str | None = None
    to: tuple[int, ...] = ()


class LinearPattern:
    """An expression, ready to be searched for.  Upper and lower case are the same."""

    def __init__(self, text: str) -> None:
        """Raises TooDifficultError."""
        self.pattern = text
        # What holds no repeat is no trouble for re either.
        self._plain = re.compile(text, re.IGNORECASE) if _PLAIN.fullmatch(text) else None
        self._places: list[_Place] = []
        self._first = 0
        if self._plain is None:
            reader = _Reader(text)
            self._first = reader.whole()
            self._places = reader.places
        self._next: dict[tuple[frozenset[int], str], frozenset[int]] = {}
        self._here: dict[tuple[frozenset[int], tuple[bool, ...]], frozenset[int]] = {}

    def search(self, text: str) -> str | None:
        """The part of a text that the expression says, or None."""
        if self._plain is not None:
            hit = self._plain.search(text)
            return hit.group() if hit else None
        if not self._is_in(text):
            return None
        ends = ((first, self._end(text, first)) for first in range(len(text) + 1))
        return next(text[first:end] for first, end in ends if end is not None)

    def _is_in(self, text: str) -> bool:
        """Whether there is any part, in one go."""
        begin = frozenset({self._first})
        found = begin
        for i in range(len(text) + 1):
            here = self._reached(found, text, i)
            if _END in here:
                return True
            if i < len(text):
                found = self._taken(here, text[i]) | begin
        return False

    def _end(self, text: str, first: int) -> int | None:
        """Where the longest part that starts at a character ends."""
        end = None
        found = frozenset({self._first})
        for i in range(first, len(text) + 1):
            here = self._reached(found, text, i)
            if _END in here:
                end = i
            if i == len(text) or not here:
                break
            found = self._taken(here, text[i])
        return end

    def _taken(self, places: frozenset[int], character: str) -> frozenset[int]:
        key = (places, character)
        known = self._next.get(key)
        if known is None:
            steps = (self._places[place] for place in places if place != _END)
            known = frozenset(
                to
                for step in steps
                if step.takes is not None and step.takes.match(character)
                for to in step.to
            )
            _remember(self._next, key, known)
        return known

    def _reached(self, places: frozenset[int], text: str, i: int) -> frozenset[int]:
        """All places that these lead to without a character."""
        is_border = _is_word(text, i - 1) != _is_word(text, i)
        where = (i == 0, i == len(text), is_border, not is_border)
        key = (places, where)
        known = self._here.get(key)
        if known is None:
            holds = {
                name for name, is_so in zip(("start", "end", "border", "inside"), where, strict=True) if is_so
            }
            known = frozenset(self._all_reached(places, holds))
            _remember(self._here, key, known)
        return known

    def _all_reached(self, places: frozenset[int], holds: set[str]) -> set[int]:
        seen: set[int] = set()
        left = list(places)
        while left:
            place = left.pop()
            if place in seen:
                continue
            seen.add(place)
            step = _Place() if place == _END else self._places[place]
            if step.takes is None and (step.at is None or step.at in holds):
                left += step.to
        return seen


_END = -1


def _remember(known: dict[_Key, frozenset[int]], key: _Key, value: frozenset[int]) -> None:
    if len(known) >= _MOST_SETS:
        known.clear()
    known[key] = value


def _is_word(text: str, i: int) -> bool:
    return 0 <= i < len(text) and _WORD.match(text[i]) is not None


# What comes behind -> where the piece begins.
_Piece = Callable[[int], int]


class _Reader:
    """Reads an expression into places, from its end: each piece is told what comes behind it."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.depth = 0
        self.places: list[_Place] = []

    def whole(self) -> int:
        """The first place of the whole expression.  Raises TooDifficultError."""
        piece = self._choice()
        if self.at < len(self.text):
            raise TooDifficultError(f"unbalanced {self.text[self.at]!r} at character {self.at + 1}")
        return piece(_END)

    def _add(self, place: _Place) -> int:
        if len(self.places) >= MOST_PLACES:
            raise TooDifficultError("it repeats too much")
        self.places.append(place)
        return len(self.places) - 1

    def _choice(self) -> _Piece:
        """``A|B|C``"""
        self.depth += 1
        if self.depth > _DEEPEST:
            raise TooDifficultError("it is nested too deeply")
        branches = [self._row()]
        while self._takes("|"):
            branches.append(self._row())
        self.depth -= 1
        if len(branches) == 1:
            return branches[0]
        return lambda then: self._add(_Place(to=tuple(branch(then) for branch in branches)))

    def _row(self) -> _Piece:
        """``ABC``, each with its repeat."""
        pieces = list(self._pieces())

        def row(then: int) -> int:
            for piece in reversed(pieces):
                then = piece(then)
            return then

        return row

    def _pieces(self) -> Iterator[_Piece]:
        while self.at < len(self.text) and self.text[self.at] not in "|)":
            piece = self._one()
            while repeat := _REPEAT.match(self.text, self.at):
                if repeat[1].startswith("{") and not (repeat[2] or repeat[4]):
                    break  # {} and {,} are text
                self.at = repeat.end()
                piece = self._repeated(piece, repeat)
            yield piece

    def _one(self) -> _Piece:
        """A group, a character or something that must be here."""
        group = _OPEN.match(self.text, self.at)
        if group is not None:
            self.at = group.end()
            inside = self._choice()
            if not self._takes(")"):
                raise TooDifficultError("a ( is not closed")
            return inside
        for mark, at in _AT.items():
            if self._takes(mark):
                return lambda then, at=at: self._add(_Place(at=at, to=(then,)))  # type: ignore[misc]
        return self._character()

    def _character(self) -> _Piece:
        atom = _ATOM.match(self.text, self.at)
        rest = self.text[self.at : self.at + 4]
        if atom is None or rest[0] in "(*+?":
            raise TooDifficultError(f"{rest!r} at character {self.at + 1} is not understood in a profile")
        self.at = atom.end()
        text = atom[0] if len(atom[0]) > 1 or atom[0] == "." else re.escape(atom[0])
        try:
            with warnings.catch_warnings(action="ignore"):  # of what sets may mean in a later Python
                takes = re.compile(text, re.IGNORECASE)
        except re.error as error:
            raise TooDifficultError(f"{error}") from None
        return lambda then: self._add(_Place(takes=takes, to=(then,)))

    def _repeated(self, piece: _Piece, repeat: re.Match[str]) -> _Piece:
        if repeat[5] == "+":
            raise TooDifficultError(f"{repeat[0]!r} is not understood in a profile")
        least, most = _counts(repeat)
        if most is not None and most < least:
            raise TooDifficultError(f"{repeat[0]!r}: the least is more than the most")

        def repeated(then: int) -> int:
            if most is None:
                loop = self._add(_Place())
                self.places[loop] = _Place(to=(piece(loop), then))
                then = loop
            for _ in range(0 if most is None else most - least):
                then = self._add(_Place(to=(piece(then), then)))
            for _ in range(least):
                begin = piece(then)
                if begin == then:
                    break  # nothing, however often
                then = begin
            return then

        return repeated

    def _takes(self, mark: str) -> bool:
        if not self.text.startswith(mark, self.at):
            return False
        self.at += len(mark)
        return True


def _counts(repeat: re.Match[str]) -> tuple[int, int | None]:
    """How often at least and at most; None: any number."""
    if not repeat[1].startswith("{"):
        return {"*": (0, None), "+": (1, None), "?": (0, 1)}[repeat[1]]
    least = int(repeat[2] or 0)
    if not repeat[3]:
        return least, least
    return least, int(repeat[4]) if repeat[4] else None
