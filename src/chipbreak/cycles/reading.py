"""The contour of a cycle, read from the blocks of the program as the control reads them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from chipbreak.cycles import alarms
from chipbreak.cycles.alarms import with_alarm
from chipbreak.cycles.contour import Frame, Point, Segment, drop_mm, turns_back_along_t
from chipbreak.cycles.corners import (
    BAD_CONTOUR,
    Corner,
    add_placed,
    corner_of,
    cornered,
    refuse_lone_angle,
    words_of_corner,
)
from chipbreak.kinematics.toolpath import Leg, path_of
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.points import WRITE_THE_POINT, first_without_point
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

TURNS_BACK = "CYC003"
BEYOND_START = "CYC006"
_TURNS = {"line": 0, "cw": -1, "ccw": 1, "rapid": 0}
_GROUPS = frozenset({"motion", "compensation", "feed_mode", "speed_mode"})
_SAME_MM = 1e-6
_CHAMFERS = frozenset("CA")
_NO_MOVES = frozenset("BDH")  # an axis that turns, an offset: the passes would be without them


class Contour(NamedTuple):
    """A contour in the axes of its passes, with the frame, the start, and how its first block moves.

    ``first_names_both`` where its first block names both axes: then it may have pockets (type II).
    """

    frame: Frame
    start: Point
    segments: tuple[Segment, ...]
    feeds_in: bool
    first_names_both: bool


def effects_of_contour(
    interpreted: InterpretedProgram, state: State, first: int, last: int, *, roughs: bool = False
) -> list[BlockEffect]:
    """What the blocks of a contour, lines ``first`` to ``last`` (inclusive), do one after the other.

    T acts in the finishing cycle alone: what ``roughs`` passes it over.

    Errors: CYC002 for a block that no contour can have.
    """
    settings = interpreted.settings
    reader = Interpreter(settings, Flow(frozenset(), ()))
    effects: list[BlockEffect] = []
    for line in range(first, last + 1):
        block = interpreted.program.block(line)
        effect = reader.advance(state, _without_tool(block) if roughs else block)
        _check_block(effect, settings)
        state = add_placed(effects, effect, settings).after
    refuse_lone_angle(effects, settings)
    return effects


def _without_tool(block: Block) -> Block:
    return block._replace(words=tuple(word for word in block.words if word.address != "T"))


def _check_block(effect: BlockEffect, settings: Settings) -> None:
    """The first of the rules that a block breaks.  Errors: CYC002."""
    why, alarm = next((said for *said, breaks in _RULES if breaks(effect, settings)), ("", ""))
    if why:
        message = f"the contour block {effect.block.text.strip()[:40]} {why}"
        help_text = "a contour has G0, G1, G2 and G3 with plain numbers"
        raise RefusalError(BAD_CONTOUR, message, with_alarm(help_text, alarm) if alarm else help_text)


def _is_unreadable(effect: BlockEffect, _: Settings) -> bool:
    block = effect.block
    return bool(block.opaque or block.skip or block.has_macro)


def _has_foreign_code(effect: BlockEffect, _: Settings) -> bool:
    dwells = effect.non_modal == {"dwell"} and effect.move is None
    is_foreign = bool(effect.non_modal) and not dwells
    return is_foreign or bool(set(effect.before.modes.changed(effect.after.modes)) - _GROUPS)


def _has_unread_word(effect: BlockEffect, settings: Settings) -> bool:
    corners = words_of_corner(effect, settings)
    others = [word for word in (*effect.unread, *effect.vibration) if word not in corners]
    is_axis = not corners and effect.block.has_any(_CHAMFERS)
    is_other = any(
        word.address in _NO_MOVES and word.address not in effect.taken for word in effect.block.words
    )
    return bool(others or is_axis or is_other)


def has_unread_axes(effect: BlockEffect, settings: Settings) -> bool:
    """Axis words that move nothing: beside a G code that the profile does not know."""
    return effect.move is None and not effect.non_modal and effect.block.has_any(settings.axis_words.axes)


def _moves_otherwise(effect: BlockEffect, _: Settings) -> bool:
    return effect.move is not None and effect.move.kind not in _TURNS


def _moves_another_axis(effect: BlockEffect, _: Settings) -> bool:
    return effect.move is not None and bool(set(effect.move.axes) - {"X", "Z"})


def _leaves_the_contour(effect: BlockEffect, _: Settings) -> bool:
    """M codes and T are for the finishing cycle; what stops or leaves the program is for neither."""
    return effect.block.has("T") or effect.does("program") or effect.does("subprogram") or effect.does("stop")


_RULES: tuple[tuple[str, str, Callable[[BlockEffect, Settings], bool]], ...] = (
    ("cannot be read, has block delete or is worked out on the control", "", _is_unreadable),
    ("has a G code that does not belong into a contour", alarms.FOREIGN_COMMAND, _has_foreign_code),
    ("has a word that is not read here", "", _has_unread_word),
    ("has axis words beside a G code that is not read", alarms.FOREIGN_COMMAND, has_unread_axes),
    ("is no line and no arc", "", _moves_otherwise),
    ("moves another axis than X and Z", "", _moves_another_axis),
    ("changes the tool, stops or leaves the program", "", _leaves_the_contour),
)


def read_contour(
    interpreted: InterpretedProgram, state: State, lines: tuple[int, int], along: str
) -> Contour:
    """The contour that a cycle called in ``state`` cuts, its passes ``along`` Z or X.

    Errors: CYC002 for a contour that cannot be used, CYC003 for one that turns back, CYC006 for one that
    begins beyond the start point, VIB022 for an arc that cannot be.
    """
    steps = steps_of(effects_of_contour(interpreted, state, *lines, roughs=True), interpreted.settings)
    first = steps[0].move
    steps = _without_way_out(steps, along)
    frame = frame_of([step.move for step in steps], along)
    start = frame.inside(first.start.z, first.start.x)
    segments = segments_of(steps[1:], frame)
    _check_shape(segments, start, along)
    return Contour(frame, start, segments, first.kind == "line", {"X", "Z"} <= set(first.axes))


def _without_way_out(steps: list[Step], along: str) -> list[Step]:
    """The moves without those at the end that run where no stock is: at the height of the start, or above.

    Many contours end with the way back of the finishing cut (``G0 G40 Z2.``).
    """
    begin, start = steps[0].move.end, steps[0].move.start
    heights = (start.z, begin.z) if along == "X" else (start.x, begin.x)
    outwards = heights[0] - heights[1]
    last = len(steps)
    while last > 2 and _is_outside(steps[last - 1].move, along, heights[0], outwards):
        last -= 1
    return steps[:last]


def _is_outside(move: Move, along: str, start_mm: float, outwards: float) -> bool:
    """True for a straight move no end of which is nearer to the part than the start."""
    ends = (move.start.z, move.end.z) if along == "X" else (move.start.x, move.end.x)
    is_straight = move.kind in ("rapid", "line")
    return is_straight and all((end - start_mm) * outwards >= -_SAME_MM for end in ends)


class Step(NamedTuple):
    """A move of a contour, and the corner behind it."""

    move: Move
    corner: Corner | None


def steps_of(effects: Sequence[BlockEffect], settings: Settings) -> list[Step]:
    """The moves of a contour, the one to its first point included.

    Errors: CYC002 for a contour that cannot be used.
    """
    steps = [Step(e.move, corner_of(e, settings)) for e in effects if e.move is not None]
    if len(steps) < 2:
        raise RefusalError(
            BAD_CONTOUR, "the contour of this cycle has fewer than two moves", "give it its shape"
        )
    if any(math.isnan(value) for step in steps for value in (step.move.end.x, step.move.end.z)):
        raise _unknown_point(effects, settings)
    if steps[0].move.kind not in ("rapid", "line") or steps[0].corner is not None:
        message = "the first block of the contour is an arc, or says a corner"
        help_text = with_alarm("begin the contour with G0 or G1", alarms.FIRST_IS_NO_LINE)
        raise RefusalError(BAD_CONTOUR, message, help_text)
    return steps


def _unknown_point(effects: Sequence[BlockEffect], settings: Settings) -> RefusalError:
    """Why a point of the contour is not known."""
    words = ((word, effect) for effect in effects for word in effect.block.words_of(settings.axis_words.axes))
    pointless = (first_without_point([word], effect.before, settings) for word, effect in words)
    shown = next((one for one in pointless if one), "")
    if shown:
        message = f"{shown} in the contour has no decimal point"
        return RefusalError(BAD_CONTOUR, message, WRITE_THE_POINT)
    message = "a point of the contour cannot be known"
    return RefusalError(BAD_CONTOUR, message, "write it with plain numbers")


def segments_of(steps: Sequence[Step], frame: Frame) -> tuple[Segment, ...]:
    """The moves as geometry, their corners taken off; a rapid among them is a line.  Errors: CYC002."""
    return tuple(one for several in pieces_of(steps, frame) for one in several if one.length_mm > _SAME_MM)


def pieces_of(steps: Sequence[Step], frame: Frame) -> list[list[Segment]]:
    """What stands for each move: itself, and the corner behind it.  Errors: CYC002."""
    return cornered([segment_of(step.move, frame) for step in steps], [step.corner for step in steps])


def frame_of(moves: list[Move], along: str) -> Frame:
    """Cutting goes from the first point of the contour towards its last; stock is where the tool waits."""
    begin, last, start = moves[0].end, moves[-1].end, moves[0].start
    z_mm, x_mm = last.z - begin.z, start.x - begin.x
    if along == "X":
        x_mm, z_mm = start.z - begin.z, last.x - begin.x
    if abs(x_mm) <= _SAME_MM or abs(z_mm) <= _SAME_MM:
        message = "the contour begins at the height of the start point, or has no extent along the passes"
        raise RefusalError(BEYOND_START, message, "start the cycle outside the stock, before the contour")
    return Frame(along, 1 if z_mm > 0.0 else -1, 1 if x_mm > 0.0 else -1)


def segment_of(move: Move, frame: Frame) -> Segment:
    """A move in the axes of the passes."""
    start = frame.inside(move.start.z, move.start.x)
    end = frame.inside(move.end.z, move.end.x)
    if move.kind in ("line", "rapid"):
        return Segment(start, end)
    (arc,) = path_of([leg_of(move)]).arcs
    assert arc is not None
    turn = _TURNS[move.kind] * (-1 if frame.mirrors else 1)
    return Segment(start, end, frame.inside(arc.centre[2], arc.centre[0]), turn)


def leg_of(move: Move) -> Leg:
    """A move of the lathe as geometry; Y counts as 0."""
    offsets = (math.nan,) * 3 if move.offsets is None else tuple(move.offsets)
    return Leg(
        (move.start.x, 0.0, move.start.z),
        (move.end.x, 0.0, move.end.z),
        _TURNS[move.kind],
        move.plane or "ZX",
        (offsets[0], offsets[1], offsets[2]),
        move.radius_mm,
    )


def _check_shape(segments: tuple[Segment, ...], start: Point, along: str) -> None:
    if segments[0].start.t < start.t - _SAME_MM:
        message = "the contour begins before the start point of the cycle, seen along the passes"
        raise RefusalError(BEYOND_START, message, "start the cycle before the contour")
    if turns_back_along_t(segments):
        message = "the contour turns back along the passes: an undercut"
        help_text = "take the undercut out of the contour, or cut it by itself"
        raise RefusalError(TURNS_BACK, message, with_alarm(help_text, alarms.TURNS_BACK[along]))


def goes_down(contour: Contour, least_mm: float) -> bool:
    """True for a contour with pockets, which cycles of type I cannot cut.

    An arc whose ends have the digits of a program may go down by less than the last of them (``least_mm``).
    """
    return drop_mm(contour.segments) > least_mm
