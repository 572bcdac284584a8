"""Corners and angles of cuts outside of cycles: drawn where asked, as the control would cut them."""

from __future__ import annotations

import math
import re

import pytest

import chipbreak
from chipbreak import Settings
from chipbreak.cycles import corner_runs as corner_run_module
from chipbreak.cycles.corner_runs import corner_edit, corner_runs
from chipbreak.model.block_effect import BlockEffect
from chipbreak.model.from_source import interpret_source
from chipbreak.settings import load
from chipbreak.text.source import read

HEAD = "G21 G40 G99\nT0101\nG97 S900 M3\nG0 X20. Z2.\n"
TAIL = "G0 X100. Z50.\nM30\n"
WISH = (
    "vibration.n=auto",
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
)


def drawn(blocks: str) -> list[list[str]]:
    """The blocks that stand for each run of a program."""
    interpreted = interpret_source(read((HEAD + blocks + TAIL).encode()), load("fanuc-lathe"))
    return [list(map(str, corner_edit(interpreted, run).content)) for run in corner_runs(interpreted)]


@pytest.mark.parametrize(
    ("blocks", "wanted"),
    [
        ("G1 Z-20. F0.2 ,C1.\nX30.\n", ["F0.2 G1 Z-19.", "G1 X22. Z-20.", "G1 X30."]),
        ("G1 Z-20. ,R2. F0.2\nX30.\n", ["F0.2 G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1 X30."]),
        (
            "G1 Z-20. F0.2 ,R2.\nX40. ,C1.\nZ-30.\n",
            ["F0.2 G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1 X38.", "G1 X40. Z-21.", "G1 Z-30."],
        ),
        ("G1 Z-20. F0.2 R2.\nG1 X30.\n", ["F0.2 G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1 X30."]),
        ("G1 Z0. F0.2\nX30. ,A135.\nG1 Z-20.\n", ["G1 X30. Z-5.", "G1 Z-20."]),
        ("G1 Z0. F0.2\nG1 ,A90.\nG1 X30. Z-2. ,A135.\nZ-20.\n", ["G1 X26.", "G1 X30. Z-2.", "G1 Z-20."]),
        (
            "G1 Z0. F0.2\nG1 ,A90. ,R1.\nG1 X30. Z-2. ,A135.\nZ-20.\n",
            ["G1 X25.172", "G3 X26.586 Z-0.293 I0. K-1.", "G1 X30. Z-2.", "G1 Z-20."],
        ),
        ("G1 W-22. F0.2 ,C1.\nU10.\n", ["F0.2 G1 Z-19.", "G1 X22. Z-20.", "G1 X30."]),
        (
            "G1 Z-20. F0.2 ,C1. (SHOULDER)\nX30. M8\n",
            ["(SHOULDER)", "F0.2 G1 Z-19.", "G1 X22. Z-20.", "M8 G1 X30."],
        ),
    ],
)
def test_a_corner_is_drawn(blocks: str, wanted: list[str]) -> None:
    """Worked out by hand: a chamfer is as long on both sides, a radius touches both lines."""
    assert drawn(blocks) == [wanted]


def test_the_code_of_a_move_that_a_corner_takes_in_stays_in_force() -> None:
    """The radius ends where the last move does, so no block of it is left to say G1 for the move behind."""
    (found,) = drawn("G1 Z-20. F0.2 ,R2.\nX24.\nX40. Z-30.\n")
    assert found == ["F0.2 G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1"]
    (chamfer,) = drawn("G1 Z-20. F0.2 ,C2.\nX24.\nX40. Z-30.\n")
    assert chamfer == ["F0.2 G1 Z-18.", "G1 X24. Z-20."], "it is a G1 itself"
    (arc,) = drawn("G1 Z-20. F0.2 ,R2.\nX30.\nX40. Z-30.\n")
    assert arc[-1] == "G1 X30."


def test_the_code_of_an_arc_without_radius_stays_in_force() -> None:
    """It is a line, and is written as one; the block behind it may be no line."""
    (found,) = drawn("G1 Z-20. F0.2 ,R2.\nG3 X30.\nX40. Z-30. R20.\n")
    assert found == ["F0.2 G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1 X30.", "G3"]
    (alone,) = drawn("G1 Z-20. F0.2 ,C1.\nG2\nX30.\n")
    assert alone == ["F0.2 G1 Z-19.", "G1 X22. Z-20.", "G1 X30.", "G2"]


def test_a_corner_is_drawn_behind_thousands_of_plain_blocks() -> None:
    """They say none of the letters of a corner, so they are not among those that are looked at."""
    before = "G1 Z1. F0.2\n" + "Z1.5\nZ1.\n" * 1100
    (found,) = drawn(before + "G1 Z-20. R2.\nG1 X30.\n")
    assert found == ["G1 Z-18.", "G2 X24. Z-20. I2. K0.", "G1 X30."]


@pytest.mark.parametrize("angle", [20.0, 45.0, 77.0, 110.0, 150.0])
@pytest.mark.parametrize("radius", [0.5, 1.3])
def test_a_radius_touches_both_lines(angle: float, radius: float) -> None:
    """Its ends lie R tan(angle/2) off the corner of a line along Z and one that turns off by an angle."""
    turn = math.radians(angle)
    end = (20.0 + 2.0 * 9.0 * math.sin(turn), -20.0 - 9.0 * math.cos(turn))
    (blocks,) = drawn(f"G1 Z-20. F0.2 ,R{radius}\nX{end[0]:.3f} Z{end[1]:.3f}\n")
    cut = radius * math.tan(turn / 2.0)
    assert float(re.findall(r"Z(\S+)", blocks[0])[0]) == pytest.approx(-20.0 + cut, abs=1e-3)
    words = dict(re.findall(r"([XZIK])(\S+)", blocks[1]))
    ends = (20.0 + 2.0 * cut * math.sin(turn), -20.0 - cut * math.cos(turn))
    assert blocks[1].startswith("G2 ")
    assert (float(words["X"]), float(words["Z"])) == pytest.approx(ends, abs=4e-3)
    assert (float(words["I"]), float(words["K"])) == pytest.approx((radius, 0.0), abs=2e-3)


@pytest.mark.parametrize(
    "blocks",
    [
        "G1 Z-20. F0.25 ,C1.\nX40. ,R2.\nZ-40.\nX50.\n",
        "G1 X10. F0.25\nZ-20. ,R3.\nX40. Z-30. ,C.5\nZ-40.\nX50.\n",
        "G42 G0 X20. Z1.\nG1 Z-20. F0.25 ,C1.\nX40.\nG40 G0 X60. Z5.\n",
    ],
)
def test_asked_cuts_with_corners_vibrate_and_come_back(blocks: str) -> None:
    """Under compensation too, where the nose is known: the corners come first."""
    settings = load("fanuc-lathe", [*WISH, "tools.nose_radius_mm.1=0.4", "tools.nose_tip.1=3"])
    program = (HEAD + blocks + TAIL).encode()
    result = chipbreak.rewrite(program, settings)
    assert b"UNROLLED CORNERS" in result.data
    assert result.cuts
    assert not [cut for cut in result.left if cut.said.code in ("VIB048", "VIB040")]
    assert chipbreak.restore(result.data) == program
    assert chipbreak.rewrite(result.data, settings).data == result.data
    assert not [one for one in result.diagnostics if one.code == "MOD001"]


@pytest.mark.parametrize(
    ("blocks", "cut"),
    [
        ("G1 Z-20. F0.25 ,C1.\nG2 X30. Z-25. R5.\nG1 Z-40.\n", "G2 X30. Z-25. R5."),
        ("G1 Z-20. F0.25 ,C1.\nM1\nG1 X40.\n", "G1 X40."),
        ("G1 Z-20. F0.25 ,C30.\nG1 X40.\n", "G1 X40."),
    ],
    ids=["beside an arc", "a stop between", "too large"],
)
def test_behind_a_corner_that_is_not_drawn_nothing_begins(blocks: str, cut: str) -> None:
    """The tool is not at the point of the corner, so a cut from there would be another one."""
    result = chipbreak.rewrite((HEAD + blocks + TAIL).encode(), load("fanuc-lathe", WISH))
    assert b"UNROLLED" not in result.data
    assert f"WAS {cut}" not in result.data.decode()
    assert "VIB051" in {left.said.code for left in result.left}


def test_no_cut_goes_back_to_where_an_axis_was_before_an_angle() -> None:
    """The line by its angle is not asked, so it stays; the control has moved Z along it all the same."""
    blocks = "G1 Z-10. F0.2\nX50. ,A135\nX60.\n(VIB N1.5)\nX70.\nZ-40.\n(VIB OFF)\n"
    program = (HEAD + blocks + TAIL).encode()
    interpreted = interpret_source(read(program), load("fanuc-lathe"))
    line = program.decode().splitlines().index("X60.")
    assert math.isnan(interpreted.before(line).position.z)
    assert interpreted.before(line).position.x == 25.0
    result = chipbreak.rewrite(program, load("fanuc-lathe", ["vibration.refused=leave"]))
    said = [one.message for one in result.diagnostics if one.code == "VIB051"]
    assert len(said) == 1
    assert "the angle in line 6 gives an axis its place" in said[0]
    assert b"\nZ-40.\n" in result.data, "left as it was"
    assert not re.search(rb"Z-10\.\d", result.data), "what vibrates names X alone"
    assert chipbreak.restore(result.data) == program


def test_corners_without_a_move_behind_them_are_gone_through_once(monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at: list[int] = []
    says_corner = corner_run_module._says_corner

    def counted(effect: BlockEffect, settings: Settings) -> bool:
        looked_at.append(effect.block.line)
        return says_corner(effect, settings)

    monkeypatch.setattr(corner_run_module, "_says_corner", counted)
    program = "G97 S3000 M3\n" + "G0 X30. Z2.R1.\n" * 100 + "M30\n"
    interpreted = interpret_source(read(program.encode(), "corners.nc"), chipbreak.load("fanuc-lathe"))
    assert not list(corner_runs(interpreted))
    assert 100 <= len(looked_at) < 300


@pytest.mark.parametrize("word", ["C2.", "A135."])
@pytest.mark.parametrize(("option", "begins"), [("true", False), ("false", True)])
def test_behind_what_may_be_a_corner_nothing_begins(word: str, option: str, begins: bool) -> None:
    """Without a comma it is a chamfer where the control takes it so, and then the tool stands elsewhere."""
    blocks = f"G1 Z-20. F0.25 {word}\nG1 X40.\nZ-40.\n"
    settings = load("fanuc-lathe", [*WISH, f"cycles.plain_corners={option}"])
    result = chipbreak.rewrite((HEAD + blocks + TAIL).encode(), settings)
    assert (b"(CHIPBREAK WAS G1 X40.)" in result.data) is begins
    said = [one for one in result.diagnostics if one.code == "VIB051"]
    assert bool(said) is not begins
    for one in said:
        assert f"{word} before it may take the corner off" in one.message
        assert f"where {word[0]} is an axis, cycles.plain_corners=false says so" in one.help


def test_a_rapid_with_an_axis_says_no_corner() -> None:
    blocks = "G0 X20. Z1. C90.\nG1 Z-20. F0.25\n"
    result = chipbreak.rewrite((HEAD + blocks + TAIL).encode(), load("fanuc-lathe", WISH))
    assert b"(CHIPBREAK WAS G1 Z-20. F0.25)" in result.data


@pytest.mark.parametrize("end", ["X45. Z-50", "X45 Z-50.", "X#1 Z-50."])
def test_a_block_between_that_ends_nowhere_leaves_the_corner(end: str) -> None:
    """What a number without a point means is not known here, so the corner is none that can be drawn."""
    program = (
        f"G21\nG97 S800 M3\nG98\nG0 X20. Z2.\nG1 Z-25. F120. N1.5 ,R0.5\n{end}\nG1 X50. Z-51.\nG0 X80.\nM30\n"
    )
    with pytest.raises(chipbreak.ProgramRejectedError) as rejected:
        chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe"))
    assert ",R0.5 cannot stand in a block that vibrates" in str(rejected.value)


@pytest.mark.parametrize("words", ["N1" * 60, "O1" * 60])
def test_words_that_would_not_fit_in_a_line_leave_the_corner(words: str) -> None:
    program = f"G21\nG97 S800 M3\nG98\nG0 X30. Z2.\nG1 Z-5. F100. ,R1. {words}\nX50. N1.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError):
        chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe"))


@pytest.mark.parametrize("last", ["G0 X80. O1", "G1 X80. O1", "X80. N1 O2"])
def test_an_o_in_a_block_of_a_run_leaves_the_corner(last: str) -> None:
    """Its other words are written in front, and there an O would begin another program."""
    program = f"G97 S800 M3\nG99\nG0 X20. Z1.\nG1 Z-24. F0.12 N0.5 ,R2.\n{last}\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as rejected:
        chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe"))
    assert ",R2. cannot stand in a block that vibrates" in str(rejected.value)


@pytest.mark.parametrize(("behind", "left"), [("G0 X40.", ["VIB048"]), ("G1 X40.", [])])
def test_a_corner_before_a_rapid_is_not_drawn(behind: str, left: list[str]) -> None:
    """Corners lie between feeds: a control stops there."""
    program = (
        f"G97 S1000 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-20. F0.2 ,C2.\n{behind}\n(VIB OFF)\nG0 X50.\nM30\n"
    )
    settings = load("fanuc-lathe", ["vibration.refused=leave"])
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    assert [cut.said.code for cut in result.left] == left
    assert ("has a rapid behind it" in str(result.left)) is bool(left)
    assert (b"UNROLLED CORNERS" in result.data) is (not left)
