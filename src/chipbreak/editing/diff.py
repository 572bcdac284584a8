"""Numeric comparison of two programs, block by block.

Block numbers, spacing and the way numbers are written do not count; comments count unless told otherwise.
A part that chipbreak wrote is one item.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any, Literal

from chipbreak.editing.restore import regions
from chipbreak.syntax.nodes import Block
from chipbreak.syntax.parse import Program, parse
from chipbreak.text.source import read

_CONTEXT = 3
Tag = Literal["equal", "change"]


@dataclass(frozen=True)
class Item:
    """A block, or a whole part that chipbreak wrote: its key, its text, its line (from 1)."""

    key: Hashable
    text: str
    line: int


@dataclass(frozen=True)
class Hunk:
    """Items ``a_items`` of the first program stand where ``b_items`` stand in the second; equal or not."""

    tag: Tag
    a_items: tuple[Item, ...]
    b_items: tuple[Item, ...]


# What stands in both programs, only in the first, or only in the second.
_Pair = tuple[Item | None, Item | None]


def items_of(data: bytes, name: str, *, ignore_comments: bool = False) -> list[Item]:
    """The comparable items of a program.  Raises ProgramRejectedError for a broken bracket."""
    source = read(data, name)
    program = parse(source)
    items: list[Item] = []
    line = 0
    for region in regions(source):
        items.extend(_block_items(program, line, region.first, ignore_comments))
        moves = region.last - region.body - 1
        text = f"[{region.title}: {moves} block{'s' if moves != 1 else ''}]"
        content = bytes(source.data[source.starts[region.body] : source.starts[region.last]])
        items.append(Item(("part", content), text, region.first + 1))
        line = region.last
    items.extend(_block_items(program, line, source.line_count, ignore_comments))
    return items


def _block_items(program: Program, first: int, last: int, ignore_comments: bool) -> Iterator[Item]:
    for line in range(first, last):
        block = program.block(line)
        key = _key(block, ignore_comments)
        if key:
            yield Item(key, block.text, line + 1)


def _key(block: Block, ignore_comments: bool) -> Hashable:
    """Equal for blocks that say the same; empty for one that says nothing."""
    if block.opaque or block.mark or block.assignments or block.controls:
        return " ".join(block.text.split())
    words = tuple(
        (w.address if w.letter != "f" else "f", w.value_text if w.number is None else w.number)
        for w in block.words
    )
    comments = () if ignore_comments else tuple(c.text.strip() for c in block.comments)
    return (block.skip, words, comments) if words or any(comments) else ()


def compare(a: Sequence[Item], b: Sequence[Item]) -> list[Hunk]:
    """The two programs as alternating equal and changed stretches."""
    hunks: list[Hunk] = []

    def add(tag: Tag, i1: int, i2: int, j1: int, j2: int) -> None:
        if i1 == i2 and j1 == j2:
            return
        if hunks and hunks[-1].tag == tag:
            last = hunks.pop()
            hunks.append(Hunk(tag, last.a_items + tuple(a[i1:i2]), last.b_items + tuple(b[j1:j2])))
        else:
            hunks.append(Hunk(tag, tuple(a[i1:i2]), tuple(b[j1:j2])))

    for tag, i1, i2, j1, j2 in _stretches(a, b):
        add(tag, i1, i2, j1, j2)
    return hunks


def _stretches(a: Sequence[Item], b: Sequence[Item]) -> Iterator[tuple[Tag, int, int, int, int]]:
    """Between blocks that are unique in both programs (few gaps, all short), difflib decides."""
    i = j = 0
    for anchor_i, anchor_j in [*_anchors(a, b), (len(a), len(b))]:
        yield from _gap(a, b, (i, anchor_i), (j, anchor_j))
        if anchor_i < len(a):
            yield "equal", anchor_i, anchor_i + 1, anchor_j, anchor_j + 1
        i, j = anchor_i + 1, anchor_j + 1


def _gap(
    a: Sequence[Item], b: Sequence[Item], i: tuple[int, int], j: tuple[int, int]
) -> Iterator[tuple[Tag, int, int, int, int]]:
    keys_a, keys_b = [x.key for x in a[slice(*i)]], [x.key for x in b[slice(*j)]]
    if not keys_a or not keys_b:
        yield "change", *i, *j
        return
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, keys_a, keys_b, autojunk=False).get_opcodes():
        kind: Tag = "equal" if tag == "equal" else "change"
        yield kind, i[0] + i1, i[0] + i2, j[0] + j1, j[0] + j2


def _anchors(a: Sequence[Item], b: Sequence[Item]) -> list[tuple[int, int]]:
    """Pairs of equal items that occur once in each program, as many as keep their order."""
    count_a, count_b = Counter(x.key for x in a), Counter(x.key for x in b)
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
            tails[place], at_tail[place] = j, index
    chosen = []
    index = at_tail[-1] if at_tail else -1
    while index >= 0:
        chosen.append(pairs[index])
        index = back[index]
    return chosen[::-1]


def differs(hunks: Sequence[Hunk]) -> bool:
    """True when anything is changed."""
    return any(h.tag == "change" for h in hunks)


def unified(hunks: Sequence[Hunk], name_a: str, name_b: str) -> Iterator[str]:
    """The changes with their surroundings, as ``diff -u`` writes them."""
    if not differs(hunks):
        return
    yield f"--- {name_a}"
    yield f"+++ {name_b}"
    group: list[_Pair] = []
    for index, hunk in enumerate(hunks):
        if hunk.tag == "change":
            group += [(item, None) for item in hunk.a_items] + [(None, item) for item in hunk.b_items]
            continue
        pairs: list[_Pair] = list(zip(hunk.a_items, hunk.b_items, strict=True))
        is_last = index == len(hunks) - 1
        if group and (is_last or len(pairs) > 2 * _CONTEXT):
            yield from _print_group(group + pairs[:_CONTEXT])
            group = []
        if not group and not is_last:
            group = pairs[-_CONTEXT:]
        elif not is_last:
            group += pairs
    if any(None in pair for pair in group):
        yield from _print_group(group)


def _print_group(group: Sequence[_Pair]) -> Iterator[str]:
    a = [item.line for item, _ in group if item is not None]
    b = [item.line for _, item in group if item is not None]
    yield f"@@ -{a[0] if a else 0},{len(a)} +{b[0] if b else 0},{len(b)} @@"
    for one, other in group:
        if one is not None:
            yield (" " if other is not None else "-") + one.text
        elif other is not None:
            yield "+" + other.text


def as_json(hunks: Sequence[Hunk]) -> list[dict[str, Any]]:
    """The changes for a program to read."""

    def side(items: Sequence[Item]) -> list[dict[str, Any]]:
        return [{"line": item.line, "text": item.text} for item in items]

    return [{"a": side(h.a_items), "b": side(h.b_items)} for h in hunks if h.tag == "change"]
