"""What must not vibrate is refused, whoever asks; what does not ask is left alone.

The single cases with their places are the files in tests/bad; here is what holds for all of them.
"""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.vibration import plan
from machine_reader import beside_unproven, filtered, rejected, run_program

HEAD = "G97 S3000 M3\nG0 X20. Z2.\n"
NO_CHECKS = ["checks.enabled=false"]
# What stands before the cut, what stands in it beside its end and feed, and the refusal.
REFUSED = [
    pytest.param("G41", "G1 Z-30. F0.05", "VIB040", id="nose compensation left"),
    pytest.param("G42", "G1 Z-30. F0.05", "VIB040", id="nose compensation right"),
    pytest.param("G68 X0. Z0. R30.\nG0 X20. Z2.", "G1 Z-30. F0.05", "VIB041", id="rotation"),
    pytest.param("G112\nG0 X20. Z2.", "G1 Z-30. F0.05", "VIB041", id="polar"),
    pytest.param("G107 C20.\nG0 X20. Z2.", "G1 Z-30. F0.05", "VIB041", id="cylinder"),
    pytest.param("G66 P9100\nG0 X20. Z2.", "G1 Z-30. F0.05", "VIB042", id="modal macro"),
    pytest.param("", "G1 Z#100 F0.05", "VIB047", id="end by variable"),
    pytest.param("", "G1 Z[2*3] F0.05", "VIB047", id="end by expression"),
    pytest.param("", "G1 Z-30. F#1", "VIB047", id="feed by variable"),
    pytest.param("F#1", "G1 Z-30.", "VIB050", id="modal feed by variable"),
    pytest.param("", "G1 Z-30. F0.05 M9", "VIB048", id="coolant off"),
    pytest.param("", "G1 Z-30. F0.05 M0", "VIB048", id="stop"),
    pytest.param("", "G1 Z-30. F0.05 B5.", "VIB048", id="another axis"),
    pytest.param("", "G9 G1 Z-30. F0.05", "VIB048", id="exact stop"),
    pytest.param("G93", "G1 Z-30. F5.", "VIB049", id="inverse time"),
    pytest.param("", "G1 Z-30.", "VIB050", id="no feed"),
    pytest.param("F0.", "G1 Z-30.", "VIB050", id="feed zero"),
    pytest.param("F-0.1", "G1 Z-30.", "VIB050", id="feed negative"),
    pytest.param("M5", "G1 Z-30. F0.05", "VIB046", id="spindle stopped"),
    pytest.param("M19", "G1 Z-30. F0.05", "VIB046", id="spindle orientated"),
    pytest.param("", "/G1 Z-30. F0.05", "VIB045", id="block delete"),
    pytest.param("", "/2 G1 Z-30. F0.05", "VIB045", id="block delete by number"),
    pytest.param("G92 X0. Z0.", "G1 Z-30. F0.05", "VIB051", id="origin set"),
    pytest.param("G52 Z5.", "G1 Z-30. F0.05", "VIB051", id="origin shifted"),
    pytest.param("G10 P0 Z1.", "G1 Z-30. F0.05", "VIB051", id="offset changed"),
    pytest.param("M98 P100", "G1 Z-30. F0.05", "VIB051", id="subprogram"),
    pytest.param("G0 Z#1", "G1 Z-30. F0.05", "VIB051", id="start by variable"),
    pytest.param("G31 Z0. F0.1", "G1 Z-30. F0.05", "VIB051", id="behind a skip move"),
    pytest.param("G37 Z5.", "G1 Z-30. F0.05", "VIB051", id="behind a measurement"),
]


@pytest.mark.parametrize(("before", "cut", "code"), REFUSED)
@pytest.mark.parametrize("how", ["word", "directive", "profile"])
def test_refused_whoever_asks(before: str, cut: str, code: str, how: str) -> None:
    before = before and before + "\n"
    ask = "(VIB N1.5)\n" if how == "directive" else ""
    word = " N1.5" if how == "word" else ""
    sets = ("vibration.n=1.5", "vibration.refused=error") if how == "profile" else ()
    errors = rejected(f"{HEAD}{before}{ask}{cut}{word}\nM30\n", "generic-lathe", *sets)
    line = 3 + before.count("\n") + ask.count("\n")
    assert [(found, at) for found, at, _ in errors] == [(code, line)]


@pytest.mark.parametrize(("before", "cut", "code"), REFUSED)
def test_off_is_a_way_out(before: str, cut: str, code: str) -> None:
    program = f"{HEAD}{before}\n(VIB OFF)\n{cut}\nM30\n"
    assert filtered(program, "generic-lathe", "vibration.n=1.5") == program, code


@pytest.mark.parametrize(
    ("line", "profile"),
    [
        pytest.param("G33 Z-30. F1.5", "generic-lathe", id="thread"),
        pytest.param("G92 X18. Z-30. F1.5", "fanuc-lathe", id="threading cycle"),
        pytest.param("G83 Z-30. Q5. F0.1", "generic-lathe", id="drilling cycle"),
        pytest.param("G76 P010060 Q100 R0.05", "fanuc-lathe", id="compound thread"),
        pytest.param("G0 Z5.", "generic-lathe", id="rapid"),
    ],
)
def test_a_directive_passes_over_what_it_cannot_mean(line: str, profile: str) -> None:
    program = f"G99 G97 S3000 M3\nG0 X20. Z2.\n(VIB N1.5)\n{line}\n(VIB OFF)\nM30\n".replace("G99 ", "", 1)
    assert filtered(program, profile) == program


def test_the_words_of_a_contour_are_refused_and_its_directive_is_not() -> None:
    shape = "G71 P100 Q110 U0.5 W0.1 F0.2\nN100 G0 X20.\nG1 Z-30. F0.1{0}\nN110 X40.\nG70 P100 Q110\nM30\n"
    head = "G97 S3000 M3\nG0 X40. Z2.\n"
    assert rejected(head + shape.format(" N1.5")) == [("VIB043", 5, 15)]
    program = head + "(VIB N1.5)\n" + shape.format("")
    assert rejected(program) == [("CYC004", 4, 1)]
    depth = program.replace("G71 P", "G71 U2. R1.\nG71 P")
    assert "(CHIPBREAK UNROLLED G71 P100 Q110)" in filtered(depth)


def test_an_unbroken_cut_passes_only_when_allowed() -> None:
    program = f"{HEAD}G1 Z-30. F0.05 N1.5 Q0.5\nM30\n"
    assert rejected(program) == [("VIB060", 3, 1)]
    assert len(run_program(filtered(program, allow_unbroken=True)).cuts) == 1


def test_the_way_out_of_an_unbroken_cut_works() -> None:
    program = f"{HEAD}G1 Z-30. F0.05 N1.5 Q0.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe"))
    (error,) = caught.value.diagnostics
    ratio = error.help.split("works: Q ")[1].split()[0]
    assert len(run_program(filtered(program.replace("Q0.5", f"Q{ratio}"))).cuts) == 1


def test_vibration_on_a_finishing_operation_is_warned_of() -> None:
    program = f"(FINISH TURN)\nT0101\n{HEAD}G1 Z-30. F0.05 N1.5\nM30\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe"))
    assert [d.code for d in beside_unproven(result.diagnostics)] == ["VIB061"]
    assert result.changed


@pytest.mark.parametrize(
    ("asks", "cut", "sets", "asks_no_more", "cut_then"),
    [
        ("", "N1.5", [], "", ""),
        ("(VIB N1.5)\n", "", [], "(VIB N1.5)\n(VIB OFF)\n", ""),
        ("", "", ["vibration.n=1.5", "vibration.only=['finish', 'rough']"], "(VIB OFF)\n", ""),
    ],
    ids=["word", "directive", "profile"],
)
def test_the_ways_out_of_vibration_on_a_finishing_operation(
    *, asks: str, cut: str, sets: list[str], asks_no_more: str, cut_then: str
) -> None:
    settings = chipbreak.load("generic-lathe", sets)
    program = f"(FINISH TURN)\nT0101\n{HEAD}{{}}G1 Z-30. F{{}} {{}}\nM30\n"
    result = chipbreak.rewrite(program.format(asks, "0.1", cut).encode(), settings)
    (warning,) = beside_unproven(result.diagnostics)
    without = chipbreak.rewrite(program.format(asks_no_more, "0.1", cut_then).encode(), settings)
    assert not without.cuts
    assert "VIB061" not in {d.code for d in without.diagnostics}
    if sets:
        assert '"finish"' in warning.help
        only = chipbreak.load("generic-lathe", ["vibration.n=1.5", "vibration.only=['rough']"])
        assert not chipbreak.rewrite(program.format("", "0.1", "").encode(), only).cuts
    share = float(warning.help.split("with ")[1].split("%")[0]) / 100.0
    (cut_before,) = result.cuts
    slower = chipbreak.rewrite(program.format(asks, f"{0.1 * share:.3f}", cut).encode(), settings)
    (cut_after,) = slower.cuts
    assert cut_after.verdict.roughness_factor * share**2 == pytest.approx(1.0, rel=0.03)
    assert cut_before.verdict.breaks


@pytest.mark.parametrize(
    ("words", "sets", "codes"),
    [
        ("G5.1 Q1", [], ["VIB063"]),
        ("G08 P1", [], ["VIB063"]),
        ("G5.1 Q0", [], []),
        ("G5.1 Q1", ["planner.smoothing_off=G5.1 Q0", "planner.smoothing_on=G5.1 Q1"], []),
    ],
)
def test_smoothing_in_a_vibrated_cut_is_warned_of(words: str, sets: list[str], codes: list[str]) -> None:
    settings = chipbreak.load("fanuc-mill", ["checks.enabled=false", *sets])
    program = f"G21 G95 S3000 M3\n{words}\nG0 X0. Z2.\nG1 Z-3. F0.05 N1.5\nM30\n"
    found = beside_unproven(chipbreak.rewrite(program.encode(), settings).diagnostics)
    assert [d.code for d in found] == codes


def test_cuts_too_short_may_stay_plain_where_chips_may_stay_whole() -> None:
    """A profile or comment asks for all cuts, the small ones between them too."""
    program = f"{HEAD}(VIB N1.5)\nG1 Z-3. F0.05\nG0 X20.4\nG1 X20. Z-3.01\nG0 X30.\nM30\n"
    assert rejected(program) == [("VIB013", 6, 1)]
    settings = chipbreak.load("generic-lathe")
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    found = beside_unproven(result.diagnostics)
    assert [(d.code, d.severity.value) for d in found] == [("VIB013", "warning")]
    assert len(result.cuts) == 1
    assert b"\nG1 X20. Z-3.01\n" in result.data
    by_word = program.replace("Z-3.01", "Z-3.01 N1.5")
    with pytest.raises(chipbreak.ProgramRejectedError):
        chipbreak.rewrite(by_word.encode(), settings, allow_unbroken=True)


def test_one_refused_cut_stops_the_whole_program() -> None:
    good = "G1 Z-30. F0.05 N1.5\nG0 Z2.\n"
    errors = rejected(f"{HEAD}{good}G1 Z-20. N2\nG0 Z2.\nG1 Z-10. N3\nM30\n")
    assert [(code, line) for code, line, _ in errors] == [("VIB005", 5), ("VIB005", 7)]


@pytest.mark.parametrize(
    "words",
    ["N1.5 Q0", "N1.5 E-2", "N1.5 f-62.5", "N1.5 Q-0.5", "N0.", "E0.", "f0.", "N-0.5"],
)
def test_words_out_of_range(words: str) -> None:
    assert [code for code, *_ in rejected(f"{HEAD}G1 Z-30. F0.05 {words}\nM30\n")] == ["VIB017"]


@pytest.mark.parametrize(
    "item", ["N0", "E0", "F0", "Q0", "A0", "K0", "ALPHA0", "ALPHA1", "EDGES0", "S0", "RAMP-1"]
)
def test_directive_values_out_of_range(item: str) -> None:
    assert rejected(f"{HEAD}(VIB {item})\nG1 Z-30. F0.05\nM30\n") == [("VIB017", 3, 1)]


def test_a_word_that_is_an_error_is_not_said_to_pass() -> None:
    program = b"G97 S1250 M3\nG0 X30. Z2.\nG1 Z-30. F0.1 N1.5 K2\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program, chipbreak.load("generic-lathe"))
    assert [d.code for d in caught.value.diagnostics] == ["VIB048"]


@pytest.mark.parametrize(
    ("behind", "said"),
    [
        ("G0 X30 Z2\nG1 X28. F0.1 N1.5\n", "X30 in line {} has no decimal point"),
        ("F1\nG0 X30. Z2.\nG1 X28. N1.5\n", "the feed F1 (line {})"),
    ],
)
def test_lines_named_in_messages_are_those_of_the_file_at_hand(behind: str, said: str) -> None:
    """A filtered program is put back before it is read, and its lines have other numbers then."""
    done = filtered("G97 S2500 M3\nG0 X20. Z2.\nG1 Z-10. F0.05 N1.5\n", "fanuc-lathe")
    settings = chipbreak.load("fanuc-lathe")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite((done + behind + "M30\n").encode("latin-1"), settings)
    (found,) = caught.value.diagnostics
    assert said.format(done.count("\n") + 1) in found.message


def test_the_active_speed_stands_in_a_line_of_the_file_at_hand() -> None:
    cut = "G0 X{}. Z2.\nG1 Z-10. F0.05 N1.5\n"
    done = filtered("G97 S2500 M3\n" + cut.format(20) + "S2000\n" + cut.format(18) + "M30\n", "fanuc-lathe")
    result = chipbreak.rewrite(done.encode("latin-1"), chipbreak.load("fanuc-lathe"))
    line = done.split("\n").index("S2000") + 1
    assert result.cuts[1].plan.given["S"].origin == f"active S, line {line}"


@pytest.mark.parametrize(
    ("profile", "blocks", "reason"),
    [
        ("fanuc-lathe", "G83 Z-20. R5. Q5000 F0.1\nG80", "a drilling cycle in line 3 moves the tool"),
        ("fanuc-lathe", "G84 Z-20. F1.\nG80", "a drilling cycle in line 3 moves the tool"),
        ("fanuc-lathe", "G85 Z-20. R5. F0.1\nX10.\nG80", "a drilling cycle in line 4 moves the tool"),
        ("linuxcnc-lathe", "G83 Z-20. R5. Q5 F0.1\nG80", "a drilling cycle in line 3 moves the tool"),
        ("fanuc-mill", "G81 Z-20. R5. F100.\nG80", "a drilling cycle in line 3 moves the tool"),
        ("fanuc-lathe", "G0 Z#1", "the control works out where line 3 goes"),
        ("fanuc-lathe", "G0 X10. Z[#1+2]", "the control works out where line 3 goes"),
        ("fanuc-lathe", "G83 Z-20. R5. F0.1\nG80\nT0101", "a tool or its offset changed"),
        ("fanuc-lathe", "T0101", "a tool or its offset changed"),
    ],
)
def test_the_reason_of_an_unknown_place_is_the_last_one(profile: str, blocks: str, reason: str) -> None:
    tool = "T3 M6" if "mill" in profile else "T0303"
    per_revolution = "G99" if profile == "fanuc-lathe" else "G95"
    head = f"{tool} S3000 M3\nG0 {per_revolution} X20. Z2.\n"
    cut = "(VIB N1.5)\nG1 Z-30. F0.05\nM30\n"
    (found,) = chipbreak.check(f"{head}{blocks}\n{cut}".encode(), chipbreak.load(profile, NO_CHECKS))
    assert found.code == "VIB051"
    assert found.message == f"where Z stands before this cut cannot be known: {reason}"


@pytest.mark.parametrize("decimals", ["5", "6"])
def test_a_feed_below_the_smallest_number_of_f_is_refused(decimals: str) -> None:
    """It would be written as that number, and the cut would take a part of its time."""
    program = b"G21 G95 G18\nG97 S1 M3\nG0 X1. Z0.\n(VIB N0.5)\nG1 Z-3. F0.005\nM30\n"
    sets = [f"output.decimals={decimals}", "output.feed_decimals=3", "output.feed_mode=minute"]
    codes = [one.code for one in chipbreak.check(program, chipbreak.load("generic-lathe", sets))]
    assert codes[:1] == ["VIB059"]


@pytest.mark.parametrize("profile", ["linuxcnc-mill", "fanuc-mill"])
def test_a_feed_per_revolution_where_it_counts_per_minute_is_said(profile: str) -> None:
    program = b"G97 S3000 M3\nG0 X0 Z2.\nG1 Z-30. F0.05 N1.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as refused:
        chipbreak.rewrite(program, chipbreak.load(profile))
    (said,) = [one for one in refused.value.diagnostics if one.code == "VIB021"]
    assert "the feed F0.05 is per minute: 2e-05 mm per revolution" in said.message
    assert said.help.startswith("command feed per revolution (G95, G99)")


def test_a_stroke_of_few_steps_is_refused_before_its_blocks_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "sample", None)
    program = "G97 S3000 M3\nG0 X20. Z2.\nG1 Z1. F0.05 N1.5 Q0.5\nM30\n"
    assert "VIB059" in [code for code, *_ in rejected(program, "speedio-renishaw")]


def test_a_spindle_that_hardly_turns_is_refused_before_its_control_is_followed() -> None:
    sets = ["axes.X.max_acceleration_mm_s2=1000", "axes.Z.max_acceleration_mm_s2=1000"]
    program = b"G18 G7 G90 G95 G97 S0.01 M3\nG0 X20. Z2.\nG1 Z-30 F0.05 N1.5\nM2\n"
    (said,) = chipbreak.check(program, chipbreak.load("linuxcnc-lathe", sets))
    assert said.code == "VIB021"
    assert "3840000000 servo periods of the control" in said.message


@pytest.mark.parametrize(
    ("mode", "feed", "words"),
    [
        ("G94", "F0.2", "the feed F0.2 is per minute: 0.0002 mm per revolution"),
        ("G95", "F0.0002", "no chip is as thin as 0.0002 mm per revolution"),
    ],
)
def test_no_chip_is_thinner_than_a_thousandth(mode: str, feed: str, words: str) -> None:
    """It was meant in another unit; all that is worked out for such a cut takes seconds."""
    program = f"G97 S1000 M3\n{mode}\nG0 X20. Z2.\nG1 Z1.9 {{}} N1.5\nM30\n"
    sets = ("output.decimals=6", "output.feed_decimals=8")
    with pytest.raises(chipbreak.ProgramRejectedError, match=words) as caught:
        filtered(program.format(feed), "generic-lathe", *sets)
    assert [one.code for one in caught.value.diagnostics if one.place and one.place.line == 4] == ["VIB059"]
    enough = "F1.2" if mode == "G94" else "F0.0012"
    assert "CHIPBREAK BEGIN" in filtered(program.format(enough), "generic-lathe", *sets)


def test_the_digits_of_f_do_not_count_where_the_program_has_written_it() -> None:
    """The plain end runs at F0.0047 in all its digits, and not at the F0.005 of the others."""
    program = b"G20\nG97 S800 M3\nG99\nG0 X1.5 Z0.1969\nG1 Z0.1024 F0.0047 N1.5 f50. Q1.3\nG0 X3.\nM30\n"
    sets = ["vibration.ramp_vibrations=0.5", "output.form=expanded"]
    chipbreak.rewrite(program, chipbreak.load("haas-lathe", [*sets, "output.feed_decimals=3"]))
    with pytest.raises(chipbreak.ProgramRejectedError) as rejected:
        chipbreak.rewrite(program, chipbreak.load("haas-lathe", [*sets, "output.feed_decimals=2"]))
    (error,) = [one for one in rejected.value.diagnostics if one.code == "VIB059"]
    assert "with 3 decimals of F this cut of 0.603 s would take 0.606 s" in error.message


def test_a_corner_and_a_crest_that_digits_set_apart_are_refused() -> None:
    """They are one moment, and no block between them has a feed."""
    cuts = "G1 Z-0.7575 F4.7244\nX2.3717 Z-1.5449\n"
    program = f"G20\nS1000 M3\nG94\n(VIB AUTO)\nG0 X1.5843 Z0.0299\n{cuts}".encode()
    settings = chipbreak.load("generic-lathe", ("output.decimals=2", "planner.max_blocks_per_s=500"))
    with pytest.raises(chipbreak.ProgramRejectedError):
        chipbreak.rewrite(program, settings)
