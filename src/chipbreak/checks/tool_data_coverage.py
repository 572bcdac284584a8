"""Whether all that a call says about a tool is known, and a word about what is not."""

from __future__ import annotations

from chipbreak.checks.calls import CallSet, CallValues, CheckKind
from chipbreak.checks.findings import LEFT_TO_CONTROL, NO_SPEED, Findings
from chipbreak.checks.tool_values import source_field
from chipbreak.checks.ways_out import GIVE_THE_SPEED, GIVE_THE_TOOL_DATA, LEAVE_THE_CHECK_OUT
from chipbreak.settings.sections import Checks
from chipbreak.text.diagnostics import Severity
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.needs import not_given


class ToolDataCoverage:
    """What is known of the tools of a program; ``findings`` collects what is said."""

    def __init__(self, checks: Checks, calls: CallSet, tools: ToolTable, findings: Findings) -> None:
        self.checks = checks
        self.calls = calls
        self.tools = tools
        self.findings = findings
        self._said: set[tuple[int, str]] = set()

    def allows(self, kind: CheckKind, values: CallValues, first_cut: int) -> bool:
        """True when the set has such a call, and all it says about the tool and its speed is known."""
        return (
            self.calls.has(kind)
            and self._has_speed(kind, values, first_cut)
            and self._has_data(kind, values, first_cut)
        )

    def _has_speed(self, kind: CheckKind, values: CallValues, first_cut: int) -> bool:
        needs_speed = any(self.calls.needs(one, "speed_rpm") for one in self.calls.counts_on(kind))
        if values.speed_rpm is not None or not needs_speed:
            return True
        message = f"left out: {kind.title} T{values.tool}; the spindle speed of this cut is not known"
        self.findings.say(first_cut, NO_SPEED, message, GIVE_THE_SPEED)
        return False

    def _has_data(self, kind: CheckKind, values: CallValues, first_cut: int) -> bool:
        lacking = self.calls.lacking(kind, values)
        tool = values.tool or 0
        names = list(dict.fromkeys(source_field(name, self.tools.get(tool)) for name in lacking))
        left_to_control = self.checks.missing == "control" and self.calls.text(kind, values, is_inch=False)
        if lacking and left_to_control:
            self._say_left_to_control(names, tool, first_cut)
            return True
        for name in names:
            self._say_missing(kind, tool, name, first_cut)
        return not lacking

    def _say_left_to_control(self, names: list[str], tool: int, line: int) -> None:
        """Once for each tool: the check is made, but the control must know the tool itself."""
        if (tool, "") not in self._said:
            self._said.add((tool, ""))
            message = (
                f"nobody gave {', '.join(names)} of T{tool}: the call that tells the control is left out,"
                " and the check alarms unless the control knows the tool"
            )
            self.findings.say(line, LEFT_TO_CONTROL, message, GIVE_THE_TOOL_DATA)

    def _say_missing(self, kind: CheckKind, tool: int, name: str, line: int) -> None:
        """Once for each field of a tool: TOOL CHECK and TRACE want the same."""
        if (tool, name) not in self._said:
            self._said.add((tool, name))
            # A call that says nothing but what is missing cannot be left to the control.
            severity = Severity.WARNING if self.checks.missing == "skip" else Severity.ERROR
            found = not_given(self.tools.get(tool), kind.title, name, severity)
            way_out = found.help + ("" if self.checks.missing == "skip" else LEAVE_THE_CHECK_OUT)
            self.findings.add(line, found.code, severity, found.message, way_out)
