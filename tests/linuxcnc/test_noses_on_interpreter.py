"""LinuxCNC's own nose compensation against shapes that the filter offsets, both on its interpreter.

The ways are compared as drawn lines: every place on one of them lies on the other one, and in the same order.
"""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from numpy.typing import NDArray

from chipbreak.cycles.nose import Nose
from chipbreak.cycles.nose_runs import compensated_runs, offset_run
from chipbreak.editing.bracket import OFFSET_RUNS
from chipbreak.editing.render import render
from chipbreak.model.interpreted_program import interpret
from chipbreak.self_check import verify_unrolled
from chipbreak.settings import load
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.source import read
from chipbreak.tools.merge import ToolTable
from chipbreak.tools.nose import nose_of
from longer import short_where

from . import rs274
from .test_cycles_on_interpreter import moves_of

Floats = NDArray[np.float64]
pytestmark = pytest.mark.skipif(not rs274.available(), reason="LinuxCNC's interpreter is not installed")
SETTINGS = load("linuxcnc-lathe", ["output.decimals=4"])
WITHIN_MM = 1e-3
DRAWN = 8


def drawn(seed: int) -> bytes:
    """A program with a random shape of lines and arcs under G41.1 or G42.1."""
    rng = random.Random(seed)
    radius = rng.choice((0.2, 0.4, 0.8, 1.2))
    turned = rng.choice((1, -1))  # towards the chuck, or away from it
    side = rng.choice(("left", "right"))
    z, x = 2.0, 20.0
    blocks = [f"G0 X{x + rng.uniform(3, 8):.3f} Z{turned * (z + rng.uniform(3, 8)):.3f}"]
    code = "G41.1" if side == "left" else "G42.1"
    first = rng.choice(("G0", "G1"))
    blocks.append(f"{code} D{2 * radius} L{rng.choice(range(10))} {first} X{x} Z{turned * z}")
    for _ in range(rng.randint(2, 8)):
        along, out = rng.uniform(2, 9), rng.uniform(-5, 7)
        end_z, end_x = z - along, x + out
        blocks.append(move_to(rng, (z, x), (end_z, end_x), turned, radius))
        z, x = end_z, end_x
    blocks.append(f"G40 {rng.choice(('G0', 'G1'))} X{x + 12:.3f} Z{turned * (z + 4):.3f}")
    head = "G8 G18 G21 G90 G94 G40\nF200 S800 M3\n"
    return (head + "\n".join(blocks) + "\nM2\n").encode()


def move_to(
    rng: random.Random, start: tuple[float, float], end: tuple[float, float], turned: int, radius: float
) -> str:
    """A line, or an arc that bulges by not too much."""
    ends = f"X{end[1]:.6f} Z{turned * end[0]:.6f}"
    half = math.dist(start, end) / 2.0
    if rng.random() < 0.6:
        return f"G1 {ends}"
    return f"{rng.choice(('G2', 'G3'))} {ends} R{max(half * rng.uniform(1.05, 3.0), 1.5 * radius):.6f}"


def offset(program: bytes) -> bytes:
    """The program with its compensation written out."""
    interpreted = interpret(parse(read(program), SETTINGS.dialect), SETTINGS)
    (run,) = compensated_runs(interpreted)
    nose = nose_of(interpreted, run.first, ToolTable({}, ()))
    assert isinstance(nose, Nose)
    edit = offset_run(interpreted, run, nose).edit
    output = b"".join(render(interpreted.program, [edit], SETTINGS, OFFSET_RUNS))
    verify_unrolled(interpreted, output, [edit], OFFSET_RUNS)
    return output


def line_of(program: bytes) -> Floats:
    """Places on all moves, (n, 2); a straight move has its ends."""
    return np.concatenate([way if len(way) == 2 else way[::10] for _, way in moves_of(program)])


def places_of(line: Floats) -> Floats:
    """Some places on a line."""
    return np.concatenate([line[:-1] + share * np.diff(line, axis=0) for share in (0.0, 0.3, 0.7)])


def farthest(places: Floats, line: Floats) -> float:
    """How far any of the places is off a line."""
    first, way = line[:-1], np.diff(line, axis=0)
    length = np.maximum((way**2).sum(axis=1), 1e-18)
    off = places[:, None] - first
    share = np.clip((off * way).sum(axis=2) / length, 0.0, 1.0)
    return float(np.hypot(*np.moveaxis(off - share[:, :, None] * way, 2, 0)).min(axis=1).max())


def compared(seed: int) -> bool | None:
    """True where both go the same way; None where one of them refuses the shape."""
    program = drawn(seed)
    try:
        written = offset(program)
    except RefusalError as error:
        assert error.code in ("VIB040", "VIB022")
        return None
    if not rs274.judge(program, lathe=True).accepted:
        return None
    own, ours = line_of(program), line_of(written)
    off = max(farthest(places_of(own), ours), farthest(places_of(ours), own))
    assert off <= WITHIN_MM, f"seed {seed}: {off:.4f} mm"
    return True


@pytest.mark.parametrize("seed", short_where(range(DRAWN), lambda seed: seed in (0, 6)))
def test_both_go_the_same_way(seed: int) -> None:
    if compared(seed) is None:
        pytest.skip("one of them refuses this shape")
