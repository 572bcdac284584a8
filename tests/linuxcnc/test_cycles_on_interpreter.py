"""LinuxCNC's own cycles against the passes written for them, both on its interpreter.

What each removes is drawn from the canonical moves alone: the tool is a point, and a feed takes away all that
lies over its way, on the side of the stock.  So heights at places along the passes are compared.
"""

from __future__ import annotations

import math
import re
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import chipbreak
from chipbreak.settings import load
from longer import first_of_each, short_where

from . import rs274

Floats = NDArray[np.float64]
pytestmark = pytest.mark.skipif(not rs274.available(), reason="LinuxCNC's interpreter is not installed")
PLACES = 20_001
ALWAYS = 'cycles.unroll="always"'

STEPPED = "G0 X8\nG1 Z-15\nG1 X12\nG1 X15 Z-22\nG1 Z-30\nG1 X26"
POCKETS = "G0 X8\nG1 Z-15\nG1 X15\nG1 X13 Z-22\nG1 Z-24\nG1 X15 Z-30\nG1 X18\nG1 X16.5 Z-36\nG1 X26 Z-40"
ARCS = "G0 X8\nG1 Z-5\nG2 X12 Z-9 I4 K0\nG1 X14\nG3 X17 Z-12 I0 K-3\nG1 Z-20\nG1 X26"
TAPERS = "G0 X6\nG1 X8 Z-2\nG1 X12 Z-20\nG1 X20 Z-24\nG1 X26"
CORNERS = "G0 X8\nG1 Z-15 A1\nG1 X12 C1\nG1 X15 Z-22 A2\nG1 Z-30 C1.5\nG1 X26"
INSIDE = "G0 X26\nG1 Z-15\nG1 X20\nG1 X16 Z-22\nG1 Z-30\nG1 X8"
BACKWARDS = "G0 X8 Z-40\nG1 Z-25\nG1 X12\nG1 X15 Z-18\nG1 Z-8\nG1 X26"
FACING = "G0 Z-20\nG1 X20\nG1 Z-12\nG1 X14\nG1 X10 Z-6\nG1 Z2"
FACED_POCKETS = "G0 Z-20\nG1 X20\nG1 Z-12\nG1 X17 Z-14\nG1 X14 Z-12\nG1 X10 Z-6\nG1 X8 Z-7.5\nG1 X7\nG1 Z2"

OUTER = "X28 Z2"
CASES = [
    *[(shape, OUTER, f"G71 Q100 I{depth} R0.5{rest}") for shape in (STEPPED, POCKETS, ARCS, TAPERS)
      for depth, rest in ((2, ""), (1.3, " D0.4"), (0.7, " D0.25"))],
    (CORNERS, OUTER, "G71 Q100 I2 R0.5"),
    (CORNERS, OUTER, "G71 Q100 I1.3 R0.5 D0.4"),
    (CORNERS, OUTER, "G71 Q100 I0.7 R0.5 D0.25"),
    (POCKETS, OUTER, "G71.1 Q100 I1.5 R0.5"),
    (POCKETS, OUTER, "G71.1 Q100 I1.5 R0.5 D0.3"),
    (POCKETS, OUTER, "G71.2 Q100 I1.5 R0.5"),
    (INSIDE, "X6 Z2", "G71 Q100 I2 R0.4"),
    (INSIDE, "X6 Z2", "G71 Q100 I2 R0.4 D0.3"),
    (BACKWARDS, "X28 Z-42", "G71 Q100 I2 R0.5"),
    (FACING, "X28 Z3", "G72 Q100 I1.5 R0.4"),
    (FACING, "X28 Z3", "G72 Q100 I1.5 R0.4 D0.3"),
    (FACING, "X28 Z3", "G72.1 Q100 I1.5 R0.4"),
    (FACED_POCKETS, "X28 Z3", "G72 Q100 I1.5 R0.4"),
    (FACED_POCKETS, "X28 Z3", "G72.2 Q100 I1.5 R0.4"),
]  # fmt: skip
FINISHES = [
    (shape, OUTER, f"G70 Q100{rest}")
    for shape in (STEPPED, POCKETS, ARCS, TAPERS, CORNERS)
    for rest in ("", " D0.4", " D0.6 E0.2 P3")
]


def program_of(shape: str, start: str, cycle: str) -> str:
    subroutine = f"o100 sub\n{shape}\no100 endsub\n"
    return f"G8 G18 G21 G90 G94 G40\nF200 S800 M3\n{subroutine}G0 {start}\n{cycle}\nG0 X40 Z10\nM2\n"


def moves_of(program: bytes) -> list[tuple[bool, Floats]]:
    """Each move: whether it feeds, and places on it (n, 2) as Z and X."""
    judged = rs274.judge(program, lathe=True)
    assert judged.accepted, judged.message
    found = []
    at = np.zeros(2)
    for call in rs274.calls(judged.canon):
        if call.name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            end = np.array([float(call.arguments[2]), float(call.arguments[0])])
            way = np.array([at, end])
        elif call.name == "ARC_FEED":
            end = np.array([float(text) for text in call.arguments[:2]])
            centre = np.array([float(text) for text in call.arguments[2:4]])
            way = arc(at, end, centre, int(call.arguments[4]))
        else:
            continue
        found.append((call.name != "STRAIGHT_TRAVERSE", way))
        at = end
    return found


def arc(start: Floats, end: Floats, centre: Floats, turn: int) -> Floats:
    first = math.atan2(*(start - centre)[::-1])
    last = math.atan2(*(end - centre)[::-1])
    sweep = (last - first) * turn % (2.0 * math.pi) * turn
    angles = first + sweep * np.linspace(0.0, 1.0, 2000)
    radius = math.dist(start, centre)
    return np.column_stack((centre[0] + radius * np.cos(angles), centre[1] + radius * np.sin(angles)))


def left(moves: list[tuple[bool, Floats]], t: Floats, top: float, turned: Floats) -> Floats:
    """The heights that are left at places ``t``; ``turned`` takes Z and X into the axes of the passes."""
    height = np.full(len(t), top)
    for feeds, drawn in moves:
        way = drawn @ turned
        way = way if way[-1, 0] >= way[0, 0] else way[::-1]
        inside = (t >= way[0, 0]) & (t <= way[-1, 0])
        there = np.interp(t[inside], way[:, 0], way[:, 1])
        if feeds and len(there):
            height[inside] = np.minimum(height[inside], there)
    return height


def axes_of(shape: str, start: str, cycle: str) -> tuple[Floats, Floats, float]:
    """The axes of the passes, the places along them that the contour spans, and the height of the start."""
    x, z = map(float, re.fullmatch(r"X(\S+) Z(\S+)", start).groups())  # type: ignore[union-attr]
    points = [(z, x)]
    for block in shape.splitlines():
        words = dict(re.findall(r"([XZ])([-.\d]+)", block))
        points.append((float(words.get("Z", points[-1][0])), float(words.get("X", points[-1][1]))))
    shape_points = np.array(points[1:])
    along = np.array([[1.0, 0.0], [0.0, 1.0]]) if "G71" in cycle else np.array([[0.0, 1.0], [1.0, 0.0]])
    there = shape_points @ along
    begin = np.array([z, x]) @ along
    signs = np.sign([there[-1, 0] - there[0, 0], begin[1] - there[0, 1]])
    turned = along * signs
    spans = (shape_points @ turned)[:, 0]
    return turned, np.linspace(spans.min(), spans.max(), PLACES), float((np.array([z, x]) @ turned)[1])


@pytest.mark.parametrize(
    ("shape", "start", "cycle"),
    first_of_each(
        CASES, lambda case: (*case[:2], case[2].split()[0], case[0] == STEPPED and " D" in case[2])
    ),
)
def test_both_remove_the_same(shape: str, start: str, cycle: str) -> None:
    hold(shape, start, cycle)


def hold(shape: str, start: str, cycle: str) -> None:
    """The passes that are written for a cycle remove what the cycle itself does."""
    program = program_of(shape, start, cycle).encode()
    written = chipbreak.rewrite(program, load("linuxcnc-lathe", [ALWAYS])).data
    assert b"UNROLLED G7" in written
    assert chipbreak.restore(written) == program
    turned, t, top = axes_of(shape, start, cycle)
    own = left(moves_of(program), t, top, turned)
    ours = left(moves_of(written), t, top, turned)
    walls = np.convolve(np.abs(np.gradient(own)) > 0.05, np.ones(9), "same") > 0
    assert float(np.abs(own - ours)[~walls].max()) <= 2e-3
    step = t[1] - t[0]
    assert float(np.abs(own - ours).sum() * step) <= 1e-3 * (t[-1] - t[0]) + 4.0 * step * np.ptp(own)


@pytest.mark.parametrize(
    ("shape", "start", "cycle"),
    short_where(FINISHES, lambda case: case[0] == STEPPED or " D" not in case[2]),
)
def test_both_finish_along_the_same_line(shape: str, start: str, cycle: str) -> None:
    program = program_of(shape, start, cycle).encode()
    written = chipbreak.rewrite(program, load("linuxcnc-lathe", [ALWAYS])).data
    assert b"UNROLLED G70" in written
    assert ends_of(moves_of(written)) == pytest.approx(ends_of(moves_of(program)), abs=3e-4)


def cycles_of(text: str) -> list[tuple[str, str, str]]:
    """The shape, the start and the words of each G71 and G72 that a program says with plain numbers."""
    bodies = re.findall(r"(?ims)^\s*o(\d+)\s+sub\s*$(.*?)^\s*o\1\s+endsub", text)
    shapes = {number: re.sub(r"(?m)^\s*(;.*)?\n", "", body).strip() for number, body in bodies}
    found = []
    for code, number, x, z, rest in re.findall(
        r"(?im)^\s*(G7[12](?:\.[12])?) Q(\d+) X([-.\d]+) Z([-.\d]+)( [^#\[\n]*)$", text
    ):
        if number in shapes and not set(shapes[number]) & set("#["):
            shape = "\n".join(line.strip().upper() for line in shapes[number].splitlines())
            found.append((shape, f"X{x} Z{z}", f"{code} Q100{rest}"))
    return found


def test_cycles_of_real_programs_remove_what_they_remove_on_the_control(corpus: list[Path]) -> None:
    """What stays as it was says why; what is written out is held, where the control comes to an end."""
    cases = {case for path in corpus for case in cycles_of(path.read_bytes().decode("latin-1"))}
    held = 0
    for shape, start, cycle in sorted(cases):
        program = program_of(shape, start, cycle).encode()
        result = chipbreak.rewrite(program, load("linuxcnc-lathe", [ALWAYS]))
        if result.data == program:
            assert [d for d in result.diagnostics if d.code.startswith("CYC")]
            continue
        if ends_on_the_control(program):
            hold(shape, start, cycle)
            held += 1
    assert held > 0


def ends_on_the_control(program: bytes) -> bool:
    """False where its interpreter works without end, as at an outer corner under some distances D."""
    try:
        return rs274.judge(program, lathe=True, timeout_s=10.0).accepted
    except subprocess.TimeoutExpired:
        return False


def ends_of(moves: list[tuple[bool, Floats]]) -> Floats:
    """Where each move ends, (n, 2); a move without length is none."""
    ends = [way[-1] for _, way in moves]
    return np.array([b for a, b in pairwise(ends) if math.dist(a, b) > 1e-3])


def test_pockets_alone_follow_a_cycle_without_them() -> None:
    both = program_of(POCKETS, OUTER, "G71.1 Q100 I1.5 R0.5\nG0 X28 Z2\nG71.2 Q100 I1.5 R0.5").encode()
    written = chipbreak.rewrite(both, load("linuxcnc-lathe", [ALWAYS])).data
    assert written.count(b"UNROLLED G71") == 2
    turned, t, top = axes_of(POCKETS, OUTER, "G71")
    own = left(moves_of(both), t, top, turned)
    ours = left(moves_of(written), t, top, turned)
    walls = np.convolve(np.abs(np.gradient(own)) > 0.05, np.ones(9), "same") > 0
    assert float(np.abs(own - ours)[~walls].max()) <= 2e-3


def test_the_tool_stays_where_the_cycle_of_the_control_leaves_it() -> None:
    program = program_of(STEPPED, OUTER, "G71 Q100 I2").encode()
    written = chipbreak.rewrite(program, load("linuxcnc-lathe", [ALWAYS])).data
    assert moves_of(written)[-2][1][-1] == pytest.approx(moves_of(program)[-2][1][-1], abs=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("Q100 I2", "Q101 I2", "CYC001"),
        ("Q100 I2", "Q100 I0", "CYC004"),
        ("Q100 I2", "Q100 I2 D-1", "CYC007"),
        ("Q100 I2", "Q100 I2 D#1", "CYC007"),
        ("G71 Q100 I2", "G72 Q100 I2 W1", "CYC007"),
        ("G0 X40", "X40", "CYC007"),
        ("G1 X15 Z-22", "G1 X15 Z-12", "CYC003"),
        ("G1 X15 Z-22", "G2 X15 Z-18 I3 K0\nX16 Z-19 I1 K0", "CYC002"),
        ("G1 Z-15", "o101 repeat [3]\nG1 Z-15\no101 endrepeat", "CYC002"),
        ("G40", "G40 G90.1", "CYC007"),
        ("G1 X26\no100 endsub\nG0 X28 Z2\nG71 Q100", "G1 X9\no100 endsub\nG0 X28 Z2\nG71.1 Q100", "CYC003"),
    ],
)
def test_what_cannot_be_written_out_stays(old: str, new: str, code: str) -> None:
    program = program_of(STEPPED, OUTER, "G71 Q100 I2").replace(old, new).encode()
    result = chipbreak.rewrite(program, load("linuxcnc-lathe", [ALWAYS]))
    assert result.data == program
    assert [d.code for d in result.diagnostics if d.code.startswith("CYC")] == [code]
