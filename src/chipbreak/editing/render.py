"""Edits to bytes: untouched lines verbatim, new blocks in the file's own line end, numbers in bulk."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from chipbreak.editing import bracket
from chipbreak.editing.edits import Edit, MoveTable, in_order
from chipbreak.kinematics.floats import Floats
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program

_ROWS_AT_ONCE = 1 << 15
_ZERO = ord("0")
_MINUS = ord("-")
_POINT = ord(".")


def render(
    program: Program, edits: Sequence[Edit], settings: Settings, layer: bracket.Layer = bracket.CHANGES
) -> list[bytes | memoryview]:
    """The pieces of the new program, in order.  Without edits it is the original, byte for byte.

    Raises OverlapError.
    """
    source = program.source
    data = memoryview(source.data)
    pieces: list[bytes | memoryview] = []
    line = 0
    for edit in in_order(edits):
        pieces.append(data[source.starts[line] : source.starts[edit.first]])
        pieces.extend(_region(program, edit, settings, layer))
        line = edit.last
    pieces.append(data[source.starts[line] :])
    return pieces


def _region(program: Program, edit: Edit, settings: Settings, layer: bracket.Layer) -> list[bytes]:
    """One change between its brackets."""
    source = program.source
    control = settings.control
    end = source.line_end
    originals = [source.raw(line) for line in range(edit.first, edit.last)]
    sequence = ""
    if originals and edit.keeps_number and (number := program.block(edit.first).sequence) is not None:
        sequence = f"{number.letter}{number.value_text} "
    marks = settings.dialect.comment_marks
    title = bracket.title_text(edit.title, control.max_line_chars, marks, sequence, layer)
    lower = settings.dialect.reads_comments_in_lower_case
    kept = bracket.was_lines(originals, end, control.max_line_chars, marks, lower_case=lower)
    inner = [text.encode("latin-1") + end for text in kept]
    for item in edit.content:
        inner.append(print_moves(item, end) if isinstance(item, MoveTable) else item.encode("latin-1") + end)
    content = b"".join(inner)
    head = f"{sequence}{bracket.comment(layer.begin, title, marks)}".encode("latin-1")
    foot = bracket.comment(layer.end, bracket.checksum(content), marks).encode("ascii")
    # A file without a last line end keeps none.
    is_last = bool(originals) and not originals[-1].endswith((b"\n", b"\r"))
    return [head + end, content, foot if is_last else foot + end]


def print_moves(table: MoveTable, line_end: bytes) -> bytes:
    """Print a table of moves, a block a row: ``Z-0.125 F0.58000``."""
    parts = []
    for first in range(0, len(table), _ROWS_AT_ONCE):
        rows = slice(first, first + _ROWS_AT_ONCE)
        cells: list[NDArray[np.uint8]] = []
        for letter, column, decimals in zip(table.letters, table.columns, table.decimals, strict=True):
            lead = letter if not cells else " " + letter
            cells.append(_cells(lead, column[rows], decimals))
        count = len(cells[0])
        behind = table.behind.encode("ascii") + line_end if table.behind else b""
        foot = np.frombuffer(line_end + behind, np.uint8)
        cells.append(np.broadcast_to(foot, (count, len(foot))))
        text = np.concatenate(cells, axis=1)
        parts.append(text[text != 0].tobytes())
    return b"".join(parts)


def can_be_written(values: Floats, decimals: int) -> bool:
    """True where numbers, (n,), keep each of their digits when they are printed with so many decimals."""
    scaled = np.rint(values * 10.0**decimals)
    return bool(np.isfinite(scaled).all() and np.abs(scaled).max(initial=0.0) < 2.0**53)


def _cells(lead: str, values: Floats, decimals: int) -> NDArray[np.uint8]:
    """The characters of one column, (n, width), NUL where a number is shorter than the longest."""
    if not can_be_written(values, decimals):
        raise ValueError("a number that cannot be written in a program")
    scaled = np.rint(values * 10.0**decimals)
    whole = np.abs(scaled).astype(np.int64)
    largest = int(whole.max(initial=0))
    digits = max(len(str(largest)), decimals + 1)
    if largest < 2**31:
        whole = whole.astype(np.int32)
    width = len(lead) + 1 + digits + 1
    cells = np.empty((len(values), width), np.uint8)
    cells[:, : len(lead)] = np.frombuffer(lead.encode("ascii"), np.uint8)
    cells[:, len(lead)] = np.where(scaled < 0.0, _MINUS, 0)
    column = width - 1
    for place in range(digits):
        if place == decimals:
            cells[:, column] = _POINT
            column -= 1
        rest = whole // 10
        digit = (whole - rest * 10 + _ZERO).astype(np.uint8)
        # In front of the point only the first digit is printed when it is zero.
        cells[:, column] = np.where(whole > 0, digit, 0) if place > decimals else digit
        whole = rest
        column -= 1
    return cells
