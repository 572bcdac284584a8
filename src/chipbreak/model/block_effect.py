"""What one block does: the values the interpreter hands on."""

from __future__ import annotations

from typing import Literal

from chipbreak.dialects.base import MCode
from chipbreak.dialects.modes import Motion
from chipbreak.model.cutting_speed import CuttingSpeed
from chipbreak.model.modal import Position, State
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.named_tuple import NamedTuple

CUTTING: tuple[Motion, ...] = ("line", "cw", "ccw")
_OTHER_AXES = frozenset("ABCUVW")
MoveKind = Literal["rapid", "line", "cw", "ccw", "thread", "other"]


class Move(NamedTuple):
    """A motion from ``start`` to ``end`` [mm, X as radius].

    ``kind``         what the motion code makes of it; ``other`` ends where the control decides
    ``axes``         the axes the block names, in its order
    ``incremental``  True where the block gives nothing but distances (G91, U, W)
    ``offsets``      from the start to the centre of an arc [mm], NaN where not given
    ``radius_mm``    its R, NaN without;  ``plane`` the plane it turns in: XY, ZX or YZ
    ``more_turns``   whole turns that it makes beside the way to its end, NaN where that is not known
    """

    kind: MoveKind
    start: Position
    end: Position
    axes: str
    incremental: bool
    offsets: Position | None = None
    radius_mm: float = float("nan")
    plane: str = ""
    more_turns: float = 0.0

    @property
    def is_cut(self) -> bool:
        """True for a feed move that can be vibrated in principle."""
        return self.kind in CUTTING


class BlockEffect(NamedTuple):
    """A block with the state before and after it.

    ``non_modal``   what its non-modal codes do (dwell, home, macro-call, ...)
    ``vibration``   the words that ask for vibration, in the block's order
    ``unread``      words nothing reads here
    ``in_contour``  True for a line that is only the shape of a cycle
    ``functions``   what its M codes do
    ``cutting_speed`` a spindle speed asked by V and D
    ``taken``       the letters that its codes take for themselves: those beside G65 and G66 are for the macro
    """

    block: Block
    before: State
    after: State
    move: Move | None = None
    non_modal: frozenset[str] = frozenset()
    vibration: tuple[Word, ...] = ()
    unread: tuple[Word, ...] = ()
    in_contour: bool = False
    cutting_speed: CuttingSpeed | None = None
    functions: tuple[MCode, ...] = ()
    taken: str = ""

    @property
    def feeds_others(self) -> bool:
        """True where axes feed that are none of X, Y and Z: ``G1 B90. F500.`` may cut, too."""
        return (
            self.move is None
            and not self.non_modal
            and self.after.modes.motion in CUTTING
            and any(word.letter.upper() in _OTHER_AXES for word in self.block.words)
        )

    def says(self, letter: str) -> bool:
        """True where the block has a word of this letter for the control itself."""
        return self.block.has(letter) and letter not in self.taken

    def does(self, group: str, *values: str) -> bool:
        """True when one of its M codes does this; without ``values``, anything of the group."""
        # Plain loops, here and in blocks: nearly every block says no M code, and is asked all the same.
        for code in self.functions:  # noqa: SIM110
            if code.group == group and (not values or code.value in values):
                return True
        return False
