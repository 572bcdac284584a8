"""All that is known about the tools of a program, merged in a declared order, field by field.

Files come before comments, and files in the order in which they were given; the first that says something
about a field wins.  Within one file two entries of the same number that differ cancel each other: nobody can
say which of them is in the magazine.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.data import FIELDS, ToolData

TWICE = "TOL008"
AT_ODDS = "TOL009"
# Sources agree within this: lists round to a hundredth of a mm or a thousandth of an inch.
_SAME_MM: Final = 0.02
_COMPARED: Final = (
    "teeth",
    "diameter_mm",
    "length_mm",
    "corner_radius_mm",
    "helix_deg",
    "point_deg",
    "holder_mm",
    "nose_tip",
)
_COUNTED: Final = ("teeth", "nose_tip")
_WORDS: Final = {
    "type": "type",
    "teeth": "number of teeth",
    "diameter_mm": "diameter",
    "length_mm": "length below the holder",
    "corner_radius_mm": "corner radius",
    "helix_deg": "helix angle",
    "point_deg": "point angle",
    "holder_mm": "holder length",
    "nose_tip": "tip number of the nose",
    "name": "name",
}


class ToolTable(NamedTuple):
    """``tools`` by number, and what has to be said about the sources."""

    tools: dict[int, ToolData]
    diagnostics: tuple[Diagnostic, ...]

    def get(self, number: int) -> ToolData:
        """A tool; one that nobody described has no fields."""
        return self.tools.get(number, ToolData(number))


def field_words(field: str) -> str:
    """A field in the words of messages."""
    return _WORDS[field]


def merge(
    files: Sequence[Sequence[ToolData]], comments: Sequence[ToolData], wanted: Iterable[int]
) -> ToolTable:
    """The tools with the ``wanted`` numbers, from files in their order and then from comments."""
    found: dict[int, ToolData] = {}
    diagnostics: list[Diagnostic] = []
    for number in sorted(set(wanted)):
        sources = []
        for tools in files:
            one, twice = _of_one_file([tool for tool in tools if tool.number == number])
            diagnostics += twice
            sources += [one] if one else []
        sources += [tool for tool in comments if tool.number == number]
        tool = ToolData(number)
        for source in sources:
            diagnostics += _at_odds(tool, source)
            tool = _filled(tool, source)
        found[number] = _with_radius(tool)
    return ToolTable(found, tuple(diagnostics))


def _filled(tool: ToolData, other: ToolData) -> ToolData:
    """The tool with what only the other one knows."""
    known = tool.known()
    news = {key: value for key, value in other.known().items() if key not in known}
    if not news:
        return tool
    origins = {**tool.origins, **{key: other.origins[key] for key in news}}
    return tool._replace(**news, origins=origins)


def _of_one_file(entries: Sequence[ToolData]) -> tuple[ToolData | None, list[Diagnostic]]:
    """The one tool that all entries of a file describe, without the fields in which they differ."""
    if not entries:
        return None, []
    values: dict[str, Any] = {}
    origins: dict[str, str] = {}
    diagnostics = []
    for field in FIELDS:
        said = [tool for tool in entries if getattr(tool, field) is not None]
        different = {getattr(tool, field) for tool in said}
        if len(different) > 1 and field != "name":
            shown = " and ".join(f"{getattr(t, field)} ({t.origins[field]})" for t in (said[0], said[-1]))
            message = (
                f"T{entries[0].number} is there twice in one file: {_WORDS[field]} {shown}; neither is used"
            )
            help_text = "give every tool a number of its own, or the right one in a file before this"
            diagnostics.append(Diagnostic(TWICE, Severity.WARNING, message, help_text))
        elif said:
            values[field] = getattr(said[0], field)
            origins[field] = said[0].origins[field]
    return entries[0]._replace(**{**dict.fromkeys(FIELDS), **values}, origins=origins), diagnostics


def _at_odds(tool: ToolData, other: ToolData) -> list[Diagnostic]:
    """Warnings where a later source contradicts an earlier one: is it the same tool at all?"""
    diagnostics = []
    for field in _COMPARED:
        one = getattr(tool, field)
        two = getattr(other, field)
        if one is None or two is None or abs(one - two) <= (0 if field in _COUNTED else _SAME_MM):
            continue
        message = (
            f"T{tool.number}: {_WORDS[field]} {one:g} ({tool.origins[field]})"
            f" or {two:g} ({other.origins[field]})? The first is used"
        )
        diagnostics.append(
            Diagnostic(AT_ODDS, Severity.WARNING, message, "check that both mean the same tool")
        )
    return diagnostics


def _with_radius(tool: ToolData) -> ToolData:
    """A ball's radius is half its diameter: that is what makes it a ball."""
    if tool.type != "ball end mill" or tool.diameter_mm is None:
        return tool
    origin = f"half the diameter ({tool.origins['diameter_mm']})"
    origins = {**tool.origins, "corner_radius_mm": origin}
    return tool._replace(corner_radius_mm=tool.diameter_mm / 2.0, origins=origins)
