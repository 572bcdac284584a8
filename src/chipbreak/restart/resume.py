"""A program that starts in the middle of another one: its head, a start block, and the rest as it is.

The result is looked after before it is given: read again, it must be, before the first line of the rest, in
the state and at the place of the program from its start.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence

from chipbreak.editing.beside import Parted, parted
from chipbreak.editing.notes import does_something
from chipbreak.insertion.retract import retract_blocks
from chipbreak.model.flow import Flow
from chipbreak.model.interpret import Interpreter, initial_state
from chipbreak.model.modal import Position, State
from chipbreak.model.state_difference import difference, moved, spindle_speed
from chipbreak.operations.main_program import calls_subprogram
from chipbreak.restart.from_before import Before
from chipbreak.restart.points import Refused, RestartPoints
from chipbreak.restart.restart_case import RestartCase
from chipbreak.restart.standing import Standing, standing
from chipbreak.restart.start_block import start_block
from chipbreak.settings.sections import Settings
from chipbreak.syntax.parse import read_block
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, SelfCheckError, Severity
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.source import Source

NO_PLACE = "RSM001"
IN_A_SUBPROGRAM = "RSM002"
ELSEWHERE = "RSM003"
NOT_SAID = "RSM004"
NO_WAY_HOME = "RSM005"
_MOST_NAMED = 8


class Resumed(NamedTuple):
    """``data`` is the program to run, ``line`` that of the old one with which its rest begins, from 1.

    ``beside`` is the file beside it, where the brackets of the old one are in a file too.
    """

    data: bytes
    line: int
    diagnostics: tuple[Diagnostic, ...]
    beside: bytes | None = None


def resume(
    data: bytes, settings: Settings, line: int, name: str = "<stdin>", *, beside: bytes | None = None
) -> Resumed:
    """The program from ``line`` on (from 1), or from the last safe line before it.

    ``beside`` is the file beside a program whose brackets were left out of it.
    Raises ProgramRejectedError where there is none, and where a filtered part was edited; ValueError for a
    line that the program does not have; SelfCheckError where the result would not do the same.
    """
    program = standing(data, settings, name, beside)
    file_line = program.line_of_number(line)
    _check_is_main(program, file_line)
    points = RestartPoints(program)
    case, refused = points.last_before(file_line)
    head = _head(program)
    if case is None or case.file_line <= head.stop:
        raise ProgramRejectedError([_nowhere(program, file_line, refused)])
    before = Before(program, points.obstacles, case)
    texts = start_block(before)
    _look_after(case, texts)
    said = [*_elsewhere(program, case, refused, file_line), *_not_said(before), *_no_way_home(before)]
    new = Parted(_written(program, case, head, texts, line), None)
    if program.file.user_lines is not None:
        new = parted(new.data, name)
    return Resumed(new.data, program.number(case.file_line), tuple(said), new.beside)


# --- refusals and remarks -------------------------------------------------------------------------------
def _check_is_main(program: Standing, file_line: int) -> None:
    """Refuse a line of a subprogram, or behind the end: it is reached from the line of a call."""
    line = program.line_of(file_line)
    main = program.main
    if line <= main.last and (line < main.first or line == main.last or main.has(line)):
        return
    calls = [one.block.line for one in program.original.effects if calls_subprogram(one)]
    lines = [str(program.number(int(program.places[at]))) for at in calls if main.has(at)][:_MOST_NAMED]
    help_text = (
        f"give the line of its call: {', '.join(lines)}" if lines else "give a line of the main program"
    )
    message = "this line is in a subprogram, or behind the end of the program"
    raise ProgramRejectedError([_diagnostic(program, file_line, IN_A_SUBPROGRAM, message, help_text)])


def _nowhere(program: Standing, file_line: int, refused: Sequence[Refused]) -> Diagnostic:
    message = "the program cannot be started here, nor at a line before but its first"
    if refused:
        message += f": {refused[0].why}"
    help_text = (
        "start it from its first line, or give a line behind a rapid with which the tool has left the work"
    )
    return _diagnostic(program, file_line, NO_PLACE, message, help_text)


def _elsewhere(
    program: Standing, case: RestartCase, refused: Sequence[Refused], file_line: int
) -> Iterator[Diagnostic]:
    """It starts at another line than the one that was asked for."""
    number = program.number(case.file_line)
    if number == program.number(file_line):
        return
    written = program.written_at(file_line)
    if written is not None:
        first, last = program.numbers(written)
        why = f"is in what chipbreak wrote, lines {first} to {last}"
    else:
        why = f"is no place to start: {refused[0].why}"
    message = f"starts at line {number}; line {program.number(file_line)} {why}"
    help_text = "all from there on is done again"
    yield _diagnostic(program, file_line, ELSEWHERE, message, help_text, severity=Severity.NOTE)


def _not_said(before: Before) -> Iterator[Diagnostic]:
    """M codes of the machine before the line: nobody here knows what they have switched."""
    known = before.dialect.m_codes
    found: dict[str, int] = {}
    for effect in before.effects():
        words = () if "macro-call" in effect.non_modal else effect.block.words_of("M")
        found |= {effect.block.text_of(word): effect.block.line for word in words if word.number not in known}
    if found:
        names = ", ".join(
            f"{code} (line {before.user_line(line)})" for code, line in list(found.items())[:_MOST_NAMED]
        )
        message = f"not in the start block, for the profile does not know them: {names}"
        help_text = "switch what the rest needs of it by hand before the start"
        yield _diagnostic(
            before.program, before.case.file_line, NOT_SAID, message, help_text, severity=Severity.WARNING
        )


def _no_way_home(before: Before) -> Iterator[Diagnostic]:
    if not list(retract_blocks(before.interpreted.settings)):
        message = (
            "nothing in the start block takes the axes to a safe place, for this control has no code for it"
        )
        help_text = "take the tool there by hand before the start"
        yield _diagnostic(
            before.program, before.case.file_line, NO_WAY_HOME, message, help_text, severity=Severity.WARNING
        )


def _diagnostic(
    program: Standing,
    file_line: int,
    code: str,
    message: str,
    help_text: str,
    *,
    severity: Severity = Severity.ERROR,
) -> Diagnostic:
    """A finding at a line of the file."""
    file = program.file
    place = file.place(file_line)
    said = (file.meant(message), file.meant(help_text))
    return Diagnostic(code, severity, *said, place, file.shown(file_line), file.encoding)


# --- looking after the result ---------------------------------------------------------------------------
def _look_after(case: RestartCase, texts: Sequence[str]) -> None:
    """Behind the start block all is as it must be.  Raises SelfCheckError."""
    settings = case.interpreted.settings
    interpreter = Interpreter(settings, Flow(frozenset(), ()))
    now = initial_state(settings)
    for text in texts:
        now = interpreter.advance(now, read_block(0, text, settings.dialect)).after
    wanted = _wanted(case, now)
    what = difference(wanted, now)
    if not what and case.needs_speed and spindle_speed(wanted) != spindle_speed(now):
        what = "the spindle speed"
    if not what and case.axes:
        what = moved(_at(wanted, case.axes), _at(now, case.axes))
    if what:
        raise SelfCheckError(f"the start block leaves something else in force: {what}")


def _at(state: State, axes: Collection[str]) -> State:
    """The state with the place of these axes only."""
    places = {axis: getattr(state.position, axis.lower()) for axis in "XYZ" if axis in axes}
    return state._replace(position=Position(*(places.get(axis, 0.0) for axis in "XYZ")))


def _wanted(case: RestartCase, now: State) -> State:
    """What must be in force; a tool call that comes next leaves open what it says itself."""
    state = case.in_force
    spindle = state.spindle if case.restarts else "stop"
    state = state._replace(spindle=spindle, coolant=case.coolant)
    if state.modes.feed_mode == "inverse":  # each block says its own
        state = state._replace(feed=None)
    elif state.feed is not None and math.isnan(state.feed.value):  # then no block counts on it
        state = state._replace(feed=now.feed)
    if case.calls_tool:
        state = state._replace(tool=now.tool)
    if not case.offset_words:
        state = state._replace(modes=state.modes._replace(length_offset="off"))
    return state


# --- the bytes --------------------------------------------------------------------------------------------
def _head(program: Standing) -> range:
    """Lines of the file before the first that does anything: leader, ``%``, the name, remarks."""
    count = program.file.line_count
    return range(next((line for line in range(count) if _is_behind_head(program, line)), count))


def _is_behind_head(program: Standing, line: int) -> bool:
    """True for what chipbreak wrote, and for a block that does something.

    Up to there the lines of the file are those that the control runs.
    """
    is_read = line in program.runs.program.source.body
    return program.written_at(line) is not None or (is_read and does_something(program.runs.program, line))


def _written(program: Standing, case: RestartCase, head: range, texts: list[str], line: int) -> bytes:
    """Head, subprograms that stand before the line, start block, rest."""
    file = program.file
    marks = case.dialect.comment_marks
    note = f"{marks.before}CHIPBREAK RESUME LINE {line}{marks.behind}"
    pieces = [_lines(file, head.start, head.stop)]
    for first, last in program.main.bodies:
        start = int(program.places[first])
        if head.stop <= start < case.file_line:  # one that is never closed stands behind it
            pieces.append(_lines(file, start, int(program.places[last]) + 1))
    notes = (note,) if file.user_lines is None else ()  # its control takes none
    pieces += [text.encode("latin-1") + file.line_end for text in (*notes, *texts)]
    pieces.append(file.data[file.starts[case.file_line] :])
    return b"".join(pieces)


def _lines(file: Source, first: int, stop: int) -> bytes:
    return file.data[file.starts[first] : file.starts[stop]]
