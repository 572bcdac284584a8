"""Which lines of a long file are kept, against a rule that sees all of the file at once."""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest

from chipbreak.dialects import find
from chipbreak.syntax import deciding_lines
from chipbreak.syntax.deciding_lines import read_long
from chipbreak.text.long_file import LongFile

FANUC = find("fanuc-mill", "A")
PLAIN = re.compile(r"(?:N\d+ ?)?(?:G0?([0-3]) ?)?((?:[XYZF]-?[0-9.]+ ?)+)")


def kept_lines(text: str, folder: Path, around: int, piece_bytes: int) -> list[int] | None:
    """The lines that are kept, from 0; None where the file is read whole."""
    file = folder / "long.nc"
    file.write_bytes(text.encode())
    with file.open("rb") as opened:
        found = read_long(LongFile.of(opened, "long.nc"), FANUC, around, piece_bytes)
        if found is None:
            return None
        lines = text.splitlines(keepends=True)
        assert found.source.user_lines is not None
        kept = [int(number) - 1 for number in found.source.user_lines.numbers]
        assert found.source.data.decode() == "".join(lines[at] for at in kept)
        # Between them is what was left out, every byte of it.
        gaps = "".join(text[gap.start : gap.start + gap.size] for gap in found.gaps)
        assert gaps == "".join(line for at, line in enumerate(lines) if at not in kept)
        assert sum(gap.line_count for gap in found.gaps) == len(lines) - len(kept)
        return kept


def by_rule(text: str, around: int) -> list[int]:
    """Run by run: up to the first cut and some more, the last of each kind, from some before the last cut."""
    lines = text.splitlines()
    kept: set[int] = set()
    mode: int | None = None
    at = 0
    for is_plain, some in groupby(lines, lambda line: PLAIN.fullmatch(line) is not None):
        run = list(some)
        if is_plain:
            found, mode = kept_of_run(run, mode, around)
            kept |= {at + line for line in found}
        else:
            kept |= {*range(at, at + len(run))}
            mode = mode_behind(run, mode)
        at += len(run)
    return sorted(kept)


def kept_of_run(run: list[str], mode: int | None, around: int) -> tuple[set[int], int | None]:
    """What is kept of lines of plain motion, and the motion that they leave in force."""
    cuts = []
    for at, line in enumerate(run):
        match = PLAIN.fullmatch(line)
        assert match is not None
        mode = int(match[1]) if match[1] else mode
        if mode != 0 and re.search("[XYZ]", match[2]):
            cuts.append(at)
    every = set(range(len(run)))
    if not cuts:
        return every, mode
    middle = range(cuts[0] + around + 1, cuts[-1] - around)
    lasts = {kind_of(run[at]): at for at in middle}
    return every.difference(middle) | {*lasts.values()}, mode


def mode_behind(lines: list[str], mode: int | None) -> int | None:
    """The motion in force behind lines that are more than plain motion; None where nobody says."""
    for line in lines:
        for code in map(int, re.findall(r"G0*(\d{1,3})", re.sub(r"\([^)]*\)|;.*", "", line))):
            if code in (0, 1, 2, 3):
                mode = code
            elif code in (33, 38, *range(73, 90)):
                mode = None
    return mode


def kind_of(line: str) -> tuple[object, ...]:
    """Letters, whether all numbers have points, code of motion."""
    match = PLAIN.fullmatch(line)
    assert match is not None
    numbers = re.findall(r"([XYZF])(-?[0-9.]+)", match[2])
    return (
        frozenset(letter for letter, _ in numbers),
        all("." in one for _, one in numbers),
        match[1] and int(match[1]),
    )


LINES = [
    *["X1. Y2.", "X1. Y2.", "Y3.", "X5", "G1 X1. F100.", "F50.", "N7 X2.", "G2 X1. Y1.", "G1 X1."],
    *["G0 X1.", "M8", "G81 Z-1.", "(G1 NOTE)", "G4 P0.1 ; G0", "G90", "G33 Z-1. F1.", "G04 P1. G00", "N5"],
]  # fmt: skip


def drawn(seed: int) -> str:
    random = np.random.default_rng(seed)
    lines: list[str] = []
    while len(lines) < 120:
        some = random.choice(LINES[:9] if random.random() < 0.7 else LINES, random.integers(1, 4)).tolist()
        lines += random.choice(some, random.integers(1, 40)).tolist()
    return "".join(f"{line}\n" for line in lines)


@pytest.mark.parametrize("seed", range(12))
def test_the_lines_that_are_kept_are_those_of_the_rule(seed: int, tmp_path: Path) -> None:
    text = drawn(seed)
    for around, piece_bytes in ((0, 1 << 20), (3, 1 << 20), (0, 90), (1, 200), (2, 33)):
        wanted = by_rule(text, around)
        found = kept_lines(text, tmp_path, around, piece_bytes)
        if len(wanted) == text.count("\n"):
            assert found is None, "nothing is left out"
        else:
            assert found == wanted, (around, piece_bytes)


@pytest.mark.parametrize("piece_bytes", [40, 1 << 20])
@pytest.mark.parametrize(
    ("before", "first_cut"),
    [
        # With what is in force before a run its first line cuts, or none does.
        ("G1", True),
        ("G0", False),
        ("G01", True),
        ("G00", False),
        ("G3 X1. R5. M8", True),
        ("G1 G0 M8", False),
        ("G0 G90", False),
        ("G0 G4 P1.", False),
        ("G0\n(G1)", False),
        ("G0\nM8 ; G1", False),
        ("G0\nG81 Z1. M8", True),
        ("G0\nG89", True),
        ("G0\nG73", True),
        ("G0\nG33", True),
        ("G0\nG38.2", True),
        ("G0\nG72", False),
        ("G0\nG90", False),
        ("G0\nG5", False),
        ("G0\ng 001 m8", True),
        ("M8", True),
    ],
)
def test_what_is_in_force_before_a_run(
    before: str, first_cut: bool, piece_bytes: int, tmp_path: Path
) -> None:
    head = before.count("\n") + 1
    text = f"{before}\n" + "X1. Y1.\n" * 9 + "M8\nG1\n" + "X2. Y2.\n" * 9
    second = [head + 9, head + 10, head + 11, head + 18, head + 19]
    run = [head, head + 7, head + 8] if first_cut else [*range(head, head + 9)]
    kept = kept_lines(text, tmp_path, 0, piece_bytes)
    assert kept == [*range(head), *run, *second]


@pytest.mark.parametrize(
    ("text", "is_read_whole"),
    [
        ("G1\n" + "X1.\n" * 9, False),
        ("G1\n" + "X1.\n" * 2, True),
        ("G1\r\n" + "X1.\r\n" * 9, False),
        ("G1\r" + "X1.\r" * 9, True),
        ("G1\n" + "X1.\n" * 9 + "M8\rM9\n", True),
        ("G1\n" + "X1.\n" * 9 + "G1 X1. N1.5\n", True),
        ("G1\n" + "X1.\n" * 9 + "N15 X1.\n", False),
        ("G1\n" + "X1.\n" * 9 + "X1.", False),
        ("", True),
    ],
)
@pytest.mark.parametrize("piece_bytes", [7, 1 << 20])
def test_what_is_read_whole(text: str, is_read_whole: bool, piece_bytes: int, tmp_path: Path) -> None:
    assert (kept_lines(text, tmp_path, 0, piece_bytes) is None) is is_read_whole


@pytest.mark.parametrize(
    ("most_bytes", "most_share", "is_read_whole"), [(0, 0.0, True), (0, 1.0, False), (1 << 20, 0.0, False)]
)
def test_a_file_of_which_too_much_is_kept_is_read_whole(
    monkeypatch: pytest.MonkeyPatch, most_bytes: int, most_share: float, is_read_whole: bool, tmp_path: Path
) -> None:
    monkeypatch.setattr(deciding_lines, "_MOST_KEPT_BYTES", most_bytes)
    monkeypatch.setattr(deciding_lines, "_MOST_KEPT_SHARE", most_share)
    text = "G1\n" + "X1.\n" * 9
    assert (kept_lines(text, tmp_path, 0, 1 << 20) is None) is is_read_whole
