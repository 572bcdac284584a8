"""What a feed override, a drooping spindle and a spindle without an encoder do to a cut, and what is said."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.kinematics.chip_model import judge
from chipbreak.kinematics.waveform import feed_override_band

PROGRAM = "G21 G99\nG97 S1500 M3\nG0 X50. Z2.\nG1 Z-20. F0.1 {}\nM30\n"


@pytest.mark.parametrize("words", ["N1.5", "N1.5 Q1.5", "N0.5", "N2.5 Q2."])
def test_at_the_ends_of_the_band_of_the_override_chips_just_break(words: str) -> None:
    settings = chipbreak.load("fanuc-lathe")
    result = chipbreak.rewrite(PROGRAM.format(words).encode(), settings)
    (cut,) = result.cuts
    (motion,) = chipbreak.motions(result, settings)
    band = cut.override_band
    assert band is not None
    tried = [(band[0] + 0.01, True), (band[1] - 0.01, True), (band[1] + 0.01, False)]
    if band[0] > 0.1:  # below that it is no override any more
        tried.append((band[0] - 0.01, False))
    for override, breaks in tried:
        verdict = judge(
            motion.time_s / override,
            motion.distance_mm,
            speed_rpm=cut.plan.solution.speed_rpm,
            feed_mm_rev=0.1 * override,
        )
        assert verdict.breaks is breaks, (override, verdict.margin)


@pytest.mark.parametrize("mode", ["minute", "inverse"])
@pytest.mark.parametrize("words", ["N1.5", "N0.5", "N2.5 Q2."])
def test_at_the_ends_of_the_band_of_the_spindle_chips_just_break(words: str, mode: str) -> None:
    """Blocks that take their times whatever the spindle does: a slower one has more feed in a revolution."""
    settings = chipbreak.load("fanuc-mill", [f"output.feed_mode={mode}"])
    program = PROGRAM.format(words).replace("G21 G99", "G21 G90 G95").replace("X50.", "X0. Y0.")
    result = chipbreak.rewrite(program.encode(), settings)
    (cut,) = result.cuts
    (motion,) = chipbreak.motions(result, settings)
    band = cut.verdict.speed_band_rpm
    assert band is not None
    programmed_rpm = cut.plan.solution.speed_rpm
    assert band[0] < programmed_rpm < band[1]
    tried = [(1.01 * band[0], True), (0.99 * band[0], False), (0.99 * band[1], True)]
    if band[1] < 5.0 * programmed_rpm:  # above that it is no droop any more
        tried.append((1.01 * band[1], False))
    for speed_rpm, breaks in tried:
        feed_mm_rev = 0.1 * programmed_rpm / speed_rpm
        verdict = judge(motion.time_s, motion.distance_mm, speed_rpm=speed_rpm, feed_mm_rev=feed_mm_rev)
        assert verdict.breaks is breaks, (speed_rpm, verdict.margin)


def test_five_percent_is_too_much_for_the_usual_stroke() -> None:
    band = feed_override_band("triangle", 1.5, 1.2)
    assert band is not None
    assert 1.0 < band[1] < 1.05
    assert feed_override_band("triangle", 1.5, 0.9) is None


def explained(profile: str, program: str, *sets: str) -> str:
    return str(chipbreak.explain(program.encode(), chipbreak.load(profile, sets)))


def test_the_report_says_what_feed_per_revolution_and_an_override_do() -> None:
    said = explained("fanuc-lathe", PROGRAM.format("N1.5"))
    assert "which feed per revolution ties to the spindle: N stays" in said
    assert "of feed override, which takes N with it" in said
    per_minute = explained("fanuc-lathe", PROGRAM.format("N1.5"), "output.feed_mode=minute")
    assert "ties to the spindle" not in per_minute
    assert "rpm at this frequency and feed per minute" in per_minute


def test_the_report_says_how_much_of_the_acceleration_is_used() -> None:
    sets = ("planner.model=trapezoid", "axes.Z.max_acceleration_mm_s2=5000")
    assert "% of what there is" in explained("fanuc-lathe", PROGRAM.format("N0.5"), *sets)
    assert "of what there is" not in explained("fanuc-lathe", PROGRAM.format("N0.5"))


def test_a_sine_of_four_base_periods_is_called_a_triangle() -> None:
    program = PROGRAM.format("").replace("G1", "(VIB S2500 F62.5 WAVE SINE)\nG1")
    assert "a sine of 4 base periods is a triangle" in explained("fanuc-lathe", program)
    assert "is a triangle" not in explained("fanuc-lathe", program.replace("62.5", "50"))


def test_feed_per_revolution_in_a_milling_program_that_has_none_is_said() -> None:
    drill = "G21 G90 G17\nS1200 M3\nG0 X0. Y0. Z2.\nG1 Z-20. F120. N0.5\nM30\n"
    sets = ["checks.enabled=false"]

    def said(program: str, *more: str) -> list[str]:
        result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-mill", [*sets, *more]))
        return [d.message for d in result.diagnostics if d.code == "VIB088"]

    assert said(drill) == ["the blocks of this cut feed per revolution (G95), which the program does nowhere"]
    assert not said(drill, "output.feed_mode=minute")
    assert not said(drill.replace("G17", "G17 G95").replace("F120.", "F0.1"))


LINUXCNC = "G21 G7 G90 G95 G97 S1000 M3\nG0 X20 Z2\nG1 Z-20 F0.1 N0.5\nG0 X30\nM2\n"
HELD = ["M50 P0", "M51 P0"]
GIVEN_BACK = ["M50 P1", "M51 P1"]
LEFT_TO_THE_OPERATOR = ("planner.override_off=[]", "planner.override_on=[]")


def overrides_in(data: bytes) -> list[str]:
    return [line for line in data.decode().splitlines() if line.startswith(("M48", "M49", "M50", "M51"))]


def test_the_overrides_are_held_in_the_cut_and_given_back() -> None:
    result = chipbreak.rewrite(LINUXCNC.encode(), chipbreak.load("linuxcnc-lathe"))
    lines = result.data.decode().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("G1 Z"))
    last = next(i for i, line in enumerate(lines) if "CHIPBREAK END" in line)
    assert overrides_in(result.data) == HELD + GIVEN_BACK
    assert all(lines.index(line) < first for line in HELD)
    assert all(first < lines.index(line) < last for line in GIVEN_BACK)
    assert chipbreak.restore(result.data) == LINUXCNC.encode()
    assert not chipbreak.rewrite(result.data, chipbreak.load("linuxcnc-lathe")).changed
    assert "of feed override, which this cut holds at 100%" in explained("linuxcnc-lathe", LINUXCNC)


def test_every_cut_holds_them_for_itself() -> None:
    twice = LINUXCNC.replace("G0 X30\n", "G0 X30\nZ2\nX18\nG1 Z-20 F0.1 N0.5\n")
    data = chipbreak.rewrite(twice.encode(), chipbreak.load("linuxcnc-lathe")).data
    assert overrides_in(data) == 2 * (HELD + GIVEN_BACK)


def test_a_program_that_switches_overrides_itself_keeps_them() -> None:
    for own in ("M49", "M50 P0", "M51"):
        program = LINUXCNC.replace("G0 X20", f"{own}\nG0 X20")
        data = chipbreak.rewrite(program.encode(), chipbreak.load("linuxcnc-lathe")).data
        assert overrides_in(data) == [own]


def test_they_can_be_left_to_the_operator() -> None:
    data = chipbreak.rewrite(LINUXCNC.encode(), chipbreak.load("linuxcnc-lathe", LEFT_TO_THE_OPERATOR)).data
    assert overrides_in(data) == []


def test_a_variable_of_the_control_holds_them_on_fanuc() -> None:
    lathe = "G21 G99 G97 S1000 M3\nG0 X20. Z2.\nG1 Z-20. F0.1 N0.5\nG0 X30.\nM30\n"
    sets = ["planner.override_off=#3004=2", "planner.override_on=#3004=0"]
    result = chipbreak.rewrite(lathe.encode(), chipbreak.load("fanuc-lathe", sets))
    assert [line for line in result.data.decode().splitlines() if "#" in line] == ["#3004=2", "#3004=0"]
    assert chipbreak.restore(result.data) == lathe.encode()


def test_who_holds_the_override_gives_it_back() -> None:
    with pytest.raises(chipbreak.SettingsError, match="override_on"):
        chipbreak.load("linuxcnc-lathe", ["planner.override_on=[]"])


@pytest.mark.parametrize(
    ("profile", "block"),
    [
        (f"{name}-lathe", block)
        for name in ("linuxcnc", "fanuc")
        for block in ("X", "M3", "M30", "M98 P1", "F9")
    ]
    + [("fanuc-lathe", "G91"), ("fanuc-lathe", "#1=2"), ("fanuc-lathe", "#3004=X"), ("grbl", "#3004=2")],
)
def test_a_block_that_does_anything_else_is_refused(profile: str, block: str) -> None:
    sets = ["planner.override_off=M48", f'planner.override_on="{block}"']
    with pytest.raises(chipbreak.SettingsError, match="holds overrides or gives them back"):
        chipbreak.load(profile, sets)


@pytest.mark.parametrize("profile", ["grblhal-lathe", "haas-lathe", "linuxcnc-lathe"])
def test_m_codes_of_overrides_are_taken(profile: str) -> None:
    sets = ["planner.override_off=M49", "planner.override_on=M48"]
    assert chipbreak.load(profile, sets).planner.override_on == ("M48",)
