"""Kill chipbreak at random moments and look at what it leaves.

    python benchmarks/faults.py               1,000 whole runs of -i and -o, and 1,000 of the writing alone
    python benchmarks/faults.py --runs 50     fewer

A whole run spends most of its time before the first byte is written, so the writing alone is killed as often
again: a process that does nothing else, with files large enough to be met in the middle.  After each kill the
file must be the old or the new one to the byte.  What a kill has left beside it must be gone after the next
run.  The last line says how often what was found; exit code 1 where anything was wrong.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import chipbreak
from chipbreak import whole_files

OLD = b"G97 S3000 M3\nG0 X20. Z2.\n" + b"G0 Z2.\nG1 Z-3. F0.05 N1.5\n" * 40 + b"M30\n"
PROFILE = "generic-lathe"
COMMAND = [sys.executable, "-m", "chipbreak", "filter", "-q", "-p", PROFILE]
LARGE_OLD, LARGE_NEW = b"G1 X1.\n" * 300_000, b"G1 X2.\n" * 400_000


def whole_run(folder: Path, arguments: list[str], after_s: float) -> bool:
    """Start a run and kill it after so long; False where it had ended by itself."""
    process = subprocess.Popen(
        [*COMMAND, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        process.wait(after_s)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return True
    return False


def written_alone(write: Callable[[], object], after_s: float) -> float | None:
    """Write in a process of its own and kill that after so long; what it took where it ended by itself."""
    begin_s = time.perf_counter()
    child = os.fork()
    if not child:
        try:
            write()
        finally:
            os._exit(0)
    while time.perf_counter() - begin_s < after_s:
        if os.waitpid(child, os.WNOHANG)[0]:
            return time.perf_counter() - begin_s
        time.sleep(0.0002)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def duration_s(work: Callable[[], object]) -> float:
    """How long something takes, and a tenth more."""
    begin_s = time.perf_counter()
    work()
    return 1.1 * (time.perf_counter() - begin_s)


def what_is(file: Path, old: bytes | None, new: bytes) -> str:
    """The content of a file in a word."""
    data = file.read_bytes() if file.exists() else None
    return {old: "old", new: "new"}.get(data, "HALF")


def parts(folder: Path) -> list[Path]:
    """What a killed run has left."""
    return [path for path in folder.iterdir() if path.suffix == ".part"]


def kill_whole_runs(folder: Path, runs: int, draw: random.Random) -> Counter[str]:
    """Runs of ``-i`` (with a backup every second time) and of ``-o``, in turn."""
    new = chipbreak.rewrite(OLD, chipbreak.load(PROFILE), "a.nc").data
    source, target, backup = folder / "a.nc", folder / "out.nc", folder / "a.nc.bak"
    source.write_bytes(OLD)
    longest_s = duration_s(lambda: whole_run(folder, ["a.nc", "-o", "out.nc"], 60.0))
    found: Counter[str] = Counter()
    for number in range(runs):
        source.write_bytes(OLD)
        backup.unlink(missing_ok=True)
        target.unlink(missing_ok=True)
        in_place = bool(number % 2)
        arguments = (
            ["-i", "a.nc", *["--backup=.bak"] * (number % 4 == 1)] if in_place else ["a.nc", "-o", "out.nc"]
        )
        found["killed"] += whole_run(folder, arguments, draw.uniform(0.0, longest_s))
        found[what_is(source, OLD, new) if in_place else what_is(target, None, new)] += 1
        if backup.exists() and backup.read_bytes() != OLD:
            found["HALF"] += 1
        if not in_place and source.read_bytes() != OLD:
            found["INPUT CHANGED"] += 1
        found["left beside it"] += len(parts(folder))
    whole_run(folder, ["a.nc", "-o", "out.nc"], 60.0)
    found["LEFT AFTER THE NEXT RUN"] += len(parts(folder))
    return found


def kill_writing(folder: Path, runs: int, draw: random.Random) -> Counter[str]:
    """The writing alone: a backup, and then the file."""
    file = folder / "large.nc"
    found: Counter[str] = Counter()

    def write() -> None:
        whole_files.keep(file, LARGE_OLD, ".bak")
        whole_files.replace(file, [LARGE_NEW])

    file.write_bytes(LARGE_OLD)
    longest_s = duration_s(write)
    whole_files.SWEPT.clear()  # each process that writes is a run of its own
    backup = folder / "large.nc.bak"
    for _ in range(runs):
        file.write_bytes(LARGE_OLD)
        backup.unlink(missing_ok=True)
        took_s = written_alone(write, draw.uniform(0.0, longest_s))
        longest_s = longest_s if took_s is None else 1.1 * took_s
        found["killed"] += took_s is None
        is_new = what_is(file, LARGE_OLD, LARGE_NEW)
        found[is_new] += 1
        is_kept = what_is(backup, None, LARGE_OLD)
        found["HALF"] += is_kept == "HALF"
        found["WITHOUT ITS BACKUP"] += is_new == "new" and is_kept != "new"
        found["left beside it"] += len(parts(folder))
    (folder / "small.nc").write_bytes(OLD)
    whole_run(folder, ["small.nc", "-o", "small.nc"], 60.0)
    found["LEFT AFTER THE NEXT RUN"] += len(parts(folder))
    return found


def main() -> int:
    """Kill and count."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=None)
    options = parser.parse_args()
    seed = random.SystemRandom().randrange(2**32) if options.seed is None else options.seed
    print(f"seed {seed}", flush=True)
    draw = random.Random(seed)
    wrong = 0
    for name, kill in (("whole runs", kill_whole_runs), ("writing alone", kill_writing)):
        with tempfile.TemporaryDirectory() as folder:
            found = kill(Path(folder), options.runs, draw)
        print(f"{name}: {options.runs};", ", ".join(f"{key} {found[key]}" for key in found), flush=True)
        wrong += sum(count for key, count in found.items() if key.isupper())
    return min(wrong, 1)


if __name__ == "__main__":
    sys.exit(main())
