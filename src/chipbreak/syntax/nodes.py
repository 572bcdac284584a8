"""What a block is made of.  Nodes point into the block's own text; nothing is ever printed from them."""

from __future__ import annotations

from collections.abc import Collection

from chipbreak.text.named_tuple import NamedTuple

Operand = "Number | Variable | Operation | Call"


class Number(NamedTuple):
    """A literal number in an expression."""

    value: float


class Variable(NamedTuple):
    """``#101``, ``#<name>`` or an indirect ``#[...]``: ``key`` is the number, the name or an expression."""

    key: int | str | Expression


class Operation(NamedTuple):
    """``left operator right``; a sign in front of something is ``0 - something``."""

    operator: str
    left: Expression
    right: Expression


class Call(NamedTuple):
    """A function such as ``SIN[...]``."""

    function: str
    arguments: tuple[Expression, ...]


Expression = Number | Variable | Operation | Call


class Word(NamedTuple):
    """A letter and its value.  ``start`` and ``end`` are offsets in the text of the block.

    ``letter`` is as written (``f`` is not ``F``).  ``number`` is None where the value is an expression, but
    for a code that is one without variables (``G[60+4]``).
    """

    letter: str
    value_text: str
    number: float | None
    expression: Expression | None
    start: int
    end: int

    @property
    def address(self) -> str:
        """The letter in upper case, as controls read it."""
        return self.letter.upper()

    @property
    def has_point(self) -> bool:
        """True when the number was written with a decimal point."""
        return "." in self.value_text


class Comment(NamedTuple):
    """``text`` is what stands inside ``( )`` or behind ``;``."""

    text: str
    start: int
    end: int


class Assignment(NamedTuple):
    """``#100=[...]``."""

    target: Variable
    value: Expression
    start: int
    end: int


class Control(NamedTuple):
    """A control word: ``IF``, ``WHILE``, ``DO``, ``END``, ``GOTO``, ``THEN``, an o-word, a program name.

    ``keyword`` is upper case; o-words carry ``O-`` (``O-CALL``) and their label in ``label``.
    """

    keyword: str
    label: str
    arguments: tuple[Expression, ...]
    start: int
    end: int


# Controls that only mark a block: they name a program, a path or a spindle, or let a path wait.
MARKS = frozenset({"PROGRAM-NAME", "PROGRAM-NUMBER", "PATH-MARK", "HEAD-MARK", "WAIT-MARK"})


class Block(NamedTuple):
    """One line of a program.

    ``line`` counts from 0.  ``sequence`` is the leading N word.  ``skip`` is the block-delete level (``/``
    is 1) or 0.  ``opaque`` says why the line could not be read; then there are no words.
    """

    line: int
    text: str
    words: tuple[Word, ...] = ()
    comments: tuple[Comment, ...] = ()
    assignments: tuple[Assignment, ...] = ()
    controls: tuple[Control, ...] = ()
    sequence: Word | None = None
    skip: int = 0
    mark: bool = False
    opaque: str = ""
    opaque_column: int = 0

    @property
    def is_empty(self) -> bool:
        """Nothing a control would act on: blank, comment only, or a block number alone."""
        return not (self.words or self.assignments or self.controls or self.opaque)

    @property
    def is_optional(self) -> bool:
        """True where its words may not act: under block delete, or where a condition stands before them."""
        if self.skip:
            return True
        return bool(self.controls and self.words) and any(one.keyword == "IF" for one in self.controls)

    @property
    def marks(self) -> tuple[Control, ...]:
        """Its marks: ``$1``, ``!2L1``, ``:100``."""
        return tuple([control for control in self.controls if control.keyword in MARKS])

    @property
    def statements(self) -> tuple[Control, ...]:
        """Its control words that are no marks: ``IF``, o-words, what a grammar has of its own."""
        return tuple([control for control in self.controls if control.keyword not in MARKS])

    @property
    def has_macro(self) -> bool:
        """True when variables or control words other than marks take part."""
        if self.assignments or (self.controls and self.statements):
            return True
        for word in self.words:  # noqa: SIM110
            if word.expression is not None:
                return True
        return False

    def word(self, address: str) -> Word | None:
        """The last word with this address (upper case), as controls take it."""
        for word in reversed(self.words):
            if word.letter.upper() == address:
                return word
        return None

    def words_of(self, addresses: Collection[str]) -> tuple[Word, ...]:
        """The words with one of these addresses, in the block's order."""
        # The letter itself, here and below: a property costs more than all that is done with it.
        return tuple([word for word in self.words if word.letter.upper() in addresses])

    def has(self, address: str, *numbers: float) -> bool:
        """True with a word of this address; with ``numbers``, only one that is written as one of them.

        >>> Block(0, "M6", (Word("M", "6", 6.0, None, 0, 2),)).has("M", 3, 6)
        True
        """
        # Plain loops: every block of a program is asked such things several times.
        for word in self.words:
            if word.letter.upper() == address and (not numbers or word.number in numbers):
                return True
        return False

    def has_any(self, addresses: Collection[str]) -> bool:
        """True with a word of one of these addresses."""
        for word in self.words:  # noqa: SIM110
            if word.letter.upper() in addresses:
                return True
        return False

    def has_letter(self, letter: str) -> bool:
        """True with a word whose letter is written so: ``f`` is not ``F``."""
        return any(word.letter == letter for word in self.words)

    def number(self, address: str) -> float | None:
        """The number of the last word with this address; None without one, or where it is an expression."""
        word = self.word(address)
        return None if word is None else word.number

    def numbers(self, address: str) -> tuple[float, ...]:
        """All numbers at this address, without expressions: the G codes of a block, or its M codes."""
        return tuple([w.number for w in self.words if w.letter.upper() == address and w.number is not None])

    def text_of(self, word: Word) -> str:
        """A word as it is written."""
        return self.text[word.start : word.end]
