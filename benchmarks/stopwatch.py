"""Whole processes by the clock on the wall, subject and peers in turn.

A machine gets slower and faster while one looks at it.  So in each round everybody runs once, a different
one first each time, and only what ran in the same round is compared.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

_LONGEST_S = 300.0


class BenchmarkError(Exception):
    """A command that is measured did not do its work."""


@dataclass(frozen=True)
class Contestant:
    """A command, and how many blocks or moves it gets through in one run.

    With ``own_clock`` it prints the seconds its work took; its start-up is then left out.
    """

    name: str
    command: tuple[str, ...]
    units: int = 1
    own_clock: bool = False
    folder: Path | None = None
    environment: Mapping[str, str] | None = None
    note: str = ""


@dataclass(frozen=True)
class Sample:
    """One run: seconds on the wall, seconds of the processor, and the most memory the process held.

    ``cpu_s`` is 0 with an own clock: it would count the start-up.
    """

    wall_s: float
    cpu_s: float
    peak_bytes: int


def run(contestant: Contestant) -> Sample:
    """Run it once.  Raises BenchmarkError when it fails."""
    environment = {**os.environ, **(contestant.environment or {})}
    # As pip installs it: with byte code.  A first run, which nobody times, leaves it beside the sources.
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as complained:
        start = time.perf_counter()
        process = subprocess.Popen(
            contestant.command,
            cwd=contestant.folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=complained,
        )
        patience = threading.Timer(_LONGEST_S, process.kill)
        patience.start()
        _, status, usage = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - start
        patience.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            complained.seek(0)
            text = complained.read(2000).decode("utf-8", "replace")
            late = f" after {wall_s:.0f} s" if wall_s > _LONGEST_S else ""
            raise BenchmarkError(f"{contestant.name} ended with {process.returncode}{late}: {text}")
        if contestant.own_clock:
            said.seek(0)
            wall_s = float(said.read())
    cpu_s = 0.0 if contestant.own_clock else usage.ru_utime + usage.ru_stime
    return Sample(wall_s, cpu_s, usage.ru_maxrss * 1024)


def in_turn(contestants: Sequence[Contestant], rounds: int) -> list[list[Sample]]:
    """The samples of each contestant, in the order given, one a round."""
    samples: list[list[Sample]] = [[] for _ in contestants]
    for turn in range(rounds):
        for place in range(len(contestants)):
            at = (place + turn) % len(contestants)
            samples[at].append(run(contestants[at]))
    return samples


def ratio(one: Sequence[Sample], other: Sequence[Sample], units: float = 1.0) -> float:
    """How many times as long the one takes as the other; median of the rounds.

    ``units`` is how many times as much work the one does.
    """
    return median(a.wall_s / b.wall_s for a, b in zip(one, other, strict=True)) / units


def cpu_ratio(one: Sequence[Sample], other: Sequence[Sample], units: float = 1.0) -> float:
    """The same by the time of the processor, which others at work on the machine disturb less."""
    return median(a.cpu_s / b.cpu_s for a, b in zip(one, other, strict=True)) / units


def cpu_note(one: Sequence[Sample], other: Sequence[Sample], units: float = 1.0) -> str:
    """:func:`cpu_ratio` in words; none where a contestant has a clock of its own."""
    if not all(sample.cpu_s > 0.0 for sample in (*one, *other)):
        return ""
    return f"x {cpu_ratio(one, other, units):.3g} by the processor's time"
