"""Loops written out: a filtered program as the control runs it, block by block.

Only loops exactly as chipbreak prints them are known, and only inside its brackets.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from chipbreak.dialects.base import Loop
from chipbreak.editing.restore import Region
from chipbreak.text.source import Source, read


def unrolled(source: Source, found: Sequence[Region], loop: Loop | None) -> tuple[Source, list[Region]]:
    """The program with every loop in its changes written out, and where the changes are then."""
    if loop is None or not any(_may_hold(source, region, _sign(loop)) for region in found):
        return source, list(found)
    pattern = _pattern(loop, source.line_end)
    pieces: list[bytes] = []
    moved: list[Region] = []
    line = shift = 0
    for region in found:
        body = source.data[source.starts[region.body] : source.starts[region.last]]
        text = pattern.sub(lambda match: match["body"] * int(match["passes"]), body)
        pieces += [source.data[source.starts[line] : source.starts[region.body]], text]
        more = text.count(source.line_end) - body.count(source.line_end)
        first = region.first + shift
        start = region.body + shift
        last = region.last + shift + more
        moved.append(region._replace(first=first, body=start, last=last))
        line = region.last
        shift += more
    pieces.append(source.data[source.starts[line] :])
    return read(b"".join(pieces), source.name), moved


def _may_hold(source: Source, region: Region, sign: bytes) -> bool:
    return source.data.find(sign, int(source.starts[region.body]), int(source.starts[region.last])) >= 0


def _sign(loop: Loop) -> bytes:
    """Text without which there is no loop."""
    return max(re.split(r"\{\w+\}", loop.begin[-1]), key=len).encode("ascii")


def _pattern(loop: Loop, line_end: bytes) -> re.Pattern[bytes]:
    """A loop with its blocks; a number that stands twice is the same both times."""
    text = "".join(re.escape(line) + "\n" for line in loop.begin)
    text += "(?P<body>.*?)" + "".join(re.escape(line) + "\n" for line in loop.end)
    for name in ("passes", "label", "variable"):
        first, *others = text.split(re.escape("{" + name + "}"))
        if others:
            text = f"{first}(?P<{name}>[0-9]+)" + f"(?P={name})".join(others)
    ends = re.escape(line_end.decode("ascii"))
    # At the start of a line, which may be the first one of a change.
    return re.compile(("(?<![^\r\n])" + text.replace("\n", ends)).encode("ascii"), re.DOTALL)
