"""A reader of tool files that end with ``.magazine``: a line a tool, ``1 LENGTH 52.3 DIAMETER 12``, in mm."""

from __future__ import annotations

from chipbreak.tools.data import BAD_VALUE, Errors, ToolData
from chipbreak.tools.reader import ToolReader, Unit

EXAMPLE = "1 LENGTH 52.3 DIAMETER 12"
FIELDS = {"LENGTH": "length_mm", "DIAMETER": "diameter_mm"}


def read_magazine(data: bytes, name: str, unit: Unit) -> list[ToolData]:
    """The tools of a file; all lines that cannot be read are said at once.  Raises ToolFileError."""
    text = data.decode("latin-1")
    errors = Errors(name, text)
    tools = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            tools += _tool(line.split(), f"{name}, line {number}")
        except (ValueError, KeyError):
            errors.add(
                BAD_VALUE, "this line is no tool", "write for example: 1 LENGTH 52.3 DIAMETER 12", number
            )
    errors.raise_if_any()
    return tools


def _tool(words: list[str], origin: str) -> list[ToolData]:
    """The tool of one line; an empty line has none."""
    if not words:
        return []
    pairs = zip(words[1::2], words[2::2], strict=True)
    return [ToolData.said(int(words[0]), origin, {FIELDS[key]: float(value) for key, value in pairs})]


READER = ToolReader((".magazine",), read_magazine)
