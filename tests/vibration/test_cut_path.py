"""Which feed move leads back over what has just been cut."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.model.block_effect import Move
from chipbreak.model.modal import Position
from chipbreak.vibration.cut_path import CutPath

Place = tuple[float, float]
PLACES = st.lists(st.tuples(st.sampled_from([0.0, 1.0, 2.0, 5.0]), st.sampled_from([0.0, 1.0])), max_size=40)


def backs(places: list[Place], path: CutPath | None = None) -> list[bool]:
    path = path or CutPath()
    found = []
    at = Position(0.0, 0.0, 0.0)
    for x, z in places:
        end = Position(x, float("nan"), z)
        found.append(path.is_way_back(Move("line", at, end, "XZ", incremental=False)))
        at = end
    return found


def is_between(point: Place, one: Place, other: Place) -> bool:
    across = (other[0] - one[0]) * (point[1] - one[1]) - (other[1] - one[1]) * (point[0] - one[0])
    inside = all(min(a, b) <= p <= max(a, b) for p, a, b in zip(point, one, other, strict=True))
    return across == 0.0 and inside


def all_that_was_cut(places: list[Place]) -> list[bool]:
    """The same with every corner kept, in whole numbers."""
    corners: list[Place] = [(0.0, 0.0)]
    found = []
    for end in places:
        at = len(corners) - 1 if corners[-1] != end else 0
        while at > 0 and not is_between(end, corners[at], corners[at - 1]):
            at = at - 1 if is_between(corners[at - 1], corners[at], end) else 0
        found.append(at > 0)
        corners = [*corners[:at], end] if at > 0 else [*corners, end]
    return found


@given(PLACES)
def test_a_way_back_leads_over_what_was_cut(places: list[Place]) -> None:
    assert backs(places) == all_that_was_cut(places)


@pytest.mark.parametrize("repeated", [[(0.0, 9.0), (0.0, 0.0)], [(0.0, -1.0), (0.0, 9.0)], [(0.0, 0.0)]])
def test_a_long_way_is_followed_in_a_time_that_grows_with_it(repeated: list[Place]) -> None:
    there = [(0.0, place / 100.0) for place in range(901)]
    path = CutPath()
    backs([*there, *repeated * 3], path)
    assert len(path.corners) < 910
    backs([*repeated * 1000], path)
    assert len(path.corners) < 10
