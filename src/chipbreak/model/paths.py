"""What is of its own: programs and subprograms in one file, paths that run at once, further spindles.

What one of them commands says nothing of another: each path has its own state, a subprogram does not know
its caller's, and behind a wait another path may have commanded the spindle.  What is not followed is said in
``State.spindle_why`` until the program itself starts the spindle again.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from chipbreak.dialects import Dialect
from chipbreak.dialects.base import PATH, PROGRAM, SPINDLE, WAIT, MCode
from chipbreak.model.codes import BlockCodes
from chipbreak.model.modal import State
from chipbreak.syntax.nodes import Block, Control
from chipbreak.syntax.parse import Program

CALLERS_STATE = "a subprogram, or another program, begins in line {line}: the caller's state is not followed"
# Of an M code that may turn the spindle.
UNNAMED = "and neither spindle.cw_codes nor spindle.ccw_codes names it"
_FIRST_SPINDLE = "$0"
_LEAST_WAITING_CODE = 100
# Two paths or more, each once, in order: P12, P123, P13.
_PATHS = re.compile(r"(?=\d\d)1?2?3?4?5?6?7?8?9?")
_STARTS = frozenset({("spindle", "cw"), ("spindle", "ccw")})
_LAST_AXIS = 9


def begins_program(block: Block, dialect: Dialect) -> bool:
    """True for ``O1000``, ``:1000`` or ``<SHAFT>`` in front of a block."""
    first = block.words[0] if block.words else None
    if not block.controls:
        return first is not None and first.address == "O"
    mark = block.controls[0]
    is_first = first is None or mark.start < first.start
    return is_first and dialect.marks.get(mark.keyword) == PROGRAM


def marks_that(block: Block, dialect: Dialect, *meanings: str) -> list[Control]:
    """The marks of a block that say one of these things on this control."""
    if not block.controls:  # as nearly every block
        return []
    return [mark for mark in block.marks if dialect.marks.get(mark.keyword) in meanings]


def entered(state: State, block: Block, dialect: Dialect, line: int) -> State:
    """The state of the path that a block belongs to; that of the path before it is parked.

    ``line`` is that of the block in the user's file.  A path that was not there before has the modes of what
    stands in front of all paths, and nothing else.
    """
    for mark in marks_that(block, dialect, PATH):
        path = mark.label.replace(" ", "").replace("\t", "").upper()
        if path != state.path:
            state = _switched(state, path, line)
    return state


def _switched(state: State, path: str, line: int) -> State:
    parked = dict(state.parked)
    parked[state.path] = state._replace(parked=())
    known = parked.pop(path, None)
    if known is None:
        why = f"path {path} begins in line {line}, and what others command is not followed"
        modes = parked[""].modes if "" in parked else state.modes
        known = State(modes, unknown_why=why, spindle_why=why, path=path)
    return known._replace(parked=tuple(parked.items()))


def behind_wait(state: State, block: Block, dialect: Dialect, line: int) -> State:
    """The state behind a block in which a path may wait: another one may have commanded the spindle.

    ``line`` is that of the block in the user's file.
    """
    for mark in marks_that(block, dialect, WAIT):
        why = f"line {line} waits for another path ({mark.label}), which is not followed"
        state = state._replace(speed=None, spindle_why=why)
    code = _waiting_code(block, state, dialect)
    if code:
        why = f"line {line} may wait for another path ({code}), which is not followed"
        state = state._replace(speed=None, spindle_why=why)
    return state


def _waiting_code(block: Block, state: State, dialect: Dialect) -> str:
    """The M code by which the paths of a machine wait for each other, with its P; empty where there is none.

    The builder chooses the codes, three digits of which the control knows nothing (M100 to M199 on many).
    They stand alone, with the paths in P (``M101 P12``), or in a program with marks of paths.
    """
    words = [word for word in block.words if word.address != "N"]
    if WAIT not in dialect.marks.values() or not words or words[0].address != "M" or block.has_macro:
        return ""
    number = words[0].number
    if number is None or number < _LEAST_WAITING_CODE or int(number) in dialect.m_codes:
        return ""
    named = "".join(word.value_text for word in words[1:] if word.address == "P")
    is_alone = len(words) == 1 and bool(state.path)
    names_paths = len(words) == 2 and _PATHS.fullmatch(named) is not None
    return " ".join(map(block.text_of, words)) if is_alone or names_paths else ""


def behind_choice(state: State, before: State, choice: str, line: int) -> State:
    """The state behind a block that speaks of the spindle of its choice; ``before`` is the one before it.

    ``line`` is that of the block in the user's file.
    """
    reason = UNNAMED if choice.upper().startswith("M") else "which is not followed"
    why = f"line {line} chooses a spindle ({choice}), {reason}"
    spindle, limit = before.spindle, before.speed_limit
    return state._replace(speed=None, spindle=spindle, speed_limit=limit, spindle_why=why, choice="")


def work_spindles(program: Program) -> tuple[str, ...]:
    """The words by which a program chooses spindles that turn the work, not a tool in the turret.

    Such a spindle is started under constant surface speed, which counts with the diameter that is turned:
    ``G96 S200 M3 P11``.  A P of one digit may say there whose axis that diameter is of.
    """
    dialect = program.dialect
    if not dialect.spindle_word or not dialect.can("speed_mode", "surface"):
        return ()
    surface = float(dialect.code("speed_mode", "surface").lstrip("G"))
    found = set()
    for block in program.event_blocks():
        named = block.word(dialect.spindle_word)
        if named is None or surface not in block.numbers("G") or not block.has("S"):
            continue
        functions = (dialect.m_codes.get(int(number)) for number in block.numbers("M"))
        starts = any(one is not None and one[:2] in _STARTS for one in functions)
        if starts and (named.number or 0.0) > _LAST_AXIS:
            found.add(block.text_of(named))
    return tuple(sorted(found))


def behind_work_spindle(state: State, before: State, choice: str, block: Block, line: int) -> State:
    """The state behind a block that speaks of a spindle that turns the work; ``before`` is the one before it.

    What was commanded of the spindle before it says nothing of this one.  ``line`` is that of the block in
    the user's file.
    """
    after = state._replace(choice=choice)
    if choice == before.choice:
        return after
    if not block.has("S"):
        after = after._replace(speed=None)
    if block.numbers("M"):
        return after
    return after._replace(spindle_why=f"line {line} chooses a spindle ({choice}), and does not start it")


def spindle_choice(block: Block, codes: BlockCodes, dialect: Dialect) -> str:
    """The word or mark by which a block speaks of another spindle; empty where it does not."""
    marks = [mark.label for mark in marks_that(block, dialect, SPINDLE) if mark.label != _FIRST_SPINDLE]
    if marks:
        return marks[0]
    if not block.has_any("MS"):
        return ""
    said = []
    for word in block.words_of("M"):
        function = dialect.m_codes.get(int(word.number or 0))
        if function is not None:
            said.append(function)
            if function.group == "other_spindle":
                return block.text_of(word)
    return "" if codes.modes.motion == "cycle" else _chosen_by_letter(block, codes, dialect, said)


def _chosen_by_letter(block: Block, codes: BlockCodes, dialect: Dialect, said: Sequence[MCode]) -> str:
    """``S2000 P12`` or ``M3 P12``, where no code of the block has another meaning for P."""
    named = block.word(dialect.spindle_word) if dialect.spindle_word else None
    if named is None or named.address in codes.taken or codes.non_modal - {"set-position"}:
        return ""
    calls = any(function.group == "subprogram" for function in said)
    starts = any(function[:2] in _STARTS for function in said)
    return block.text_of(named) if not calls and (starts or block.has("S")) else ""


def behind_unknown_start(state: State, block: Block, dialect: Dialect, line: int) -> State:
    """The state behind a block that gives a spindle that stands an S, and an M code nobody knows.

    Builders have codes of their own that start the spindle (``S600 M13``).  ``line`` is that of the block in
    the user's file.
    """
    if state.turns or state.spindle_why or not block.has("S"):
        return state
    unknown = next(
        (w for w in block.words_of("M") if w.number is not None and w.number not in dialect.m_codes), None
    )
    if unknown is None:
        return state
    code = block.text_of(unknown)
    return state._replace(spindle_why=f"line {line} may start it by {code}, {UNNAMED}")
