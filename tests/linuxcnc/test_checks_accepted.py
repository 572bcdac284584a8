"""Mill programs with tool checks past LinuxCNC's own interpreter, with the macros that they call."""

from __future__ import annotations

from pathlib import Path

import pytest

import chipbreak
from beam import BEAM
from chipbreak.editing.restore import regions
from chipbreak.text.source import read
from macros.lc_stand import LC_SETTINGS, subroutines

from . import rs274

MILLS = tuple(rs274.Tool(number, orientation=0) for number in range(100))
SAMPLE = Path(__file__).parents[2] / "samples" / "fusion-mill.nc"
INCREMENTAL = b"""G21 G17 G40 G80 G90
T1 M6
S1000 M3
G0 X1 Y1
G43 H1 Z10
G91
G1 Z-11 F100
X5
G0 Z11
(FINISH)
G90 G0 X1 Y5
Z-1
G1 X7 F100
G0 Z10
M2
"""


def filtered(program: bytes, folder: Path) -> chipbreak.Result:
    """With all that a check says of a tool, a sister and a count."""
    table = folder / "tools.csv"
    row = "flat end mill,4,10,50,80,30"
    head = "number,type,teeth,diameter_mm,length_mm,holder_mm,helix_deg"
    table.write_text("\n".join([head, *(f"{number},{row}" for number in range(100)), ""]))
    options = [f'tools.files=["{table}"]', "checks.every=2", "checks.sister.1=51"]
    return chipbreak.rewrite(program, chipbreak.load("linuxcnc-mill", (*BEAM, *options)), "program.ngc")


def cuts(judgement: rs274.Judgement) -> list[tuple[object, ...]]:
    return [
        (move.kind, round(move.x_mm, 3), round(move.y_mm, 3), round(move.z_mm, 3), move.feed, move.speed)
        for move in judgement.motion
        if move.kind not in ("traverse", "dwell")
    ]


def is_taken(program: bytes, folder: Path) -> bool:
    """True when the filter changed a program that LinuxCNC takes; then it must take the result."""
    try:
        result = filtered(program, folder)
    except chipbreak.ProgramRejectedError:
        return False
    if not result.edits:
        return False
    subs = folder / "subs"
    subs.mkdir(exist_ok=True)
    subroutines(LC_SETTINGS, subs)
    before = rs274.judge(program, lathe=False, subroutines=subs, tools=MILLS)
    if not before.accepted:
        return False
    after = rs274.judge(result.data, lathe=False, subroutines=subs, tools=MILLS)
    assert after.accepted, after.message
    assert cuts(after) == cuts(before)
    source = read(result.data)
    new = [source.text(line) for found in regions(source) for line in range(found.first, found.last)]
    assert max(map(len, new)) <= 80
    return True


@pytest.mark.linuxcnc
def test_the_sample(tmp_path: Path) -> None:
    program = SAMPLE.read_bytes().replace(b"O1042 ", b"")  # LinuxCNC reads a subprogram there
    assert is_taken(program, tmp_path)


@pytest.mark.linuxcnc
def test_incremental_mode_at_a_check(tmp_path: Path) -> None:
    assert is_taken(
        INCREMENTAL.replace(b"(FINISH)\nG90 ", b"(FINISH)\n").replace(b"Z-1\n", b"Z-11\n"), tmp_path
    )
    assert is_taken(INCREMENTAL, tmp_path)


@pytest.mark.linuxcnc
def test_real_programs(corpus: list[Path], tmp_path: Path) -> None:
    taken = [
        file.name
        for file in corpus
        if file.stat().st_size < 2_000_000 and is_taken(file.read_bytes(), tmp_path)
    ]
    assert len(taken) >= 10
