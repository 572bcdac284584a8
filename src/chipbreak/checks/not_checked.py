"""What of a program is not checked at all, and would not be noticed: one rule for each reason."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from chipbreak.checks.findings import NO_TOOL_CALL, NOT_LOOKED_AT, SISTER_IS_CALLED, WHICH_TOOL, Findings
from chipbreak.checks.limits import Uses
from chipbreak.checks.ways_out import CALL_WITH_ITS_NUMBER, KEEP_THE_SISTER, call_a_tool
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.operations.operations import Operation, calls_tool
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.tips import Tip, tip_of


class WholeProgram(NamedTuple):
    """A program and what its tools do."""

    interpreted: InterpretedProgram
    main: MainProgram
    operations: Sequence[Operation]
    uses: Uses
    tools: ToolTable


def say_what_is_not_checked(program: WholeProgram, findings: Findings) -> None:
    """Tools without a number or an edge, sisters that cut themselves, cuts after the end."""
    for rule in _RULES:
        rule(program, findings)


def _tools(program: WholeProgram, findings: Findings) -> None:
    if not any(operation.call_line is not None for operation in program.operations):
        message = "no tool is called in the main program, so there is nothing to check"
        way_out = call_a_tool(_where_tools_are(program.interpreted))
        findings.say(program.main.first, NO_TOOL_CALL, message, way_out)
    elif None in program.uses.of_tool:
        operation = program.uses.of_tool[None][0]
        message = "this operation cuts with a tool whose number cannot be known; it is not checked"
        if (
            operation.call_line is not None
            and program.interpreted.effect(operation.call_line).after.tool == 0
        ):
            message = "this operation cuts after T0, which calls no tool; it is not checked"
        findings.say(operation.first_cut or 0, WHICH_TOOL, message, CALL_WITH_ITS_NUMBER)
    elif not program.uses.cutting:
        message = "no tool that is called here cuts, so none is checked"
        findings.say(program.main.first, NOT_LOOKED_AT, message)


def _sisters(program: WholeProgram, findings: Findings) -> None:
    sisters = program.interpreted.settings.checks.sister
    for tool in program.uses.of_tool:
        sister = sisters.get(str(tool), 0)
        if sister and sister in program.uses.of_tool:
            message = f"T{sister} is the sister of T{tool}, and this program cuts with it as well"
            line = program.uses.of_tool[sister][0].first_cut or 0
            findings.say(line, SISTER_IS_CALLED, message, KEEP_THE_SISTER)


def _without_edge(program: WholeProgram, findings: Findings) -> None:
    for number, uses in program.uses.of_tool.items():
        tool = None if number is None else program.tools.get(number)
        if tool is not None and tip_of(tool) is Tip.NO_EDGE:
            why = f'"{tool.type}" ({tool.origins["type"]})'
            message = f"T{number} has no edge to measure, so it is not checked: {why}"
            findings.say(uses[0].first_cut or 0, NOT_LOOKED_AT, message)


def _other_programs(program: WholeProgram, findings: Findings) -> None:
    if program.main.after_end is not None:
        message = "another program or a subprogram starts after the end; its tools are not checked"
        findings.say(program.main.after_end, NOT_LOOKED_AT, message)


_RULES: tuple[Callable[[WholeProgram, Findings], None], ...] = (
    _tools,
    _sisters,
    _without_edge,
    _other_programs,
)


def _where_tools_are(interpreted: InterpretedProgram) -> str:
    """Of a program that calls no tool: a call in a subprogram, or a T without its M6."""
    dialect = interpreted.settings.dialect
    place = interpreted.program.source.place
    calls = (effect.block.line for effect in interpreted.effects if calls_tool(effect, dialect))
    inside = next(calls, None)
    if inside is not None:
        return f", and the call in line {place(inside).line} is not in the main program"
    words = (
        effect.block.line
        for effect in interpreted.effects
        if effect.says("T") and "macro-call" not in effect.non_modal
    )
    prepared = next(words, None)
    if prepared is None or dialect.tool_by_word:
        return ""
    change = dialect.m_code("tool", "change")
    return f": T in line {place(prepared).line} prepares a tool, and {change} would bring it into the spindle"
