"""The LinuxCNC macros: accepted by its interpreter, and run on its simulated machine.

A probe stops within one servo period of feed behind the edge: 0.2 um at the slow feed of 12 mm/min.  The
same happens to the master bar, and values are rounded to 1 um, so the verdicts are those of the exact
simulation for every tool whose measures lie on whole micrometres.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from chipbreak.dialects.check_programs import O_WORDS
from linuxcnc import laser, rs274

from .cases import CASES, STRAIGHT, WITH_A_TWIN, Case
from .lc_stand import LC_SETTINGS, subroutines, verdicts
from .stand import BAR, BEAM

CALLS = (
    "o<cb_calibrate> call",
    *STRAIGHT.data(1, O_WORDS).split("\n"),
    "o<cb_tool_check> call [1] [5000]",
    "o<cb_trace> call [1] [20]",
    "o<cb_chip_check> call [1] [0.02] [1]",
)


@pytest.mark.linuxcnc
def test_the_interpreter_takes_every_macro(tmp_path: Path) -> None:
    """In a preview nothing moves; each file is also called by itself, so that none is left unread."""
    folder = subroutines(LC_SETTINGS, tmp_path)
    program = "\n".join(["G21", "S1000", "F100", *CALLS, "G1 X1", "M2", ""]).encode()
    verdict = rs274.judge(program, lathe=False, subroutines=folder)
    assert verdict.accepted, verdict.message
    assert [(m.kind, m.x_mm, m.y_mm, m.z_mm) for m in verdict.motion] == [("feed", 1.0, 0.0, 0.0)]


@pytest.mark.linuxcnc
def test_every_block_of_a_macro_is_read(tmp_path: Path) -> None:
    """Blocks that a preview jumps over, read one by one where they stand alone."""
    folder = subroutines(LC_SETTINGS, tmp_path)
    names = [path.stem for path in folder.glob("cb_*.ngc")]
    assert len(names) >= 18
    for path in folder.glob("cb_*.ngc"):
        lines = path.read_text("ascii").split("\n")
        assert lines[0] == f"o<{path.stem}> sub"
        assert lines[-3:] == [f"o<{path.stem}> endsub", "M2", ""]
        called = [line.split("<")[1].split(">")[0] for line in lines if "> call" in line and "o<" in line]
        assert set(called) <= set(names)


GROUPS = 4  # machines that run side by side
# Each check of each macro says no once, and yes once.
FEW = (
    ("good flat end mill", "runout 0.006", "length L+0.000", "length L+3.001"),
    ("diameter OD-0.500", "ball, a little longer", "missing tool", "beam blocked"),
    ("chip: 0.03 on one of four",),
)


def verdicts_are_those_expected(cases: Sequence[Case]) -> None:
    expected = {case.name: (case.expected, case.rough, case.finish) for case in cases}
    assert verdicts(cases, expected) == expected


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("names", FEW, ids=lambda names: names[0])
def test_a_tool_gets_the_verdict_of_the_fanuc_macros(names: tuple[str, ...]) -> None:
    cases = [case for case in CASES if case.name in names]
    assert len(cases) == len(names)
    verdicts_are_those_expected(cases)


@pytest.mark.long
@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize("group", range(GROUPS))
def test_every_tool_gets_the_verdict_of_the_fanuc_macros(group: int) -> None:
    # All tools take four minutes.
    left_out = set() if os.environ.get("CHIPBREAK_ALL_TOOLS") else WITH_A_TWIN
    assert left_out <= {case.name for case in CASES}
    verdicts_are_those_expected([case for case in CASES if case.name not in left_out][group::GROUPS])


@pytest.mark.linuxcnc("machine")
@pytest.mark.parametrize(
    "before",
    ["G20 G91 G94 G64 G55 S700 F30", pytest.param("G20 G91 G93 G64 G55 S700", marks=pytest.mark.long)],
)
def test_everything_in_force_is_as_it_was(tmp_path: Path, before: str) -> None:
    feed = "" if "G93" in before else " #<_feed>"  # in G93 each move has its own
    shown = f"(debug, #<_metric> #<_absolute> #<_rpm> #5220 #<_units_per_minute> #<_inverse_time>{feed})"
    calls = [f"{before}\n{shown}\n{call}\n{shown}" for call in CALLS[:1]]
    calls += ["M68 E0 Q1", *CALLS[1:3]]
    in_inches = [CALLS[3], "o<cb_trace> call [1] [0.15]", "o<cb_chip_check> call [1] [0.0008] [1]"]
    calls += [f"{call}\n{shown}" for call in in_inches]
    program = "\n".join(["M68 E0 Q0", *calls, "M2", ""]).encode()
    (run,) = laser.run_until(
        lambda runs: not runs[0].errors,
        [program],
        tools=[BAR, STRAIGHT.real()],
        beam=BEAM,
        subroutines=subroutines(LC_SETTINGS, tmp_path),
    )
    assert run.errors == ()
    assert len(run.messages) == 5
    assert len(set(run.messages)) == 1
    assert run.moving()[-1, 3] == LC_SETTINGS.safe_z_mm


def test_both_sets_meet_all_tools() -> None:
    assert len({case.name for case in CASES}) == len(CASES) > 45
    assert any(isinstance(case, Case) and case.is_blocked for case in CASES)
