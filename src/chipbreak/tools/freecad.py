"""Tools of FreeCAD: tool bits (``.fctb``) and libraries (``.fctl``) that number them.

A bit has no number of its own, so a library is read, which names its bits by file.  Lengths carry their
unit ("6.0000 mm", '0.375 "').  ``Length`` is the overall length, which says nothing about how far the tool
sticks out of its holder, so it is not taken.
"""

from __future__ import annotations

import errno
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, Final

from chipbreak.text.bounds import read_bounded
from chipbreak.tools.cells import decoded
from chipbreak.tools.data import (
    BAD_VALUE,
    CANNOT_OPEN,
    MOST_BYTES,
    NO_FORMAT,
    NO_NUMBER,
    NO_UNIT,
    Errors,
    ToolData,
    ToolFileError,
)
from chipbreak.tools.json_text import json_line, load_json
from chipbreak.tools.reader import Unit
from chipbreak.tools.values import name_of, number_of, type_of
from chipbreak.tools.ways_out import SHAPE_OF_A_FREECAD_ENTRY
from chipbreak.units import MM_PER_INCH

# Opens the file of a bit as a library names it; raises OSError.
Opener = Callable[[str], bytes]

_PARAMETERS: Final = {
    "Diameter": "diameter_mm",
    "CornerRadius": "corner_radius_mm",
    "TorusRadius": "corner_radius_mm",
    "Flutes": "teeth",
    "TipAngle": "point_deg",
}
_QUANTITY: Final = re.compile(r"\s*([-+]?[\d.,]+)\s*(\S*)\s*")
_SCALES: Final = {
    "mm": 1.0,
    "cm": 10.0,
    "m": 1000.0,
    "µm": 0.001,
    "um": 0.001,
    "in": MM_PER_INCH,
    '"': MM_PER_INCH,
    "''": MM_PER_INCH,
}


def read_bit(data: bytes, name: str, _unit: Unit) -> list[ToolData]:
    """A bit alone has no number: always ToolFileError, with the way out."""
    errors = Errors(name, decoded(data))
    load_json(errors)
    errors.stop(NO_NUMBER, "a tool bit has no tool number", "give the library (.fctl) that holds it")


def read_library(data: bytes, name: str, _unit: Unit) -> list[ToolData]:
    """Tools of a library, whose bits are files of their own.  Raises ToolFileError."""
    return read_library_with(name, data, lambda path: _bit_of(Path(name), path))


def read_library_with(name: str, data: bytes, open_bit: Opener) -> list[ToolData]:
    """Tools of a library with its bits from ``open_bit``.  Raises ToolFileError."""
    errors = Errors(name, decoded(data))
    library = load_json(errors)
    entries = library.get("tools") if isinstance(library, dict) else None
    if not isinstance(entries, list):
        errors.stop(NO_FORMAT, 'there is no list "tools" in it', "a library of FreeCAD lists nr and path")
    tools = []
    for index, entry in enumerate(entries):
        tool = _entry(errors, index, entry, open_bit)
        tools += [tool] if tool else []
    errors.raise_if_any()
    return tools


def _bit_of(library: Path, path: str) -> bytes:
    """A bit of a FreeCAD library: beside it, or in the folder ``Bit`` beside its own."""
    if PurePosixPath(path).suffix.lower() != ".fctb":  # a library makes nobody read other files
        raise OSError(errno.EINVAL, "it is no tool bit (.fctb)")
    places = [library.parent / path, library.parent.parent / "Bit" / path]
    for place in places:
        try:
            return read_bounded(place, MOST_BYTES)
        except ValueError:
            break
        except OSError as error:
            if place == places[-1]:
                raise OSError(error.errno, error.strerror or "") from None
    raise FileNotFoundError(2, "no such file")


def _entry(errors: Errors, index: int, entry: Any, open_bit: Opener) -> ToolData | None:
    line = partial(json_line, errors, ("tools", index))  # asked for where something is wrong
    path = entry.get("path") if isinstance(entry, dict) else None
    if not isinstance(path, str) or not path:
        errors.add(NO_FORMAT, f"tools[{index}] names no bit", SHAPE_OF_A_FREECAD_ENTRY, line())
        return None
    if "nr" not in entry:
        errors.add(NO_NUMBER, f"tools[{index}] has no number", SHAPE_OF_A_FREECAD_ENTRY, line())
        return None
    try:
        number = number_of("number", entry["nr"])
        data = open_bit(path)
    except ValueError as error:
        errors.add(BAD_VALUE, f"tools[{index}].nr: {error}", "correct the number in FreeCAD", line())
        return None
    except OSError as error:
        message = f"tools[{index}]: {path[:80]} cannot be read: {error.strerror or 'no such file'}"
        help_text = "bits lie beside the library, or in the folder Bit beside its own"
        errors.add(CANNOT_OPEN, message, help_text, line())
        return None
    try:
        values = _bit_values(PurePosixPath(path).name, data)
    except ToolFileError as error:
        errors.found += error.diagnostics
        return None
    return ToolData.said(int(number), f"{errors.name}, {path[:80]}", values)


def _bit_values(name: str, data: bytes) -> dict[str, Any]:
    errors = Errors(name, decoded(data))
    bit = load_json(errors)
    parameters = bit.get("parameter") if isinstance(bit, dict) else None
    if not isinstance(parameters, dict):
        errors.stop(NO_FORMAT, 'there is no table "parameter" in it', "this is no tool bit of FreeCAD")
    values: dict[str, Any] = {}
    for key, field in _PARAMETERS.items():
        if key in parameters:
            value = _quantity(errors, key, field, parameters[key])
            values[field] = value if value or field == "corner_radius_mm" else None
    if values.get("corner_radius_mm") is None and "FlatRadius" in parameters:
        values["corner_radius_mm"] = _round_corner(
            errors, values.get("diameter_mm"), parameters["FlatRadius"]
        )
    errors.raise_if_any()
    values["type"] = _type(bit)
    label = bit.get("name")
    values["name"] = name_of(label) if isinstance(label, str) else None
    return values


def _round_corner(errors: Errors, diameter_mm: float | None, flat: Any) -> float | None:
    """The corner radius [mm] of a bull nose that is described by the radius of its flat end."""
    flat_mm = _quantity(errors, "FlatRadius", "corner_radius_mm", flat)
    if flat_mm is None or diameter_mm is None:
        return None
    if flat_mm > diameter_mm / 2.0:
        line = json_line(errors, ("parameter", "FlatRadius"))
        message = f"FlatRadius {flat_mm:g} mm is more than half the Diameter {diameter_mm:g} mm"
        errors.add(BAD_VALUE, message, "correct the bit in FreeCAD", line)
        return None
    return diameter_mm / 2.0 - flat_mm


def _type(bit: Mapping[str, Any]) -> str | None:
    """By the kind of shape, or by the file of the shape: ``ballend.fcstd``."""
    for key in ("shape-type", "shape"):
        said = bit.get(key)
        if isinstance(said, str) and said:
            stem = PurePosixPath(said).name.lower().removesuffix(".fcstd")
            return type_of(stem) or name_of(stem)
    return None


def _quantity(errors: Errors, key: str, field: str, value: Any) -> float | int | None:
    """A parameter in mm, or a count; 0 means that nobody entered it."""
    line = json_line(errors, ("parameter", key))
    hit = _QUANTITY.fullmatch(value) if isinstance(value, str) else None
    unit = hit[2] if hit else ""
    text = hit[1].replace(",", ".") if hit else value
    is_length = field.endswith("_mm")
    if hit and is_length and unit not in _SCALES:
        message = f"{key} = {value[:40]!r} has no unit that is known"
        errors.add(NO_UNIT, message, "known: mm, cm, m, in", line)
        return None
    try:
        number = float(text) * (_SCALES[unit] if hit and is_length else 1.0)
        return 0 if number == 0.0 else number_of(field, number)
    except (ValueError, TypeError, OverflowError) as error:
        message = f"{key}: {error}" if isinstance(error, ValueError) else f"{key} is no number"
        errors.add(BAD_VALUE, message, "correct the bit in FreeCAD", line)
        return None
