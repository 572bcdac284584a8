"""What a check has to know about a tool, and where it could be given; never a guess."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Final

from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.tools.data import ToolData
from chipbreak.tools.merge import field_words
from chipbreak.tools.tips import Tip, tip_of

NOT_GIVEN = "TOL010"


class Check(enum.Enum):
    """The measurements of a tool; the values are what messages call them."""

    RUNOUT = "runout"
    LENGTH = "length"
    DIAMETER = "diameter"
    CHIPPING = "edge"


_AT_THE_SIDE: Final[Mapping[Tip, tuple[str, ...]]] = {
    Tip.FLAT: ("diameter_mm",),
    Tip.BALL: ("diameter_mm",),
    Tip.CORNER: ("diameter_mm", "corner_radius_mm"),
    Tip.POINT: ("diameter_mm", "point_deg"),
}
# A length is taken at the outer edge of a flat tool, and at the centre of a ball or a point.
_AT_THE_END: Final[Mapping[Tip, tuple[str, ...]]] = {
    Tip.FLAT: ("length_mm", "holder_mm", "diameter_mm"),
    Tip.BALL: ("length_mm", "holder_mm"),
    Tip.CORNER: ("length_mm", "holder_mm", "diameter_mm"),
    Tip.POINT: ("length_mm", "holder_mm"),
}
_OF_AN_EDGE: Final = ("teeth", "diameter_mm", "helix_deg")
_NEEDS: Final[Mapping[Check, Mapping[Tip, tuple[str, ...]]]] = {
    Check.RUNOUT: _AT_THE_SIDE,
    Check.LENGTH: _AT_THE_END,
    Check.DIAMETER: _AT_THE_SIDE,
    Check.CHIPPING: dict.fromkeys(_AT_THE_SIDE, _OF_AN_EDGE),
}
# Where each field is given, beside the column of that name in a CSV or TOML file.
_WHERE: Final = {
    "type": "; also type of a Fusion library, the shape of a FreeCAD bit, or a comment (T2 - FLAT END MILL)",
    "teeth": "; also NOF of a Fusion library, Flutes of a FreeCAD bit, or a comment (T2 ... 4 FLUTE)",
    "diameter_mm": "; also DC of a Fusion library, Diameter of a FreeCAD bit, D of a tool table, or comments",
    "length_mm": "; also LB of a Fusion library, or a comment (STICKOUT: 42)",
    "corner_radius_mm": "; also RE of a Fusion library, CornerRadius of a FreeCAD bit, or a comment (CR=0.5)",
    "helix_deg": "; no CAM library stores it",
    "point_deg": "; also SIG of a Fusion library, TipAngle of a FreeCAD bit, or a comment (... TAPER=118DEG)",
    "holder_mm": "; also the gauge length of a Fusion library, or a comment (HOLDER LENGTH: 70)",
}


def lacking(tool: ToolData, check: Check) -> list[str]:
    """The fields that a check needs and nobody gave."""
    tip = tip_of(tool)
    if tip in (Tip.STANDING, Tip.NO_EDGE):
        return []
    known = tool.known()
    if tip is None:
        return ["type", *(field for field in ("diameter_mm",) if field not in known)]
    return [field for field in _NEEDS[check][tip] if field not in known]


def missing(tool: ToolData, check: Check, severity: Severity = Severity.ERROR) -> list[Diagnostic]:
    """A diagnostic for every field that a check needs and nobody gave."""
    what = f"the {check.value} check"
    return [not_given(tool, what, field, severity) for field in lacking(tool, check)]


def not_given(tool: ToolData, check: str, field: str, severity: Severity) -> Diagnostic:
    """What to say about a field that a check needs and nobody gave."""
    what = f"{check} of T{tool.number} needs its {field_words(field)}, and nobody gave it"
    if field == "type" and tool.type is not None:
        what = (
            f'{check} of T{tool.number} cannot tell its lower end from the type "{tool.type}"'
            f" ({tool.origins['type']})"
        )
    help_text = f"give {field} in a tool file (--tools FILE, or files in [tools]){_WHERE[field]}"
    return Diagnostic(NOT_GIVEN, severity, what, help_text)
