"""Tables as text: a header line, then a row a line; every cell knows its columns.

Separators are commas, semicolons or tabs, whichever the header has.  With semicolons a number may have a
decimal comma, as spreadsheets of half of Europe write it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

from chipbreak.tools.data import NO_FORMAT, UNKNOWN_KEY, Errors
from chipbreak.tools.values import hint_at


class Cell(NamedTuple):
    """The text of a cell, and its characters in the line (from 0)."""

    text: str
    start: int
    end: int


class Row(NamedTuple):
    """A line (from 1) and its cells by column name; an empty cell is left out."""

    line: int
    cells: dict[str, Cell]


def decoded(data: bytes) -> str:
    """UTF-8, or else what Western spreadsheets write; this never fails."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def rows(errors: Errors, required: Collection[str], optional: Collection[str] = ()) -> Iterator[Row]:
    """The rows below the header.  Blank lines and lines that start with ``#`` do not count.

    Raises ToolFileError when there is no header or when it lacks a required column.
    """
    lines = [(n, line.rstrip("\r")) for n, line in enumerate(errors.lines, 1)]
    lines = [(n, line) for n, line in lines if line.strip() and not line.lstrip().startswith("#")]
    known = (*required, *optional)
    if not lines:
        errors.stop(NO_FORMAT, "this table is empty", f"its first line is {','.join(known)}")
    at, header = lines[0]
    separator = next((s for s in ";\t" if s in header and "," not in header), ",")
    columns = _columns(errors, at, _split(header, separator), known)
    lacking = [name for name in required if name not in columns]
    if lacking:
        message = f"there is no column {lacking[0]}"
        errors.stop(UNKNOWN_KEY, message, f"columns are {','.join(known)}", at, (0, len(header)))
    for number, line in lines[1:]:
        cells = _split(line, separator)
        extra = next((cell for cell in cells[len(columns) :] if cell.text), None)
        if extra:
            message = f"this row has {len(cells)} cells, the header has {len(columns)} columns"
            help_text = 'a cell with a separator in it stands in quotes: "a, b"'
            errors.add(NO_FORMAT, message, help_text, number, extra[1:])
            continue
        if separator == ";":
            cells = [cell._replace(text=cell.text.replace(",", ".")) for cell in cells]
        named = zip(columns, cells, strict=False)
        yield Row(number, {name: cell for name, cell in named if cell.text})


def _columns(errors: Errors, line: int, cells: list[Cell], known: Collection[str]) -> list[str]:
    names: list[str] = []
    for cell in cells:
        name = cell.text.lower()
        if name not in known:
            shown = f'"{cell.text[:40]}"'
            errors.add(UNKNOWN_KEY, f"there is no column {shown}", hint_at(name, known), line, cell[1:])
        elif name in names:
            errors.add(UNKNOWN_KEY, f"the column {name} stands twice", "leave one out", line, cell[1:])
        names.append(name)
    errors.raise_if_any()
    return names


def _split(line: str, separator: str) -> list[Cell]:
    """Cells of a line; a quote inside quotes is doubled."""
    cells: list[Cell] = []
    at = 0
    while True:
        start = at
        while line[at : at + 1].isspace() and line[at] != separator:
            at += 1
        if line[at : at + 1] == '"':
            at += 1
            text = ""
            while at < len(line):
                end = line.find('"', at)
                end = len(line) if end < 0 else end
                text += line[at:end]
                at = end + 1
                if line[at : at + 1] != '"':
                    break
                text += '"'
                at += 1
            end = line.find(separator, at)
            end = len(line) if end < 0 else end
            text += line[at:end]
        else:
            end = line.find(separator, at)
            end = len(line) if end < 0 else end
            text = line[at:end]
        blank = len(line[start:end]) - len(line[start:end].lstrip())
        cells.append(Cell(text.strip(), start + blank, max(start + blank, len(line[:end].rstrip()))))
        if end >= len(line):
            return cells
        at = end + 1
