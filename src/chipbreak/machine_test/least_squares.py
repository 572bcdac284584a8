"""Least squares in a few numbers above zero: Levenberg's way with Marquardt's scale, on their logarithms."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple

_STEP = 1e-3  # a smaller one is lost in how well the begin of a group is known
_LONGEST = 0.7  # of one step of a logarithm
_ENOUGH = 1e-6
_FIRST_DAMPING = 1e-2
_LEAST_DAMPING = 1e-9
_MOST_DAMPING = 1e6
_LEAST, _MOST = -30.0, 30.0


class Solution(NamedTuple):
    """The numbers, (p,), the sum of squares there, and the derivatives of what is left, (n, p)."""

    numbers: Floats
    squares: float
    slopes: Floats


def least_squares(
    residuals: Callable[[Floats], Floats], start: Sequence[float], rounds: int = 30
) -> Solution:
    """The numbers near ``start`` that make the residuals, (n,), smallest; their slopes are per logarithm."""
    at = np.log(np.asarray(start, dtype=np.float64))
    left = residuals(np.exp(at))
    slopes = _slopes(residuals, at, left)
    damping = _FIRST_DAMPING
    for _ in range(rounds):
        squares = float(left @ left)
        step, tried = _step(residuals, at, left, slopes, damping)
        gained = squares - float(tried @ tried)
        if not gained > 0.0:
            damping *= 8.0
            if damping > _MOST_DAMPING:
                break
            continue
        at = at + step
        left = tried
        damping = max(damping / 6.0, _LEAST_DAMPING)
        if gained < _ENOUGH * squares:
            break
        slopes = _slopes(residuals, at, left)
    return Solution(np.exp(at), float(left @ left), slopes)


def _step(
    residuals: Callable[[Floats], Floats], at: Floats, left: Floats, slopes: Floats, damping: float
) -> tuple[Floats, Floats]:
    square = slopes.T @ slopes
    scaled = square + damping * np.diag(np.maximum(np.diag(square), 1e-12))
    step = np.linalg.lstsq(scaled, -slopes.T @ left, rcond=None)[0]
    longest = float(np.abs(step).max(initial=0.0))
    taken: Floats = np.clip(at + step * min(1.0, _LONGEST / max(longest, 1e-12)), _LEAST, _MOST) - at
    return taken, residuals(np.exp(at + taken))


def _slopes(residuals: Callable[[Floats], Floats], at: Floats, left: Floats) -> Floats:
    slopes = np.empty((len(left), len(at)))
    for column in range(len(at)):
        moved = at.copy()
        moved[column] += _STEP
        slopes[:, column] = (residuals(np.exp(moved)) - left) / _STEP
    return slopes
