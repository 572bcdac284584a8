"""What an editor shows of a program.

Lines and columns count from 0, columns in UTF-16 units, as editors do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from chipbreak.outcome import Outcome
from chipbreak.pipeline import Result
from chipbreak.report.as_text import about_line
from chipbreak.report.build import report_of
from chipbreak.report.model import Report
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

Judge = Callable[[str], Outcome]


class Stretch(NamedTuple):
    """Characters ``first`` to ``last`` (exclusive) of a line."""

    line: int
    first: int
    last: int


class Finding(NamedTuple):
    """A diagnostic where an editor shows it.  What is about no place is shown at the first line."""

    said: Diagnostic
    at: Stretch


class Repair(NamedTuple):
    """A text that may stand at a place, and what is then no longer wrong; it has been tried."""

    finding: Finding
    text: str


class Checked(NamedTuple):
    """A text, and what was found of it; ``report`` is None where it is rejected."""

    text: str
    findings: tuple[Finding, ...]
    report: Report | None = None


def checked(text: str, judge: Judge, settings: Settings) -> Checked:
    """Everything that is to be said of a text."""
    outcome = judge(text)
    lines = text.split("\n")
    findings = tuple(Finding(one, _stretch(one, lines)) for one in outcome.diagnostics)
    result = outcome.result
    return Checked(text, findings, _report(result, settings) if isinstance(result, Result) else None)


def not_checked(text: str, said: Diagnostic) -> Checked:
    """A text of which nothing can be said, and why: the profile cannot be used."""
    return Checked(text, (Finding(said._replace(place=None), _stretch(None, text.split("\n"))),))


def _report(result: Result, settings: Settings) -> Report:
    return report_of(result, settings)


def _stretch(said: Diagnostic | None, lines: list[str]) -> Stretch:
    """Where a diagnostic points; its columns are bytes of UTF-8, in which an editor's text is judged."""
    if said is None or said.place is None:
        return Stretch(0, 0, _units(lines[0].rstrip("\r")))
    line = min(said.place.line, len(lines)) - 1
    raw = lines[line].rstrip("\r").encode("utf-8", "replace")
    ends = (min(max(one - 1, 0), len(raw)) for one in (said.place.column, said.place.end_column))
    first, last = (_units(raw[:end].decode("utf-8", "ignore")) for end in ends)
    return Stretch(line, first, last)


def _units(text: str) -> int:
    return len(text.encode("utf-16-le", "surrogatepass")) // 2


def told_of(found: Checked, line: int) -> str:
    """What 'explain' says of a line: its cut, why it stays as it was, its operation.  Empty for nothing."""
    return "\n".join(about_line(found.report, line + 1)) if found.report is not None else ""


def repairs(found: Checked, first: int, last: int, judge: Judge) -> Iterator[Repair]:
    """The ways out of what is wrong from line ``first`` to ``last``, each tried.

    One counts that takes its own error away and brings no other.
    """
    for finding in found.findings:
        if first <= finding.at.line <= last:
            for text in finding.said.instead:
                if _helps(found, finding, judge(with_text(found.text, finding.at, text))):
                    yield Repair(finding, text)


def with_text(text: str, at: Stretch, other: str) -> str:
    """A text with another one at a place."""
    lines = text.split("\n")
    units = lines[at.line].encode("utf-16-le", "surrogatepass")
    before, behind = units[: 2 * at.first], units[2 * at.last :]
    whole = before + other.encode("utf-16-le") + behind
    lines[at.line] = whole.decode("utf-16-le", "surrogatepass")
    return "\n".join(lines)


def _helps(found: Checked, finding: Finding, outcome: Outcome) -> bool:
    was = [one.said for one in found.findings]
    now = outcome.diagnostics
    same = (finding.said.code, finding.at.line + 1)
    gone = same not in [(one.code, one.place.line) for one in now if one.place]
    return gone and _errors(now) <= _errors(was)


def _errors(said: list[Diagnostic] | tuple[Diagnostic, ...]) -> int:
    return sum(one.severity is Severity.ERROR for one in said)
