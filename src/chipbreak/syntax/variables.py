"""Which variables a program names."""

from __future__ import annotations

from collections.abc import Iterator

from chipbreak.syntax.nodes import Block, Call, Expression, Operation, Variable


def variables_of(block: Block) -> Iterator[int | str | None]:
    """Numbers and names (in lower case) of the variables in a block; None for one that is worked out."""
    expressions = [word.expression for word in block.words if word.expression is not None]
    for assignment in block.assignments:
        expressions += [assignment.target, assignment.value]
    for control in block.controls:
        expressions += control.arguments
    for expression in expressions:
        yield from variables_in(expression)


def variables_in(expression: Expression) -> Iterator[int | str | None]:
    """The same of one expression."""
    waiting = [expression]
    while waiting:
        one = waiting.pop()
        if isinstance(one, Variable):
            if isinstance(one.key, int):
                yield one.key
            elif isinstance(one.key, str):
                yield one.key.lower()
            else:
                yield None
                waiting.append(one.key)
        elif isinstance(one, Call):
            waiting += one.arguments
        elif isinstance(one, Operation):
            waiting += (one.left, one.right)
