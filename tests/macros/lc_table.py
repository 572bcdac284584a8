"""The table of faults, tools, units and speeds on the simulated LinuxCNC: do its macros say what numpy says?

Every tool with every fault once, in millimetres and in inches in turn and at each S; then a touch plate in
the place of the laser, with tools that became shorter or longer, or are missing.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

from chipbreak.dialects.check_programs import O_WORDS
from chipbreak.macros import MacroSettings
from chipbreak.syntax.numbers import print_number
from laser_simulator.tool import SimulatedTool
from linuxcnc import laser, machine
from macro_interpreter import CONTROLS
from macros.cases import FINISH_W, ROUGH_W
from macros.lc_stand import LC_SETTINGS, subroutines
from macros.stand import ALARMS, BAR, BEAM
from macros.table import HEIGHT_MM, SPEEDS, TOOLS, Row, by_numpy, faults

_BEAM_SETTINGS = replace(LC_SETTINGS, trace_step_mm=0.5)
_PLATE_SETTINGS = MacroSettings(
    setter_x_mm=BEAM.x_mm,
    setter_y_mm=BEAM.y_mm,
    setter_z_mm=BEAM.z_mm + 100.0,
    safe_z_mm=LC_SETTINGS.safe_z_mm,
    store_first=LC_SETTINGS.store_first,
    store_last=LC_SETTINGS.store_last,
)
_PLATE_W_MM = 0.05
_PLATE_CHANGES_MM = (0.0, -0.04, -0.06, 0.06)
_AT_A_TIME = 6
# At the speed of the wall oftener than elsewhere: the reader of the program looks at the barrier only when
# the computer lets it, and on a busy one it misses whole signals of a tool that turns slowly.
_SPEEDS = (*laser.SPEEDS, 1.0, 1.0)


@dataclass(frozen=True)
class Job:
    """A program, the tools that it asks for one after the other, and the verdict that it must come to."""

    text: str
    program: str
    tools: tuple[SimulatedTool, ...]
    expected: str


def beam_jobs() -> list[Job]:
    """Every tool with every fault; unit and speed change from one to the next."""
    found = []
    for number, (tool, nominal) in enumerate(TOOLS.items()):
        for index, (fault, real, later) in enumerate(faults(nominal)):
            rpm = SPEEDS[(number + index) % len(SPEEDS)]
            row = Row(tool, fault, CONTROLS[0], bool((number + index // len(SPEEDS)) % 2), rpm, real, later)
            found.append(_beam_job(row))
    return found


def _beam_job(row: Row) -> Job:
    unit = "inch" if row.is_inch else "mm"
    begin = ["", "G20" if row.is_inch else "G21", "M68 E0 Q0", "o<cb_calibrate> call", "M68 E0 Q{first}"]
    data = row.nominal.data(1, O_WORDS)
    if row.later is None:
        checks = [f"o<cb_tool_check> call [1] [{row.rpm}]", "(debug, good)"]
    else:
        checks = [f"o<cb_trace> call [1] [{_number(HEIGHT_MM, row)}] [{row.rpm}]", "M68 E0 Q{second}"]
        for w_mm in (ROUGH_W, FINISH_W):
            checks += [f"o<cb_chip_check> call [1] [{_number(w_mm, row)}] [1]", "(debug, good)"]
    tools = (row.real, *([row.later] if row.later else []))
    program = "\n".join([*begin, data, *checks, "M2", ""])
    return Job(f"{row.tool}, {row.fault}, {unit}, S{row.rpm}", program, tools, by_numpy(row))


def _number(length_mm: float, row: Row) -> str:
    return print_number(length_mm / (25.4 if row.is_inch else 1.0), 6)


def plate_jobs() -> list[Job]:
    """Every tool on a touch plate, as it was and as it became."""
    found = []
    for number, (tool, nominal) in enumerate(TOOLS.items()):
        good = nominal.real()
        for index, change_mm in enumerate(_PLATE_CHANGES_MM):
            later = replace(good, length_mm=good.length_mm + change_mm)
            found.append(_plate_job(tool, f"L{change_mm:+.2f}", good, later, bool((number + index) % 2)))
        found.append(_plate_job(tool, "missing", good, replace(good, is_missing=True), bool(number % 2)))
    return found


def _plate_job(tool: str, fault: str, good: SimulatedTool, later: SimulatedTool, is_inch: bool) -> Job:
    w = print_number(_PLATE_W_MM / (25.4 if is_inch else 1.0), 6)
    program = [
        "",
        "G20" if is_inch else "G21",
        "M68 E0 Q{first}",
        "o<cb_setter> call [1]",
        "M68 E0 Q{second}",
        f"o<cb_setter> call [1] [{w}]",
        "(debug, good)",
        "M2",
        "",
    ]
    expected = "CHIP" if abs(later.length_mm - good.length_mm) >= _PLATE_W_MM - 1e-9 else ""
    if later.is_missing:
        expected = "NO CONTACT"
    text = f"{tool} on a plate, {fault}, {'inch' if is_inch else 'mm'}"
    return Job(text, "\n".join(program), (good, later), expected)


def table(pool: Executor) -> tuple[list[str], int]:
    """A line a job, and how many came to another verdict."""
    groups = [
        *((_BEAM_SETTINGS, group) for group in _groups(beam_jobs())),
        *((_PLATE_SETTINGS, group) for group in _groups(plate_jobs())),
    ]
    lines: list[str] = []
    wrong = 0
    for (_, group), said in zip(groups, pool.map(_judge, groups), strict=True):
        for job, verdict in zip(group, said, strict=True):
            wrong += verdict != job.expected
            mark = "" if verdict == job.expected else f"  <-- numpy says {job.expected}"
            lines.append(f"{job.text}: {verdict or 'passes'}{mark}")
    lines.append(f"{len(lines)} rows on LinuxCNC, {wrong} differ")
    return lines, wrong


def _groups(jobs: Sequence[Job]) -> Iterable[Sequence[Job]]:
    return [jobs[first : first + _AT_A_TIME] for first in range(0, len(jobs), _AT_A_TIME)]


def _judge(group: tuple[MacroSettings, Sequence[Job]]) -> list[str]:
    """The verdicts of some jobs on one machine; what differs runs again, slower (:mod:`linuxcnc.laser`)."""
    settings, jobs = group
    found: dict[str, str] = {}
    left = list(jobs)
    for speed_up in _SPEEDS:
        found |= dict(zip((job.text for job in left), _run(settings, left, speed_up), strict=True))
        left = [job for job in left if found[job.text] != job.expected]
        if not left:
            break
    return [found[job.text] for job in jobs]


def _run(settings: MacroSettings, jobs: Sequence[Job], speed_up: float) -> list[str]:
    tools = [BAR]
    programs = []
    for job in jobs:
        numbers = {"first": len(tools), "second": len(tools) + 1}
        text = job.program
        for name, number in numbers.items():
            text = text.replace(f"{{{name}}}", str(number))
        programs.append(text.encode())
        tools += job.tools
    with tempfile.TemporaryDirectory(dir="/var/tmp") as name:
        folder = Path(name)
        folder.chmod(0o755)
        subs = subroutines(settings, folder)
        runs = laser.run(programs, tools=tools, beam=BEAM, subroutines=subs, speed_up=speed_up)
    return [_verdict(job, run) for job, run in zip(jobs, runs, strict=True)]


def _verdict(job: Job, run: machine.Run) -> str:
    """As :func:`macros.table.by_numpy` says it; what stops before a rough operation stops before a finish."""
    alarm = ""
    if run.errors:
        number = re.match(r"\s*(\d{3}) ", run.errors[0])
        if not number:
            return run.errors[0]
        alarm = ALARMS[int(number[1])]
    passed = [message.strip() for message in run.messages].count("good")
    wanted = job.program.count("(debug, good)")
    if not alarm and passed < wanted:
        return "did not come to its end"
    if wanted == 1:
        return alarm
    return f"{'' if passed else alarm}/{alarm}"
