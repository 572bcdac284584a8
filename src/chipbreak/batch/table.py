"""What became of many programs: a line each, and one for all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from chipbreak.batch.work import Finished
from chipbreak.outcome import DONE, FAILED, REJECTED, USAGE
from chipbreak.text.diagnostics import Severity
from chipbreak.text.encoding import escaped

NOT_WRITTEN = "BAT004"
_WORDS = {DONE: "", USAGE: "NOT READ", REJECTED: "REJECTED", FAILED: "FAILED"}


def table_lines(results: Sequence[Finished]) -> Iterator[str]:
    """The results in the order of the command line, names in one column."""
    width = max((len(escaped(one.name)) for one in results), default=0)
    for one in results:
        yield f"{escaped(one.name):{width}}  {escaped(told(one))}"
    yield ""
    yield total(results)


def total(results: Sequence[Finished]) -> str:
    """``300 programs: 250 written, 8 of them with cuts that vibrate; 30 rejected``."""
    written = [one for one in results if one.report]
    vibrating = sum(bool(one.report and one.report.cuts) for one in written)
    parts = [f"{len(written)} written, {vibrating} of them with cuts that vibrate"]
    unwritten = [one for one in results if _is_unwritten(one)]
    others = [one for one in results if not _is_unwritten(one)]
    counts = [(len(unwritten), "not written")]
    for code, word in ((REJECTED, "rejected"), (USAGE, "not read"), (FAILED, "failed")):
        counts.append((sum(one.code == code for one in others), word))
    parts += [f"{count} {word}" for count, word in counts if count]
    programs = f"{len(results)} programs" if len(results) != 1 else "1 program"
    return f"{programs}: {'; '.join(parts)}"


def told(one: Finished) -> str:
    """What became of one program, in a line."""
    if one.report is not None:
        return one.report.summary()
    errors = [said for said in one.diagnostics if said.severity is Severity.ERROR]
    first = errors[0]
    where = f"line {first.place.line}: " if first.place else ""
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    word = "NOT WRITTEN" if _is_unwritten(one) else _WORDS[one.code]
    return f"{word} {where}{first.code}, {first.message}{more}"


def _is_unwritten(one: Finished) -> bool:
    return any(said.code == NOT_WRITTEN for said in one.diagnostics)


def as_dicts(results: Sequence[Finished]) -> list[dict[str, Any]]:
    """The same for programs: the report of each, or what was said of it."""
    return [
        {
            "file": one.name,
            "exit": one.code,
            "duration_s": one.duration_s,
            "report": None if one.report is None else one.report.as_dict(),
            "diagnostics": [said.as_json() for said in one.diagnostics],
        }
        for one in results
    ]
