"""Machines on a bench: the program of the machine test on machines whose numbers the test does not know.

The program is read here from its text alone, and run by ``stepped_machine``: every quantity is stepped
through time with other formulas than those of the package.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
from click.testing import CliRunner
from numpy.typing import NDArray

import chipbreak
from chipbreak.cli import cli
from chipbreak.kinematics.waveform import full_window
from stepped_machine import Machine, behind_filters, commanded, seen

Floats = NDArray[np.float64]
STEP_S = 0.0001
REST_S = 1.0
_WORD = re.compile(r"([A-Z])(-?[0-9.]+)")
_AXIS_OF = {"U": "X", "W": "Z", "V": "Y", "X": "X", "Y": "Y", "Z": "Z"}


class Block(NamedTuple):
    """A move: millimetres of X and Z, and its feed [mm/s]."""

    x_mm: float
    z_mm: float
    feed_mm_s: float


def groups_of(program: str, *, x_is_diameter: bool) -> list[list[Block]]:
    """The moves between the rests of a program."""
    groups: list[list[Block]] = []
    feed = 0.0
    for line in program.splitlines():
        code = re.sub(r"\([^)]*\)|;.*", "", line)
        words = dict(_WORD.findall(code))
        if code.startswith("G4 "):
            groups.append([])
        elif not code.startswith(("#", "O", "%")) and groups and words.keys() & _AXIS_OF.keys():
            feed = float(words.get("F", feed))
            ways = {_AXIS_OF[letter]: float(number) for letter, number in words.items() if letter in _AXIS_OF}
            x_mm = ways.get("X", 0.0) / (2.0 if x_is_diameter else 1.0)
            groups[-1].append(Block(x_mm, ways.get("Z", 0.0), feed / 60.0))
    return [group for group in groups if group]


class Record(NamedTuple):
    """What was recorded: times [s] and places of X and Z [mm], (n,) each; the time of each group [s]."""

    time_s: Floats
    x_mm: Floats
    z_mm: Floats
    times_s: list[float]

    def csv(self, axes: str = "XZ") -> str:
        """As a recorder writes it."""
        columns = {"X": self.x_mm, "Z": self.z_mm}
        rows = np.stack([self.time_s * 1000.0, *(columns[axis] for axis in axes)], axis=1)
        head = ",".join(["time_ms", *(axis.lower() + "_mm" for axis in axes)])
        return head + "\n" + "".join(",".join(f"{v:.4f}" for v in row) + "\n" for row in rows.tolist())


def recorded(
    groups: list[list[Block]],
    machines: dict[str, Machine],
    draw: np.random.Generator,
    *,
    noise_mm: float = 0.001,
    jitter_s: float = 0.001,
    every_s: float = 0.001,
) -> Record:
    """Run the groups on the machine of their axis, and record places with noise and times with jitter."""
    places: dict[str, list[Floats]] = {"X": [], "Z": []}
    times: list[float] = []
    for group in groups:
        along, time_s = _run(group, machines)
        times.append(time_s + draw.normal(0.0, jitter_s))
        for axis, rows in places.items():
            rows.append(along.get(axis, np.zeros(len(next(iter(along.values()))))))
    columns = {axis: np.concatenate(rows) for axis, rows in places.items()}
    every = round(every_s / STEP_S)
    seen = {
        axis: place[::every] + draw.normal(0.0, noise_mm, len(place[::every]))
        for axis, place in columns.items()
    }
    return Record(np.arange(len(seen["X"])) * every_s, seen["X"], seen["Z"], times)


def _run(group: list[Block], machines: dict[str, Machine]) -> tuple[dict[str, Floats], float]:
    """The places of the axes in a group with a rest before and behind it, and how long it takes."""
    found: dict[str, Floats] = {}
    longest_s = 0.0
    for axis, ways in (("X", [b.x_mm for b in group]), ("Z", [b.z_mm for b in group])):
        if not any(ways):
            continue
        machine = machines[axis]
        lengths = np.array(ways)
        feeds = np.array([b.feed_mm_s for b in group])
        command, duration_s = commanded(lengths, feeds, machine, STEP_S)
        settling_s = sum(machine.averages_s) + 12.0 * sum(machine.lags_s)
        held = np.full(round((REST_S + settling_s) / STEP_S), command[-1])
        still = np.zeros(round(REST_S / 2.0 / STEP_S))
        found[axis] = behind_filters(np.concatenate([still, command, held]), machine, STEP_S)
        longest_s = max(longest_s, duration_s + sum(machine.averages_s) + 5.0 * sum(machine.lags_s))
    return found, longest_s


class Cut(NamedTuple):
    """A cut in Z with a wish."""

    speed_rpm: float
    wish: str
    feed_mm: float
    length_mm: float

    def program(self, head: str) -> bytes:
        """As a person writes it for a Fanuc lathe, behind a head."""
        return (
            f"{head}G97 S{self.speed_rpm:.3f} M3\nG0 X20. Z0.\n(VIB {self.wish})\n"
            f"G1 Z-{self.length_mm:.3f} F{self.feed_mm}\nM30\n"
        ).encode()


def drawn_cut(draw: np.random.Generator, settling_s: float) -> Cut:
    """A cut that is long enough for the machine to settle, and for some revolutions after that."""
    period_s = float(draw.choice([0.020, 0.032, 0.048, 0.064, 0.100]))
    per_rev = float(draw.choice([0.5, 0.75, 1.25, 1.5, 2.5]))
    speed_rpm = 60.0 / period_s / per_rev
    feed_mm = round(float(draw.uniform(0.04, 0.2)), 3)
    ratio = str(draw.choice(["", "", " Q1.3", " Q2.2"]))
    whole_s = settling_s + 12.0 * period_s + 8.0 * 60.0 / speed_rpm
    wish = f"N{per_rev} F{1.0 / period_s:.6g}{ratio}"
    return Cut(speed_rpm, wish, feed_mm, whole_s * feed_mm * speed_rpm / 60.0 * 1.6)


FINE = (
    "command.periods_ms=[20.0, 32.0, 48.0, 64.0, 100.0]",
    "command.base_period_ms=1.0",
    "spindle.resolution_rpm=0.001",
    "output.decimals=5",
    "output.feed_decimals=7",
    "vibration.end_revolutions=1",
)


class Kept(NamedTuple):
    """What was promised and what was run: N, stroke [mm], whether chips break.

    ``is_on_edge``: it was said that the last is not known.
    """

    promised: tuple[float, float, bool]
    run: tuple[float, float, bool]
    is_on_edge: bool = False

    @property
    def count_error(self) -> float:
        """In N, as a share."""
        return abs(self.promised[0] / self.run[0] - 1.0) if self.run[0] and self.promised[0] else 0.0

    @property
    def stroke_error(self) -> float:
        """In the stroke, as a share; of what is left of a stroke below 0.02 mm, as a share of that."""
        return abs(self.promised[1] - self.run[1]) / max(self.run[1], 0.02)

    @property
    def same_verdict(self) -> bool:
        """Chips break as promised, where that was said to be known."""
        return self.is_on_edge or self.promised[2] == self.run[2]


def fanuc_cut(cut: Cut, profile: str, machine: Machine) -> Kept | None:
    """A cut as the measured profile promises it, and as the machine runs it; None where it is refused."""
    settings = chipbreak.load(profile, FINE)
    try:
        result = chipbreak.rewrite(cut.program(""), settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError:
        return None
    if not result.cuts:
        return None
    (report,) = result.cuts
    lengths_mm, per_rev_mm = blocks_of(result.data.decode())
    speed_rpm = report.plan.solution.speed_rpm
    step_s = report.wave.period_s / 640.0
    command, _ = commanded(lengths_mm, per_rev_mm * speed_rpm / 60.0, machine, step_s)
    real_mm = behind_filters(command, machine, step_s)
    settling_s = sum(machine.averages_s) + 7.0 * sum(machine.lags_s)
    first_s, last_s = full_window(report.wave)
    if last_s - first_s < settling_s + 3.0 * report.wave.period_s:
        return None
    ran = seen(real_mm, step_s, 60.0 / speed_rpm, report.wave.period_s, (first_s + settling_s, last_s))
    verdict = report.verdict
    promised = (verdict.per_rev, verdict.stroke_mm, bool(verdict.breaks))
    return Kept(promised, (ran.per_rev, ran.stroke_mm, ran.margin >= 1.0), report.is_on_edge)


def blocks_of(text: str, mark: str = "(CHIPBREAK") -> tuple[Floats, Floats]:
    """Lengths and feeds per revolution of the blocks of a cut in Z from 0."""
    body = text.split(f"{mark} BEGIN VIB")[1].split(f"{mark} END", maxsplit=1)[0]
    ends, feeds = [0.0], list[float]()
    for line in body.splitlines():
        words = dict(_WORD.findall(re.sub(r"\([^)]*\)", "", line)))
        if "Z" in words:
            ends.append(-float(words["Z"]))
            feeds.append(float(words["F"]) if "F" in words else feeds[-1])
    return np.diff(ends), np.array(feeds)


def drawn_machine(draw: np.random.Generator) -> tuple[str, Machine]:
    """A machine whose numbers nobody is told, and what it is called in tables."""
    kind = str(draw.choice(["linear", "exponential", "bell"]))
    first_s = float(draw.uniform(0.006, 0.040))
    lag_s = (1.0 - float(draw.choice([0.0, 0.0, 0.7]))) / float(draw.uniform(25.0, 120.0))
    averages = {
        "linear": (first_s,),
        "exponential": (),
        "bell": (first_s, first_s * float(draw.uniform(0.3, 0.8))),
    }
    lags = (first_s, lag_s) if kind == "exponential" else (lag_s,)
    if draw.random() < 0.5:
        return f"after-interpolation, {kind}", Machine(averages[kind], lags)
    joint_mm_s = float(draw.uniform(100.0, 1500.0)) / 60.0
    return f"look-ahead, {kind}", Machine(
        averages[kind], lags, joint_mm_s, float(draw.uniform(1000.0, 8000.0))
    )


def measured_profile(machine: Machine, draw: np.random.Generator, folder: Path, axes: str = "Z") -> str:
    """The profile that the machine test makes of a machine, from a trace with noise."""
    program, form, trace, profile = (folder / name for name in ("t.nc", "t.toml", "t.csv", "p.toml"))
    command_line("write", "-p", "fanuc-lathe", "-o", str(program), "--axes", axes, "--force", "-q")
    groups = groups_of(program.read_text(), x_is_diameter=True)
    record = recorded(groups, {"X": machine, "Z": machine}, draw)
    trace.write_text(record.csv(axes))
    said = command_line("read", str(form), "--trace", str(trace), "-o", str(profile), "--force", "--json")
    (folder / "said.json").write_text(said)
    return str(profile)


def numbers_of(machine: Machine, axis: str = "Z") -> dict[str, float]:
    """The numbers of a machine as a profile calls them."""
    if machine.averages_s:
        names = ("acc_dec_ms", "bell_ms")[: len(machine.averages_s)]
        times_s = dict(zip(names, machine.averages_s, strict=True))
        (lag_s,) = machine.lags_s
    else:
        lag_s, longer_s = sorted(machine.lags_s)
        times_s = {"acc_dec_ms": longer_s}
    found = {f"axes.{axis}.{name}": time_s * 1000.0 for name, time_s in times_s.items()}
    found[f"axes.{axis}.position_gain_1_s"] = 1.0 / lag_s
    if machine.joint_mm_s is not None:
        found["planner.joint_speed_mm_min"] = machine.joint_mm_s * 60.0
        found[f"axes.{axis}.max_acceleration_mm_s2"] = machine.ramp_mm_s2
    return found


def held(machine: Machine, folder: Path) -> list[bool]:
    """Which of the measured numbers are within what was said of their uncertainty.

    Those behind acc/dec are left out where it was said that its kind cannot be told.
    """
    said = json.loads((folder / "said.json").read_text())
    is_open = any(".acc_dec:" in one for one in said["cannot_tell"])
    known = numbers_of(machine)
    return [
        abs(one["value"] / known[one["key"]] - 1.0) <= one["share"]
        for one in said["measured"]
        if one["key"] in known and not (is_open and one["key"].endswith(("_ms", "_1_s")))
    ]


def command_line(*arguments: str) -> str:
    """What ``chipbreak machine-test`` prints."""
    done = CliRunner().invoke(cli, ["machine-test", *arguments])
    assert done.exit_code == 0, done.output
    return done.stdout
