"""Which cuts the profile's wish is for: the operations that ``vibration.only`` names."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from chipbreak.operations.kinds import Kind
from chipbreak.operations.operations import Operation

_FINISHING = (Kind.FINISH, Kind.SEMI_FINISH)


class Scope:
    """Looks up the operation of a line, and whether it is asked; without names, all but finishing is."""

    def __init__(self, only: Sequence[str], operations: Sequence[Operation]) -> None:
        self.only = frozenset(only)
        self.operations = operations
        self.firsts = [operation.first_line for operation in operations]

    def operation_of(self, line: int) -> Operation | None:
        """The operation in which a line (from 0) stands."""
        at = bisect_right(self.firsts, line) - 1
        found = self.operations[at] if at >= 0 else None
        return found if found is not None and line < found.last_line else None

    def is_asked(self, line: int) -> bool:
        """True where the profile asks this cut to vibrate."""
        operation = self.operation_of(line)
        if not self.only:
            return not self.is_finishing(line)
        if operation is None:
            return Kind.UNKNOWN.value in self.only
        return operation.kind.value in self.only or f"T{operation.tool}" in self.only

    def is_finishing(self, line: int) -> bool:
        """True in an operation that finishes."""
        operation = self.operation_of(line)
        # One tool that roughs and finishes by cycles: what stands between the cycles may be either.
        if operation is None or operation.by_cycle:
            return False
        return operation.kind in _FINISHING
