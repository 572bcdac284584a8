"""Cycles on machines whose axes run the other way: a program and its mirror image stay mirror images."""

from __future__ import annotations

import re

import pytest

import chipbreak
from twin import Mapping, twin

HEAD = "G18 G21 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
RISING = "N10 G0 X16.\nG1 Z-15.\nG2 X30. Z-22. R7.\nN20 G1 X52.\n"
FACING = "N10 G0 Z-22.\nG1 X30.\nG3 X16. Z-15. R7.\nN20 G1 Z2.\n"
POCKET = "N10 G0 X16.\nG1 Z-15.\nX30.\nX26. Z-25.\nG2 X30. Z-30. R6.\nN20 G1 X52.\n"
CYCLES = {
    "along Z": f"G71 P10 Q20 U0.4 W0.1 D2. F0.3\n{RISING}G70 P10 Q20\n",
    "along Z, a pass along the contour": f"G71 P10 Q20 U0.4 W0.1 I0.3 K0.2 D2. F0.3\n{RISING}",
    "along X": f"G72 P10 Q20 U0.4 W0.1 D2. F0.3\n{FACING}",
    "pattern in two blocks": f"G73 U4. W1. R3\nG73 P10 Q20 U0.4 W0.1 F0.3\n{POCKET}",
    "pattern in one block": f"G73 P10 Q20 U0.4 W0.1 I4. K1. D3 F0.3\n{POCKET}",
    "single passes along Z": "G90 X48. Z-20. F0.2\nX44.\nU-16. W-12.\n",
    "single passes along X": "G94 X20. Z-2. F0.2\nZ-4.\nU-20. W-8.\n",
}
_COMMENT = re.compile(r"\([^()]*\)")


def unrolled(program: str, *options: str) -> str:
    settings = chipbreak.load("fanuc-lathe", ['cycles.unroll="always"', *options])
    result = chipbreak.rewrite(program.encode(), settings)
    assert result.changed and not result.diagnostics
    return _COMMENT.sub("", result.data.decode())


@pytest.mark.parametrize("signs", [(1, 1, -1), (-1, 1, 1), (-1, 1, -1)])
@pytest.mark.parametrize("name", CYCLES)
def test_the_mirror_image_is_cut_as_the_mirror_image(name: str, signs: tuple[int, int, int]) -> None:
    program = f"{HEAD}{CYCLES[name]}G0 X100. Z100.\nM30\n"
    mapping = Mapping("XYZ", signs)
    mirrored = twin(program, mapping, "ZX")
    assert mirrored != program
    assert unrolled(mirrored, *mapping.sets) == twin(unrolled(program), mapping, "ZX")
