"""Arcs of which the digits of the output leave none: what they would stand for stays, and says so."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.settings import load

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
