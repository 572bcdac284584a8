"""The blocks that hand a tool's data to the macros, straight before TOOL CHECK."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from chipbreak.syntax.numbers import print_number

FLAT, BALL, DRILL, REAMER = 1, 2, 3, 4
_DECIMALS = 4

TEMPLATES: Final[Mapping[str, tuple[str, ...]]] = {
    "fanuc-mill": ("G65 P9814 T{tool} K{kind} D{diameter} R{tip} H{length} E{holder} Q{teeth} B{helix}",),
    "linuxcnc-mill": (
        "o<cb_tool> call [{tool}] [{kind}] [{diameter}] [{tip}] [{teeth}] [{helix}]",
        "o<cb_length> call [{tool}] [{length}] [{holder}]",
    ),
}


@dataclass(frozen=True)
class ToolValues:
    """What the macros must know about a tool; lengths in mm, whatever the units of the program.

    ``kind``: FLAT (also a bull nose), BALL, DRILL or REAMER.  ``tip``: corner radius [mm] of FLAT and
    REAMER, point angle [deg] of DRILL, without meaning for BALL.  ``length_mm``: below the holder,
    ``holder_mm``: from the spindle nose to the holder's lower end (0 where the length counts from the nose).
    """

    tool: int
    kind: int
    diameter_mm: float
    tip: float
    length_mm: float
    holder_mm: float
    teeth: int
    helix_deg: float

    def blocks(self, dialect: str) -> tuple[str, ...]:
        """The blocks for a dialect, none longer than 80 characters."""
        numbers = {
            "diameter": self.diameter_mm,
            "tip": self.tip,
            "length": self.length_mm,
            "holder": self.holder_mm,
            "helix": self.helix_deg,
        }
        texts = {name: print_number(value, _DECIMALS) for name, value in numbers.items()}
        whole = {"tool": self.tool, "kind": self.kind, "teeth": self.teeth}
        return tuple(template.format(**texts, **whole) for template in TEMPLATES[dialect])
