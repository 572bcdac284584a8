"""Runs macro programs block by block."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from chipbreak.syntax.nodes import Block, Control, Expression, Word
from macro_interpreter.blocks import BlockRunner
from macro_interpreter.expressions import Value, evaluate, variable_number
from macro_interpreter.faults import (
    ARGUMENT,
    ENDLESS,
    NO_LOOP,
    NO_PROGRAM,
    TEXT,
    TOO_DEEP,
    UNSUPPORTED,
    Alarm,
    ProgramEnd,
    fault,
)
from macro_interpreter.machine import Machine
from macro_interpreter.modes import Modes
from macro_interpreter.programs import Library, MacroProgram
from macro_interpreter.variables import ALARM, ARGUMENTS, STOP, Variables

# Beyond this a loop is taken to be endless.
MOST_BLOCKS = 500_000


@dataclass(frozen=True)
class Outcome:
    """How a program ended: its alarm number and text (0 and empty when it had none), and its #3006 stops."""

    alarm: int = 0
    text: str = ""
    stops: tuple[str, ...] = ()


@dataclass
class Interpreter:
    """A control with programs in its memory, in front of a machine.

    ``beam_input`` is the signal variable of the skip input, ``at_stop`` what somebody does at the machine
    while the program waits.  Common variables stay from run to run.
    """

    library: Library
    machine: Machine
    beam_input: int = 1000
    most_blocks: int = MOST_BLOCKS
    modes: Modes = field(default_factory=Modes)
    length_offsets_mm: dict[int, float] = field(default_factory=dict)
    at_stop: Callable[[str], None] | None = None

    def __post_init__(self) -> None:
        self.variables = Variables(self.machine, self.modes, self.beam_input)
        self.blocks = BlockRunner(self.machine, self.modes, self.length_offsets_mm)
        self.stops: list[str] = []
        self.block_count = 0

    def run(self, text: str) -> Outcome:
        """Run program text as the main program; its O number may be left out.

        Raises RefusalError (MAC001 to MAC010) for what the control could not do at all.
        """
        self.stops, self.block_count = [], 0
        self.variables.levels = [{}]
        main = Library([f"O0000\n{text}"]).get(0)
        try:
            self._run(main, 0)
            self.machine.catch_up()
        except Alarm as alarm:
            # What was waiting is never done: the alarm came while it was still being read ahead.
            return Outcome(alarm.number, alarm.text, tuple(self.stops))
        except ProgramEnd:
            self.machine.catch_up()
        return Outcome(stops=tuple(self.stops))

    def _run(self, program: MacroProgram, depth: int) -> None:
        """Run a program to its M99 or its end."""
        deepest = self.machine.control.levels
        if depth > deepest:
            raise fault(TOO_DEEP, f"calls are nested deeper than {deepest}")
        at = 0
        while 0 <= at < len(program.blocks):
            self.block_count += 1
            if self.block_count > self.most_blocks:
                raise fault(ENDLESS, f"O{program.number:04}: more than {self.most_blocks} blocks")
            block = program.blocks[at]
            if block.is_empty or (at == 0 and not block.has_macro and block.words[0].address == "O"):
                at += 1
                continue
            following = self._block(program, at, block, depth)
            if following is None:
                return
            at = following

    def _block(self, program: MacroProgram, at: int, block: Block, depth: int) -> int | None:
        """Run one block; the index of the next, None to return from the program."""
        for control in block.controls:
            goes_on, following = self._control(program, at, block, control)
            if not goes_on:
                return following
        if block.assignments:
            self._assign(block)
        return self._words(block, at, depth) if block.words else at + 1

    def _control(
        self, program: MacroProgram, at: int, block: Block, control: Control
    ) -> tuple[bool, int | None]:
        """Whether the block goes on behind a control word, and which block follows where it does not."""
        match control.keyword:
            case "IF":
                return self._is_true(control), at + 1
            case "THEN" | "DO":
                return True, None
            case "GOTO":
                return False, self._jump(program, block, control)
            case "WHILE":
                if self._is_true(control):
                    return True, None
                if at not in program.partners:
                    raise fault(NO_LOOP, f"O{program.number:04}: WHILE without DO: {block.text}")
                return False, program.partners[at] + 1
            case "END":
                return False, program.partners[at]
            case _:
                raise fault(ARGUMENT, f"O{program.number:04}: not of this control: {block.text}")

    def _words(self, block: Block, at: int, depth: int) -> int | None:
        """Calls, returns, and the codes of a block."""
        is_dwell = any(word.number == 4.0 and word.address == "G" for word in block.words)
        words = [(word, self._word(word, is_dwell=is_dwell)) for word in block.words]
        codes = {(word.address, value) for word, value in words if word.address in "GM"}
        if ("G", 65.0) in codes:
            self._call(block, words, depth)
            return at + 1
        if ("M", 98.0) in codes:
            self._call_subprogram(block, words, depth)
            return at + 1
        if ("M", 99.0) in codes:
            if len(words) > 1:
                raise fault(UNSUPPORTED, f"M99 returns to where the call was, and nowhere else: {block.text}")
            return None
        present = [(word.address, value) for word, value in words if value is not None]
        if present:
            self.blocks.run(block, present)
        return at + 1

    def _call_subprogram(self, block: Block, words: list[tuple[Word, Value]], depth: int) -> None:
        """``M98 P.. L..``: L times."""
        if depth + 1 - (len(self.variables.levels) - 1) > self.machine.control.sub_levels:
            raise fault(
                TOO_DEEP, f"M98 is nested deeper than {self.machine.control.sub_levels}: {block.text}"
            )
        times = [value for word, value in words if word.address == "L" and value is not None]
        for _ in range(round(times[-1]) if times else 1):
            self._run(self.library.get(self._program_number(block, words)), depth + 1)

    def _call(self, block: Block, words: list[tuple[Word, Value]], depth: int) -> None:
        """``G65 P.. A..``: a new level of local variables."""
        deepest = self.machine.control.macro_levels
        if len(self.variables.levels) > deepest:
            raise fault(TOO_DEEP, f"G65 is nested deeper than {deepest}: {block.text}")
        number = self._program_number(block, words)
        behind = [word.address for word, _ in words].index("G") + 1
        given: dict[int, Value] = {}
        for word, value in words[behind:]:
            if word.address == "P":
                continue
            if word.address not in ARGUMENTS:
                raise fault(ARGUMENT, f"{word.address} is no argument of G65: {block.text}")
            given[ARGUMENTS[word.address]] = value
        self.variables.levels.append(given)
        try:
            self._run(self.library.get(number), depth + 1)
        finally:
            self.variables.levels.pop()

    def _program_number(self, block: Block, words: list[tuple[Word, Value]]) -> int:
        numbers = [value for word, value in words if word.address == "P" and value is not None]
        if not numbers:
            raise fault(ARGUMENT, f"a call without P: {block.text}")
        return round(numbers[-1])

    def _jump(self, program: MacroProgram, block: Block, control: Control) -> int | None:
        if control.arguments:
            label = self._value(control.arguments[0])
        else:
            label = float(control.label.upper().lstrip("N"))
        if label is None:
            raise fault(NO_PROGRAM, f"O{program.number:04}: GOTO a vacant variable: {block.text}")
        return program.line_of(round(label))

    def _assign(self, block: Block) -> None:
        for assignment in block.assignments:
            number = variable_number(assignment.target, self.variables.read)
            value = self._value(assignment.value)
            if number in (ALARM, STOP):
                comments = [c.text for c in block.comments if c.start >= assignment.end]
                self._say(number, round(value or 0.0), comments[0] if comments else "", block)
                continue
            self.variables.write(number, value)

    def _say(self, variable: int, number: int, text: str, block: Block) -> None:
        """An alarm ends the program, a stop waits until somebody has looked."""
        control = self.machine.control
        if len(text) > control.text_chars:
            raise fault(TEXT, f"{len(text)} characters, and {control.text_chars} are shown: {block.text}")
        if variable == ALARM:
            if not 0 <= number <= control.last_alarm:
                raise fault(TEXT, f"alarm {number}; there are 0 to {control.last_alarm}: {block.text}")
            raise Alarm(number, text)
        self.machine.catch_up()
        self.stops.append(text)
        if self.at_stop is not None:
            self.at_stop(text)

    def _is_true(self, control: Control) -> bool:
        return bool(self._value(control.arguments[0]))

    def _word(self, word: Word, *, is_dwell: bool) -> Value:
        """The value of a word; one without a decimal point may count increments."""
        if word.expression is not None:
            return self._value(word.expression)
        if word.number is None or word.has_point:
            return word.number
        scale = self.machine.control.scale(word.address, is_inch=self.modes.is_inch, is_dwell=is_dwell)
        return word.number * scale

    def _value(self, expression: Expression) -> Value:
        return evaluate(expression, self.variables.read)
