"""What is said about checks that are left out: the codes, and how much each weighs."""

from __future__ import annotations

from typing import Final

from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity

NO_TOOL_CALL: Final = "CHK001"
NO_SAFE_POINT: Final = "CHK002"
NO_SPEED: Final = "CHK003"
NO_SHAPE: Final = "CHK004"
NOT_LOOKED_AT: Final = "CHK005"
WHICH_TOOL: Final = "CHK006"
LEFT_TO_CONTROL: Final = "CHK007"
SISTER_IS_CALLED: Final = "CHK008"
SHARED_VARIABLE: Final = "CHK009"
SHARED_NUMBER: Final = "CHK010"
NO_BEAM: Final = "CHK011"
SHARED_OFFSET: Final = "CHK012"
# A check that is left out; a strict profile makes an error of it.
_LEFT_OUT: Final = frozenset(
    {NO_SAFE_POINT, NO_SPEED, NO_SHAPE, WHICH_TOOL, SHARED_VARIABLE, SHARED_NUMBER, NO_BEAM, SHARED_OFFSET}
)


class Findings:
    """Collects what is said; ``diagnostics`` holds it."""

    def __init__(self, program: Program, *, is_strict: bool) -> None:
        self.program = program
        self.is_strict = is_strict
        self.diagnostics: list[Diagnostic] = []

    def say(self, line: int, code: str, message: str, way_out: str = "") -> None:
        """A warning at a line of the program, a note where the user can do nothing about it."""
        severity = Severity.NOTE if code == NOT_LOOKED_AT else Severity.WARNING
        if self.is_strict and code in _LEFT_OUT:
            severity = Severity.ERROR
        self.add(line, code, severity, message, way_out)

    def add(self, line: int, code: str, severity: Severity, message: str, way_out: str) -> None:
        """The same with a severity of its own; a line after the last one means the last one."""
        line = min(line, self.program.source.line_count - 1)
        if line < 0:
            self.diagnostics.append(Diagnostic(code, severity, message, way_out))
        else:
            self.diagnostics.append(self.program.diagnose(line, code, message, way_out, severity=severity))
