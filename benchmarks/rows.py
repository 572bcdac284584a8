"""What was measured, beside what was wanted; as a table for people and as JSON."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import median

from peers import Missing
from stopwatch import Contestant, Sample

MB = 1_000_000


@dataclass(frozen=True)
class Goal:
    """A value and its limit, in ``unit``."""

    value: float
    limit: float
    at_least: bool
    unit: str

    @property
    def met(self) -> bool:
        """True on the right side of the limit."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def text(self) -> str:
        sign = ">=" if self.at_least else "<="
        verdict = "met" if self.met else "MISSED"
        return f"{self.value:9.4g} {sign} {self.limit:<6.4g} {self.unit:11} {verdict}"


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    name: str
    goal: Goal | None = None
    samples: tuple[Sample, ...] = ()
    units: int = 0
    note: str = ""

    @property
    def rate(self) -> float | None:
        """Blocks or moves a second, by the median."""
        if not self.samples or self.units < 2:
            return None
        return self.units / median(s.wall_s for s in self.samples)

    @property
    def peak_bytes(self) -> int | None:
        """The most memory in any run."""
        return max((s.peak_bytes for s in self.samples), default=None)

    def text(self) -> str:
        times = sorted(s.wall_s for s in self.samples)
        cells = [f"{t:8.3f}" for t in (times[0], median(times), times[-1])] if times else [" " * 8] * 3
        cpu_s = median(s.cpu_s for s in self.samples) if times else 0.0
        cells.append(f"{cpu_s:8.3f}" if cpu_s else " " * 8)
        cells.append(f"{self.rate:11,.0f}" if self.rate else " " * 11)
        cells.append(f"{self.peak_bytes / MB:8.1f}" if self.peak_bytes else " " * 8)
        goal = self.goal.text() if self.goal else ""
        line = f"  {self.name:29} {' '.join(cells)} {goal:42} {self.note}"
        return line.rstrip()

    def as_json(self) -> dict[str, object]:
        found = asdict(self)
        found["rate"], found["peak_bytes"] = self.rate, self.peak_bytes
        found["met"] = self.goal.met if self.goal else None
        return found


@dataclass
class Table:
    """One case."""

    name: str
    title: str
    rows: list[Row] = field(default_factory=list)

    def add(
        self, contestant: Contestant, samples: Sequence[Sample], goal: Goal | None = None, note: str = ""
    ) -> None:
        """A line for one contestant."""
        said = "; ".join(part for part in (note, contestant.note) if part)
        self.rows.append(Row(contestant.name, goal, tuple(samples), contestant.units, said))

    def miss(self, peer: Missing) -> None:
        """Say loudly that a peer is not here."""
        note = f"*** NOT INSTALLED, NOTHING COMPARED: {peer.how} ***"
        self.rows.append(Row(peer.name, note=note))

    def text(self) -> str:
        columns = ("min s", "median s", "max s", "cpu s", "a second", "peak MB")
        widths = (8, 8, 8, 8, 11, 8)
        head = " ".join(f"{c:>{w}}" for c, w in zip(columns, widths, strict=True))
        title = f"{self.name}: {self.title}"
        return "\n".join([title, f"  {'':29} {head}  measured    target", *(row.text() for row in self.rows)])


def machine() -> dict[str, object]:
    """Where it was measured, and how busy it was already: programs that wait for a processor, on average."""
    return {
        "machine": platform.machine(),
        "processors": os.cpu_count(),
        "python": platform.python_version(),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else 0.0,
    }


def busy(found: dict[str, object]) -> str:
    """A warning when others are at work: ratios are then rough, and rates are too low."""
    load, processors = found["load"], found["processors"]
    if isinstance(load, float) and isinstance(processors, int) and load > processors / 2:
        return (
            f"*** THE MACHINE IS BUSY (load {load}): a rate is too low when cpu s is far below median s ***"
        )
    return ""


def write_json(path: Path, tables: Sequence[Table], options: dict[str, object]) -> None:
    """Everything, every sample."""
    cases = {
        table.name: {"title": table.title, "rows": [row.as_json() for row in table.rows]} for table in tables
    }
    path.write_text(json.dumps({**options, "cases": cases}, indent=1) + "\n")
