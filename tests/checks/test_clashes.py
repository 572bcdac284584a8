"""Programs that use variables which the macros of the checks work in."""

from __future__ import annotations

import re
from importlib import resources

import pytest

import chipbreak
from chipbreak.dialects.check_programs import MACRO_B

BODY = "T1 M6\nS1000 M3\nG0 X1. Y2.\nG43 Z15. H1\n{line}\nG1 Z-1. F100.\n{cut}\nG0 Z15.\nM30\n"


def rewritten(line: str, cut: str, profile: str, *options: str) -> chipbreak.Result:
    data = BODY.format(line=line, cut=cut).encode()
    return chipbreak.rewrite(data, chipbreak.load(profile, options))


def told(result: chipbreak.Result) -> list[str]:
    return [d.message for d in result.diagnostics if d.code == "CHK009"]


@pytest.mark.parametrize(
    ("profile", "line", "cut", "what"),
    [
        ("fanuc-mill", "#105=4.", "X#105", "#105"),
        ("fanuc-mill", "", "X[#150+1.]", "#150"),
        ("fanuc-mill", "#600=1", "X4.", "#600"),
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
    ("profile", "line", "options"),
    [
        ("fanuc-mill", "#99=4.", ()),
        ("fanuc-mill", "#151=4.", ()),
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
