"""Brackets in a file beside the program, for controls that choke on comments.

The program then has the new blocks alone, and ``NAME.chipbreak`` has the bracket comments, each with its
place.  Put together they are the program with its comments, byte for byte, so all else (the way back,
:mod:`chipbreak.self_check`, comparison) knows one form only.

The file is JSON::

    {"chipbreak": 1, "programs": [{"sha256": "...", "brackets": [[5, 0, "(CHIPBREAK BEGIN VIB N1.5)\\n"]]}]}

``sha256`` is that of the program without the comments; a text belongs before the character at that column
(from 0) of that line (from 1).  A program that is not among those is never guessed at.  There are several
because the program before it was filtered is known too, and, while the files are written one after the other,
the one that stood there before: whenever a run is killed, what is on the disk fits together.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any, Final

import numpy as np

from chipbreak.editing import bracket
from chipbreak.editing.restore import outermost, restore
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, SelfCheckError, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import TAPE_LINE_END, Source, UserLines, read

SUFFIX: Final = ".chipbreak"
OTHER_PROGRAM = "RES003"
UNREADABLE = "RES004"
_FORMAT = 1
_LINE_ENDS = (b"\n", b"\r\n", b"\r")


class Piece(NamedTuple):
    """A text that was taken out, and where: the line (from 1) and the column (from 0) of what is left."""

    line: int
    column: int
    text: str


class Bare(NamedTuple):
    """A program by its hash, and what was taken out of it, in order; nothing of one that has its comments."""

    sha256: str
    brackets: tuple[Piece, ...] = ()


class Parted(NamedTuple):
    """A program without its brackets, and the file beside it; None where nothing was taken out."""

    data: bytes
    beside: bytes | None


# --- taking them out ------------------------------------------------------------------------------------
def parted(data: bytes, name: str) -> Parted:
    """Take the brackets out of a filtered program, and look whether they can be put back.

    Raises ProgramRejectedError as :func:`chipbreak.editing.restore.regions` does, SelfCheckError.
    """
    source = read(data, name)
    cuts = list(_joined(_cuts(source), source))
    if not cuts:
        return Parted(data, None)
    firsts = [0, *(stop for _, stop in cuts)]
    lasts = [*(start for start, _ in cuts), len(data)]
    bare = b"".join(data[first:last] for first, last in zip(firsts, lasts, strict=True))
    entry = Bare(_hash(bare), tuple(_pieces(data, bare, cuts)))
    beside = _printed([entry, Bare(_hash(restore(source).data))])
    if with_brackets(bare, name, beside).data != data:
        raise SelfCheckError("the comments cannot be put back into the program without them")
    return Parted(bare, beside)


def _cuts(source: Source) -> Iterator[tuple[int, int]]:
    """The bytes of every bracket: the whole line, or what follows a block number."""
    for lines in outermost(source):
        stop = int(source.starts[lines.stop])
        at = source.data.find(bracket.NAME, int(source.starts[lines.start]), stop)
        while at >= 0:
            line = int(np.searchsorted(source.starts, at, "right")) - 1
            yield from _cut(source, line)
            at = source.data.find(bracket.NAME, int(source.starts[line + 1]), stop)


def _cut(source: Source, line: int) -> Iterator[tuple[int, int]]:
    raw = source.raw(line)
    text = raw.rstrip(b"\r\n")
    match = bracket.LINE.fullmatch(text)
    if match is None:
        return
    start = int(source.starts[line])
    number = text[: text.index(b"(" if match["parenthesis"] else b";")].rstrip(b" \t")
    if number:
        yield start + len(number), start + len(text)
    else:
        yield start, start + len(raw)


def _joined(cuts: Iterator[tuple[int, int]], source: Source) -> Iterator[tuple[int, int]]:
    """Cuts that touch as one; a file without a last line end keeps none."""
    pending: tuple[int, int] | None = None
    for start, stop in cuts:
        if pending is not None and pending[1] == start:
            pending = (pending[0], stop)
            continue
        if pending is not None:
            yield pending
        pending = (start, stop)
    if pending is None:
        return
    start, stop = pending
    if stop == len(source.data) and not source.data.endswith((b"\n", b"\r")):
        start = len(source.data[:start].removesuffix(source.line_end))
    yield start, stop


def _pieces(data: bytes, bare: bytes, cuts: Sequence[tuple[int, int]]) -> Iterator[Piece]:
    starts = read(bare).starts
    taken = 0
    for start, stop in cuts:
        at = start - taken
        line = max(int(np.searchsorted(starts, at, "right")) - 1, 0)
        yield Piece(line + 1, at - int(starts[line]), data[start:stop].decode("latin-1"))
        taken += stop - start


# --- putting them back ----------------------------------------------------------------------------------
def with_brackets(data: bytes, name: str, beside: bytes | None) -> Source:
    """The program with its comments, from a file beside it; the program itself where there is none.

    Messages about it name the lines of the file it came from.  Raises ProgramRejectedError: RES003 where the
    file beside is about another program, RES004 where it cannot be read.
    """
    if beside is None:
        return read(data, name)
    entry = _entry_of(data, name, _programs(beside, name))
    return _put_back(read(data, name), entry.brackets) if entry.brackets else read(data, name)


def fits(data: bytes, name: str, beside: bytes) -> bool:
    """True where the file beside is about this program; one that cannot be read is about none."""
    try:
        return _found(data, _programs(beside, name)) is not None
    except ProgramRejectedError:
        return False


def _entry_of(data: bytes, name: str, programs: Sequence[Bare]) -> Bare:
    entry = _found(data, programs)
    if entry is None:
        message = (
            f"its file NAME{SUFFIX} is not about this program: it was changed since chipbreak wrote it, or"
            " another one has been put in its place"
        )
        help_text = (
            "change the original and filter that again; where this is a new program that was never filtered,"
            f" remove NAME{SUFFIX}"
        )
        raise _rejected(read(data, name), OTHER_PROGRAM, message, help_text)
    return entry


def _found(data: bytes, programs: Sequence[Bare]) -> Bare | None:
    """The entry of a program; transmission may have changed how its lines end."""
    known = {one.sha256: one for one in reversed(programs)}
    exact = known.get(_hash(data))
    if exact is not None:
        return exact
    end = read(data).line_end.decode("ascii")
    for other in _LINE_ENDS:
        entry = known.get(_hash(TAPE_LINE_END.sub(other, data)))
        if entry is not None:
            brackets = (one._replace(text=_with_ends(one.text, end)) for one in entry.brackets)
            return entry._replace(brackets=tuple(brackets))
    return None


def _with_ends(text: str, end: str) -> str:
    return TAPE_LINE_END.sub(end.encode("ascii"), text.encode("latin-1")).decode("latin-1")


def _put_back(source: Source, brackets: Sequence[Piece]) -> Source:
    """The program with its comments, and where its lines stand in the user's file."""
    places = [_offset(source, one) for one in brackets]
    if places != sorted(places):
        raise _unreadable(source, "its places are not in order")
    texts = [one.text.encode("latin-1") for one in brackets]
    pieces: list[bytes] = []
    line_at = 0
    for place, text in zip(places, texts, strict=True):
        pieces += [source.data[line_at:place], text]
        line_at = place
    pieces.append(source.data[line_at:])
    whole = read(b"".join(pieces), source.name, encoding=source.encoding)
    before = np.array([0, *accumulate(map(len, texts))], np.int64)
    begins = np.array(places, np.int64) + before[:-1]
    starts = whole.starts[:-1]
    count = np.searchsorted(begins, starts, "right")
    is_new = (count > 0) & (starts < begins[count - 1] + np.diff(before)[count - 1])
    at = np.where(is_new, np.array(places, np.int64)[count - 1], starts - before[count])
    numbers = np.clip(np.searchsorted(source.starts, at, "right"), 1, max(source.line_count, 1))
    return whole._replace(user_lines=UserLines(source, numbers, np.where(is_new, -1, 0)))


def _offset(source: Source, piece: Piece) -> int:
    """The place of a piece in the program.  Raises ProgramRejectedError (RES004)."""
    line = piece.line - 1
    is_there = source.line_count > 0 and 0 <= line <= source.line_count
    end = int(source.starts[min(line + 1, source.line_count)]) if is_there else -1
    at = int(source.starts[line]) + piece.column if is_there else 0
    if piece.column < 0 or at > end:
        raise _unreadable(source, "it names a place that the program does not have")
    return at


# --- the file -------------------------------------------------------------------------------------------
def plain(data: bytes) -> bytes:
    """The file beside a program that has nothing taken out."""
    return _printed([Bare(_hash(data))])


def both(beside: bytes, before: bytes, name: str) -> bytes:
    """A file beside that is about the program to come and about the one before it.

    One that cannot be read is about none.
    """
    try:
        return _printed([*_programs(beside, name), *_programs(before, name)])
    except ProgramRejectedError:
        return beside


def _printed(programs: Sequence[Bare]) -> bytes:
    known = {one.sha256: one for one in reversed(programs)}
    unlike = list(reversed(known.values()))
    value = {"chipbreak": _FORMAT, "programs": [one._asdict() for one in unlike]}
    return f"{json.dumps(value, indent=1)}\n".encode("ascii")


def _programs(beside: bytes, name: str) -> list[Bare]:
    """What a file beside says.  Raises ProgramRejectedError (RES004)."""
    try:
        value = json.loads(beside)
    except (ValueError, RecursionError):
        raise _unreadable(read(b"", name), "it is not JSON") from None
    if not isinstance(value, dict) or "chipbreak" not in value:
        raise _unreadable(read(b"", name), "chipbreak did not write it")
    if value["chipbreak"] != _FORMAT:
        raise _unreadable(read(b"", name), "a newer chipbreak has written it")
    try:
        return [Bare(str(one["sha256"]), tuple(map(_piece, one["brackets"]))) for one in value["programs"]]
    except (AttributeError, KeyError, TypeError, ValueError):
        raise _unreadable(read(b"", name), "something in it is missing") from None


def _piece(value: Any) -> Piece:
    """Raises TypeError or ValueError for anything else than a place and a text of ours."""
    line, column, text = value
    if not (isinstance(line, int) and isinstance(column, int) and text.isascii()):
        raise TypeError
    return Piece(line, column, text)


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _unreadable(source: Source, why: str) -> ProgramRejectedError:
    message = f"its file NAME{SUFFIX} cannot be used: {why}"
    help_text = f"take the program from before it was filtered, and remove NAME{SUFFIX}"
    return _rejected(source, UNREADABLE, message, help_text)


def _rejected(source: Source, code: str, message: str, help_text: str) -> ProgramRejectedError:
    place, shown = (source.place(0), source.shown(0)) if source.line_count else (None, "")
    return ProgramRejectedError([Diagnostic(code, Severity.ERROR, message, help_text, place, shown)])
