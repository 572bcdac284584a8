"""What blocks do: modal groups, units, positions known and unknown, and long runs taken at once."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

import chipbreak
from chipbreak.dialects.modes import Modes
from chipbreak.model.interpret import initial_state
from chipbreak.model.interpreted_program import InterpretedProgram, interpret
from chipbreak.model.modal import Setting, State
from chipbreak.settings import load
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read


def traced(program: str, profile: str = "generic-lathe", *sets: str) -> InterpretedProgram:
    settings = load(profile, sets)
    return interpret(parse(read(program.encode("latin-1")), settings.dialect), settings)


def after(program: str, profile: str = "generic-lathe", *sets: str) -> State:
    return traced(program, profile, *sets).end()


def place(state: State) -> tuple[float | None, ...]:
    return tuple(None if math.isnan(v) else round(v, 9) for v in state.position)


def facts(state: State) -> dict[str, object]:
    """A state that can be compared: NaN equals NaN."""

    def value(item: object) -> object:
        return str(item) if isinstance(item, float) or item is None else item

    settings = {name: getattr(state, name) for name in ("feed", "speed", "speed_limit")}
    return {
        "modes": dict(state.modes.items()),
        "position": [str(v) for v in state.position],
        **{k: None if s is None else [value(v) for v in s] for k, s in settings.items()},
        "spindle": state.spindle,
        "coolant": state.coolant,
        "tool": state.tool,
        "ended": state.ended,
    }


# --- a long run is the same as its blocks one by one ------------------------------------------------------

_PLAIN = st.sampled_from(
    [
        "G1 X10. Z-2.",
        "Z-3.5",
        "X12",
        "G0 Z5.",
        "G2 X14. Z-4. R3.",
        "G3 X16. Z-5. I2. K0.",
        "F0.3",
        "X1. F.2",
        "Y2.",
        "U1. W-2.",
        "W-.5",
        "N100 Z1.",
        "N200 X3.",
        "X5 Z5 F100",
        "G01 X0",
        "A90.",
    ]
)
_EVENTS = st.sampled_from(
    [
        "G90",
        "G91",
        "G20",
        "G21",
        "G94",
        "G95",
        "G96 S100",
        "G97 S500 M3",
        "M5",
        "T0101",
        "G28 U0",
        "G54",
        "G55",
        "(note)",
        "",
        "/G0 X7.",
        "G4 X1.",
        "M98 P5",
        "G92 X0. Z0.",
        "G50 S2000",
        "?!",
        "#1=5",
        "X#1",
        "G80",
        "G7",
        "G8",
        "M30",
        "G41 D1",
        "G33 Z-2. F1.",
        "G83 Z-5. F.1",
        "M8",
        "M9",
        "M6",
        "S900",
        "N100",
        "G68 R30.",
        "WHILE[#1LT2]DO1",
        "V100. D20.",
        "(SPEED V100 D20)",
        "G53 X0",
        "g1 x3.",
        "G1X1.Z2.F.1 N1.5",
    ]
)
_FLOWS = st.sampled_from(["", "", "", "GOTO100", "IF[#1EQ1]GOTO100", "G71 P100 Q200 U.1 W.1"])


@pytest.mark.few(12)
@given(
    st.lists(st.one_of(_EVENTS, st.lists(_PLAIN, min_size=1, max_size=30))),
    _FLOWS,
    st.sampled_from(["generic-lathe", "fanuc-lathe", "linuxcnc-lathe", "fanuc-mill"]),
)
@hypothesis_settings(max_examples=100)
def test_skipping_is_advancing(parts: list[str | list[str]], flow: str, profile: str) -> None:
    lines = [line for part in parts for line in ([part] if isinstance(part, str) else part)]
    lines.insert(len(lines) // 2, flow)
    interpreted = traced("\n".join(lines), profile)
    state = initial_state(interpreted.settings)
    for line in range(interpreted.program.source.body.start, interpreted.program.source.body.stop):
        effect = interpreted.interpreter.advance(state, interpreted.program.block(line))
        # At a jump target or behind the program's end the block itself begins with another state.
        assert facts(interpreted.before(line)) in (facts(state), facts(effect.before)), lines[line]
        state = effect.after
    assert facts(interpreted.end()) == facts(state)


FLOWS = ("GOTO100", "GOTO200", "G71 P100 Q200 U.1 W.1", "G71 P100 Q100 U.1 W.1")
RUNS = ("X1. F.2\nZ5.", "G91\nU1. W-2.\nG2 X14. Z-4. R3.")
_TURNS = [
    pytest.param(flow, run.split("\n"), marks=pytest.mark.long if (at + turn) % 2 else ())
    for at, flow in enumerate(FLOWS)
    for turn, run in enumerate(RUNS)
]


@pytest.mark.parametrize(("flow", "run"), _TURNS)
def test_long_runs_around_what_a_program_goes_to_are_skipped_rightly(flow: str, run: list[str]) -> None:
    """Between such lines a run is skipped as a whole; those themselves are stepped through."""
    rest = run[1:] * 15
    lines = [flow, "G1 F.1", *run, *rest, "N100 Z1.", *rest, "N200 X3. F.3", *rest, "G0 X9."]
    interpreted = traced("\n".join(lines), "generic-lathe")
    assert interpreted.flow.contours or interpreted.flow.targets
    state = initial_state(interpreted.settings)
    for line in interpreted.program.source.body:
        effect = interpreted.interpreter.advance(state, interpreted.program.block(line))
        assert facts(interpreted.before(line)) in (facts(state), facts(effect.before)), lines[line]
        state = effect.after
    assert facts(interpreted.end()) == facts(state)


# --- units, diameters, distances --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "profile", "sets", "end"),
    [
        pytest.param("G0 X20. Z2.", "generic-lathe", (), (10.0, None, 2.0), id="X is a diameter"),
        pytest.param(
            "G0 X20. Z2.", "generic-lathe", ("control.x_diameter=false",), (20.0, None, 2.0), id="radius"
        ),
        pytest.param("G20\nG0 X2. Z1.", "generic-lathe", (), (25.4, None, 25.4), id="inch"),
        pytest.param("G0 X20. Z2.\nG0 U4. W-1.", "generic-lathe", (), (12.0, None, 1.0), id="U and W"),
        pytest.param("G0 X20. Z2.\nG91 X4. Z-1.", "generic-lathe", (), (12.0, None, 1.0), id="G91"),
        pytest.param(
            "G0 X20. Z2.\nG91\nX4.\nX4.\nG90 Z5.", "generic-lathe", (), (14.0, None, 5.0), id="and back"
        ),
        pytest.param("G0 X20. Z2.\nU4. Z-1.", "generic-lathe", (), (12.0, None, -1.0), id="U beside Z"),
        pytest.param("G91 G0 X4.", "generic-lathe", (), (None, None, None), id="a distance from nowhere"),
        pytest.param("G0 X20 Z2", "generic-lathe", (), (10.0, None, 2.0), id="calculator"),
        pytest.param("G0 X20 Z2.", "fanuc-lathe", (), (None, None, 2.0), id="no point where it is required"),
        pytest.param("G0 X0 Z2.", "fanuc-lathe", (), (0.0, None, 2.0), id="zero needs no point"),
        pytest.param(
            "G0 X20000 Z2.",
            "fanuc-lathe",
            ("control.decimal_point=increment",),
            (10.0, None, 2.0),
            id="increments",
        ),
        pytest.param(
            "G20 G0 X20000",
            "fanuc-lathe",
            ("control.decimal_point=increment",),
            (25.4, None, None),
            id="inch increments",
        ),
        pytest.param("G0 X20 Z2", "linuxcnc-lathe", (), (20.0, None, 2.0), id="LinuxCNC starts in radius"),
        pytest.param("G7 G0 X20\nG8 G0 Z2", "linuxcnc-lathe", (), (10.0, None, 2.0), id="G7"),
        pytest.param("G0 X[4*5] Z[-2]", "generic-lathe", (), (10.0, None, -2.0), id="constant expressions"),
        pytest.param("G0 X[9 MOD 5]", "generic-lathe", (), (2.0, None, None), id="a remainder"),
        pytest.param("G0 X[-9 MOD 5]", "generic-lathe", (), (None, None, None), id="each control its own"),
        pytest.param("G0 X[4 + 2 AND 1]", "generic-lathe", (), (None, None, None), id="bits or truth"),
        pytest.param("G0 X20. Z2.\nX#1", "generic-lathe", (), (None, None, 2.0), id="a variable"),
        pytest.param(
            "G0 X20. X30.", "generic-lathe", (), (15.0, None, None), id="the last of two words counts"
        ),
        pytest.param("g0 x20. z2.", "generic-lathe", (), (10.0, None, 2.0), id="lower case"),
        pytest.param("G90 X18. Z-30. F.2", "fanuc-lathe", (), (None, None, None), id="a cycle from nowhere"),
        pytest.param(
            "G0 X20. Z2.\nG90 X18. Z-30. F.2", "fanuc-lathe", (), (10.0, None, 2.0), id="a cycle comes back"
        ),
        pytest.param(
            "G0 X20. Z2.\nG33 Z-5. F1.", "generic-lathe", (), (10.0, None, -5.0), id="a thread ends there"
        ),
        pytest.param(
            "G0 X20. Z2.\nG3 X40. Z-8. R10. F.1", "generic-lathe", (), (20.0, None, -8.0), id="an arc"
        ),
        pytest.param("G0 X20. Z2.\nG2 I5. F.1", "generic-lathe", (), (10.0, None, 2.0), id="a full circle"),
    ],
)
def test_where_blocks_lead(
    program: str, profile: str, sets: tuple[str, ...], end: tuple[float | None, ...]
) -> None:
    assert place(after(program, profile, *sets)) == end


# --- what makes a position unknown ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "known", "profile"),
    [
        pytest.param("T0202", "", "generic-lathe", id="tool change by T"),
        pytest.param("T2", "XZ", "linuxcnc-lathe", id="T only prepares"),
        pytest.param("M6", "", "linuxcnc-lathe", id="tool change by M6"),
        pytest.param("G28 U0", "Z", "generic-lathe", id="home in X"),
        pytest.param("G28", "", "generic-lathe", id="home without axes"),
        pytest.param("G53 Z0", "X", "generic-lathe", id="machine coordinates"),
        pytest.param("G31 Z0. F.1", "X", "generic-lathe", id="skip"),
        pytest.param("G92 X0.", "", "generic-lathe", id="new origin"),
        pytest.param("G92 S2000", "XZ", "generic-lathe", id="G92 S is a clamp"),
        pytest.param("G50 S2000", "XZ", "generic-lathe", id="G50 S is a clamp"),
        pytest.param("G52 Z1.", "", "generic-lathe", id="shift"),
        pytest.param("G10 P1 Z1.", "", "generic-lathe", id="data setting"),
        pytest.param("G55", "", "generic-lathe", id="work offset"),
        pytest.param("G54", "XZ", "generic-lathe", id="the work offset it has"),
        pytest.param("G43 H1", "X", "linuxcnc-lathe", id="length offset"),
        pytest.param("G65 P9100 X1.", "", "generic-lathe", id="macro call"),
        pytest.param("M98 P100", "", "generic-lathe", id="subprogram"),
        pytest.param("o100 call", "", "linuxcnc-lathe", id="o-word call"),
        pytest.param("WHILE[#1LT3]DO1", "", "fanuc-lathe", id="a loop"),
        pytest.param("G68 X0. Z0. R30.", "", "generic-lathe", id="rotation"),
        pytest.param("G123 X5.", "", "generic-lathe", id="an unknown code with an axis"),
        pytest.param("G123", "XZ", "generic-lathe", id="an unknown code alone"),
        pytest.param("?!", "", "generic-lathe", id="an unreadable line"),
        pytest.param("/G0 Z9.", "X", "generic-lathe", id="block delete"),
        pytest.param("/M8", "XZ", "generic-lathe", id="block delete without a move"),
        pytest.param("G4 X1.", "XZ", "generic-lathe", id="a dwell"),
        pytest.param("G71 P1 Q2 U.1 W.1", "", "generic-lathe", id="a roughing cycle"),
        pytest.param("M30\nG0 X20.", "X", "generic-lathe", id="another program"),
        pytest.param("(note)", "XZ", "generic-lathe", id="a comment"),
    ],
)
def test_what_loses_the_position(line: str, known: str, profile: str) -> None:
    state = after(f"G0 X20. Z2.\n{line}\n", profile)
    assert "".join(a for a, v in zip("XYZ", state.position, strict=True) if not math.isnan(v)) == known
    assert known == "XZ" or state.unknown_why != State(Modes()).unknown_why, "the reason is remembered"


def test_a_jump_target_forgets_feed_and_speed_that_not_all_ways_bring() -> None:
    state = after("G97 S500 M3\nG0 X20. Z2. F.1\nIF[#1EQ1]GOTO100\nS600 F.2\nN100\n")
    assert place(state) == (None, None, None)
    assert (state.feed, state.speed) == (None, None)
    assert "jump" in state.unknown_why
    state = after("G97 S500 M3\nG0 X20. Z2. F.1\nGOTO200\nN100\n")
    assert place(state) == (10.0, None, 2.0)


def test_a_computed_jump_can_arrive_at_every_number() -> None:
    assert place(after("G0 X20. Z2.\nGOTO#1\nN100\n")) == (None, None, None)


def test_the_shape_of_a_cycle_moves_nothing_where_it_stands() -> None:
    interpreted = traced(
        "G0 X40. Z2.\nG71 P100 Q110 U.5 W.1 F.2\nN100 G0 X20.\nG1 Z-30. F.1\nN110 X40.\nG0 X50.\nM30\n"
    )
    assert [effect.block.line for effect in interpreted.effects_of(0, 7) if effect.in_contour] == [2, 3, 4]
    assert place(interpreted.before(5)) == (None, None, None)
    assert place(interpreted.end()) == (25.0, None, None)


# --- modal values -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "feed", "speed"),
    [
        ("F.1 S500", 0.1, 500.0),
        ("G94 F100.\nG95", None, None),
        ("G95 F.1\nG95", 0.1, None),
        ("F.1\nG94 F100.", 100.0, None),
        ("G1 X1. F100. G94", 100.0, None),
        ("S500\nG96 S120", None, 120.0),
        ("G96 S120\nG97", None, None),
        ("G97 S500\nG50 S2000", None, 500.0),
        ("V188.5 D20.", None, 3000.0),
        ("S500\n(SPEED V188.5 D20)", None, 3000.0),
        ("S500\nV188.5", None, 500.0),
        ("S#1", None, "unknown"),
        ("G4 X1. F5.", 5.0, None),
        ("G4 F5.", None, None),
        ("G65 P1 S3. F2.", None, None),
        ("f.1 s500", 0.1, 500.0),
    ],
)
def test_feed_and_speed(program: str, feed: float | None, speed: float | str | None) -> None:
    state = after(program)
    assert (state.feed.value if state.feed else None) == feed
    got = state.speed.value if state.speed else None
    assert (got is not None and math.isnan(got)) if speed == "unknown" else got == speed


@pytest.mark.parametrize(
    ("program", "limit"),
    [("G50 S2000", 2000.0), ("G92 S2000", 2000.0), ("G50 X1. Z1.", None), ("G97 S2000", None)],
)
def test_speed_limits(program: str, limit: float | None) -> None:
    state = after(program)
    assert (state.speed_limit.value if state.speed_limit else None) == limit


def test_the_limit_of_linuxcnc_stands_with_its_g96() -> None:
    limit = Setting(1500.0, "1500", 0)
    assert after("G96 D1500 S120", "linuxcnc-lathe").speed_limit == limit
    assert after("G96 D1500 S120\nS100", "linuxcnc-lathe").speed_limit == limit
    assert after("G96 D1500 S120\nG96 S100", "linuxcnc-lathe").speed_limit is None
    assert after("G96 D1500 S120\nG97 S500", "linuxcnc-lathe").speed_limit is None
    assert after("G96 D1500 S120").speed_limit is None, "on another control D is no limit"


@pytest.mark.parametrize(
    ("first", "second", "off"),
    [("G7.1 C20.", "", False), ("G7.1 C20.", "G7.1 C0", True), ("G107 H20.", "G107 H0.", True)],
)
def test_a_cylinder_of_no_radius_ends_it(*, first: str, second: str, off: bool) -> None:
    modes = after(f"{first}\n{second}", "fanuc-lathe").modes
    assert modes.cylinder == ("off" if off else "on")


@pytest.mark.parametrize(
    ("program", "spindle", "coolant"),
    [
        ("M3", "cw", ()),
        ("M4 M8", "ccw", ("flood",)),
        ("M3\nM5", "stop", ()),
        ("M3\nM19", "stop", ()),
        ("M7\nM8", "stop", ("flood", "mist")),
        ("M7\nM8\nM9", "stop", ()),
    ],
)
def test_machine_functions(program: str, spindle: str, coolant: tuple[str, ...]) -> None:
    state = after(program)
    assert (state.spindle, tuple(sorted(state.coolant))) == (spindle, coolant)


@pytest.mark.parametrize(
    ("code", "group", "value", "profile"),
    [
        ("G90", "motion", "turning-cycle", "fanuc-lathe"),
        ("G90", "distance", "absolute", "generic-lathe"),
        ("G98", "feed_mode", "minute", "fanuc-lathe"),
        ("G98", "return_level", "initial", "fanuc-mill"),
        ("G92", "motion", "threading-cycle", "fanuc-lathe"),
        ("G76", "motion", "thread-cycle", "linuxcnc-lathe"),
        ("G41.1", "compensation", "left", "linuxcnc-lathe"),
        ("G05.1", "look_ahead", "switched", "fanuc-lathe"),
        ("G01", "motion", "line", "generic-lathe"),
        ("G1.0", "motion", "line", "generic-lathe"),
    ],
)
def test_modal_groups(code: str, group: str, value: str, profile: str) -> None:
    assert after(code, profile).modes.value(group) == value


def test_words_that_nothing_reads_are_named() -> None:
    effects_of = list(
        traced("G1 X1. P5\nG1 X1. R2.\nG2 X1. R2.\nG4 P5\nM98 P100\nG1 Z2. L3 F.1\n").effects_of(0, 6)
    )
    shown = [[effect.block.text[w.start : w.end] for w in effect.unread] for effect in effects_of]
    assert shown == [["P5"], ["R2."], [], [], [], ["L3"]]


@pytest.mark.parametrize(
    "line", ["M3 S1000", "G4 P1", "#1=2", "M98 P100", "G10 L2 P1 X1.", "G65 P9 A1.", "M8"]
)
def test_a_wish_where_nothing_is_cut_is_named(line: str) -> None:
    block = traced(f"{line} N0.5\n").effect(0)
    assert [word.value_text for word in block.unread if word.address == "N"] == ["0.5"]
    assert not any(word.address == "N" for word in traced(f"{line} N5\n").effect(0).unread)


@pytest.mark.parametrize("line", ["G68 X0. Y0. R30.", "G51 X0. Y0. P2000", "G51.1 X0."])
def test_the_words_of_a_rotation_are_read_by_it(line: str) -> None:
    settings = chipbreak.load("fanuc-mill", ["checks.enabled=false"])
    assert not chipbreak.rewrite(f"G0 X1. Y1.\n{line}\nM30\n".encode(), settings).diagnostics


@pytest.mark.parametrize("distances", ["G91", "G90"])
def test_comments_alone_leave_states_near(distances: str) -> None:
    """Wherever a walk begins it is short, also where nothing but comments stands between moves."""
    moves = "(A)\nG1 Z-1.\n" * 100 + "Z-1.\n" * 40
    found = traced(f"G0 X0. Z0.\n{distances}\n{moves}M30\n")
    steps = [after - before for before, after in pairwise(found.lines)]
    assert max(steps[:-2]) <= 10  # the forty moves at the end are one run
    walked = [facts(effect.before) for effect in found.effects_of(0, 240)]
    assert [facts(found.before(line)) for line in range(240)] == walked


def test_a_comment_behind_few_moves_keeps_no_state() -> None:
    """The state of every other line of a long program would fill the memory."""
    found = traced("G0 X0. Z0.\nG91\n" + "(A)\nG1 Z-1.\n" * 500)
    assert len(found.lines) < 150
