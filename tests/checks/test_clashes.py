"""Programs that use variables or program numbers of the macros of the checks."""

from __future__ import annotations

import re
from importlib import resources

import pytest

import chipbreak
from beam import BEAM
from chipbreak.dialects.check_programs import MACRO_B, MACRO_B_SETS

BODY = "T1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\n{line}\nG1 Z-1. F100.\n{cut}\nG0 Z15.\nM30\n"


def rewritten(line: str, cut: str, profile: str, *options: str) -> chipbreak.Result:
    data = BODY.format(line=line, cut=cut).encode()
    return chipbreak.rewrite(data, chipbreak.load(profile, (*BEAM, *options)))


def told(result: chipbreak.Result) -> list[str]:
    return [d.message for d in result.diagnostics if d.code == "CHK009"]


@pytest.mark.parametrize(
    ("profile", "line", "cut", "what"),
    [
        ("fanuc-mill", "#105=4.", "X#105", "#105"),
        ("fanuc-mill", "", "X[#150+1.]", "#150"),
        ("fanuc-mill", "#600=1", "X4.", "#600"),
        ("fanuc-mill", "#500=1", "X4.", "#500"),
        ("fanuc-mill", "#999=1", "X4.", "#999"),
        ("fanuc-mill", "#1=2", "X#[#1+1]", "worked out"),
        ("fanuc-mill", "IF [#140 EQ 2] GOTO 9", "N9 X4.", "#140"),
        ("linuxcnc-mill", "#700=4", "X4", "#700"),
        ("linuxcnc-mill", "#<_CB_Limit>=4", "X4", "#<_cb_limit>"),
    ],
)
def test_a_program_with_a_variable_of_the_macros_gets_no_check(
    profile: str, line: str, cut: str, what: str
) -> None:
    result = rewritten(line, cut, profile)
    assert not result.changed
    (message,) = told(result)
    assert what in message
    with pytest.raises(chipbreak.ProgramRejectedError):
        rewritten(line, cut, profile, "checks.strict=true")


@pytest.mark.parametrize(
    ("line", "options", "ranges"),
    [
        ("#105=4.", (), "#100 to #179 and #500 to #999"),
        ("#205=4.", ("macros.first_variable=200",), "#200 to #279 and #500 to #999"),
        ("#705=4.", ("macros.store_first=700",), "#100 to #179 and #700 to #999"),
    ],
)
def test_all_variables_of_the_macros_are_said(line: str, options: tuple[str, ...], ranges: str) -> None:
    """From the first to the last: another variable is free when it lies in none of them."""
    (message,) = told(rewritten(line, "X4.", "fanuc-mill", *options))
    assert message.endswith(f"the macros they call use {ranges}")


@pytest.mark.parametrize(
    ("profile", "line", "options"),
    [
        ("fanuc-mill", "#99=4.", ()),
        ("fanuc-mill", "#180=4.", ()),
        ("fanuc-mill", "#105=4.", ("macros.first_variable=200",)),
        ("fanuc-mill", "#600=4.", ("macros.store_first=700",)),
        ("fanuc-mill", "#105=4.", ("checks.calls=haas",)),
        ("linuxcnc-mill", "#105=4", ()),
        ("linuxcnc-mill", "#<_mine>=4", ()),
    ],
)
def test_other_variables_and_other_calls_do_not_matter(
    profile: str, line: str, options: tuple[str, ...]
) -> None:
    result = rewritten(line, "X4.", profile, *options)
    assert told(result) == []
    assert result.changed


def test_where_nothing_is_checked_nothing_is_said() -> None:
    result = rewritten("#105=4.", "X4.", "fanuc-mill", "checks.ignore=[1]")
    assert told(result) == []


def test_the_shipped_macros_work_in_no_other_variables() -> None:
    folder = resources.files("chipbreak") / "macros" / "fanuc"
    numbers = {
        int(number)
        for file in folder.iterdir()
        if file.name.endswith(".nc")
        for number in re.findall(r"#(\d+)", file.read_text("ascii"))
    }
    commons = {number for number in numbers if 100 <= number < 1000}
    assert commons
    assert commons <= set(MACRO_B.working)


def numbers_told(program: str, profile: str, *options: str) -> list[chipbreak.Diagnostic]:
    """What is said of program numbers, in a program that gets no check where anything is."""
    result = chipbreak.rewrite(program.encode(), chipbreak.load(profile, (*BEAM, *options)))
    found = [d for d in result.diagnostics if d.code == "CHK010"]
    assert result.changed != bool(found)
    return found


@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("G65 P8900 Z10. F3000", "P8900 with F, Z"),
        ("G65 P8901 Z0. S1", "P8901 with S, Z"),
        ("G65 P8901 S1000", "P8901 with S,"),
        ("G65 P8902 Z-5. X20.", "P8902 with X, Z"),
        ("G65 P8904 D20.", "P8904 with D,"),
        ("G65 P8905", "P8905 without arguments"),
        ("G66 P8913 A1.\nG67", "P8913 with A,"),
        ("M98 P8900", "P8900 without arguments"),
        ("M98 P38901", "P8901 without arguments"),
    ],
)
def test_a_program_that_calls_another_maker_s_programs_gets_no_call_of_ours(call: str, what: str) -> None:
    program = BODY.format(line="G0 Z50.", cut="X4.").replace("T1 M6", f"{call}\nT1 M6", 1)
    (found,) = numbers_told(program, "fanuc-mill")
    assert f"this program calls {what}" in found.message
    assert found.message.startswith("left out: all checks")
    assert found.place is not None and found.place.line == 1
    assert "checks.calls" in found.help and "[calls.NAME]" in found.help
    with pytest.raises(chipbreak.ProgramRejectedError):
        numbers_told(program, "fanuc-mill", "checks.strict=true")
    shop = ('calls.shop={chip_check="G65 P8501 T{tool}"}', "checks.calls=shop")
    assert numbers_told(program, "fanuc-mill", *shop) == []
    assert numbers_told(program, "fanuc-mill", "checks.calls=renishaw") == []


@pytest.mark.parametrize("before", ["G0 Z50.", "G4 P1.5", "G4 P500"])
def test_a_call_is_found_wherever_it_stands(before: str) -> None:
    program = BODY.format(line=f"G0 Z50.\n{before}\nG65 P8905", cut="X4.")
    (found,) = numbers_told(program, "fanuc-mill")
    assert "this program calls P8905 without arguments" in found.message
    assert found.place is not None and found.place.line == 7


@pytest.mark.parametrize(
    ("call", "what"),
    [
        ("G65 P9843", "P9843, a number of probe makers (Renishaw, Blum, Haas)"),
        ("G65 P9853 T1 B0. H0.1", "P9853, a number of probe makers"),
    ],
)
def test_a_maker_s_program_is_on_the_control_instead_of_ours_where_the_numbers_are_the_same(
    call: str, what: str
) -> None:
    program = BODY.format(line="G0 Z50.", cut="X4.").replace("T1 M6", f"{call}\nT1 M6", 1)
    assert numbers_told(program, "fanuc-mill") == []
    (found,) = numbers_told(program, "fanuc-mill", "macros.first_program=9810")
    assert f"this program calls {what}" in found.message
    # Ours are 33 programs, P8900 to P8932 as they are delivered.
    assert found.message.endswith("whose programs also take P9810 to P9842")


def test_a_number_of_ours_is_named_before_one_beside_ours() -> None:
    program = BODY.format(line="G0 Z50.", cut="X4.")
    program = program.replace("T1 M6", "G65 P9843\nG65 P9810 Z10.\nT1 M6", 1)
    (found,) = numbers_told(program, "fanuc-mill", "macros.first_program=9810")
    assert found.place is not None and found.place.line == 2


@pytest.mark.parametrize(
    "call", ["G65 P8919 T2", "G65 P8900", "G65 P8901 T1 S1000 K3", "G65 P1234 X1.", "M98 P1234", "M97 P8901"]
)
def test_calls_as_the_checks_call_do_not_matter(call: str) -> None:
    program = BODY.format(line="G0 Z50.", cut="X4.").replace("T1 M6", f"{call}\nT1 M6", 1)
    assert numbers_told(program, "fanuc-mill") == []


@pytest.mark.parametrize(
    ("profile", "program", "name"),
    [
        ("fanuc-mill", "{body}O8901\nG0 X1.\nM99\n", "O8901"),
        ("fanuc-mill", "O8903 (MINE)\n{body}", "O8903"),
        ("haas-mill", "{body}O9853\nG0 X1.\nM99\n", "O9853"),
        ("linuxcnc-mill", "o<CB_Trace> sub\nG0 X1\no<CB_Trace> endsub\n{body}", "o<CB_Trace>"),
    ],
)
def test_a_program_that_defines_what_a_check_would_call_gets_none(
    profile: str, program: str, name: str
) -> None:
    body = BODY.format(line="G0 Z50.", cut="X4.")
    (found,) = numbers_told(program.format(body=body), profile)
    assert f"{name} is defined in this program" in found.message
    other = program.replace("O8", "O7").replace("O9", "O7").replace("CB_", "MINE_")
    assert numbers_told(other.format(body=body), profile) == []


def test_the_letters_of_our_calls_are_those_of_the_templates() -> None:
    """What a program may call by hand is what the checks write, and the release of a locked tool."""
    sets = MACRO_B_SETS["builtin"]
    written: dict[int, set[str]] = {8919: {"T"}}
    for kind, blocks in sets.blocks.items():
        for block in blocks:
            text = block + (sets.tails.get(kind, "") if block == blocks[-1] else "")
            written.setdefault(int(text[5:9]), set()).update(re.findall(r" ([A-Z])\{", text))
    assert {number: set(letters) for number, letters in MACRO_B.arguments.items()} == {
        **written,
        8902: written[8902] | {"S"},  # a TRACE by hand may say its speed
    }
    files = {int(file.name[1:5]) for file in (resources.files("chipbreak") / "macros" / "fanuc").iterdir()}
    files |= {int(name[1:5]) for name in MACRO_B.written}
    assert files <= set(MACRO_B.numbers)
