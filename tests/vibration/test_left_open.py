"""What block delete may skip, and what another way may bring otherwise, is not taken for granted."""

from __future__ import annotations

import math

import pytest

import chipbreak
from chipbreak.model import arrivals
from chipbreak.model.interpreted_program import interpret
from chipbreak.syntax.parse import parse
from chipbreak.text.source import read

HEAD = "G21 G18 G40 G99\nT0101\nG97 S2000 M3\nG0 X30. Z5.\n"
# Says its F and S; or takes those in force.
CUT = "G0 X28. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1 S2000\n(VIB OFF)\nG0 X40.\nM30\n"
BARE_CUT = "G0 X28. Z5.\n(VIB N1.5)\nG1 Z-5.\n(VIB OFF)\nG0 X40.\nM30\n"
SETS = ("checks.enabled=false", "vibration.refused=leave", "planner.model=ideal")


def filtered(program: str, profile: str = "fanuc-lathe") -> chipbreak.Result:
    settings = chipbreak.load(profile, SETS)
    return chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)


def why_left(program: str, profile: str = "fanuc-lathe") -> list[str]:
    """The codes of the cuts that stay."""
    return [cut.said.code for cut in filtered(program, profile).left]


@pytest.mark.parametrize(
    ("skipped", "again", "code"),
    [
        ("S900", "S900", "VIB053"),
        ("M3 S700", "S700", "VIB053"),
        ("G96 S100", "G97 S900", "VIB050"),
        ("G97 S500", "S500", "VIB053"),
        ("F0.3", "F0.1", "VIB050"),
        ("G1 Z3. F0.3", "F0.1", "VIB050"),
        ("G98", "G99 F0.1", "VIB050"),
        ("G20", "G21 F0.1", "VIB050"),
        ("G17", "G18", "VIB050"),
        ("M4", "M3", "VIB069"),
        ("M5", "M3", "VIB069"),
    ],
)
def test_a_cut_behind_what_may_be_skipped_stays(skipped: str, again: str, code: str) -> None:
    assert why_left(f"{HEAD}F0.1\n/{skipped}\n{BARE_CUT}") == [code]
    assert why_left(f"{HEAD}F0.1\n/{skipped}\n{again}\n{BARE_CUT}") == []


@pytest.mark.parametrize("line", ["S2000", "F0.1", "G99", "M3", "M8", "M1", "G4 X1.", "G54", "G21"])
def test_what_is_the_same_skipped_or_not_stays_known(line: str) -> None:
    assert why_left(f"{HEAD}F0.1\n/{line}\nG0 X28. Z5.\n(VIB N1.5)\nG1 Z-5.\n(VIB OFF)\nM30\n") == []


@pytest.mark.parametrize("line", ["S2000", "S900", "G96 S100", "G97", "M3 S700", "M5"])
def test_the_programmed_speed_is_back_before_one_that_may_be_skipped(line: str) -> None:
    cut = "(VIB N1.5 F62.5)\nG1 Z-5. F0.1\n(VIB OFF)\n"
    lines = filtered(f"{HEAD}{cut}/{line}\nG0 X40.\nG1 X41. F0.2\nM30\n").data.decode().splitlines()
    at = lines.index(f"/{line}")
    assert lines[at - 3 : at] == ["(CHIPBREAK BEGIN SPEED AS PROGRAMMED)", "S2000", lines[at - 1]]


def test_a_speed_that_may_be_skipped_is_given_back_to_nobody() -> None:
    program = f"{HEAD}/S900\n(VIB N1.5 F62.5)\nG1 Z-5. F0.1\n(VIB OFF)\nG0 X40.\nG1 X41. F0.2\nM30\n"
    assert why_left(program) == ["VIB057"]


@pytest.mark.parametrize(
    ("part", "again"),
    [
        ("o10 if [#1 EQ 1]\nG20\no10 endif\n", "G21"),
        ("o10 if [#1 EQ 1]\nG94\no10 else\nG95\no10 endif\n", "G95"),
        ("o10 if [#1 EQ 1]\nG8\no10 endif\n", "G7"),
        ("o10 while [#1 LT 3]\nG61\no10 endwhile\n", "G64"),
        ("o10 if [#1 EQ 1]\nG64 P0.01\no10 endif\n", "G64"),
        ("o10 if [#1 EQ 1]\nG64 P0.01\no10 else\nG64 P0.02\no10 endif\n", "G64"),
        ("o10 repeat [3]\nG64\nG64 P0.01\no10 continue\nG64\no10 endrepeat\n", "G64"),
        ("o10 sub\nG61\no10 endsub\no10 call\n", "G64"),
        ("o10 sub\nG17\no10 endsub\no10 call\n", "G18"),
    ],
)
def test_a_cut_behind_a_branch_that_sets_a_mode_stays(part: str, again: str) -> None:
    """LinuxCNC would read its numbers otherwise, or finds another path mode given back."""
    head = "G21 G18 G7 G40 G95 G64\n"
    cut = "G97 S2000 M3\nG0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\nM2\n"
    assert why_left(f"{head}{part}{cut}", "linuxcnc-lathe") == ["VIB050"]
    assert why_left(f"{head}{part}{again}\n{cut}", "linuxcnc-lathe") == []


@pytest.mark.parametrize(
    ("part", "again", "code"),
    [
        pytest.param("GOTO#1\nG98\nN20", "G99", "VIB050", id="over the mode from above"),
        pytest.param("G98\nGOTO#1\nG99\nN20", "G99", "VIB050", id="with another mode"),
        pytest.param("GOTO#1\nG98\nN10\nGOTO20\nN20", "G99", "VIB050", id="beside a jump to it"),
        pytest.param("GOTO#1\nG20\nN20", "G21", "VIB050", id="units"),
        pytest.param("M98 P7\nG98\nM99 P20\nG99\nN20", "M3\nG99", "VIB050", id="a return that may come"),
    ],
)
def test_a_cut_behind_a_jump_that_is_worked_out_stays(part: str, again: str, code: str) -> None:
    """It says its F and S, which are read by the modes that the jump brings."""
    assert why_left(f"{HEAD}{part}\n{CUT}")[:1] == [code]
    assert why_left(f"{HEAD}{part}\n{again}\n{CUT}") == []


def test_a_jump_that_is_worked_out_brings_what_is_in_force_there() -> None:
    assert why_left(f"{HEAD}F0.1\nGOTO#1\nG4 X1.\nN20\n{BARE_CUT}") == []
    assert why_left(f"{HEAD}F0.1\nGOTO#1\nF0.2\nN20\n{BARE_CUT}") == ["VIB050"]


def test_behind_very_many_places_of_a_jump_the_modes_are_open(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is not followed, what the program says in two ways is not known, and F and S are not."""
    monkeypatch.setattr(arrivals, "_MOST_NUMBERS", 50)
    places = "".join(f"N{number}\n" for number in range(100, 200))
    assert why_left(f"{HEAD}G98\nGOTO#1\nG99\n{places}{CUT}") == ["VIB050"]
    assert why_left(f"{HEAD}GOTO#1\n{places}{CUT}") == []


@pytest.mark.parametrize(
    ("part", "again"),
    [
        ("o10 if [#1 EQ 1]\nG94\nM70\nG95\no10 endif\n", "G95"),
        ("o10 if [#1 EQ 1]\nG94\nM70\nG95\no10 else\nM70\no10 endif\n", "G95"),
        ("o10 while [#1 LT 3]\nG61\nM70\nG64\no10 endwhile\n", "G64"),
        ("o10 if [#1 EQ 1]\nG64 P0.01\nM70\nG64\no10 endif\n", "G64"),
        ("o10 while [#1 LT 3]\nG61\nM70\nG64\no11 endif\n", "G64"),
    ],
)
def test_a_cut_behind_modes_that_were_kept_on_one_way_only_stays(part: str, again: str) -> None:
    """M72 gives back those from before the branch, or those of its arm."""
    head = "G21 G18 G7 G40 G95 G64\nM70\n"
    cut = "G97 S2000 M3\nG0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\nM2\n"
    assert why_left(f"{head}{part}M72\n{cut}", "linuxcnc-lathe") == ["VIB050"]
    assert why_left(f"{head}{part}M72\n{again}\n{cut}", "linuxcnc-lathe") == []
    assert why_left(f"{head}{part}M70\nM72\n{cut}", "linuxcnc-lathe") == _behind_improper_nests(part)


def _behind_improper_nests(part: str) -> list[str]:
    """What is open stays so where any way may come in."""
    return ["VIB050"] if "o11 endif" in part else []


@pytest.mark.parametrize("kept", ["F0.3", "S900", "F0.1 S2000"])
def test_f_and_s_that_were_kept_on_one_way_only(kept: str) -> None:
    """They are known where M72 gives the same back on both ways."""
    head = "G21 G18 G7 G40 G95 G64 G97\nF0.1 S2000 M3\nM70\n"
    part = f"o10 if [#1 EQ 1]\n{kept}\nM70\nF0.1 S2000\no10 endif\nM72\n"
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5.\n(VIB OFF)\nM2\n"
    assert len(why_left(head + part + cut, "linuxcnc-lathe")) == (kept != "F0.1 S2000")


@pytest.mark.parametrize(
    ("part", "codes"),
    [
        ("o10 if [#1 EQ 1]\nM5\no10 endif\n", ["VIB069"]),
        ("o10 if [#1 EQ 1]\nM4\no10 endif\n", ["VIB069"]),
        ("o10 if [#1 EQ 1]\nM5\no10 endif\nM3\n", []),
        ("o10 if [#1 EQ 1]\nM5\nM3\no10 endif\n", []),
        ("o10 while [#1 LT 3]\nM5\no10 endwhile\n", ["VIB069"]),
        ("M70\no10 if [#1 EQ 1]\nM5\nM70\nM3\no10 endif\nM72\n", ["VIB069"]),
        ("M70\no10 if [#1 EQ 1]\nM5\nM70\nM3\no10 endif\nM72\nM3\n", []),
        ("M70\nM5\n/M70\nM3\nM72\n", ["VIB069"]),
    ],
)
def test_a_spindle_that_a_way_brings_otherwise(part: str, codes: list[str]) -> None:
    head = "G21 G18 G7 G40 G95 G97\nF0.1 S2000 M3\n"
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1 S2000\n(VIB OFF)\nM2\n"
    assert why_left(head + part + cut, "linuxcnc-lathe") == codes


def test_the_other_arm_has_the_spindle_from_before_the_branch() -> None:
    head = "G21 G18 G7 G40 G95 G97\nF0.1 S2000 M3\no10 if [#1 EQ 1]\nM5\no10 else\n"
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5.\n(VIB OFF)\no10 endif\nM2\n"
    assert len(filtered(head + cut, "linuxcnc-lathe").cuts) == 1


def test_what_an_arm_kept_first_is_given_back_behind_the_branch() -> None:
    """A way without M70 comes to no M72: that is an error of LinuxCNC."""
    head = "G21 G18 G7 G40 G95 G64 G97\nF0.1 S2000 M3\no10 if [#1 EQ 1]\nM70\no10 endif\n"
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5.\n(VIB OFF)\nM2\n"
    (found,) = filtered(f"{head}G94 F300 M72\n{cut}", "linuxcnc-lathe").cuts
    assert found.plan.wave.feed_mm_rev == pytest.approx(0.1)


def test_a_smoothing_that_a_jump_may_bring_is_not_given_back() -> None:
    """Of one code with other words the ways that are not known may bring either."""
    cut = "G97 S2000 M3\nG0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\nM2\n"
    head = "G21 G18 G7 G40 G95\nG64 P0.1\no10 while [#1 LT 3]\nG64 P0.02\n"
    assert why_left(f"{head}o11 endif\n{cut}", "linuxcnc-lathe") == ["VIB050"]
    assert why_left(f"{head}o11 endif\nG64 P0.02\n{cut}", "linuxcnc-lathe") == []


@pytest.mark.parametrize(
    ("line", "again", "code"),
    [
        ("IF[#1EQ1]THEN G98", "G99 F0.1", "VIB050"),
        ("IF[#1EQ1] F0.3", "F0.1", "VIB050"),
        ("IF[#1EQ1] S900", "S2000", "VIB053"),
        ("IF[#1EQ1] M5", "M3", "VIB069"),
        ("M#1", "M3", "VIB069"),
        ("G98 X[1", "G99 F0.1 S2000", "VIB050"),
        ("G20 ?", "G21 F0.1 S2000", "VIB050"),
        ("G" + "9" * 308, "G99 F0.1 S2000", "VIB050"),
        ("G98 X[" + "9" * 400 + "]", "G99 F0.1 S2000", "VIB050"),
        ("M4 ?", "M3 F0.1 S2000", "VIB069"),
    ],
)
def test_a_cut_behind_what_may_be_said_stays(line: str, again: str, code: str) -> None:
    """Under a condition, worked out by the control, or in a line that nobody here can read."""
    assert why_left(f"{HEAD}F0.1\n{line}\n{BARE_CUT}")[:1] == [code]
    assert why_left(f"{HEAD}F0.1\n{line}\n{again}\n{BARE_CUT}") == []


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("/F0.3", "F0.3 is that of line 6, which block delete may skip"),
        ("IF[#1EQ1] F0.3", "F0.3 is that of line 6, which acts only under its condition"),
    ],
)
def test_why_the_feed_is_not_known(line: str, why: str) -> None:
    (left,) = filtered(f"{HEAD}F0.1\n{line}\n{BARE_CUT}").left
    assert left.said.message == f"the feed is not known: {why}"


def test_a_g_code_that_is_worked_out_may_be_any() -> None:
    cut = "G0 X28. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\nG0 X40.\nM30\n"
    assert why_left(f"{HEAD}G#1\n{cut}") == ["VIB050"]
    assert why_left(f"{HEAD}G21 G18 G40 G99 G97 G#1\n{cut}") == ["VIB050"]
    assert why_left(f"{HEAD}G65 P9 M#1\n{HEAD}{cut}") == []


def test_a_g_code_that_is_worked_out_may_set_another_origin() -> None:
    settings = chipbreak.load("fanuc-lathe", SETS)
    text = f"{HEAD}G#1\n(HERE)\nM30\n".encode()
    program = interpret(parse(read(text, "origin.nc"), settings.dialect), settings)
    assert math.isnan(program.before(6).position.z)


@pytest.mark.parametrize("line", ["SETTING X[1", "IF[#1EQ1]THEN #2=98", "IF[#1EQ1] GOTO 5\nN5"])
def test_what_says_no_code_leaves_the_modes_known(line: str) -> None:
    assert why_left(f"{HEAD}{line}\n{CUT}") == []


def test_the_programmed_speed_is_back_before_one_under_a_condition() -> None:
    cut = "(VIB N1.5 F62.5)\nG1 Z-5. F0.1\n(VIB OFF)\n"
    lines = filtered(f"{HEAD}{cut}IF[#1EQ1] S900\nG0 X40.\nG1 X41. F0.2\nM30\n").data.decode().splitlines()
    at = lines.index("IF[#1EQ1] S900")
    assert lines[at - 3 : at] == ["(CHIPBREAK BEGIN SPEED AS PROGRAMMED)", "S2000", lines[at - 1]]


def test_a_cut_in_a_loop_that_ends_with_another_tolerance_stays() -> None:
    head = "G21 G18 G7 G40 G95 G64\nG97 S2000 M3\no10 repeat [2]\nG0 X30. Z5.\n"
    cut = "(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\n"
    assert why_left(f"{head}{cut}G64 P0.01\no10 endrepeat\nM2\n", "linuxcnc-lathe") == ["VIB050"]
    assert why_left(f"{head}{cut}G64\no10 endrepeat\nM2\n", "linuxcnc-lathe") == []


@pytest.mark.parametrize(
    ("line", "codes"),
    [
        ("G[64]", ["VIB050"]),
        ("G[10**200]", ["VIB050"]),
        ("G[60+1]", ["VIB050"]),
        ("M[5]", ["VIB046"]),
        ("G[90+5]", []),
        ("M[3]", []),
    ],
)
def test_a_code_that_is_worked_out_from_numbers_is_that_code(line: str, codes: list[str]) -> None:
    """A path mode of this kind cannot be given back; the others hold as if they were written plainly."""
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\nM2\n"
    assert why_left(f"G21 G18 G7 G40 G95 G97 S2000 M3\n{line}\n{cut}", "linuxcnc-lathe") == codes


def test_the_other_arm_has_the_modes_from_before_the_branch() -> None:
    """G20 in the first arm does not hold in the second."""
    head = "G21 G18 G7 G40 G95 G64\nG97 S2000 M3\no10 if [#1 EQ 1]\nG20\no10 else\n"
    cut = "G0 X30. Z5.\n(VIB N1.5)\nG1 Z-5. F0.1\n(VIB OFF)\no10 endif\nM2\n"
    (found,) = filtered(head + cut, "linuxcnc-lathe").cuts
    assert found.plan.wave.feed_mm_rev == pytest.approx(0.1)


def test_a_cycle_whose_units_may_be_skipped_stays() -> None:
    program = f"{HEAD}/G20\nG0 X30. Z5.\n(VIB N1.5)\nG90 X28. Z-5. F0.1\nG0 X40.\nM30\n"
    result = filtered(program)
    assert result.data == program.encode()
    assert "CYC007" in {said.code for said in result.diagnostics}


@pytest.mark.parametrize("line", ["G81 Z-3.", "G777", "G777 X5.", "B90. F0.2"])
def test_what_may_cut_finds_the_programmed_speed(line: str) -> None:
    program = f"{HEAD}(VIB N1.5 F62.5)\nG1 Z-5. F0.1\n(VIB OFF)\n{line}\nM30\n"
    lines = filtered(program).data.decode().splitlines()
    assert lines[lines.index(line) - 2] == "S2000"


@pytest.mark.parametrize(
    ("call", "codes"),
    [
        ("/T0202", ["VIB040"] * 2),
        ("T0202 ?", ["VIB040"] * 2),
        ("T0202", []),
        ("/T0202\nT0202", []),
        ("T0202 ?\nT0202\nG97 S2000", []),
    ],
)
def test_the_nose_of_a_tool_that_may_not_have_been_called(call: str, codes: list[str]) -> None:
    noses = [
        f"tools.nose_{what}.{number}={value}"
        for number in (1, 2)
        for what, value in (("radius_mm", 0.4 * number), ("tip", 3))
    ]
    settings = chipbreak.load("fanuc-lathe", [*SETS, *noses])
    program = f"{HEAD}{call}\nG0 X42. Z2.\n(VIB N1.5)\nG0 G42 X30.\nG1 Z-20. F0.1\n"
    program += "X40. Z-30.\nG0 G40 X50.\n(VIB OFF)\nM30\n"
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    assert [cut.said.code for cut in result.left] == codes
    assert (b"COMPENSATED G42 R0.8" in result.data) is (not codes)
