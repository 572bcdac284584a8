"""The tools of one program: which it calls, and all that files and comments say about them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.operations import calls_tool
from chipbreak.tools.comments import program_unit, tools_in_comments
from chipbreak.tools.data import FIELDS, ToolData
from chipbreak.tools.files import files_of, read_files, table_unit
from chipbreak.tools.merge import ToolTable, merge
from chipbreak.tools.needs import Check, lacking

_HEADS = ("type", "teeth", "diameter", "length", "radius", "helix", "point", "holder", "tip", "name")


def called_tools(interpreted: InterpretedProgram) -> list[int]:
    """The numbers of the tools that a program calls, in its order."""
    dialect = interpreted.settings.dialect
    numbers = [s.after.tool for s in interpreted.effects if calls_tool(s, dialect)]
    return list(dict.fromkeys(n for n in numbers if n))  # T0 M6 calls none


def tool_table(interpreted: InterpretedProgram) -> ToolTable:
    """All that is known about the tools that a program calls, or lists without calling them.

    Raises ToolFileError when a file of ``[tools]`` or ``--tools`` cannot be used.
    """
    settings = interpreted.settings
    first = interpreted.program.source.body.start
    unit = table_unit(settings, program_unit(interpreted, first))
    files = read_files(files_of(settings), unit)
    comments = tools_in_comments(interpreted)
    return merge(files, comments, [*called_tools(interpreted), *(tool.number for tool in comments)])


def table_text(table: ToolTable) -> list[str]:
    """The tools as lines: what is known [mm, degrees], what said it, which check lacks what."""
    if not table.tools:
        return ["no tool is called or listed"]
    rows = [["tool", *_HEADS]]
    rows += [[f"T{number}", *map(_shown, _values(table, number))] for number in table.tools]
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]
    for number, tool in table.tools.items():
        lines += ["", f"T{number}", *_origins(tool), *_gaps(tool)]
    return lines


def _origins(tool: ToolData) -> Iterator[str]:
    """What said which fields."""
    by_origin: dict[str, list[str]] = {}
    for field in tool.known():
        by_origin.setdefault(tool.origins[field], []).append(field)
    for origin, fields in by_origin.items():
        yield f"  {', '.join(fields)}: {origin}"


def _gaps(tool: ToolData) -> Iterator[str]:
    """Which check lacks which fields."""
    for check in Check:
        fields = lacking(tool, check)
        if fields:
            yield f"  the {check.value} check lacks {', '.join(fields)}"


def table_json(table: ToolTable) -> dict[str, Any]:
    """The same for programs; lengths in mm, angles in degrees."""
    return {
        "tools": [
            {
                "number": number,
                "known": tool.known(),
                "sources": dict(tool.origins),
                "missing": {check.value: lacking(tool, check) for check in Check if lacking(tool, check)},
            }
            for number, tool in table.tools.items()
        ],
        "diagnostics": [d.as_json() for d in table.diagnostics],
    }


def _values(table: ToolTable, number: int) -> Sequence[Any]:
    tool = table.get(number)
    return [getattr(tool, field) for field in FIELDS]


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:z.4f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)
