"""Comparison by what blocks say: what counts, what does not, and the shape of the result."""

from __future__ import annotations

import difflib
import re
from collections import Counter
from collections.abc import Sequence
from difflib import SequenceMatcher
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.editing import diff
from chipbreak.editing.diff import compare, differs, items_of
from chipbreak.editing.diff_items import Item
from chipbreak.editing.diff_output import as_json, page, side_by_side, unified
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import KEPT
from chipbreak.editing.render import render
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

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


BEFORE = b"""O0100
N100 #1=1
N110 G0 X50. Z2.
N120 G1 Z-10. F0.2
N130 IF[#1 GT 3]GOTO150
N140 #1=#1+1
N145 GOTO110
N150 G0 X100.
N160 M99 P100
"""
RENUMBERED = (
    (b"N160", b"n80"), (b"N150", b"n70"), (b"N145", b"n60"), (b"N140", b"n50"), (b"N130", b"n40"),
    (b"N120", b"n30"), (b"N110", b"n20"), (b"N100", b"n10"), (b"O150", b"O70"), (b"O110", b"O20"),
    (b"P100", b"P10"),
)  # fmt: skip


def renumbered(data: bytes) -> bytes:
    for old, new in RENUMBERED:
        data = data.replace(old, new)
    return data


def test_a_right_renumbering_is_no_difference() -> None:
    assert b"GOTO20" in renumbered(BEFORE)
    assert same(BEFORE, renumbered(BEFORE))
    assert same(renumbered(BEFORE), BEFORE)


@pytest.mark.parametrize(
    ("old", "new"),
    [(b"GOTO70", b"GOTO80"), (b"GOTO20", b"GOTO30"), (b"P10", b"P20"), (b"GOTO70", b"GOTO150")],
)
def test_a_number_that_names_another_block_is_a_difference(old: bytes, new: bytes) -> None:
    assert not same(BEFORE, renumbered(BEFORE).replace(old, new))


CYCLE = b"""G0 X60. Z2.
G71 U2. R0.5
G71 P40 Q75 U0.4 W0.1 F0.3
N40 G0 X20.
G1 Z-20. F0.1
N75 X60.
G70 P40 Q75
"""


@pytest.mark.parametrize(
    ("a", "b", "is_same"),
    [
        (b"GOTO20\nN20 G0 X5.\nN30 G0 X6.\n", b"GOTO20\nN10 G0 X5.\nN20 G0 X6.\n", False),
        (b"GOTO20\nN20\nG0 X5.\nG0 X6.\n", b"GOTO 7\nN07 G0 X5.\nG0 X6.\n", True),
        (b"N1 G0 X1.\nN1 G0 X2.\nGOTO1\n", b"G0 X1.\nN1 G0 X2.\nGOTO1\n", False),
        (b"GOTO1\nN1 G0 X1.\nN1 G0 X2.\n", b"GOTO1\nN1 G0 X1.\nG0 X2.\n", True),
        (CYCLE, CYCLE.replace(b"40", b"400").replace(b"75", b"750"), True),
        (CYCLE, CYCLE.replace(b"N40 G0 X20.\nG1", b"G0 X20.\nN40 G1"), False),
        (CYCLE, CYCLE.replace(b"P40", b"P41"), False),
        (b"M98 P8\nM30\nO8\nM99\n", b"M98 P8\nM30\nO9\nM99\n", False),
        (b"M97 P8\nM30\nN8 G0 X1.\nM99\n", b"M97 P9\nM30\nN9 G0 X1.\nM99\n", True),
        (b"M98 P1234\n", b"M98 P1235\n", False),
        (b"M98 P1234\n", b"M98 P01234\n", True),
        (b"N5 G0 X1.\nM30\nO8\nM99 P5\n", b"N6 G0 X1.\nM30\nO8\nM99 P6\n", True),
        (b"G10 L50\nN1320 P1 R500\nG11\n", b"G10 L50\nN1321 P1 R500\nG11\n", False),
        (b"G10 L51\nN1320 P1 R500\nG11\n", b"G10 L51\nN1321 P1 R500\nG11\n", False),
        (b"G10 L52\nN1320 P1 R500\nG11\n", b"G10 L52\nN1321 P1 R500\nG11\n", False),
        (b"G10 L2\nN1320 P1 X5.\nG11\n", b"G10 L2\nN1321 P1 X5.\nG11\n", True),
        (b"G10 L50\nN1320 P1 R500\nG11\nN1\nM30\n", b"G10L50\nN1320P1R500\nG11\nN2\nM30\n", True),
    ],
)
def test_numbers_that_name_blocks(a: bytes, b: bytes, is_same: bool) -> None:
    assert same(a, b) is is_same
    assert same(b, a) is is_same


def test_what_a_number_leads_to_is_shown() -> None:
    sides = [
        items_of(data, "x") for data in (b"GOTO20\nN20 G0 X5.\nG0 X6.\n", b"GOTO20\nG0 X5.\nN20 G0 X6.\n")
    ]
    hunks = compare(*sides)
    assert list(unified(hunks, "a", "b"))[3:5] == ["-GOTO20  [N20 is line 2]", "+GOTO20  [N20 is line 3]"]
    assert as_json(hunks)[0]["b"] == [{"line": 1, "text": "GOTO20", "note": "N20 is line 3"}]


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (b"N10 #1=1\n", b"N20 #1 = 1.\n"),
        (b"#2=#1+1\n", b"#2 = [ #1 + 1.0 ]\n"),
        (b"IF[#1EQ0]GOTO5\nN5 M30\n", b"IF [ #1 EQ 0. ] GOTO 05\nN5 M30\n"),
        (b"WHILE[#1LT3]DO1\nEND1\n", b"WHILE [#1 LT 3.] DO 1\nEND 1\n"),
        (b"o100 call [1]\n", b"O100 CALL [1.0]\n"),
        (b"G1 X[#1+2] F#3\n", b"G1 X[#1 + 2.] F#3\n"),
    ],
)
def test_macro_statements_count_by_what_they_say(a: bytes, b: bytes) -> None:
    assert same(a, b)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (b"#1=1\n", b"#1=2\n"),
        (b"#2=#1+1\n", b"#2=#1-1\n"),
        (b"G1 X[#1+2]\n", b"G1 X[#1+3]\n"),
        (b"#1=2 G1 X#1\n", b"G1 X#1 #1=2\n"),
        (b"IF[#1EQ0]THEN#2=1\n", b"IF[#1EQ0]THEN#2=3\n"),
        (b"o100 call [1]\nN100 M30\n", b"o200 call [1]\nN200 M30\n"),
        (b"WHILE[#1LT3]DO1\nEND1\nN1 M30\n", b"WHILE[#1LT3]DO2\nEND2\nN2 M30\n"),
    ],
)
def test_macro_statements_that_differ(a: bytes, b: bytes) -> None:
    assert not same(a, b)


@pytest.mark.parametrize(
    ("profile", "sets", "a", "b", "is_same"),
    [
        ("", (), b"G0 X50\n", b"G0 X50.\n", False),
        ("", (), b"G0 X0\n", b"G0 X0.\n", True),
        ("", (), b"G65 P500 S12 T3 M3\n", b"G65 P500. S12. T3. M03\n", True),
        ("", (), b"G4 P500\n", b"G04 P500.\n", False),
        ("fanuc-lathe", ('control.decimal_point="calculator"',), b"G0 X50\n", b"G0 X50.\n", True),
        ("fanuc-lathe", ('control.decimal_point="increment"',), b"G0 X50\n", b"G0 X50.\n", False),
        ("fanuc-lathe", ('control.decimal_point="increment"',), b"G0 X50000\n", b"G0 X50.\n", True),
        ("fanuc-lathe", ('control.decimal_point="increment"',), b"G20\nX50000\n", b"G20\nX5.\n", True),
        ("fanuc-lathe", ('control.decimal_point="required"',), b"G0 X50\n", b"G0 X50.\n", False),
        ("linuxcnc-mill", (), b"G0 X50\n", b"G0 X50.\n", True),
        ("fanuc-lathe", (), b"G98\nG1 X1. F200\n", b"G98\nG1 X1. F200.\n", True),
        ("fanuc-lathe", (), b"G99\nG1 X1. F2\n", b"G99\nG1 X1. F2.\n", False),
    ],
)
def test_numbers_are_read_as_the_control_reads_them(
    profile: str, sets: tuple[str, ...], a: bytes, b: bytes, is_same: bool
) -> None:
    settings = chipbreak.load(profile, sets) if profile else None
    sides = [items_of(data, "x", settings) for data in (a, b)]
    assert differs(compare(*sides)) is not is_same


@pytest.mark.parametrize(
    ("a", "b", "tolerance", "is_same"),
    [
        (b"G1 X1.\nX2.\n", b"G1 X1.001\nX2.\n", 0.001, True),
        (b"G1 X1.\nX2.\n", b"G1 X1.002\nX2.\n", 0.001, False),
        # 1.1 - 1.0 is a little more than 0.1 in binary digits.
        (b"G1 X1.\n", b"G1 X1.1\n", 0.1, True),
        (b"G1 X1. S100\n", b"G1 X1. S101\n", 5.0, False),
        (b"G1 X1. F.1\n", b"G2 X1. F.1\n", 5.0, False),
        (b"G1 X1.\nM8\nX2.\n", b"G1 X1.001\nX2.001\n", 0.01, False),
    ],
)
def test_a_tolerance(a: bytes, b: bytes, tolerance: float, is_same: bool) -> None:
    sides = [items_of(data, "x") for data in (a, b)]
    assert differs(compare(*sides, tolerance=tolerance)) is not is_same


def test_side_by_side_and_as_a_page() -> None:
    a = b"".join(b"G0 X%d.\n" % n for n in range(30))
    b = a.replace(b"X20.", b"X20.5 (<b>)").replace(b"G0 X25.\n", b"")
    hunks = compare(items_of(a, "a"), items_of(b, "b"))
    rows = list(side_by_side(hunks, "a.nc", "b.nc", 80))
    assert rows[1] == "..."
    assert rows[5] == f"{21:6} {'G0 X20.':30} | {21:6} G0 X20.5 (<b>)"
    assert f"{26:6} {'G0 X25.':30} <" in rows
    text = page(hunks, "a.nc", "b<.nc")
    assert "G0 X20.5 (&lt;b&gt;)" in text and "b&lt;.nc" in text and "2 places differ." in text
    assert not list(side_by_side(compare(items_of(a, "a"), items_of(a, "a")), "a", "a", 80))


def test_the_page_says_by_signs_what_it_says_by_colours() -> None:
    """On paper and to the colour-blind: what changed, what only one of the two has."""
    a = items_of(b"G0 X1.\nG0 X2.\nM8\nG0 X3.\n", "a")
    b = items_of(b"G0 X1.\nG0 X2.5\nG0 X3.\nM9\n", "b")
    text = page(compare(a, b), "a", "b")
    rows = re.findall(r'<tr class="([a-z-]+)">.*<td class="s">(.*?)</td>', text)
    signs = {"same": "", "change": "|", "only-a": "&lt;", "only-b": "&gt;"}
    assert {kind for kind, _ in rows} == set(signs)
    assert all(sign == signs[kind] for kind, sign in rows)
    assert '<meta name="viewport"' in text


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


def keys(items: Sequence[Item]) -> list[object]:
    return [item.key for item in items]


@given(_BLOCKS, _BLOCKS)
def test_the_changes_lead_from_one_to_the_other(a: list[bytes], b: list[bytes]) -> None:
    one, other = (items_of(b"\n".join(lines), "x") for lines in (a, b))
    hunks = compare(one, other)
    assert [item for hunk in hunks for item in hunk.a_items] == one
    assert [item for hunk in hunks for item in hunk.b_items] == other
    for hunk in hunks:
        assert hunk.tag != "equal" or keys(hunk.a_items) == keys(hunk.b_items)
    assert all(hunk.tag != behind.tag for hunk, behind in pairwise(hunks))
    assert differs(hunks) == (keys(one) != keys(other))
    assert bool(as_json(hunks)) == differs(hunks)


@given(_BLOCKS, _BLOCKS)
def test_the_unified_text_is_a_patch(a: list[bytes], b: list[bytes]) -> None:
    """Its counts are right, and it holds as little as difflib's own context allows."""
    one, other = (items_of(b"\n".join(lines), "x") for lines in (a, b))
    lines = list(unified(compare(one, other), "a", "b"))
    if not lines:
        assert keys(one) == keys(other)
        return
    assert lines[:2] == ["--- a", "+++ b"]
    olds = {item.line: item.text for item in one}
    news = {item.line: item.text for item in other}
    heads = [at for at, line in enumerate(lines) if line.startswith("@@")]
    assert heads[0] == 2
    for first, stop in pairwise([*heads, len(lines)]):
        hunk_is_right(lines[first], lines[first + 1 : stop], olds, news)
    first_letters = Counter(line[0] for line in lines[2:])
    assert len(one) - first_letters["-"] == len(other) - first_letters["+"]


def hunk_is_right(head: str, body: list[str], olds: dict[int, str], news: dict[int, str]) -> None:
    match = re.fullmatch(r"@@ -([0-9]+),([0-9]+) \+([0-9]+),([0-9]+) @@", head)
    assert match is not None, head
    old_first, old_count, new_first, new_count = map(int, match.groups())
    old = [line[1:] for line in body if line[0] in "- "]
    new = [line[1:] for line in body if line[0] in "+ "]
    assert (len(old), len(new)) == (old_count, new_count)
    assert not old or olds[old_first] == old[0]
    assert not new or news[new_first] == new[0]


@given(_BLOCKS, st.integers(0, 24), _BLOCKS)
def test_a_changed_stretch_is_not_larger_than_it_was(lines: list[bytes], at: int, new: list[bytes]) -> None:
    """As many blocks are taken for equal as difflib finds, up to what the anchors between them cost."""
    a = items_of(b"\n".join(lines), "x")
    b = items_of(b"\n".join(lines[:at] + new + lines[at:]), "x")
    kept = sum(len(h.a_items) for h in compare(a, b) if h.tag == "equal")
    keys = [i.key for i in a], [i.key for i in b]
    best = sum(m.size for m in difflib.SequenceMatcher(None, *keys, autojunk=False).get_matching_blocks())
    assert kept >= best / 2


@given(
    st.integers(0, 30),
    st.lists(
        st.tuples(st.integers(0, 30), st.sampled_from(["cut", "add", "change"])), min_size=1, max_size=4
    ),
)
def test_hunks_are_those_of_difflib(count: int, changes: list[tuple[int, str]]) -> None:
    """Each line says something else, so there is one way to go from one program to the other."""
    old = [f"G1 X{number}." for number in range(count)]
    new = list(old)
    for number, (place, change) in enumerate(changes):
        at = min(place, len(new))
        if change != "add":
            del new[at : at + 1]
        if change != "cut":
            new.insert(at, f"G1 Y{number}.")
    sides = [items_of("\n".join([*lines, ""]).encode(), "x") for lines in (old, new)]
    ours = list(unified(compare(*sides), "a", "b"))
    theirs = [line.rstrip("\n") for line in difflib.unified_diff(old, new, "a", "b", lineterm="")]
    # Ours say the number of lines also where it is one; the order inside of a change is free.
    wanted = [
        re.sub(r"(@@ |\+|-)(\d+)(?= )", r"\1\2,1", line) if line[:2] == "@@" else line for line in theirs
    ]
    assert [line for line in ours if line[:2] == "@@"] == [line for line in wanted if line[:2] == "@@"]
    assert Counter(ours) == Counter(wanted)


@given(st.lists(st.sampled_from("AB"), max_size=60), st.lists(st.sampled_from("AB"), max_size=60))
def test_programs_that_say_the_same_again_and_again_are_compared_window_by_window(
    a: list[str], b: list[str]
) -> None:
    """What is called equal is, nothing is left out or taken twice, and the ends are met."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diff, "_MOST_PAIRS", 20)
        patch.setattr(diff, "_WINDOW", 7)
        found = list(diff._aligned(a, b))
    starts = [(i1, j1) for _, i1, _, j1, _ in found] + [(len(a), len(b))]
    ends = [(0, 0)] + [(i2, j2) for _, _, i2, _, j2 in found]
    assert starts == ends
    for tag, i1, i2, j1, j2 in found:
        assert (i2 > i1 or j2 > j1) and (tag != "equal" or a[i1:i2] == b[j1:j2])


def test_hundreds_of_same_blocks_with_others_between_are_aligned(monkeypatch: pytest.MonkeyPatch) -> None:
    """difflib would go through all of them for each of them, for every difference."""
    sizes: list[int] = []

    def counted(
        junk: None, a: Sequence[object], b: Sequence[object], autojunk: bool
    ) -> SequenceMatcher[object]:
        sizes.append(max(len(a), len(b)))
        return SequenceMatcher(junk, a, b, autojunk)

    monkeypatch.setattr(diff, "SequenceMatcher", counted)
    sides = [items_of(f"M3\nG1 X{x}.\n".encode() * 500, "x") for x in (1, 2)]
    hunks = compare(*sides)
    assert Counter(one.tag for one in hunks) == {"equal": 500, "change": 500}
    assert max(sizes) <= 200


def test_side_by_side_shows_three_blocks_around_a_change_and_none_far_from_one() -> None:
    old = [f"G1 X{number}." for number in range(40)]
    new = [*old[:12], "G1 Y1.", *old[13:25], "G1 Y2.", *old[26:]]
    sides = [items_of("\n".join([*lines, ""]).encode(), "x") for lines in (old, new)]
    rows = list(side_by_side(compare(*sides), "a", "b", 80))
    shown = [number for number in range(40) if any(f"X{number}." in row for row in rows)]
    assert shown == [*range(9, 16), *range(22, 29)]


def with_change(data: bytes, line: int, *content: str) -> bytes:
    """The program with blocks between brackets before a line (from 0)."""
    edit = Edit(line, line, content, "TEST", "a reason", KEPT, "test")
    settings = chipbreak.load("generic-lathe")
    program = parse(read(data), settings.dialect)
    return b"".join(render(program, [edit], settings))


def test_a_jump_into_a_change_is_no_jump_behind_it() -> None:
    a = with_change(b"GOTO50\nG0 X1.\nN60 G0 X5.\nM30\n", 2, "G1 X2. F0.1", "N50 X3.")
    assert same(a, a)
    assert not same(a, a.replace(b"GOTO50", b"GOTO60"))


@pytest.mark.parametrize(("content", "shown"), [(["S900"], "1 block"), (["S900", "S800"], "2 blocks")])
def test_a_change_is_shown_by_its_title_and_how_many_blocks_it_has(content: list[str], shown: str) -> None:
    (item,) = items_of(with_change(b"", 0, *content), "x")
    assert item.text == f"[TEST: {shown}]"
