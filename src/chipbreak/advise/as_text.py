"""Advice as a table for people, and as plain values for JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from chipbreak.advise.of_cut import Advice, AdvisedRow

_HEAD = (
    "",
    "S rpm",
    "N",
    "f Hz",
    "stroke mm",
    "margin",
    "chip rev",
    "chip mm",
    "peak",
    "time s",
    "needs m/s2",
)


def advice_lines(advice: Advice) -> Iterator[str]:
    """The cut, the rows with what they do, and how a program asks for each."""
    cut = advice.cut
    way = "facing" if cut.axis == "X" else "turning"
    edges = f", {cut.edges} edges" if cut.edges > 1 else ""
    yield (
        f"{way} {cut.length_mm:g} mm at diameter {cut.diameter_mm:g}, F{cut.feed_mm_rev:g} mm/rev,"
        f" S{cut.speed_rpm:g}{edges}; profile {advice.profile}, planner model {advice.control}"
    )
    if advice.is_unproven:
        yield "unproven: on a control that follows the blocks exactly (planner.model is not set)"
    table = [_HEAD, *(_cells(number, row) for number, row in enumerate(advice.rows, 1))]
    widths = [max(len(row[column]) for row in table) for column in range(len(_HEAD))]
    for cells in table:
        yield "  ".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))
    yield "chip: the longest uncut one of an edge; peak: chip thickness in feeds; in a program:"
    for number, one in enumerate(advice.rows, 1):
        yield f"{number:>3}  {one.directive}"


def _cells(number: int, row: AdvisedRow) -> tuple[str, ...]:
    share = "" if row.acceleration_share is None else f" ({row.acceleration_share:.0%})"
    return (
        f"{number}",
        f"{row.speed_rpm:g}",
        f"{row.per_rev:z.3f}",
        f"{row.frequency_hz:z.2f}",
        f"{row.stroke_mm:z.3f}",
        f"{row.margin:z.2f}",
        f"{row.longest_chip_rev:z.2f}",
        "" if row.longest_chip_mm is None else f"{row.longest_chip_mm:z.0f}",
        f"{row.peak_thickness:z.2f}",
        f"{row.duration_s:z.1f}",
        f"{row.acceleration_mm_s2 / 1000.0:z.2f}{share}",
    )


def advice_values(advice: Advice) -> Mapping[str, Any]:
    """The same with all digits: lengths in mm, times in s."""
    return {
        "schema": 1,
        "profile": advice.profile,
        "control": advice.control,
        "unproven": advice.is_unproven,
        "cut": advice.cut._asdict(),
        "rows": [row._asdict() for row in advice.rows],
    }
