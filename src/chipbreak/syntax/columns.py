"""Numbers of many plain blocks at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chipbreak.kinematics.floats import Floats
from chipbreak.syntax.parse import Program
from chipbreak.syntax.shapes import Shape
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source

_MOST_DECIMALS = 9
# Those that a float holds exactly.
_POWERS: Floats = np.array([10.0**power for power in range(23)])
_NEAR = 3  # lines from one repeated line to the next one, at most, where a stretch of them begins
_FEWEST = 8
_LEAST_AT_ONCE = 1 << 6
_MOST_AT_ONCE = 1 << 14
_LETTERS = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def uniform_run(program: Program, first: int, last: int) -> int:
    """The end of the stretch from ``first`` (at most to ``last``) whose lines all have one shape's words."""
    ids = program.plain[first:last]
    if not len(ids) or ids[0] < 0:
        return first + min(1, len(ids))
    alike = program.table.alike()
    start, window = 0, 64
    while start < len(ids):
        other = np.flatnonzero(alike[ids[start : start + window]] != alike[ids[0]])
        if len(other):
            return first + start + int(other[0])
        start, window = start + window, window * 2  # short stretches stay cheap, long ones need few looks
    return last


def read_columns(
    program: Program, first: int, last: int, *, with_line_code: bool = False
) -> tuple[str, Floats] | None:
    """Letters and numbers of lines ``first`` to ``last`` (exclusive): ("ZF", array of shape (n, 2)).

    Only for plain blocks that all have the same words in the same order, without block numbers and G codes;
    None otherwise.  ``with_line_code``: all of them may begin with ``G1``.
    """
    ids = np.flatnonzero(np.bincount(program.plain[first:last] + 1)) - 1
    shapes = {program.shapes[i] if i >= 0 else None for i in ids.tolist()}
    letters = {shape.letters for shape in shapes if shape is not None}
    motions = {shape.motion for shape in shapes if shape is not None}
    says_line = with_line_code and motions == {1}
    if None in shapes or len(letters) != 1 or not (motions == {None} or says_line):
        return None
    source = program.source
    text = source.data[source.starts[first] : source.starts[last]]
    text = text.replace(b"G1 ", b"") if says_line else text
    return _columns(program, text, letters.pop(), last - first)


def _columns(program: Program, text: bytes, letters: str, count: int) -> tuple[str, Floats] | None:
    """The numbers of so many lines that have these letters in a row; None where there are others too."""
    between = _LETTERS + program.table.grammar.separators.encode("latin-1")
    text = text.translate(bytes.maketrans(between, b" " * len(between)))
    numbers = _even_numbers(text, count, len(letters))
    if numbers is None:
        numbers = np.fromstring(text.decode("ascii"), np.float64, sep=" ")
    if len(numbers) != count * len(letters):  # block numbers stand between
        return None
    return letters, numbers.reshape(-1, len(letters))


class Repeats(NamedTuple):
    """Lines ``first`` to ``last`` (exclusive): one that comes again and again, and plain ones between.

    ``repeated`` are those that have the bytes of the first one, (k,); the others all have the words
    ``letters``, with points, and their numbers are ``numbers``, (n, len(letters)).  ``says_line``: each of
    them says G1.
    """

    first: int
    last: int
    repeated: NDArray[np.intp]
    says_line: bool
    letters: str
    numbers: Floats

    @property
    def before(self) -> NDArray[np.intp]:
        """How many of the plain lines stand before each repeated one, (k,)."""
        return self.repeated - self.first - np.arange(len(self.repeated))


def repeats(program: Program, first: int, last: int) -> Repeats | None:
    """The stretch from ``first`` (at most to ``last``) in which that line, no plain one, comes again.

    None where it does not, or the lines between cannot be read all at once.
    """
    following = program.plain[first + 1 : min(first + _NEAR, last)]
    plain = following[following >= 0]
    if not len(plain):
        return None
    wanted = program.shapes[plain[0]]
    if wanted.numbered or not wanted.has_points or wanted.motion not in (None, 1):
        return None
    source = program.source
    raw = source.raw(first)
    # The last one is for lines that have no shape.
    stop = _stop_of(program, first, last, np.array([*(shape == wanted for shape in program.shapes), False]))
    repeated = np.flatnonzero(program.plain[first:stop] < 0) + first
    if len(repeated) < _FEWEST:
        return None
    text = source.data[source.starts[first] : source.starts[stop]]
    if text.count(raw) != len(repeated):
        return None
    text = text.replace(raw, b"").replace(b"G1 ", b"")
    columns = _columns(program, text, wanted.letters, stop - first - len(repeated))
    return None if columns is None else Repeats(first, stop, repeated, wanted.motion == 1, *columns)


def _stop_of(program: Program, first: int, last: int, fits: NDArray[np.bool_]) -> int:
    """The end of the stretch of lines that are the first one again, or have one of the shapes that fit."""
    source = program.source
    raw = source.raw(first)
    start, window = first, _LEAST_AT_ONCE
    while start < last:
        lines = np.arange(start, min(start + window, last))
        others = lines[program.plain[lines] < 0]
        is_same = fits[program.plain[lines]]
        is_same[others - start] = _have_bytes(source, others, raw)
        misfits = np.flatnonzero(~is_same)
        if len(misfits):
            return start + int(misfits[0])
        start, window = start + len(lines), min(2 * window, _MOST_AT_ONCE)
    return last


def _have_bytes(source: Source, lines: NDArray[np.intp], raw: bytes) -> NDArray[np.bool_]:
    """Which lines have these bytes."""
    starts = source.starts[lines]
    alike: NDArray[np.bool_] = source.starts[lines + 1] - starts == len(raw)
    data = np.frombuffer(source.data, np.uint8)
    rows = data[starts[alike][:, np.newaxis] + np.arange(len(raw))]
    alike[alike] = (rows == np.frombuffer(raw, np.uint8)).all(axis=1)
    return alike


def _even_numbers(text: bytes, count: int, width: int) -> Floats | None:
    """The numbers of rows that have the same decimals in every row, read as whole numbers without points.

    A whole number below 2 ** 53 through a power of ten is rounded once, as the decimal itself would be.
    None where the decimals differ.
    """
    raw = np.frombuffer(text, np.uint8)
    points = np.flatnonzero(raw == ord("."))
    if not count or len(points) != count * width:
        return None
    powers = np.empty(width)
    for column in range(width):
        behind = points[column::width] + 1
        first = text[behind[0] : behind[0] + _MOST_DECIMALS]
        decimals = len(first) - len(first.lstrip(b"0123456789"))
        # A digit where the last decimal should stand, and none behind it: so many in every row, for what
        # began in between would have its own point there.
        at_last, at_end = (raw.take(behind + at, mode="clip") for at in (decimals - 1, decimals))
        if (at_last <= ord(" ")).any() or (at_end > ord(" ")).any():
            return None
        powers[column] = 10.0**decimals
    whole = np.fromstring(text.translate(None, b".").decode("ascii"), np.int64, sep=" ")
    if len(whole) != count * width or np.abs(whole).max() >= 2**53:
        return None
    numbers: Floats = (whole.reshape(count, width) / powers).ravel()
    return numbers


def _numbers(text: bytes) -> Floats:
    """The numbers of a text of nothing else, read as whole numbers without points where that is exact.

    It is four times as fast; see :func:`_even_numbers`.
    """
    raw = np.frombuffer(text + b"\n", np.uint8)
    is_end = (raw[:-1] > ord(" ")) & (raw[1:] <= ord(" "))  # the last character of a number
    marks = np.flatnonzero(is_end | (raw[:-1] == ord(".")))
    ends = np.flatnonzero(is_end[marks])
    whole = np.fromstring(text.translate(None, b".").decode("latin-1"), np.int64, sep=" ")
    before = marks[np.maximum(ends - 1, 0)]
    decimals = np.where(is_end[before], 0, marks[ends] - before)  # behind the point, where one is before it
    fits = len(whole) == len(ends) and np.abs(whole).max(initial=0) < 2**53
    if not fits or decimals.max(initial=0) >= len(_POWERS):
        return np.fromstring(text.decode("latin-1"), np.float64, sep=" ")
    numbers: Floats = whole / _POWERS[decimals]
    return numbers


def read_words(program: Program, first: int, last: int, wanted: str) -> Floats | None:
    """The numbers of these letters on lines ``first`` to ``last`` (exclusive), all plain: (n, len(wanted)).

    NaN where a line does not have the letter; None where the lines cannot be read all at once.
    """
    ids = program.plain[first:last]
    written = [_letters_as_written(shape) for shape in program.shapes]
    source = program.source
    text = source.data[source.starts[first] : source.starts[last]]
    between = _LETTERS + program.table.grammar.separators.encode("latin-1")
    numbers = _numbers(text.translate(bytes.maketrans(between, b" " * len(between))))
    stops = np.cumsum(np.array([len(one) for one in written])[ids])
    if len(numbers) != (stops[-1] if len(stops) else 0):
        return None
    columns = np.full((last - first, len(wanted)), np.nan)
    for at, letter in enumerate(wanted.encode("ascii")):
        # How many numbers of its line, from this one on: 0 where the letter is not there.
        behind = np.array([len(one) - one.find(letter) if letter in one else 0 for one in written])
        if behind.any():
            of_line = behind[ids]
            columns[:, at] = np.where(of_line, numbers.take(stops - of_line, mode="clip"), np.nan)
    return columns


def _letters_as_written(shape: Shape) -> bytes:
    """The letter of every number on a line, those of the block number and of the motion code too."""
    head = ("N" if shape.numbered else "") + ("" if shape.motion is None else "G")
    return (head + shape.letters).encode("ascii")
