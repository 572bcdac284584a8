"""Starting again in the middle: the start block says what was in force, and the rest is what it was."""

from __future__ import annotations

import math
from pathlib import Path
from random import Random
from typing import Any

import pytest
from click.testing import CliRunner

import chipbreak
from chipbreak.cli import cli
from chipbreak.model.interpreted_program import interpret
from chipbreak.model.state_difference import difference, spindle_speed
from chipbreak.restart.resume import Resumed, resume
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from longer import short_where

LATHE = chipbreak.load("fanuc-lathe", ['planner.model="ideal"'])
MILL = chipbreak.load("fanuc-mill")
LINUXCNC = chipbreak.load("linuxcnc-lathe", ['planner.model="ideal"'])

TURNING = b"""%
O1000 (SHAFT)
G21 G40 G99
G54
N1 (ROUGH)
T0101
G50 S2500
G97 S1200 M3
G0 X52. Z2. M8
G0 X46.
G1 Z-30. F0.2 N1.5
G0 X50.
Z2.
G0 X42.
G1 Z-30. F0.25
G0 U2. Z2.
G28 U0 W0 M9
M1
N2 (FINISH)
T0202
G96 S180 M3
G0 X40. Z2. M8
G1 Z-30. F0.08
G0 X60.
G28 U0 W0 M9
M5
M30
%
"""


def started(data: bytes, line: int, settings: chipbreak.Settings = LATHE) -> tuple[Resumed, list[str]]:
    """The result, and the lines of its start block."""
    result = resume(data, settings, line)
    rest = b"".join(data.splitlines(keepends=True)[result.line - 1 :])
    assert result.data.endswith(rest)
    block = result.data[: -len(rest)].decode().splitlines()
    at = next(n for n, text in enumerate(block) if "CHIPBREAK RESUME" in text)
    return result, block[at + 1 :]


def refusal(data: bytes, line: int, settings: chipbreak.Settings = LATHE) -> chipbreak.Diagnostic:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        resume(data, settings, line)
    (found,) = caught.value.diagnostics
    assert found.help
    return found


def test_a_place_between_two_cuts() -> None:
    result, block = started(TURNING, 14)
    assert result.line == 14
    assert not result.diagnostics
    assert result.data.startswith(b"%\nO1000 (SHAFT)\n(CHIPBREAK RESUME LINE 14)\n")
    assert block == [
        "G21 G40",
        "G28 U0",
        "G28 W0",
        "T0101",
        "G54",
        "G50 S2500",
        "G97 S1200 M3",
        "G0 Z2.",
        "M8",
        "G0 X50.",
        "G99 F0.2",
    ]


def test_a_tool_call_needs_no_place_and_no_other_tool() -> None:
    result, block = started(TURNING, 20)
    assert result.line == 20
    # The program has not stopped the spindle either.
    assert block == ["G21 G40", "G28 U0", "G28 W0", "G54", "G50 S2500", "G97 S1200 M3", "G99 F0.25"]


def test_the_title_before_a_tool_call_starts_with_that_tool() -> None:
    _, block = started(TURNING, 18)
    assert not [text for text in block if text.startswith("T")]


def test_surface_speed_comes_back_with_its_limit() -> None:
    _, block = started(TURNING, 23)
    assert block[3:8] == ["T0202", "G54", "G50 S2500", "G96 S180 M3", "G0 Z2."]


@pytest.mark.parametrize("line", [11, 12, 200])
def test_inside_a_vibrated_cut_it_starts_before_it(line: int) -> None:
    filtered = chipbreak.rewrite(TURNING, LATHE).data
    lines = filtered.decode().splitlines()
    begin = next(n for n, text in enumerate(lines, 1) if "BEGIN VIB" in text)
    end = next(n for n, text in enumerate(lines, 1) if n > begin and "CHIPBREAK END" in text)
    if not begin <= line <= end:
        pytest.skip("the cut is shorter")
    result, block = started(filtered, line)
    assert result.line == begin
    assert block[-1] == "G99"
    (said,) = result.diagnostics if line != begin else [None]
    if said is not None:
        assert (said.code, said.severity.value) == ("RSM003", "note")
        assert f"lines {begin} to {end}" in said.message


def test_behind_a_vibrated_cut_its_speed_is_in_force() -> None:
    """The filter changed S for the cut, and nothing has given it back yet."""
    data = chipbreak.rewrite(TURNING.replace(b"F0.2 N1.5", b"F0.2 N1.5 f25"), LATHE).data
    lines = data.decode().splitlines()
    after = lines.index("Z2.") + 2
    _, block = started(data, after)
    assert "G97 S1000 M3" in block


@pytest.mark.parametrize("line", [11, 12, 13, 15, 16])
def test_a_line_at_which_the_tool_cuts_is_no_start(line: int) -> None:
    result, _ = started(TURNING, line)
    assert result.line <= line
    assert result.line in (11, 13, 14, 15, 16)
    if result.line != line:
        assert "RSM003" in [one.code for one in result.diagnostics]


def test_cutter_compensation_is_cancelled_and_not_started_in() -> None:
    data = TURNING.replace(b"G1 Z-30. F0.08\n", b"G42 G1 Z0. F0.08\nZ-30.\nG0 X45.\nZ2.\nG40 X60.\n")
    result, block = started(data, 26)
    assert result.line == 23
    assert "G40" in block[0]
    assert "compensation" in result.diagnostics[0].message


def test_a_subprogram_is_started_from_its_call() -> None:
    data = b"T0101\nG97 S1000 M3\nG0 X20. Z2.\nM98 P2000\nG28 U0 W0\nM30\nO2000\nG1 W-5. F0.1\nG0 W5.\nM99\n"
    said = refusal(data, 8)
    assert said.code == "RSM002"
    assert said.help == "give the line of its call: 4"
    result, _ = started(data, 4)
    assert result.line == 4
    assert result.data.endswith(b"O2000\nG1 W-5. F0.1\nG0 W5.\nM99\n")


def test_subroutines_of_linuxcnc_that_stand_before_come_along() -> None:
    body = b"o100 sub\nG1 Z-5 F0.1\nG0 Z2\no100 endsub\n"
    data = (
        body + b"G21 G18 G7 G90 G95\nT1 M6 G43\nG97 S900 M3\nG0 X20 Z2\no100 call\nG0 X18 Z2\no100 call\nM2\n"
    )
    result, block = started(data, 9, LINUXCNC)
    assert body in result.data
    assert "G43" in block
    assert "T1 M6" in block


def test_where_nothing_is_known_it_says_what() -> None:
    data = (
        b"G21 G99\nT0101\nG97 S1000 M3\nWHILE [#1 LT 3] DO1\nG0 X20. Z2.\nG1 Z-5. F0.1\nG0 X30.\nEND1\nM30\n"
    )
    said = refusal(b"G0 X20. Z2.\nG1 Z-5. F0.1\nG0 X30.\nM30\n", 1)
    assert said.code == "RSM001"
    result, _ = started(data, 7)
    assert result.line == 2
    assert "loop" in result.diagnostics[0].message


def test_the_way_out_of_no_place() -> None:
    """A line behind a rapid with which the tool has left the work."""
    data = b"T0101\nG97 S900 M3\nG0 X20. Z2.\nG1 Z-5. F0.1\nG0 X30.\nZ2.\nG0 X18.\nG1 Z-5.\nG0 X30.\nM30\n"
    assert started(data, 7)[0].line == 7


def test_plain_variables_are_set_again_others_are_named() -> None:
    data = TURNING.replace(b"G54\n", b"G54\n#100=42.\n#101=#100-2.\n").replace(b"X42.", b"X#101")
    _, block = started(data, 16)
    assert block[3:5] == ["#100=42.", "#101=#100-2."]
    counted = data.replace(b"#101=#100-2.", b"#101=#101+1.")
    result, _ = started(counted, 16)
    assert result.line == 6
    assert "the rest reads #101, which line 6 has set" in result.diagnostics[0].message
    unread = counted.replace(b"X#101", b"X42.")
    assert started(unread, 16)[0].line == 16


def test_the_shape_of_a_cycle_must_come_along() -> None:
    data = (
        b"T0101\nG97 S900 M3\nG0 X52. Z2.\nG71 U2. R1.\nG71 P10 Q20 U0.4 W0.1 F0.3\n"
        b"N10 G0 X20.\nG1 Z-20. F0.1\nN20 X52.\nG0 X60. Z20.\nT0202\n"
        b"G0 X52. Z2.\nG70 P10 Q20\nG0 X60. Z20.\nM30\n"
    )
    result, _ = started(data, 10)
    assert result.line == 4
    assert "reads its shape from lines 6 to 8" in result.diagnostics[0].message


def test_an_origin_that_the_program_sets_is_not_passed_over() -> None:
    data = TURNING.replace(b"G54\n", b"G50 X200. Z100.\n")
    said = refusal(data, 14)
    assert said.code == "RSM001"
    assert "G50 X200. Z100." in said.message


def test_codes_of_the_machine_are_named() -> None:
    data = TURNING.replace(b"G54\n", b"G54\nM41\nM69\n")
    result, _ = started(data, 16)
    (said,) = result.diagnostics
    assert (said.code, said.severity.value) == ("RSM004", "warning")
    assert "M41 (line 5), M69 (line 6)" in said.message
    assert not started(data.replace(b"M41\nM69\n", b""), 14)[0].diagnostics


def test_a_control_without_a_way_home_says_so() -> None:
    data = b"G21 G90\nM3 S1000\nG0 X10. Y10. Z5.\nG1 Z-1. F100.\nG0 Z5.\nG0 X20.\nG1 Z-1.\nG0 Z5.\n"
    result, _ = started(data, 6, chipbreak.load("klipper"))
    assert [one.code for one in result.diagnostics] == ["RSM005"]


def test_a_mill_gets_its_offset_and_the_waiting_tool() -> None:
    data = (
        b"%\nO7\nG21 G17 G40 G49 G80 G90\nT1 M6\nT2\nG55\nS2000 M3\nG0 X10. Y20.\nG43 H1 Z50. M8\nZ2.\n"
        b"G1 Z-3. F200.\nX40.\nG0 Z2.\nX60.\nG91\nG1 Z-5.\nG0 Z5.\nG90\nG28 Z50.\nM30\n%\n"
    )
    _, block = started(data, 14, MILL)
    assert block == [
        "G21 G17 G40",
        "G80",
        "G49",
        "G90",
        "G91 G28 Z0.",
        "G90",
        "T1 M6",
        "T2",
        "G55",
        "S2000 M3",
        "G0 X40. Y20.",
        "M8",
        "G0 G43 H1 Z2.",
        "F200.",
    ]
    _, block = started(data, 16, MILL)
    assert block[-1] == "G91"


def test_a_rotary_axis_comes_back() -> None:
    data = (
        b"G21 G90\nT1 M6\nS900 M3\nG0 X0. Y0. A90.\nG43 H1 Z5.\nG1 Z-1. F99.\nG0 Z5.\n"
        b"G0 X9.\nG1 Z-1.\nG0 Z5.\nM30\n"
    )
    _, block = started(data, 8, MILL)
    assert "G0 A90." in block
    turned, _ = started(data.replace(b"G43", b"G91 A10.\nG90 G43"), 10, MILL)
    assert turned.line == 5
    assert "where axis A stands after line 5 is not known" in turned.diagnostics[0].message


def test_a_line_that_is_not_there_and_a_part_that_was_edited() -> None:
    with pytest.raises(ValueError, match="no line 99"):
        resume(TURNING, LATHE, 99)
    filtered = chipbreak.rewrite(TURNING, LATHE).data.replace(b"G1 Z1.", b"G1 Z3.", 1)
    assert refusal(filtered, 14).code == "RES001"


def test_the_command(tmp_path: Path) -> None:
    runner = CliRunner()
    old, new = tmp_path / "a.nc", tmp_path / "b.nc"
    old.write_bytes(TURNING)
    asked = ["resume", "-p", "fanuc-lathe", str(old), "--line"]
    done = runner.invoke(cli, [*asked, "14", "-o", str(new)])
    assert done.exit_code == 0, done.output
    assert new.read_bytes() == resume(TURNING, chipbreak.load("fanuc-lathe"), 14).data
    assert runner.invoke(cli, [*asked, "99"]).exit_code == 2
    rejected = runner.invoke(cli, [*asked, "2"])
    assert rejected.exit_code == 3
    assert rejected.stdout == ""


# --- random programs: what is in force, and where all moves go --------------------------------------------
def _program(random: Random) -> bytes:
    """A turning program with one to three tools, in all modes that a shop mixes."""
    lines = [
        "%",
        "O77",
        random.choice(["G21 G40 G99", "G21 G98", "G40"]),
        random.choice(["G54", "G55", "(NONE)"]),
    ]
    for tool in random.sample(range(1, 9), k=random.randint(1, 3)):
        lines += [
            "M1",
            f"N{tool}00 (TOOL {tool})",
            f"T0{tool}0{tool}",
            random.choice(["G50 S3000", "(NO LIMIT)"]),
        ]
        lines.append(random.choice(["G97 S900 M3", "G96 S150 M4", "G97 S1500 M3"]))
        x, z = 60.0, 3.0
        lines.append(f"G0 X{x} Z{z}" + random.choice(["", " M8"]))
        for _ in range(random.randint(1, 4)):
            x -= random.choice([1.0, 2.5])
            lines += [random.choice([f"G0 X{x}", f"G0 X{x} Z{z}"])]
            lines.append(
                f"G1 Z{random.choice(['0', '1.', '-0.5'])} F{random.choice(['0.1', '0.25'])}"
                + random.choice(["", " N1.5 f10"])
            )
            lines += [random.choice(["G0 U3.", "G0 X70."]), f"Z{z}"]
            lines += random.choice(
                [["M8"], ["M9"], ["G99 F0.15"], ["G98 F120."], ["S1100"], ["(SO)"], ["G4 U1."]]
            )
        lines += ["G28 U0 W0", random.choice(["M5", "M9", "(ON)"])]
    return "\n".join([*lines, "M30", "%", ""]).encode()


def _rest(data: bytes, line: int) -> tuple[Any, list[Any]]:
    """The state before a line (from 1), and what the blocks from there on do."""
    whole = interpret(parse(read(data), LATHE.dialect), LATHE)
    source = whole.program.source
    effects = [
        (one.block.text, one.after.modes, one.after.feed and one.after.feed.value, one.after.spindle)
        + ((one.move.kind, one.move.start, one.move.end) if one.move else ())
        for one in whole.effects_of(line - 1, source.body.stop)
    ]
    return whole.before(line - 1), effects


def _ends(moves: list[Any]) -> list[Any]:
    """Where the moves with a known end go to."""
    known = [one for one in moves if len(one) > 4 and not math.isnan(one[6].x + one[6].z)]
    return [one[6] for one in known]


def _goes_on(data: bytes, line: int) -> None:
    """A restart at a line does what the whole program does from there on, or says why there is none."""
    try:
        result = resume(data, LATHE, line)
    except chipbreak.ProgramRejectedError as error:
        assert {one.code for one in error.diagnostics} <= {"RSM001", "RSM002"}
        return
    rest = b"".join(data.splitlines(keepends=True)[result.line - 1 :])
    was, moves = _rest(data, result.line)
    now, again = _rest(result.data, result.data.count(b"\n") - rest.count(b"\n") + 1)
    if moves[0][0].startswith(("M1", "N", "T")):  # at a tool call: the way there is another
        assert _ends(moves) == _ends(again)
        return
    assert difference(was, now) == ""
    assert spindle_speed(was) == spindle_speed(now)
    assert moves == again


@pytest.mark.parametrize("seed", short_where(range(16), lambda seed: seed % 2 == 0))
def test_random_programs_go_on_as_they_would_have(seed: int) -> None:
    random = Random(seed)
    data = _program(random)
    if seed % 2 and b"G98" not in data:
        data = chipbreak.rewrite(data, LATHE, allow_unbroken=True).data
    for line in random.sample(range(5, data.count(b"\n")), k=4):
        _goes_on(data, line)


def test_overrides_that_the_filter_holds_are_given_back_before_anything_moves() -> None:
    """A run that ended inside a cut has left them held, and the operator must slow down what comes now."""
    settings = chipbreak.load("linuxcnc-lathe", ["planner.model=ideal"])
    program = (Path(__file__).parents[2] / "samples" / "linuxcnc-lathe.ngc").read_bytes()
    held = chipbreak.rewrite(program, settings).data
    assert resume(held, settings, 200).data.splitlines()[2:4] == [b"M50 P1", b"M51 P1"]
    assert b"M50" not in resume(program, settings, 25).data.partition(b"T1 M6")[0]


def test_nothing_starts_inside_what_was_offset_for_the_nose() -> None:
    settings = chipbreak.load(
        "fanuc-lathe", ["planner.model=ideal", "tools.nose_radius_mm.1=0.8", "tools.nose_tip.1=3"]
    )
    program = (
        b"O5\nG21 G40 G99\nT0101\nG97 S800 M3\nG0 X60. Z5.\n(VIB N1.5)\nG42 G0 X30. Z2.\nG1 Z-20. F0.2\n"
        b"X40. Z-30.\nZ-50.\nG40 G0 X60.\n(VIB OFF)\nG0 Z5.\nG1 X20. Z0 F0.1\nG0 X100. Z100.\nM30\n"
    )
    filtered = chipbreak.rewrite(program, settings).data
    lines = filtered.split(b"\n")
    first = next(n for n, text in enumerate(lines, 1) if b"CHIPBREAK COMPENSATED" in text)
    last = next(n for n, text in enumerate(lines, 1) if b"CHIPBREAK OFFSET" in text)
    assert last - first > 100
    for line in range(first + 1, last, 97):
        assert resume(filtered, settings, line).line == first


@pytest.mark.parametrize(("line", "wishes"), [(8, ["(VIB N1.5)"]), (12, ["(VIB OFF)"]), (15, [])])
def test_the_wish_in_force_is_said_again(line: int, wishes: list[str]) -> None:
    program = (
        b"G21 G40 G99\nT0101\nG97 S800 M3\nG0 X60. Z5.\n(VIB N1.5)\nG1 Z-20. F0.2\nG0 X70. Z5.\nG0 X58.\n"
        b"G1 Z-20.\n(VIB OFF)\nG0 X70. Z5.\nG0 X56.\nG1 Z-10. F0.1\nG0 X100. Z100.\nT0202\nG0 X60. Z5.\n"
        b"G1 Z-10. F0.1\nG0 X100. Z100.\nM30\n"
    )
    result = resume(program, LATHE, line)
    assert result.line == line
    rest = b"".join(program.splitlines(keepends=True)[line - 1 :])
    start = result.data.removesuffix(rest).decode().splitlines()
    assert [text for text in start if text.startswith("(VIB")] == wishes


BEHIND_FINISHING = (
    "G97 S600 M3\nG99\nG0 X30. Z5.\nG71 U1. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.12\n"
    "N10 G0 X28.\nG1 Z0. F0.1\nZ-5.\nN20 X30.\nG70 P10 Q20\nG0 X80.\nZ10.\n{}G1 Z5.{}\nG0 X80.\nM30\n"
)


@pytest.mark.parametrize("profile", ["fanuc-lathe", "haas-lathe", "mitsubishi-lathe", "generic-lathe"])
@pytest.mark.parametrize(
    ("before", "feed", "is_safe"),
    [
        ("", " F0.3", True),
        ("F0.3\n", "", True),
        ("", "", False),
        # The F of a contour is that of its G70; roughing passes over it.
        ("G71 U1. R0.5\nG71 P30 Q40\nN30 G0 X78.\nG1 Z0. F0.2\nN40 X80.\n", "", False),
    ],
)
def test_which_f_finishing_leaves_is_not_known_and_need_not_be(
    profile: str, before: str, feed: str, is_safe: bool
) -> None:
    program = BEHIND_FINISHING.format(before, feed).encode()
    try:
        resumed = resume(program, chipbreak.load(profile), 11)
    except chipbreak.ProgramRejectedError:
        assert not is_safe
        return
    assert (resumed.line == 11) == is_safe


def test_a_subprogram_behind_the_line_that_is_never_closed() -> None:
    program = b"G21 G18 G90\nT1 M6\nG97 S1000 M3\nG0 X30 Z5\nG1 Z-5 F0.1\nG0 X40\no100 sub\nG0 X50\nM2"
    resumed = resume(program, chipbreak.load("linuxcnc-lathe"), 4)
    assert resumed.data.endswith(b"G0 X40\no100 sub\nG0 X50\nM2")
