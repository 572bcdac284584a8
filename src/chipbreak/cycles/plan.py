"""Which cycles are written out as plain blocks, and the edits that do it.

A contour and all cycles that call it belong together: the contour stands in the way of the program, so it is
taken out, and then nothing may call it any more.  One cycle that cannot be written out leaves them all.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from operator import attrgetter

from chipbreak.cycles import alarms
from chipbreak.cycles.alarms import with_alarm
from chipbreak.cycles.call import BAD_DEPTH, UNREAD_FORM, Call, kind_of, read_call
from chipbreak.cycles.contour import Frame
from chipbreak.cycles.corner_runs import corner_edit, corner_runs
from chipbreak.cycles.corners import BAD_CONTOUR, words_of_corner
from chipbreak.cycles.moved_contour import moved_contour
from chipbreak.cycles.pattern import Pattern, offsets_of, pattern_passes
from chipbreak.cycles.pecks import deep_hole_edit, is_deep_hole, is_peck, peck_edit
from chipbreak.cycles.promise import CopiedContour, PlannedMoves, RemovedContour, UnrolledRoughing
from chipbreak.cycles.reading import (
    TURNS_BACK,
    Contour,
    effects_of_contour,
    goes_down,
    read_contour,
    segments_of,
    steps_of,
)
from chipbreak.cycles.roughing import Motion, Roughing, roughing_passes
from chipbreak.cycles.single_passes import first_lines, single_passes
from chipbreak.cycles.starts import leaves_motion, refuse_contour_before, refuse_start
from chipbreak.cycles.subroutine_cycles import cycles_in, subroutine_edit
from chipbreak.cycles.writing import (
    BlockWriter,
    blocks_of_passes,
    plain_contour,
    wished,
    with_wish,
    without_number,
)
from chipbreak.dialects.base import ContourCycle
from chipbreak.editing.edits import Edit
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.flow import ContourCall, contour_calls, sequence_lines
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import NOWHERE, State
from chipbreak.model.paths import begins_program
from chipbreak.model.words import codes_of
from chipbreak.operations.kinds import Kind
from chipbreak.settings.sections import Settings
from chipbreak.syntax.nodes import Block
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.named_tuple import NamedTuple

BAD_ALLOWANCE = "CYC005"
REPEATED_NUMBER = "CYC008"
UNDER_COMPENSATION = "CYC009"
DEEPER_THAN_ALL = "CYC011"
_SAME_MM = 1e-6
_MOST_LINES_BETWEEN = 2000
_MOST_PASSES = 500
_NARROW_STEPS = 8  # of the output; the digits blur what is shorter
_PASS = re.compile(r"[(;] ?PASS \d")
_MOTION_CODE = re.compile(r"G0*([0-3])(?![\d.])", re.IGNORECASE)
_COMMENT = re.compile(r"\([^)]*\)?|;.*")
_DIRECTIVE = re.compile(r"\s*(VIB|OP)\b", re.IGNORECASE)


class UnrolledEdit(NamedTuple):
    """An edit of the unroll stage; ``kind`` is that of its cuts, None where the cycle says none.

    ``group`` is the line of the first cycle that calls the same contour.  A contour that was moved is no
    cycle.
    """

    edit: Edit
    kind: Kind | None
    group: int = -1
    is_cycle: bool = True

    @property
    def passes(self) -> int:
        """How many passes were written; 1 where they are not counted."""
        titles = (text for text in self.edit.content if isinstance(text, str))
        return max(sum(_PASS.match(text) is not None for text in titles), 1)

    @property
    def depth_mm(self) -> float | None:
        """How deep each of them is, where that is one number."""
        promise = self.edit.promise
        return promise.cycle.depth_mm if isinstance(promise, UnrolledRoughing) else None


class Refused(NamedTuple):
    """A cycle that was asked and stays as it is, and the lines of others that stay with it."""

    line: int
    error: RefusalError
    others: tuple[int, ...] = ()


class UnrollPlan(NamedTuple):
    """What the unroll stage does with a program; ``notes`` are said of cycles that are written out.

    ``undrawn``: why the corners of a run are not drawn, by the lines of its cuts.
    """

    edits: list[UnrolledEdit]
    refused: list[Refused]
    notes: list[Refused]
    undrawn: dict[int, RefusalError]


def cycle_lines(interpreted: InterpretedProgram) -> dict[int, Kind | None]:
    """The lines of cycles that can be written out, with the kind of their cuts where the cycle says it."""
    found: dict[int, Kind | None] = dict.fromkeys(first_lines(interpreted))
    found |= {line: _kind_of_cuts(kind) for line, kind in cycles_in(interpreted).items()}
    if not interpreted.settings.dialect.contour_cycles:
        return found
    calls = contour_calls(interpreted.program, interpreted.settings.dialect)
    kinds = ((one.line, kind_of(interpreted.program.block(one.line), interpreted.settings)) for one in calls)
    return found | {line: _kind_of_cuts(kind) for line, kind in kinds if kind}


def _kind_of_cuts(kind: ContourCycle) -> Kind:
    return Kind.FINISH if kind == "finish" else Kind.ROUGH


def plan_unrolling(
    interpreted: InterpretedProgram, asked: Iterable[int], cuts: Iterable[int] = ()
) -> UnrollPlan:
    """The edits that write out the cycles at ``asked`` lines (from 0), and all that share their contours.

    ``cuts`` are lines of other cuts that are asked: the corners that they say are drawn.
    """
    wanted = set(asked)
    plan = UnrollPlan([], [], [], {})
    _add_single_passes(plan, interpreted, wanted)
    _add_subroutine_cycles(plan, interpreted, wanted)
    _add_pecks(plan, interpreted, wanted)
    _add_contours(plan, interpreted, wanted)
    _add_corners(plan, interpreted, set(cuts))
    return plan


def _add_corners(plan: UnrollPlan, interpreted: InterpretedProgram, cuts: set[int]) -> None:
    """Runs of cuts with corners; one that cannot be drawn stays, and its cuts say why they do not vibrate."""
    for run in corner_runs(interpreted) if cuts else ():
        own = cuts.intersection(range(run.first, run.last))
        if not own:
            continue
        try:
            edit = corner_edit(interpreted, run)
        except RefusalError as error:
            plan.undrawn.update(dict.fromkeys(own, error))
            continue
        plan.edits.append(UnrolledEdit(edit, None, run.first))


def _add_single_passes(plan: UnrollPlan, interpreted: InterpretedProgram, wanted: set[int]) -> None:
    """Cycles without a contour (G90, G94)."""
    for line in sorted(wanted.intersection(first_lines(interpreted))):
        try:
            plan.edits.append(UnrolledEdit(single_passes(interpreted, line), None, line))
        except RefusalError as error:
            plan.refused.append(Refused(line, error))


def _add_subroutine_cycles(plan: UnrollPlan, interpreted: InterpretedProgram, wanted: set[int]) -> None:
    """Cycles whose contour is a subroutine, which stays for the others."""
    for line, kind in cycles_in(interpreted).items():
        if line not in wanted:
            continue
        try:
            plan.edits.append(UnrolledEdit(subroutine_edit(interpreted, line), _kind_of_cuts(kind), line))
        except RefusalError as error:
            plan.refused.append(Refused(line, error))


def _add_pecks(plan: UnrollPlan, interpreted: InterpretedProgram, wanted: set[int]) -> None:
    """Cycles that go without their pecks (G74, G75, G83)."""
    for line in sorted(wanted):
        edit_of = deep_hole_edit if is_deep_hole(interpreted, line) else peck_edit
        if edit_of is peck_edit and not is_peck(interpreted, line):
            continue
        try:
            plan.edits.append(UnrolledEdit(edit_of(interpreted, line), None, line))
        except RefusalError as error:
            plan.refused.append(Refused(line, error))


def _add_contours(plan: UnrollPlan, interpreted: InterpretedProgram, wanted: set[int]) -> None:
    """Cycles that call a contour: all of a group, or none.

    Where the profile does not know where a cycle ends, one behind it needs it to be written out as well: it
    is planned once more where that one has turned out to stay.
    """
    calls = contour_calls(interpreted.program, interpreted.settings.dialect)
    staying: frozenset[int] = frozenset()
    while True:
        planned = UnrollPlan([], [], [], {})
        starts = _start_states(interpreted, calls, staying)
        found = _add_groups(planned, interpreted, _groups(calls), starts, wanted)
        if found <= staying:
            break
        staying |= found  # they only become more, so there is an end
    plan.edits.extend(planned.edits)
    plan.refused.extend(planned.refused)
    plan.notes.extend(planned.notes)


def _add_groups(
    plan: UnrollPlan,
    interpreted: InterpretedProgram,
    groups: Sequence[Sequence[ContourCall]],
    starts: Mapping[int, State],
    wanted: set[int],
) -> frozenset[int]:
    """Add what becomes of the cycles of each contour; the lines of the cycles that stay."""
    behind = _Behind(interpreted)
    staying = (_add_group(plan, group, starts, wanted, behind) for group in groups)
    return frozenset(line for lines in staying for line in lines)


def _add_group(
    plan: UnrollPlan,
    group: Sequence[ContourCall],
    starts: Mapping[int, State],
    wanted: set[int],
    behind: _Behind,
) -> list[int]:
    """Add what becomes of the cycles of one contour; the lines of those that stay."""
    interpreted = behind.interpreted
    lines = [one.line for one in group]
    asked = [line for line in lines if line in wanted]
    if not asked:
        return lines
    try:
        edits, stay = _edits_of_group(interpreted, group, starts, wanted, behind)
    except _GroupError as error:
        refused = error.refused
        if refused.line not in wanted:
            refused = _because_of_another(interpreted, refused, asked[0])
        plan.refused.append(refused._replace(others=tuple(asked)))
        return lines
    plan.edits.extend(edits)
    plan.refused.extend(one for one in stay if one.line in wanted)
    plan.notes.extend(_deeper_than_all(edits))
    plan.notes.extend(_repeated(interpreted, group))
    plan.notes.extend(_under_compensation(interpreted, group, starts))
    return [one.line for one in stay]


def _deeper_than_all(edits: Iterable[UnrolledEdit]) -> Iterator[Refused]:
    """For cycles whose one pass takes all there is: more than a depth of U20 for U2. would be meant to."""
    for one in edits:
        promise = one.edit.promise
        if not isinstance(promise, UnrolledRoughing):
            continue
        cycle = promise.cycle
        deepest_mm = cycle.start.h - min(min(s.start.h, s.end.h) for s in cycle.rough_contour)
        if cycle.depth_mm > deepest_mm + _SAME_MM:
            message = f"the depth of a pass, {cycle.depth_mm:g} mm, is more than the {deepest_mm:.4g} mm that"
            message += " there is to take: one pass takes all of it"
            help_text = "check its unit and its point; a depth of what there is says the same"
            yield Refused(one.edit.last - 1, RefusalError(DEEPER_THAN_ALL, message, help_text))


def _because_of_another(interpreted: InterpretedProgram, refused: Refused, line: int) -> Refused:
    """Why the cycle in a line stays: another one has the same contour, over which nothing else passes."""
    error = refused.error
    other = interpreted.program.source.place(refused.line).line
    message = f"the cycle in line {other} needs the same contour and cannot be written out: {error.message}"
    return Refused(line, RefusalError(error.code, message, error.help))


def _repeated(interpreted: InterpretedProgram, group: Sequence[ContourCall]) -> Iterator[Refused]:
    """For cycles whose P stands on several blocks: which of them the control takes."""
    lines = sequence_lines(interpreted.program)
    for one in group:
        number = interpreted.program.block(one.line).number("P")
        found = lines.get(int(number), []) if number is not None else []
        if len(found) > 1 and one.first is not None:
            way = "the next one" if one.first > one.line else "none stands behind the cycle, so the first one"
            taken = interpreted.program.source.place(one.first).line
            message = f"N{number:g} stands on {len(found)} blocks: {way}, in line {taken}, is taken"
            help_text = "give every contour of the program numbers of its own"
            yield Refused(one.line, RefusalError(REPEATED_NUMBER, message, help_text))


def _under_compensation(
    interpreted: InterpretedProgram, group: Sequence[ContourCall], starts: Mapping[int, State]
) -> Iterator[Refused]:
    """For roughing cycles at which G41 or G42 is in force: controls differ in what that does."""
    for one in group:
        kind = kind_of(interpreted.program.block(one.line), interpreted.settings)
        if kind != "finish" and starts[one.line].modes.compensation != "off":
            message = (
                "nose compensation is in force at this roughing cycle; its passes are written without it"
            )
            help_text = "rough under G40; where the control compensates here,"
            help_text += ' cycles.nose_in_roughing = "compensated" lets the cycle stay'
            yield Refused(one.line, RefusalError(UNDER_COMPENSATION, message, help_text))


def _groups(calls: Sequence[ContourCall]) -> list[list[ContourCall]]:
    """The calls whose contours share lines; the group that ends first in the program is the first."""
    shapes = sorted(
        (one.first, one.last, one) for one in calls if one.first is not None and one.last is not None
    )
    groups = [[one] for one in calls if one.first is None or one.last is None]
    reached = -1
    for first, last, one in shapes:
        if first > reached:
            groups.append([])
        groups[-1].append(one)
        reached = max(reached, last)
    in_order = (sorted(group, key=lambda one: one.line) for group in groups)
    return sorted(in_order, key=lambda group: group[-1].line)


def _start_states(
    interpreted: InterpretedProgram, calls: Sequence[ContourCall], staying: Container[int]
) -> dict[int, State]:
    """The state before each cycle, where the tool is back at the start behind the cycle before it.

    Not behind one that is ``staying``, from which it is not known where the control takes the tool.
    """
    found: dict[int, State] = {}
    last: ContourCall | None = None
    for one in calls:
        first = _first_line(interpreted, one)
        state = interpreted.effect(first).before  # which a program that begins there has begun
        near = last is not None and first - last.line <= _MOST_LINES_BETWEEN
        if (
            last is not None
            and last.line not in staying
            and near
            and math.isnan(state.position.x + state.position.z)
        ):
            state = _behind_cycle(interpreted, last.line, first, found[last.line])
        found[one.line] = state
        last = one
    return found


def _behind_cycle(interpreted: InterpretedProgram, line: int, stop: int, start: State) -> State:
    """The state before line ``stop``, from the cycle in ``line`` on, which ends where it began."""
    state = interpreted.behind(line + 1)._replace(position=start.position)
    for at in range(line + 1, stop):
        state = interpreted.interpreter.advance(state, interpreted.program.block(at)).after
    return state


def _first_line(interpreted: InterpretedProgram, one: ContourCall) -> int:
    try:
        return read_call(interpreted, one).first
    except RefusalError:
        return one.line


class _GroupError(Exception):
    """The cycle because of which none of a contour is written out."""

    def __init__(self, line: int, error: RefusalError) -> None:
        super().__init__(line, error)  # as it is made again from a pickle
        self.refused = Refused(line, error)


def _edits_of_group(
    interpreted: InterpretedProgram,
    group: Sequence[ContourCall],
    starts: Mapping[int, State],
    wanted: Container[int],
    behind: _Behind,
) -> tuple[list[UnrolledEdit], list[Refused]]:
    """The edits of the cycles of a contour, and the finishing cycles that stay with it.

    Errors: _GroupError for the first one that cannot be written out, and cannot stay without the others.
    """
    edits = []
    stay = []
    is_wanted = False
    for one in group:
        try:
            edits.append(_edit_of_call(interpreted, one, starts[one.line], behind))
            is_wanted |= one.line in wanted
        except RefusalError as error:
            if kind_of(interpreted.program.block(one.line), interpreted.settings) != "finish":
                raise _GroupError(one.line, error) from None
            stay.append(Refused(one.line, error))
    # Behind the passes another motion code is in force than before them, and who knows what G70 makes of it.
    if stay and (not is_wanted or leaves_motion(starts[stay[0].line])):
        raise _GroupError(stay[0].line, stay[0].error)
    line = group[0].line
    try:
        edits += _contour_edits(interpreted, group, [starts[one.line] for one in group], stay)
        _refuse_lines(interpreted, [one.edit for one in edits])
    except RefusalError as error:
        raise _GroupError(line, error) from None
    return [one._replace(group=line) for one in edits], stay


def _contour_edits(
    interpreted: InterpretedProgram,
    group: Sequence[ContourCall],
    starts: Sequence[State],
    stay: Sequence[Refused],
) -> list[UnrolledEdit]:
    """The contour is taken out of the way; for those that stay it goes behind the end of the program.

    Nothing but a cycle comes to it there.  Where it stands there already, it stays.
    Errors: CYC007, and _GroupError where it cannot go there.
    """
    first = group[0].first
    if not stay:
        return [_contour_edit(interpreted, group, starts)]
    if first is not None and interpreted.before(first).ended:
        return []
    removed = _contour_edit(interpreted, group, starts)
    if any((one.first, one.last) != (first, group[0].last) for one in group):
        raise _GroupError(stay[0].line, stay[0].error)  # one of them would find only a part of it
    try:
        moved = moved_contour(interpreted, removed.edit, group[-1].line)
    except RefusalError:
        raise _GroupError(stay[0].line, stay[0].error) from None
    removed = removed._replace(edit=removed.edit._replace(keeps_number=False))  # it goes with the contour
    return [removed, UnrolledEdit(moved, None, is_cycle=False)]


def _refuse_lines(interpreted: InterpretedProgram, edits: Sequence[Edit]) -> None:
    """Nothing may jump into what is replaced, and no wish or mark (a path waits) may get lost with it."""
    lines = {at for edit in edits for at in range(edit.first, edit.last)}
    comments = (comment for at in lines for comment in interpreted.program.block(at).comments)
    if not lines.isdisjoint(interpreted.flow.targets) or _is_called(interpreted, lines):
        raise RefusalError(UNREAD_FORM, "a jump leads into this cycle or its contour", "take the jump out")
    blocks = [interpreted.program.block(line) for line in sorted(lines)]
    if any(begins_program(block, interpreted.settings.dialect) for block in blocks[1:]):
        message = "another program begins between this cycle and the end of its contour"
        raise RefusalError(UNREAD_FORM, message, "put the contour into the program of the cycle")
    mark = next((block.text[one.start : one.end].strip() for block in blocks for one in block.marks), "")
    if mark:
        message = f"{mark} stands inside this cycle or its contour, and would not hold for its passes"
        raise RefusalError(UNREAD_FORM, message, "put it on a line of its own before the cycle")
    if any(_DIRECTIVE.match(comment.text) for comment in comments):
        message = "a directive stands inside this cycle or its contour"
        raise RefusalError(UNREAD_FORM, message, "write it before the first block of the cycle")


def _is_called(interpreted: InterpretedProgram, lines: set[int]) -> bool:
    """True where a call by block number, or a cycle whose P or Q is a variable, may lead into the lines.

    A line that begins as its calls leave the control is no such line: its number stays where it was.
    """
    others = lines - interpreted.interpreter.entries.keys()
    sequences = (interpreted.program.block(line).sequence for line in others)
    numbers = {sequence.number for sequence in sequences if sequence is not None}
    for effect in interpreted.effects:
        block = effect.block
        calls = any(function.group == "subprogram" for function in effect.functions)
        if calls and block.number("P") in numbers:
            return True
        words = block.words_of("PQ")
        if any(word.number is None for word in words) and kind_of(block, interpreted.settings):
            return True
    return False


def _contour_edit(
    interpreted: InterpretedProgram, group: Sequence[ContourCall], starts: Sequence[State]
) -> UnrolledEdit:
    """The contour of cycles, each of them from its start, is taken out of the way.

    The control passes over what cycles before it call.  A finishing cycle behind it may call less or more:
    to what more it calls the control comes by itself.
    Errors: CYC007 where the cycles before it call different parts of it.
    """
    _, first, last = group[0]
    before = [one for one in group if one.first is not None and one.line < one.first]
    if first is None or last is None or any((one.first, one.last) != (first, last) for one in before):
        message = "other cycles call another part of the same contour"
        raise RefusalError(UNREAD_FORM, message, "let P and Q of all of them name the same blocks")
    numbers = [interpreted.program.block(line).sequence for line in (first, last)]
    names = " to ".join(f"N{number.value_text}" for number in numbers if number is not None)
    reason = "nothing calls this contour any more"
    promise = RemovedContour(leaves_motion=any(map(leaves_motion, starts)))
    return UnrolledEdit(Edit(first, last + 1, (), f"CONTOUR {names}", reason, promise), None)


def _edit_of_call(
    interpreted: InterpretedProgram, contour: ContourCall, state: State, behind: _Behind
) -> UnrolledEdit:
    call = read_call(interpreted, contour)
    refuse_contour_before(interpreted, call)
    refuse_start(interpreted, call, state)
    _refuse_noses(interpreted, call, state)
    if call.kind == "finish":
        return UnrolledEdit(_finish_edit(interpreted, call, state, behind), Kind.FINISH)
    edit_of = _pattern_edit if call.kind == "pattern" else _rough_edit
    return UnrolledEdit(edit_of(interpreted, call, state), Kind.ROUGH)


def _refuse_noses(interpreted: InterpretedProgram, call: Call, state: State) -> None:
    """Where the control compensates the nose in roughing too, passes without it would leave another shape."""
    if call.kind == "finish" or interpreted.settings.cycles.nose_in_roughing == "ignored":
        return
    effects = effects_of_contour(interpreted, state, call.contour_first, call.contour_last, roughs=True)
    if any(one.modes.compensation != "off" for one in (state, *(effect.after for effect in effects))):
        message = "this control compensates the nose in this cycle (cycles.nose_in_roughing)"
        raise RefusalError(UNREAD_FORM, message, "rough under G40, and take G41 and G42 out of the contour")


def _uncompensated(blocks: Sequence[str], state: State, settings: Settings) -> list[str]:
    """The passes under G40, from the start point itself; behind them the compensation that was in force."""
    dialect = settings.dialect
    if state.modes.compensation == "off":
        return list(blocks)
    there = BlockWriter(state._replace(position=NOWHERE), settings)
    off = dialect.code("compensation", "off")
    start = there.block("G0", state.position.z, state.position.x)
    return [f"{off} {start}", *blocks, dialect.code("compensation", state.modes.compensation)]


def _rough_edit(interpreted: InterpretedProgram, call: Call, state: State) -> Edit:
    along = "Z" if call.kind == "along-z" else "X"
    lines = (call.contour_first, call.contour_last)
    contour = read_contour(interpreted, state, lines, along)
    settings = interpreted.settings
    step_mm = settings.output.step_mm(is_inch=state.is_inch)
    if goes_down(contour, step_mm) and not (contour.first_names_both or call.is_type_two):
        message = (
            "the contour goes down again, which a cycle whose first contour block moves one axis does not cut"
        )
        help_text = "name X and Z in the first block of the contour, where the control has pockets (type II)"
        other = "X" if along == "Z" else "Z"
        raise RefusalError(TURNS_BACK, message, with_alarm(help_text, alarms.TURNS_BACK[other]))
    is_type_two = contour.first_names_both or call.is_type_two
    finishes = settings.cycles.finish_pass in ("always", "type-2" if is_type_two else "type-1")
    cycle = _cycle(call, contour)._replace(narrow_mm=_NARROW_STEPS * step_mm, finishes=finishes)
    passes = roughing_passes(cycle)
    if not passes:
        message = "no level of this cycle lies above its contour, and it has no pass along it"
        raise RefusalError(BAD_DEPTH, message, "give a smaller depth")
    blocks = blocks_of_passes(passes, contour.frame, state, settings, call.feed)
    blocks = _uncompensated(wished(blocks, call.wish), state, settings)
    content = tuple(text for text in (call.speed, *blocks, *_motion_back(state, blocks)) if text)
    reason = f"passes of {call.depth_mm:g} mm along {along} to the contour with its allowances"
    promise = UnrolledRoughing(cycle=cycle, contour=contour, leaves_motion=leaves_motion(state))
    return Edit(call.first, call.last, content, call.name, reason, promise)


def _cycle(call: Call, contour: Contour) -> Roughing:
    t_mm, h_mm = _against_cutting(call.z_allowance_mm, call.x_allowance_mm, contour.frame)
    t_first_mm, h_first_mm = _against_cutting(call.z_first_mm, call.x_first_mm, contour.frame)
    allowances = (("W", t_mm), ("U", h_mm), ("K", t_first_mm), ("I", h_first_mm))
    if call.kind == "along-x":
        allowances = (("U", t_mm), ("W", h_mm), ("I", t_first_mm), ("K", h_first_mm))
    for letter, value_mm in allowances:
        if value_mm < 0.0:
            message = f"the allowance {letter} of this cycle lies inside the finished part"
            raise RefusalError(BAD_ALLOWANCE, message, f"give {letter} the sign that points to the stock")
    if t_first_mm + h_first_mm > call.depth_mm:
        message = "I and K of this cycle leave more than the depth of a pass"
        raise RefusalError(BAD_DEPTH, message, "give less than D for the pass before the last one")
    _refuse_many_passes(call, contour)
    return Roughing(
        contour.start,
        contour.segments,
        call.depth_mm,
        call.retract_mm,
        t_mm,
        h_mm,
        contour.feeds_in,
        t_first_mm,
        h_first_mm,
    )


def _refuse_many_passes(call: Call, contour: Contour) -> None:
    lowest_mm = min(min(one.start.h, one.end.h) for one in contour.segments)
    passes = (contour.start.h - lowest_mm) / call.depth_mm
    if passes > _MOST_PASSES:
        message = f"passes of {call.depth_mm:g} mm would be {passes:z.0f} in this cycle"
        help_text = "check the unit of D (cycles.depth_unit), or give a greater depth"
        raise RefusalError(BAD_DEPTH, message, help_text)


def _against_cutting(z_mm: float, x_mm: float, frame: Frame) -> tuple[float, float]:
    """What stays against the direction of cutting, and towards the stock."""
    moved = frame.inside(z_mm, x_mm)
    return -moved.t, moved.h


def _pattern_edit(interpreted: InterpretedProgram, call: Call, state: State) -> Edit:
    settings = interpreted.settings
    frame = Frame("Z", 1, 1)
    effects = effects_of_contour(interpreted, state, call.contour_first, call.contour_last, roughs=True)
    steps = steps_of(effects, settings)
    first = steps[0].move
    offsets = offsets_of(
        call.times,
        frame.inside(call.z_first_mm, call.x_first_mm),
        frame.inside(call.z_allowance_mm, call.x_allowance_mm),
    )
    start = frame.inside(state.position.z, state.position.x)
    begin = frame.inside(first.end.z, first.end.x)
    segments = segments_of(steps[1:], frame)
    passes = pattern_passes(Pattern(start, begin, segments, offsets, first.kind == "line"))
    blocks = blocks_of_passes(passes, frame, state, settings, call.feed)
    blocks = _uncompensated(wished(blocks, call.wish), state, settings)
    content = tuple(text for text in (call.speed, *blocks, *_motion_back(state, blocks)) if text)
    reason = f"{call.times} passes along the contour, the last one at its allowances"
    # Under compensation a block leads to the start itself; else the tool stands there.
    motions = (Motion(False, start), *(motion for one in passes for motion in one.moves))
    promise = PlannedMoves(frame=frame, motions=motions, leaves_motion=leaves_motion(state))
    return Edit(call.first, call.last, content, call.name, reason, promise)


def _finish_edit(interpreted: InterpretedProgram, call: Call, state: State, behind: _Behind) -> Edit:
    lines = (call.contour_first, call.contour_last)
    effects = effects_of_contour(interpreted, state, *lines)
    stays_on = _leaves_compensation(interpreted, call, state, effects[-1].after)
    _refuse_left_behind(state, effects[-1].after, {"motion", "compensation"} if stays_on else {"motion"})
    behind.refuse_unsaid(call)
    settings = interpreted.settings
    if any(words_of_corner(effect, settings) for effect in effects):
        blocks, ends = plain_contour(effects, state, settings)
        blocks = wished(blocks, call.wish)
    else:
        ends = [effect.move.end for effect in effects if effect.move is not None]
        blocks = [_copied(effect, call.wish, settings) for effect in effects]
    if any(math.isnan(end.x + end.z) for end in ends):
        raise RefusalError(
            BAD_CONTOUR, "a point of the contour cannot be known", "write it with plain numbers"
        )
    BlockWriter(state, settings)  # refuses a start to which no block leads back
    home = BlockWriter(effects[-1].after, settings)
    back = home.block("G0", state.position.z, state.position.x)
    head = " ".join(text for text in (call.speed, call.feed) if text)
    content = (head, *blocks, back, *_motion_back(state, [*blocks, back]))
    reason = "the contour as the finishing cycle runs it"
    promise = CopiedContour(
        ends=tuple(ends), leaves_motion=leaves_motion(state), leaves_compensation=stays_on
    )
    return Edit(call.first, call.last, tuple(filter(None, content)), call.name, reason, promise)


def _leaves_compensation(interpreted: InterpretedProgram, call: Call, before: State, behind: State) -> bool:
    """True where G41 or G42 of the contour holds up to the next move, which says what holds then."""
    if "compensation" not in before.modes.changed(behind.modes):
        return False
    dialect = interpreted.settings.dialect
    for effect in interpreted.effects_of(call.last, interpreted.program.source.body.stop):
        if effect.in_contour:
            continue
        if codes_of(effect.block, "compensation", dialect):
            return not effect.block.is_optional
        if effect.move is not None or effect.non_modal or effect.after.ended:
            return False
    return False


def _refuse_left_behind(before: State, behind: State, may_differ: set[str]) -> None:
    """What the finishing cut leaves in force is not known of the cycle, so it must be what was in force."""
    changed = sorted(set(before.modes.changed(behind.modes)) - may_differ)
    if before.coolant != behind.coolant:
        changed.append("coolant")
    if (before.spindle, before.choice) != (behind.spindle, behind.choice):
        changed.append("spindle")
    if changed:
        message = f"the contour leaves another {', '.join(changed)} in force behind this cycle"
        help_text = "end in the contour what it begins"
        help_text += ": G40 in its last block" if changed == ["compensation"] else ""
        raise RefusalError(UNREAD_FORM, message, help_text)


class _Behind:
    """Which blocks behind finishing cycles say F and S, and which cut: each is looked at once."""

    def __init__(self, interpreted: InterpretedProgram) -> None:
        self.interpreted = interpreted
        self.first = -1
        self.walk: Iterator[BlockEffect] = iter(())
        self.cuts: list[Block] = []  # outside of contours, in order
        self.saying: dict[str, list[int]] = {"F": [], "S": []}  # the lines, in order

    def refuse_unsaid(self, call: Call) -> None:
        """F and S of the contour stay behind its blocks; behind the cycle of the control they may not.

        Errors: CYC007.
        """
        said = self.interpreted.flow.finishes.get(call.last - 1, ())
        cut = self._cut_from(call.last) if said else None
        if cut is None:
            return
        missing = [letter for letter in sorted(said) if not self._is_said(letter, call.last, cut.line)]
        if missing:
            letters = " and ".join(missing)
            shown = cut.text.strip()[:40]
            message = f"{shown} behind this cycle says no {letters}, and which is in force there is not known"
            raise RefusalError(UNREAD_FORM, message, f"give {letters} on that block, or before it")

    def _is_said(self, letter: str, first: int, last: int) -> bool:
        lines = self.saying[letter]
        at = bisect_left(lines, first)
        return at < len(lines) and lines[at] <= last

    def _cut_from(self, line: int) -> Block | None:
        """The first block from a line on that cuts; None where the program ends before."""
        if not 0 <= self.first <= line:
            self.first = line
            self.walk = self.interpreted.effects_of(line, self.interpreted.program.source.body.stop)
            self.cuts.clear()
            for lines in self.saying.values():
                lines.clear()
        while not self.cuts or self.cuts[-1].line < line:
            effect = next(self.walk, None)
            if effect is None or effect.after.ended:
                self.walk = iter(())
                return None
            self._note(effect)
        return self.cuts[bisect_left(self.cuts, line, key=attrgetter("line"))]

    def _note(self, effect: BlockEffect) -> None:
        if effect.in_contour:
            return
        for letter in self.saying.keys() & {word.address for word in effect.block.words}:
            self.saying[letter].append(effect.block.line)
        if effect.move is not None and effect.move.is_cut:
            self.cuts.append(effect.block)


def _copied(effect: BlockEffect, wish: str, settings: Settings) -> str:
    """A block of the contour, without its number; a cut with the wish of the cycle."""
    if not (effect.block.words or effect.block.comments):
        return ""
    text = without_number(effect.block, settings)
    cuts = effect.move is not None and effect.move.is_cut
    return with_wish(text, wish) if cuts else text


def _motion_back(state: State, blocks: Sequence[str]) -> list[str]:
    """The motion code that was in force, where the blocks leave another; none of an arc or a cycle."""
    wanted = {"line": "G1", "rapid": "G0"}.get(state.modes.motion, "")
    codes = [f"G{code}" for text in blocks for code in _MOTION_CODE.findall(_COMMENT.sub("", text))]
    return [wanted] if wanted and codes and codes[-1] != wanted else []
