"""Cycles block by block, worked out by hand; and what is found where one of the blocks is another."""

from __future__ import annotations

import re

import pytest

from chipbreak.cycles.plan import cycle_lines, plan_unrolling
from chipbreak.cycles.writing import with_wish
from chipbreak.editing.bracket import UNROLLED_CYCLES
from chipbreak.editing.edits import Edit
from chipbreak.editing.render import render
from chipbreak.operations.kinds import Kind
from chipbreak.self_check import verify_unrolled
from chipbreak.text.diagnostics import SelfCheckError

from .planned import HEAD, TAIL, blocks, edits, interpreted, planned
from .test_what_is_said import PROGRAMS


def only(name: str, *change: str, options: tuple[str, ...] = ()) -> Edit:
    """The first edit of a program."""
    program = PROGRAMS[name].replace(*change) if change else PROGRAMS[name]
    profile = "linuxcnc-lathe" if name == "linuxcnc" else "fanuc-lathe"
    return edits(program, *options, profile=profile)[0]


def number(value: float) -> str:
    return f"{value:.3f}".rstrip("0")


def passes_of(back: float = 0.5, feed: str = " F0.3") -> list[str]:
    """G71 from X52 Z2 in steps of 2 mm; the cone runs from X16.4 Z-14.9 to X30.4 Z-29.9."""
    wanted = []
    for count in range(1, 9):
        x = 52.0 - 4.0 * count
        z = max(-29.9, -14.9 - 15.0 * (x - 16.4) / 14.0)
        wanted += [f"(PASS {count} LEVEL {2 * count} MM BELOW THE START)"]
        wanted += ["G0 Z2.1"] if count == 1 else []
        wanted += [f"G0 X{number(x)}", f"G1 Z{number(z)}{feed if count == 1 else ''}"]
        wanted += [f"G0 X{number(x + 2.0 * back)} Z{number(z + back)}", "G0 Z2.1"]
    return [*wanted, "(PASS 9 ALONG THE CONTOUR)", "G0 X52."]


END = ["G0 X16.4", "G1 Z-14.9", "G1 X30.4 Z-29.9", "G1 X52.4", "G0 Z2.", "G0 X52."]


@pytest.mark.parametrize("name", ["G71", "G71 in one block"])
def test_roughing_along_z(name: str) -> None:
    edit = only(name)
    assert blocks(edit) == passes_of() + END
    assert (edit.title, edit.reason) == (
        "G71 P10 Q20",
        "passes of 2 mm along Z to the contour with its allowances",
    )
    assert (edit.first, edit.last) == ((4, 6) if name == "G71" else (4, 5))


def test_words_of_the_cycle_stand_where_they_act() -> None:
    """S first of all, F in the first cut, N in every cut; the retract of the cycle, or of the profile."""
    said = blocks(only("G71", "F0.3", "F0.25 S900 N1.5"))
    assert said[0] == "S900"
    wanted = [f"{one} N1.5" if one.startswith("G1") else one for one in passes_of(feed=" F0.25") + END]
    assert said[1:] == wanted
    assert blocks(only("G71", "R0.5", "R0.25")) == passes_of(back=0.25) + END
    by_profile = only("G71", " R0.5", "", options=("cycles.retract_mm=0.75",))
    assert blocks(by_profile) == passes_of(back=0.75) + END
    fed = blocks(only("G71", "N10 G0", "N10 G1"))
    assert [one for one in fed if one.startswith("G0 X4")] == [
        "G0 X49. Z-29.4",
        "G0 X45. Z-29.4",
        "G0 X41. Z-29.4",
    ]
    assert fed[2] == "G1 X48. F0.3" and fed[3] == "G1 Z-29.9"


def test_the_motion_code_and_the_compensation_that_were_in_force_are_given_back() -> None:
    assert blocks(only("G71", "Z2.\nG71", "Z2.\nG1 F0.2\nG71")) == [*passes_of(), *END, "G1"]
    under = blocks(only("G71", "G0 X52. Z2.", "G0 X60. Z4.\nG42 G0 X52. Z2."))
    assert under == ["G40 G0 X52. Z2.", *passes_of(), *END, "G42"]
    left = blocks(only("G71", "G0 X52. Z2.", "G0 X60. Z4.\nG41 G1 X52. Z2. F0.2"))
    assert left == ["G40 G0 X52. Z2.", *passes_of(), *END, "G41", "G1"]


def test_without_a_pass_along_the_contour() -> None:
    steps = blocks(only("G71", options=("cycles.finish_pass=never",)))
    # 17.8 mm are 8 levels and 1.8 mm.
    end = ["(PASS 9 LEVEL 17.8 MM BELOW THE START)", "G0 X16.4", "G1 Z-14.9", "G0 X17.4 Z-14.4", "G0 Z2.1"]
    assert steps == [*passes_of()[:-2], *end, "G0 X52.", "G0 Z2."]


def test_i_and_k_are_left_for_a_pass_of_their_own() -> None:
    """In one block I is a radius; the levels end 0.2 mm before the cone, which stands 0.3 mm higher."""
    said = blocks(only("G71 in one block", "F0.3", "I0.3 K0.2 F0.3"))
    assert said[:4] == ["(PASS 1 LEVEL 2 MM BELOW THE START)", "G0 Z2.3", "G0 X48.", "G1 Z-29.7 F0.3"]
    first = said.index("(PASS 9 ALONG THE CONTOUR)")
    assert said[first:] == [
        *("(PASS 9 ALONG THE CONTOUR)", "G0 X52.", "G0 X17.", "G1 Z-14.7", "G1 X31. Z-29.7", "G1 X53."),
        *("(PASS 10 ALONG THE CONTOUR)", "G0 Z2.3", "G0 X16.4", "G1 Z2.1", "G1 Z-14.9", "G1 X30.4 Z-29.9"),
        *("G1 X52.4", "G0 Z2.", "G0 X52."),
    ]


@pytest.mark.parametrize("name", ["G72", "G72 in one block"])
def test_roughing_along_x(name: str) -> None:
    """From Z2 X52 in steps of 2 mm; the slope runs from X40.4 Z-19.9 to X30.4 Z-9.9, by 1 mm of X in Z."""
    wanted = []
    for count in range(1, 11):
        z = 2.0 - 2.0 * count
        x = max(30.4, 30.4 + (-9.9 - z))
        wanted += [f"(PASS {count} LEVEL {2 * count} MM BELOW THE START)"]
        wanted += ["G0 X52.4"] if count == 1 else []
        wanted += [f"G0 Z{number(z)}", f"G1 X{number(x)}{' F0.3' if count == 1 else ''}"]
        wanted += [f"G0 X{number(x + 1.0)} Z{number(z + 0.5)}", "G0 X52.4"]
    end = ["(PASS 11 ALONG THE CONTOUR)", "G0 Z2.", "G0 Z-19.9", "G1 X40.4", "G1 X30.4 Z-9.9", "G1 Z2.1"]
    assert blocks(only(name)) == [*wanted, *end, "G0 X52.", "G0 Z2."]
    assert only(name).reason == "passes of 2 mm along X to the contour with its allowances"


@pytest.mark.parametrize("name", ["G73", "G73 in one block"])
def test_a_pattern(name: str) -> None:
    wanted = []
    for at, off in enumerate((1.0, 0.5, 0.0)):
        x, z = 0.4 + 8.0 * off, 0.1 + off
        wanted += [f"(PASS {at + 1} {x / 2:.4g} AND {z:.4g} MM OFF THE CONTOUR)"]
        wanted += ["G0 X60.4 Z3.1"] if at == 0 else []
        wanted += [f"G0 X{number(16 + x)}", f"G1 Z{number(z - 15)}{' F0.3' if at == 0 else ''}"]
        wanted += [f"G1 X{number(30 + x)} Z{number(z - 30)}", f"G1 X{number(52 + x)}"]
        wanted += ["G0 Z2.", "G0 X52."] if at == 2 else [f"G0 Z{number(z + 1.5)}", f"G0 X{number(48 + x)}"]
    edit = only(name)
    assert blocks(edit) == wanted
    assert edit.reason == "3 passes along the contour, the last one at its allowances"
    under = blocks(only(name, "G0 X52. Z2.", "G0 X60. Z4.\nG42 G0 X52. Z2."))
    assert under == ["G40 G0 X52. Z2.", *wanted, "G42"]
    assert blocks(only(name, "F0.3", "F0.3 S800"))[0] == "S800"
    fed = blocks(only(name, "N10 G0", "N10 G1"))
    assert fed[2] == "G1 X24.4 F0.3" and "G1 X20.4" in fed and "G1 X16.4" in fed


@pytest.mark.parametrize("name", ["G71", "G73"])
def test_roughing_passes_over_what_is_for_finishing(name: str) -> None:
    said = only(name, "G1 Z-15.", "G42 G1 Z-15. T0202 M8 S900 F0.05")
    assert blocks(said) == blocks(only(name))


def test_a_bore_that_is_hardly_larger_than_where_the_tool_waits() -> None:
    """Half a millimetre on the radius, in steps of 0.2 mm from X39 to X40."""
    shape = "N10 G0 X40.\nG1 Z-15.\nX39.5 Z-30.\nN20 X39.\n"
    program = f"{HEAD.replace('X52.', 'X39.')}G71 U0.2 R0.1\nG71 P10 Q20 U-0.1 W0.1 F0.1\n{shape}{TAIL}"
    found = [one for one in blocks(edits(program)[0]) if one[:4] == "G1 X" or "LEVEL" in one]
    assert found == [
        "(PASS 1 LEVEL 0.2 MM BELOW THE START)",
        "(PASS 2 LEVEL 0.4 MM BELOW THE START)",
        *("G1 X39.4 Z-29.9", "G1 X38.9"),
    ]


def test_finishing() -> None:
    edit = only("G70")
    assert blocks(edit) == ["G0 X16. F0.1", "G1 Z-15.", "X30. Z-30.", "X52.", "G0 Z2."]
    assert (edit.title, edit.reason) == ("G70 P10 Q20", "the contour as the finishing cycle runs it")
    said = blocks(only("G70", "Q20", "Q20 F0.2 S700 N1.5"))
    assert said == [
        *("S700 F0.2", "G0 X16. F0.1", "G1 Z-15. N1.5", "X30. Z-30. N1.5", "X52. N1.5", "G0 Z2."),
    ]
    corner = blocks(only("G70", "G1 Z-15.", "G1 Z-15. ,C1. (SHOULDER)\nM8\nX20.\nM9"))
    assert corner == [
        *("F0.1 G0 X16.", "G1 Z-14.", "G1 X18. Z-15.", "M8", "G1 X20.", "M9", "G1 X30. Z-30.", "G1 X52."),
        "G0 Z2.",
    ]
    # A chamfer of 1 mm begins at 1 mm of the cone, 15 by 7 mm: 0.906 along Z and 0.423 of the radius.
    nowhere = blocks(only("G70", "X30. Z-30.", "X30. Z-30. ,C1.\nX40.\nX40. F0.2"))
    assert nowhere == [
        *("F0.1 G0 X16.", "G1 Z-15.", "G1 X29.154 Z-29.094", "G1 X32. Z-30.", "G1 X40.", "F0.2", "G1 X52."),
        "G0 Z2.",
    ]
    wished = blocks(only("G70", "X30.", "X30. (CONE)"))
    assert wished[2] == "X30. (CONE) Z-30."


@pytest.mark.parametrize(("before", "behind"), [("", ""), ("G1 F0.2\n", "G1"), ("G28 U0\nG0 X52.\n", "")])
def test_behind_finishing_the_motion_code_is_given_back(before: str, behind: str) -> None:
    said = blocks(only("G70", "Z2.\n", f"Z2.\n{before}"))
    assert said[5:] == ([behind] if behind else [])


def test_what_stands_for_a_contour() -> None:
    (_, contour) = edits(PROGRAMS["G70"])
    assert (contour.first, contour.last, contour.content) == (5, 9, ())
    assert (contour.title, contour.reason) == ("CONTOUR N10 to N20", "nothing calls this contour any more")


def test_what_is_told_of_each_edit() -> None:
    found = planned(PROGRAMS["G71 and G70"]).edits
    assert [(one.kind, one.group, one.is_cycle, one.passes, one.depth_mm) for one in found] == [
        (Kind.ROUGH, 5, True, 9, 2.0),
        (Kind.FINISH, 5, True, 1, None),
        (None, 5, True, 1, None),
    ]
    stays = planned(PROGRAMS["G71 and G70"].replace("N20 X52.", "N20 X52. M8"))
    assert [(one.kind, one.group, one.is_cycle) for one in stays.edits] == [
        (Kind.ROUGH, 5, True),
        (None, 5, True),
        (None, 5, False),
    ]
    contour, moved = (one.edit for one in stays.edits[1:])
    assert (contour.keeps_number, moved.keeps_number) == (False, True)
    assert blocks(moved) == ["M30", "N10 G0 X16. F0.1", "G1 Z-15.", "X30. Z-30.", "N20 X52. M8"]
    assert moved.reason == "the finishing cycle that stays looks for it by its numbers"
    single = planned(PROGRAMS["G90"]).edits
    assert [(one.kind, one.group, one.passes) for one in single] == [(None, 4, 2)]
    lx = planned(PROGRAMS["linuxcnc"], profile="linuxcnc-lathe").edits
    assert [(one.kind, one.group, one.passes, one.depth_mm) for one in lx] == [(Kind.ROUGH, 11, 10, 2.0)]


def test_cuts_without_pecks() -> None:
    groove = only("G75")
    steps = [f"G0 Z-{z}." for z in (13, 16, 18)]
    cuts = [block for step in steps for block in ("G0 X42.", step, "G1 X20.")]
    assert blocks(groove) == ["(PASS 1 WITHOUT PECKS)", "G1 X20. F0.1", *cuts, "G0 X42.", "G0 Z-10."]
    assert (groove.title, groove.reason) == ("G75 X20. Z-18.", "the cuts of the cycle without its pecks")
    face = [block for x in (38, 34, 30, 26, 22, 20) for block in ("G0 Z3.", f"G0 X{x}.", "G1 Z-40.")]
    assert blocks(only("G74")) == [
        *("(PASS 1 WITHOUT PECKS)", "G1 Z-40. F0.12", *face, "G0 Z3.", "G0 X42."),
    ]
    assert blocks(only("G74", "X20. Z-40. P2000", "Z-40."))[1:] == ["G1 Z-40. F0.12", "G0 Z3."]
    hole = only("G83")
    assert blocks(hole) == ["(PASS 1 WITHOUT PECKS)", "G1 Z-40. F0.12", "G0 Z3.", "G80"]
    assert (hole.title, hole.reason) == ("G83 Z-40.", "the hole of the cycle without its pecks")
    assert (hole.first, hole.last) == (5, 7)
    said = only("G83", "F0.12\nG80", "F0.12\n(WAIT)\nM9\nN7 G80 M5 (OUT)")
    assert blocks(said)[3:] == ["M9", "G80 M5 (OUT)"]


@pytest.mark.parametrize(("name", "line"), [("G75", "G75 R"), ("G74", "G74 R"), ("G83", "G83")])
def test_a_motion_code_before_them_is_given_back(name: str, line: str) -> None:
    said = blocks(only(name, line, f"G1 F0.3\n{line}"))
    assert said == [
        *blocks(only(name))[: 3 if name == "G83" else None],
        "G1",
        *(["G80"] if name == "G83" else []),
    ]


def test_the_steps_of_grooves_in_inches() -> None:
    """Without a point they count ten-thousandths of an inch."""
    inch = HEAD.replace("G21", "G20").replace("X52. Z2.", "X2. Z-.5")
    (edit,) = edits(f"{inch}G75 R.02\nG75 X1. Z-.8 P800 Q1000 F.004\n{TAIL}")
    assert [one for one in blocks(edit) if one.startswith("G0 Z")] == [
        "G0 Z-0.6",
        "G0 Z-0.7",
        "G0 Z-0.8",
        "G0 Z-0.5",
    ]
    for steps in ("I.08 K.1", "P.08 Q.1"):
        plain = f"{inch}G75 R.02\nG75 X1. Z-.8 {steps} F.004\n{TAIL}"
        assert blocks(edits(plain)[0]) == blocks(edit)


def test_the_depth_of_one_block_in_inches() -> None:
    inch = HEAD.replace("G21", "G20").replace("X52. Z2.", "X2. Z.1")
    shape = "N10 G0 X1.\nG1 Z-1.\nN20 X2.1\n"
    one = f"{inch}G71 P10 Q20 U.02 W.004 D1000 F.01\n{shape}{TAIL}"
    levels = re.findall(r"LEVEL \S+ MM", " ".join(blocks(edits(one)[0])))
    assert levels == ["LEVEL 2.54 MM", "LEVEL 5.08 MM", "LEVEL 7.62 MM", "LEVEL 10.16 MM"]
    said = one.replace("D1000", "D.1")
    assert blocks(edits(said)[0]) == blocks(edits(one)[0])
    assert blocks(edits(one.replace("D1000", "D.1"), "cycles.depth_unit=program")[0]) == blocks(edits(one)[0])
    assert blocks(edits(one.replace("U.02", "U.02")[:])[0])[2] == "G0 X1.8"


def test_a_cycle_in_a_subroutine() -> None:
    """LinuxCNC, X a radius; the tool stays over the end of the contour."""
    ends = [-30.0] * 6 + [-15.0 - 7.0 * 2.0 / 3.0] + [-15.0, -15.0]
    wanted = []
    for count, z in enumerate(ends, 1):
        x = 28 - 2 * count
        end = f"{z:.4f}".rstrip("0")
        wanted += [f"(PASS {count} LEVEL {2 * count} MM BELOW THE START)", f"G0 X{x}.", f"G1 Z{end}"]
        wanted += [f"G0 X{x}.5 Z{z + 0.5:.4f}".rstrip("0"), "G0 Z2."]
    shape = ["G1 Z-15.", "G1 X12.", "G1 X15. Z-22.", "G1 Z-30.", "G1 X26.", "G1 X28."]
    edit = only("linuxcnc")
    assert blocks(edit) == [*wanted, "(PASS 10 ALONG THE CONTOUR)", "G0 X28.", "G0 X8.", *shape]
    assert (edit.title, edit.reason) == (
        "G71 Q100",
        "passes of 2 mm along Z to the contour in its subroutine",
    )


def test_finishing_in_a_subroutine() -> None:
    """From D to E: 0.6 - 0.4 / 3 and so on; a step of 0.4 mm in X makes arcs of the outer corners."""
    edit = only("linuxcnc", "G71 Q100 I2 R0.5", "G70 Q100 P2 F150 S700")
    way = ["G0 X8.", "G1 Z-15.", "G1 X12.", "G1 X15. Z-22.", "G1 Z-30.", "G1 X26."]
    assert blocks(edit) == [
        *("F150 S700", "(PASS 1 0 MM OFF THE CONTOUR)", *way),
        *("(PASS 2 0 MM OFF THE CONTOUR)", "G0 X28. Z2.", *way),
    ]
    assert edit.reason == "the contour in its subroutine"
    off = blocks(only("linuxcnc", "G71 Q100 I2 R0.5", "G70 Q100 D0.5"))
    assert off[:3] == ["(PASS 1 0 MM OFF THE CONTOUR)", "G0 X8.", "G1 Z-15."]
    last = blocks(only("linuxcnc", "G71 Q100 I2 R0.5", "G70 Q100 E0.5"))
    assert last[:4] == ["(PASS 1 0.5 MM OFF THE CONTOUR)", "G0 X8.5", "G1 Z-14.5", "G1 X12."]


@pytest.mark.parametrize(
    ("cycle", "first", "along"),
    [
        # Where the first pass begins and ends, and the first block of the one along the contour.
        ("G71 Q100 I2 R0.5 D0.4", ["G0 X26.", "G1 Z-29.6"], "G0 X8.4"),
        ("G71 Q100 I2 R0.5 U0.4", ["G0 X26.", "G1 Z-30."], "G0 X8.4"),
        ("G71 Q100 I2 R0.5 W0.4", ["G0 Z2.4", "G0 X26.", "G1 Z-29.6"], "G0 X8."),
        ("G71 Q100 R0.5", ["G0 X27.", "G1 Z-30."], "G0 X8."),
        ("G71 Q100 X28 Z3 I2", ["G0 Z3.", "G0 X26.", "G1 Z-30."], "G0 X8."),
    ],
)
def test_the_words_of_a_cycle_in_a_subroutine(cycle: str, first: list[str], along: str) -> None:
    """D is square to the contour, U and W are along the axes; I is 1 where it is not said."""
    said = blocks(only("linuxcnc", "G71 Q100 I2 R0.5", cycle))
    assert said[1 : 1 + len(first)] == first
    last = said.index(next(one for one in said if "ALONG THE CONTOUR" in one))
    assert said[last + 2] == along
    assert ("G0 X26.5" in " ".join(said[:8])) == ("I2" in cycle)


@pytest.mark.parametrize(
    ("text", "wished"),
    [
        ("G1 X1.", "G1 X1. N1.5"),
        ("G1 X1. (A; B)", "G1 X1. N1.5 (A; B)"),
        ("G1 X1. ; A", "G1 X1. N1.5 ; A"),
        ("G1 X1.(A)", "G1 X1. N1.5 (A)"),
    ],
)
def test_a_wish_stands_before_the_comment(text: str, wished: str) -> None:
    assert with_wish(text, "N1.5") == wished
    assert with_wish(text, "") == text


def test_each_of_several_cycles_is_asked_by_itself() -> None:
    """A cycle that is not asked, or whose shape is missing, keeps none behind it."""
    lx = PROGRAMS["linuxcnc"].replace("G0 X40", "G0 X28 Z2\nG71 Q100 I3\nG0 X28 Z2\nG71 Q100 I0\nG0 X40")
    read = interpreted(lx, profile="linuxcnc-lathe")
    assert cycle_lines(read) == {11: Kind.ROUGH, 13: Kind.ROUGH, 15: Kind.ROUGH}
    second = plan_unrolling(read, [13, 15])
    assert [(one.edit.first, one.group) for one in second.edits] == [(13, 13)]
    assert [one.line for one in second.refused] == [15]
    two = PROGRAMS["G90"].replace("G0 X100.", "G0 X52. Z2.\nG90 X44. Z-20.\nG0 X52. Z2.\nG90 X44.\nG0 X100.")
    read = interpreted(two)
    assert cycle_lines(read) == dict.fromkeys((4, 7, 9))
    assert [one.edit.first for one in plan_unrolling(read, [7, 9]).edits] == [7]
    lost = PROGRAMS["G71 and G70"].replace("G71 P10", "G71 P11")
    read = interpreted(lost)
    assert cycle_lines(read) == {5: Kind.ROUGH, 10: Kind.FINISH}
    plan = plan_unrolling(read, [5, 10])
    # Nothing finds the contour before the G70, so the control cuts along it there.
    assert [(one.line, one.error.code) for one in plan.refused] == [(5, "CYC001"), (10, "CYC002")]
    assert plan.edits == []


# --- and where a block is another ---------------------------------------------------------------------------


def broken(name: str, old: str, new: str, *, at: int = 0) -> str:
    """What is said of a program one block of whose edit is another; "" where nothing is found."""
    profile = "linuxcnc-lathe" if name == "linuxcnc" else "fanuc-lathe"
    found = edits(PROGRAMS[name], profile=profile)
    assert old in found[at].content, found[at].content
    changed = [new if one == old else one for one in found[at].content]
    written = [*found[:at], found[at]._replace(content=tuple(filter(None, changed))), *found[at + 1 :]]
    return looked_after(PROGRAMS[name], written, profile)


def looked_after(program: str, written: list[Edit], profile: str) -> str:
    """What is said of a program whose cycles are these blocks."""
    read = interpreted(program, profile=profile)
    order = sorted(written, key=lambda one: one.first)
    output = b"".join(render(read.program, order, read.settings, UNROLLED_CYCLES))
    try:
        verify_unrolled(read, output, written, UNROLLED_CYCLES)
    except SelfCheckError as error:
        return str(error)
    return ""


LEFT = "an unrolled cycle leaves {} mm too much, {} mm too little over its contour"
BROKEN = [
    ("G71", "G1 Z-29.9 F0.3", "G1 Z-31. F0.3", ""),  # behind the contour stands nothing that is looked after
    ("G71", "G1 Z-27.329", "G1 Z-27.6", LEFT.format("0.000", "0.125")),  # 0.271 x 7 / 15, less a few digits
    ("G71", "G0 X44.", "G0 X43.", "a pass takes 2.500 mm, 2 are commanded"),
    ("G71", "G1 Z-23.043", "G0 Z-23.043", "a rapid of an unrolled cycle goes through 2.000 mm of stock"),
    (
        "G71",
        "G0 X45. Z-29.4",
        "G0 X43. Z-29.4",
        "a rapid of an unrolled cycle goes through 0.492 mm of stock",
    ),
    ("G71", "G1 X30.4 Z-29.9", "G1 X30.2 Z-29.9", "a pass takes 2.079 mm, 2 are commanded"),
    ("G71", "G0 X52.", "G0 X53.", "the position of X (26 and 26.5) differs at the cycle in line 5"),
    ("G71", "G0 Z2.", "G0 Z2.5", "the position of Z (2 and 2.5) differs at the cycle in line 5"),
    ("G71", "G0 Z2.", "G0 Z2. M8", "the coolant differs at the cycle in line 5"),
    ("G71", "G0 Z2.", "G0 Z2. S900", ""),
    ("G71", "G0 Z2.", "G0 Z2.001", "the position of Z (2 and 2.001) differs at the cycle in line 5"),
    ("linuxcnc", "G1 X28.", "G1 X28.0001", ""),
    (
        "linuxcnc",
        "G1 X28.",
        "G1 X28.001",
        "the position of X (28 and 28.001) differs at the cycle in line 12",
    ),
    ("G70", "X30. Z-30.", "X30.01 Z-30.", "the finishing cut at line 5 misses its contour"),
    ("G70", "X30. Z-30.", "X30. Z-30.002", "the finishing cut at line 5 misses its contour"),
    ("G70", "X30. Z-30.", "X30. Z-30.001", ""),
    ("G70", "X30. Z-30.", "X30.002 Z-30.", ""),
    ("G70", "X30. Z-30.", "", "the finishing cut at line 5 misses its contour"),
    ("G70", "G0 Z2.", "G0 Z3.", "the position of Z (2 and 3) differs at the cycle in line 5"),
    ("G90", "G1 Z-20. F0.2", "G1 Z-20.002 F0.2", "the passes at line 5 are not those of the cycle"),
    ("G90", "G1 Z-20. F0.2", "G1 Z-20.001 F0.2", ""),
    ("G90", "G1 Z-20. F0.2", "G0 Z-20.", "the passes at line 5 are not those of the cycle"),
    ("G90", "G0 X46.", "G0 X46.01", "the passes at line 5 are not those of the cycle"),
    ("G90", "G0 X46.", "G0 X46.002", ""),
    ("G90", "G0 X46.", "", "the passes at line 5 are not those of the cycle"),
    ("G73", "G1 X34.4 Z-29.4", "G1 X34.4 Z-29.404", "the passes at line 5 are not those of the cycle"),
    ("G73", "G1 X34.4 Z-29.4", "G1 X34.4 Z-29.402", ""),
    ("G73", "G1 X34.4 Z-29.4", "G0 X34.4 Z-29.4", "the passes at line 5 are not those of the cycle"),
    ("G73", "G1 X34.4 Z-29.4", "G3 X34.4 Z-29.4 R50.", "the passes at line 5 are not those of the cycle"),
    ("G73", "G1 X34.4 Z-29.4", "", "the passes at line 5 are not those of the cycle"),
    ("G73", "G1 X34.4 Z-29.4", "G1 X34.4 Z-29.4\nG1 X35.", "the passes at line 5 are not those of the cycle"),
    ("G75", "G0 Z-16.", "G0 Z-16.01", "the passes at line 7 are not those of the cycle"),
    ("linuxcnc", "G1 X15. Z-22.", "G1 X15.01 Z-22.", LEFT.format("0.010", "0.000")),
    ("linuxcnc", "G1 X28.", "G1 X29.", "the position of X (28 and 29) differs at the cycle in line 12"),
]


ARC = ("G1 Z-15.\nX30. Z-30.", "G1 Z-15.\nG2 X30. Z-22. R7.\nG1 Z-30.")
UNKNOWN = ("G0 X28 Z2\nG71 Q100 I2", "G71 Q100 X28 Z2 I2")


@pytest.mark.parametrize("name", PROGRAMS)
def test_blocks_as_they_are_keep_every_promise(name: str) -> None:
    profile = "linuxcnc-lathe" if name == "linuxcnc" else "fanuc-lathe"
    for program in (PROGRAMS[name], PROGRAMS[name].replace(*ARC), PROGRAMS[name].replace(*UNKNOWN)):
        assert not looked_after(program, edits(program, profile=profile), profile)


@pytest.mark.parametrize(
    ("old", "new", "is_found"),
    [
        ("G2 X34.4 Z-21.4 I7. K0.", "G2 X34.4 Z-21.4 I7.002 K0.", False),
        ("G2 X34.4 Z-21.4 I7. K0.", "G2 X34.4 Z-21.4 I7.5 K0.5", True),
        ("G2 X34.4 Z-21.4 I7. K0.", "G3 X34.4 Z-21.4 I7. K0.", True),
        ("G2 X34.4 Z-21.4 I7. K0.", "G1 X34.4 Z-21.4", True),
    ],
)
def test_an_arc_that_is_another_is_found(old: str, new: str, is_found: bool) -> None:
    program = PROGRAMS["G73"].replace(*ARC)
    found = edits(program)
    assert old in found[0].content, found[0].content
    changed = tuple(new if one == old else one for one in found[0].content)
    said = looked_after(program, [found[0]._replace(content=changed), *found[1:]], "fanuc-lathe")
    assert said == ("the passes at line 5 are not those of the cycle" if is_found else "")


@pytest.mark.parametrize(("name", "old", "new", "said"), BROKEN)
def test_a_block_that_is_another_is_found(name: str, old: str, new: str, said: str) -> None:
    assert broken(name, old, new) == said
