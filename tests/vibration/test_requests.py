"""Which words and comments ask for vibration, whose value wins, and where messages say it came from."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.text.diagnostics import RefusalError
from chipbreak.vibration.directive import KEYS, read_directive
from machine_reader import filtered, rejected, run_program, vibration_of

HEAD = "G97 S3000 M3\nG0 X20. Z2.\n"
CUT = "G1 Z-30. F0.05"


def cuts_of(program: str, *sets: str, profile: str = "generic-lathe") -> int:
    return len(run_program(filtered(program, profile, *sets)).cuts)


def explained(program: str, *sets: str) -> list[str]:
    """What was asked of each cut, and where it was said, as explain shows it."""
    result = chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe", sets))
    return [
        ", ".join(f"{key} {given.value:g} ({given.origin})" for key, given in cut.plan.given.items())
        for cut in result.cuts
    ]


# --- words ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("block", "asks"),
    [
        pytest.param("N1.5 G1 Z-30. F0.05", False, id="the first N is a block number"),
        pytest.param("N10 G1 Z-30. F0.05 N1.5", True, id="the second N asks"),
        pytest.param("N10N1.5 G1 Z-30. F0.05", True, id="the second N asks, even straight behind the first"),
        pytest.param("N10 N20 G1 Z-30. F0.05", True, id="two block numbers are one and a count"),
        pytest.param("G1 Z-30. F0.05 E2", True, id="E"),
        pytest.param("G1 Z-30. F0.05 f62.5", True, id="f beside F"),
        pytest.param("G1 Z-30. N1.5 f62.5 F0.05", True, id="f before F"),
        pytest.param("G1 Z-30. f0.05", False, id="f alone is a feed"),
        pytest.param("g1X54.834 Z-52.151f120000", False, id="a sloppy feed"),
        pytest.param("g1 z-30. f0.05", False, id="lower case"),
        pytest.param("g1 z-30. f0.05 n1.5", False, id="lower-case n"),
        pytest.param("G1 Z-30. (N1.5) F0.05", False, id="in a comment"),
        pytest.param("G4 X1. N1.5", False, id="a dwell"),
        pytest.param("G65 P9100 E1. Q2. X3.", False, id="a macro call's own words"),
        pytest.param("G83 Z-30. Q5. F0.05", False, id="a cycle's own Q"),
        pytest.param("G76 P010060 Q100 R0.05", False, id="a threading cycle's own Q"),
        pytest.param("M98 P100 Q2", False, id="a call"),
    ],
)
def test_words(block: str, asks: bool) -> None:
    program = f"{HEAD}{block}\nM30\n"
    if asks and "N20" in block:
        assert rejected(program) == [("VIB005", 3, 5)]
        return
    out = filtered(program)
    assert (out != program) == asks
    assert (b"CHIPBREAK" in out.encode("latin-1")) == asks


@pytest.mark.parametrize(
    "block",
    [
        "G1 Z-30. F0.05 N1.5 Q1.4",
        "G1 Z-30. F0.05 E2 Q1.4",
        "N5 G1 Z-30. F0.05 f62.5",
        "/N5 G0 X1.\nG0 Z2. X20.\nG1 Z-30. F0.05 N1.5 f62.5 Q1.4",
    ],
)
def test_no_vibration_word_reaches_the_output(block: str) -> None:
    out = filtered(f"{HEAD}{block}\nM30\n")
    code = re.sub(r"\([^)]*\)", "", out)
    assert not re.search(r"[fEQ]", code)
    assert not re.search(r"(?m)^(?!/?N5).*N", code)


def test_a_stray_f_is_said_with_both_readings() -> None:
    program = f"{HEAD}{CUT} N1.5\nG1X54.834 Z-52.151f0.2\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe"))
    (error,) = (d for d in caught.value.diagnostics if d.code == "VIB019")
    assert "feed" in error.message + error.help
    assert "frequency" in error.help


def test_a_lower_case_line_in_a_vibrating_program_is_no_stray_f() -> None:
    assert cuts_of(f"{HEAD}{CUT} N1.5\ng1 x54.8 f0.2\nM30\n") == 1


def test_a_lower_case_program_asks_by_directive() -> None:
    assert cuts_of("g97 s3000 m3\ng0 x20. z2.\n(vib n1.5)\ng1 z-30. f0.05\nm30\n") == 1


@pytest.mark.parametrize(
    "line",
    ["G1 Z-30. F0.05 N1.5 X#1", "G1 Z[1] F0.05 N1.5", "IF [#1 EQ 1] THEN #2 = 3"],
    ids=["variable", "expression", "condition"],
)
def test_macro_lines(line: str) -> None:
    program = f"{HEAD}{line}\nM30\n"
    if "N1.5" in line:
        assert [code for code, *_ in rejected(program)] == ["VIB047"]
    else:
        assert filtered(program) == program


# --- directives -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "cuts"),
    [
        pytest.param("(VIB N1.5)\nG1 Z-5. F0.05\nG0 X30.\nG1 Z-10.\n", 2, id="modal"),
        pytest.param("(VIB N1.5)\nG1 Z-5. F0.05\n(VIB OFF)\nG0 X30.\nG1 Z-10.\n", 1, id="off"),
        pytest.param(
            "(VIB N1.5)\nG1 Z-5. F0.05\nT0303\nG0 X30. Z2.\nG1 Z-10.\n", 1, id="the next tool ends it"
        ),
        pytest.param("T0101\n(VIB N1.5)\nT0101\nG0 X30. Z2.\nG1 Z-10. F0.05\n", 0, id="the same tool again"),
        pytest.param(
            "(VIB N1.5)\nT0303\nG0 X30. Z2.\n(vib n1.5)\nG1 Z-10. F0.05\n", 1, id="again, lower case"
        ),
        pytest.param(";VIB N1.5\nG1 Z-5. F0.05\n", 1, id="a semicolon comment"),
        pytest.param("G1 Z-5. F0.05 (VIB N1.5)\n", 1, id="on the line of the cut"),
        pytest.param("(VIBRATION CUTTING)\nG1 Z-5. F0.05\n", 0, id="another comment"),
        pytest.param("(  VIB , N = 1.5 , Q=1.4 )\nG1 Z-5. F0.05\n", 1, id="commas and equal signs"),
        pytest.param("(VIBN1.5)\nG1 Z-5. F0.05\n", 0, id="a space is needed"),
    ],
)
def test_directive_reach(lines: str, cuts: int) -> None:
    assert cuts_of(f"{HEAD}{lines}M30\n") == cuts


def test_a_directive_ends_with_m6_where_that_changes_the_tool() -> None:
    program = (
        "G7 G95 G97 S3000 M3\nG0 X20. Z2.\n(VIB E2)\nT2\nG1 Z-5. F0.05\nT3 M6\nG0 X20. Z2.\nG1 Z-10.\nM2\n"
    )
    assert cuts_of(program, profile="linuxcnc-lathe") == 1


@given(
    st.lists(st.sampled_from([k for k in KEYS if k != "WAVE"]), unique=True, max_size=6),
    st.data(),
)
def test_any_directive_reads_back(keys: list[str], data: st.DataObject) -> None:
    numbers = {key: data.draw(st.decimals(0, 99, places=2)) for key in keys}
    wave = data.draw(st.sampled_from(["", "TRIANGLE", "SINE"]))
    items = [
        f"{key}{data.draw(st.sampled_from(['', ' ', '=', ' = ']))}{value}" for key, value in numbers.items()
    ]
    items += [f"WAVE {wave}"] if wave else []
    text = "VIB " + data.draw(st.sampled_from([" ", ", "])).join(items)
    text = data.draw(st.sampled_from([text, text.lower()]))
    directive = read_directive(text, 7)
    assert directive is not None
    assert directive.on
    assert {k: g.value for k, g in directive.values.items()} == {k: float(v) for k, v in numbers.items()}
    assert directive.waveform == wave.lower()
    assert all(g.origin == "directive, line 7" for g in directive.values.values())


@given(st.text(alphabet=st.characters(max_codepoint=255), max_size=40))
def test_any_comment_is_read_or_refused(text: str) -> None:
    for comment in (text, f"VIB {text}"):
        try:
            read_directive(comment, 1)
        except RefusalError as error:
            assert error.code == "VIB014"
            assert error.help


def test_a_misspelt_key_is_answered_with_the_right_one() -> None:
    with pytest.raises(RefusalError) as caught:
        read_directive("VIB N1.5 ALPH0.75", 1)
    assert "did you mean ALPHA?" in caught.value.help


# --- who wins ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lines", "sets", "asked"),
    [
        pytest.param(f"{CUT} N1.5", (), "S 3000 (active S, line 1), N 1.5 (N word, line 3)", id="block"),
        pytest.param(
            f"(VIB N2.5)\n{CUT} N1.5",
            ("vibration.n=3.5",),
            "S 3000 (active S, line 1), N 1.5 (N word, line 4)",
            id="block over directive over profile",
        ),
        pytest.param(
            f"(VIB N2.5)\n{CUT}",
            ("vibration.n=3.5",),
            "S 3000 (active S, line 1), N 2.5 (directive, line 3)",
            id="directive over profile",
        ),
        pytest.param(
            CUT,
            ("vibration.n=3.5",),
            "S 3000 (active S, line 1), N 3.5 (profile vibration.n, --set)",
            id="profile",
        ),
        pytest.param(
            f"(VIB N2.5)\n{CUT} E2",
            (),
            "S 3000 (active S, line 1), N 0.5 (E word, line 4)",
            id="E of the block over N of the directive",
        ),
        pytest.param(
            f"(VIB N1.5 F50)\n{CUT} f62.5",
            (),
            "N 1.5 (directive, line 3), F 62.5 (f word, line 4)",
            id="each value on its own",
        ),
        pytest.param(
            f"{CUT} S2000 N1.5",
            ("vibration.f_hz=62.5",),
            "S 2000 (S word, line 3), N 1.5 (N word, line 3)",
            id="the profile adds no third",
        ),
    ],
)
def test_precedence_and_origin(lines: str, sets: tuple[str, ...], asked: str) -> None:
    assert explained(f"{HEAD}{lines}\nM30\n", *sets) == [asked]


def test_errors_name_every_value_and_its_line() -> None:
    program = f"{HEAD}(VIB S2500)\n{CUT} N1.5 f62.5\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), chipbreak.load("generic-lathe"))
    (error,) = caught.value.diagnostics
    assert error.code == "VIB002"
    for part in ("S 2500 (directive, line 3)", "N 1.5 (N word, line 4)", "f 62.5 (f word, line 4)"):
        assert part in error.message


def test_a_profile_that_fixes_n_makes_every_cut_vibrate() -> None:
    program = (
        f"{HEAD}G1 Z-5. F0.05\nG0 X30.\n(VIB OFF)\nG1 Z-10. F0.1\nT0303\nG0 X30. Z2.\nG1 Z-10. F0.05\nM30\n"
    )
    assert cuts_of(program, "vibration.n=1.5") == 2


def test_values_of_the_profile_fill_what_was_not_said() -> None:
    out = filtered(f"{HEAD}{CUT} N1.5\nM30\n", "generic-lathe", "vibration.q=1.6", "output.decimals=5")
    assert vibration_of(run_program(out).cuts[0]).stroke_mm == pytest.approx(0.08, abs=1e-4)
    out = filtered(f"{HEAD}{CUT} N1.5 Q2\nM30\n", "generic-lathe", "vibration.a_mm=0.5", "output.decimals=5")
    assert vibration_of(run_program(out).cuts[0]).stroke_mm == pytest.approx(0.1, abs=1e-4)


def test_an_s_word_under_g96_is_no_rpm() -> None:
    out = filtered("G50 S4000\nG96 S100 M3\nG0 X20. Z2.\nG1 Z-30. F0.05 S120 N1.5\nG1 X30.\nM30\n")
    run = run_program(out)
    assert run.cuts[0][-1].speed_rpm == 2000.0  # 120 m/min on 20 mm is 1910 rpm; N 1.5 at 50 Hz
    assert "G96 S120" in out.splitlines()


@pytest.mark.parametrize("cycle", ["G70 P10 Q20 F0.1", "G71 U1. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2"])
def test_a_cut_that_a_cycle_behind_it_takes_for_its_shape_stays(cycle: str) -> None:
    """The control comes through it as it stands, and the cycle would cut the vibration again."""
    shape = "N10 G1 Z-8. F0.2{word}\nN20 X30.\n"
    program = f"G21 G99\nG97 S1200 M3\nG0 X20. Z5.\n{shape}G0 Z5.\n{cycle}\nG0 X90.\nM30\n"
    settings = chipbreak.load("fanuc-lathe")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.format(word=" N1.5").encode(), settings)
    assert [one.code for one in caught.value.diagnostics][:1] == ["VIB043"]
    plain = program.format(word="").encode()
    asked = chipbreak.load("fanuc-lathe", ("vibration.n=1.5", "vibration.refused=leave"))
    result = chipbreak.rewrite(plain, asked)
    assert b"N10 G1 Z-8. F0.2\nN20 X30.\n" in result.data


def test_a_shape_of_another_program_of_the_file_is_not_meant() -> None:
    """Both number their blocks alike, and only the cycle of the second one looks for a shape."""
    first = "O1\nG21 G99 G97 S1200 M3\nG0 X20. Z5.\nN10 G1 Z-8. F0.2 N1.5\nN20 X30.\nM30\n"
    cycle = "G71 U1. R0.5\nG71 P10 Q20 U0.4 W0.1 F0.2\nN10 G0 X40.\nG1 Z-5.\nN20 X50.\nG70 P10 Q20\n"
    second = f"O2\nG97 S900 M3\nG0 X50. Z2.\n{cycle}M30\n"
    result = chipbreak.rewrite((first + second).encode(), chipbreak.load("fanuc-lathe"))
    assert len(result.cuts) == 1
