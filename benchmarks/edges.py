"""What a small program waits for, and a line that never ends."""

from __future__ import annotations

import sys

import programs
from rows import MB, Goal, Table
from stopwatch import Contestant, cpu_note, in_turn, ratio, run
from subject import MILL, Context, add_memory, command, filtering, insertions

_IMPORTS = "import numpy, lark, click"
_SMALL = 100


def start_up(context: Context) -> Table:
    """A hundred blocks, and help; against the imports alone."""
    program = context.path("small.nc")
    programs.milling(program, _SMALL, operations=2)
    table = Table("start-up", f"{_SMALL} blocks, and help; against the imports alone")
    imports = Contestant(f"python: {_IMPORTS}", (sys.executable, "-c", _IMPORTS))
    small = filtering(program, MILL, _SMALL)
    helping = Contestant("chipbreak --help", (*command(), "--help"))
    for contestant in (imports, small, helping):
        run(contestant)
    waited, filtered, helped = in_turn([imports, small, helping], 3 * context.rounds)
    note = f"{_SMALL} blocks, {insertions(program)} insertions, {cpu_note(filtered, waited)}"
    table.add(imports, waited)
    table.add(small, filtered, Goal(ratio(filtered, waited), 1.6, at_least=False, unit="x as long"), note)
    goal = Goal(ratio(helped, waited), 0.6, at_least=False, unit="x as long")
    table.add(helping, helped, goal, cpu_note(helped, waited))
    return table


def long_line(context: Context) -> Table:
    """It cannot be a block; it passes through, in time that grows with its length and no faster."""
    sizes = [context.blocks(n) for n in (10 * MB, 100 * MB)]
    table = Table("long-line", f"one line of {sizes[1] / MB:.0f} MB without an end")
    names = [context.path(f"line-{size}.nc") for size in sizes]
    for name, size in zip(names, sizes, strict=True):
        programs.long_line(name, size)
    subjects = [filtering(name, MILL, 1) for name in names]
    run(subjects[0])
    short, long = in_turn(subjects, context.rounds)
    table.add(subjects[0], short, note=f"{sizes[0] / MB:.0f} MB")
    goal = Goal(ratio(long, short), 11.0, at_least=False, unit="x as long")
    table.add(subjects[1], long, goal, f"{sizes[1] / MB:.0f} MB")
    add_memory(table, names[1], long)
    return table
