"""Conditions that the machine chooses: within its limits, near the programmed speed, and the chips break."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import chipbreak
from chipbreak.kinematics.conditions import (
    LEAST_PER_REV,
    Conditions,
    Limits,
    Wanted,
    best_first,
    least_demand,
)
from chipbreak.kinematics.speed_solver import CommandGroup, SolverRules
from chipbreak.kinematics.waveform import WaveformParameters, least_stroke_mm
from chipbreak.vibration.choice import Chooser, _Tried
from chipbreak.vibration.measure import CutReport

MACHINE = (
    "planner.model=trapezoid",
    "axes.X.max_acceleration_mm_s2=5000",
    "axes.Z.max_acceleration_mm_s2=5000",
    "vibration.n=auto",
)
GROUP = CommandGroup()


def filtered(program: str, *sets: str, profile: str = "fanuc-lathe") -> chipbreak.Result:
    return chipbreak.rewrite(program.encode(), chipbreak.load(profile, [*MACHINE, *sets]))


def turned(speed: str = "G97 S1500", cut: str = "G1 Z-30. F0.2", head: str = "") -> str:
    return f"G21 G99\n{head}\n{speed} M3\nG0 X50. Z2.\n{cut}\nG0 X60.\nM30\n"


def one(program: str, *sets: str) -> CutReport:
    (cut,) = filtered(program, *sets).cuts
    return cut


@given(
    feed_mm=st.floats(0.02, 0.6),
    speed_rpm=st.integers(60, 6000).map(float),
    edges=st.integers(1, 3),
    limit=st.floats(300.0, 20000.0),
    top_rpm=st.none() | st.integers(60, 6000).map(float),
)
def test_every_choice_breaks_within_the_limits(
    feed_mm: float, speed_rpm: float, edges: int, limit: float, top_rpm: float | None
) -> None:
    wanted = Wanted(feed_mm, speed_rpm, edges, 1.2, 0.2)
    turns_hz = speed_rpm * edges / 60.0
    periods = GROUP.between(LEAST_PER_REV * turns_hz, 5.0 * turns_hz)
    rules = SolverRules(max_rpm=top_rpm, edges=edges)
    found = best_first(wanted, periods, rules, Limits(limit, math.inf))
    for choice in found[:20]:
        assert abs(choice.speed_rpm / speed_rpm - 1.0) <= 0.2 + 1e-9
        assert top_rpm is None or choice.speed_rpm <= top_rpm
        assert choice.per_rev == pytest.approx(60.0 / choice.period.period_s / choice.speed_rpm)
        forward = round(choice.alpha * choice.period.ticks)
        least_mm = least_stroke_mm(
            "triangle", choice.per_rev, feed_mm, alpha_share=choice.alpha, edges=edges, margin=1.2
        )
        assert choice.stroke_mm == pytest.approx(least_mm, rel=1e-9)
        wave = WaveformParameters(
            100.0,
            feed_mm,
            choice.speed_rpm,
            choice.period.period_s,
            choice.period.ticks,
            forward,
            least_mm,
        )
        need = wave.shape.least_acceleration_mm_s2(wave, choice.per_rev)
        assert choice.acceleration_mm_s2 == pytest.approx(need, rel=1e-9)
        assert need <= limit
    least = least_demand(wanted, periods, rules, Limits(limit, math.inf))
    if not found and least is not None:
        assert least.acceleration_mm_s2 > limit


def test_what_a_fixed_count_cannot_do_the_machine_finds() -> None:
    with pytest.raises(chipbreak.ProgramRejectedError):
        filtered(turned(), "vibration.n=1.5", "vibration.refused=error")
    cut = one(turned())
    assert cut.plan.solution.speed_rpm == 1500.0
    assert cut.verdict.breaks
    assert cut.verdict.margin == pytest.approx(1.2, abs=0.02)
    assert cut.acceleration_mm_s2 <= 0.9 * 5000.0
    assert cut.duration_s == pytest.approx(cut.programmed_s or 0.0, rel=0.01)


def test_chips_are_shorter_than_a_revolution_where_the_axis_can() -> None:
    assert one(turned("G97 S500")).plan.solution.per_rev == pytest.approx(1.5, rel=0.1)
    assert one(turned("G97 S2500")).plan.solution.per_rev < 0.7


def test_the_reserve_is_kept() -> None:
    assert one(turned(), "vibration.reserve=0.6").acceleration_mm_s2 <= 0.4 * 5000.0
    assert one(turned(), "vibration.reserve=0").acceleration_mm_s2 <= 5000.0 * (1.0 + 1e-9)


def test_a_clamp_below_the_programmed_speed_is_respected() -> None:
    cut = one(turned("G97 S1500", head="G50 S1300"))
    assert cut.plan.solution.speed_rpm <= 1300.0
    assert cut.verdict.breaks


def test_a_speed_stays_within_the_tolerance_of_the_profile() -> None:
    cut = one(turned(), "spindle.speed_tolerance=0")
    assert cut.plan.solution.speed_rpm == 1500.0
    assert cut.verdict.breaks


def test_constant_surface_speed_is_chosen_near_its_start() -> None:
    cut = one(turned("G96 S150", head="G50 S3000"))
    assert cut.plan.solution.speed_rpm == pytest.approx(1000.0 * 150.0 / math.pi / 50.0, rel=0.2)
    assert cut.verdict.breaks


def test_a_directive_asks_and_a_count_goes_before_it() -> None:
    program = turned(cut="(VIB AUTO Q1.4)\nG1 Z-10. F0.1\n(VIB AUTO)\nG1 Z-20. N0.5\n(VIB E4)\nG1 Z-40.")
    settings = chipbreak.load("fanuc-lathe", [one for one in MACHINE if "auto" not in one])
    cuts = chipbreak.rewrite(program.encode(), settings).cuts
    assert [cut.plan.given["N"].origin.split(" ")[0] for cut in cuts] == ["chosen", "N", "directive,"]
    assert cuts[0].plan.wave.stroke_mm == pytest.approx(0.14)
    assert cuts[1].plan.solution.per_rev == pytest.approx(0.5)
    assert cuts[2].plan.solution.per_rev == pytest.approx(0.25, rel=0.01)


def test_a_short_cut_gets_a_short_ramp() -> None:
    cut = one(turned(cut="G1 Z1. F0.2"))
    assert cut.verdict.breaks
    assert cut.plan.wave.ramp_in_s < 3.0 * cut.plan.wave.period_s
    left = filtered(turned(cut="G1 Z1.9 F0.2")).left
    assert [cut.said.code for cut in left] == ["VIB013"]


def test_a_chain_that_a_corner_spoils_is_tried_block_by_block() -> None:
    corner = "G1 X46. F0.2\nX49. Z-1.\nX46. Z-2.\nX49. Z-3.\nX46. Z-4.\nZ-40.\nX50. Z-70."
    result = filtered(turned("G97 S2000", cut=corner))
    assert sum(cut.plan.path.length_mm for cut in result.cuts) > 65.0
    assert all(cut.verdict.breaks for cut in result.cuts)


@pytest.mark.parametrize("model", ["ideal", "linuxcnc", "trapezoid"])
def test_what_is_chosen_breaks_by_the_law_of_the_control(model: str) -> None:
    for speed in (300, 900, 2700):
        for feed in (0.08, 0.3):
            cut = one(turned(f"G97 S{speed}", cut=f"G1 Z-15. F{feed}"), f"planner.model={model}")
            assert cut.verdict.breaks
            assert not cut.misses_plan


@pytest.mark.parametrize("wave", ["SINE", "DWELL"])
def test_another_wave_is_chosen_for_too(wave: str) -> None:
    settings = chipbreak.load("fanuc-lathe", MACHINE)
    for speed in ("G97 S1500", "G97 S700", "G97 S1370"):
        program = turned(speed, cut=f"(VIB AUTO WAVE {wave})\nG1 Z-30. F0.2")
        (cut,) = chipbreak.rewrite(program.encode(), settings).cuts
        assert cut.verdict.breaks
        assert cut.plan.wave.waveform == wave.lower()


def test_many_cuts_of_a_kind_are_chosen_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from chipbreak.vibration import choice

    judged = []
    real = choice.measure_planned
    monkeypatch.setattr(choice, "measure_planned", lambda *a: judged.append(1) or real(*a))
    cuts = "".join(f"G0 X{50 - n}.\nG1 Z-30. F0.2\nG0 Z2.\n" for n in range(20))
    result = filtered(f"G21 G99\nG97 S1500 M3\nG0 Z2.\n{cuts}M30\n")
    assert len(result.cuts) == 20
    assert len(judged) < 3


def test_other_speeds_and_feeds_are_tried_for_few_cuts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing does it, trying them takes longer than all cuts: eight in a run, however many it has."""
    from chipbreak.vibration import choice

    feeds: list[float] = []
    real = choice.Chooser._tried

    def counted(self: choice.Chooser, cut: Any, *rest: Any) -> Any:
        feeds.append(cut.wanted.feed_mm_rev)
        return real(self, cut, *rest)

    monkeypatch.setattr(choice.Chooser, "_tried", counted)
    cuts = "".join(f"G0 X{50 - n}. Z2.\nG1 Z-30. F0.{n}1\nG0 Z2.\n" for n in range(2, 5))
    program = f"G21 G99\nG97 S1500 M3\n{cuts}M30\n".encode()
    weak = ("vibration.n=auto", "vibration.refused=leave", "planner.model=after-interpolation")
    slow = [f"axes.{axis}.{key}" for axis in "XZ" for key in ("acc_dec_ms=200", "position_gain_1_s=15")]
    chipbreak.rewrite(program, chipbreak.load("fanuc-lathe", (*weak, *slow)))
    own = {0.21, 0.31, 0.41}
    assert own <= set(feeds)
    assert len(feeds) == 3 + 8


@pytest.mark.filterwarnings("error")
def test_a_speed_of_one_turn_a_minute() -> None:
    """Speeds near it print as zero: nothing is divided by them."""
    program = b"G99 G97 S1 M3\nG0 X20. Z2.\n(VIB AUTO)\nG1 Z-30. F0.3\nM30\n"
    (cut,) = chipbreak.rewrite(program, chipbreak.load("fanuc-lathe")).cuts
    assert cut.plan.solution.speed_rpm == 1.0


def test_what_worked_for_a_long_cut_is_judged_again_where_a_short_one_is_mostly_ramp() -> None:
    """Of 1.1 mm the ramps of the choice for 51 mm leave too little; another one has room."""
    back = "G0 X64.\nZ1.\n"
    passes = f"G0 X59.\nG1 Z-50. F0.3\n{back}G0 X54.\nG1 Z-0.113\n{back}G0 X50.\nG1 Z-50.\n{back}"
    program = f"T0101\nG97 S900 M3\nG0 X64. Z1.\n{passes}M30\n"
    result = filtered(program)
    assert not [left.said.message for left in result.left if left.said.code != "VIB068"]
    long, short, again = (cut.plan.solution.per_rev for cut in result.cuts)
    assert short != long
    assert again == long, "the short one changes nothing for others"


@pytest.mark.parametrize(("waveform", "most"), [("sine", 4), ("triangle", 99)])
def test_waves_of_several_blocks_a_stroke_are_tried_a_few_times(
    waveform: str, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None breaks the chips here; to find their feeds on LinuxCNC takes a second for each try."""
    tried: list[float] = []

    def fails(_self: object, _cut: object, conditions: Conditions, _make: object) -> _Tried:
        tried.append(conditions.period.frequency_hz)
        return _Tried(0.0, conditions, None)  # type: ignore[arg-type]

    monkeypatch.setattr(Chooser, "_try", fails)
    settings = chipbreak.load("linuxcnc-lathe", ["vibration.n=auto", f"vibration.waveform={waveform}"])
    program = b"G21 G97 S1500 M3\nG95\nG0 X50. Z2.\nG1 Z-30. F0.1\nG0 X60.\nM2\n"
    chipbreak.rewrite(program, settings, allow_unbroken=True)
    shares = [after / before for before, after in pairwise(tried)]
    shares = shares[: next(at for at, share in enumerate(shares) if share >= 1.0)]  # then other speeds follow
    assert 2 <= len(shares) < most
    assert all(share < 0.86 for share in shares)
    assert shares[-1] < shares[0], (
        "each that fails like the one before is followed by one that is slower still"
    )


def test_behind_cuts_of_a_kind_that_nothing_breaks_one_choice_is_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each takes long where the strokes are run through: of a roughing with a hundred passes, minutes."""
    from chipbreak.vibration import choice

    tried: list[int] = []
    real = choice.Chooser._try

    def counted(self: choice.Chooser, cut: Any, *rest: Any) -> Any:
        tried.append(cut.chain.first)
        return real(self, cut, *rest)

    monkeypatch.setattr(choice.Chooser, "_try", counted)
    passes = "".join(f"G0 X{40 - n}. Z2.\nG1 Z-{n + 1}. F0.12\nG0 X60.\n" for n in range(5))
    program = f"G21 G18 G95\nG97 S500 M3\n{passes}M30\n".encode()
    options = ("vibration.waveform=sine", "vibration.n=auto", "vibration.refused=leave")
    result = chipbreak.rewrite(
        program, chipbreak.load("linuxcnc-lathe", (*options, "output.feed_decimals=2"))
    )
    assert [left.said.code for left in result.left] == ["VIB059"] * 5
    assert tried == [3] * 4 + [6] * 4 + [9] * 4 + [12, 15]
