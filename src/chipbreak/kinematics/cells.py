"""Between which of many rising numbers some others lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats


def cells_of(knots: Floats, values: Floats) -> NDArray[np.intp]:
    """The last knot, of (n,) with n > 1, that is not above each value, (m,); never the last one of all.

    Values that lie near each other are looked for among the knots near them, which then are in the cache.
    """
    low, high = np.searchsorted(knots, [values.min(), values.max()], "right").tolist()
    first = max(low - 1, 0)
    cell = np.searchsorted(knots[first : high + 1], values, "right")
    cell += first - 1
    return np.clip(cell, 0, len(knots) - 2, out=cell)
