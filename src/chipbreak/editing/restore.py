"""The way back: a filtered program to the original bytes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from chipbreak.editing import bracket
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source, UserLines, in_a_row, read, user_lines

EDITED = "RES001"
BROKEN = "RES002"


class Region(NamedTuple):
    """One bracketed change in a filtered program.

    Lines ``first`` (BEGIN or UNROLLED) to ``last`` (exclusive, behind END or ROLLED); ``body`` is the first
    line behind the WAS and HEX lines; ``original`` the bytes that were there.
    """

    first: int
    body: int
    last: int
    title: str
    original: bytes


def regions(source: Source, layer: bracket.Layer = bracket.CHANGES) -> list[Region]:
    """The changes in a filtered program; of the outer layer once the inner one has been taken off.

    Raises ProgramRejectedError: RES001 when a bracketed part was edited, RES002 when a bracket is broken.
    """
    found: list[Region] = []
    at = bracket.find(source.data, layer.begin)
    while at >= 0:
        line = int(np.searchsorted(source.starts, at, "right")) - 1
        match = bracket.LINE.fullmatch(source.raw(line).rstrip(b"\r\n"))
        if match and match["kind"].decode() == layer.begin:
            region = _region(source, line, match["text"].decode("latin-1"), layer)
            found.append(region)
            at = bracket.find(source.data, layer.begin, int(source.starts[region.last]))
        else:
            at = bracket.find(source.data, layer.begin, at + 1)
    return found


def _region(source: Source, first: int, title: str, layer: bracket.Layer) -> Region:
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
    last = _end_line(source, first, layer)
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


def _end_line(source: Source, first: int, layer: bracket.Layer) -> int:
    """The line behind the bracket that closes the one in line ``first``."""
    start = int(source.starts[first + 1])
    at = bracket.find(source.data, layer.end, start)
    inner = bracket.find(source.data, layer.begin, start, max(at, start))
    if at < 0 or inner >= 0:
        raise _broken(source, first, f"the {layer.end} comment of this part is missing")
    line = int(np.searchsorted(source.starts, at, "right")) - 1
    if bracket.LINE.fullmatch(source.raw(line).rstrip(b"\r\n")) is None:
        raise _broken(source, line, f"this {layer.end} comment cannot be read")
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
    found = Diagnostic(
        code, Severity.ERROR, message, help_text, source.place(line), source.shown(line), source.encoding
    )
    return ProgramRejectedError([found])


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
    if not bracket.has_any(source.data):
        return source
    for layer in bracket.LAYERS:
        source = _without(source, regions(source, layer))
    return source


def outermost(source: Source) -> list[range]:
    """The lines of all that was written by chipbreak, its comments included, in order.

    A change inside a cycle that was written out, or inside offset blocks, is part of that.  Raises
    ProgramRejectedError as :func:`regions` does.
    """
    if not bracket.has_any(source.data):
        return []
    found: list[range] = []
    for layer in bracket.LAYERS:
        changes = regions(source, layer)
        place = user_lines(source, 0, source.line_count).numbers
        outer = [range(int(place[one.first]) - 1, int(place[one.last - 1])) for one in changes]
        inner = (one for one in found if not any(one.start in around for around in outer))
        found = sorted([*inner, *outer], key=lambda one: one.start)
        source = _without(source, changes)
    return found


def _without(source: Source, found: Sequence[Region]) -> Source:
    """The program without these changes."""
    if not found:
        return source
    pieces = []
    line = 0
    for region in found:
        pieces += [user_lines(source, line, region.first), _kept_at(source, region)]
        line = region.last
    pieces.append(user_lines(source, line, source.line_count))
    return read(b"".join(restored(source, found)), source.name, in_a_row(pieces))


def _kept_at(source: Source, region: Region) -> UserLines:
    """For every original line of a change: where the comment that keeps it stands in the user's file."""
    comments = user_lines(source, region.first + 1, region.body)
    offsets: list[int] = []
    shifts: list[int] = []
    at = 0
    for line, shift in zip(range(region.first + 1, region.body), comments.shifts.tolist(), strict=True):
        match = bracket.LINE.fullmatch(source.raw(line).rstrip(b"\r\n"))
        assert match is not None
        is_text = match["kind"].decode() == bracket.WAS
        offsets.append(at)
        shifts.append(match.start("text") + shift if is_text and shift >= 0 else -1)
        at += len(match["text"] + source.line_end if is_text else _from_hex(source, line, match["text"]))
    starts = read(region.original).starts[:-1] if region.original else np.empty(0, np.int64)
    of_line = np.searchsorted(offsets, starts, "right") - 1
    return UserLines(comments.file, comments.numbers[of_line], np.array(shifts, np.int64)[of_line])
