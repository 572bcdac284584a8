"""From the grammar's tree of an expression to its nodes, in the order in which the control works it out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from chipbreak.dialects.base import Precedence
from chipbreak.syntax.nodes import Call, Expression, Number, Operation, Variable
from chipbreak.text.named_tuple import NamedTuple

if TYPE_CHECKING:
    from lark import Token, Tree

DEEPEST = 200
LONGEST_VARIABLE_NUMBER = 15


class UnreadableError(Exception):
    """The grammar reads the line, but what stands at ``column`` is more than can be held."""

    def __init__(self, why: str, column: int) -> None:
        super().__init__(why, column)
        self.why, self.column = why, column


def rule_of(tree: Tree[Token]) -> str:
    """The rule's own name: lark puts the name of the importing file in front."""
    return str(tree.data).rsplit("__", 1)[-1]


def is_token(node: Any) -> bool:
    """True for a token, False for a tree."""
    return isinstance(node, str)


_TOO_LARGE = 1e255  # more than a line of plain words can hold; a thousand times it is a float


def finite(text: str, column: int) -> float:
    """The number of a text; raises UnreadableError where a float cannot hold it, or a multiple of it."""
    value = float(text)
    if not abs(value) < _TOO_LARGE:
        raise UnreadableError("a number has too many digits", column)
    return value


class _Pair(NamedTuple):
    """Two operands that belong together, and the column where the left one starts."""

    operator: str
    left: Any
    right: Any
    start: int


@lru_cache
def _strengths(precedence: Precedence) -> Mapping[str, int]:
    """Operator -> how strongly it binds."""
    weakest_first = enumerate(reversed(precedence))
    return {operator: strength for strength, operators in weakest_first for operator in operators}


class ExpressionReader:
    """Reads the expressions of a control with this precedence; equals are worked out from left to right."""

    def __init__(self, precedence: Precedence) -> None:
        self.strengths = _strengths(precedence)

    def read(self, node: Any, depth: int = 0) -> Expression:
        """An expression node; brackets group and leave no trace.

        The depth is bounded so that whoever walks the expression can do it by recursion.  Raises
        UnreadableError.
        """
        while not isinstance(node, _Pair) and rule_of(node) in ("expression", "bracket"):
            node = self._grouped(node.children)
        start = node.start if isinstance(node, _Pair) else node.meta.start_pos
        if depth > DEEPEST:
            raise UnreadableError("it is nested too deeply", start)
        if isinstance(node, _Pair):
            left, right = (self.read(one, depth + 1) for one in (node.left, node.right))
            return Operation(node.operator, left, right)
        return _READ[rule_of(node)](self, node.children, depth + 1, start)

    def _grouped(self, row: list[Any]) -> Any:
        """The flat row of operands and operators as pairs."""
        operands = [row[0]]
        operators: list[str] = []
        for operator, operand in zip(row[1::2], row[2::2], strict=True):
            name = operator.upper()
            if name not in self.strengths:
                raise UnreadableError(f"this control has no operator {name}", operator.start_pos)
            self._join(operands, operators, self.strengths[name])
            operators.append(name)
            operands.append(operand)
        self._join(operands, operators, 0)
        return operands[0]

    def _join(self, operands: list[Any], operators: list[str], weakest: int) -> None:
        """Join what binds at least so strongly, from the right end on."""
        while operators and self.strengths[operators[-1]] >= weakest:
            right = operands.pop()
            left = operands.pop()
            start = left.start if isinstance(left, _Pair) else left.meta.start_pos
            operands.append(_Pair(operators.pop(), left, right, start))

    def _number(self, children: list[Any], depth: int, start: int) -> Expression:
        return Number(finite(children[0], start))

    def _signed(self, children: list[Any], depth: int, start: int) -> Expression:
        value = self.read(children[1], depth)
        return value if children[0] == "+" else Operation("-", Number(0.0), value)

    def _variable(self, children: list[Any], depth: int, start: int) -> Expression:
        key = children[0]
        if not is_token(key):
            return Variable(self.read(key, depth))
        if key.startswith("<"):
            return Variable(key[1:-1].replace(" ", "").replace("\t", "").lower())
        if len(key) > LONGEST_VARIABLE_NUMBER:
            raise UnreadableError("a variable number has too many digits", start)
        return Variable(int(key))

    def _arc_tangent(self, children: list[Any], depth: int, start: int) -> Expression:
        angle = Call("ATAN", (self.read(children[1], depth),))
        return Operation("/", angle, self.read(children[2], depth))

    def _call(self, children: list[Any], depth: int, start: int) -> Expression:
        return Call(str(children[0]).upper(), tuple(self.read(child, depth) for child in children[1:]))


_READ: Mapping[str, Callable[[ExpressionReader, list[Any], int, int], Expression]] = {
    "number": ExpressionReader._number,
    "signed": ExpressionReader._signed,
    "variable": ExpressionReader._variable,
    "arc_tangent": ExpressionReader._arc_tangent,
    "call": ExpressionReader._call,
}
