"""The figure of an inspected tool, as SVG: the worst place of its edges as they are, and all edges at once.

On the left the edge before (dashes and dots), the limit line (dashes) and the edge after (solid) around the
point that lies furthest inward, to scale in both directions.  On the right the distance inward along the
normal of every tooth over the height.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final
from xml.sax.saxutils import escape

import numpy as np

from chipbreak.kinematics.floats import Floats

_WIDTH = 920
_HEIGHT = 480
_COLOURS: Final = ("#1f5fa8", "#2f8f4e", "#8a5bb5", "#b5761b", "#3a9fa8", "#a83f7a", "#6b6b6b", "#7a8f2f")
_RED: Final = "#c0272d"
# Points of a curve beyond this many are not drawn: nobody sees them.
_MOST_POINTS = 4000


@dataclass(frozen=True, eq=False)
class EdgeCurves:
    """One tooth: points (height, radius) before, after and of the limit line, all (n, 2) [mm].

    ``inward_mm`` belongs to the points after, shape (n,); -inf where there was nothing to compare with.
    """

    tooth: int
    before: Floats
    after: Floats
    limit: Floats
    inward_mm: Floats
    is_chipped: bool

    @property
    def worst(self) -> int:
        """Index of the point after that lies furthest inward."""
        return int(np.argmax(self.inward_mm))


@dataclass(frozen=True)
class _Panel:
    """A rectangle [px] that shows a range of x and y."""

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    def place(self, points: Floats) -> Floats:
        """Points (x, y) in px."""
        share_x = (points[:, 0] - self.x[0]) / (self.x[1] - self.x[0])
        share_y = (points[:, 1] - self.y[0]) / (self.y[1] - self.y[0])
        return np.column_stack(
            (self.left + share_x * self.width, self.top + self.height - share_y * self.height)
        )


def edge_figure(edges: Sequence[EdgeCurves], limit_mm: float, title: str) -> str:
    """An SVG page for the edges of one tool; ``limit_mm`` is W."""
    worst = max(edges, key=lambda edge: float(edge.inward_mm[edge.worst]))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}"'
        f' height="{_HEIGHT}" font-family="sans-serif" font-size="12" fill="#222">',
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#fff"/>',
        _text(_WIDTH / 2, 24, title, anchor="middle", size=15),
        *_detail(worst, limit_mm, _COLOURS[list(edges).index(worst) % len(_COLOURS)]),
        *_overview(edges, limit_mm),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _detail(edge: EdgeCurves, limit_mm: float, colour: str) -> Iterator[str]:
    """The worst place of one tooth, to scale, with some measured points on both sides of it."""
    height_mm, radius_mm = (float(v) for v in edge.after[edge.worst])
    inward_mm = float(edge.inward_mm[edge.worst])
    away = np.hypot(edge.before[:, 0] - height_mm, edge.before[:, 1] - radius_mm)
    reach_mm = max(5.0 * limit_mm, 1.8 * abs(inward_mm), float(np.sort(away)[:6].max()))
    x = (radius_mm - reach_mm, radius_mm + reach_mm)
    y = (height_mm - reach_mm, height_mm + reach_mm)
    panel = _Panel(72, 62, 340, 340, x, y)
    yield _text(panel.left, 50, f"Tooth {edge.tooth}, its worst place", size=13)
    yield from _axes(panel, "radius [mm]", "height above the tip [mm]")
    yield from _curve(panel, edge.before[:, ::-1], "#444", "9 3 2 3", "before")
    yield from _curve(panel, edge.limit[:, ::-1], _RED, "5 4", "limit")
    yield from _curve(panel, edge.after[:, ::-1], colour, "", "after")
    ((px, py),) = panel.place(np.array([[radius_mm, height_mm]]))
    yield f'<circle cx="{px:.2f}" cy="{py:.2f}" r="5" fill="none" stroke="{_RED}" stroke-width="1.5"/>'
    samples = (
        ("before", "#444", "9 3 2 3"),
        ("limit line", _RED, "5 4"),
        ("after", colour, ""),
    )
    yield from _legend(panel.left, 456, samples, 118)


def _overview(edges: Sequence[EdgeCurves], limit_mm: float) -> Iterator[str]:
    """Distance inward over height, of all teeth."""
    heights = np.concatenate([edge.before[:, 0] for edge in edges])
    inward = np.concatenate([edge.inward_mm[np.isfinite(edge.inward_mm)] for edge in edges])
    low = min(-0.2 * limit_mm, float(inward.min()))
    high = max(1.4 * limit_mm, float(inward.max()))
    margin = 0.05 * (high - low)
    x = (low - margin, high + margin)
    y = (float(heights.min()), float(heights.max()))
    panel = _Panel(510, 62, 370, 340, x, y)
    yield _text(panel.left, 50, "All teeth", size=13)
    yield from _axes(panel, "distance inward along the normal [mm]", "height above the tip [mm]")
    limit = np.array([[limit_mm, y[0]], [limit_mm, y[1]]])
    yield from _curve(panel, limit, _RED, "5 4", "limit of all")
    for index, edge in enumerate(edges):
        seen = np.isfinite(edge.inward_mm)
        points = np.column_stack((edge.inward_mm[seen], edge.after[seen, 0]))
        yield from _curve(panel, points, _COLOURS[index % len(_COLOURS)], "", f"tooth {edge.tooth}")
    samples = [
        (f"tooth {edge.tooth}{' !' if edge.is_chipped else ''}", _COLOURS[i % len(_COLOURS)], "")
        for i, edge in enumerate(edges[: len(_COLOURS)])
    ]
    yield from _legend(panel.left, 456, samples, 92)


def _axes(panel: _Panel, x_title: str, y_title: str) -> Iterator[str]:
    right = panel.left + panel.width
    bottom = panel.top + panel.height
    yield (
        f'<rect x="{panel.left}" y="{panel.top}" width="{panel.width}" height="{panel.height}"'
        ' fill="#fcfcfc" stroke="#888"/>'
    )
    for value, text in _ticks(*panel.x):
        ((at, _),) = panel.place(np.array([[value, panel.y[0]]]))
        yield f'<path d="M{at:.2f} {panel.top}V{bottom}" stroke="#e4e4e4"/>'
        yield _text(at, bottom + 16, text, anchor="middle")
    for value, text in _ticks(*panel.y):
        ((_, at),) = panel.place(np.array([[panel.x[0], value]]))
        yield f'<path d="M{panel.left} {at:.2f}H{right}" stroke="#e4e4e4"/>'
        yield _text(panel.left - 6, at + 4, text, anchor="end")
    yield _text((panel.left + right) / 2, bottom + 34, x_title, anchor="middle")
    middle = (panel.top + bottom) / 2
    beside = panel.left - 52
    yield _text(beside, middle, y_title, anchor="middle", turn=True)


def _ticks(low: float, high: float) -> Iterator[tuple[float, str]]:
    """Round values between two ends, about five of them, and their texts."""
    rough = (high - low) / 5.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * factor for factor in (1.0, 2.0, 5.0, 10.0) if power * factor >= rough * 0.999)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    for index in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
        yield index * step, f"{index * step + 0.0:.{decimals}f}"


def _curve(panel: _Panel, points: Floats, colour: str, dashes: str, name: str) -> Iterator[str]:
    """A line of points (x, y) in the units of the panel, cut at its frame."""
    step = max(1, len(points) // _MOST_POINTS)
    placed = panel.place(points[::step])
    # Far outside the frame coordinates would only grow the file.
    far = max(_WIDTH, _HEIGHT) * 4.0
    coordinates = " ".join(f"{x:.2f},{y:.2f}" for x, y in np.clip(placed, -far, far))
    frame = f"{panel.left:g}-{panel.top:g}-{panel.width:g}"
    yield f'<svg x="{panel.left}" y="{panel.top}" width="{panel.width}" height="{panel.height}"'
    yield f' viewBox="{panel.left} {panel.top} {panel.width} {panel.height}" id="{escape(name)}-{frame}">'
    style = f' stroke-dasharray="{dashes}"' if dashes else ""
    yield f'<polyline points="{coordinates}" fill="none" stroke="{colour}" stroke-width="1.6"{style}/>'
    yield "</svg>"


def _legend(left: float, y: float, samples: Sequence[tuple[str, str, str]], width: float) -> Iterator[str]:
    per_row = 4
    for index, (text, colour, dashes) in enumerate(samples):
        x = left + width * (index % per_row)
        row_y = y + 16.0 * (index // per_row)
        style = f' stroke-dasharray="{dashes}"' if dashes else ""
        yield f'<path d="M{x} {row_y - 4}h28" stroke="{colour}" stroke-width="1.6"{style}/>'
        yield _text(x + 33, row_y, text)


def _text(x: float, y: float, text: str, *, anchor: str = "start", size: int = 12, turn: bool = False) -> str:
    turned = f' transform="rotate(-90 {x:.2f} {y:.2f})"' if turn else ""
    style = f'text-anchor="{anchor}" font-size="{size}"{turned}'
    return f'<text x="{x:.2f}" y="{y:.2f}" {style}>{escape(text)}</text>'
