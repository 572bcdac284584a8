"""Arcs with turns (LinuxCNC's P): their time against closed forms and the simulated machine."""

from __future__ import annotations

import math

import numpy as np
import pytest

import chipbreak
from chipbreak.report.model import CycleTime
from linuxcnc import machine

MILL = "G21 G17 G90 G94 G40 G49 G80 G54\nG0 X10. Y0\nG0 Z0\nG1 X11. F1200\nX10.\n"
FAST = ("times.rapid_mm_min=6000", "checks.enabled=false")
# Each arc starts at X10 Y0 Z0; what it should be long [mm].
ARCS = {
    "a circle twice": ("G3 X10 Y0 I-10 P2", 40 * math.pi),
    "a half and two turns": ("G2 X-10 Y0 I-10 P3", 50 * math.pi),
    "a helix": ("G3 X10 Y0 Z-6 I-10 P3", math.hypot(60 * math.pi, 6)),
    "by R": ("G2 X0 Y-10 R10 P2", 25 * math.pi),
    "one turn, said": ("G3 X-10 Y0 I-10 P1", 10 * math.pi),
}


def time_of(block: str, profile: str = "linuxcnc-mill") -> CycleTime:
    settings = chipbreak.load(profile, FAST)
    result = chipbreak.rewrite(f"{MILL}{block}\nM2\n".encode(), settings)
    time = chipbreak.explain(result, settings).time
    assert time is not None
    return time


@pytest.mark.parametrize(("block", "length_mm"), ARCS.values(), ids=ARCS)
def test_each_turn_takes_its_time(block: str, length_mm: float) -> None:
    time = time_of(block)
    assert not time.untimed
    (cutting,) = (part.before_s for part in time.parts if part.name == "cutting")
    assert cutting == pytest.approx((2.0 + length_mm) / 1200.0 * 60.0, rel=1e-9)


@pytest.mark.linuxcnc("machine")
def test_the_machine_takes_as_long() -> None:
    programs = [f"G61\n{MILL}{block}\nM2\n".encode() for block, _ in ARCS.values()]
    runs = machine.run_steadily(programs, acceleration_mm_s2=20000.0, lathe=False)
    for run, (block, length_mm) in zip(runs, ARCS.values(), strict=True):
        assert not run.errors, block
        way_mm = np.linalg.norm(np.diff(run.samples[:, 1:], axis=0), axis=1)
        on_arc = run.lines[1:] == MILL.count("\n") + 2
        assert way_mm[on_arc].sum() == pytest.approx(length_mm, rel=2e-3), block


@pytest.mark.parametrize("turns", ["P0", "P1.5", "P#1"])
def test_turns_that_are_no_number_of_turns_have_no_time(turns: str) -> None:
    assert time_of(f"G3 X-10 Y0 I-10 {turns}").untimed


def test_where_p_is_not_known_to_be_turns_the_arc_has_no_time_and_its_word_a_warning() -> None:
    program = f"{MILL}G3 X-10. Y0 I-10. P2\nM30\n".encode()
    settings = chipbreak.load("fanuc-mill", FAST)
    assert [one.code for one in chipbreak.check(program, settings)] == ["MOD001"]
    assert time_of("G3 X-10. Y0 I-10. P2", "fanuc-mill").untimed


def test_turns_are_no_unread_word_and_no_pass_takes_them_over() -> None:
    settings = chipbreak.load("linuxcnc-mill", FAST)
    assert not chipbreak.check(f"{MILL}G3 X10 Y0 I-10 P2\nM2\n".encode(), settings)
    lathe = chipbreak.load("linuxcnc-lathe")
    start = "G21 G90 G18 G8 G97 S1000 M3\nG0 X10 Z2\nG95 F0.1\nG1 Z0\n"
    asked = f"{start}G3 X10 Z-3 I-10 K0 P2 N1.5\nM2\n".encode()
    assert "VIB048" in [one.code for one in chipbreak.check(asked, lathe)]
