"""Wishes that cannot be met: what stays as it was, how it runs, and what is said of it."""

from __future__ import annotations

import pytest
from test_refusals import REFUSED

import chipbreak
from machine_reader import beside_unproven, filtered, rejected, run_program

HEAD = "G97 S3000 M3\nG0 X20. Z2.\n"
PROFILE = ("vibration.n=1.5",)
LEAVE = "vibration.refused=leave"
GOOD = "G1 Z-30. F0.05\nG0 X30. Z2.\nG0 X18.\n"


def result_of(program: str, *sets: str, profile: str = "generic-lathe") -> chipbreak.Result:
    return chipbreak.rewrite(program.encode(), chipbreak.load(profile, sets))


def warned(result: chipbreak.Result) -> list[tuple[str, int]]:
    assert all(d.severity.value != "error" for d in result.diagnostics)
    breaks = any(cut.verdict.breaks for cut in result.cuts)
    return [(d.code, d.place.line) for d in beside_unproven(result.diagnostics, breaks) if d.place]


@pytest.mark.parametrize(
    ("before", "cut", "code"),
    [case for case in REFUSED if case.id != "no feed"],  # the cut before it gives one
)
@pytest.mark.parametrize("how", ["directive", "profile"])
def test_a_cut_that_cannot_vibrate_stays(before: str, cut: str, code: str, how: str) -> None:
    """With the cut before it, which vibrates, at a speed and feed that the left one does not take over."""
    program = f"{HEAD}{'(VIB N1.5)' if how == 'directive' else ''}\n{GOOD}{before}\n{cut}\nM30\n"
    sets = PROFILE if how == "profile" else (LEAVE,)
    result = result_of(program, *sets)
    line = 8 + before.count("\n")
    assert (code, line) in warned(result)
    (left,) = result.left
    assert (left.said.code, left.first, left.last, left.asked_by) == (code, line - 1, line, how)
    assert len(result.cuts) == 1
    assert chipbreak.restore(result.data) == program.encode()


def test_a_directive_is_refused_and_words_are_always() -> None:
    asked = f"{HEAD}G41\n(VIB N1.5)\nG1 Z-30. F0.05\nM30\n"
    assert rejected(asked) == [("VIB040", 5, 1)]
    assert rejected(asked, "generic-lathe", "vibration.refused=error") == [("VIB040", 5, 1)]
    word = f"{HEAD}G41\nG1 Z-30. F0.05 N1.5\nM30\n"
    assert rejected(word, "generic-lathe", LEAVE) == [("VIB040", 4, 16)]
    assert rejected(word, "generic-lathe", *PROFILE) == [("VIB040", 4, 16)]


def test_a_left_cut_between_vibrated_ones_runs_as_programmed() -> None:
    """Of the same chain, of another feed mode, under G96, with an S of its own."""
    program = (
        f"{HEAD}G1 Z-30. F0.05\nG41\nG1 X24. F0.07\nG40\nG1 X25.\nG1 Z-60. F0.05\nG0 X30. Z2.\n"
        "G96 S120\nG0 X20.\nG1 Z-30. F0.05\nG41 S150\nG1 X24. F0.07\nG40\nG1 X25.\nG1 Z-60. F0.05\nM30\n"
    )
    out = filtered(program, "generic-lathe", *PROFILE)
    run = run_program(out)
    outside = {line: state for line, state in run.outside if line.startswith("G1 X24.")}
    assert len(run.cuts) == 4
    lines = out.splitlines()
    first = lines.index("G1 X24. F0.07")
    back = [line for line in lines[:first] if line.startswith(("S", "G97 S", "G96"))]
    assert back[-1] == "S3000"
    second = len(lines) - 1 - lines[::-1].index("G1 X24. F0.07")
    back = [line for line in lines[:second] if "S1" in line and not line.startswith("(")]
    assert back[-1].endswith("S150")
    assert outside


def test_what_does_not_break_its_chips_stays_too() -> None:
    """Found only in the output: all is planned again without it."""
    program = f"{HEAD}G1 Z-30. F0.05\nG0 X30. Z2.\nG0 X18.\n(VIB N1.5 Q0.5)\nG1 Z-30.\nM30\n"
    assert rejected(program, "generic-lathe") == [("VIB060", 7, 1)]
    result = result_of(program, LEAVE, *PROFILE)
    assert warned(result) == [("VIB060", 7)]
    assert [cut.plan.chain.first for cut in result.cuts] == [2]
    settings = chipbreak.load("generic-lathe", [LEAVE, *PROFILE])
    assert len(chipbreak.verify(result.data, settings).cuts) == 1


def test_loops_count_only_the_cuts_that_vibrate() -> None:
    program = f"{HEAD}G1 Z-60. F0.05\nG41\nG1 X24.\nG40\nG0 X20. Z2.\nG1 Z-60. F0.05\nM30\n"
    result = result_of(program, *PROFILE, "output.form=loop", profile="fanuc-lathe")
    assert [cut.plan.chain.first for cut in result.cuts] == [2, 7]
    assert [left.first for left in result.left] == [4]


def test_speed_that_is_not_known_behind_a_cut_leaves_the_cut() -> None:
    program = "G97 M3\nG0 X20. Z2.\n(VIB N1.5 F62.5)\nG1 Z-30. F0.05\n(VIB OFF)\nG1 X30.\nM30\n"
    assert rejected(program) == [("VIB057", 4, 1)]
    result = result_of(program, LEAVE)
    assert warned(result) == [("VIB057", 4)]
    assert not result.changed


def test_many_alike_are_said_once() -> None:
    program = HEAD + "G41\n" + "".join(f"G1 Z-{10 + n}. F0.05\nG0 Z2.\n" for n in range(8)) + "M30\n"
    result = result_of(program, *PROFILE)
    (warning,) = result.diagnostics
    assert "7 more up to line 18" in warning.message
    assert len(result.left) == 8


# --- moves that are no cuts, lines that cannot matter ------------------------------------------------------


@pytest.mark.parametrize(
    ("program", "codes", "cuts"),
    [
        pytest.param(
            f"{HEAD}G1 Z-20. F0.1\nG0 X30. Z50.\nM5\nT0505 (BAR PULLER)\nG94\nG0 X0. Z10.\n"
            "G1 Z-1. F2000.\nM30\n",
            [("VIB046", 9)],
            1,
            id="bar puller",
        ),
        pytest.param(
            "G97 S1000 M3\nG0 X40. Z0.\nG1 Z0. F0.1\nX2. F0.2\nG0 X60. Z50.\nM30\n",
            [("VIB023", 3)],
            1,
            id="no length",
        ),
        pytest.param(
            f"[BILLET X50 Z70\n{HEAD}G1 Z-20. F0.1\nM30\n", [("SYN001", 1)], 1, id="head that cannot be read"
        ),
        pytest.param(
            f"[G96 S200\n{HEAD}G1 Z-20. F0.1\nM30\n",
            [("SYN001", 1), ("VIB018", 1)],
            0,
            id="a head that may say codes",
        ),
        pytest.param(
            f"{HEAD}G1 Z-20. F0.1\nX2O.\nG0 X20. Z2.\nS3000\nG1 Z-20. F0.1\nT0202\nG0 X20. Z2.\n"
            "G1 Z-20. F0.1\nM30\n",
            [("SYN001", 4), ("VIB018", 4)],
            2,
            id="behind a line that cannot be read, up to the next tool",
        ),
    ],
)
def test_no_cut_rejects_a_program_that_asked_by_profile(
    program: str, codes: list[tuple[str, int]], cuts: int
) -> None:
    result = result_of(program, *PROFILE)
    assert warned(result) == codes
    assert len(result.cuts) == cuts


# --- operations, air --------------------------------------------------------------------------------------

OPERATIONS = (
    "G97 S3000 M3\nT0101 (ROUGH)\nG0 X20. Z2.\nG1 Z-30. F0.05\nG0 X30. Z2.\n"
    "T0202 (FINISH)\nG0 X19. Z2.\nG1 Z-30. F0.05\nG0 X30. Z2.\n"
    "T0303 (DRILL 8)\nG0 X0. Z2.\nG1 Z-30. F0.05\nG0 Z2.\nG0 X40.\n"
    "T0404\nG0 X40. Z2.\nG1 Z-30. F0.05\nM30\n"
)


@pytest.mark.parametrize(
    ("only", "lines"),
    [
        pytest.param([], [4, 12, 17], id="all but finishing"),
        pytest.param(["rough"], [4], id="roughing"),
        pytest.param(["drill", "finish"], [8, 12], id="drilling and finishing"),
        pytest.param(["T4", "rough"], [4, 17], id="a tool"),
        pytest.param(["unknown"], [17], id="what nobody named"),
    ],
)
def test_only_these_operations(only: list[str], lines: list[int]) -> None:
    result = result_of(OPERATIONS, *PROFILE, f"vibration.only={only}", profile="fanuc-lathe")
    assert [cut.plan.chain.first + 1 for cut in result.cuts] == lines


def test_finishing_that_nobody_named_is_said() -> None:
    result = result_of(OPERATIONS, *PROFILE, profile="fanuc-lathe")
    assert ("VIB068", 8) in warned(result)


def test_words_and_comments_ask_whatever_only_says() -> None:
    program = OPERATIONS.replace("G0 X19. Z2.\n", "G0 X19. Z2.\n(VIB)\n")
    result = result_of(program, *PROFILE, 'vibration.only=["rough"]', profile="fanuc-lathe")
    assert [cut.plan.chain.first + 1 for cut in result.cuts] == [4, 9]


def test_only_that_reaches_nothing_is_said() -> None:
    result = result_of(OPERATIONS, *PROFILE, 'vibration.only=["T9"]', profile="fanuc-lathe")
    assert [code for code, _ in warned(result)] == ["VIB065"]


@pytest.mark.parametrize("only", ['["roughing"]', '["T0"]', '["t3"]', '["3"]'])
def test_only_names_what_there_is(only: str) -> None:
    with pytest.raises(chipbreak.SettingsError) as caught:
        chipbreak.load("generic-lathe", [f"vibration.only={only}"])
    assert caught.value.diagnostic.code == "SET003"


def test_kinds_of_the_settings_are_those_of_operations() -> None:
    from chipbreak.operations.kinds import Kind
    from chipbreak.settings.sections import OPERATION_KINDS

    assert tuple(kind.value for kind in Kind) == OPERATION_KINDS


@pytest.mark.parametrize(
    ("moves", "vibrated"),
    [
        pytest.param(["X-1. F0.1", "X20. F0.5"], [0], id="a facing pass and back"),
        pytest.param(["Z-10. F0.1", "Z-4.", "Z-20."], [0, 2], id="back a part of the way"),
        pytest.param(["Z-10. F0.1", "X30. Z-10.", "X20.", "Z2."], [0, 1], id="back round a corner"),
        pytest.param(["Z-10. F0.1", "Z5."], [0, 1], id="back beyond the start"),
        pytest.param(["Z-10. F0.1", "X20.02 Z2."], [0, 1], id="beside the way"),
    ],
)
@pytest.mark.parametrize("how", ["directive", "profile"])
def test_the_way_back_through_air(moves: list[str], vibrated: list[int], how: str) -> None:
    cuts = "".join(f"G1 {move}\n" for move in moves)
    program = f"{HEAD}{'(VIB N1.5)' if how == 'directive' else ''}\n{cuts}M30\n"
    sets = ("vibration.ramp_vibrations=0", "vibration.end_revolutions=0")
    result = result_of(program, *sets, *(PROFILE if how == "profile" else ()))
    lines = [line for cut in result.cuts for line in range(cut.plan.chain.first, cut.plan.chain.last)]
    assert lines == [3 + n for n in vibrated]
    assert not any(left.is_cut for left in result.left)
    every = result_of(program, "vibration.air=vibrate", *sets, *(PROFILE if how == "profile" else ()))
    assert sum(cut.plan.chain.last - cut.plan.chain.first for cut in every.cuts) == len(moves)


def test_no_speed_is_changed_for_the_way_back() -> None:
    program = f"{HEAD}G1 Z-30. F0.05\nG1 Z2. F1.\nG0 X18.\nG1 Z-30. F0.05\nG1 Z2. F1.\nG0 X40.\nM30\n"
    out = filtered(program, "generic-lathe", *PROFILE)
    speeds = [line for line in out.splitlines() if line.startswith("S")]
    assert speeds == ["S2500", "S3000"]


# --- what is said of it -----------------------------------------------------------------------------------

MIXED = f"{HEAD}G1 Z-30. F0.05\nG1 Z2.\nG41\nG1 Z-30.\nX24.\nG40\nG0 X20. Z2.\nG1 Z-30. F0.05\nM30\n"


def test_explain_lists_what_stays() -> None:
    settings = chipbreak.load("generic-lathe", PROFILE)
    report = chipbreak.explain(chipbreak.rewrite(MIXED.encode(), settings), settings)
    left = report.as_dict()["left"]
    assert [(one["code"], one["first_line"], one["last_line"], one["is_cut"]) for one in left] == [
        ("", 4, 4, False),
        ("VIB040", 6, 7, True),
    ]
    assert {one["asked_by"] for one in left} == {"profile"}
    text = str(report)
    assert "Left as they were: 2" in text
    assert "lines 6 to 7: G1 Z-30." in text
    assert "because  VIB040, tool nose or cutter compensation (G41, G42) is active" in text


@pytest.mark.parametrize(
    ("program", "sets", "line"),
    [
        pytest.param(
            MIXED,
            PROFILE,
            "2 cuts vibrate, unproven: all would break on a control that follows the blocks exactly;"
            " 1 left as it was; cycle 0:53.2 -> 0:58.3 "
            "(assumed: rapids 10 m/min, 1 s a rapid where a place is unknown);"
            " profile names no axis data",
            id="all of it",
        ),
        pytest.param(
            MIXED,
            (*PROFILE, "axes.Z.max_acceleration_mm_s2=50000"),
            "2 cuts vibrate, unproven: all would break on a control that follows the blocks exactly;"
            " 1 left as it was; cycle 0:53.2 -> 0:58.3 "
            "(assumed: rapids 10 m/min, 1 s a rapid where a place is unknown)",
            id="with axis data",
        ),
        pytest.param(f"{HEAD}M30\n", PROFILE, "no cut vibrates: nothing asks for it", id="nothing"),
    ],
)
def test_the_summary(program: str, sets: tuple[str, ...], line: str) -> None:
    settings = chipbreak.load("generic-lathe", sets)
    report = chipbreak.explain(chipbreak.rewrite(program.encode(), settings), settings)
    assert report.summary() == line
