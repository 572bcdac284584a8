"""While the stroke grows, no vibration is lost, however small its return: the motion follows the ramp."""

from __future__ import annotations

import re
from itertools import product

import numpy as np
import pytest

import chipbreak
from longer import every_second

HEAD = "G21 G18 G90 G8 G97 G95 S{} M3\nG0 X6 Z0\n(VIB {})\nG1 Z-{} F{}\nM2\n"


def crests(speed: int, wish: str, length: float, feed: float, *sets: str) -> list[tuple[float, float]]:
    """How high the crests of the ramp are, as they should be and as the law of the control has them."""
    settings = chipbreak.load("linuxcnc-lathe", ["axes.Z.max_acceleration_mm_s2=5000", *sets])
    program = HEAD.format(speed, wish, length, feed).encode()
    result = chipbreak.rewrite(program, settings, allow_unbroken=True)
    ((cut,), (motion,)) = result.cuts, chipbreak.motions(result, settings)
    wave = cut.wave
    ahead = (motion.distance_mm - wave.speed_mm_s * motion.time_s) / wave.stroke_mm
    found = list[tuple[float, float]]()
    for index in range(round(wave.ramp_in_s / wave.period_s)):
        crest_s = (index + wave.alpha_share) * wave.period_s
        near = np.abs(motion.time_s - crest_s) <= wave.period_s / 4.0
        wanted = min(1.0, crest_s / wave.ramp_in_s) ** wave.ramp_exponent
        found.append((wanted, float(ahead[near].max())))
    return found


# Return strokes that go on forward, that are nothing, and that are one step.
WISHES = ["N0.5", "N0.5 Q1.5", "N2.5", "N2.5 Q1.6", "N1.5 RAMP8", "N0.5 RAMP2"]


@pytest.mark.parametrize(("wish", "mode"), every_second(product(WISHES, ["rev", "minute", "inverse"])))
def test_every_crest_of_the_ramp_is_there(wish: str, mode: str) -> None:
    for speed, feed in ((600, 0.04), (1200, 0.08)):
        for wanted, seen in crests(
            speed, wish, 2.4, feed, f"output.feed_mode={mode}", "command.periods_ms=[80, 100]"
        ):
            assert seen == pytest.approx(wanted, abs=0.1), (wish, speed, feed)


def test_a_return_of_no_length_becomes_a_step_back() -> None:
    settings = chipbreak.load(
        "linuxcnc-lathe", ["axes.Z.max_acceleration_mm_s2=5000", "output.feed_mode=minute"]
    )
    program = HEAD.format(600, "N0.5 Q1.5 RAMP3", 2.4, 0.08).encode()
    result = chipbreak.rewrite(program, settings, allow_unbroken=True)
    (cut,) = result.cuts
    assert cut.move_count == 2 * cut.wave.vibrations + 1


def test_on_other_controls_the_points_stay_where_they_are() -> None:
    settings = chipbreak.load("generic-lathe", ["output.decimals=4"])
    program = b"G97 G95 S600 M3\nG0 X12. Z0.\n(VIB N0.5 Q1.5)\nG1 Z-2.4 F0.08\nM2\n"
    (cut,) = chipbreak.rewrite(program, settings, allow_unbroken=True).cuts
    assert np.diff(cut.expansion.time_s).max() >= cut.wave.period_s * 0.99


@pytest.mark.parametrize("wish", ["E2.5", "E2", "E3"])
def test_no_rest_is_longer_than_the_way_to_the_next_block(wish: str) -> None:
    """Three slow servo periods are longer than the base period in which a block follows the crest."""
    sets = ("planner.servo_period_ms=2", "output.segments=tick", "axes.Z.max_acceleration_mm_s2=10000")
    settings = chipbreak.load("linuxcnc-lathe", sets)
    program = HEAD.format(750, wish, 3.0, 0.09).encode()
    (cut,) = chipbreak.rewrite(program, settings, allow_unbroken=True).cuts
    assert np.diff(cut.expansion.time_s, prepend=0.0).min() > 0.0


def test_on_an_arc_a_crest_is_raised_along_it() -> None:
    """F tells steps of 28 digits here; along one axis alone the point would leave the arc by 0.75 um."""
    sets = ["vibration.phase=0.25", "output.decimals=5", "planner.model=linuxcnc", "vibration.n=auto"]
    sets += [f"axes.{axis}.max_acceleration_mm_s2=2000" for axis in "XZ"]
    program = b"G20\nG97 S1000 M3\nG99\nG0 X0.7874 Z0.\nG2 X0.9764 Z-0.0945 R0.0945 F0.0047 N0.5\nM30\n"
    data = chipbreak.rewrite(program, chipbreak.load("haas-lathe", sets)).data
    x, z = np.array(re.findall(rb"X([\d.]+) Z(-[\d.]+) F", data), dtype=float).T
    off_in = np.hypot(x / 2.0 - 0.3937 - 0.0945, z) - 0.0945
    assert np.count_nonzero(np.diff(z) > 0.0) > 3  # it turns back
    assert np.abs(off_in[:-1]).max() < 2e-6
