"""A cut behind a subprogram: what that may have set otherwise is said again, or the cut is refused."""

from __future__ import annotations

import pytest

import chipbreak

MAIN = (
    "O1\nG21 G99 G97 G18\nT0101\nS2000 M3\nG0 X30. Z2.\nF0.1\n{call}\n{again}\n"
    "G0 X30. Z2.\nG1 Z-2. N1.5\nM30\n"
)


def filtered(body: str, again: str = "", call: str = "M98 P2") -> chipbreak.Result:
    program = MAIN.format(call=call, again=again) + (f"O2\n{body}\nM99\n" if body else "")
    return chipbreak.rewrite(program.encode(), chipbreak.load("fanuc-lathe"), "a.nc")


@pytest.mark.parametrize("body", ["G0 X40.", "G0 X40.\nM8", "(nothing)", "M98 P3\nM99\nO3\nG0 X50."])
def test_what_says_neither_changes_nothing(body: str) -> None:
    assert filtered(body).changed


@pytest.mark.parametrize(
    ("body", "again", "code", "said"),
    [
        ("F0.2", "", "VIB050", "the feed is not known: what line 7 calls may say another F"),
        ("S3000", "", "VIB053", "the spindle speed is not known: what line 7 calls may say another S"),
        ("/S3000", "", "VIB053", "may say another S"),
        ("M98 P3\nM99\nO3\nS3000 F0.2", "S2000", "VIB050", "may say another F"),
        ("G1 X#1 F#2", "", "VIB050", "may say another F"),
        ("F0.2", "F0.1 S2000\nM98 P2", "VIB050", "what line 9 calls may say another F"),
        ("G20", "", "VIB050", "what line 7 calls leaves the units (G20, G21) changed"),
        ("G98 F100.", "F0.1", "VIB050", "leaves the feed mode (G93, G94, G95) changed"),
    ],
)
def test_what_may_be_otherwise_is_refused(body: str, again: str, code: str, said: str) -> None:
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        filtered(body, again)
    (error,) = [found for found in caught.value.diagnostics if found.severity.value == "error"]
    assert (error.code, said in error.message) == (code, True)


def warned(result: chipbreak.Result) -> list[str]:
    return [said.message for said in result.diagnostics if said.code == "VIB095"]


@pytest.mark.parametrize("call", ["M98 P9", "G65 P9"])
def test_what_nobody_can_follow_is_said(call: str) -> None:
    (message,) = warned(filtered("", call=call))
    assert message == (
        "what line 7 calls is not in this file; that F0.1 holds behind it is taken for granted"
    )
    assert not warned(filtered("", "F0.1 S2000", call))


def test_what_calls_itself_has_an_end() -> None:
    assert not warned(filtered("M98 P2"))


@pytest.mark.parametrize(
    ("body", "again"),
    [
        ("F0.2 S3000", "F0.1 S2000"),
        ("G20\nG21", ""),
        ("G20", "G21"),
        ("G98 F100.", "G99 F0.1"),
        ("G96 S100", "G97 S2000"),
    ],
)
def test_the_ways_out(body: str, again: str) -> None:
    assert filtered(body, again).changed
