"""The blocks that hand a tool's data to the macros, straight before TOOL CHECK."""

from __future__ import annotations

from dataclasses import dataclass

from chipbreak.dialects import MacroSet
from chipbreak.syntax.numbers import print_number

FLAT, BALL, DRILL, REAMER = 1, 2, 3, 4
_DECIMALS = 4


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

    def blocks(self, macros: MacroSet) -> tuple[str, ...]:
        """The blocks for the programs of a control, none longer than 80 characters."""
        lengths = {
            "diameter_mm": self.diameter_mm,
            "tip": self.tip,
            "length_mm": self.length_mm,
            "holder_mm": self.holder_mm,
            "helix": self.helix_deg,
        }
        texts = {name: print_number(value, _DECIMALS) for name, value in lengths.items()}
        whole = {"tool": self.tool, "kind": self.kind, "teeth": self.teeth}
        return tuple(template.format(**texts, **whole) for template in macros.tool_data)
