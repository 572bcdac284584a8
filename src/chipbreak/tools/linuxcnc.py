"""LinuxCNC's tool table: ``T1 P1 D12.0 Z-63.2 ;12 mm end mill``.

D is the diameter in the units of the machine, on a turning tool (with an orientation Q) that of its nose.
Z is the length *offset*, measured from wherever the machine's zero is; how far the tool sticks out of its
holder is not in the table.
"""

from __future__ import annotations

import re
from typing import Any, Final

from chipbreak.operations.kinds import tool_text
from chipbreak.tools.cells import check_lines, decoded
from chipbreak.tools.data import BAD_VALUE, NO_NUMBER, UNKNOWN_KEY, Errors, ToolData
from chipbreak.tools.facts import teeth_said
from chipbreak.tools.reader import Unit
from chipbreak.tools.values import name_of, number_of, type_of

_WORD: Final = re.compile(
    r"\s*(?:([A-Za-z])\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)(?=[\sA-Za-z]|$)|(\S+))"
)
_LETTERS: Final = "TPXYZABCUVWDIJQ"


def read_table(data: bytes, name: str, unit: Unit) -> list[ToolData]:
    """Tools of a table, whose lengths are in this unit.  Raises ToolFileError."""
    errors = Errors(name, decoded(data))
    check_lines(errors)
    tools = []
    for number, line in enumerate(errors.lines, 1):
        text, _, comment = line.partition(";")
        if not text.strip():
            continue
        before = len(errors.found)
        words = _words(errors, number, text)
        if len(errors.found) > before:
            continue
        if "T" not in words:
            errors.add(NO_NUMBER, "this line has no T", "a line is T1 P1 D12. Z0. ;comment", number)
            continue
        tools += _tool(errors, number, words, comment, unit)
    errors.raise_if_any()
    return tools


def _words(errors: Errors, line: int, text: str) -> dict[str, tuple[str, int, int]]:
    """Letter -> its number and its characters."""
    words: dict[str, tuple[str, int, int]] = {}
    at = 0
    text = text.rstrip()
    while at < len(text):
        hit = _WORD.match(text, at)
        assert hit is not None  # the last branch takes anything
        at = hit.end()
        letter = (hit[1] or "").upper()
        if letter and letter in _LETTERS:
            words[letter] = (hit[2], hit.start(1), hit.end())
            continue
        start = hit.start(1) if hit[1] else hit.start(3)
        shown = text[start : min(at, start + 20)]
        help_text = f"words are one of {', '.join(_LETTERS)} and a number; a comment comes after ;"
        errors.add(UNKNOWN_KEY, f'"{shown}" is no word of a tool table', help_text, line, (start, at))
        break
    return words


def _tool(
    errors: Errors,
    line: int,
    words: dict[str, tuple[str, int, int]],
    comment: str,
    unit: Unit,
) -> list[ToolData]:
    note = tool_text(comment)
    is_turning = "Q" in words and float(words["Q"][0]) != 0.0
    values: dict[str, Any] = {"name": name_of(comment), "teeth": teeth_said(comment)}
    # A remark here names the tool, so also a word that elsewhere may be work names its type: ";drill 5 mm".
    said = (note.type if note else None) or type_of(comment)
    values["type"] = "turning tool" if is_turning else said
    try:
        if is_turning:
            text, start, end = words["Q"]
            values["nose_tip"] = number_of("nose_tip", text)
        text, start, end = words["T"]
        number = number_of("number", text)
        if "D" in words and float(words["D"][0]) != 0.0:  # D0. is how a table says nothing
            text, start, end = words["D"]
            field, share = ("corner_radius_mm", 0.5) if is_turning else ("diameter_mm", 1.0)
            values[field] = number_of(field, float(text) * unit.mm * share)
    except ValueError as error:
        help_text = f"lengths here are in {'inches' if unit.mm != 1.0 else 'mm'}: {unit.origin}"
        errors.add(BAD_VALUE, str(error), help_text, line, (start, end))
        return []
    tool = ToolData.said(int(number), f"{errors.name}, line {line}", values)
    by_unit = {
        key: f"{origin} ({unit.origin})" for key, origin in tool.origins.items() if key.endswith("_mm")
    }
    return [tool._replace(origins={**tool.origins, **by_unit})]
