"""Cycles of real programs: what is written removes what the cycle is documented to remove.

The contour is read from the brackets by a reader of its own; the region is drawn by ``removed_region``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import chipbreak
from chipbreak.settings import load
from chipbreak.text.diagnostics import ProgramRejectedError
from longer import every_second

from .removed_region import Columns, Floats, arc_places, centre_by_radius, ways_of

SAMPLES = sorted((Path(__file__).parents[2] / "samples").glob("*.nc"))
SHOP = sorted((Path(__file__).parents[1] / "shop").glob("*.nc"))
ROUGHS = re.compile(rb"G0*7[123]\D[^\n]*P", re.IGNORECASE)
_WORD = re.compile(r"([A-Z])\s*(-?[\d.]+)")
_CALL = re.compile(r"M98 P(\d+)")
_TITLE = re.compile(r"O(\d+)")
_HEADS = re.compile(r"\(CHIPBREAK UNROLLED (G7[12]|CONTOUR|G\d+)")


@dataclass
class Written:
    """A cycle as its brackets show it: what it was, what stands for it, and where the tool was before."""

    name: str
    was: list[str]
    blocks: list[str]
    before: tuple[float, float]


class Calls:
    """Where the tool stands when a subprogram of the same file is called: there it begins."""

    def __init__(self) -> None:
        self.places: dict[int, dict[str, float]] = {}

    def start_of(self, line: str, at: dict[str, float]) -> dict[str, float]:
        """Where the tool stands at a line instead, if that begins a subprogram that has been called."""
        if call := _CALL.match(line):
            self.places[int(call[1]) % 10_000] = dict(at)
        title = _TITLE.match(line)
        return self.places.get(int(title[1]), {}) if title else {}


def written_cycles(output: str) -> Iterator[Written]:
    """The cycles of a program in millimetres with X as a diameter, in order."""
    at = {"X": float("nan"), "Z": float("nan")}
    called = Calls()
    inside: Written | None = None
    kept: list[str] = []
    for line in output.splitlines():
        at |= called.start_of(line, at)
        if head := _HEADS.search(line):
            inside = Written(head[1], [], [], (at["Z"], at["X"] / 2.0))
            kept = []
        elif not line.startswith("("):
            at |= {letter: float(number) for letter, number in _WORD.findall(line) if letter in "XZ"}
            if inside is not None:
                inside.blocks.append(line)
        elif inside is not None and "(CHIPBREAK ROLLED" in line:
            yield inside
            inside = None
        elif inside is not None and line.startswith("(CHIPBREAK "):
            kept.append(kept_text(line))
            inside.was = "".join(kept).splitlines()


def kept_text(line: str) -> str:
    """What a comment of a bracket keeps of the program as it was."""
    _, kind, text = line[:-1].split(" ", 2)
    return bytes.fromhex(text).decode("latin-1") if kind == "HEX" else f"{text}\n"


def words_of(block: str) -> dict[str, float]:
    return {letter: float(number) for letter, number in _WORD.findall(re.sub(r"\(.*?\)|;.*", "", block))}


def outline_of(contour: list[str], start: tuple[float, float]) -> tuple[Floats, bool]:
    """Places on a contour of plain G0 to G3, as Z and radius; whether it is all plain."""
    at = np.array(start)
    rows = []
    code = 0.0
    for block in contour:
        words = words_of(re.sub(r"^N\d+", "", block.strip()))
        code = next((float(g) for g in re.findall(r"G0*([0-3])(?!\d)", block)), code)
        if not words.keys() & set("XZUW"):
            continue
        if has_corners(block, words, code):
            return np.empty((0, 2)), False
        z = words.get("Z", at[0]) + words.get("W", 0.0)
        x = words["X"] / 2.0 if "X" in words else at[1] + words.get("U", 0.0) / 2.0
        end = np.array([z, x])
        rows.append(arc_of(at, end, words, ccw=code == 3.0) if code >= 2.0 and rows else end[None])
        at = end
    return np.concatenate(rows), True


def has_corners(block: str, words: dict[str, float], code: float) -> bool:
    """True where a block draws more than its own line or arc."""
    letters = set(words)
    return "," in block or bool(letters & set("AC")) or (code < 2.0 and bool(letters & set("RIK")))


def arc_of(at: Floats, end: Floats, words: dict[str, float], *, ccw: bool) -> Floats:
    """Places on an arc by R, or by I and K, behind its start."""
    centre = np.add(at, (words.get("K", 0.0), words.get("I", 0.0)))
    if "R" in words:
        centre = centre_by_radius(at, end, words["R"], ccw=ccw)
    return arc_places(at, end, centre, ccw=ccw)[1:]


def check(cycle: Written, contour: list[str]) -> bool:
    """True where the region of a cycle was held against its contour."""
    outline, is_plain = outline_of(contour, cycle.before)
    said = words_of(cycle.was[-1])
    first = words_of(cycle.was[0])
    if not is_plain or "I" in said or "K" in said:
        return False
    along_z = cycle.name == "G71"
    depth = said["D"] if "D" in said else first["U" if along_z else "W"]
    depth = depth / 1000.0 if "D" in said and "." not in cycle.was[-1].split("D")[1].split()[0] else depth
    outline = np.add(outline, (said.get("W", 0.0), said.get("U", 0.0) / 2.0))
    order = (0, 1) if along_z else (1, 0)
    start = np.array(cycle.before)[list(order)]
    line = outline[:, list(order)]
    signs = np.array([np.sign(line[-1, 0] - line[0, 0]), np.sign(start[1] - line[0, 1])])
    ways = ways_of(cycle.blocks, cycle.before, lambda places: places[:, list(order)] * signs)
    columns = Columns(ways, line * signs, float((line * signs)[0, 0]), float((start * signs)[1]))
    for way in ways:
        too_deep, rushed = columns.run(way, depth)
        assert too_deep <= 0.01
        assert rushed <= 0.005
    length = sum(float(np.hypot(*(b - a))) for a, b in pairwise(line))
    assert columns.lost() <= 1e-3 * length
    return True


def held(program: bytes, *options: str) -> int:
    """Write all cycles out, and hold each against its contour; how many were.  Wishes are taken out."""
    program = re.sub(rb"\(VIB[^)]*\)", b"", program)
    settings = load("fanuc-lathe", ['cycles.unroll="always"', "cycles.retract_mm=0.5", *options])
    try:
        output = chipbreak.rewrite(program, settings).data
    except ProgramRejectedError:
        return 0  # what is wrong with it has nothing to do with its cycles, or stands in another test
    assert chipbreak.restore(output) == program
    assert chipbreak.rewrite(output, settings).data == output
    if b"G20" in program:
        return 0
    cycles = list(written_cycles(output.decode("latin-1")))
    contours = [cycle.was for cycle in cycles if cycle.name == "CONTOUR"]
    count = 0
    for cycle in cycles:
        if cycle.name in ("G71", "G72"):
            number = words_of(cycle.was[-1])["P"]
            contour = next(c for c in contours if words_of(c[0]).get("N") == number)
            count += check(cycle, contour)
    return count


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda path: path.stem)
def test_samples(sample: Path) -> None:
    program = sample.read_bytes()
    if ROUGHS.search(program):
        assert held(program) > 0


@pytest.mark.parametrize("path", every_second(SHOP), ids=lambda path: path.stem)
def test_programs_of_shops(path: Path) -> None:
    """Patterns, boring with G20, and cycles that stay have no contour to be held against here."""
    held(path.read_bytes(), "control.lathe_system=A")  # whose codes ``held`` knows


def test_real_programs(corpus: list[Path]) -> None:
    """Those that a lathe profile reads at all; the others are not of such controls."""
    roughing = [path for path in corpus if ROUGHS.search(path.read_bytes())]
    assert roughing
    for path in roughing:
        held(path.read_bytes(), 'control.decimal_point="calculator"')
