"""Which check stands where, and the limit that depends on what the tool does next."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import chipbreak
from beam import BEAM
from checks.filtered import Filtered, check, filtered

SAMPLE = (Path(__file__).parents[2] / "samples" / "fusion-mill.nc").read_bytes()
HEAD = "G90 G94 G17 G49 G40 G80\nG21\nG28 G91 Z0.\nG90\n"
END = "G28 G91 Z0.\nG90\nM30\n"


def visit(tool: int, *operations: str, speed: str = "S1000 M3\n") -> str:
    """A tool call with its operations, each a title or "" for none."""
    text = f"T{tool} M6\n{speed}"
    for title in operations:
        text += f"({title})\n" if title else ""
        text += f"G0 X1. Y2.\nG43 Z15. H{tool}\nG1 Z-1. F100.\nX9.\nG0 Z15.\n"
    return text + "M5\nG28 G91 Z0.\nG90\nG49\n"


def run(*visits: str, options: tuple[str, ...] = (), profile: str = "fanuc-mill") -> Filtered:
    result = filtered((HEAD + "".join(visits) + END).encode(), profile, *options)
    check(result)
    return result


def limits(result: Filtered) -> list[str]:
    return [title for edit in result.titles for title in edit.split(", ") if title.startswith("CHIP")]


def test_the_sample_checks_between_two_operations_of_one_tool() -> None:
    result = filtered(SAMPLE)
    check(result)
    assert result.titles == [
        "CALIBRATE",
        "TOOL CHECK T1, TRACE T1",
        "CHIP CHECK T1 W0.02",
        "TOOL CHECK T2, TRACE T2",
        "CHIP CHECK T2 W0.02",
        "CHIP CHECK T2 W0.05",
        "TOOL CHECK T3, TRACE T3",
        "CHIP CHECK T3 W0.02",
    ]
    assert result.diagnostics == []
    assert not any(d.code == "SYN001" for d in result.interpreted.program.unreadable())
    between, last = result.edits[4], result.edits[5]
    assert result.interpreted.program.source.text(between.first) == "(2D CONTOUR3 FINISH)"
    assert between.reason.startswith('T2 is used next for FINISH ("FINISH" in the comment')
    assert last.reason.startswith("last use of T2; the next workpiece starts with ROUGH")


@pytest.mark.parametrize(
    "between",
    [
        visit(9, "PROBE"),
        visit(9, "PROBE").replace("G1", "G0"),
        visit(9, "DRILL").replace("G1", "G0"),
        visit(9, "DRILL", "ROUGH"),
        visit(8, "ROUGH") + visit(9, "DRILL", "ROUGH", "FACE"),
    ],
    ids=["a probe that touches", "a probe", "nothing is cut", "two operations", "two tools"],
)
def test_what_other_tools_do_between_changes_no_limit(between: str) -> None:
    """T1 finishes next, whatever comes before that: tight, and then wide for the next workpiece."""
    rough, finish = visit(1, "ROUGH"), visit(1, "FINISH")
    assert limits(run(rough, finish)) == ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]
    found = [title for title in limits(run(rough, between, finish)) if "T1" in title]
    assert found == ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]


def test_a_speed_in_turns_is_given_back_in_whatever_units_it_was_said() -> None:
    """1000 rpm are as many in inches, so nothing is said of units."""
    result = run(visit(1, "ROUGH", "FINISH", speed="G20\nS1000 M3\nG21\n"))
    between = next(edit for edit in result.edits if edit.title == "CHIP CHECK T1 W0.02")
    assert between.content == ("G91 G28 Z0.", "G90", "M5", "G65 P9813 T1 W0.02", "S1000 M3")


def swapped(data: bytes) -> bytes:
    """The two operations of T2 change places; the tool call stays where it was."""
    rough = re.search(rb"N160 G0 X-11.*?N300 G0 Z15\.\r\n", data, re.DOTALL)
    finish = re.search(rb"N305 G0 X0.*?N385 G0 Z15\.\r\n", data, re.DOTALL)
    assert rough and finish
    moved_g43 = rough[0].replace(b"G43 Z15. H2", b"Z15."), finish[0].replace(b"Z5.", b"G43 Z15. H2", 1)
    data = data.replace(rough[0], b"@").replace(finish[0], moved_g43[0]).replace(b"@", moved_g43[1])
    data = data.replace(b"(2D ADAPTIVE2)", b"@").replace(b"(2D CONTOUR3 FINISH)", b"(2D ADAPTIVE2)")
    return data.replace(b"@", b"(2D CONTOUR3 FINISH)")


def test_swapped_operations_swap_the_limits() -> None:
    result = filtered(swapped(SAMPLE))
    check(result)
    assert [op.kind.value for op in result.operations] == ["unknown", "finish", "rough", "drill"]
    assert result.titles[4:6] == ["CHIP CHECK T2 W0.05", "CHIP CHECK T2 W0.02"]


@pytest.mark.parametrize(
    ("title", "w_mm"),
    [
        ("ROUGH", "0.05"),
        ("FINISH", "0.02"),
        ("SEMI-FINISH", "0.02"),
        ("2D CONTOUR2", "0.02"),
        ("DRILL4", "0.02"),
    ],
)
def test_the_next_operation_sets_the_limit(title: str, w_mm: str) -> None:
    assert limits(run(visit(1, "ADAPTIVE1", title)))[0] == f"CHIP CHECK T1 W{w_mm}"
    assert (
        limits(run(visit(1, "ADAPTIVE1"), visit(2, "FACE1"), visit(1, title)))[0] == f"CHIP CHECK T1 W{w_mm}"
    )


def test_an_unknown_operation_takes_the_stricter_limit_whichever_it_is() -> None:
    options = ("checks.w_rough_mm=0.01", "checks.w_finish_mm=0.03")
    assert limits(run(visit(1, "ADAPTIVE1", "TRACE7"), options=options))[0] == "CHIP CHECK T1 W0.01"


def test_the_limit_may_be_set_per_tool() -> None:
    result = run(visit(1, "ADAPTIVE1", "FINISH"), visit(2, "FINISH"), options=("checks.w_mm.1=0.04",))
    assert limits(result) == ["CHIP CHECK T1 W0.04", "CHIP CHECK T1 W0.04", "CHIP CHECK T2 W0.02"]
    assert "checks.w_mm gives T1" in result.edits[2].reason


@pytest.mark.parametrize(
    ("policy", "expected"),
    [
        ("next-part", ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]),
        ("none", ["CHIP CHECK T1 W0.02"]),
        ("0.1", ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.1"]),
    ],
)
def test_the_last_use_of_a_tool(policy: str, expected: list[str]) -> None:
    result = run(visit(1, "ADAPTIVE1", "FINISH"), options=(f"checks.last_use={policy}",))
    assert limits(result) == expected


def test_the_next_part_starts_with_the_first_operation_not_the_last() -> None:
    result = run(visit(1, "FINISH"), visit(2, "ADAPTIVE1"), visit(1, "ADAPTIVE2"))
    assert limits(result) == ["CHIP CHECK T1 W0.05", "CHIP CHECK T2 W0.05", "CHIP CHECK T1 W0.02"]


def test_a_tool_called_again_is_checked_again_but_its_shape_is_kept() -> None:
    result = run(visit(1, "ADAPTIVE1"), visit(2, "FACE1"), visit(1, "FINISH"))
    assert [t for t in result.titles if not t.startswith("CHIP")] == [
        "CALIBRATE",
        "TOOL CHECK T1, TRACE T1",
        "TOOL CHECK T2, TRACE T2",
        "TOOL CHECK T1",
    ]


def test_only_and_ignore() -> None:
    visits = (visit(1, "FACE1"), visit(2, "FACE2"), visit(3, "FACE3"))

    def tools(*options: str) -> set[str]:
        return set(re.findall(r"T\d", " ".join(run(*visits, options=options).titles)))

    assert tools("checks.ignore=[2]") == {"T1", "T3"}
    assert tools("checks.only=[2, 3]") == {"T2", "T3"}
    assert tools("checks.only=[2, 3]", "checks.ignore=[3]") == {"T2"}


def test_the_beam_is_measured_straight_before_the_first_checked_tool() -> None:
    result = run(visit(1, "FACE1"), visit(2, "FACE2"), options=("checks.only=[2]",))
    assert result.titles[0] == "CALIBRATE"
    assert result.interpreted.program.source.text(result.edits[0].first) == "T2 M6"


def test_nothing_happens_unless_asked() -> None:
    result = run(visit(1, "FACE1"), options=("checks.enabled=false",))
    assert (result.edits, result.diagnostics) == ([], [])


def test_a_lathe_checks_when_the_profile_asks() -> None:
    program = b"G28 U0 W0\nT0101 (ROUGH TURN)\nG97 S800 M3\nG0 X50. Z2.\nG1 Z-20. F0.2\nG28 U0 W0\nM30\n"
    assert filtered(program, "fanuc-lathe").edits == []
    result = filtered(program, "fanuc-lathe", "checks.enabled=true")
    assert result.titles == ["CALIBRATE", "TOOL CHECK T1, TRACE T1", "CHIP CHECK T1 W0.05"]
    assert [edit.content[:2] for edit in result.edits] == [("G28 U0", "G28 W0")] * 3


@pytest.mark.parametrize(
    ("way_out", "is_checked"),
    [
        ("G0 X19. Z-10.", False),  # off the wall, but still in the bore
        ("G0 X19.\nZ2.", True),
        ("G0 X60.", True),
        ("G0 X19. Z-10.\nG28 U0 W0", True),
    ],
)
def test_no_turning_tool_goes_home_through_the_wall_of_a_bore(way_out: str, is_checked: bool) -> None:
    program = "G28 U0 W0\nT0303 (ROUGH BORE)\nG97 S800 M3\nG0 X20. Z2.\nG1 Z-20. F0.2\n"
    program += f"{way_out}\n(FINISH BORE)\nG0 X20. Z-5.\nG1 X20.2 F0.1\nZ-20.\nG0 X19.\nG0 Z2.\nG28 U0 W0\n"
    result = filtered(program.encode(), "fanuc-lathe", "checks.enabled=true")
    check(result)
    assert ("CHIP CHECK T3 W0.02" in result.titles) == is_checked
    assert is_checked or "through the wall" in only_code(result, "CHK002")


def test_a_probe_is_not_checked() -> None:
    probing = "T9 M6\n(PROBE)\nG0 X1. Y2.\nG43 Z15. H9\nG31 Z-5. F100.\nG0 Z50.\nG28 G91 Z0.\nG90\n"
    assert "T9" not in " ".join(run(probing, visit(1, "FACE1")).titles)


@pytest.mark.parametrize(
    "options", [(), ('calls.shop={chip_check=["G65 P9858 T{tool}"]}', "checks.calls=shop")]
)
@pytest.mark.parametrize("name", ["T14 - CHIP FAN", "T14 - AIR NOZZLE", "T14 | BLOW-OFF FAN | H14"])
def test_what_has_no_edge_is_not_measured_and_that_is_said(name: str, options: tuple[str, ...]) -> None:
    program = f"({name})\n{HEAD}" + visit(1, "FACE1") + visit(14, "FACE2") + END
    found = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-mill", (*BEAM, *options)))
    assert not [edit.title for edit in found.edits if "T14" in edit.title]
    assert [edit.title for edit in found.edits if "T1 " in edit.title + " "]
    (told,) = (d.message for d in found.diagnostics if d.code == "CHK005")
    kind = "air nozzle" if "AIR" in name else "chip fan"
    assert told == f'T14 has no edge to measure, so it is not checked: "{kind}" (comment in line 1)'


def test_a_tool_that_never_cuts_is_not_checked() -> None:
    result = run(visit(1, "FACE1"), "T2 M6\n")
    assert "T2" not in " ".join(result.titles)


def test_an_own_set_without_trace_needs_no_shape() -> None:
    shop = ('calls.shop={chip_check=["G65 P9858 T{tool} H{limit}"]}', "checks.calls=shop")
    result = run(visit(1, "ADAPTIVE1", "FINISH", speed=""), options=shop)
    assert result.titles == ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]
    assert "G65 P9858 T1 H0.02" in result.edits[0].content


# --- what cannot be done is said -----------------------------------------------------------------------


def only_code(result: Filtered, code: str) -> str:
    (found,) = (d for d in result.diagnostics if d.code == code)
    assert found.place is not None
    return f"{found.place.line}: {found.message}"


OTHER_TOOL = "{skip}T2 M6\n{skip}S900 M3\n"
WORK = "G0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nX9.\nG0 Z15.\n"


@pytest.mark.parametrize(("skip", "limit"), [("", 0.05), ("/", 0.02)])
def test_where_block_delete_leaves_the_other_tool_in_the_magazine_this_one_goes_on(
    skip: str, limit: float
) -> None:
    """/T2 M6: with the switch on T1 finishes, and a chip that is no harm to roughing marks the part."""
    call = OTHER_TOOL.format(skip=skip)
    result = run(visit(1, "ROUGH").replace("M5\n", ""), call, f"(FINISH)\n{WORK}")
    assert limits(result)[0] == f"CHIP CHECK T1 W{limit:g}"
    reason = next(edit.reason for edit in result.edits if edit.title.startswith("CHIP CHECK T1"))
    assert ("if block delete (/) leaves out the call of T2" in reason) == (skip == "/")


def test_its_own_limit_goes_with_the_tool_that_may_go_on() -> None:
    own = ("checks.w_mm.1=0.03", "checks.w_mm.2=0.01")
    call = OTHER_TOOL.format(skip="/")
    result = run(visit(1, "ROUGH").replace("M5\n", ""), call, f"(FINISH)\n{WORK}", options=own)
    assert limits(result)[0] == "CHIP CHECK T1 W0.03"


@pytest.mark.parametrize(("skip", "limit"), [("", 0.05), ("/", 0.02)])
def test_an_operation_that_may_be_left_out_does_not_decide_alone(skip: str, limit: float) -> None:
    optional = "".join(f"{skip}{line}\n" for line in WORK.splitlines())
    result = run(visit(1, "ROUGH"), f"T1 M6\nS1000 M3\n(ROUGH 2)\n{optional}(FINISH)\n{WORK}")
    assert limits(result)[0] == f"CHIP CHECK T1 W{limit:g}"


@pytest.mark.parametrize(("jump", "limit"), [("", 0.05), ("/GOTO 100\n", 0.02)])
def test_an_operation_that_a_jump_may_pass_by_does_not_decide_alone(jump: str, limit: float) -> None:
    result = run(visit(1, "ROUGH"), f"{jump}T1 M6\nS1000 M3\n(ROUGH 2)\n{WORK}N100 (FINISH)\n{WORK}")
    assert limits(result)[0] == f"CHIP CHECK T1 W{limit:g}"


def test_no_tool_call() -> None:
    result = run("S1000 M3\nG0 Z5.\nG1 X5. F100.\n")
    assert result.edits == []
    assert only_code(result, "CHK001").startswith("1: no tool is called")
    (waiting,) = run("T3\nS1000 M3\nG0 Z5.\nG1 X5. F100.\n").diagnostics
    assert waiting.code == "CHK001"
    assert "T in line 5 prepares a tool" in waiting.help
    inside = f"{HEAD}M98 P2000\nS1000 M3\nG0 Z5.\nG1 X5. F100.\n{END}O2000\nT1 M6\nM99\n"
    (elsewhere,) = [d for d in filtered(inside.encode()).diagnostics if d.code == "CHK001"]
    assert elsewhere.help.endswith("the call in line 13 is not in the main program")


def test_no_safe_border() -> None:
    start = "T1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\n"
    result = run(start + "G41 D1 X5.\nG1 Z-1. F100.\n(FINISH)\nX9.\nG0 Z15.\nG40 X1.\n")
    message = only_code(result, "CHK002")
    assert message.startswith("11: left out: CHIP CHECK T1 W0.02; nothing can be inserted here, because")
    assert message.endswith("cutter compensation (G41, G42) is on")


def test_a_beam_that_cannot_be_measured_at_the_start_is_measured_later() -> None:
    """The first tool comes down where the operator left X and Y; the second one is sent to a place."""
    first = "T1 M6\nS1000 M3\nG43 Z15. H1\nG0 X1. Y2.\nG1 Z-1. F100.\nG0 Z15.\n"
    first += "M5\nG28 G91 Z0.\nG90\nG49\n"
    calls = (
        'calls.counting={calibrate="G65 P9810 K{every}", tool_check="G65 P9811 T{tool} K{every}", '
        'chip_check="G65 P9813 T{tool} W{limit} K{every}"}'
    )
    options = (calls, "checks.calls=counting", "checks.every=3")
    result = run(first, visit(2, "FINISH"), visit(1, "FINISH"), options=options)
    assert result.titles[:3] == ["TOOL CHECK T1", "CHIP CHECK T1 W0.02, CALIBRATE", "TOOL CHECK T2"]
    assert "".join(result.titles).count("CALIBRATE") == 1
    said = result.output.decode()  # nobody has counted this workpiece before T2
    assert said.index("P9811 T1 K1") < said.index("P9810 K3") < said.index("P9811 T2 K3")
    assert said.index("P9810 K3") < said.index("P9811 T1 K3")
    message = only_code(result, "CHK002")
    assert "CALIBRATE before T1, which is measured by the beam as it was last found, if ever; " in message
    assert "rely on where X is" in message
    only_one = run(first)
    assert only_one.titles[0] == "TOOL CHECK T1, TRACE T1"
    assert "CALIBRATE before T1" in only_code(only_one, "CHK002")


def test_no_speed_at_the_first_cut() -> None:
    """TRACE takes the speed of TOOL CHECK, and the tool data that came with it: alone it would only alarm."""
    result = run(visit(1, "ADAPTIVE1", "FINISH", speed=""))
    assert result.codes == ["CHK003", "CHK003", "CHK004"]
    said = [d.message for d in result.diagnostics]
    assert said[0].endswith("TOOL CHECK T1; the spindle speed of this cut is not known")
    assert said[1].endswith("TRACE T1; the spindle speed of this cut is not known")
    assert result.titles == []
    later = run(visit(1, "ADAPTIVE1", speed=""), visit(1, "FINISH"))
    assert later.titles[:2] == ["CALIBRATE", "TOOL CHECK T1, TRACE T1"]


def test_a_trace_that_counts_on_no_speed_stands_alone() -> None:
    calls = 'calls.mine={trace="G65 P8500 T{tool}", chip_check="G65 P8501 T{tool}"}'
    options = (calls, "checks.calls=mine")
    result = run(visit(1, "ADAPTIVE1", "FINISH", speed=""), options=options)
    assert result.titles[0] == "TRACE T1"
    assert result.codes == []


def test_no_shape_to_compare_with() -> None:
    result = run(
        "T1 M6\nS1000 M3\nG1 X5. Z-1. F100.\nX9.\nG0 Z15.\n(FINISH)\nG0 X1. Y2.\nZ1.\nG1 Z-1.\nG0 Z50.\n"
    )
    # Where the first cut starts nobody knows: neither CALIBRATE may move X and Y there, nor TOOL CHECK.
    assert result.codes == ["CHK002", "CHK002", "CHK004"]
    assert result.edits == []  # and no beam is measured for nothing


def test_another_program_behind_the_end() -> None:
    result = filtered((HEAD + visit(1, "FACE1") + "M30\nO2\n" + visit(2, "FACE2") + "M99\n").encode())
    check(result)
    assert "T2" not in " ".join(result.titles)
    assert only_code(result, "CHK005").startswith("24: another program")


@pytest.mark.parametrize("end", ["T0", "T0100"])
def test_an_offset_that_ends_on_the_way_home_changes_no_limit(end: str) -> None:
    program = (
        "G21 G40 G99\nN1 (ROUGHING OD)\nG28 U0 W0 {end}\nT0101\nG97 S800 M3\nG54 G0 X80. Z2.\nG1 Z-50. F0.3\n"
        "G0 X90. Z2.\nG28 U0 W0 {end}\nM1\nN2 (FINISHING OD)\nG28 U0 W0 {end}\nT0101\nG97 S900 M3\n"
        "G54 G0 X78. Z2.\nG1 Z-50. F0.1\nG0 X90. Z2.\nG28 U0 W0 {end}\nM30\n"
    )
    with_end = filtered(program.format(end=end).encode(), "fanuc-lathe", "checks.enabled=true")
    without = filtered(program.format(end="").encode(), "fanuc-lathe", "checks.enabled=true")
    check(with_end)
    assert limits(with_end) == limits(without) == ["CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]
    assert with_end.titles == without.titles


@pytest.mark.parametrize("change", ["T0 M6", "T5 M6"])
def test_a_tool_is_checked_before_another_takes_its_place_even_if_that_one_cuts_nothing(change: str) -> None:
    blocked = f"T1 M6\nS1000 M3\n(ROUGH)\n{WORK}G41 D1 X1.\n{change}\nG40 X0.\nG0 Z50.\n"
    result = run(blocked, visit(2, "FINISH"))
    call = result.data.decode().splitlines().index(change)
    places = {title: edit.first for edit in result.edits for title in [edit.title]}
    assert [title for title in places if title.startswith("CHIP CHECK T1")]
    assert all(line <= call for title, line in places.items() if title.startswith("CHIP CHECK T1"))


def test_a_tool_zero_is_nobody_s_sister() -> None:
    assert "CHK008" not in run(visit(0, "FACE1")).codes


def test_a_tool_without_a_number() -> None:
    result = run("S1000 M3\nG0 X1. Y1.\nG0 Z1.\nG1 Z-1. F100.\nG0 Z50.\n", visit(1, "FACE1"))
    assert only_code(result, "CHK006").startswith("8: this operation cuts with a tool whose number")
    assert any(title.startswith("CHIP CHECK T1") for title in result.titles)


def test_what_is_cut_after_t0_is_cut_by_no_tool_that_could_be_checked() -> None:
    result = run(visit(1, "FACE1"), visit(0, "FACE2"))
    assert only_code(result, "CHK006").endswith("cuts after T0, which calls no tool; it is not checked")
    assert not [title for title in result.titles if "T0" in title]


def test_a_code_that_nobody_knows_may_have_switched_anything_until_a_tool_is_called() -> None:
    """G254, Haas: from here on the machine works out the work offset from where the table stands."""
    odd = visit(1, "ROUGH", "FINISH").replace("(FINISH)", "G254\n(FINISH)")
    result = run(odd, visit(2, "ROUGH", "FINISH"))
    assert "TOOL CHECK T2, TRACE T2" in result.titles
    assert [title for title in result.titles if "T1" in title] == [
        "TOOL CHECK T1, TRACE T1",
        "CHIP CHECK T1 W0.02",  # the one before the code
    ]
    assert result.codes == ["CHK002"]
    message = result.diagnostics[0].message
    assert message.endswith("before it says G254, which this profile does not know")
    assert result.diagnostics[0].help.startswith("call the tool again after it")
    assert run(odd.replace("G254\n", "G187 P3 E0.1\nG103 P1\n")).codes == []


def test_coolant_through_the_spindle_must_be_off() -> None:
    work = visit(1, "ROUGH", "FINISH").replace("S1000 M3\n", "S1000 M3\nM88\n")
    result = run(work, visit(2, "FINISH"))
    assert result.codes == ["CHK002", "CHK002"]
    assert "coolant through the spindle (M88, line 7) is on" in result.diagnostics[0].message
    assert "TOOL CHECK T2, TRACE T2" in result.titles
    off = run(work.replace("(FINISH)", "M89\n(FINISH)"), visit(2, "FINISH"))
    assert off.codes == []
    assert "CHIP CHECK T1 W0.02" in off.titles


def test_behind_a_subprogram_it_is_the_call_that_is_in_the_way() -> None:
    called = "(ROUGH)\nG0 X1. Y2.\nG43 Z15. H1\nM98 P1000\n(FINISH)\nM98 P1000\nG0 Z15.\n"
    data = f"{HEAD}T1 M6\nS1000 M3\n{called}{END}O1000\nG1 Z-1. F100.\nG0 Z15.\nM99\n"
    result = filtered(data.encode())
    assert "because a subprogram or a macro was called last" in only_code(result, "CHK002")


def test_under_constant_surface_speed_s_of_a_check_would_be_no_speed_of_the_spindle() -> None:
    g96 = visit(1, "ROUGH", "FINISH").replace("(FINISH)", "G96 S120\n(FINISH)")
    result = run(visit(1, "ROUGH"), g96.replace("M5\n", "G97 S900\nM5\n"))
    assert result.codes == []
    result = run(visit(1, "ROUGH"), g96)
    assert "constant surface speed (G96) is on" in only_code(result, "CHK002")


def maybe(before: str, inside: str, behind: str) -> str:
    """A rough operation, something that may be left out, and a finish of the same tool."""
    head = "G21 G90 G17\nT1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\n(ROUGH)\nG1 Z-1. F100.\nG0 Z15.\n"
    again = "G0 X1. Y2.\nS1000\n(FINISH)\nG0 X3. Y4.\nG0 Z5.\nG1 Z-1. F100.\nG0 Z15.\nM30\n"
    return f"{head}{before}\n{inside}\n{behind}\nG1 X5. F100.\nG0 Z15.\n{again}"


@pytest.mark.parametrize(
    ("profile", "before", "behind"),
    [
        ("fanuc-mill", "IF [#1 EQ 0] GOTO 50", "N50"),
        ("fanuc-mill", "WHILE [#1 LT 3] DO1", "END1"),
        ("linuxcnc-mill", "o10 if [#1 EQ 0]", "o10 endif"),
        ("linuxcnc-mill", "o10 repeat [#1]", "o10 endrepeat"),
        ("linuxcnc-mill", "o10 while [#1 LT 3]", "o10 endwhile"),
        ("linuxcnc-mill", "o10 if [#1 EQ 0]", "o10 else\nG4 P1\no10 endif"),
    ],
)
@pytest.mark.parametrize(
    ("inside", "what"),
    [
        ("M8", "coolant"),
        ("M4", "the spindle"),
        ("G91", "the distance mode (G90, G91)"),
        ("G20", "the units (G20, G21)"),
    ],
)
def test_what_a_part_sets_that_may_be_left_out_is_not_put_back(
    profile: str, before: str, behind: str, inside: str, what: str
) -> None:
    """M3 before a branch with M4 in it: behind the check the spindle would turn the wrong way."""
    result = filtered(maybe(before, inside, behind).encode(), profile)
    check(result)
    assert "CHIP CHECK T1 W0.05" not in result.titles  # behind the finish
    assert f"may or may not have set {what}" in "".join(d.message for d in result.diagnostics)


@pytest.mark.parametrize(
    ("profile", "before", "inside", "behind"),
    [
        ("fanuc-mill", "WHILE [#1 LT 3] DO1", "G91\nG1 X1.\nG90\nG0", "END1"),
        ("fanuc-mill", "N50", "M8", "IF [#1 EQ 0] GOTO 50"),
        ("linuxcnc-mill", "o10 repeat [3]", "M8", "o10 endrepeat"),
        ("linuxcnc-mill", "o10 do", "M8", "o10 while [#1 LT 3]"),
        ("linuxcnc-mill", "o10 if [#1 EQ 0]", "G91\nG1 X1.\nG90\nG0", "o10 endif"),
    ],
)
def test_a_part_that_always_runs_or_leaves_all_as_it_was_is_in_nobodys_way(
    profile: str, before: str, inside: str, behind: str
) -> None:
    result = filtered(maybe(before, inside, behind).encode(), profile)
    check(result)
    assert "CHIP CHECK T1 W0.05" in result.titles


@pytest.mark.parametrize(
    ("profile", "opened", "closed"),
    [
        ("fanuc-mill", "WHILE [#1 LT 3] DO1", "END1"),
        ("fanuc-mill", "N50", "IF [#1 LT 3] GOTO 50"),
        ("linuxcnc-mill", "o10 while [#1 LT 3]", "o10 endwhile"),
    ],
)
@pytest.mark.parametrize(("inside", "is_known"), [("", True), ("S1000\n", True), ("S800\n", False)])
def test_a_loop_hides_the_speed_only_where_it_sets_another(
    profile: str, opened: str, closed: str, inside: str, is_known: bool
) -> None:
    """The first cut stands in the loop, and the spindle has to turn again behind the check that follows."""
    head = "G21 G90 G17\nT1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\n(ROUGH)\n"
    loop = f"{opened}\nG0 X3. Y4. Z2.\nG1 Z-1. F100.\nG0 Z15.\n{inside}#1=[#1+1]\n{closed}\n"
    again = "G0 X1. Y2. Z15.\n(FINISH)\nG0 X3. Y4.\nG1 Z-1. F100.\nG0 Z15.\nM30\n"
    result = filtered((head + loop + again).encode(), profile)
    check(result)
    checks = ["CALIBRATE", "TOOL CHECK T1, TRACE T1", "CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]
    assert (result.titles == checks) is is_known
    assert ("CHK003" in result.codes) is not is_known


@pytest.mark.parametrize("opened", ["o10 if [#1 EQ 0]", "o10 while [#1 EQ 0]", "o10 do", "o10 repeat [2]"])
def test_a_part_that_is_never_closed_is_no_trouble(opened: str) -> None:
    check(filtered(maybe(opened, "M8", "G91").encode(), "linuxcnc-mill"))


def test_calls_without_a_calibration_are_told_how_often_they_check() -> None:
    own = ('calls.own={tool_check="G65 P1 T{tool} A{every}"}', "checks.calls=own", "checks.every=4")
    program = b"T1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nX5.\nG0 Z15.\nM30\n"
    output = chipbreak.rewrite(program, chipbreak.load("fanuc-mill", ["checks.enabled=true", *own])).data
    assert b"G65 P1 T1 A4\n" in output


def test_a_program_may_end_where_the_next_one_begins() -> None:
    drills = "T1 M6\nG54 G90 G43 H1 S100 M3\nG98 G81 X-32. Y-18. Z-17. R5. F560.\nG0 Z15.\nG90\n"
    settings = chipbreak.load("fanuc-mill-renishaw")
    result = chipbreak.rewrite(f"O1\n{drills}O2\nM30\n".encode(), settings)
    assert [edit.title.split()[:3] for edit in result.edits] == [["CHIP", "CHECK", "T1"]]
