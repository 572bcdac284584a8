"""What blocks do beside moving and setting modes: variables, statements, marks, M and T, acting comments."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.syntax.comments import acting_comments
from chipbreak.syntax.nodes import Assignment, Block, Control


def deeds_in(interpreted: InterpretedProgram, first: int, last: int) -> dict[str, int]:
    """What the lines from ``first`` to ``last`` (exclusive) do, each with the first line that does it.

    Plain motion does nothing of it, and the shape of a cycle is the cycle's, which passes over some.
    """
    special = interpreted.program.special_lines
    begin, end = np.searchsorted(special, (first, last))
    lines = [line for line in special[begin:end].tolist() if not interpreted.flow.in_contour(line)]
    shows_comments = bool(interpreted.settings.dialect.message_mark)
    found: dict[str, int] = {}
    for line in lines:
        for deed in _deeds_of(interpreted.program.block(line), shows_comments=shows_comments):
            found.setdefault(deed, line)
    return found


def _deeds_of(block: Block, *, shows_comments: bool) -> Iterator[str]:
    """Each as it is written, without blanks; a word as the number that it is."""
    parts: list[Assignment | Control] = [*block.assignments, *block.controls]
    for part in parts:
        yield "".join(block.text[part.start : part.end].split()).upper()
    for word in block.words_of("MT"):
        yield f"{word.address}{word.value_text if word.number is None else format(word.number, 'g')}"
    acting = acting_comments(block) if shows_comments else ""
    if acting:
        yield acting
