"""Operations: which tool does what, from which line to which, and what says so.

Operations start at tool calls, at titles in comments and at directives ``(OP ROUGH)``.  A start where
nothing has been cut since the last one belongs to the same operation, so a title may be before its tool
call (Fusion) or after it (by hand).  Only the main program counts: bodies of subprograms and what comes after
the program's end are left out.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, field

from chipbreak.dialects import Dialect
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.model.modal import State
from chipbreak.operations.cycle_kinds import kind_by_cycle
from chipbreak.operations.kinds import (
    Kind,
    KindFinding,
    KindRules,
    OperationMark,
    directive,
    kind_of_text,
    operation_title,
    tool_text,
)
from chipbreak.operations.main_program import MainProgram
from chipbreak.syntax.nodes import Block, Comment
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError, RefusalError
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.text.record import ValueRecord

_EMPTY = 0  # the tool that T0 M6 leaves in the spindle
# Canned cycles that do not drill: tapping, and the boring that leaves a finished bore.
# Where one operation has several cycles, the one that asks most of the edge names it.
_CYCLE_ORDER = (Kind.FINISH, Kind.ROUGH, Kind.THREAD, Kind.DRILL, Kind.PROBE)
_BY_CYCLE = "cycle "  # how such a reason begins


class Operation(ValueRecord):
    """One operation; lines count from 0, ``last_line`` is exclusive.

    ``reason``     why it is of this kind: the words, and their line
    ``tool``       None where no tool with a number is in the spindle
    ``call_line``  where its tool is called or the spindle left empty, None where it goes on with the tool of
                   the one before
    ``first_cut``  first line that cuts (or calls a subprogram, which may cut), None where none does
    ``speed_rpm``  at the first cut, None where it cannot be known;  ``spindle``  its direction there
    """

    index: int
    tool: int | None
    kind: Kind
    reason: str
    label: str
    first_line: int
    last_line: int
    call_line: int | None
    first_cut: int | None
    last_cut: int | None
    speed_rpm: float | None
    spindle: str

    @property
    def by_cycle(self) -> bool:
        """True where no words say the kind but a cycle that stands in the operation."""
        return self.reason.startswith(_BY_CYCLE)

    @property
    def cuts(self) -> bool:
        """True when the tool touches the workpiece in it, or may."""
        return self.first_cut is not None


class _Remark(NamedTuple):
    """A comment and its line."""

    line: int
    text: str


class _Said(NamedTuple):
    """A comment, and the tool, the title or mark and the directive it holds, None where there is none."""

    remark: _Remark
    tool: int | None
    mark: OperationMark | None
    ordered: Kind | None
    may_name: bool

    @property
    def is_title(self) -> bool:
        return self.may_name and self.mark is not None and self.mark.is_start

    @property
    def begins(self) -> bool:
        return self.is_title or self.ordered is not None

    @property
    def ends(self) -> bool:
        return self.mark is not None and not self.mark.is_start


@dataclass(eq=False, repr=False)
class _Draft:
    """An operation while it is read.

    ``named``  False for what comes before the first start
    ``tool``   0 where the spindle was left empty, None where it cannot be known
    """

    first: int
    tool: int | None
    named: bool
    call: int | None = None
    ordered: tuple[Kind, _Remark] | None = None
    titles: list[_Remark] = field(default_factory=list)
    remarks: list[_Remark] = field(default_factory=list)


def operations_of(interpreted: InterpretedProgram, main: MainProgram, rules: KindRules) -> list[Operation]:
    """The operations of a program, in order.

    Raises ProgramRejectedError when a directive is misspelt.
    """
    scan = _Scan(interpreted, main)
    drafts = scan.run()
    judge = _Judge(interpreted, rules, scan.tool_list)
    ends = [draft.first for draft in drafts[1:]] + [main.last]
    operations: list[Operation] = []
    for draft, last in zip(drafts, ends, strict=True):
        cuts = main.cut_ends(draft.first, last)
        if draft.named or cuts:
            operations.append(judge.operation(len(operations), draft, last, cuts))
    return operations


class _Scan:
    """Finds the starts, and collects what is said before the first cut."""

    def __init__(self, interpreted: InterpretedProgram, main: MainProgram) -> None:
        self.interpreted = interpreted
        self.main = main
        self.effect_at = {effect.block.line: effect for effect in interpreted.effects}
        self.drafts = [_Draft(main.first, None, named=False)]
        self.above: list[_Remark] = []  # comments straight above
        self.tool_list: dict[int, _Remark] = {}
        self.last_move = -1
        self.wrong: list[Diagnostic] = []

    def run(self) -> list[_Draft]:
        for block in self.interpreted.program.event_blocks():
            if self.main.has(block.line):
                self._read(block, self.effect_at.get(block.line))
        if self.wrong:
            raise ProgramRejectedError(self.wrong)
        return self.drafts

    def _read(self, block: Block, effect: BlockEffect | None) -> None:
        called = effect is not None and calls_tool(effect, self.interpreted.settings.dialect)
        if self.above and self._has_plain(self.above[-1].line, block.line):
            self.above = []
        call = effect if called else None
        # Beside a block that does something else a comment explains that block.
        may_name = called or effect is None or not (effect.move or effect.non_modal)
        said = self._all_said(block, may_name=may_name)
        self._begin(block.line, call, said)
        self._remember(said, goes_on=block.is_empty and not any(one.ends for one in said))
        if effect and effect.move:
            self.last_move = block.line

    def _begin(self, line: int, call: BlockEffect | None, said: Sequence[_Said]) -> None:
        """Whatever starts in a block, by a call or by a comment, and what its comments say."""
        for one in said:
            if call or one.begins:
                self._start(line, call)
                call = None
            self._note(one)
        if call:
            self._start(line, call)

    def _remember(self, said: Sequence[_Said], *, goes_on: bool) -> None:
        """Comments on lines of their own belong to the start that may come straight after them."""
        self.above = [*self.above, *(one.remark for one in said)] if goes_on else []

    def _all_said(self, block: Block, *, may_name: bool) -> list[_Said]:
        """What the comments of a block say; "O7 (FINISH SIDE 2)" only names the program."""
        comments = block.comments
        if _names_the_program(block):
            comments = tuple(comment for comment in comments if self._directive(block, comment))
        return [self._said(block, comment, may_name=may_name) for comment in comments]

    def _said(self, block: Block, comment: Comment, *, may_name: bool) -> _Said:
        """What a comment says; ``may_name`` is False beside a block that it only explains."""
        note = tool_text(comment.text)
        title = operation_title(comment.text)
        is_header = block.is_empty and block.sequence is not None and note is None
        if title is None and is_header and kind_of_text(comment.text, KindRules()):
            title = OperationMark(True, comment.text.strip())  # "N2 (FIN)"
        ordered = self._directive(block, comment)
        tool = note.number if note else None
        return _Said(_Remark(block.line, comment.text), tool, title, ordered, may_name)

    def _note(self, said: _Said) -> None:
        """Keep what a comment says for the operation it is about."""
        draft = self.drafts[-1]
        if said.tool is not None:
            self.tool_list.setdefault(said.tool, said.remark)
        if said.ordered:
            draft.ordered = (said.ordered, said.remark)
        elif said.is_title:
            draft.titles.append(said.remark)
        elif said.mark is None and not self.main.has_work(draft.first, said.remark.line):
            draft.remarks.append(said.remark)

    def _directive(self, block: Block, comment: Comment) -> Kind | None:
        try:
            return directive(comment.text)
        except RefusalError as error:
            at = (comment.start, comment.end)
            said = (error.code, error.message, error.help)
            diagnose = self.interpreted.program.diagnose
            self.wrong.append(diagnose(block.line, *said, at=at, instead=error.instead))
            return None

    def _start(self, line: int, call: BlockEffect | None) -> None:
        """A tool call or a title: the same operation as long as nothing has worked since its start."""
        draft = self.drafts[-1]
        works = self.main.has_work(draft.first, line)
        if works or not draft.named:
            if not works:
                self.drafts.pop()  # the head of the program is no operation
            first = self.above[0].line if self.above else line
            draft = _Draft(first, draft.tool, named=True, remarks=list(self.above))
            self.drafts.append(draft)
        elif call and draft.call is not None and draft.tool != _EMPTY:
            # The tool before did nothing; only what was said after its call is about this one.
            self._forget(draft, draft.call + 1)
            draft.first = line
        elif not call and draft.titles and self._moves(draft.titles[-1].line, line):
            self._forget(draft, line)
        if call:
            draft.tool = call.after.tool
            draft.call = line

    @staticmethod
    def _forget(draft: _Draft, first: int) -> None:
        """Drop what was said before a line, but not beside the tool call."""
        draft.titles = [r for r in draft.titles if r.line >= first]
        draft.remarks = [r for r in draft.remarks if r.line >= first]
        if draft.ordered and draft.ordered[1].line < first:
            draft.ordered = None

    def _moves(self, first: int, last: int) -> bool:
        return self.last_move > first or self._has_plain(first, last)

    def _has_plain(self, first: int, last: int) -> bool:
        """True with plain motion between two lines; those blocks are not special and never read here."""
        return bool((self.interpreted.program.plain[first:last] >= 0).any())


def _names_the_program(block: Block) -> bool:
    """``O7``: a comment beside it is about the whole program."""
    return block.word("O") is not None and not block.controls


def calls_tool(effect: BlockEffect, dialect: Dialect) -> bool:
    """True where the tool changes: M6, or T on a turret (but not T0 and T0100, which only end offsets).

    ``T0 M6`` leaves the spindle empty: the tool after it is 0, and no tool is that.
    """
    if "macro-call" in effect.non_modal or "T" in effect.taken:  # a number for a macro
        return False
    if not dialect.tool_by_word:
        return effect.does("tool", "change")
    word = next(iter(effect.block.words_of("T")), None)
    if word is None or word.number is None:
        return word is not None
    if not dialect.offset_digits:
        return word.number > 0.0
    offsets = 10.0**dialect.offset_digits
    return 0.0 < word.number < offsets or word.number % offsets != 0.0


class _Judge:
    """Says of which kind an operation is, and why."""

    def __init__(
        self, interpreted: InterpretedProgram, rules: KindRules, tool_list: dict[int, _Remark]
    ) -> None:
        self.interpreted = interpreted
        self.rules = rules
        self.tool_list = tool_list
        self.event_lines = [effect.block.line for effect in interpreted.effects]

    def operation(self, index: int, draft: _Draft, last: int, cuts: tuple[int, int] | None) -> Operation:
        first_cut, last_cut = cuts or (None, None)
        kind, reason = self._kind(draft, last)
        speed_rpm = None
        spindle = "stop"
        if first_cut is not None:
            state = self.interpreted.effect(first_cut).after
            speed_rpm = _speed_rpm(state)
            spindle = state.spindle
        tool = draft.tool or None
        label = f"T{tool}" if tool else "spindle left empty" if draft.tool == _EMPTY else "no tool called"
        if draft.titles:
            title = operation_title(draft.titles[-1].text)
            label = title.label if title else draft.titles[-1].text.strip()
        first = draft.first
        return Operation(
            index,
            tool,
            kind,
            reason,
            label,
            first,
            last,
            draft.call,
            first_cut,
            last_cut,
            speed_rpm,
            spindle,
        )

    def _kind(self, draft: _Draft, last: int) -> tuple[Kind, str]:
        if draft.ordered:
            kind, remark = draft.ordered
            return kind, f'directive "{remark.text.strip()}", {self._line(remark.line)}'
        tools = [r for r in draft.remarks if self._is_about_tool(r, draft)]
        others = [r for r in draft.remarks if r not in tools and tool_text(r.text) is None]
        said = draft.titles[::-1] + others
        if draft.tool in self.tool_list:
            tools.append(self.tool_list[draft.tool])
        for remark in said + tools:
            finding = kind_of_text(remark.text, self.rules, self._unit_mm(last))
            if finding and not self._only_taps(finding, draft, last):
                return finding.kind, f"{finding.reason}, {self._line(remark.line)}"
        cycles = self._cycles(draft, last)
        by_cycle = next(((kind, cycles[kind]) for kind in _CYCLE_ORDER if kind in cycles), None)
        return by_cycle or (Kind.UNKNOWN, self._unknown(draft.titles, tools))

    def _unit_mm(self, last: int) -> float:
        """mm per unit of the program at the end of an operation: tool lists stand before G20 and G21."""
        at = bisect_left(self.event_lines, last) - 1
        return self.interpreted.effects[at].after.mm_per_unit if at >= 0 else 1.0

    def _only_taps(self, finding: KindFinding, draft: _Draft, last: int) -> bool:
        """True where a title calls a tap a drill, as CAM systems number holes: DRILL12, which runs G84."""
        if finding.kind is not Kind.DRILL or finding.by_rule:
            return False
        cycles = self._cycles(draft, last)
        return Kind.THREAD in cycles and Kind.DRILL not in cycles

    @staticmethod
    def _is_about_tool(remark: _Remark, draft: _Draft) -> bool:
        note = tool_text(remark.text)
        beside_call = remark.line == draft.call
        return beside_call or (note is not None and note.number in (None, draft.tool))

    def _cycles(self, draft: _Draft, last: int) -> dict[Kind, str]:
        """The kinds that cycles of an operation mean, each with its reason."""
        found: dict[Kind, str] = {}
        at = bisect_left(self.event_lines, draft.first)
        end = bisect_left(self.event_lines, last)
        for effect in self.interpreted.effects[at:end]:
            kind = kind_by_cycle(effect)
            if kind and kind not in found:
                found[kind] = f"{_BY_CYCLE}{effect.block.text.strip()[:40]}, {self._line(effect.block.line)}"
        return found

    def _unknown(self, titles: Sequence[_Remark], tools: Sequence[_Remark]) -> str:
        looked = [
            f'{what} "{remarks[-1].text.strip()[:40]}" ({self._line(remarks[-1].line)})'
            for what, remarks in (("title", titles), ("tool comment", tools))
            if remarks
        ]
        return f"nothing says what it does: {', '.join(looked or ['no comment'])}, no cycle that would"

    def _line(self, line: int) -> str:
        return f"line {self.interpreted.program.source.place(line).line}"


def _speed_rpm(state: State) -> float | None:
    """The spindle speed where it is a known number and the spindle turns."""
    speed = state.speed
    if speed is None or not state.turns or state.modes.speed_mode == "surface":
        return None
    return speed.value if speed.value > 0.0 else None
