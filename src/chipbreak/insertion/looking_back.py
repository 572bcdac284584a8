"""The blocks before a line, the nearest first."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator

from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram


def effects_before(interpreted: InterpretedProgram, line: int) -> Iterator[BlockEffect]:
    """The effects of blocks before a line, the last one first."""
    at = bisect_left(interpreted.effects, line, key=lambda effect: effect.block.line)
    while at:
        at -= 1
        yield interpreted.effects[at]
