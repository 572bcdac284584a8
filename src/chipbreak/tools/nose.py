"""The round nose of the tool under G41 and G42: its radius and tip number, from whoever says them first.

Words of the block (LinuxCNC's ``G42.1 D0.8 L2``) come before the profile, that before files of tools, and
these before comments.  What the profile says of all other tools comes last, and is called assumed.
"""

from __future__ import annotations

from chipbreak.cycles.nose import Nose
from chipbreak.model.findings import COMPENSATED
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.merge import ToolTable

_SAYS_ITSELF = frozenset({411, 421})


class _Row(NamedTuple):
    """A row of the offset screen, and the tool that it is of; None where it need not be of this tool."""

    number: int
    tool: int | None


def nose_of(interpreted: InterpretedProgram, line: int, table: ToolTable) -> Nose:
    """The nose of the tool that the block in ``line`` (from 0) begins to compensate.

    Errors: VIB040 where its radius or tip is not known.
    """
    block = interpreted.program.block(line)
    if says_its_nose(block):
        return _said_by_block(interpreted, block)
    row = _row(interpreted, block)
    tools = interpreted.settings.tools
    radius_mm = tools.nose_radius_mm.get(str(row.number))
    tip = tools.nose_tip.get(str(row.number))
    if row.tool is not None:
        known = table.get(row.tool)
        radius_mm = known.corner_radius_mm if radius_mm is None else radius_mm
        tip = known.nose_tip if tip is None else tip
    is_assumed = radius_mm is None or tip is None
    radius_mm = tools.other_nose_radius_mm if radius_mm is None else radius_mm
    tip = tools.other_nose_tip if tip is None else tip
    return _checked(radius_mm, tip, row)._replace(is_assumed=is_assumed)


def says_its_nose(block: Block) -> bool:
    """True for a code that has the nose in its own words: no table of the control counts for it."""
    return any(round(number * 10) in _SAYS_ITSELF for number in block.numbers("G"))


def _checked(radius_mm: float | None, tip: int | None, row: _Row) -> Nose:
    missing = [
        name for name, value in (("nose radius (R)", radius_mm), ("tip number (T)", tip)) if value is None
    ]
    if missing:
        why = f"the {' and the '.join(missing)} of offset {row.number} {_verb(missing)} not known"
        help_text = "give them as on the offset screen, for this offset: tools.nose_radius_mm."
        help_text += (
            f"{row.number} = 0.8 and tools.nose_tip.{row.number} = 3 in the profile; where all turning"
        )
        help_text += " tools are alike, tools.other_nose_radius_mm and tools.other_nose_tip"
        raise _refused(why, help_text)
    assert radius_mm is not None
    assert tip is not None
    if not radius_mm > 0.0:
        raise _refused(f"the nose radius of offset {row.number} is 0", "give the radius that the nose has")
    return Nose(radius_mm, tip)


def _verb(names: list[str]) -> str:
    return "are" if len(names) > 1 else "is"


def _said_by_block(interpreted: InterpretedProgram, block: Block) -> Nose:
    """D is a diameter, L the tip; without L the centre of the nose is programmed."""
    diameter = block.number("D")
    tip = block.number("L") if block.has("L") else 0.0
    if diameter is None or not diameter > 0.0 or tip is None or tip not in range(10):
        raise _refused(
            "D and L of its block say no nose", "write D as the diameter of the nose, and L as 0 to 9"
        )
    return Nose(diameter / 2.0 * interpreted.before(block.line).mm_per_unit, int(tip))


def _row(interpreted: InterpretedProgram, block: Block) -> _Row:
    """Which offset is in force.  Errors: VIB040 where none is known."""
    is_turret = interpreted.settings.dialect.tool_by_word
    return _row_of_word(interpreted, block) if is_turret else _row_of_tool(interpreted, block)


def _row_of_tool(interpreted: InterpretedProgram, block: Block) -> _Row:
    """D of the block, or the tool in the spindle."""
    before = interpreted.before(block.line)
    tool = block.number("D") if block.has("D") else None if _is_open(before) else before.tool
    if tool is None or tool != int(tool) or tool < 1:
        raise _refused("which tool is in the spindle is not known", "call the tool before it with T and M6")
    return _Row(int(tool), int(tool))


def _row_of_word(interpreted: InterpretedProgram, block: Block) -> _Row:
    """The last digits of the T word that has turned the turret."""
    dialect = interpreted.settings.dialect
    called = [e.block for e in interpreted.effects if e.block.line <= block.line and e.says("T")]
    word = called[-1].word("T") if called else None
    if word is None or word.number is None:
        raise _refused(
            "no T word says which offset is in force", "call the tool and its offset before it: T0101"
        )
    whole = int(word.number)
    tool = dialect.tool_of(whole)
    offsets = 10**dialect.offset_digits
    number = whole % offsets if whole >= offsets else whole
    if number == 0:
        raise _refused(f"T{word.value_text} takes the offset off", "call the tool with its offset: T0101")
    before = interpreted.before(block.line)
    if called[-1].is_optional or before.tool != tool or _is_open(before):
        line = interpreted.program.source.place(called[-1].line).line
        why = f"T{word.value_text} in line {line} may be skipped or passed by"
        raise _refused(why, "call the tool and its offset again before this block")
    return _Row(number, tool if number == tool else None)


def _is_open(state: State) -> bool:
    """True where a call of another tool may have been skipped, or passed by."""
    return "tool" in dict(state.left_open)


def _refused(why: str, help_text: str) -> RefusalError:
    return RefusalError(COMPENSATED, f"tool nose compensation (G41, G42) is active, and {why}", help_text)
