"""Operations: where they start and end, and why each is what it is."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from chipbreak import settings
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.operations.kinds import Kind, KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import Operation, operations_of
from chipbreak.syntax.parse import parse
from chipbreak.text.diagnostics import ProgramRejectedError
from chipbreak.text.source import read
from chipbreak.tools.program import called_tools

SAMPLE = Path(__file__).parents[2] / "samples" / "fusion-mill.nc"


def traced(program: str | bytes, profile: str = "fanuc-mill") -> InterpretedProgram:
    data = program if isinstance(program, bytes) else program.encode("latin-1")
    rules = settings.load(profile)
    return interpret(parse(read(data), rules.dialect), rules)


def operations(program: str | bytes, profile: str = "fanuc-mill", **rules: list[str]) -> list[Operation]:
    interpreted = traced(program, profile)
    return operations_of(interpreted, main_program(interpreted), KindRules.from_profile(rules))


def short(found: list[Operation]) -> list[tuple[int | None, str, str]]:
    return [(op.tool, op.kind.value, op.label) for op in found]


def one(program: str, profile: str = "fanuc-mill", **rules: list[str]) -> Operation:
    (found,) = operations(program, profile, **rules)
    return found


CUT = "G0 Z5.\nG1 Z-1. F100.\nG0 Z5.\n"


def test_the_fusion_sample() -> None:
    found = operations(SAMPLE.read_bytes())
    assert short(found) == [
        (1, "unknown", "FACE1"),
        (2, "rough", "2D ADAPTIVE2"),
        (2, "finish", "2D CONTOUR3 FINISH"),
        (3, "drill", "DRILL4"),
    ]
    assert [op.speed_rpm for op in found] == [2200.0, 5300.0, 5300.0, 3740.0]
    assert {op.spindle for op in found} == {"cw"}
    assert all(op.last_line == after.first_line for op, after in pairwise(found))
    text = SAMPLE.read_text("ascii").split("\n")
    assert text[found[1].first_line].strip() == "(2D ADAPTIVE2)"
    assert found[1].call_line is not None and text[found[1].call_line].endswith("T2 M6")
    assert found[2].call_line is None
    assert found[0].first_cut is not None and text[found[0].first_cut].endswith("G1 Z0. F900.")
    assert found[1].reason == '"ADAPTIVE" in the comment "2D ADAPTIVE2", line 33'


def test_a_title_may_stand_before_or_behind_its_tool_call() -> None:
    before = f"(ROUGH A)\nT1 M6\n{CUT}(FINISH B)\nM9\nT2 M6\n{CUT}"
    behind = f"T1 M6\n(ROUGH A)\n{CUT}T2 M6\n(FINISH B)\n{CUT}"
    for program in (before, behind):
        assert short(operations(program)) == [(1, "rough", "ROUGH A"), (2, "finish", "FINISH B")]


def test_a_block_number_of_its_own_heads_an_operation() -> None:
    """FIN alone may be the end in French or Spanish; behind a block number it is the work that follows."""
    found = operations(f"N1 (RGH)\nT1 M6\n{CUT}N2(FIN)\n{CUT}N3 (FIN)\nM30\n")
    assert short([op for op in found if op.cuts]) == [(1, "rough", "RGH"), (1, "finish", "FIN")]
    assert short(operations(f"T1 M6 (RGH)\n{CUT}N2 (ROUGHING END MILL)\n{CUT}(FIN)\nM30\n")) == [
        (1, "rough", "RGH")
    ]


def test_one_tool_may_do_two_operations() -> None:
    found = operations(f"T1 M6\n(ROUGH .168 DEEP STEP)\n{CUT}(FINISH .168 DEEP STEP FLOOR)\n{CUT}")
    assert [(op.tool, op.kind.value) for op in found] == [(1, "rough"), (1, "finish")]


def test_a_comment_beside_a_tool_call_names_the_operation() -> None:
    found = operations("T0101 (ROUGH TURN)\nG1 Z-1. F0.1\nT0303 (FINISH TURN)\nG1 Z-1.\n", "fanuc-lathe")
    assert short(found) == [(1, "rough", "ROUGH TURN"), (3, "finish", "FINISH TURN")]


def test_a_tool_in_the_magazine_is_no_tool_in_the_spindle() -> None:
    found = operations(f"T1\nM6\nT2 M1\n{CUT}M6\nT1\n{CUT}")
    assert [op.tool for op in found] == [1, 2]
    assert one(f"T3\nS500 M3\n{CUT}").tool is None


def test_an_offset_that_ends_is_no_tool_call() -> None:
    found = operations("T0101\nG1 Z-1. F0.1\nG0 Z5. T0100\nG28 U0 W0\nM30\n", "fanuc-lathe")
    assert [(op.tool, op.call_line) for op in found] == [(1, 0)]


HAAS = """O00078
N1 (O.D. ROUGHING)
G53 G0 X0. Z0. {end}
T101 (O.D. TOOL 0.031 TNR)
G97 S500 M3
G54 G0 X3.1 Z0.1
G1 Z-2.5 F0.012
G53 G0 X0. Z0. {end}
M1
N2 (O.D. FINISHING)
G53 G0 X0. Z0. {end}
T202
G97 S800 M3
G54 G0 X3. Z0.1
G1 Z-2.5 F0.004
G53 G0 X0. Z0. {end}
M30
"""


@pytest.mark.parametrize("end", ["T0", "T00", "T0000", ""])
def test_t0_on_a_way_home_is_no_tool_and_the_title_before_it_names_what_follows(end: str) -> None:
    interpreted = traced(HAAS.format(end=end), "fanuc-lathe")
    found = operations_of(interpreted, main_program(interpreted), KindRules())
    assert short(found) == [(1, "rough", "O.D. ROUGHING"), (2, "finish", "O.D. FINISHING")]
    assert [(op.first_line, op.call_line) for op in found] == [(1, 3), (9, 11)]
    assert called_tools(interpreted) == [1, 2]
    assert [effect.after.tool for effect in interpreted.effects][-1] == 2


def test_an_empty_spindle_is_no_tool_and_what_is_cut_after_it_is_cut_by_nobody() -> None:
    interpreted = traced(f"T1 M6\n(ROUGH A)\n{CUT}(FINISH B)\nT0 M6\nT2 M6\n{CUT}T0 M6\n{CUT}M30\n")
    found = operations_of(interpreted, main_program(interpreted), KindRules())
    assert short(found) == [
        (1, "rough", "ROUGH A"),
        (2, "finish", "FINISH B"),
        (None, "unknown", "spindle left empty"),
    ]
    assert called_tools(interpreted) == [1, 2]


@pytest.mark.parametrize("head", ["O7 (FINISH SIDE 2)", "(FINISH SIDE 2) O7", "O7 (SIDE 2) (ROUGH)"])
def test_the_name_of_the_program_is_no_operation_of_its_first_tool(head: str) -> None:
    found = one(f"%\n{head}\nT1 M6\n{CUT}M30\n%\n")
    assert (found.kind, found.label) == (Kind.UNKNOWN, "T1")
    below = one(f"%\nO7\n(FINISH SIDE 2)\nT1 M6\n{CUT}M30\n%\n")
    assert (below.kind, below.label) == (Kind.FINISH, "FINISH SIDE 2")
    assert one(f"O7 (OP FINISH)\nT1 M6\n{CUT}").kind is Kind.FINISH


def test_freecad_ends_an_operation_with_finish() -> None:
    program = (
        f"(Begin operation: Adaptive)\nT1 M6\n{CUT}(Finish operation: Adaptive)\n"
        f"(Begin operation: Profile)\n{CUT}(Finish operation: Profile)\nM2\n"
    )
    assert short(operations(program, "linuxcnc-mill")) == [
        (1, "rough", "Adaptive"),
        (1, "unknown", "Profile"),
    ]


def test_a_directive_wins_over_the_title() -> None:
    found = one(f"T1 M6\n(FINISH CONTOUR)\n(OP ROUGH)\n{CUT}")
    assert (found.kind, found.reason) == (Kind.ROUGH, 'directive "OP ROUGH", line 3')


def test_a_directive_starts_an_operation_of_its_own() -> None:
    found = operations(f"T1 M6\n{CUT}(OP FINISH)\n{CUT}")
    assert [(op.kind.value, op.first_line) for op in found] == [("unknown", 0), ("finish", 4)]


def test_a_misspelt_directive_is_an_error_with_its_place() -> None:
    with pytest.raises(ProgramRejectedError) as caught:
        operations(f"T1 M6\n(OP ROUHG)\n{CUT}")
    (found,) = caught.value.diagnostics
    assert found.code == "OPS001"
    assert found.place is not None and (found.place.line, found.place.column) == (2, 1)


def test_the_tool_list_speaks_where_no_title_does() -> None:
    found = operations(
        f"(T7|1/2 EM|H7|XY STOCK TO LEAVE - .005)\n(T8 D=5. - DRILL)\nT7 M6\n{CUT}T8 M6\n{CUT}"
    )
    assert [op.kind.value for op in found] == ["rough", "drill"]
    assert found[0].reason.endswith(", line 1")


def test_comments_straight_above_a_start_belong_to_it() -> None:
    found = operations(f"T1 M6\n{CUT}M9\n(1/4 REAMER)\n(REV. )\nT2 M6\n{CUT}")
    assert [op.kind.value for op in found] == ["unknown", "drill"]
    assert found[1].first_line == 5


def test_the_head_of_the_program_names_no_operation() -> None:
    assert one(f"(ROUGH FIXTURE PLATE)\nG90 G21\nG28 G91 Z0.\nG90\nT1 M6\n{CUT}").kind is Kind.UNKNOWN


def test_a_title_without_work_does_not_colour_the_next() -> None:
    found = one(f"T1 M6\n(ROUGH 1)\nG0 X5.\nG0 Y5.\n(CONTOUR 2)\n{CUT}")
    assert (found.kind, found.label) == (Kind.UNKNOWN, "CONTOUR 2")


@pytest.mark.parametrize(
    ("block", "profile", "kind"),
    [
        ("G81 X1. Y1. Z-5. R2. F100.", "fanuc-mill", Kind.DRILL),
        ("G84 X1. Y1. Z-5. R2. F100.", "fanuc-mill", Kind.THREAD),
        ("G76 X1. Y1. Z-5. R2. Q0.1 F100.", "fanuc-mill", Kind.FINISH),
        ("G31 Z-5. F100.", "fanuc-mill", Kind.PROBE),
        ("G38.2 Z-5 F100", "linuxcnc-mill", Kind.PROBE),
        ("G71 P10 Q20 U0.5 W0.1 F0.2", "fanuc-lathe", Kind.ROUGH),
        ("G70 P10 Q20", "fanuc-lathe", Kind.FINISH),
        ("G76 X18. Z-20. P920 Q300 F1.5", "fanuc-lathe", Kind.THREAD),
        ("G92 X18. Z-20. F1.5", "fanuc-lathe", Kind.THREAD),
        ("G33 Z-20. F1.5", "fanuc-lathe", Kind.THREAD),
        ("G1 Z-5. F100.", "fanuc-mill", Kind.UNKNOWN),
    ],
)
def test_cycles_name_a_kind(block: str, profile: str, kind: Kind) -> None:
    call = "T0101" if profile.endswith("lathe") else "T1 M6"
    found = one(f"{call}\nG0 Z5.\n{block}\n", profile)
    assert found.kind is kind
    if kind is not Kind.UNKNOWN:
        assert found.reason == f"cycle {block}, line 3"


def test_a_tap_that_is_titled_as_a_drill_is_a_tap() -> None:
    """CAM systems number what they do with holes, and a tap is one of them."""
    tap = one("T1 M6\n(DRILL12)\nG0 Z5.\nG84 X1. Y1. Z-5. R2. F100.\nG80\n")
    assert (tap.kind, tap.label) == (Kind.THREAD, "DRILL12")
    assert tap.reason.startswith("cycle G84")
    both = one("T1 M6\n(DRILL12)\nG0 Z5.\nG81 X1. Y1. Z-5. R2. F100.\nG84 Z-4.\nG80\n")
    assert both.kind is Kind.DRILL
    ruled = one("T1 M6\n(DRILL12)\nG0 Z5.\nG84 X1. Y1. Z-5. R2. F100.\nG80\n", drill=["DRILL"])
    assert ruled.kind is Kind.DRILL


@pytest.mark.parametrize(("units", "left", "kind"), [("G21", ".02", "finish"), ("G20", ".02", "rough")])
def test_stock_to_leave_is_in_the_units_of_the_program(units: str, left: str, kind: str) -> None:
    assert one(f"(T1|FLAT ENDMILL|H1|XY STOCK TO LEAVE - {left})\n{units}\nT1 M6\n{CUT}").kind.value == kind


def test_a_finishing_cycle_counts_before_the_roughing_one() -> None:
    program = "T0101\nG71 P10 Q20 U0.5 W0.1 F0.2\nN10 G0 X20.\nN20 G1 Z-5.\nG70 P10 Q20\n"
    assert one(program, "fanuc-lathe").kind is Kind.FINISH


def test_probing_is_work_but_no_cut() -> None:
    found = operations(f"T9 M6\n(PROBE)\nG31 Z-5. F100.\nG0 Z50.\n(ADAPTIVE 1)\nT1 M6\n{CUT}")
    assert [(op.kind.value, op.cuts) for op in found] == [("probe", False), ("rough", True)]


def test_rules_of_the_profile_come_first() -> None:
    found = one(f"T1 M6\n(FINISH POCKET)\n{CUT}", rough=["POCKET"])
    assert found.kind is Kind.ROUGH
    assert "profile" in found.reason


def test_unknown_says_where_was_looked() -> None:
    found = one(f"(T1 D=6. - END MILL)\nT1 M6\n(2D CONTOUR (2))\n{CUT}")
    assert found.kind is Kind.UNKNOWN
    assert "2D CONTOUR (2)" in found.reason and "END MILL" in found.reason and "line 3" in found.reason


def test_subprograms_and_what_stands_behind_the_end_are_left_out() -> None:
    program = (
        "o<pocket> sub\nT5 M6\n(ROUGH)\nG1 X1 F100\no<pocket> endsub\n"
        "T1 M6\nS100 M3\no<pocket> call\nM2\n(FINISH)\nT2 M6\nG1 X5\n"
    )
    found = operations(program, "linuxcnc-mill")
    assert [(op.tool, op.first_cut, op.last_line) for op in found] == [(1, 7, 8)]
    assert main_program(traced(program, "linuxcnc-mill")).after_end is not None


def test_a_tool_that_does_nothing_leaves_its_place_to_the_next() -> None:
    found = operations(f"T1 M6 (ROUGH EM)\nT2 M6\n{CUT}")
    assert [(op.tool, op.kind.value) for op in found] == [(2, "unknown")]


def test_nothing_is_an_operation_in_an_empty_program() -> None:
    for program in ("", "%\n%\n", "(ROUGH)", "\n\n"):
        assert all(not op.cuts for op in operations(program))


def test_cuts_found_by_shapes_are_the_cuts_found_block_by_block(corpus: list[Path]) -> None:
    """Fast and slow way to the same lines."""
    compared = 0
    for file in corpus:
        if file.stat().st_size > 60_000:
            continue
        for profile in ("fanuc-mill", "linuxcnc-mill"):
            interpreted = traced(file.read_bytes(), profile)
            main = main_program(interpreted)
            plain = interpreted.program.plain
            slow = [
                effect.block.line
                for effect in interpreted.effects_of(main.first, main.last)
                if main.has(effect.block.line)
                and plain[effect.block.line] >= 0
                and not effect.in_contour
                and (effect.move or set("XYZABCIJK") & {w.address for w in effect.block.words})
                and effect.after.modes.motion not in ("rapid", "none", "probe")
            ]
            assert slow == main.cuts[plain[main.cuts] >= 0].tolist(), file.name
            assert np.isin(main.cuts, main.works).all()
            compared += len(slow)
    assert compared > 10_000


def test_another_program_number_ends_the_main_program() -> None:
    found = operations(f"O1 (PART)\nT1 M6\n{CUT}O2\nT2 M6\n{CUT}M99\n")
    assert [op.tool for op in found] == [1]
    assert [op.tool for op in operations(f"!DEBUG: post\nO1\nT1 M6\n{CUT}M30\n")] == [1]
