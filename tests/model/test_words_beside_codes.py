"""F, S, T and M act whatever stands in their block, unless a code there takes them for itself."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.dialects import Code
from chipbreak.dialects.base import NON_MODAL, check_dialect
from chipbreak.model.giving_back import speed_text
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import State
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

MANY = 5000


def interpreted(profile: str, *lines: str) -> InterpretedProgram:
    settings = chipbreak.load(profile)
    return interpret(parse(read("\n".join([*lines, ""]).encode(), "words.nc"), settings.dialect), settings)


def after(profile: str, *lines: str) -> State:
    return interpreted(profile, *lines).end()


def values(state: State) -> tuple[float | None, float | None]:
    return (state.feed and state.feed.value, state.speed and state.speed.value)


def codes_said(profile: str, *lines: str) -> list[str]:
    settings = chipbreak.load(profile)
    found = chipbreak.rewrite("\n".join([*lines, ""]).encode(), settings).diagnostics
    return [one.code for one in found if one.code.startswith("MOD")]


@pytest.mark.parametrize(
    ("profile", "block"),
    [
        ("fanuc-lathe", "G4 X1. S1250 F0.2"),
        ("fanuc-lathe", "G4 U1. F0.2 S1250"),
        ("fanuc-lathe", "S1250 G28 U0 W0 F0.2"),
        ("fanuc-lathe", "G30 U0 S1250 F0.2"),
        ("fanuc-lathe", "G10 P1 X0.1 S1250 F0.2"),
        ("fanuc-lathe", "G52 X1. S1250 F0.2"),
        ("fanuc-lathe", "G71 P10 Q20 U0.4 W0.1 F0.2 S1250"),
        ("fanuc-lathe", "G76 X20. Z-20. P600 Q200 F0.2 S1250"),
        ("fanuc-mill", "G4 P100 S1250 F0.2 G95"),
        ("fanuc-mill", "G95 G92.1 X0 S1250 F0.2"),
        ("generic-lathe", "G4 X1. S1250 F0.2"),
        ("generic-lathe", "G74 Z-5. S1250 F0.2"),
        ("linuxcnc-lathe", "G95 G4 P1 S1250 F0.2"),
        ("linuxcnc-lathe", "G95 G92 X1 S1250 F0.2"),
        ("linuxcnc-lathe", "G95 G10 L2 P1 X0 S1250 F0.2"),
    ],
)
def test_feed_and_speed_are_read_beside_a_code_of_one_block(profile: str, block: str) -> None:
    assert values(after(profile, "S600 F0.05", block)) == (0.2, 1250.0)


@pytest.mark.parametrize("block", ["G65 P100 S1250 F0.2 T5 M8", "G66 P100 S1250 F0.2 T5 M8"])
def test_the_words_of_a_macro_call_are_arguments(block: str) -> None:
    state = after("fanuc-lathe", "S600 F0.05 T101", block)
    assert values(state) == (0.05, 600.0)
    assert (state.tool, state.coolant) == (1, frozenset())


@pytest.mark.parametrize(
    ("profile", "block"),
    [("fanuc-lathe", "G50 S2000"), ("generic-lathe", "G92 S2000"), ("fanuc-mill", "G92 S2000")],
)
def test_the_speed_beside_a_new_origin_is_a_limit(profile: str, block: str) -> None:
    state = after(profile, "S600", block)
    assert values(state) == (None, 600.0)
    assert state.speed_limit is not None
    assert state.speed_limit.value == 2000.0


def test_a_lone_f_of_a_dwell_is_its_time_in_iso_6983() -> None:
    assert values(after("generic-lathe", "F0.05", "G4 F2."))[0] == 0.05
    assert values(after("generic-lathe", "F0.05", "G4 X1. F0.2"))[0] == 0.2
    assert values(after("fanuc-lathe", "F0.05", "G4 F0.2"))[0] == 0.2


def test_linuxcnc_reads_feed_and_surface_speed_before_the_units_of_their_block() -> None:
    state = after("linuxcnc-lathe", "G20 G94", "G21 F100")
    assert values(state)[0] == 2540.0
    state = after("linuxcnc-lathe", "G20", "G21 G96 S100")
    assert values(state)[1] == pytest.approx(30.48)
    assert values(after("fanuc-mill", "G20", "G21 F100."))[0] == 100.0


def test_linuxcnc_works_a_surface_speed_out_again_where_the_spindle_starts() -> None:
    state = after("linuxcnc-lathe", "G20", "G21 G96 S100 M3")
    assert values(state)[1] == pytest.approx(30.48)
    assert speed_text(state) == "30.48"
    assert values(after("linuxcnc-lathe", "G20", "G21 G96 S100", "M3"))[1] == pytest.approx(100.0)


def test_a_surface_speed_of_other_units_is_not_known_where_nothing_converts_it() -> None:
    assert values(after("fanuc-lathe", "G96 S150", "G20"))[1] is None
    assert values(after("fanuc-lathe", "G97 S150", "G20"))[1] == 150.0
    assert values(after("linuxcnc-lathe", "G96 S150", "G20"))[1] == 150.0


def test_a_feed_of_other_units_is_said() -> None:
    begin = ("G20 G18 G94", "G97 S900 M3", "G0 X1 Z1")
    assert codes_said("linuxcnc-lathe", *begin, "G21 F100", "G1 Z2") == ["MOD002"]
    assert codes_said("linuxcnc-lathe", *begin, "F4", "G21", "G0 Z5", "G1 Z2", "G1 Z3") == ["MOD002"]
    assert codes_said("linuxcnc-lathe", *begin, "F4", "G21", "G0 Z5", "F100", "G1 Z2") == []
    assert codes_said("linuxcnc-lathe", *begin, "F4", "G21", "G0 Z5", "G20", "G1 Z2") == []


CYCLE = ("G0 X52. Z2.", "G71 U2. R1.", "G71 P10 Q20 U0.4 W0.1 F0.3", "N10 G0 X20.", "G1 Z-30.", "N20 X52.")


def test_a_cycle_of_a_fanuc_lathe_ends_where_it_began() -> None:
    assert after("fanuc-lathe", *CYCLE).position[::2] == (26.0, 2.0)
    assert after("fanuc-lathe", *CYCLE, "G70 P10 Q20").position[::2] == (26.0, 2.0)
    assert after("fanuc-lathe", "G0 X30. Z2.", "G74 R1.", "G74 Z-20. Q5000 F0.1").position[::2] == (15.0, 2.0)
    assert math.isnan(after("generic-lathe", *CYCLE).position.z)


def test_a_shape_without_its_numbers_is_said() -> None:
    assert codes_said("fanuc-lathe", *CYCLE) == []
    assert codes_said("fanuc-lathe", *CYCLE[:3], *CYCLE[4:]) == ["MOD003"]
    assert codes_said("fanuc-lathe", *CYCLE[:5]) == ["MOD003"]
    assert codes_said("linuxcnc-lathe", "G71 P10 Q20 D1") == []


def test_a_cycle_in_a_shape_asks_for_nothing() -> None:
    program = interpreted("fanuc-lathe", *CYCLE[:4], CYCLE[2], "N20 G1 Z-10.", "N30 X52.")
    assert not any(effect.vibration for effect in program.effects)


def test_shapes_that_share_lines_are_one() -> None:
    lines = ["G71 P1 Q4 F.1", "G71 P2 Q3 F.1", "N1 G0 X1.", "N2 X2.", "N3 X3.", "X4.", "N4 X5.", "X6."]
    flow = interpreted("fanuc-lathe", *lines).flow
    assert [line for line in range(len(lines)) if flow.in_contour(line)] == [2, 3, 4, 5, 6]


def test_g80_leaves_the_motion_code_of_a_fanuc_in_force() -> None:
    assert after("fanuc-mill", "G0 G80").modes.motion == "rapid"
    assert after("fanuc-mill", "G1 X1. F100.", "G80").modes.motion == "line"
    cycle = ("G1 X1. F100.", "G81 Z-1. R1.", "X2.", "G80")
    assert after("fanuc-mill", *cycle).modes.motion == "line"
    assert after("fanuc-mill", *cycle, "G0", "G83 Z-1. R1. Q1.", "G80").modes.motion == "rapid"
    assert after("linuxcnc-mill", *cycle).modes.motion == "none"


def test_an_arc_without_a_centre_is_a_line_on_a_fanuc() -> None:
    lines = ("G0 X10. Z0.", "G3 X20. Z-5. R5. F0.1", "Z-20.")
    kinds = {name: interpreted(name, *lines).effect(2).move for name in ("fanuc-lathe", "generic-lathe")}
    assert [move and move.kind for move in kinds.values()] == ["line", "ccw"]


def test_the_thread_of_linuxcnc_ends_at_its_end() -> None:
    state = after("linuxcnc-lathe", "G8 G0 X10 Z2", "G76 P0.05 Z-1 I-.075 J0.008 K0.045")
    assert state.position[::2] == (10.0, -1.0)


@pytest.mark.parametrize("first", ["G1 X1 Z1", "G1 X1"])
def test_a_run_is_stepped_only_until_a_motion_is_in_force(
    monkeypatch: pytest.MonkeyPatch, first: str
) -> None:
    program = interpreted("linuxcnc-mill", "G21", first, *[f"X{i} Y{i}" for i in range(MANY)], "F3", "G80")
    steps = 0
    advance = type(program.interpreter).advance

    def counted(self: object, *given: object) -> object:
        nonlocal steps
        steps += 1
        return advance(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(type(program.interpreter), "advance", counted)
    state = interpret(program.program, program.settings).end()
    assert state.position.x == MANY - 1
    assert steps < 50


def test_a_table_made_by_hand_is_checked() -> None:
    dialect = chipbreak.load("fanuc-mill").dialect
    check_dialect(dialect)
    codes = {**dialect.g_codes, 950: Code("feed_mode", "revv")}
    with pytest.raises(ValueError, match="feed_mode has no value 'revv'"):
        check_dialect(dialect._replace(g_codes=codes))
    check_dialect(dialect._replace(g_codes={**codes, 950: Code(NON_MODAL, "anything")}))


SHAPE = "N10 G0 X20.{s}\nG1 Z-30.{f}\nN20 X52."


@pytest.mark.parametrize(
    ("f", "s", "behind"),
    [
        ("", "", (0.3, 1000.0)),
        (" F0.1", "", (None, 1000.0)),
        ("", " S1200", (0.3, None)),
        (" F0.1", " S1200", (None, None)),
    ],
)
@pytest.mark.parametrize("place", ["before", "behind"])
def test_feed_and_speed_of_a_shape_may_hold_behind_its_finishing_cycle(
    f: str, s: str, behind: tuple[float | None, float | None], place: str
) -> None:
    """They act in G70; no manual says whether they stay. Those of the roughing cycle do."""
    head = ["G21 G97 S1000 M3", "G0 X52. Z2.", "G71 U2. R1.", "G71 P10 Q20 U0.4 W0.1 F0.3"]
    shape = SHAPE.format(f=f, s=s).split("\n")
    lines = [*head, *shape, "G70 P10 Q20"] if place == "before" else [*head, "G70 P10 Q20", *shape]
    known = [
        None if value is None or math.isnan(value) else value
        for value in values(after("fanuc-lathe", *lines))
    ]
    assert known == list(behind)
    again = values(after("fanuc-lathe", *lines, "G1 X60. F0.2 S900"))
    assert again == (0.2, 900.0)
    assert values(after("fanuc-lathe", *lines[:4], *shape)) == (0.3, 1000.0)


def test_a_cut_behind_a_finishing_cycle_is_not_planned_with_an_old_feed() -> None:
    lines = ["G21 G97 S1000 M3", "G0 X52. Z2.", "G71 U2. R1.", "G71 P10 Q20 U0.4 W0.1 F0.3"]
    lines += [
        *SHAPE.format(f=" F0.1", s="").split("\n"),
        "G70 P10 Q20",
        "(VIB N1.5)",
        "G0 X40.",
        "G1 Z-20.",
        "M30",
    ]
    (found,) = chipbreak.check("\n".join([*lines, ""]).encode(), chipbreak.load("fanuc-lathe"))
    assert (found.code, found.place and found.place.line) == ("VIB050", 11)
    assert "F0.1 of the shape of the finishing cycle in line 8" in found.message


@pytest.mark.parametrize("code", ["G65", "G66"])
def test_what_stands_beside_a_macro_is_said_to_nobody_else(code: str) -> None:
    """Whoever looks ahead for what the program says itself must not find it there."""
    *_, effect = interpreted("fanuc-mill", f"{code} P9 F100. S900 M3 T4 H2").effects
    assert not any(effect.says(letter) for letter in "FSTH")
    assert not effect.does("spindle")
    *_, alone = interpreted("fanuc-mill", "G1 X1. F100. S900 M3 T4 H2").effects
    assert all(alone.says(letter) for letter in "FSTH")
    assert alone.does("spindle", "cw")


def test_the_words_of_a_modal_macro_are_read() -> None:
    """P is its program, and the others are numbers for it."""
    assert not codes_said("fanuc-mill", "G66 P9010 A1. L2", "X5.", "G67", "M30")
    assert codes_said("fanuc-mill", "G0 P9010", "M30")
