"""Many programs through ``batch`` with several workers, one of which is killed on the way.

As a command, ``python tests/batch/killed_worker.py FOLDER --programs 300``, it takes the programs of a
folder, copies of them under other names until there are enough, and compares what ``batch`` makes of each
with a run of its own.  ``--dask 4`` takes a Dask cluster of so many processes.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from itertools import cycle, islice
from pathlib import Path
from typing import NamedTuple

import chipbreak

PROFILE = "fanuc-lathe"
SETS = ("vibration.n=1.5",)  # so that many programs change that do not ask by themselves
_LARGEST_BYTES = 100_000
_GENERATIONS = 3  # of processes: batch, the one that starts workers where there is one, the workers


class Outcome(NamedTuple):
    """What became of the programs; ``wrong`` names those whose result is another than that of a run alone.

    ``peak_mb`` is the most memory that one worker held.
    """

    written: int
    changed: int
    rejected: int
    killed: int
    wrong: tuple[str, ...]
    peak_mb: int


TWO_PROCESSES = ("-j", "2")


def run(programs: Sequence[bytes], folder: Path, workers: Sequence[str] = TWO_PROCESSES) -> Outcome:
    """Filter programs below ``folder`` with some workers; kill one as soon as some results are there."""
    source = folder / "in"
    target = folder / "out"
    source.mkdir()
    names = [f"{number:04}.nc" for number in range(len(programs))]
    for name, data in zip(names, programs, strict=True):
        (source / name).write_bytes(data)
    sets = [word for one in SETS for word in ("--set", one)]
    command = [sys.executable, "-m", "chipbreak", "batch", "-p", PROFILE, *sets, *workers, "-q"]
    clean = {key: value for key, value in os.environ.items() if not key.startswith("CHIPBREAK")}
    with (folder / "said.txt").open("wb") as said:
        batch = subprocess.Popen(
            [*command, "in", "-o", "out"], cwd=folder, env=clean, stdout=said, stderr=said
        )
        killed, peak_mb = _kill_a_worker(batch, target, after=max(1, len(programs) // 4))
    alone: dict[bytes, bytes | None] = {}
    for data in programs:
        if data not in alone:
            alone[data] = _alone(data)
    wrong = [
        name
        for name, data in zip(names, programs, strict=True)
        if _result(target, name) != alone[data] or (alone[data] is None) != _is_rejected(target, name)
    ]
    results = [alone[data] for data in programs]
    return Outcome(
        written=sum(one is not None for one in results),
        changed=sum(one not in (None, data) for one, data in zip(results, programs, strict=True)),
        rejected=results.count(None),
        killed=killed,
        wrong=tuple(wrong),
        peak_mb=peak_mb,
    )


def _alone(data: bytes) -> bytes | None:
    try:
        return chipbreak.rewrite(data, chipbreak.load(PROFILE, SETS)).data
    except chipbreak.ProgramRejectedError:
        return None


def _result(target: Path, name: str) -> bytes | None:
    file = target / name
    return file.read_bytes() if file.exists() else None


def _is_rejected(target: Path, name: str) -> bool:
    return (target / f"{name}.rejected").exists()


def _kill_a_worker(batch: subprocess.Popen[bytes], target: Path, after: int) -> tuple[int, int]:
    """Kill one worker when so many results are there, and wait for the end.

    How many were killed, and the most memory [MB] of any.
    """
    killed = peak_mb = 0
    while batch.poll() is None:
        workers = _workers(batch.pid)
        peak_mb = max([peak_mb, *map(_peak_mb, workers)])
        if workers and not killed and target.is_dir() and sum(1 for _ in target.iterdir()) >= after:
            os.kill(workers[0], signal.SIGKILL)
            killed = 1
        time.sleep(0.02)
    return killed, peak_mb


def _workers(pid: int) -> list[int]:
    """The processes that filter: below ``batch``, they start none themselves, and keep no resources."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it ended meanwhile
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    below = {pid}
    for _ in range(_GENERATIONS):
        below |= {child for child, parent in parents.items() if parent in below}
    return sorted(one for one in below - {pid, *parents.values()} if b"resource_tracker" not in _command(one))


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def _peak_mb(pid: int) -> int:
    try:
        found = re.search(r"VmHWM:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    except OSError:
        return 0
    return int(found[1]) // 1000 if found else 0


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--programs", type=int, default=300)
    parser.add_argument(
        "--dask", type=int, help="so many processes of a Dask cluster, in place of two workers"
    )
    asked = parser.parse_args()
    found = sorted(
        path for path in asked.folder.rglob("*") if path.is_file() and not path.name.startswith(".")
    )
    own = [path for path in found if path.suffix.lower() not in {".md", ".tsv", ".csv", ".json", ".toml"}]
    small = [path.read_bytes() for path in own if path.stat().st_size <= _LARGEST_BYTES]
    with tempfile.TemporaryDirectory() as folder:
        workers = ("--dask", "local", "--jobs", str(asked.dask)) if asked.dask else TWO_PROCESSES
        outcome = run(list(islice(cycle(small), asked.programs)), Path(folder), workers)
    print(f"{len(small)} different programs, {asked.programs} in all: {outcome}")
    return 1 if outcome.wrong or not outcome.killed else 0


if __name__ == "__main__":
    sys.exit(main())
