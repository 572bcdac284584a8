"""Controls that stop at what they do not know: what is refused, what passes, what is said of settings."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.text.diagnostics import SelfCheckError
from chipbreak.vibration import cut_edit

HEAD = {"grbl": b"G21 G90 G94\n", "grblhal-lathe": b"G21 G90 G94\n", "klipper": b"G21\nG90\n"}


def refused(profile: str, line: bytes) -> str:
    """What is said of the line; empty where it passes."""
    try:
        chipbreak.rewrite(HEAD[profile] + line + b"\n", chipbreak.load(profile))
    except chipbreak.ProgramRejectedError as error:
        (one,) = (one for one in error.diagnostics if one.severity.value == "error")
        assert (one.code, one.place and one.place.line) == ("MOD010", HEAD[profile].count(b"\n") + 1)
        assert one.help
        return one.message
    return ""


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"G64", "refuses G64"),
        (b"G61.1", "refuses G61.1"),
        (b"G41 D1", "refuses G41"),
        (b"G1 U-0.5 F100", "the letter of U-0.5"),
        (b"G0 W5.", "the letter of W5."),
        (b"O1234", "the letter of O1234"),
        (b"O100 SUB", "O100 SUB"),
        (b":1234", ":1234"),
        (b"/2 G0 X5.", "/2"),
        (b"#1=5", "#1=5"),
        (b"G0 X#1", "X#1"),
        (b"G0 X[1+1]", "no number"),
        (b"IF [#1 EQ 0] GOTO 5", "refuses IF"),
        (b"G0 X5 (WAS (A) G1 X9.)", "the control acts on G1 X9"),
        (b"(CHECK!)", "obeys '!'"),
        (b"(A~B)", "obeys '~'"),
        (b"(\xc4)", "byte 0xC4"),
        (b"(" + b"A" * 260 + b")", "line of 262"),
        (b"G0 X5..", "refuses this line"),
    ],
)
@pytest.mark.parametrize("profile", ["grbl", "grblhal-lathe"])
def test_what_both_refuse(profile: str, line: bytes, said: str) -> None:
    found = refused(profile, line)
    if profile == "grbl" and said.startswith("line of"):
        assert not found  # a comment does not get into its buffer
    else:
        assert said in found


@pytest.mark.parametrize(
    "line",
    [
        *(code.encode() for code in ["G95", "G97", "G7", "G8", "G98", "G99", "M6", "M70", "M72", "%"]),
        b"G96 S100",
        b"G33 Z-5. K1.",
        b"G1 "
        + b" ".join(letter + b"1.0000000" for letter in (b"X", b"Y", b"Z", b"I", b"J", b"K", b"F", b"R")),
    ],
)
def test_what_grbl_refuses_and_grblhal_takes(line: bytes) -> None:
    assert refused("grbl", line)
    if line not in (b"M70", b"M72"):
        assert not refused("grblhal-lathe", line)


@pytest.mark.parametrize(
    "line",
    [b"G1 X5. F100 (PLAIN)", b"/G0 X5.", b"G4 P0.5", b"$H", b"$X", b"T3", b"S500 M4", b"G38.2 Z-5 F50"],
)
@pytest.mark.parametrize("profile", ["grbl", "grblhal-lathe"])
def test_what_both_take(profile: str, line: bytes) -> None:
    assert not refused(profile, line)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"X5.", "without a code in front"),
        (b"S500 M3", "without a code in front"),
        (b"G90 G1 X5.", "G1 behind another code"),
        (b"G95", "refuses G95"),
        (b"G1 W5", "the letter of W5"),
    ],
)
def test_what_klipper_does_not_obey(line: bytes, said: str) -> None:
    assert said in refused("klipper", line)


@pytest.mark.parametrize(
    "line", [b"G1 X5. F100", b"M3 S500", b"SET_VELOCITY_LIMIT ACCEL=500", b"; (A!)", b"T0"]
)
def test_what_klipper_takes(line: bytes) -> None:
    assert not refused("klipper", line)


def test_a_wrong_letter_in_plain_moves_is_found() -> None:
    plain = b"".join(b"G1 X%d. F100\n" % n for n in range(40))
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(b"G21\n" + plain + b"U7.\n", chipbreak.load("grbl"))
    assert [one.place.line for one in caught.value.diagnostics if one.place] == [42]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"$11=0.02", "has 0.01 (planner.junction_deviation_mm)"),
        (b"$120=500", "does not say it (axes.X.max_acceleration_mm_s2)"),
        (b"$112=3000.000", ""),
        (b"$102=400", "has 250"),
        (b"$398=35", "has 100 (planner.look_ahead_blocks)"),
        (b"$32=1", ""),
    ],
)
def test_settings_in_the_program_are_compared_with_the_profile(line: bytes, said: str) -> None:
    profile = chipbreak.load("grblhal-lathe", ["axes.Z.steps_per_mm=250", "axes.Z.max_velocity_mm_min=3000"])
    found = [one for one in chipbreak.rewrite(line + b"\nM30\n", profile).diagnostics if one.code == "MOD011"]
    assert [said in one.message for one in found] == ([True] if said else [])


def test_what_is_written_is_looked_at_too(monkeypatch: pytest.MonkeyPatch) -> None:
    program = b"G21 G90 G94\nS3000 M3\nG0 X10. Z2.\nG1 Z-20. F150. N1.5\nG0 X30.\nM30\n"
    profile = chipbreak.load("grbl", ["axes.Z.max_acceleration_mm_s2=9000"])
    chipbreak.rewrite(program, profile)  # what is imported while it is changed would keep the change
    monkeypatch.setattr(cut_edit, "settling", lambda settings: ["G97"])
    with pytest.raises(SelfCheckError, match="refuses G97, and it stands in a new block"):
        chipbreak.rewrite(program, profile)
