"""What a check has to know about a tool, and who could have said it; never a guess."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from typing import Final

from chipbreak.diagnostics import Diagnostic, Severity
from chipbreak.tools.data import ToolData
from chipbreak.tools.merge import field_words

NOT_GIVEN = "TOL010"


class Check(enum.Enum):
    """The measurements of a tool; the values are what messages call them."""

    RUNOUT = "runout"
    LENGTH = "length"
    DIAMETER = "diameter"
    CHIPPING = "edge"


class Tip(enum.Enum):
    """The lower end of a tool, which says where it is measured."""

    FLAT = "flat"
    BALL = "ball"
    CORNER = "corner radius"
    POINT = "point"
    STANDING = "does not rotate"


_TIPS: Final = {
    "flat end mill": Tip.FLAT,
    "face mill": Tip.FLAT,
    "slot mill": Tip.FLAT,
    "dovetail mill": Tip.FLAT,
    "counter bore": Tip.FLAT,
    "boring head": Tip.FLAT,
    "reamer": Tip.FLAT,
    "ball end mill": Tip.BALL,
    "bull nose end mill": Tip.CORNER,
    "drill": Tip.POINT,
    "spot drill": Tip.POINT,
    "center drill": Tip.POINT,
    "counter sink": Tip.POINT,
    "chamfer mill": Tip.POINT,
    "tap": Tip.POINT,
    "turning tool": Tip.STANDING,
    "boring bar": Tip.STANDING,
    "grooving tool": Tip.STANDING,
    "parting tool": Tip.STANDING,
    "threading tool": Tip.STANDING,
    "probe": Tip.STANDING,
}
_AT_THE_SIDE: Final[Mapping[Tip, tuple[str, ...]]] = {
    Tip.FLAT: ("diameter_mm",),
    Tip.BALL: ("diameter_mm",),
    Tip.CORNER: ("diameter_mm", "corner_radius_mm"),
    Tip.POINT: ("diameter_mm",),
}
# A length is taken at the outer edge of a flat tool, and at the centre of a ball or a point.
_AT_THE_END: Final[Mapping[Tip, tuple[str, ...]]] = {
    Tip.FLAT: ("length_mm", "diameter_mm"),
    Tip.BALL: ("length_mm",),
    Tip.CORNER: ("length_mm", "diameter_mm", "corner_radius_mm"),
    Tip.POINT: ("length_mm",),
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
    "type": "type of a Fusion library, the shape of a FreeCAD bit, or a comment (T2 D=12. - FLAT END MILL)",
    "teeth": "NOF of a Fusion library, Flutes of a FreeCAD bit, or a comment (T2 ... 4 FLUTE)",
    "diameter_mm": "DC of a Fusion library, Diameter of a FreeCAD bit, D of a LinuxCNC table, or a comment",
    "length_mm": "LB of a Fusion library, or a comment (STICKOUT: 42)",
    "corner_radius_mm": "RE of a Fusion library, CornerRadius of a FreeCAD bit, or a comment (... CR=0.5)",
    "helix_deg": "nowhere else: no CAM library stores it",
}


def tip_of(tool: ToolData) -> Tip | None:
    """The lower end of a tool, None where its type does not say."""
    if tool.type == "end mill" and tool.corner_radius_mm is not None:
        if tool.corner_radius_mm == 0.0:
            return Tip.FLAT
        is_ball = tool.diameter_mm is not None and tool.corner_radius_mm * 2.0 >= tool.diameter_mm
        return Tip.BALL if is_ball else Tip.CORNER
    return _TIPS.get(tool.type or "")


def lacking(tool: ToolData, check: Check) -> list[str]:
    """The fields that a check needs and nobody gave."""
    tip = tip_of(tool)
    if tip is Tip.STANDING:
        return []
    known = tool.known()
    if tip is None:
        return ["type", *(field for field in ("diameter_mm",) if field not in known)]
    return [field for field in _NEEDS[check][tip] if field not in known]


def missing(tool: ToolData, check: Check, severity: Severity = Severity.ERROR) -> list[Diagnostic]:
    """A diagnostic for every field that a check needs and nobody gave."""
    return [_diagnostic(tool, check, field, severity) for field in lacking(tool, check)]


def _diagnostic(tool: ToolData, check: Check, field: str, severity: Severity) -> Diagnostic:
    what = f"the {check.value} check of T{tool.number} needs its {field_words(field)}, and nobody gave it"
    if field == "type" and tool.type is not None:
        what = (
            f'the {check.value} check of T{tool.number} cannot tell its lower end from the type "{tool.type}"'
            f" ({tool.origins['type']})"
        )
    help_text = f"give {field} in a tool file (--tools FILE, or files in [tools]); also {_WHERE[field]}"
    return Diagnostic(NOT_GIVEN, severity, what, help_text)
