"""One look for every figure, and how one becomes a file.

The colours are those of Okabe and Ito, which people tell apart whatever kind of colour vision they have; what
a colour says is said by a shape, a dash or a word as well, so that a print in grey says it too.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from chipbreak.text.diagnostics import RefusalError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLUE: Final = "#0072b2"
ORANGE: Final = "#d55e00"
GREEN: Final = "#009e73"
SKY: Final = "#56b4e9"
YELLOW: Final = "#e69f00"
GREY: Final = "#5f6368"
LIGHT: Final = "#d8dce0"

KINDS: Final = ("svg", "png", "pdf")
_NOT_THERE = "FIG001"
_DOTS_PER_INCH = 144
_LOOK: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": "#202124",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": LIGHT,
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.constrained_layout.use": True,
    # The same figure gives the same bytes.
    "svg.hashsalt": "chipbreak",
    "svg.fonttype": "none",
}

# Yellow is seen as a line, but not read as a word.
_READABLE: Final = {YELLOW: "#7a5200"}
_NAME_HEIGHT = 0.075  # of the diagram, for a name beside it

Draw = Callable[["Figure"], None]


def require_matplotlib() -> None:
    """Errors: FIG001 without matplotlib."""
    try:
        import matplotlib  # noqa: F401, PLC0415 (an optional extra)
    except ImportError:
        way_out = "pip install 'chipbreak[plot]'"
        raise RefusalError(_NOT_THERE, "figures need matplotlib, which is not installed", way_out) from None


def picture(draw: Draw, kind: str, size_inch: tuple[float, float]) -> bytes:
    """The file of a figure: ``kind`` is one of :data:`KINDS`.  Errors: FIG001 without matplotlib."""
    require_matplotlib()
    from matplotlib import rc_context  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    with rc_context(_LOOK):
        figure = Figure(figsize=size_inch)
        draw(figure)
        stream = io.BytesIO()
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
        figure.savefig(stream, format=kind, dpi=_DOTS_PER_INCH, metadata=undated[kind])
    return stream.getvalue()


def kind_of(path: str | Path) -> str | None:
    """The kind of file that a name asks for, None where it is no kind of figure."""
    suffix = Path(path).suffix.lower().removeprefix(".")
    return suffix if suffix in KINDS else None


def name_at_edge(axes: Axes, names: Sequence[tuple[float, str, str]], *, at: float) -> None:
    """Name lines where they leave the diagram at ``at`` on the right: height, name and colour of each.

    Names that would run into each other move apart.
    """
    low, high = axes.get_ylim()
    line_height = _NAME_HEIGHT * (high - low)
    ordered = sorted(names)
    places = apart([height for height, _, _ in ordered], line_height)
    for (height, name, colour), place in zip(ordered, places, strict=True):
        axes.annotate(
            name,
            (at, height),
            xytext=(1.03, (place - low) / (high - low)),
            textcoords="axes fraction",
            va="center",
            color=_READABLE.get(colour, colour),
            fontsize=8.5,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.6, "shrinkA": 0.0, "shrinkB": 0.0},
        )


def apart(places: Sequence[float], gap: float) -> list[float]:
    """Places in their order, moved as little as needed to be ``gap`` from each other."""
    groups: list[tuple[float, int]] = []  # the middle of each run of names, and how many it has
    for place in places:
        middle = place
        count = 1
        while groups and middle - groups[-1][0] < gap * (count + groups[-1][1]) / 2.0:
            before, some = groups.pop()
            middle = (middle * count + before * some) / (count + some)
            count += some
        groups.append((middle, count))
    return [middle + (index - (count - 1) / 2.0) * gap for middle, count in groups for index in range(count)]


def point_out(axes: Axes, text: str, place: tuple[float, float], label: tuple[float, float]) -> None:
    """A word with an arrow to what it names; ``label`` in points from there."""
    axes.annotate(
        text,
        place,
        xytext=label,
        textcoords="offset points",
        fontsize=8.5,
        ha="center",
        va="center",
        bbox={"boxstyle": "round,pad=0.2", "fc": "white", "ec": "none", "alpha": 0.85},
        arrowprops={"arrowstyle": "->", "color": "#202124", "lw": 0.9},
    )
