"""Whether all that a call says about a tool is known, and a word about what is not."""

from __future__ import annotations

from chipbreak.checks.calls import CallSet, CallValues, Event
from chipbreak.checks.tool_values import source_field
from chipbreak.settings.sections import Checks
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.needs import not_given

NO_BORDER, NO_SPEED, NO_SHAPE = "CHK002", "CHK003", "CHK004"
NOT_LOOKED_AT, WHICH_TOOL, LEFT_TO_CONTROL = "CHK005", "CHK006", "CHK007"
SHARED_VARIABLE = "CHK009"
# A check that is left out; a strict profile makes an error of it.
_LEFT_OUT = (NO_BORDER, NO_SPEED, NO_SHAPE, WHICH_TOOL, SHARED_VARIABLE)


class Known:
    """What is known of the tools of a program; ``diagnostics`` collects what is said."""

    def __init__(self, program: Program, checks: Checks, calls: CallSet, tools: ToolTable) -> None:
        self.program, self.checks, self.calls, self.tools = program, checks, calls, tools
        self.diagnostics: list[Diagnostic] = []
        self._said: set[tuple[int, str]] = set()

    def allows(self, event: Event, values: CallValues, first_cut: int) -> bool:
        """True when the set has such a call, and all it says about the tool and its speed is known."""
        if not self.calls.has(event):
            return False
        needs_speed = any(self.calls.needs(one, "speed_rpm") for one in self.calls.counts_on(event))
        if values.speed_rpm is None and needs_speed:
            message = f"left out: {event.title} T{values.tool}; the spindle speed of this cut is not known"
            help_text = "give S and M3 or M4 before the cut, behind any block that a jump or a loop reaches"
            self.say(first_cut, NO_SPEED, message, help_text)
            return False
        lacking = self.calls.lacking(event, values)
        left_to_control = self.checks.missing == "control" and self.calls.text(event, values, is_inch=False)
        if lacking and left_to_control:
            self._say_left_to_control(lacking, values.tool or 0, first_cut)
            return True
        for name in dict.fromkeys(source_field(name, self.tools.get(values.tool or 0)) for name in lacking):
            self._say_missing(event, values.tool or 0, name, first_cut)
        return not lacking

    def _say_left_to_control(self, lacking: list[str], tool: int, line: int) -> None:
        """Once for each tool: the check stands, but the control must know the tool itself."""
        fields = dict.fromkeys(source_field(name, self.tools.get(tool)) for name in lacking)
        if (tool, "") not in self._said:
            self._said.add((tool, ""))
            message = (
                f"nobody gave {', '.join(fields)} of T{tool}: the call that tells the control is left out,"
                " and the check alarms unless the control knows the tool"
            )
            help_text = "give them in a tool file (--tools FILE); with checks.missing=error this is an error"
            self.say(line, LEFT_TO_CONTROL, message, help_text)

    def _say_missing(self, event: Event, tool: int, name: str, line: int) -> None:
        """Once for each field of a tool: TOOL CHECK and TRACE want the same."""
        if (tool, name) not in self._said:
            self._said.add((tool, name))
            # A call that says nothing but what is missing cannot be left to the control.
            severity = Severity.WARNING if self.checks.missing == "skip" else Severity.ERROR
            found = not_given(self.tools.get(tool), event.title, name, severity)
            skip = "" if self.checks.missing == "skip" else "; checks.missing=skip leaves the check out"
            help_text = found.help + skip
            self.diagnostics.append(
                self.program.diagnose(line, found.code, found.message, help_text, severity=severity)
            )

    def say(self, line: int, code: str, message: str, help_text: str = "") -> None:
        """A warning at a line of the program, a note where nobody can do anything about it."""
        severity = Severity.NOTE if code == NOT_LOOKED_AT else Severity.WARNING
        if self.checks.strict and code in _LEFT_OUT:
            severity = Severity.ERROR
        line = min(line, self.program.source.line_count - 1)
        if line < 0:
            self.diagnostics.append(Diagnostic(code, severity, message, help_text))
        else:
            self.diagnostics.append(self.program.diagnose(line, code, message, help_text, severity=severity))
