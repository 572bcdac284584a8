"""Runs under nose compensation and runs of corners: what each block may not be, and what is said of it."""

from __future__ import annotations

import math
import re

import pytest

from chipbreak.cycles.corner_runs import CornerRun, corner_edit, corner_runs
from chipbreak.cycles.nose import Nose
from chipbreak.cycles.nose_runs import Run, compensated_runs, offset_run
from chipbreak.cycles.plan import plan_unrolling
from chipbreak.text.diagnostics import RefusalError

from .planned import blocks, interpreted

HEAD = "T0101\nG97 S800 M3\nG0 X60. Z5.\n"
SHAPE = "G42 G0 X28. Z2.\nG1 X30. Z0. F0.2\nZ-20.\nX40. Z-30.\nG1 X50.\nZ-50.\nX62.\nG40 G0 X80. Z5.\n"
PROGRAM = f"{HEAD}{SHAPE}M30\n"
ACTIVE = "tool nose compensation (G41, G42) is active, and "
END_BEFORE = "end it with G40 before, or write the block without it"
LEAD_OUT = ("how the tool leaves it is not known", "lead out with G40 and a straight move: G40 G0 X100. Z10.")
LEAD_IN = "lead in with a straight move, from a place that plain numbers give"
TOO_LARGE = (
    "a nose of 0.8 mm does not get into all of this shape",
    "check R and T of the nose, or take what is so small out",
)
READ_OTHERWISE = "cannot be read, has block delete or is worked out on the control"
ENDS = "changes the tool or leaves the program"


def block(text: str, why: str) -> tuple[str, str]:
    return f"the block {text} {why}", END_BEFORE


# What is written otherwise; what is said behind ``ACTIVE``, and the way out.
FAULTS: list[tuple[tuple[str, str], tuple[str, str]]] = [
    (("Z-50.", "?Z-50."), block("?Z-50.", READ_OTHERWISE)),
    (("Z-50.", "/Z-50."), block("/Z-50.", READ_OTHERWISE)),
    (("Z-50.", "Z#1"), block("Z#1", READ_OTHERWISE)),
    (("Z-50.", "GOTO8"), block("GOTO8", READ_OTHERWISE)),
    (("Z-50.", "G20 Z-50."), block("G20 Z-50.", "changes units, plane or coordinates")),
    (("Z-50.", "G17 Z-50."), block("G17 Z-50.", "changes units, plane or coordinates")),
    (("Z-50.", "G53 Z-50."), block("G53 Z-50.", "is a cycle, a call or a way home")),
    (("Z-50.", "G28 U0"), block("G28 U0", "is a cycle, a call or a way home")),
    (("Z-50.", "G65 P9000"), block("G65 P9000", "is a cycle, a call or a way home")),
    (("Z-50.", "T0202"), block("T0202", ENDS)),
    (("Z-50.", "M30"), LEAD_OUT),
    (("Z-50.", "M98 P9"), block("M98 P9", ENDS)),
    (("Z-50.", "G41 Z-50."), block("G41 Z-50.", "changes the side of the compensation")),
    (("Z-50.", "Z-50. R1."), block("Z-50. R1.", "has a word that is not read here")),
    (("Z-50.", "G32 Z-50. F1."), block("G32 Z-50. F1.", "moves otherwise than in X and Z")),
    (("Z-50.", "Z-50. C2."), block("Z-50. C2.", "has C2., which may be a corner (cycles.plain_corners)")),
    (("Z-50.", "Z-50. A90."), block("Z-50. A90.", "has A90., which may be a corner (cycles.plain_corners)")),
    (("G40 G0 X80. Z5.\n", ""), LEAD_OUT),
    (("G40 G0 X80.", "G40 G2 R40. X80."), LEAD_OUT),
    (("G40 G0 X80.", "G40 G0 X#5"), LEAD_OUT),
    (("G40 G0 X80.", "/G40 G0 X80."), LEAD_OUT),
    (("G40 G0 X80. Z5.", "G40 I1. G0 X80. Z5."), LEAD_OUT),
    (("G40 G0 X80. Z5.", "G40 G28 U0"), LEAD_OUT),
    (("G40 G0 X80. Z5.", "G40 G53 X0 Z0"), LEAD_OUT),
    (("G42 G0 X28. Z2.", "G42 G2 X28. Z2. R20."), ("the compensation begins with an arc", LEAD_IN)),
    (
        ("G1 X30. Z0. F0.2\nZ-20.\nX40. Z-30.\nG1 X50.\nZ-50.\nX62.\n", ""),
        ("the compensation ends before it is in force", "let a move follow the one of G41 or G42"),
    ),
    (
        ("G42 G0 X28. Z2.", "G0 X28. Z3.\nG42 G0 Z3."),
        ("the move that leads into the compensation is not longer than the nose radius", LEAD_IN),
    ),
    (("X50.\n", "X40.4\nZ-30.2\nX50.\n"), TOO_LARGE),
    (("X40. Z-30.\n", "X40. Z-30.\nZ-30.4\nX41.\nZ-30.\nX42.\n"), TOO_LARGE),
]


def said_of(program: str, nose: Nose, *options: str) -> tuple[str, str, str]:
    read = interpreted(program, *options)
    (run,) = compensated_runs(read)
    with pytest.raises(RefusalError) as caught:
        offset_run(read, run, nose)
    return caught.value.code, caught.value.message, caught.value.help


@pytest.mark.parametrize(("change", "said"), FAULTS, ids=lambda one: one[1][:30])
def test_what_a_run_may_not_have(change: tuple[str, str], said: tuple[str, str]) -> None:
    assert change[0] in PROGRAM
    assert said_of(PROGRAM.replace(*change, 1), Nose(0.8, 3)) == ("VIB040", ACTIVE + said[0], said[1])


def test_modes_and_jumps() -> None:
    plane = PROGRAM.replace("G97", "G17 G97")
    assert said_of(plane, Nose(0.8, 3)) == (
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        "end it before the cycle",
    )
    jump = PROGRAM.replace("Z-50.", "N7 X50. Z-50.").replace("M30", "IF[#1EQ1]GOTO7\nM30")
    assert said_of(jump, Nose(0.8, 3)) == ("VIB040", f"{ACTIVE}a jump leads into it", "take the jump out")


def test_noses_that_are_none() -> None:
    unknown = f"{ACTIVE}how this control counts the tip 12 of a nose is not known"
    assert said_of(PROGRAM, Nose(0.8, 12)) == ("VIB040", unknown, "take the wish out")
    away = f"{ACTIVE}tip 1, which is assumed, does not point at the material here"
    help_text = "say R and T of this offset in tools.nose_radius_mm and tools.nose_tip"
    assert said_of(PROGRAM, Nose(0.8, 1, is_assumed=True)) == ("VIB040", away, help_text)


@pytest.mark.parametrize("tip", [1, 2, 3, 4, 5, 6, 7, 8, 9])
@pytest.mark.parametrize("shape", ["outer", "inner"])
@pytest.mark.parametrize("zero", [0, 700])
def test_which_assumed_tips_point_at_the_material(tip: int, shape: str, zero: int) -> None:
    """Turned outside, the material lies at smaller X; in a bore at greater X: that of each cut counts.

    Both go to smaller Z by more than along X: outside 52 mm with 17 mm out, in the bore 62 mm with 6 mm in.
    So the material lies at -X and -Z of the first one, at +X and -Z of the other; tip 9 points nowhere.
    """
    bore = "G41 G0 X42. Z2.\nG1 X40. Z0. F0.2\nZ-20.\nX30. Z-30.\nZ-60.\nG40 G0 X16. Z-58.\n"
    program = PROGRAM if shape == "outer" else HEAD.replace("X60.", "X20.") + bore + "M30\n"
    read = interpreted(re.sub(r"Z(-?\d+)", lambda z: f"Z{int(z[1]) + zero}", program))
    (run,) = compensated_runs(read)
    # Fanuc: 1 to 4 are the corners +X+Z, +X-Z, -X-Z, -X+Z; 5 to 8 the sides +Z, +X, -Z, -X.
    points_at_it = {"outer": (3, 4, 7, 8), "inner": (1, 2, 6, 7)}[shape]
    try:
        offset_run(read, run, Nose(0.4, tip, is_assumed=True))
    except RefusalError as error:
        is_refused = "does not point at the material" in error.message
    else:
        is_refused = False
    assert is_refused is (tip not in points_at_it)


def test_the_title_says_side_radius_tip_and_what_is_assumed() -> None:
    read = interpreted(PROGRAM)
    (run,) = compensated_runs(read)
    edit = offset_run(read, run, Nose(0.8, 3)).edit
    assert (edit.title, edit.reason) == (
        "G42 R0.8 T3",
        "a nose of 0.8 mm with tip 3, offset by the filter",
    )
    assert offset_run(read, run, Nose(0.8, 3, is_assumed=True)).edit.title == "G42 R0.8 T3 ASSUMED"
    assert (edit.first, edit.last) == (3, 11)


def test_each_block_that_is_written_knows_the_line_that_it_stands_for() -> None:
    program = PROGRAM.replace("Z-20.", "Z-20. (A) M8").replace("G1 X50.", "M9\nG1 X50. N1.5")
    read = interpreted(program)
    (run,) = compensated_runs(read)
    written = offset_run(read, run, Nose(0.8, 3))
    assert list(zip(blocks(written.edit), written.sources, strict=True)) == [
        ("G0 X27.831 Z1.558", 3),
        ("F0.2 G1 X30. Z-0.611", 4),
        ("(A)", 5),
        ("M8 G1 Z-20.611", 5),
        ("G1 X39.389 Z-30.", 6),
        ("M9", 7),
        ("G1 X50. N1.5", 8),
        ("G1 Z-50.", 9),
        ("G1 X60.4", 10),
        ("G0 X80. Z5.", 11),
    ]


@pytest.mark.parametrize(
    ("program", "runs"),
    [
        (PROGRAM, [Run(3, 11)]),
        (PROGRAM.replace("M30", "G41 G0 X20.\nG1 Z-5.\nG40 X30.\nM30"), [Run(3, 11), Run(11, 14)]),
        (PROGRAM.replace("G40 G0 X80. Z5.", "G40\nM9\nG28 U0\nG28 W0\nM5"), [Run(3, 14)]),
        (PROGRAM.replace("G40 G0 X80. Z5.", "G40\nG28 U0\nG4 X1.\nG28 W0\nM5"), [Run(3, 13)]),
        (PROGRAM.replace("G40 G0 X80. Z5.", "G40\nG28 U0 W0\nM5"), [Run(3, 12)]),
        (PROGRAM.replace("G40 G0 X80. Z5.\nM30\n", ""), [Run(3, 10)]),
        (PROGRAM.replace("G40 G0 X80. Z5.\n", ""), [Run(3, 11)]),
        (PROGRAM.replace("G42 ", ""), []),
    ],
)
def test_where_runs_begin_and_end(program: str, runs: list[Run]) -> None:
    assert compensated_runs(interpreted(program)) == runs


BESIDE = "G21 G40 G99\nT0101\nG97 S900 M3\nG0 X20. Z2.\nG1 Z-20. F0.2 ,C1.\nM8\nX30.\nG0 X100. Z50.\nM30\n"
DRAW = "draw the corner with G1, G2 and G3"
CORNER_FAULTS = [
    ("M8", "?", "CYC007", f"the block ? {READ_OTHERWISE}", DRAW),
    ("M8", "/M8", "CYC007", f"the block /M8 {READ_OTHERWISE}", DRAW),
    (
        "M8",
        "M0 (A COMMENT THAT IS LONGER THAN FORTY CHARACTERS)",
        "CYC007",
        "the block M0 (A COMMENT THAT IS LONGER THAN FORTY  stops or leaves the program",
        DRAW,
    ),
    ("M8", "GOTO5", "CYC007", f"the block GOTO5 {READ_OTHERWISE}", DRAW),
    ("M8", "#1=5", "CYC007", f"the block #1=5 {READ_OTHERWISE}", DRAW),
    ("M8", "G20", "CYC007", "the block G20 changes units, plane or coordinates", DRAW),
    ("M8", "M0", "CYC007", "the block M0 stops or leaves the program", DRAW),
    ("M8", "M98 P9", "CYC007", "the block M98 P9 stops or leaves the program", DRAW),
    ("M8", "G32 X25. F1.", "CYC007", "the block G32 X25. F1. moves otherwise than in X and Z", DRAW),
    ("X20. Z2.", "X20. Z#1", "CYC002", "where a corner begins is not known", "move there with G0 X Z"),
    (
        "Z-20. F0.2 ,C1.",
        "F0.2 ,A90.",
        "CYC002",
        "the contour block G1 F0.2 ,A90. has an angle, and the next block does not say X, Z and an angle",
        "name one axis beside the angle",
    ),
    (
        "Z-20. F0.2 ,C1.",
        "Z-20. F0.2 ,C30.",
        "CYC002",
        "a corner of 30 mm is larger than the moves beside it",
        "write the contour with G1, G2 and G3 to plain points",
    ),
    (
        "G21",
        "G17 G21",
        "CYC007",
        "another plane, G91 or G90.1 is in force at this cycle",
        "end it before the cycle",
    ),
]


@pytest.mark.parametrize(("old", "new", "code", "message", "help_text"), CORNER_FAULTS)
def test_what_a_run_of_corners_may_not_have(
    old: str, new: str, code: str, message: str, help_text: str
) -> None:
    read = interpreted(BESIDE.replace(old, new, 1))
    (run,) = corner_runs(read)
    with pytest.raises(RefusalError) as caught:
        corner_edit(read, run)
    assert (caught.value.code, caught.value.message, caught.value.help) == (code, message, help_text)


def test_a_jump_into_a_run_of_corners() -> None:
    read = interpreted(BESIDE.replace("X30.", "N7 X30.").replace("M30", "IF[#1EQ1]GOTO7\nM30"))
    with pytest.raises(RefusalError, match=r"^the block N7 X30. is what a jump leads to$"):
        corner_edit(read, next(corner_runs(read)))


def test_behind_an_angle_both_axes_are_named() -> None:
    read = interpreted(
        BESIDE.replace("Z-20. F0.2 ,C1.", "Z0. F0.2\nX30. ,A135.").replace("X30.\nG0", "X40.\nG0")
    )
    with pytest.raises(RefusalError) as caught:
        corner_edit(read, next(corner_runs(read)))
    assert caught.value.message == "the block behind an angle does not name the axis that the angle gives"
    assert caught.value.help == "name both axes in it"


@pytest.mark.parametrize(
    ("program", "runs"),
    [
        (BESIDE, [CornerRun(4, 7)]),
        (BESIDE.replace("X30.", "X30. ,R1.\nZ-30.\nX40. R2.\nX50."), [CornerRun(4, 8), CornerRun(8, 10)]),
        (BESIDE.replace("M8", "T0202"), []),
        (BESIDE.replace("M8", "G4 X1."), []),
        (BESIDE.replace("M8", "M30"), []),
        (BESIDE.replace("X30.\nG0 X100. Z50.\nM30\n", "M8\n"), []),
        (BESIDE.replace(",C1.", "C1."), []),
        (BESIDE.replace(",C1.", "K1."), [CornerRun(4, 7)]),
        (BESIDE.replace("G1 Z-20. F0.2 ,C1.", "G2 X22. Z-20. R5. F0.2"), []),
    ],
)
def test_where_runs_of_corners_begin_and_end(program: str, runs: list[CornerRun]) -> None:
    assert list(corner_runs(interpreted(program))) == runs


def test_the_title_of_a_run_of_corners_has_the_first_four() -> None:
    said = " ".join(f"X{30 + 20 * n}. ,C{n}.\nZ-{20 + 10 * n}. ,R{n}.\n" for n in (1, 2, 3))
    read = interpreted(BESIDE.replace("X30.\n", f"{said}X120.\n"))
    edit = corner_edit(read, next(corner_runs(read)))
    assert (edit.title, edit.reason) == (
        "CORNERS ,C1. ,C1. ,R1. ,C2.",
        "the corners as the control cuts them",
    )


def test_lines_that_say_slanted_angles_meet() -> None:
    """From X20 Z0 at 100 degrees, and at 150 to X60 Z-30: both as X = 10 + tan (z), from +Z towards +X."""
    one, other = math.tan(math.radians(100.0)), math.tan(math.radians(150.0))
    z = (30.0 + 30.0 * other - 10.0) / (one - other)
    corner = f"G1 X{2.0 * (10.0 + one * z):.3f} Z{z:.3f}"
    program = BESIDE.replace("Z-20. F0.2 ,C1.\nM8\nX30.", "Z0. F0.2\n,A100.\nX60. Z-30. ,A150.\nZ-40.")
    read = interpreted(program)
    assert blocks(corner_edit(read, next(corner_runs(read)))) == [corner, "G1 X60. Z-30.", "G1 Z-40."]


def test_a_run_of_corners_that_cannot_be_drawn_keeps_no_other_one() -> None:
    """Of three the first is not asked, and the second one is larger than its moves."""
    more = "G0 X20. Z2.\nG1 Z-20. F0.2 ,C{}.\nX30.\n"
    read = interpreted(BESIDE.replace("G0 X100.", f"{more.format(30)}{more.format(2)}G0 X100."))
    assert [run.first for run in corner_runs(read)] == [4, 8, 11]
    drawn = plan_unrolling(read, [], cuts=[8, 9, 12]).edits
    assert [(one.edit.first, one.kind, one.group) for one in drawn] == [(11, None, 11)]
    assert plan_unrolling(read, []).edits == []
