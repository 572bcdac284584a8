"""One look for every figure, and how one becomes a file.

The colours are those of Okabe and Ito, which people tell apart whatever kind of colour vision they have; what
a colour says is said by a shape, a dash or a word as well, so that a print in grey says it too.
"""

from __future__ import annotations

import io
from collections.abc import Callable
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


def names_beside(axes: Axes, **options: Any) -> None:
    """The legend to the right of a diagram, where it hides nothing."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), **options)
