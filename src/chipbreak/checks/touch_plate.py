"""What a check that is written out in the program must know of the touch plate: fields of its blocks.

The setters of controls that run macros read the same keys of ``[macros]`` in the macro.
"""

from __future__ import annotations

from typing import Final

from chipbreak.settings.sections import Settings
from chipbreak.syntax.numbers import print_number
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import mm_per_unit

_DECIMALS: Final = 4


class TouchPlate(NamedTuple):
    """Where the plate is and how it is touched; lengths in mm, feeds in mm/min.

    ``depth_mm`` is the way from the safe height down to where every tool must have met the plate.
    """

    x_mm: float
    y_mm: float
    safe_z_mm: float
    depth_mm: float
    clear_mm: float
    fast_feed: float
    slow_feed: float

    def texts(self, *, is_inch: bool) -> dict[str, str]:
        """The fields as texts, in units of the program."""
        scale = mm_per_unit(is_inch=is_inch)
        values = (
            self.x_mm,
            self.y_mm,
            self.safe_z_mm,
            self.depth_mm,
            self.clear_mm,
            self.fast_feed,
            self.slow_feed,
        )
        texts = (print_number(value / scale, _DECIMALS) for value in values)
        return dict(zip(PLATE_FIELDS, texts, strict=True))


PLATE_FIELDS: Final = (
    "setter_x", "setter_y", "safe_z", "setter_depth", "clear", "fast_feed", "slow_feed",
)  # fmt: skip


def touch_plate_of(settings: Settings) -> TouchPlate | None:
    """The plate of a profile; None where a key is missing."""
    macros = settings.macros
    x_mm = macros.setter_x_mm
    y_mm = macros.setter_y_mm
    z_mm = macros.setter_z_mm
    safe_z_mm = macros.safe_z_mm
    if x_mm is None or y_mm is None or z_mm is None or safe_z_mm is None:
        return None
    depth_mm = safe_z_mm - z_mm
    return TouchPlate(x_mm, y_mm, safe_z_mm, depth_mm, macros.clear_mm, macros.fast_feed, macros.slow_feed)
