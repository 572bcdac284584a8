"""Numbers of many plain blocks at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from chipbreak.syntax.parse import Program

_LETTERS_TO_BLANK = bytes.maketrans(b"ABCDEFGHIJKLMNOPQRSTUVWXYZ", b" " * 26)


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


def read_columns(program: Program, first: int, last: int) -> tuple[str, NDArray[np.float64]] | None:
    """Letters and numbers of lines ``first`` to ``last`` (exclusive): ("ZF", array of shape (n, 2)).

    Only for plain blocks that all have the same words in the same order, without block numbers and G codes;
    None otherwise.
    """
    shapes = {program.shapes[i] if i >= 0 else None for i in np.unique(program.plain[first:last]).tolist()}
    letters = {shape.letters for shape in shapes if shape is not None}
    if None in shapes or len(letters) != 1 or any(s is not None and s.motion is not None for s in shapes):
        return None
    source = program.source
    text = source.data[source.starts[first] : source.starts[last]].translate(_LETTERS_TO_BLANK)
    numbers = np.fromstring(text.decode("ascii"), np.float64, sep=" ")
    width = len(next(iter(letters)))
    if len(numbers) != (last - first) * width:  # block numbers stand between
        return None
    return letters.pop(), numbers.reshape(-1, width)
