"""Spindle speed and vibrations per revolution: what the control can command, and what breaks chips."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chipbreak.figures.style import BLUE, GREEN, GREY, ORANGE, name_at_edge, point_out
from chipbreak.kinematics.speed_solver import CommandGroup, never_breaks
from chipbreak.kinematics.waveform import least_stroke_mm
from chipbreak.text.named_tuple import NamedTuple
from chipbreak.units import S_PER_MIN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SPAN = 1.8  # of the larger speed, to which the diagram reaches
_APART = 0.35  # of the logarithms of two frequencies that are both drawn
_SAME = 0.02
_HIGHEST_PER_REV = 4.0
_COUNTS = 1601
_BAND_TEXT = "#00563f"


class SpeedPoint(NamedTuple):
    """A spindle speed [rpm] and the vibrations per revolution there."""

    speed_rpm: float
    per_rev: float


class SpeedChart(NamedTuple):
    """What the diagram shows: the frequencies of the control, the stroke, where the cut was and where it is.

    ``stroke_ratio`` is stroke / feed per revolution; ``programmed`` None where it is not known.
    """

    group: CommandGroup
    waveform: str
    alpha_share: float
    edges: int
    stroke_ratio: float
    chosen: SpeedPoint
    programmed: SpeedPoint | None = None


def speed_chart(figure: Figure, chart: SpeedChart) -> None:
    """The hyperbolas N = 60 f / S of the control's frequencies (the patent's figure 6).

    The points that a control can command lie on the curves; the bands are where chips break with this stroke.
    """
    axes = figure.add_subplot()
    points = [point for point in (chart.chosen, chart.programmed) if point]
    top_rpm = _SPAN * max(point.speed_rpm for point in points)
    top_count = max(_HIGHEST_PER_REV, *(1.25 * point.per_rev for point in points))
    axes.set_xlim(0.0, top_rpm)
    axes.set_ylim(0.0, top_count)
    _bands(axes, chart, top_rpm, top_count)
    frequency_hz = chart.chosen.per_rev * chart.chosen.speed_rpm / S_PER_MIN
    names: list[tuple[float, str, str]] = []
    for curve_hz in _curves_hz(chart.group, frequency_hz):
        is_ours = abs(curve_hz / frequency_hz - 1.0) < _SAME
        _curve(axes, curve_hz, top_rpm, is_ours=is_ours)
        count = S_PER_MIN * curve_hz / top_rpm
        if count < top_count:
            names.append((count, f"{curve_hz:.4g} Hz", BLUE if is_ours else GREY))
    name_at_edge(axes, names, at=top_rpm)
    if chart.programmed and chart.programmed != chart.chosen:
        axes.plot(*chart.programmed, "o", mfc="white", mec=ORANGE, mew=1.8, ms=8)
        axes.annotate("", chart.chosen, chart.programmed, arrowprops={"arrowstyle": "->", "color": ORANGE})
        is_right = chart.programmed.speed_rpm >= chart.chosen.speed_rpm
        point_out(axes, "as programmed", chart.programmed, (52 if is_right else -52, 26))
        point_out(axes, "as it runs", chart.chosen, (-46 if is_right else 46, -26))
    else:
        point_out(axes, "as it runs", chart.chosen, (46, 26))
    axes.plot(*chart.chosen, "D", color=ORANGE, ms=7)
    axes.set_title("Spindle speed and vibrations per revolution")
    axes.set_xlabel("S, spindle speed [rpm]")
    axes.set_ylabel("N, vibrations per revolution")


def _bands(axes: Axes, chart: SpeedChart, top_rpm: float, top_count: float) -> None:
    """The N at which this stroke breaks chips."""
    counts = np.linspace(1e-3, top_count, _COUNTS)
    breaks = np.array([_breaks(chart, float(count)) for count in counts])
    edges = np.flatnonzero(np.diff(np.concatenate(([0], breaks.astype(int), [0]))))
    bands = [(float(counts[first]), float(counts[last - 1])) for first, last in edges.reshape(-1, 2)]
    for low, high in bands:
        axes.axhspan(low, high, color=GREEN, alpha=0.16, lw=0)
    if bands:
        middle = sum(bands[-1]) / 2.0
        said = "in the bands chips break with this stroke"
        axes.text(0.985 * top_rpm, middle, said, ha="right", va="center", fontsize=8.5, color=_BAND_TEXT)


def _breaks(chart: SpeedChart, per_rev: float) -> bool:
    if never_breaks(per_rev, chart.edges):
        return False
    least = least_stroke_mm(
        chart.waveform, per_rev, 1.0, alpha_share=chart.alpha_share, edges=chart.edges, margin=1.0
    )
    return least <= chart.stroke_ratio


def _curves_hz(group: CommandGroup, frequency_hz: float) -> list[float]:
    """The frequency of the cut and others of the control around it, far enough apart to be told apart."""
    ours_hz = group.nearest(frequency_hz).frequency_hz
    chosen = [ours_hz]
    for factor in (0.25, 0.4, 0.6, 1.6, 2.5, 4.0):
        other_hz = group.nearest(ours_hz * factor).frequency_hz
        if all(abs(np.log(other_hz / known_hz)) > _APART for known_hz in chosen):
            chosen.append(other_hz)
    return sorted(chosen)


def _curve(axes: Axes, frequency_hz: float, top_rpm: float, *, is_ours: bool) -> None:
    """One frequency."""
    speeds_rpm = np.linspace(top_rpm / 400.0, top_rpm, 800)
    (line,) = axes.plot(speeds_rpm, S_PER_MIN * frequency_hz / speeds_rpm, "--", color=GREY, lw=0.9)
    if is_ours:
        line.set(color=BLUE, linewidth=2.0, linestyle="-")
