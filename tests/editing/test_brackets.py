"""Bracket lines by themselves, and what is said when some are broken: every word, and where it points."""

from __future__ import annotations

import json
import zlib
from hashlib import sha256

import numpy as np
import pytest

import chipbreak
from chipbreak.dialects.base import PARENTHESES, SEMICOLON, CommentMarks
from chipbreak.editing import beside, bracket
from chipbreak.editing.beside import fits, parted, with_brackets
from chipbreak.editing.edits import Edit, MoveTable, OverlapError, in_order
from chipbreak.editing.promise import KEPT
from chipbreak.editing.render import print_moves, render
from chipbreak.editing.restore import outermost, regions, restore, restored, restores
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import Diagnostic, ProgramRejectedError
from chipbreak.text.source import read

BOTH = pytest.mark.parametrize("marks", [PARENTHESES, SEMICOLON], ids=["parentheses", "semicolon"])
SETTINGS = chipbreak.load("generic-lathe")


# --- the lines --------------------------------------------------------------------------------------------


def kept(line: bytes, most: int, marks: CommentMarks = PARENTHESES, *, lower_case: bool = False) -> list[str]:
    return list(bracket.was_lines([line], b"\n", most, marks, lower_case=lower_case))


@BOTH
def test_a_line_is_kept_as_text_up_to_the_last_character_that_fits(marks: CommentMarks) -> None:
    text = "X" * 20
    whole = f"{marks.before}CHIPBREAK WAS {text}{marks.behind}"
    assert kept(text.encode() + b"\n", len(whole), marks) == [whole]
    shorter = kept(text.encode() + b"\n", len(whole) - 1, marks)
    assert all("HEX" in line and len(line) <= len(whole) - 1 for line in shorter)


@pytest.mark.parametrize(
    ("line", "is_text"),
    [
        (b"G1 X-1.5 Z+2.,R3=_/\n", True),
        (b"\n", True),
        (b"g1\n", False),
        (b"(A)\n", False),
        (b"X#1\n", False),
        (b"X1.\r\n", False),
        (b"X1.", False),
        (b"\xe9\n", False),
    ],
)
def test_what_is_kept_as_text(line: bytes, is_text: bool) -> None:
    (said,) = kept(line, 80)
    text = line[:-1].decode("latin-1")
    wanted = f"(CHIPBREAK WAS {text})" if is_text else f"(CHIPBREAK HEX {line.hex().upper()})"
    assert said == wanted


@pytest.mark.parametrize(("line", "is_text"), [(b"g1 X#1 [A*2]<B>:-\n", True), (b"a;b\n", False)])
def test_what_is_kept_as_text_where_lower_case_is_read(line: bytes, is_text: bool) -> None:
    assert ("WAS" in kept(line, 80, lower_case=True)[0]) is is_text
    assert "HEX" in kept(line, 80)[0]


@pytest.mark.parametrize(("marks", "is_text"), [(PARENTHESES, True), (SEMICOLON, False)])
def test_a_blank_at_the_end_is_kept_as_text_where_something_closes_the_comment(
    marks: CommentMarks, is_text: bool
) -> None:
    assert ("WAS" in kept(b"X1. \n", 80, marks)[0]) is is_text
    assert "WAS" in kept(b"X1.\n", 80, marks)[0]


@BOTH
@pytest.mark.parametrize(("most", "step"), [(200, 30), (76, 30), (75, 29), (74, 29), (30, 7), (29, 6)])
def test_bytes_are_kept_thirty_to_a_line_or_as_many_as_fit(marks: CommentMarks, most: int, step: int) -> None:
    # "(CHIPBREAK HEX )" has as many characters as "; CHIPBREAK HEX ".
    lines = kept(b"\xe9" * 61 + b"\n", most, marks)
    texts = [line.split("HEX ")[1].rstrip(")") for line in lines]
    assert bytes.fromhex("".join(texts)) == b"\xe9" * 61 + b"\n"
    assert {len(text) for text in texts[:-1]} == {2 * step}
    assert all(len(line) <= most for line in lines)


def test_every_line_is_kept_by_itself() -> None:
    lines = list(bracket.was_lines([b"A\n", b"\xe9\n", b"B\n"], b"\n", 80, PARENTHESES, lower_case=False))
    assert lines == ["(CHIPBREAK WAS A)", "(CHIPBREAK HEX E90A)", "(CHIPBREAK WAS B)"]


@BOTH
@pytest.mark.parametrize(("number", "layer"), [("", bracket.CHANGES), ("N1234567 ", bracket.UNROLLED_CYCLES)])
def test_a_title_fills_the_line_and_no_more(marks: CommentMarks, number: str, layer: bracket.Layer) -> None:
    """Room is left for a block number of five digits, or for the one that is there."""
    for most in (40, 41, 60):
        title = bracket.title_text("A" * 99, most, marks, number, layer)
        line = bracket.comment(layer.begin, title, marks)
        assert len(line) + max(len(number), len("N99999 ")) == most
    assert bracket.title_text("A" * 99, 10, marks, number, layer) == ""


@pytest.mark.parametrize(
    ("title", "fit"), [("vib (n) 1.5", "VIB  N  1.5"), ("a\nb#c", "A B C"), ("A.,=_+/-9 ", "A.,=_+/-9")]
)
def test_a_title_has_only_what_every_comment_may_have(title: str, fit: str) -> None:
    assert bracket.title_text(title, 80, PARENTHESES) == fit


@pytest.mark.parametrize(
    ("line", "kind"),
    [
        (b"(CHIPBREAK BEGIN X)", b"BEGIN"),
        (b" \tN12.5 (CHIPBREAK END 1F0A33C2) ", b"END"),
        (b"; CHIPBREAK WAS G1", b"WAS"),
        (b";CHIPBREAK HEX 47", b"HEX"),
        (b"(CHIPBREAK ROLLED)", b"ROLLED"),
        (b"(CHIPBREAK BEGIN X", None),
        (b"CHIPBREAK BEGIN X", None),
        (b"G1 (CHIPBREAK BEGIN X)", None),
        (b"(CHIPBREAK BEGIN (X))", None),
        (b"(CHIPBREAK STAMP)", None),
    ],
)
def test_which_lines_are_brackets(line: bytes, kind: bytes | None) -> None:
    match = bracket.LINE.fullmatch(line)
    assert (match and match["kind"]) == kind


@pytest.mark.parametrize(
    ("data", "at"),
    [
        (b"(CHIPBREAK END 1)", 1),
        (b"; CHIPBREAK END 1", 2),
        (b";CHIPBREAK END 1", 1),
        (b"CHIPBREAK END (CHIPBREAK END", 15),
        (b"X CHIPBREAK END", -1),
        (b"CHIPBREAK END", -1),
        (b"(CHIPBREAK BEGIN", -1),
        (b"(  CHIPBREAK END", -1),
    ],
)
def test_where_a_bracket_may_be(data: bytes, at: int) -> None:
    assert bracket.find(data, "END") == at
    assert bracket.find(b"(CHIPBREAK END" + data, "END", 14) == (at + 14 if at >= 0 else -1)
    assert bracket.find(data, "END", 0, 4) == -1


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r", b"\n\r\r"])
def test_a_checksum_is_that_of_the_lines_with_plain_ends(end: bytes) -> None:
    plain = format(zlib.crc32(b"Z1.\nZ2.\n"), "08X")
    assert bracket.checksum(end.join([b"Z1.", b"Z2.", b""])) == plain


# --- numbers in bulk --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [
        (0.0, 0, "0."),
        (-0.4, 0, "0."),
        (-0.6, 0, "-1."),
        (10.0, 0, "10."),
        (0.5, 3, "0.500"),
        (-0.0004, 3, "0.000"),
        (-0.0006, 3, "-0.001"),
        (99.9996, 3, "100.000"),
        (123.456, 3, "123.456"),
        (2147483.647, 3, "2147483.647"),
        (2147483.648, 3, "2147483.648"),
        (-2147483.649, 3, "-2147483.649"),
        (2.0**53 - 1.0, 0, "9007199254740991."),
        (0.001, 6, "0.001000"),
    ],
)
def test_a_number_as_it_is_printed(value: float, decimals: int, text: str) -> None:
    assert print_moves(MoveTable(("Z",), (np.array([value]),), (decimals,)), b"\n").decode() == f"Z{text}\n"


@pytest.mark.parametrize("value", [2.0**53, -(2.0**53), np.inf, np.nan])
def test_a_number_with_digits_that_nobody_knows_is_not_printed(value: float) -> None:
    with pytest.raises(ValueError, match=r"^a number that cannot be written in a program$"):
        print_moves(MoveTable(("Z",), (np.array([1.0, value]),), (0,)), b"\n")


def test_a_table_with_a_block_behind_every_row() -> None:
    table = MoveTable(("X", "Z="), (np.array([1.0, -22.5]), np.array([0.0, 3.0])), (1, 2), "G4 P0.1")
    assert print_moves(table, b"\r\n") == b"X1.0 Z=0.00\r\nG4 P0.1\r\nX-22.5 Z=3.00\r\nG4 P0.1\r\n"
    assert print_moves(table.rows(1, 2), b"\n") == b"X-22.5 Z=3.00\nG4 P0.1\n"
    assert len(table) == 2 and len(table.rows(0, 1)) == 1
    assert repr(table) == "<MoveTable X Z=: 2 rows>"
    assert print_moves(table.rows(0, 0), b"\n") == b""


# --- edits in order ---------------------------------------------------------------------------------------


def edit(first: int, last: int, *content: str, name: str = "one", keeps_number: bool = True) -> Edit:
    return Edit(first, last, content, "TEST", "a reason", KEPT, name, keeps_number=keeps_number)


def test_edits_that_touch_do_not_overlap() -> None:
    some = [edit(4, 6), edit(2, 4), edit(4, 4, "A"), edit(4, 4, "B"), edit(6, 6)]
    assert in_order(some) == [some[1], some[2], some[3], some[0], some[4]]


@pytest.mark.parametrize(("first", "last"), [(3, 5), (2, 3), (3, 3), (0, 3), (1, 9)])
def test_edits_that_overlap_are_said(first: int, last: int) -> None:
    pair = sorted(
        [edit(2, 4), edit(first, last, name="two")], key=lambda one: (one.first, one.last > one.first)
    )
    with pytest.raises(OverlapError) as caught:
        in_order(pair[::-1])
    names = [
        f"{one.pass_name} (lines {one.first + 1} to {one.last})"
        for one in (caught.value.one, caught.value.other)
    ]
    assert str(caught.value) == f"{names[0]} and {names[1]} change the same lines"
    assert sorted(names) == sorted(["one (lines 3 to 4)", f"two (lines {first + 1} to {last})"])


def test_an_edit_says_who_made_it() -> None:
    assert repr(edit(1, 3)) == "<Edit of one, lines 1 to 3: TEST>"
    assert repr(edit(1, 3, name="")) == "<Edit of no pass yet, lines 1 to 3: TEST>"


def written(data: bytes, *edits: Edit) -> list[bytes]:
    return b"".join(render(parse(read(data), SETTINGS.dialect), edits, SETTINGS)).split(b"\n")


def test_a_change_as_it_is_written() -> None:
    """Twice, so that the second one begins where the first has ended."""
    data = b"N1 X1.\nn20X2.\nX3.\nN4 X4.\n"
    first = [
        b"n20 (CHIPBREAK BEGIN TEST)",
        b"(CHIPBREAK HEX 6E323058322E0A)",
        b"M8",
        b"(CHIPBREAK END 64FD5F2E)",
    ]
    second = [b"(CHIPBREAK BEGIN TEST)", b"(CHIPBREAK WAS N4 X4.)", b"(CHIPBREAK END %s)", b""]
    out = written(data, edit(1, 2, "M8"), edit(3, 4, keeps_number=False))
    crc = bracket.checksum(b"(CHIPBREAK HEX 6E323058322E0A)\nM8\n").encode()
    first[-1] = b"(CHIPBREAK END %s)" % crc
    second[2] %= bracket.checksum(b"(CHIPBREAK WAS N4 X4.)\n").encode()
    assert out == [b"N1 X1.", *first, b"X3.", *second]
    found = regions(read(b"\n".join(out)))
    assert [one[:4] for one in found] == [(1, 3, 5, "TEST"), (6, 8, 9, "TEST")]
    assert [one.original for one in found] == [b"n20X2.\n", b"N4 X4.\n"]
    assert b"".join(restored(read(b"\n".join(out)), found)) == data
    assert restores(read(b"\n".join(out)), found, data)


@pytest.mark.parametrize(
    "other", [b"", b"N1 X1.\nX2.\n", b"N1 X1.\nX2.\nX3.\nM30\n\n", b"N1 X1.\nX2.\nX4.\nM30\n", b"N1 X1."]
)
def test_other_bytes_are_not_what_was_there(other: bytes) -> None:
    data = b"N1 X1.\nX2.\nX3.\nM30\n"
    source = read(b"\n".join(written(data, edit(1, 2, "M8"), edit(2, 3, "M9"))))
    assert restores(source, regions(source), data)
    assert not restores(source, regions(source), other)


def test_a_change_at_the_end_of_a_file_without_a_last_line_end() -> None:
    assert written(b"X1.\nX2.", edit(1, 2, "M8"))[-1].startswith(b"(CHIPBREAK END")
    assert written(b"X1.\nX2.", edit(0, 1, "M8"))[-1] == b"X2."
    assert written(b"X1.\nX2.\n", edit(1, 2, "M8"))[-1] == b""


# --- what is refused --------------------------------------------------------------------------------------

DATA = b"N1 X1.\nX2.\nX3.\nM30\n"
OUT = b"\n".join(written(DATA, edit(1, 2, "M8"), edit(2, 3, "M9")))
CHANGED = "this part was changed after chipbreak wrote it; restoring it would lose the change"
CHANGE_IT = "change the original program instead, or delete the CHIPBREAK comments to keep the part as it is"
NO_END = "the END comment of this part is missing"
BAD_END = "this END comment cannot be read"
TAKE_IT = "take the program from before the damage and filter it again"


def refused(data: bytes) -> tuple[str, int, str, str, str]:
    """Code, line, the line itself, message and way out."""
    with pytest.raises(ProgramRejectedError) as caught:
        restore(read(data, "part.nc"))
    (said,) = caught.value.diagnostics
    return place_of(said)


def place_of(said: Diagnostic) -> tuple[str, int, str, str, str]:
    assert said.place is not None and said.place.file == "part.nc" and said.severity.value == "error"
    return said.code, said.place.line, said.line_text, said.message, said.help


@pytest.mark.parametrize(
    ("old", "new", "line", "shown", "message"),
    [
        # The second of two changes as well as the first.
        (b"M8", b"M7", 2, "(CHIPBREAK BEGIN TEST)", CHANGED),
        (b"M9", b"M7", 6, "(CHIPBREAK BEGIN TEST)", CHANGED),
        (b"WAS X3.", b"HEX X3.", 7, "(CHIPBREAK HEX X3.)", "this HEX comment cannot be read"),
        (b"M8\n(CHIPBREAK END", b"M8\n(CHIPBREAK ENT", 2, "(CHIPBREAK BEGIN TEST)", NO_END),
        (b"M9\n(CHIPBREAK END", b"M9\n(CHIPBREAK ENT", 6, "(CHIPBREAK BEGIN TEST)", NO_END),
        (b"M8\n", b"M8\n(CHIPBREAK BEGIN X)\n", 2, "(CHIPBREAK BEGIN TEST)", NO_END),
        (b"M9\n(CHIPBREAK END", b"M9\nG0 (CHIPBREAK END", 9, "G0 (CHIPBREAK END ", BAD_END),
    ],
)
def test_what_is_said_of_a_broken_part(old: bytes, new: bytes, line: int, shown: str, message: str) -> None:
    assert OUT.count(old) == 1
    said = refused(OUT.replace(old, new))
    kind = ("RES001", CHANGE_IT) if message == CHANGED else ("RES002", TAKE_IT)
    assert (said[0], said[1], said[3], said[4]) == (kind[0], line, message, kind[1])
    assert said[2].startswith(shown)


def test_a_part_of_another_layer_is_said_by_its_own_words() -> None:
    data = b"X1.\n(CHIPBREAK UNROLLED G71)\nX2.\nM30\n"
    assert refused(data)[1:4:2] == (2, "the ROLLED comment of this part is missing")


def test_where_lines_stand_that_were_put_back() -> None:
    """What is kept as bytes is one comment or several; each line is found in the one in which it begins."""
    data = b"X1.\n(" + b"A" * 40 + b")\nX2.\n(B)\nX3.\n"
    out = read(b"\n".join(written(data, edit(1, 4, "M8"))))
    back = restore(out)
    assert back.data == data
    lines = [out.text(line) for line in range(out.line_count)]
    assert [back.place(line).line for line in range(5)] == [1, 3, 5, 6, 9]
    assert [lines[at - 1][:14] for at in (3, 5, 6, 9)] == [
        "(CHIPBREAK HEX",
        "(CHIPBREAK WAS",
        "(CHIPBREAK HEX",
        "X3.",
    ]
    assert [(back.place(line).column, back.place(line).end_column) for line in (0, 2, 4)] == [
        (1, 4),
        (16, 19),
        (1, 4),
    ]
    assert outermost(out) == [range(1, 8)]


def test_of_changes_in_an_unrolled_cycle_the_cycle_is_the_outermost() -> None:
    inner = b"\n".join(written(b"X1.\nX2.\nX3.\n", edit(1, 2, "M8")))
    plain = b"X1.\nX2.\nX3.\n"
    kept_line = b"(CHIPBREAK WAS G71)\n"
    crc = bracket.checksum(kept_line + plain).encode()
    data = b"M3\n(CHIPBREAK UNROLLED G71)\n" + kept_line + inner + b"(CHIPBREAK ROLLED %s)\nM5\n" % crc
    data += b"\n".join(written(b"X4.\nX5.\n", edit(0, 1, "M9")))
    assert outermost(read(data)) == [range(1, 10), range(11, 15)]
    assert restore(read(data)).data == b"M3\nG71\nM5\nX4.\nX5.\n"


# --- the file beside --------------------------------------------------------------------------------------


def entry(data: bytes, *brackets: tuple[int, int, str]) -> bytes:
    programs = [{"sha256": sha256(data).hexdigest(), "brackets": brackets}]
    return json.dumps({"chipbreak": 1, "programs": programs}).encode()


def test_the_file_beside_as_it_is_written() -> None:
    data = b"\n".join(written(b"X1.\nN2 X2.\nX3.\n", edit(1, 2, "M8"), edit(2, 2, "M9")))
    bare, file = parted(data, "part.nc")
    assert bare == b"X1.\nN2\nM8\nM9\nX3.\n"
    assert file is not None
    lines = data.decode().split("\n")
    assert json.loads(file) == {
        "chipbreak": 1,
        "programs": [
            {
                "sha256": sha256(bare).hexdigest(),
                "brackets": [
                    [2, 2, lines[1].removeprefix("N2")],
                    [3, 0, f"{lines[2]}\n"],
                    [4, 0, f"{lines[4]}\n{lines[5]}\n"],
                    [5, 0, f"{lines[7]}\n"],
                ],
            },
            {"sha256": sha256(b"X1.\nN2 X2.\nX3.\n").hexdigest(), "brackets": []},
        ],
    }
    assert parted(b"X1.\n", "part.nc") == (b"X1.\n", None)
    whole = with_brackets(bare, "part.nc", file)
    assert whole.data == data
    # Each line where it is in the bare program; a bracket where it belongs, as a whole.
    assert [whole.place(line).line for line in range(whole.line_count)] == [1, 2, 3, 3, 4, 4, 4, 5, 5]
    assert [whole.place(line)[2:] for line in (0, 3, 6, 8)] == [(1, 4), (1, 3), (1, 3), (1, 4)]
    assert whole.place(2)[2:] == (1, len("M8") + 1)


@pytest.mark.parametrize(
    ("brackets", "whole"),
    [
        ([(1, 0, "A")], b"AX1.\nX2.\n"),
        ([(1, 4, "A")], b"X1.\nAX2.\n"),
        ([(2, 4, "A")], b"X1.\nX2.\nA"),
        ([(3, 0, "A")], b"X1.\nX2.\nA"),
        ([(1, 0, "A"), (1, 0, "B")], b"ABX1.\nX2.\n"),
        ([(1, 5, "A")], None),
        ([(3, 1, "A")], None),
        ([(4, 0, "A")], None),
        ([(0, 0, "A")], None),
        ([(1, -1, "A")], None),
    ],
)
def test_places_up_to_the_end_of_a_line_are_there(
    brackets: list[tuple[int, int, str]], whole: bytes | None
) -> None:
    data = b"X1.\nX2.\n"
    if whole is not None:
        assert with_brackets(data, "part.nc", entry(data, *brackets)).data == whole
        return
    with pytest.raises(ProgramRejectedError) as caught:
        with_brackets(data, "part.nc", entry(data, *brackets))
    (said,) = caught.value.diagnostics
    assert place_of(said) == (
        "RES004", 1, "X1.",
        "its file NAME.chipbreak cannot be used: it names a place that the program does not have",
        "take the program from before it was filtered, and remove NAME.chipbreak",
    )  # fmt: skip


MISSING = "something in it is missing"


@pytest.mark.parametrize(
    ("file", "why"),
    [
        (b"{", "it is not JSON"),
        (b"[" * 100_000, "it is not JSON"),
        (b"[1]", "chipbreak did not write it"),
        (b'{"programs": []}', "chipbreak did not write it"),
        (b'{"chipbreak": 2, "programs": []}', "a newer chipbreak has written it"),
        (b'{"chipbreak": 1}', MISSING),
        (b'{"chipbreak": 1, "programs": [{"sha256": "0"}]}', MISSING),
        (b'{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [["1", 0, "A"]]}]}', MISSING),
        (b'{"chipbreak": 1, "programs": [{"sha256": "0", "brackets": [[1, 0.5, "A"]]}]}', MISSING),
        (entry(b"X1.\n", (2, 0, "A"), (1, 0, "B")), "its places are not in order"),
    ],
)  # fmt: skip
def test_a_file_beside_that_cannot_be_used(file: bytes, why: str) -> None:
    with pytest.raises(ProgramRejectedError) as caught:
        with_brackets(b"X1.\n", "part.nc", file)
    (said,) = caught.value.diagnostics
    assert (said.code, said.message) == ("RES004", f"its file NAME.chipbreak cannot be used: {why}")
    assert said.help == "take the program from before it was filtered, and remove NAME.chipbreak"
    assert fits(b"X1.\n", "part.nc", file) is why.startswith("its places")


def test_a_file_beside_of_another_program() -> None:
    with pytest.raises(ProgramRejectedError) as caught:
        with_brackets(b"X1.\nX2.\n", "part.nc", entry(b"X3.\n"))
    (said,) = caught.value.diagnostics
    assert place_of(said) == (
        "RES003", 1, "X1.",
        "its file NAME.chipbreak is not about this program: it was changed since chipbreak wrote it,"
        " or another one has been put in its place",
        "change the original and filter that again; where this is a new program that was never filtered,"
        " remove NAME.chipbreak",
    )  # fmt: skip
    assert not fits(b"X1.\nX2.\n", "part.nc", entry(b"X3.\n"))
    assert fits(b"X1.\nX2.\n", "part.nc", entry(b"X1.\r\nX2.\r\n"))


def test_of_two_entries_of_one_program_the_first_is_taken_and_written_once() -> None:
    one, other = entry(b"X1.\n", (1, 0, "A")), entry(b"X1.\n", (1, 0, "B"))
    together = beside.both(one, other, "part.nc")
    assert with_brackets(b"X1.\n", "part.nc", together).data == b"AX1.\n"
    assert len(json.loads(together)["programs"]) == 1
    with_third = json.loads(beside.both(together, beside.plain(b"M30\n"), "part.nc"))["programs"]
    assert [item["sha256"] for item in with_third] == [
        sha256(data).hexdigest() for data in (b"X1.\n", b"M30\n")
    ]
    assert beside.both(one, b"{", "part.nc") == one
