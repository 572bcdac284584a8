"""Every refused program of ``tests/bad``, with the way out that its help names followed: then it is taken.

A way out is a pattern in the program with what stands there instead, or a setting that is changed; several
where the help names several.
"""

from __future__ import annotations

import re

import pytest

import chipbreak
from test_bad import FILES, expectation

Way = tuple[str, str] | str  # (pattern, new text), or SECTION.KEY=VALUE

WAYS: dict[str, list[Way]] = {
    "arc-cannot-be": [("R3.", "R9.")],
    "arc-radius-without-point": [("R5 ", "R5. "), "control.decimal_point=calculator"],
    "arc-of-a-chain-cannot-be": [("X47.", "X50.")],
    "arc-ends-off-its-circle": [("Z-10.", "Z-8.")],
    "arc-goes-on-without-its-code": [("X60.", "G3 X60.")],
    "arc-of-too-many-bends": [("N1.25", "N1.25 f31.25")],
    "arc-without-centre": [("F0.05", "R9. F0.05")],
    "axis-accelerates-too-slowly": [("N1.5", "N1.5 f35.7143")],
    "axis-moves-too-slowly": [("N1.5", "N1.5 f10")],
    "axis-without-declared-acceleration": [
        "axes.Z.max_acceleration_mm_s2=5000",
        'planner.model="ideal"',
    ],
    "axis-without-acceleration": ["axes.Y.max_acceleration_mm_s2=20000", 'planner.model="ideal"'],
    "block-delete": [("/G1", "G1"), ("N1.5", "")],
    "cycle-allowance-inside": [("U-0.4", "U0.4")],
    "cycle-asked-by-a-word-stays": ['cycles.unroll="asked"', (" N1.5", "")],
    "cycle-begins-beyond-its-start": [("X52. Z2.", "X52. Z6.")],
    "cycle-contour-of-one-block": [
        (r"Q10(?s:.*)X16\.\n", "Q20 U0.4 F0.3\nN10 G0 X16.\nG1 Z-15.\nN20 X52.\n")
    ],
    "cycle-contour-turns-back": [("X26. Z-34.\n", "")],
    "cycle-depth-missing": [("G71 P", "G71 U2. R0.5\nG71 P")],
    "cycle-depth-zero": [("U0. ", "U2. ")],
    "cycle-pattern-of-no-pass": [("R0", "R3")],
    "cycle-without-contour": [("Q30", "Q20")],
    "check-has-no-place": [("(.FINISH.)", r"G0 Z15.\nG40 X1.\n\1\nG0 X1. Y2.\nG1 Z-1. F50.")],
    "check-shares-its-work-offset": [("G59", "G58")],
    "check-has-no-beam": ["checks.calls=haas", "checks.enabled=false"],
    "chips-do-not-break": [("Q0.5", "Q1.06")],
    "contour-of-a-cycle": [("N1.5", ""), ("G7.*P100.*\n", "")],
    "comment-not-closed": [("APPROACH", "APPROACH)")],
    "control-refuses-a-code": [(" G64", "")],
    "control-reads-too-few-blocks-of-a-sine": ["vibration.waveform=triangle"],
    "control-reads-too-few-blocks": [("N1.5", "N1.5 f41.6667")],
    "corner-is-too-slow": [("N1.5", "N1.5 f50")],
    "corner-word": [(" ,R1.", "\nG2 X22. Z-31. R1. F0.05")],
    "count-becomes-whole-where-s-stays": [("S1250", "S1500"), ("S1250", "S1071")],
    "count-is-a-variable": [("N#1", "N1.5")],
    "count-is-whole-per-edge": [("N2", "N1"), ("N2", "N3")],
    "count-is-whole": [("N2", "N1.5"), ("N2", "N2.5")],
    "count-negative": [("N-1.5", "N1.5")],
    "count-twice": [(" N2.5", "")],
    "count-unreadable": [("N1.5.2", "N1.5"), (" N1.5.2", "")],
    "count-zero": [("N0", "N0.5")],
    "cut-is-endless": [("F0.05", "F999.")],
    "cut-is-too-short": ["vibration.ramp_vibrations=0", ("N1.5", "")],
    "cut-without-length": [("Z2. F", "Z-2. F")],
    "cylindrical-interpolation": [("G7.1 C20.", "G7.1 C20.\nG7.1 C0"), (" N1.5", "")],
    "directive-alpha-one": [("ALPHA1", "ALPHA0.75")],
    "directive-edges-not-whole": [("EDGES1.5", "EDGES1")],
    "directive-exponent-zero": [("K0", "K1.5")],
    "directive-key-twice": [(" N2.5", "")],
    "directive-key-unknown": [("M1.5", "N1.5"), ("VIB M1.5", "VIB OFF")],
    "directive-stroke-zero": [("A0", "A0.08")],
    "directive-value-missing": [("VIB N", "VIB N1.5")],
    "directive-value-unreadable": [("N1.5.2", "N1.5")],
    "directive-wave-unknown": [("SQUARE", "SINE"), ("SQUARE", "TRIANGLE")],
    "drilling-cycle": [("G83", "G1"), (" N1.5", "")],
    "dwell-has-no-stroke": [(" Q1.4", "")],
    "dwell-moves-too-little": ["output.decimals=4", ("E2", "E8")],
    "dwell-of-a-whole-count": [("N2", "E2")],
    "dwell-stands-too-short-on-this-control": [("E2", "E2.2"), ("E2", "E2 ALPHA0.4")],
    "dwell-stands-too-short": [("N0.75", "E2"), ("N0.75", "N0.75 ALPHA0.2")],
    "end-is-a-variable": [("Z#1", "Z-30.")],
    "end-without-point": [("Z-30", "Z-30."), 'control.decimal_point="calculator"'],
    "feed-is-per-minute": [("G7", "G7 G95"), ("F0.1 N0.5", "F50. N0.5")],
    "feed-missing-since-mode-change": [("N1.5", "F0.05 N1.5"), ("G95", "G95 F0.05")],
    "feed-missing": [("N1.5", "F0.05 N1.5"), ("G0 X20.", "G0 F0.05 X20.")],
    "feed-without-point": [("F5", "F0.05")],
    "feed-zero": [("F0.", "F0.05")],
    "feeds-too-small-for-the-digits": ["output.feed_decimals=5"],
    "frequency-is-far-out": [("f120000", "f62.5"), (" f120000", "")],
    "frequency-zero": [("f0", "f62.5")],
    "incremental-distance-too-fine": [("Z-30.12345", "Z-30.123"), ("G91\nG1 Z-30.12345", "G1 Z-28.12345")],
    "inverse-time": [("G93\n(.*) F5.", r"G95\n\1 F.05"), ("G93\n(.*) F5.", r"G94\n\1 F150.")],
    "loop-counter-is-taken": ["output.loop_variable=32", 'output.form="expanded"'],
    "loop-counter-may-be-taken": ['output.form="expanded"'],
    "loop-labels-are-taken": ['output.form="expanded"'],
    "loop-takes-no-whole-servo-periods": ["command.periods_ms=[40]"],
    "m-code-acts-behind-the-move": [(" M9", "\nM9")],
    "machine-chooses-and-count-given": [(" N1.5", ""), ("AUTO ", "")],
    "machine-chooses-without-speed": [("M3", "S1000 M3")],
    "machine-finds-nothing": [("S4000", "S1960"), ("F0.3", "F0.088")],
    "modal-macro": [("G66 P9100", "G66 P9100\nG67"), (" N1.5", "")],
    "nose-compensation": [("G1 Z-30.", "G40 G1 Z0.\nG1 Z-30."), (" N1.5", "")],
    "path-mode-drops-strokes": [("G64 P0.03", "G61"), ("P0.03", "P0.005")],
    "path-mode-in-the-block": [("Q0.01 G1", "Q0.01\nG1")],
    "path-mark-in-the-block": [(r"(\$1)G1", r"\1\nG1")],
    "program-name-in-the-block": [("<SHAFT> (?=G1)", "<SHAFT>\nG97 S3000 M3\nG0 X20. Z2.\n")],
    "wait-mark-in-a-marked-block": [("(.*) (!2L1)", r"\2\nS3000 M3\n\1")],
    "path-does-not-start-the-spindle": [("G0 X10.", "S2000 M3\nG0 X10."), (" N1.5", "")],
    "path-waits-for-another": [("!2L1", "!2L1\nS3000 M3"), (" N1.5", "")],
    "smoothing-in-the-block": [("R3 G1", "R3\nG1")],
    "statement-in-the-block": [("GOTO5 ", "GOTO5\nG97 S1000 M3\nG0 X20. Z2.\n")],
    "variable-set-in-the-block": [("#1=2 ", "#1=2\n")],
    "spindle-of-choice-by-m-code": [("G0 X20.", "S3000 M3\nG0 X20."), (" N1.5", "")],
    "spindle-of-choice-by-p": [(" P12", " P12\nS3000 M3"), (" N1.5", "")],
    "spindle-of-choice-by-mark": [("G0 X20.", "S1000 M3\nG0 X20."), (" N1.5", "")],
    "subprogram-does-not-start-the-spindle": [("O0200", "O0200\nG97 S3000 M3"), (" N1.5", "")],
    "subprogram-of-o-words": [("o100 sub", "o100 sub\nG97 S1000 M3"), (" N1.5", "")],
    "peripheral-above-profile-limit": [("V120.", "V90.")],
    "peripheral-above-the-clamp": [("V120.", "V90.")],
    "peripheral-beside-s": [(" S500", ""), (" V120. D20.", "")],
    "peripheral-beyond-any-spindle": [("D0.000001", "D20.")],
    "peripheral-d-alone": [("D20.", "V120. D20."), ("D20.", "S1910")],
    "peripheral-d-negative": [("D-20.", "D20.")],
    "peripheral-directive-v-alone": [("SPEED V120", "SPEED V120 D20")],
    "peripheral-in-inches": [("V120. D20.", "S1910")],
    "peripheral-prints-as-zero": [("V0.01", "V120.")],
    "peripheral-under-surface-speed": [("G96", "G97"), ("V120. D20.", "S120")],
    "peripheral-v-alone": [("V120.", "V120. D20."), ("V120.", "S1910")],
    "peripheral-v-zero": [("V0.", "V120.")],
    "polar-interpolation": [("G112", "G112\nG113"), (" N1.5", "")],
    "profile-multiple-of-an-hour": ["command.min_multiple=8"],
    "programmed-speed-not-known": [("M3", "S3000 M3"), ("G1 X30.", "G1 S2500 X30.")],
    "rapid": [("G0 Z-30.", "G1 Z-30. F0.05"), (" N1.5", "")],
    "revolutions-zero": [("E0", "E2")],
    "rotary-axis": [("G1 Z-30. C90.", "G0 C90.\nG1 Z-30.")],
    "ramp-exponent-as-a-word": [("G1(.*) N1.5 K2", r"(VIB N1.5 K2)\nG1\1")],
    "rotated-coordinates": [("G68 X0. Z0. R30.", "G68 X0. Z0. R30.\nG69"), (" N1.5", "")],
    "look-ahead-with-feed-per-revolution": [
        "output.feed_mode=minute",
        "planner.model=after-interpolation",
    ],
    "on-the-edge-under-strict": [("Q4.1", "Q4.25"), ("Q4.1", "")],
    "unproven-under-strict": ["planner.model=after-interpolation"],
    "servo-leaves-too-little": [("N1.5", "N1.5 f2."), ("Q1.2", "Q10.6"), (" Q1.2", "")],
    "sine-in-strokes": ['output.segments="tick"', ("SINE", "TRIANGLE")],
    "sine-with-uneven-share": [("SINE", "TRIANGLE"), (" ALPHA0.75", "")],
    "skip-move": [("G31", "G1"), (" N1.5", "")],
    "solver-all-three-in-block": [(" S3000 N", " N"), (" N1.5", ""), (" f62.5", "")],
    "solver-only-n-and-no-speed": [("M3", "S3000 M3"), ("N1.5", "N1.5 f62.5")],
    "solver-only-q": [("Q1.5", "Q1.5 N1.5"), ("Q1.5", "Q1.5 f62.5")],
    "solver-only-s-in-directive": [("S2500", "S2500 N1.5"), ("S2500", "S2500 F62.5")],
    "solver-s-in-directive-with-n-and-f": [("VIB S3000", "VIB"), (" N1.5", ""), (" f62.5", "")],
    "speed-above-g50-clamp": [("f62.5", "f50")],
    "speed-above-profile-limit": [("N1.5", "N1.5 f50"), ("N1.5", "N2.5 f62.5")],
    "speed-below-profile-limit": [("N1.5", "N1.25")],
    "speed-beyond-any-spindle": [("S99999999", "S3000")],
    "speed-is-a-variable": [("S#1", "S3000")],
    "speed-would-more-than-double": [("N1.5", "N3.5")],
    "speed-would-more-than-halve": [("S20000", "S3750"), ("f31.25", "N1.5 f31.25")],
    "speed-would-print-as-zero": [("N1000000000.5", "N1.5")],
    "speed-not-known-behind-an-unreadable-line": [("G0 X30.", "S1000\nG0 X30.")],
    "speed-not-known-in-a-loop": [("G0 X30.", "S1000\nG0 X30.")],
    "start-without-point": [("Z2", "Z2."), 'control.decimal_point="calculator"'],
    "speed-zero": [("S0", "S3000")],
    "spindle-is-off": [("S3000", "S3000 M3")],
    "spindle-was-stopped": [("M5", "M5\nM3"), ("M5\n", "")],
    "stray-lower-case-f-beside-a-feed": [(" f62.5", ""), ("G1 F0.05 f62.5\n", "G1 F0.05\n")],
    "stray-lower-case-f": [("f0.2", "F0.2"), ("f0.2", "F0.2 f62.5")],
    "stroke-of-thousands-of-feeds": [("G94", "G95"), ("F0.05", "F150.")],
    "stroke-ratio-negative": [("Q-1.2", "Q1.2")],
    "stroke-too-small-for-the-digits": ["output.decimals=3", ("N1.5", "N1.5 Q8.5")],
    "surface-speed-on-the-axis": [("G96 S120", "G97 S3000"), ("G96", "G50 S3000\nG96")],
    "surface-speed-rounds-to-zero": [("S0.01", "S120")],
    "thread-g32-fanuc": [("G32 Z-30. F1.5", "G1 Z-30. F0.05"), (" N1.5", "")],
    "thread": [("G33 Z-30. F1.5", "G1 Z-30. F0.05"), (" N1.5", "")],
    "threading-cycle": [("G92 X18. Z-30. F1.5", "G1 X18. Z-30. F0.05"), (" N1.5", "")],
    "tool-change-in-the-block": [("G1 Z-30. F0.05 N1.5 T0202", "T0202\nG0 X20. Z2.\nG1 Z-30. F0.05 N1.5")],
    "turning-cycle": [("G90 X18.", "G1 X18."), (" N1.5", "")],
    "unreadable-block-in-a-chain": [("X2O.", "X20."), ("X2O.", "(VIB OFF)\nX2O.")],
}
START = "move Z to an absolute position with G0 before the cut"


def ways_of(stem: str) -> list[Way]:
    """What is done about a bad program; all those with an unknown start have one way out."""
    if stem in WAYS:
        return WAYS[stem]
    if stem == "start-not-known-behind-a-jump":
        return [("N100 G1", "N100 G0 X20. Z2.\nG1")]
    return [("G1 Z-30.", "G0 X20. Z2.\nG1 Z-30.")] if stem.startswith("start-not-known") else []


# The first way out of each; the others in the long form.
CASES = [
    pytest.param(file.stem, way, id=f"{file.stem}-{way}", marks=pytest.mark.long if at else ())
    for file in FILES
    for at, way in enumerate(ways_of(file.stem))
]


@pytest.mark.parametrize(("stem", "way"), CASES)
def test_the_way_out_works(stem: str, way: Way) -> None:
    text = next(file for file in FILES if file.stem == stem).read_text("latin-1")
    _, _, _, profile, sets = expectation(text)
    head, _, program = text.partition("\n")
    if isinstance(way, str):
        sets = [*sets, way]
    else:
        old, new = way
        program, count = re.subn(old, new, program)
        assert count, "the advice is of another program"
    result = chipbreak.rewrite(f"{head}\n{program}".encode("latin-1"), chipbreak.load(profile, sets))
    assert not [d for d in result.diagnostics if d.severity.value == "error"]


def test_every_refused_program_has_a_way_out() -> None:
    without = [file.stem for file in FILES if not ways_of(file.stem)]
    assert not without, "say what their help tells to do"


def written_instead(text: str, said: chipbreak.Diagnostic, other: str) -> bytes:
    """The program with another text where a diagnostic points."""
    assert said.place is not None
    lines = text.split("\n")
    line = lines[said.place.line - 1]
    lines[said.place.line - 1] = line[: said.place.column - 1] + other + line[said.place.end_column - 1 :]
    return "\n".join(lines).encode("latin-1")


def test_what_an_editor_may_write_instead_works() -> None:
    """Every text that a diagnostic offers, in every bad program: with it, the program is taken."""
    tried = set()
    for file in FILES:
        text = file.read_text("latin-1")
        _, _, _, profile, sets = expectation(text)
        settings = chipbreak.load(profile, sets)
        for said in chipbreak.check(text.encode("latin-1"), settings, file.name):
            for other in said.instead:
                found = chipbreak.check(written_instead(text, said, other), settings, file.name)
                errors = [one for one in found if one.severity is chipbreak.Severity.ERROR]
                assert not errors, (file.stem, other, errors)
                tried.add(said.code)
    assert {"SYN003", "VIB004", "VIB005", "VIB006", "VIB030", "VIB031", "VIB032"} <= tried
