"""Where spindle speeds are commanded, and V and D as a peripheral speed."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from machine_reader import filtered, rejected, run_program

HEAD = "G97 S3000 M3\nG0 X20. Z2.\n"
CUT = "G1 Z-10. F0.05 N1.5\nG0 Z2.\n"


def commands(program: str, *sets: str) -> list[str]:
    """Every line of the output that says S, without the lines of the original that were kept in comments."""
    lines = re.sub(r"\([^)]*\)", "", filtered(program, "generic-lathe", *sets)).splitlines()
    return [line.strip() for line in lines if "S" in line]


# --- time to settle ---------------------------------------------------------------------------------------


def test_the_spindle_may_settle_wherever_its_speed_is_changed() -> None:
    program = HEAD + CUT + CUT + "G33 Z-20. F1.\n" + CUT + "M30\n"
    out = filtered(program, "generic-lathe", "spindle.settle_s=0.8")
    lines = re.sub(r"\([^)]*\)\n", "", out).splitlines()
    dwells = [i for i, line in enumerate(lines) if line.startswith("G4")]
    assert [lines[i - 1 : i + 1] for i in dwells] == [
        ["S2500", "G4 X0.8"],
        ["S3000", "G4 X0.8"],  # before the thread
        ["S2500", "G4 X0.8"],
    ]
    assert lines[-2:] == ["S3000", "M30"]


@pytest.mark.parametrize(
    ("profile", "letter"), [("haas-mill", "P"), ("fanuc-mill", "X"), ("linuxcnc-mill", "P")]
)
def test_a_dwell_has_the_letter_of_its_control(profile: str, letter: str) -> None:
    program = "G90 G97 G95 G21 S3000 M3\nG0 X0. Y0. Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    sets = ("spindle.settle_s=2", "vibration.end=dwell", "checks.enabled=false", "planner.model=ideal")
    dwells = [line for line in filtered(program, profile, *sets).split("\n") if line.startswith("G4 ")]
    assert dwells == [f"G4 {letter}2.", f"G4 {letter}0.024"]


# --- one change where one will do -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        pytest.param(CUT * 3 + "M30", ["S2500", "S3000"], id="a run of cuts shares one change"),
        pytest.param(CUT + "G1 X30. F0.1\n" + CUT + "M30", ["S2500", "S3000"] * 2, id="back for a plain cut"),
        pytest.param(CUT + "G33 Z-10. F1.\nM30", ["S2500", "S3000"], id="back for a thread"),
        pytest.param(CUT + "G83 Z-10. F0.1\nM30", ["S2500", "S3000"], id="back for a cycle"),
        pytest.param(CUT + "M98 P100\nM30", ["S2500", "S3000"], id="back for a subprogram"),
        pytest.param(CUT + "G65 P9100\nM30", ["S2500", "S3000"], id="back for a macro"),
        pytest.param(CUT + "M5\nM3\nM30", ["S2500", "S3000"], id="back for a spindle start"),
        pytest.param(CUT + "M99", ["S2500", "S3000"], id="back at the end of a subprogram"),
        pytest.param(CUT + "WHILE[#1 LT 3]DO1\nEND1\nM30", ["S2500", "S3000"], id="back for a loop"),
        pytest.param(
            CUT + "S1000\nG1 X30. F0.1\nM30", ["S2500", "S1000"], id="the program's own S is enough"
        ),
        pytest.param(CUT + "M3 S1000\nG1 X30. F0.1\nM30", ["S2500", "M3 S1000"], id="also with M3"),
        pytest.param(CUT + "G96 S120\nG1 X30. F0.1\nM30", ["S2500", "G96 S120"], id="also with G96"),
        pytest.param(CUT.replace("1.5", "2.5") + CUT + "M30", ["S1500", "S2500", "S3000"], id="two speeds"),
        pytest.param(
            CUT.replace("N", "S2500 N") + "G1 X30. F0.1\nM30", ["S2500"], id="S in the block, right"
        ),
        pytest.param(CUT.replace("N", "S2000 N") + "M30", ["S2000"], id="S in the block, f 50"),
        pytest.param(
            CUT.replace("N", "S2400 N") + "G1 X30. F0.1\nM30",
            ["S2500", "S2400"],
            id="S in the block, corrected, comes back as written there",
        ),
        pytest.param(CUT + "M5", ["S2500"], id="nothing needs it any more"),
        pytest.param(
            CUT + "M8\nG4 X1.\nT0101\n(X)\nG28 U0.\nM5\nM30", ["S2500", "S3000"], id="not for these"
        ),
    ],
)
def test_speed_commands(lines: str, said: list[str]) -> None:
    assert commands(f"{HEAD}{lines}\n") == ["G97 S3000 M3", *said]


def test_the_speed_is_back_before_a_block_that_is_jumped_to() -> None:
    program = f"{HEAD}{CUT}N100 G0 X50.\nG1 X60. F0.1\nIF[#1 EQ 1]GOTO100\nM30\n"
    lines = [line for line in filtered(program).splitlines() if not line.startswith("(")]
    assert lines[lines.index("S3000") + 1].startswith("N100"), "who jumps there must not meet S3000 twice"


def test_a_speed_that_needs_no_change_is_not_commanded() -> None:
    assert commands(f"{HEAD}G1 Z-10. F0.05 E2\nM30\n") == ["G97 S3000 M3"]


def test_the_speed_stands_before_the_first_move() -> None:
    lines = filtered(f"{HEAD}{CUT}M30\n").splitlines()
    assert lines.index("S2500") < next(i for i, line in enumerate(lines) if line.startswith("G1 "))


def test_a_spindle_speed_in_the_programs_own_digits_comes_back() -> None:
    assert commands(f"G97 S03000. M3\nG0 X20. Z2.\n{CUT}M30\n")[-1] == "S03000."


# --- constant surface speed -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("head", "rpm_at_start"),
    [
        pytest.param("G96 S120 M3\nG0 X20. Z2.\n", 1910, id="no clamp"),
        pytest.param("G50 S1000\nG96 S120 M3\nG0 X20. Z2.\n", 1000, id="clamped by G50"),
        pytest.param("G92 S1000\nG96 S120 M3\nG0 X20. Z2.\n", 1000, id="clamped by G92"),
        pytest.param("G50 S3000\nG96 S120 M3\nG0 X0. Z2.\n", 3000, id="on the axis the clamp holds"),
        pytest.param("G20 G96 S400 M3\nG0 X1. Z.1\n", 1528, id="feet per minute"),
    ],
)
def test_surface_speed_becomes_rpm_at_the_start_diameter(head: str, rpm_at_start: int) -> None:
    cut = "G1 Z-.4 F.002 N1.5\n" if head.startswith("G20") else CUT
    settings = chipbreak.load("generic-lathe", ("vibration.correct=count",))
    result = chipbreak.rewrite(f"{head}{cut}G1 X30.\nM30\n".encode(), settings)
    text = result.data.decode()
    assert f"{rpm_at_start} rpm" in result.cuts[0].plan.reasons[0]
    spoken = re.findall(r"(?m)^G97 S([0-9.]+)", text)
    assert float(spoken[0]) == pytest.approx(rpm_at_start, abs=1)
    assert re.search(r"(?m)^G96 S(?:120|400)\n", text.split("CHIPBREAK END")[1])


def test_facing_under_g96_runs_in_g97_and_g96_comes_back() -> None:
    run = run_program(
        filtered("G50 S3500\nG96 S180 M3\nG0 X50. Z0.\nG1 X1. F0.1 N1.5\nG0 Z2.\nG1 X20.\nM30\n")
    )
    (cut,) = run.cuts
    speeds = [move.speed_rpm for move in cut]
    assert speeds == sorted(speeds)
    assert len(set(speeds)) > 4, "the speed follows the diameter in steps"
    assert speeds[-1] <= 3500.0
    assert run.state.speed_mode == 96
    assert run.moves[-1].speed_rpm == 180.0, "m/min again"


def test_a_bare_s_behind_a_g96_cut_is_not_taken_for_rpm() -> None:
    lines = filtered(
        "G50 S3000\nG96 S120 M3\nG0 X20. Z2.\nG1 Z-5. F0.05 N1.5\nS150\nG1 X30.\nM30\n"
    ).splitlines()
    assert lines.index("G96 S120") < lines.index("S150")


@pytest.mark.parametrize("cut", ["G1 Z-9.", "(VIB OFF)\nG1 X30."])
def test_g96_again_without_s_finds_the_surface_speed(cut: str) -> None:
    """It takes the S in force, and the rpm of the cut before it would be metres per minute."""
    program = f"G99\nG96 S100 M3\nG0 X20. Z2.\n(VIB N1.5)\nG1 Z-5. F0.05\nG96\n{cut}\nG0 X80.\nM30\n"
    lines = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe")).data.decode().splitlines()
    at = lines.index("G96")
    speeds = [line for line in lines[:at] if "S" in line.split("(")[0]]
    assert speeds[-2:] == ["G97 S1667", "G96 S100"]


def test_g96_in_the_block_itself_never_meets_the_rpm_before_it() -> None:
    out = filtered(f"{HEAD}G96 G1 Z-10. S120 F0.05 N1.5\nG1 X30.\nM30\n")
    code = re.sub(r"\([^)]*\)", "", out)
    assert re.findall(r"G96.*", code) == ["G96 S120"], "G96 without its S would take 3000 for m/min"


@pytest.mark.parametrize(
    ("program", "code"),
    [
        ("G50 S2400\n" + HEAD + CUT, "VIB006"),
        ("G92 S2400\n" + HEAD + CUT, "VIB006"),
        (HEAD + CUT.replace("N1.5", "N1.5 f62.5").replace("G1", "G50 S2400\nG1"), "VIB006"),
    ],
)
def test_a_clamp_is_never_crossed(program: str, code: str) -> None:
    assert [found for found, *_ in rejected(program + "M30\n")] == [code]


@pytest.mark.parametrize(("profile", "program"), [(2400, 3000), (3000, 2400)])
def test_the_lower_of_two_limits_holds(profile: int, program: int) -> None:
    text = f"G50 S{program}\n{HEAD}{CUT}M30\n"
    assert rejected(text, "generic-lathe", f"spindle.max_rpm={profile}") == [("VIB006", 4, 16)]


def test_the_clamp_itself_is_allowed() -> None:
    assert "S2500" in filtered("G50 S2500\n" + HEAD + CUT + "M30\n")


def test_the_clamp_of_linuxcnc_stands_with_g96() -> None:
    program = "G7 G95 G96 D1500 S120 M3\nG0 X20. Z2.\nG1 Z-10. F0.05 E2\nM2\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-lathe"))
    assert "1500 rpm" in result.cuts[0].plan.reasons[0]
    # G96 without D would let the spindle run as fast as it can.
    assert result.data.decode().splitlines()[-3] == "G96 D1500 S120"


# --- V and D ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "new"),
    [
        ("G97 V120. D20. M3", "G97 S1910 M3"),
        ("G97 D20. V120. M3", "G97 S1910 M3"),
        ("N10 G97V120.D20.M3 (GO)", "N10 G97S1910M3 (GO)"),
        ("V120 D20", "S1910"),
        ("g97 v120. d20. m3", "g97 S1910 m3"),
        ("G97 V120. M3 D20.", "G97 S1910 M3"),
    ],
)
def test_peripheral_speed_words(line: str, new: str) -> None:
    lines = filtered(f"{line}\nM30\n").splitlines()
    assert new in lines
    assert sum("S1910" in text and "CHIPBREAK" not in text for text in lines) == 1


def test_peripheral_speed_directive() -> None:
    lines = filtered("G97\n(SPEED V120 D20)\nM3\nM30\n").splitlines()
    assert lines.index("(SPEED V120 D20)") < lines.index("S1910") < lines.index("M3")
    lines = filtered("G97 M3 (SPEED V120 D20)\nM30\n").splitlines()
    assert lines.index("S1910") < lines.index("G97 M3 (SPEED V120 D20)"), "before the spindle starts"


@given(v=st.floats(20.0, 900.0), d=st.floats(0.5, 900.0), resolution=st.sampled_from(["1", "0.1", "10"]))
def test_peripheral_speed_formula(v: float, d: float, resolution: str) -> None:
    out = filtered(
        f"G97 V{v:.3f} D{d:.3f} M3\nM30\n", "generic-lathe", f"spindle.resolution_rpm={resolution}"
    )
    (speed,) = re.findall(r"(?m)^G97 S([0-9.]+) M3$", out)
    wanted = 1000.0 * float(f"{v:.3f}") / (math.pi * float(f"{d:.3f}"))
    assert abs(float(speed) - wanted) <= float(resolution) / 2 + 1e-6


def test_a_cut_counts_with_the_peripheral_speed() -> None:
    run = run_program(filtered("G97 V188.5 D20. M3\nG0 X20. Z2.\nG1 Z-10. F0.05 N1.5\nG1 X30.\nM30\n"))
    assert run.cuts[0][-1].speed_rpm == 2500.0
    assert run.moves[-1].speed_rpm == 3000.0


@pytest.mark.parametrize(
    ("line", "profile"),
    [
        ("G65 P9100 V12. D20.", "fanuc-lathe"),
        ("G65 P9100 D20.", "fanuc-lathe"),
        ("G28 U0 V0", "fanuc-lathe"),
        ("G0 V5.", "fanuc-lathe"),
        ("G41 D1", "fanuc-mill"),
        ("G41 D1 X5. Y5. F100.", "fanuc-mill"),
        ("G43 H1 D1", "fanuc-mill"),
        ("G96 D2500 S200 M3", "linuxcnc-lathe"),
        ("G97 S1000 D5 M3", "generic-lathe"),
        ("G10 L12 P1 R5. D2.", "fanuc-mill"),
        ("(SPEED V120 D20 RPM)", "generic-lathe"),
        ("(CUTTING SPEED V120 D20)", "generic-lathe"),
        ("(SPEED: V120, D20)", "generic-lathe"),
        ("(SPEED AND FEED)", "generic-lathe"),
        ("V12.", "generic-lathe"),
    ],
)
def test_v_and_d_that_are_not_ours(line: str, profile: str) -> None:
    program = f"{line}\nM30\n"
    assert filtered(program, profile) == program


# --- what reads the speed -----------------------------------------------------------------------------------

READING = {
    "fanuc-lathe": ["#500=#4119", "#500=#[#1+2]", "G4 X[#4119/1000]", "#1=#4002"],
    "linuxcnc-lathe": ["#5=#<_rpm>", "#5=#<_RPM>", "G4 P[#<_rpm>/1000]", "M70", "M73", "#5=#[#6]"],
}


@pytest.mark.parametrize(("profile", "block"), [(p, block) for p in READING for block in READING[p]])
def test_a_block_that_works_with_the_speed_finds_the_programmed_one(profile: str, block: str) -> None:
    cut = "G95 G97 S2000 M3\nG0 X20. Z2.\n(VIB N1.5 F62.5)\nG1 Z-3. F0.1\n(VIB OFF)\n"
    settings = chipbreak.load(profile, ['planner.model="ideal"'])
    output = chipbreak.rewrite(f"{cut}{block}\nG0 X30.\nS900\nM30\n".encode(), settings).data.decode()
    speeds = [line for line in output[: output.index(f"\n{block}\n")].split("\n") if line.startswith("S")]
    assert speeds == ["S2500", "S2000"]
    plain = chipbreak.rewrite(f"{cut}#5=7\nG0 X30.\nS900\nM30\n".encode(), settings).data.decode()
    assert "S2000\n" not in plain.split("\n", 1)[1], "the program says a speed before anything needs one"


# --- constant surface speed in both directions --------------------------------------------------------------


def surface_warnings(program: str) -> list[str]:
    result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe"))
    return [d.message for d in result.diagnostics if d.code == "VIB064"]


def test_outwards_on_an_arc_the_speed_of_the_start_may_be_far_too_high() -> None:
    head = "G50 S2000\nG96 S120 M3\n"
    arc = "G0 X0. Z0.\nG3 X60. Z-30. R30. F0.1 N1.5\nG0 Z5.\nM30\n"
    (warning,) = surface_warnings(head + arc)
    assert "G96 S120 runs as S2000: at diameter 60 mm that is 377 m/min" in warning
    assert not surface_warnings(f"{head}G0 X0. Z0.\nG1 X60. F0.1 N1.5\nG0 Z5.\nM30\n"), "a line in steps"
    assert not surface_warnings(f"{head}G0 X60. Z0.\nG1 X-1.6 F0.1 N1.5\nG0 Z5.\nM30\n")
    # The ways out: towards the centre (above), N and f with a lower S, a lower clamp.
    assert not surface_warnings(head + arc.replace("N1.5", "N1.5 f15.625"))
    assert not surface_warnings(head.replace("2000", "600") + arc)


def test_a_loop_that_says_its_speed_itself_is_left_with_it_too() -> None:
    turn = f"WHILE[#1LT2]DO1\n#1=#1+1\nS3000\nG0 X20. Z2.\n{CUT}END1\n"
    program = f"{HEAD}#1=0\n{turn}G0 X10.\nG1 Z-5. F0.05\nM30\n"
    lines = filtered(program, "fanuc-lathe", "planner.model=ideal").splitlines()
    behind = lines[lines.index("G0 Z2.") + 1 : lines.index("END1")]
    assert [line for line in behind if not line.startswith("(")] == ["S3000"]


@pytest.mark.parametrize("block", ["G92 V120. D20. M3", "G50 V120. D20.", "G50 (SPEED V120 D20)"])
def test_v_and_d_become_no_limit_of_the_spindle(block: str) -> None:
    assert [code for code, _, _ in rejected(f"{HEAD}{block}\n")] == ["VIB070"]


def test_a_line_that_is_too_long_already_may_be_rewritten() -> None:
    line = "G97 V120. D20. M3 (" + "X" * 90 + ")"
    lines = filtered(f"{line}\nM30\n", "speedio-blum").splitlines()
    assert line.replace("V120. D20.", "S1910") in lines
