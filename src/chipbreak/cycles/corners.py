"""Corners and angles of a contour that are said instead of drawn: ``,C1.`` ``,R2.`` ``,A30.``.

Many controls take C, R and A without a comma too, and I and K of a straight move as its chamfer.

A chamfer begins and ends at its size before and behind the corner, a radius touches both lines.  An angle
counts from +Z towards +X, and gives the axis that its block does not name.

In a subroutine of LinuxCNC A is a radius, and C the chord of one: a chamfer that ends where it would touch.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from chipbreak.cycles import alarms
from chipbreak.cycles.alarms import with_alarm
from chipbreak.cycles.contour import Point, Segment, direction
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.points import WRITE_THE_POINT
from chipbreak.model.words import length_mm, plain_value
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

BAD_CONTOUR = "CYC002"
_CHAMFERS = (",C", "C", "I", "K")
_RADII = (",R", "R")
_WITH_COMMA = frozenset({",C", ",R", ",A"})
_PLAIN = frozenset("CRIKA")
# Outside of a contour C and A without a comma may be axes.
MAY_BE_AXES = frozenset("CA")
ANGLES = (",A", "A")
_NOTHING_MM = 1e-9


class Corner(NamedTuple):
    """How the corner behind a move is taken off: a chamfer, or a radius, of a size [mm].

    ``touches``: it ends where an arc of this radius would touch both lines.
    """

    is_radius: bool
    size_mm: float
    touches: bool


def words_of_corner(effect: BlockEffect, settings: Settings) -> tuple[Word, ...]:
    """The words of a straight move that say its corner or its angle."""
    if effect.move is None and not effect.block.has_any(ANGLES):
        return ()
    dialect = settings.dialect
    if effect.after.modes.motion not in ("line", "rapid"):
        return ()
    if dialect.subroutine_cycles:
        return effect.block.words_of(dialect.subroutine_radius + dialect.subroutine_chamfer)
    if not dialect.contour_cycles:
        return ()
    known = _WITH_COMMA | _PLAIN if settings.cycles.plain_corners else _WITH_COMMA
    return effect.block.words_of(known)


def may_be_corner(effect: BlockEffect, settings: Settings) -> Word | None:
    """C or A without a comma in a feed outside of contours, which may be an axis; None without.

    Where the profile says that the letter is X, Y or Z, it is.
    """
    if not settings.dialect.contour_cycles or effect.after.modes.motion != "line":
        return None
    unsure = MAY_BE_AXES - settings.axis_words.axes.keys()
    return next((word for word in words_of_corner(effect, settings) if word.address in unsure), None)


def corner_of(effect: BlockEffect, settings: Settings) -> Corner | None:
    """The corner that a block says; None without one.  Errors: CYC002 for two, or a size that cannot be."""
    dialect = settings.dialect
    is_called = bool(dialect.subroutine_cycles)
    words = [w for w in words_of_corner(effect, settings) if is_called or w.address not in ANGLES]
    if not words:
        return None
    if len(words) > 1:
        raise _refused(effect.block, "says two corners", "a block has one of C and R")
    size_mm = abs(length_mm(words[0], effect.after, settings))
    if math.isnan(size_mm):
        raise _refused(effect.block, "has a corner of unknown size", WRITE_THE_POINT)
    letter = words[0].address
    is_radius = letter in (dialect.subroutine_radius if is_called else _RADII)
    return Corner(is_radius, size_mm, touches=is_radius or is_called)


def with_angle(effect: BlockEffect, settings: Settings) -> BlockEffect:
    """A block whose angle says the axis that it does not name, with the end that this gives.

    Errors: CYC002 for an angle that gives none.
    """
    words = [word for word in words_of_corner(effect, settings) if word.address in ANGLES]
    if not words or settings.dialect.subroutine_cycles:
        return effect
    move = effect.move
    if len(words) > 1 or move is None or move.axes not in ("X", "Z"):
        why = "has an angle beside both axes or none"
        raise _refused(effect.block, why, "name one axis beside the angle")
    end = move.end._replace(**_end_by_angle(move, words[0], settings))
    if math.isnan(end.x + end.z):
        raise _no_end(effect.block, words[0], settings)
    return effect._replace(move=move._replace(end=end), after=effect.after._replace(position=end))


def _no_end(block: Block, word: Word, settings: Settings) -> RefusalError:
    """Why an angle leads nowhere."""
    if math.isnan(_direction_of(word, settings)[0]):
        shown = f"says {word.address}{word.value_text} without a decimal point"
        return _refused(block, shown, WRITE_THE_POINT)
    return _refused(block, "has an angle that never gets there", "write X and Z of its end")


def add_placed(effects: list[BlockEffect], effect: BlockEffect, settings: Settings) -> BlockEffect:
    """Add a block behind others, with the place that its angle gives; the block as it was added.

    A block with nothing but an angle ends where its line meets that of the next one, which says X, Z and its
    own angle: ``G1 ,A90`` and ``G1 X40. Z-2. ,A135``.  Errors: CYC002.
    """
    at = _lone_angle_at_end(effects, settings)
    if at is not None and effect.move is not None:
        effects[at], placed = _meeting(effects[at], effect, settings)
    elif _is_lone_angle(effect, settings):
        placed = effect
    else:
        placed = with_angle(effect, settings)
    effects.append(placed)
    return placed


def _lone_angle_at_end(effects: Sequence[BlockEffect], settings: Settings) -> int | None:
    """The place of an angle behind the last move."""
    for at in range(len(effects) - 1, -1, -1):
        if effects[at].move is not None:
            return None
        if _is_lone_angle(effects[at], settings):
            return at
    return None


def refuse_lone_angle(effects: Sequence[BlockEffect], settings: Settings) -> None:
    """Errors: CYC002 for an angle behind which no move comes."""
    lone = next((one for one in effects if _is_lone_angle(one, settings)), None)
    if lone is not None:
        raise _refused(lone.block, "has an angle beside no axis", "name one axis beside the angle")


def _is_lone_angle(effect: BlockEffect, settings: Settings) -> bool:
    words = [word for word in words_of_corner(effect, settings) if word.address in ANGLES]
    return effect.move is None and len(words) == 1 and not settings.dialect.subroutine_cycles


def _meeting(first: BlockEffect, then: BlockEffect, settings: Settings) -> tuple[BlockEffect, BlockEffect]:
    """Two lines, each by its angle, the second one to a known place; the first ends where they meet."""
    move = then.move
    words = [word for word in words_of_corner(then, settings) if word.address in ANGLES]
    if move is None or len(words) != 1 or {"X", "Z"} - set(move.axes) or move.kind != "line":
        why = "has an angle, and the next block does not say X, Z and an angle"
        raise _refused(first.block, why, "name one axis beside the angle")
    (own,) = (word for word in words_of_corner(first, settings) if word.address in ANGLES)
    one = _direction_of(own, settings)
    other = _direction_of(words[0], settings)
    start = move.start
    cross = one[0] * other[1] - one[1] * other[0]
    way_z, way_x = move.end.z - start.z, move.end.x - start.x
    along_mm = (way_z * other[1] - way_x * other[0]) / cross if abs(cross) > _NOTHING_MM else math.nan
    if math.isnan(along_mm):
        raise _refused(then.block, "does not meet the line before it", "write X and Z of its start")
    corner = start._replace(z=start.z + along_mm * one[0], x=start.x + along_mm * one[1])
    led = move._replace(end=corner)
    return first._replace(move=led), then._replace(move=move._replace(start=corner))


def _direction_of(word: Word, settings: Settings) -> tuple[float, float]:
    """Along Z and along the radius; NaN for an angle of unknown worth."""
    is_known = word.has_point or word.number == 0.0 or settings.number_rule.reads_whole
    angle = math.radians(plain_value(word)) if is_known else math.nan
    signs = settings.axis_words.signs
    return math.cos(angle) * signs["Z"], math.sin(angle) * signs["X"]


def _end_by_angle(move: Move, word: Word, settings: Settings) -> dict[str, float]:
    run, rise = _direction_of(word, settings)
    if move.axes == "Z":
        way_mm = move.end.z - move.start.z
        return {"x": move.start.x + way_mm * rise / run if abs(run) > _NOTHING_MM else math.nan}
    way_mm = move.end.x - move.start.x
    return {"z": move.start.z + way_mm * run / rise if abs(rise) > _NOTHING_MM else math.nan}


def _refused(block: Block, why: str, help_text: str) -> RefusalError:
    return RefusalError(BAD_CONTOUR, f"the contour block {block.text.strip()[:40]} {why}", help_text)


def cornered(segments: Sequence[Segment], corners: Sequence[Corner | None]) -> list[list[Segment]]:
    """The segments with their corners taken off; what stands for each is a list, its corner the last.

    Errors: CYC002 for a corner beside an arc, without a move behind it, or larger than its moves.
    """
    made = [[one] for one in segments]
    for index, corner in enumerate(corners):
        if corner is None or corner.size_mm <= _NOTHING_MM:
            continue
        if index + 1 >= len(segments):
            error = _bad("the last block of the contour says a corner, and no move follows it")
            raise RefusalError(error.code, error.message, with_alarm(error.help, alarms.OPEN_CORNER))
        before = made[index][-1]
        after = made[index + 1][0]
        if before.centre is not None or after.centre is not None:
            raise _bad("a corner stands beside an arc")
        made[index], made[index + 1] = _taken_off(before, after, corner)
    return made


def _bad(why: str) -> RefusalError:
    help_text = "write the contour with G1, G2 and G3 to plain points"
    return RefusalError(BAD_CONTOUR, why, help_text)


def _taken_off(before: Segment, after: Segment, corner: Corner) -> tuple[list[Segment], list[Segment]]:
    """Two lines with the corner between them."""
    if min(before.length_mm, after.length_mm) <= _NOTHING_MM:
        raise _bad("a corner stands beside a move without length")
    in_t, in_h = direction(before)
    out_t, out_h = direction(after)
    cross = in_t * out_h - in_h * out_t
    cut_mm = corner.size_mm
    if corner.touches:
        cut_mm *= math.tan(abs(math.atan2(cross, in_t * out_t + in_h * out_h)) / 2.0)
    if cut_mm > min(before.length_mm, after.length_mm) + 1e-6:
        raise _bad(f"a corner of {corner.size_mm:g} mm is larger than the moves beside it")
    tip = before.end
    first = Point(tip.t - cut_mm * in_t, tip.h - cut_mm * in_h)
    last = Point(tip.t + cut_mm * out_t, tip.h + cut_mm * out_h)
    new = Segment(first, last)
    if corner.is_radius and abs(cross) > _NOTHING_MM:
        turn = 1 if cross > 0.0 else -1
        centre = Point(first.t - turn * corner.size_mm * in_h, first.h + turn * corner.size_mm * in_t)
        new = Segment(first, last, centre, turn)
    return [before._replace(end=first), new], [after._replace(start=last)]
