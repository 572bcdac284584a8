"""The fields of a call that say something about the tool, as texts; and which field gives a missing one.

``{kind}`` and ``{tip}`` are how the macros sort tools: kind 1 flat or bull nose, 2 ball, 3 drill, 4 reamer;
tip is a corner radius [mm], or the point angle [deg] of kind 3.
"""

from __future__ import annotations

from typing import Final

from chipbreak.syntax.numbers import print_number
from chipbreak.tools.data import ToolData
from chipbreak.tools.tips import Tip, tip_of
from chipbreak.units import mm_per_unit

_LENGTHS: Final = {
    "diameter": "diameter_mm",
    "length": "length_mm",
    "corner_radius": "corner_radius_mm",
    "holder": "holder_mm",
}
_ANGLES: Final = {"helix": "helix_deg", "point": "point_deg"}
_KINDS: Final = {Tip.FLAT: 1, Tip.CORNER: 1, Tip.BALL: 2, Tip.POINT: 3}
_REAMER: Final = 4
DATA_FIELDS: Final = (
    "type",
    "kind",
    "teeth",
    "tip",
    *_ANGLES,
    *(name + unit for name in _LENGTHS for unit in ("", "_mm")),
)
_DECIMALS: Final = 4
_INCH_DECIMALS: Final = 5
_DEGREE_DECIMALS: Final = 2


def data_texts(tool: ToolData, *, is_inch: bool) -> dict[str, str]:
    """The texts of all fields that are known; lengths without ``_mm`` are in program units."""
    return {**_lengths(tool, is_inch), **_angles(tool), **_type_and_teeth(tool), **_kind_and_tip(tool)}


def _lengths(tool: ToolData, is_inch: bool) -> dict[str, str]:
    texts: dict[str, str] = {}
    for name, field in _LENGTHS.items():
        value_mm = getattr(tool, field)
        if value_mm is not None:
            texts[f"{name}_mm"] = print_number(value_mm, _DECIMALS)
            inches = print_number(value_mm / mm_per_unit(is_inch=True), _INCH_DECIMALS)
            texts[name] = inches if is_inch else texts[f"{name}_mm"]
    return texts


def _angles(tool: ToolData) -> dict[str, str]:
    values_deg = {name: getattr(tool, field) for name, field in _ANGLES.items()}
    return {name: print_number(deg, _DEGREE_DECIMALS) for name, deg in values_deg.items() if deg is not None}


def _type_and_teeth(tool: ToolData) -> dict[str, str]:
    texts: dict[str, str] = {}
    if tool.type is not None:
        texts["type"] = tool.type.upper()
    if tool.teeth is not None:
        texts["teeth"] = str(tool.teeth)
    return texts


def _kind_and_tip(tool: ToolData) -> dict[str, str]:
    tip = tip_of(tool)
    if tip not in _KINDS:
        return {}
    texts = {"kind": str(_REAMER if tool.type == "reamer" else _KINDS[tip])}
    value = _tip_value(tool, tip)
    return texts if value is None else {**texts, "tip": print_number(value, _DECIMALS)}


def _tip_value(tool: ToolData, tip: Tip) -> float | None:
    if tip is Tip.POINT:
        return tool.point_deg
    # A flat end is one without a radius; one that is given all the same is believed.
    return 0.0 if tip is Tip.FLAT and tool.corner_radius_mm is None else tool.corner_radius_mm


def source_field(name: str, tool: ToolData) -> str:
    """The field of the tool data that is missing when a field of a call has no value."""
    if name in ("type", "teeth"):
        return name
    tip = tip_of(tool)
    if name in ("kind", "tip"):
        if tip is None or name == "kind":
            return "type"
        return {Tip.POINT: "point_deg", Tip.BALL: "diameter_mm"}.get(tip, "corner_radius_mm")
    return _LENGTHS.get(name.removesuffix("_mm")) or _ANGLES[name]
