"""Who else reads such programs, and the shortest fair program that makes them do it.

Peers are development tools: nothing of chipbreak imports them.  Each runs in an interpreter of its own, and
only reads; chipbreak reads, changes, checks and writes.  A peer too slow for the whole program gets a part
of it and is scaled by the block; then its start-up does not count, because it would be scaled as well.
"""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from stopwatch import Contestant

GRAMMAR = Path(__file__).resolve().parents[1] / "grammar"

_GCODEPARSER = """
import sys
from collections import deque
from gcodeparser import parse_gcode_lines
with open(sys.argv[1], encoding="latin-1") as file:
    deque(parse_gcode_lines(file), 0)
"""

_NC_GCODE_INTERPRETER = """
import sys, time
from nc_gcode_interpreter import nc_to_dataframe
with open(sys.argv[1], encoding="latin-1") as file:
    text = file.read()
start = time.perf_counter()
nc_to_dataframe(text)
print(time.perf_counter() - start)
"""

_LARK = """
import sys, time
from lark import Lark
with open(sys.argv[2] + "/fanuc.lark", encoding="ascii") as file:
    grammar = file.read()
parser = Lark(grammar, start="block", parser="lalr", lexer="contextual", propagate_positions=True,
              import_paths=[sys.argv[2]])
with open(sys.argv[1], encoding="latin-1", newline="\\n") as file:
    lines = file.read().split("\\n")
start = time.perf_counter()
for line in lines:
    parser.parse(line)
print(time.perf_counter() - start)
"""

_RS274_INI = """[EMC]
VERSION = 1.1
[DISPLAY]
LATHE = 0
[RS274NGC]
PARAMETER_FILE = parameters.var
[TRAJ]
COORDINATES = X Y Z
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
[EMCIO]
TOOL_TABLE = tool.tbl
"""


@dataclass(frozen=True)
class Missing:
    """A peer that is not here, and how to get it."""

    name: str
    how: str


def gcodeparser(program: Path, blocks: int) -> Contestant | Missing:
    """Regular expressions, line by line; it reads a block only where it says G, M or T."""
    if find_spec("gcodeparser") is None:
        return Missing("gcodeparser", "pip install -e '.[bench]'")
    command = (sys.executable, "-c", _GCODEPARSER, str(program))
    return Contestant("gcodeparser", command, blocks, note="reads only")


def nc_gcode_interpreter(program: Path, blocks: int) -> Contestant | Missing:
    """A PEG grammar in Rust; it makes a data frame."""
    if find_spec("nc_gcode_interpreter") is None:
        return Missing("nc-gcode-interpreter", "pip install -e '.[bench]'")
    command = (sys.executable, "-c", _NC_GCODE_INTERPRETER, str(program))
    return Contestant("nc-gcode-interpreter", command, blocks, own_clock=True, note=_part(blocks))


def plain_lark(program: Path, blocks: int) -> Contestant:
    """The grammar of this project, a line at a time, with nothing around it."""
    command = (sys.executable, "-c", _LARK, str(program), str(GRAMMAR))
    return Contestant("plain Lark, our grammar", command, blocks, own_clock=True, note=_part(blocks))


def rs274(program: Path, blocks: int, folder: Path) -> Contestant | Missing:
    """LinuxCNC's interpreter without a machine; it prints each call it would make, here to nowhere."""
    if shutil.which("rs274") is None:
        return Missing("rs274", "install linuxcnc-uspace")
    folder.mkdir(exist_ok=True)
    (folder / "rs274.ini").write_text(_RS274_INI)
    (folder / "tool.tbl").write_text("".join(f"T{tool} P{tool} D0.3\n" for tool in range(1, 10)))
    (folder / "parameters.var").write_text("")
    command = ("rs274", "-g", "-i", "rs274.ini", "-t", "tool.tbl", "-v", "parameters.var")
    environment = {"HOME": str(folder), "LC_ALL": "C"}
    return Contestant(
        "rs274 (LinuxCNC)",
        (*command, str(program), "/dev/null"),
        blocks,
        folder=folder,
        environment=environment,
        note="reads and interprets",
    )


def _part(blocks: int) -> str:
    return f"on {blocks} blocks, without its start-up; scaled by the block"
