"""Which check stands at which border, and its limit W.

The limit depends on what the tool does *next*: a small chip is no harm before roughing, but leaves its mark
in a finish.  So it is taken from the next operation of the same tool, and behind its last use from its
first one, which is what the next workpiece starts with.

The shape of the edge is stored at a tool's first call and stays the reference for all its CHIP CHECKs in
the program: wear adds up, and a new reference at every call would hide it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

from chipbreak.checks.borders import Border, BorderFinder, NoBorder, Range
from chipbreak.checks.calls import CallSet, CallValues, Event, calls_of
from chipbreak.checks.ground import Ground
from chipbreak.checks.limits import Limit, limit_before
from chipbreak.checks.tool_values import source_field
from chipbreak.diagnostics import Diagnostic, Severity
from chipbreak.model.kinds import Kind
from chipbreak.model.main_program import MainProgram
from chipbreak.model.operations import Operation
from chipbreak.model.trace import Trace
from chipbreak.settings.sections import Settings
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.needs import not_given
from chipbreak.tools.tips import Tip, tip_of

NO_TOOL_CALL, NO_BORDER, NO_SPEED = "CHK001", "CHK002", "CHK003"
NO_SHAPE, NOT_LOOKED_AT, WHICH_TOOL = "CHK004", "CHK005", "CHK006"
LEFT_TO_CONTROL = "CHK007"


class PlannedCheck(NamedTuple):
    """A check that will be inserted; ``limit_mm`` is the W of a CHIP CHECK."""

    event: Event
    tool: int | None
    border: Border
    blocks: tuple[str, ...]
    title: str
    reason: str
    limit_mm: float | None = None


def plan_checks(
    operations: Sequence[Operation], trace: Trace, main: MainProgram, settings: Settings, tools: ToolTable
) -> tuple[list[PlannedCheck], list[Diagnostic]]:
    """All checks of a program, in its order, and what could not be checked.

    Raises RefusalError when the calls of the profile cannot be used (SET030 to SET034).
    """
    planner = _Planner(operations, trace, main, settings, tools)
    planner.run()
    return planner.planned, planner.diagnostics


class _Wish(NamedTuple):
    """A check that wants a place."""

    event: Event
    values: CallValues
    reason: str

    @property
    def title(self) -> str:
        """``CHIP CHECK T2 W0.02``."""
        values = self.values
        parts = [self.event.title]
        parts += [f"T{values.tool}"] if values.tool is not None else []
        parts += [f"W{values.limit_mm:g}"] if values.limit_mm is not None else []
        return " ".join(parts)


class _Planner:
    """One walk over the operations."""

    def __init__(
        self,
        operations: Sequence[Operation],
        trace: Trace,
        main: MainProgram,
        settings: Settings,
        tools: ToolTable,
    ) -> None:
        self.trace, self.main, self.tools = trace, main, tools
        self.settings, self.checks = settings, settings.checks
        self.operations = operations
        self.calls: CallSet = calls_of(settings)
        self.finder = BorderFinder(trace, Ground(trace, self.main))
        self.cutting = [op for op in operations if op.cuts and op.kind is not Kind.PROBE]
        self.uses: dict[int | None, list[Operation]] = {}
        for operation in self.cutting:
            self.uses.setdefault(operation.tool, []).append(operation)
        self.next_use = {one.index: other for uses in self.uses.values() for one, other in pairwise(uses)}
        self.call_lines: list[int | None] = []  # of each operation: where its tool was called
        for operation in operations:
            before = self.call_lines[-1] if self.call_lines else None
            self.call_lines.append(before if operation.call_line is None else operation.call_line)
        self.planned: list[PlannedCheck] = []
        self.diagnostics: list[Diagnostic] = []
        self.traced: set[int] = set()
        self.shapeless: set[int] = set()
        self.said_missing: set[tuple[int, str]] = set()
        self.uses_tool_data = self.calls.uses_tool_data()

    def run(self) -> None:
        """Plan visit by visit: what a tool does between its call and the next one."""
        self._say_what_is_left_out()
        is_calibrated = False
        for call, group in groupby(self.cutting, lambda op: self.call_lines[op.index]):
            visit = list(group)
            tool = visit[0].tool
            if tool is None or call is None or not self._is_wanted(tool):
                continue
            if not is_calibrated:
                self._calibrate(call)
                is_calibrated = True
            self._check_tool(call, visit[0], tool)
            for operation in visit:
                self._check_chips(operation, tool)
        if all(check.event is Event.CALIBRATE for check in self.planned):
            self.planned.clear()  # a beam that nobody looks at

    def _is_wanted(self, tool: int) -> bool:
        if self.uses_tool_data and tip_of(self.tools.get(tool)) is Tip.STANDING:
            return False  # a turning tool or a probe: nothing turns in the beam
        return tool not in self.checks.ignore and (not self.checks.only or tool in self.checks.only)

    def _say_what_is_left_out(self) -> None:
        """What nobody would notice otherwise: cuts of tools without a number, cuts behind the end."""
        called = any(op.call_line is not None for op in self.operations)
        if not called:
            message = "no tool is called in the main program, so there is nothing to check"
            help_text = "a check needs the tool's number from its call"
            self._say(self.main.first, NO_TOOL_CALL, message, help_text)
        elif None in self.uses:
            message = "this operation cuts with a tool whose number cannot be known; it is not checked"
            line = self.uses[None][0].first_cut or 0
            self._say(line, WHICH_TOOL, message, "call the tool with its number before it cuts")
        elif not self.cutting:
            self._say(self.main.first, NOT_LOOKED_AT, "no tool that is called here cuts, so none is checked")
        if self.main.behind is not None:
            message = "another program or a subprogram starts behind the end; its tools are not checked"
            self._say(self.main.behind, NOT_LOOKED_AT, message)

    def _calibrate(self, call: int) -> None:
        """Straight before the first tool call: behind it the master bar would have to change places."""
        if not self.calls.has(Event.CALIBRATE):
            return
        ends = [last + 1 for _, last in self.main.bodies if last < call]
        ends += [op.last_cut + 1 for op in self.operations if op.last_cut is not None and op.last_cut < call]
        first = max([self.main.first, *ends])
        where = Range(first, call, call, at_start=first == self.main.first)
        reason = "the beam is measured once a workpiece, before the first tool is called"
        self._place(where, _Wish(Event.CALIBRATE, CallValues(), reason))

    def _check_tool(self, call: int, operation: Operation, tool: int) -> None:
        """TOOL CHECK and TRACE, after the tool call and before its first cut."""
        assert operation.first_cut is not None
        where = Range(call + 1, call + 1, operation.first_cut)
        data = self.tools.get(tool)
        values = CallValues(tool, operation.speed_rpm, self.checks.trace_height_mm, data=data)
        called = f"called in line {self.trace.program.source.place(call).line}"
        wishes = []
        if self._can_call(Event.TOOL_CHECK, values, operation.first_cut):
            reason = f"T{tool} is {called} and has not cut yet"
            wishes.append(_Wish(Event.TOOL_CHECK, values, reason))
        if tool not in self.traced and self._can_call(Event.TRACE, values, operation.first_cut):
            reason = f"the edge of T{tool}, {called}, is stored before its first cut"
            wishes.append(_Wish(Event.TRACE, values, reason))
        if wishes and self._place(where, *wishes) and wishes[-1].event is Event.TRACE:
            self.traced.add(tool)

    def _can_call(self, event: Event, values: CallValues, first_cut: int) -> bool:
        """True when the set has such a call, and all it says about the tool and its speed is known."""
        if not self.calls.has(event):
            return False
        if values.speed_rpm is None and self.calls.needs(event, "speed_rpm"):
            message = f"left out: {event.title} T{values.tool}; the spindle speed of this cut is not known"
            self._say(first_cut, NO_SPEED, message, "give S and M3 or M4 before the cut")
            return False
        lacking = self.calls.lacking(event, values)
        left_to_control = self.checks.missing == "control" and self.calls.text(event, values, is_inch=False)
        if lacking and left_to_control:
            self._say_left_to_control(lacking, values.tool or 0, first_cut)
            return True
        for field in dict.fromkeys(source_field(name, self.tools.get(values.tool or 0)) for name in lacking):
            self._say_missing(event, values.tool or 0, field, first_cut)
        return not lacking

    def _say_left_to_control(self, lacking: list[str], tool: int, line: int) -> None:
        """Once for each tool: the check stands, but the control must know the tool itself."""
        fields = dict.fromkeys(source_field(name, self.tools.get(tool)) for name in lacking)
        if (tool, "") not in self.said_missing:
            self.said_missing.add((tool, ""))
            message = (
                f"nobody gave {', '.join(fields)} of T{tool}: the call that tells the control is left out,"
                " and the check alarms unless the control knows the tool"
            )
            help_text = "give them in a tool file (--tools FILE); with checks.missing=error this is an error"
            self._say(line, LEFT_TO_CONTROL, message, help_text)

    def _say_missing(self, event: Event, tool: int, field: str, line: int) -> None:
        """Once for each field of a tool: TOOL CHECK and TRACE want the same."""
        if (tool, field) not in self.said_missing:
            self.said_missing.add((tool, field))
            # A call that says nothing but what is missing cannot be left to the control.
            severity = Severity.WARNING if self.checks.missing == "skip" else Severity.ERROR
            found = not_given(self.tools.get(tool), event.title, field, severity)
            skip = "" if self.checks.missing == "skip" else "; checks.missing=skip leaves the check out"
            help_text = found.help + skip
            program = self.trace.program
            self.diagnostics.append(
                program.diagnose(line, found.code, found.message, help_text, severity=severity)
            )

    def _check_chips(self, operation: Operation, tool: int) -> None:
        """CHIP CHECK at the end of an operation, with the limit of what the tool does next."""
        limit = self._limit(operation, tool) if self.calls.has(Event.CHIP_CHECK) else None
        if limit is None:
            return
        assert operation.last_cut is not None
        if self.calls.has(Event.TRACE) and tool not in self.traced:
            if tool not in self.shapeless:
                message = (
                    f"left out: CHIP CHECK T{tool} until it is called again; no shape of its edge was stored"
                )
                self._say(operation.last_cut, NO_SHAPE, message, "see why its TRACE was left out")
            self.shapeless.add(tool)
            return
        values = CallValues(
            tool=tool,
            height_mm=self.checks.trace_height_mm,
            limit_mm=limit.w_mm,
            operation=limit.next_kind.value.upper(),
            data=self.tools.get(tool),
        )
        if not self._can_call(Event.CHIP_CHECK, values, operation.last_cut):
            return
        where = Range(operation.last_cut + 1, operation.last_line, self._last_place_behind(operation))
        self._place(where, _Wish(Event.CHIP_CHECK, values, limit.reason))

    def _limit(self, operation: Operation, tool: int) -> Limit | None:
        if operation.index in self.next_use:
            return limit_before(self.next_use[operation.index], self.settings, f"T{tool} is used next for")
        policy = self.checks.last_use
        if policy == "none":
            return None
        if policy == "next-part":
            when = f"last use of T{tool}; the next workpiece starts with"
            return limit_before(self.uses[tool][0], self.settings, when)
        assert isinstance(policy, float)
        return Limit(policy, f"last use of T{tool}: checks.last_use gives W {policy:g} mm", Kind.UNKNOWN)

    def _last_place_behind(self, operation: Operation) -> int:
        """The line of the next tool call or the next cut."""
        for later in self.operations[operation.index + 1 :]:
            for line in (later.call_line, later.first_cut):
                if line is not None:
                    return line
        return self.main.last

    def _place(self, where: Range, *wishes: _Wish) -> bool:
        """Plan checks at the first safe border of a range, or say why there is none."""
        found = self.finder.find(where)
        if isinstance(found, NoBorder):
            titles = ", ".join(wish.title for wish in wishes)
            message = f"left out: {titles}; nothing can be inserted here, because {found.why}"
            help_text = "make a place for it: G0 to a known position, G40, G80, the spindle with S"
            self._say(found.line, NO_BORDER, message, help_text)
            return False
        for wish in wishes:
            blocks = self.calls.text(wish.event, wish.values, is_inch=found.state.is_inch)
            tool, limit_mm = wish.values.tool, wish.values.limit_mm
            check = PlannedCheck(wish.event, tool, found, blocks, wish.title, wish.reason, limit_mm)
            self.planned.append(check)
        return True

    def _say(self, line: int, code: str, message: str, help_text: str = "") -> None:
        """A warning at a line of the program, a note where nobody can do anything about it."""
        program = self.trace.program
        severity = Severity.NOTE if code == NOT_LOOKED_AT else Severity.WARNING
        line = min(line, program.source.line_count - 1)
        if line < 0:
            self.diagnostics.append(Diagnostic(code, severity, message, help_text))
        else:
            self.diagnostics.append(program.diagnose(line, code, message, help_text, severity=severity))
