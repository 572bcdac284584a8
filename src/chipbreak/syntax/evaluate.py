"""Constant expressions.  A variable has no value here: it is known only when the machine runs."""

from __future__ import annotations

import math
from collections.abc import Callable

from chipbreak.syntax.nodes import Call, Expression, Number, Operation, Variable


def round_half(value: float) -> float:
    """ROUND: to the nearest whole number, halves away from zero."""
    return math.copysign(math.floor(abs(value) + 0.5), value)


# What every control works out in the same way; the macro interpreter adds what its control has beside.
OPERATORS: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "**": lambda a, b: a**b,
    "MOD": lambda a, b: math.fmod(a, b) if a >= 0.0 and b > 0.0 else math.nan,
    "EQ": lambda a, b: float(a == b),
    "NE": lambda a, b: float(a != b),
    "GT": lambda a, b: float(a > b),
    "GE": lambda a, b: float(a >= b),
    "LT": lambda a, b: float(a < b),
    "LE": lambda a, b: float(a <= b),
}
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda a: math.sin(math.radians(a)),
    "COS": lambda a: math.cos(math.radians(a)),
    "TAN": lambda a: math.tan(math.radians(a)),
    "ASIN": lambda a: math.degrees(math.asin(a)),
    "ACOS": lambda a: math.degrees(math.acos(a)),
    "SQRT": math.sqrt,
    "SQR": math.sqrt,
    "ABS": abs,
    "ROUND": round_half,
    "RND": round_half,
    "LN": math.log,
    "EXP": math.exp,
}


def constant(expression: Expression) -> float | None:
    """The value of an expression without variables, or None when there is none.

    What depends on the control is left out: FIX and FUP (Fanuc rounds toward and away from zero, LinuxCNC
    down and up), AND, OR and XOR (bits on Fanuc, and of another precedence), MOD of negative values.
    Division by zero and roots of negative numbers have no value either.
    """
    try:
        value = _value(expression)
    except (ArithmeticError, ValueError, RecursionError):
        return None
    if not isinstance(value, float) or not math.isfinite(value):
        return None
    return value


def _value(expression: Expression) -> float | None:
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Variable):
        return None
    if isinstance(expression, Call):
        return _call(expression)
    quotient = _arc_tangent(expression)
    if quotient is not None:
        return quotient
    left = _value(expression.left)
    right = _value(expression.right)
    if left is None or right is None:
        return None
    operator = OPERATORS.get(expression.operator)
    return operator(left, right) if operator else None


def _call(call: Call) -> float | None:
    arguments = [_value(argument) for argument in call.arguments]
    function = FUNCTIONS.get(call.function)
    if function is None or len(arguments) != 1 or arguments[0] is None:
        return None
    return function(arguments[0])


def _arc_tangent(expression: Operation) -> float | None:
    """``ATAN[y]/[x]``: the angle of a point in degrees, a division only to the grammar."""
    left = expression.left
    if expression.operator != "/" or not isinstance(left, Call) or left.function != "ATAN":
        return None
    y = _value(left.arguments[0])
    x = _value(expression.right)
    return None if x is None or y is None else math.degrees(math.atan2(y, x))
