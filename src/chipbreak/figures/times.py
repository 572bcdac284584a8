"""How long each vibrated cut took as it was written, and how long it takes now."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from chipbreak.figures.style import BLUE, GREY
from chipbreak.report.model import ExplainedCut

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 40
_BAR = 0.38


def cut_times(figure: Figure, cuts: Sequence[ExplainedCut]) -> None:
    """A pair of bars for each cut whose time was known before; of many the longest ones."""
    known = [cut for cut in cuts if cut.programmed_s is not None]
    kept = sorted(range(len(known)), key=lambda at: -known[at].duration_s)[:_MOST]
    longest = [known[at] for at in sorted(kept)]
    names = cut_names(known)
    axes = figure.add_subplot()
    places = np.arange(len(longest))
    before_s = [cut.programmed_s or 0.0 for cut in longest]
    after_s = [cut.duration_s for cut in longest]
    before = axes.barh(places - _BAR / 2, before_s, _BAR, color="white", edgecolor=GREY, hatch="///")
    after = axes.barh(places + _BAR / 2, after_s, _BAR, color=BLUE)
    axes.bar_label(before, _said(before_s, "as written"), padding=3, fontsize=8, color=GREY)
    axes.bar_label(after, _said(after_s, "with vibration"), padding=3, fontsize=8, color=BLUE)
    axes.set_xlim(0.0, 1.22 * max(1e-6, *before_s, *after_s))
    axes.set_yticks(places, [names[at] for at in sorted(kept)])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set_title("Time of the cuts" if len(longest) == len(known) else f"Time of the {_MOST} longest cuts")
    axes.set_xlabel("time [s]")


def _said(times_s: Sequence[float], what: str) -> list[str]:
    """The time at the end of each bar; at the first one what it is."""
    return [f"{time_s:z.1f} s{' ' + what if not at else ''}" for at, time_s in enumerate(times_s)]


def cut_names(cuts: Sequence[ExplainedCut]) -> list[str]:
    """``line 20``, and of several cuts that one line makes ``line 20, pass 2``."""
    count = Counter(cut.first_line for cut in cuts)
    seen: Counter[int] = Counter()
    names = []
    for cut in cuts:
        seen[cut.first_line] += 1
        which = f", pass {seen[cut.first_line]}" if count[cut.first_line] > 1 else ""
        names.append(f"line {cut.first_line}{which}")
    return names


def height_inch(cuts: Sequence[ExplainedCut]) -> float:
    """How high the diagram must be to be read."""
    return 1.4 + 0.32 * min(_MOST, max(1, len(cuts)))
