"""Long programs in which little changes: what it costs to look at every block."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import peers
import programs
from rows import Goal, Table
from stopwatch import Contestant, cpu_note, in_turn, ratio, run
from subject import MILL, Context, add_memory, filtering, insertions, rate_goal, title

_BLOCKS = 1_000_000
# Of a program that is not held in memory: 60 MB, and what the runs between two changes keep.
MOST_MB = 80.0


def pass_through(context: Context) -> Table:
    """Tool checks are put in at the borders.  Every block says G1, so that every peer reads every block."""
    blocks, part = context.blocks(_BLOCKS), context.blocks(_BLOCKS // 10)
    program, bare, few = (context.path(f"{name}.nc") for name in ("mill", "bare", "few"))
    programs.milling(program, blocks)
    programs.milling(bare, part, comments=False)
    programs.milling(few, part // 5, comments=False)
    table = Table("pass-through", title(program, blocks, f"{programs.OPERATIONS} operations, fanuc-mill"))
    wanted = [
        (peers.gcodeparser(program, blocks), 1.3),
        (peers.rs274(program, blocks, context.path("rs274")), 3.0),
        (peers.nc_gcode_interpreter(bare, part), 10.0),
        (peers.plain_lark(few, part // 5), 80.0),
    ]
    _compare(context, table, program, wanted)
    return table


def modal(context: Context) -> Table:
    """The same with G1 said once: gcodeparser then passes over nearly every block."""
    blocks = context.blocks(_BLOCKS)
    program = context.path("modal.nc")
    programs.milling(program, blocks, modal=True)
    table = Table("modal", title(program, blocks, "as pass-through, but G1 is said once"))
    _compare(context, table, program, [(peers.gcodeparser(program, blocks), 1.3)])
    return table


def _compare(
    context: Context,
    table: Table,
    program: Path,
    wanted: Sequence[tuple[Contestant | peers.Missing, float]],
) -> None:
    """A row for the subject, one for its memory, and one a peer: how many times as long it takes a block."""
    subject = filtering(program, MILL, context.blocks(_BLOCKS))
    run(subject)
    found = [(peer, limit) for peer, limit in wanted if isinstance(peer, Contestant)]
    samples, *others = in_turn([subject, *(peer for peer, _ in found)], context.rounds)
    goal = rate_goal(subject, samples, 1e6, "blocks/s")
    table.add(subject, samples, goal, f"{insertions(program)} insertions")
    add_memory(table, program, samples, MOST_MB)
    for (peer, limit), theirs in zip(found, others, strict=True):
        times = ratio(theirs, samples, peer.units / subject.units)
        note = cpu_note(theirs, samples, peer.units / subject.units)
        table.add(peer, theirs, Goal(times, limit, at_least=True, unit="x as long"), note)
    for missing, _ in wanted:
        if isinstance(missing, peers.Missing):
            table.miss(missing)


def scaling(context: Context) -> Table:
    """Ten times the blocks."""
    sizes = [context.blocks(n) for n in (_BLOCKS // 10, _BLOCKS, 10 * _BLOCKS)[: 3 if context.large else 2]]
    table = Table("scaling", "ten times the blocks take at most eleven times as long")
    subjects = []
    for size in sizes:
        program = context.path(f"mill-{size}.nc")
        programs.milling(program, size)
        subjects.append(filtering(program, MILL, size))
    run(subjects[0])
    samples = in_turn(subjects, context.rounds)
    for at, subject in enumerate(subjects):
        goal, note = None, f"{subject.units:,} blocks"
        if at:
            goal = Goal(ratio(samples[at], samples[at - 1]), 11.0, at_least=False, unit="x as long")
            note += f", {cpu_note(samples[at], samples[at - 1])}"
        table.add(subject, samples[at], goal, note)
        add_memory(table, context.path(f"mill-{sizes[at]}.nc"), samples[at], MOST_MB)
    return table
