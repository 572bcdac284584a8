"""Run programs on LinuxCNC's simulated machine and see where it commands the axes, every servo period.

Every run is a complete LinuxCNC without a screen, in Linux namespaces of its own: no process, shared memory
or lock of it can meet another LinuxCNC on this computer, and when the last program has ended the whole
namespace is closed.  That needs root.

The realtime clock can run faster than the wall (``speed_up``).  The motion is the same sample by sample up to
20 times where every block stops at its end (G61.1, and G61 when every block turns back): ``test_harness.py``
checks it at 10.  Where blocks may be blended (G64), the first few depend on how far the program has been read
when the first one starts; that is seldom seen at the speed of the wall, and often at 20 times with feed per
revolution or on a busy computer, so run G64 at 5 and do not judge it by its first blocks.
"""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import config

HERE = Path(__file__).parent
PROGRAMS_NEEDED = ("linuxcnc", "halsampler", "halcmd", "unshare", "ip")


class MachineError(RuntimeError):
    """The simulated machine did not start or its record has holes; says nothing about a program."""


@dataclass(frozen=True)
class Run:
    """What one program did.

    ``samples`` is (n, 4): time [s] and commanded machine position x, y, z [mm], one row per servo period,
    from just before the program to just after it.  ``lines`` is (n,): the line number in the program that
    was in motion.  ``errors`` are the operator errors; ``messages`` what ``(msg, …)`` and ``(debug, …)``
    showed.
    """

    samples: NDArray[np.float64]
    lines: NDArray[np.int64]
    errors: tuple[str, ...]
    messages: tuple[str, ...]

    def moving(self) -> NDArray[np.float64]:
        """The samples from the last one at rest before the motion to the first one at its end."""
        still = np.all(np.diff(self.samples[:, 1:], axis=0) == 0, axis=1)
        moved = np.flatnonzero(~still)
        return self.samples[moved[0] : moved[-1] + 2] if len(moved) else self.samples[:0]

    def line_times(self) -> dict[int, float]:
        """Time [s] that each line of the program was in motion (a line that moves nothing is not in it)."""
        numbers, counts = np.unique(self.lines[self.lines > 0], return_counts=True)
        period = self.samples[1, 0] - self.samples[0, 0]
        return {int(number): float(count * period) for number, count in zip(numbers, counts, strict=True)}

    @property
    def waited_s(self) -> float:
        """Time [s] that the machine stood in the middle of the program because nothing more had been read."""
        known = np.flatnonzero(self.lines > 0)
        inside = self.lines[known[0] : known[-1]] if len(known) else self.lines[:0]
        return float(np.count_nonzero(inside == 0) * (self.samples[1, 0] - self.samples[0, 0]))


@functools.cache
def available() -> bool:
    """True where a simulated machine can be started: LinuxCNC installed, root, namespaces allowed."""
    if os.geteuid() != 0 or any(shutil.which(name) is None for name in PROGRAMS_NEEDED):
        return False
    tried = subprocess.run([*NAMESPACES, "true"], capture_output=True, check=False)
    return tried.returncode == 0


NAMESPACES = ("unshare", "--ipc", "--net", "--pid", "--fork", "--kill-child", "--mount-proc", "--mount")


def run(
    programs: Sequence[Path | bytes],
    *,
    acceleration_mm_s2: float | Sequence[float],
    velocity_mm_s: float | Sequence[float] = 500.0,
    servo_period_s: float = 0.001,
    lathe: bool = False,
    subroutines: Path | None = None,
    max_feed_override: float = 1.0,
    speed_up: float = 10.0,
    timeout_s: float = 300.0,
) -> list[Run]:
    """Run the programs one after the other, each from machine zero, and return one :class:`Run` for each.

    ``acceleration_mm_s2`` and ``velocity_mm_s`` hold for every axis, or give one number for each of X, Y, Z
    (X, Z on a ``lathe``, whose Y samples are 0).  ``max_feed_override`` is that of the
    INI file, ``subroutines`` the folder for ``o<name> call``.  The spindle turns exactly as commanded.  A
    ``speed_up`` below 1 slows the clock down, for a busy computer.  ``timeout_s`` is wall time for one
    program.
    """
    # /var/tmp, because the run gets a /tmp of its own; open to all, because LinuxCNC's realtime part
    # changes user.
    with tempfile.TemporaryDirectory(prefix="machine-", dir="/var/tmp") as name:
        folder = Path(name)
        folder.chmod(0o777)
        jobs = []
        for index, program in enumerate(programs):
            path = folder / f"program{index}.ngc"
            path.write_bytes(program if isinstance(program, bytes) else program.read_bytes())
            jobs.append({"program": str(path), "samples": str(folder / f"samples{index}")})
        shutil.copy(HERE / "driver.py", folder / "driver.py")
        shutil.copytree(subroutines, folder / "subs") if subroutines else (folder / "subs").mkdir()
        axes = "XZ" if lathe else "XYZ"
        limits = config.limits(axes, acceleration_mm_s2, velocity_mm_s)
        ini = config.ini(folder, limits, servo_period_s, lathe=lathe, max_feed_override=max_feed_override)
        (folder / "machine.ini").write_text(ini)
        (folder / "machine.hal").write_text(config.hal(axes))
        (folder / "tool.tbl").write_text(config.tool_table())
        (folder / "parameters.var").write_text("")
        work = {"jobs": jobs, "axes": len(axes), "timeout_s": timeout_s}
        (folder / "jobs.json").write_text(json.dumps(work))
        reports = _start(folder, speed_up, timeout_s * len(jobs) + 60)
        return [
            _read(report, Path(job["samples"]), servo_period_s, axes)
            for report, job in zip(reports, jobs, strict=True)
        ]


def run_steadily(programs: Sequence[Path | bytes], **options: Any) -> list[Run]:
    """:func:`run` for programs whose every sample counts: again, and slower, while the machine had to wait.

    On a busy computer the reader of the program does not always keep up.  Not for programs that wait by
    themselves.
    """
    speeds = [options.pop("speed_up", 10.0), 3.0, 1.0, 1.0]
    for speed_up in speeds:
        runs = run(programs, speed_up=speed_up, **options)
        if not any(one.waited_s for one in runs):
            return runs
    raise MachineError("this computer is too busy to run the machine without waiting")


# A machine that shares the processors with other tests must not wait for them: its reader would come late.
# Its motion goes before its reader (clock.c): held up between two steps of a move, it would be misread.
_BEFORE_OTHERS = "ulimit -r 2; chrt --rr --pid 1 $$"
_OWN_TMP = "ip link set lo up; mount -t tmpfs tmpfs /tmp; chmod 1777 /tmp"


def _start(folder: Path, speed_up: float, limit_s: float) -> list[dict[str, list[str]]]:
    """Start LinuxCNC, wait for the driver's report, close the namespace."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "PYTHONPATH")}
    environment |= {"HOME": str(folder), "RTAPI_UID": "65534", "RUNTESTS": "1", "LC_ALL": "C"}
    environment |= {"RTAPI_FIFO_PATH": str(folder / "rtapi_fifo")}
    environment |= {"LD_PRELOAD": str(_clock(folder)), "CLOCK_SPEED_UP": str(speed_up)}
    inside = f"{_BEFORE_OTHERS}; {_OWN_TMP}; exec linuxcnc -r machine.ini"
    said = folder / "said.txt"
    with said.open("wb") as out:
        process = subprocess.Popen(
            [*NAMESPACES, "bash", "-c", inside],
            cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out,
        )  # fmt: skip
        report, end = folder / "report.json", time.monotonic() + limit_s
        try:
            while not report.exists() and process.poll() is None and time.monotonic() < end:
                time.sleep(0.02)
        finally:
            # Nothing in there is worth an orderly goodbye: the namespace takes every process along.
            process.kill()
            process.wait()
    if not report.exists():
        raise MachineError("LinuxCNC did not report: " + said.read_text("latin-1")[-2000:])
    found = json.loads(report.read_text())
    if found["failure"]:
        raise MachineError(found["failure"] + "\n" + said.read_text("latin-1")[-2000:])
    return list(found["runs"])


def _clock(folder: Path) -> Path:
    """The library that makes LinuxCNC's realtime threads wait less than they ask for, and go first."""
    library = folder / "clock.so"
    subprocess.run(
        ["gcc", "-shared", "-fPIC", "-O2", "-o", library, HERE / "clock.c", "-ldl", "-lpthread"],
        check=True,
        capture_output=True,
        env={key: value for key, value in os.environ.items() if key != "LD_PRELOAD"},
    )
    return library


def _read(report: dict[str, list[str]], samples: Path, period_s: float, axes: str) -> Run:
    """The sampled rows: sample number, one position per axis, line number."""
    # halsampler marks a jump of the sample number; in front of the first sample there is nothing to lose.
    text = samples.read_text().removeprefix("overrun\n")
    if "overrun" in text:
        raise MachineError("the sampler lost samples: use a smaller speed_up")
    rows = np.array(text.split(), dtype=np.float64).reshape(-1, len(axes) + 2)
    if len(rows) < 2:
        raise MachineError("nothing was sampled")
    if np.any(np.diff(rows[:, 0]) != 1):
        raise MachineError("the record of the motion has holes: use a smaller speed_up")
    table = np.zeros((len(rows), 4))
    table[:, 0] = (rows[:, 0] - rows[0, 0]) * period_s
    for column, axis in enumerate(axes, start=1):
        table[:, "XYZ".index(axis) + 1] = rows[:, column]
    return Run(table, rows[:, -1].astype(np.int64), tuple(report["errors"]), tuple(report["messages"]))
