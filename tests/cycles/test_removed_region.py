"""What is removed is the stock over the contour with its allowances, no pass is too deep, no rapid cuts.

Twelve shapes in six places of the lathe: outer and inner turning, both ways along Z, and facing.  The region
is drawn by ``removed_region``, which knows nothing of the product.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.cycles.plan import DEEPER_THAN_ALL
from chipbreak.settings import load
from longer import short_where

from .removed_region import Columns, Floats, Way, arc_places, centre_by_radius, over, ways_of

T_ALLOWANCE, H_ALLOWANCE = 0.1, 0.2
BEFORE, RETRACT = 2.0, 0.4

# Steps of a shape: along t, along h, and the radius of an arc that turns left (positive) or right.
Step = tuple[float, float, float]
SHAPES: dict[str, list[Step]] = {
    name: [(*step, 0.0)[:3] for step in steps]  # type: ignore[misc]
    for name, steps in {
        "cylinder": [(30.0, 0.0), (0.0, 9.0)],
        "steps": [(8.0, 0.0), (0.0, 3.0), (6.5, 0.0), (0.0, 2.2), (9.0, 0.0), (0.0, 4.0)],
        "taper": [(4.0, 0.0), (18.0, 6.0), (5.0, 0.0), (0.0, 3.0)],
        "steep-tapers": [(1.0, 4.0), (6.0, 0.5), (0.3, 5.0), (7.0, 0.0)],
        "chamfers": [(0.0, 2.0), (1.0, 1.0), (10.0, 0.0), (0.0, 2.0), (1.5, 1.5), (8.0, 0.0)],
        "fillet": [(8.0, 0.0), (3.0, 3.0, 3.0), (0.0, 2.0), (9.0, 0.0)],
        "round-corner": [(0.0, 1.0), (3.0, 3.0, -3.0), (12.0, 0.0), (2.0, 2.0, 2.0), (0.0, 1.5)],
        "flat-arcs": [(10.0, 3.0, 25.0), (8.0, 2.0, -20.0), (6.0, 4.0, 12.0)],
        "pocket": [(6.0, 4.0), (5.0, 0.0), (4.0, -3.0), (6.0, 0.0), (3.0, 3.5), (4.0, 4.0)],
        "two-pockets": [(4.0, 5.0), (5.0, -3.0), (3.0, 2.0), (3.0, -1.5), (4.0, 0.0), (4.0, 5.0)],
        "round-pocket": [(5.0, 5.0), (6.0, 0.0, 5.0), (4.0, 0.0), (2.0, 3.0)],
        "walled-pocket": [(5.0, 0.0), (0.0, 5.0), (4.0, 0.0), (0.0, -2.5), (6.0, 0.0), (0.0, 6.0)],
    }.items()
}


class Place(NamedTuple):
    """Where on the lathe a shape is: along Z or X, and the signs of t and h there."""

    along: str
    t_sign: int
    h_sign: int

    def lathe(self, places: Floats) -> Floats:
        """t and h as Z and radius."""
        moved = places * (self.t_sign, self.h_sign)
        return (moved if self.along == "Z" else moved[:, ::-1]) + (0.0, 40.0)

    def turned(self, places: Floats) -> Floats:
        """Z and radius as t and h."""
        moved = places - (0.0, 40.0)
        return (moved if self.along == "Z" else moved[:, ::-1]) * (self.t_sign, self.h_sign)

    @property
    def mirrors(self) -> bool:
        return (self.t_sign * self.h_sign < 0) != (self.along == "X")


PLACES = {
    "outer": Place("Z", -1, 1),
    "outer-from-the-chuck": Place("Z", 1, 1),
    "inner": Place("Z", -1, -1),
    "inner-from-the-chuck": Place("Z", 1, -1),
    "facing": Place("X", -1, 1),
    "facing-outwards": Place("X", 1, 1),
}


def outline_of(shape: Sequence[Step]) -> Floats:
    """Places on a shape from 0, 0."""
    at = np.zeros(2)
    rows = [at[None]]
    for t, h, radius in shape:
        end = np.add(at, (t, h))
        places = end[None]
        if radius:
            centre = centre_by_radius(at, end, abs(radius), ccw=radius > 0.0)
            places = arc_places(at, end, centre, ccw=radius > 0.0)[1:]
        rows.append(places)
        at = end
    return np.concatenate(rows)


def top_of(shape: Sequence[Step], over: float) -> float:
    """How high the stock is, as far as the digits of the program go."""
    return round(float(outline_of(shape)[:, 1].max()) + over, 3)


def words_of(place: Place, point: Sequence[float], letters: str = "XZ") -> str:
    z, x = place.lathe(np.array([point]))[0]
    return " ".join(f"{letter}{value:.3f}" for letter, value in (("X", 2 * x), ("Z", z)) if letter in letters)


def program_of(shape: Sequence[Step], place: Place, depth: float, over: float, *, one_block: bool) -> str:
    """A G71 or G72 with its contour, as a user writes it; the first block names both axes (type II)."""
    top = top_of(shape, over)
    blocks = []
    at = np.zeros(2)
    for t, h, radius in shape:
        at = np.add(at, (t, h))
        left = (radius > 0.0) != place.mirrors
        code = "G1" if not radius else "G3" if left else "G2"
        blocks.append(f"{code} {words_of(place, at)}" + (f" R{abs(radius):.3f}" if radius else ""))
    blocks[-1] = f"N20 {blocks[-1]}"
    allowances = place.lathe(np.array([[-T_ALLOWANCE, H_ALLOWANCE]]))[0] - (0.0, 40.0)
    said = f"P10 Q20 U{2.0 * allowances[1]:.3f} W{allowances[0]:.3f}"
    code, letter = ("G71", "U") if place.along == "Z" else ("G72", "W")
    head = [f"{code} {letter}{depth:.3f} R{RETRACT}", f"{code} {said} F0.2"]
    head = [f"{code} {said} D{depth:.3f} F0.2"] if one_block else head
    start = words_of(place, (-BEFORE, top))
    first = f"N10 G0 {words_of(place, (0.0, 0.0))}"
    lines = ["G21 G99", "G97 S900 M3", f"G0 {start}", *head, first, *blocks, "G0 X300. Z300.", "M30", ""]
    return "\n".join(lines)


def check(shape: Sequence[Step], place: Place, depth: float, blocks: Sequence[str], over: float) -> None:
    """Run the blocks of a cycle against the stock."""
    outline = np.add(outline_of(shape), (-T_ALLOWANCE, H_ALLOWANCE))
    top = top_of(shape, over)
    start = place.lathe(np.array([[-BEFORE, top]]))[0]
    ways = ways_of(blocks, (start[0], start[1]), place.turned)
    columns = Columns(ways, outline, float(outline[0, 0]), top)
    for way in ways:
        too_deep, rushed = columns.run(way, depth)
        assert too_deep <= 0.01, "a pass is deeper than commanded"
        assert rushed <= 0.005, "a rapid goes through material"
        assert_sinks_into_air(way, columns)
    length = float(np.hypot(*np.diff(outline, axis=0).T).sum())
    assert columns.lost() <= 1e-3 * length, "another region is left"
    assert math.dist(ways[-1].places[-1], (-BEFORE, top)) <= 1e-9


def assert_sinks_into_air(way: Way, columns: Columns) -> None:
    """A rapid straight down has free room beside it."""
    (t, from_h), (end, to_h) = way.places[0], way.places[-1]
    if way.cuts or end != t or to_h >= from_h:
        return
    near = np.abs(columns.t - t) < 0.006
    if near.any() and t > columns.edges[0] + 0.006:
        assert float(columns.height[near].min()) <= to_h + 2e-3, "a rapid goes down into material"


def blocks_of(program: str, *options: str) -> list[str]:
    """The blocks that stand for the cycle."""
    settings = load("fanuc-lathe", ['cycles.unroll="always"', *options])
    output = chipbreak.rewrite(program.encode(), settings).data
    assert chipbreak.restore(output) == program.encode()
    lines = output.decode().splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith("(CHIPBREAK UNROLLED G7"))
    end = next(i for i, line in enumerate(lines) if i > begin and line.startswith("(CHIPBREAK ROLLED"))
    return [line for line in lines[begin:end] if not line.startswith("(")]


CASES = [
    (shape, place, (1.0, 1.7, 2.5)[number % 3], (1.0, 3.3)[number % 2])
    for number, (shape, place) in enumerate((s, p) for s in SHAPES for p in PLACES)
]


def is_short(case: tuple[Any, ...]) -> bool:
    """Each shape in half of the places, and in each place half of the shapes."""
    shape, place, *_ = case
    return (list(SHAPES).index(shape) + list(PLACES).index(place)) % 2 == 0


@pytest.mark.parametrize(("shape", "place", "depth", "over"), short_where(CASES, is_short))
def test_the_region_is_the_stock_over_the_contour(shape: str, place: str, depth: float, over: float) -> None:
    one_block = shape in ("steps", "flat-arcs")
    program = program_of(SHAPES[shape], PLACES[place], depth, over, one_block=one_block)
    check(SHAPES[shape], PLACES[place], depth, blocks_of(program), over)


RISING = ("cylinder", "steps", "taper", "steep-tapers", "chamfers")


def steps_over(outline: Floats, columns: Columns, top: float, depth: float) -> Floats:
    """What levels of the depth leave: of each place the lowest level that lies not below the shape there.

    The last level is the lowest line of the shape, however little it takes.
    """
    lowest = float(outline[:, 1].min())
    levels = [*np.arange(top - depth, lowest + 1e-6, -depth), lowest, top]
    shape = over(outline, columns.t)
    return np.array([min(level for level in levels if level >= height - 1e-6) for height in shape])


@pytest.mark.parametrize(("shape", "place"), short_where(product(RISING, PLACES), is_short))
def test_without_a_pass_along_the_contour_the_steps_are_left(shape: str, place: str) -> None:
    program = program_of(SHAPES[shape], PLACES[place], 1.7, 1.0, one_block=False)
    blocks = blocks_of(program, 'cycles.finish_pass="never"')
    outline = np.add(outline_of(SHAPES[shape]), (-T_ALLOWANCE, H_ALLOWANCE))
    top = top_of(SHAPES[shape], 1.0)
    start = PLACES[place].lathe(np.array([[-BEFORE, top]]))[0]
    ways = ways_of(blocks, (start[0], start[1]), PLACES[place].turned)
    columns = Columns(ways, outline, float(outline[0, 0]), top)
    for way in ways:
        too_deep, rushed = columns.run(way, 1.7)
        assert (too_deep, rushed) <= (0.01, 0.005)
        assert_sinks_into_air(way, columns)
    columns.aimed = np.minimum(steps_over(outline, columns, top, 1.7), top)
    assert columns.lost() <= 0.01 * float(np.hypot(*np.diff(outline, axis=0).T).sum())
    assert math.dist(ways[-1].places[-1], (-BEFORE, top)) <= 1e-9


@pytest.mark.parametrize(
    ("value", "shape", "has_pass"),
    [
        ("always", "pocket", True),
        ("type-2", "pocket", True),
        ("type-1", "pocket", False),
        ("never", "pocket", False),
    ],
)
def test_the_type_says_whether_the_contour_is_followed(value: str, shape: str, has_pass: bool) -> None:
    program = program_of(SHAPES[shape], PLACES["outer"], 1.0, 1.0, one_block=False).encode()
    settings = load("fanuc-lathe", ['cycles.unroll="always"', f'cycles.finish_pass="{value}"'])
    output = chipbreak.rewrite(program, settings).data
    assert (b"ALONG THE CONTOUR" in output) is has_pass
    assert chipbreak.restore(output) == program


def test_there_are_enough_of_them() -> None:
    assert len(CASES) >= 60


def changed(blocks: list[str], change: Callable[[str], str], at: str) -> list[str]:
    number = next(i for i, block in enumerate(blocks) if at in block)
    return [*blocks[:number], change(blocks[number]), *blocks[number + 1 :]]


@pytest.mark.parametrize(
    ("at", "old", "new", "why"),
    [
        ("G1 Z-14.4", "Z-14.4", "Z-14.8", "another region"),
        ("G1 Z-7.9", "Z-7.9", "Z-7.8", "deeper"),
        ("G1 Z-14.4", "G1", "G0", "rapid"),
        ("G0 X96.4", "X96.4", "X95.4", "deeper"),
    ],
)
def test_a_wrong_block_is_found(at: str, old: str, new: str, why: str) -> None:
    """The check above can fail."""
    blocks = blocks_of(program_of(SHAPES["steps"], PLACES["outer"], 2.0, 1.0, one_block=False))
    check(SHAPES["steps"], PLACES["outer"], 2.0, blocks, 1.0)
    with pytest.raises(AssertionError, match=why):
        check(SHAPES["steps"], PLACES["outer"], 2.0, changed(blocks, lambda b: b.replace(old, new), at), 1.0)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    "shape",
    [
        [(10.0, 0.0, 0.0), (-2.0, 3.0, 0.0), (10.0, 5.0, 0.0)],
        [(8.0, 0.0, 0.0), (0.0, 4.0, 2.0), (10.0, 2.0, 0.0)],
        [(8.0, 4.0, 0.0), (0.0, -2.0, 1.5), (6.0, 5.0, 0.0)],
    ],
    ids=["line", "arc-out", "arc-in"],
)
def test_an_undercut_is_refused(shape: list[Step], place: str) -> None:
    program = program_of(shape, PLACES[place], 1.5, 1.0, one_block=False).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ['cycles.unroll="always"']))
    assert result.data == program
    assert [d.code for d in result.diagnostics if d.code.startswith("CYC")] == ["CYC003"]


MANY = 40 if settings.default and settings.default.derandomize else 1000  # in a search
# Whole micrometres, and many steps of a few of them: the digits of the output are no finer.
SIZES = st.one_of(st.integers(0, 9000), st.integers(0, 6), st.integers(0, 9000))
DROPS = st.one_of(st.integers(-3000, 5000), st.integers(-5, 6), st.integers(0, 5000))
STEPS = st.lists(st.tuples(SIZES, DROPS, st.sampled_from([0, 0, 1, -1])), min_size=2, max_size=7)


def shape_of(steps: list[tuple[int, int, int]]) -> list[Step]:
    """Steps in micrometres; an arc has twice the larger way as its radius, so it seldom turns back."""
    return [
        (t / 1000.0, h / 1000.0, turn * 2.0 * max(t, abs(h)) / 1000.0 if min(t, abs(h)) > 100 else 0.0)
        for t, h, turn in steps
        if t or h
    ]


@pytest.mark.few(10)
@settings(max_examples=MANY)
@example([(1, 4, 0), (0, -4, 0), (594, 0, 0)], "facing", 150, 600)
@given(STEPS, st.sampled_from(sorted(PLACES)), st.integers(150, 4000), st.integers(600, 5000))
def test_the_region_of_any_contour(
    steps: list[tuple[int, int, int]], name: str, depth: int, over: int
) -> None:
    shape = shape_of(steps)
    assume(sum(t for t, _, _ in shape) > 0.5)
    place = PLACES[name]
    program = program_of(shape, place, depth / 1000.0, over / 1000.0, one_block=False)
    result = chipbreak.rewrite(program.encode(), load("fanuc-lathe", ['cycles.unroll="always"']))
    refused = {d.code for d in result.diagnostics if d.code.startswith(("CYC", "VIB022"))} - {DEEPER_THAN_ALL}
    assert refused <= {"CYC003"}, "an arc may turn back"
    if not refused:
        check(shape, place, depth / 1000.0, blocks_of(program), over / 1000.0)
