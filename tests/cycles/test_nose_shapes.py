"""Which cuts of a run are walls of one another, where a way in ends, and what a nose of a size gets into."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

from chipbreak.cycles.contour import Frame, Point, Segment
from chipbreak.cycles.nose import Nose, Offset, _beside, _cuts, offset_moves
from chipbreak.dialects import DIALECTS
from chipbreak.dialects.base import NoseRules
from chipbreak.model.block_effect import Move
from chipbreak.settings import load
from chipbreak.text.diagnostics import RefusalError

from .planned import interpreted

RULES: dict[str, NoseRules] = {one.name: one.nose for one in DIALECTS if one.nose is not None}


@pytest.mark.parametrize(
    ("rapids", "first", "cuts"),
    [
        ("cc>c", 0, [(0, 2), (3, 4)]),
        ("cc>c", 1, [(1, 2), (3, 4)]),
        ("c>>cc", 0, [(0, 2), (3, 5)]),
        (">cc>", 0, [(1, 4)]),
        (">c>c>c>", 0, [(1, 2), (3, 4), (5, 7)]),
        (">>", 0, []),
        ("c", 0, [(0, 1)]),
        ("c", 1, []),
    ],
)
def test_cuts_with_the_rapids_behind_them(rapids: str, first: int, cuts: list[tuple[int, int]]) -> None:
    """But for the last of them, which leads to the next cut."""
    assert list(_cuts([one == ">" for one in rapids], first)) == cuts


def test_beside_a_place_is_on_its_left() -> None:
    assert _beside(Segment(Point(1.0, 2.0), Point(4.0, 6.0)), 5.0) == pytest.approx((-3.0, 5.0))
    arc = Segment(Point(0.0, 0.0), Point(3.0, 3.0), Point(0.0, 3.0), 1)
    assert _beside(arc, 0.5) == pytest.approx((0.0, 0.5))
    back = Segment(Point(3.0, 3.0), Point(0.0, 0.0), Point(0.0, 3.0), -1)
    assert _beside(back, 0.5) == pytest.approx((3.5, 3.0))


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_tip_is_the_radius_off_the_centre_along_both_axes(name: str, side: str) -> None:
    """In the axes in which the nose is on the left; on the right of the way the radius is turned over."""
    for tip, (z, x) in RULES[name].tips.items():
        offset = Offset(side, Nose(0.8, tip), RULES[name])
        assert offset.tip == (0.8 * z, 0.8 * x * (-1 if side == "right" else 1))
        assert {abs(z), abs(x)} <= {0, 1}
    words = load("fanuc-lathe").axis_words
    assert offset.frame(words) == Frame("Z", 1, -1 if side == "right" else 1)


def moves_of(*blocks: str) -> list[Move]:
    """The moves of blocks from X60 Z5."""
    read = interpreted("G21 G99\nG97 S900 M3\nG0 X60. Z5.\n" + "\n".join(blocks) + "\nM30\n")
    return [one.move for one in read.effects_of(3, 3 + len(blocks)) if one.move is not None]


@pytest.mark.parametrize(("radius_mm", "gets_in"), [(0.8, True), (0.99, True), (1.05, False)])
@pytest.mark.parametrize("x_way", [-1, 1])
def test_a_groove_of_two_millimetres(radius_mm: float, gets_in: bool, x_way: int) -> None:
    """A nose of 1 mm fits just so; in a shaft and in a bore."""
    places = [(30, 0), (30, -10), (24, -10), (24, -12), (30, -12), (30, -30)]
    cuts = [f"G1 X{x if x_way < 0 else 80 - x}. Z{z}. F0.1" for x, z in places]
    offset = Offset("right" if x_way < 0 else "left", Nose(radius_mm, 9), RULES["fanuc-lathe"])
    moves = moves_of("G0 X30. Z2." if x_way < 0 else "G0 X50. Z2.", *cuts)
    with nullcontext() if gets_in else pytest.raises(RefusalError) as caught:
        made = offset_moves(moves, offset, load("fanuc-lathe").axis_words)
    if gets_in:
        assert len(made) == len(moves)
        ends = [(motion.end.t, abs(motion.end.h)) for motions in made for motion in motions]
        floor = 12.0 + radius_mm if x_way < 0 else 28.0 - radius_mm
        assert (-10.0 - radius_mm, floor) in [pytest.approx(end) for end in ends]
    else:
        assert f"a nose of {radius_mm:g} mm does not get into all of this shape" in caught.value.message
