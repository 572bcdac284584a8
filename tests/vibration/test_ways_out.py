"""What a refused cut is told to do instead works."""

from __future__ import annotations

import re

import pytest

import chipbreak
from chipbreak.vibration import judged
from chipbreak.vibration.blocks import Expansion, moves_of
from chipbreak.vibration.measure import CutReport
from chipbreak.vibration.plan import CutPlan

HEAD = "G21 G18 G90 G8 G97 G95 S{} M3\nG0 X{} Z1\n"
SHOULDER = "G1 Z-2 F0.1 {0}\nX12 F0.1 {0}\nM2\n"
ARC = "G3 X12 Z-3 I0 K-4 F0.1 {}\nM2\n"


def settings(acceleration_mm_s2: float) -> chipbreak.Settings:
    limits = [f"axes.{axis}.max_acceleration_mm_s2={acceleration_mm_s2:g}" for axis in "XZ"]
    return chipbreak.load("linuxcnc-lathe", limits)


@pytest.mark.parametrize(
    ("blocks", "x", "speed", "wish", "acceleration", "code"),
    [
        (SHOULDER, 10, 2500, "N1.5", 10000, "VIB060"),
        (SHOULDER, 10, 600, "N2.5", 2000, "VIB060"),
        (ARC, 8, 2000, "N1.25", 10000, "VIB034"),
    ],
)
def test_conditions_that_work(
    *, blocks: str, x: int, speed: int, wish: str, acceleration: float, code: str
) -> None:
    program = HEAD.format(speed, x) + blocks.format(wish)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program.encode(), settings(acceleration))
    (error,) = caught.value.diagnostics
    assert error.code == code
    works = re.search(r"works: N ([0-9.]+) f ([0-9.]+) Hz \(S ([0-9]+)\)", error.help)
    assert works, error.help
    followed = HEAD.format(works[3], x) + blocks.format(f"N{works[1]}")
    (cut,) = chipbreak.rewrite(followed.encode(), settings(acceleration)).cuts
    assert cut.verdict.breaks
    assert cut.plan.solution.frequency_hz == pytest.approx(float(works[2]), rel=1e-5)
    assert cut.verdict.per_rev == pytest.approx(float(works[1]), rel=0.01)


SLOW_STEPS = [
    "planner.model=junction",
    *(f"axes.{axis}.steps_per_mm=80" for axis in "XZ"),
    *(f"axes.{axis}.max_velocity_mm_min=3000" for axis in "XZ"),
    *(f"axes.{axis}.max_acceleration_mm_s2=8000" for axis in "XZ"),
]
SLOW = "G21 G18 G90 G94\nM3 S{}\nG0 X20 Z2\n(VIB {})\n{}\nG0 X80\nM30\n"


@pytest.mark.parametrize(
    ("speed_rpm", "wish", "blocks"),
    [
        (200, "E3", "G1 Z-20 F{}"),
        (200, "N1.5 WAVE SINE", "G1 Z-15 F{}\nX24 Z-17\nZ-30"),
    ],
)
def test_a_cut_that_is_too_slow_for_the_control_gets_a_higher_feed(
    speed_rpm: int, wish: str, blocks: str
) -> None:
    """At a lower frequency every move would be slower still."""
    grbl = chipbreak.load("grbl", SLOW_STEPS)
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(SLOW.format(speed_rpm, wish, blocks.format(10)).encode(), grbl)
    (error,) = caught.value.diagnostics
    assert error.code == "VIB034"
    assert "as slowly" in error.message
    works = re.search(r"works: a feed of ([0-9.]+) mm/rev \(([0-9.]+) mm/min\)", error.help)
    assert works, error.help
    assert float(works[2]) == pytest.approx(float(works[1]) * speed_rpm)
    followed = SLOW.format(speed_rpm, wish, blocks.format(works[2]))
    (cut,) = chipbreak.rewrite(followed.encode(), grbl).cuts
    assert cut.verdict.breaks
    assert cut.plan.solution.speed_rpm == speed_rpm


SLOW_AXES = [
    "planner.model=after-interpolation",
    *(f"axes.{axis}.{number}" for axis in "XZ" for number in ("acc_dec_ms=16", "position_gain_1_s=50")),
]


@pytest.mark.parametrize(
    ("speed_rpm", "feed_mm", "turns", "more"),
    [(1200, 0.2, 3.0, "ALPHA0.8"), (1200, 0.03, 2.0, ""), (700, 0.2, 1.5, ""), (2400, 0.1, 2.4, "")],
)
def test_a_dwell_that_slow_axes_leave_nothing_of_gets_an_e_that_works(
    speed_rpm: int, feed_mm: float, turns: float, more: str
) -> None:
    settings = chipbreak.load("fanuc-lathe", SLOW_AXES)
    text = f"G21 G18 G99 G97 S{speed_rpm} M3\n(VIB E{{:g}} WAVE DWELL {more})\nG0 X20. Z2.\n"
    text += f"G1 Z-20. F{feed_mm}\nG0 X80.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(text.format(turns).encode(), settings)
    (error,) = caught.value.diagnostics
    assert error.code == "VIB086"
    named = re.search(r"take E ([0-9.]+)", error.help)
    assert named, error.help
    (cut,) = chipbreak.rewrite(text.format(float(named[1])).encode(), settings).cuts
    assert cut.verdict.breaks


@pytest.mark.parametrize(("feed_mm", "wish"), [(0.15, "N1.5"), (0.05, "N1.5 WAVE SINE")])
def test_what_a_step_of_a_facing_is_told_works_for_all_its_steps(feed_mm: float, wish: str) -> None:
    """Words stand for all steps: an E, or a Q, may do for one and not for the next."""
    limits = [f"axes.{axis}.max_acceleration_mm_s2=3000" for axis in "XZ"]
    settings = chipbreak.load("fanuc-lathe", [*SLOW_AXES, *limits])
    text = "G21 G18 G99\nG50 S3000\nG96 S200 M3\n(VIB {})\nG0 X80. Z0.\n"
    text += f"G1 X10. F{feed_mm}\nG0 X90.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(text.format(wish).encode(), settings)
    said = caught.value.diagnostics[0].help
    kept = " ".join(re.findall(r"WAVE \w+", wish))
    ways = [f"N{n} F{f} {kept}" for n, f in re.findall(r"N ([0-9.]+) f ([0-9.]+) Hz \(S", said)]
    ways += [f"E{turns} {kept}" for turns in re.findall(r"E ([0-9.]+) \(S", said)]
    ways += [f"{wish} Q{ratio}" for ratio in re.findall(r"Q ([0-9.]+) with the same", said)]
    assert ways, said
    for way in ways:
        result = chipbreak.rewrite(text.format(way).encode(), settings)
        assert all(cut.verdict.breaks for cut in result.cuts), way


def test_of_a_whole_n_that_was_given_another_s_is_no_way_out() -> None:
    settings = chipbreak.load("fanuc-lathe", ["vibration.correct=count"])
    text = "G21 G18 G99 G97 S150 M3\n(VIB {})\nG0 X20. Z2.\nG1 Z-20. F0.03\nG0 X80.\nM30\n"
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(text.format("N1").encode(), settings)
    (error,) = caught.value.diagnostics
    assert (error.code, error.help) == ("VIB005", "N 0.5 or 1.5 breaks best")
    for per_rev in ("N0.5", "N1.5"):
        (cut,) = chipbreak.rewrite(text.format(per_rev).encode(), settings).cuts
        assert cut.verdict.breaks


def test_strokes_of_several_blocks_on_linuxcnc_are_advised_after_few_tries(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each try plans a thousand blocks, no two strokes of them alike."""
    tried = list[object]()

    def expanded(cut: CutPlan, settings: chipbreak.Settings) -> Expansion:
        tried.append(cut)
        return moves_of(cut, settings)

    monkeypatch.setattr("chipbreak.vibration.trial.moves_of", expanded)
    program = HEAD.format(819, 40) + "(VIB N1.5 WAVE SINE)\nG1 X41 Z-4 F0.12\nM2\n"
    with pytest.raises(chipbreak.ProgramRejectedError, match=r"needs 1\.39 m/s2, Z has 0\.486"):
        chipbreak.rewrite(program.encode(), settings(500))
    assert 0 < len(tried) < 5


FOLLOWING = tuple(
    f"axes.{axis}.{number}"
    for axis in "XZ"
    for number in ("acc_dec_ms=8", "position_gain_1_s=90", "max_acceleration_mm_s2=1500")
)


@pytest.mark.parametrize(
    ("profile", "sets", "words", "code"),
    [
        ("generic-lathe", (), "N1.5 Q0.5", "VIB060"),
        ("fanuc-lathe", ("planner.model=after-interpolation", *FOLLOWING), "N1.5 Q1.5", "VIB062"),
        ("fanuc-lathe", ("planner.model=after-interpolation", *FOLLOWING), "N1.5 Q8", "VIB030"),
    ],
)
def test_of_many_cuts_that_fail_alike_few_are_advised(
    profile: str, sets: tuple[str, ...], words: str, code: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What works is tried for the first three, whatever they are refused for."""
    tried: set[int] = set()

    def counted(_settings: chipbreak.Settings, report: CutReport) -> str:
        tried.add(report.plan.chain.first)
        return ""

    monkeypatch.setattr(judged, "ways_out", counted)
    cuts = f"G0 X40. Z2.\nG1 Z1. F0.02 {words}\nG0 X300.\n" * 6
    program = f"G21 G18 G99 G97 S2500 M3\n{cuts}M30\n".encode()
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program, chipbreak.load(profile, sets))
    assert [one.code for one in caught.value.diagnostics if one.code == code] == [code] * 6
    assert len(tried) == 3
