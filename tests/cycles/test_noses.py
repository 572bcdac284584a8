"""Shapes under G41 and G42 whose nose is known are offset by the filter; others stay, with the reason."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import chipbreak
from chipbreak.cycles.nose import Nose
from chipbreak.cycles.nose_runs import compensated_runs, offset_run
from chipbreak.editing.bracket import OFFSET_RUNS
from chipbreak.editing.render import render
from chipbreak.model.interpreted_program import interpret
from chipbreak.self_check import verify_unrolled
from chipbreak.settings import load
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import ProgramRejectedError
from chipbreak.text.source import read

Floats = NDArray[np.float64]
MACHINE = (
    'planner.model="trapezoid"',
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
)
NOSE = ("tools.nose_radius_mm.1=0.8", "tools.nose_tip.1=3")
ASKED = (*MACHINE, "vibration.n=1.5", 'vibration.only=["rough","semi-finish","finish","unknown"]')
HEAD = "T0101\nG97 S800 M3\nG0 X60. Z5.\n"
SHAPE = """G42 G0 X28. Z2.
G1 X30. Z0. F0.2
G1 Z-20.
X40. Z-30.
G1 X50.
Z-50.
X62.
G40 G0 X80. Z5.
"""
PLAIN = HEAD + SHAPE + "M30\n"
CYCLE = """T0101
G97 S800 M3
G0 X64. Z5.
G70 P10 Q20
G28 U0 W0
M30
N10 G42 G0 X30. F0.15
G1 Z-20.
X40. Z-30.
Z-40.
X62.
N20 G40 G1 X64.
"""


def kept(program: str, *options: str, profile: str = "fanuc-lathe") -> list[str]:
    """The plain blocks of the output: of each vibrated cut those that it stands for."""
    written = chipbreak.rewrite(program.encode(), load(profile, [*ASKED, *options])).data
    assert chipbreak.restore(written) == program.encode()
    settings = load(profile, [*ASKED, *options])
    assert chipbreak.rewrite(written, settings).data == written
    blocks = []
    inside = False
    for line in written.decode().splitlines():
        if was := re.fullmatch(r"\(CHIPBREAK WAS (.*)\)", line):
            blocks += [was[1]] if inside else []
        elif "(CHIPBREAK BEGIN" in line:
            inside = True
        elif "(CHIPBREAK END" in line:
            inside = False
        elif not inside and not line.startswith("("):
            blocks.append(line)
    return blocks


def offset(program: str, nose: Nose) -> list[str]:
    """The blocks that stand for the run of a program, as they are written; looked after, but not vibrated."""
    settings = load("fanuc-lathe")
    interpreted = interpret(parse(read(program.encode()), settings.dialect), settings)
    (run,) = compensated_runs(interpreted)
    edit = offset_run(interpreted, run, nose).edit
    output = b"".join(render(interpreted.program, [edit], settings, OFFSET_RUNS))
    verify_unrolled(interpreted, output, [edit], OFFSET_RUNS)
    return [text for text in edit.content if isinstance(text, str)]


def test_the_worked_example() -> None:
    """Along Z and X the tip is on the shape.

    On the cone (26.565 degrees) it is R (1 - tan 13.283) ahead in Z, so 0.8 less 0.189; into its inner corner
    2 R (1 - tan 31.717) back in X, so 0.611, and out of the last wall the diameter less 2 R.
    """
    assert kept(PLAIN, *NOSE)[3:-1] == [
        "G0 X27.831 Z1.558",
        "F0.2 G1 X30. Z-0.611",
        "G1 Z-20.611",
        "G1 X39.389 Z-30.",
        "G1 X50.",
        "G1 Z-50.",
        "G1 X60.4",
        "G0 X80. Z5.",
    ]


@pytest.mark.parametrize(
    ("comment", "profile"),
    [
        ("(OD FINISH TNR 0.8 TIP 3)", ()),
        ("(OD FINISH NOSE R0.8 TIP DIRECTION 3)", ()),
        ("(NOSE RADIUS: 0.8 MM, TIP NO. 3)", ()),
        ("(NOSE R0.4 TIP 2)", NOSE),
        ("(OD ROUGH RIGHT - 80 DEG.  INSERT - CNMG 12 04 08, TIP 3)", ()),
        ("(CNMG120408)", NOSE[1:]),
        ("(DCMT 11T308-PF)", NOSE[1:]),
        ("(FINISHING VBMT R0.8)", NOSE[1:]),
        ("(CNMG120412)", NOSE),
    ],
)
def test_who_says_the_nose(comment: str, profile: tuple[str, ...]) -> None:
    """A comment at the tool, and before it the profile."""
    said = PLAIN.replace("T0101", f"T0101 {comment}")
    assert kept(said, *profile)[3:] == kept(PLAIN, *NOSE)[3:]


@pytest.mark.parametrize(
    ("change", "options", "why"),
    [
        (("", ""), (), "the nose radius (R) and the tip number (T) of offset 1 are not known"),
        (("", ""), NOSE[:1], "the tip number (T) of offset 1 is not known"),
        (("T0101", "T0112"), NOSE, "of offset 12 are not known"),
        (("T0101", "T0100"), NOSE, "T0100 takes the offset off"),
        (("Z-50.\n", "Z-50.\nG41 Z-52.\n"), NOSE, "changes the side of the compensation"),
        (
            ("X40. Z-30.\n", "X40. Z-30.\nZ-30.4\nX41.\nZ-30.\nX42.\n"),
            NOSE,
            "does not get into all of this shape",
        ),
        (
            # A groove that is wider inside: its floor has room for the nose, the 1.5 mm of its mouth none.
            ("Z-20.\n", "Z-20.\nX24. Z-18.\nZ-23.5\nX30. Z-21.5\n"),
            NOSE,
            "does not get into all of this shape",
        ),
        (
            # The rapid begins at X36., and the cut that it leads to stands at X44. there.
            (
                "X40. Z-30.\nG1 X50.\nZ-50.\n",
                "G0 X36. Z-30.\nG0 X30. Z-22.\nG1 X26. Z-24.\nX56. Z-34.\n",
            ),
            NOSE,
            "does not get into all of this shape",
        ),
        (("X50.\n", "X#100\n"), NOSE, "worked out on the control"),
        (("G42 G0 X28. Z2.", "G42 G2 X28. Z2. R20."), NOSE, "begins with an arc"),
        (("G40 G0 X80. Z5.\n", ""), NOSE, "how the tool leaves it is not known"),
        (("G40 G0 X80.", "G40 G2 R40. X80."), NOSE, "how the tool leaves it is not known"),
        (("G40 G0 X80.", "G40 G0 X#5"), NOSE, "how the tool leaves it is not known"),
    ],
)
def test_what_stays_and_why(change: tuple[str, str], options: tuple[str, ...], why: str) -> None:
    program = PLAIN.replace(*change)
    settings = load("fanuc-lathe", [*ASKED, *options])
    result = chipbreak.rewrite(program.encode(), settings)
    assert not result.changed
    assert any(why in left.said.message for left in result.left)
    strict = load("fanuc-lathe", [*ASKED, *options, 'vibration.refused="error"'])
    with pytest.raises(ProgramRejectedError) as error:
        chipbreak.rewrite(program.encode(), strict)
    assert any(one.code == "VIB040" and why in one.message for one in error.value.diagnostics)


@pytest.mark.parametrize(
    ("change", "lead_out"),
    [
        (("G40 G0 X80. Z5.", "G40\nM9\nG28 U0\nG28 W0"), ["M9", "G28 U0", "G28 W0"]),
        (("G40 G0 X80. Z5.", "G40 G28 U0 W0"), ["G40 G28 U0 W0"]),
        (("G40 G0 X80. Z5.", "G40 G0 U5.\nZ5."), ["G0 X67.", "Z5."]),
        (("G40 G0 X80. Z5.", "G40 G0 X80. Z5. T0100"), ["T0100 G0 X80. Z5."]),
        (("G40 G0 X80. Z5.", "M1\nG40\nG0 X80.\nZ5."), ["M1", "G0 X80.", "Z5."]),
    ],
)
def test_ways_out(change: tuple[str, str], lead_out: list[str]) -> None:
    """The move behind G40 says each axis along which the tool is beside its programmed place."""
    assert kept(PLAIN.replace(*change), *NOSE)[9:-1] == ["G1 X60.4", *lead_out]


@pytest.mark.parametrize(
    "way", ["G40 G1 X80. Z5.", "G40 G2 X80. Z5. R40.", "G40\nG1 X80. Z5.", "G40\nM9\nG1 X80."]
)
def test_the_way_out_is_no_cut_of_its_own(way: str) -> None:
    """It begins a nose radius beside X62. Z-50., so it vibrates with its run or not at all."""
    program = PLAIN.replace("G40 G0 X80. Z5.", way)
    assert not chipbreak.rewrite(program.encode(), load("fanuc-lathe", ASKED)).changed
    asked = program.replace("\nM30", " N1.5\nM30").encode()
    with pytest.raises(ProgramRejectedError) as caught:
        chipbreak.rewrite(asked, load("fanuc-lathe"))
    (said,) = caught.value.diagnostics
    assert (said.code, "ends in this cut" in said.message) == ("VIB040", True)
    behind = program.replace("\nM30", "\nX90. F0.2 N1.5\nM30").encode()
    assert len(chipbreak.rewrite(behind, load("fanuc-lathe", MACHINE)).cuts) == 1


def test_where_the_tool_comes_from_does_not_matter_on_a_control_that_leads_in_square_to_the_shape() -> None:
    from_home = PLAIN.replace("G0 X60. Z5.\n", "")
    assert kept(from_home, *NOSE)[2:] == kept(PLAIN, *NOSE)[3:]


def test_finishing_cycle_whose_contour_compensates() -> None:
    """The contour of a G70 is written out, then offset; both come back."""
    written = chipbreak.rewrite(CYCLE.encode(), load("fanuc-lathe", [*ASKED, *NOSE])).data
    assert b"(CHIPBREAK UNROLLED G70 P10 Q20)" in written
    assert b"(CHIPBREAK COMPENSATED G42 R0.8 T3)" in written
    assert b"(CHIPBREAK BEGIN VIB" in written
    assert chipbreak.restore(written) == CYCLE.encode()
    assert chipbreak.rewrite(written, load("fanuc-lathe", [*ASKED, *NOSE])).data == written


def test_finishing_cycle_under_compensation_that_began_before() -> None:
    program = CYCLE.replace("N10 G42 G0", "N10 G0").replace("N20 G40 G1", "N20 G1")
    program = program.replace("G70", "G42 G0 X64. Z4.\nG70").replace("G28", "G40 G0 X70. Z6.\nG28")
    written = chipbreak.rewrite(program.encode(), load("fanuc-lathe", [*ASKED, *NOSE])).data
    assert b"(CHIPBREAK COMPENSATED G42 R0.8 T3)" in written
    assert chipbreak.restore(written) == program.encode()


def test_what_cannot_vibrate_stays_compensated() -> None:
    """Too slow an axis: nothing vibrates, so nothing is offset either."""
    slow = [*ASKED, *NOSE, "axes.X.max_acceleration_mm_s2=1", "axes.Z.max_acceleration_mm_s2=1"]
    result = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", slow))
    assert not result.changed
    assert all(left.said.code != "VIB040" for left in result.left)


def test_a_word_asks_for_one_block_of_the_run() -> None:
    program = PLAIN.replace("Z-50.", "Z-50. N1.5")
    written = chipbreak.rewrite(program.encode(), load("fanuc-lathe", [*MACHINE, *NOSE])).data
    assert b"COMPENSATED" in written
    assert written.count(b"(CHIPBREAK BEGIN VIB") == 1


def test_a_list_of_tools_at_the_head_says_the_nose() -> None:
    said = "(TO1 = 80* Tool, Insert: 02-0083, Tool Holder: 01-0263, Tool Nose Radius: 0.8, Tool Tip: 3)\n"
    assert kept(said + PLAIN)[3:] == kept(PLAIN, *NOSE)[3:]


@pytest.mark.few(8)
@hypothesis_settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_the_nose_touches_the_shape_and_cuts_nothing_else(seed: int) -> None:
    """Random shapes: the centre of the nose is nowhere nearer to the shape than R, and R off every part of it
    but beside inner corners."""
    rng = random.Random(seed)
    radius, tip = rng.choice((0.2, 0.4, 0.8)), rng.choice((2, 3, 4, 8, 9))
    z, x = 0.0, 15.0
    places = [(z, x)]
    for _ in range(rng.randint(3, 8)):
        z, x = z - rng.uniform(2.5, 8.0), x + rng.uniform(-2.0, 4.0)
        places.append((round(z, 3), round(x, 3)))
    z, x = places[-1]
    shape = "\n".join(f"G1 X{2 * b:.3f} Z{a:.3f} F0.2" for a, b in places[1:])
    program = f"{HEAD}G42 G0 X30. Z0.\n{shape}\nG40 G0 X{2 * x + 20:.3f} Z{z:.3f}\nM30\n"
    blocks = offset(program, Nose(radius, tip))
    ends = np.array(list(ends_of(blocks, (5.0, 30.0))))[:-1]
    signs = {2: (-1, 1), 3: (-1, -1), 4: (1, -1), 8: (0, -1), 9: (0, 0)}[tip]
    centres = ends - radius * np.array(signs)
    way = drawn(centres)
    wall = drawn(np.array(places))
    apart = np.hypot(*(way[:, None] - wall[None]).transpose(2, 0, 1))
    assert apart.min() >= radius - 2e-3
    assert apart.min(axis=1).max() <= radius * math.sqrt(2.0) + 0.01
    assert np.median(apart.min(axis=0)) <= radius + 5e-3


def ends_of(blocks: list[str], at: tuple[float, float]) -> Iterator[tuple[float, float]]:
    z, x = at
    for block in blocks:
        words = dict(re.findall(r"([XZ])(-?[\d.]+)", block))
        if words:
            z, x = float(words.get("Z", z)), float(words["X"]) / 2.0 if "X" in words else x
            yield z, x


def drawn(places: Floats) -> Floats:
    return np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(places)])


def test_that_the_control_no_longer_offsets_is_said() -> None:
    """Its offset screen, with the wear that an operator enters there, counts no more."""
    result = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", [*ASKED, *NOSE]))
    (said,) = [d for d in result.diagnostics if d.code == "CYC010"]
    assert said.place is not None
    assert (said.place.line, said.message[:13]) == (4, "G42 R0.8 T3: ")
    plain = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", [*ASKED]), allow_unbroken=True)
    assert not [d for d in plain.diagnostics if d.code == "CYC010"]  # not offset: the nose is not known
    own = PLAIN.replace("G42 G0", "G42.1 D1.6 L2 G0").replace("T0101", "G7 G18 G95\nT1 M6")
    result = chipbreak.rewrite(own.encode(), load("linuxcnc-lathe", ASKED[:-1]), allow_unbroken=True)
    assert not [d for d in result.diagnostics if d.code == "CYC010"]  # its block says the nose itself


ASSUMED = ("tools.other_nose_radius_mm=0.8", "tools.other_nose_tip=3")


def test_a_nose_that_is_assumed_is_called_so_and_offset_as_if_it_was_said() -> None:
    assert kept(PLAIN, *ASSUMED) == kept(PLAIN, *NOSE)
    result = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", [*ASKED, *ASSUMED]))
    assert b"(CHIPBREAK COMPENSATED G42 R0.8 T3 ASSUMED)" in result.data
    (said,) = [one for one in result.diagnostics if one.code == "CYC010"]
    assert "assumed" in said.message
    other = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", [*ASKED, *NOSE, *ASSUMED]))
    assert b"ASSUMED" not in other.data


@pytest.mark.parametrize(
    ("said", "shown"), [("tools.nose_radius_mm.1=0.4", "R0.4 T3"), ("tools.nose_tip.1=8", "R0.8 T8")]
)
def test_what_is_said_of_an_offset_goes_before_what_is_assumed(said: str, shown: str) -> None:
    """One of R and T is said, the other one is assumed."""
    result = chipbreak.rewrite(PLAIN.encode(), load("fanuc-lathe", [*ASKED, *ASSUMED, said]))
    assert f"G42 {shown} ASSUMED".encode() in result.data


def test_an_assumed_tip_that_points_away_from_the_material_is_refused() -> None:
    """An outer tool's tip in a bore; the way out of the message is tried."""
    bore = (
        "T0101\nG97 S800 M3\nG0 X20. Z5.\nG41 G0 X42. Z2.\nG1 X40. Z0. F0.2\nZ-20.\nX30. Z-30.\nZ-40.\nX18.\n"
    )
    bore += "G40 G0 X16. Z-38.\nZ5.\nM30\n"
    refused = chipbreak.rewrite(bore.encode(), load("fanuc-lathe", [*ASKED, *ASSUMED]))
    assert not refused.cuts
    assert any("does not point at the material" in left.said.message for left in refused.left)
    own = ("tools.nose_radius_mm.1=0.8", "tools.nose_tip.1=2")
    assert chipbreak.rewrite(bore.encode(), load("fanuc-lathe", [*ASKED, *ASSUMED, *own])).cuts


@pytest.mark.parametrize(("behind", "last"), [("", 5), ("G0 X60.\n", 6), ("M8\nG0 X60.\n", 7), ("M30\n", 6)])
def test_a_run_ends_behind_the_move_that_leads_out_or_behind_g40(behind: str, last: int) -> None:
    settings = load("fanuc-lathe")
    program = f"T0101\nG0 X20. Z2.\nG42 G1 X16. F0.2\nG1 Z-20.\nG40\n{behind}"
    (run,) = compensated_runs(interpret(parse(read(program.encode()), settings.dialect), settings))
    assert (run.first, run.last) == (2, last)


def test_a_shoulder_as_high_as_the_nose_radius() -> None:
    """The inner corner at its foot leaves nothing of it; the tip goes along the shape, which is square."""
    program = f"{HEAD}G42 G0 X28. Z2.\nG1 X30. Z0. F0.2\nZ-20.\nX31.6\nZ-50.\nX62.\nG40 G0 X80. Z5.\nM30\n"
    assert offset(program, Nose(0.8, 3))[2:6] == ["G1 Z-20.", "G1 X31.6", "G1 Z-50.", "G1 X60.4"]
