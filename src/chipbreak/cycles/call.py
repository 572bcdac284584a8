"""The words of a cycle: depth, allowances, feed and speed, from one block or from two in a row.

::

    G71 U2. R0.5                          G71 P10 Q20 U0.4 W0.1 D2000 F0.3
    G71 P10 Q20 U0.4 W0.1 F0.3
    G73 U4. W1. R3                        G73 P10 Q20 U0.4 W0.1 I4. K1. D3 F0.3
    G73 P10 Q20 U0.4 W0.1 F0.3
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Mapping

from chipbreak.cycles import alarms
from chipbreak.cycles.alarms import with_alarm
from chipbreak.dialects.base import ContourCycle
from chipbreak.model.findings import NUMBER_THE_SHAPE
from chipbreak.model.flow import ContourCall
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.model.points import WRITE_THE_POINT
from chipbreak.model.words import is_diameter, length_mm
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block, Word
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

NO_CONTOUR = "CYC001"
BAD_DEPTH = "CYC004"
UNREAD_FORM = "CYC007"
_READ_BY = frozenset({"units", "distance", "arc_distance", "plane", "diameter", "compensation"})
_OFF_GROUPS = ("rotation", "scaling", "mirror", "polar", "cylinder", "polygon", "modal_macro")
_WORDS_OF_CALL: Mapping[ContourCycle, frozenset[str]] = {
    "along-z": frozenset("GPQUWDIKRFSN"),
    "along-x": frozenset("GPQUWDIKRFSN"),
    "pattern": frozenset("GPQUWDIKFSN"),
    "finish": frozenset("GPQFSN"),
}
_FIRST_BLOCK: Mapping[ContourCycle, frozenset[str]] = {
    "along-z": frozenset("GUR"),
    "along-x": frozenset("GWR"),
    "pattern": frozenset("GUWR"),
}
# The words of the first of two blocks, and what they say.
_EXAMPLES: Mapping[ContourCycle, tuple[str, str]] = {
    "along-z": ("U2. R0.5", "depth"),
    "along-x": ("W2. R0.5", "depth"),
    "pattern": ("U4. W1. R3", "passes"),
}
_MOST_TIMES = 500


class Call(NamedTuple):
    """A cycle as its blocks say it; lines ``first`` to ``last`` (exclusive), lengths in mm.

    ``contour_first``, ``contour_last``  the lines of its contour, both inclusive
    ``depth_mm``       of a pass, as a radius;  ``retract_mm`` how far the tool goes back
    ``x_allowance_mm``, ``z_allowance_mm``  with the sign of the program, X as a radius
    ``x_first_mm``, ``z_first_mm``  with their signs: what an additional pass along the contour leaves before
                       the last one, or of a pattern how far its first pass is from its last
    ``times``          the passes of a pattern
    ``is_type_two``    the cycle says that its contour may have pockets
    ``feed``, ``speed``  F and S as written, empty where the cycle says none
    ``wish``           N as written, the wish for vibration of every cut of the cycle
    """

    kind: ContourCycle
    first: int
    last: int
    contour_first: int
    contour_last: int
    name: str
    depth_mm: float = math.nan
    retract_mm: float = 0.0
    x_allowance_mm: float = 0.0
    z_allowance_mm: float = 0.0
    x_first_mm: float = 0.0
    z_first_mm: float = 0.0
    times: int = 1
    is_type_two: bool = False
    feed: str = ""
    speed: str = ""
    wish: str = ""


def refuse_modes(state: State) -> None:
    """Moves must mean plain places.  Errors: CYC007 for what gives them another meaning, or may."""
    modes = state.modes
    for group, why in state.left_open:
        if group in _READ_BY or group in _OFF_GROUPS:
            message = f"{group.replace('_', ' ')} is not known for sure at this cycle: {why}"
            raise RefusalError(UNREAD_FORM, message, "say the code again before the cycle")
    on = [group for group in _OFF_GROUPS if modes.value(group) != "off"]
    if on or modes.plane != "ZX" or modes.distance == "incremental" or modes.arc_distance == "absolute":
        what = on[0].replace("_", " ") if on else "another plane, G91 or G90.1"
        message = f"{what} is in force at this cycle"
        raise RefusalError(UNREAD_FORM, message, "end it before the cycle")


def kind_of(block: Block, settings: Settings) -> ContourCycle | None:
    """Which contour cycle a block calls."""
    cycles = settings.dialect.contour_cycles
    return next((cycles[code] for n in block.numbers("G") if (code := round(n * 10)) in cycles), None)


def read_call(interpreted: InterpretedProgram, contour: ContourCall) -> Call:
    """The words of a cycle.

    Errors: CYC001 without a contour, CYC004 without a depth, CYC007 for a form that is not known.
    """
    block = interpreted.program.block(contour.line)
    kind = kind_of(block, interpreted.settings)
    if kind is None:
        raise RefusalError(UNREAD_FORM, "this cycle is not written out as passes", "write its passes as G1")
    if contour.first is None or contour.last is None:
        all_missing = interpreted.flow.missing  # in the order of their lines
        missing = all_missing[bisect_left(all_missing, contour.line, key=lambda one: one.line)]
        help_text = with_alarm(NUMBER_THE_SHAPE, alarms.NO_SUCH_BLOCK)
        raise RefusalError(NO_CONTOUR, missing.message, help_text)
    _refuse_words(block, _WORDS_OF_CALL[kind])
    codes = [f"G{number:g}" for number in block.numbers("G")]
    name = f"{codes[0]} P{block.number('P'):g} Q{block.number('Q'):g}"
    call = Call(kind, contour.line, contour.line + 1, contour.first, contour.last, name)
    call = call._replace(feed=_text(block, "F"), speed=_text(block, "S"), wish=_text(block, "N"))
    return call if kind == "finish" else _with_lengths(call, block, interpreted)


def _with_lengths(call: Call, block: Block, interpreted: InterpretedProgram) -> Call:
    state = interpreted.effect(block.line).before
    settings = interpreted.settings
    halved = 2.0 if is_diameter(state, settings.control) else 1.0
    signs = settings.axis_words.signs
    call = call._replace(
        x_allowance_mm=_length(block, "U", state, settings) / halved * signs["X"],
        z_allowance_mm=_length(block, "W", state, settings) * signs["Z"],
    )
    call = call._replace(retract_mm=settings.cycles.retract_mm)
    if block.has("D"):
        return _checked(_one_block(call, block, state, settings))
    if block.has_any("IKR"):
        message = "I, K or R stands in a cycle that says no D"
        raise RefusalError(UNREAD_FORM, message, "say the whole cycle in one block, with D")
    before = _first_block(call, interpreted)
    if before is None:
        example, rest = _EXAMPLES[call.kind]
        code = call.name.partition(" ")[0]
        message = f"nothing says the {rest} of this cycle"
        help_text = f"write the block with the {rest} straight before it: {code} {example}"
        raise RefusalError(BAD_DEPTH, message, help_text)
    return _checked(_two_blocks(call._replace(first=before.line), before, state, settings))


def _one_block(call: Call, block: Block, state: State, settings: Settings) -> Call:
    """D, I, K and R of a cycle that stands in one block; I is a radius."""
    signs = settings.axis_words.signs
    call = call._replace(
        x_first_mm=_length(block, "I", state, settings) * signs["X"],
        z_first_mm=_length(block, "K", state, settings) * signs["Z"],
    )
    if call.kind == "pattern":
        return call._replace(times=_times(block, "D"))
    type_of_contour = block.number("R")
    if block.has("R") and type_of_contour not in (0.0, 1.0):
        message = "R of a cycle in one block is the type of its contour: R1 with pockets"
        raise RefusalError(UNREAD_FORM, message, "take R out, or write the cycle in two blocks")
    depth_mm = _depth_of_one_line(block, state, settings)
    return call._replace(depth_mm=depth_mm, is_type_two=type_of_contour == 1.0)


def _two_blocks(call: Call, before: Block, state: State, settings: Settings) -> Call:
    """What the block before says: depth and retract, or how far off a pattern begins, and its passes."""
    if call.kind == "pattern":
        signs = settings.axis_words.signs
        return call._replace(
            x_first_mm=_length(before, "U", state, settings) * signs["X"],
            z_first_mm=_length(before, "W", state, settings) * signs["Z"],
            times=_times(before, "R"),
        )
    letter = "U" if call.kind == "along-z" else "W"
    retract_mm = _length(before, "R", state, settings) if before.has("R") else call.retract_mm
    return call._replace(depth_mm=_length(before, letter, state, settings), retract_mm=retract_mm)


def _times(block: Block, letter: str) -> int:
    """How many passes a pattern has.  Errors: CYC004 for none, CYC007 for a number that is not whole."""
    number = block.number(letter)
    if number is None or number != int(number) or number > _MOST_TIMES:
        message = f"{letter} of this cycle is not the number of its passes"
        raise RefusalError(UNREAD_FORM, message, f"write a whole number up to {_MOST_TIMES}: {letter}3")
    if number < 1.0:
        message = f"{number:g} passes of a pattern cannot be"
        help_text = with_alarm(f"give {letter} as a number above zero", alarms.NO_TIMES)
        raise RefusalError(BAD_DEPTH, message, help_text)
    return int(number)


def _first_block(call: Call, interpreted: InterpretedProgram) -> Block | None:
    """The block with the depth and the retract, with nothing but comments between it and the cycle."""
    for line in range(call.first - 1, interpreted.program.source.body.start - 1, -1):
        block = interpreted.program.block(line)
        if block.is_empty and not block.opaque:
            continue
        if block.has("P") or kind_of(block, interpreted.settings) != call.kind:
            return None
        _refuse_words(block, _FIRST_BLOCK[call.kind])
        return block
    return None


def _checked(call: Call) -> Call:
    """Depth and retract can be."""
    depth_mm = 1.0 if call.kind == "pattern" else call.depth_mm
    if depth_mm <= 0.0:
        help_text = with_alarm("give the depth of a pass as a number above zero", alarms.NO_DEPTH)
        raise RefusalError(BAD_DEPTH, f"a depth of {depth_mm:g} mm cannot be", help_text)
    if call.retract_mm < 0.0:
        message = f"a retract of {call.retract_mm:g} mm cannot be"
        raise RefusalError(BAD_DEPTH, message, "give R as zero or more")
    return call


def _depth_of_one_line(block: Block, state: State, settings: Settings) -> float:
    """D of a block that says the whole cycle: increments where it has no point, or a length as others."""
    word = block.word("D")
    assert word is not None and word.number is not None
    if word.has_point or settings.cycles.depth_unit == "program":
        return word.number * state.mm_per_unit
    return word.number * settings.control.increment_mm * (2.54 if state.is_inch else 1.0)


def _length(block: Block, letter: str, state: State, settings: Settings) -> float:
    """A length in mm, 0 where it is not said.  Errors: CYC007 for one that is not known."""
    word = block.word(letter)
    if word is None:
        return 0.0
    length = length_mm(word, state, settings)
    if math.isnan(length):
        message = f"{_shown(word)} of this cycle has no decimal point"
        raise RefusalError(UNREAD_FORM, message, WRITE_THE_POINT)
    return length


def _text(block: Block, letter: str) -> str:
    word = block.word(letter)
    return "" if word is None else f"{letter}{word.value_text}"


def _refuse_words(block: Block, known: frozenset[str]) -> None:
    """Every word of the block has a meaning here, and nothing else stands in it."""
    said = Counter(word.address for word in block.words)
    twice = {letter for letter, count in said.items() if count > 1} - {"G"}
    foreign = next((w for w in block.words if w.address not in known or w.address in twice), None)
    if foreign is not None:
        raise RefusalError(
            UNREAD_FORM, f"{_shown(foreign)} has no known meaning in this cycle", "take it out"
        )
    if block.skip or block.has_macro or len(block.numbers("G")) > 1:
        message = "a cycle with block delete, a variable or another G code in its block is not written out"
        raise RefusalError(UNREAD_FORM, message, "write the cycle alone in its block, with plain numbers")


def _shown(word: Word) -> str:
    return f"{word.address}{word.value_text}"
