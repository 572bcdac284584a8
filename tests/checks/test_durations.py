"""How long the checks take: what `explain` says against the clock of the machine that the macros run on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import chipbreak
from beam import BEAM
from chipbreak.checks.calls import CallValues, CheckKind
from chipbreak.checks.durations import check_s
from chipbreak.report.build import report_of
from chipbreak.report.model import Report
from chipbreak.tools.data import ToolData
from macros.stand import SETTINGS, Nominal, Stand

SAMPLE = Path(__file__).parents[2] / "samples" / "fusion-mill.nc"
GAP = ("macros.gap_ms=15", 'macros.gap_on="M75"')


@pytest.mark.parametrize(("teeth", "rpm"), [(2, 5000), (5, 900)])
def test_the_time_that_is_said_is_about_that_of_the_machine(teeth: int, rpm: int) -> None:
    nominal = Nominal(teeth=teeth, helix_deg=30.0)
    stand = Stand(nominal, nominal.real(), settings=replace(SETTINGS, trace_step_mm=1.0), rpm=rpm)
    settings = chipbreak.load("fanuc-mill", [*BEAM, *GAP])
    values = CallValues(1, rpm, 6.0, 0.02, data=ToolData(1, "flat end mill", teeth))
    took = {CheckKind.CALIBRATE: stand.seconds("T90 M6\nG65 P8900") - 5.0}
    stand.run("T1 M6")
    took[CheckKind.TOOL_CHECK] = stand.seconds(f"{nominal.data(1)}\nG65 P8901 T1. S{rpm}.")
    took[CheckKind.TRACE] = stand.seconds(f"G65 P8902 T1. Z6. S{rpm}.")
    for kind, seconds in took.items():
        assert check_s(kind, values, settings) == pytest.approx(seconds, rel=0.25), kind
    for depth in (0, 1, 2):
        seconds = stand.seconds(f"G65 P8903 T1. W0.02 D{depth}.")
        said = check_s(CheckKind.CHIP_CHECK, values._replace(depth=depth), settings)
        assert said == pytest.approx(seconds, rel=0.25, abs=1.5), depth


def test_explain_says_the_seconds_and_their_share() -> None:
    settings = chipbreak.load("fanuc-mill", [*BEAM, *GAP, "checks.depth=breakage"])
    report = report_of(chipbreak.rewrite(SAMPLE.read_bytes(), settings), settings)
    text = str(report)
    assert report.feed_s is not None
    assert report.time is not None
    others = [part.after_s for part in report.time.parts if part.name != "tool checks"]
    assert len(others) > 1  # rapids and tool changes count as well
    whole = sum(check.duration_s or 0.0 for check in report.checks)
    cycle_s = sum(others) + whole
    share = 100.0 * whole / cycle_s
    assert f"about {whole:.0f} s together, {share:.0f} % of the filtered program ({cycle_s:.0f} s)" in text
    assert f"CALIBRATE (about {report.checks[0].duration_s:.0f} s): " in text
    makers = chipbreak.load("haas-mill")
    assert "about" not in str(report_of(chipbreak.rewrite(SAMPLE.read_bytes(), makers), makers))


@pytest.mark.parametrize(
    ("setting", "sets"),
    [
        ("macros.gap_ms=15", GAP),
        ("checks.trace_height_mm=5", ("checks.trace_height_mm=5",)),
        ("checks.depth=breakage", ("checks.depth=breakage",)),
    ],
)
def test_what_makes_long_checks_shorter_is_said_with_the_time_that_it_makes(
    setting: str, sets: tuple[str, ...]
) -> None:
    def report(*more: str) -> Report:
        settings = chipbreak.load("fanuc-mill", [*BEAM, *more])
        return report_of(chipbreak.rewrite(SAMPLE.read_bytes(), settings), settings)

    by_setting = sum(check.duration_s or 0.0 for check in report(*sets).checks)
    text = str(report())
    assert f"  about {by_setting:.0f} s with {setting}" in text
    assert f"with {setting}" not in str(report(*sets))


def test_checks_that_are_short_need_no_advice() -> None:
    settings = chipbreak.load("fanuc-mill", [*BEAM, *GAP, "checks.depth=breakage", "checks.only=[3]"])
    report = report_of(chipbreak.rewrite(SAMPLE.read_bytes(), settings), settings)
    assert report.checks
    assert " s with " not in str(report)
