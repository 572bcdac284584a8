"""Which cuts are asked to vibrate, and with which values: block over directive over profile."""

from __future__ import annotations

import re
from collections.abc import Container, Mapping, Sequence

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.model.block_effect import CUTTING, BlockEffect
from chipbreak.model.flow import CONTOUR_CYCLES
from chipbreak.model.interpreted_program import InterpretedProgram, followed_calls
from chipbreak.model.modal import State
from chipbreak.operations.operations import Operation
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.syntax.comments import OPEN_COMMENT, leaves_blocks_open
from chipbreak.text.diagnostics import Diagnostic, RefusalError, Severity
from chipbreak.text.lazy_pattern import LazyPattern
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.vibration.cut_path import CutPath
from chipbreak.vibration.directive import KEYS, Directive, read_directive
from chipbreak.vibration.left_cut import UNASKED_FINISHING, LeftCut
from chipbreak.vibration.near_miss import NEAR_MISS, counts_as_block_numbers, meant_directive
from chipbreak.vibration.scope import Scope
from chipbreak.vibration.wish import AskedBy, Wish, said_of

AUTO = "auto"  # vibration.n: the machine chooses
OUT_OF_RANGE = "VIB017"
CYCLE_STAYS = "VIB087"
UNREADABLE = "VIB018"
_FROM_PROFILE = {
    "N": "n",
    "E": "e",
    "F": "f_hz",
    "Q": "q",
    "A": "a_mm",
    "K": "ramp_exponent",
    "ALPHA": "alpha",
    "RAMP": "ramp_vibrations",
    "EDGES": "edges",
}
_INSTEAD = {"N": "E", "E": "N", "Q": "A", "A": "Q"}
_OFF = Directive(False)
_CODE = LazyPattern(r"[GMSTF]\s*\d", re.IGNORECASE)
_AXIS = LazyPattern(r"[XYZUVWABC]\s*[-+.\d]")
_COUNT = LazyPattern(r"N\s*[-+]?[.\d]")
_FEED = LazyPattern(r"F\s*[.\d]")
_FREQUENCY = LazyPattern(r"f\s*[-+]?[.\d]")


def may_be_left(asked_by: AskedBy, refused: str) -> bool:
    """True where a wish that cannot be met leaves the cut as it was; ``refused`` is the profile's key."""
    if refused == "auto":
        return asked_by == "profile"
    return refused == "leave" and asked_by != "word"


class _Range(NamedTuple):
    """Which values a key may have."""

    above: float = 1e-9
    below: float = 1e12
    may_be_zero: bool = False
    is_whole: bool = False
    told: str = "a number above zero that makes sense"

    def holds(self, value: float) -> bool:
        """True for a value that can be."""
        if self.may_be_zero and value == 0.0:
            return True
        return self.above < value < self.below and not (self.is_whole and value != int(value))


_ANY = _Range()
_RANGES = {
    "ALPHA": _Range(0.0, 1.0, told="between 0 and 1"),
    "RAMP": _Range(may_be_zero=True),
    "EDGES": _Range(is_whole=True, told="a whole number above zero"),
}


class Request(NamedTuple):
    """A block that is asked to vibrate.

    ``values`` holds what was said, by the keys of directives; ``speed`` is an S of the block or directive.
    ``asked_by`` is ``word`` when the block's own words ask, else ``directive`` or ``profile``.
    ``speed_line`` is where the active S stands in the user's file, 0 without one.
    ``chosen_by`` says who lets the machine choose N and f, empty where they are given.
    """

    effect: BlockEffect
    values: dict[str, SourcedValue]
    waveform: str
    asked_by: AskedBy
    speed_line: int
    chosen_by: str = ""

    @property
    def by_word(self) -> bool:
        """True when the block's own words ask: they would reach the control if the cut stayed as it is."""
        return self.asked_by == "word"

    def may_be_left(self, refused: str) -> bool:
        """True where the cut stays as it was when it cannot vibrate; ``refused`` is the profile's key."""
        return may_be_left(self.asked_by, refused)

    def same_wish(self, other: Request) -> bool:
        """True when both ask for the same vibration, so that they can be one chain."""
        mine = {k: v.value for k, v in self.values.items()}
        is_same = self.waveform == other.waveform and bool(self.chosen_by) == bool(other.chosen_by)
        return is_same and mine == {k: v.value for k, v in other.values.items()}


class Requests(NamedTuple):
    """The cuts that are asked to vibrate, in order; those that a wish does not reach; what is to be said.

    ``air_lines`` (from 0) are moves back through what was just cut: they need no spindle speed.
    ``cycles`` are the lines of cycles that a wish passed over, with who asked; of ``pecks`` among them the
    wish says that they go without pecks.
    """

    requests: list[Request]
    left: list[LeftCut]
    air_lines: frozenset[int]
    diagnostics: list[Diagnostic]
    cycles: dict[int, AskedBy]
    pecks: frozenset[int] = frozenset()


class RequestReader:
    """Walks through the program once and collects requests and complaints."""

    def __init__(
        self,
        interpreted: InterpretedProgram,
        operations: Sequence[Operation] = (),
        named_cycles: Container[int] = frozenset(),
    ) -> None:
        self.interpreted = interpreted
        self.program = interpreted.program
        self.settings = interpreted.settings
        self.named_cycles = named_cycles
        self.followed_calls = followed_calls(interpreted)
        self.scope = Scope(self.settings.vibration.only, operations)
        self.default = Wish("profile", profile_directive(interpreted.settings))
        self.wish = self.default
        self.wishes = [self.default]
        self.path = CutPath()
        self.has_moved = False
        self.mark = ""  # of the path of the machine that the lines are of
        self.parked: dict[str, Wish] = {}  # what is in force in the others
        self.requests: list[Request] = []
        self.left: list[LeftCut] = []
        self.air_lines: list[int] = []
        self.diagnostics: list[Diagnostic] = []
        self.stray: list[tuple[int, tuple[int, int]]] = []
        self.wished_cycles: set[int] = set()
        self.open_comment: Diagnostic | None = None  # behind which other blocks may run than are read

    def read(self) -> None:
        """Fill ``requests``, ``left`` and ``diagnostics``."""
        line = self.program.source.body.start
        events = {effect.block.line: effect for effect in self.interpreted.effects}
        for event in self.program.special_lines.tolist():
            self._run(line, event)
            line = event + 1
            block = self.program.block(event)
            effect = events.get(event)
            if effect is not None:
                self._enter(effect.after.path)
            self._comments(event)
            if effect is not None:
                self._event(effect)
            elif block.opaque:
                self._opaque(event)
        self._run(line, self.program.source.body.stop)
        if any(request.asked_by != "profile" for request in self.requests):
            self._complain_of_stray()
        self._complain_of_silence()

    def _run(self, first: int, last: int) -> None:
        if last <= first:
            return
        self.has_moved = self.has_moved or bool((self.program.plain[first:last] >= 0).any())
        if not self.wish.on:
            self.path.forget()
            return
        for effect in self.interpreted.effects_of(first, last):
            self._cut(effect)

    def _enter(self, mark: str) -> None:
        """What a directive asks for holds for the path of the machine that it stands in."""
        if mark != self.mark:
            self.parked[self.mark] = self.wish
            self.wish = self.parked.pop(mark, self.default)
            self.mark = mark
            self.path.forget()

    def _event(self, effect: BlockEffect) -> None:
        if effect.block.opaque:
            self._opaque(effect.block.line)
            return
        self.has_moved = self.has_moved or effect.move is not None
        if self._calls_a_tool(effect):
            self._begin(self.default, effect.block.line)
            self.default.blocked = None
        self._wish_of_cycle(effect)
        if effect.vibration:
            self.path.is_way_back(effect.move)
            self.wish.reached += 1
            self._asked_by_words(effect)
        elif self.wish.on:
            self._cut(effect)
        if not effect.vibration and (effect.block.has_letter("F") or (effect.move and effect.move.is_cut)):
            stray = (word for word in effect.block.words if word.letter == "f")
            self.stray += [(effect.block.line, (word.start, word.end)) for word in stray]

    def _wish_of_cycle(self, effect: BlockEffect) -> None:
        """N of a cycle asks for all its cuts; where the cycle stays, the word would reach the control."""
        word = effect.block.word("N")
        if word is None or not (not effect.non_modal.isdisjoint(CONTOUR_CYCLES) and effect.block.has("Q")):
            return
        line = effect.block.line
        self.wished_cycles.add(line)
        if line not in self.named_cycles:
            message = f"N{word.value_text} asks for vibration in a cycle that is not written out"
            error = RefusalError(CYCLE_STAYS, message, 'set cycles.unroll = "asked", or take N out')
            self._error(line, error, (word.start, word.end))

    def _begin(self, wish: Wish, line: int) -> None:
        """Another wish is in force from a line on."""
        if self.wish.ended_at is None and self.wish is not self.default:
            self.wish.ended_at = line
        self.wish = wish
        if wish is not self.default:
            self.wishes.append(wish)

    def _calls_a_tool(self, effect: BlockEffect) -> bool:
        """True for the T word or the M6 that this control changes tools by, also to the tool it has."""
        by_word = self.settings.dialect.tool_by_word
        return effect.says("T") if by_word else effect.does("tool", "change")

    def _pass_over(self, effect: BlockEffect) -> None:
        """No cut; the profile asks the cuts of a program of this file where they stand, not at its call."""
        line = effect.block.line
        if self.wish.asked_by != "profile" or line not in self.followed_calls:
            self.wish.pass_over(effect, is_named=line in self.named_cycles)

    def _cut(self, effect: BlockEffect) -> None:
        """A block under a wish: a cut is asked, and what the control moves by itself is noted."""
        is_back = self.path.is_way_back(effect.move)
        # An X, Y or Z that no axis of the profile has: refused later, with what the profile says.
        is_foreign = any(w.address in AXES for w in effect.unread) and effect.after.modes.motion in CUTTING
        is_cut = is_foreign if effect.move is None else effect.move.is_cut
        if not is_cut or effect.in_contour:
            self._pass_over(effect)
            return
        wish = self.wish
        line = effect.block.line
        if is_back and self.settings.vibration.air == "leave":
            self.air_lines.append(line)
            self._leave(line, "", "feeds back through what was just cut", 'vibration.air = "vibrate"')
        elif wish.asked_by == "profile" and not self.scope.is_asked(line):
            self._leave_unasked(line)
        elif (blocked := self._blocked()) is not None:
            wish.reached += 1
            self.left.append(LeftCut(line, line + 1, blocked, wish.asked_by))
        else:
            wish.reached += 1
            self.requests.append(self._request(effect, {}, wish.asked_by))

    def _blocked(self) -> Diagnostic | None:
        """Why no cut can be planned here that may be left."""
        may_stay = may_be_left(self.wish.asked_by, self.settings.vibration.refused)
        return self.wish.blocked or (self.open_comment if may_stay else None)

    def _leave_unasked(self, line: int) -> None:
        """A cut of an operation that the profile's wish is not for; finishing is said where nobody chose."""
        self.wish.unasked += 1
        if not self.settings.vibration.only and self.scope.is_finishing(line):
            message = "a finishing cut, which vibrates only when it is asked for by name"
            way_out = 'name it, vibration.only = ["rough", "finish"], or write (VIB) before the cut'
            self._leave(line, UNASKED_FINISHING, message, way_out)

    def _leave(self, line: int, code: str, message: str, help_text: str) -> None:
        said = self.program.diagnose(line, code, message, help_text, severity=Severity.WARNING)
        self.left.append(LeftCut(line, line + 1, said, self.wish.asked_by))

    def _open(self, line: int) -> None:
        """A comment that is not closed, and where it ends counts."""
        if self.open_comment is None and leaves_blocks_open(self.program, line):
            message = "this comment is not closed, and a control may take the blocks behind it as comment"
            said = (OPEN_COMMENT, message, "close it with ) on its line")
            self.open_comment = self.program.diagnose(line, *said, severity=Severity.WARNING)

    def _comments(self, line: int) -> None:
        self._open(line)
        for comment in self.program.block(line).comments:
            at = (comment.start, comment.end)
            try:
                found = read_directive(comment.text, int(self.program.source.place(line).line))
            except RefusalError as error:
                self._error(line, error, at)
                found = _OFF  # one fault, one error: the cuts behind it are not judged by it
            if found is None:
                self._complain_of_near_miss(line, comment.text, at)
                continue
            fits = self._check_values(line, found.values, at)
            self._begin(Wish("directive", found if fits else _OFF, line, at), line)

    def _complain_of_near_miss(self, line: int, text: str, at: tuple[int, int]) -> None:
        meant = meant_directive(text)
        if meant:
            message = "this comment is no wish for vibration, though it looks like one"
            help_text = f"a wish is written {meant}"
            said = (NEAR_MISS, message, help_text)
            warning = Severity.WARNING
            self.diagnostics.append(
                self.program.diagnose(line, *said, at=at, severity=warning, instead=(meant,))
            )

    def _complain_of_silence(self) -> None:
        """Wishes that nothing answered, and counts that are block numbers."""
        is_strict = self.settings.checks.strict
        said = [said_of(wish, self.program, is_strict=is_strict) for wish in self.wishes]
        self.diagnostics += [diagnostic for diagnostic in said if diagnostic is not None]
        self.diagnostics += counts_as_block_numbers(self.interpreted)

    def _asked_by_words(self, effect: BlockEffect) -> None:
        values: dict[str, SourcedValue] = {}
        line_number = self.program.source.place(effect.block.line).line
        for word in effect.vibration:
            key = "F" if word.letter == "f" else word.letter
            at = (word.start, word.end)
            if word.number is None:
                message = f"{word.letter} is a variable; its value is known only on the machine"
                error = RefusalError("VIB015", message, "write the number itself")
                self._error(effect.block.line, error, at)
                return
            if key in values:
                error = RefusalError("VIB016", f"{word.letter} stands twice in this block", "give it once")
                self._error(effect.block.line, error, at)
                return
            values[key] = SourcedValue(word.number, f"{word.letter} word, line {line_number}")
            if not self._check_values(effect.block.line, {key: values[key]}, at):
                return
        speed = effect.block.number("S")
        is_rpm = effect.after.modes.speed_mode == "rpm"  # under G96 an S is metres per minute
        if speed is not None and is_rpm:
            values["S"] = SourcedValue(speed, f"S word, line {line_number}")
        self.requests.append(self._request(effect, values, "word"))

    def _request(self, effect: BlockEffect, words: dict[str, SourcedValue], asked_by: AskedBy) -> Request:
        """Merge block over directive over profile; N and E, Q and A stand for each other."""
        said = self.wish.directive if self.wish.on else Directive(True)
        merged: dict[str, SourcedValue] = {}
        for source in (words, said.values):
            for key, given in source.items():
                if key not in merged and _INSTEAD.get(key) not in merged:
                    merged[key] = given
        chosen_by = "" if merged.keys() & set("NEF") else self._chosen_by(said)
        if not chosen_by:
            merged = _fill_from_profile(merged, self.settings)
        else:
            merged = _fill_from_profile(merged, self.settings, without="NEF")
        waveform = said.waveform or self.settings.vibration.waveform
        speed = effect.after.speed
        speed_line = self.program.source.place(speed.line).line if speed is not None else 0
        return Request(effect, merged, waveform, asked_by, speed_line, chosen_by)

    def _chosen_by(self, said: Directive) -> str:
        """Who lets the machine choose; nobody where the directive or the profile fixes N, E or f."""
        if said.auto:
            return f"AUTO, line {self.program.source.place(self.wish.line).line}"
        if self.settings.vibration.n == AUTO:
            return f"profile vibration.n, {self.settings.origin('vibration.n')}"
        return ""

    def _check_values(self, line: int, values: Mapping[str, SourcedValue], at: tuple[int, int]) -> bool:
        for key, given in values.items():
            allowed = _RANGES.get(key, _ANY)
            if not allowed.holds(given.value):
                letter = "f" if key == "F" else key
                message = f"{letter} {given.value:g} is not possible: {KEYS[key]}"
                self._error(line, RefusalError(OUT_OF_RANGE, message, allowed.told), at)
                return False
        return True

    def _opaque(self, line: int) -> None:
        """An unreadable line where cuts are asked to vibrate."""
        block = self.program.block(line)
        self.path.forget()
        if not self.wish.on and not _looks_asking(block.text):
            return
        if self._cannot_matter(block.text):
            return
        message = f"this line cannot be read ({block.opaque}) and stands where cuts are asked to vibrate"
        help_text = "correct the line, or take N, f and the wish for vibration out of it"
        if self.wish.on:
            help_text = "correct the line, or write (VIB OFF) before it"
        at = (block.opaque_column, block.opaque_column + 1)
        said = self.program.diagnose(line, UNREADABLE, message, help_text, at=at)
        if self.wish.on and may_be_left(self.wish.asked_by, self.settings.vibration.refused):
            self.wish.blocked = self.wish.blocked or said
            return
        self.diagnostics.append(said)
        self._begin(Wish("directive", _OFF, line), line)

    def _cannot_matter(self, text: str) -> bool:
        """True before any motion for a line without a code, where nothing but the profile asks."""
        asks = self.wish.asked_by == "directive" or _looks_asking(text)
        return not (asks or self.has_moved or _CODE.search(text))

    def _complain_of_stray(self) -> None:
        """In a program that vibrates, a lone lower-case f is a feed to the control: say so, do not guess."""
        for line, at in self.stray:
            if not any(c.isupper() for c in self.program.source.text(line)):
                continue
            message = "this f is a feed to the control, but the program asks for vibration elsewhere"
            help_text = "write F for a feed; for a frequency give F and f in one block"
            self.diagnostics.append(self.program.diagnose(line, "VIB019", message, help_text, at=at))

    def _error(self, line: int, error: RefusalError, at: tuple[int, int]) -> None:
        self.diagnostics.append(self.program.diagnose(line, error.code, error.message, error.help, at=at))


def profile_directive(settings: Settings) -> Directive:
    """A profile that fixes N, E or f asks for vibration in every cut; a program then need only give S."""
    vibration = settings.vibration
    return Directive(any(v is not None for v in (vibration.n, vibration.e, vibration.f_hz)))


def _fill_from_profile(
    values: dict[str, SourcedValue], settings: Settings, *, without: str = ""
) -> dict[str, SourcedValue]:
    """Add what was not said, but for some keys.  Of S, N and f the profile adds no third."""
    filled = dict(values)
    for key, name in _FROM_PROFILE.items():
        value = getattr(settings.vibration, name)
        if value in (None, AUTO) or key in filled or key in without or _INSTEAD.get(key) in filled:
            continue
        if key in "NEF" and sum(k in filled for k in "SNEF") >= 2:
            continue
        filled[key] = SourcedValue(
            float(value), f"profile vibration.{name}, {settings.origin(f'vibration.{name}')}"
        )
    if settings.vibration.ramp_s is not None and "RAMP" not in values:
        del filled["RAMP"]
    return filled


def solver_inputs(
    request: Request, state: State
) -> tuple[SourcedValue | None, SourcedValue | None, SourcedValue | None]:
    """S, N and f as given for a cut; E is turned into N.

    The modal S counts only when N and f are not both given.
    """
    values = request.values
    per_rev = values.get("N")
    if per_rev is None and "E" in values:
        per_rev = values["E"]._replace(value=1.0 / values["E"].value)
    frequency = values.get("F")
    speed = values.get("S")
    if speed is None and not (per_rev and frequency) and state.speed is not None:
        speed = SourcedValue(state.speed.value, f"active S, line {request.speed_line}")
    return speed, per_rev, frequency


def requests_of(
    interpreted: InterpretedProgram,
    operations: Sequence[Operation] = (),
    named_cycles: Container[int] = frozenset(),
) -> Requests:
    """All requests of a program in order, and what is wrong with them.

    ``named_cycles`` are lines of cycles of which it is said already why they stay as they are.
    """
    reader = RequestReader(interpreted, operations, named_cycles)
    reader.read()
    cycles = {
        passed.line: wish.asked_by
        for wish in reader.wishes
        for passed in wish.passed
        if wish.on and passed.what == "cycle"
    }
    cycles |= dict.fromkeys(reader.wished_cycles, "word")
    pecks = frozenset(
        passed.line for wish in reader.wishes for passed in wish.passed if wish.directive.peck_off
    )
    air_lines = frozenset(reader.air_lines)
    return Requests(reader.requests, reader.left, air_lines, reader.diagnostics, cycles, pecks)


def directive_before(interpreted: InterpretedProgram, line: int) -> str:
    """The text of the directive in force before a line (from 0); empty where there is none."""
    reader = RequestReader(interpreted)
    reader.read()
    said = [wish for wish in reader.wishes if wish is not reader.default and wish.line < line]
    if not said or (said[-1].ended_at is not None and said[-1].ended_at < line):
        return ""
    comments = interpreted.program.block(said[-1].line).comments
    return next((one.text for one in comments if (one.start, one.end) == said[-1].at), "")


def _looks_asking(text: str) -> bool:
    """An axis word with, behind it, an N, or an F and then an f: a request even where the line is unreadable.

    Each search starts behind the last find, so a line of any length is read once.
    """
    axis = _AXIS.search(text)
    if axis is None:
        return False
    if _COUNT.search(text, axis.end()):
        return True
    feed = _FEED.search(text, axis.end())
    return feed is not None and _FREQUENCY.search(text, feed.end()) is not None
