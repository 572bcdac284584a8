"""Figures inside a page."""

from __future__ import annotations

import re
from html import escape

from chipbreak.figures.of_run import Drawn

_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_IDS = re.compile(r'(\bid="|url\(#|xlink:href="#|href="#)([\w.-]+)')


def inline(drawn: Drawn, part: str) -> str:
    """A figure as a part of a page; ``part`` keeps its names apart from those of the others."""
    svg = _HEAD.sub("", drawn.file("svg").decode("utf-8"))
    svg = _IDS.sub(lambda match: f"{match[1]}{part}-{match[2]}", svg)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    label = escape(drawn.title, quote=True)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{label}" class="{drawn.name}" ', 1)
