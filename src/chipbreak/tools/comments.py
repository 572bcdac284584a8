"""What the comments of a program say about its tools: tool lists of CAM posts, and notes at tool calls.

A comment that names a tool ("T2 D=12. CR=0. - FLAT END MILL", "Tool Number: 4") is about that tool, and so
are single facts straight after it ("DIA: 10", "Number of Flutes: 4").  One without a number is about the
tool that is called in the same block, or in the one before as long as nothing has moved.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import Any

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.operations.kind_words import FUSION_TOOL, TOOL_FACT
from chipbreak.operations.kinds import ToolNote, tool_text
from chipbreak.operations.operations import calls_tool
from chipbreak.syntax.nodes import Block
from chipbreak.tools.data import ToolData
from chipbreak.tools.facts import holder_said, stick_out_said, teeth_said
from chipbreak.tools.tips import Tip, tip_of_type
from chipbreak.tools.values import name_of, number_of, type_of
from chipbreak.units import mm_per_unit


def tools_in_comments(interpreted: InterpretedProgram) -> list[ToolData]:
    """Every remark about a tool with a number, in the order of the program; a tool may come several times."""
    reader = _Reader(interpreted)
    for block in interpreted.program.event_blocks():
        reader.read(block)
    return reader.found


def program_unit(interpreted: InterpretedProgram, line: int) -> tuple[float, str]:
    """mm per unit of the program at a line, and what says so.

    A tool list comes before the G20 or G21 it is meant in, so the next one counts where none has come yet.
    """
    return _unit_at(interpreted, _unit_codes(interpreted), line)


def _unit_at(interpreted: InterpretedProgram, given: list[tuple[int, str]], line: int) -> tuple[float, str]:
    unit: str = interpreted.settings.dialect.initial.units
    if not given:
        origin = f"{_word(unit)}, as {interpreted.settings.dialect.title} starts"
    else:
        at = max(bisect_right([number for number, _ in given], line) - 1, 0)
        code_line, unit = given[at]
        origin = (
            f"{_word(unit)}, as line {interpreted.program.source.place(code_line).line} of the program says"
        )
    return mm_per_unit(is_inch=unit == "inch"), origin


def _unit_codes(interpreted: InterpretedProgram) -> list[tuple[int, str]]:
    dialect = interpreted.settings.dialect
    found = []
    for effect in interpreted.effects:
        codes = codes_of(effect.block, "units", dialect)
        if codes:
            found.append((effect.block.line, dialect.g_codes[codes[-1]].value))
    return found


def _word(unit: str) -> str:
    return "inches" if unit == "inch" else "mm"


class _Reader:
    """One walk over the comments; ``current`` is the tool that facts without a number are about."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.dialect = interpreted.settings.dialect
        self.effect_at: dict[int, BlockEffect] = {effect.block.line: effect for effect in interpreted.effects}
        self.found: list[ToolData] = []
        self.current: int | None = None
        self.is_called = False
        self.line = 0  # of the block before
        self.units = _unit_codes(interpreted)

    def read(self, block: Block) -> None:
        # Plain motion is no special line; it shows between two of them.
        if bool((self.interpreted.program.plain[self.line : block.line] >= 0).any()):
            self.current = None
        self.line = block.line
        effect = self.effect_at.get(block.line)
        if effect and calls_tool(effect, self.dialect):
            self.current = effect.after.tool
            self.is_called = True
        elif effect and (effect.move or effect.non_modal):
            self.current = None
        elif not block.is_empty and not self.is_called:
            self.current = None  # the list of tools ends here
        for comment in block.comments:
            self._remark(block.line, comment.text)

    def _remark(self, line: int, text: str) -> None:
        note = tool_text(text)
        number = self._number(note) if note else None
        if number is not None:
            self.current = number
            self.is_called = False
        is_fact = bool(TOOL_FACT.match(text.strip())) or note is None
        if self.current is None or not (number is not None or self.is_called or is_fact):
            return
        values = self._values(line, text, note)
        if values:
            origin = f"comment in line {self.interpreted.program.source.place(line).line}"
            self.found.append(ToolData.said(self.current, origin, values))

    def _number(self, note: ToolNote) -> int | None:
        """The tool; on a turret ``T0212`` is tool 2 with offset 12."""
        number = note.number
        if number is None:
            head = note.text.split(maxsplit=1)[0].upper().replace("O", "0") if note.text else ""
            number = int(head[1:]) if head[:1] == "T" and head[1:].isdecimal() and len(head) < 9 else None
        return None if number is None else self.dialect.tool_of(number)

    def _values(self, line: int, text: str, note: ToolNote | None) -> dict[str, Any]:
        """The fields that a comment gives; a value that cannot be is no value."""
        scale = _unit_at(self.interpreted, self.units, line)[0]
        scales = {None: scale, "mm": 1.0, "in": mm_per_unit(is_inch=True)}
        values: dict[str, Any] = {"teeth": teeth_said(text)}
        for field, length in (("length_mm", stick_out_said(text)), ("holder_mm", holder_said(text))):
            values[field] = length.value * scales[length.unit] if length else None
        if note:
            values |= _values_of_note(note, scales[note.unit])
        return {key: value for key, value in values.items() if value is not None and _can_be(key, value)}


def _values_of_note(note: ToolNote, unit_mm: float) -> dict[str, Any]:
    """The fields that a comment about a tool gives, None for those it does not."""
    kind = (type_of(note.type) or name_of(note.type)) if note.type else None
    # Fusion's TAPER is the point angle of a drill, and the side of a tapered mill.
    is_point = tip_of_type(kind) is Tip.POINT
    is_name = not (TOOL_FACT.match(note.text.strip()) or FUSION_TOOL.match(note.text))
    return {
        "type": kind,
        "diameter_mm": note.diameter * unit_mm if note.diameter else None,
        "corner_radius_mm": None if note.corner_radius is None else note.corner_radius * unit_mm,
        "point_deg": note.taper_deg if is_point else None,
        "name": name_of(note.text) if is_name else None,
    }


def _can_be(field: str, value: Any) -> bool:
    if field in ("type", "name"):
        return True
    try:
        number_of(field, value)
    except ValueError:
        return False
    return True
