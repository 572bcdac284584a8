"""Programs to measure with: made here, the same bytes every time, written a block at a time.

Nothing is held in memory: on Linux the peak memory of a child counts that of the process it was started
from, and the process that makes the programs is the one that starts the children.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

OPERATIONS = 50
# Tools that come back, so that a tool is measured again when its next operation asks for another limit.
TOOLS = 5
_LEAST_BLOCKS = 20
_CUT_MM = 166.0
_MOVES_A_CUT = 10_000


def milling(
    path: Path, blocks: int, operations: int = OPERATIONS, *, comments: bool = True, modal: bool = False
) -> None:
    """A three-axis program of so many blocks: numbered, each coordinate with its point, G1 in every move.

    Each tool roughs, then finishes, and goes: half of the borders are tool changes, half are not.  Without
    ``comments`` there is no ``%`` either, because not every reader takes them; ``modal`` says G1 once.
    """
    lines = _milling_lines(blocks, operations, comments, "" if modal else "G1 ")
    with path.open("w", encoding="ascii", newline="\n") as file:
        file.write("%\n" if comments else "")
        file.writelines(lines)
        file.write("%\n" if comments else "")


def _milling_lines(blocks: int, operations: int, comments: bool, code: str) -> Iterator[str]:
    operations = max(1, min(operations, blocks // _LEAST_BLOCKS))
    number, cuts = 0, blocks // operations
    for operation in range(operations):
        for text in _head(operation, comments):
            number += 1
            yield f"N{number} {text}\n"
        tail = ("G0 Z50.000 M9", "M30" if operation == operations - 1 else "M1")
        last = blocks if operation == operations - 1 else (operation + 1) * cuts
        for move in range(last - number - len(tail)):
            number += 1
            yield f"N{number} {code}{_move(operation, move)}\n"
        for text in tail:
            number += 1
            yield f"N{number} {text}\n"


def _head(operation: int, comments: bool) -> Iterator[str]:
    tool = operation // 2 % TOOLS + 1
    finishes = operation % 2 == 1
    if comments:
        yield f"(POCKET {operation // 2 + 1} {'FINISH' if finishes else 'ROUGH'})"
    if not finishes:
        yield f"T{tool} M6"
        yield "G90 G54 G17 G21 G94"
        yield f"S{3000 + 500 * tool} M3"
        yield "G0 X0.000 Y0.000"
        yield f"G43 Z50.000 H{tool} M8"
    yield "G0 Z2.000"
    yield f"G1 Z-0.500 F{200 if finishes else 600}.0"


def _move(operation: int, move: int) -> str:
    """Rows to and fro over a wavy floor; whole arithmetic, so the same on every machine."""
    row, step = divmod(move, 200)
    x = (step if row % 2 == 0 else 199 - step) * 997 - 99_000
    y = row * 353 % 160_001 - 80_000
    z = -500 - operation * 40 - (step * 37 + row * 11) % 1000
    return f"X{_decimal(x)} Y{_decimal(y)} Z{_decimal(z)}"


def _decimal(thousandths: int) -> str:
    whole, part = divmod(abs(thousandths), 1000)
    return f"{'-' if thousandths < 0 else ''}{whole}.{part:03d}"


def turning(path: Path, moves: int) -> int:
    """A roughing program whose cuts expand to about so many moves; returns the number of its blocks."""
    cuts = max(1, moves // _MOVES_A_CUT)
    lines = ["%", "O1 (ROUGH TURN)", "G21 G40 G80 G99", "T0101", "G97 S2500 M3"]
    for cut in range(cuts):
        diameter = 60.0 - 0.2 * cut
        lines += [f"G0 X{diameter:.3f} Z2. M8", f"G1 Z-{_CUT_MM - 2.0:.3f} F0.05 N1.5", "G0 U2. Z2."]
    lines += ["M9", "M30", "%"]
    path.write_text("".join(f"{line}\n" for line in lines), "ascii", newline="\n")
    return len(lines)


def planned(path: Path, cuts: int, wave: str) -> int:
    """Cuts for LinuxCNC's own planner, asked for by a directive; returns the number of its blocks."""
    lines = ["(ROUGH TURN)", "G21 G40 G80 G95 G7 G18", "G97 S500 M3"]
    for cut in range(cuts):
        diameter = 60.0 - 0.2 * cut
        lines += [f"G0 X{diameter:.3f} Z2. M8", f"(VIB N{wave})", "G1 Z-82. F0.05", "(VIB OFF)"]
        lines += ["G0 X70. Z2."]
    lines += ["M9", "M30"]
    path.write_text("".join(f"{line}\n" for line in lines), "ascii", newline="\n")
    return len(lines)


def long_line(path: Path, size: int) -> None:
    """One line without an end."""
    words = b"X1.5 Y-2.25 Z0.125 "
    part = words * (1 << 12)
    with path.open("wb") as file:
        for _ in range(size // len(part)):
            file.write(part)
        file.write(part[: size % len(part)])
