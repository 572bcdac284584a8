"""The way back: a filtered program to the original bytes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chipbreak.editing import bracket
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, Severity
from chipbreak.text.source import Source, read

EDITED = "RES001"
BROKEN = "RES002"


class Region(NamedTuple):
    """One bracketed change in a filtered program.

    Lines ``first`` (BEGIN) to ``last`` (exclusive, behind END); ``body`` is the first line behind the WAS
    and HEX lines; ``original`` the bytes that were there.
    """

    first: int
    body: int
    last: int
    title: str
    original: bytes


def regions(source: Source) -> list[Region]:
    """The changes in a filtered program.

    Raises ProgramRejectedError: RES001 when a bracketed part was edited, RES002 when a bracket is broken.
    """
    found: list[Region] = []
    at = bracket.find(source.data, bracket.BEGIN)
    while at >= 0:
        line = int(np.searchsorted(source.starts, at, "right")) - 1
        match = bracket.LINE.fullmatch(source.raw(line).rstrip(b"\r\n"))
        if match and match["kind"].decode() == bracket.BEGIN:
            region = _region(source, line, match["text"].decode("latin-1"))
            found.append(region)
            at = bracket.find(source.data, bracket.BEGIN, int(source.starts[region.last]))
        else:
            at = bracket.find(source.data, bracket.BEGIN, at + 1)
    return found


def _region(source: Source, first: int, title: str) -> Region:
    original = bytearray()
    line = first + 1
    while line < source.line_count:
        raw = source.raw(line)
        match = bracket.LINE.fullmatch(raw.rstrip(b"\r\n"))
        kind = match["kind"].decode() if match else ""
        if match and kind == bracket.WAS:
            original += match["text"] + source.line_end
        elif match and kind == bracket.HEX:
            original += _from_hex(source, line, match["text"])
        else:
            break
        line += 1
    body = line
    last = _end_line(source, first)
    content = source.data[source.starts[first + 1] : source.starts[last - 1]]
    end = bracket.LINE.fullmatch(source.raw(last - 1).rstrip(b"\r\n"))
    assert end is not None
    if end["text"].decode("latin-1").strip() != bracket.checksum(content):
        raise _rejected(
            source,
            first,
            EDITED,
            "this part was changed after chipbreak wrote it; restoring it would lose the change",
            "change the original program instead, or delete the CHIPBREAK comments to keep the part as it is",
        )
    return Region(first, body, last, title.strip(), bytes(original))


def _end_line(source: Source, first: int) -> int:
    """The line behind the END that closes a BEGIN."""
    start = int(source.starts[first + 1])
    at = bracket.find(source.data, bracket.END, start)
    inner = bracket.find(source.data, bracket.BEGIN, start, max(at, start))
    if at < 0 or inner >= 0:
        raise _broken(source, first, "the END comment of this part is missing")
    line = int(np.searchsorted(source.starts, at, "right")) - 1
    if bracket.LINE.fullmatch(source.raw(line).rstrip(b"\r\n")) is None:
        raise _broken(source, line, "this END comment cannot be read")
    return line + 1


def _from_hex(source: Source, line: int, text: bytes) -> bytes:
    try:
        return bytes.fromhex(text.decode("ascii"))
    except ValueError:
        raise _broken(source, line, "this HEX comment cannot be read") from None


def _broken(source: Source, line: int, message: str) -> ProgramRejectedError:
    help_text = "take the program from before the damage and filter it again"
    return _rejected(source, line, BROKEN, message, help_text)


def _rejected(source: Source, line: int, code: str, message: str, help_text: str) -> ProgramRejectedError:
    text = source.text(line)
    place = source.place(line)
    return ProgramRejectedError([Diagnostic(code, Severity.ERROR, message, help_text, place, text)])


def restored(source: Source, found: Sequence[Region]) -> Iterator[bytes | memoryview]:
    """The original program in pieces, from the changes that :func:`regions` found."""
    data = memoryview(source.data)
    line = 0
    for region in found:
        yield data[source.starts[line] : source.starts[region.first]]
        yield region.original
        line = region.last
    yield data[source.starts[line] :]


def restores(source: Source, found: Sequence[Region], original: bytes) -> bool:
    """True when putting the program back gives these bytes."""
    at = 0
    for piece in restored(source, found):
        if not original.startswith(piece, at):
            return False
        at += len(piece)
    return at == len(original)


def restore(source: Source) -> Source:
    """The original program.  Messages about it still name the lines of the file it came from.

    Raises ProgramRejectedError as :func:`regions` does.
    """
    found = regions(source)
    if not found:
        return source
    numbers: list[NDArray[np.int64]] = []
    line = 0
    for region in found:
        numbers.append(np.arange(line, region.first) + 1)
        count = read(region.original).line_count if region.original else 0
        numbers.append(np.full(count, region.first + 1))
        line = region.last
    numbers.append(np.arange(line, source.line_count) + 1)
    return read(b"".join(restored(source, found)), source.name, np.concatenate(numbers))
