"""From the grammar's tree to a :class:`Block`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from chipbreak.syntax.nodes import (
    Assignment,
    Block,
    Call,
    Comment,
    Control,
    Expression,
    Number,
    Operation,
    Variable,
    Word,
)

if TYPE_CHECKING:
    from lark import Token, Tree

DEEPEST = 200
LONGEST_VARIABLE_NUMBER = 15
_O_WORD_SYNONYMS = {"CALLSUB": "CALL"}
_MACRO_KEYWORDS = {
    "condition": "IF",
    "loop": "WHILE",
    "loop_begin": "DO",
    "loop_end": "END",
    "jump": "GOTO",
    "then": "THEN",
}


class UnreadableError(Exception):
    """The grammar reads the line, but what stands at ``column`` is more than can be held."""

    def __init__(self, why: str, column: int) -> None:
        super().__init__(why, column)
        self.why, self.column = why, column


def _rule(tree: Tree[Token]) -> str:
    """The rule's own name: lark puts the name of the importing file in front."""
    return str(tree.data).rsplit("__", 1)[-1]


def _is_token(node: Any) -> bool:
    return isinstance(node, str)


def _float(text: str, column: int) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise UnreadableError("a number has too many digits", column)
    return value


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
            self.sequence = Word(number[0], value, _float(value, start), None, start, end)

    def add_word(self, word: Word) -> None:
        """A word; a leading N is the sequence number, always."""
        first = not (self.words or self.assignments or self.controls or self.sequence)
        if first and word.address == "N" and word.number is not None:
            self.sequence = word
        else:
            self.words.append(word)

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


def build_block(tree: Tree[Token], line: int, text: str) -> Block:
    """Turn the tree of one block into a Block."""
    builder = BlockBuilder(line, text)
    for node in tree.children:
        if isinstance(node, str):
            start, end = _ends(node)
            if node.type.endswith("COMMENT"):
                builder.add_comment(start, end)
            else:
                builder.add_delete(str(node), start)
            continue
        _add_rule(builder, node, text)
    return builder.done()


def opaque(line: int, text: str, why: str, column: int) -> Block:
    """A line that could not be read; it prints as it came."""
    return Block(line, text, opaque=why, opaque_column=column)


def _ends(node: Token) -> tuple[int, int]:
    return int(node.start_pos or 0), int(node.end_pos or 0)


def _add_rule(builder: BlockBuilder, tree: Tree[Token], text: str) -> None:
    start, end = tree.meta.start_pos, tree.meta.end_pos
    rule = _rule(tree)
    children: list[Any] = tree.children
    if rule == "word":
        value_start = children[1].meta.start_pos  # blanks may stand between the letter and its value
        value_text = text[value_start:end]
        number = _float(value_text, value_start) if _rule(children[1]) == "number" else None
        expression = None if number is not None else _expression(children[1])
        builder.add_word(Word(str(children[0]), value_text, number, expression, start, end))
    elif rule == "assignment":
        target = _expression(children[0])
        assert isinstance(target, Variable)
        builder.assignments.append(Assignment(target, _expression(children[1]), start, end))
    elif rule == "o_word":
        name = children[1]
        label = str(name) if _is_token(name) else text[name.meta.start_pos : name.meta.end_pos]
        keyword = str(children[2]).upper()
        keyword = "O-" + _O_WORD_SYNONYMS.get(keyword, keyword)
        arguments = tuple(_expression(node) for node in children[3:])
        builder.controls.append(Control(keyword, label, arguments, start, end))
    elif rule in _MACRO_KEYWORDS:
        trees = [node for node in children if not _is_token(node)]
        label = "".join(str(node) for node in children[1:] if _is_token(node))
        arguments = tuple(_expression(node) for node in trees)
        builder.controls.append(Control(_MACRO_KEYWORDS[rule], label, arguments, start, end))
    else:  # program_name, program_number, path_mark
        builder.controls.append(Control(rule.upper().replace("_", "-"), text[start:end], (), start, end))


def _expression(node: Any, depth: int = 0) -> Expression:
    """An expression node; brackets group and leave no trace.

    The depth is bounded so that whoever walks the expression can do it by recursion.
    """
    rule = _rule(node)
    while rule in ("expression", "bracket"):
        node = node.children[0]
        rule = _rule(node)
    if depth > DEEPEST:
        raise UnreadableError("it is nested too deeply", node.meta.start_pos)
    children, inner = node.children, depth + 1
    if rule == "number":
        return Number(_float(children[0], node.meta.start_pos))
    if rule == "signed":
        value = _expression(children[1], inner)
        return value if children[0] == "+" else Operation("-", Number(0.0), value)
    if rule == "variable":
        key = children[0]
        if not _is_token(key):
            return Variable(_expression(key, inner))
        if key.startswith("<"):
            return Variable(key[1:-1].replace(" ", "").replace("\t", "").lower())
        if len(key) > LONGEST_VARIABLE_NUMBER:
            raise UnreadableError("a variable number has too many digits", node.meta.start_pos)
        return Variable(int(key))
    if rule == "arc_tangent":
        return Operation(
            "/", Call("ATAN", (_expression(children[1], inner),)), _expression(children[2], inner)
        )
    if rule == "call":
        return Call(str(children[0]).upper(), tuple(_expression(c, inner) for c in children[1:]))
    left, operator, right = children
    return Operation(str(operator).upper(), _expression(left, inner), _expression(right, inner))
