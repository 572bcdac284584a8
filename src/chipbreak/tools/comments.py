"""What the comments of a program say about its tools: tool lists of CAM posts, and notes at tool calls.

A comment that names a tool ("T2 D=12. CR=0. - FLAT END MILL", "Tool Number: 4") is about that tool, and so
are single facts straight after it ("DIA: 10", "Number of Flutes: 4").  One without a number is about the
tool that is called in the same block, or in the one before as long as nothing has moved, or else about the
one that is called straight after it ("TC: 6mm Endmill").
"""

from __future__ import annotations

import re
from bisect import bisect_right
from typing import Any, Final

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.words import codes_of
from chipbreak.operations.kind_words import CUTVIEWER_TOOL, FUSION_TOOL, HAND_TOOL, TOOL_AHEAD, TOOL_FACT
from chipbreak.operations.kinds import ToolNote, tool_text
from chipbreak.operations.operations import calls_tool
from chipbreak.syntax.nodes import Block
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.data import ToolData
from chipbreak.tools.facts import holder_said, nose_said, stick_out_said, teeth_said, tip_said
from chipbreak.tools.tips import Tip, tip_of_type
from chipbreak.tools.values import name_of, number_of, type_of
from chipbreak.units import mm_per_unit

# Codes that only take the machine to its tool change.
_WAYS_HOME: Final = frozenset({"home", "machine"})
# Of a tool that is put away, or of another one.
_AWAY: Final = re.compile(
    r"\b(?:REMOVE|UNLOAD|TAKE|PREVIOUS|LAST|OLD|AFTER|BEFORE|FROM|SAME)\b", re.IGNORECASE
)


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


class _Remark(NamedTuple):
    """A comment, and the tool it describes."""

    line: int
    text: str
    note: ToolNote | None


def _is_fact(text: str) -> bool:
    """True for what says something of a tool that was named before."""
    return any(form.match(text.strip()) for form in (TOOL_FACT, TOOL_AHEAD, CUTVIEWER_TOOL))


class _Reader:
    """One walk over the comments; ``current`` is the tool that facts without a number are about."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.dialect = interpreted.settings.dialect
        self.effect_at: dict[int, BlockEffect] = {effect.block.line: effect for effect in interpreted.effects}
        self.found: list[ToolData] = []
        self.current: int | None = None
        self.is_called = False
        self.waiting: list[_Remark] = []  # about the tool that is called next, or the one that cuts next
        self.line = 0  # of the block before
        self.units = _unit_codes(interpreted)

    def read(self, block: Block) -> None:
        # Plain motion is no special line; it shows between two of them.
        if bool((self.interpreted.program.plain[self.line : block.line] >= 0).any()):
            self._move()
        self.line = block.line
        effect = self.effect_at.get(block.line)
        if effect and calls_tool(effect, self.dialect):
            self._call(effect.after.tool or None)  # T0 M6 calls none
        elif effect and effect.non_modal & _WAYS_HOME:
            self.current = None
        elif effect and (effect.move or effect.non_modal):
            self._move()
        elif not block.is_empty and not self.is_called:
            self.current = None  # the list of tools ends here
        for comment in block.comments:
            self._remark(block, comment.text)

    def _call(self, tool: int | None) -> None:
        self.current = tool
        self.is_called = True
        self._settle()

    def _move(self) -> None:
        """What was said since the last call, and no call came, is about the tool in the spindle."""
        if self.is_called:
            self._settle()
        self.waiting = []
        self.current = None

    def _settle(self) -> None:
        for remark in self.waiting:
            self._keep(remark)
        self.waiting = []

    def _remark(self, block: Block, text: str) -> None:
        note = tool_text(text)
        remark = _Remark(block.line, text, note)
        number = self._number(note) if note else self._number_of_nose(text)
        if number is not None:
            self.current = number or None
            self.is_called = False
            self._keep(remark)
        elif note is not None and block.is_empty and self._waits(text):
            self.waiting.append(remark)
        elif self.is_called or note is None or _is_fact(text):
            self._keep(remark)

    def _waits(self, text: str) -> bool:
        """True for a tool without a number that is said on a line of its own, as it is before its call."""
        if self.current is not None and not self.is_called:
            return False  # one more line about a tool of the list
        is_ahead = any(form.match(text.strip()) for form in (TOOL_AHEAD, CUTVIEWER_TOOL))
        return is_ahead or (self.current is None and _AWAY.search(text) is None)

    def _keep(self, remark: _Remark) -> None:
        """What a remark says is about the current tool."""
        if self.current is None:
            return
        values = self._values(*remark)
        if values:
            origin = f"comment in line {self.interpreted.program.source.place(remark.line).line}"
            one = ToolData.said(self.current, origin, values)
            if not (
                self.found and self.found[-1].known() == one.known() and self.found[-1].number == one.number
            ):
                self.found.append(one)  # some posts say a tool twice

    def _number(self, note: ToolNote) -> int | None:
        """The tool; on a turret ``T0212`` is tool 2 with offset 12."""
        number = note.number
        if number is None:
            head = note.text.split(maxsplit=1)[0].upper().replace("O", "0") if note.text else ""
            number = int(head[1:]) if head[:1] == "T" and head[1:].isdecimal() and len(head) < 9 else None
        return None if number is None else self.dialect.tool_of(number)

    def _number_of_nose(self, text: str) -> int | None:
        """The tool of a long remark that says a nose: ``T01 = OD TOOL, HOLDER 01-02, NOSE RADIUS: .03``."""
        hit = HAND_TOOL.match(text.strip()) if nose_said(text) else None
        return self.dialect.tool_of(int(hit["n"].upper().replace("O", "0"))) if hit else None

    def _values(self, line: int, text: str, note: ToolNote | None) -> dict[str, Any]:
        """The fields that a comment gives; a value that cannot be is no value."""
        scale = _unit_at(self.interpreted, self.units, line)[0]
        scales = {None: scale, "mm": 1.0, "in": mm_per_unit(is_inch=True)}
        values: dict[str, Any] = {"teeth": teeth_said(text), "nose_tip": tip_said(text)}
        if note:
            values |= _values_of_note(note, scales[note.unit])
        for field, length in (
            ("length_mm", stick_out_said(text)),
            ("holder_mm", holder_said(text)),
            ("corner_radius_mm", nose_said(text)),
        ):
            values[field] = length.value * scales[length.unit] if length else values.get(field)
        return {key: value for key, value in values.items() if value is not None and _can_be(key, value)}


def _values_of_note(note: ToolNote, unit_mm: float) -> dict[str, Any]:
    """The fields that a comment about a tool gives, None for those it does not."""
    kind = (type_of(note.type) or name_of(note.type)) if note.type else None
    # Fusion's TAPER is the point angle of a drill, and the side of a tapered mill.
    is_point = tip_of_type(kind) is Tip.POINT
    ahead = TOOL_AHEAD.match(note.text)
    is_name = not (_is_fact(note.text) or FUSION_TOOL.match(note.text))
    name = ahead["tool"] if ahead else note.text if is_name else ""
    return {
        "type": kind,
        "diameter_mm": note.diameter * unit_mm if note.diameter else None,
        "corner_radius_mm": None if note.corner_radius is None else note.corner_radius * unit_mm,
        "point_deg": note.taper_deg if is_point else None,
        "name": name_of(name),
    }


def _can_be(field: str, value: Any) -> bool:
    if field in ("type", "name"):
        return True
    try:
        number_of(field, value)
    except ValueError:
        return False
    return True
