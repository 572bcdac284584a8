"""Which check goes to which safe point, and its limit W.

The limit depends on what the tool does *next*: a small chip is no harm before roughing, but leaves its mark
in a finish.  So it is taken from the next operation of the same tool, and after its last use from its
first one, which is what the next workpiece starts with.

The shape of the edge is stored at a tool's first call and stays the reference for all its CHIP CHECKs in
the program: wear adds up, and a new reference at every call would hide it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from chipbreak.checks.calls import DEPTHS, CallSet, CallValues, CheckKind, calls_of, check_blocks
from chipbreak.checks.clashes import clash_of
from chipbreak.checks.durations import check_s, otherwise_s
from chipbreak.checks.findings import NO_BEAM, NO_SAFE_POINT, NO_SHAPE, Findings
from chipbreak.checks.limits import Uses, limit_before
from chipbreak.checks.not_checked import WholeProgram, say_what_is_not_checked
from chipbreak.checks.tool_data_coverage import ToolDataCoverage
from chipbreak.checks.touch_plate import touch_plate_of
from chipbreak.checks.ways_out import NAME_THE_BEAM, SEE_ITS_TRACE
from chipbreak.insertion.obstacles import Obstacles
from chipbreak.insertion.safe_points import NoSafePoint, Range, SafePoint, SafePointFinder
from chipbreak.macros.parameters import missing_of
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.operations.operations import Operation
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.tips import Tip, tip_of


class PlannedCheck(NamedTuple):
    """A check that will be inserted; ``limit_mm`` is the W of a CHIP CHECK.

    ``duration_s`` is about how long it takes, None where its programs are not ours; ``otherwise_s`` how long
    with each of a few settings.
    """

    kind: CheckKind
    tool: int | None
    point: SafePoint
    blocks: tuple[str, ...]
    title: str
    reason: str
    limit_mm: float | None = None
    duration_s: float | None = None
    otherwise_s: tuple[tuple[str, float], ...] = ()


def plan_checks(
    operations: Sequence[Operation],
    interpreted: InterpretedProgram,
    main: MainProgram,
    settings: Settings,
    tools: ToolTable,
) -> tuple[list[PlannedCheck], list[Diagnostic]]:
    """All checks of a program, in its order, and what could not be checked.

    Raises RefusalError when the calls of the profile cannot be used (SET030 to SET037).
    """
    planner = _Planner(operations, interpreted, main, settings, tools)
    planner.run()
    if not planner.planned:
        return [], planner.findings.diagnostics
    findings = Findings(interpreted.program, is_strict=settings.checks.strict)
    missing = _missing_of_beam(settings)
    clash = None if missing else clash_of(interpreted)
    if missing:
        message = f"left out: all checks; nothing says where the tool setter is: no {', '.join(missing)}"
        findings.say(planner.planned[0].point.line, NO_BEAM, message, NAME_THE_BEAM)
    elif clash is not None:
        findings.say(clash.line, clash.code, clash.message, clash.help)
    if findings.diagnostics:
        return [], findings.diagnostics
    check_blocks(settings.checks.calls, settings)
    return planner.planned, planner.findings.diagnostics


def _missing_of_beam(settings: Settings) -> list[str]:
    """The keys that the programs behind the built-in calls cannot do without, and that have no value."""
    calls = settings.checks.calls
    if calls in settings.call_sets:
        return []
    return [f"macros.{key}" for key in missing_of(settings.macros, calls)]


class _Wish(NamedTuple):
    """A check that wants a place."""

    kind: CheckKind
    values: CallValues
    reason: str

    @property
    def title(self) -> str:
        """``CHIP CHECK T2 W0.02``."""
        values = self.values
        parts = [self.kind.title]
        parts += [f"T{values.tool}"] if values.tool is not None else []
        is_limited = self.kind is CheckKind.CHIP_CHECK and values.limit_mm is not None
        parts += [f"W{values.limit_mm:g}"] if is_limited else []
        return " ".join(parts)


class _Planner:
    """One walk over the operations."""

    def __init__(
        self,
        operations: Sequence[Operation],
        interpreted: InterpretedProgram,
        main: MainProgram,
        settings: Settings,
        tools: ToolTable,
    ) -> None:
        self.interpreted = interpreted
        self.main = main
        self.tools = tools
        self.settings = settings
        self.checks = settings.checks
        self.operations = operations
        self.calls: CallSet = calls_of(settings)
        obstacles = Obstacles(interpreted, self.main)
        self.tool_changes = obstacles.tool_changes
        self.finder = SafePointFinder(
            interpreted,
            obstacles,
            calls_end_offset=self.calls.ends_offset,
            calls_in_line=self.calls.in_line,
        )
        self.plate = touch_plate_of(settings)
        # How many workpieces a check is for; the control counts them where the beam is measured, not before.
        self.every = 1
        self.uses = Uses(operations, interpreted)
        self.call_lines: list[int | None] = []  # of each operation: where its tool was called
        for operation in operations:
            before = self.call_lines[-1] if self.call_lines else None
            self.call_lines.append(before if operation.call_line is None else operation.call_line)
        self.planned: list[PlannedCheck] = []
        self.findings = Findings(interpreted.program, is_strict=self.checks.strict)
        self.coverage = ToolDataCoverage(self.checks, self.calls, tools, self.findings)
        self.traced: set[int] = set()
        self.shapeless: set[int] = set()
        self.uses_tool_data = self.calls.uses_tool_data()
        self.is_built_in = self.calls.hands_over_depth()

    def run(self) -> None:
        """Plan visit by visit: what a tool does between its call and the next one."""
        whole = WholeProgram(self.interpreted, self.main, self.operations, self.uses, self.tools)
        say_what_is_not_checked(whole, self.findings)
        is_calibrated = False
        for call, group in groupby(self.uses.cutting, lambda op: self.call_lines[op.index]):
            visit = list(group)
            tool = visit[0].tool
            if tool is None or call is None or not self._is_wanted(tool):
                continue
            if not is_calibrated:
                is_calibrated = self._calibrate(call, tool)
                self.every = self.checks.every if is_calibrated else 1
            self._check_tool(call, visit[0], tool)
            for operation in visit:
                self._check_chips(operation, tool)
        if all(check.kind is CheckKind.CALIBRATE for check in self.planned):
            self.planned.clear()  # a beam that nobody looks at

    def _is_wanted(self, tool: int) -> bool:
        tip = tip_of(self.tools.get(tool))
        if tip is Tip.NO_EDGE or (self.uses_tool_data and tip is Tip.STANDING):
            return False  # a probe or a chip fan; a turning tool: nothing turns in the beam
        return tool not in self.checks.ignore and (not self.checks.only or tool in self.checks.only)

    def _sister(self, tool: int) -> int:
        """The tool that may take its place, 0 where there is none."""
        return self.checks.sister.get(str(tool), 0)

    def _calibrate(self, call: int, tool: int) -> bool:
        """Straight before a tool call: after it the master bar would have to change places.

        False where there is no place for it; the next call is tried then.
        """
        if not self.calls.has(CheckKind.CALIBRATE):
            return True
        ends = [last + 1 for _, last in self.main.bodies if last < call]
        ends += [op.last_cut + 1 for op in self.operations if op.last_cut is not None and op.last_cut < call]
        first = max([self.main.first, *ends])
        where = Range(first, call, call, at_start=not self.main.has_work(self.main.first, call))
        reason = "the beam is measured once a workpiece, before the first tool is called"
        every = self.checks.every
        if every > 1:
            reason += f"; the control counts, and checks every {every} workpieces"
        wish = _Wish(CheckKind.CALIBRATE, CallValues(every=every), reason)
        so = f" before T{tool}, which is measured by the beam as it was last found, if ever"
        return self._place(where, wish, without=so)

    def _check_tool(self, call: int, operation: Operation, tool: int) -> None:
        """TOOL CHECK and TRACE, after the tool call and before its first cut."""
        assert operation.first_cut is not None
        first = self._behind_stop(call, operation.first_cut) if self.calls.in_line else call + 1
        where = Range(first, first, operation.first_cut)
        data = self.tools.get(tool)
        limit = limit_before(operation, self.settings, "")
        values = CallValues(
            tool,
            operation.speed_rpm,
            self.checks.trace_height_mm,
            limit.w_mm,
            limit.next_kind.value.upper(),
            data,
            self.every,
            self._sister(tool),
            DEPTHS.index(self.checks.depth),
        )
        if self.checks.depth == "breakage" and self.calls.hands_over_depth():
            values = values._replace(height_mm=0.0)  # no edge is looked at
        called = f"called in line {self.interpreted.program.source.place(call).line}"
        wishes = []
        if self.coverage.allows(CheckKind.TOOL_CHECK, values, operation.first_cut):
            reason = f"T{tool} is {called} and has not cut yet"
            reason += f"; T{values.sister} may take its place" if values.sister else ""
            wishes.append(_Wish(CheckKind.TOOL_CHECK, values, reason))
        if tool not in self.traced and self.coverage.allows(CheckKind.TRACE, values, operation.first_cut):
            reason = f"the edge of T{tool}, {called}, is stored before its first cut"
            wishes.append(_Wish(CheckKind.TRACE, values, reason))
        if wishes and self._place(where, *wishes) and wishes[-1].kind is CheckKind.TRACE:
            self.traced.add(tool)

    def _check_chips(self, operation: Operation, tool: int) -> None:
        """CHIP CHECK at the end of an operation, with the limit of what the tool does next."""
        limit = (
            self.uses.limit_after(operation, self.settings) if self.calls.has(CheckKind.CHIP_CHECK) else None
        )
        if limit is None:
            return
        assert operation.last_cut is not None
        if self.calls.has(CheckKind.TRACE) and tool not in self.traced:
            if tool not in self.shapeless:
                message = (
                    f"left out: CHIP CHECK T{tool} until it is called again; no shape of its edge was stored"
                )
                self.findings.say(operation.last_cut, NO_SHAPE, message, SEE_ITS_TRACE)
            self.shapeless.add(tool)
            return
        values = CallValues(
            tool=tool,
            height_mm=self.checks.trace_height_mm,
            limit_mm=limit.w_mm,
            operation=limit.next_kind.value.upper(),
            data=self.tools.get(tool),
            every=self.every,
            sister=self._sister(tool),
            depth=DEPTHS.index(self.checks.depth),
        )
        if not self.coverage.allows(CheckKind.CHIP_CHECK, values, operation.last_cut):
            return
        last = self._last_place_after(operation.last_cut, operation)
        where = Range(operation.last_cut + 1, min(operation.last_line, last), last)
        self._place(where, _Wish(CheckKind.CHIP_CHECK, values, limit.reason))

    def _behind_stop(self, call: int, first_cut: int) -> int:
        """Where the new tool is in the spindle: somebody changes it at the last M0 behind its call."""
        stops = [e.block.line for e in self.interpreted.effects_of(call, first_cut) if e.does("stop")]
        return max([call, *stops]) + 1

    def _last_place_after(self, last_cut: int, operation: Operation) -> int:
        """The line of the next tool change, also of one after which nothing is cut, or of the next cut."""
        cuts = (later.first_cut for later in self.operations[operation.index + 1 :])
        next_cut = next((line for line in cuts if line is not None), self.main.last)
        changes = (line for line in self.tool_changes if last_cut < line < next_cut and self.main.has(line))
        last = next(changes, next_cut)
        if not self.calls.in_line:
            return last
        # At a stop somebody may change the tool, before or behind the T that says its number.
        stops = (e.block.line for e in self.interpreted.effects_of(last_cut, last) if e.does("stop"))
        return next(stops, last)

    def _place(self, where: Range, *wishes: _Wish, without: str = "") -> bool:
        """Plan checks at the first safe point of a range, or say why there is none, and what that means."""
        comes_back = all(wish.kind in self.calls.returning for wish in wishes)
        found = self.finder.find(where, comes_back=comes_back)
        if isinstance(found, NoSafePoint):
            titles = ", ".join(wish.title for wish in wishes)
            message = f"left out: {titles}{without}; nothing can be inserted here, because {found.why}"
            self.findings.say(found.line, NO_SAFE_POINT, message, found.help)
            return False
        for wish in wishes:
            offset = str(found.state.modes.value("work_offset"))
            values = wish.values._replace(plate=self.plate, work_offset=offset)
            blocks = self.calls.text(wish.kind, values, is_inch=found.state.is_inch)
            self.planned.append(
                PlannedCheck(
                    wish.kind,
                    wish.values.tool,
                    found,
                    blocks,
                    wish.title,
                    wish.reason,
                    wish.values.limit_mm,
                    check_s(wish.kind, wish.values, self.settings) if self.is_built_in else None,
                    otherwise_s(wish.kind, wish.values, self.settings) if self.is_built_in else (),
                )
            )
        return True
