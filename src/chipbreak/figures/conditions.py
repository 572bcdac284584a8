"""Spindle speed and vibrations per revolution for a cut: what the control commands, and what the axis can."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from chipbreak.advise.of_cut import Advice
from chipbreak.figures.style import BLUE, GREEN, GREY, ORANGE, picture
from chipbreak.kinematics.floats import Floats
from chipbreak.settings.sections import Settings
from chipbreak.units import S_PER_MIN
from chipbreak.vibration.plan import command_group

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE_INCH = (7.2, 4.6)
_CELLS = 240
_FREQUENCIES = 9
_LOWEST, _HIGHEST = 0.15, 4.5


def figure_of_advice(advice: Advice, settings: Settings, kind: str) -> bytes:
    """The file of the figure.  Errors: FIG001 without matplotlib."""

    def draw(figure: Figure) -> None:
        _draw(figure, advice, settings)

    return picture(draw, kind, _SIZE_INCH)


def _draw(figure: Figure, advice: Advice, settings: Settings) -> None:
    axes = figure.add_subplot()
    cut = advice.cut
    speeds = [row.speed_rpm for row in advice.rows]
    tolerance = settings.spindle.speed_tolerance
    low_rpm = min(*speeds, cut.speed_rpm * (1.0 - tolerance)) * 0.9
    high_rpm = max(*speeds, cut.speed_rpm * (1.0 + tolerance)) * 1.1
    _region(axes, advice, settings, (low_rpm, high_rpm))
    _hyperbolas(axes, settings, (low_rpm, high_rpm))
    axes.axvspan(
        cut.speed_rpm * (1.0 - tolerance),
        cut.speed_rpm * (1.0 + tolerance),
        fill=False,
        ec=GREY,
        ls=":",
        label="within the tolerance of S",
    )
    axes.plot(
        speeds,
        [row.per_rev for row in advice.rows],
        "D",
        color=ORANGE,
        ms=6,
        ls="",
        label="rows of the table",
    )
    for number, row in enumerate(advice.rows, 1):
        axes.annotate(f"{number}", (row.speed_rpm, row.per_rev), xytext=(5, 4), textcoords="offset points")
    axes.set_yscale("log")
    axes.set_yticks([0.2, 0.25, 0.33, 0.5, 1.0, 1.5, 2.5, 3.5], minor=False)
    axes.set_yticklabels(["0.2", "0.25", "0.33", "0.5", "1", "1.5", "2.5", "3.5"])
    axes.minorticks_off()
    axes.set_xlim(low_rpm, high_rpm)
    axes.set_ylim(_LOWEST, _HIGHEST)
    axes.set_title(f"F{cut.feed_mm_rev:g} mm/rev on {advice.profile}")
    axes.set_xlabel("S, spindle speed [rpm]")
    axes.set_ylabel("N, vibrations per revolution")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2)


def _region(axes: Axes, advice: Advice, settings: Settings, span_rpm: tuple[float, float]) -> None:
    """Where the least stroke that breaks, with the best forward share, stays within the acceleration."""
    shares = [row for row in advice.rows if row.acceleration_share]
    if not shares:
        return
    limit = shares[0].acceleration_mm_s2 / (shares[0].acceleration_share or 1.0)
    usable = limit * (1.0 - settings.vibration.reserve)
    speeds = np.linspace(*span_rpm, _CELLS)
    counts = np.geomspace(_LOWEST, _HIGHEST, _CELLS)
    need = _need(counts[:, np.newaxis], speeds[np.newaxis, :], advice, settings.vibration.margin)
    axes.contourf(speeds, counts, need, levels=[0.0, usable], colors=[GREEN], alpha=0.18)
    axes.fill_between([], [], color=GREEN, alpha=0.18, label=f"up to {usable / 1000.0:.2g} m/s2")


def _need(counts: Floats, speeds_rpm: Floats, advice: Advice, margin: float) -> Floats:
    """The acceleration of the strokes at N and S with the better of two forward shares, (n, m)."""
    cut = advice.cut
    share = counts / cut.edges
    delta = np.clip(share - np.floor(share), 1e-3, 1.0 - 1e-3)
    advance_mm = cut.feed_mm_rev / counts
    period_s = S_PER_MIN / (counts * speeds_rpm)
    found = []
    for alpha in (np.full_like(delta, 0.5), 1.0 - delta):
        drop = np.minimum(delta / (1.0 - alpha), (1.0 - delta) / alpha)
        stroke_mm = margin * cut.feed_mm_rev / cut.edges / drop
        forward = 4.0 * (stroke_mm + alpha * advance_mm) / (alpha * period_s) ** 2
        back = 4.0 * (stroke_mm - (1.0 - alpha) * advance_mm) / ((1.0 - alpha) * period_s) ** 2
        found.append(np.maximum(forward, back))
    least: Floats = np.minimum(*found)
    return least


def _hyperbolas(axes: Axes, settings: Settings, span_rpm: tuple[float, float]) -> None:
    """N = 60 f / S of frequencies that the control can command, some of them where they are many."""
    low_hz = _LOWEST * span_rpm[0] / S_PER_MIN
    periods = command_group(settings).between(low_hz, _HIGHEST * span_rpm[1] / S_PER_MIN)
    speeds = np.linspace(*span_rpm, _CELLS)
    chosen = np.unique(np.geomspace(1, max(1, len(periods)), _FREQUENCIES).round().astype(int)) - 1
    for index, place in enumerate(chosen.tolist()):
        frequency_hz = periods[place].frequency_hz
        counts = S_PER_MIN * frequency_hz / speeds
        label = "" if index else "frequencies of the control (some of them)"
        axes.plot(speeds, counts, color=BLUE, lw=0.8, label=label)
        if _LOWEST < counts[-1] < _HIGHEST:
            axes.annotate(
                f"{frequency_hz:.3g} Hz",
                (span_rpm[1], counts[-1]),
                xytext=(4, 0),
                textcoords="offset points",
                va="center",
                fontsize=8,
                annotation_clip=False,
            )
