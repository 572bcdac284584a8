"""Whatever is mixed around the cuts, a Fanuc control does the same outside the changes as it did before.

The original is held against the filtered program on a second reader of Fanuc's words, which knows nothing of
the package: each block outside the brackets with the state that it meets, and the state behind each bracket.
``make test`` draws some programs, ``make fuzz`` others, and
``python tests/mixed_search.py fanuc 100000`` as many as one likes.
"""

from __future__ import annotations

import math
from random import Random

import pytest
from hypothesis import event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from brackets import marked
from lines_anywhere import changed

from .compared import checked, difference, differing, settings_of
from .programs import program
from .reader import Control, Record, run

EXAMPLES = 150 if hypothesis_settings.default and hypothesis_settings.default.derandomize else 2000
LATHE, MILL = Control("A"), Control()


@pytest.mark.few(25)
@given(st.integers(0, 2**32 - 1))
@hypothesis_settings(max_examples=EXAMPLES)
def test_all_else_stays_as_it_was(seed: int) -> None:
    text, control = program(seed)
    found, wrong = checked(text, control)
    event(found)
    assert not wrong, f"{wrong}\n{control}\n{text}"


@pytest.mark.parametrize("seed", range(12))
def test_lines_and_words_anywhere(seed: int) -> None:
    """A few of what ``tests/mixed_search.py fanuc-lines`` draws."""
    text, control = program(seed)
    other = changed(Random(seed), text, "fanuc")
    assert changed(Random(seed), text, "fanuc") == other
    assert not checked(other, control)[1]


# --- the reader itself ------------------------------------------------------------------------------------


def last(text: str, control: Control) -> Record:
    return run(text, control)[-1]


def at(text: str, control: Control = LATHE) -> list[float]:
    """Where the program's coordinates are at the end."""
    state = last(text, control).state
    place, zero = state["at"], state["zero"]
    assert isinstance(place, tuple)
    assert isinstance(zero, tuple)
    return [round(place[i] - zero[i], 6) for i in range(3)]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("G0 X10. Z20.\nG1 U2. W-5. F0.1", (12.0, 15.0)),
        ("G20\nG0 X1. Z2.", (25.4, 50.8)),
        ("G0 X10. Z20.\nG4 X3.\nG0 Z21.", (10.0, 21.0)),
        ("G0 X10. Z20.\nG50 X30.\nG1 W1. F0.1", (30.0, 21.0)),
        ("G0 X10. Z20.\nG50 U5.\nG1 W1. F0.1", (15.0, 21.0)),
        ("G0 X10. Z20.\nG52 Z5.\nG1 U1. F0.1", (11.0, 15.0)),
        ("G0 X10. Z20.\nG10 L2 P1 Z505.\nG1 U1. F0.1", (11.0, 15.0)),
        ("G0 X10. Z20.\nG90 X8. Z10. F0.1\nG0 W1.", (10.0, 21.0)),
        ("G0 X10. Z20.\nM98 P2 L3\nG0 U0.\nM30\nO2\nG0 U1.\nM99", (13.0, 20.0)),
        ("G0 X10. Z20.\n/G0 X20.\nG0 W1.", (20.0, 21.0)),
    ],
)
def test_where_a_lathe_is(text: str, place: tuple[float, float]) -> None:
    found = at(text)
    assert (found[0], found[2]) == place


def test_where_a_mill_is() -> None:
    assert at("G90 G0 X10. Y20. Z30.\nG91 G1 X1. Y-1.\nG90 Z5.", MILL) == [11.0, 19.0, 5.0]
    assert at("G90 G0 X10. Y20. Z30.\nG99 G81 Z2. R4. F100.\nX13.\nG80\nG91 G0 Y1.", MILL) == [
        13.0,
        21.0,
        4.0,
    ]
    assert at("G91 G0 X1.\nG90 G0 Z30.\nX10.\nG91 G81 Z-5. R-1. X1. K3\nG80\nG90 Y3.", MILL) == [
        13.0,
        3.0,
        30.0,
    ]
    assert at("G90 G0 X10. Y20. Z30.\nG43 H2 Z50.\nG49\nX0.", MILL) == [0.0, 20.0, 112.0]


def test_home_and_machine_coordinates() -> None:
    state = last("G0 X10. Z20.\nG28 U0 W0", LATHE).state
    assert state["at"] == (0.0, 19.0, 0.0)
    assert last("G0 X10. Z20.\nG53 X5. Z6.", LATHE).state["at"] == (5.0, 19.0, 6.0)
    assert last("G0 X10. Z20.\nG30 P2 U0", LATHE).state["at"] == (-100.0, 19.0, 520.0 + 0.0)


@pytest.mark.parametrize(("size", "centre"), [("R5.", (25.0, 5.0)), ("K5.", (25.0, 5.0))])
def test_the_centre_of_an_arc(size: str, centre: tuple[float, float]) -> None:
    """G3 from Z20 X10 (radius 5) round Z25: a half circle on to Z30."""
    record = last(f"G54\nG0 X10. Z20.\nG3 X10. Z30. {size} F0.1", LATHE)
    zero = record.state["zero"]
    assert isinstance(zero, tuple)
    assert record.numbers[0] == 3.0
    assert math.isclose(record.numbers[1] - zero[2], centre[0])
    assert math.isclose(record.numbers[2] - zero[0] / 2.0, centre[1])


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("G50 S2000\nS500 M3\nG1 X1. F0.1", "most", 2000.0),
        ("G96 S120 M3\nG1 X1. F0.1", "speed", (True, 120.0)),
        ("G96 S120 M3\nG97 S900\nG96\nG1 X1. F0.1", "speed", (True, 120.0)),
        ("G50 X30.\nG96 S120 M3\nG97\nG1 X1. F0.1", "speed", (False, ("of", 120.0, 30.0))),
        ("G20\nG96 S100 M3\nG1 X1. F0.1", "speed", (True, 30.48)),
        ("G98 F100.\nG1 X1.", "feed", ("min", "min", 100.0)),
        ("M8\nG1 X1. F0.1 M9\nG1 X2.", "coolant", ()),
        ("M3 S100\nG1 X1. F0.1 M5\nG1 X2.", "spindle", 5),
        ("T0203\nG1 X1. F0.1", "tool", (2.0, 3.0, 0.0, (40, 0.0))),
    ],
)
def test_what_holds_for_a_cut(text: str, key: str, value: object) -> None:
    found = last(text, LATHE).state[key]
    assert found == pytest.approx(value) if isinstance(value, float) else found == value


def test_block_delete_skips() -> None:
    assert at("G0 X10. Z20.\n/G0 X20.\nG0 W1.", Control("A", block_delete=True))[0] == 10.0


@pytest.mark.parametrize("inside", ["F0.3", "S900", "M5", "G98", "G20", "G1 Z4. F0.1", "T0202", "G55", "M8"])
def test_a_change_that_a_bracket_leaves_behind_is_found(inside: str) -> None:
    """The comparison can fail: one word too much inside a bracket."""
    begin, end = "(CHIPBREAK BEGIN VIB N1.5)", "(CHIPBREAK END 00000000)"
    start = "G21 G99\nT0101\nG97 S2000 M3\nG0 X30. Z5. F0.1"
    was = run(f"{start}\n{begin}\n{end}\nG1 X20.\nM30", LATHE)
    now = run(f"{start}\n{begin}\n{inside}\n{end}\nG1 X20.\nM30", LATHE)
    assert [one.state for one in was] != [other.state for other in now]


def test_a_filtered_program_that_was_spoilt_is_found() -> None:
    text, control = program(0)
    data = chipbreak.rewrite(text.encode(), settings_of(control), allow_unbroken=True).data
    assert not difference(data, control)
    assert data.count(b"(CHIPBREAK END") > 0
    for words in ("F0.777", "M5", "G1 X77.7", "G58", "(CHIPBREAK END 00000000)"):
        spoilt = data.decode().replace("(CHIPBREAK END", f"{words}\n(CHIPBREAK END", 1)
        assert differing(marked(data).decode("latin-1"), spoilt, control), words
