"""The comments around every change: what was there, and a checksum of what is there now.

::

    (CHIPBREAK BEGIN VIB N1.5 F62.5 S2500)
    (CHIPBREAK WAS G1 Z-30. F0.05 N1.5)
    ...the new blocks...
    (CHIPBREAK END 1F0A33C2)

A line that would not survive inside a comment (parentheses, lower case, other bytes, a foreign line end) is
written as ``(CHIPBREAK HEX ...)``, its bytes in hexadecimal with their line end.  A control whose comments
run to the end of the line has ``; CHIPBREAK BEGIN ...`` instead.

Brackets come in layers.  A cycle that was written out as plain blocks stands between ``UNROLLED`` and
``ROLLED``; blocks under nose compensation that were offset, of such a cycle or of the program itself, stand
between ``COMPENSATED`` and ``OFFSET``; the changes that the passes make to all of these lie inside, between
``BEGIN`` and ``END``.  The way back takes the inner layers off first, so the checksum of an outer one is that
of its plain blocks.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator

from chipbreak.dialects import CommentMarks
from chipbreak.text.named_tuple import NamedTuple

BEGIN = "BEGIN"
WAS = "WAS"
HEX = "HEX"
END = "END"


class Layer(NamedTuple):
    """The words that open and close the brackets of one layer."""

    begin: str
    end: str


CHANGES = Layer(BEGIN, END)
UNROLLED_CYCLES = Layer("UNROLLED", "ROLLED")
OFFSET_RUNS = Layer("COMPENSATED", "OFFSET")
LAYERS = (CHANGES, OFFSET_RUNS, UNROLLED_CYCLES)  # the inner one first
LINE = re.compile(
    rb"[ \t]*(?:[Nn][-+]?[0-9.]+[ \t]*)?(?:(?P<parenthesis>\()|; ?)"
    rb"CHIPBREAK (?P<kind>BEGIN|WAS|HEX|END|UNROLLED|ROLLED|COMPENSATED|OFFSET) ?"
    rb"(?P<text>[^()]*)(?(parenthesis)\))[ \t]*"
)
NAME = b"CHIPBREAK "
_HEX_BYTES_PER_LINE = 30
# What every control takes inside a comment; LinuxCNC also takes lower case and more signs.
_SAFE = re.compile(rb"[A-Z0-9 .,=_+/-]*")
_SAFE_WITH_LOWER_CASE = re.compile(rb"[A-Za-z0-9 .,=_+/#*\[\]<>:-]*")


def comment(kind: str, text: str, marks: CommentMarks) -> str:
    """One bracket line without its end."""
    return f"{marks.before}CHIPBREAK {kind} {text}{marks.behind}".rstrip()


def has_any(data: bytes) -> bool:
    """False where no bracket line of any kind stands."""
    return NAME in data


def find(data: bytes, kind: str, start: int = 0, stop: int | None = None) -> int:
    """Where the next bracket line of a kind may be, -1 where there is none; :data:`LINE` knows for sure."""
    name = NAME + kind.encode("ascii")
    at = data.find(name, start, stop)
    while at >= 0 and not data[max(at - 2, 0) : at].rstrip(b" ").endswith((b"(", b";")):
        at = data.find(name, at + 1, stop)
    return at


def title_text(
    title: str, max_chars: int, marks: CommentMarks, number: str = "", layer: Layer = CHANGES
) -> str:
    """A title made fit for a comment: upper case, no parentheses, not too long after a block number."""
    fit = re.sub(r"[^A-Z0-9 .,=_+/-]", " ", title.upper())
    room = max_chars - _frame(layer.begin, marks) - max(len(number), len("N99999 "))
    return fit[: max(room, 0)].rstrip()


def _frame(kind: str, marks: CommentMarks) -> int:
    """Characters of a bracket line beside its text."""
    return len(f"{marks.before}CHIPBREAK {kind} {marks.behind}")


def was_lines(
    lines: list[bytes], line_end: bytes, max_chars: int, marks: CommentMarks, *, lower_case: bool
) -> Iterator[str]:
    """The bracket lines that keep the original lines (with their ends)."""
    safe = _SAFE_WITH_LOWER_CASE if lower_case else _SAFE
    step = min(_HEX_BYTES_PER_LINE, (max_chars - _frame(HEX, marks)) // 2)
    for raw in lines:
        text = raw.removesuffix(line_end)
        fits = len(text) <= max_chars - _frame(WAS, marks)
        # Blanks at the end of a line get lost where nothing closes the comment.
        shows_its_end = bool(marks.behind) or not text.endswith(b" ")
        if raw.endswith(line_end) and fits and shows_its_end and safe.fullmatch(text):
            yield comment(WAS, text.decode("ascii"), marks)
            continue
        for at in range(0, len(raw), step):
            yield comment(HEX, raw[at : at + step].hex().upper(), marks)


def checksum(content: bytes) -> str:
    """CRC-32 of the lines between the brackets, blind to how lines end (transmission may change that)."""
    if b"\r" in content:
        content = content.replace(b"\n\r\r", b"\n").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return f"{zlib.crc32(content):08X}"
