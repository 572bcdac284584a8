"""The lower end of a tool by its type: it says where the tool is measured, and with which fields."""

from __future__ import annotations

import enum
from typing import Final

from chipbreak.tools.data import ToolData


class Tip(enum.Enum):
    """The lower end of a tool, which says where it is measured."""

    FLAT = "flat"
    BALL = "ball"
    CORNER = "corner radius"
    POINT = "point"
    STANDING = "does not rotate"
    NO_EDGE = "has no edge"


_TIPS: Final = {
    "flat end mill": Tip.FLAT,
    "face mill": Tip.CORNER,
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
    "probe": Tip.NO_EDGE,
    "chip fan": Tip.NO_EDGE,
    "air nozzle": Tip.NO_EDGE,
}


def tip_of_type(type_name: str | None) -> Tip | None:
    """The lower end that a type has, None where the type does not say."""
    return _TIPS.get(type_name or "")


def tip_of(tool: ToolData) -> Tip | None:
    """The lower end of a tool, None where its type does not say."""
    if tool.type == "end mill" and tool.corner_radius_mm is not None:
        if tool.corner_radius_mm == 0.0:
            return Tip.FLAT
        is_ball = tool.diameter_mm is not None and tool.corner_radius_mm * 2.0 >= tool.diameter_mm
        return Tip.BALL if is_ball else Tip.CORNER
    return tip_of_type(tool.type)
