"""Our own lists of tools, CSV and TOML, and traced edges as CSV.

::

    number,type,teeth,diameter_mm,length_mm,corner_radius_mm,helix_deg,name
    2,flat end mill,4,12,38,0,45,finisher

    [[tool]]
    number = 2
    type = "flat end mill"
    teeth = 4
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.cells import Row, check_lines, decoded, rows
from chipbreak.tools.data import BAD_VALUE, FIELDS, NO_FORMAT, NO_NUMBER, UNKNOWN_KEY, Errors, ToolData
from chipbreak.tools.reader import Unit
from chipbreak.tools.values import TYPES, hint_at, name_of, number_of, type_of
from chipbreak.tools.ways_out import SHAPE_OF_A_TOML_TOOL

_REQUIRED = ("number", "type", "teeth", "diameter_mm", "length_mm")
_OPTIONAL = tuple(field for field in FIELDS if field not in _REQUIRED)
_KEYS = (*_REQUIRED, *_OPTIONAL)


def read_csv(data: bytes, name: str, _unit: Unit) -> list[ToolData]:
    """Tools of a CSV table; an empty cell is not said.  Raises ToolFileError."""
    errors = Errors(name, decoded(data))
    tools = []
    for row in rows(errors, _REQUIRED, _OPTIONAL):
        if "number" not in row.cells:
            errors.add(NO_NUMBER, "this row has no tool number", "the column number names the tool", row.line)
            continue
        values: dict[str, Any] = {}
        for key, cell in row.cells.items():
            try:
                values[key] = _value(key, cell.text)
            except ValueError as error:
                errors.add(BAD_VALUE, str(error), _help(key, cell.text), row.line, cell[1:])
        if "number" in values:
            tools.append(ToolData.said(values.pop("number"), f"{name}, line {row.line}", values))
    errors.raise_if_any()
    return tools


def read_toml(data: bytes, name: str, _unit: Unit) -> list[ToolData]:
    """Tools of a TOML file with ``[[tool]]`` tables.  Raises ToolFileError."""
    errors = Errors(name, decoded(data))
    check_lines(errors)
    text = "\n".join(errors.lines)
    try:
        given = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number of thousands of digits is none
        where = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(where[1]), int(where[2]) - 1) if where else (1, 0)
        why = str(error).split(" (at", maxsplit=1)[0].lower()
        errors.stop(NO_FORMAT, f"this is not TOML: {why}", SHAPE_OF_A_TOML_TOOL, line,
                    (column, column + 1))  # fmt: skip
    places = _Places.of(errors.lines)
    entries = given.get("tool")
    for key in given:
        if key != "tool":
            errors.add(
                UNKNOWN_KEY, f"there is no key {key[:40]}", SHAPE_OF_A_TOML_TOOL, _line_of(places, key)
            )
    if not (isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries)):
        errors.stop(NO_FORMAT, "there is no [[tool]] in it", SHAPE_OF_A_TOML_TOOL)
    tools = []
    for index, entry in enumerate(entries):
        tool = _toml_tool(errors, places, index, entry)
        tools += [tool] if tool else []
    errors.raise_if_any()
    return tools


def _toml_tool(errors: Errors, places: _Places, index: int, entry: Mapping[str, Any]) -> ToolData | None:
    values: dict[str, Any] = {}
    head = places.head(index)
    for key, value in entry.items():
        if key not in _KEYS:
            line = _line_of(places, key, index)
            errors.add(UNKNOWN_KEY, f"there is no key {key[:40]}", hint_at(key, _KEYS), line)
            continue
        try:
            values[key] = _value(key, value)
        except ValueError as error:
            errors.add(BAD_VALUE, str(error), _help(key, value), _line_of(places, key, index))
    if "number" not in entry:
        errors.add(NO_NUMBER, "this tool has no number", "write number = and the T number", head)
    if "number" not in values:
        return None
    return ToolData.said(values.pop("number"), f"{errors.name}, line {head}", values)


class _Places(NamedTuple):
    """The lines of a TOML file, and which of them (from 1) are headers of a tool."""

    lines: list[str]
    heads: list[int]

    @classmethod
    def of(cls, lines: list[str]) -> _Places:
        head = re.compile(r"\s*\[\[\s*[\"']?tool[\"']?\s*\]\]")
        return cls(lines, [number for number, line in enumerate(lines, 1) if head.match(line)])

    def head(self, index: int) -> int:
        """The line of the ``index``-th header; 1 where the tools have none of their own."""
        return self.heads[index] if index < len(self.heads) else 1


def _line_of(places: _Places, key: str, index: int | None = None) -> int:
    """The line (from 1) of a key in the ``index``-th [[tool]], or anywhere; else that of its header."""
    first, last = 1, len(places.lines)
    if index is not None:
        first = places.head(index) + 1
        last = places.heads[index + 1] - 1 if index + 1 < len(places.heads) else last
    said = re.compile(rf"\s*\[*\s*[\"']?{re.escape(key)}[\"']?\s*[=.\]]")
    found = (number for number in range(first, last + 1) if said.match(places.lines[number - 1]))
    return next(found, max(1, first - 1))


def _value(key: str, value: Any) -> Any:
    """A value of a column in its final form; raises ValueError."""
    if key not in ("type", "name"):
        return number_of(key, value)
    if not isinstance(value, str):
        raise ValueError(f"{key} is no text")
    found = name_of(value) if key == "name" else type_of(value)
    if found is None:
        raise ValueError(f'{key} = "{value[:40]}" is not known')
    return found


def _help(key: str, value: Any) -> str:
    if key == "type":
        return hint_at(str(value), TYPES)
    return "lengths are in mm, angles in degrees; leave a value out that nobody knows"


_TRACE_COLUMNS = ("tooth", "height_mm", "radius_mm")


def read_traces(name: str, data: bytes) -> dict[int, Floats]:
    """Traced edges: tooth -> points (height, radius) [mm] by rising height, an array of shape (n, 2).

    Raises ToolFileError.
    """
    errors = Errors(name, decoded(data))
    points: dict[int, dict[float, float]] = {}
    for row in rows(errors, _TRACE_COLUMNS):
        values = _trace_values(errors, row)
        if values is None:
            continue
        tooth, height_mm, radius_mm = values
        edge = points.setdefault(int(tooth), {})
        if height_mm in edge:
            message = f"tooth {tooth:g} has the height {height_mm:g} mm twice"
            cell = row.cells["height_mm"]
            errors.add(BAD_VALUE, message, "one trace a file; one radius a height", row.line, cell[1:])
        edge[height_mm] = radius_mm
    errors.raise_if_any()
    if not points:
        errors.stop(NO_FORMAT, "there is no point in it", f"a row is {','.join(_TRACE_COLUMNS)}")
    return {tooth: np.array(sorted(edge.items()), np.float64) for tooth, edge in sorted(points.items())}


def _trace_values(errors: Errors, row: Row) -> list[float] | None:
    before = len(errors.found)
    values = []
    for column in _TRACE_COLUMNS:
        cell = row.cells.get(column)
        if cell is None:
            help_text = "a radius of 0 says that nothing touched the beam"
            errors.add(BAD_VALUE, f"this row has no {column}", help_text, row.line)
            continue
        try:
            values.append(number_of(column, cell.text))
        except ValueError as error:
            errors.add(BAD_VALUE, str(error), "heights and radii are in mm", row.line, cell[1:])
    return values if len(errors.found) == before else None
