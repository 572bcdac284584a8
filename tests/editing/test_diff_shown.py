"""What a reader sees of a comparison, line by line: as a patch, side by side, as a page, as JSON."""

from __future__ import annotations

import pytest

from chipbreak.editing.diff import compare, items_of
from chipbreak.editing.diff_items import Item
from chipbreak.editing.diff_output import as_json, page, side_by_side, unified

A = b"""%
GOTO20
G1 Z-5. F0.2
N20 X50.
M8
X40.
X41.
X42.
X43.
X44.
X45.
X46.
X47.
X48.
T0202\t(TOOL <2>)
M30
%
"""
B = b"""%
GOTO20
N20 G1 Z-5. F0.2
X50.
M8
(\x1b[31m)
X41.
X42.
X43.
X44.
X45.
X46.
X47.
X48.
T0303\t(TOOL <2>)
M9
M30
%
"""


def sides(a: bytes = A, b: bytes = B) -> tuple[list[Item], list[Item]]:
    return items_of(a, "a"), items_of(b, "b")


def test_as_a_patch() -> None:
    assert list(unified(compare(*sides()), "a.nc", "b\a.nc")) == [
        "--- a.nc",
        r"+++ b\x07.nc",
        "@@ -1,9 +1,9 @@",
        " %",
        "-GOTO20  [N20 is line 4]",
        "+GOTO20  [N20 is line 3]",
        " G1 Z-5. F0.2",
        " N20 X50.",
        " M8",
        "-X40.",
        r"+(\x1b[31m)",
        " X41.",
        " X42.",
        " X43.",
        "@@ -12,6 +12,7 @@",
        " X46.",
        " X47.",
        " X48.",
        "-T0202 (TOOL <2>)",
        "+T0303 (TOOL <2>)",
        "+M9",
        " M30",
        " %",
    ]


def test_side_by_side() -> None:
    assert list(side_by_side(compare(*sides()), "a.nc", "b\a.nc", 81)) == [
        rf"       {'a.nc':31}          b\x07.nc",
        f"     1 {'%':31}        1 %",
        f"     2 {'GOTO20  [N20 is line 4]':31} |      2 GOTO20  [N20 is line 3]",
        f"     3 {'G1 Z-5. F0.2':31}        3 N20 G1 Z-5. F0.2",
        f"     4 {'N20 X50.':31}        4 X50.",
        f"     5 {'M8':31}        5 M8",
        rf"     6 {'X40.':31} |      6 (\x1b[31m)",
        f"     7 {'X41.':31}        7 X41.",
        f"     8 {'X42.':31}        8 X42.",
        f"     9 {'X43.':31}        9 X43.",
        "...",
        f"    12 {'X46.':31}       12 X46.",
        f"    13 {'X47.':31}       13 X47.",
        f"    14 {'X48.':31}       14 X48.",
        f"    15 {'T0202 (TOOL <2>)':31} |     15 T0303 (TOOL <2>)",
        f"       {'':31} >     16 M9",
        f"    16 {'M30':31}       17 M30",
        f"    17 {'%':31}       18 %",
    ]


def test_what_only_the_first_has_stands_on_the_left_alone() -> None:
    rows = list(side_by_side(compare(*sides(b"M8\nM9\nM30\n", b"M8\nM30\n")), "a", "b", 59))
    assert rows[2] == f"     2 {'M9':20} <"
    assert rows[3] == f"     3 {'M30':20}        2 M30"


@pytest.mark.parametrize(("width", "half"), [(20, 20), (60, 20), (61, 21), (62, 21), (63, 22), (130, 55)])
def test_a_column_has_its_share_of_the_width_and_is_never_too_narrow(width: int, half: int) -> None:
    hunks = compare(*sides(b"(" + b"A" * 80 + b")\n", b"(" + b"B" * 80 + b")\n"))
    rows = list(side_by_side(hunks, "a" * 80, "b" * 80, width))
    assert rows == [
        f"       {'a' * half}          {'b' * half}",
        f"     1 ({'A' * (half - 1)} |      1 ({'B' * (half - 1)}",
    ]


def test_as_a_page() -> None:
    body = page(compare(*sides()), "a<.nc", "b&\a.nc").split("<body>\n")[1].split("\n")
    same = '<tr class="same"><td class="n a">{0}</td><td class="a">{1}</td><td class="s"></td>'
    same += '<td class="n b">{2}</td><td class="b">{3}</td></tr>'
    head = '<thead><tr><th></th><th>a&lt;.nc</th><th class="s"></th><th></th>'
    assert body == [
        r"<h1>a&lt;.nc and b&amp;\x07.nc</h1><p>3 places differ.</p>",
        '<table><colgroup><col class="n"><col><col class="s"><col class="n"><col></colgroup>',
        head + r"<th>b&amp;\x07.nc</th></tr></thead><tbody>",
        same.format(1, "%", 1, "%"),
        '<tr class="change"><td class="n a">2</td>'
        '<td class="a">GOTO20 <span class="note">N20 is line 4</span></td><td class="s">|</td>'
        '<td class="n b">2</td><td class="b">GOTO20 <span class="note">N20 is line 3</span></td></tr>',
        same.format(3, "G1 Z-5. F0.2", 3, "N20 G1 Z-5. F0.2"),
        same.format(4, "N20 X50.", 4, "X50."),
        same.format(5, "M8", 5, "M8"),
        '<tr class="change"><td class="n a">6</td><td class="a">X40.</td><td class="s">|</td>'
        r'<td class="n b">6</td><td class="b">(\x1b[31m)</td></tr>',
        same.format(7, "X41.", 7, "X41."),
        same.format(8, "X42.", 8, "X42."),
        same.format(9, "X43.", 9, "X43."),
        '<tr class="skipped"><td colspan="5">...</td></tr>',
        same.format(12, "X46.", 12, "X46."),
        same.format(13, "X47.", 13, "X47."),
        same.format(14, "X48.", 14, "X48."),
        '<tr class="change"><td class="n a">15</td><td class="a">T0202 (TOOL &lt;2&gt;)</td>'
        '<td class="s">|</td><td class="n b">15</td><td class="b">T0303 (TOOL &lt;2&gt;)</td></tr>',
        '<tr class="only-b"><td class="n a"></td><td class="a"></td><td class="s">&gt;</td>'
        '<td class="n b">16</td><td class="b">M9</td></tr>',
        same.format(16, "M30", 17, "M30"),
        same.format(17, "%", 18, "%"),
        "</tbody></table></body></html>",
        "",
    ]


@pytest.mark.parametrize(
    ("b", "said"),
    [
        (b"M8\n", "Both programs say the same."),
        (b"M9\n", "1 place differs."),
        (b"M9\nM8\nM9\n", "2 places differ."),
    ],
)
def test_the_page_counts_places(b: bytes, said: str) -> None:
    text = page(compare(*sides(b"M8\n", b)), "a", "b")
    assert f"<h1>a and b</h1><p>{said}</p>" in text
    assert "<title>a and b</title>" in text
    assert ("<tr class" in text) is (b != b"M8\n")


def test_as_json() -> None:
    assert as_json(compare(*sides())) == [
        {
            "a": [{"line": 2, "text": "GOTO20", "note": "N20 is line 4"}],
            "b": [{"line": 2, "text": "GOTO20", "note": "N20 is line 3"}],
        },
        {"a": [{"line": 6, "text": "X40."}], "b": [{"line": 6, "text": "(\x1b[31m)"}]},
        {
            "a": [{"line": 15, "text": "T0202\t(TOOL <2>)"}],
            "b": [{"line": 15, "text": "T0303\t(TOOL <2>)"}, {"line": 16, "text": "M9"}],
        },
    ]


def said_in(row: list[str]) -> int | str:
    """The number of an equal row; else what it is."""
    if row == ["..."]:
        return row[0]
    return "change" if "|" in row else int(float(row[1][1:]))


@pytest.mark.parametrize(
    ("before", "between", "behind", "shown"),
    [
        # Three around a change; one row says no more than the block that it stands for.
        (4, 7, 4, [*range(4), "change", *range(7), "change", *range(4)]),
        (5, 8, 5, ["...", 2, 3, 4, "change", 0, 1, 2, "...", 5, 6, 7, "change", 0, 1, 2, "..."]),
        (0, 0, 0, ["change", "change"]),
    ],
)
def test_how_many_equal_blocks_are_shown(
    before: int, between: int, behind: int, shown: list[int | str]
) -> None:
    equal = [
        [f"{letter}{x}." for x in range(n)]
        for letter, n in zip("XYZ", (before, between, behind), strict=True)
    ]

    def program(*changed: str) -> bytes:
        return "\n".join([*equal[0], changed[0], *equal[1], changed[1], *equal[2], ""]).encode()

    hunks = compare(*sides(program("M3", "M4"), program("M13", "M14")))
    rows = [row.split() for row in side_by_side(hunks, "a", "b", 80)][1:]
    assert list(map(said_in, rows)) == shown
    # In a patch between changes: six together, of seven the three at each end.
    heads = [line for line in unified(hunks, "a", "b") if line.startswith("@@")]
    assert len(heads) == (1 if between <= 6 else 2)


@pytest.mark.parametrize(
    ("between", "heads"), [(6, ["@@ -1,14 +1,14 @@"]), (7, ["@@ -1,7 +1,7 @@", "@@ -9,7 +9,7 @@"])]
)
def test_changes_near_each_other_share_their_surroundings(between: int, heads: list[str]) -> None:
    equal = [f"Y{x}." for x in range(between)]

    def program(code: int) -> bytes:
        lines = ["X0.", "X1.", "X2.", f"M{code}", *equal, f"M{code + 1}", "Z0.", "Z1.", "Z2.", "Z3."]
        return "\n".join([*lines, ""]).encode()

    lines = list(unified(compare(*sides(program(3), program(13))), "a", "b"))
    assert [line for line in lines if line.startswith("@@")] == heads
    assert lines[-1] == " Z2."


@pytest.mark.parametrize(
    ("a", "b", "head"), [(b"", b"M8\nM9\n", "@@ -0,0 +1,2 @@"), (b"\n\nM8\n", b"", "@@ -3,1 +0,0 @@")]
)
def test_a_program_that_says_nothing_begins_at_line_0(a: bytes, b: bytes, head: str) -> None:
    assert list(unified(compare(*sides(a, b)), "a", "b"))[2] == head


def test_programs_that_say_the_same_are_no_patch_and_no_table() -> None:
    hunks = compare(*sides(A, A))
    assert not list(unified(hunks, "a", "b")) and not list(side_by_side(hunks, "a", "b", 80))
    assert as_json(hunks) == []
