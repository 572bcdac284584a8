"""Run programs on the simulated machine with a laser barrier and a simulated tool in its spindle.

    from linuxcnc import laser
    runs = laser.run([b"M68 E0 Q0\\nG38.3 Z-5 F60\\nM2\\n"], tools=[SimulatedTool()], beam=Beam(0, 0, -100))

``M68 E0 Qn`` in a program puts tool n of the list into the spindle, ``M68 E0 Q-1`` blocks the beam.  The
barrier is ``laser.c``; it answers every servo period, so that a probe stops within feed x 1 ms behind the
edge.  ``M66 P0 L0`` reads the barrier, ``M19 R`` turns the spindle at once.

The part of LinuxCNC that reads the program looks at the motion's status without a lock.  Where the motion is
held up between taking a command and saying that it moves, the reader takes the move for done: it goes on
before a probe has ended ("Queue is not empty after probing"), or reads the barrier too early.  Where
priorities are allowed the motion goes before the reader (``clock.c``); elsewhere a busy computer holds it up,
and a virtual one now and then in any case, the more often the faster the clock.  So the wall's speed is the
judge, and :func:`run_until` gets there only when a faster run has not done as expected.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from laser_simulator.barrier import Beam
from laser_simulator.tool import CORE_SHARE, GASH_MM, Kind, SimulatedTool, table

from . import config, machine

_STEP_MM, _HEIGHT_MM = 0.02, 26.0
_SERVO_S = 0.001
SPEEDS = (20.0, 5.0, 1.0, 1.0)
_MODULES = Path("/usr/lib/linuxcnc/modules")

_WIRES = """loadrt and2 names=gate
addf laser servo-thread
addf gate servo-thread
net at-X => laser.x
net at-Y => laser.y
net at-Z => laser.z
net laser-select motion.analog-out-00 => laser.select
net laser-turns spindle.0.on => laser.turns
net laser-orient spindle.0.orient => laser.orient
net laser-angle spindle.0.orient-angle => laser.orient-angle
net laser-oriented laser.is-oriented => spindle.0.is-oriented
net spindle-speed => laser.speed
net laser-gap motion.digital-out-01 => laser.looks-for-gap
net laser-broken laser.broken => motion.digital-in-00 gate.in0
net laser-gate motion.digital-out-00 => gate.in1
net laser-probe gate.out => motion.probe-input
"""


def run(
    programs: Sequence[bytes],
    *,
    tools: Sequence[SimulatedTool],
    beam: Beam,
    subroutines: Path | None = None,
    acceleration_mm_s2: float = 5000.0,
    velocity_mm_s: float = 1000.0,
    speed_up: float = SPEEDS[0],
    timeout_s: float = 120.0,
) -> list[machine.Run]:
    """Run the programs one after the other, each from machine zero; as :func:`linuxcnc.machine.run`."""
    with tempfile.TemporaryDirectory(prefix="machine-", dir="/var/tmp") as name:
        folder = Path(name)
        folder.chmod(0o777)
        jobs = []
        for index, program in enumerate(programs):
            path = folder / f"program{index}.ngc"
            path.write_bytes(program)
            jobs.append({"program": str(path), "samples": str(folder / f"samples{index}")})
        shutil.copy(machine.HERE / "driver.py", folder / "driver.py")
        shutil.copytree(subroutines, folder / "subs") if subroutines else (folder / "subs").mkdir()
        limits = config.limits("XYZ", acceleration_mm_s2, velocity_mm_s)
        (folder / "machine.ini").write_text(config.ini(folder, limits, _SERVO_S, lathe=False))
        (folder / "machine.hal").write_text(config.hal("XYZ") + _component(folder, tools, beam) + _WIRES)
        (folder / "tool.tbl").write_text(config.tool_table())
        (folder / "parameters.var").write_text("")
        work = {"jobs": jobs, "axes": 3, "timeout_s": timeout_s}
        (folder / "jobs.json").write_text(json.dumps(work))
        reports = machine._start(folder, speed_up, timeout_s * len(jobs) + 60)
        return [
            machine._read(report, Path(job["samples"]), _SERVO_S, "XYZ")
            for report, job in zip(reports, jobs, strict=True)
        ]


def run_until(
    is_right: Callable[[list[machine.Run]], bool], programs: Sequence[bytes], **options: Any
) -> list[machine.Run]:
    """:func:`run`, slower each time while ``is_right`` says no; in the end at the speed of the wall."""
    for speed_up in SPEEDS:
        runs = run(programs, speed_up=speed_up, **options)
        if is_right(runs):
            break
    return runs


def _component(folder: Path, tools: Sequence[SimulatedTool], beam: Beam) -> str:
    """Compile the barrier, and the HAL lines that load it.

    Components come from one folder of the system.  The run has a file system view of its own, and there a
    copy of that folder with the barrier in it takes its place.
    """
    (folder / "tools.bin").write_bytes(_table(tools))
    modules = folder / "modules"
    shutil.copytree(_MODULES, modules)
    defines = {"BEAM_X": beam.x_mm, "BEAM_Y": beam.y_mm, "BEAM_Z": beam.z_mm}
    options = [f"-D{key}={value!r}" for key, value in defines.items()]
    options += [
        f"-DFOCUS_HALF={beam.focus_half_mm!r}",
        f"-DGASH={GASH_MM!r}",
        f'-DTABLE="{folder}/tools.bin"',
    ]
    command = ["gcc", "-shared", "-fPIC", "-O2", *options, machine.HERE / "laser.c", "-lm"]
    subprocess.run([*command, "-o", modules / "laser.so"], check=True, capture_output=True)
    return f"loadusr -w mount --bind {modules} {_MODULES}\nloadrt laser\n"


def _table(tools: Sequence[SimulatedTool]) -> bytes:
    """The tools as laser.c reads them: doubles."""
    heights = np.arange(0.0, _HEIGHT_MM, _STEP_MM)
    parts = [np.array([float(len(tools))])]
    for tool in tools:
        core = 1.0 if tool.kind is Kind.BAR else CORE_SHARE
        head = [tool.gauge_mm, tool.teeth, core, tool.is_missing, tool.runout_mm]
        head += [np.radians(tool.runout_deg), _STEP_MM, len(heights)]
        parts += [np.array(head, np.float64), np.array(table(tool, heights), np.float64).ravel()]
    return b"".join(part.tobytes() for part in parts)
