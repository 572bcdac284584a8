"""Comparison by what blocks say: what counts, what does not, and the shape of the result."""

from __future__ import annotations

import difflib
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.editing.diff import as_json, compare, differs, items_of, unified

CUT = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nG1 X30.\nM30\n"


def same(a: bytes, b: bytes, *, ignore_comments: bool = False) -> bool:
    sides = [items_of(data, "x", ignore_comments=ignore_comments) for data in (a, b)]
    return not differs(compare(*sides))


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (b"N10 G1 X1.0\nN20 Z2.\n", b"G1 X1.\nN5 Z2.\n"),
        (b"G01 X+1.50\n", b"g1x1.5\n"),
        (b"G1 X.5\r\n", b"G1 X0.500\n"),
        (b"G0 X1.\n\n\nG0 X2.\n", b"G0 X1.\nG0 X2."),
        (b"N10\nG0 X1.\n", b"G0 X1.\n"),
        (b"G1 X1. (note)\n", b"G1 X1. ( note )\n"),
        (b"IF [#1 EQ 2] GOTO 10\n", b"IF  [#1 EQ 2]  GOTO 10\n"),
    ],
)
def test_what_does_not_count(a: bytes, b: bytes) -> None:
    assert same(a, b)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (b"G1 X1.\n", b"G1 X1.001\n"),
        (b"G1 X1.\n", b"G0 X1.\n"),
        (b"G1 X1. Z2.\n", b"G1 Z2. X1.\n"),
        (b"/G1 X1.\n", b"G1 X1.\n"),
        (b"/2 G1 X1.\n", b"/3 G1 X1.\n"),
        (b"G1 X#1\n", b"G1 X#2\n"),
        (b"G1 X1. F0.1 f50\n", b"G1 X1. F0.1 F50\n"),
        (b"(ONE)\n", b"(TWO)\n"),
        (b"#1=2\n", b"#1=3\n"),
        (b"?!\n", b"?!?\n"),
        (b"%\nM30\n", b"M30\n"),
        (b"G0 X1.\nG0 X1.\n", b"G0 X1.\n"),
    ],
)
def test_what_counts(a: bytes, b: bytes) -> None:
    assert not same(a, b)
    assert not same(b, a)


def test_comments_on_demand() -> None:
    assert same(b"(A)\nG1 X1. (B)\n;C\n", b"G1 X1.\n", ignore_comments=True)


def test_an_expanded_chain_is_one_line() -> None:
    out = chipbreak.rewrite(CUT, chipbreak.load("generic-lathe")).data
    items = items_of(out, "x")
    assert len(out.splitlines()) > 200
    assert [item.text for item in items if item.text.startswith("[VIB")] == [items[2].text]
    assert re.fullmatch(r"\[VIB N1.5 F62.5 S2500 STROKE 0.06: [0-9]+ blocks\]", items[2].text)
    assert len(items) == 6
    changed = out.replace(b"Z1.967", b"Z1.966", 1)
    with pytest.raises(chipbreak.ProgramRejectedError):
        items_of(changed, "x")


_BLOCKS = st.lists(
    st.sampled_from([b"G0 X1.", b"G1 Z2. F.1", b"G1 Z3.", b"M8", b"(a)", b"M9", b"X5.", b"?"]), max_size=25
)


@given(_BLOCKS, _BLOCKS)
def test_the_changes_lead_from_one_to_the_other(a: list[bytes], b: list[bytes]) -> None:
    one, other = (items_of(b"\n".join(lines), "x") for lines in (a, b))
    hunks = compare(one, other)
    assert [item for hunk in hunks for item in hunk.a_items] == one
    assert [item for hunk in hunks for item in hunk.b_items] == other
    for hunk in hunks:
        if hunk.tag == "equal":
            assert [i.key for i in hunk.a_items] == [i.key for i in hunk.b_items]
    assert [h.tag for h in hunks] == [
        h.tag for i, h in enumerate(hunks) if not i or hunks[i - 1].tag != h.tag
    ]
    assert differs(hunks) == ([i.key for i in one] != [i.key for i in other])
    assert bool(as_json(hunks)) == differs(hunks)


@given(_BLOCKS, _BLOCKS)
def test_the_unified_text_is_a_patch(a: list[bytes], b: list[bytes]) -> None:
    """Its counts are right, and it holds as little as difflib's own context allows."""
    one, other = (items_of(b"\n".join(lines), "x") for lines in (a, b))
    lines = list(unified(compare(one, other), "a", "b"))
    if not lines:
        assert [i.key for i in one] == [i.key for i in other]
        return
    assert lines[:2] == ["--- a", "+++ b"]
    olds = {item.line: item.text for item in one}
    news = {item.line: item.text for item in other}
    removed = added = 0
    at = 2
    while at < len(lines):
        head = re.fullmatch(r"@@ -([0-9]+),([0-9]+) \+([0-9]+),([0-9]+) @@", lines[at])
        assert head is not None, lines[at]
        old_first, old_count, new_first, new_count = map(int, head.groups())
        body = []
        at += 1
        while at < len(lines) and not lines[at].startswith("@@"):
            body.append(lines[at])
            at += 1
        old = [line[1:] for line in body if line[0] in "- "]
        new = [line[1:] for line in body if line[0] in "+ "]
        assert (len(old), len(new)) == (old_count, new_count)
        assert not old or olds[old_first] == old[0]
        assert not new or news[new_first] == new[0]
        removed += sum(line[0] == "-" for line in body)
        added += sum(line[0] == "+" for line in body)
    assert len(one) - removed == len(other) - added


@given(_BLOCKS, st.integers(0, 24), _BLOCKS)
def test_a_changed_stretch_is_not_larger_than_it_was(lines: list[bytes], at: int, new: list[bytes]) -> None:
    """As many blocks are taken for equal as difflib finds, up to what the anchors between them cost."""
    a = items_of(b"\n".join(lines), "x")
    b = items_of(b"\n".join(lines[:at] + new + lines[at:]), "x")
    kept = sum(len(h.a_items) for h in compare(a, b) if h.tag == "equal")
    keys = [i.key for i in a], [i.key for i in b]
    best = sum(m.size for m in difflib.SequenceMatcher(None, *keys, autojunk=False).get_matching_blocks())
    assert kept >= best / 2
