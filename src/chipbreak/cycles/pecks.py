"""G74, G75 and G83 without their pecks: each cut in one move, for a wish that says PECK OFF.

::

    G75 R0.5                              G1 X20. F0.1
    G75 X20. Z-18. P2000 Q3000 F0.1  ->   G0 X42.
                                          G0 Z-13. ...
"""

from __future__ import annotations

import math

from chipbreak.cycles.call import BAD_DEPTH, UNREAD_FORM, refuse_modes
from chipbreak.cycles.contour import Frame, Point
from chipbreak.cycles.promise import PlannedMoves
from chipbreak.cycles.roughing import Motion, Pass
from chipbreak.cycles.writing import blocks_of_passes, without_number
from chipbreak.editing.edits import Edit
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.motion import named_place
from chipbreak.model.words import length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError

_WORDS = frozenset("GXZUWPQRIKDF")
# What P and R of a G83 on a lathe are differs from maker to maker.
_HOLE_WORDS = frozenset("GXZUWQF")
_LATHE = Frame("Z", 1, 1)
_MOST_CUTS = 500
_NOTHING_MM = 1e-6


def is_peck(interpreted: InterpretedProgram, line: int) -> bool:
    """True for a G74 or G75 that cuts."""
    effect = interpreted.effect(line)
    return "peck-cycle" in effect.non_modal and effect.block.has_any("XZUW")


def is_deep_hole(interpreted: InterpretedProgram, line: int) -> bool:
    """True for a G83 that drills, and does not go on with the one before."""
    effect = interpreted.effect(line)
    codes = {round(number * 10) for number in effect.block.numbers("G")}
    begins = effect.before.modes.motion != "cycle" and effect.move is not None
    return begins and not codes.isdisjoint(interpreted.settings.dialect.deep_drilling)


def deep_hole_edit(interpreted: InterpretedProgram, line: int) -> Edit:
    """The edit that writes out the cycle in a line (from 0), and the G80 that ends it, as one cut.

    Errors: CYC007 for a form that is not known.
    """
    block = interpreted.program.block(line)
    state = interpreted.effect(line).before
    end = named_place(block, state, "XZUW", interpreted.settings)
    last, ends = _end_of_cycle(interpreted, line)
    _refuse_hole(block, state, (end.z - state.position.z, end.x - state.position.x))
    start = _LATHE.inside(state.position.z, state.position.x)
    moves = (Motion(True, _LATHE.inside(end.z, end.x)), Motion(False, start))
    feed = "".join(block.text_of(word) for word in block.words_of("F"))
    blocks = blocks_of_passes([Pass(1, "without pecks", moves)], _LATHE, state, interpreted.settings, feed)
    back = ["G1"] if state.modes.motion == "line" else []
    name = " ".join(block.text_of(word) for word in block.words_of("GXZUW"))
    promise = PlannedMoves(frame=_LATHE, motions=moves)
    content = (*blocks, *back, *ends)
    return Edit(line, last + 1, content, name, "the hole of the cycle without its pecks", promise)


def _end_of_cycle(interpreted: InterpretedProgram, line: int) -> tuple[int, list[str]]:
    """The line of the G80 behind a cycle, and the blocks up to it; none of them may move or drill again."""
    said: list[str] = []
    for effect in interpreted.effects_of(line + 1, interpreted.program.source.body.stop):
        block = effect.block
        if effect.move is not None or effect.after.ended or block.opaque or block.controls or block.skip:
            break
        said += [without_number(block, interpreted.settings)] if not block.is_empty else []
        if effect.after.modes.motion != "cycle":
            return block.line, said
    message = "a G80 without a move does not stand behind the one hole of this cycle"
    raise RefusalError(UNREAD_FORM, message, "end it with a block G80 after one hole, or take PECK OFF out")


def _refuse_hole(block: Block, state: State, way_mm: tuple[float, float]) -> None:
    refuse_modes(state)
    foreign = next((word for word in block.words if word.address not in _HOLE_WORDS), None)
    why = ""
    if foreign is not None or block.skip or block.has_macro or len(block.numbers("G")) > 1:
        why = "the cycle does not stand alone in its block, with plain numbers and without P and R"
    elif math.isnan(sum(way_mm)):
        why = f"where this cycle starts or ends is not known: {state.unknown_why}"
    elif abs(way_mm[1]) > _NOTHING_MM or abs(way_mm[0]) <= _NOTHING_MM:
        why = "the tool does not wait over its hole"
    elif state.modes.compensation != "off" or state.modes.motion not in ("rapid", "line"):
        why = "nose compensation, an arc or a cycle is in force at this cycle"
    if why:
        raise RefusalError(UNREAD_FORM, why, "move over the hole before it, or take PECK OFF out")


def peck_edit(interpreted: InterpretedProgram, line: int) -> Edit:
    """The edit that writes out the cycle in a line (from 0) with one move for each cut.

    Errors: CYC004 for a step that cannot be, CYC007 for a form that is not known.
    """
    block = interpreted.program.block(line)
    state = interpreted.effect(line).before
    settings = interpreted.settings
    _refuse(block, state)
    end = named_place(block, state, "XZUW", settings)
    start = _LATHE.inside(state.position.z, state.position.x)
    along_z = _goes_along_z(block, settings)
    moves: list[Motion] = []
    bottom = _LATHE.inside(end.z, end.x)
    if math.isnan(bottom.t + bottom.h):
        raise RefusalError(
            UNREAD_FORM, "where this cycle ends is not known", "write its points with decimals"
        )
    for place in _places(block, state, settings, (start.h, bottom.h) if along_z else (start.t, bottom.t)):
        above = Point(start.t, place) if along_z else Point(place, start.h)
        below = Point(bottom.t, place) if along_z else Point(place, bottom.h)
        moves += [Motion(False, above)] if moves else []
        moves += [Motion(True, below), Motion(False, above)]
    if math.dist(moves[0].end, start) <= _NOTHING_MM:
        raise RefusalError(UNREAD_FORM, "this cycle has no depth", "give the end of its cuts")
    moves.append(Motion(False, start))
    feed = "".join(block.text_of(word) for word in block.words_of("F"))
    blocks = blocks_of_passes([Pass(1, "without pecks", tuple(moves))], _LATHE, state, settings, feed)
    back = ["G1"] if state.modes.motion == "line" else []
    name = " ".join(block.text_of(word) for word in block.words_of("GXZUW"))
    promise = PlannedMoves(frame=_LATHE, motions=tuple(moves))
    return Edit(line, line + 1, (*blocks, *back), name, "the cuts of the cycle without its pecks", promise)


def _refuse(block: Block, state: State) -> None:
    refuse_modes(state)
    foreign = next((word for word in block.words if word.address not in _WORDS), None)
    back = next((word for word in block.words_of("RD") if word.number != 0.0), None)
    why = ""
    if foreign is not None or block.skip or block.has_macro or len(block.numbers("G")) > 1:
        why = "the cycle does not stand alone in its block, with plain numbers"
    elif back is not None:
        why = "the cycle moves aside at the bottom of its cuts"
    elif math.isnan(state.position.x + state.position.z):
        why = f"where this cycle starts is not known: {state.unknown_why}"
    elif state.modes.compensation != "off" or state.modes.motion not in ("rapid", "line"):
        why = "nose compensation, an arc or a cycle is in force at this cycle"
    if why:
        raise RefusalError(UNREAD_FORM, why, "write its cuts as G1, or take PECK OFF out")


def _goes_along_z(block: Block, settings: Settings) -> bool:
    """The lower of the two codes of a control cuts along Z, the higher one along X."""
    codes = settings.dialect.g_codes
    pecks = sorted(number for number, code in codes.items() if code.value == "peck-cycle")
    return round(block.numbers("G")[0] * 10) == pecks[0]


def _places(block: Block, state: State, settings: Settings, ends: tuple[float, float]) -> list[float]:
    """Where the cuts stand, from the start to the end across them, in steps."""
    first, last = ends
    if abs(last - first) <= _NOTHING_MM:
        return [first]
    letters = "PI" if _goes_along_z(block, settings) else "QK"
    words = block.words_of(letters)
    step_mm = _step_mm(words[0], state, settings) if len(words) == 1 else math.nan
    if not step_mm > _NOTHING_MM or abs(last - first) / step_mm > _MOST_CUTS:
        message = f"{letters[0]} of this cycle is no step from one cut to the next"
        help_text = f"give the step as a number above zero, for {_MOST_CUTS} cuts at most"
        raise RefusalError(BAD_DEPTH, message, help_text)
    count = math.ceil(abs(last - first) / step_mm - _NOTHING_MM)
    way = math.copysign(step_mm, last - first)
    return [first + way * number for number in range(count)] + [last]


def _step_mm(word: Word, state: State, settings: Settings) -> float:
    """P and Q without a point count increments; X steps are radii."""
    if word.number is None or word.has_point or word.address in "IK":
        return length_mm(word, state, settings)
    return word.number * settings.control.increment_mm * (2.54 if state.is_inch else 1.0)
