"""The LinuxCNC macros on the simulated machine, for the same tools as the Fanuc ones."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from chipbreak.dialects import LINUXCNC_MILL
from chipbreak.dialects.check_programs import O_WORDS
from chipbreak.macros import MacroSettings, macro_files
from laser_simulator.tool import SimulatedTool
from linuxcnc import laser, machine

from .cases import FINISH_W, ROUGH_W, Case
from .stand import ALARMS, BAR, BEAM, SETTINGS

Verdict = tuple[str, str, str]

LC_SETTINGS = replace(
    SETTINGS,
    master_tool=3,
    gap_on="M64 P1",
    gap_off="M65 P1",
    safe_z_mm=-180.0,
    # A simulated machine latches within a servo period, so it need not go back as far as a real one.
    entry_feed=2400.0,
    store_first=1000,
    store_last=4999,
)


def subroutines(settings: MacroSettings, folder: Path) -> Path:
    for name, data in macro_files(LINUXCNC_MILL, settings).items():
        (folder / name).write_bytes(data)
    return folder


def programs(case: Case, first: int) -> list[str]:
    """One program for each check; ``first`` is the number of the case's tool on the machine."""
    before = f"M68 E0 Q0\no<cb_calibrate> call\nM68 E0 Q{first}\n{case.nominal.data(1, O_WORDS)}\n"
    if case.later is None:
        blocked = "M68 E0 Q-1\n" if case.is_blocked else ""
        return [f"{before}{blocked}o<cb_tool_check> call [1] [5000]\n(debug, good)\nM2\n"]
    trace = f"{before}o<cb_trace> call [1] [20] [5000]\nM68 E0 Q{first + 1}\n"
    checks = f"o<cb_chip_check> call [1] [{ROUGH_W}] [1]\n(debug, good before rough)\n"
    checks += f"o<cb_chip_check> call [1] [{FINISH_W}] [1]\n(debug, good before finish)\n"
    return [f"{trace}{checks}M2\n"]


def alarms(runs: Sequence[machine.Run]) -> list[list[str]]:
    """What stopped each program."""
    return [[error.strip() for error in run.errors] for run in runs]


def verdicts(cases: Sequence[Case], expected: Mapping[str, Verdict]) -> dict[str, Verdict]:
    """The alarms of TOOL CHECK or of CHIP CHECK with both limits; a CHIP CHECK that stops is the last.

    A case with another verdict than expected is run again, slower (see :mod:`linuxcnc.laser`).
    """
    found: dict[str, Verdict] = {}
    for settings in {case.settings for case in cases}:
        group = [case for case in cases if case.settings == settings]
        found |= _verdicts_of(group, replace(LC_SETTINGS, runout_mm=settings.runout_mm), expected)
    return found


def _verdicts_of(
    group: Sequence[Case], settings: MacroSettings, expected: Mapping[str, Verdict]
) -> dict[str, Verdict]:
    """The verdicts of cases with the same settings."""
    found: dict[str, Verdict] = {}
    for speed_up in laser.SPEEDS:
        runs = _run(group, settings, speed_up)
        found |= {case.name: _verdict(case, run) for case, run in zip(group, runs, strict=True)}
        group = [case for case in group if found[case.name] != expected[case.name]]
        if not group:
            break
    return found


def _run(cases: Sequence[Case], settings: MacroSettings, speed_up: float) -> list[machine.Run]:
    tools: list[SimulatedTool] = [BAR]
    texts = []
    for case in cases:
        texts += programs(case, len(tools))
        tools += [case.real, *([case.later] if case.later else [])]
    with tempfile.TemporaryDirectory(dir="/var/tmp") as name:
        folder = Path(name)
        folder.chmod(0o755)
        return laser.run(
            [text.encode() for text in texts],
            tools=tools,
            beam=BEAM,
            subroutines=subroutines(settings, folder),
            speed_up=speed_up,
        )


def _verdict(case: Case, run: machine.Run) -> Verdict:
    """Where no alarm of the macros ended the program, what did stands in its place."""
    alarm = ""
    if run.errors:
        number = re.match(r"\s*(\d{3}) ", run.errors[0])
        if not number:
            return run.errors[0], "", ""
        alarm = ALARMS[int(number[1])]
    ended = " good" if case.later is None else " good before finish"
    if not alarm and ended not in run.messages:
        return "did not come to its end", "", ""
    if run.samples[-1, 3] != LC_SETTINGS.safe_z_mm:
        return "the tool was left at the beam", "", ""
    if case.later is None:
        return alarm, "", ""
    if " good before rough" not in run.messages:
        # The program has ended: what stops a tool before a rough operation stops it before a finish too.
        return "", alarm, alarm
    return "", "", alarm
