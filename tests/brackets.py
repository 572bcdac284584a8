"""The brackets of an output, for readers that hold it against the original."""

from __future__ import annotations

from chipbreak.editing.restore import regions
from chipbreak.text.source import read


def marked(output: bytes) -> bytes:
    """The original, with the first and the last line of every bracket that the output has."""
    source = read(output)
    parts = []
    line = 0
    for region in regions(source):
        kept = source.data[source.starts[line] : source.starts[region.first]]
        # A number before BEGIN stands in the original block too.
        begin = source.raw(region.first)
        parts += [kept, begin[begin.index(b"(") :], region.original, source.raw(region.last - 1)]
        line = region.last
    return b"".join([*parts, source.data[source.starts[line] :]])
