"""A small machine that runs lathe programs: the tests' own reading of what comes out.

It knows nothing of the package.  Lengths are mm with X as radius, times are seconds on a control without
limits, speeds are what the spindle is told.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import chipbreak

Floats = NDArray[np.float64]
_WORD = re.compile(r"([A-Za-z])[ \t]*([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))")
_COMMENT = re.compile(r"\([^)]*\)|;.*")
_NO_MOVE = re.compile(r"G0?4(?![0-9])|G(?:28|50|92|65)|M98")
_BRACKET = re.compile(r"\(CHIPBREAK (BEGIN|WAS|HEX|END) ?([^()]*)\)")
_FEED_MODES = {93: "inverse", 94: "minute", 98: "minute", 95: "rev", 99: "rev"}


@dataclass(frozen=True)
class State:
    """What the control holds between two blocks."""

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    motion: int = 0
    feed_mode: str = "rev"
    feed: float = 0.0
    speed_mode: int = 97
    speed: float = 0.0
    incremental: bool = False
    unit: float = 1.0
    spindle: int = 5
    plane: int = 18


@dataclass(frozen=True)
class Move:
    """One feed move: where it goes, how long it takes, and the words it was written with."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    span_s: float
    speed_rpm: float
    words: dict[str, str]


@dataclass
class Run:
    """A program, run.  ``outside`` are the lines that no change touched, with the state before each."""

    moves: list[Move] = field(default_factory=list)
    cuts: list[list[Move]] = field(default_factory=list)
    titles: list[str] = field(default_factory=list)
    outside: list[tuple[str, State]] = field(default_factory=list)
    state: State = State()


def run_program(text: str, *, diameter: bool = True, feed_mode: str = "rev") -> Run:
    """Run a program from its first to its last line."""
    run = Run(state=State(feed_mode=feed_mode))
    inside = False
    for line in text.splitlines():
        mark = _BRACKET.search(line)
        if mark:
            inside = mark[1] not in ("END",)
            if mark[1] == "BEGIN":
                run.titles.append(mark[2].strip())
                run.cuts.append([])
            continue
        if not inside:
            run.outside.append((line, run.state))
        move = _step(run, line, diameter)
        if move is not None:
            run.moves.append(move)
            if inside:
                run.cuts[-1].append(move)
    run.cuts = [cut for cut in run.cuts if cut]
    return run


def _step(run: Run, line: str, diameter: bool) -> Move | None:
    code = _COMMENT.sub("", line)
    words = _WORD.findall(code)
    modal: dict[str, Any] = {}
    for letter, value in words:
        modal |= _modal(letter.upper(), value)
    state = replace(run.state, **modal) if modal else run.state
    first = words[0][0].upper() if words else ""
    axes = {a: v for a, v in (words[1:] if first == "N" else words) if a in "XYZUVW"}
    if not axes or _NO_MOVE.search(code):
        run.state = state
        return None
    end = list(state.point)
    for letter, value in axes.items():
        axis = "XYZUVW".index(letter) % 3
        mm = float(value) * state.unit / (2.0 if axis == 0 and diameter else 1.0)
        relative = state.incremental or letter in "UVW"
        end[axis] = state.point[axis] + mm if relative else mm
    target = (end[0], end[1], end[2])
    run.state = replace(state, point=target)
    if state.motion == 0:
        return None
    span_s = _span(state, math.dist(state.point, target))
    return Move(state.point, target, span_s, state.speed, axes)


def _modal(letter: str, value: str) -> dict[str, Any]:
    """What a word sets."""
    if letter in "GM":
        return _SETS.get((letter, float(value)), {})
    held = {"F": "feed", "S": "speed"}.get(letter)
    return {held: float(value)} if held else {}


# What G and M codes set.
_SETS: dict[tuple[str, float], dict[str, Any]] = {
    **{("M", code): {"spindle": code} for code in (3, 4, 5)},
    **{("G", code): {"motion": code} for code in (0, 1, 2, 3)},
    **{("G", code): {"feed_mode": mode} for code, mode in _FEED_MODES.items()},
    **{("G", code): {"speed_mode": code} for code in (96, 97)},
    **{("G", code): {"incremental": code == 91} for code in (90, 91)},
    **{("G", code): {"plane": code} for code in (17, 18, 19)},
    ("G", 20): {"unit": 25.4},
    ("G", 21): {"unit": 1.0},
}


def _span(state: State, length_mm: float) -> float:
    if state.feed_mode == "inverse":
        return 60.0 / state.feed
    per_min = state.feed * state.unit * (state.speed if state.feed_mode == "rev" else 1.0)
    return length_mm / per_min * 60.0 if per_min > 0.0 else math.nan


# --- what a cut does, measured on its moves ---------------------------------------------------------------


def times(cut: Sequence[Move]) -> Floats:
    """When each move of a cut starts, and the end of the last: (moves + 1,) seconds."""
    return np.concatenate(([0.0], np.cumsum([move.span_s for move in cut])))


def points(cut: Sequence[Move]) -> Floats:
    """The knots of a cut: (moves + 1, 3) mm."""
    return np.array([cut[0].start, *(move.end for move in cut)])


def along_line(cut: Sequence[Move]) -> Floats:
    """Distance from the start of the cut along its chord, for cuts on one straight line."""
    knots = points(cut)
    chord = knots[-1] - knots[0]
    along: Floats = (knots - knots[0]) @ (chord / np.linalg.norm(chord))
    return along


@dataclass(frozen=True)
class Vibration:
    """A vibration as fitted to a cut: crests and troughs of the motion about its mean."""

    crest_s: Floats
    crest_mm: Floats
    trough_s: Floats
    speed_rpm: float

    @property
    def period_s(self) -> float:
        """The mean time between two crests of full stroke."""
        full_s = self.crest_s[self.crest_mm > 0.9 * self.stroke_mm]
        return float((full_s[-1] - full_s[0]) / (len(full_s) - 1))

    @property
    def per_rev(self) -> float:
        """Vibrations per revolution."""
        return 60.0 / (self.period_s * self.speed_rpm)

    @property
    def stroke_mm(self) -> float:
        """The largest height of a crest above the mean motion that the troughs run on."""
        return float(self.crest_mm.max())

    @property
    def forward_share(self) -> float:
        """Which share of a vibration goes forward."""
        shares = [
            (crest - self.trough_s[self.trough_s < crest - 1e-9].max(initial=0.0)) / self.period_s
            for crest in self.crest_s
        ]
        return float(np.median(shares))


def fit(time_s: Floats, distance_mm: Floats, speed_rpm: float, mean_mm_s: float) -> Vibration:
    """Crests and troughs of s(t) - v t; troughs of a vibration ahead of the mean feed lie on it."""
    ahead = distance_mm - mean_mm_s * time_s
    rising = np.diff(ahead) > 1e-9
    crest = np.flatnonzero(rising[:-1] & ~rising[1:]) + 1
    trough = np.flatnonzero(~rising[:-1] & rising[1:]) + 1
    return Vibration(time_s[crest], ahead[crest], time_s[trough], speed_rpm)


def vibration_of(cut: Sequence[Move]) -> Vibration:
    """The vibration of a cut on one straight line; the plain move at its end gives the mean feed."""
    time_s, along = times(cut), along_line(cut)
    mean = (along[-1] - along[-2]) / cut[-1].span_s
    return fit(time_s, along, cut[-1].speed_rpm, float(mean))


# --- running the filter -----------------------------------------------------------------------------------


def filtered(
    program: str | bytes, profile: str = "generic-lathe", *sets: str, allow_unbroken: bool = False
) -> str:
    """The program that the filter makes of a program, as latin-1 text."""
    data = program.encode("latin-1") if isinstance(program, str) else program
    settings = chipbreak.load(profile, sets)
    return chipbreak.rewrite(data, settings, allow_unbroken=allow_unbroken).data.decode("latin-1")


def rejected(program: str | bytes, profile: str = "generic-lathe", *sets: str) -> list[tuple[str, int, int]]:
    """Code, line and column of every error in a program that must be rejected; each has a way out."""
    data = program.encode("latin-1") if isinstance(program, str) else program
    try:
        chipbreak.rewrite(data, chipbreak.load(profile, sets))
    except chipbreak.ProgramRejectedError as error:
        return list(_errors(error))
    raise AssertionError("the program was taken")


def beside_unproven(
    diagnostics: Sequence[chipbreak.Diagnostic], cuts: bool = True
) -> list[chipbreak.Diagnostic]:
    """The others: where cuts break their chips on a control of which nothing is known, that is said once."""
    others = [found for found in diagnostics if found.code != "VIB079"]
    assert len(diagnostics) - len(others) == int(cuts), "unproven verdicts are said once, and no others are"
    return others


def _errors(error: chipbreak.ProgramRejectedError) -> Iterator[tuple[str, int, int]]:
    for diagnostic in error.diagnostics:
        if diagnostic.severity.value == "error":
            assert diagnostic.place is not None
            assert diagnostic.help, f"{diagnostic.code} shows no way out"
            yield diagnostic.code, diagnostic.place.line, diagnostic.place.column
