"""Controls that smooth what they have interpolated: Fanuc, Mitsubishi and alike without look-ahead.

The interpolator follows the blocks exactly, so every block takes its time; then the filters of the axes take
from each stroke what they do.  Without the numbers of these filters nothing could be promised.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from chipbreak.trajectory.ideal import Ideal


@dataclass(frozen=True)
class AfterInterpolation(Ideal):
    """The blocks exactly, and the axes behind their filters."""

    name: ClassVar[str] = "after-interpolation"
    is_assumed: ClassVar[bool] = False
    needs_filters: ClassVar[bool] = True
