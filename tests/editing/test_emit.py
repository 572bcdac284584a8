"""Numbers in bulk, untouched bytes, line ends, and the self-check that distrusts them."""

from __future__ import annotations

import re
from decimal import ROUND_HALF_EVEN, Decimal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from beam import BEAM
from chipbreak.editing.edits import Edit, MoveTable, OverlapError
from chipbreak.editing.promise import KEPT, Promise
from chipbreak.editing.render import _ROWS_AT_ONCE, print_moves, render
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.self_check import verify
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from chipbreak.vibration.cuts import edits_of_cuts
from chipbreak.vibration.request import requests_of

SETTINGS = chipbreak.load("generic-lathe")
CUT = b"G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nG1 X30.\nM30\n"


# --- numbers ----------------------------------------------------------------------------------------------


@pytest.mark.few(50)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40), st.integers(0, 6))
def test_a_column_prints_as_decimal_does(values: list[float], decimals: int) -> None:
    table = MoveTable(("Z",), (np.array(values),), (decimals,))
    lines = print_moves(table, b"\n").decode().splitlines()
    for line, value in zip(lines, values, strict=True):
        assert re.fullmatch(r"Z-?[0-9]+\.[0-9]*", line), "a point, no exponent"
        assert len(line.split(".")[1]) == decimals
        printed = Decimal(line[1:])
        exact = Decimal(float(np.rint(value * 10.0**decimals))).scaleb(-decimals)
        assert printed == exact.quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_EVEN)
        assert not re.fullmatch(r"Z-0*\.0*", line), "no negative zero"
        assert not re.match(r"Z-?0[0-9]", line), "no leading zeros"


@pytest.mark.few(50)
@given(
    st.lists(st.tuples(st.floats(-99, 99), st.floats(-99, 99)), min_size=1, max_size=9),
    st.sampled_from([b"\n", b"\r\n", b"\r"]),
)
def test_a_table_prints_a_block_a_row(rows: list[tuple[float, float]], end: bytes) -> None:
    x, z = np.array(rows).T
    data = print_moves(MoveTable(("X", "Z"), (x, z), (3, 2)), end)
    assert data.endswith(end)
    lines = data.decode().split(end.decode())[:-1]
    assert lines == [_row(a, b) for a, b in rows]


def _row(x: float, z: float) -> str:
    def text(value: float, decimals: int) -> str:
        rounded = float(np.rint(value * 10.0**decimals)) / 10.0**decimals + 0.0
        return f"{rounded:.{decimals}f}"

    return f"X{text(x, 3)} Z{text(z, 2)}"


def test_a_table_of_several_pieces_prints_every_row_once() -> None:
    """Rows are printed some thousand at a time, and a piece may need more digits than the one before."""
    count = 2 * _ROWS_AT_ONCE + 3
    z = -np.arange(count) / 1000.0
    z[_ROWS_AT_ONCE] = 12345.678
    data = print_moves(MoveTable(("X", "Z"), (np.linspace(0.0, 9.0, count), z), (3, 2)), b"\n")
    lines = data.decode().split("\n")
    assert lines.pop() == ""
    assert lines == [_row(a, b) for a, b in zip(np.linspace(0.0, 9.0, count), z, strict=True)]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e20])
def test_a_number_that_cannot_be_written_is_never_written(value: float) -> None:
    with pytest.raises(ValueError, match="cannot be written"):
        print_moves(MoveTable(("Z",), (np.array([value]),), (3,)), b"\n")


# --- bytes ------------------------------------------------------------------------------------------------


def edit(first: int, last: int, *content: str, name: str = "a") -> Edit:
    return Edit(first, last, content, "TEST", "a reason", KEPT, name)


@given(st.binary(max_size=200))
def test_without_edits_every_byte_stays(data: bytes) -> None:
    assert b"".join(render(parse(read(data), SETTINGS.dialect), [], SETTINGS)) == data


@pytest.mark.few(50)
@given(
    st.lists(st.sampled_from([b"G1 X1.\n", b"(a)\r\n", b"\r", b"N5 Z2.\r\n", b"x\x00\xe9\n"]), max_size=12),
    st.data(),
)
def test_bytes_outside_an_edit_stay(lines: list[bytes], data: st.DataObject) -> None:
    program = parse(read(b"".join(lines)), SETTINGS.dialect)
    count = program.source.line_count
    first = data.draw(st.integers(0, count))
    last = data.draw(st.integers(first, count))
    out = b"".join(render(program, [edit(first, last, "G4 X1.")], SETTINGS))
    assert out.startswith(b"".join(program.source.raw(i) for i in range(first)))
    assert out.endswith(b"".join(program.source.raw(i) for i in range(last, count)))
    assert b"G4 X1." in out


def test_edits_that_overlap_name_both_passes() -> None:
    program = parse(read(b"G1 X1.\n" * 6), SETTINGS.dialect)
    with pytest.raises(OverlapError) as caught:
        render(program, [edit(1, 4, name="one"), edit(3, 5, name="two")], SETTINGS)
    assert "one (lines 2 to 4)" in str(caught.value)
    assert "two (lines 4 to 5)" in str(caught.value)


def test_insertions_stand_before_a_replacement_of_the_same_line() -> None:
    program = parse(read(b"G1 X1.\nG1 X2.\n"), SETTINGS.dialect)
    edits = [edit(1, 2, "X5."), edit(1, 1, "M8"), edit(1, 1, "M9")]
    lines = b"".join(render(program, edits, SETTINGS)).decode().splitlines()
    assert [line for line in lines if not line.startswith("(")] == ["G1 X1.", "M8", "M9", "X5."]


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"], ids=["LF", "CRLF", "CR"])
def test_new_blocks_take_the_line_end_of_the_file(end: bytes) -> None:
    out = chipbreak.rewrite(CUT.replace(b"\n", end), SETTINGS).data
    rest = out.replace(end, b"")
    assert b"\r" not in rest
    assert b"\n" not in rest


@given(data=st.binary(max_size=300))
def test_a_program_that_asks_nothing_comes_out_byte_for_byte(data: bytes) -> None:
    try:
        result = chipbreak.rewrite(data, SETTINGS)
    except chipbreak.ProgramRejectedError:
        return
    assert result.data == data
    assert not result.changed


_LINES = st.sampled_from(
    [
        "%",
        "O1000",
        "G0 X20. Z2.",
        "G1 Z-3. F0.1",
        "N10 X5",
        "(note)",
        "",
        "/M8",
        "G97 S500 M3",
        "#1=#2+3",
        "G71 P1 Q2",
        "IF[#1EQ2]GOTO10",
        "x1 y2",
        "T0101",
        "?!",
        "G2 X1. R5.",
        "M30",
        "\xe9\x00",
    ]
)


@pytest.mark.few(50)
@given(st.lists(_LINES, max_size=25), st.sampled_from(["\n", "\r\n", "\r"]), st.booleans())
def test_a_likely_program_that_asks_nothing_comes_out_byte_for_byte(
    lines: list[str], end: str, last: bool
) -> None:
    data = (end.join(lines) + (end if last else "")).encode("latin-1")
    for profile in ("generic-lathe", "fanuc-lathe", "linuxcnc-lathe"):
        result = chipbreak.rewrite(data, chipbreak.load(profile))
        assert result.data == data
        assert not result.changed


# Programs of other controls that a profile refuses, because their words look like ours.
_REFUSED = {
    "GCodeProjects-GCodeWorkShop__OSP7000L.nc": "Okuma: a block number behind G85, and E is a feed",
    "Michael-F-Bryan-gcode-rs___gcodeLexer_samples.ngc": "a printer: E is an extruder",
}


@pytest.mark.parametrize("profile", ["generic-lathe", "fanuc-lathe", "linuxcnc-lathe"])
def test_the_corpus_comes_out_byte_for_byte(profile: str, corpus: list[Path]) -> None:
    settings = chipbreak.load(profile)
    wrong = []
    for file in corpus:
        data = file.read_bytes()
        if len(data) > 300_000 or file.name in _REFUSED:
            continue
        try:
            result = chipbreak.rewrite(data, settings, file.name)
        except chipbreak.ProgramRejectedError as error:
            wrong.append(f"{file.name}: {error}")
            continue
        if result.data != data or result.changed:
            wrong.append(f"{file.name}: changed")
    assert not wrong


# --- the self-check ---------------------------------------------------------------------------------------


def planned(data: bytes, *sets: str) -> tuple[InterpretedProgram, list[Edit], bytes]:
    settings = chipbreak.load("generic-lathe", sets)
    interpreted = interpret(parse(read(data), settings.dialect), settings)
    edits = edits_of_cuts(interpreted, requests_of(interpreted).requests).edits
    return interpreted, edits, b"".join(render(interpreted.program, edits, settings))


def resealed(output: bytes) -> bytes:
    """The output with checksums that fit again, so that only what the blocks do can give it away."""
    from chipbreak.editing.bracket import checksum

    text = output.decode("latin-1")

    def seal(match: re.Match[str]) -> str:
        content = match[2].encode("latin-1")
        return f"{match[1]}{match[2]}(CHIPBREAK END {checksum(content)})"

    pattern = r"(\(CHIPBREAK BEGIN[^\n]*\n)(.*?)\(CHIPBREAK END [0-9A-F]+\)"
    return re.sub(pattern, seal, text, flags=re.DOTALL).encode("latin-1")


def caught(interpreted: InterpretedProgram, edits: list[Edit], output: bytes) -> bool:
    """True when the self-check stops the output."""
    try:
        verify(interpreted, output, edits)
    except Exception as error:
        assert type(error).__name__ in ("SelfCheckError", "ProgramRejectedError"), error
        return True
    return False


TRACE, EDITS, OUTPUT = planned(CUT)
_BODY = range(OUTPUT.index(b"(CHIPBREAK BEGIN VIB"), OUTPUT.index(b"G1 X30."))


def test_the_output_as_it_is_passes() -> None:
    assert resealed(OUTPUT) == OUTPUT
    assert not caught(TRACE, EDITS, OUTPUT)


@pytest.mark.few(50)
@given(st.data())
def test_a_lost_line_is_caught(data: st.DataObject) -> None:
    lines = OUTPUT.splitlines(keepends=True)
    index = data.draw(st.integers(0, len(lines) - 1))
    assert caught(TRACE, EDITS, resealed(b"".join(lines[:index] + lines[index + 1 :]))), lines[index]


@pytest.mark.few(50)
@given(st.data())
def test_a_doubled_line_is_caught(data: st.DataObject) -> None:
    lines = OUTPUT.splitlines(keepends=True)
    index = data.draw(st.integers(0, len(lines) - 1))
    doubled = resealed(b"".join(lines[: index + 1] + lines[index:]))
    # A modal word said twice does the same, inside a change.
    assert caught(TRACE, EDITS, doubled) or lines[index] in (b"S2500\n", b"S3000\n")


@pytest.mark.few(50)
@given(st.data())
def test_a_changed_digit_of_a_position_is_caught(data: st.DataObject) -> None:
    words = re.finditer(rb"(?m)^(?:G1 )?Z-?[0-9.]+", OUTPUT[: _BODY.stop])
    places = [
        m.start() + i for m in words for i in range(m[0].index(b"Z"), len(m[0])) if m[0][i : i + 1].isdigit()
    ]
    at = data.draw(st.sampled_from([place for place in places if place in _BODY]))
    digit = OUTPUT[at : at + 1]
    # One step of the last digit may still be a rounding of the right place.
    far = [b"%d" % other for other in range(10) if abs(other - int(digit)) > 1]
    other = data.draw(st.sampled_from(far))
    mutant = resealed(OUTPUT[:at] + other + OUTPUT[at + 1 :])
    assert caught(TRACE, EDITS, mutant), mutant[at - 12 : at + 12]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"S2500\n", b"S2400\n"),
        (b"S3000\n(C", b"S2999\n(C"),
        (b"Z-3. F0.05\n", b"Z-3.1 F0.05\n"),
        (b"Z-3. F0.05\n", b"Z-3. F0.06\n"),
        (b"Z-3. F0.05\n", b"Z-3. F0.05\nM9\nM8\n"),
        (b"Z-3. F0.05\n", b"Z-3. F0.05\nG91\n"),
        (b"Z-3. F0.05\n", b"Z-3. F0.05\nT0202\n"),
        (b"S2500\n", b"S2500\nG0 X21.\n"),
        (b"S2500\n", b"S2500\nG0 Z5.\n"),
        (b"S2500\n", b"G96 S2500\n"),
        (b"S3000\n(C", b"G96 S3000\n(C"),
        (b"S2500\n", b"S2500\nG94\n"),
        (b"(CHIPBREAK WAS G1 Z-3. F0.05 N1.5)", b"(CHIPBREAK WAS G1 Z-3. F0.05 N2.5)"),
        (b"G1 X30.\n", b"G1 X31.\n"),
        (b"M30", b"M02"),
    ],
)
def test_a_mutant_is_caught(old: bytes, new: bytes) -> None:
    assert OUTPUT.count(old) >= 1
    mutant = resealed(OUTPUT.replace(old, new, 1))
    assert caught(TRACE, EDITS, mutant)


def test_a_speed_that_no_feed_depends_on_is_checked_too() -> None:
    interpreted, edits, output = planned(CUT, "output.feed_mode=minute")
    assert not caught(interpreted, edits, output)
    assert caught(interpreted, edits, resealed(output.replace(b"S2500\n", b"S2400\n", 1)))


def test_a_file_without_a_last_line_end_keeps_none() -> None:
    data = CUT[: CUT.index(b"\nG1 X30.")]
    assert chipbreak.rewrite(data, SETTINGS).data.endswith(b")")


def test_feeds_that_take_another_time_are_caught() -> None:
    slower = re.sub(rb"F0\.1([0-9]+)", rb"F0.2\1", OUTPUT)
    assert slower != OUTPUT
    assert caught(TRACE, EDITS, resealed(slower))


def test_a_line_too_long_for_the_control_is_caught() -> None:
    mutant = OUTPUT.replace(b"S2500\n", b"S2500 (" + b"X" * 80 + b")\n", 1)
    assert caught(TRACE, EDITS, resealed(mutant))


CHECKED = (
    b"T1 M6\nS3000 M3\nM8\nG0 X0. Y0.\nG43 H1 Z5.\n(ROUGH)\nG1 Z-2. F300.\nX30.\nG0 Z5.\n"
    b"(FINISH)\nG0 X0. Y0.\nZ5.\nG1 Z-2.5 F300.\nX30.\nG0 Z5.\nM30\n"
)


@pytest.mark.parametrize("word", [b"M3", b"M8"])
def test_a_check_that_does_not_give_spindle_or_coolant_back_is_caught(word: bytes) -> None:
    settings = chipbreak.load("fanuc-mill", BEAM)
    result = chipbreak.rewrite(CHECKED, settings)
    interpreted = interpret(parse(read(CHECKED), settings.dialect), settings)
    first = result.data.index(b"BEGIN CHIP CHECK")
    last = result.data.index(b"(CHIPBREAK END", first)
    assert word in result.data[first:last]
    mutant = result.data[:first] + result.data[first:last].replace(word, b"") + result.data[last:]
    assert caught(interpreted, list(result.edits), resealed(mutant))
    assert not caught(interpreted, list(result.edits), result.data)


@pytest.mark.parametrize(
    ("profile", "program"),
    [
        ("speedio-renishaw", b"M3\nM30\n(SPEED V120D20)\nM5\n"),
        (
            "linuxcnc-mill",
            b"T8 M6\nS867 M3\nG0 X16 Y-11\nZ28\nG1 Y30 F90\nG0 Z20 M9\n(SEMI FINISH)\nG0 X29 Y-33\nM30\nZ2\n",
        ),
    ],
)
def test_what_stands_behind_the_end_is_another_program(profile: str, program: bytes) -> None:
    """It starts from the power-on state, and the proof of a change before it ends there."""
    assert chipbreak.rewrite(program, chipbreak.load(profile, BEAM)).edits


@pytest.mark.parametrize(
    ("promise", "content", "is_caught"),
    [
        (KEPT, "G0 X20.", False),
        (KEPT, "G1 X20.", True),
        (Promise(leaves_motion=True), "G1 X20.", False),
        (KEPT, "M5", True),
        (KEPT, "M9", True),
        (KEPT, "F0.2", True),
        (KEPT, "S900", True),
    ],
)
def test_an_edit_that_promises_nothing_leaves_all_in_force(
    promise: Promise, content: str, is_caught: bool
) -> None:
    """The next block says its own G0, so another code may be left where that is promised."""
    program = b"G99 G97 S1000 M3 F0.1\nM8\nG0 X20. Z2.\nG0 X30.\nM30\n"
    interpreted = interpret(parse(read(program), SETTINGS.dialect), SETTINGS)
    edit = Edit(3, 3, (content,), "TEST", "a reason", promise, "test")
    output = b"".join(render(interpreted.program, [edit], SETTINGS))
    assert caught(interpreted, [edit], output) == is_caught
