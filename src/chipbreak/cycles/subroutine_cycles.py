"""LinuxCNC's G70 to G72.2: the contour stands in a subroutine, and the tool stays where the contour ends.

::

    o100 sub
      G0 X16 Z2
      G1 Z-15
      G1 X52
    o100 endsub
    G71 Q100 X60 Z2 D0.5 I2 R0.5

X and Z say where the cycle begins, D how far off the contour it stays, I is the depth of a pass, R how far
the tool goes back, U and W what stays beyond D.  None of I, R, D, U and W is a diameter.
G71.1 leaves the pockets, G71.2 cuts nothing but them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import takewhile

from chipbreak.cycles.call import BAD_DEPTH, NO_CONTOUR, UNREAD_FORM, refuse_modes
from chipbreak.cycles.contour import (
    Frame,
    Point,
    Segment,
    filled,
    turns_back_along_t,
)
from chipbreak.cycles.corners import BAD_CONTOUR
from chipbreak.cycles.offset import at_distance
from chipbreak.cycles.promise import PlannedMoves, UnrolledRoughing
from chipbreak.cycles.reading import (
    BEYOND_START,
    TURNS_BACK,
    Contour,
    Step,
    effects_of_contour,
    frame_of,
    segments_of,
    steps_of,
)
from chipbreak.cycles.roughing import Motion, Pass, Roughing, roughing_passes
from chipbreak.cycles.starts import END_COMPENSATION, UNDER_COMPENSATION, refuse_next_move
from chipbreak.cycles.writing import blocks_of_passes
from chipbreak.dialects.base import ContourCycle
from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import Position, State
from chipbreak.model.motion import named_place
from chipbreak.model.words import codes_of, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.comments import acting_comments
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

_WORDS = frozenset("GQXZDEIPRUWFS")
_MOST_TIMES = 100
_NARROW_STEPS = 8
_MOST_PASSES = 500
_SAME_MM = 1e-6


class _Call(NamedTuple):
    """The words of a cycle; lengths in mm.  ``subcycle`` is the digit behind the point."""

    kind: ContourCycle
    subcycle: int
    start: Position
    distance_mm: float
    end_distance_mm: float
    times: int
    depth_mm: float
    retract_mm: float
    u_mm: float
    w_mm: float


class _Cut(NamedTuple):
    """What is written for a cycle: the ways to its start, its passes, why, and what they promise."""

    frame: Frame
    ways: list[Motion]
    passes: Sequence[Pass]
    reason: str
    promise: UnrolledRoughing | PlannedMoves


def cycles_in(interpreted: InterpretedProgram) -> dict[int, ContourCycle]:
    """The lines of such cycles, and what each is."""
    codes = interpreted.settings.dialect.subroutine_cycles
    if not codes:
        return {}
    found = {}
    for effect in interpreted.effects:
        kind = _kind_of(effect.block, interpreted.settings)
        if kind is not None and effect.block.has("Q"):
            found[effect.block.line] = kind[0]
    return found


def _kind_of(block: Block, settings: Settings) -> tuple[ContourCycle, int] | None:
    codes = settings.dialect.subroutine_cycles
    said = [code for number in block.numbers("G") if (code := round(number * 10)) in codes]
    return (codes[said[0]], said[0] % 10) if said else None


def subroutine_edit(interpreted: InterpretedProgram, line: int) -> Edit:
    """The edit that writes out the cycle in a line (from 0).

    Errors: CYC001 to CYC007, as their messages say.
    """
    state = interpreted.before(line)
    block = interpreted.program.block(line)
    if state.ended:
        raise RefusalError(UNREAD_FORM, "it stands behind the end of the program", "move it before M2 or M30")
    _refuse_state(state, block)
    refuse_next_move(interpreted, line)
    call = _read(block, state, interpreted.settings)
    if math.isnan(call.start.x + call.start.z):
        why = f"where this cycle starts is not known: {state.unknown_why}"
        raise RefusalError(UNREAD_FORM, why, "say X and Z in the cycle, or move there with G0 before it")
    first, last = _body(interpreted, block, line)
    started = state._replace(position=call.start)
    effects = effects_of_contour(interpreted, started, first, last)
    _refuse_modal_arcs(effects, interpreted.settings)
    _refuse_what_acts(interpreted, first, last)
    steps = steps_of(effects, interpreted.settings)
    if call.kind == "finish":
        return _finish(interpreted, block, call, steps)
    return _rough(interpreted, block, call, steps)


def _refuse_state(state: State, block: Block) -> None:
    refuse_modes(state)
    foreign = next((word for word in block.words if word.address not in _WORDS), None)
    has_more = block.has_macro or block.skip or block.marks or len(block.numbers("G")) > 1
    if foreign is not None or has_more:
        alone = "the cycle does not stand alone in its block, with plain numbers"
        raise RefusalError(UNREAD_FORM, alone, "write it so, with the numbers themselves")
    if state.modes.compensation != "off":
        raise RefusalError(UNREAD_FORM, UNDER_COMPENSATION, END_COMPENSATION)


def _read(block: Block, state: State, settings: Settings) -> _Call:
    def length(letter: str, default: float) -> float:
        word = block.word(letter)
        return default * state.mm_per_unit if word is None else length_mm(word, state, settings)

    kind = _kind_of(block, settings)
    assert kind is not None
    times = block.number("P") if block.has("P") else 1.0
    call = _Call(
        *kind,
        named_place(block, state, "XZ", settings),
        length("D", 0.0),
        length("E", 0.0),
        int(times) if times is not None and times == int(times) else 0,
        length("I", 1.0),
        length("R", 0.5),
        length("U", 0.0),
        length("W", 0.0),
    )
    if any(math.isnan(value) for value in (*call[3:5], *call[6:])):
        message = "a length of this cycle cannot be known"
        raise RefusalError(UNREAD_FORM, message, "write plain numbers")
    if call.depth_mm <= 0.0:
        message = "I of this cycle is not above zero"
        raise RefusalError(BAD_DEPTH, message, "give the depth of a pass as a number above zero")
    if not 1 <= call.times <= _MOST_TIMES:
        message = "P of this cycle is not the number of its passes"
        raise RefusalError(BAD_DEPTH, message, f"write a whole number from 1 to {_MOST_TIMES}")
    if min(call.distance_mm, call.end_distance_mm, call.retract_mm, call.u_mm, call.w_mm) < 0.0:
        message = "D, E, R, U or W of this cycle is negative"
        raise RefusalError(UNREAD_FORM, message, "give each of them as zero or more")
    if call.kind == "along-x" and max(call.u_mm, call.w_mm) > 0.0:
        message = "what U and W mean in a cycle along X is told in two ways for this control"
        raise RefusalError(UNREAD_FORM, message, "leave the stock by D, or move the contour")
    return call


def _body(interpreted: InterpretedProgram, block: Block, line: int) -> tuple[int, int]:
    """The lines of the subroutine, both inclusive.  Errors: CYC001 where it is not before the cycle."""
    number = block.number("Q")
    begun = None
    named = (effect.block for effect in interpreted.effects if effect.block.controls)
    for one in takewhile(lambda block: block.line < line, named):
        at = one.line
        keywords = {(control.keyword, control.label) for control in one.controls}
        if number is not None and ("O-SUB", f"{number:g}") in keywords:
            begun = at + 1
        elif begun is not None and ("O-ENDSUB", f"{number:g}") in keywords:
            return begun, at - 1
    name = "its Q" if number is None else f"o{number:g}"
    message = f"the subroutine {name} with the contour does not stand before this cycle"
    raise RefusalError(NO_CONTOUR, message, "write o100 sub ... o100 endsub before the cycle that says Q100")


def _refuse_modal_arcs(effects: list[BlockEffect], settings: Settings) -> None:
    """This control turns an arc without its own code the wrong way in these cycles."""
    for effect in effects:
        is_arc = effect.move is not None and effect.move.kind in ("cw", "ccw")
        if is_arc and not codes_of(effect.block, "motion", settings.dialect):
            message = "an arc of the contour does not say G2 or G3 itself, which this control reads as G2"
            raise RefusalError(BAD_CONTOUR, message, "write G2 or G3 into each arc of the contour")


def _refuse_what_acts(interpreted: InterpretedProgram, first: int, last: int) -> None:
    """How often the control would do what comments and marks ($1) say is not known."""
    for block in map(interpreted.program.block, range(first, last + 1)):
        marks = [block.text[one.start : one.end].strip() for one in block.marks]
        for text in filter(None, (acting_comments(block), *marks)):
            message = f"{text} stands in the contour, and when the control does it is not known"
            raise RefusalError(UNREAD_FORM, message, "put it on a line before the cycle")


def _rough(interpreted: InterpretedProgram, block: Block, call: _Call, steps: list[Step]) -> Edit:
    along = "Z" if call.kind == "along-z" else "X"
    frame = frame_of([step.move for step in steps], along)
    contour = _contour(steps, frame, call.distance_mm)
    contour = tuple(one.shifted(-call.w_mm, call.u_mm) for one in contour)
    if call.subcycle == 1:
        _refuse_open_pocket(contour)
        contour = filled(contour).contour
    begin = frame.inside(call.start.z, call.start.x)
    start = Point(min(begin.t - call.w_mm, contour[0].start.t), begin.h)
    state = interpreted.before(block.line)
    at = frame.inside(state.position.z, state.position.x)
    if at.t > start.t + _SAME_MM and min(at.h, start.h) < begin.h - _SAME_MM:
        message = "the way to the start of this cycle may lead through stock"
        raise RefusalError(BEYOND_START, message, "move there with G0 before the cycle")
    step_mm = interpreted.settings.output.step_mm(is_inch=state.is_inch)
    cycle = Roughing(
        start,
        contour,
        call.depth_mm,
        call.retract_mm,
        narrow_mm=_NARROW_STEPS * step_mm,
        only_pockets=call.subcycle == 2,
        stays_at_h_mm=begin.h + call.u_mm,
    )
    lowest_mm = min(one.end.h for one in contour)
    if (start.h - lowest_mm) / call.depth_mm > _MOST_PASSES:
        raise RefusalError(BAD_DEPTH, "this cycle would have too many passes", "give a greater I")
    passes = roughing_passes(cycle)
    end = contour[-1].end
    place = frame.outside(Point(end.t, max(end.h, begin.h + call.u_mm)))
    promise = UnrolledRoughing(
        cycle=cycle,
        contour=Contour(frame, start, contour, feeds_in=False, first_names_both=True),
        end=state.position._replace(z=place[0], x=place[1]),
        leaves_motion=True,
    )
    reason = f"passes of {call.depth_mm:g} mm along {along} to the contour in its subroutine"
    return _edit(interpreted, block, _Cut(frame, [Motion(False, start)], passes, reason, promise))


def _refuse_open_pocket(contour: tuple[Segment, ...]) -> None:
    """A cycle that leaves pockets cuts nothing behind the edge of one that no wall ends."""
    highest_mm = max(max(one.start.h, one.end.h) for one in contour)
    if contour[-1].end.h < highest_mm - _SAME_MM:
        message = "the contour ends in a pocket, behind whose edge this cycle cuts nothing"
        help_text = "end the contour as far out as its outermost point, or clear the pocket too (G71, G72)"
        raise RefusalError(TURNS_BACK, message, help_text)


def _contour(steps: list[Step], frame: Frame, distance_mm: float) -> tuple[Segment, ...]:
    """The contour in the axes of the passes, at its distance.  Errors: CYC003 where it turns back."""
    contour = at_distance(segments_of(steps[1:], frame), distance_mm)
    if turns_back_along_t(contour):
        message = "the contour turns back along the passes: an undercut"
        raise RefusalError(TURNS_BACK, message, "take the undercut out of the contour, or cut it by itself")
    return contour


def _finish(interpreted: InterpretedProgram, block: Block, call: _Call, steps: list[Step]) -> Edit:
    frame, plain = _frame_of_finish(steps)
    start = frame.inside(call.start.z, call.start.x)
    passes: list[Pass] = []
    for number in range(call.times, 0, -1):
        share = (number - 1) / call.times
        distance_mm = share * (call.distance_mm - call.end_distance_mm) + call.end_distance_mm
        contour = at_distance(plain, distance_mm)
        moves = [Motion(False, start)] if passes else []
        moves.append(Motion(False, contour[0].start))
        moves += [Motion(True, one.end, one.centre, one.turn) for one in contour]
        passes.append(Pass(len(passes) + 1, f"{distance_mm:.4g} mm off the contour", tuple(moves)))
    last = passes[-1].moves[-1].end
    z_mm, x_mm = frame.outside(last)
    ways = [Motion(False, start)]
    promise = PlannedMoves(
        frame=frame,
        motions=(*ways, *(motion for one in passes for motion in one.moves)),
        end=interpreted.before(block.line).position._replace(z=z_mm, x=x_mm),
        leaves_motion=True,
    )
    return _edit(interpreted, block, _Cut(frame, ways, passes, "the contour in its subroutine", promise))


def _frame_of_finish(steps: list[Step]) -> tuple[Frame, tuple[Segment, ...]]:
    """The axes of a finishing cut: along the one in which the contour does not turn back."""
    moves = [step.move for step in steps]
    frame = frame_of(moves, "Z")
    plain = segments_of(steps[1:], frame)
    if turns_back_along_t(plain):
        frame = frame_of(moves, "X")
        plain = segments_of(steps[1:], frame)
    return frame, plain


def _edit(interpreted: InterpretedProgram, block: Block, cut: _Cut) -> Edit:
    """The blocks of all passes, with the way to the start before them."""
    state = interpreted.before(block.line)
    words = [block.text_of(word) for word in block.words_of("FS")]
    first = cut.passes[0]._replace(moves=(*cut.ways, *cut.passes[0].moves))
    passes = [first, *cut.passes[1:]]
    blocks = blocks_of_passes(passes, cut.frame, state, interpreted.settings, "")
    content = (*filter(None, (acting_comments(block), " ".join(words))), *blocks)
    name = " ".join(block.text_of(word) for word in block.words_of("GQ"))
    return Edit(block.line, block.line + 1, content, name, cut.reason, cut.promise)
