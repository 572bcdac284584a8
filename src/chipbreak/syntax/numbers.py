"""The only place that prints numbers.

``X1.0``, ``X1.`` and ``X1`` may differ on a control, so a number that was read keeps its text and a new
one is printed with fixed decimals, the point kept, no exponent, no ``-0``.
"""

from __future__ import annotations

import math


def print_number(value: float, decimals: int, *, point: bool = True) -> str:
    """Print a number the way NC programs write it: ``X20.``, ``X-0.5``, ``S2500`` (``point=False``).

    >>> print_number(20.0, 3), print_number(-0.50004, 3), print_number(-0.0001, 3)
    ('20.', '-0.5', '0.')
    >>> print_number(2500.0, 0, point=False), print_number(2586.2, 1, point=False)
    ('2500', '2586.2')
    """
    if not math.isfinite(value):
        raise ValueError(f"{value} cannot be written in a program")
    text = f"{value:.{decimals}f}"
    if "." in text:
        text = text.rstrip("0")
    if text.strip("-0.") == "":
        text = "0." if point else "0"
    if point:
        return text if "." in text else text + "."
    return text.removesuffix(".")
