"""Whether a turning tool may go home from where it is: X outward first, then Z.

Inside a bore that way leads through the wall.  The workpiece is not known, but where tools have cut is: in
front of all cuts, or further out than all of them, the way is free.
"""

from __future__ import annotations

from bisect import bisect_left
from math import inf

from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import Position
from chipbreak.operations.main_program import MainProgram


class Clearance:
    """The furthest places that have been cut before each line of a turning program."""

    def __init__(self, interpreted: InterpretedProgram, main: MainProgram) -> None:
        self._lines: list[int] = []
        self._reach: list[tuple[float, float]] = []
        x = -inf
        z = -inf
        for effect in interpreted.effects_of(main.first, main.last):
            if effect.move is None or effect.move.kind == "rapid":
                continue
            for place in (effect.before.position, effect.move.end):
                x = max(x, place.x)  # an unknown place compares as nothing
                z = max(z, place.z)
            self._lines.append(effect.block.line)
            self._reach.append((x, z))

    def is_clear(self, line: int, position: Position) -> bool:
        """True when the tool is in front of, or outside, all that was cut before a line."""
        at = bisect_left(self._lines, line)
        if at == 0:
            return True
        x, z = self._reach[at - 1]
        return position.x > x or position.z >= z
