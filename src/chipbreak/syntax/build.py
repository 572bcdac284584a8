"""From the grammar's tree to a :class:`Block`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from chipbreak.dialects.base import Precedence
from chipbreak.syntax.evaluate import constant
from chipbreak.syntax.expressions import ExpressionReader, finite, is_token, rule_of
from chipbreak.syntax.nodes import MARKS, Assignment, Block, Comment, Control, Expression, Variable, Word

if TYPE_CHECKING:
    from lark import Token, Tree

_O_WORD_SYNONYMS = {"CALLSUB": "CALL"}
_CODE_LETTERS = frozenset("GgMm")
_NO_CODE = 1e6  # no code is such a number
_MACRO_KEYWORDS = {
    "condition": "IF",
    "loop": "WHILE",
    "loop_begin": "DO",
    "loop_end": "END",
    "jump": "GOTO",
    "then": "THEN",
}


class BlockBuilder:
    """Collects the items of one block in the order they stand."""

    def __init__(self, line: int, text: str) -> None:
        self.line, self.text = line, text
        self.words: list[Word] = []
        self.comments: list[Comment] = []
        self.assignments: list[Assignment] = []
        self.controls: list[Control] = []
        self.skip = 0
        self.sequence: Word | None = None

    def add_comment(self, start: int, end: int) -> None:
        """A comment between two offsets, with its marks."""
        inner = self.text[start + 1 : end]
        if self.text[start] == "(" and inner.endswith(")"):
            inner = inner[:-1]
        self.comments.append(Comment(inner, start, end))

    def add_delete(self, text: str, start: int) -> None:
        """A block-delete mark, with the block number that may stand before it."""
        number, _, level = text.partition("/")
        self.skip = int(level or "1")
        if number:
            value = number[1:].strip()
            end = start + len(number.rstrip(" \t"))
            self.sequence = Word(number[0], value, finite(value, start), None, start, end)

    def add_word(self, word: Word) -> None:
        """A word; a leading N is the sequence number, always, also behind marks."""
        first = not (self.words or self.assignments or self.sequence)
        first = first and all(control.keyword in MARKS for control in self.controls)
        if first and word.address == "N" and word.number is not None:
            self.sequence = word
        else:
            self.words.append(word)

    def add_call(self, label: str, arguments: tuple[Expression, ...], start: int, end: int) -> None:
        """A call of a subprogram of LinuxCNC."""
        self.controls.append(Control("O-CALL", label, arguments, start, end))

    def done(self) -> Block:
        """The finished block."""
        return Block(
            self.line,
            self.text,
            tuple(self.words),
            tuple(self.comments),
            tuple(self.assignments),
            tuple(self.controls),
            self.sequence,
            self.skip,
        )


def build_block(tree: Tree[Token], line: int, text: str, precedence: Precedence) -> Block:
    """Turn the tree of one block into a Block."""
    rules = _Rules(BlockBuilder(line, text), ExpressionReader(precedence))
    for node in tree.children:
        if isinstance(node, str):
            rules.add_token(node)
        else:
            rules.add(node)
    return rules.builder.done()


def opaque(line: int, text: str, why: str, column: int) -> Block:
    """A line that could not be read; it prints as it came."""
    return Block(line, text, opaque=why, opaque_column=column)


class _Rules:
    """What each rule of a grammar adds to a block; a rule of another name is a control word of that name."""

    def __init__(self, builder: BlockBuilder, expressions: ExpressionReader) -> None:
        self.builder, self.text, self.expression = builder, builder.text, expressions.read

    def add_token(self, token: Token) -> None:
        """A comment or a block-delete mark."""
        start, end = int(token.start_pos or 0), int(token.end_pos or 0)
        if token.type.endswith("COMMENT"):
            self.builder.add_comment(start, end)
        else:
            self.builder.add_delete(str(token), start)

    def add(self, tree: Tree[Token]) -> None:
        """Any other item."""
        rule = rule_of(tree)
        _ADD.get(rule, _Rules._named)(self, rule, tree.children, tree.meta.start_pos, tree.meta.end_pos)

    def _word(self, rule: str, children: list[Any], start: int, end: int) -> None:
        value_start = children[-1].meta.start_pos  # blanks and a separator may stand before it
        value_text = self.text[value_start:end]
        is_number = rule_of(children[-1]) == "number"
        number = finite(value_text, value_start) if is_number else None
        expression = None if is_number else self.expression(children[-1])
        letter = str(children[0])
        if expression is not None and letter in _CODE_LETTERS:  # G[64] is G64
            value = constant(expression)
            number = value if value is not None and abs(value) < _NO_CODE else None
        self.builder.add_word(Word(letter, value_text, number, expression, start, end))

    def _assignment(self, rule: str, children: list[Any], start: int, end: int) -> None:
        target = self.expression(children[0])
        assert isinstance(target, Variable)
        self.builder.assignments.append(Assignment(target, self.expression(children[1]), start, end))

    def _o_word(self, rule: str, children: list[Any], start: int, end: int) -> None:
        name = children[1]
        label = str(name) if is_token(name) else self.text[name.meta.start_pos : name.meta.end_pos]
        keyword = str(children[2]).upper()
        keyword = "O-" + _O_WORD_SYNONYMS.get(keyword, keyword)
        arguments = tuple(self.expression(node) for node in children[3:])
        self.builder.controls.append(Control(keyword, label, arguments, start, end))

    def _macro(self, rule: str, children: list[Any], start: int, end: int) -> None:
        label = "".join(str(node) for node in children[1:] if is_token(node))
        arguments = tuple(self.expression(node) for node in children if not is_token(node))
        self.builder.controls.append(Control(_MACRO_KEYWORDS[rule], label, arguments, start, end))

    def _named(self, rule: str, children: list[Any], start: int, end: int) -> None:
        """A program name, a program number, a path mark, and what a grammar has of its own."""
        keyword = rule.upper().replace("_", "-")
        self.builder.controls.append(Control(keyword, self.text[start:end], (), start, end))


_ADD: Mapping[str, Callable[[_Rules, str, list[Any], int, int], None]] = {
    "word": _Rules._word,
    "assignment": _Rules._assignment,
    "o_word": _Rules._o_word,
    **dict.fromkeys(_MACRO_KEYWORDS, _Rules._macro),
}
