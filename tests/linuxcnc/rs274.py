"""Ask LinuxCNC's own interpreter whether it takes a program, and what it would do with it.

``rs274`` is the interpreter without a machine: it reads a program and prints one *canonical call* for every
thing the machine would be told.  Three habits of it are hidden here: its tool table is in inches whatever
the units of the machine are; it does not run the start-up code of its INI file; and it ends with status 0
for some programs that it never read to the end.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import dist
from pathlib import Path
from typing import NamedTuple

MM_PER_INCH = 25.4
# Nothing of what the interpreter writes need reach a disk.
_IN_MEMORY = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None

START_UP = {
    True: b"G18 G21 G8 G40 G49 G54 G80 G90 G94 G97",
    False: b"G17 G21 G8 G40 G49 G54 G80 G90 G94 G97",
}
"""What the INI file of a lathe (True) or a mill (False) would run before a program."""


class Tool(NamedTuple):
    """One line of the tool table, in mm."""

    number: int
    z_mm: float = 0.0
    x_mm: float = 0.0
    diameter_mm: float = 0.8
    orientation: int = 2

    def line(self) -> str:
        x, z, diameter = (mm / MM_PER_INCH for mm in (self.x_mm, self.z_mm, self.diameter_mm))
        return f"T{self.number} P{self.number} X{x:.8f} Z{z:.8f} D{diameter:.8f} Q{self.orientation}"


ANY_TOOL = tuple(Tool(number) for number in range(1, 100))
"""T1 to T99 without offsets: for programs whose tool data are not the subject."""


@dataclass(frozen=True)
class Judgement:
    """What the interpreter said: ``message`` is its complaint, empty when it had none."""

    accepted: bool
    message: str
    canon: list[str]

    @property
    def motion(self) -> list[Motion]:
        """The moves of the program, in mm."""
        return motion(self.canon)


def available() -> bool:
    """True where the interpreter is installed."""
    return shutil.which("rs274") is not None


def judge(
    program: bytes,
    *,
    lathe: bool,
    subroutines: Path | None = None,
    tools: Sequence[Tool] = ANY_TOOL,
    block_delete: bool = False,
    timeout_s: float = 120.0,
) -> Judgement:
    """Run the real interpreter on a copy of ``program``.

    ``subroutines`` is the folder for ``o<name> call``; ``block_delete`` skips the blocks that start with
    ``/``. The program is accepted when the interpreter reads it to its end (M2, M30 or the second ``%``)
    without a complaint: a program cut short is a rejected one, whatever the exit status says.
    """
    with tempfile.TemporaryDirectory(prefix="rs274-", dir=_IN_MEMORY) as name:
        folder = Path(name)
        (folder / "program.ngc").write_bytes(_with_start_up(program, START_UP[lathe]))
        (folder / "tool.tbl").write_text("".join(tool.line() + "\n" for tool in tools))
        (folder / "parameters.var").write_text("")  # the interpreter fills in what is missing
        (folder / "rs274.ini").write_text(_ini(lathe, subroutines or folder))
        command = ["rs274", "-g", "-i", "rs274.ini", "-t", "tool.tbl", "-v", "parameters.var"]
        command += ["-b"] if block_delete else []
        done = subprocess.run(
            [*command, "program.ngc", "canon.txt"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=timeout_s,
            check=False,
            # The tool table in use lies in the home folder, where two interpreters would share it.
            env={**os.environ, "LC_ALL": "C", "HOME": str(folder)},
        )
        written = folder / "canon.txt"
        canon = written.read_text("latin-1").split("\n")[:-1] if written.exists() else []
    said = [
        line for line in done.stderr.decode("latin-1").split("\n") if line.strip() not in ("", "executing")
    ]
    # Of a hundred thousand moves it is soon seen that they are neither.
    ends = calls(filter(_SAYS_HOW_IT_ENDED.search, canon))
    said += [call.arguments[0] for call in ends if call.name == "CANON_ERROR"]
    finished = any(call.name in ("PROGRAM_END", "FINISH") for call in ends)
    if done.returncode == 0 and not finished and not said:
        said = ["the interpreter stopped before the end of the program and did not say why"]
    return Judgement(done.returncode == 0 and finished, "\n".join(said), canon)


def _with_start_up(program: bytes, start_up: bytes) -> bytes:
    """The program with the start-up block in front, behind the leading ``%`` if there is one."""
    opened = re.match(rb"\s*%[ \t\r]*\n", program)
    cut = opened.end() if opened else 0
    return program[:cut] + start_up + b"\n" + program[cut:]


def _ini(lathe: bool, subroutines: Path) -> str:
    return f"""[EMC]
VERSION = 1.1
[DISPLAY]
LATHE = {int(lathe)}
[RS274NGC]
PARAMETER_FILE = parameters.var
SUBROUTINE_PATH = {subroutines.resolve()}
[TRAJ]
COORDINATES = {"X Z" if lathe else "X Y Z"}
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
[EMCIO]
TOOL_TABLE = tool.tbl
"""


class Call(NamedTuple):
    """One canonical call: its name and the text of its arguments."""

    name: str
    arguments: tuple[str, ...]


_SAYS_HOW_IT_ENDED = re.compile("CANON_ERROR|PROGRAM_END|FINISH")
_BETWEEN = re.compile(r"[ ,]+")
_CALL = re.compile(r"\s*\d+\s+N\S*\s+([A-Z0-9_]+)\((.*)\)\s*$")


def calls(canon: Iterable[str]) -> list[Call]:
    """The canonical calls in ``canon``; a comment or message keeps its text as one argument."""
    found = []
    for line in canon:
        if match := _CALL.match(line):
            name, inside = match.groups()
            whole = name in ("COMMENT", "MESSAGE", "CANON_ERROR")
            found.append(Call(name, (inside[1:-1],) if whole else tuple(_BETWEEN.split(inside.strip()))))
    return found


class Motion(NamedTuple):
    """One move as the machine will get it: end point in program coordinates [mm, X as a radius].

    ``feed`` is mm/min, or mm/rev where ``per_rev``; G93 arrives here as the mm/min that the interpreter
    worked out.  ``speed`` is rev/min, or m/min where ``surface`` (G96).  ``time_s`` is the time asked for:
    0 where feed or speed do not say; an arc counts with its chord.
    """

    kind: str  # feed, traverse, arc, probe, tap, thread, dwell
    x_mm: float
    y_mm: float
    z_mm: float
    feed: float
    per_rev: bool
    speed: float
    surface: bool
    path_mode: str
    time_s: float


_KINDS = {
    "STRAIGHT_FEED": "feed",
    "STRAIGHT_TRAVERSE": "traverse",
    "STRAIGHT_PROBE": "probe",
    "RIGID_TAP": "tap",
    "ARC_FEED": "arc",
}
_PLANE = {"CANON_PLANE_XY": (0, 1, 2), "CANON_PLANE_XZ": (2, 0, 1), "CANON_PLANE_YZ": (1, 2, 0)}
_PATH_MODES = {"CANON_EXACT_PATH": "G61", "CANON_EXACT_STOP": "G61.1", "CANON_CONTINUOUS": "G64"}


def arc_end(arguments: Sequence[str], plane: str) -> list[str]:
    """The words of the end of an ARC_FEED, in the order X, Y, Z."""
    return _arc_end(arguments, _PLANE[plane])


def _arc_end(arguments: Sequence[str], axes: tuple[int, int, int]) -> list[str]:
    """End in the plane, centre and turns stand in front; the end across the plane behind them."""
    first, second, across = axes
    ends = {first: 0, second: 1, across: 5}
    return [arguments[ends[axis]] for axis in range(3)]


class _Machine:
    """The modal state that the canonical calls build up, in mm."""

    def __init__(self) -> None:
        self.scale, self.feed, self.speed, self.pitch = 1.0, 0.0, 0.0, 0.0
        self.per_rev, self.surface = False, False
        self.axes, self.path_mode = (0, 1, 2), "G64"
        self.at = [0.0, 0.0, 0.0]

    def move(self, kind: str, arguments: Sequence[str]) -> Motion:
        start = list(self.at)
        texts = _arc_end(arguments, self.axes) if kind == "arc" else arguments[:3]
        self.at = [float(text) * self.scale for text in texts]
        if kind == "feed" and self.pitch:
            kind = "thread"
        known = kind != "traverse" and not (self.surface and (self.per_rev or self.pitch))
        rate = self.rate_mm_min() if known else 0.0
        return self.record(kind, dist(start, self.at) / rate * 60 if rate > 0 else 0.0)

    def rate_mm_min(self) -> float:
        if self.pitch:
            return self.pitch * self.speed
        return self.feed * self.speed if self.per_rev else self.feed

    def record(self, kind: str, time_s: float) -> Motion:
        feed, per_rev = (self.pitch, True) if self.pitch else (self.feed, self.per_rev)
        x, y, z = self.at
        return Motion(kind, x, y, z, feed, per_rev, self.speed, self.surface, self.path_mode, time_s)

    def set(self, name: str, arguments: Sequence[str]) -> None:
        if name in _SETS:
            field, value = _SETS[name]
            setattr(self, field, value(self, arguments))


# What a call sets, and to what.
_SETS: dict[str, tuple[str, Callable[[_Machine, Sequence[str]], object]]] = {
    "USE_LENGTH_UNITS": ("scale", lambda _, said: MM_PER_INCH if said[0] == "CANON_UNITS_INCHES" else 1.0),
    "SET_FEED_RATE": ("feed", lambda machine, said: float(said[0]) * machine.scale),
    "SET_FEED_MODE": ("per_rev", lambda _, said: said[1] == "1"),
    "START_SPEED_FEED_SYNC": ("pitch", lambda machine, said: float(said[0]) * machine.scale),
    "STOP_SPEED_FEED_SYNCH": ("pitch", lambda _machine, _said: 0.0),
    "SET_SPINDLE_SPEED": ("speed", lambda _, said: float(said[1])),
    "SET_SPINDLE_MODE": ("surface", lambda _, said: float(said[1]) > 0),
    "SELECT_PLANE": ("axes", lambda _, said: _PLANE[said[0]]),
    "SET_MOTION_CONTROL_MODE": ("path_mode", lambda _, said: _PATH_MODES[said[0]]),
}


def motion(canon: Iterable[str]) -> list[Motion]:
    """The moves and dwells in ``canon``, each with the feed, speed and path mode that hold for it."""
    state, moves = _Machine(), []
    for name, arguments in calls(canon):
        if name in _KINDS:
            moves.append(state.move(_KINDS[name], arguments))
        elif name == "DWELL":
            moves.append(state.record("dwell", float(arguments[0])))
        else:
            state.set(name, arguments)
    return moves
