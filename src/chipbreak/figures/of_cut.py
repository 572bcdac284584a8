"""The figures of one vibrated cut."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chipbreak.figures.cut_data import DrawnCut, turn_samples
from chipbreak.figures.style import BLUE, GREEN, GREY, ORANGE, SKY, YELLOW, name_at_edge, point_out

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

_TURNS = 4
_DASHES = ("-", "--", "-.", ":")
_COLOURS = (BLUE, ORANGE, GREEN, YELLOW)
_ORDINALS = ("1st", "2nd", "3rd", "4th")
_RAMP_TURNS = 8


def chip_pattern(figure: Figure, cut: DrawnCut) -> None:
    """The path of the edge in consecutive revolutions over the angle of the spindle (the patent's figure 4).

    Where a revolution reaches the one before, the edge is in air and the chip has ended.
    """
    axes = figure.add_subplot()
    share = turn_samples()
    begin_s = cut.middle_s()
    base_mm = float(cut.at(np.array([begin_s]))[0])
    before_mm = cut.at(begin_s + (share - 1.0) * cut.turn_s) - base_mm
    axes.plot(360.0 * share, before_mm, color=GREY, lw=0.8)
    names = [(float(before_mm[-1]), "the revolution before", GREY)]
    ends: list[tuple[float, float]] = []
    for turn in range(_TURNS):
        time_s = begin_s + (turn + share) * cut.turn_s
        place_mm = cut.at(time_s) - base_mm
        axes.plot(360.0 * share, place_mm, _DASHES[turn], color=_COLOURS[turn])
        names.append((float(place_mm[-1]), f"{_ORDINALS[turn]} revolution", _COLOURS[turn]))
        air = cut.thickness_mm(time_s) <= 1e-9 * cut.feed_mm
        wall_mm = np.where(air, cut.at(time_s - cut.pass_s) - base_mm, np.nan)
        axes.fill_between(360.0 * share, place_mm, wall_mm, where=air, color=SKY, alpha=0.35, lw=0)
        axes.plot(360.0 * share, np.where(air, place_mm, np.nan), color="black", lw=3.2, alpha=0.55)
        ends += [(360.0 * float(share[at]), float(place_mm[at])) for at in _middles(air)]
    axes.set_title("Path of the edge, revolution after revolution")
    axes.set_xlabel("angle of the spindle [deg]")
    axes.set_ylabel("way along the cut [mm]")
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(range(0, 361, 60))
    name_at_edge(axes, names, at=360.0)
    inside = [place for place in ends if 60.0 < place[0] < 300.0]
    if inside:
        point_out(axes, "edge in air: here a chip ends", min(inside, key=lambda place: place[1]), (0, -24))
        axes.margins(y=0.12)


def _middles(found: NDArray[np.bool_]) -> list[int]:
    """The middle of each stretch that is True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], found.astype(int), [0]))))
    return [int(first + last - 1) // 2 for first, last in edges.reshape(-1, 2)]


def chip_thickness(figure: Figure, cut: DrawnCut) -> None:
    """Thickness of the uncut chip over some revolutions: where it touches 0, a chip has ended."""
    axes = figure.add_subplot()
    share = np.linspace(0.0, _TURNS, _TURNS * 360 + 1)
    height = np.maximum(cut.thickness_mm(cut.middle_s() + share * cut.turn_s), 0.0) / cut.feed_mm
    axes.fill_between(share, height, color=SKY, alpha=0.45, lw=0)
    axes.plot(share, height, color=BLUE)
    axes.axhline(1.0, color=GREY, ls="--", lw=1.2)
    broken = height <= 1e-6
    axes.plot(share[broken], height[broken], "|", color=ORANGE, ms=9)
    axes.set_title("Thickness of the chip")
    axes.set_xlabel("revolutions of the spindle")
    axes.set_ylabel("thickness\n[x feed per revolution]")
    axes.set_xlim(0.0, _TURNS)
    top = 1.12 * float(height.max(initial=1.0))
    axes.set_ylim(0.0, top)
    names = [
        (float(height[-1]), "with vibration", BLUE),
        (1.0, "without vibration:\none chip, as long as the cut", GREY),
    ]
    name_at_edge(axes, names, at=_TURNS)
    inside = [at for at in _middles(broken) if 0.5 < share[at] < _TURNS - 0.5]
    if inside:
        point_out(axes, "air: a chip has ended", (float(share[inside[0]]), 0.03 * top), (0, 34))


def ramp(figure: Figure, cut: DrawnCut) -> None:
    """How the stroke grows at the begin and shrinks at the end: the swing about the steady feed."""
    begin, end = figure.subplots(1, 2, sharey=True)
    end_s = float(cut.motion.time_s[-1])
    first_s = min(_RAMP_TURNS * cut.turn_s, end_s / 2.0)
    _swing(begin, cut, (0.0, first_s), "The stroke grows")
    _swing(end, cut, (end_s - first_s, end_s), "The stroke shrinks, then a plain end")
    begin.set_ylabel("swing about the even feed [mm]")


def _swing(axes: Axes, cut: DrawnCut, part_s: tuple[float, float], title: str) -> None:
    """The swing about the even feed from one time to another, in revolutions from the first."""
    time_s = cut.motion.time_s
    inside = (time_s >= part_s[0] - cut.turn_s) & (time_s <= part_s[1] + cut.turn_s)
    even_mm = cut.told.feed_mm_rev / cut.turn_s * time_s[inside]
    swing_mm = cut.motion.distance_mm[inside] - even_mm
    rest_mm = swing_mm[0] if part_s[0] == 0.0 else swing_mm[-1]  # where the tool does not swing
    axes.plot((time_s[inside] - part_s[0]) / cut.turn_s, swing_mm - rest_mm, color=BLUE, lw=1.1)
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set_title(title)
    axes.set_xlabel("revolutions of the spindle")
    axes.set_xlim(0.0, (part_s[1] - part_s[0]) / cut.turn_s)
