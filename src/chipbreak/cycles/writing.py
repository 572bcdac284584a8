"""Moves of a cycle as blocks: G0 to G3 in the program's own units, axes that do not move left out."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

from chipbreak.cycles.call import UNREAD_FORM
from chipbreak.cycles.contour import Frame, Point, Segment
from chipbreak.cycles.reading import Step, pieces_of, steps_of
from chipbreak.cycles.roughing import Motion, Pass
from chipbreak.kinematics.toolpath import RADIUS_TOLERANCE_MM
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.modal import Position, State
from chipbreak.model.words import is_diameter
from chipbreak.settings.axis_words import CENTRES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.syntax.numbers import print_number
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

# As near as the state behind written blocks must be to that of the cycle.
_NEAR_MM = 2e-5


class ArcWays(NamedTuple):
    """The ways of an arc from its start to its centre and to its end, in Z and in the radius [mm]."""

    to_centre_mm: tuple[float, float]
    to_end_mm: tuple[float, float]

    @property
    def side(self) -> float:
        """Above or below zero, as the end lies to the one side of the way to the centre or to the other."""
        return _side(self.to_centre_mm, self.to_end_mm)


def _side(to_centre_mm: tuple[float, float], to_end_mm: tuple[float, float]) -> float:
    return to_centre_mm[0] * to_end_mm[1] - to_centre_mm[1] * to_end_mm[0]


class BlockWriter:
    """Writes moves from where the tool stands in ``state``; remembers what it has printed last.

    Errors: CYC007 where that place has more digits than are written, so that no block leads back to it, and
    for an arc of which the digits make none.
    """

    def __init__(self, state: State, settings: Settings) -> None:
        self.state = state
        self.settings = settings
        self.words = settings.axis_words
        places = {axis: getattr(state.position, axis.lower()) for axis in "XZ"}
        self.at = {
            axis: "" if math.isnan(place) else self._place(axis, place) for axis, place in places.items()
        }
        self.code = ""
        for axis, place in places.items():
            self._refuse_fine_start(axis, place)

    def _refuse_fine_start(self, axis: str, place_mm: float) -> None:
        if not self.at[axis]:
            return
        scale = self._factor(axis) / self.state.mm_per_unit
        if abs(float(self.at[axis]) / scale - place_mm) > _NEAR_MM:
            start = f"{self.words.letters[axis]}{place_mm * scale:z.6f}"
            message = f"{start}, where this starts, has more digits than are written"
            help_text = (
                f"move before it to a place with as few digits as {self.words.letters[axis]}{self.at[axis]}"
            )
            raise RefusalError(UNREAD_FORM, message, help_text)

    def block(
        self,
        code: str,
        z_mm: float,
        radius_mm: float,
        behind: str = "",
        arc: ArcWays | None = None,
    ) -> str:
        """One move; empty where nothing would move."""
        places = {"X": self._place("X", radius_mm), "Z": self._place("Z", z_mm)}
        moved = [axis for axis in "XZ" if places[axis] != self.at[axis]]
        if not moved:
            return ""
        said = [f"{self.words.letters[axis]}{places[axis]}" for axis in moved]
        if arc is not None:
            said.append(self._centre(places, arc))
        self.at = places
        return " ".join([code, *said, *([behind] if behind else [])])

    def _place(self, axis: str, value_mm: float) -> str:
        return self._number(value_mm * self._factor(axis))

    def _factor(self, axis: str) -> float:
        """What a place in the geometry is multiplied with to become a number of the program."""
        factor = 2.0 if axis == "X" and is_diameter(self.state, self.settings.control) else 1.0
        return factor * self.words.signs[axis]

    def _number(self, length_mm: float) -> str:
        decimals = self.settings.output.decimals_of(is_inch=self.state.is_inch)
        return print_number(length_mm / self.state.mm_per_unit, decimals)

    def _centre(self, ends: Mapping[str, str], arc: ArcWays) -> str:
        """I and K of an arc to where it ends: from its start to its centre, never a diameter."""
        z_mm, radius_mm = arc.to_centre_mm
        offsets = {
            axis: self._number(offset_mm * self.words.signs[axis])
            for axis, offset_mm in (("X", radius_mm), ("Z", z_mm))
        }
        self._refuse_coarse_arc(ends, offsets, arc)
        return " ".join(f"{CENTRES[self.words.places.index(axis)]}{offsets[axis]}" for axis in "XZ")

    def _refuse_coarse_arc(self, ends: Mapping[str, str], offsets: Mapping[str, str], arc: ArcWays) -> None:
        """Few digits may leave an arc that ends elsewhere than on its circle, or behind its start.

        The first a control refuses, and the second it runs as a whole circle.
        """
        if not all(self.at.values()):
            return
        mm = self.state.mm_per_unit
        starts_mm = {axis: float(offsets[axis]) * mm for axis in "XZ"}
        moved_mm = {
            axis: (float(ends[axis]) - float(self.at[axis])) * mm / abs(self._factor(axis)) for axis in "XZ"
        }
        start_mm = math.hypot(*starts_mm.values())
        end_mm = math.hypot(*(starts_mm[axis] - moved_mm[axis] for axis in "XZ"))
        said = f"start {start_mm:z.4f} mm and end {end_mm:z.4f} mm from its centre"
        is_coarse = abs(start_mm - end_mm) > RADIUS_TOLERANCE_MM or start_mm == 0.0
        signs = self.words.signs
        to_centre_mm, way_mm = (
            (ways["Z"] * signs["Z"], ways["X"] * signs["X"]) for ways in (starts_mm, moved_mm)
        )
        if not is_coarse and math.hypot(*way_mm) < start_mm and arc.side * _side(to_centre_mm, way_mm) <= 0.0:
            is_coarse, said = True, "end behind its start, and become a whole circle"
        if is_coarse:
            decimals = self.settings.output.decimals_of(is_inch=self.state.is_inch)
            message = f"with {decimals} decimals an arc would {said}"
            raise RefusalError(UNREAD_FORM, message, "raise output.decimals")

    def comment(self, text: str) -> str:
        """A comment of a pass."""
        marks = self.settings.dialect.comment_marks
        return f"{marks.before}{text.upper()}{marks.behind}"

    @property
    def mirrors(self) -> bool:
        """True where a clockwise arc of the control turns the other way in the geometry."""
        return self.words.plane(self.state.modes.plane)[1]


def blocks_of_passes(
    passes: Sequence[Pass], frame: Frame, state: State, settings: Settings, feed: str
) -> list[str]:
    """The blocks of all passes, one comment a pass; ``feed`` stands in the first block that cuts."""
    writer = BlockWriter(state, settings)
    blocks: list[str] = []
    at = frame.inside(state.position.z, state.position.x)
    for one in passes:
        blocks.append(writer.comment(f"pass {one.number} {one.title}"))
        for motion in one.moves:
            text = _block(writer, frame, at, motion, feed)
            if text:
                blocks.append(text)
                feed = "" if motion.cuts else feed
            at = motion.end
    return blocks


def block_of_motion(writer: BlockWriter, frame: Frame, at: Sequence[float], motion: Motion) -> str:
    """One motion from ``at`` as a block; empty where nothing would move."""
    return _block(writer, frame, at, motion, "")


def _block(writer: BlockWriter, frame: Frame, at: Sequence[float], motion: Motion, feed: str) -> str:
    arc = None
    if motion.centre is not None:
        ways = (frame.outside(Point(to.t - at[0], to.h - at[1])) for to in (motion.centre, motion.end))
        arc = ArcWays(*ways)
    behind = feed if motion.cuts else ""
    return writer.block(_code(writer, frame, motion), *frame.outside(motion.end), behind, arc)


def _code(writer: BlockWriter, frame: Frame, motion: Motion) -> str:
    if motion.centre is None:
        return "G1" if motion.cuts else "G0"
    is_ccw = motion.turn > 0
    return "G3" if is_ccw != (frame.mirrors != writer.mirrors) else "G2"


_CUTS = re.compile(r"\bG[123]\b")


def wished(blocks: Sequence[str], wish: str) -> list[str]:
    """The blocks, each cut with a wish for vibration."""
    return [with_wish(block, wish) if _CUTS.search(block) else block for block in blocks]


def with_wish(text: str, wish: str) -> str:
    """A block with a wish behind its words; a comment stays behind them."""
    words, mark, rest = text.partition("(") if "(" in text else text.partition(";")
    return f"{words.rstrip()} {wish} {mark}{rest}".rstrip() if wish else text


_LATHE = Frame("Z", 1, 1)
_ROOM_FOR_WISH = 12
_GEOMETRY = frozenset("XZUWRIKCA") | {",R", ",C", ",A"}


def plain_contour(
    effects: Sequence[BlockEffect], state: State, settings: Settings
) -> tuple[list[str], list[Position]]:
    """The blocks of a contour with its corners and angles drawn, and where each ends; other words stay.

    Errors: CYC002 for a contour that cannot be used.
    """
    writer = BlockWriter(state, settings)
    steps = steps_of(effects, settings)
    drawn = iter(zip(steps, pieces_of(steps, _LATHE), strict=True))
    blocks: list[str] = []
    ends: list[Position] = []
    for effect in effects:
        if effect.move is None:
            blocks += [without_number(effect.block, settings)] if effect.block.words else []
            continue
        said = " ".join(effect.block.text_of(word) for word in other_words(effect.block))
        step, pieces = next(drawn)
        for text, end in _drawn(writer, step, pieces):
            blocks.append(f"{said} {text}".strip())
            ends.append(end)
            said = ""
        blocks += [said] if said else []
    return blocks, ends


def _drawn(writer: BlockWriter, step: Step, pieces: Sequence[Segment]) -> Iterator[tuple[str, Position]]:
    """The blocks of a move and its corner, and where each ends; a piece without length is left out."""
    for piece in pieces:
        motion = Motion(step.move.kind != "rapid", piece.end, piece.centre, piece.turn)
        text = _block(writer, _LATHE, piece.start, motion, "")
        if text:
            yield text, step.move.end._replace(z=piece.end.t, x=piece.end.h)


def without_number(block: Block, settings: Settings) -> str:
    """The text of a block without its N word: the number names the block of the contour alone.

    A comment that makes it longer than a new block may be is left out; the bracket keeps it.
    """
    number = block.sequence
    text = block.text if number is None else block.text[: number.start] + block.text[number.end :]
    text = text.strip()
    if len(text) + _ROOM_FOR_WISH > settings.control.max_line_chars:
        return " ".join(map(block.text_of, block.words))
    return text


def other_words(block: Block, wish: Sequence[Word] = ()) -> list[Word]:
    """The words of a block that are no part of its geometry, nor of its wish: G41, F, S, M."""
    return [
        word
        for word in block.words
        if word.address not in _GEOMETRY
        and word not in wish
        and not (word.address == "G" and (word.number or 0.0) < 4.0)
    ]
