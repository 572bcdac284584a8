"""Where a tool with a round nose goes under G41 and G42, as plain moves under G40.

The control takes the centre of the nose along the programmed shape at the nose radius, and counts from the
imaginary tip: the point in which the two sides of the nose would meet, in the direction that the tip number
says.  Without compensation it takes the tip to the programmed places.  So the moves here are those of the
centre, shifted by the way from the centre to the tip.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from chipbreak.cycles.contour import Frame, Point, Segment
from chipbreak.cycles.offset import check_distance, heading, pieces_at_distance, round_corner, sharp_corner
from chipbreak.cycles.reading import segment_of
from chipbreak.cycles.roughing import Motion
from chipbreak.dialects.base import NoseRules
from chipbreak.model.block_effect import Move
from chipbreak.model.findings import COMPENSATED
from chipbreak.settings.axis_words import AxisWords
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_NOTHING_MM = 1e-6
_NEAR = 2  # blocks before and behind


class Nose(NamedTuple):
    """The round nose of a turning tool: its radius [mm], and its tip number as its control counts them.

    ``is_assumed`` where nothing says them of this tool, and the profile of tools in general.
    """

    radius_mm: float
    tip: int
    is_assumed: bool = False


class Offset(NamedTuple):
    """What a run of moves is offset by: the side (``left`` of the way, or ``right``), the nose, the rules."""

    side: str
    nose: Nose
    rules: NoseRules

    def frame(self, words: AxisWords) -> Frame:
        """Axes in which the nose is on the left of the way."""
        turned = -1 if self.side == "right" else 1
        return Frame("Z", words.signs["Z"], words.signs["X"] * turned)

    @property
    def tip(self) -> Point:
        """The way from the centre of the nose to the imaginary tip, in the axes of :meth:`frame`."""
        z, x = self.rules.tips[self.nose.tip]
        turned = -1 if self.side == "right" else 1
        return Point(z * self.nose.radius_mm, x * turned * self.nose.radius_mm)


def offset_moves(moves: Sequence[Move], offset: Offset, words: AxisWords) -> list[list[Motion]]:
    """What stands for each of the moves under compensation, the first of which leads in.

    The motions are places of the imaginary tip, in the axes of :meth:`Offset.frame`.
    Errors: VIB040 for a shape that the nose cannot follow, and for a way in that is not known.
    """
    frame = offset.frame(words)
    segments = [segment_of(move, frame) for move in moves]
    behind = zip(segments[1:], moves[1:], strict=True)
    _refuse_unlikely_tip([one for one, move in behind if move.kind != "rapid"], offset)
    _refuse_way_in(moves[0], segments[0], offset)
    led = 0 if offset.rules.leads_in_by_itself else 1
    kept = [index for index in range(led, len(moves)) if segments[index].length_mm > _NOTHING_MM]
    if len(kept) + led < 2:
        why = "the compensation ends before it is in force"
        raise _refused(why, "let a move follow the one of G41 or G42")
    pieces = _pieces([segments[index] for index in kept], offset)
    _refuse_gouging(
        [segments[index] for index in kept], [moves[index].kind == "rapid" for index in kept], pieces, offset
    )
    made = dict(zip(kept, pieces, strict=True))
    if led:
        made[0] = [Segment(segments[0].start, _beside(segments[kept[0]], offset.nose.radius_mm))]
    tip = offset.tip
    return [
        [_motion(one.shifted(tip.t, tip.h), move) for one in made.get(index, [])]
        for index, move in enumerate(moves)
    ]


def _refuse_unlikely_tip(cuts: Sequence[Segment], offset: Offset) -> None:
    """An assumed tip that points away from the material of these cuts is that of another tool.

    Errors: VIB040.
    """
    if not offset.nose.is_assumed:
        return
    tip = offset.tip
    # The nose is on the left of each way, so the material is on the right.
    towards = sum((one.end.h - one.start.h) * tip.t - (one.end.t - one.start.t) * tip.h for one in cuts)
    if towards <= 0.0:
        why = f"tip {offset.nose.tip}, which is assumed, does not point at the material here"
        raise _refused(why, "say R and T of this offset in tools.nose_radius_mm and tools.nose_tip")


def _pieces(shape: Sequence[Segment], offset: Offset) -> list[list[Segment]]:
    """What stands for each segment at the nose radius.  Errors: VIB040 where the nose does not get in."""
    corner = round_corner if offset.rules.rounds_corners else sharp_corner
    try:
        return pieces_at_distance(shape, offset.nose.radius_mm, corner)
    except RefusalError:
        raise _too_large(offset.nose) from None


def _refuse_gouging(
    shape: Sequence[Segment], rapids: Sequence[bool], pieces: Sequence[Sequence[Segment]], offset: Offset
) -> None:
    """No place of a cut, and of the rapids beside it, may be nearer to that cut than the nose radius.

    Other cuts of the run are none of its walls, nor are blocks that are farther away than a control looks:
    each of several passes is deeper than the one before, and may be fed back.
    Errors: VIB040.
    """
    # The way in of a control that leads in by itself is not parallel to its own.
    first = 1 if offset.rules.leads_in_by_itself else 0
    for begin, behind in _cuts(rapids, first):
        for index in range(max(begin - 1, first), behind):
            near = range(max(begin, index - _NEAR), min(behind, index + _NEAR + 1))
            walls = [shape[at] for at in near if not rapids[at]]
            try:
                check_distance(walls, pieces[index], offset.nose.radius_mm)
            except RefusalError:
                raise _too_large(offset.nose) from None


def _cuts(rapids: Sequence[bool], first: int) -> Iterator[tuple[int, int]]:
    """Cuts in a row with the rapids behind them, but for the last one: that leads to the next cut."""
    begins = [
        index
        for index in range(first, len(rapids))
        if not rapids[index] and (index == first or rapids[index - 1])
    ]
    yield from zip(begins, [*(one - 1 for one in begins[1:]), len(rapids)], strict=False)


def _too_large(nose: Nose) -> RefusalError:
    message = f"a nose of {nose.radius_mm:g} mm does not get into all of this shape"
    return _refused(message, "check R and T of the nose, or take what is so small out")


def _beside(one: Segment, distance_mm: float) -> Point:
    """The place at a distance square to the begin of a segment, on its left."""
    t, h = heading(one, at_end=False)
    return Point(one.start.t - h * distance_mm, one.start.h + t * distance_mm)


def _motion(one: Segment, move: Move) -> Motion:
    cuts = move.kind != "rapid" or one.centre is not None
    return Motion(cuts, one.end, one.centre, one.turn)


def _refuse_way_in(move: Move, way: Segment, offset: Offset) -> None:
    why = ""
    if move.kind not in ("rapid", "line"):
        why = "the compensation begins with an arc"
    elif math.isnan(way.length_mm):
        # Where it ends square to the next move, where it begins does not matter.
        why = "where the compensation begins is not known" if offset.rules.leads_in_by_itself else ""
    elif way.length_mm <= (offset.nose.radius_mm if offset.rules.leads_in_by_itself else _NOTHING_MM):
        why = "the move that leads into the compensation is not longer than the nose radius"
    if why:
        raise _refused(why, "lead in with a straight move, from a place that plain numbers give")


def _refused(why: str, help_text: str) -> RefusalError:
    message = f"tool nose compensation (G41, G42) is active, and {why}"
    return RefusalError(COMPENSATED, message, help_text)
