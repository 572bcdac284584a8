"""Chains of lines and arcs in every plane: LinuxCNC's interpreter says where the original goes, and whether
every point of the vibrated cut lies there.

The original goes through the interpreter as it is, without the wish for vibration; its canonical moves are
the truth.  Then the filtered program goes through it, and its straight moves are held against them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import Phase, event, given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.text.source import read

from . import rs274

Floats = NDArray[np.float64]
_AXES = {"17": (0, 1), "18": (2, 0), "19": (1, 2)}
_DIGITS = 4
# Canonical numbers have four decimals, in inches as in millimetres.
_CANON = 1.01e-4


@dataclass(frozen=True)
class Drawn:
    """A program that asks for vibration, with what the test must know of it."""

    program: str
    lathe: bool
    plane: str
    inch: bool
    sets: tuple[str, ...]

    @property
    def unit_mm(self) -> float:
        return 25.4 if self.inch else 1.0

    def without_wish(self) -> str:
        return self.program.replace("(VIB N1.5)\n", "")


class _Writer:
    """Writes the blocks of a chain, and keeps where the tool stands, in the units of the program."""

    def __init__(self, draw: st.DrawFn) -> None:
        self.draw = draw
        self.lathe, self.inch, self.minute = (draw(st.booleans()) for _ in range(3))
        self.incremental, self.absolute_centre, self.diameter = (draw(st.booleans()) for _ in range(3))
        self.plane = draw(st.sampled_from(["18"] if self.lathe else ["17", "18", "19"]))
        self.named = [0, 2] if self.lathe else [0, 1, 2]
        self.at = [self.grid(draw(st.floats(5.0, 30.0))) if a in self.named else 0.0 for a in range(3)]
        self.start = self.words([0.0, 0.0, 0.0], self.at, self.named)

    def grid(self, mm: float) -> float:
        """A drawn length in program units, as it will be printed."""
        return round(mm / (25.4 if self.inch else 1.0), _DIGITS)

    def words(self, start: Sequence[float], end: Sequence[float], axes: Sequence[int]) -> str:
        """Axis words from one point to another: the differences."""
        wide = [2.0 if self.diameter and axis == 0 else 1.0 for axis in range(3)]
        return " ".join(f"{'XYZ'[a]}{(end[a] - start[a]) * wide[a]:.{_DIGITS + 1}f}" for a in sorted(axes))

    def go(self, end: list[float], axes: Sequence[int]) -> str:
        words = self.words(self.at if self.incremental else [0.0] * 3, end, axes)
        self.at = end
        return words

    def line(self) -> str:
        moved = self.draw(st.lists(st.sampled_from(self.named), min_size=1, max_size=3, unique=True))
        end = list(self.at)
        for axis in moved:
            end[axis] += self.grid(self.draw(st.floats(2.0, 6.0) | st.floats(-6.0, -2.0)))
        return f"G1 {self.go(end, moved)}"

    def arc(self, kind: str) -> str:
        draw, turn, start, end = self.draw, self.draw(st.sampled_from([2, 3])), list(self.at), list(self.at)
        first, second = _AXES[self.plane]
        size, angle = draw(st.floats(1.5, 5.0)), draw(st.floats(0.0, 2.0 * math.pi))
        sweep = draw(st.floats(0.9, 2.8) | st.floats(3.5, 5.5))
        offset = self.grid(size * math.cos(angle)), self.grid(size * math.sin(angle))
        radius = math.hypot(*offset)
        last = math.atan2(-offset[1], -offset[0]) + (sweep if turn == 3 else -sweep)
        axes = [first, second]
        if kind != "full circle":
            end[first] = round(start[first] + offset[0] + radius * math.cos(last), _DIGITS)
            end[second] = round(start[second] + offset[1] + radius * math.sin(last), _DIGITS)
        if not self.lathe and draw(st.booleans()):
            axes.append(3 - first - second)
            end[axes[2]] += self.grid(draw(st.floats(-2.0, 2.0)))
        words = f"G{turn} {self.go(end, axes)}"
        if kind == "arc by radius":
            return f"{words} R{math.copysign(radius, math.pi - sweep):.6f}"
        centre = [o + (start[a] if self.absolute_centre else 0.0) for o, a in zip(offset, axes, strict=False)]
        return f"{words} {'IJK'[first]}{centre[0]:.{_DIGITS}f} {'IJK'[second]}{centre[1]:.{_DIGITS}f}"


@st.composite
def programs(draw: st.DrawFn) -> Drawn:
    write = _Writer(draw)
    kinds = st.sampled_from(["line", "arc by centre", "arc by radius", "full circle"])
    chosen = draw(st.lists(kinds, min_size=1, max_size=3))
    blocks = [write.line() if kind == "line" else write.arc(kind) for kind in chosen]
    feed = draw(st.sampled_from([0.2, 0.4])) / (25.4 if write.inch else 1.0)
    blocks[0] += f" F{feed * 800 if write.minute else feed:.6f}"
    head = [
        f"G{20 if write.inch else 21} G{write.plane} G{7 if write.diameter else 8}",
        f"G{'90.1' if write.absolute_centre else '91.1'} G97 S800 M3",
        f"G{94 if write.minute else 95}",
        f"G90 G0 {write.start}",
        f"G{91 if write.incremental else 90}",
    ]
    tail = ["(VIB OFF)", "G90 G0 X40. Z40.", "G1 X41. F0.5", "M2", ""]
    program = "\n".join([*head, "(VIB N1.5)", *blocks, *tail])
    sets = (
        'planner.model="ideal"',
        f"output.feed_mode={draw(st.sampled_from(['rev', 'inverse', 'minute']))}",
        f"output.segments={draw(st.sampled_from(['tick', 'stroke']))}",
    )
    return Drawn(program, write.lathe, write.plane, write.inch, sets)


class Leg:
    """One canonical move of the original: a line or an arc, in the units of the program."""

    def __init__(self, start: Floats, name: str, arguments: tuple[str, ...], axes: tuple[int, int]) -> None:
        values = [float(text) for text in arguments]
        self.start, self.end, self.arc = start, start.copy(), name == "ARC_FEED"
        if not self.arc:
            self.end[:] = values[:3]
            return
        first, second, *centre, rotation, across = values[:6]
        self.axes, self.centre, self.across = axes, np.array(centre), 3 - sum(axes)
        self.end[axes[0]], self.end[axes[1]], self.end[self.across] = first, second, across
        self.sense = math.copysign(1.0, rotation)
        here = start[list(axes)] - self.centre
        there = self.end[list(axes)] - self.centre
        self.first = math.atan2(here[1], here[0])
        sweep = self.sense * (math.atan2(there[1], there[0]) - self.first) % (2.0 * math.pi)
        is_full = np.hypot(*(here - there)) < 2.0 * _CANON
        self.sweep = self.sense * (2.0 * math.pi if is_full else sweep)
        self.radius = float(np.hypot(*here))

    def at(self, share: Floats) -> Floats:
        """Points at shares of the way, (n,) -> (n, 3)."""
        points: Floats = self.start + share[:, None] * (self.end - self.start)
        if self.arc:
            angle = self.first + self.sweep * share
            points[:, self.axes[0]] = self.centre[0] + self.radius * np.cos(angle)
            points[:, self.axes[1]] = self.centre[1] + self.radius * np.sin(angle)
        return points

    def length(self) -> float:
        """The length of the way."""
        if not self.arc:
            return float(np.linalg.norm(self.end - self.start))
        return math.hypot(self.radius * self.sweep, self.end[self.across] - self.start[self.across])

    def distances(self, points: Floats) -> Floats:
        """How far points are away, (n, 3) -> (n,); on a helix the foot is taken at the same angle."""
        if self.arc:
            seen = points[:, self.axes] - self.centre
            turned = (np.arctan2(seen[:, 1], seen[:, 0]) - self.first) * self.sense % (2.0 * math.pi)
            share = np.minimum(turned / abs(self.sweep), 1.0)
        else:
            way = self.end - self.start
            share = np.clip((points - self.start) @ way / (way @ way), 0.0, 1.0)
        feet = [self.at(share), self.at(np.zeros(1)), self.at(np.ones(1))]
        nearest: Floats = np.min([np.linalg.norm(points - foot, axis=1) for foot in feet], axis=0)
        return nearest


def judged(program: str | bytes, *, lathe: bool) -> rs274.Judgement:
    data = program.encode("latin-1") if isinstance(program, str) else program
    judgement = rs274.judge(data, lathe=lathe)
    assert judgement.accepted, judgement.message
    return judgement


def cut_of(judgement: rs274.Judgement, plane: str) -> tuple[Floats, list[Leg]]:
    """The start of the cut and its moves: from the first feed move to the next rapid."""
    at, legs = np.zeros(3), []
    for name, arguments in rs274.calls(judgement.canon):
        if name == "STRAIGHT_TRAVERSE":
            if legs:
                break
            at = np.array([float(text) for text in arguments[:3]])
        elif name in ("STRAIGHT_FEED", "ARC_FEED"):
            legs.append(Leg(at, name, arguments, _AXES[plane]))
            at = legs[-1].end
    return legs[0].start, legs


@pytest.mark.few(6)
@pytest.mark.linuxcnc
@given(programs())
@hypothesis_settings(max_examples=40, phases=[Phase.explicit, Phase.reuse, Phase.generate])
def test_every_point_lies_where_the_original_goes(drawn: Drawn) -> None:
    profile = "linuxcnc-lathe" if drawn.lathe else "linuxcnc-mill"
    settings = chipbreak.load(profile, (*drawn.sets, "checks.enabled=false"))
    data = drawn.program.encode()
    try:
        result = chipbreak.rewrite(data, settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError as error:
        codes = {d.code for d in error.diagnostics if d.severity.value == "error"}
        event(f"refused {codes}")
        assert codes <= {"VIB013", "VIB022", "VIB058"}, [d.render() for d in error.diagnostics]
        return
    event("taken" if result.cuts else "too short, left plain")
    if not result.cuts:
        assert result.data == data
        return
    assert restore(read(result.data)).data == data
    assert chipbreak.rewrite(result.data, settings, allow_unbroken=True).data == result.data
    lies_on_the_path(drawn, settings, result)


def lies_on_the_path(drawn: Drawn, settings: chipbreak.Settings, result: chipbreak.Result) -> None:
    """Every point of the cut as the interpreter runs it, and the time that it takes."""
    was, now = judged(drawn.without_wish(), lathe=drawn.lathe), judged(result.data, lathe=drawn.lathe)
    start, legs = cut_of(was, drawn.plane)
    start_now, moves = cut_of(now, drawn.plane)
    assert not any(move.arc for move in moves)
    assert start_now == pytest.approx(start, abs=_CANON)
    assert moves[-1].end == pytest.approx(legs[-1].end, abs=2.0 * _CANON)

    # Off the path by rounding and chords alone.
    ends = np.array([move.end for move in moves])
    step = 10.0**-settings.output.decimals / (10.0 if drawn.inch else 1.0)
    off = np.min([leg.distances(ends) for leg in legs], axis=0)
    assert off.max() <= step + 2.0 * _CANON
    middles = (ends[1:] + ends[:-1]) / 2.0
    off = np.min([leg.distances(middles) for leg in legs], axis=0)
    assert off.max() <= 0.0011 / drawn.unit_mm + step + 2.0 * _CANON

    # It takes the time of the cut without vibration, at the speed that it has now.
    cut = next(c for c in result.cuts)
    took_s = sum(move.time_s for move in now.motion[:-1] if move.kind == "feed")
    feed_mm_s = cut.wave.feed_mm_rev * cut.plan.solution.speed_rpm / 60.0
    length_mm = sum(leg.length() for leg in legs) * drawn.unit_mm
    # Canonical moves have four decimals; of a short one in inches that leaves too little to take its time.
    assert drawn.inch or took_s == pytest.approx(length_mm / feed_mm_s, rel=0.006)

    # Behind the cut the control does what it did: places, feed, feed mode, speed and path mode.
    assert now.motion[-2][:4] == was.motion[-2][:4]
    assert now.motion[-1] == was.motion[-1]
