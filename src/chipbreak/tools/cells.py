"""Tables as text: a header line, then a row a line; every cell knows its columns.

Separators are commas, semicolons or tabs, whichever the header has.  With semicolons a number may have a
decimal comma, as spreadsheets of half of Europe write it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from chipbreak.text.bounds import long_line
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.data import NO_FORMAT, UNKNOWN_KEY, Errors
from chipbreak.tools.values import hint_at
from chipbreak.tools.ways_out import IS_IT_THE_RIGHT_FILE


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
    lines = _lines_that_count(errors)
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
        if _fits(errors, number, cells, columns):
            yield Row(number, _named(columns, cells, has_decimal_comma=separator == ";"))


def check_lines(errors: Errors) -> None:
    """Raises ToolFileError where a line is longer than any of a table."""
    number = long_line(errors.lines)
    if number is not None:
        message = f"line {number} has {len(errors.lines[number - 1])} characters"
        errors.stop(NO_FORMAT, message, IS_IT_THE_RIGHT_FILE)


def _lines_that_count(errors: Errors) -> list[tuple[int, str]]:
    check_lines(errors)
    lines = [(number, line.rstrip("\r")) for number, line in enumerate(errors.lines, 1)]
    return [(n, line) for n, line in lines if line.strip() and not line.lstrip().startswith("#")]


def _fits(errors: Errors, number: int, cells: list[Cell], columns: list[str]) -> bool:
    """False, and an error, for a row with text beyond the last column."""
    extra = next((cell for cell in cells[len(columns) :] if cell.text), None)
    if extra is None:
        return True
    message = f"this row has {len(cells)} cells, the header has {len(columns)} columns"
    help_text = 'write a cell with a separator in it in quotes: "a, b"'
    errors.add(NO_FORMAT, message, help_text, number, extra[1:])
    return False


def _named(columns: list[str], cells: list[Cell], *, has_decimal_comma: bool) -> dict[str, Cell]:
    if has_decimal_comma:
        cells = [cell._replace(text=cell.text.replace(",", ".")) for cell in cells]
    return {name: cell for name, cell in zip(columns, cells, strict=False) if cell.text}


def _columns(errors: Errors, line: int, cells: list[Cell], known: Collection[str]) -> list[str]:
    names: list[str] = []
    for cell in cells:
        name = cell.text.lower()
        if name not in known:
            shown = f'"{cell.text[:40]}"'
            errors.add(UNKNOWN_KEY, f"there is no column {shown}", hint_at(name, known), line, cell[1:])
        elif name in names:
            errors.add(UNKNOWN_KEY, f"the column {name} is there twice", "leave one out", line, cell[1:])
        names.append(name)
    errors.raise_if_any()
    return names


def _split(line: str, separator: str) -> list[Cell]:
    """Cells of a line; a quote inside quotes is doubled."""
    cells: list[Cell] = []
    at = 0
    while True:
        text, end = _text_of_cell(line, at, separator)
        cells.append(_cell(line, at, end, text))
        if end >= len(line):
            return cells
        at = end + 1


def _text_of_cell(line: str, at: int, separator: str) -> tuple[str, int]:
    """The text of the cell that starts at a character, and its end."""
    first = at
    while line[first : first + 1].isspace() and line[first] != separator:
        first += 1
    quoted = ""
    if line[first : first + 1] == '"':
        quoted, first = _quoted(line, first + 1)
    end = _find(line, separator, first)
    return quoted + line[first:end], end


def _quoted(line: str, at: int) -> tuple[str, int]:
    """The text from a character to the closing quote, and the character after it."""
    text = ""
    while at < len(line):
        end = _find(line, '"', at)
        text += line[at:end]
        at = end + 1
        if line[at : at + 1] != '"':
            break
        text += '"'
        at += 1
    return text, at


def _find(line: str, what: str, at: int) -> int:
    """Where the next such character is; the end of the line where there is none."""
    found = line.find(what, at)
    return len(line) if found < 0 else found


def _cell(line: str, start: int, end: int, text: str) -> Cell:
    """A cell with its place, blanks around it left out."""
    blank = len(line[start:end]) - len(line[start:end].lstrip())
    return Cell(text.strip(), start + blank, max(start + blank, start + len(line[start:end].rstrip())))
