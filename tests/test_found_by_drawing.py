"""Programs and profiles that nobody would write, and which ended in a fault of ours once."""

from __future__ import annotations

import pytest

import chipbreak

CUT = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z-3. F0.05 N1.5\nG0 X30.\nM30\n"


def outcome(program: str, profile: str, *sets: str) -> list[tuple[str, int]]:
    """The errors of a program, code and line; none where there is an output."""
    try:
        chipbreak.rewrite(program.encode(), chipbreak.load(profile, sets))
    except chipbreak.ProgramRejectedError as error:
        every = [d for d in error.diagnostics if d.severity.value == "error"]
        return [(d.code, d.place.line if d.place else 0) for d in every]
    return []


@pytest.mark.parametrize("call", ["G65", "G65 P9000", "G66", "G66 P9000"])
def test_v_and_d_of_a_macro_are_its_arguments(call: str) -> None:
    """No speed of the spindle, also where P is missing."""
    program = f"G97 S3000 M3\nG0 X20. Z2.\n{call} V12. D20.\nG67\nM30\n".encode()
    assert chipbreak.rewrite(program, chipbreak.load("fanuc-lathe")).data == program
    assert outcome(program.decode().replace(call, "G97"), "fanuc-lathe") == []


def test_a_limit_of_zero() -> None:
    """Under G96 the spindle then stands."""
    for last in ("G1 Z-14. F0.05 N1.5", "G1 X30. Z-3. F0.05 N1.5"):
        found = outcome(f"G50 S0\nG96 S120 M3\nG0 X20. Z2.\n{last}\nM30\n", "haas-lathe")
        assert found == [("VIB054", 4)]


@pytest.mark.parametrize("key", ["axes.Z.acc_dec_ms", "vibration.end_revolutions"])
@pytest.mark.parametrize("tiny", ["1e-300", "1e-12"])
def test_numbers_next_to_nothing(key: str, tiny: str) -> None:
    """They are as good as none."""
    laws = ["planner.model=after-interpolation", "axes.Z.position_gain_1_s=200", "axes.Z.acc_dec_ms=0"]
    settings = chipbreak.load("generic-lathe", [*laws, f"{key}={tiny}"])
    none = chipbreak.load("generic-lathe", [*laws, f"{key}=0"])
    one, other = (chipbreak.rewrite(CUT.encode(), each, allow_unbroken=True) for each in (settings, none))
    assert one.data.partition(b"\n")[2].count(b"\n") == other.data.partition(b"\n")[2].count(b"\n")
    assert one.cuts[0].verdict == other.cuts[0].verdict


def contour(block: str) -> str:
    """A roughing cycle with one block of its contour."""
    return (
        "G97 S1200 M3\nG0 X52. Z2.\nG71 U2. R0.5\nG71 P10 Q20 U0.4 F0.3\n"
        f"N10 G0 X16.\nG1 Z-15.\n{block}\nX26. Z-34.\nN20 X52.\nM30\n"
    )


@pytest.mark.parametrize("block", ["X20. G940. Z-30.", "G940. X20. Z-30."])
def test_a_point_beside_an_unknown_code(block: str) -> None:
    """It was passed over, and the contour went on without it."""
    assert outcome("(VIB N1.5)\n" + contour(block), "fanuc-lathe") == [("CYC002", 5)]
    last = contour("X20. Z-30.").replace(
        "N20 X52.", f"N20 {block.replace('X20.', 'X52.').replace('Z-30.', 'Z-40.')}"
    )
    assert outcome("(VIB N1.5)\n" + last, "fanuc-lathe") == [("CYC002", 5)]
    assert outcome("(VIB N1.5)\n" + contour("X20. Z-30."), "fanuc-lathe") == []


def test_a_corner_of_a_rapid() -> None:
    """The control has corners between feeds alone: nothing is drawn, and no cut begins there."""
    program = "G97 S1200 M3\nG0 X32. Z1.\nG0 X25. {}\nG1 Z-12. F0.1 N1.5\nG0 X40.\nM30\n"
    assert outcome(program.format(",R1."), "fanuc-lathe") == [("VIB051", 4)]
    assert outcome(program.format(""), "fanuc-lathe") == []


def test_a_point_beside_an_unknown_code_in_a_subroutine() -> None:
    """The lines beside it were along each other, and met nowhere."""
    program = (
        "G7 G18 G21 G40 G90 G97\no100 sub\nG0 X8. Z1.\nG1 Z-6.\n{}\nX15. Z-9.\nZ-12.\nX22.\no100 endsub\n"
        "T1 M6\nG43\nS800 M3\nG95 F0.15\nG0 X22. Z1.\n(VIB N1.5 Q1.3)\n"
        "G71 Q100 I2. R0.3 D0.2\n(VIB OFF)\nG0 X30.\nM2\n"
    )
    assert outcome(program.format("X1G12."), "linuxcnc-lathe") == [("CYC002", 16)]
    assert "CYC002" not in dict(outcome(program.format("X12."), "linuxcnc-lathe"))


@pytest.mark.parametrize("move", ["G3 X62.4 Z3.8 R1.2", "G1 X62.4"])
def test_a_stroke_just_as_long_as_the_tool_advances_in_it(move: str) -> None:
    """Q1 with N0.5: what is left to go back was a rounding, and no feed runs it."""
    cut = f"G97 S750 M3\nG95\nG0 X60. Y0. Z5.\n(VIB WAVE SINE N0.5)\nQ1. {move} F0.1\nM30\n"
    sets = ("spindle.max_rpm=500", "output.form=expanded", "checks.enabled=false")
    assert outcome(cut, "fanuc-mill", *sets) == [("VIB006", 5)]
