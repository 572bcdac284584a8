"""Which cuts are asked to vibrate, and with which values: block over directive over profile."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from chipbreak.kinematics.sourced_value import SourcedValue
from chipbreak.model.block_effect import CUTTING, BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.settings.axis_words import AXES
from chipbreak.settings.sections import Settings
from chipbreak.text.diagnostics import Diagnostic, RefusalError
from chipbreak.vibration.directive import KEYS, Directive, read_directive

OUT_OF_RANGE = "VIB017"
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
_AXIS = re.compile(r"[XYZUVWABC]\s*[-+.\d]")
_COUNT = re.compile(r"N\s*[-+]?[.\d]")
_FEED = re.compile(r"F\s*[.\d]")
_FREQUENCY = re.compile(r"f\s*[-+]?[.\d]")


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
    ``by_word`` is True when the block's own words ask.  ``speed_line`` is where the active S stands in the
    user's file, 0 without one.
    """

    effect: BlockEffect
    values: dict[str, SourcedValue]
    waveform: str
    by_word: bool
    speed_line: int

    def same_wish(self, other: Request) -> bool:
        """True when both ask for the same vibration, so that they can be one chain."""
        mine = {k: v.value for k, v in self.values.items()}
        return self.waveform == other.waveform and mine == {k: v.value for k, v in other.values.items()}


class RequestReader:
    """Walks through the program once and collects requests and complaints."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.program = interpreted.program
        self.settings = interpreted.settings
        self.default = profile_directive(interpreted.settings)
        self.directive = self.default
        self.requests: list[Request] = []
        self.diagnostics: list[Diagnostic] = []
        self.stray: list[tuple[int, tuple[int, int]]] = []

    def read(self) -> None:
        """Fill ``requests`` and ``diagnostics``."""
        line = self.program.source.body.start
        events = {effect.block.line: effect for effect in self.interpreted.effects}
        for event in self.program.special_lines.tolist():
            self._run(line, event)
            line = event + 1
            block = self.program.block(event)
            self._comments(event)
            effect = events.get(event)
            if effect is not None:
                self._event(effect)
            elif block.opaque:
                self._opaque(event)
        self._run(line, self.program.source.body.stop)
        if self.requests:
            self._complain_of_stray()

    def _run(self, first: int, last: int) -> None:
        if self.directive.on and last > first:
            for effect in self.interpreted.effects_of(first, last):
                self._cut(effect)

    def _event(self, effect: BlockEffect) -> None:
        if effect.block.opaque:
            self._opaque(effect.block.line)
            return
        if self._calls_a_tool(effect):
            self.directive = self.default
        if effect.vibration:
            self._asked_by_words(effect)
        elif self.directive.on:
            self._cut(effect)
        if not effect.vibration:
            for word in effect.block.words:
                has_feed = effect.block.has_letter("F")
                if word.letter == "f" and (has_feed or (effect.move and effect.move.is_cut)):
                    self.stray.append((effect.block.line, (word.start, word.end)))

    def _calls_a_tool(self, effect: BlockEffect) -> bool:
        """True for the T word or the M6 that this control changes tools by, also to the tool it has."""
        by_word = self.settings.dialect.tool_by_word
        return effect.block.has("T") if by_word else effect.does("tool", "change")

    def _cut(self, effect: BlockEffect) -> None:
        # An X, Y or Z that no axis of the profile has: refused later, with what the profile says.
        is_foreign = any(w.address in AXES for w in effect.unread) and effect.after.modes.motion in CUTTING
        is_cut = is_foreign if effect.move is None else effect.move.is_cut
        if is_cut and not effect.in_contour:
            self.requests.append(self._request(effect, {}, by_word=False))

    def _comments(self, line: int) -> None:
        for comment in self.program.block(line).comments:
            try:
                found = read_directive(comment.text, int(self.program.source.place(line).line))
            except RefusalError as error:
                self._error(line, error, (comment.start, comment.end))
                found = _OFF  # one fault, one error: the cuts behind it are not judged by it
            if found is not None:
                fits = self._check_values(line, found.values, (comment.start, comment.end))
                self.directive = found if fits else _OFF

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
        self.requests.append(self._request(effect, values, by_word=True))

    def _request(self, effect: BlockEffect, words: dict[str, SourcedValue], *, by_word: bool) -> Request:
        """Merge block over directive over profile; N and E, Q and A stand for each other."""
        said = self.directive if self.directive.on else Directive(True)
        merged: dict[str, SourcedValue] = {}
        for source in (words, said.values):
            for key, given in source.items():
                if key not in merged and _INSTEAD.get(key) not in merged:
                    merged[key] = given
        merged = _fill_from_profile(merged, self.settings)
        waveform = said.waveform or self.settings.vibration.waveform
        speed = effect.after.speed
        speed_line = self.program.source.place(speed.line).line if speed is not None else 0
        return Request(effect, merged, waveform, by_word, speed_line)

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
        block = self.program.block(line)
        if self.directive.on or _looks_asking(block.text):
            message = f"this line cannot be read ({block.opaque}) and stands where cuts are asked to vibrate"
            help_text = "correct the line, or take N, f and the wish for vibration out of it"
            if self.directive.on:
                help_text = "correct the line, or write (VIB OFF) before it"
            at = (block.opaque_column, block.opaque_column + 1)
            self.diagnostics.append(self.program.diagnose(line, "VIB018", message, help_text, at=at))
            self.directive = _OFF

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


def _fill_from_profile(values: dict[str, SourcedValue], settings: Settings) -> dict[str, SourcedValue]:
    """Add what was not said.  Of S, N and f the profile adds no third."""
    filled = dict(values)
    for key, name in _FROM_PROFILE.items():
        value = getattr(settings.vibration, name)
        if value is None or key in filled or _INSTEAD.get(key) in filled:
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


def requests_of(interpreted: InterpretedProgram) -> tuple[list[Request], list[Diagnostic]]:
    """All requests of a program in order, and what is wrong with them."""
    reader = RequestReader(interpreted)
    reader.read()
    return reader.requests, reader.diagnostics


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
