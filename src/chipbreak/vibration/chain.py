"""Requests in a row become one chain; what must not vibrate is refused, with the reason and the way out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from chipbreak.cycles.corners import MAY_BE_AXES, may_be_corner
from chipbreak.cycles.nose_runs import compensated_runs
from chipbreak.dialects import Dialect
from chipbreak.dialects.modes import Group
from chipbreak.insertion.sure_effects import words_for
from chipbreak.kinematics.toolpath import Leg
from chipbreak.model.block_effect import BlockEffect, Move
from chipbreak.model.findings import COMPENSATED
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import NOWHERE, Setting, State
from chipbreak.model.paths import UNNAMED
from chipbreak.model.points import WRITE_THE_POINT, moved_without_point
from chipbreak.model.words import JUMPED, codes_of, length_mm
from chipbreak.settings.axis_words import AXES, AxisWords
from chipbreak.syntax.comments import acting_comments
from chipbreak.syntax.nodes import Assignment, Block, Control, Word
from chipbreak.syntax.shapes import bits_of
from chipbreak.text.diagnostics import Diagnostic, RefusalError
from chipbreak.text.frozen_table import FrozenTable
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.called import READ_BY, Called
from chipbreak.vibration.directive import KEYS
from chipbreak.vibration.left_cut import NO_SPINDLE, UNKNOWN_SPEED, LeftCut
from chipbreak.vibration.request import Request

_NO_REASONS: Mapping[int, RefusalError] = FrozenTable({})
# Modal groups that must be at rest, with what the user knows them as.
_AT_REST: dict[Group, tuple[str, str, str, str]] = {
    "compensation": ("off", COMPENSATED, "tool nose or cutter compensation (G41, G42) is active", "G40"),
    "rotation": ("off", "VIB041", "the coordinate system is rotated (G68)", "G69"),
    "polar": ("off", "VIB041", "polar interpolation or polar input is active", "G15 or G13.1 (G113)"),
    "interpolation": ("off", "VIB041", "polar interpolation is active", "G13.1"),
    "cylinder": ("off", "VIB041", "cylindrical interpolation (G7.1) is on", "G7.1 C0"),
    "polygon": ("off", "VIB041", "polygon turning is active", "G50.2"),
    "scaling": ("off", "VIB041", "scaling (G51) is active", "G50"),
    "mirror": ("off", "VIB041", "mirror image (G51.1) is active", "G50.1"),
    "modal_macro": ("off", "VIB042", "a modal macro call (G66) is active", "G67"),
}
SPEED_MODES = (96.0, 97.0)  # G codes
# What is said of a corner in a block, and of a cut behind one.
_BY_CORNERS = ("VIB048", "VIB051")
_MOTION_CODES = (0.0, 1.0, 2.0, 3.0)
_START_HERE = "give S and M3 or M4 (without a choice of spindle) between there and the cut"
_NAME_IT = "where that code turns this spindle, name it: --set spindle.cw_codes=13 for M13"


@dataclass(frozen=True, eq=False)
class Chain:
    """Cutting blocks in a row that vibrate as one; ``first`` to ``last`` (exclusive) are their lines.

    ``whole`` is the chain of which this is a step, None where it is one itself: words stand for all steps.
    """

    requests: tuple[Request, ...]
    whole: Chain | None = None

    @property
    def first(self) -> int:
        """The first line."""
        return self.requests[0].effect.block.line

    @property
    def last(self) -> int:
        """The line behind the last."""
        return self.requests[-1].effect.block.line + 1

    @cached_property
    def before(self) -> State:
        """The state when the tool starts to move: modal words of the first block have acted."""
        effect = self.requests[0].effect
        return effect.after._replace(position=effect.before.position, unknown_why=effect.before.unknown_why)

    @property
    def after(self) -> State:
        """The state behind the last block, as programmed."""
        return self.requests[-1].effect.after

    @property
    def moves(self) -> Iterator[Move]:
        """The moves, in order."""
        for request in self.requests:
            assert request.effect.move is not None
            yield request.effect.move

    @property
    def axes(self) -> str:
        """The axes that the chain moves, in the order X, Y, Z."""
        named = {axis for move in self.moves for axis in move.axes + move.plane}
        return "".join(axis for axis in AXES if axis in named)

    def may_be_left(self, refused: str) -> bool:
        """True where the chain stays as it was when it cannot vibrate; ``refused`` is the profile's key."""
        return all(request.may_be_left(refused) for request in self.requests)

    def left(self, said: Diagnostic) -> LeftCut:
        """The chain as a cut that stays as it was, and what stood in its way."""
        return LeftCut(self.first, self.last, said, self.requests[0].asked_by)

    @property
    def asked_by_word(self) -> bool:
        """True when words of its blocks ask for the vibration, and no comment or profile alone."""
        return any(request.by_word for request in self.requests)

    def preamble(self) -> str:
        """Words of the first block that act before its move and are no part of its move or speed."""
        block = self.requests[0].effect.block
        kept = [w for w in _preamble_words(block) if w.address != "G" or w.number not in SPEED_MODES]
        return " ".join(map(block.text_of, kept))


# The corner behind a move, or its angle, beside or without a comma.
_CORNER_LETTERS = frozenset("CRIKA")
_ANGLES = frozenset({",A"})
_CORNERS = bits_of(_CORNER_LETTERS)
_MOST_BETWEEN = 20


def _preamble_words(block: Block) -> list[Word]:
    return [w for w in block.words_of("GM") if w.address == "M" or w.number not in _MOTION_CODES]


class Chains(NamedTuple):
    """The chains of a program; the cuts that stay as they are; what is an error."""

    chains: list[Chain]
    left: list[LeftCut]
    refused: list[Diagnostic]


def chains_of(
    interpreted: InterpretedProgram,
    requests: Sequence[Request],
    reasons: Mapping[int, RefusalError] = _NO_REASONS,
) -> Chains:
    """Group requests into chains, and say which of them must not vibrate.

    ``reasons``: why cuts, by their line, stay under nose compensation, or why corners there are not drawn.
    """
    key = interpreted.settings.vibration.refused
    refused: list[Diagnostic] = []
    left: list[LeftCut] = []
    groups: list[list[Request]] = []
    called = Called(interpreted)
    ways_out = _ways_out(interpreted)
    for request in requests:
        refusal = refusal_of(request, interpreted) or _refusal_by_what_came(request, called, ways_out)
        if refusal is not None:
            error, at = refusal
            line = request.effect.block.line
            error = _with_reason(error, reasons.get(line))
            said = interpreted.program.diagnose(line, error.code, error.message, error.help, at=at)
            if request.may_be_left(key):
                left.append(Chain((request,)).left(said))
            else:
                refused.append(said)
        elif groups and _joins(interpreted, groups[-1][-1], request):
            groups[-1].append(request)
        else:
            groups.append([request])
    chains = [Chain(tuple(group)) for group in groups]
    return Chains(chains, left, refused)


def _with_reason(error: RefusalError, reason: RefusalError | None) -> RefusalError:
    """The same, with what stood in the way of the offset that the control would make, or of a corner."""
    if reason is not None and error.code == COMPENSATED:
        return reason
    if reason is None or error.code not in _BY_CORNERS:
        return error
    message = f"{error.message}; the corners here are not drawn: {reason.message}"
    return RefusalError(error.code, message, reason.help)


def _joins(interpreted: InterpretedProgram, one: Request, other: Request) -> bool:
    """True when a cut goes on in the next block: nothing between them, nothing changed, the same wish."""
    between = range(one.effect.block.line + 1, other.effect.block.line)
    blocks = [interpreted.program.block(line) for line in between]
    if not all(block.is_empty for block in blocks) or any(
        map(acting_comments, [*blocks, other.effect.block])
    ):
        return False
    if other.effect.block.line in interpreted.flow.targets or _preamble_words(other.effect.block):
        return False
    a = one.effect.after
    b = other.effect.after
    same_feed = a.feed is not None and b.feed is not None and a.feed.value == b.feed.value
    return same_feed and a.speed == b.speed and one.same_wish(other)


def refusal_of(
    request: Request, interpreted: InterpretedProgram
) -> tuple[RefusalError, tuple[int, int] | None] | None:
    """Why a block must not vibrate, with the place in the block, or None."""
    effect = request.effect
    axis_words = interpreted.settings.axis_words
    move = effect.move
    state = effect.after
    at = (effect.vibration[0].start, effect.vibration[-1].end) if effect.vibration else None
    if effect.in_contour:
        message = "this block is the shape of a cycle (G70 to G73); the control cuts it in its own way"
        help_text = f"write the passes as G1 without the cycle, or {_without(request)}"
        return RefusalError("VIB043", message, help_text), at
    if interpreted.flow.is_run_again(effect.block.line):
        message = (
            "a cycle behind this block (G70 to G73) takes it for its shape, and would cut the vibration too"
        )
        return RefusalError("VIB043", message, f"write that cycle as G1, or {_without(request)}"), at
    if move is None or not move.is_cut:
        return _foreign_axis(effect, axis_words) or (_not_a_cut(move, _without(request)), at)
    if effect.block.skip:
        message = "a block with block delete (/) cannot vibrate: the cut would start elsewhere without it"
        return RefusalError("VIB045", message, f"take the / away, or {_without(request)}"), (0, 1)
    for group, (rest, code, what, end) in _AT_REST.items():
        if state.modes.value(group) != rest:
            help_text = f"turn it off before the cut ({end}), or {_without(request)}"
            return RefusalError(code, f"{what}; a cut cannot vibrate in it", help_text), at
    return (
        _mark_refusal(effect)
        or _open_refusal(request, at)
        or _mode_refusal(effect, interpreted.settings.dialect)
        or _spindle_refusal(request, at)
        or _words_refusal(effect, axis_words, interpreted.settings.dialect)
        or _position_refusal(interpreted, effect, move)
        or _feed_refusal(interpreted, state)
        or _path_mode_refusal(interpreted, state)
    )


def _open_refusal(
    request: Request, at: tuple[int, int] | None
) -> tuple[RefusalError, tuple[int, int] | None] | None:
    """A mode that a skipped block, or another way to this one, may have left otherwise."""
    for group, why in request.effect.after.left_open:
        if group in READ_BY:
            message = f"not known for sure: {words_for(group)}; {why}"
            help_text = f"say the code again between there and this cut, or {_without(request)}"
            return RefusalError("VIB050", message, help_text), at
    return None


def _mark_refusal(effect: BlockEffect) -> tuple[RefusalError, tuple[int, int]] | None:
    """A mark in front of the first of many new blocks would not hold for the others, or hold twice.

    A statement, or a variable that is set, would be lost: the words of a cut are written anew.
    """
    block = effect.block
    foreign: list[Control | Assignment] = [*block.controls, *block.assignments]
    for one in foreign:
        shown = block.text[one.start : one.end].strip()
        message = f"{shown} cannot stand in a block that vibrates"
        error = RefusalError("VIB048", message, "put it on a line of its own before this block")
        return error, (one.start, one.end)
    return None


def _mode_refusal(effect: BlockEffect, dialect: Dialect) -> tuple[RefusalError, tuple[int, int]] | None:
    """A code with words of its own: beside a cut they would be read as those of the cut, or be lost."""
    modes: tuple[tuple[Group, str], ...] = (
        ("path", effect.after.path_words),
        ("look_ahead", effect.after.smooth_words),
    )
    for group, words in modes:
        codes = codes_of(effect.block, group, dialect)
        if codes and " " in words:
            message = f"{words} cannot stand in a block that vibrates"
            error = RefusalError("VIB048", message, "put it into a block of its own before this one")
            code = next(
                word for word in effect.block.words_of("G") if round((word.number or 0.0) * 10) == codes[0]
            )
            return error, (code.start, code.end)
    return None


def _spindle_refusal(
    request: Request, at: tuple[int, int] | None
) -> tuple[RefusalError, tuple[int, int] | None] | None:
    state = request.effect.after
    if state.spindle_why:
        message = f"whether the spindle turns is not known: {state.spindle_why}"
        named = f"{_NAME_IT}; else " if UNNAMED in state.spindle_why else ""
        return RefusalError("VIB069", message, f"{named}{_START_HERE}, or {_without(request)}"), at
    if not state.turns:
        message = "the spindle is not turning (no M3 or M4 before this block)"
        return RefusalError(NO_SPINDLE, message, "start the spindle before the cut"), at
    return None


def _without(request: Request) -> str:
    """How this block is left without vibration: its own words ask whatever stands before it."""
    return "take N, f, E and Q out of it" if request.by_word else "write (VIB OFF) before it"


def _foreign_axis(effect: BlockEffect, axis_words: AxisWords) -> tuple[RefusalError, tuple[int, int]] | None:
    """An X, Y or Z in a profile that names this axis otherwise."""
    for word in effect.unread:
        if word.address in AXES and effect.move is None:
            named = ", ".join(f"{axis} by {letter} words" for axis, letter in axis_words.letters.items())
            message = f"no axis of this profile has the letter {word.address}"
            help_text = f"this profile moves {named}: write these, or correct [axes.{word.address}]"
            return RefusalError("VIB048", message, help_text), (word.start, word.end)
    return None


def _not_a_cut(move: Move | None, without: str) -> RefusalError:
    if move is not None and move.kind == "rapid":
        help_text = f"give N, f, E or Q on a G1, G2 or G3 block, or {without}"
        return RefusalError("VIB044", "vibration on a rapid (G0)", help_text)
    message = "this block is a thread, a cycle or another move that the control controls itself"
    help_text = f"only G1, G2 and G3 can vibrate: write the cut as G1, or {without}"
    return RefusalError("VIB043", message, help_text)


def _words_refusal(
    effect: BlockEffect, axis_words: AxisWords, dialect: Dialect
) -> tuple[RefusalError, tuple[int, int]] | None:
    """Words that the expansion could not carry over."""
    foreign_letters = frozenset("TABCDHVOP") - {a for a, axis in axis_words.axes.items() if axis in AXES}
    for word in effect.block.words:
        at = (word.start, word.end)
        shown = effect.block.text_of(word)
        if word.expression is not None:
            message = f"{shown} is computed on the machine; the cut cannot be planned"
            return RefusalError("VIB047", message, "write the number itself"), at
        late_m = word.address == "M" and not _acts_before_its_move(word, dialect)
        foreign = word in effect.unread or word.address in foreign_letters or word.letter.startswith(",")
        if late_m or foreign or (word.address == "G" and effect.non_modal):
            message = f"{shown} cannot stand in a block that vibrates"
            return RefusalError("VIB048", message, _way_out_of(word)), at
    return None


def _acts_before_its_move(word: Word, dialect: Dialect) -> bool:
    code = None if word.number is None else dialect.m_codes.get(int(word.number))
    return code is not None and code.before_move and word.number == int(word.number or 0)


def _way_out_of(word: Word) -> str:
    if word.letter.startswith(","):
        return "write the chamfer or the rounding as a block of its own (G1, G2 or G3)"
    if word.address == "P":
        return "write each turn of the arc as a block of its own"
    if word.address == "K":
        return f"take it out; the {KEYS['K']} is given in a comment before the cut, (VIB N1.5 K2)"
    place = "behind" if word.address == "M" else "before"
    stroke = f"; a {KEYS['A']} is given in a comment, (VIB N1.5 A0.1)" if word.address == "A" else ""
    return f"put it into a block of its own {place} this one{stroke}"


def _feed_refusal(interpreted: InterpretedProgram, state: State) -> tuple[RefusalError, None] | None:
    if state.modes.feed_mode == "inverse":
        message = "inverse-time feed (G93) gives each block its own time; it cannot be vibrated"
        return RefusalError("VIB049", message, "program the cut in G95 or G94"), None
    if state.feed is None:
        message = "the feed is missing: no F since the feed mode was set"
        return RefusalError("VIB050", message, "give F on this block or before it"), None
    return None if state.feed.value > 0.0 else (_feed_that_cannot_be(interpreted, state, state.feed), None)


def _feed_that_cannot_be(interpreted: InterpretedProgram, state: State, feed: Setting) -> RefusalError:
    """Why a feed is not above zero, or not known."""
    program = interpreted.program
    line = program.source.place(feed.line).line
    word = program.block(feed.line).word("F")
    why = ""
    if program.block(feed.line).is_optional:
        skips = "block delete may skip" if program.block(feed.line).skip else "acts only under its condition"
        why = f"is that of line {line}, which {skips}"
    elif word is None:
        why = f"of the shape of the finishing cycle in line {line} may hold behind it or not"
    elif state.kept is not None and word.number is not None and math.isnan(feed.value):
        why = f"(line {line}) is rounded to a tenth by M72, at least in LinuxCNC since 2.9"
    if why:
        message = f"the feed is not known: F{feed.text} {why}"
        return RefusalError("VIB050", message, "give F on this block or before it")
    why = "is zero or negative" if feed.value <= 0.0 else "has no decimal point or is a variable"
    message = f"the feed F{feed.text} (line {line}) {why}"
    return RefusalError("VIB050", message, "give F with a decimal point, above zero")


def _path_mode_refusal(interpreted: InterpretedProgram, state: State) -> tuple[RefusalError, None] | None:
    """A variable may have another value where the mode is given back, or what it is worth is not known."""
    planner = interpreted.settings.planner
    modes = ((planner.path_mode, state.path_words), (planner.smoothing_off, state.smooth_words))
    for leaves, words in modes:
        if leaves and ("#" in words or "[" in words):
            message = f"{words} takes its number from a variable, so it cannot be given back behind the cut"
            return RefusalError("VIB050", message, "write the number itself"), None
    return None


def _ways_out(interpreted: InterpretedProgram) -> frozenset[int]:
    """The lines of the moves by which G41 and G42 end."""
    return frozenset(run.last - 1 for run in compensated_runs(interpreted))


def _refusal_by_what_came(
    request: Request, called: Called, ways_out: frozenset[int]
) -> tuple[RefusalError, None] | None:
    """Why a cut must not vibrate that could by what is in force."""
    return _way_out_refusal(request, ways_out) or _call_refusal(request, called)


def _way_out_refusal(request: Request, ways_out: frozenset[int]) -> tuple[RefusalError, None] | None:
    """The move by which G41 or G42 ends begins where the control has the tool, not as programmed."""
    if request.effect.block.line not in ways_out:
        return None
    message = "tool nose or cutter compensation (G41, G42) ends in this cut: where it begins is not known"
    help_text = f"lead out before the cut (G40 and a move), or {_without(request)}"
    return RefusalError(COMPENSATED, message, help_text), None


def _call_refusal(request: Request, called: Called) -> tuple[RefusalError, None] | None:
    """Behind a subprogram the program says again what that may have set."""
    line = request.effect.block.line
    state = request.effect.after
    assert state.feed is not None  # it was looked for before
    call = called.line_that_says("F", state.feed.line, line)
    if call is not None:
        message = f"the feed is not known: what line {_user_line(called, call)} calls may say another F"
        return RefusalError("VIB050", message, "give F on this block or between there and it"), None
    call = called.line_that_says("S", 0 if state.speed is None else state.speed.line, line)
    if call is not None:
        message = (
            f"the spindle speed is not known: what line {_user_line(called, call)} calls may say another S"
        )
        return RefusalError(UNKNOWN_SPEED, message, "give S between there and this cut"), None
    found = called.line_that_changes(line)
    if found is not None:
        message = f"what line {_user_line(called, found[0])} calls leaves {words_for(found[1])} changed"
        return RefusalError("VIB050", message, "say the code again between there and this cut"), None
    return None


def _user_line(called: Called, line: int) -> int:
    return int(called.interpreted.program.source.place(line).line)


def _position_refusal(
    interpreted: InterpretedProgram, effect: BlockEffect, move: Move
) -> tuple[RefusalError, None] | None:
    wanted = set(move.axes)
    if move.kind in ("cw", "ccw"):
        wanted |= set(move.plane)
    for axis in sorted(wanted):
        at = AXES.index(axis)
        if math.isnan(move.start[at]):
            pointless = moved_without_point(interpreted, effect.block.line, effect.before.unknown_why, axis)
            why = f"{pointless} has no decimal point" if pointless else effect.before.unknown_why
            message = f"where {axis} stands before this cut cannot be known: {why}"
            help_text = f"move {axis} to an absolute position with G0 before the cut"
            if effect.before.unknown_why == JUMPED:
                help_text += ", and let the jump arrive there"
            elif pointless:
                help_text = WRITE_THE_POINT
            return RefusalError("VIB051", message, help_text), None
        if math.isnan(move.end[at]):
            message = f"where {axis} ends cannot be known: its number has no decimal point"
            return RefusalError("VIB052", message, WRITE_THE_POINT), None
    return _corner_refusal(interpreted, effect) or _arc_refusal(interpreted, effect, move)


def _corner_refusal(interpreted: InterpretedProgram, effect: BlockEffect) -> tuple[RefusalError, None] | None:
    """A cut begins where the corner of the move before it ends, and that one is not drawn here."""
    word = _corner_before(interpreted, effect.block.line)
    if word is None:
        return None
    takes = "takes"
    help_text = "draw the corner with G1, G2 and G3"
    if word.address in MAY_BE_AXES:
        takes = "may take"
        help_text += f"; where {word.address} is an axis, cycles.plain_corners=false says so"
    message = (
        f"where this cut starts is not known: {word.letter}{word.value_text} before it {takes} the corner off"
    )
    return RefusalError("VIB051", message, help_text), None


def _corner_before(interpreted: InterpretedProgram, line: int) -> Word | None:
    """The word of the last move before a line that says the corner behind it (``,C1.``), or its angle."""
    program = interpreted.program
    for at in range(line - 1, max(line - _MOST_BETWEEN, program.source.body.start - 1), -1):
        if program.plain[at] >= 0 and not program.bits[at] & _CORNERS:
            return None
        block = program.block(at)
        if not block.has_any(interpreted.settings.axis_words.axes) and not block.has_any(_ANGLES):
            continue
        effect = interpreted.effect(at)
        corners = (word for word in effect.unread if word.address.removeprefix(",") in _CORNER_LETTERS)
        return next(corners, may_be_corner(effect, interpreted.settings))
    return None


def _arc_refusal(
    interpreted: InterpretedProgram, effect: BlockEffect, move: Move
) -> tuple[RefusalError, None] | None:
    """An arc whose centre or radius is a number without a decimal point."""
    if move.kind not in ("cw", "ccw"):
        return None
    for word in effect.block.words_of("RIJK"):
        length = length_mm(word, effect.after, interpreted.settings)
        if length is not None and math.isnan(length):
            message = f"how this arc runs cannot be known: {effect.block.text_of(word)} has no decimal point"
            return RefusalError("VIB052", message, WRITE_THE_POINT), None
    return None


def legs_of(chain: Chain) -> list[Leg]:
    """The chain's moves as pure geometry; axes that it does not move count as 0."""
    return [leg_of(move) for move in chain.moves]


def leg_of(move: Move) -> Leg:
    """A feed move as pure geometry; axes whose place is not known count as 0."""
    turns = {"line": 0, "cw": -1, "ccw": 1}
    start = _numbers(move.start)
    end = _numbers(move.end)
    offsets = move.offsets or NOWHERE
    return Leg(start, end, turns[move.kind], move.plane, offsets, move.radius_mm)


def _numbers(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (0.0 if math.isnan(v) else v for v in values)
    return x, y, z
