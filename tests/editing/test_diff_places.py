"""Where blocks that a number names stand on both sides, and which blocks are taken for the same."""

from __future__ import annotations

from difflib import SequenceMatcher
from itertools import combinations, pairwise, product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.editing import diff
from chipbreak.editing.diff import compare, items_of
from chipbreak.editing.diff_items import Item

Lines = tuple[str, list[int], list[int]]


def lines_of(a: str, b: str, tolerance: float = 0.0) -> list[Lines]:
    """The hunks of two programs, whose lines are separated by ``;``: kind and line numbers of both."""
    sides = [items_of(text.replace(";", "\n").encode(), "x") for text in (a, b)]
    hunks = compare(*sides, tolerance=tolerance)
    return [(hunk.tag, [x.line for x in hunk.a_items], [x.line for x in hunk.b_items]) for hunk in hunks]


def is_first_equal(a: str, b: str) -> bool:
    """Whether the first blocks of two programs say the same; asked in both directions."""
    found = [lines_of(*sides)[0][0] == "equal" for sides in ((a, b), (b, a))]
    assert found[0] == found[1]
    return found[0]


def jump_among(letter: str, count: int, at: int) -> str:
    """A jump to one of some blocks that have a letter."""
    blocks = [f"{'N20 ' if number == at else ''}{letter}{number}." for number in range(count)]
    return ";".join(["GOTO20", "M8", *blocks, "M9", "M30"])


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_block_among_changed_ones_is_found_again_from_their_start_or_from_their_end(count: int) -> None:
    for other_count in range(1, 5):
        for at, other_at in product(range(count), range(other_count)):
            is_there = at == other_at or count - at == other_count - other_at
            sides = jump_among("X", count, at), jump_among("Z", other_count, other_at)
            assert is_first_equal(*sides) is is_there, sides


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        # What comes before does not count.
        ("GOTO20;X1.;N20 X2.;M30", "GOTO20;M8;X1.;N20 X2.;M30", True),
        ("GOTO20;M8;M9;X1.;N20 X2.;M30", "GOTO20;X1.;N20 X2.;M30", True),
        # As far into another stretch is another block.
        ("GOTO20;X1.;N20 X2.;M8;X3.;X4.;M30", "GOTO20;Z1.;Z2.;M8;Z3.;N20 Z4.;M30", False),
        ("GOTO20;N20 X1.;M8;X3.;M30", "GOTO20;X1.;N20 M8;X3.;M30", False),
        ("GOTO20;N20 M8;X1.;M30", "GOTO20;M8;N20 Z1.;M30", False),
    ],
)
def test_a_jump_goes_where_it_went(a: str, b: str, is_same: bool) -> None:
    assert is_first_equal(a, b) is is_same


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        # Neither P nor Q is there: their numbers count; what one has counts, behind what both have not.
        ("G71 P10 Q20;X1.;X2.", "G71 P10 Q20;X1.;X2.", True),
        ("G71 P10 Q20;X1.;X2.", "G71 P11 Q20;X1.;X2.", False),
        ("G71 P10 Q20;X1.;X2.", "G71 P10 Q21;X1.;X2.", False),
        ("G71 P10 Q20;X1.;N20 X2.", "G71 P10 Q20;X1.;N20 X2.", True),
        ("G71 P10 Q20;X1.;N20 X2.", "G71 P10 Q21;X1.;N21 X2.", True),
        ("G71 P10 Q20;X1.;N20 X2.", "G71 P10 Q20;N20 X1.;X2.", False),
        ("G71 P10 Q20;X1.;N20 X2.", "G71 P10 Q20;X1.;X2.", False),
        ("G71 P10 Q20;N10 X1.;N20 X2.", "G71 P10 Q20;X1.;N20 X2.", False),
        ("G71 P10 Q20;N10 X1.;N20 X2.", "G71 P2 Q1;N2 X1.;N1 X2.", True),
        ("G71 P10 Q20;N10 X1.;N20 X2.", "G71 P10 Q20;N20 X1.;N10 X2.", False),
    ],
)
def test_each_number_of_a_cycle_counts_by_itself(a: str, b: str, is_same: bool) -> None:
    assert is_first_equal(a, b) is is_same


def test_a_jump_that_changed_is_a_change_between_equal_blocks() -> None:
    assert lines_of("M8;GOTO20;X1.;N20 X2.;M30", "M8;GOTO20;N20 X1.;X2.;M30") == [
        ("equal", [1], [1]),
        ("change", [2], [2]),
        ("equal", [3, 4, 5], [3, 4, 5]),
    ]


@pytest.mark.parametrize(
    ("a", "b", "hunks"),
    [
        # Between blocks that are near are others that are not, on one side or on both.
        (
            "M8;S1;X1.;S2;Y1.;M30",
            "M8;X1.001;M3;Y1.001;M30",
            [
                ("equal", [1], [1]),
                ("change", [2], []),
                ("equal", [3], [2]),
                ("change", [4], [3]),
                ("equal", [5, 6], [4, 5]),
            ],
        ),
        (
            "M8;X1.;Y1.;M30",
            "M8;S1;X1.001;Y2.;M30",
            [
                ("equal", [1], [1]),
                ("change", [], [2]),
                ("equal", [2], [3]),
                ("change", [3], [4]),
                ("equal", [4], [5]),
            ],
        ),
        # The second of two stretches.
        (
            "X1.;M8;X2.;M9;X3.",
            "X1.5;M8;X2.005;M9;X3.005",
            [("change", [1], [1]), ("equal", [2, 3, 4, 5], [2, 3, 4, 5])],
        ),
    ],
)  # fmt: skip
def test_blocks_within_a_tolerance_are_equal_where_they_stand(a: str, b: str, hunks: list[Lines]) -> None:
    assert lines_of(a, b, 0.01) == hunks


def test_without_a_tolerance_a_changed_stretch_is_one() -> None:
    """With one, blocks of one shape in it are held against each other, and a jump goes by them."""
    a = "GOTO20;X1.;N20 Y1.;Z1.;Z2.;M30"
    b = "GOTO20;N20 Y2.;A2.;M30"
    assert not is_first_equal(a, b)
    assert [tag for tag, *_ in lines_of(a, b, 0.1)] == ["equal", "change", "equal"]
    assert [tag for tag, *_ in lines_of(a, b, 1.0)] == ["equal", "change", "equal", "change", "equal"]


@pytest.mark.parametrize("tolerance", [0.25, 0.5, 3.0])
def test_a_tolerance_is_the_largest_difference_that_counts_as_none(tolerance: float) -> None:
    for off, tag in ((tolerance, "equal"), (tolerance * (1.0 + 1e-6), "change")):
        for sign in (1.0, -1.0):
            assert lines_of("X10.", f"X{10.0 + sign * off:.9f}", tolerance)[0][0] == tag


def longest(pairs: list[tuple[int, int]]) -> int:
    """Of how many pairs, all of them tried, both numbers rise."""
    for count in range(len(pairs), 0, -1):
        for some in combinations(pairs, count):
            if all(one[1] < other[1] for one, other in pairwise(some)):
                return count
    return 0


@given(st.permutations(range(6)), st.lists(st.integers(0, 8), max_size=3))
def test_anchors_are_as_many_unique_blocks_as_keep_their_order(order: list[int], more: list[int]) -> None:
    a = [Item(key, str(key), 1) for key in [*range(6), *more]]
    b = [Item(key, str(key), 1) for key in [*order, 7]]
    found = diff._anchors(a, b)
    assert all(one[0] < other[0] and one[1] < other[1] for one, other in pairwise(found))
    unique = [key for key in range(9) if [x.key for x in a].count(key) == [x.key for x in b].count(key) == 1]
    places = sorted(
        (next(i for i, x in enumerate(a) if x.key == key), [x.key for x in b].index(key)) for key in unique
    )
    assert set(found) <= set(places)
    assert len(found) == longest(places)


def pairs_of(a: str, b: str, i: int = 0, j: int = 0) -> list[tuple[int, int]]:
    """Which items difflib takes for the same."""
    blocks = SequenceMatcher(None, a, b, autojunk=False).get_matching_blocks()
    return [(i + one.a + k, j + one.b + k) for one in blocks for k in range(one.size)]


def pairs_by_windows(a: str, b: str, window: int) -> list[tuple[int, int]]:
    """Which items windows of both take for the same, each behind the last that the one before took."""
    found: list[tuple[int, int]] = []
    i = j = 0
    while i < len(a) and j < len(b):
        some = pairs_of(a[i : i + window], b[j : j + window], i, j)
        found += some
        i, j = (some[-1][0] + 1, some[-1][1] + 1) if some else (i + window, j + window)
    return found


@given(st.text("ABC", max_size=24), st.text("ABC", max_size=24), st.integers(1, 7))
def test_windows_begin_behind_the_last_equal_items(a: str, b: str, window: int) -> None:
    pairs = sum(b.count(item) for item in a)
    for most in (pairs, pairs - 1):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(diff, "_MOST_PAIRS", most)
            patch.setattr(diff, "_WINDOW", window)
            found = list(diff._aligned(a, b))
        same = [
            pair
            for tag, i1, i2, j1, j2 in found
            if tag == "equal"
            for pair in zip(range(i1, i2), range(j1, j2), strict=True)
        ]
        assert same == (pairs_of(a, b) if most == pairs else pairs_by_windows(a, b, window))
