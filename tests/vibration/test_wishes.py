"""A wish for vibration that nothing answers is said, and so is what was meant as one and is none."""

from __future__ import annotations

import pytest

import chipbreak
from machine_reader import beside_unproven

HEAD = "G97 S3000 M3\nG0 X20. Z2.\n"
WISH = ("vibration.n=1.5",)
STRICT = "checks.strict=true"


def said(program: str, *sets: str, profile: str = "generic-lathe") -> list[tuple[str, int, str]]:
    """Code, line and severity of all that is said; what no wish reached must not change."""
    all_found = chipbreak.check(program.encode(), chipbreak.load(profile, sets))
    found = beside_unproven(all_found, any(d.code == "VIB079" for d in all_found))
    return [(d.code, d.place.line if d.place else 0, d.severity.value) for d in found]


MOVED_BY_THE_CONTROL = [
    pytest.param("G74 R1.\nG74 Z-30. Q5000 F0.1", "1 cycle was", id="G74"),
    pytest.param("G75 R1.\nG75 X10. P5000 F0.1", "1 cycle was", id="G75"),
    pytest.param("G92 X18. Z-20. F1.5", "1 thread was", id="G92"),
    pytest.param("G32 Z-20. F1.5", "1 thread was", id="G32"),
    pytest.param("G76 P020060 Q50 R0.05\nG76 X18. Z-20. P900 Q200 F1.5", "1 thread was", id="G76"),
    pytest.param("G83 Z-20. Q5000 F0.1\nG80", "1 cycle was", id="G83"),
    pytest.param("M98 P100", "1 call was", id="M98"),
    pytest.param("G65 P9100 X1.", "1 call was", id="G65"),
]


@pytest.mark.parametrize(("blocks", "counted"), MOVED_BY_THE_CONTROL)
@pytest.mark.parametrize("how", ["directive", "profile"])
def test_what_the_control_moves_by_itself(blocks: str, counted: str, how: str) -> None:
    wish = "(VIB N1.5)\n" if how == "directive" else ""
    sets = WISH if how == "profile" else ()
    program = f"{HEAD}{wish}{blocks}\nG0 X60. Z5.\nM30\n"
    result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe", sets))
    (warning,) = (d for d in result.diagnostics if d.code == "VIB065")
    assert counted in warning.message
    assert warning.severity.value == "warning"
    assert not result.changed
    found = said(program, STRICT, *sets, profile="fanuc-lathe")
    assert [(code, severity) for code, _, severity in found if code == "VIB065"] == [("VIB065", "error")]
    way_out = program.replace(wish, "") if wish else program
    assert not said(way_out, profile="fanuc-lathe")


def test_a_profile_says_once_what_it_passed_over() -> None:
    program = (
        f"{HEAD}G1 Z-30. F0.05\nG0 X30. Z2.\n"
        + "G83 Z-20. Q5000 F0.1\nG80\nG0 X30. Z2.\n" * 12
        + "G32 Z-20. F1.5\nG0 Z2.\n" * 3
        + "M30\n"
    )
    (found,) = beside_unproven(chipbreak.check(program.encode(), chipbreak.load("fanuc-lathe", WISH)))
    assert found.code == "VIB067"
    assert found.message.startswith("12 cycles, 3 threads were not vibrated")
    assert found.place is not None
    assert found.place.line == 5


def test_threads_beside_cuts_are_no_news() -> None:
    assert not said(f"{HEAD}G1 Z-30. F0.05\nG0 Z2.\nG32 Z-20. F1.5\nM30\n", *WISH, profile="fanuc-lathe")


@pytest.mark.parametrize(
    ("program", "line", "why"),
    [
        pytest.param(f"{HEAD}(VIB N1.5)\nG0 X30.\nM30\n", 3, "no cut stands behind it", id="no cut"),
        pytest.param(
            f"{HEAD}(VIB N1.5)\nT0101\nG0 X20. Z2.\nG1 Z-30. F0.05\nM30\n",
            3,
            "line 4 ends it",
            id="tool call",
        ),
        pytest.param(
            f"{HEAD}(VIB N1.5)\n(VIB OFF)\nG1 Z-30. F0.05\nM30\n",
            3,
            "line 4 ends it",
            id="turned off at once",
        ),
    ],
)
def test_a_directive_that_reaches_nothing(program: str, line: int, why: str) -> None:
    (found,) = chipbreak.check(program.encode(), chipbreak.load("fanuc-lathe"))
    assert (found.code, found.place and found.place.line) == ("VIB065", line)
    assert why in found.message


@pytest.mark.parametrize(
    "program",
    [
        pytest.param(f"{HEAD}(VIB OFF)\nG0 X30.\nM30\n", id="off asks for nothing"),
        pytest.param(f"{HEAD}(VIB ALPHA0.5)\nG1 Z-30. F0.05 N1.5\nM30\n", id="values for words"),
        pytest.param(f"{HEAD}G0 X30.\nM30\n", id="a program without a cut"),
    ],
)
@pytest.mark.parametrize("sets", [(), WISH], ids=["no wish", "profile"])
def test_nothing_to_say(program: str, sets: tuple[str, ...]) -> None:
    assert not said(program, *sets)


@pytest.mark.parametrize(
    ("comment", "right"),
    [
        ("VIBRATION N1.5", "(VIB N1.5)"),
        ("VIBN1.5", "(VIB N1.5)"),
        ("vibrate n1.5 q1.4", "(VIB N1.5 Q1.4)"),
        ("VIB: N1.5", "(VIB N1.5)"),
        ("VIB_OFF", "(VIB OFF)"),
        ("VIBRATION OFF", "(VIB OFF)"),
        ("VIBRATION DAMPED BAR", ""),
        ("VIBRATION TEST F100", ""),
        ("VIBRATION ON THE FAR SIDE", ""),
        ("AVOID VIBRATION N1.5", ""),
        ("VIBRATORY FEEDER", ""),
    ],
)
def test_a_comment_that_was_meant(comment: str, right: str) -> None:
    program = f"{HEAD}({comment})\nG1 Z-30. F0.05\nM30\n"
    found = chipbreak.check(program.encode(), chipbreak.load("generic-lathe"))
    assert [(d.code, d.place and d.place.line) for d in found] == ([("VIB066", 3)] if right else [])
    assert all(right in d.help for d in found)
    if right and "OFF" not in right:
        # The way out works.
        result = chipbreak.rewrite(
            program.replace(f"({comment})", right).encode(), chipbreak.load("generic-lathe")
        )
        assert result.changed


@pytest.mark.parametrize(
    ("block", "is_said"),
    [
        pytest.param("N1.5 G1 Z-30. F0.05", True, id="a count where the number stands"),
        pytest.param("N10 G1 Z-30. F0.05", False, id="a number"),
        pytest.param("N10. G1 Z-30. F0.05", False, id="a number with a point"),
        pytest.param("N1.5 G0 Z-30.", False, id="a rapid"),
        pytest.param("N1.5 M8", False, id="no axis word"),
        pytest.param("(N1.5) G1 Z-30. F0.05", False, id="in a comment"),
    ],
)
def test_a_count_that_is_a_block_number(block: str, is_said: bool) -> None:
    assert [code for code, _, _ in said(f"{HEAD}{block}\nM30\n")] == ["VIB066"] * is_said


def test_many_counts_are_said_once() -> None:
    program = HEAD + "".join(f"N{n}.5 G1 Z-{n}. F0.05\n" for n in range(1, 40)) + "M30\n"
    (found,) = chipbreak.check(program.encode(), chipbreak.load("generic-lathe"))
    assert "and of 38 more" in found.message


CYCLE = (
    "G97 S1000 M3\nG0 X52. Z2.\nG71 U2. R0.5\nG71 P140 Q220 U0.4 F0.3\nG1 X30. Z0.\nX36. Z-30.\nX52.\nM30\n"
)


@pytest.mark.parametrize(
    ("program", "codes"),
    [
        (CYCLE, ["CYC001"]),
        (CYCLE.replace("G1 X30.", "N140 G1 X30."), ["CYC001"]),  # the end is missing
        (CYCLE.replace("G71 U2. R0.5", "(NO DEPTH)").replace("G1 X30.", "N140 G0 X30.\nN220 G1"), ["CYC004"]),
        (CYCLE.replace("X52.\nM30", "G83 Z-20. Q5000 F0.1\nM30"), ["CYC001", "VIB067"]),
    ],
)
def test_why_a_cycle_stays_is_said_once(program: str, codes: list[str]) -> None:
    """By the profile a warning; a directive over the cycle alone is an error, and nothing else is said."""
    result = chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe", ["vibration.n=1.5"]))
    assert [one.code for one in beside_unproven(result.diagnostics, bool(result.cuts))] == codes
    one_wish = program.replace("G71 U2.", "(VIB N1.5)\nG71 U2.").replace("(NO DEPTH)", "(VIB N1.5)")
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(one_wish.encode(), chipbreak.load("fanuc-lathe"))
    assert [one.code for one in caught.value.diagnostics] == codes[:1]
    quiet = [one.code for one in chipbreak.check(program.encode(), chipbreak.load("fanuc-lathe"))]
    assert quiet == (["MOD003"] if codes[0] == "CYC001" else [])
