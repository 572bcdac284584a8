"""The blocks that come before the rest of a program: what is in force there, said again on a control at rest.

Order: the overrides; units, plane and all that must be off; the axes to the safe end of their travel;
variables, tool, offset; the limit of the spindle, its mode, S and its direction; rotary axes; the place
of the tool, on a lathe Z and then X, on a mill X and Y and then Z, with coolant before the last; feed
and what is left. Of the modal groups only those are said that the program itself uses somewhere: all
others are what the operator has.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from chipbreak.dialects.base import CYCLE_END
from chipbreak.dialects.modes import UNSAID
from chipbreak.insertion.looking_back import effects_before
from chipbreak.insertion.place_words import place_word
from chipbreak.insertion.retract import retract_blocks
from chipbreak.model.flow import Flow
from chipbreak.model.giving_back import feed_blocks, path_mode_blocks, speed_text
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.model.modal import State
from chipbreak.restart.from_before import Before, rotary_places
from chipbreak.restart.restart_case import RestartCase
from chipbreak.syntax.parse import Program, read_block
from chipbreak.vibration.request import directive_before

# Said before anything moves; of these groups "off" is what lets the axes go home.
_FIRST = ("units", "plane", "compensation", "rotation", "polar", "interpolation", "scaling", "mirror")
_FIRST_TOO = ("cylinder", "polygon", "modal_macro", "diameter", "arc_distance")
# Said with their words where the place, the spindle or the feed is said.
_LATER = frozenset({"motion", "length_offset", "speed_mode", "feed_mode", "distance", "look_ahead", "path"})


def start_block(before: Before) -> list[str]:
    """The blocks, without their line ends."""
    writer = _Writer(before)
    for part in _PARTS:
        part(writer)
    return writer.texts


class _Writer:
    """Writes blocks, and knows by the interpreter what they leave in force."""

    def __init__(self, before: Before) -> None:
        self.before = before
        self.case: RestartCase = before.case
        self.settings = before.interpreted.settings
        self.dialect = before.dialect
        self.state: State = before.case.in_force
        self.interpreter = Interpreter(self.settings, Flow(frozenset(), ()))
        self.now = initial_state(self.settings)
        self.texts: list[str] = []
        self.codes = _codes_of(before)
        self.used = {self.dialect.g_codes[code].group for code in self.codes}

    def write(self, *texts: str) -> None:
        """Add a block of these words, if there are any."""
        text = " ".join(filter(None, texts))
        if text:
            self.texts.append(text)
            self.now = self.interpreter.advance(self.now, read_block(0, text, self.dialect)).after

    def mode(self, group: str) -> str:
        """The code of what is in force in a group that the program uses; "" where there is nothing to say."""
        value = self.state.modes.value(group)
        if group not in self.used or value == UNSAID or not self.dialect.can(group, value.split(" ")[0]):
            return ""
        return self.dialect.code(group, value, self.codes)

    # --- the parts, in their order ------------------------------------------------------------------------
    def overrides(self) -> None:
        """Given back where the filter holds them: a run that ended inside a cut has left them held."""
        planner = self.settings.planner
        held = set(planner.override_off)
        original, runs = (
            {block.text.strip() for block in program.event_blocks()} for program in _programs(self.before)
        )
        if held and held <= runs - original:
            for text in planner.override_on:
                self.write(text)

    def first_modes(self) -> None:
        """What says how all else is read, and what must be off."""
        self.write(*map(self.mode, _FIRST))
        for group in _FIRST_TOO:
            self.write(self.mode(group))
        if CYCLE_END in self.used:
            self.write(self.dialect.code(CYCLE_END, "ends", self.codes))
        if "length_offset" in self.used and self.dialect.can("length_offset", "off"):
            self.write(self.dialect.code("length_offset", "off", self.codes))
        if "distance" in self.used or self.dialect.retract_is_absolute:
            self.write(self.dialect.code("distance", "absolute", self.codes))

    def home(self) -> None:
        """The axes to the safe end of their travel."""
        for text in retract_blocks(self.settings):
            self.write(text)

    def variables(self) -> None:
        """Those that were set to plain values."""
        for text in self.before.variables.texts:
            self.write(text)

    def tool(self) -> None:
        """The tool with its offset, in the program's own words, and the one that waits for its turn."""
        if not self.case.calls_tool:
            for text in self._tool_words():
                self.write(text)
        waiting = self.state.next_tool
        if waiting is not None and not self.dialect.tool_by_word and self.now.next_tool != waiting:
            self.write(f"T{waiting}")

    def _tool_words(self) -> list[str]:
        if not self.dialect.tool_by_word:
            change = self.dialect.m_code("tool", "change")
            called = any(line < self.before.line for line in self.before.obstacles.tool_changes)
            return [f"T{self.state.tool} {change}"] if called and self.state.tool is not None else []
        words: list[str] = []
        for effect in effects_before(self.before.interpreted, self.before.line):
            word = effect.block.word("T") if effect.says("T") and not effect.non_modal else None
            if word is not None:
                words.insert(0, effect.block.text_of(word))
                if word.number:  # T0 alone ends the offset of the tool before it
                    return words
        return words

    def other_modes(self) -> None:
        """The work offset, and the groups that nothing here depends on."""
        said = (*_FIRST, *_FIRST_TOO, *_LATER)
        self.write(*(self.mode(group) for group, _ in self.state.modes.items() if group not in said))
        for text in path_mode_blocks(self.state, self.dialect) or [self.mode("path")]:
            self.write(text)
        self.write(self.state.smooth_words)

    def spindle(self) -> None:
        """The limit, the mode with S, and the direction."""
        limit = self.state.speed_limit
        own = self.dialect.surface_limit
        if limit is not None and not own:
            self.write(self._limit_code(limit.line), f"S{limit.text}")
        mode = self.mode("speed_mode")
        with_limit = f"{own}{limit.text}" if limit is not None and own and mode else ""
        speed = f"S{speed_text(self.state)}" if self.state.speed is not None else ""
        needs = self.case.needs_speed or (self.state.turns and not self.case.calls_tool)
        starts = self.dialect.m_code("spindle", self.state.spindle) if self.case.restarts else ""
        if mode and not speed and self.dialect.surface_needs_speed:
            mode = self.mode("speed_mode") if self.state.modes.speed_mode != "surface" else ""
        said = speed if needs or mode else ""
        self.write(mode, with_limit, *self._for_choice(said, starts))

    def _for_choice(self, speed: str, starts: str) -> tuple[str, ...]:
        """S and the start, for the spindle that the program has chosen."""
        return (speed, starts, self.state.choice if speed or starts else "")

    def _limit_code(self, line: int) -> str:
        """The program's own code for it: G50 or G92."""
        block = self.before.program.runs.program.block(line)
        codes = [word for word in block.words_of("G") if word.number is not None]
        own = [word for word in codes if round((word.number or 0.0) * 10) in self.dialect.speed_limit]
        return block.text_of(own[-1])

    def place(self) -> None:
        """Where the tool stood; the axis that comes to the work is the last, and coolant flows by then."""
        for letter, effect in rotary_places(self.before).items():
            word = effect.block.word(letter)
            if word is not None and not self.case.calls_tool:
                self.write("G0", effect.block.text_of(word))
        last = "X" if self.dialect.is_lathe else "Z"
        offset = self.case.offset_words or ""
        if self.dialect.is_lathe:  # it counts for both axes
            self.write(offset)
            offset = ""
        others = [axis for axis in self.case.place_axes if axis in self.case.axes and axis != last]
        if others:
            self.write("G0", *map(self._word, others))
        for name in sorted(self.case.coolant):
            self.write(self.dialect.m_code("coolant", name))
        self.write("G0" if last in self.case.axes else "", offset, *self._words([last]))

    def _words(self, axes: Sequence[str]) -> Iterable[str]:
        return [self._word(axis) for axis in axes if axis in self.case.axes]

    def _word(self, axis: str) -> str:
        return place_word(axis, self.state, self.settings)

    def feed(self) -> None:
        """The feed mode with F, the motion code, and the way of counting."""
        is_inverse = self.state.modes.feed_mode == "inverse"
        blocks = [] if is_inverse else feed_blocks(self.state, self.dialect)
        first, *more = blocks or [""]
        self.write(self.mode("feed_mode"), first)
        for text in more:
            self.write(text)
        self._motion()
        if self.now.modes.distance != self.state.modes.distance:
            self.write(self.dialect.code("distance", self.state.modes.distance, self.codes))

    def wish(self) -> None:
        """The directive for the cuts that come, for who filters the new program; a tool call would end it."""
        text = "" if self.case.calls_tool else directive_before(self.before.interpreted, self.before.line)
        marks = self.dialect.comment_marks
        self.write(f"{marks.before}{text}{marks.behind}" if text else "")

    def _motion(self) -> None:
        motion = self.state.modes.motion
        if motion == self.now.modes.motion or (motion == "none" and not self.dialect.can("motion", "none")):
            return
        self.write(self.dialect.code("motion", motion))


def _codes_of(before: Before) -> frozenset[int]:
    """All G codes of the program, ten times their number, that its control knows."""
    known = before.dialect.g_codes
    blocks = (block for program in _programs(before) for block in program.event_blocks())
    codes = {round(number * 10) for block in blocks for number in block.numbers("G")}
    return frozenset(code for code in codes if code in known)


def _programs(before: Before) -> tuple[Program, ...]:
    return before.interpreted.program, before.program.runs.program


_PARTS = (
    _Writer.overrides,
    _Writer.first_modes,
    _Writer.home,
    _Writer.variables,
    _Writer.tool,
    _Writer.other_modes,
    _Writer.spindle,
    _Writer.place,
    _Writer.feed,
    _Writer.wish,
)
