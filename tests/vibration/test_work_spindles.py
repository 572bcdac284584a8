"""Spindles that the program chooses by P and turns under G96 turn the work; each keeps its own speed."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

import chipbreak
from chipbreak.settings import load
from chipbreak.text.diagnostics import ProgramRejectedError

MAIN = """G21 G99 G40
T0101
G50 S3000
G96 S150 M03 P11
G0 X40. Z2.
G1 Z-20. F0.2
X44.
G0 X60. Z5.
"""
SUB = """T0202
G97 S900 M04 P13
G0 X30. Z2.
G1 Z-15. F0.2
G0 X60. Z5.
G96 S120 M04 P13
G0 X24. Z2.
G1 Z-8. F0.2
G0 X60. Z5.
"""
END = "M05 P11\nM30\n"
ASKED = ["vibration.n=1.5"]


def rewritten(text: str, *options: str) -> chipbreak.Result:
    """The result, with the way back and the second run looked after."""
    settings = load("fanuc-lathe", [*ASKED, *options])
    result = chipbreak.rewrite(text.encode(), settings)
    assert chipbreak.restore(result.data) == text.encode()
    assert chipbreak.rewrite(result.data, settings).data == result.data
    return result


def spindles(text: str) -> Iterator[tuple[str, bool, dict[str, tuple[str, str]]]]:
    """Each block, whether it is one of the filter's, and how each spindle turns behind it.

    A reader of its own: S and M3 without P are for the spindle that was named last, G96 and G97 are modal.
    """
    mode = "G97"
    chosen = ""
    turns: dict[str, tuple[str, str]] = {}
    is_ours = False
    for line in text.splitlines():
        is_ours = _is_ours(line, is_ours)
        code = re.sub(r"\([^)]*\)", "", line)
        mode = _last(r"(G9[67])\b", code, mode)
        chosen = _last(r"P(\d+)", code, chosen)
        speed = "" if "G50" in code else _last(r"S(\d+)", code, "")
        turns = {**turns, chosen: (mode, speed)} if speed else turns
        yield line, is_ours, turns


def _is_ours(line: str, is_ours: bool) -> bool:
    bracket = re.match(r"\(CHIPBREAK (BEGIN|END)", line)
    return is_ours if bracket is None else bracket[1] == "BEGIN"


def _last(pattern: str, code: str, otherwise: str) -> str:
    found = re.findall(pattern, code)
    return found[-1] if found else otherwise


def test_the_cuts_of_each_spindle_vibrate() -> None:
    result = rewritten(MAIN + SUB + END)
    assert len(result.cuts) == 3
    ours = [line for line, is_ours, _ in spindles(result.data.decode()) if is_ours]
    said = [line for line in ours if re.search(r"\bS\d", line) and not line.startswith("(")]
    assert said
    assert all(re.search(r" P1[13]$", line) for line in said)


def test_each_spindle_turns_as_programmed_where_it_counts() -> None:
    """At every block that does not vibrate and cuts, or starts a spindle, all of them do."""
    program = MAIN + SUB + MAIN + END
    result = rewritten(program)
    own = iter([(line, turns) for line, _, turns in spindles(program)])
    compared = 0
    for line, is_ours, turns in spindles(result.data.decode()):
        if is_ours or line.startswith("(CHIPBREAK"):
            continue
        was = next(one for one in own if one[0] == line)
        if re.search("M03|M04|M30", line) or line.startswith(("G1", "X44")):
            assert turns == was[1], line
            compared += 1
    assert compared == 5


@pytest.mark.parametrize(
    "other",
    [
        "T0303\nG97 S900 M03 P12\nG0 X20. Z2.\nG1 Z-10. F0.2\n",  # nothing shows what it turns
        "T0303\nG97 S900\nM03 P13\nG0 X20. Z2.\nG1 Z-10. F0.2\n",  # whose S that is
        "T0303\nP13\nG0 X20. Z2.\nG97 S900 P13\nG1 Z-10. F0.2\n",  # nothing has started it
        "/G97 S900 M03 P13\nG0 X20. Z2.\nG1 Z-10. F0.2\n",
    ],
)
def test_what_is_not_known_of_a_spindle_stays(other: str) -> None:
    program = f"{MAIN}{other}{SUB}{END}"
    result = rewritten(program)
    assert b"WAS G1 Z-10." not in result.data
    assert len(result.cuts) == 3


def test_a_spindle_without_surface_speed_shows_nothing() -> None:
    program = (MAIN.replace("G96 S150", "G97 S900") + END).encode()
    assert chipbreak.rewrite(program, load("fanuc-lathe", ASKED)).data == program
    with pytest.raises(ProgramRejectedError) as refused:
        chipbreak.rewrite(b"(VIB N1.5)\n" + program.replace(b"T0101\n", b""), load("fanuc-lathe"))
    assert "VIB069" in {one.code for one in refused.value.diagnostics}


def test_a_p_that_may_name_an_axis_shows_nothing() -> None:
    program = (MAIN.replace("P11", "P1") + END).encode()
    assert chipbreak.rewrite(program, load("fanuc-lathe", ASKED)).data == program


def test_a_program_without_p_is_as_before() -> None:
    result = rewritten(MAIN.replace(" P11", "") + "M30\n")
    assert len(result.cuts) == 1
    assert not result.shown.spindles
    assert b" P" not in re.sub(rb"\([^)]*\)", b"", result.data)


def test_an_s_without_p_behind_another_spindle_is_written_as_the_program_writes_it() -> None:
    """What P12 is, nobody knows; the S behind it is for whatever the program starts with it."""
    program = MAIN + "M3 P12\nT0303\nG97 S900 M3\nG0 X20. Z2.\nG1 Z-10. F0.2\nG0 X60. Z5.\n" + END
    result = rewritten(program)
    assert len(result.cuts) == 2
    ours = [line for line, is_ours, _ in spindles(result.data.decode()) if is_ours and "WAS" not in line]
    assert {line for line in ours if re.match(r"S\d+$", line)}
