"""Cuts that become a million moves, and the printing of these moves alone."""

from __future__ import annotations

import filecmp
import shutil
import subprocess
import sys
from array import array
from pathlib import Path

import programs
from peers import Missing
from rows import Goal, Table
from stopwatch import BenchmarkError, Contestant, in_turn, ratio, run
from subject import LATHE, LINUXCNC, Context, add_memory, filtering, insertions, output_of, rate_goal, title

_MOVES = 1_000_000
_IDEAL = ("planner.model=ideal",)
_LOOP = Path(__file__).with_name("printf_moves.c")

_PRINT_MOVES = """
import sys, time
import numpy as np
from chipbreak.editing.edits import MoveTable
from chipbreak.editing.render import print_moves
values = np.fromfile(sys.argv[1]).reshape(-1, 2)
table = MoveTable(("Z", "F"), (values[:, 0].copy(), values[:, 1].copy()), (3, 5))
start = time.perf_counter()
with open(sys.argv[2], "wb") as file:
    file.write(print_moves(table, b"\\n"))
print(time.perf_counter() - start)
"""


def expansion(context: Context) -> Table:
    """A turning program through the whole filter; the clock runs for every block that comes out."""
    program = context.path("turn.nc")
    blocks = programs.turning(program, context.blocks(_MOVES))
    subject = filtering(program, LATHE, 1)
    run(subject)
    changes = insertions(program)
    with output_of(program).open("rb") as file:
        moves = sum(line.startswith((b"Z", b"G1 Z")) for line in file)
    subject = filtering(program, LATHE, moves)
    table = Table("expansion", title(program, blocks, f"{moves:,} moves come out, {LATHE}"))
    (samples,) = in_turn([subject], context.rounds)
    table.add(subject, samples, rate_goal(subject, samples, 0.7e6, "moves/s"), f"{changes} insertions")
    add_memory(table, program, samples)
    return table


def planned(context: Context) -> Table:
    """The same where LinuxCNC's planner is followed: one block a stroke, and a sine of many.

    Beside it stands the same program for a control that follows the blocks exactly, in the same rounds.
    """
    table = Table("planned", f"cuts whose feeds are found for LinuxCNC's planner, {LINUXCNC}")
    for name, cuts, wave in (("strokes", 40, "1.5"), ("sine", 2, "0.5 WAVE SINE")):
        program = context.path(f"{name}.ngc")
        programs.planned(program, max(1, context.blocks(cuts)), wave)
        counts = [_moves_of(program, *sets) for sets in ((), _IDEAL)]
        own, ideal = (
            filtering(program, LINUXCNC, moves, *sets)
            for moves, sets in zip(counts, ((), _IDEAL), strict=True)
        )
        samples, other = in_turn([own, ideal], context.rounds)
        goal = Goal(ratio(other, samples, counts[1] / counts[0]), 0.5, at_least=True, unit="of the ideal law")
        table.add(own, samples, goal if name == "strokes" else None, note=f"{name}: {counts[0]:,} moves")
        table.add(ideal, other, note=f"{name}, ideal law: {counts[1]:,} moves")
    return table


def _moves_of(program: Path, *sets: str) -> int:
    """How many moves the output has."""
    run(filtering(program, LINUXCNC, 1, *sets))
    with output_of(program).open("rb") as file:
        return sum(line.startswith((b"Z", b"G1 Z")) for line in file)


def emit(context: Context) -> Table:
    """From an array to a file, without start-up on either side; both write the same bytes."""
    moves = context.blocks(_MOVES)
    values, ours, theirs = (context.path(f"moves.{name}") for name in ("bin", "ours", "c"))
    _write_moves(values, moves)
    table = Table("emit", f"print {moves:,} moves, from an array to a file, without start-up")
    words = (sys.executable, "-c", _PRINT_MOVES, str(values), str(ours))
    subject = Contestant("emit.print_moves", words, moves, own_clock=True)
    loop = _compiled(context, (str(values), str(theirs), str(moves)), moves)
    contestants = [subject] if isinstance(loop, Missing) else [subject, loop]
    for contestant in contestants:
        run(contestant)
    samples, *others = in_turn(contestants, context.rounds)
    table.add(subject, samples)
    if isinstance(loop, Missing):
        table.miss(loop)
        return table
    if not filecmp.cmp(ours, theirs, shallow=False):
        raise BenchmarkError("print_moves and the C loop do not write the same bytes")
    goal = Goal(ratio(others[0], samples), 1.3, at_least=True, unit="x as long")
    table.add(loop, others[0], goal, "the same bytes")
    return table


def _write_moves(path: Path, moves: int) -> None:
    """Pairs of Z and F as an oscillating cut has them."""
    with path.open("wb") as file:
        for first in range(0, moves, 1 << 14):
            part = array("d")
            for move in range(first, min(moves, first + (1 << 14))):
                back = move % 2
                part.extend(
                    ((2000 - move // 60 + 47 * back) / 1000, (58000 + 37 * (move % 90) - 90 * back) / 1e5)
                )
            part.tofile(file)


def _compiled(context: Context, arguments: tuple[str, ...], moves: int) -> Contestant | Missing:
    compiler = shutil.which("cc")
    if compiler is None:
        return Missing("C printf loop", "install a C compiler")
    program = context.path("printf_moves")
    subprocess.run([compiler, "-O2", "-o", str(program), str(_LOOP)], check=True)
    return Contestant("C printf loop", (str(program), *arguments), moves, own_clock=True)
