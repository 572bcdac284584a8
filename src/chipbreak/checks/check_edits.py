"""The insertions of tool checks: what stands before the calls, and what gives the machine back behind them.

The tool goes up before anything else stops; X and Y come back at that height, with the spindle turning, and
Z last.  The calls are macros that put back what they themselves change.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from chipbreak.checks.plan import PlannedCheck, plan_checks
from chipbreak.dialects.modes import UNSAID
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import SpindleRestarted
from chipbreak.insertion.place_words import place_word
from chipbreak.insertion.retract import retract_blocks
from chipbreak.insertion.safe_points import SafePoint
from chipbreak.model.flow import Flow
from chipbreak.model.giving_back import feed_text, is_same, speed_text
from chipbreak.model.interpret import Interpreter
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.main_program import MainProgram
from chipbreak.operations.operations import Operation
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import read_block
from chipbreak.text.diagnostics import Diagnostic
from chipbreak.tools.merge import ToolTable


def edits_of_checks(
    interpreted: InterpretedProgram, operations: Sequence[Operation], main: MainProgram, tools: ToolTable
) -> tuple[list[Edit], list[Diagnostic]]:
    """The insertions of all checks, and what could not be checked.

    Raises RefusalError for calls that cannot be used.
    """
    settings = interpreted.settings
    checks, found = plan_checks(operations, interpreted, main, settings, tools)
    checks.sort(key=_line)
    edits = [_edit(list(group), settings) for _, group in groupby(checks, _line)]
    return edits, [*tools.diagnostics, *found]


def _line(check: PlannedCheck) -> int:
    return check.point.line


def _edit(checks: Sequence[PlannedCheck], settings: Settings) -> Edit:
    """One insertion for all checks of a safe point."""
    point = checks[0].point
    blocks = _Blocks(point, settings)
    blocks.make_ready()
    for check in checks:
        for text in check.blocks:
            blocks.write(text)
    blocks.put_back()
    title = ", ".join(check.title for check in checks)
    reason = "; ".join(check.reason for check in checks)
    promise = SpindleRestarted(
        leaves_spindle=point.state.turns and not point.restarts,
        leaves_coolant=point.coolant != point.state.coolant,
        leaves_feed=not is_same(blocks.before.feed, blocks.now.feed),
    )
    edit = Edit(point.line, point.line, tuple(blocks.texts), title, reason, promise)
    known = [check.duration_s for check in checks if check.duration_s is not None]
    if not known:
        return edit
    settings_s = zip(*(check.otherwise_s for check in checks), strict=True)  # the same ones for each check
    otherwise_s = tuple((rows[0][0], sum(seconds for _, seconds in rows)) for rows in settings_s)
    return edit._replace(duration_s=sum(known), otherwise_s=otherwise_s)


class _Blocks:
    """Writes blocks, and knows by the interpreter what each of them has changed."""

    def __init__(self, point: SafePoint, settings: Settings) -> None:
        self.point = point
        self.settings = settings
        self.dialect = settings.dialect
        self.before = self.now = point.state
        self.interpreter = Interpreter(settings, Flow(frozenset(), ()))
        self.texts: list[str] = []

    def write(self, text: str) -> None:
        """Add a block."""
        self.texts.append(text)
        self.now = self.interpreter.advance(self.now, read_block(0, text, self.dialect)).after

    def make_ready(self) -> None:
        """Coolant off, tool up, spindle off."""
        if self.before.coolant:
            self.write(self.dialect.m_code("coolant", "off"))
        # A move in machine coordinates is absolute, and some controls want that said.
        if self.dialect.retract_is_absolute and self.now.modes.distance == "incremental":
            self.write(self.dialect.code("distance", "absolute"))
        for text in retract_blocks(self.settings):
            self.write(text)
        if self.before.turns:
            self._stop_spindle()

    def _stop_spindle(self) -> None:
        self.write(" ".join([self.dialect.m_code("spindle", "stop"), *self._choice()]))

    def _choice(self) -> list[str]:
        """The word by which the program has chosen its spindle."""
        return [self.before.choice] if self.before.choice else []

    def put_back(self) -> None:
        """Speed and spindle, the position from above, coolant, and the modal groups."""
        self._put_back_spindle()
        # What a place means depends on it, so it is given back before the tool goes to one.
        self._put_back_mode("work_offset")
        self._put_back_position_and_coolant()
        for group in self.now.modes.changed(self.before.modes):
            self._put_back_mode(group)
        feed = feed_text(self.before)
        if feed and not is_same(self.before.feed, self.now.feed):  # a call has set another one
            self.write(f"F{feed}")

    def _put_back_mode(self, group: str) -> None:
        value = self.before.modes.value(group)
        # A block that gives one group back may give another back with it.
        if value != UNSAID and self.now.modes.value(group) != value:
            self.write(self.dialect.code(group, value))

    def _put_back_spindle(self) -> None:
        if not self.point.restarts and self.now.turns:  # a call has started it
            self._stop_spindle()
        is_changed = self.now.speed != self.before.speed
        if not (self.before.speed and (self.point.needs_speed or is_changed)):
            return
        starts = [self.dialect.m_code("spindle", self.before.spindle)] if self.point.restarts else []
        typed = self.before.speed.units
        if typed == self.before.modes.units or not self._reads_before_units():
            self.write(" ".join([f"S{speed_text(self.before)}", *starts, *self._choice()]))
            return
        # The control keeps the number: it is read in the units in which it was set.
        self.write(self.dialect.code("units", typed))
        back = self.dialect.code("units", self.before.modes.units)
        self.write(" ".join([back, f"S{self.before.speed.text}", *starts, *self._choice()]))

    def _reads_before_units(self) -> bool:
        """True where an S of surface speed is read before the units of its block."""
        return self.before.modes.speed_mode == "surface" and self.dialect.feed_before_units

    def _put_back_position_and_coolant(self) -> None:
        """The axis that comes down to the work is the last, and the coolant flows by then."""
        last = "X" if self.dialect.is_lathe else "Z"
        first_axes = [axis for axis in self.point.axes if axis != last]
        if self.point.axes and self.now.modes.distance != "absolute":
            self.write(self.dialect.code("distance", "absolute"))
        if first_axes:
            self.write(" ".join(["G0", *map(self._word, first_axes)]))
        if self.now.coolant - self.point.coolant:  # a call has switched it on
            self.write(self.dialect.m_code("coolant", "off"))
        for name in sorted(self.point.coolant - self.now.coolant):
            self.write(self.dialect.m_code("coolant", name))
        if last in self.point.axes:
            offset = [self.point.length_offset] if self.point.length_offset else []
            self.write(" ".join(["G0", *offset, self._word(last)]))

    def _word(self, axis: str) -> str:
        """Where an axis stood, as a word."""
        return place_word(axis, self.before, self.settings)
