"""Comments of a program, the order of sources, and what a check lacks."""

from __future__ import annotations

import pytest

from chipbreak import settings
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read
from chipbreak.tools.comments import tools_in_comments
from chipbreak.tools.data import ToolData
from chipbreak.tools.merge import ToolTable, merge
from chipbreak.tools.needs import Check, Tip, lacking, missing, tip_of
from chipbreak.tools.program import called_tools


def trace_of(text: str, profile: str = "fanuc-mill") -> InterpretedProgram:
    rules = settings.load(profile)
    return interpret(parse(read(text.encode()), rules.dialect), rules)


def said(text: str, profile: str = "fanuc-mill") -> ToolTable:
    """What the comments of a program say, merged."""
    comments = tools_in_comments(trace_of(text, profile))
    return merge([], comments, {tool.number for tool in comments})


def test_tool_list_of_fusion_in_mm() -> None:
    tool = said("(T2 D=12. CR=0.5 - ZMIN=-12. - BULLNOSE END MILL)\nG21\n").get(2)
    assert (tool.diameter_mm, tool.corner_radius_mm) == (12.0, 0.5)
    assert tool.origins["diameter_mm"] == "comment in line 1"
    assert tool.teeth is None
    assert tool.length_mm is None


def test_a_list_above_g20_is_in_inches() -> None:
    tool = said("(T2 D=0.5 CR=0. - FLAT END MILL)\nG20\n").get(2)
    assert tool.diameter_mm == pytest.approx(12.7)


def test_a_list_between_units_is_in_those_before_it() -> None:
    tools = said("G20\n(T1 D=0.5 CR=0. - DRILL)\nG21\n(T2 D=12. CR=0. - DRILL)\n")
    assert tools.get(1).diameter_mm == pytest.approx(12.7)
    assert tools.get(2).diameter_mm == 12.0


def test_without_g20_and_g21_the_control_decides() -> None:
    assert said("(T2 D=12. CR=0. - DRILL)\n").get(2).diameter_mm == 12.0


def test_a_size_with_its_own_unit_keeps_it() -> None:
    tools = said("G21\n(TOOL 17 - 3/8 EM - 2 FLUTE)\nG20\n(TOOL 3 - 6MM DRILL)\n")
    assert tools.get(17).diameter_mm == pytest.approx(9.525)
    assert tools.get(17).teeth == 2
    assert tools.get(3).diameter_mm == 6.0


def test_facts_behind_a_tool_number() -> None:
    text = (
        "G21\n(Tool Number : 5)\n(DIA: 10)\n(TIP RADIUS: 1)\n(Number of Flutes: 4)\n"
        "(STICKOUT/OVERHANG: 42.5)\n(HOLDER LENGTH: 70)\nG0 X0\n(DIA: 99)\n"
    )
    known = said(text).get(5).known()
    assert known.pop("name")
    assert known == {
        "diameter_mm": 10.0,
        "corner_radius_mm": 1.0,
        "teeth": 4,
        "length_mm": 42.5,
        "holder_mm": 70.0,
    }


@pytest.mark.parametrize(("kind", "point"), [("DRILL", 118.0), ("TAPERED MILL", None)])
def test_taper_is_the_point_of_a_drill_only(kind: str, point: float | None) -> None:
    assert said(f"G21\n(T3 D=6.8 CR=0. TAPER=118DEG - {kind})\n").get(3).point_deg == point


def test_a_note_without_number_is_about_the_tool_called_there() -> None:
    tools = said("G21\nT4 M6 (Change tool: Carbide 2-Flute Endmill, 1mm)\nT5 M6\n(6MM BALL END MILL)\n")
    assert (tools.get(4).teeth, tools.get(4).diameter_mm) == (2, 1.0)
    assert tools.get(5).corner_radius_mm == 3.0


def test_a_note_behind_motion_is_about_nothing() -> None:
    tools = said("G21\nT5 M6\nG0 X1\n(6MM BALL END MILL)\n(STICKOUT: 40)\n")
    assert tools.tools == {}


def test_a_note_in_a_tool_list_without_number_is_about_nothing() -> None:
    tools = said("G21\n(T1 D=50. CR=0. - FACE MILL)\n(6MM DRILL)\nT9 M6\n")
    assert tools.get(1).diameter_mm == 50.0
    assert list(tools.tools) == [1]


CUT = "S1000 M3\nG0 X0. Y0.\nG1 Z-1. F100.\nG0 Z30.\n"


@pytest.mark.parametrize(
    ("remark", "known"),
    [
        (
            '( Tool #7 "Drill 0.8mm" / Diameter 0.8 mm )',
            {"type": "drill", "diameter_mm": 0.8, "name": "Drill 0.8mm"},
        ),
        (
            '( Tool #7 "Engraver 0.2mm" / Diameter 0,2 mm )',
            {"type": "chamfer mill", "diameter_mm": 0.2, "name": "Engraver 0.2mm"},
        ),
        (
            '( Werkzeug Nr. 7 "Universalfraeser 1mm" / Durchmesser 1 mm )',
            {"type": "end mill", "diameter_mm": 1.0, "name": "Universalfraeser 1mm"},
        ),
        (
            "(TOOL/MILL,16.0,0.0,30.0,0.0)",
            {"type": "flat end mill", "diameter_mm": 16.0, "corner_radius_mm": 0.0},
        ),
        (
            "( TOOL/MILL, 6.0, 3.0, 30.0, 0 )",
            {"type": "ball end mill", "diameter_mm": 6.0, "corner_radius_mm": 3.0},
        ),
        (
            "(TOOL/MILL,6.0,1.0,30.0,0)",
            {"type": "bull nose end mill", "diameter_mm": 6.0, "corner_radius_mm": 1.0},
        ),
        (
            "(TOOL/MILL,1.0,0.0,30.0,5.0)",
            {"type": "tapered mill", "diameter_mm": 1.0, "corner_radius_mm": 0.0},
        ),
        ("(TOOL/DRILL,5.0,118.0,40.0)", {"type": "drill", "diameter_mm": 5.0, "point_deg": 118.0}),
        ("(TC: 6mm Endmill)", {"type": "end mill", "diameter_mm": 6.0, "name": "6mm Endmill"}),
        (
            "(Begin operation: TC: 5mm Drill)",
            {"type": "drill", "diameter_mm": 5.0, "name": "5mm Drill"},
        ),
        ("(tool change to 6mm end mill)", {"type": "end mill", "diameter_mm": 6.0, "name": "6mm end mill"}),
        ('(1/4" E.M.)', {"type": "end mill", "diameter_mm": 6.35, "name": '1/4" E.M.'}),
    ],
)
def test_posts_say_a_tool_before_its_call(remark: str, known: dict[str, object]) -> None:
    """After another tool has cut, and with the way to the tool change between the remark and the call."""
    for between in ("", "M5\n", "G28 G91 Z0.\nG90\n"):
        table = said(f"G21\nT1 M6\n{CUT}{remark}\n{between}T7 M6\n{CUT}M30\n")
        assert table.get(7).known() == known, between
        assert table.get(1).known() == {}
    beside_no_call = said(f"G21\nT7 M6\n{CUT}{remark}\nG0 X5.\nT9 M6\n{CUT}M30\n")
    assert beside_no_call.get(9).known() == {}


def test_a_remark_of_a_post_after_its_call_is_about_the_tool_that_cuts() -> None:
    assert said(f"G21\nT3 M6\n(TOOL/MILL,16.0,0.0,30.0,0.0)\n{CUT}T4 M6\n{CUT}").get(3).diameter_mm == 16.0


def test_a_tool_that_is_put_away_is_not_the_next_one() -> None:
    assert said(f"T1 M6\n{CUT}(REMOVE 1/4 END MILL)\nT2 M6\n{CUT}").get(2).known() == {}


def test_what_a_comment_says_of_m6_and_t0_is_no_tool_change_and_no_tool() -> None:
    program = (
        f"G21\n(T0 : 3.175)\nT1 M6\n(TC: 6mm Endmill, M6 T4 FIRST)\n(M6 T5)\n{CUT}(T6 M6)\nX5.\nT0 M6\nM30\n"
    )
    assert called_tools(trace_of(program)) == [1]
    assert set(said(program).tools) == {1}


def test_stick_out_in_inches() -> None:
    assert said('(T3 - 1/2" ENDMILL, STICK-OUT 1.5")\nG21\n').get(3).length_mm == pytest.approx(38.1)


def test_offset_digits_of_a_turret() -> None:
    tools = said(
        "G21\n(T0303 - 80 DEG TURNING TOOL)\n(T212 - BORING BAR)\nT0101 (TURN TOOL .8 TNR)\n", "fanuc-lathe"
    )
    assert {number: tool.type for number, tool in tools.tools.items()} == {
        1: "turning tool",
        2: "boring bar",
        3: "turning tool",
    }
    assert tools.get(1).corner_radius_mm == 0.8


def test_impossible_values_in_comments_are_none() -> None:
    assert said("G21\n(T2 D=0. CR=0. - DRILL)\n(T3 D=99999. CR=0. - DRILL)\n").get(3).diameter_mm is None


def test_the_tools_that_are_called() -> None:
    interpreted = trace_of("(T9 D=1. - DRILL)\nT2 M6\nT3\nG0 X1\nM6\nT2 M6\n")
    assert called_tools(interpreted) == [2, 3]


def tool(number: int = 2, origin: str = "a.csv, line 2", **values: object) -> ToolData:
    return ToolData.said(number, origin, values)


def test_files_win_over_comments_and_earlier_files_over_later() -> None:
    files = [
        [tool(origin="a", teeth=4)],
        [tool(origin="b", teeth=4, diameter_mm=12.0)],
    ]
    merged = merge(files, [tool(origin="c", diameter_mm=12.0, type="drill")], [2])
    assert merged.get(2).known() == {"type": "drill", "teeth": 4, "diameter_mm": 12.0}
    assert merged.get(2).origins == {"teeth": "a", "diameter_mm": "b", "type": "c"}
    assert merged.diagnostics == ()


def test_sources_at_odds_are_said() -> None:
    merged = merge([[tool(origin="a", diameter_mm=12.0)]], [tool(origin="c", diameter_mm=10.0)], [2])
    (found,) = merged.diagnostics
    assert (found.code, found.severity.value) == ("TOL009", "warning")
    assert found.message == "T2: diameter 12 (a) or 10 (c)? The first is used"
    assert merged.get(2).diameter_mm == 12.0


@pytest.mark.parametrize("other", [12.02, 11.98])
def test_sources_that_only_round_are_not_at_odds(other: float) -> None:
    assert merge([[tool(diameter_mm=12.0)]], [tool(diameter_mm=other)], [2]).diagnostics == ()


def test_one_edge_more_is_another_tool() -> None:
    assert merge([[tool(teeth=4)]], [tool(teeth=3)], [2]).diagnostics


def test_twice_in_one_file_cancels_what_differs() -> None:
    entries = [
        tool(origin="a, line 2", teeth=4, diameter_mm=12.0),
        tool(origin="a, line 3", teeth=4, diameter_mm=10.0),
        tool(3, origin="a, line 4", teeth=1),
    ]
    merged = merge([entries], [tool(origin="c", diameter_mm=12.0)], [2])
    (found,) = merged.diagnostics
    assert found.code == "TOL008"
    assert "12.0 (a, line 2) and 10.0 (a, line 3)" in found.message
    assert merged.get(2).origins == {"teeth": "a, line 2", "diameter_mm": "c"}


def test_only_wanted_tools_are_merged_and_unknown_ones_are_empty() -> None:
    merged = merge([[tool(2, teeth=4), tool(3, teeth=4)]], [], [2, 7])
    assert list(merged.tools) == [2, 7]
    assert merged.get(7).known() == {}
    assert merged.get(99).known() == {}


def test_the_radius_of_a_ball_is_half_its_diameter() -> None:
    ball = merge([[tool(origin="a", type="ball end mill", diameter_mm=6.0)]], [], [2]).get(2)
    assert ball.corner_radius_mm == 3.0
    assert ball.origins["corner_radius_mm"] == "half the diameter (a)"


@pytest.mark.parametrize(
    ("values", "check", "fields"),
    [
        ({"type": "flat end mill"}, Check.RUNOUT, ["diameter_mm"]),
        ({"type": "flat end mill", "diameter_mm": 12.0}, Check.RUNOUT, []),
        ({"type": "flat end mill"}, Check.LENGTH, ["length_mm", "holder_mm", "diameter_mm"]),
        ({"type": "drill"}, Check.LENGTH, ["length_mm", "holder_mm"]),
        ({"type": "ball end mill", "length_mm": 30.0, "holder_mm": 0.0}, Check.LENGTH, []),
        ({"type": "drill", "diameter_mm": 6.8}, Check.RUNOUT, ["point_deg"]),
        ({"type": "bull nose end mill", "diameter_mm": 12.0}, Check.DIAMETER, ["corner_radius_mm"]),
        ({"type": "drill", "diameter_mm": 6.8}, Check.CHIPPING, ["teeth", "helix_deg"]),
        ({"teeth": 4}, Check.CHIPPING, ["type", "diameter_mm"]),
        ({"type": "radius mill", "diameter_mm": 8.0}, Check.LENGTH, ["type"]),
        ({"type": "turning tool"}, Check.CHIPPING, []),
        ({"type": "end mill", "diameter_mm": 8.0}, Check.RUNOUT, ["type"]),
        ({"type": "end mill", "diameter_mm": 8.0, "corner_radius_mm": 0.0}, Check.RUNOUT, []),
    ],
)
def test_what_a_check_lacks(values: dict[str, object], check: Check, fields: list[str]) -> None:
    assert lacking(tool(**values), check) == fields
    found = missing(tool(**values), check)
    assert [d.code for d in found] == ["TOL010"] * len(fields)
    for field, diagnostic in zip(fields, found, strict=True):
        assert "T2" in diagnostic.message
        assert check.value in diagnostic.message
        assert field in diagnostic.help
        assert "--tools" in diagnostic.help


@pytest.mark.parametrize(("radius", "tip"), [(0.0, Tip.FLAT), (1.0, Tip.CORNER), (4.0, Tip.BALL)])
def test_the_corner_radius_tells_one_end_mill_from_another(radius: float, tip: Tip) -> None:
    assert tip_of(tool(type="end mill", diameter_mm=8.0, corner_radius_mm=radius)) is tip


def test_a_type_that_does_not_help_is_named() -> None:
    (found,) = missing(tool(type="radius mill", diameter_mm=8.0), Check.RUNOUT)
    assert '"radius mill" (a.csv, line 2)' in found.message
