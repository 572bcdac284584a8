"""Which cycles share a contour, where a contour ends, and both sides of a nose."""

from __future__ import annotations

import pytest

from chipbreak.cycles.nose import Nose
from chipbreak.cycles.nose_runs import compensated_runs, offset_run
from chipbreak.cycles.plan import _groups
from chipbreak.editing.bracket import UNROLLED_CYCLES
from chipbreak.editing.render import render
from chipbreak.model.flow import ContourCall
from chipbreak.self_check import verify_unrolled
from chipbreak.text.diagnostics import SelfCheckError

from .planned import blocks, edits, interpreted
from .test_what_is_said import PROGRAMS

Lines = tuple[int | None, int | None]


@pytest.mark.parametrize(
    ("one", "other", "is_shared"),
    [
        ((5, 9), (5, 9), True),
        ((5, 9), (9, 12), True),
        ((9, 12), (5, 9), True),
        ((5, 9), (10, 12), False),
        ((10, 12), (5, 9), False),
        ((5, 12), (7, 8), True),
        ((5, 5), (5, 5), True),
        ((None, 9), (5, 9), False),
        ((5, None), (5, 9), False),
        ((5, 9), (None, 9), False),
        ((5, 9), (5, None), False),
        ((None, None), (None, None), False),
    ],
)
def test_cycles_belong_together_where_their_contours_share_a_line(
    one: Lines, other: Lines, is_shared: bool
) -> None:
    calls = [ContourCall(1, *one), ContourCall(2, *other)]
    assert _groups(calls) == ([calls] if is_shared else [[calls[0]], [calls[1]]])


def test_a_cycle_may_bring_others_together() -> None:
    """The third one shares lines with both before it, the fourth with none."""
    calls = [ContourCall(1, 10, 12), ContourCall(2, 14, 16), ContourCall(3, 12, 14), ContourCall(4, 20, 22)]
    assert _groups(calls) == [calls[:3], calls[3:]]


@pytest.mark.parametrize(
    "end", ["N20 X52.", "X52.\nN20 G0 Z2.", "X52.\nG0 X56.\nN20 Z2.", "X52.\nG1 X54.\nG0 X60. Z-20.\nN20 Z2."]
)
def test_the_way_back_at_the_end_is_no_part_of_a_contour(end: str) -> None:
    wanted = blocks(edits(PROGRAMS["G71"])[0])
    assert blocks(edits(PROGRAMS["G71"].replace("N20 X52.", end))[0]) == wanted


@pytest.mark.parametrize(
    ("end", "cuts"),
    [("X50.\nN20 G0 X56.", ["G1 X50.4", "G1 X56.4"]), ("X56.\nN20 X60.", ["G1 X30.4 Z-29.9", "G1 X56.4"])],
)
def test_what_begins_below_the_start_is(end: str, cuts: list[str]) -> None:
    """Up through the height of the start, X52."""
    said = blocks(edits(PROGRAMS["G71"].replace("N20 X52.", end))[0])
    assert said[-4:] == [*cuts, "G0 Z2.", "G0 X52."]


OUTER = "G42 G0 X28. Z2.\nG1 X30. Z0. F0.2\nZ-20.\nX40. Z-30.\nG1 X50.\nZ-50.\nX62.\nG40 G0 X80. Z5.\n"
# The same at 70 mm less the diameter: a bore.
INNER = "G41 G0 X42. Z2.\nG1 X40. Z0. F0.2\nZ-20.\nX30. Z-30.\nG1 X20.\nZ-50.\nX8.\nG40 G0 X-10. Z5.\n"


def test_a_bore_is_the_mirror_image_of_a_shaft() -> None:
    """Its diameters and those of the shaft are 70 mm together."""
    found = []
    for shape, start, tip in ((OUTER, "X60.", 3), (INNER, "X10.", 2)):
        read = interpreted(f"T0101\nG97 S800 M3\nG0 {start} Z5.\n{shape}M30\n")
        (run,) = compensated_runs(read)
        edit = offset_run(read, run, Nose(0.8, tip)).edit
        found.append(blocks(edit))
        assert edit.title == f"{shape[:3]} R0.8 T{tip}"
    assert found == [
        [
            *("G0 X27.831 Z1.558", "F0.2 G1 X30. Z-0.611", "G1 Z-20.611", "G1 X39.389 Z-30.", "G1 X50."),
            *("G1 Z-50.", "G1 X60.4", "G0 X80. Z5."),
        ],
        [
            *("G0 X42.169 Z1.558", "F0.2 G1 X40. Z-0.611", "G1 Z-20.611", "G1 X30.611 Z-30.", "G1 X20."),
            *("G1 Z-50.", "G1 X9.6", "G0 X-10. Z5."),
        ],
    ]


@pytest.mark.parametrize(
    ("old", "new"),
    [("G1 Z-15.", "G1 Z-16."), ("N10 G0 X16. F0.1", "N11 G0 X16. F0.1"), ("N20 X52. M8", "N21 X52. M8")],
)
def test_a_contour_that_was_moved_is_looked_for(old: str, new: str) -> None:
    program = PROGRAMS["G71 and G70"].replace("N20 X52.", "N20 X52. M8")
    read = interpreted(program)
    found = edits(program)
    moved = found[-1]
    assert old in moved.content

    def said(content: tuple[str, ...]) -> str:
        written = sorted([*found[:-1], moved._replace(content=content)], key=lambda one: one.first)
        output = b"".join(render(read.program, written, read.settings, UNROLLED_CYCLES))
        try:
            verify_unrolled(read, output, written, UNROLLED_CYCLES)
        except SelfCheckError as error:
            return str(error)
        return ""

    assert said(tuple(map(str, moved.content))) == ""
    changed = tuple(new if one == old else str(one) for one in moved.content)
    assert said(changed) == "the moved contour N10 is not found as it was"
