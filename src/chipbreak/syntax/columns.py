"""Numbers of many plain blocks at once."""

from __future__ import annotations

import numpy as np

from chipbreak.kinematics.floats import Floats
from chipbreak.syntax.parse import Program
from chipbreak.syntax.shapes import Shape

_MOST_DECIMALS = 9
# Those that a float holds exactly.
_POWERS: Floats = np.array([10.0**power for power in range(23)])
_LETTERS = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"


def uniform_run(program: Program, first: int, last: int) -> int:
    """The end of the stretch from ``first`` (at most to ``last``) whose lines all have one shape's words."""
    ids = program.plain[first:last]
    if not len(ids) or ids[0] < 0:
        return first + min(1, len(ids))
    wanted = program.shapes[ids[0]]
    same = [
        i
        for i, shape in enumerate(program.shapes)
        if (shape.letters, shape.motion) == (wanted.letters, wanted.motion)
    ]
    start, window = 0, 64
    while start < len(ids):
        other = np.flatnonzero(~np.isin(ids[start : start + window], same))
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
    shapes = {program.shapes[i] if i >= 0 else None for i in np.unique(program.plain[first:last]).tolist()}
    letters = {shape.letters for shape in shapes if shape is not None}
    motions = {shape.motion for shape in shapes if shape is not None}
    says_line = with_line_code and motions == {1}
    if None in shapes or len(letters) != 1 or not (motions == {None} or says_line):
        return None
    source = program.source
    between = _LETTERS + program.table.grammar.separators.encode("latin-1")
    to_blank = bytes.maketrans(between, b" " * len(between))
    text = source.data[source.starts[first] : source.starts[last]]
    text = (text.replace(b"G1 ", b"") if says_line else text).translate(to_blank)
    width = len(next(iter(letters)))
    numbers = _even_numbers(text, last - first, width)
    if numbers is None:
        numbers = np.fromstring(text.decode("ascii"), np.float64, sep=" ")
    if len(numbers) != (last - first) * width:  # block numbers stand between
        return None
    return letters.pop(), numbers.reshape(-1, width)


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
