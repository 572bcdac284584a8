"""What expressions are worth on Fanuc, where a variable may be vacant."""

from __future__ import annotations

import math
from collections.abc import Callable
from operator import and_, or_, xor

from chipbreak.syntax.evaluate import FUNCTIONS, OPERATORS
from chipbreak.syntax.nodes import Call, Expression, Number, Operation, Variable
from macro_interpreter.faults import ARITHMETIC, UNREADABLE, VARIABLE, fault

Value = float | None
Read = Callable[[int], Value]


def evaluate(expression: Expression, read: Read) -> Value:
    """The value of an expression; None is the vacant ``#0``.

    Vacant alone stays vacant; in arithmetic it is 0.  ``EQ`` and ``NE`` tell vacant from 0, the other
    comparisons do not.
    """
    if isinstance(expression, Variable):
        return read(variable_number(expression, read))
    if isinstance(expression, Number):
        return expression.value
    if isinstance(expression, Call):
        return _call(expression, read)
    if _is_arc_tangent(expression):
        assert isinstance(expression.left, Call)
        return _angle(_number(expression.left.arguments[0], read), _number(expression.right, read))
    left, right = evaluate(expression.left, read), evaluate(expression.right, read)
    if expression.operator in ("EQ", "NE"):
        is_same = left is right if left is None or right is None else left == right
        return float(is_same == (expression.operator == "EQ"))
    return _operate(expression.operator, left or 0.0, right or 0.0)


def variable_number(variable: Variable, read: Read) -> int:
    """The number of ``#1``, ``##1`` or ``#[...]``."""
    key = variable.key
    if isinstance(key, int):
        return key
    if isinstance(key, str):
        raise fault(VARIABLE, f"#<{key}>: this control has no variables with names")
    value = evaluate(key, read)
    number = round(value or 0.0)
    if value is None or abs(value - number) > 1e-4:
        raise fault(VARIABLE, f"#[{value}]: the number of a variable must be whole")
    return number


def _is_arc_tangent(node: Operation) -> bool:
    if node.operator != "/":
        return False
    left = node.left
    return isinstance(left, Call) and left.function == "ATAN" and len(left.arguments) == 1


def _number(expression: Expression, read: Read) -> float:
    return evaluate(expression, read) or 0.0


_LOGIC_OPERATORS: dict[str, Callable[[int, int], int]] = {"AND": and_, "OR": or_, "XOR": xor}


def _operate(operator: str, left: float, right: float) -> float:
    if operator in ("/", "MOD") and right == 0.0:
        raise fault(ARITHMETIC, "division by zero")
    if operator == "MOD":
        return math.fmod(left, right)
    if operator in _LOGIC_OPERATORS:
        return float(_LOGIC_OPERATORS[operator](round(left), round(right)))
    if operator not in OPERATORS or operator == "**":
        raise fault(UNREADABLE, f"{operator} is no operator of this control")
    return OPERATORS[operator](left, right)


def _angle(y: float, x: float) -> float:
    """``ATAN[y]/[x]``: 0 to 360 degrees."""
    return math.degrees(math.atan2(y, x)) % 360.0


_FUNCTIONS: dict[str, Callable[..., float]] = {
    **FUNCTIONS,
    "FIX": lambda a: float(math.trunc(a)),
    "FUP": lambda a: math.copysign(math.ceil(abs(a)), a),
    "POW": math.pow,
    "BIN": lambda a: float(int(str(round(a)), 10)) if a < 0 else float(int(f"{round(a):x}", 10)),
    "BCD": lambda a: float(int(str(round(a)), 16)),
    "ADP": lambda a: a,
}


def _call(call: Call, read: Read) -> float:
    arguments = [_number(argument, read) for argument in call.arguments]
    if call.function == "ATAN":
        return _angle(*arguments) if len(arguments) == 2 else math.degrees(math.atan(arguments[0]))
    function = _FUNCTIONS.get(call.function)
    if function is None or len(arguments) != 1 + (call.function == "POW"):
        raise fault(UNREADABLE, f"{call.function} with {len(arguments)} arguments is no function here")
    try:
        return function(*arguments)
    except (ArithmeticError, ValueError):
        values = ", ".join(f"{value:g}" for value in arguments)
        raise fault(ARITHMETIC, f"{call.function}[{values}] has no value") from None
