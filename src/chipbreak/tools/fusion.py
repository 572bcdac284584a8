"""Tool libraries of Fusion: JSON with a list ``data``, and ``.tools``, a zip of such files.

``geometry`` holds DC (diameter), NOF (edges), LB (length below the holder), RE (corner radius), SIG (point
angle) and assemblyGaugeLength (LB and the holder above it); ``unit`` is "millimeters" or "inches".  A zero
means what the type does not have.  Fusion stores no helix angle.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from typing import Any, Final

from chipbreak.tools.cells import decoded
from chipbreak.tools.data import BAD_VALUE, MOST_BYTES, NO_FORMAT, NO_UNIT, Errors, ToolData
from chipbreak.tools.json_text import json_line, load_json
from chipbreak.tools.reader import Unit
from chipbreak.tools.values import name_of, number_of, type_of
from chipbreak.tools.ways_out import EXPORT_AGAIN, IS_IT_THE_RIGHT_FILE
from chipbreak.units import MM_PER_INCH

_GEOMETRY: Final = {
    "NOF": "teeth",
    "DC": "diameter_mm",
    "LB": "length_mm",
    "RE": "corner_radius_mm",
    "SIG": "point_deg",
    "assemblyGaugeLength": "gauge_mm",
}
_MOST_MEMBERS: Final = 1000
_UNITS: Final = {"millimeters": 1.0, "inches": MM_PER_INCH}


def read_tools_zip(data: bytes, name: str, unit: Unit) -> list[ToolData]:
    """Tools of a ``.tools`` file.  Raises ToolFileError."""
    errors = Errors(name)
    tools: list[ToolData] = []
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as packed:
            members = [info.filename for info in packed.infolist() if info.filename.endswith(".json")]
            # A few kilobytes can be packed that unpack to gigabytes: all together may be as much as one file.
            texts: list[bytes] = []
            left = MOST_BYTES
            for member in members[: _MOST_MEMBERS + 1]:
                with packed.open(member) as file:
                    texts.append(file.read(left + 1))
                left = max(0, left - len(texts[-1]))
    except Exception as error:  # zipfile raises a dozen kinds for damaged, encrypted and odd archives
        why = str(error) or type(error).__name__
        errors.stop(NO_FORMAT, f"this zip cannot be read: {why[:80]}", EXPORT_AGAIN)
    if not members:
        errors.stop(NO_FORMAT, "there is no .json in this zip", EXPORT_AGAIN)
    if len(members) > _MOST_MEMBERS or sum(map(len, texts)) > MOST_BYTES:
        errors.stop(NO_FORMAT, "what is in it is larger than any library", IS_IT_THE_RIGHT_FILE)
    for member, text in zip(members, texts, strict=True):
        tools += read_fusion(text, f"{name}/{member}", unit)
    return tools


def read_fusion(data: bytes, name: str, _unit: Unit) -> list[ToolData]:
    """Tools of a library as JSON.  Raises ToolFileError."""
    errors = Errors(name, decoded(data))
    library = load_json(errors)
    entries = library.get("data") if isinstance(library, dict) else None
    if not isinstance(entries, list):
        errors.stop(NO_FORMAT, 'there is no list "data" in it', "a library of Fusion holds its tools in data")
    tools = []
    for index, entry in enumerate(entries):
        if not isinstance(entry, dict):
            line = json_line(errors, ("data", index))
            errors.add(NO_FORMAT, f"data[{index}] is no tool", EXPORT_AGAIN, line)
            continue
        post = _table(entry, "post-process")
        if entry.get("type") != "holder" and "number" in post:
            tools += _tool(errors, index, entry, post)
    errors.raise_if_any()
    return tools


def _tool(errors: Errors, index: int, entry: Mapping[str, Any], post: Mapping[str, Any]) -> list[ToolData]:
    """The tool of an entry, or nothing when something in it is wrong."""
    before = len(errors.found)
    number = _number(errors, (index, "post-process", "number"), "number", post["number"])
    scale = _unit_mm(errors, index, entry)
    if scale is None:
        return []
    values = _geometry(errors, index, entry, scale)
    said = entry.get("type")
    if isinstance(said, str):
        values["type"] = type_of(said) or name_of(said.lower())
    text = entry.get("description")
    values["name"] = name_of(text) if isinstance(text, str) else None
    if len(errors.found) > before or number is None:
        return []
    return [ToolData.said(int(number), f"{errors.name}, data[{index}]", values)]


def _unit_mm(errors: Errors, index: int, entry: Mapping[str, Any]) -> float | None:
    """mm per unit of an entry; None, and an error, where its unit is not known."""
    # Older exports have the unit as an expression: "'inches'".
    unit = entry.get("unit", _table(entry, "expressions").get("tool_unit"))
    scale = _UNITS.get(unit.strip("'")) if isinstance(unit, str) else None
    if scale is None:
        line = json_line(errors, ("data", index, "unit"))
        message = f"data[{index}] has no unit that is known"
        errors.add(NO_UNIT, message, f"known: {', '.join(_UNITS)}", line)
    return scale


def _geometry(errors: Errors, index: int, entry: Mapping[str, Any], scale: float) -> dict[str, Any]:
    """The numbers of an entry; a zero is nothing, but a corner radius of zero is a sharp corner."""
    values: dict[str, Any] = {}
    for key, field in _GEOMETRY.items():
        given = _table(entry, "geometry").get(key)
        if given is not None and given != 0:
            factor = scale if field.endswith("_mm") else 1.0
            values[field] = _number(errors, (index, "geometry", key), field, given, factor)
        elif given == 0 and field == "corner_radius_mm":
            values[field] = 0.0
    gauge_mm = values.pop("gauge_mm", None)
    length_mm = values.get("length_mm")
    if gauge_mm and length_mm and gauge_mm > length_mm:  # equal where the library has no holder
        values["holder_mm"] = gauge_mm - length_mm
    return values


def _number(
    errors: Errors, path: tuple[int, str, str], field: str, value: Any, factor: float = 1.0
) -> float | int | None:
    try:
        if isinstance(value, str):
            raise ValueError(f"{field} is text, not a number")
        is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e9
        return number_of(field, value * factor if is_number and factor != 1.0 else value)
    except ValueError as error:
        line = json_line(errors, ("data", *path))
        message = f"data[{path[0]}].{path[1]}.{path[2]}: {error}"
        errors.add(BAD_VALUE, message, "correct the tool in Fusion, and export again", line)
        return None


def _table(entry: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = entry.get(key)
    return value if isinstance(value, dict) else {}
