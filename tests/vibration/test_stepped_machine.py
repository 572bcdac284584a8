"""Verdicts behind filters against a machine that is stepped through time, on cuts drawn at random.

The suite takes a few of them; ``CHIPBREAK_DRAWN=200`` takes so many.
"""

from __future__ import annotations

import os
import re

import numpy as np
import pytest

import chipbreak
from chipbreak.kinematics.waveform import full_window
from stepped_machine import Machine, behind_filters, commanded, seen

COUNT = int(os.environ.get("CHIPBREAK_DRAWN", "8"))
_STEPS = 1280  # a vibration: a twentieth of the steps in which the package looks at it
_MOVE = re.compile(r"(?:G1 )?Z(-?[0-9.]+)(?: F([0-9.]+))?$")


class Drawn:
    """A cut and a machine, from a number."""

    def __init__(self, seed: int) -> None:
        draw = np.random.default_rng(seed)
        self.period_s = float(draw.choice([0.016, 0.020, 0.032, 0.048, 0.100]))
        self.per_rev = float(draw.choice([0.3333, 0.5, 0.75, 1.25, 1.5, 2.5, 2.6]))
        self.speed_rpm = 60.0 / self.period_s / self.per_rev
        self.alpha = float(draw.choice([0.5, 0.5, 0.75]))
        self.feed_mm = round(float(draw.uniform(0.03, 0.15)), 3)
        self.average_s = float(draw.choice([0.0, 0.4, 0.7])) * self.period_s * float(draw.uniform(0.2, 1.0))
        self.gain_1_s = float(draw.uniform(20.0, 300.0))
        self.forward = float(draw.choice([0.0, 0.0, 0.6]))
        self.kind = str(draw.choice(["linear", "exponential", "bell"])) if self.average_s else "linear"
        self.ratio = float(draw.choice([0.0, 1.2, 3.0]))
        self.looks_ahead = bool(draw.random() < 0.3)
        self.joint_mm_min = float(draw.uniform(50.0, 2000.0))
        self.ramp_mm_s2 = float(draw.uniform(8000.0, 40000.0))

    @property
    def machine(self) -> Machine:
        """Its numbers as the stepped machine takes them."""
        first = round(self.average_s * 1000.0, 3) / 1000.0
        lags = [(1.0 - self.forward) / self.gain_1_s]
        averages = [first, round(first / 2.0, 6)] if self.kind == "bell" else [first]
        if self.kind == "exponential":
            averages = []
            lags.insert(0, first)
        averages = [one for one in averages if one]
        if not self.looks_ahead:
            return Machine(tuple(averages), tuple(lags))
        return Machine(tuple(averages), tuple(lags), self.joint_mm_min / 60.0, self.ramp_mm_s2)

    @property
    def sets(self) -> list[str]:
        """The keys of its profile."""
        first_ms = round(self.average_s * 1000.0, 3)
        found = [
            f"command.periods_ms=[{self.period_s * 1000.0}]",
            f"vibration.alpha={self.alpha}",
            "command.base_period_ms=1.0",
            "spindle.resolution_rpm=0.001",
            "output.decimals=5",
            "output.feed_decimals=7",
            "vibration.end_revolutions=1",
            f"axes.Z.acc_dec={self.kind}",
            f"axes.Z.acc_dec_ms={first_ms}",
            f"axes.Z.position_gain_1_s={self.gain_1_s}",
            f"axes.Z.feed_forward={self.forward}",
            f"planner.model={'look-ahead' if self.looks_ahead else 'after-interpolation'}",
        ]
        if self.kind == "bell":
            found.append(f"axes.Z.bell_ms={round(first_ms / 2.0, 3)}")
        if self.looks_ahead:
            found.append(f"planner.joint_speed_mm_min={self.joint_mm_min}")
            found.append(f"axes.Z.max_acceleration_mm_s2={self.ramp_mm_s2}")
        return found

    @property
    def program(self) -> str:
        """Long enough for the machine to settle and for some vibrations and revolutions after that."""
        machine = self.machine
        settling_s = sum(machine.averages_s) + 7.0 * sum(machine.lags_s)
        whole_s = settling_s + 12.0 * self.period_s + 10.0 * 60.0 / self.speed_rpm
        length_mm = whole_s * self.feed_mm * self.speed_rpm / 60.0 * 1.6
        asked = f" Q{self.ratio}" if self.ratio else ""
        frequency = 1.0 / self.period_s
        return (
            f"G97 S{self.speed_rpm:.3f} M3\nG0 X20. Z0.\n"
            f"(VIB N{self.per_rev} F{frequency:.6g}{asked})\nG1 Z-{length_mm:.3f} F{self.feed_mm}\nM30\n"
        )


def blocks_of(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Lengths and feeds per revolution of the blocks of a cut in Z from 0, as they are printed."""
    body = text.split("(CHIPBREAK BEGIN VIB")[1].split("(CHIPBREAK END", maxsplit=1)[0]
    ends, feeds = [0.0], list[float]()
    for line in body.splitlines():
        found = _MOVE.match(line.strip())
        if found:
            ends.append(-float(found[1]))
            feeds.append(float(found[2]) if found[2] else feeds[-1])
    return np.diff(ends), np.array(feeds)


@pytest.mark.parametrize("seed", range(COUNT))
def test_a_drawn_cut_on_the_stepped_machine(seed: int) -> None:
    drawn = Drawn(seed)
    settings = chipbreak.load("fanuc-lathe", drawn.sets)
    try:
        result = chipbreak.rewrite(drawn.program.encode(), settings, allow_unbroken=True)
    except chipbreak.ProgramRejectedError as error:
        assert {d.code for d in error.diagnostics if d.severity.value == "error"} <= {"VIB030"}
        return
    (cut,) = result.cuts
    lengths_mm, per_rev_mm = blocks_of(result.data.decode())
    speed_rpm = cut.plan.solution.speed_rpm
    feeds_mm_s = per_rev_mm * speed_rpm / 60.0
    step_s = drawn.period_s / _STEPS
    machine = drawn.machine
    command_mm, duration_s = commanded(lengths_mm, feeds_mm_s, machine, step_s)
    real_mm = behind_filters(command_mm, machine, step_s)
    assert cut.duration_s == pytest.approx(duration_s, rel=0.01)
    settling_s = sum(machine.averages_s) + 7.0 * sum(machine.lags_s)
    first_s, last_s = full_window(cut.wave)
    assert last_s - first_s > settling_s + 3.0 * drawn.period_s
    stepped = seen(real_mm, step_s, 60.0 / speed_rpm, drawn.period_s, (first_s + settling_s, last_s))
    if not stepped.per_rev and abs(duration_s / cut.wave.duration_s - 1.0) > 0.005:
        # It never turns back and takes another time than planned: nothing tells its mean feed.
        assert not cut.verdict.breaks
        assert not cut.verdict.per_rev
        return
    assert cut.verdict.stroke_mm == pytest.approx(stepped.stroke_mm, rel=0.01, abs=2e-5)
    assert cut.verdict.margin == pytest.approx(stepped.margin, rel=0.01, abs=0.003)
    assert cut.verdict.breaks == (cut.verdict.margin >= 1.0)
    if stepped.per_rev and cut.verdict.per_rev:
        assert cut.verdict.per_rev == pytest.approx(stepped.per_rev, rel=0.01)
    assert bool(stepped.per_rev) == bool(cut.verdict.per_rev)
