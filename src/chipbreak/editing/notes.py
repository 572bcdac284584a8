"""Comments of our own that change nothing: who wrote a program, and what the operator should read."""

from __future__ import annotations

import re
from collections.abc import Iterable

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Promise
from chipbreak.settings.fingerprint import fingerprint
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import Program
from chipbreak.text.diagnostics import Diagnostic, Severity
from chipbreak.text.named_tuple import NamedTuple

_STAMP = re.compile(rb"CHIPBREAK BEGIN STAMP (\S+) (.*?) ([0-9A-F]{8})\b")
_UNSAFE = re.compile(r"[^A-Za-z0-9 .,=_+/-]")
_WHO = "chipbreak"


class Stamp(NamedTuple):
    """Who filtered a program: version, the profile's name in capitals, and its fingerprint."""

    version: str
    profile: str
    fingerprint: str


def stamp_edit(program: Program, settings: Settings) -> Edit:
    """One comment that says version, profile and the profile's fingerprint."""
    from importlib.metadata import version  # noqa: PLC0415 (slow, and most runs write none)

    name = settings.name.replace("\\", "/").rpartition("/")[2].removesuffix(".toml")
    title = f"STAMP {version('chipbreak').partition('+')[0]} {name} {fingerprint(settings)}"
    return Edit(*_place(program), (), title, "the profile stamps what it filters", Promise(), _WHO)


def stamp_of(data: bytes) -> Stamp | None:
    """The stamp of a filtered program, None without one."""
    match = _STAMP.search(data)
    if match is None:
        return None
    return Stamp(*(part.decode("latin-1") for part in match.groups()))


def messages_edit(program: Program, settings: Settings, diagnostics: Iterable[Diagnostic]) -> Edit | None:
    """The warnings as comments, which LinuxCNC shows to the operator when it runs them; None without any.

    None either in a program in which nothing is run.
    """
    said = [one for one in diagnostics if one.severity is Severity.WARNING]
    first, last = _place(program)
    if not said or first == program.source.body.stop:
        return None
    lines = [_line(one, settings) for one in said]
    return Edit(first, last, tuple(lines), "MESSAGES", "asked for", Promise(), _WHO)


def _line(one: Diagnostic, settings: Settings) -> str:
    """A warning in one comment; what no comment can hold is left out."""
    marks = settings.dialect.comment_marks
    where = f"line {one.place.line}, " if one.place else ""
    said = f"{where}{one.code} {one.message}".replace("%", " percent ")
    text = " ".join(_UNSAFE.sub(" ", said).split())
    head = f"{marks.before}{settings.dialect.message_mark}{_WHO} "
    room = settings.control.max_line_chars - len(head) - len(marks.behind)
    line = f"{head}{text[:room].rstrip()}{marks.behind}"
    return line if settings.dialect.reads_comments_in_lower_case else line.upper()


def _place(program: Program) -> tuple[int, int]:
    """Before the first block that does anything; a program number or a title stays in front."""
    body = program.source.body
    first = next((line for line in body if does_something(program, line)), body.stop)
    return first, first


def does_something(program: Program, line: int) -> bool:
    """False for blank lines, comments, program numbers and names."""
    block = program.block(line)
    is_named = bool(block.marks) and not block.words
    words = [word.address for word in block.words]
    return not (block.is_empty or is_named or words == ["O"])
