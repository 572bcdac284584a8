"""Subprograms between checks: followed where they stand in the file, refused where nobody knows them."""

from __future__ import annotations

import pytest

from checks.filtered import Filtered, check, filtered

START = "O1\nG90 G21\nT1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\nG1 Z-1. F100.\nG0 Z15.\n"
BEHIND = "G0 Z15.\n(FINISH)\nG0 X1. Y2.\nG1 Z-1. F100.\nG0 Z15.\n"
NEXT_TOOL = "T2 M6\nS500 M3\nG0 X1. Y2.\nG43 Z15. H2\nG1 Z-1. F100.\nG0 Z15.\n"


def run(body: str, call: str = "M98 P100", behind: str = BEHIND) -> Filtered:
    sub = f"O100\n{body}M99\n" if body else ""
    result = filtered(f"{START}{call}\n{behind}M30\n{sub}".encode())
    check(result)
    return result


def chip_checks(result: Filtered) -> list[str]:
    return [title for title in result.titles if title.startswith("CHIP")]


@pytest.mark.parametrize("call", ["M98 P100", "M98 P100 L3", "M98 P30100", "G65 P100 A1."])
def test_one_that_only_moves_is_followed(call: str) -> None:
    assert len(chip_checks(run("X5. Y5.\nX6.\n", call))) == 2


def test_of_several_things_that_it_sets_the_same_one_is_named_in_every_run() -> None:
    several = run("G91\nG20\nM8\nG17\nS700\nX5.\n")
    (first, _) = (d for d in several.diagnostics if d.code == "CHK002")
    assert "may or may not have set S;" in first.message or first.message.endswith(
        "may or may not have set S"
    )


def test_what_it_sets_must_be_said_again() -> None:
    left_incremental = run("G91\nX5.\n")
    assert chip_checks(left_incremental) == []
    (first, _) = (d for d in left_incremental.diagnostics if d.code == "CHK002")
    assert (
        "line 9 calls a subprogram, which may or may not have set the distance mode (G90, G91)"
        in first.message
    )
    assert len(chip_checks(run("G91\nX5.\n", behind="G90\n" + BEHIND))) == 2
    assert len(chip_checks(run("G91\nX5.\nM98 P200\nM99\nO200\nG41 D1\nX1.\nG40\nG90\n"))) == 2
    branch = "IF [#1 EQ 1] GOTO 5\nG91\nN5 X5.\nG90\nM8\n"
    assert chip_checks(run(branch)) == []
    assert len(chip_checks(run(branch, behind="G90 M9\n" + BEHIND))) == 2
    left_in_a_cut = run("G1 X5. F100.\nX6.\n", behind=BEHIND.removeprefix("G0 "))
    edit = next(edit for edit in left_in_a_cut.edits if edit.title.startswith("CHIP"))
    assert left_in_a_cut.interpreted.program.source.text(edit.first - 1) == "G0 X1. Y2."  # not before its G0
    assert chip_checks(run("S700\n")) == []
    assert len(chip_checks(run("S700\n", behind="S900\n" + BEHIND))) == 2
    assert chip_checks(run("M98 P200\n")) == []


@pytest.mark.parametrize(
    ("body", "call", "why"),
    [
        ("", "M98 P100", "line 9 is not in this file"),
        ("", "G65 P9100 A1.", "line 9 is not in this file"),
        ("", "M98 P#1", "line 9 is not in this file"),
        ("? what is this\n", "M98 P100", "nobody knows what it leaves in force"),
        ("M98 P100\n", "M98 P100", "nobody knows what it leaves in force"),
        ("T3 M6\nX1.\n", "M98 P100", "line 9 calls tools"),
    ],
)
def test_behind_one_that_nobody_knows_nothing_stands_until_a_tool_is_called(
    body: str, call: str, why: str
) -> None:
    result = run(body, call, BEHIND + NEXT_TOOL)
    assert chip_checks(result) == ["CHIP CHECK T2 W0.02"]
    assert "TOOL CHECK T2, TRACE T2" in result.titles
    refused = [d.message for d in result.diagnostics if d.code == "CHK002"]
    assert len(refused) == 2
    assert all(why in message for message in refused)


def test_o_words_too() -> None:
    sub = "o<hole> sub\n{}o<hole> endsub\n"
    main = START.replace("O1\n", "") + "o<hole> call\n" + BEHIND + "M2\n"
    followed = filtered((sub.format("G0 X5\n") + main).encode(), "linuxcnc-mill")
    check(followed)
    assert len(chip_checks(followed)) == 2
    for body in ("T2 M6\n", "o<drill> call\n"):
        refused = filtered((sub.format(body) + main).encode(), "linuxcnc-mill")
        check(refused)
        assert chip_checks(refused) == []


def test_what_a_body_in_front_of_the_program_says_counts_where_it_is_called_only() -> None:
    """LinuxCNC reads over ``o<mill> sub`` to its endsub: neither its G91 nor its M8 is in force behind it."""
    body = "o<mill> sub\nG91\nM8\nG1 Z-1 F100\nG0 Z10\no<mill> endsub\n"
    cut = "G0 Z10\nG1 Z-2 F100\nG0 Z10\n"
    main = f"T1 M6\nS1000 M3\nG0 X0 Y0\n(ROUGH)\n{cut}(FINISH)\n{cut}M2\n"
    result = filtered((body + main).encode(), "linuxcnc-mill")
    check(result)
    assert result.codes == []
    assert result.titles[:2] == ["CALIBRATE", "TOOL CHECK T1, TRACE T1"]
    written = [text for edit in result.edits for text in edit.content]
    assert not {"G91", "M8", "M9"} & set(written)


def test_a_branch_in_one_that_nobody_has_called_yet_leaves_nothing_open() -> None:
    body = "o<wash> sub\no7 if [#1 GT 2]\nM8\nG91\no7 endif\n/G20\no<wash> endsub\n"
    called = "G21 G90\nT1 M6\nS1000 M3\nG0 X1 Y2\nG43 Z15 H1\nG1 Z-1 F100\nG0 Z15\no<wash> call [3]\n"
    result = filtered(f"{body}{called}(FINISH)\nG0 X1 Y2\nZ3\nG1 Z-2\nG0 Z9\nM2\n".encode(), "linuxcnc-mill")
    check(result)
    assert result.titles == ["CALIBRATE", "TOOL CHECK T1, TRACE T1"]
    assert "line 15 calls a subprogram" in next(d.message for d in result.diagnostics)


@pytest.mark.parametrize(
    "body",
    [
        "IF [#1 EQ 1] GOTO 10\nM99\nN10 S700\n",
        "IF [#1 EQ 1] GOTO 10\nM99\nN10 G91\nX1.\n",
        "IF [#1 EQ 1] GOTO 10\nM99\nN10 IF [#1 EQ 2] GOTO 20\nM99\nN20 M8\n",
        "#2=10\nGOTO #2\nM99\nN10 S700\n",
    ],
    ids=["S", "G91", "in the third branch", "a jump that is worked out"],
)
def test_what_a_branch_behind_the_first_m99_sets_counts(body: str) -> None:
    assert chip_checks(run(body)) == []


def test_what_no_jump_leads_to_behind_an_m99_does_not_count() -> None:
    assert len(chip_checks(run("X5.\nM99\nN10 S700\n"))) == 2
    assert len(chip_checks(run("IF [#1 EQ 1] GOTO 5\nX5.\nN5 X6.\nM99\nN10 S700\n"))) == 2


@pytest.mark.parametrize(
    ("body", "is_known"),
    [
        ("S1000\nWHILE [#1 LT 3] DO1\nX5.\n#1=#1+1\nEND1\n", True),
        ("WHILE [#1 LT 3] DO1\nS1000\nX5.\n#1=#1+1\nEND1\n", True),  # as its one call hands it over
        ("WHILE [#1 LT 3] DO1\nS700\nX5.\n#1=#1+1\nEND1\n", False),
        ("S700\nWHILE [#1 LT 3] DO1\nX5.\n#1=#1+1\nEND1\n", False),  # known, but a start of it was 1000
        ("IF [#1 EQ 1] GOTO 5\nS1000\nM99\nN5 S700\n", False),
        ("S1000\n/S700\nWHILE [#1 LT 3] DO1\nX5.\n#1=#1+1\nEND1\n", False),
        ("S1000\nWHILE [#1 LT 3] DO1\nM98 P200\n#1=#1+1\nEND1\nM99\nO200\nS700\n", False),
    ],
)
def test_an_s_that_all_ways_of_a_loop_bring_is_known_behind_its_subprogram(body: str, is_known: bool) -> None:
    assert len(chip_checks(run(body))) == (2 if is_known else 0)


def test_an_s_of_its_own_is_known_behind_a_subprogram_that_loops_by_label() -> None:
    """The body says S again on every way, so it is known wherever it is called from."""
    body = "o<wash> sub\nS1000\no7 while [#1 GT 2]\nG0 X5\no7 endwhile\n{}o<wash> endsub\n"
    main = START.replace("O1\n", "") + "o<wash> call [3]\n" + BEHIND + "M2\n"
    known = filtered((body.format("") + main).encode(), "linuxcnc-mill")
    check(known)
    assert len(chip_checks(known)) == 2
    returns = "o8 if [#1 GT 9]\nS700\no<wash> return\no8 endif\n"
    assert chip_checks(filtered((body.format(returns) + main).encode(), "linuxcnc-mill")) == []
