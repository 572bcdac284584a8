"""One program of many: what a worker gets, and what it gives back.  Both cross processes and machines."""

from __future__ import annotations

import time

from chipbreak.outcome import Outcome, failed, internal_fault, outcome_of
from chipbreak.pipeline import rewrite
from chipbreak.report.build import report_of
from chipbreak.report.model import Report
from chipbreak.settings import Settings
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.text.named_tuple import NamedTuple

# The profile names a file of tools: a worker on another machine needs it under the same name.


class Task(NamedTuple):
    """A program to filter, with the file beside it.  ``number`` is its place among the others."""

    number: int
    name: str
    data: bytes
    settings: Settings
    allow_unbroken: bool = False
    beside: bytes | None = None


class Finished(NamedTuple):
    """What became of a program: ``code`` as a run of its own would exit with.

    ``data`` is the program to write, ``beside`` the file beside it where there is to be one, ``report`` what
    is said of it; all None unless ``code`` is 0.
    ``duration_s`` is what the filter took.
    """

    number: int
    name: str
    code: int
    diagnostics: tuple[Diagnostic, ...]
    data: bytes | None = None
    report: Report | None = None
    duration_s: float = 0.0
    beside: bytes | None = None


def filtered(task: Task) -> Finished:
    """Filter one program; never raises."""
    begin_s = time.perf_counter()
    outcome = _outcome(task)
    took_s = time.perf_counter() - begin_s
    finished = Finished(task.number, task.name, outcome.code, outcome.diagnostics, duration_s=took_s)
    result = outcome.result
    if result is None:
        return finished
    report = report_of(result, task.settings)
    return finished._replace(data=result.data, beside=result.beside, report=report)


def _outcome(task: Task) -> Outcome:
    try:
        return outcome_of(
            lambda: rewrite(
                task.data, task.settings, task.name, beside=task.beside, allow_unbroken=task.allow_unbroken
            )
        )
    except Exception as error:  # one program must not end the others
        return internal_fault(error)


def lost(task: Task, why: str) -> Finished:
    """The outcome of a program whose worker died more than once."""
    help_text = "nothing was written for it; run it alone to see why: it may need more memory than there is"
    outcome = failed("BAT001", f"the worker that filtered it died: {why}", help_text)
    return Finished(task.number, task.name, outcome.code, outcome.diagnostics)
