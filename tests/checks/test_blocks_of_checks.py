"""The blocks of an insertion one by one: up, still, the calls, and the machine as it was, from above."""

from __future__ import annotations

import pytest

import chipbreak
from beam import BEAM
from chipbreak.checks.check_edits import edits_of_checks
from chipbreak.editing.edits import Edit
from chipbreak.editing.promise import SpindleRestarted
from chipbreak.model.from_source import interpret_source
from chipbreak.operations.kinds import KindRules
from chipbreak.operations.main_program import main_program
from chipbreak.operations.operations import operations_of
from chipbreak.text.source import read

from .filtered import EveryTool

MILL = (
    "G90 G21 G40 G80 G54\nT1 M6\nS1000 M3\n{on}G0 X1. Y1.\nG43 H1 Z15.\n(ROUGH)\nG1 Z-1. F100.\nG0 Z15.\n"
    "(FINISH)\n{behind}G0 X2. Y2.\nZ15.\nG1 Z-1.\nG0 Z15.\nM30\n"
)
LATHE = (
    "G21 G40 G99 G18\nT0101\nG97 S1000 M3\n{on}G0 X20. Z2.\n(ROUGH)\nG1 Z-1. F0.1\nG0 X30. Z2.\n"
    "(FINISH)\n{behind}G0 X19. Z2.\nG1 Z-1.\nG0 X30. Z2.\nM30\n"
)


def edits(program: str, profile: str, *options: str) -> list[Edit]:
    """The insertions; all is known of every tool."""
    settings = chipbreak.load(profile, options)
    interpreted = interpret_source(read(program.encode()), settings)
    main = main_program(interpreted)
    operations = operations_of(interpreted, main, KindRules.from_profile(settings.operations))
    return edits_of_checks(interpreted, operations, main, EveryTool({}, ()))[0]


def own(call: str) -> tuple[str, ...]:
    return (f'calls.own={{chip_check="{call}"}}', "checks.calls=own", "checks.enabled=true")


def leaves(edit: Edit) -> tuple[bool, bool, bool]:
    """Whether the spindle, the coolant and the feed may be others behind it."""
    promise = edit.promise
    assert isinstance(promise, SpindleRestarted)
    return promise.leaves_spindle, promise.leaves_coolant, promise.leaves_feed


PROFILES = ("fanuc-mill", "linuxcnc-mill")
UP = ("G91 G28 Z0.", "G90", "M5")
DOWN = ("G0 X1. Y1.", "G0 G43 H1 Z15.")
# What stands before the cut, the call, what stands behind the cut; the blocks between the operations, and
# those at the end.
BETWEEN: list[tuple[str, str, str, tuple[str, ...], tuple[str, ...]]] = [
    ("", "G65 P1", "", (*UP, "G65 P1", "S1000 M3", *DOWN), (*UP, "G65 P1")),
    (
        "M8\n",
        "G65 P1",
        "",
        ("M9", *UP, "G65 P1", "S1000 M3", DOWN[0], "M8", DOWN[1]),
        ("M9", *UP, "G65 P1"),
    ),
    (
        "M7\nM8\n",
        "G65 P1",
        "",
        ("M9", *UP, "G65 P1", "S1000 M3", DOWN[0], "M8", "M7", DOWN[1]),
        ("M9", *UP, "G65 P1"),
    ),
    ("", "G91", "", (*UP, "G91", "S1000 M3", "G90", *DOWN), (*UP, "G91", "G90")),
    ("", "G55", "", (*UP, "G55", "S1000 M3", "G54", *DOWN), (*UP, "G55", "G54")),
    ("", "M8", "", (*UP, "M8", "S1000 M3", DOWN[0], "M9", DOWN[1]), (*UP, "M8", "M9")),
    ("M8\n", "M8", "", ("M9", *UP, "M8", "S1000 M3", *DOWN), ("M9", *UP, "M8", "M9")),
    (
        "M8\n",
        "M7",
        "",
        ("M9", *UP, "M7", "S1000 M3", DOWN[0], "M9", "M8", DOWN[1]),
        ("M9", *UP, "M7", "M9"),
    ),
    ("", "M3 S500", "", (*UP, "M3 S500", "S1000 M3", *DOWN), (*UP, "M3 S500", "M5", "S1000")),
    (
        "",
        "M3 S500",
        "M5\n",
        (*UP, "M3 S500", "M5", "S1000", *DOWN),
        (*UP[:2], "M3 S500", "M5", "S1000"),
    ),
    ("", "S500", "", (*UP, "S500", "S1000 M3", *DOWN), (*UP, "S500", "S1000")),
    ("", "G18", "", (*UP, "G18", "S1000 M3", *DOWN, "G17"), (*UP, "G18", "G17")),
    ("", "G90 G0 Z50.", "", (*UP, "G90 G0 Z50.", "S1000 M3", *DOWN), (*UP, "G90 G0 Z50.")),
]


@pytest.mark.parametrize(("on", "call", "behind", "between", "last"), BETWEEN)
def test_what_stands_between_two_operations_and_behind_the_last_one(
    on: str, call: str, behind: str, between: tuple[str, ...], last: tuple[str, ...]
) -> None:
    found = edits(MILL.format(on=on, behind=behind), "fanuc-mill", *own(call))
    assert [one.content for one in found] == [between, last]
    line = 8 + on.count("\n")
    assert [(one.first, one.last) for one in found] == [(line, line), (line + 5 + len(behind) // 3,) * 2]
    assert [leaves(one) for one in found] == [(bool(behind), False, False), (not behind, bool(on), False)]


def test_on_a_lathe_x_comes_down_last() -> None:
    cut = edits(LATHE.format(on="M8\n", behind="G1 X18. F0.1\n"), "fanuc-lathe", *own("G65 P1"))
    assert [one.content for one in cut] == [
        ("M9", "G28 U0", "G28 W0", "M5", "G65 P1", "S1000 M3", "G0 Z2.", "M8", "G0 X30."),
        ("M9", "G28 U0", "G28 W0", "M5", "G65 P1"),
    ]
    rapid = edits(LATHE.format(on="G96 S150\n", behind=""), "fanuc-lathe", *own("G65 P1"))
    assert rapid[0].content == ("G28 U0", "G28 W0", "M5", "G65 P1", "S150 M3")


def test_calls_written_out_in_the_program_give_feed_and_offset_back() -> None:
    plate = (
        "macros.setter_x_mm=1",
        "macros.setter_y_mm=2",
        "macros.setter_z_mm=-300",
        "macros.safe_z_mm=-10",
    )
    program = MILL.format(on="", behind="").replace("G43 H1 ", "").replace(" G80", "")
    found = edits(program, "grbl", "checks.calls=setter", "checks.enabled=true", *plate)
    over = ("G53 G0 Z-10.", "G53 G0 X1. Y2.", "G59")
    assert [one.content for one in found] == [
        (
            *("G53 G0 Z0", *over, "G10 L20 P6 Z0", "G38.2 Z-290. F150.", "G10 L20 P6 Z0", "G0 Z2."),
            *("G38.2 Z-2. F12.", "G10 L20 P6 Z0", "G53 G0 Z-10.", "G54"),
        ),
        (
            *("G53 G0 Z0", "M5", *over, "G38.3 Z0.02 F150.", "G38.2 Z-0.02 F12.", "G53 G0 Z-10.", "G54"),
            *("S1000 M3", "F100."),
        ),
        (
            *("G53 G0 Z0", "M5", *over, "G38.3 Z0.05 F150.", "G38.2 Z-0.05 F12.", "G53 G0 Z-10.", "G54"),
            "F100.",
        ),
    ]
    # Before the first cut no feed is in force that could be given back.
    assert [leaves(one) for one in found] == [
        (False, False, True),
        (False, False, False),
        (True, False, False),
    ]
    assert [one.title for one in found] == ["TOOL CHECK T1", "CHIP CHECK T1 W0.02", "CHIP CHECK T1 W0.05"]
    assert {one.duration_s for one in found} == {None}


@pytest.mark.parametrize("profile", PROFILES)
def test_the_checks_of_one_place_are_one_insertion_and_their_seconds_one_sum(profile: str) -> None:
    """TOOL CHECK: 22 + 4 x 2.2 + 73 turns of 60 ms; TRACE: 20 + 4 x 1.27 x 21 heights + 36 turns."""
    found = edits(MILL.format(on="", behind=""), profile, *BEAM)
    assert [one.title for one in found] == [
        "CALIBRATE",
        "TOOL CHECK T1, TRACE T1",
        "CHIP CHECK T1 W0.02",
        "CHIP CHECK T1 W0.05",
    ]
    both = 22.0 + 4 * 2.2 + 73 * 0.06 + 20.0 + 4 * 1.27 * 21 + 36 * 0.06
    assert [one.duration_s for one in found[:2]] == pytest.approx([15.0, both])
    shorter = [name.partition("=")[0] for name, _ in found[1].otherwise_s]
    assert shorter == ["macros.gap_ms", "checks.trace_height_mm", "checks.depth"]
    low = both - 4 * 1.27 * (21 - 6)
    length = both - 20.0 - 4 * 1.27 * 21 + 5.0
    assert [seconds for _, seconds in found[1].otherwise_s] == pytest.approx([both, low, length])
    reasons = found[1].reason.split("; ")
    assert [one[:8] for one in reasons] == ["T1 is ca", "the edge"]


def test_linuxcnc_goes_up_in_machine_coordinates_and_ends_its_calls_with_g80() -> None:
    found = edits(MILL.format(on="", behind=""), "linuxcnc-mill", *BEAM)
    assert [one.content for one in found] == [
        ("G53 G0 Z0", "o<cb_calibrate> call", "G80"),
        (
            *(
                "G53 G0 Z0",
                "o<cb_tool> call [1] [1] [10.] [0.] [4] [30.]",
                "o<cb_length> call [1] [40.] [60.]",
            ),
            *("o<cb_tool_check> call [1] [1000]", "o<cb_trace> call [1] [20.]", "G80"),
        ),
        ("G53 G0 Z0", "M5", "o<cb_chip_check> call [1] [0.02] [1]", "S1000 M3"),
        ("G53 G0 Z0", "M5", "o<cb_chip_check> call [1] [0.05] [1]"),
    ]


def test_an_incremental_program_goes_up_absolutely_where_the_control_wants_it() -> None:
    program = MILL.format(on="", behind="G90\n").replace("G0 Z15.\n(FINISH)", "G91 G0 Z16.\n(FINISH)", 1)
    found = {profile: edits(program, profile, *own("G65 P1"))[0].content for profile in PROFILES}
    assert found["linuxcnc-mill"] == ("G90", "G53 G0 Z0", "M5", "G65 P1", "S1000 M3", "G91")
    assert found["fanuc-mill"] == (*UP, "G65 P1", "S1000 M3", *DOWN, "G91")


LINUXCNC = (
    "G21 G40 G95 G18 G7\nT1 M6\nG97 S1000 M3\n{on}G0 X20 Z2\n(ROUGH)\nG1 Z-1 F0.1\nG0 X30 Z2\n(FINISH)\n"
    "G0 X19 Z2\nG1 Z-1\nG0 X30 Z2\nM2\n"
)


@pytest.mark.parametrize(
    ("on", "back"),
    [
        ("", ("S1000 M3",)),
        ("G20\nS900\nG21\n", ("S900 M3",)),
        ("G96 S150\n", ("S150 M3",)),
        # The number was read in feet a minute, and S is read before the units of its block.
        ("G20\nG96 S500\nG21\n", ("G20", "G21 S500 M3")),
    ],
)
def test_a_surface_speed_comes_back_in_the_units_in_which_it_was_said(on: str, back: tuple[str, ...]) -> None:
    between, last = edits(LINUXCNC.format(on=on), "linuxcnc-lathe", *own("G4 P1"))
    assert between.content == ("G53 G0 X0", "G53 G0 Z0", "M5", "G4 P1", *back)
    assert last.content == between.content[:4]


def test_a_check_stands_behind_the_call_and_where_calls_are_written_out_behind_the_stop() -> None:
    """At a stop behind it somebody changes the tool by hand."""
    stop = MILL.format(on="M0\n", behind="")
    assert [one.first for one in edits(stop, "fanuc-mill", *BEAM)][:2] == [1, 2]
    plate = (
        "macros.setter_x_mm=1",
        "macros.setter_y_mm=2",
        "macros.setter_z_mm=-300",
        "macros.safe_z_mm=-10",
    )
    for text, line in ((MILL.format(on="", behind=""), 2), (stop, 6)):  # there the place is known again
        plain = text.replace("G43 H1 ", "").replace(" G80", "")
        assert edits(plain, "grbl", "checks.calls=setter", "checks.enabled=true", *plate)[0].first == line
