"""The shapes of lines do not depend on how many lines are looked at at once, nor on other bytes nearby."""

from __future__ import annotations

import numpy as np
import pytest

from chipbreak.dialects import find
from chipbreak.syntax import shapes
from chipbreak.syntax.grammar import grammar_of
from chipbreak.syntax.shapes import LONGEST_PLAIN, Shape, ShapeReader, ShapeTable, classify
from chipbreak.text.source import read

FANUC = find("fanuc-mill", "A")


def found(data: bytes, first: int = 0, stop: int | None = None) -> list[Shape | None]:
    """What each line is."""
    source = read(data)
    table = ShapeTable(grammar_of(FANUC))
    ids = classify(source, table, first, source.line_count if stop is None else stop)
    return [table.shapes[at] if at >= 0 else None for at in ids.tolist()]


LINES = [
    b"X1. Y2.",
    b"G1 X-1.5",
    b"N5 Z3",
    b"M8",
    b"X1\xff.",
    b"X\x02 1.",
    b"G2X1.R5.",
    b"",
    b"X1.X2.",
    b"(X1.)",
    b"Y.5",
]


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r", b"\n\r\r"])
@pytest.mark.parametrize("chunk", [1, 8, 20, 50, 1 << 18])
def test_lines_in_chunks_are_what_they_are_alone(
    monkeypatch: pytest.MonkeyPatch, end: bytes, chunk: int
) -> None:
    alone = {line: found(b"M3" + end + line + end)[1] for line in LINES}
    monkeypatch.setattr(shapes, "_CHUNK_BYTES", chunk)
    draw = np.random.default_rng(7)
    lines = [LINES[at] for at in draw.integers(0, len(LINES), 60)]
    data = b"M3" + end + end.join(lines) + end
    wanted = [None, *(alone[line] for line in lines)]
    assert found(data) == wanted
    assert found(data, 5, 31) == wanted[5:31]
    assert found(data, 5, 5) == []


def test_what_lines_alone_are() -> None:
    assert [found(line + b"\n")[0] for line in LINES if line] == [
        Shape("XY", None, has_points=True, numbered=False),
        Shape("X", 1, has_points=True, numbered=False),
        Shape("Z", None, has_points=False, numbered=True),
        None,
        None,
        None,
        Shape("XR", 2, has_points=True, numbered=False),
        None,
        None,
        Shape("Y", None, has_points=True, numbered=False),
    ]


@pytest.mark.parametrize(
    ("line", "motion"),
    [
        (b"G0X1.", 0),
        (b"G00X1.", 0),
        (b"G1X1.", 1),
        (b"G01 X1.", 1),
        (b"G2X1.", 2),
        (b"G03X1.", 3),
        (b"G3 X1.", 3),
    ],
)
def test_codes_of_motion(line: bytes, motion: int) -> None:
    (one,) = found(line)
    assert one is not None and (one.motion, one.letters) == (motion, "X")


@pytest.mark.parametrize(
    "line",
    [
        b"G4X1.",
        b"G04X1.",
        b"G10X1.",
        b"G001X1.",
        b"G100X1.",
        b"G1.X1.",
        b"G1.5X1.",
        b"GX1.",
        b"G-1X1.",
        b"X1.G1",
        b"G1G0X1.",
    ],
)
def test_what_is_no_code_of_motion(line: bytes) -> None:
    assert found(line) == [None]


@pytest.mark.parametrize(
    ("line", "is_plain"),
    [
        (b"X-1.", True),
        (b"X-.5", True),
        (b"X+1.", True),
        (b"X- 1.", False),
        (b"X--1.", False),
        (b"X-", False),
        (b"X.", False),
        (b"X1.5.", False),
        (b"X1-2.", False),
        (b"X 1.", True),
        (b"X\t1. ", True),
        (b" X1.", True),
        (b"x1.", False),
        (b"X1.Y2.Z3.U4.V5.W6.A7.B8.C9.I1.J2.K3.R4.F5.", True),
        (b"D5", False),
        (b"/X1.", False),
        (b"N5", False),
        (b"N5 X1.", True),
        (b"N5.5X1.", True),
        (b"X1. N5", False),
        (b"-X1.", False),
        (b"-", False),
        (b".X1.", False),
    ],
)
def test_what_is_plain(line: bytes, is_plain: bool) -> None:
    assert (found(line)[0] is not None) is is_plain
    assert (found(b"M8\n" + line + b"\nM8\n")[1] is not None) is is_plain


@pytest.mark.parametrize(("length", "is_plain"), [(LONGEST_PLAIN, True), (LONGEST_PLAIN + 1, False)])
def test_how_long_a_plain_line_is(length: int, is_plain: bool) -> None:
    line = b"X1." + b" " * (length - 4) + b"\n"
    assert len(line) == length
    assert (found(line + b"X2.\n")[0] is not None) is is_plain
    assert found(line + b"X2.\n")[1] is not None
    assert ShapeReader(grammar_of(FANUC)).read(b"X\0" + b" " * (LONGEST_PLAIN - 2)) is not None
    assert ShapeReader(grammar_of(FANUC)).read(b"X\0" + b" " * (LONGEST_PLAIN - 1)) is None


@pytest.mark.parametrize(
    ("line", "may"),
    [
        (b"X1. N1.5", True),
        (b"N 1.5 X1.", True),
        (b"N.5", True),
        (b"N15 X1.5", False),
        (b"N15.", False),
        (b"X1.5", False),
        (b"(N1.5)", True),
    ],
)
def test_which_lines_may_have_a_fraction_behind_n(line: bytes, may: bool) -> None:
    table = ShapeTable(grammar_of(FANUC))
    source = read(b"X1.\n" + line + b"\n")
    classify(source, table, 0, 2)
    assert table.may_have_fraction_behind_n() is may


def test_a_shape_is_read_once() -> None:
    table = ShapeTable(grammar_of(FANUC))
    source = read(b"X1.\nX-22.\nY1.\nX3.\nM8\nM9\n")
    assert classify(source, table, 0, 6).tolist() == [0, 0, 1, 0, -1, -1]
    assert len(table.shapes) == 2
