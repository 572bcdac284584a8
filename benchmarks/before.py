"""This chipbreak and another one, say that of an older checkout, in turn on the same programs."""

from __future__ import annotations

import filecmp
from dataclasses import replace
from pathlib import Path

import programs
from rows import Goal, Table
from stopwatch import BenchmarkError, Contestant, cpu_ratio, in_turn, ratio, run
from subject import LATHE, MILL, Context, command, filtering

_BLOCKS = 1_000_000
_SMALL = 100
# So much longer it may take: less cannot be told from what the machine does meanwhile.
_LIMIT = 1.05


def before(context: Context) -> Table:
    """Pass-through, expansion, a small program and help; the goal is about the processor's time."""
    if context.before is None:
        raise BenchmarkError("say which other one: --before PATH/TO/OTHER/chipbreak")
    table = Table("before", f"in turn with {context.before}; how long it takes against that")
    for name, ours in _contestants(context):
        # Each ratio of two runs is rough; a short run is cheap to repeat.
        rounds = context.rounds if ours.units > _SMALL else 3 * context.rounds
        theirs = _of_other(ours, context.before, context.path(f"{name}.before"))
        run(ours)
        run(theirs)
        new, old = in_turn([ours, theirs], rounds)
        goal = Goal(cpu_ratio(new, old), _LIMIT, at_least=False, unit="x processor")
        table.add(ours, new, goal, f"x {ratio(new, old):.3g} on the wall{_same(ours, theirs)}")
        table.add(theirs, old)
    return table


def _contestants(context: Context) -> list[tuple[str, Contestant]]:
    mill, modal, small, turn = (context.path(f"{one}.nc") for one in ("mill", "modal", "small", "turn"))
    blocks = context.blocks(_BLOCKS)
    programs.milling(mill, blocks)
    programs.milling(modal, blocks, modal=True)
    programs.milling(small, _SMALL, operations=2)
    programs.turning(turn, blocks)
    found = {
        "pass-through": filtering(mill, MILL, blocks),
        "modal": filtering(modal, MILL, blocks),
        "expansion": filtering(turn, LATHE, blocks),
        "small": filtering(small, MILL, _SMALL),
        "help": Contestant("", (*command(), "--help")),
    }
    return [(name, replace(one, name=name)) for name, one in found.items()]


def _of_other(ours: Contestant, other: str, output: Path) -> Contestant:
    """The same work by the other program, written to a file of its own."""
    words = (other, *ours.command[len(command()) :])
    if "-o" in words:
        words = (*words[:-1], str(output))
    return replace(ours, name="  before", command=words)


def _same(ours: Contestant, theirs: Contestant) -> str:
    """Whether both wrote the same bytes."""
    if "-o" not in ours.command:
        return ""
    one, other = Path(ours.command[-1]), Path(theirs.command[-1])
    return ", the same bytes" if filecmp.cmp(one, other, shallow=False) else ", OTHER BYTES"
