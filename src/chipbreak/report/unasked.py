"""Which cuts nothing asks to vibrate, operation by operation, and why."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from chipbreak.operations.kinds import Kind
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import Operation
from chipbreak.pipeline import Result, interpreted_of
from chipbreak.report.model import ExplainedUnasked
from chipbreak.settings import Settings
from chipbreak.vibration.request import profile_directive
from chipbreak.vibration.scope import Scope

_NOTHING_ASKS = "neither the block, nor a comment, nor the profile asks"


def unasked_cuts(result: Result, settings: Settings) -> tuple[ExplainedUnasked, ...]:
    """The cuts of each operation that are neither vibrated nor left; none where nothing vibrates."""
    if not (result.cuts or result.left):
        return ()
    return tuple(_found(result, settings))


def _found(result: Result, settings: Settings) -> Iterator[ExplainedUnasked]:
    source = result.source
    cuts = main_program(interpreted_of(result, settings)).cuts
    asked = [range(cut.plan.chain.first, cut.plan.chain.last) for cut in result.cuts]
    asked += [range(cut.first, cut.last) for cut in result.left]
    rest = cuts[~np.isin(cuts, np.array([line for lines in asked for line in lines], np.int64))]
    scope = Scope(settings.vibration.only, result.operations)
    for operation in result.operations:
        lines = rest[(rest >= operation.first_line) & (rest < operation.last_line)]
        if len(lines):
            tool = "no tool" if operation.tool is None else f"T{operation.tool}"
            yield ExplainedUnasked(
                operation=f"{tool}, {operation.kind.value}",
                first_line=source.place(int(lines[0])).line,
                last_line=source.place(int(lines[-1])).line,
                blocks=len(lines),
                reason=_reason(operation, int(lines[0]), scope, settings),
            )


def _reason(operation: Operation, line: int, scope: Scope, settings: Settings) -> str:
    if operation.kind is Kind.THREAD:
        return "a thread does not vibrate"
    if not profile_directive(settings).on:
        return _NOTHING_ASKS
    if settings.vibration.only and not scope.is_asked(line):
        return f"the profile asks {', '.join(settings.vibration.only)} only"
    if not scope.is_asked(line):
        return "the profile does not ask cuts that finish"
    return "(VIB OFF), or no cut that the profile's wish is for"
