"""A cut that ends in an arc ends in G1: what comes behind it must say what it is, drilling cycles or not."""

from __future__ import annotations

import pytest

import chipbreak
from machine_reader import filtered, rejected

HEAD = "G21 G97 S1000 M3\nG99\nG0 X30. Z0.\n"
ARC = "G2 X42. Z-6. R6. F0.2 N1.5\n"
DRILLED = "G83 Z-18. R-4. Q5. F0.1\nG80\n"
PROFILES = ["fanuc-lathe", "haas-lathe", "mitsubishi-lathe"]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("behind", ["G1 X50. F0.2\n", "G2 X54. Z-12. R6. F0.2\n", "G1\nX50. F0.2\n"])
def test_a_code_behind_the_cycle_settles_it(profile: str, behind: str) -> None:
    program = HEAD + ARC + DRILLED + behind + "G0 X80.\nM30\n"
    text = filtered(program, profile, allow_unbroken=True)
    assert "CHIPBREAK BEGIN VIB" in text
    assert chipbreak.restore(text.encode()).decode() == program


@pytest.mark.parametrize("profile", PROFILES)
def test_behind_the_end_of_a_cycle_the_arc_would_go_on(profile: str) -> None:
    """G80 gives back what was in force before G83: an arc for the program, a line behind the cut."""
    program = HEAD + ARC + DRILLED + "X54. Z-12. R6. F0.2\nG0 X80.\nM30\n"
    assert [(code, line) for code, line, _ in rejected(program, profile)] == [("VIB056", 4)]


def test_where_g80_ends_all_motion_the_cycle_settles_it() -> None:
    """On LinuxCNC nothing is in force behind it."""
    drilled = "G17\nG81 Z-18. R-4. F0.1\nG80\nG18\nM2\n"
    program = "G7 G18 G97 S1000 M3\nG95\nG0 X30. Z0.\n" + ARC.replace("F0.2", "F0.05") + drilled
    sets = (f"axes.{axis}.max_acceleration_mm_s2=20000" for axis in "XZ")
    text = filtered(program, "linuxcnc-lathe", *sets, allow_unbroken=True)
    assert "CHIPBREAK BEGIN VIB" in text


def test_corners_right_behind_a_cycle_behind_an_arc_are_drawn() -> None:
    """The blocks of the cycle leave G0 where the program has G2; the block with the corner says G1 itself."""
    program = (
        "G97 S1000 M3\nG99\nG0 X30. Z5.\nG2 X31. Z4.5 R0.5 F0.2\n"
        "G71 U0.5 R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2 N1.5\n"
        "N10 G0 X21.\nG1 Z-0.4 F0.2\nZ-5.4\nN20 X31.\n"
        "G70 P10 Q20\nG1 Z3.5 F0.2 N1.5 ,R0.5\nX33. Z2.5\nG1 Z1.5\nG0 X80.\nM30\n"
    )
    text = filtered(
        program, "fanuc-lathe", "cycles.unroll=always", "vibration.refused=leave", allow_unbroken=True
    )
    assert text.count("UNROLLED CORNERS") == 1
    assert text.count("UNROLLED G7") == 2
    assert chipbreak.restore(text.encode()).decode() == program
