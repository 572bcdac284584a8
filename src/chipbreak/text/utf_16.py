"""Programs of two bytes a character are refused by name: no control reads them."""

from __future__ import annotations

from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, Severity
from chipbreak.text.span import Place

UTF_16 = "SYN005"
_MARKS = {b"\xff\xfe": "UTF-16", b"\xfe\xff": "UTF-16"}
_MOSTLY = 0.9


def refuse_utf_16(data: bytes, name: str) -> None:
    """Raises ProgramRejectedError (SYN005) for a program in UTF-16, with or without a byte-order mark."""
    encoding = _utf_16_of(data)
    if not encoding:
        return
    message = f"this program is saved with two bytes a character ({encoding}), which no control reads"
    help_text = f"save it as ANSI or UTF-8, or convert it: iconv -f {encoding} -t UTF-8 OLD > NEW"
    raise ProgramRejectedError([Diagnostic(UTF_16, Severity.ERROR, message, help_text, Place(name, 1, 1, 2))])


def _utf_16_of(data: bytes) -> str:
    """Its name for iconv, empty for anything else: every second byte of letters and digits is NUL."""
    if data[:2] in _MARKS:
        return _MARKS[data[:2]]
    if len(data) < 4 or 0 not in data:
        return ""
    first, second = (half.count(0) > _MOSTLY * len(half) for half in (data[0::2], data[1::2]))
    if first == second:
        return ""
    return "UTF-16BE" if first else "UTF-16LE"
