"""The way back: the original bytes from a filtered program, and a second run that changes nothing."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.dialects.base import PARENTHESES, SEMICOLON, CommentMarks
from chipbreak.editing.bracket import checksum
from chipbreak.editing.restore import regions, restore
from chipbreak.text.source import read
from longer import short_where

SETTINGS = chipbreak.load("generic-lathe")
CUT = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"


def there_and_back(data: bytes, settings: chipbreak.Settings = SETTINGS) -> bytes:
    """Filter, filter again, restore; the middle step must change nothing."""
    non_modal = chipbreak.rewrite(data, settings)
    twice = chipbreak.rewrite(non_modal.data, settings)
    assert twice.data == non_modal.data, "a second run changes nothing"
    assert not twice.changed
    assert restore(read(non_modal.data)).data == data
    return non_modal.data


PROGRAMS = [
    pytest.param(CUT, id="plain"),
    pytest.param(CUT.replace(b"\n", b"\r\n"), id="CRLF"),
    pytest.param(CUT.replace(b"\n", b"\r"), id="CR"),
    pytest.param(CUT.replace(b"1.5\n", b"1.5\r\n"), id="mixed line ends"),
    pytest.param(CUT[:-5], id="ends with the cut, and a line end"),
    pytest.param(CUT[:-5].rstrip(), id="ends with the cut, no line end"),
    pytest.param(CUT.rstrip(), id="no last line end"),
    pytest.param(CUT.replace(b"N1.5", "N1.5 (荒加工)".encode("shift-jis")), id="Shift-JIS in the block"),
    pytest.param(
        CUT.replace(b"G1", b"(VIB N1.5)\nG1 X21. F0.05\n(\x8dr\x89\xc1\x8dH)\nG1").replace(
            b" N1.5\nM", b"\nM"
        ),
        id="Shift-JIS in a chain",
    ),
    pytest.param(CUT.replace(b"G1 Z-3. F0.05 N1.5", b"g1 z-3. F0.05 N1.5"), id="lower-case words"),
    pytest.param(CUT.replace(b"G1", b"N30 G1").replace(b"M30", b"N40 M30"), id="block numbers"),
    pytest.param(CUT.replace(b"G1", b"N 30 G1"), id="a blank in the block number"),
    pytest.param(CUT.replace(b"G1", b"n30 G1"), id="a lower-case block number"),
    pytest.param(CUT.replace(b"G1", b"N+30. G1"), id="a block number with sign and point"),
    pytest.param(CUT.replace(b"G1", b"N\x0030 G1"), id="a NUL in the block number"),
    pytest.param(CUT.replace(b"N1.5", b"N1.5 (a (nested))"), id="nested comment"),
    pytest.param(CUT.replace(b"N1.5", b"N1.5 ; ) ("), id="semicolon comment with parentheses"),
    pytest.param(CUT.replace(b"N1.5", b"N1.5\t \t"), id="trailing blanks"),
    pytest.param(CUT.replace(b"N1.5", b"N1.5 (" + b"LONG " * 30 + b")"), id="a long line"),
    pytest.param(CUT.replace(b"G1 Z", b"G1\x00 Z"), id="a NUL"),
    pytest.param(b"\xef\xbb\xbf%\nO1000\n" + CUT + b"%\n", id="BOM and percent signs"),
    pytest.param(b"leader (CHIPBREAK)\n%\n" + CUT + b"%\ntrailer", id="leader and trailer"),
    pytest.param(CUT.replace(b"G97 S3000", b"G97 V188.5 D20."), id="V and D"),
    pytest.param(b"(SPEED V188.5 D20)\n" + CUT, id="V and D by directive"),
    pytest.param(CUT.replace(b"N1.5\n", b"N1.5\nG0 Z2.\nG1 Z-4. N2.5\n"), id="two cuts"),
    pytest.param(CUT.replace(b"N1.5\n", b"N1.5\nX30. N1.5\n"), id="a chain"),
    pytest.param(CUT.replace(b"N1.5\n", b"N1.5\nX30. N2.5\n"), id="two chains, one behind the other"),
    pytest.param(
        CUT.replace(b"N1.5\n", b"N1.5\n(CHIPBREAK IS FINE)\n(CHIPBREAK END)\n"), id="comments like ours"
    ),
]


@pytest.mark.parametrize("program", PROGRAMS)
def test_there_and_back(program: bytes) -> None:
    out = there_and_back(program)
    assert out != program


@pytest.mark.parametrize("end", [b"", b"\n", b"\r"])
def test_a_file_without_a_last_line_end_gets_none(end: bytes) -> None:
    """A control may read what stands behind the last line end as one more block."""
    program = CUT[:-5].rstrip() + end
    assert there_and_back(program.replace(b"\n", end or b"\n")).endswith(b")" + end)


def test_the_line_that_was_stands_readable_where_it_can() -> None:
    assert b"(CHIPBREAK WAS G1 Z-3. F0.05 N1.5)\n" in there_and_back(CUT)
    assert b"(CHIPBREAK HEX " in there_and_back(CUT.replace(b"N1.5", b"N1.5 (x)"))


def test_lower_case_is_kept_readable_only_where_the_control_takes_it() -> None:
    program = b"G7 G95 G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 f25 E2\nM2\n".replace(b" E2", b" N0.5")
    assert b"(CHIPBREAK WAS G1 Z-3. F0.05 f25 N0.5)" in there_and_back(
        program, chipbreak.load("linuxcnc-lathe")
    )
    assert b"HEX" in there_and_back(CUT.replace(b"N1.5", b"f62.5"))


# Each limit once, and each of the others; all that can stand together in the long form.
_FEW_LIMITS = ((60, b"\n", b"N12345678901234 "), (75, b"\r\n", b"N12345678901234 "), (80, b"\r\n", b""))
_LIMITS = product((60, 75, 80), (b"\n", b"\r\n"), (b"", b"N12345678901234 "))


@pytest.mark.parametrize(("limit", "end", "number"), short_where(_LIMITS, _FEW_LIMITS.__contains__))
def test_no_line_around_a_cut_is_longer_than_the_control_takes(limit: int, end: bytes, number: bytes) -> None:
    settings = chipbreak.load("generic-lathe", [f"control.max_line_chars={limit}"])
    cut = number + b"G1 Z-1. F0.05 N1.5"
    for comment in (b"", b" (X)"):
        cuts = [cut.ljust(size - len(comment)) + comment for size in range(30, 90)]
        blocks = [block for one in cuts for block in (b"G0 X20. Z0.", one)]
        result = chipbreak.rewrite(end.join([b"G97 S3000 M3", *blocks, b"M30", b""]), settings)
        parts = result.data.split(b"(CHIPBREAK BEGIN VIB")[1:]
        assert len(parts) == len(cuts)
        assert max(map(len, result.data.split(end))) <= limit
        assert min(max(map(len, part.split(end))) for part in parts) > 40


@pytest.mark.parametrize(("room", "title"), [(3, "VIB"), (2, "VI"), (1, "V"), (0, ""), (-1, ""), (-4, "")])
def test_a_title_takes_the_room_that_a_long_block_number_leaves(room: int, title: str) -> None:
    """``(CHIPBREAK BEGIN )`` is 18 characters, and a blank stands behind the number."""
    settings = chipbreak.load("generic-lathe", ["control.max_line_chars=60"])
    number = b"N".ljust(60 - 18 - 1 - room, b"1")
    result = chipbreak.rewrite(
        b"G97 S3000 M3\nG0 X20. Z0.\n" + number + b" G1 Z-1. F0.05 N1.5\nM30\n", settings
    )
    (begin,) = [line for line in result.data.split(b"\n") if line.startswith(number)]
    assert begin == number + f" (CHIPBREAK BEGIN {title})".encode()
    assert len(begin) <= 60 or room < 0


def test_a_comment_in_a_chain_may_be_longer_than_the_control_takes() -> None:
    comment = b"(" + b"A" * 100 + b")"
    out = there_and_back(CUT.replace(b"N1.5\n", b"N1.5\n" + comment + b"\nX30. N1.5\n"))
    assert out.count(comment + b"\n") == 1


@pytest.mark.few(25)
@given(
    st.lists(
        st.sampled_from(
            [
                b"G1 Z-3. F0.05 N1.5",
                b"G1 X25. F0.1 N1.5 (up)",
                b"N20 G1 W-2. F0.05 N2.5",
                b"G0 X20. Z2.",
                b"g0 z5.",
                b"(\x83R\x83\x81\x83\x93\x83g)",
                b"",
                b"M8",
                b"G97 V188.5 D20.",
                b"S2500",
                b"(VIB N1.5)",
                b"(VIB OFF)",
                b"G1 X30. F0.2",
            ]
        ),
        max_size=10,
    ),
    st.sampled_from([b"\n", b"\r\n", b"\r"]),
    st.booleans(),
)
@hypothesis_settings(max_examples=60)
def test_any_likely_program_there_and_back(lines: list[bytes], end: bytes, last: bool) -> None:
    data = end.join([b"G97 S3000 M3", b"G0 X20. Z2.", *lines]) + (end if last else b"")
    try:
        there_and_back(data)
    except chipbreak.ProgramRejectedError as error:
        assert {d.code for d in error.diagnostics} <= {"VIB023", "VIB013", "VIB050", "VIB002", "VIB061"}


@given(st.binary(max_size=300))
def test_a_program_that_was_never_filtered_stays(data: bytes) -> None:
    source = read(data)
    if b"(CHIPBREAK BEGIN" not in data:
        assert restore(source) is source


@given(st.binary(max_size=60), st.binary(max_size=60), st.sampled_from([b"\n", b"\r\n"]))
def test_anything_between_brackets_is_restored_or_rejected(inside: bytes, text: bytes, end: bytes) -> None:
    content = b"(CHIPBREAK HEX " + text.hex().upper().encode() + b")" + end + inside + end
    seal = checksum(content).encode()
    data = b"(CHIPBREAK BEGIN X)" + end + content + b"(CHIPBREAK END " + seal + b")" + end
    try:
        restore(read(data))
    except chipbreak.ProgramRejectedError as error:
        assert {d.code for d in error.diagnostics} <= {"RES001", "RES002"}


# --- damage -----------------------------------------------------------------------------------------------


OUT = chipbreak.rewrite(CUT, SETTINGS).data


def complaint(data: bytes) -> tuple[str, int]:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(data, SETTINGS)
    (error,) = caught.value.diagnostics
    assert error.place is not None
    assert error.help
    return error.code, error.place.line


def test_an_edited_part_is_not_restored_over() -> None:
    assert complaint(OUT.replace(b"Z-3. F0.05\n", b"Z-3.1 F0.05\n")) == ("RES001", 3)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"(CHIPBREAK END", b"(CHIPBREAK ENT"),
        (b"(CHIPBREAK WAS G1 Z-3. F0.05 N1.5)\n", b"(CHIPBREAK HEX 4G)\n"),
        (b"(CHIPBREAK WAS G1 Z-3. F0.05 N1.5)\n", b"(CHIPBREAK HEX 471)\n"),
        (b"(CHIPBREAK BEGIN SPEED", b"(CHIPBREAK BEGIN X)\n(CHIPBREAK BEGIN SPEED"),
    ],
)
def test_a_broken_bracket_is_said(old: bytes, new: bytes) -> None:
    assert complaint(OUT.replace(old, new, 1))[0] in ("RES001", "RES002")
    assert OUT.count(old) > 0


def test_a_part_inside_a_part_has_lost_its_end() -> None:
    inner = b"(CHIPBREAK BEGIN X)\n(CHIPBREAK BEGIN SPEED"
    assert complaint(OUT.replace(b"(CHIPBREAK BEGIN SPEED", inner, 1))[0] == "RES002"


def test_a_checksum_does_not_see_how_lines_end() -> None:
    assert len({checksum(b"Z1.".join([end] * 3)) for end in (b"\n", b"\r\n", b"\r")}) == 1
    assert checksum(b"Z1.\n") != checksum(b"Z2.\n")


def test_deleting_the_comments_keeps_the_part() -> None:
    """The way out that the message names."""
    free = re.sub(rb"\(CHIPBREAK[^)]*\)\n", b"", OUT.replace(b"Z-3. F0.05\n", b"Z-3.1 F0.05\n"))
    result = chipbreak.rewrite(free, SETTINGS)
    assert result.data == free


def test_other_line_ends_after_a_transmission_still_come_back() -> None:
    sent = OUT.replace(b"\n", b"\r\n")
    assert restore(read(sent)).data == CUT.replace(b"\n", b"\r\n")


def test_a_last_line_end_added_by_an_editor_does_no_harm() -> None:
    data = CUT[:-5].rstrip()
    out = chipbreak.rewrite(data, SETTINGS).data
    assert restore(read(out + b"\n")).data in (data, data + b"\n")


def test_messages_name_lines_of_the_file_the_user_has() -> None:
    """A filtered program with a new error in it: the line number is that of the filtered file."""
    wrong = OUT.replace(b"M30", b"G0 Z2.\nG1 Z-1. N2\nM30")
    line = wrong[: wrong.index(b"N2\n")].count(b"\n") + 1
    assert complaint(wrong) == ("VIB005", line)


SMALL = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5 (cut)\nM30\n"
CHAIN = b"G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-3. F0.05\nX24. Z-5.\n(VIB OFF)\nG1 X30.\nM30\n"


@pytest.mark.parametrize("program", [CUT, CHAIN, SMALL], ids=["one block", "a chain", "as bytes"])
def test_restored_lines_have_the_numbers_of_the_file_at_hand(program: bytes) -> None:
    """A block that was put back is found in the comment that keeps it, every other line where it stands."""
    filtered = read(chipbreak.rewrite(program, SETTINGS).data)
    back = restore(filtered)
    assert back.data == program
    for line in range(back.line_count):
        place, shown, text = back.place(line), back.shown(line), back.text(line)
        assert shown == filtered.text(place.line - 1)
        if "HEX" not in shown:
            assert shown[place.column - 1 : place.end_column - 1] == text
        else:
            assert bytes.fromhex(shown[len("(CHIPBREAK HEX ") : -1]).startswith(text.encode())
            # In bytes no word has a place of its own, so the whole comment is marked.
            assert (place.column, place.end_column) == (1, len(shown) + 1)


def test_regions_say_what_was_there() -> None:
    first, second = regions(read(OUT))
    assert first.original == b"G1 Z-3. F0.05 N1.5\n"
    assert first.title.startswith("VIB N1.5 F62.5 S2500")
    assert second.original == b""
    assert second.title == "SPEED AS PROGRAMMED"


def test_a_jump_target_straight_behind_the_cut_is_reached_in_the_same_state() -> None:
    program = b"IF [#1 EQ 0] GOTO 5\nG97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nN5 M30\n"
    result = chipbreak.rewrite(program, chipbreak.load("generic-lathe"))
    assert b"\nS3000\n" in result.data
    assert restore(read(result.data)).data == program


@pytest.mark.parametrize("mode", ["G61", "G64", "G64 P0.01"])
def test_a_path_mode_goes_round_the_cut_on_a_control_that_said_none(mode: str) -> None:
    settings = chipbreak.load("generic-lathe", [f"planner.path_mode={mode}"])
    program = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    result = chipbreak.rewrite(program, settings)
    assert f"\n{mode}\nG1 Z".encode() in result.data
    assert b"F0.05\nG64\n(CHIPBREAK END" in result.data


@pytest.mark.parametrize("comments", [PARENTHESES, SEMICOLON], ids=["parentheses", "semicolon"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(
    "first",
    [
        "G1 Z-30. F0.05 N1.5",
        "N10 G1 Z-30. F0.05 N1.5 ",
        "g1 z-30. F0.05 (VIB) N1.5",
        "G1 Z-30. F0.05 N1.5 ; X",
    ],
)
def test_the_way_back_reads_comments_of_either_form(comments: CommentMarks, end: str, first: str) -> None:
    settings = chipbreak.load("generic-lathe")
    control = replace(settings, dialect=settings.dialect._replace(comment_marks=comments))
    stray = ["; CHIPBREAK END", "(SEE CHIPBREAK BEGIN)"]
    program = end.join(["G97 S3000 M3", "G0 X20. Z2.", first, *stray, "M30", ""])
    out = chipbreak.rewrite(program.encode(), control).data
    assert out != program.encode()
    mark = b"; CHIPBREAK BEGIN VIB" if comments == SEMICOLON else b"(CHIPBREAK BEGIN VIB"
    assert out.count(mark) == out.count(b"CHIPBREAK BEGIN VIB") == 1
    assert restore(read(out)).data.decode() == program
