"""A pass: an optional stop before every finishing operation, so that the operator can measure."""

from __future__ import annotations

from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Promise, Written
from chipbreak.operations.kinds import Kind
from chipbreak.passes.base import Context, Pass, Planned
from chipbreak.text.diagnostics import RefusalError, SelfCheckError

STOPS = (0.0, 1.0)  # M0 and M1


class Stops(Promise, kw_only=True):
    """The control stops there, and all else is as it was."""

    def check(self, written: Written) -> None:
        """Read the block that was written.  Raises SelfCheckError where it does not stop."""
        block = written.result.program.block(written.region.body)
        if not any(number in STOPS for number in block.numbers("M")):
            raise SelfCheckError(f"before line {written.edit.first + 1} the machine does not stop")


class StopBeforeFinishing(Pass):
    """``plugins.stop-before-finishing.block`` is the block that stops: M0 or M1."""

    name = "stop-before-finishing"

    def plan(self, context: Context) -> Planned:
        """One block before each finishing operation.

        Raises RefusalError (SHP001) for a block that does not stop.
        """
        block = str(context.settings.plugins.get(self.name, {}).get("block", "M1"))
        if block not in ("M0", "M1"):
            raise RefusalError("SHP001", f"{block} does not stop the machine", 'write block = "M0" or "M1"')
        finishing = [one for one in context.operations if one.kind is Kind.FINISH]
        return Planned([_stop(one.first_line, block) for one in finishing])


def _stop(line: int, block: str) -> Edit:
    return Edit(line, line, (block,), "STOP BEFORE FINISHING", "the operator measures here", Stops())
