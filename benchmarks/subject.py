"""The command that is measured, as a user gives it, and the rows every case needs."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from rows import MB, Goal, Row, Table
from stopwatch import BenchmarkError, Contestant, Sample

# A machining centre with a beam: without one no check is inserted.
MILL = str(Path(__file__).parents[1] / "samples" / "mill-with-laser.toml")
LATHE = "generic-lathe"
LINUXCNC = "linuxcnc-lathe"
_BEGIN = b"(CHIPBREAK BEGIN"


@dataclass(frozen=True)
class Context:
    """Where programs go, how often each is run, and how many times smaller they are than they should be.

    ``before`` is another chipbreak to compare with, if there is one.
    """

    folder: Path
    rounds: int
    smaller: int = 1
    large: bool = False
    before: str | None = None

    def blocks(self, full: int) -> int:
        return full // self.smaller

    def path(self, name: str) -> Path:
        return self.folder / name


def command() -> tuple[str, ...]:
    """The script that pip installed beside this interpreter."""
    script = Path(sys.executable).with_name("chipbreak")
    return (str(script),) if script.is_file() else (sys.executable, "-m", "chipbreak")


def filtering(program: Path, profile: str, units: int, *sets: str) -> Contestant:
    """The whole way, from start-up to the written file; ``sets`` change the profile."""
    options = [word for one in sets for word in ("--set", one)]
    words = (*command(), "filter", "-q", "-p", profile, *options, str(program), "-o", str(output_of(program)))
    return Contestant("chipbreak filter", words, units)


def output_of(program: Path) -> Path:
    return program.with_suffix(".out")


def insertions(program: Path) -> int:
    """How many changes stand in the output; a run that changes nothing is not what should be measured."""
    with output_of(program).open("rb") as file:
        count = sum(line.count(_BEGIN) for line in file)
    if not count:
        raise BenchmarkError(f"nothing was changed in {program.name}: this is not the work to be measured")
    return count


def rate_goal(subject: Contestant, samples: Sequence[Sample], per_second: float, unit: str) -> Goal:
    """Blocks or moves a second, against those wanted."""
    rate = subject.units / median(s.wall_s for s in samples)
    return Goal(rate / 1e6, per_second / 1e6, at_least=True, unit=f"M {unit}")


def add_memory(table: Table, program: Path, samples: Sequence[Sample], most_mb: float | None = None) -> None:
    """Peak memory against ``most_mb``, or against the bytes that went in and out."""
    size = program.stat().st_size + output_of(program).stat().st_size
    peak = max(s.peak_bytes for s in samples)
    limit_mb = (3 * size + 90 * MB) / MB if most_mb is None else most_mb
    goal = Goal(peak / MB, limit_mb, at_least=False, unit="MB")
    note = "3 x (input + output) + 90 MB" if most_mb is None else "whatever the length"
    table.rows.append(Row("  its peak memory", goal, note=note))


def title(program: Path, units: int, what: str) -> str:
    return f"{units:,} blocks, {program.stat().st_size / MB:.1f} MB, {what}"
