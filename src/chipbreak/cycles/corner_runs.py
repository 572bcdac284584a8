"""Cuts with a corner or an angle that is said instead of drawn, outside of cycles, as plain blocks.

::

    G1 X40. F0.2 ,C1.          G1 X38. F0.2
    Z-20. ,R2.            ->   G1 X40. Z-1.
    X60.                       G1 Z-18.
                               G2 X44. Z-20. I2. K0.
                               G1 X60.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from chipbreak.cycles import alarms
from chipbreak.cycles.alarms import with_alarm
from chipbreak.cycles.call import UNREAD_FORM, refuse_modes
from chipbreak.cycles.contour import Frame
from chipbreak.cycles.corners import (
    BAD_CONTOUR,
    MAY_BE_AXES,
    add_placed,
    corner_of,
    refuse_lone_angle,
    words_of_corner,
)
from chipbreak.cycles.promise import OffsetMoves
from chipbreak.cycles.reading import Step, has_unread_axes, pieces_of
from chipbreak.cycles.roughing import Motion
from chipbreak.cycles.writing import BlockWriter, block_of_motion, other_words
from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_GROUPS = frozenset({"motion", "compensation", "feed_mode", "speed_mode"})
_LATHE = Frame("Z", 1, 1)
_WITH_COMMA = frozenset({",C", ",R", ",A"})
_BESIDE_MOVES = frozenset("RIK")
_MOST_PLAIN = 2_000
_MOST_SAID = 4
_MOST_SHOWN = 40  # characters of a block


class CornerRun(NamedTuple):
    """Lines ``first`` to ``last`` (exclusive): blocks that say corners, and the move behind the last one."""

    first: int
    last: int


def corner_runs(interpreted: InterpretedProgram) -> Iterator[CornerRun]:
    """The runs of a program outside of contours, in order."""
    behind = -1
    for line in _lines(interpreted):
        if line < behind:
            continue
        effect = interpreted.effect(line)
        if effect.in_contour or not _says_corner(effect, interpreted.settings):
            continue
        behind, is_run = _behind_run(interpreted, line)
        if is_run:
            yield CornerRun(line, behind)


def _lines(interpreted: InterpretedProgram) -> list[int]:
    """The lines that may say a corner: with a comma, or R, I and K of a move that says no G2 or G3."""
    if not interpreted.settings.dialect.contour_cycles:
        return []
    program = interpreted.program
    special = [e.block.line for e in interpreted.effects if e.block.has_any(_WITH_COMMA)]
    arcs = [i for i, shape in enumerate(program.shapes) if shape.motion in (2, 3)]
    says = (program.bits & bits_of(_BESIDE_MOVES)) != 0
    says &= (program.plain >= 0) & ~np.isin(program.plain, arcs)
    return sorted({*special, *(int(line) for line in np.flatnonzero(says)[:_MOST_PLAIN])})


def _says_corner(effect: BlockEffect, settings: Settings) -> bool:
    words = words_of_corner(effect, settings)
    return bool(words) and not any(word.letter.upper() in MAY_BE_AXES for word in words)


def _behind_run(interpreted: InterpretedProgram, first: int) -> tuple[int, bool]:
    """The line behind the first move that says no corner, True; or where something else comes before it.

    From no line up to there another run begins.
    """
    stop = interpreted.program.source.body.stop
    for effect in interpreted.effects_of(first, stop):
        if effect.non_modal or effect.after.ended or effect.block.has("T") or effect.in_contour:
            return effect.block.line + 1, False
        if effect.move is not None and not _says_corner(effect, interpreted.settings):
            return effect.block.line + 1, True
    return stop, False


def corner_edit(interpreted: InterpretedProgram, run: CornerRun) -> Edit:
    """The edit that draws the corners of a run.

    Errors: CYC002 for a corner that cannot be, CYC007 for a block that cannot be written so.
    """
    settings = interpreted.settings
    begin = interpreted.effect(run.first).before
    refuse_modes(begin)
    effects = _effects(interpreted, run, begin)
    if any(math.isnan(value) for value in (begin.position.x, begin.position.z)):
        raise RefusalError(BAD_CONTOUR, "where a corner begins is not known", "move there with G0 X Z")
    if effects[-1].after.position != interpreted.behind(run.last).position:
        message = "the block behind an angle does not name the axis that the angle gives"
        raise RefusalError(BAD_CONTOUR, message, "name both axes in it")
    unknown = next((one for one in effects if one.move is not None and _ends_nowhere(one.move)), None)
    if unknown is not None:
        shown = unknown.block.text.strip()[:_MOST_SHOWN]
        message = f"where the block {shown} ends is not known"
        raise RefusalError(BAD_CONTOUR, message, "write X and Z of its end as numbers with a decimal point")
    writer = _Writer(effects, settings)
    for effect in effects:
        writer.write(effect)
    writer.give_motion_back(effects[-1].after.modes.motion)
    most = max(settings.control.max_line_chars, *(len(effect.block.text) for effect in effects))
    if any(len(line) > most for line in writer.lines):
        message = "a block with its corner drawn would be longer than the control takes"
        raise RefusalError(UNREAD_FORM, message, "write fewer words in it")
    said = [e.block.text_of(w) for e in effects for w in words_of_corner(e, settings)]
    title = f"CORNERS {' '.join(said[:_MOST_SAID])}"
    return Edit(
        run.first,
        run.last,
        tuple(writer.lines),
        title,
        "the corners as the control cuts them",
        OffsetMoves(frame=_LATHE, motions=tuple(writer.motions)),
    )


def _ends_nowhere(move: Move) -> bool:
    return math.isnan(move.end.x + move.end.z)


def _effects(interpreted: InterpretedProgram, run: CornerRun, state: State) -> list[BlockEffect]:
    """What the blocks of a run do, each behind the one before it."""
    settings = interpreted.settings
    effects: list[BlockEffect] = []
    for line in range(run.first, run.last):
        effect = interpreted.interpreter.advance(state, interpreted.program.block(line))
        why = next(_faults(effect, settings), "")
        why = "is what a jump leads to" if line in interpreted.flow.targets else why
        if why:
            shown = effect.block.text.strip()[:_MOST_SHOWN]
            raise RefusalError(UNREAD_FORM, f"the block {shown} {why}", "draw the corner with G1, G2 and G3")
        state = add_placed(effects, effect, settings).after
    refuse_lone_angle(effects, settings)
    _refuse_before_rapid(effects, settings)
    return effects


def _refuse_before_rapid(effects: Sequence[BlockEffect], settings: Settings) -> None:
    """Corners lie between feeds: a control that finds a rapid behind one stops.  Errors: CYC007."""
    moves = [effect for effect in effects if effect.move is not None]
    for effect, behind in itertools.pairwise(moves):
        if _says_corner(effect, settings) and behind.move is not None and behind.move.kind == "rapid":
            shown = effect.block.text.strip()[:_MOST_SHOWN]
            message = f"the corner of the block {shown} has a rapid behind it"
            raise RefusalError(
                UNREAD_FORM, message, with_alarm("go on with G1", alarms.NO_FEED_BEHIND_CORNER)
            )


def _faults(effect: BlockEffect, settings: Settings) -> Iterator[str]:
    """What stands in the way of a block of a run."""
    block = effect.block
    if block.opaque or block.skip or block.has_macro or block.controls or block.marks:
        yield "cannot be read, has block delete or is worked out on the control"
    if set(effect.before.modes.changed(effect.after.modes)) - _GROUPS:
        yield "changes units, plane or coordinates"
    if effect.does("program") or effect.does("subprogram") or effect.does("stop"):
        yield "stops or leaves the program"
    # Words go to the front, and there an O would be the number of a program.
    if block.has("O") or set(effect.unread) - set(words_of_corner(effect, settings)):
        yield "has a word that is not read here"
    if has_unread_axes(effect, settings):
        yield "has axis words beside a G code that is not read"
    if effect.move is not None and effect.move.kind == "rapid" and _says_corner(effect, settings):
        yield "says a corner in a rapid"
    move = effect.move
    if move is not None and (set(move.axes) - {"X", "Z"} or move.kind not in ("rapid", "line", "cw", "ccw")):
        yield "moves otherwise than in X and Z"


class _Writer:
    """Writes the blocks of a run one after the other, and keeps their moves."""

    def __init__(self, effects: Sequence[BlockEffect], settings: Settings) -> None:
        self.blocks = BlockWriter(effects[0].before, settings)
        steps = [Step(e.move, corner_of(e, settings)) for e in effects if e.move is not None]
        self.pieces = iter(pieces_of(steps, _LATHE))
        self.lines: list[str] = []
        self.motions: list[Motion] = []
        self.leaves = ""  # the motion code behind the last block; empty behind the arc of a corner

    def write(self, effect: BlockEffect) -> None:
        """The blocks that stand for one block."""
        block = effect.block
        self.lines += [block.text[one.start : one.end] for one in block.comments]
        said = _joined(block, other_words(block, effect.vibration))
        if effect.move is not None:
            said = self._move(effect, said)
        self.lines += [said] if said else []

    def give_motion_back(self, motion: str) -> None:
        """Where no block has left the code of the last move in force.

        A corner may take in all of that move, and G2 and G3 may be without radius and centre: a line.
        """
        if self.leaves != motion:
            self.lines.append(self.blocks.settings.dialect.code("motion", motion))

    def _move(self, effect: BlockEffect, said: str) -> str:
        """A move and the corner behind it; the other words, where no block took them."""
        assert effect.move is not None
        cuts = effect.move.kind != "rapid"
        wish = _joined(effect.block, effect.vibration) if cuts else ""
        own = str(effect.after.modes.motion)
        for number, piece in enumerate(next(self.pieces)):
            motion = Motion(cuts, piece.end, piece.centre, piece.turn)
            self.motions.append(motion)
            text = block_of_motion(self.blocks, _LATHE, piece.start, motion)
            if text:
                self.lines.append(" ".join(filter(None, (said, text, wish))))
                said = ""
                code = own if number == 0 else ""
                self.leaves = code if piece.centre is not None else "line" if cuts else "rapid"
        return said


def _joined(block: Block, words: Sequence[Word]) -> str:
    return " ".join(block.text_of(word) for word in words)
