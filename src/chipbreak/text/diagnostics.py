"""Diagnostics are values: a code that never changes meaning, a severity, a place, a cause and a way out."""

from __future__ import annotations

import enum
from collections.abc import Iterable
from typing import Any

from chipbreak.text.encoding import LATIN_1, cells, escaped, meant
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.span import Place


class Severity(enum.Enum):
    """How much a diagnostic weighs: an error stops all output."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Diagnostic(NamedTuple):
    """One finding.

    ``line_text`` is the line it points at, without its line end: of a program as latin-1 text, one character
    a byte, which means what ``encoding`` says.  ``instead`` are texts that may stand where it points, each a
    way out of its own; an editor writes them.
    """

    code: str
    severity: Severity
    message: str
    help: str = ""
    place: Place | None = None
    line_text: str = ""
    encoding: str = LATIN_1
    instead: tuple[str, ...] = ()

    def render(self) -> str:
        """The text for stderr: place, severity, code and message, the line with a caret, and the way out.

        What cannot be printed is escaped: neither a file nor its name gives orders to a terminal.
        """
        head = f"{self.place}: " if self.place else ""
        lines = [escaped(f"{head}{self.severity.value} {self.code}: {self.message}")]
        if self.place and self.line_text:
            lines += self._line_and_caret(self.place)
        if self.help:
            lines.append(escaped(f"  help: {self.help}"))
        return "\n".join(lines)

    def _line_and_caret(self, place: Place) -> list[str]:
        """The line around the place, and a caret under the place."""
        first = max(0, place.column - 60)
        at = place.column - 1
        end = max(at + 1, min(place.end_column - 1, first + 99))
        before, inside, behind = (
            escaped(meant(self.line_text[a:b].replace("\t", " "), self.encoding))
            for a, b in ((first, at), (at, end), (end, first + 100))
        )
        beyond = max(0, end - max(at, len(self.line_text)))  # the line may end before the place
        missing = max(0, at - max(first, len(self.line_text)))
        caret = " " * (cells(before) + missing) + "^" * (cells(inside) + beyond)
        return [f"    {before}{inside}{behind}".rstrip(), f"    {caret}"]

    def as_json(self) -> dict[str, Any]:
        """The same facts for a program to read."""
        span = None
        if self.place:
            span = {"line": self.place.line, "column": self.place.column, "end_column": self.place.end_column}
        return {
            "code": self.code,
            "severity": self.severity.value,
            "file": self.place.file if self.place else None,
            "span": span,
            "message": self.message,
            "help": self.help,
            "instead": list(self.instead),
        }


# Errors keep what they were made of in ``args``: Python pickles and copies them by that.


class ChipbreakError(Exception):
    """What this package raises for those who call it; each kind below says more."""

    __module__ = "chipbreak"


class ProgramRejectedError(ChipbreakError):
    """The program has an error in it; ``diagnostics`` says which.  No output may be written."""

    __module__ = "chipbreak"

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        return "; ".join(d.message for d in self.diagnostics if d.severity is Severity.ERROR)


class SelfCheckError(ChipbreakError):
    """The output does not do what was promised: a fault of this program.  Nothing may be written."""

    __module__ = "chipbreak"


class RefusalError(Exception):
    """A calculation that cannot be done honestly.

    Code without a place in a program raises it with a code, the cause and the way out; the caller that
    knows the block turns it into a :class:`Diagnostic`.  ``instead`` is the way out as words to write:
    ``N1.5``.
    """

    def __init__(self, code: str, message: str, help: str = "", instead: tuple[str, ...] = ()) -> None:
        super().__init__(code, message, help, instead)
        self.code = code
        self.message = message
        self.help = help
        self.instead = instead

    def __str__(self) -> str:
        return self.message


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """True when any of them stops the output."""
    return any(d.severity is Severity.ERROR for d in diagnostics)
