"""Arcs of which the digits of the output leave none: what they would stand for stays, and says so."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.cycles.contour import Frame, Point
from chipbreak.cycles.roughing import Motion
from chipbreak.cycles.writing import BlockWriter, block_of_motion
from chipbreak.model.from_source import interpret_source
from chipbreak.settings import load
from chipbreak.text.diagnostics import RefusalError
from chipbreak.text.source import read

HEAD = "G20\nG97 S900 M3\nG95\n"
SUBROUTINE = (
    "o800 sub\nG0 X2.3433 Z0.0394\nG1 Z-0.1575\nG2 R0.1181 X2.3528 Z-0.2756\nG1 Z-0.4331\nX2.4409\n"
    "o800 endsub\n"
)
CYCLE = "G0 X2.4 Z0.1\nG71 Q800 X2.4 Z0.1 D0.0079 I0.0197 R0.0197 F0.0079\n"
TAIL = "G0 X4.\nM30\n"


def _said(program: str, decimals: int) -> tuple[bool, str]:
    """Whether anything was written out, and what was said of what was not."""
    settings = load(
        "linuxcnc-lathe", [f"output.decimals={decimals}", "cycles.unroll=always", "vibration.refused=leave"]
    )
    result = chipbreak.rewrite(program.encode(), settings, allow_unbroken=True)
    said = [one for one in result.diagnostics if "from its centre" in one.message]
    return b"UNROLLED" in result.data, "".join(f"{one.code} {one.message} {one.help}" for one in said)


@pytest.mark.parametrize(("decimals", "stays"), [(1, True), (2, True), (3, False), (4, False)])
def test_a_cycle_with_such_arcs_stays(decimals: int, stays: bool) -> None:
    is_written, said = _said(SUBROUTINE + HEAD + CYCLE + TAIL, decimals)
    assert is_written is not stays
    assert bool(said) is stays
    if stays:
        assert said.startswith(f"CYC007 with {decimals + 1} decimals an arc would start ")
        assert said.endswith("raise output.decimals")


@pytest.mark.parametrize(
    ("start", "end", "centre", "becomes_whole"),
    [
        (
            (-4.1694116, 19.0167487),
            (-4.1687211, 19.0167507),
            (-4.1692071, 19.0667483),
            True,
        ),
        (
            (-9.9167391, 18.1777528),
            (-9.9174439, 18.1777473),
            (-9.9167050, 18.1277528),
            True,
        ),
        ((-4.1695, 19.0168), (-4.1665, 19.0169), (-4.1692, 19.0668), False),
        ((-4.0, 19.0), (-4.0, 19.1), (-4.0, 19.05), False),
    ],
)
def test_a_short_arc_never_becomes_a_whole_circle(
    start: tuple[float, float], end: tuple[float, float], centre: tuple[float, float], becomes_whole: bool
) -> None:
    """The digits put its end straight behind its start, as seen from a centre that has moved too."""
    settings = load("fanuc-lathe")
    program = f"G97 S800 M3\nG0 X{2.0 * start[1]:.3f} Z{start[0]:.3f}\nM30\n"
    writer = BlockWriter(interpret_source(read(program.encode()), settings).before(2), settings)
    motion = Motion(True, Point(*end), Point(*centre), 1)
    if becomes_whole:
        with pytest.raises(RefusalError, match="with 3 decimals an arc would end behind its start"):
            block_of_motion(writer, Frame("Z", 1, 1), start, motion)
    else:
        assert block_of_motion(writer, Frame("Z", 1, 1), start, motion).startswith("G")
