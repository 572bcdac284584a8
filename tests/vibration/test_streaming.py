"""Programs that come over a line: what is refused because its blocks come in too slowly."""

from __future__ import annotations

import re

import pytest

import chipbreak

PROGRAM = b"G21 G90 G94\nS2500 M3\nG0 X10. Z2.\nG1 Z-20. F125. N1.5\nG0 X30.\nM30\n"
AXES = ("axes.X.max_acceleration_mm_s2=20000", "axes.Z.max_acceleration_mm_s2=20000")


def cuts_at(baud: int, program: bytes = PROGRAM) -> tuple[chipbreak.CutReport, ...]:
    """Ten bits a byte."""
    profile = chipbreak.load("grbl", [*AXES, f"planner.max_bytes_per_s={baud / 10}"])
    return chipbreak.rewrite(program, profile).cuts


def test_a_fast_line_is_enough() -> None:
    assert len(cuts_at(115_200)) == 1


@pytest.mark.parametrize(
    ("profile", "sets"),
    [
        ("fanuc-lathe", ("vibration.waveform=dwell",)),
        ("linuxcnc-lathe", ("vibration.waveform=sine", "output.segments=tick")),
        ("linuxcnc-lathe", ("vibration.waveform=dwell",)),
    ],
)
def test_a_control_that_reads_too_few_blocks_is_said(profile: str, sets: tuple[str, ...]) -> None:
    """In the mean: single blocks may be shorter, for controls read ahead.  A dwell is a block as well."""
    program = b"G21 G97 S1200 M3\nG95\nG0 X20. Z2.\nG1 Z-20. F0.1 E2.5\nG0 X30.\nM30\n"
    acceleration = ("axes.X.max_acceleration_mm_s2=20000", "axes.Z.max_acceleration_mm_s2=20000")
    (cut,) = chipbreak.rewrite(program, chipbreak.load(profile, [*acceleration, *sets])).cuts
    blocks = cut.move_count + int((cut.expansion.dwell_s > 0.0).sum())
    rate = blocks / cut.duration_s
    few, enough = (
        chipbreak.load(profile, [*acceleration, *sets, f"planner.max_blocks_per_s={share * rate}"])
        for share in (0.9, 1.1)
    )
    with pytest.raises(chipbreak.ProgramRejectedError) as caught:
        chipbreak.rewrite(program, few)
    errors = [one.code for one in caught.value.diagnostics if one.severity is chipbreak.Severity.ERROR]
    assert errors == ["VIB032"]
    (again,) = chipbreak.rewrite(program, enough).cuts
    assert again.duration_s == pytest.approx(cut.duration_s, rel=1e-6)


def test_a_slow_line_is_refused_with_what_works() -> None:
    """62.5 Hz are 125 blocks a second; at 9,600 baud N 1.5 would fall to 0.5."""
    with pytest.raises(chipbreak.ProgramRejectedError, match="the control gets 960") as caught:
        cuts_at(9600)
    (error,) = caught.value.diagnostics
    assert error.code == "VIB032"
    works = re.search(r"works at f ([0-9.]+) Hz", error.help)
    assert works
    (cut,) = cuts_at(9600, PROGRAM.replace(b"N1.5", b"N1.5 f" + works[1].encode()))
    assert cut.verdict.breaks
    assert cut.plan.solution.per_rev == pytest.approx(1.5, abs=0.001)


def test_blocks_that_are_too_long_anyway_are_refused_before_their_feeds_are_looked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On LinuxCNC that takes a second, and shorter they do not get."""
    program = b"G21 G97 S1200 M3\nG95\nG0 X20. Z2.\nG1 Z-20. F0.1 N0.5\nG0 X30.\nM30\n"
    sets = ("vibration.waveform=sine", "output.segments=tick")

    def refused(most: float) -> str:
        settings = chipbreak.load("linuxcnc-lathe", [*sets, f"planner.max_bytes_per_s={most}"])
        with pytest.raises(chipbreak.ProgramRejectedError) as caught:
            chipbreak.rewrite(program, settings, allow_unbroken=True)
        (error,) = (one for one in caught.value.diagnostics if one.severity is chipbreak.Severity.ERROR)
        assert error.code == "VIB032"
        return error.message

    needed = float(re.findall(r"needs (\d+) bytes", refused(100.0))[0])
    assert needed > 1000.0
    monkeypatch.setattr("chipbreak.vibration.blocks._feed_words", None)
    refused(0.9 * needed)
    with pytest.raises(TypeError):
        refused(1.1 * needed)
