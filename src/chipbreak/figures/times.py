"""How long each vibrated cut took as it was written, and how long it takes now."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from chipbreak.figures.style import BLUE, GREY, names_beside
from chipbreak.report.model import ExplainedCut

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 40
_BAR = 0.38


def cut_times(figure: Figure, cuts: Sequence[ExplainedCut]) -> None:
    """A pair of bars for each cut whose time was known before; of many the longest ones."""
    known = [cut for cut in cuts if cut.programmed_s is not None]
    longest = sorted(sorted(known, key=lambda cut: -cut.duration_s)[:_MOST], key=lambda cut: cut.first_line)
    axes = figure.add_subplot()
    places = np.arange(len(longest))
    before_s = [cut.programmed_s or 0.0 for cut in longest]
    after_s = [cut.duration_s for cut in longest]
    axes.barh(
        places - _BAR / 2, before_s, _BAR, color="white", edgecolor=GREY, hatch="///", label="as written"
    )
    axes.barh(places + _BAR / 2, after_s, _BAR, color=BLUE, label="with vibration")
    axes.set_yticks(places, [f"line {cut.first_line}" for cut in longest])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_title("Time of the cuts" if len(longest) == len(known) else f"Time of the {_MOST} longest cuts")
    axes.set_xlabel("time [s]")
    names_beside(axes)


def height_inch(cuts: Sequence[ExplainedCut]) -> float:
    """How high the diagram must be to be read."""
    return 1.4 + 0.32 * min(_MOST, max(1, len(cuts)))
