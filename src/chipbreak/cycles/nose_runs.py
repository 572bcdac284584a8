"""Blocks under nose compensation as blocks without it: from G41 or G42 to the move that leads out.

::

    G42 G0 X30. Z2.            G0 X30. Z2.
    G1 Z-20. F0.2              G1 Z-20.332 F0.2
    X40. Z-30.            ->   G1 X40. Z-30.332
    G40 G0 X60. Z5.            G0 X60. Z5.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

from chipbreak.cycles.call import refuse_modes
from chipbreak.cycles.corners import may_be_corner
from chipbreak.cycles.nose import Nose, Offset, offset_moves
from chipbreak.cycles.promise import OffsetMoves
from chipbreak.cycles.roughing import Motion
from chipbreak.cycles.writing import BlockWriter, block_of_motion, without_number
from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.findings import COMPENSATED
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_KINDS = ("rapid", "line", "cw", "ccw")
_GROUPS = frozenset({"motion", "compensation", "feed_mode", "speed_mode"})
_SHAPE = frozenset("RIK")
_HOME = frozenset({"home"})
ASSUMED = "ASSUMED"  # behind a nose of which nothing says that it is this tool's


class Run(NamedTuple):
    """Lines ``first`` to ``last`` (exclusive): all under compensation, and the move that leads out."""

    first: int
    last: int


class Written(NamedTuple):
    """The edit of a run, and for each of its new lines the line (from 0) that it stands for."""

    edit: Edit
    sources: tuple[int, ...]


def compensated_runs(interpreted: InterpretedProgram) -> list[Run]:
    """Where compensation is in force, in order; a run without an end goes to the end of the program."""
    runs: list[Run] = []
    first: int | None = None
    for effect in interpreted.effects:
        is_on = effect.after.modes.compensation != "off" and not effect.after.ended
        if is_on and first is None:
            first = effect.block.line
        elif not is_on and first is not None:
            runs.append(Run(first, _behind(interpreted, effect)))
            first = None
    return runs if first is None else [*runs, Run(first, interpreted.program.source.body.stop)]


def _behind(interpreted: InterpretedProgram, ends: BlockEffect) -> int:
    """The line behind the move that leads out, or behind the blocks that take both axes home."""
    line = ends.block.line
    for effect in interpreted.effects_of(line, interpreted.program.source.body.stop):
        is_on_its_way = effect.non_modal == _HOME and not _is_home(effect)
        if not is_on_its_way and (effect.move is not None or effect.non_modal or effect.after.ended):
            return effect.block.line + 1
    return line + 1


def _is_home(effect: BlockEffect) -> bool:
    """True where neither axis is at a known place any more."""
    return math.isnan(effect.after.position.x) and math.isnan(effect.after.position.z)


def offset_run(interpreted: InterpretedProgram, run: Run, nose: Nose) -> Written:
    """The edit that writes a run without compensation.

    Errors: VIB040 for a run that cannot be written so, and CYC007 for a mode in which places mean others.
    """
    settings = interpreted.settings
    rules = settings.dialect.nose
    if rules is None or nose.tip not in rules.tips:
        raise _refused(
            f"how this control counts the tip {nose.tip} of a nose is not known", "take the wish out"
        )
    effects = list(interpreted.effects_of(run.first, run.last))
    _refuse_run(interpreted, effects)
    under = [effect for effect in effects if effect.after.modes.compensation != "off"]
    offset = Offset(under[0].after.modes.compensation, nose, rules)
    writer = _Writer(effects, offset, settings)
    for effect in effects:
        writer.write(effect)
    codes = {"left": "G41", "right": "G42"}
    assumed = f" {ASSUMED}" if nose.is_assumed else ""
    title = f"{codes[offset.side]} R{nose.radius_mm:g} T{nose.tip}{assumed}"
    reason = f"a nose of {nose.radius_mm:g} mm with tip {nose.tip}, offset by the filter"
    promise = OffsetMoves(frame=offset.frame(settings.axis_words), motions=tuple(writer.motions))
    return Written(
        Edit(run.first, run.last, tuple(writer.lines), title, reason, promise), tuple(writer.sources)
    )


class _Writer:
    """Writes the blocks of a run one after the other."""

    def __init__(self, effects: Sequence[BlockEffect], offset: Offset, settings: Settings) -> None:
        self.settings = settings
        self.frame = offset.frame(settings.axis_words)
        begin = effects[0].before
        self.blocks = BlockWriter(begin, settings)
        self.at = self.frame.inside(begin.position.z, begin.position.x)
        moves = [e.move for e in effects if e.move is not None and e.after.modes.compensation != "off"]
        self.waiting = iter(offset_moves(moves, offset, settings.axis_words))
        self.lines: list[str] = []
        self.sources: list[int] = []
        self.motions: list[Motion] = []

    def write(self, effect: BlockEffect) -> None:
        """The blocks that stand for one block."""
        block = effect.block
        for comment in block.comments:
            if comment.end - comment.start <= self.settings.control.max_line_chars:
                self._add(effect, block.text[comment.start : comment.end])
        if effect.move is None or effect.non_modal:
            plain = _joined(block, _other_words(effect, ""))
            text = without_number(block, self.settings) if effect.non_modal else plain
            self._add(effect, text)
            return
        said = _joined(block, _other_words(effect, self.settings.axis_words.axes))
        wish = _joined(block, effect.vibration)
        for motion in self._motions(effect):
            text = block_of_motion(self.blocks, self.frame, self.at, motion)
            self.at = motion.end
            self.motions.append(motion)
            if text:
                self._add(effect, " ".join(filter(None, (said, text, wish if motion.cuts else ""))))
                said = ""
        self._add(effect, said)

    def _motions(self, effect: BlockEffect) -> list[Motion]:
        """Those of a move under compensation, or the straight way out."""
        assert effect.move is not None
        if effect.after.modes.compensation != "off":
            return next(self.waiting)
        end = self.frame.inside(effect.move.end.z, effect.move.end.x)
        return [Motion(effect.move.kind != "rapid", end)]

    def _add(self, effect: BlockEffect, text: str) -> None:
        if text:
            self.lines.append(text)
            self.sources.append(effect.block.line)


def _joined(block: Block, words: Sequence[Word]) -> str:
    return " ".join(block.text_of(word) for word in words)


def _other_words(effect: BlockEffect, axes: Collection[str]) -> list[Word]:
    """The words of a block beside its move, its wish and its compensation."""
    letters = frozenset(axes) | _SHAPE if axes else frozenset()
    starts = any(_is_start(word) for word in effect.block.words)
    letters |= frozenset("DL") if starts else frozenset()
    return [
        word
        for word in effect.block.words
        if word.address not in letters and word not in effect.vibration and not _is_of_the_move(word)
    ]


def _is_start(word: Word) -> bool:
    return word.address == "G" and word.number is not None and 40.0 < word.number < 43.0


def _is_of_the_move(word: Word) -> bool:
    """True for G0 to G3 and for G40 to G42."""
    return (
        word.address == "G" and word.number is not None and (word.number < 4.0 or 40.0 <= word.number < 43.0)
    )


def _refuse_run(interpreted: InterpretedProgram, effects: Sequence[BlockEffect]) -> None:
    targets = interpreted.flow.targets
    if any(effect.block.line in targets for effect in effects):
        raise _refused("a jump leads into it", "take the jump out")
    side = effects[0].after.modes.compensation
    for effect in effects[:-1]:
        if effect.after.modes.compensation != "off" or effect.non_modal != _HOME:
            _refuse_block(effect, side, interpreted.settings)
    _refuse_way_out(effects[-1])


def _refuse_block(effect: BlockEffect, side: str, settings: Settings) -> None:
    why = next(_faults(effect, side), "")
    corner = may_be_corner(effect, settings)
    if corner is not None:
        why = why or f"has {effect.block.text_of(corner)}, which may be a corner (cycles.plain_corners)"
    if why:
        shown = effect.block.text.strip()[:40]
        raise _refused(f"the block {shown} {why}", "end it with G40 before, or write the block without it")
    refuse_modes(effect.after)


def _faults(effect: BlockEffect, side: str) -> Iterator[str]:
    """What a block under compensation cannot have."""
    block = effect.block
    now = effect.after.modes.compensation
    if block.opaque or block.skip or block.has_macro or block.controls:
        yield "cannot be read, has block delete or is worked out on the control"
    if set(effect.before.modes.changed(effect.after.modes)) - _GROUPS:
        yield "changes units, plane or coordinates"
    if effect.non_modal - {"dwell"} or (effect.non_modal and effect.move is not None):
        yield "is a cycle, a call or a way home"
    changes_tool = block.has("T") and effect.before.modes.compensation != "off"
    if changes_tool or effect.does("subprogram"):
        yield "changes the tool or leaves the program"
    if now not in ("off", side):
        yield "changes the side of the compensation"
    if effect.unread:
        yield "has a word that is not read here"
    yield from _faults_of_move(effect)


def _faults_of_move(effect: BlockEffect) -> Iterator[str]:
    move = effect.move
    if move is None:
        return
    if move.kind not in _KINDS or set(move.axes) - {"X", "Z"} or move.plane not in ("", "ZX"):
        yield "moves otherwise than in X and Z"
    if math.isnan(move.end.x + move.end.z):
        yield "ends at a place that is not known"


def _refuse_way_out(effect: BlockEffect) -> None:
    """The compensation ends with a straight move to a known place, or a way home."""
    move = effect.move
    is_off = effect.after.modes.compensation == "off"
    goes_home = effect.non_modal == _HOME and _is_home(effect)
    is_straight = move is not None and move.kind in ("rapid", "line") and not effect.non_modal
    is_plain = not (effect.block.skip or effect.block.has_macro or effect.block.opaque)
    is_known = move is not None and not math.isnan(move.end.x + move.end.z)
    has_vector = effect.block.has_any("IK")
    if not (is_off and is_plain and not has_vector and (goes_home or (is_straight and is_known))):
        message = "how the tool leaves it is not known"
        raise _refused(message, "lead out with G40 and a straight move: G40 G0 X100. Z10.")


def _refused(why: str, help_text: str) -> RefusalError:
    return RefusalError(COMPENSATED, f"tool nose compensation (G41, G42) is active, and {why}", help_text)
