"""What the macros must not leave behind (another preselected tool, the data of another tool), or run into."""

from __future__ import annotations

from pathlib import Path

import pytest

from chipbreak.dialects.check_programs import O_WORDS
from linuxcnc import laser

from .cases import STRAIGHT
from .lc_stand import LC_SETTINGS, alarms, subroutines
from .stand import BAR, BAR_NUMBER, BEAM, SETTINGS, Stand

CHECK = "G65 P8901 T{tool} S5000"
TRACE = "G65 P8902 T{tool} Z4. S5000"


@pytest.fixture
def stand() -> Stand:
    stand = Stand(STRAIGHT, STRAIGHT.real())
    stand.station.tools[2] = STRAIGHT.real()
    return stand


def test_the_tool_that_waits_for_m6_still_waits_behind_the_master_bar(stand: Stand) -> None:
    """T1, CALIBRATE, M6: without its T again the master bar would be back in the spindle."""
    assert stand.run("T2 M6\nT1\nG65 P8900\nM6") == ""
    assert stand.machine.tool == 1
    assert stand.run("G65 P8900\nT2 M6") == ""
    assert stand.machine.tool == 2


def test_where_no_tool_was_called_yet_none_waits(stand: Stand) -> None:
    assert stand.run("G65 P8900") == ""
    assert stand.machine.tool == BAR_NUMBER
    assert stand.control.modes.words["T"] == BAR_NUMBER


@pytest.mark.parametrize("call", [CHECK, TRACE])
def test_a_call_without_data_alarms_again_when_it_is_repeated(stand: Stand, call: str) -> None:
    """RESET, and once more: the data of the tool before must not be taken for that of this one."""
    stand.calibrate()
    assert stand.run(f"T1 M6\n{STRAIGHT.data(1)}\n{CHECK.format(tool=1)}") == ""
    for _ in range(2):
        assert stand.run("T2 M6\n" + call.format(tool=2)) == "CALL"
    lacks_length = STRAIGHT.data(2).replace("H50.", "")
    assert lacks_length != STRAIGHT.data(2)
    assert stand.run(lacks_length) == "CALL"
    assert stand.run(call.format(tool=2)) == "CALL"


def test_behind_a_chip_check_the_length_of_another_tool_does_not_count(stand: Stand) -> None:
    stand.calibrate()
    data = {tool: STRAIGHT.data(tool) for tool in (1, 2)}
    for tool in (1, 2):
        calls = f"{data[tool]}\n{CHECK.format(tool=tool)}\n{TRACE.format(tool=tool)}"
        assert stand.run(f"T{tool} M6\n{calls}") == ""
    assert stand.run("T1 M6\nG65 P8903 T1 W0.02 Z4.") == ""
    assert stand.run(CHECK.format(tool=1)) == "CALL"
    assert stand.run(f"{data[1]}\n{CHECK.format(tool=1)}") == ""


@pytest.mark.parametrize("pulled_mm", [0.5, 2.5, 8.0])
def test_a_tool_that_the_cut_has_pulled_out_does_not_cross_the_beam(stand: Stand, pulled_mm: float) -> None:
    """``run`` asserts that nothing but a skip move breaks it; on LinuxCNC such a move aborts the program."""
    stand.calibrate()
    assert stand.run(f"T1 M6\n{STRAIGHT.data(1)}\n{CHECK.format(tool=1)}\n{TRACE.format(tool=1)}") == ""
    stand.change(STRAIGHT.real(length_mm=STRAIGHT.length_mm + 1.0 + pulled_mm))
    assert stand.run("G65 P8903 T1 W0.02 Z4.") == ""


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("count", [2, pytest.param(5, marks=pytest.mark.long)])
def test_all_of_it_on_the_simulated_linuxcnc(tmp_path: Path, count: int) -> None:
    start = "M68 E0 Q0\no<cb_calibrate> call\nM68 E0 Q1\n"
    data = {tool: STRAIGHT.data(tool, O_WORDS) for tool in (1, 2)}
    check = {tool: f"o<cb_tool_check> call [{tool}] [5000]" for tool in (1, 2)}
    trace = {tool: f"o<cb_trace> call [{tool}] [2]" for tool in (1, 2)}
    now = "(debug, tool #<_current_tool>)"
    pieces = [
        f"M68 E0 Q0\nT2 M6\nT1\no<cb_calibrate> call\n{now}\nM6\n{now}\nM2\n",
        f"{start}{data[1]}\n{check[1]}\n{check[2]}\nM2\n",
        f"M68 E0 Q1\n{check[2]}\nM2\n",
        f"{start}{data[1]}\n{check[1]}\n{trace[1]}\n{data[2]}\n{check[2]}\n"
        f"o<cb_chip_check> call [1] [0.02] [1]\n(debug, fine)\n{check[1]}\nM2\n",
        f"{start}{data[1]}\n{check[1]}\n{trace[1]}\nM68 E0 Q2\no<cb_chip_check> call [1] [0.02] [1]\nM2\n",
    ]
    expected = [
        [],
        ["100 TOOL 2 CALL LACKS A VALUE"],
        ["100 TOOL 2 CALL LACKS A VALUE"],
        ["100 TOOL 1 CALL LACKS A VALUE"],
        [],
    ][:count]
    assert SETTINGS.master_tool == BAR_NUMBER
    runs = laser.run_until(
        lambda runs: alarms(runs) == expected,
        ["\n".join(["", piece]).encode() for piece in pieces[:count]],
        tools=[BAR, STRAIGHT.real(), STRAIGHT.real(length_mm=STRAIGHT.length_mm + 4.5)],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, tmp_path),
    )
    assert alarms(runs) == expected
    said = [text.strip() for text in runs[0].messages]
    assert [text for text in said if text.startswith("tool")] == ["tool 3.000000", "tool 1.000000"]
