"""W, the limit of an edge check: it depends on what the tool does next.

Block delete (/) and jumps may leave out the next operation, or the call of another tool, so there may be
several that come next; the one that asks most of the edge decides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from chipbreak.insertion.conditional_state import jump_lines
from chipbreak.model.interpreted_program import InterpretedProgram
from chipbreak.operations.kinds import Kind
from chipbreak.operations.operations import Operation
from chipbreak.settings.sections import Settings
from chipbreak.text.named_tuple import NamedTuple


class Limit(NamedTuple):
    """W, and why."""

    w_mm: float
    reason: str
    next_kind: Kind


def limit_before(operation: Operation, settings: Settings, when: str) -> Limit:
    """W of a check before an operation; ``when`` begins its reason."""
    checks = settings.checks
    kind = operation.kind
    own = checks.w_mm.get(str(operation.tool))
    name = "an operation of unknown kind" if kind is Kind.UNKNOWN else kind.value.upper()
    what = f"{when} {name} ({operation.reason})"
    if own is not None:
        return Limit(own, f"{what}: checks.w_mm gives T{operation.tool} W {own:g} mm", kind)
    if kind is Kind.ROUGH:
        return Limit(checks.w_rough_mm, f"{what}: W {checks.w_rough_mm:g} mm", kind)
    if kind in (Kind.FINISH, Kind.SEMI_FINISH):
        return Limit(checks.w_finish_mm, f"{what}: W {checks.w_finish_mm:g} mm", kind)
    stricter_mm = min(checks.w_rough_mm, checks.w_finish_mm)
    return Limit(stricter_mm, f"{what}: neither rough nor finish, so the stricter W {stricter_mm:g} mm", kind)


def _wears(operation: Operation) -> bool:
    """True when the edge of the tool cuts in it, or may."""
    return operation.cuts and operation.kind is not Kind.PROBE


class _LeftIn:
    """Whether a tool may still be in the spindle after others were called: their calls may be left out."""

    def __init__(self) -> None:
        self.may_be = True
        self.why = ""

    def pass_call(self, operation: Operation, may_be_left_out: bool) -> None:
        """The call of another tool."""
        self.may_be = self.may_be and may_be_left_out
        self.why = f", if block delete (/) leaves out the call of T{operation.tool}"


class Uses:
    """What the tools of a program do one after the other."""

    def __init__(self, operations: Sequence[Operation], interpreted: InterpretedProgram) -> None:
        self._operations = operations
        self._program = interpreted.program
        self._jumps = jump_lines(interpreted)
        self.cutting = [operation for operation in operations if _wears(operation)]
        self.of_tool: dict[int | None, list[Operation]] = {}
        for operation in self.cutting:
            self.of_tool.setdefault(operation.tool, []).append(operation)
        # Only the first operation behind a call says its line, and those after it are left out with it too.
        self._calls: dict[int, int] = {}
        call = -1
        for operation in operations:
            call = call if operation.call_line is None else operation.call_line
            self._calls[operation.index] = call

    def limit_after(self, operation: Operation, settings: Settings) -> Limit | None:
        """W of the check after an operation, None where the profile wants none."""
        tool = operation.tool
        limits = [limit_before(one, settings, when) for one, when in self._next(operation)]
        if not limits or self._may_be_last(operation):
            last = self._limit_of_last_use(tool, settings)
            limits += [last] if last else []
        return min(limits, key=lambda limit: limit.w_mm, default=None)

    def _next(self, operation: Operation) -> Iterator[tuple[Operation, str]]:
        """What the tool may do next, and how to say so."""
        assert operation.last_cut is not None
        tool = operation.tool
        last = self.of_tool[tool][-1].index
        left_in = _LeftIn()
        for later in self._operations[operation.index + 1 :]:
            if later.index > last and not left_in.may_be:
                return
            if later.call_line is not None and later.tool != tool:
                left_in.pass_call(later, self._may_be_left_out(later.call_line))
            if not _wears(later):
                continue
            if later.tool == tool:
                yield later, f"T{tool} is used next for"
                if not self._may_be_passed_by(operation.last_cut, later):
                    return
            elif left_in.may_be:
                yield replace(later, tool=tool), f"T{tool} may be used next{left_in.why}, for"
                left_in.may_be = self._may_be_passed_by(operation.last_cut, later)

    def _may_be_last(self, operation: Operation) -> bool:
        """True when nothing after an operation is sure to be cut with its tool."""
        assert operation.last_cut is not None
        for later in reversed(self.of_tool[operation.tool]):
            if later.index <= operation.index:
                break
            if not self._may_be_passed_by(operation.last_cut, later):
                return False
        return True

    def _may_be_left_out(self, line: int | None) -> bool:
        return line is not None and self._program.block(line).is_optional

    def _may_be_passed_by(self, last_cut: int, later: Operation) -> bool:
        """True when block delete or a jump after a cut may leave out an operation, or give it to another."""
        jumps = any(last_cut < line < (later.first_cut or 0) for line in self._jumps)
        call = self._calls[later.index]
        is_called = call > last_cut
        return jumps or self._may_be_left_out(later.first_cut) or (is_called and self._may_be_left_out(call))

    def _limit_of_last_use(self, tool: int | None, settings: Settings) -> Limit | None:
        policy = settings.checks.last_use
        if policy == "none":
            return None
        if policy == "next-part":
            when = f"last use of T{tool}; the next workpiece starts with"
            return limit_before(self.of_tool[tool][0], settings, when)
        assert isinstance(policy, float)
        return Limit(policy, f"last use of T{tool}: checks.last_use gives W {policy:g} mm", Kind.UNKNOWN)
