"""Numeric comparison of two programs, block by block.

Items that say the same are aligned; then every number that names a block must name aligned blocks, and what
is left is looked at once more with a tolerance for numbers.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Literal

from chipbreak.editing.diff_items import LENGTHS, Item, items_of

__all__ = ["Hunk", "Item", "compare", "differs", "items_of"]
Tag = Literal["equal", "change"]
_Stretch = tuple[Tag, int, int, int, int]
_MOST_PAIRS = 200_000  # of equal items that difflib goes through, for each stretch that it finds
_WINDOW = 200


@dataclass(frozen=True)
class Hunk:
    """Items ``a_items`` of the first program stand where ``b_items`` stand in the second; equal or not."""

    tag: Tag
    a_items: tuple[Item, ...]
    b_items: tuple[Item, ...]


def compare(a: Sequence[Item], b: Sequence[Item], *, tolerance: float = 0.0) -> list[Hunk]:
    """The two programs as alternating equal and changed stretches.

    Lengths and angles that differ by at most ``tolerance``, in program units, are the same.
    """
    if any(item.computes for item in (*a, *b)):
        # Somewhere a program goes to a block whose number it works out: then each number may be meant.
        a = [item.with_numbers() for item in a]
        b = [item.with_numbers() for item in b]
    return _compare(a, b, tolerance)


def _compare(a: Sequence[Item], b: Sequence[Item], tolerance: float) -> list[Hunk]:
    stretches = list(_stretches(a, b))
    if tolerance > 0.0:
        stretches = [near for one in stretches for near in _within(a, b, one, tolerance)]
    places = _places(stretches)
    hunks: list[_Growing] = []
    for tag, i1, i2, j1, j2 in stretches:
        if tag == "change":
            _add(hunks, tag, a[i1:i2], b[j1:j2])
            continue
        for i, j in zip(range(i1, i2), range(j1, j2), strict=True):
            if _leads_alike(a[i], b[j], places):
                _add(hunks, "equal", a[i : i + 1], b[j : j + 1])
            else:
                _add(hunks, "change", [a[i].with_note(a)], [b[j].with_note(b)])
    return [Hunk(tag, tuple(a_items), tuple(b_items)) for tag, a_items, b_items in hunks]


def _add(hunks: list[_Growing], tag: Tag, a: Sequence[Item], b: Sequence[Item]) -> None:
    if not a and not b:
        return
    if not hunks or hunks[-1][0] != tag:
        hunks.append((tag, [], []))
    hunks[-1][1].extend(a)
    hunks[-1][2].extend(b)


# A hunk while its items are gathered.
_Growing = tuple[Tag, list[Item], list[Item]]
# Where an item of the first or the second program stands: which stretch, how far from its start and its end.
_Place = tuple[int, int, int]


def _places(stretches: Sequence[_Stretch]) -> tuple[Mapping[int, _Place], Mapping[int, _Place]]:
    """Where the items of both programs stand, so that the places of two items can be compared."""
    sides: tuple[dict[int, _Place], dict[int, _Place]] = ({}, {})
    for number, (_, i1, i2, j1, j2) in enumerate(stretches):
        for side, first, stop in ((sides[0], i1, i2), (sides[1], j1, j2)):
            side.update((at, (number, at - first, stop - at)) for at in range(first, stop))
    return sides


def _leads_alike(one: Item, other: Item, places: tuple[Mapping[int, _Place], Mapping[int, _Place]]) -> bool:
    """True when the numbers of two equal items name blocks that stand at the same place of both programs."""
    for mine, its in zip(one.references, other.references, strict=True):
        if mine.target is None or its.target is None:
            if mine.target is not its.target or mine.text != its.text:
                return False
            continue
        place = places[0][mine.target]
        its_place = places[1][its.target]
        same_end = place[1] == its_place[1] or place[2] == its_place[2]
        if place[0] != its_place[0] or not same_end:
            return False
    return True


def _within(a: Sequence[Item], b: Sequence[Item], stretch: _Stretch, tolerance: float) -> Iterator[_Stretch]:
    """A changed stretch, less the items whose numbers differ by no more than the tolerance."""
    tag, i1, i2, j1, j2 = stretch
    if tag == "equal":
        yield stretch
        return
    shapes_a = [_shape(item.key) for item in a[i1:i2]]
    shapes_b = [_shape(item.key) for item in b[j1:j2]]
    for kind, i, i_stop, j, j_stop in _aligned(shapes_a, shapes_b):
        if kind != "equal":
            yield "change", i1 + i, i1 + i_stop, j1 + j, j1 + j_stop
            continue
        for at_a, at_b in zip(range(i1 + i, i1 + i_stop), range(j1 + j, j1 + j_stop), strict=True):
            near = _is_near(a[at_a].key, b[at_b].key, tolerance)
            yield ("equal" if near else "change"), at_a, at_a + 1, at_b, at_b + 1


def _shape(key: Hashable) -> Hashable:
    """A key without its numbers of dimensions."""
    if isinstance(key, tuple):
        return tuple(map(_shape, key))
    return None if isinstance(key, float) else key


def _is_near(one: Hashable, other: Hashable, tolerance: float) -> bool:
    """True when two keys of one shape differ in dimensions by no more than the tolerance."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        if len(one) == 2 and isinstance(one[1], float) and isinstance(other[1], float):
            allowed = tolerance if one[0] in LENGTHS else 0.0
            return abs(one[1] - other[1]) <= allowed * (1.0 + 1e-9)
        return all(_is_near(x, y, tolerance) for x, y in zip(one, other, strict=True))
    return one == other


def _stretches(a: Sequence[Item], b: Sequence[Item]) -> Iterator[tuple[Tag, int, int, int, int]]:
    """Between blocks that are unique in both programs (few gaps, all short), difflib decides."""
    i = j = 0
    for anchor_i, anchor_j in [*_anchors(a, b), (len(a), len(b))]:
        yield from _gap(a, b, (i, anchor_i), (j, anchor_j))
        if anchor_i < len(a):
            yield "equal", anchor_i, anchor_i + 1, anchor_j, anchor_j + 1
        i = anchor_i + 1
        j = anchor_j + 1


def _gap(
    a: Sequence[Item], b: Sequence[Item], i: tuple[int, int], j: tuple[int, int]
) -> Iterator[tuple[Tag, int, int, int, int]]:
    keys_a = [x.key for x in a[slice(*i)]]
    keys_b = [x.key for x in b[slice(*j)]]
    if not keys_a or not keys_b:
        yield "change", *i, *j
        return
    for tag, i1, i2, j1, j2 in _aligned(keys_a, keys_b):
        yield tag, i[0] + i1, i[0] + i2, j[0] + j1, j[0] + j2


def _aligned(a: Sequence[Hashable], b: Sequence[Hashable]) -> Iterator[_Stretch]:
    """What of two sequences is equal, and what stands between.

    Where the same items come again and again, so that difflib would take hours, it sees a window of both at
    a time: the next one begins behind the last equal items of this one.
    """
    count_b = Counter(b)
    if sum(count_b[key] for key in a) <= _MOST_PAIRS:
        yield from _by_difflib(a, b)
        return
    i = j = 0
    while i < len(a) or j < len(b):
        found = list(_by_difflib(a[i : i + _WINDOW], b[j : j + _WINDOW]))
        if len(found) > 1 and found[-1][0] != "equal":
            found.pop()
        for tag, i1, i2, j1, j2 in found:
            yield tag, i + i1, i + i2, j + j1, j + j2
        *_, i_seen, _, j_seen = found[-1]
        i += i_seen
        j += j_seen


def _by_difflib(a: Sequence[Hashable], b: Sequence[Hashable]) -> Iterator[_Stretch]:
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, a, b, autojunk=False).get_opcodes():
        yield ("equal" if tag == "equal" else "change"), i1, i2, j1, j2


def _anchors(a: Sequence[Item], b: Sequence[Item]) -> list[tuple[int, int]]:
    """Pairs of equal items that occur once in each program, as many as keep their order."""
    count_a = Counter(x.key for x in a)
    count_b = Counter(x.key for x in b)
    where_b = {x.key: j for j, x in enumerate(b) if count_b[x.key] == 1}
    pairs = [(i, where_b[x.key]) for i, x in enumerate(a) if count_a[x.key] == 1 and x.key in where_b]
    tails: list[int] = []
    back: list[int] = []
    at_tail: list[int] = []
    for index, (_, j) in enumerate(pairs):
        place = bisect_left(tails, j)
        back.append(at_tail[place - 1] if place else -1)
        if place == len(tails):
            tails.append(j)
            at_tail.append(index)
        else:
            tails[place] = j
            at_tail[place] = index
    chosen = []
    index = at_tail[-1] if at_tail else -1
    while index >= 0:
        chosen.append(pairs[index])
        index = back[index]
    return chosen[::-1]


def differs(hunks: Sequence[Hunk]) -> bool:
    """True when anything is changed."""
    return any(h.tag == "change" for h in hunks)
