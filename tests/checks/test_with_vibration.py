"""A tool check between vibrated cuts: both need the spindle, each in its own way."""

from __future__ import annotations

import pytest

import chipbreak
from chipbreak.editing.restore import restore
from chipbreak.text.source import read

OWN = ["checks.enabled=true", "checks.calls=own", 'calls.own={chip_check="G65 P9858 T{tool} H{limit}"}']
PROGRAM = """G28 U0 W0
T0101 (ROUGH TURN)
{speed} M3
G0 X50. Z2.
G1 Z-20. F0.05 N1.5
G0 X60. Z5.
(SEMI-FINISH TURN)
G0 X50. Z2.
G1 Z-18. F0.05 N1.5
G0 X60. Z5.
G28 U0 W0
M30
"""


@pytest.mark.parametrize("speed", ["G97 S3000", "G96 S471"])
def test_the_programmed_speed_is_back_before_a_check(speed: str) -> None:
    program = PROGRAM.format(speed=speed).encode()
    settings = chipbreak.load("fanuc-lathe", OWN)
    found = chipbreak.rewrite(program, settings)
    lines = found.data.decode().split("\n")
    first, second = (n for n, line in enumerate(lines) if "P9858" in line)
    back = speed.removeprefix("G97 ")
    assert lines[first - 7 : first + 2] == [
        "(CHIPBREAK BEGIN SPEED AS PROGRAMMED)",
        back,
        lines[first - 5],
        "(CHIPBREAK BEGIN CHIP CHECK T1 W0.02)",
        "G28 U0",
        "G28 W0",
        "M5",
        "G65 P9858 T1 H0.02",
        f"{speed.split()[1]} M3",
    ]
    # Whatever the check did, the second cut commands its own speed again.
    commanded = [n for n, line in enumerate(lines) if line in ("S2500", "G97 S2500")]
    assert [n < first for n in commanded] == [True, False]
    assert commanded[1] < second
    assert restore(read(found.data)).data == program
    assert chipbreak.rewrite(found.data, settings).data == found.data
    assert [cut.verdict.breaks for cut in found.cuts] == [True, True]


def test_without_a_check_the_cuts_share_their_speed() -> None:
    program = PROGRAM.format(speed="G97 S3000").encode()
    found = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe"))
    assert found.data.count(b"\nS2500\n") == 1
