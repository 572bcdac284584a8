"""What is changed last in a program whose end nobody says: the next one of the file begins behind it."""

from __future__ import annotations

import pytest

import chipbreak

HEAD = "O1\nG21 G40 G99\nT0101\nG97 S1200 M3\nG0 X52. Z2.\n"
CYCLES = "G71 U2. R0.5\nG71 P10 Q20 U0.4 F0.3\nN10 G0 X16. F0.1\nG1 Z-15.\nN20 X52.\nG70 P10 Q20\n"
LAST = {
    "a vibrated cut": "G1 Z-3. F0.1 N1.5\n",
    "a chain": "(VIB N1.5)\nG1 Z-3. F0.1\nX60.\n",
    "a finishing cycle": CYCLES,
    "a corner": "(VIB N1.5)\nG1 Z-10. F0.1 ,R2.\nX60.\n",
}


@pytest.mark.parametrize("behind", ["O1\nG0 X1. Z1.\nM30\n", "O2\nG97 S500 M3\nG0 X20. Z2.\nM30\n"])
@pytest.mark.parametrize("last", LAST)
def test_it_leaves_what_it_leaves(last: str, behind: str) -> None:
    """The state in which the next program begins is not that behind the change."""
    program = (HEAD + LAST[last] + behind).encode()
    settings = chipbreak.load("fanuc-lathe", ['cycles.unroll="always"'])
    result = chipbreak.rewrite(program, settings)
    assert result.changed
    assert result.data.endswith(behind.encode())
    assert chipbreak.restore(result.data) == program
