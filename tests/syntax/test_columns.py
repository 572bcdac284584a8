"""Numbers of many lines at once, against one line after the other."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chipbreak.dialects import find
from chipbreak.syntax.columns import (
    _even_numbers,
    _numbers,
    read_columns,
    read_words,
    repeats,
    uniform_run,
)
from chipbreak.syntax.parse import Program, parse
from chipbreak.text.source import read

FANUC = find("fanuc-mill", "A")


def program_of(*lines: str) -> Program:
    return parse(read("".join(f"{line}\n" for line in lines).encode("latin-1")), FANUC)


# --- texts of numbers -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "count", "width", "even"),
    [
        (" 1.50 -2.5\n 10.25 7.0\n", 2, 2, True),
        (" 1. 2.5\n 3. 4.0\n", 2, 2, True),
        (" .5\n -.5\n", 2, 1, True),
        ("1.123456789\n2.000000001\n", 2, 1, True),
        ("1.5 \n2.5 \n", 2, 1, True),
        # Other decimals in another row: a digit less, a digit more, none.
        (" 1.50\n 10.2\n", 2, 1, False),
        (" 1.5\n 10.25\n", 2, 1, False),
        (" 1.5\n 10.\n", 2, 1, False),
        (" 1.\n 10.5\n", 2, 1, False),
        # No point, a point too many, no rows.
        (" 1.5\n 10\n", 2, 1, False),
        (" 1.5\n 10.5 3.5\n", 2, 1, False),
        ("", 0, 1, False),
        # A number that stands where none is asked for, and digits that no float holds.
        (" 1.5 7\n 10.5\n", 2, 1, False),
        (" 9007199254740.991\n", 1, 1, True),
        (" 9007199254740.992\n", 1, 1, False),
        ("-9007199254740.992\n", 1, 1, False),
    ],
)
def test_numbers_with_as_many_decimals_in_every_row(text: str, count: int, width: int, even: bool) -> None:
    found = _even_numbers(text.encode(), count, width)
    assert (found is not None) is even
    if found is not None:
        assert found.tolist() == [float(one) for one in text.split()]


digits = st.integers(0, 10**14).map(str)
written = st.tuples(
    st.sampled_from(["", "-"]), digits, st.sampled_from(["", ".", ".0", ".05", ".123456789012"])
).map("".join)


@pytest.mark.few(60)
@given(
    st.lists(written, min_size=1, max_size=12),
    st.sampled_from([" ", "  ", "\n", " \n "]),
    st.sampled_from(["", " ", "\n"]),
)
def test_numbers_of_any_kind_are_read_to_the_last_digit(numbers: list[str], between: str, end: str) -> None:
    text = between.join(numbers) + end
    assert _numbers(text.encode()).tolist() == [float(one) for one in numbers]


@pytest.mark.parametrize(
    "text",
    [
        "9007199254740991 1",
        "9007199254740992 1.5",
        "9007199254740993.5",
        "-9007199254740993",
        "0.1234567890123456789012",
        "0.12345678901234567890123",
        "0." + "0" * 21 + "1",
        "0." + "0" * 22 + "1",
        "0." + "0" * 25 + "1 2.5",
        "1.5",
        "7",
        ".5 -.5 5. 5",
        "",
    ],
)
def test_numbers_that_lie_at_the_edge_of_what_is_read_as_whole(text: str) -> None:
    assert _numbers(text.encode()).tolist() == [float(one) for one in text.split()]


# --- runs and columns -------------------------------------------------------------------------------------


def words_of(line: str) -> tuple[str, int | None] | None:
    """The letters of a plain line and its code of motion."""
    match = re.fullmatch(r"(?:N\d+ ?)?(?:G0?([0-3]) ?)?((?: ?[XYZF]-?[0-9.]+)+)", line)
    return match and (re.sub(r"[^XYZF]", "", match[2]), int(match[1]) if match[1] else None)


RUN_LINES = [
    "X1.5 Z2.",
    "X10 Z-2.25",
    "Z2. X1.",
    "N10 X1. Z2.",
    "G1 X1. Z2.",
    "G2 X1. Z2.",
    "M8",
    "X1.",
    "G01 X1. Z2.",
]


@given(
    st.lists(
        st.tuples(st.sampled_from(RUN_LINES), st.sampled_from([1, 1, 2, 63, 64, 65, 200])),
        min_size=1,
        max_size=4,
    ),
    st.integers(0, 3),
    st.integers(0, 3),
)
@pytest.mark.few(40)
def test_a_run_ends_where_other_words_begin(rows: list[tuple[str, int]], skipped: int, cut: int) -> None:
    lines = [line for line, count in rows for _ in range(count)]
    program = program_of(*lines)
    last = max(len(lines) - cut, 0)
    first = min(skipped, last)
    wanted = first
    while wanted < last and words_of(lines[wanted]) == words_of(lines[first]) is not None:
        wanted += 1
    if first < last and words_of(lines[first]) is None:
        wanted = first + 1
    assert uniform_run(program, first, last) == wanted


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        (["X1.5 Z2.", "X-3. Z4.25"], ("XZ", [[1.5, 2.0], [-3.0, 4.25]])),
        (["X1.5Z2.", "X 3.5  Z4."], ("XZ", [[1.5, 2.0], [3.5, 4.0]])),
        (["X1 Z2.", "X3. Z4."], ("XZ", [[1.0, 2.0], [3.0, 4.0]])),
        (["X1.5 Z2.", "Z2. X1.5"], None),
        (["X1.5 Z2.", "M8"], None),
        (["N1 X1.5 Z2.", "N2 X1.5 Z2."], None),
        (["G1 X1.5 Z2.", "G1 X1.5 Z2."], None),
        (["G1 X1.5 Z2.", "X1.5 Z2."], None),
    ],
)
def test_columns_of_lines_of_one_kind(lines: list[str], found: tuple[str, list[list[float]]] | None) -> None:
    """With a line of another kind before and behind, which is not asked for."""
    columns = read_columns(program_of("Y5.", *lines, "Y6."), 1, len(lines) + 1)
    assert (columns and (columns[0], columns[1].tolist())) == found


# --- a line that comes again and again --------------------------------------------------------------------


def many(repeated: str, *plain: str, count: int = 8) -> list[str]:
    return [repeated, *plain] * count


@pytest.mark.parametrize("code", ["", "G1 "])
@pytest.mark.parametrize("between", [1, 2, 3])
def test_a_line_that_comes_again(code: str, between: int) -> None:
    plain = [f"{code}X{number}.5 Z-{number}.25" for number in range(between)]
    lines = ["M8", *many("G4 P0.1", *plain, count=9), "M9"]
    # Seen where a plain line stands at most two lines behind.
    found = repeats(program_of(*lines), 1, len(lines))
    assert found is not None
    assert (found.first, found.last, found.letters, found.says_line) == (1, len(lines) - 1, "XZ", code != "")
    assert found.repeated.tolist() == [at for at, line in enumerate(lines) if line == "G4 P0.1"]
    assert found.before.tolist() == [between * number for number in range(9)]
    assert found.numbers.tolist() == [[number + 0.5, -number - 0.25] for number in range(between)] * 9


@pytest.mark.parametrize(
    ("lines", "last"),
    [
        (many("G4 P0.1", "X1."), 16),
        (many("G4 P0.1", "X1.", count=7), None),
        ([*many("G4 P0.1", "X1.", count=7), "G4 P0.1"], 15),
        # Where the first plain line stands too far behind, or not at all.
        (["G4 P0.1", *many("G4 P0.1", "X1.")], 17),
        (["G4 P0.1", "G4 P0.1", *many("G4 P0.1", "X1.")], None),
        (["G4 P0.1"] * 20, None),
        # To the first line that is neither.
        ([*many("G4 P0.1", "X1."), "G4 P0.2", *many("G4 P0.1", "X1.")], 16),
        ([*many("G4 P0.1", "X1."), "G4 P.1", *many("G4 P0.1", "X1.")], 16),
        ([*many("G4 P0.1", "X1."), "Y1.", *many("G4 P0.1", "X1.")], 16),
        ([*many("G4 P0.1", "X1."), "X1", *many("G4 P0.1", "X1.")], 16),
        ([*many("G4 P0.1", "X1.", count=100), "M9"], 200),
        # What could not be told apart from others.
        (many("G4 P0.1", "X1"), None),
        (many("G4 P0.1", "N5 X1."), None),
        (many("G4 P0.1", "G0 X1."), None),
        (many("G4 P0.1", "G2 X1."), None),
    ],
)
def test_where_a_line_comes_again(lines: list[str], last: int | None) -> None:
    found = repeats(program_of(*lines, "M30"), 0, len(lines))
    assert (found and found.last) == last
    assert found is None or found.numbers.tolist() == [[1.0]] * lines[:last].count("X1.")


def test_no_line_behind_the_asked_ones_counts() -> None:
    program = program_of(*many("G4 P0.1", "X1.", count=20))
    found = repeats(program, 2, 22)
    assert found is not None and (found.first, found.last, len(found.repeated)) == (2, 22, 10)
    assert repeats(program, 2, 3) is None
    assert repeats(program, 2, 16) is None


# --- words of any plain lines -----------------------------------------------------------------------------


def test_words_of_plain_lines_of_any_kind() -> None:
    lines = ["X1.5 Z-2.", "N20 G1 Z3 F0.25", "Y7.", "G2 X1. Z2. R.5", "N5 X-0.125"]
    found = read_words(program_of("M8", *lines, "Y1.", "M9"), 1, 6, "ZXR")
    assert found is not None
    nan = np.nan
    wanted = [[-2.0, 1.5, nan], [3.0, nan, nan], [nan, nan, nan], [2.0, 1.0, 0.5], [nan, -0.125, nan]]
    np.testing.assert_array_equal(found, np.array(wanted))
    none = read_words(program_of("X1."), 0, 0, "X")
    assert none is not None and none.shape == (0, 1)
