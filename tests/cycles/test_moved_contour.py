"""A G70 that stays finds its contour behind the end of the program; the roughing is written out."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

import chipbreak
from chipbreak.cycles.moved_contour import MovedContour
from chipbreak.editing.bracket import UNROLLED_CYCLES
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import Written
from chipbreak.editing.restore import regions
from chipbreak.model.flow import contour_calls
from chipbreak.model.from_source import interpret_source
from chipbreak.settings import load
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.text.source import read
from longer import short_where

HEAD = "O1\nG21 G40 G99\nT0101\nG97 S900 M3\nG0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U0.4 W0.1 F0.25\n"
CONTOUR = "N10 G0 X30. S1200\nG1 Z-30. F0.1 (SHOULDER)\nX40. ,R2.\nZ-40.\nN20 X52.\n"
WISH = (
    "vibration.n=auto",
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
    'vibration.only=["rough"]',
)
STAYS = {
    "a word that G70 has not": (CONTOUR, "G70 P10 Q20 U0.1 W0. D0.5 F0.1\nG1 X60. F0.2 S900\n"),
    "the next cut says no F": (CONTOUR, "G70 P10 Q20\nX60. S900\nG1 X55.\n"),
    "T in the contour": (CONTOUR.replace("S1200", "S1200 T0202"), "G70 P10 Q20\nG1 X60. F0.2 S900\n"),
}
TAIL = "G28 U0 W0\nM30\n"


ENDS = ("M30\n", "N99 M2\n", "M30 (END)\n%\n", "M99\nO2\nG0 X1.\nM99\n")
# The ends in turn: what keeps the contour and what ends the program have nothing to do with each other.
_EACH_WITH_AN_END = short_where(
    [(contour, rest, end) for contour, rest in STAYS.values() for end in ENDS],
    lambda case: list(STAYS.values()).index(case[:2]) in (ENDS.index(case[2]), ENDS.index(case[2]) - 1),
)


@pytest.mark.parametrize(("contour", "rest", "end"), _EACH_WITH_AN_END)
def test_the_roughing_is_written_and_the_contour_stands_behind_the_end(
    contour: str, rest: str, end: str
) -> None:
    program = (HEAD + contour + rest + "G28 U0 W0\n" + end).encode()
    settings = load("fanuc-lathe", WISH)
    result = chipbreak.rewrite(program, settings)
    assert result.cuts
    assert b"UNROLLED G71 P10 Q20" in result.data
    assert chipbreak.restore(result.data) == program
    assert chipbreak.rewrite(result.data, settings).data == result.data
    # As a control looks for it: from the cycle on, and then from the top.
    interpreted = interpret_source(read(result.data), settings)
    (call,) = contour_calls(interpreted.program, settings.dialect)
    assert call.first is not None and call.last is not None
    found = [interpreted.program.block(line).text for line in range(call.first, call.last + 1)]
    assert found == contour.splitlines()
    assert interpreted.before(call.first).ended
    lines = result.data.decode().splitlines()
    assert [line for line in lines if line.startswith(("N10", "N20"))] == [found[0], found[-1]]
    assert rest.splitlines()[0] in lines


def test_a_finishing_cycle_that_is_asked_is_said() -> None:
    """Its roughing is written all the same."""
    contour, rest = STAYS["T in the contour"]
    program = (HEAD + contour + rest + TAIL).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ['cycles.unroll="always"']))
    assert b"UNROLLED G71 P10 Q20" in result.data
    (said,) = [one for one in result.diagnostics if one.code == "CYC002"]
    assert "T0202" in said.message
    assert said.message.endswith("the cycle stays as it was")


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (("M30", "M5"), "no end"),
        (("M30", "/M30"), "no sure end"),
        (("T0101", "N10 T0101"), "a number on two blocks"),
        (("G28 U0 W0", "GOTO10"), "a jump"),
    ],
)
def test_where_that_is_not_sure_all_of_them_stay(change: tuple[str, str], why: str) -> None:
    contour, rest = STAYS["T in the contour"]
    program = (HEAD + contour + rest + TAIL).replace(*change).encode()
    result = chipbreak.rewrite(program, load("fanuc-lathe", ['cycles.unroll="always"']))
    assert result.data == program, why
    assert [one for one in result.diagnostics if one.code.startswith("CYC")]


def test_roughing_passes_over_the_tool_of_the_contour() -> None:
    """The passes are those of the contour without T."""
    outputs = []
    for contour in (CONTOUR, CONTOUR.replace("S1200", "S1200 T0202")):
        program = (HEAD + contour + TAIL).encode()
        outputs.append(chipbreak.rewrite(program, load("fanuc-lathe", ['cycles.unroll="always"'])).data)
    passes = [data.split(b"PASS 1")[1].split(b"CHIPBREAK ROLLED")[0] for data in outputs]
    assert passes[0] == passes[1]


@pytest.mark.parametrize(
    ("number", "between", "holds"),
    [
        (10.0, "", True),
        (99.0, "", False),  # no cycle names it
        (10.0, "N10 G0 X50.\n", False),  # which the cycle would find first
    ],
)
def test_a_contour_that_its_cycle_does_not_find_is_a_fault(number: float, between: str, holds: bool) -> None:
    contour, rest = STAYS["T in the contour"]
    settings = load("fanuc-lathe", ['cycles.unroll="always"'])
    program = HEAD + contour + rest + TAIL
    data = chipbreak.rewrite(program.encode(), settings).data.decode().replace(rest, rest + between)
    was, now = (interpret_source(read(text.encode()), settings) for text in (program, data))
    region = regions(read(data.encode()), UNROLLED_CYCLES)[-1]
    texts = ("M30", *contour.splitlines())
    promise = MovedContour(numbers=(number, 20.0), texts=texts)
    line = program.count("\n") - 1
    edit = Edit(line, line + 1, texts, "", "", promise)
    with nullcontext() if holds else pytest.raises(SelfCheckError, match=f"N{number:g} is not found"):
        promise.check(Written(edit, region, was, now, line))
